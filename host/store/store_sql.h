/* Statements of the store and how to run them. Only host/store/ includes this, and only host/store/ knows
 * SQLite. */
#ifndef MATRIG_HOST_STORE_STORE_SQL_H
#define MATRIG_HOST_STORE_STORE_SQL_H

#include <sqlite3.h>
#include <time.h>

#include "host/store/store.h"
#include "host/store/store_sql_import.h"
#include "host/store/store_sql_survey.h"

/* As corrected (store_journal.h), else as the board said. */
#define STORE_TOUCHDOWN                                                                                        \
    "coalesce((SELECT CAST(value AS REAL) FROM landing_changes WHERE landing=landings.id AND"                   \
    " field='touchdown_ft' ORDER BY landing_changes.id DESC LIMIT 1), touchdown_ft)"

/* Parameters: i int64_t (STORE_NONE: NULL), r double (NaN: NULL), t text (NULL: NULL), b bytes and their
 * size_t length. */
#define STORE_STATEMENTS(X)                                                                                  \
    X(SESSION_ADD, "itt", "INSERT INTO sessions(started_us, can_link, serial_link) VALUES(?,?,?)")           \
    X(SESSION_END, "iti", "UPDATE sessions SET ended_us=?, ended_by=? WHERE id=?")                           \
    X(SESSION_GET, "i",                                                                                      \
      "SELECT started_us, ended_us, ended_by, can_link, serial_link FROM sessions WHERE id=?")               \
    X(LINK_PUT, "iiiiiii", "INSERT OR REPLACE INTO links VALUES(?,?,?,?,?,?,?)")                             \
    X(LINK_GET, "ii", "SELECT received, lost, dropped, bad, outside FROM links WHERE session=? AND link=?")  \
    X(MISSING_PUT, "iiti", "INSERT OR REPLACE INTO missing VALUES(?,?,?,?)")                                 \
    X(LANDING_ADD, "iiiiiittiiirrt",                                                                         \
      "INSERT INTO landings(session, boot, board_landing, armed_block, armed_us, state, board_uid, "         \
      "firmware,"                                                                                            \
      " image_crc, config_crc, clock_source, touchdown_ft, switch_error_ft, image_commit) "                  \
      "VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?)")                                                                 \
    X(LANDING_PUT, "iiittiiirrti",                                                                           \
      "UPDATE landings SET armed_block=?, armed_us=?, state=?, board_uid=?, firmware=?, image_crc=?,"        \
      " config_crc=?, clock_source=?, touchdown_ft=?, switch_error_ft=?, image_commit=? WHERE id=?")         \
    X(LANDING_GET, "i",                                                                                      \
      "SELECT id, session, boot, board_landing, armed_block, armed_us, state, board_uid, firmware,"          \
      " image_crc, config_crc, clock_source, " STORE_TOUCHDOWN ", switch_error_ft, image_commit FROM landings"      \
      " WHERE id=?")                                                                                         \
    X(LANDINGS, "",                                                                                          \
      "SELECT id, session, boot, board_landing, armed_block, armed_us, state, board_uid, firmware,"          \
      " image_crc, config_crc, clock_source, " STORE_TOUCHDOWN ", switch_error_ft, image_commit FROM landings"      \
      " ORDER BY id")                                                                                        \
    X(CONFIGURATION_PUT, "it", "INSERT OR IGNORE INTO configurations VALUES(?,?)")                           \
    X(CONFIGURATION_GET, "i", "SELECT text FROM configurations WHERE crc=?")                                 \
    X(SURVEY_ADD, "i", "INSERT OR IGNORE INTO surveys(landing, source) VALUES(?, 'board')")                  \
    X(CHANNEL_PUT, "iiiiirrr", "INSERT OR REPLACE INTO channels VALUES(?,?,?,?,?,?,?,?)")                    \
    X(CALIBRATION_PUT, "iiir", "INSERT OR REPLACE INTO calibration VALUES(?,?,?,?)")                         \
    X(CALIBRATION, "i", "SELECT idx, item, value FROM calibration WHERE landing=? ORDER BY idx, item")       \
    X(QUALITY_PUT, "iiirri", "INSERT OR REPLACE INTO quality VALUES(?,?,?,?,?,?)")                           \
    X(CHANNEL_EVENTS, "i",                                                                                   \
      "SELECT code, detail, 1, board_us FROM events WHERE kind='channel' AND landing=?"                      \
      " ORDER BY board_us, id")                                                                              \
    X(SWITCH_PUT, "iiir", "INSERT OR REPLACE INTO switches VALUES(?,?,?,?)")                                 \
    X(SEGMENT_PUT, "iiirrr",                                                                                 \
      "INSERT OR REPLACE INTO slack VALUES((SELECT id FROM surveys WHERE landing=?),?,?,?,?,?)")             \
    X(CHANNELS, "i",                                                                                         \
      "SELECT idx, kind, number, band, station_ft, unit_per_code, zero_code FROM channels"                   \
      " WHERE landing=? ORDER BY idx")                                                                       \
    X(SWITCHES, "i",                                                                                         \
      "SELECT position, step_codes, station_ft FROM switches WHERE landing=? ORDER BY position")             \
    X(SEGMENTS, "i",                                                                                         \
      "SELECT segment, joints, slack_in, start_ft, end_ft FROM slack"                                        \
      " JOIN surveys ON surveys.id=slack.survey WHERE landing=? ORDER BY segment")                           \
    X(BLOCK_PUT, "iiiiibi",                                                                                  \
      "INSERT OR IGNORE INTO blocks(session, boot, idx, landing, host_us, record, link) VALUES(?,?,?,?,?,?,?)") \
    X(BLOCKS, "i", "SELECT record FROM blocks WHERE landing=? ORDER BY idx")                                 \
    X(BLOCK_LINKS, "i",                                                                                      \
      "SELECT idx, coalesce(link, (SELECT 1 + (ended_by IS 'black box') FROM sessions WHERE id=session), 1)" \
      " FROM blocks WHERE landing=? ORDER BY idx")                                                           \
    X(BLOCKS_COUNT, "i", "SELECT count(*) FROM blocks WHERE landing=?")                                      \
    X(FRAME_PUT, "iiiiiiiiib",                                                                               \
      "INSERT INTO frames(session, landing, link, direction, seq, board_us, host_us, can_id, dlc, data)"     \
      " VALUES(?,?,?,?,?,?,?,?,?,?)")                                                                        \
    X(FRAMES, "ii",                                                                                          \
      "SELECT direction, seq, board_us, host_us, can_id, data FROM frames WHERE landing=? AND link=?"        \
      " ORDER BY id")                                                                                        \
    X(FRAMES_COUNT, "ii",                                                                                    \
      "SELECT count(*) FROM frames WHERE landing=? AND link=? AND can_id & 0x20000000 = 0")                  \
    X(FRAMES_NEWEST, "", "SELECT coalesce(max(id), 0) FROM frames")                                         \
    X(FRAMES_MOVE, "iiiii", "UPDATE frames SET landing=? WHERE id>? AND session=? AND link=? AND landing IS ?") \
    X(FRAMES_JOIN, "iiiiiii",                                                                               \
      "UPDATE frames SET landing=? WHERE id>? AND session=? AND link=? AND landing IS ? AND board_us BETWEEN ? AND ?") \
    X(FRAMES_SINCE, "iii",                                                                                  \
      "SELECT can_id, host_us, data FROM frames WHERE id>? AND landing=? AND link=? AND direction=0 ORDER BY id") \
    X(EDGE_PUT, "iiiirri",                                                                                   \
      "INSERT INTO edges VALUES(?,?,?,?,?,?,?) ON CONFLICT DO UPDATE SET links=links|excluded.links,"        \
      " board_us=coalesce(board_us, excluded.board_us)")                                                     \
    X(EDGE_REFUSE, "ii", "UPDATE edges SET position=0 WHERE landing=? AND count=?")                          \
    X(EVENT_PUT, "iiiiitiiii",                                                                               \
      "INSERT INTO events(session, boot, landing, board_us, host_us, kind, code, detail, value, links)"      \
      " VALUES(?,?,?,?,?,?,?,?,?,?) ON CONFLICT DO UPDATE SET links=links|excluded.links,"                   \
      " landing=coalesce(landing, excluded.landing)")                                                        \
    X(MOTION_PUT, "iirrrrrri",                                                                               \
      "INSERT INTO motion VALUES(?,?,?,?,?,?,?,?,?) ON CONFLICT DO UPDATE SET links=links|excluded.links,"   \
      " position_error_ft=coalesce(excluded.position_error_ft, position_error_ft),"                          \
      " speed_error_ft_s=coalesce(excluded.speed_error_ft_s, speed_error_ft_s),"                             \
      " deceleration_error_ft_s2=coalesce(excluded.deceleration_error_ft_s2, deceleration_error_ft_s2)")     \
    X(ZONE_PUT, "iiirrrriii",                                                                                \
      "INSERT INTO zones VALUES(?,?,?,?,?,?,?,?,?,?) ON CONFLICT DO UPDATE SET links=links|excluded.links,"  \
      " mats=excluded.mats, start_ft=excluded.start_ft, end_ft=excluded.end_ft,"                             \
      " lead_s=coalesce(excluded.lead_s, lead_s), wheel_ft=coalesce(excluded.wheel_ft, wheel_ft),"           \
      " warning=coalesce(excluded.warning, warning),"                                                        \
      " inferred_percent=coalesce(excluded.inferred_percent, inferred_percent)")                             \
    X(TEMPERATURE_PUT, "iirri",                                                                              \
      "INSERT INTO temperatures VALUES(?,?,?,?,?) ON CONFLICT DO UPDATE SET links=links|excluded.links")     \
    X(TEMPERATURE_GET, "i",                                                                                  \
      "SELECT count(*), count(temperature_c), avg(temperature_c), max(error_c) FROM temperatures WHERE landing=?") \
    X(SLOW_PUT, "tiiiiiirrrrrrrrrrrrrrrrrrrrrrr",                                                            \
      "INSERT INTO slow_log(board_uid, seq, boot, block, time_us, faults, state, temperature_c, d1_in, d2_in, d3_in, d4_in," \
      " d5_in, d6_in, d7_in, d8_in, t1_lb, t2_lb, t3_lb, t4_lb, t5_lb, t6_lb, t7_lb, t8_lb, t9_lb, t10_lb, t11_lb, t12_lb," \
      " t13_lb, t14_lb) VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)"                   \
      " ON CONFLICT(board_uid, seq) DO UPDATE SET time_us=coalesce(time_us, excluded.time_us)")              \
    X(SLOW_ROWS, "t",                                                                                        \
      "SELECT board_uid, seq, boot, block, time_us, faults, state, temperature_c, d1_in, d2_in, d3_in, d4_in," \
      " d5_in, d6_in, d7_in, d8_in, t1_lb, t2_lb, t3_lb, t4_lb, t5_lb, t6_lb, t7_lb, t8_lb, t9_lb, t10_lb, t11_lb, t12_lb," \
      " t13_lb, t14_lb FROM slow_log WHERE ?1 IS NULL OR board_uid=?1 ORDER BY board_uid, seq, id")          \
    X(PREDICTION_PUT, "iiiiiiirrriirrrri",                                                                   \
      "INSERT INTO predictions VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?) ON CONFLICT DO UPDATE SET links=links|excluded.links, " \
      "verdict=coalesce(excluded.verdict, verdict), reason=coalesce(excluded.reason, reason), "              \
      "level=coalesce(excluded.level, level), basis=coalesce(excluded.basis, basis), "                       \
      "age_blocks=coalesce(excluded.age_blocks, age_blocks), start_error_ft=coalesce(excluded.start_error_ft, start_error_ft), " \
      "end_error_ft=coalesce(excluded.end_error_ft, end_error_ft), mean_gap_in=coalesce(excluded.mean_gap_in, mean_gap_in), " \
      "closed_joints=coalesce(excluded.closed_joints, closed_joints), coming_mats=coalesce(excluded.coming_mats, coming_mats), " \
      "coming_wheel_ft=coalesce(excluded.coming_wheel_ft, coming_wheel_ft), compression_lb=coalesce(excluded.compression_lb, compression_lb), " \
      "critical_lb=coalesce(excluded.critical_lb, critical_lb), distance_ft=coalesce(excluded.distance_ft, distance_ft)") \
    X(PREDICTIONS, "i",                                                                                      \
      "SELECT block, verdict, reason, level, basis, age_blocks, start_error_ft, end_error_ft, mean_gap_in, closed_joints," \
      " coming_mats, coming_wheel_ft, compression_lb, critical_lb, distance_ft, links FROM predictions WHERE landing=? ORDER BY block") \
    X(TRUST_PUT, "iiirri",                                                                                   \
      "INSERT INTO trust VALUES(?,?,?,?,?,?) ON CONFLICT DO UPDATE SET links=links|excluded.links")          \
    X(TRUSTS, "i", "SELECT block, doubts, resistance, updates, links FROM trust WHERE landing=? ORDER BY block") \
    X(RUNWAY_PUT, "iiiriib", "INSERT OR REPLACE INTO runways VALUES(?,?,?,?,?,?,?)")                         \
    X(RUNWAY_GET, "i", "SELECT source, state FROM runways WHERE landing=?")                                  \
    X(BACKLOGS, "i", "SELECT value, code FROM events WHERE kind='backlog' AND landing=? ORDER BY value")      \
    X(PREDICT_ITEM_PUT, "iir", "INSERT OR REPLACE INTO predict_items VALUES(?,?,?)")                         \
    X(PREDICT_ITEMS, "i", "SELECT item, value FROM predict_items WHERE landing=? ORDER BY item")             \
    X(RESULT_PUT, "irrrrrrriii",                                                                             \
      "INSERT INTO results VALUES(?,?,?,?,?,?,?,?,?,?,?) ON CONFLICT DO UPDATE SET "                         \
      "links=links|excluded.links,"                                                                          \
      " speed_ft_s=coalesce(excluded.speed_ft_s, speed_ft_s),"                                               \
      " speed_error_ft_s=coalesce(excluded.speed_error_ft_s, speed_error_ft_s),"                             \
      " deceleration_ft_s2=coalesce(excluded.deceleration_ft_s2, deceleration_ft_s2),"                       \
      " deceleration_error_ft_s2=coalesce(excluded.deceleration_error_ft_s2, deceleration_error_ft_s2),"     \
      " stop_station_ft=coalesce(excluded.stop_station_ft, stop_station_ft),"                                \
      " stop_station_error_ft=coalesce(excluded.stop_station_error_ft, stop_station_error_ft),"              \
      " after_touchdown_s=coalesce(excluded.after_touchdown_s, after_touchdown_s),"                          \
      " switches=coalesce(excluded.switches, switches), stop_gates=coalesce(excluded.stop_gates, "           \
      "stop_gates)")                                                                                         \
    X(BAND_PUT, "iiirrrrriirriirrri",                                                                        \
      "INSERT INTO bands VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?) ON CONFLICT DO UPDATE SET"              \
      " links=links|excluded.links, gages=coalesce(excluded.gages, gages),"                                  \
      " before_lb=coalesce(excluded.before_lb, before_lb),"                                                  \
      " before_error_lb=coalesce(excluded.before_error_lb, before_error_lb),"                                \
      " spread_lb=coalesce(excluded.spread_lb, spread_lb), least_lb=coalesce(excluded.least_lb, least_lb),"  \
      " least_error_lb=coalesce(excluded.least_error_lb, least_error_lb),"                                   \
      " least_gage=coalesce(excluded.least_gage, least_gage),"                                               \
      " least_block=coalesce(excluded.least_block, least_block),"                                            \
      " most_lb=coalesce(excluded.most_lb, most_lb),"                                                        \
      " most_error_lb=coalesce(excluded.most_error_lb, most_error_lb),"                                      \
      " most_gage=coalesce(excluded.most_gage, most_gage),"                                                  \
      " most_block=coalesce(excluded.most_block, most_block),"                                               \
      " after_lb=coalesce(excluded.after_lb, after_lb), change_lb=coalesce(excluded.change_lb, change_lb),"  \
      " change_error_lb=coalesce(excluded.change_error_lb, change_error_lb)")                                \
    X(BANDS, "i",                                                                                            \
      "SELECT band, gages, before_lb, before_error_lb, spread_lb, least_lb, least_error_lb, least_gage,"     \
      " least_block, most_lb, most_error_lb, most_gage, most_block, after_lb, change_lb, change_error_lb,"   \
      " links FROM bands WHERE landing=? ORDER BY band")                                                     \
    X(BAND_EVENT_PUT, "iiiiiiri",                                                                            \
      "INSERT INTO band_events VALUES(?,?,?,?,?,?,?,?) ON CONFLICT DO UPDATE SET links=links|excluded.links") \
    X(BAND_EVENTS, "i",                                                                                      \
      "SELECT block, band, gage, reason, other, value_lb, links FROM band_events WHERE landing=?"            \
      " ORDER BY block, gage")                                                                               \
    X(SHUNT_PUT, "iiiiiirrrrri",                                                                             \
      "INSERT INTO shunts VALUES(?,?,?,?,?,?,?,?,?,?,?,?) ON CONFLICT DO UPDATE SET"                         \
      " links=links|excluded.links, expected_lb=coalesce(excluded.expected_lb, expected_lb),"                \
      " change_lb=coalesce(excluded.change_lb, change_lb),"                                                  \
      " zero_change_lb=coalesce(excluded.zero_change_lb, zero_change_lb)")                                   \
    X(SHUNTS_BEFORE, "iiiii",                                                                                \
      "SELECT number, gage, block, verdict, span_lb, noise_lb, expected_lb, change_lb, zero_change_lb, links" \
      " FROM shunts WHERE session=? AND boot=? AND number=(SELECT max(number) FROM shunts WHERE session=?"   \
      " AND boot=? AND block<?) ORDER BY gage")                                                              \
    X(SHUNTS_AFTER, "iiiii",                                                                                 \
      "SELECT number, gage, block, verdict, span_lb, noise_lb, expected_lb, change_lb, zero_change_lb, links" \
      " FROM shunts WHERE session=? AND boot=? AND number=(SELECT min(number) FROM shunts WHERE session=?"   \
      " AND boot=? AND block>=?) ORDER BY gage")                                                             \
    X(EDGES, "i",                                                                                            \
      "SELECT count, position, step_codes, tick, board_us, links FROM edges WHERE landing=?"                 \
      " ORDER BY count")                                                                                     \
    X(MOTIONS, "i",                                                                                          \
      "SELECT block, position_ft, position_error_ft, speed_ft_s, speed_error_ft_s,"                          \
      " deceleration_ft_s2, deceleration_error_ft_s2, links FROM motion WHERE landing=? ORDER BY block")     \
    X(ZONES, "i",                                                                                            \
      "SELECT block, mats, start_ft, end_ft, lead_s, wheel_ft, warning, inferred_percent, links"             \
      " FROM zones WHERE landing=? ORDER BY block")                                                          \
    X(RESULT_GET, "i",                                                                                       \
      "SELECT speed_ft_s, speed_error_ft_s, deceleration_ft_s2, deceleration_error_ft_s2,"                   \
      " stop_station_ft, stop_station_error_ft, after_touchdown_s, switches, stop_gates, links FROM results" \
      " WHERE landing=?")                                                                                    \
    X(FAULTS, "iii",                                                                                         \
      "SELECT code, detail, max(value), board_us FROM events WHERE kind='fault' AND session=?"               \
      " AND boot=? AND id<=coalesce((SELECT max(id) FROM events WHERE landing=?), 0) GROUP BY code ORDER "   \
      "BY code")                                                                                             \
    X(TROUBLES, "ti",                                                                                        \
      "SELECT code, sum(detail) FROM events WHERE kind=? AND landing=? GROUP BY code ORDER BY code")         \
    X(HELD, "i", "SELECT code, sum(value), max(detail) FROM events WHERE kind='held' AND landing=? GROUP BY code")  \
    X(SWITCH_EVENTS, "i",                                                                                    \
      "SELECT code, detail, count(*), min(board_us) FROM events WHERE kind='switch' AND landing=?"           \
      " GROUP BY code, detail ORDER BY detail, code")                                                        \
    X(GAP_PUT, "iiitttiii",                                                                                  \
      "INSERT INTO gaps(session, landing, link, message, channels, cause, count, from_block, to_block)"      \
      " VALUES(?,?,?,?,?,?,?,?,?)")                                                                          \
    X(GAPS, "i",                                                                                             \
      "SELECT link, message, channels, cause, count, from_block, to_block FROM gaps WHERE landing=?"         \
      " ORDER BY id")                                                                                        \
    X(TIME_MAP_PUT, "iiiiiiiirrriir",                                                                       \
      "INSERT INTO time_maps(session, boot, link, landing, refusal, pairs, from_us, to_us, spread_us,"       \
      " fast_ppm, fast_half_ppm, board_us, host_us, host_half_us) VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?)")      \
    X(TIME_MAPS, "i",                                                                                        \
      "SELECT session, boot, link, landing, refusal, pairs, from_us, to_us, spread_us, fast_ppm,"            \
      " fast_half_ppm, board_us, host_us, host_half_us FROM time_maps WHERE landing=? ORDER BY id")          \
    X(FILM_FRAME_PUT, "iiiri",                                                                               \
      "INSERT INTO frames_film VALUES(?,?,?,?,?) ON CONFLICT DO UPDATE SET links=links|excluded.links,"      \
      " board_us=coalesce(board_us, excluded.board_us)")                                                     \
    X(FILM_FRAMES, "i",                                                                                      \
      "SELECT number, tick, board_us, links FROM frames_film WHERE landing=? ORDER BY number")               \
    X(READINESS_PUT, "itttt", "INSERT INTO readiness(made_us, board_uid, kind, verdict, checks) VALUES(?,?,?,?,?)") \
    X(READINESS_GET, "ttii",                                                                                \
      "SELECT made_us, verdict, checks FROM readiness WHERE board_uid=? AND kind=? AND made_us BETWEEN ? AND ?" \
      " ORDER BY made_us DESC, id DESC LIMIT 1")                                                            \
    X(READINESS_ALL, "t", "SELECT made_us, kind, checks FROM readiness WHERE board_uid=? ORDER BY made_us, id")     \
    X(READINESS_BOARD, "",                                                                                  \
      "SELECT board_uid FROM (SELECT board_uid, made_us AS t FROM readiness UNION ALL"                      \
      " SELECT board_uid, armed_us FROM landings WHERE board_uid<>'') ORDER BY t DESC LIMIT 1")             \
    X(BOARD_SHUNTS, "t",                                                                                    \
      "SELECT gage, span_lb, started_us FROM shunts JOIN sessions ON sessions.id=session WHERE session IN"  \
      " (SELECT session FROM landings WHERE board_uid=?) ORDER BY session, boot, number, gage")             \
    X(SAME_CUT, "i",                                                                                        \
      "SELECT coalesce(max(a.id), 0) FROM landings a, landings b WHERE b.id=? AND a.id<b.id AND a.session<>b.session" \
      " AND a.board_uid IS b.board_uid AND a.board_landing=b.board_landing AND a.state BETWEEN 1 AND 3"     \
      " AND coalesce((SELECT value FROM landing_changes WHERE landing=a.id AND field='void' ORDER BY id DESC LIMIT 1), 'no')<>'yes'") \
    X(SAME_BY_CAN, "ii",                                                                                    \
      "SELECT EXISTS(SELECT 1 FROM frames WHERE landing=?1 AND link=0) AND EXISTS(SELECT 1 FROM frames WHERE landing=?2 AND link=0)") \
    X(SAME_ARMED, "ii",                                                                                     \
      "SELECT EXISTS(SELECT 1 FROM landings a, landings b WHERE a.id=?1 AND b.id=?2 AND a.armed_block=b.armed_block)") \
    X(SAME_FRAME, "ii",                                                                                     \
      "SELECT EXISTS(SELECT 1 FROM frames b, (SELECT host_us, can_id, data FROM frames WHERE landing=?1 AND link=0 ORDER BY id DESC LIMIT 1)" \
      " a WHERE b.landing=?2 AND b.link=0 AND b.host_us=a.host_us AND b.can_id=a.can_id AND b.data=a.data" \
      " AND EXISTS(SELECT 1 FROM frames WHERE landing=?2 AND link=0 AND host_us>a.host_us))")               \
    X(SAME_BLOCK, "ii",                                                                                     \
      "SELECT EXISTS(SELECT 1 FROM blocks a JOIN blocks b ON b.idx=a.idx WHERE a.landing=?1 AND b.landing=?2" \
      " AND a.idx=(SELECT max(idx) FROM blocks WHERE landing=?1) AND a.record=b.record"                    \
      " AND EXISTS(SELECT 1 FROM blocks WHERE landing=?2 AND idx>a.idx))")                                  \
    X(DATA_VERSION, "", "PRAGMA data_version")                                                              \
    X(FRAME_LAST, "", "SELECT id, session FROM frames ORDER BY id DESC LIMIT 1")                            \
    X(SIZE, "", "SELECT (SELECT page_count FROM pragma_page_count) * (SELECT page_size FROM pragma_page_size),"  \
      " (SELECT count(*) FROM landings)")                                                                   \
    X(SIMULATION_ADD, "itirriirrrb",                                                                          \
      "INSERT INTO simulations(landing, scene, made_us, run_ms, error_in, seeds, edges, offset_s, scatter_s,"  \
      " segments_dt_s, segments_in) VALUES(?,?,?,?,?,?,?,?,?,?,?)")                                            \
    X(SIMULATION_CHANNEL, "iirrrrrrrrrrbb",                                                                  \
      "INSERT INTO simulation_channels(simulation, number, station_ft, peak_measured_in, peak_measured_error_in," \
      " peak_simulated_in, peak_simulated_error_in, rms_in, end_measured_in, end_simulated_in, t0_s, dt_s, series_in," \
      " spread_in) VALUES(?,?,?,?,?,?,?,?,?,?,?,?,?,?)")                                                     \
    X(SIMULATIONS, "i",                                                                                      \
      "SELECT number, station_ft, peak_measured_in, peak_measured_error_in, peak_simulated_in,"              \
      " peak_simulated_error_in, rms_in, end_measured_in, end_simulated_in, t0_s, dt_s, series_in, spread_in" \
      " FROM simulation_channels WHERE simulation=(SELECT max(id) FROM simulations WHERE landing=?) ORDER "  \
      "BY number")                                                                                           \
    STORE_IMPORT_STATEMENTS(X)                                                                               \
    X(SIMULATION_HEAD, "i",                                                                                  \
      "SELECT run_ms, error_in, seeds, edges, offset_s, scatter_s, segments_dt_s, segments_in," \
      " iif(json_valid(scene), json_extract(scene, '$.file'), NULL) FROM simulations WHERE id=(SELECT max(id) FROM simulations WHERE landing=?)")                        \
    STORE_SURVEY_STATEMENTS(X)

