/* The campaign database: one SQLite file (WAL) with the received data and the results computed from
 * it.
 *
 * Board time is in microseconds since the board's scans began. Host time is Unix time in
 * microseconds. RUN, in code `run`, is the id of a landing in the database, from 1. Copies of a
 * landing are recognised by the board's unique number and the board's landing number. A missing
 * value is NULL in the file, and NaN or STORE_NONE in a struct. A function copies the texts that it
 * gets. The caller frees the arrays that it reads.
 *
 * There is one transaction at a time: store_begin, any number of puts, store_commit. The data is on
 * disk when store_commit returns. Every function that returns a status returns MR_OK, or sets
 * `error` and returns the error's status. */
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

#define STORE_VERSION        1          /* PRAGMA user_version: version of the tables */
#define STORE_APPLICATION_ID 0x4d545247 /* PRAGMA application_id, "MTRG" in ASCII */
#define STORE_SWITCHES_MAX   64u

enum store_mode {
    STORE_OPEN,   /* the file must exist */
    STORE_CREATE, /* the file is created if missing */
    /* as STORE_CREATE, and no other log can open the campaign until this one closes it */
    STORE_LOG,
    STORE_READ, /* the file must exist and is not changed; it may be on a read-only medium */
    STORE_READ_FOR_BUNDLE, /* as STORE_READ, but an attached bundle is written */
};

struct store;

/* Opens a campaign. Fails with MR_IO if the file cannot be opened or another log has it open, with
 * MR_MALFORMED if it is not a campaign database, with MR_VERSION if it has another version. */
enum mr_status store_open(const char *path, enum store_mode mode, struct store **store,
                          struct error *error);
/* True if a matrig log, in any process, has the campaign open. */
bool store_is_being_logged(struct store *store);
/* Checks that a campaign can be written at the path. Fails with MR_IO and the reason. */
enum mr_status store_check_writable(const char *path, struct error *error);
/* closes the store; rolls back uncommitted changes. NULL is allowed */
void store_close(struct store *store);
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

/* Stores and reads the counts of a session on one of its links up to now; `link` is an enum
 * link_kind. */
enum mr_status store_link_put(struct store *store, int64_t session, int link,
                              const struct store_link_counts *counts, struct error *error);
enum mr_status store_link_get(struct store *store, int64_t session, int link,
                              struct store_link_counts *counts, bool *found, struct error *error);

/* Stores, for one message name, how many messages the session has lost on a link so far. */
enum mr_status store_missing_put(struct store *store, int64_t session, int link,
                                 const char *message, int64_t missing, struct error *error);

enum mr_status store_landing_add(struct store *store, struct store_landing *landing,
                                 struct error *error);
enum mr_status store_landing_put(struct store *store, const struct store_landing *landing,
                                 struct error *error);
enum mr_status store_landing_get(struct store *store, int64_t run, struct store_landing *landing,
                                 struct error *error);
/* If *run is negative, -*run is a landing number of the board, and *run is set to the RUN of that
 * landing. Fails with MR_UNKNOWN if there is no such landing, or more than one. */
enum mr_status store_find_run(struct store *store, int64_t *run, struct error *error);

/* Functions that read all rows of one kind of a landing, in order. A function named by a plural
 * reads an array: store_edges_get(store, run, &rows, &count, error) reads rows of struct
 * store_edge, and the caller frees the array.
 *
 * Switch events: `code` is the reason (common/switches.h), `detail` the switch (0: unknown),
 * `count` the number of times. Channel events: `code` is the validity (common/channels.h), `detail`
 * the channel, `board_us` the start. Restarts are the starts of the board that ended the landing:
 * `detail` has the bits of reset_cause in the message `hello` (0: not received). Backlogs are the
 * blocks in which other tasks waited for the predictor. For gage readings, `run` is the id of the
 * gage survey, and the rows are in the order of writing. */
