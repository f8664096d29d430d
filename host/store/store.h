/* The campaign database: one SQLite file (WAL) with the received data and the results computed from
 * it.
 *
 * Board time is in microseconds since the board's scans began; host time is Unix time in
 * microseconds. A landing is identified by RUN, its id in the database, from 1. It also has the
 * board's identity and the board's landing number, by which copies of a landing are recognised.
 * Missing values are NULL in the file, NaN or STORE_NONE in structs. Texts passed to a function are
 * copied; the caller frees arrays that a read returns.
 *
 * Writing uses one transaction at a time: store_begin, any number of puts, store_commit. A commit
 * is on disk when it returns. Every function returns MR_OK or sets `error` and returns its
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

#define STORE_VERSION      1          /* version of the tables: PRAGMA user_version */
#define STORE_APPLICATION  0x4d545247 /* "MTRG": PRAGMA application_id */
#define STORE_SWITCHES_MAX 64u

enum store_mode {
    STORE_OPEN,   /* the file must exist */
    STORE_CREATE, /* the file is created if missing */
    /* as STORE_CREATE, for a log: no other log can open the campaign until it is closed */
    STORE_LOG,
    STORE_READ,   /* the file must exist and is not written; it may be on a read-only medium */
    STORE_SOURCE, /* opened read-only, as STORE_READ, but attached databases are written */
};

struct store;

/* Opens a campaign. MR_IO: it cannot be opened, or another log has it open. MR_MALFORMED: not a
 * campaign database. MR_VERSION: the campaign has another version. */
enum mr_status store_open(const char *path, enum store_mode mode, struct store **store,
                          struct error *error);
/* True if a log has the campaign open. */
bool store_is_logged(struct store *store);
/* Checks that a campaign can be written at the path; MR_IO: it cannot, and `error` has the
 * reason. */
enum mr_status store_place_to_write(const char *path, struct error *error);
void store_close(struct store *store); /* rolls back uncommitted changes; NULL is allowed */
const char *store_path(const struct store *store);

enum mr_status store_begin(struct store *store, struct error *error);
enum mr_status store_commit(struct store *store, struct error *error);

/* A session is one run of `matrig log`. */
enum mr_status store_session_add(struct store *store, struct store_session *session,
                                 struct error *error);
enum mr_status store_session_end(struct store *store, int64_t session, int64_t ended_us,
                                 const char *ended_by, struct error *error);

enum mr_status store_session_get(struct store *store, int64_t session,
                                 struct store_session_row *row, struct error *error);

/* Counts of a session on one of its links so far; `link` is an enum link_kind. */
enum mr_status store_link_put(struct store *store, int64_t session, int link,
                              const struct store_link_counts *counts, struct error *error);
enum mr_status store_link_get(struct store *store, int64_t session, int link,
                              struct store_link_counts *counts, bool *found, struct error *error);

/* Number of copies of a message that the session has missed on a link so far. */
enum mr_status store_missing_put(struct store *store, int64_t session, int link,
                                 const char *message, int64_t missing, struct error *error);

enum mr_status store_landing_add(struct store *store, struct store_landing *landing,
                                 struct error *error);
enum mr_status store_landing_put(struct store *store, const struct store_landing *landing,
                                 struct error *error);
enum mr_status store_landing_get(struct store *store, int64_t run, struct store_landing *landing,
                                 struct error *error);
/* *run below 0: is replaced by the RUN of the landing with the board's number -*run. MR_UNKNOWN:
 * there is no such landing, or more than one. */
enum mr_status store_run_find(struct store *store, int64_t *run, struct error *error);

