/* The campaign database: one SQLite file (WAL) that holds what was received, and what was made of
 * it.
 *
 * Board time is microseconds since the board's scans began; host time is Unix time in microseconds.
 * A landing is known by RUN, its id here, from 1; it also has the board's identity and own number,
 * so copies can be told apart. Absent values are NULL in the file, NaN or STORE_NONE here. Text
 * handed to a function is copied; arrays that a read returns are the caller's to free().
 *
 * Writing goes through one transaction at a time: store_begin, any number of puts, store_commit. A
 * commit is on disk when it returns. Every function returns MR_OK or sets `error` and returns its
 * status. */
#ifndef MATRIG_HOST_STORE_STORE_H
#define MATRIG_HOST_STORE_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "common/catalogue.h"
#include "common/channels.h"
#include "common/closure.h"
#include "common/quantity.h"
#include "common/risk.h"
#include "common/runway.h"
#include "host/base/error.h"
#include "host/store/rows.h"

#define STORE_VERSION      1          /* of the tables: PRAGMA user_version */
#define STORE_APPLICATION  0x4d545247 /* "MTRG": PRAGMA application_id */
#define STORE_SWITCHES_MAX 64u

enum store_mode {
    STORE_OPEN,   /* must exist */
    STORE_CREATE, /* is made when it does not exist */
    STORE_LOG,    /* the same, for the one that logs: nobody else does until it is closed */
    STORE_READ,   /* must exist, nothing is written: it may lie where nothing can be */
    STORE_SOURCE, /* the same, and what is attached to it is written */
};

struct store;

/* MR_IO: cannot be opened, or another one logs; MR_MALFORMED: no campaign database; MR_VERSION:
 * another version's. */
enum mr_status store_open(const char *path, enum store_mode mode, struct store **store,
                          struct error *error);
/* Whether somebody logs into it. */
bool store_is_logged(struct store *store);
void store_close(struct store *store); /* rolls back what is not committed; NULL is allowed */
const char *store_path(const struct store *store);

enum mr_status store_begin(struct store *store, struct error *error);
enum mr_status store_commit(struct store *store, struct error *error);

/* One run of `matrig log`. */
enum mr_status store_session_add(struct store *store, struct store_session *session,
                                 struct error *error);
enum mr_status store_session_end(struct store *store, int64_t session, int64_t ended_us,
                                 const char *ended_by, struct error *error);

enum mr_status store_session_get(struct store *store, int64_t session,
                                 struct store_session_row *row, struct error *error);

/* What a session counted on one of its links so far; `link` is an enum link_kind. */
enum mr_status store_link_put(struct store *store, int64_t session, int link,
                              const struct store_link_counts *counts, struct error *error);
enum mr_status store_link_get(struct store *store, int64_t session, int link,
                              struct store_link_counts *counts, bool *found, struct error *error);

/* How many of a message the session missed on a link so far. */
enum mr_status store_missing_put(struct store *store, int64_t session, int link,
                                 const char *message, int64_t missing, struct error *error);

enum mr_status store_landing_add(struct store *store, struct store_landing *landing,
                                 struct error *error);
enum mr_status store_landing_put(struct store *store, const struct store_landing *landing,
                                 struct error *error);
enum mr_status store_landing_get(struct store *store, int64_t run, struct store_landing *landing,
                                 struct error *error);
/* *run below 0: becomes that of the landing which its board numbered -*run. MR_UNKNOWN: there is
 * none, or more than one. */
enum mr_status store_run_find(struct store *store, int64_t *run, struct error *error);

/* Rows of a landing, in order, for the caller to free: store_edges(store, run, &rows, &count,
 * error), rows of struct store_edge. Of switch events `code` is the reason (common/switches.h),
 * `detail` the switch, 0 when not known, `count` how many times; of channel events the validity
 * (common/channels.h), the channel, `board_us` since when. Restarts: the starts of the board that
 * ended the landing, `detail` the bits of hello's reset_cause, 0: not received. Backlogs: blocks in
 * which others waited for the predictor. Readings: of a gage survey (`run`: its id), in the order
 * in which they were written. */