#define STORE_LANDING_ROW_FUNCTIONS(X)                      \
    X(store_switches_get, switch, SWITCHES)                 \
    X(store_segments_get, segment, SEGMENTS)                \
    X(store_edges_get, edge, EDGES)                         \
    X(store_motions_get, motion, MOTIONS)                   \
    X(store_zones_get, zone, ZONES)                         \
    X(store_gaps_get, gap, GAPS)                            \
    X(store_time_maps_get, time_map, TIME_MAPS)             \
    X(store_film_frames_get, film_frame, FILM_FRAMES)       \
    X(store_switch_events_get, fault, SWITCH_EVENTS)        \
    X(store_channel_events_get, fault, CHANNEL_EVENTS)      \
    X(store_restarts_get, fault, RESTARTS)                  \
    X(store_command_events_get, fault, COMMAND_EVENTS)      \
    X(store_key_states_get, fault, KEY_STATES)              \
    X(store_bands_get, band, BANDS)                         \
    X(store_band_events_get, band_event, BAND_EVENTS)       \
    X(store_risks_get, risk, RISKS)                         \
    X(store_predictions_get, prediction, PREDICTIONS)       \
    X(store_backlogs_get, backlog, BACKLOGS)                \
    X(store_braking_edges_get, braking_edge, BRAKING_EDGES) \
    X(store_trusts_get, trust, TRUSTS)                      \
    X(store_predict_items_get, predict_item, PREDICT_ITEMS) \
    X(store_risk_items_get, risk_item, RISK_ITEMS)          \
    X(store_changes_get, change, CHANGES)                   \
    X(store_observations_get, observation, OBSERVATIONS)    \
    X(store_gage_readings_get, gage_reading, GAGE_READINGS)
#define STORE_DECLARE_LANDING_ROWS(function, row, NAME)                                  \
    enum mr_status function(struct store *store, int64_t run, struct store_##row **rows, \
                            size_t *count, struct error *error);
STORE_LANDING_ROW_FUNCTIONS(STORE_DECLARE_LANDING_ROWS)

/* Functions that read all rows of one kind of the campaign: store_landings_get(store, &rows,
 * &count, error). Withdrawn series and surveys are left out. */
#define STORE_CAMPAIGN_ROW_FUNCTIONS(X)                  \
    X(store_landings_get, landing, LANDINGS)             \
    X(store_all_series_get, series, SERIES)              \
    X(store_advices_get, advice, ADVICES)                \
    X(store_gage_surveys_get, gage_survey, GAGE_SURVEYS) \
    X(store_withdrawals_get, withdrawal, WITHDRAWALS)    \
    X(store_records_get, record, RECORDS)
#define STORE_DECLARE_CAMPAIGN_ROWS(function, row, NAME)                                   \
    enum mr_status function(struct store *store, struct store_##row **rows, size_t *count, \
                            struct error *error);
STORE_CAMPAIGN_ROW_FUNCTIONS(STORE_DECLARE_CAMPAIGN_ROWS)

/* Functions that write one row of the campaign: store_event_put(store, &event, error).
 *
 * If a row of the slow log exists, store_slow_put only adds the time that the row did not have. A
 * time map relates the board's clock to this computer's clock on one link (host/link/timemap.h). It
 * applies to a landing or, if `run` is STORE_NONE, to all data until the board restarted or the
 * session ended. An advice is a result of `matrig advise --keep`. */
#define STORE_CAMPAIGN_PUT_FUNCTIONS(X) \
    X(store_event_put, event)           \
    X(store_time_map_put, time_map)     \
    X(store_slow_put, slow)             \
    X(store_series_add, series)         \
    X(store_advice_add, advice)         \
    X(store_withdrawal_add, withdrawal) \
    X(store_record_add, record)
#define STORE_DECLARE_CAMPAIGN_PUT(function, row)                                 \
    enum mr_status function(struct store *store, const struct store_##row *value, \
                            struct error *error);
STORE_CAMPAIGN_PUT_FUNCTIONS(STORE_DECLARE_CAMPAIGN_PUT)