enum store_statement {
#define STORE_ENUM(name, types, sql) STORE_##name,
    STORE_STATEMENTS(STORE_ENUM)
#undef STORE_ENUM
        STORE_STATEMENT_COUNT
};

/* A frame that waits to be written with others (store_frames.c). */
#define STORE_FRAMES_A_STATEMENT 64u
struct store_waiting {
    int64_t session;
    struct store_frame frame; /* its data NULL: they are in */
    uint8_t data[8];
};

/* What is known of the file itself, by matrig log (store_written_over.c). */
#define STORE_FIRST_PAGE 4096u
struct store_checkpoints {
    uint32_t salt, done, begun; /* of the journal's index: which journal, its frames that are in the file, and those on their way */
};
struct store_newest {
    int64_t session, frame; /* frame 0: none */
};
struct store_file_look {
    bool on, written_over;
    const volatile uint32_t *index;
    int64_t bytes;
    struct timespec written;
    struct store_checkpoints known;
    uint8_t first_page[STORE_FIRST_PAGE];
    size_t first_page_bytes;
    struct store_newest newest, next; /* committed; to be committed */
    int64_t version;                  /* of the content, when the session was last looked for */
};

struct store {
    sqlite3 *database;
    char *path;
    sqlite3_stmt *statement[STORE_STATEMENT_COUNT]; /* prepared at first use */
    int64_t found_version; /* of the tables when it was opened */
    bool found_due;        /* it lacked some of this version's */
    int alone;             /* descriptor that keeps others who log out; 0: none */
    sqlite3_stmt *frames_put;
    struct store_waiting waiting[STORE_FRAMES_A_STATEMENT];
    unsigned waiting_count;
    int64_t steps, rows;   /* since the last statement that began while no other was running (store_guard.h) */
    int64_t guarded_bytes; /* of the file, when it was last looked at */
    struct store_file_look look;
    int refused; /* enum store_refusal, of the last call that failed */
};