/* Rows of a landing in order, which the caller frees: store_edges(store, run, &rows, &count, error)
 * reads rows of struct store_edge.
 *
 * Switch events: `code` is the reason (common/switches.h), `detail` the switch, 0 if not known,
 * `count` the number of times. Channel events: `code` is the validity (common/channels.h), `detail`
 * the channel, `board_us` the start. Restarts: the starts of the board that ended the landing;
 * `detail` has the bits of hello's reset_cause, 0: not received. Backlogs: blocks in which other
 * tasks waited for the predictor. Readings: those of a gage survey (`run`: its id), in the order of
 * writing. */
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
    X(store_braking_edges, braking_edge, BRAKING_EDGES) \
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

/* Rows of the campaign: store_landings(store, &rows, &count, error). Withdrawn series and surveys
 * are left out. */
#define STORE_ROWS_OF_CAMPAIGN(X)                    \
    X(store_landings, landing, LANDINGS)             \
    X(store_series_all, series, SERIES)              \
    X(store_advices, advice, ADVICES)                \
    X(store_gage_surveys, gage_survey, GAGE_SURVEYS) \
    X(store_withdrawals, withdrawal, WITHDRAWALS)    \
    X(store_records, record, RECORDS)
#define STORE_ALL_ROWS_DECLARED(function, row, NAME)                                       \
    enum mr_status function(struct store *store, struct store_##row **rows, size_t *count, \
                            struct error *error);
STORE_ROWS_OF_CAMPAIGN(STORE_ALL_ROWS_DECLARED)

/* Puts a row into the campaign: store_event_put(store, &event, error). An existing row of the slow
 * log only gets its time if it had none. A time map relates the board's clock to this computer's
 * clock on one link. It belongs to a landing, or to all data from the board until it restarted or
 * the session ended (run STORE_NONE); host/link/timemap.h explains how it is computed. Advices are
 * the stored advice before landings. */
#define STORE_PUT_OF_CAMPAIGN(X)    \
    X(store_event_put, event)       \
    X(store_time_map_put, time_map) \
    X(store_slow_put, slow)         \
    X(store_series_add, series)     \
    X(store_advice_add, advice)     \
    X(store_withdraw, withdrawal)   \
    X(store_record_add, record)
#define STORE_ADD_DECLARED(function, row)                                         \
    enum mr_status function(struct store *store, const struct store_##row *value, \
                            struct error *error);
STORE_PUT_OF_CAMPAIGN(STORE_ADD_DECLARED)

/* store_day_newest(store, &run, error): the newest landing that was logged here, neither imported
 * nor disarmed before the gear arrived. store_day_session: the newest session that was logged here.
 * store_newest_session: the newest session. 0: none. */
#define STORE_NUMBERS_OF_CAMPAIGN(X)  \
    X(store_day_newest, DAY_NEWEST)   \
    X(store_day_session, DAY_SESSION) \
    X(store_newest_session, SESSION_NEWEST)
#define STORE_NUMBER_DECLARED(function, NAME) \
    enum mr_status function(struct store *store, int64_t *value, struct error *error);
STORE_NUMBERS_OF_CAMPAIGN(STORE_NUMBER_DECLARED)

/* store_blocks_count: number of blocks of a landing. store_block_first: its first block; -1: none.
 * store_gage_loaded: time at which a gage survey (`run`: its id) was last sent to a board; 0:
 * never. */
#define STORE_NUMBERS_OF_LANDING(X)     \
    X(store_blocks_count, BLOCKS_COUNT) \
    X(store_block_first, BLOCK_FIRST)   \
    X(store_gage_loaded, GAGE_LOADED)
#define STORE_NUMBER_OF_DECLARED(function, NAME) \
    enum mr_status function(struct store *store, int64_t run, int64_t *value, struct error *error);
STORE_NUMBERS_OF_LANDING(STORE_NUMBER_OF_DECLARED)

/* store_edge_put(store, run, &edge, error): data that the board reported, stored once, from
 * whichever link. tables.def defines what happens to an existing row. A calibration row has one
 * value of a channel's calibration; its `item` is an enum mr_calibration_item. */
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

/* Stores a whole configuration as text (host/board/config_text.h), by the CRC to which landings
 * refer. An existing text is not changed. */