/* Functions that read one number of the campaign; 0: there is none.
 * store_newest_logged_run_get(store, &run, error) reads the newest RUN that was logged into this
 * campaign, not imported, and not disarmed before the gear arrived. store_newest_logged_session_get
 * reads the newest session that was not imported. store_newest_session_get reads the newest session
 * of all. */
#define STORE_CAMPAIGN_NUMBER_FUNCTIONS(X)                    \
    X(store_newest_logged_run_get, LOGGED_RUN_NEWEST)         \
    X(store_newest_logged_session_get, LOGGED_SESSION_NEWEST) \
    X(store_newest_session_get, SESSION_NEWEST)
#define STORE_DECLARE_CAMPAIGN_NUMBER(function, NAME) \
    enum mr_status function(struct store *store, int64_t *value, struct error *error);
STORE_CAMPAIGN_NUMBER_FUNCTIONS(STORE_DECLARE_CAMPAIGN_NUMBER)

/* Functions that read one number of a landing. store_blocks_count reads the number of its blocks.
 * store_first_block_get reads the index of its first block (-1: none). store_gage_load_time_get
 * reads the host time at which a gage survey was last sent to a board (0: never); `run` is the id
 * of the survey. */
#define STORE_LANDING_NUMBER_FUNCTIONS(X) \
    X(store_blocks_count, BLOCKS_COUNT)   \
    X(store_first_block_get, BLOCK_FIRST) \
    X(store_gage_load_time_get, GAGE_LOADED)
#define STORE_DECLARE_LANDING_NUMBER(function, NAME) \
    enum mr_status function(struct store *store, int64_t run, int64_t *value, struct error *error);
STORE_LANDING_NUMBER_FUNCTIONS(STORE_DECLARE_LANDING_NUMBER)

/* Functions that write one row of a landing: store_edge_put(store, run, &edge, error). Data that
 * both links deliver is stored once: tables.def defines how the function changes an existing row. A
 * calibration row has one value of a channel's calibration; `item` is an enum
 * mr_calibration_item. */
#define STORE_LANDING_PUT_FUNCTIONS(X) \
    X(quality)                         \
    X(switch)                          \
    X(edge)                            \
    X(motion)                          \
    X(zone)                            \
    X(result)                          \
    X(film_frame)                      \
    X(mat_temperature)                 \
    X(band)                            \
    X(band_event)                      \
    X(prediction) X(trust) X(risk) X(calibration) X(predict_item) X(risk_item) X(import)
#define STORE_DECLARE_LANDING_PUT(row)                                 \
    enum mr_status store_##row##_put(struct store *store, int64_t run, \
                                     const struct store_##row *value, struct error *error);
STORE_LANDING_PUT_FUNCTIONS(STORE_DECLARE_LANDING_PUT)

/* Stores a whole configuration as text (host/board/config_text.h). Landings refer to it by the CRC.
 * An existing text is not changed. */
enum mr_status store_configuration_put(struct store *store, uint32_t crc, const char *text,
                                       struct error *error);
/* Reads a configuration. *text is NULL if it was not stored; the caller frees it. */
enum mr_status store_configuration_get(struct store *store, uint32_t crc, char **text,
                                       struct error *error);

/* Stores the configuration of a channel for a landing, as the board reported it. */
enum mr_status store_channel_put(struct store *store, int64_t run, int64_t index,
                                 const struct mr_channel_config *channel, struct error *error);
/* Stores the slack of a segment for a landing. */
enum mr_status store_segment_put(struct store *store, int64_t run,
                                 const struct store_segment *segment, struct error *error);
/* Reads the channels of a landing, with their calibration, into an array of MR_CHANNELS. Channels
 * that the board did not report get kind MR_KIND_NONE. *found is the number of reported
 * channels. */
enum mr_status store_channels_get(struct store *store, int64_t run,
                                  struct mr_channel_config *channels, size_t *found,
                                  struct error *error);