#define STORE_ROWS_OF_LANDING(X)                        \
    X(store_switches, switch, SWITCHES)                 \
    X(store_segments, segment, SEGMENTS)                \
    X(store_edges, edge, EDGES)                         \
    X(store_motions, motion, MOTIONS)                   \
    X(store_zones, zone, ZONES)                         \
    X(store_gaps, gap, GAPS)                            \
    X(store_time_maps, time_map, TIME_MAPS)             \
    X(store_film_frames, film_frame, FILM_FRAMES)       \
    X(store_switch_events, fault, SWITCH_EVENTS)        \
    X(store_channel_events, fault, CHANNEL_EVENTS)      \
    X(store_restarts, fault, RESTARTS)                  \
    X(store_orders, fault, ORDERS)                      \
    X(store_keys, fault, KEYS)                          \
    X(store_bands, band, BANDS)                         \
    X(store_band_events, band_event, BAND_EVENTS)       \
    X(store_risks, risk, RISKS)                         \
    X(store_predictions, prediction, PREDICTIONS)       \
    X(store_backlogs, backlog, BACKLOGS)                \
    X(store_trusts, trust, TRUSTS)                      \
    X(store_predict_items, predict_item, PREDICT_ITEMS) \
    X(store_risk_items, risk_item, RISK_ITEMS)          \
    X(store_changes, change, CHANGES)                   \
    X(store_observations, observation, OBSERVATIONS)    \
    X(store_gage_readings, gage_reading, GAGE_READINGS)
#define STORE_ROWS_DECLARED(function, row, NAME)                                         \
    enum mr_status function(struct store *store, int64_t run, struct store_##row **rows, \
                            size_t *count, struct error *error);
STORE_ROWS_OF_LANDING(STORE_ROWS_DECLARED)

/* The same of the campaign: store_landings(store, &rows, &count, error). Series and surveys are
 * without those that were withdrawn. */
#define STORE_ROWS_OF_CAMPAIGN(X)                    \
    X(store_landings, landing, LANDINGS)             \
    X(store_series_all, series, SERIES)              \
    X(store_advices, advice, ADVICES)                \
    X(store_gage_surveys, gage_survey, GAGE_SURVEYS) \
    X(store_withdrawals, withdrawal, WITHDRAWALS)
#define STORE_ALL_ROWS_DECLARED(function, row, NAME)                                       \
    enum mr_status function(struct store *store, struct store_##row **rows, size_t *count, \
                            struct error *error);
STORE_ROWS_OF_CAMPAIGN(STORE_ALL_ROWS_DECLARED)

/* store_event_put(store, &event, error). A row of the slow log that is there already gets its time
 * when it had none, no more. A time map is the board's clock against this computer's, by one link:
 * of a landing, or of all that was heard of the board until it began again or the session ended
 * (run STORE_NONE); host/link/timemap.h says how it comes about. Advices: what was advised before
 * landings, and kept. */
#define STORE_PUT_OF_CAMPAIGN(X)    \
    X(store_event_put, event)       \
    X(store_time_map_put, time_map) \
    X(store_slow_put, slow)         \
    X(store_series_add, series)     \
    X(store_advice_add, advice)     \
    X(store_withdraw, withdrawal)
#define STORE_ADD_DECLARED(function, row)                                         \
    enum mr_status function(struct store *store, const struct store_##row *value, \
                            struct error *error);
STORE_PUT_OF_CAMPAIGN(STORE_ADD_DECLARED)

/* store_day_newest(store, &run, error): the newest landing that happened here, neither imported nor
 * disarmed before the gear came; the newest session that was logged here; the newest session.
 * 0: none. */
#define STORE_NUMBERS_OF_CAMPAIGN(X)  \
    X(store_day_newest, DAY_NEWEST)   \
    X(store_day_session, DAY_SESSION) \
    X(store_newest_session, SESSION_NEWEST)
#define STORE_NUMBER_DECLARED(function, NAME) \
    enum mr_status function(struct store *store, int64_t *value, struct error *error);
STORE_NUMBERS_OF_CAMPAIGN(STORE_NUMBER_DECLARED)