enum mr_status store_configuration_put(struct store *store, uint32_t crc, const char *text,
                                       struct error *error);
/* *text: NULL if the configuration was never read; otherwise the caller frees it. */
enum mr_status store_configuration_get(struct store *store, uint32_t crc, char **text,
                                       struct error *error);

/* Configuration of a channel for a landing, as the board reported it. */
enum mr_status store_channel_put(struct store *store, int64_t run, int64_t index,
                                 const struct mr_channel_config *channel, struct error *error);
/* Slack of a segment for a landing. */
enum mr_status store_segment_put(struct store *store, int64_t run,
                                 const struct store_segment *segment, struct error *error);
/* Reads the channels of a landing, with their calibration. `channels` has room for MR_CHANNELS;
 * channels that were not reported have kind MR_KIND_NONE. `*found`: number of reported channels. */
enum mr_status store_channels(struct store *store, int64_t run, struct mr_channel_config *channels,
                              size_t *found, struct error *error);

/* Puts a block record as received, over serial (LINK_SERIAL) or from the black box
 * (STORE_LINK_BOX); `run` is STORE_NONE outside landings. An existing block is not changed. */
#define STORE_LINK_BOX 2
enum mr_status store_block_put(struct store *store, int64_t session, int64_t boot, int64_t run,
                               int link, int64_t index, int64_t host_us, const uint8_t *record,
                               size_t length, struct error *error);
/* Calls `each` for the blocks of a landing by ascending index, with the link over which they were
 * received (or STORE_LINK_BOX), as long as `each` returns MR_OK. */
enum mr_status store_blocks_each(struct store *store, int64_t run,
                                 enum mr_status (*each)(void *context, const uint8_t *record,
                                                        size_t length, int link),
                                 void *context, struct error *error);
/* As store_blocks_each, with the indexes only, which is faster. */
enum mr_status store_block_indexes_each(struct store *store, int64_t run,
                                        void (*each)(void *context, int64_t index), void *context,
                                        struct error *error);
/* The first block of a landing between `from` and `to`; -1: none. */
enum mr_status store_block_within(struct store *store, int64_t run, int64_t from, int64_t to,
                                  int64_t *index, struct error *error);

struct store_frame {
    int64_t run;   /* landing of the frame; STORE_NONE outside landings */
    int link;      /* enum link_kind */
    int direction; /* 0 from the board, 1 to the board */
    /* number of the serial frame; on CAN, number of frames received before it in the session */
    int64_t seq;
    int64_t board_us; /* board time; STORE_NONE: not known yet */
    int64_t host_us;
    uint32_t id; /* identifier of the catalogue: on CAN without the board's base */
    size_t length;
    const uint8_t *data;
};
/* Frames are buffered and written together (store_frames.c), at the latest at a commit or before
 * any read. A write error may therefore be returned by a later call. */
/* The newest row of the frames; 0: none. */
enum mr_status store_frames_mark(struct store *store, int64_t *mark, struct error *error);
enum mr_status store_frame_put(struct store *store, int64_t session,
                               const struct store_frame *frame, struct error *error);
/* Calls `each` for the frames of a landing on one link, in order of reception. */
enum mr_status store_frames_each(struct store *store, int64_t run, int link,
                                 enum mr_status (*each)(void *context,
                                                        const struct store_frame *frame),
                                 void *context, struct error *error);
/* The base that was added on the bus to the identifiers of a landing's frames
 * (common/canbase.h). */
enum mr_status store_frames_base(struct store *store, int64_t run, uint16_t *base,
                                 struct error *error);
enum mr_status store_frames_count(struct store *store, int64_t run, int link, int64_t *count,
                                  struct error *error);

/* Mean of a quantity over a landing; `told` 0: the campaign has no column of it. */
enum mr_status store_mean_get(struct store *store, int64_t run, enum mr_quantity quantity,
                              struct store_mean *mean, struct error *error);