/* Writes a block record as it was received over serial (link LINK_SERIAL) or from the black box
 * (link STORE_LINK_BLACK_BOX). `run` is STORE_NONE outside landings. An existing block is not
 * changed. */
#define STORE_LINK_BLACK_BOX 2
enum mr_status store_block_put(struct store *store, int64_t session, int64_t boot, int64_t run,
                               int link, int64_t index, int64_t host_us, const uint8_t *record,
                               size_t length, struct error *error);
/* Calls `each` for every block of a landing in ascending order of the index, as long as `each`
 * returns MR_OK. `link` is the link that delivered the block, or STORE_LINK_BLACK_BOX. */
enum mr_status store_blocks_for_each(struct store *store, int64_t run,
                                     enum mr_status (*each)(void *context, const uint8_t *record,
                                                            size_t length, int link),
                                     void *context, struct error *error);
/* As store_blocks_for_each, but reads only the indexes, which is faster. */
enum mr_status store_block_indexes_for_each(struct store *store, int64_t run,
                                            void (*each)(void *context, int64_t index),
                                            void *context, struct error *error);
/* Reads the index of the first block of a landing from `from` to `to`; -1: none. */
enum mr_status store_find_block_within(struct store *store, int64_t run, int64_t from, int64_t to,
                                       int64_t *index, struct error *error);

struct store_frame {
    int64_t run;   /* landing of the frame; STORE_NONE outside landings */
    int link;      /* enum link_kind */
    int direction; /* 0: from the board; 1: to the board */
    /* serial: sequence number of the frame; CAN: number of frames received before it in the
     * session */
    int64_t seq;
    int64_t board_us; /* STORE_NONE: not known yet */
    int64_t host_us;
    uint32_t id; /* identifier in the catalogue; the board's CAN base is already subtracted */
    size_t length;
    const uint8_t *data;
};
/* Frames are buffered and written together (store_frames.c), at the latest at a commit or before
 * any read. The error of a failed write may therefore be returned by a later call. */
/* Reads the row id of the newest frame; 0: none. */
enum mr_status store_newest_frame_get(struct store *store, int64_t *mark, struct error *error);
enum mr_status store_frame_put(struct store *store, int64_t session,
                               const struct store_frame *frame, struct error *error);
/* Calls `each` for the frames of a landing on one link, in order of reception. */
enum mr_status store_frames_for_each(struct store *store, int64_t run, int link,
                                     enum mr_status (*each)(void *context,
                                                            const struct store_frame *frame),
                                     void *context, struct error *error);
/* Reads the CAN base of the board at a landing: the number that the board adds to its frames'
 * identifiers on the bus (common/canbase.h). */
enum mr_status store_can_base_get(struct store *store, int64_t run, uint16_t *base,
                                  struct error *error);
enum mr_status store_frames_count(struct store *store, int64_t run, int link, int64_t *count,
                                  struct error *error);

/* Reads the mean of a quantity over a landing. If the campaign has no column for the quantity,
 * mean->messages is 0. */
enum mr_status store_mean_get(struct store *store, int64_t run, enum mr_quantity quantity,
                              struct store_mean *mean, struct error *error);
/* Reads the slow log of one board, or of all boards (board_uid NULL), in order of time. */
enum mr_status store_slow_log_get(struct store *store, const char *board_uid,
                                  struct store_slow **rows, size_t *count, struct error *error);

/* Removes the switch from an edge's row. The board has rejected the edge after reporting it as a
 * gate of the landing. */
enum mr_status store_edge_reject(struct store *store, int64_t run, int64_t count,
                                 struct error *error);
enum mr_status store_result_get(struct store *store, int64_t run, struct store_result *result,
                                bool *found, struct error *error);
/* Reads the newest row of each fault that the board reported from its start until the end of the
 * landing. */
enum mr_status store_faults_get(struct store *store, const struct store_landing *landing,
                                struct store_fault **rows, size_t *count, struct error *error);