/* The tables. */
extern const char store_schema[];

/* Sets the error from SQLite's last one. Returns its status. */
enum mr_status store_failed(struct store *store, const char *doing, struct error *error);

/* Writes the frames that wait; before anything is read, and before a commit. */
enum mr_status store_frames_flush(struct store *store, struct error *error);

/* Bind and run a statement that returns no rows. */
enum mr_status store_run(struct store *store, struct error *error, enum store_statement which, ...);

/* Bind a statement; then store_step until it returns MR_TOO_FEW (no more rows) or an error. A statement that
 * is not stepped to its end is released with store_reset. */
enum mr_status store_query(struct store *store, struct error *error, sqlite3_stmt **statement,
                           enum store_statement which, ...);
enum mr_status store_step(struct store *store, sqlite3_stmt *statement, struct error *error);
/* The first column of the only row, of a query that ended with `status`; on any other than MR_OK that is returned. */
enum mr_status store_take_integer(struct store *store, sqlite3_stmt *statement, enum mr_status status, int64_t *value,
                                  struct error *error);
void store_reset(sqlite3_stmt *statement);

/* Columns with NULL as STORE_NONE and NaN; text is copied, cut to `size`. */
int64_t store_integer(sqlite3_stmt *statement, int column);
double store_real(sqlite3_stmt *statement, int column);
void store_text(sqlite3_stmt *statement, int column, char *out, size_t size);

#endif