/* A number of a landing: how many blocks it has, the first of them; -1: none. When a board was
 * given a gage survey (`run`: its id) last; 0: never. */
#define STORE_NUMBERS_OF_LANDING(X)     \
    X(store_blocks_count, BLOCKS_COUNT) \
    X(store_block_first, BLOCK_FIRST)   \
    X(store_gage_loaded, GAGE_LOADED)
#define STORE_NUMBER_OF_DECLARED(function, NAME) \
    enum mr_status function(struct store *store, int64_t run, int64_t *value, struct error *error);
STORE_NUMBERS_OF_LANDING(STORE_NUMBER_OF_DECLARED)

/* store_edge_put(store, run, &edge, error): what the board said, once, whichever link it came by;
 * what becomes of a row that is there: tables.def. */
#define STORE_PUT_OF_LANDING(X) \
    X(quality)                  \
    X(switch)                   \
    X(edge)                     \
    X(motion)                   \
    X(zone)                     \
    X(result)                   \
    X(film_frame)               \
    X(mat_temperature)          \
    X(band)                     \
    X(band_event)               \
    X(prediction) X(trust) X(risk) X(calibration) X(predict_item) X(risk_item) X(import)
#define STORE_PUT_DECLARED(row)                                        \
    enum mr_status store_##row##_put(struct store *store, int64_t run, \
                                     const struct store_##row *value, struct error *error);
STORE_PUT_OF_LANDING(STORE_PUT_DECLARED)

/* A whole configuration as text (host/board/config_text.h), by the CRC that landings name. One that
 * is there already stays as it is. */
enum mr_status store_configuration_put(struct store *store, uint32_t crc, const char *text,
                                       struct error *error);
/* *text: NULL: it was never read; else the caller frees it. */
enum mr_status store_configuration_get(struct store *store, uint32_t crc, char **text,
                                       struct error *error);

/* Configuration of a landing as the board reported it. */
enum mr_status store_channel_put(struct store *store, int64_t run, int64_t index,
                                 const struct mr_channel_config *channel, struct error *error);
/* One value of a channel's calibration: item is an enum mr_calibration_item. */
enum mr_status store_segment_put(struct store *store, int64_t run,
                                 const struct store_segment *segment, struct error *error);
/* `channels` has MR_CHANNELS places; those not reported have kind MR_KIND_NONE. `*found`: how many
 * were reported. Calibration included. */
enum mr_status store_channels(struct store *store, int64_t run, struct mr_channel_config *channels,
                              size_t *found, struct error *error);

/* Block records as they came, over serial (LINK_SERIAL) or from the black box (STORE_LINK_BOX);
 * `run` STORE_NONE outside landings. A block that is there already is left as it is. */
#define STORE_LINK_BOX 2
enum mr_status store_block_put(struct store *store, int64_t session, int64_t boot, int64_t run,
                               int link, int64_t index, int64_t host_us, const uint8_t *record,
                               size_t length, struct error *error);
/* Calls `each` for the blocks of a landing in order of their index, with the link they came over
 * (or STORE_LINK_BOX); it returns MR_OK to go on. */
enum mr_status store_blocks_each(struct store *store, int64_t run,
                                 enum mr_status (*each)(void *context, const uint8_t *record,
                                                        size_t length, int link),
                                 void *context, struct error *error);
/* The indexes alone, which cost less. */
enum mr_status store_block_indexes_each(struct store *store, int64_t run,
                                        void (*each)(void *context, int64_t index), void *context,
                                        struct error *error);
/* A landing's first block from `from` to `to`; -1: none. */
enum mr_status store_block_within(struct store *store, int64_t run, int64_t from, int64_t to,
                                  int64_t *index, struct error *error);

struct store_frame {
    int64_t run;      /* STORE_NONE outside landings */
    int link;         /* enum link_kind */
    int direction;    /* 0 from the board, 1 to it */
    int64_t seq;      /* of the serial frame; on CAN frames received before it in the session */
    int64_t board_us; /* STORE_NONE: not known yet */
    int64_t host_us;
    uint32_t id; /* of the catalogue: on CAN without the board's base */
    size_t length;
    const uint8_t *data;
};
/* Frames wait for others and are written together (store_frames.c), at a commit or before anything
 * is read at the latest: an error of writing may come from a later call. */