/* Makes a bundle: a campaign with one landing as RUN 1, in a new file at `path`. The bundle is
 * consistent even if a log writes to `store` meanwhile. Its table `bundles` has the firmware image
 * (NULL: none) and the digests of image and block records. */
enum mr_status store_bundle_make(struct store *store, int64_t run, const char *path,
                                 const uint8_t *image, size_t length, struct error *error);
/* Checks the digests of a landing in a bundle, and writes the firmware image to `path`. Fails with
 * MR_CRC if a digest differs. *found is false if `store` is not a bundle or has no image. */
enum mr_status store_bundle_extract(struct store *store, int64_t run, const char *path, bool *found,
                                    struct error *error);

/* Reads the number of errors of each kind (enum link_fault) that a link detected during a
 * landing. */
enum mr_status store_link_errors_get(struct store *store, int64_t run, int link,
                                     struct store_link_error **rows, size_t *count,
                                     struct error *error);
/* Returns the `kind` of the events that report errors of a link. In such an event, `code` is the
 * error, `detail` the number of errors since the previous event, `value` the number since the
 * session began. */
const char *store_link_error_event_kind(int link);
/* Adds a row about lost data. `message` is the name of the lost message, or "frame" if the name is
 * unknown. */
enum mr_status store_gap_put(struct store *store, int64_t session, int64_t run,
                             const struct store_gap *gap, struct error *error);

/* One channel of a comparison of a landing with a simulation. Value i of the series is the
 * simulated displacement at time t0_s + i * dt_s after touchdown, on the clock of the
 * measurement. */
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
/* Fields common to all channels of a comparison. A missing field is NaN, STORE_NONE or NULL. */
struct store_simulation_summary {
    double run_ms;   /* computing time of the simulation */
    double error_in; /* error estimate of the solver */
    int64_t seeds;   /* number of simulated runways */
    double segments_dt_s;
    /* remaining opening of each segment, MR_SEGMENTS values per row; a read allocates them */
    float *segments_in;
    size_t segment_rows;
    char file[120]; /* file of the scene or campaign that was simulated */
};
enum mr_status store_simulation_put(struct store *store, int64_t run, const char *scene_json,
                                    int64_t made_us, const struct store_simulation_summary *head,
                                    const struct store_simulation *rows, size_t count,
                                    struct error *error);
/* Reads the newest comparison of a landing. *count is 0 if there is none. Free the rows with
 * store_simulations_free. */
enum mr_status store_simulations_get(struct store *store, int64_t run,
                                     struct store_simulation **rows, size_t *count,
                                     struct error *error);
/* Reads the common fields of the newest comparison. The caller frees segments_in. */
enum mr_status store_simulation_summary_get(struct store *store, int64_t run,
                                            struct store_simulation_summary *head,
                                            struct error *error);
void store_simulations_free(struct store_simulation *rows, size_t count);

/* Assigns CAN frames to a landing that the serial link has reported. Needed if one link is read
 * after the other. The first frame assigned is the first one after row `mark` that reports the same
 * first landing state as serial. The last one is row `last` or, if `last` is STORE_NONE, the frame
 * with the landing's last state. */
enum mr_status store_frames_assign(struct store *store, int64_t session, int64_t run, int64_t mark,
                                   int64_t last, struct error *error);

/* A shunt calibration does not belong to a landing. It is identified by session, boot and block. */
enum mr_status store_shunt_put(struct store *store, int64_t session, int64_t boot,
                               const struct store_shunt *shunt, struct error *error);
/* store_shunts_before_get reads the last calibration before `block`, store_shunts_after_get the
 * first one at or after `block`: one row per gage. *count is 0 if there is none. */
enum mr_status store_shunts_before_get(struct store *store, int64_t session, int64_t boot,
                                       int64_t block, struct store_shunt **rows, size_t *count,
                                       struct error *error);
enum mr_status store_shunts_after_get(struct store *store, int64_t session, int64_t boot,
                                      int64_t block, struct store_shunt **rows, size_t *count,
                                      struct error *error);