/* Rows of one board, or of all boards (NULL), in order. */
enum mr_status store_slow_rows(struct store *store, const char *board_uid, struct store_slow **rows,
                               size_t *count, struct error *error);

/* The board rejected an edge that it had reported as a gate of the landing: the row loses its
 * switch; the event is kept. */
enum mr_status store_edge_refuse(struct store *store, int64_t run, int64_t count,
                                 struct error *error);
enum mr_status store_result_get(struct store *store, int64_t run, struct store_result *result,
                                bool *found, struct error *error);
/* Faults of the landing's board and session up to the end of the landing: the newest row of each
 * fault. */
enum mr_status store_faults(struct store *store, const struct store_landing *landing,
                            struct store_fault **rows, size_t *count, struct error *error);

/* Makes a campaign of one landing at `path`, which must not exist: all data of the landing as RUN
 * 1, consistent even while the campaign is being written, and a table `bundles` with the image
 * (NULL: none) and the digests of image and record. */
enum mr_status store_bundle_make(struct store *store, int64_t run, const char *path,
                                 const uint8_t *image, size_t length, struct error *error);
/* Checks the digests of a bundle's landing (MR_CRC: they differ) and writes its image to `path`.
 * *there false: not a bundle, or a bundle without an image. */
enum mr_status store_bundle_open(struct store *store, int64_t run, const char *path, bool *there,
                                 struct error *error);

/* Errors that the links detected during a landing (enum link_count_event), summed. */
enum mr_status store_troubles(struct store *store, int64_t run, int link,
                              struct store_trouble **rows, size_t *count, struct error *error);
/* `kind` of the events for these errors. code: the error; detail: number since the previous event;
 * value: number in the session so far. */
const char *store_trouble_kind(int link);
/* Adds lost data. The message "frame" counts frames of the link; a message's name counts the lost
 * frames of that message, if known. */
enum mr_status store_gap_put(struct store *store, int64_t session, int64_t run,
                             const struct store_gap *gap, struct error *error);

/* One channel of a comparison with the simulation. The series has u at t0 + i dt, relative to
 * touchdown, aligned with the measured series. */
struct store_simulation {
    int64_t number; /* number of the transducer */
    double station_ft;
    double peak_measured_in, peak_measured_error_in;
    double peak_simulated_in, peak_simulated_error_in;
    double rms_in;
    double end_measured_in, end_simulated_in;
    double t0_s, dt_s;
    float *series_in; /* `length` values; a read allocates them */
    float *spread_in; /* `length` values: standard deviation over an ensemble; NULL: one runway */
    size_t length;
};
/* Fields common to all channels of a simulation. Missing (stored by an older matrig): NaN,
 * STORE_NONE, NULL. */
struct store_simulation_head {
    double run_ms, error_in; /* duration of the simulation; the solver's error estimate */
    int64_t seeds;           /* number of runways */
    double segments_dt_s;
    /* Remaining openings of each segment, MR_SEGMENTS values per row; a read allocates them. */
    float *segments_in;
    size_t segment_rows;
    char file[120]; /* file of the scene or campaign that was simulated */
};
enum mr_status store_simulation_put(struct store *store, int64_t run, const char *scene_json,
                                    int64_t made_us, const struct store_simulation_head *head,
                                    const struct store_simulation *rows, size_t count,
                                    struct error *error);
/* The newest comparison of a landing; *count 0: none. store_simulations_free releases rows and
 * their series. */
enum mr_status store_simulations(struct store *store, int64_t run, struct store_simulation **rows,
                                 size_t *count, struct error *error);
/* Head of the newest comparison; the caller frees segments_in. */
enum mr_status store_simulation_head(struct store *store, int64_t run,
                                     struct store_simulation_head *head, struct error *error);
void store_simulations_free(struct store_simulation *rows, size_t count);