/* The newest row of the frames, 0: none. */
enum mr_status store_frames_mark(struct store *store, int64_t *mark, struct error *error);
enum mr_status store_frame_put(struct store *store, int64_t session,
                               const struct store_frame *frame, struct error *error);
/* Frames of a landing on one link, in order of reception. */
enum mr_status store_frames_each(struct store *store, int64_t run, int link,
                                 enum mr_status (*each)(void *context,
                                                        const struct store_frame *frame),
                                 void *context, struct error *error);
/* What was added on the bus to the identifiers of a landing's frames (common/canbase.h). */
enum mr_status store_frames_base(struct store *store, int64_t run, uint16_t *base,
                                 struct error *error);
enum mr_status store_frames_count(struct store *store, int64_t run, int link, int64_t *count,
                                  struct error *error);

/* A quantity over a landing; told 0: the campaign keeps no column of it. */
enum mr_status store_mean_get(struct store *store, int64_t run, enum mr_quantity quantity,
                              struct store_mean *mean, struct error *error);
/* Rows of a board, or of all (NULL), in order. */
enum mr_status store_slow_rows(struct store *store, const char *board_uid, struct store_slow **rows,
                               size_t *count, struct error *error);

/* The board found that an edge it told of is no gate of the landing: its row loses its switch; the
 * event keeps it. */
enum mr_status store_edge_refuse(struct store *store, int64_t run, int64_t count,
                                 struct error *error);
enum mr_status store_result_get(struct store *store, int64_t run, struct store_result *result,
                                bool *found, struct error *error);
/* Faults of the landing's board and session up to the landing's end: the newest row of each
 * fault. */
enum mr_status store_faults(struct store *store, const struct store_landing *landing,
                            struct store_fault **rows, size_t *count, struct error *error);

/* Makes a campaign at `path`, where nothing is, of one landing: all that belongs to it, as its RUN
 * 1, of one moment, also while the campaign is being written; the image (NULL: none) and the
 * digests of image and record, as table `bundles`. */
enum mr_status store_bundle_make(struct store *store, int64_t run, const char *path,
                                 const uint8_t *image, size_t length, struct error *error);
/* Checks the digests of a bundle's landing, MR_CRC, and writes its image to `path`. *there false:
 * no bundle, or none with an image. */
enum mr_status store_bundle_open(struct store *store, int64_t run, const char *path, bool *there,
                                 struct error *error);

/* Troubles that the links themselves saw in a landing (enum link_trouble), summed. */
enum mr_status store_troubles(struct store *store, int64_t run, int link,
                              struct store_trouble **rows, size_t *count, struct error *error);
/* The kind of their events: code is the trouble, detail how often it happened since the event
 * before, value how often in the session so far. */
const char *store_trouble_kind(int link);
/* Lost data. message "frame" counts frames of the link; a message's name says which of them, where
 * that is known. */
enum mr_status store_gap_put(struct store *store, int64_t session, int64_t run,
                             const struct store_gap *gap, struct error *error);

/* One channel of a comparison with the simulation. Series: u at t0 + i dt, relative to touchdown,
 * aligned with the measured. */
struct store_simulation {
    int64_t number; /* transducer */
    double station_ft;
    double peak_measured_in, peak_measured_error_in;
    double peak_simulated_in, peak_simulated_error_in;
    double rms_in;
    double end_measured_in, end_simulated_in;
    double t0_s, dt_s;
    float *series_in; /* `length` values; a read allocates it */
    float *spread_in; /* as many: standard deviation over an ensemble; NULL: of one runway */
    size_t length;
};
/* And what its channels have in common. Absent (before matrig kept it): NaN, STORE_NONE, NULL. */
struct store_simulation_head {
    double run_ms, error_in; /* of the simulation; the solver's own estimate */
    int64_t seeds;           /* runways */
    double segments_dt_s;
    /* what is left of each segment's openings, MR_SEGMENTS a row; a read allocates it */
    float *segments_in;
    size_t segment_rows;
    char file[120]; /* scene or campaign */
};
enum mr_status store_simulation_put(struct store *store, int64_t run, const char *scene_json,
                                    int64_t made_us, const struct store_simulation_head *head,
                                    const struct store_simulation *rows, size_t count,
                                    struct error *error);