/* ---- the predictor: runway state and parameters when the landing was armed ---- */

/* Reads the plan and the chart of a landing. *lamp_limit is NaN if there is none. *items is the
 * number of stored items; 0 if the board sent none. */
enum mr_status store_risk_plan_get(struct store *store, int64_t run, struct mr_risk_plan *plan,
                                   float *lamp_limit, size_t *items, struct error *error);

/* Stores or reads the runway state of a landing; only complete states are stored. *found is false
 * if the landing has none. */
enum mr_status store_runway_put(struct store *store, int64_t run,
                                const struct mr_predictor_state *state, int64_t source,
                                struct error *error);
enum mr_status store_runway_get(struct store *store, int64_t run, struct mr_predictor_state *state,
                                int64_t *source, bool *found, struct error *error);
/* Reads the parameters of the predictor of a landing. *items is the number of stored items; the
 * parameters are complete if it is MR_PREDICT_ITEM_COUNT. */
enum mr_status store_predict_config_get(struct store *store, int64_t run,
                                        struct mr_predictor_config *config, size_t *items,
                                        struct error *error);

/* ---- imported files, and readings of other instruments ----
 *
 * A session of matrig import is stored like a session of matrig log. In addition it has a row in
 * `imports` with the name of the file. */

/* Reads the import of a session, except the mapping. *found is false if the session was logged. */
enum mr_status store_import_get(struct store *store, int64_t session, struct store_import *import,
                                bool *found, struct error *error);
/* Finds the session that imported a file completely, with the same SHA-256, mapping (NULL: none),
 * bus and CAN base. *session is 0 if there is none. */
enum mr_status store_import_find(struct store *store, const struct store_import *import,
                                 uint16_t can_base, int64_t *session, struct error *error);

/* Imported readings of one channel, in the unit of the channel. Blocks are 1 ms long. */
struct store_imported_channel {
    int64_t index; /* index of the channel */
    int64_t first_block;
    int64_t stride; /* number of blocks from one sample of the instrument to the next */
    size_t count;
    float *reading; /* readings; NaN: missing. A read allocates the array */
};
enum mr_status store_imported_channel_put(struct store *store, int64_t run,
                                          const struct store_imported_channel *readings,
                                          struct error *error);
/* Reads all imported channels of a landing. Free them with store_imported_channels_free. Skips a
 * row whose size is not a whole number of floats. */
enum mr_status store_imported_channels_get(struct store *store, int64_t run,
                                           struct store_imported_channel **rows, size_t *count,
                                           struct error *error);
void store_imported_channels_free(struct store_imported_channel *rows, size_t count);

/* ---- following a campaign while another process writes it: reading new data in the order of
 * reception ---- */

/* Position in a campaign up to which its data has been read. */
struct store_follow_position {
    int64_t newest_frame_id;      /* id of the newest frame read */
    int64_t session, boot, index; /* position of the newest block read */
};

/* Sets the position to `frames` frames before the newest one, or to the beginning if there are
 * fewer. */
enum mr_status store_follow_begin(struct store *store, int64_t frames,
                                  struct store_follow_position *position, struct error *error);

/* Functions to which store_follow passes frames and block records. */
struct store_follower {
    void (*frame)(void *context, const struct store_frame *frame);
    void (*record)(void *context, const uint8_t *record, size_t length, int64_t host_us);
    void *context;
};
/* Reads up to `frames_max` frames after the position, and the blocks received before the last of
 * these frames. Passes frames of the board and blocks to the follower, and advances the position.
 * *more is true if there is more data. */
enum mr_status store_follow(struct store *store, struct store_follow_position *position,
                            int64_t frames_max, const struct store_follower *follower, bool *more,
                            struct error *error);

/* ---- functions for matrig log, which must not lose data: it retries a failed transaction, and
 * continues in another file if the campaign's file was removed ---- */