/* For links that are read one after the other: assigns CAN frames after `mark` to the landing. They
 * are the frames from the first state of the landing that serial reported to the last such state,
 * or to the row `last` unless it is STORE_NONE. */
enum mr_status store_frames_place(struct store *store, int64_t session, int64_t run, int64_t mark,
                                  int64_t last, struct error *error);

/* A shunt calibration does not belong to a landing: it is after one landing and before the next. */

enum mr_status store_shunt_put(struct store *store, int64_t session, int64_t boot,
                               const struct store_shunt *shunt, struct error *error);
/* The last calibration before `block` of a session's boot, and the first one from `block` on;
 * *count 0: none. */
enum mr_status store_shunts_before(struct store *store, int64_t session, int64_t boot,
                                   int64_t block, struct store_shunt **rows, size_t *count,
                                   struct error *error);
enum mr_status store_shunts_after(struct store *store, int64_t session, int64_t boot, int64_t block,
                                  struct store_shunt **rows, size_t *count, struct error *error);

/* ---- the predictor: the mats and the runway as the board reported them, and the parameters that
 * it had when armed ----
 *
 * A row that arrives in parts is completed by the next put. */

/* `*lamp_limit`: NaN: none. `*items`: number of stored items; 0: the board sent none. */
enum mr_status store_risk_get(struct store *store, int64_t run, struct mr_risk_plan *plan,
                              float *lamp_limit, size_t *items, struct error *error);

/* Only complete runways are stored. `*there` false: the landing has none. */
enum mr_status store_runway_put(struct store *store, int64_t run,
                                const struct mr_predictor_state *state, int64_t source,
                                struct error *error);
enum mr_status store_runway_get(struct store *store, int64_t run, struct mr_predictor_state *state,
                                int64_t *source, bool *there, struct error *error);
/* `*items`: number of stored items; all MR_PREDICT_ITEMS are needed. */
enum mr_status store_predict_config(struct store *store, int64_t run,
                                    struct mr_predictor_config *config, size_t *items,
                                    struct error *error);

/* ---- imports from a file: the file, and readings of other instruments ----
 *
 * A session of matrig import is stored like a session of matrig log; its row in `imports` names the
 * file. */

/* The import of a session; `*found` false: the session was logged. The mapping is not read. */
enum mr_status store_import_get(struct store *store, int64_t session, struct store_import *import,
                                bool *found, struct error *error);
/* The session that completely imported a file with this hash, this mapping (NULL: none), this bus
 * and this base of the board; 0: none. */
enum mr_status store_import_find(struct store *store, const struct store_import *import,
                                 uint16_t can_base, int64_t *session, struct error *error);

/* Readings of one channel by 1 ms blocks, in its unit. */
struct store_imported {
    int64_t index; /* index of the channel */
    int64_t first_block;
    int64_t stride; /* blocks between two samples of the instrument */
    size_t count;
    float *reading; /* NaN: missing; a read allocates the array */
};
enum mr_status store_imported_put(struct store *store, int64_t run,
                                  const struct store_imported *readings, struct error *error);
/* Reads all channels; release them with store_imported_free. A row whose size is not a whole number
 * of floats is left out. */
enum mr_status store_imported(struct store *store, int64_t run, struct store_imported **rows,
                              size_t *count, struct error *error);
void store_imported_free(struct store_imported *rows, size_t count);

/* ---- reading a campaign while another process writes it: the new data since the last read, in
 * order of reception ---- */

/* Position up to which the campaign was read. */
struct store_follow_place {
    int64_t frame;                /* id of the newest frame read */
    int64_t session, boot, index; /* position of the newest block read */
};

/* Sets the position to `frames` frames before the end, or to the beginning. */
enum mr_status store_follow_from(struct store *store, int64_t frames,
                                 struct store_follow_place *place, struct error *error);

/* Passes up to `most` frames that the board sent after the position, and the blocks received until
 * then, to `frame` and `record`, and moves the position. `*more`: there is more data. */