/* The newest comparison of a landing, none: *count 0. store_simulations_free releases rows and
 * their series. */
enum mr_status store_simulations(struct store *store, int64_t run, struct store_simulation **rows,
                                 size_t *count, struct error *error);
/* Of the same; the caller frees segments_in. */
enum mr_status store_simulation_head(struct store *store, int64_t run,
                                     struct store_simulation_head *head, struct error *error);
void store_simulations_free(struct store_simulation *rows, size_t count);

/* Of two links that are read one after the other: of the frames of CAN after `mark` those are the
 * landing's that came from the state that serial said first of it to the one that it said last,
 * or to the row `last`, unless STORE_NONE. */
enum mr_status store_frames_place(struct store *store, int64_t session, int64_t run, int64_t mark,
                                  int64_t last, struct error *error);

/* A shunt calibration belongs to no landing: it is before one and after another. */

enum mr_status store_shunt_put(struct store *store, int64_t session, int64_t boot,
                               const struct store_shunt *shunt, struct error *error);
/* The last calibration before `block` of a session's boot, and the first from there on; none:
 * *count 0. */
enum mr_status store_shunts_before(struct store *store, int64_t session, int64_t boot,
                                   int64_t block, struct store_shunt **rows, size_t *count,
                                   struct error *error);
enum mr_status store_shunts_after(struct store *store, int64_t session, int64_t boot, int64_t block,
                                  struct store_shunt **rows, size_t *count, struct error *error);

/* ---- the predictor: what the board said of the mats, the runway and the parameters that a landing
 * was armed with ----
 *
 * A row that came in parts is completed by the next one put. */

/* `*lamp_limit`: NaN: none. `*items`: how many there are; 0: the board sent none. */
enum mr_status store_risk_get(struct store *store, int64_t run, struct mr_risk_plan *plan,
                              float *lamp_limit, size_t *items, struct error *error);

/* Whole runways only. `*there` false: the landing has none. */
enum mr_status store_runway_put(struct store *store, int64_t run,
                                const struct mr_predictor_state *state, int64_t source,
                                struct error *error);
enum mr_status store_runway_get(struct store *store, int64_t run, struct mr_predictor_state *state,
                                int64_t *source, bool *there, struct error *error);
/* `*items`: how many there are; all MR_PREDICT_ITEMS are needed. */
enum mr_status store_predict_config(struct store *store, int64_t run,
                                    struct mr_predictor_config *config, size_t *items,
                                    struct error *error);

/* ---- what came into the campaign from a file: the file, and readings of other instruments ----
 *
 * A session of matrig import is a session like that of matrig log; its row in `imports` says from
 * which file. */

/* Of a session; `*found` false: it was logged. Its mapping is not read. */
enum mr_status store_import_get(struct store *store, int64_t session, struct store_import *import,
                                bool *found, struct error *error);
/* The session that took in a file of this hash with this mapping (NULL: none), of this bus and of
 * the board at this base, to its end; 0: none has. */
enum mr_status store_import_find(struct store *store, const struct store_import *import,
                                 uint16_t can_base, int64_t *session, struct error *error);

/* Readings of one channel by 1 ms blocks, in its unit. */
struct store_imported {
    int64_t index; /* channel */
    int64_t first_block;
    int64_t stride; /* blocks from one sample of the instrument to the next */
    size_t count;
    float *reading; /* NaN: missing; a read allocates it */
};
enum mr_status store_imported_put(struct store *store, int64_t run,
                                  const struct store_imported *readings, struct error *error);
/* store_imported_free releases them. A row whose readings are no whole floats is left out. */
enum mr_status store_imported(struct store *store, int64_t run, struct store_imported **rows,
                              size_t *count, struct error *error);
void store_imported_free(struct store_imported *rows, size_t count);

/* ---- reading a campaign while another process writes it: what has come since the last look, in
 * order of reception ---- */