/* Why the last write failed. A later attempt may succeed unless the reason is STORE_NO_RETRY. */
enum store_refusal {
    STORE_NO_RETRY, /* there was no failed write, or a retry cannot succeed */
    STORE_LOCKED,   /* another program is writing */
    STORE_DISK_FULL,
    STORE_DISK_ERROR, /* the disk or the file system reported an error */
    /* the file has reached its size limit; only another file can take more data */
    STORE_SIZE_LIMIT,
};

/* Sets how long each call waits while another program writes; default 30 s. */
void store_set_wait_ms(struct store *store, int wait_ms);
/* Returns the reason of the last failed call, and resets it. */
enum store_refusal store_refusal_pop(struct store *store);
/* Writes the journal back into the file. Used when the journal cannot grow because the disk is
 * full. Returns true if the transaction may succeed now. Call it between transactions. */
bool store_checkpoint(struct store *store);
void store_roll_back(struct store *store);

/* State of the file at a path, compared with the file that the store has open. */
enum store_file_state {
    STORE_FILE_UNCHANGED, /* the file that the store has open */
    STORE_FILE_MISSING,   /* no file at the path */
    STORE_FILE_REPLACED,  /* a different file is at the path */
    STORE_FILE_NO_JOURNAL,
    /* the journal's index file is missing, so other programs do not see new data */
    STORE_FILE_NO_INDEX,
    STORE_FILE_OVERWRITTEN, /* the file was overwritten: store_is_overwritten */
    STORE_FILE_EMPTIED,     /* the data of the session is missing: store_has_session_data */
};
/* Device and inode numbers of a campaign's files; 0: there is no such file. */
struct store_file_identity {
    dev_t file_device, journal_device;
    ino_t file_inode, journal_inode, index_inode;
};
/* Gets the identity of the file at the path. Call it directly after store_open. */
void store_file_identity_get(const char *path, struct store_file_identity *identity);
enum store_file_state store_check_file_identity(const char *path,
                                                const struct store_file_identity *identity);

/* Copies all committed data into a new file at `path`, and opens the copy to check it. Also works
 * if the open file was moved or deleted. Fails with MR_IO if `path` exists. */
enum mr_status store_copy_to(struct store *store, const char *path, struct error *error);
/* Asks the kernel for the current path of the open file; "" if the file was deleted or the path is
 * unknown. */
void store_find_current_path(const struct store *store, char *out, size_t size);
/* Closes the store as store_close does, if its file was moved, deleted or replaced. A new file at
 * the old path is not changed. If `moved`, writes the journal back into the open file first. */
void store_close_detached(struct store *store, bool moved);
/* Removes the journal at the file's old path, because SQLite would write it into a new file at that
 * path. The journal of another file is not removed. Call it after store_close_detached. */
void store_journal_remove(const char *path, const struct store_file_identity *identity);

/* ---- detection of a file that was overwritten ---- */

/* Starts checking whether another program overwrites the file. From then on, SQLite does not write
 * to an overwritten file. */
void store_watch_file(struct store *store);
/* True if another program overwrote the file (for example cp) or truncated it, which is detected
 * from the file's header or size, or from damage that SQLite finds. Once true, the result stays
 * true. */
bool store_is_overwritten(struct store *store);
/* These two functions record the newest committed data of a session: call store_record_progress
 * before a commit and store_confirm_progress after it. */
enum mr_status store_record_progress(struct store *store, int64_t session, struct error *error);
void store_confirm_progress(struct store *store);
/* Checks whether the campaign still contains the session's newest committed data. Does nothing
 * unless another program has written since the last check. Call it in a transaction. */
enum mr_status store_has_session_data(struct store *store, bool *has, struct error *error);
/* Renames the journal of an overwritten file to `new_path`, because SQLite would write it into the
 * new file. Returns false if there is no journal or it cannot be renamed. Call it after
 * store_close_detached. */
bool store_journal_rename(const char *path, const char *new_path);

#endif