struct store_follower {
    void (*frame)(void *context, const struct store_frame *frame);
    void (*record)(void *context, const uint8_t *record, size_t length, int64_t host_us);
    void *context;
};
enum mr_status store_follow(struct store *store, struct store_follow_place *place, int64_t most,
                            const struct store_follower *follower, bool *more, struct error *error);

/* ---- additional functions for matrig log, which must not lose data: to know whether waiting
 * helps, to write a transaction again, and to continue in a different file if the campaign's file
 * was removed ---- */

/* Reason of a failed write that may succeed later. */
enum store_refusal {
    STORE_TAKES,  /* nothing failed, or waiting does not help */
    STORE_LOCKED, /* another program is writing */
    STORE_FULL,   /* the disk is full */
    STORE_FAILS,  /* error of the disk or the file system */
    STORE_GROWN,  /* the file has reached its size limit: a different file is needed */
};

/* Sets how long each call waits for another program that writes; default 30 s. */
void store_patience(struct store *store, int wait_ms);
/* Returns the reason of the last failed call, and resets it. */
enum store_refusal store_take_refusal(struct store *store);
/* Writes back the journal when it cannot grow. Returns true if another try may succeed. Call it
 * between transactions. */
bool store_make_room(struct store *store);
/* Rolls back the open transaction; without a transaction it has no effect. */
void store_roll_back(struct store *store);

/* State of the file at the path, compared with the file that the store has open. */
enum store_place {
    STORE_IN_PLACE,
    STORE_MISSING,
    STORE_REPLACED,
    STORE_NO_JOURNAL,
    STORE_NO_INDEX, /* the index of the journal is missing: other programs no longer see this log */
    STORE_OVERWRITTEN,
    STORE_EMPTIED
};
struct store_identity {
    dev_t device, journal_device;
    ino_t file, journal, index;
};
/* Records the identity of the file at the path; call it just after opening. */
void store_identify(const char *path, struct store_identity *identity);
enum store_place store_find(const char *path, const struct store_identity *identity);

/* Copies all committed data, from the open file wherever it is, into a new file at `path`, and
 * opens the copy to check it. MR_IO: also if `path` exists. */
enum mr_status store_copy_to(struct store *store, const char *path, struct error *error);
/* Current path of the open file, as far as the system knows; "": deleted. */
void store_whereabouts(const struct store *store, char *out, size_t size);
/* As store_close, for a store whose file was moved or replaced. A file at its old path belongs to
 * another program and is not touched. `moved`: the open file is still the log's, and the journal is
 * written back into it. */
void store_leave(struct store *store, bool moved);
/* Call after store_leave. Removes the file's journal at the old path, which SQLite would otherwise
 * write into any file put there. A journal of another file is not removed. */
void store_journal_remove(const char *path, const struct store_identity *identity);

/* ---- detection of a file that was overwritten ---- */

/* Starts checking the file. It is also checked before each write of SQLite, and an overwritten file
 * is not written. */
void store_watch_file(struct store *store);
/* True if another program overwrote the file without SQLite (cp) or truncated it: its header or
 * size shows it, or SQLite finds the file damaged. Once true, it stays true. */
bool store_overwritten(struct store *store);
/* store_note_logged records the newest data of the session; call it before a commit. Call
 * store_logged_committed after the commit. */
enum mr_status store_note_logged(struct store *store, int64_t session, struct error *error);
void store_logged_committed(struct store *store);
/* Checks, in a transaction and after another program has committed, whether the committed data of
 * the session is still there; `*there` false: it is not. */
enum mr_status store_session_there(struct store *store, bool *there, struct error *error);
/* Call after store_leave of an overwritten file: renames its journal to `kept`, because SQLite
 * would write it into the new content. Returns false if there is no journal, or it cannot be
 * renamed. */
bool store_journal_set_aside(const char *path, const char *kept);

#endif