/* Where one has read to. */
struct store_follow_place {
    int64_t frame;                /* id of the newest frame read */
    int64_t session, boot, index; /* of the newest block read */
};

/* The place some `frames` before the end, or the beginning. */
enum mr_status store_follow_from(struct store *store, int64_t frames,
                                 struct store_follow_place *place, struct error *error);

/* Gives up to `most` frames that the board sent after the place, and the blocks received until
 * then, to `frame` and `record`, and moves the place. `*more`: there are more. */
struct store_follower {
    void (*frame)(void *context, const struct store_frame *frame);
    void (*record)(void *context, const uint8_t *record, size_t length, int64_t host_us);
    void *context;
};
enum mr_status store_follow(struct store *store, struct store_follow_place *place, int64_t most,
                            const struct store_follower *follower, bool *more, struct error *error);

/* ---- what matrig log, which must not lose what comes, needs beyond writing: to know whether
 * waiting helps, to write a transaction again, and to go on elsewhere when somebody has taken the
 * file away ---- */

/* Why writing failed, where it may succeed later. */
enum store_refusal {
    STORE_TAKES,  /* nothing failed, or waiting does not help */
    STORE_LOCKED, /* another program is writing */
    STORE_FULL,   /* no room on the disk */
    STORE_FAILS,  /* the disk or the file system says so */
    STORE_GROWN,  /* the file may not become larger: another one may */
};

/* Another program that writes is waited for so long in each call; else 30 s. */
void store_patience(struct store *store, int wait_ms);
/* Of the last call that failed, and forgets it. */
enum store_refusal store_take_refusal(struct store *store);
/* The journal may not grow: writes it back. True: another try may succeed. Between transactions. */
bool store_make_room(struct store *store);
/* Takes back what was put since store_begin. Without a transaction nothing happens. */
void store_roll_back(struct store *store);

/* Where the file is, by its path, and what the store has open. */
enum store_place {
    STORE_IN_PLACE,
    STORE_MISSING,
    STORE_REPLACED,
    STORE_NO_JOURNAL,
    STORE_NO_INDEX, /* of the journal: other programs would not see this one any more */
    STORE_OVERWRITTEN,
    STORE_EMPTIED
};
struct store_identity {
    dev_t device, journal_device;
    ino_t file, journal, index;
};
/* Of what is at the path just after opening. */
void store_identify(const char *path, struct store_identity *identity);
enum store_place store_find(const char *path, const struct store_identity *identity);

/* Copies all that is committed, from the open file wherever it is, into the new file at `path`, and
 * opens that to check it. MR_IO: also when something is there already. */
enum mr_status store_copy_to(struct store *store, const char *path, struct error *error);
/* The path where the open file is now, as far as the system knows; "": deleted. */
void store_whereabouts(const struct store *store, char *out, size_t size);
/* As store_close, of a store whose file was taken away: what is at its path belongs to somebody
 * else, and is not touched. `moved`: the open file itself is the log's: the journal is written back
 * into it. */
void store_leave(struct store *store, bool moved);
/* After it: the file's journal at the old path, which SQLite would write into whatever is put
 * there. One of another file stays. */
void store_journal_remove(const char *path, const struct store_identity *identity);

/* ---- whether the file is what was logged ---- */

/* Looked at from now on; also before each write of SQLite to it, and none
 * goes into one that somebody overwrote. */
void store_watch_file(struct store *store);
/* Somebody overwrote the file past SQLite (cp) or made it shorter: by its header and size, or
 * SQLite finds it damaged. Once true, it stays so. */
bool store_overwritten(struct store *store);
/* Before a commit: what is the newest of the session now. After it. */
enum mr_status store_note_logged(struct store *store, int64_t session, struct error *error);
void store_logged_committed(struct store *store);
/* In a transaction, when another program has committed since the last one: `*there` false: what was
 * committed of the session is no longer in the campaign. */
enum mr_status store_session_there(struct store *store, bool *there, struct error *error);
/* After store_leave of such a file: its journal gets the name `kept`, because SQLite would write it
 * into what is in the file now. False: there is none, or it stays. */
bool store_journal_aside(const char *path, const char *kept);

#endif
