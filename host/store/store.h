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

#include "common/catalogue.h"
#include "common/channels.h"
#include "common/closure.h"
#include "common/quantity.h"
#include "host/base/error.h"
#include "host/store/rows.h"

#define STORE_VERSION      1          /* of the tables: PRAGMA user_version */
#define STORE_APPLICATION  0x4d545247 /* "MTRG": PRAGMA application_id */
#define STORE_SWITCHES_MAX 64u

enum store_mode {
    STORE_OPEN,   /* must exist */
    STORE_CREATE, /* is made when it does not exist */
    STORE_READ,   /* must exist, nothing is written */
};

struct store;

/* MR_IO: cannot be opened; MR_MALFORMED: no campaign database; MR_VERSION: another version's. */
enum mr_status store_open(const char *path, enum store_mode mode, struct store **store,
                          struct error *error);
/* For the one that logs: nobody else does, into the same campaign, until it is closed. Notes,
 * surveys and reports go on beside it. MR_IO: another one does. */
enum mr_status store_take_alone(struct store *store, struct error *error);
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
enum mr_status store_landings(struct store *store, struct store_landing **rows, size_t *count,
                              struct error *error);

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
enum mr_status store_calibration_put(struct store *store, int64_t run, int64_t index, int64_t item,
                                     double value, struct error *error);
/* What the board last said a channel is worth. */
enum mr_status store_quality_put(struct store *store, int64_t run,
                                 const struct store_quality *quality, struct error *error);
enum mr_status store_switch_put(struct store *store, int64_t run, const struct store_switch *place,
                                struct error *error);
enum mr_status store_segment_put(struct store *store, int64_t run,
                                 const struct store_segment *segment, struct error *error);
/* `channels` has MR_CHANNELS places; those not reported have kind MR_KIND_NONE. `*found`: how many
 * were reported. Calibration included. */
enum mr_status store_channels(struct store *store, int64_t run, struct mr_channel_config *channels,
                              size_t *found, struct error *error);
enum mr_status store_switches(struct store *store, int64_t run, struct store_switch **rows,
                              size_t *count, struct error *error);
enum mr_status store_segments(struct store *store, int64_t run, struct store_segment **rows,
                              size_t *count, struct error *error);

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
enum mr_status store_blocks_count(struct store *store, int64_t run, int64_t *count,
                                  struct error *error);
/* A landing's first block, and its first one from `from` to `to`; -1: none. */
enum mr_status store_block_first(struct store *store, int64_t run, int64_t *index,
                                 struct error *error);
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

/* What the board said, once, whichever link it came by; `links` has bit 1 << enum link_kind set for
 * each that brought it. */
/* Mat temperature: a second of a landing. */
enum mr_status store_mat_temperature_put(struct store *store, int64_t run,
                                         const struct store_mat_temperature *row,
                                         struct error *error);
/* A quantity over a landing; told 0: the campaign keeps no column of it. */
enum mr_status store_mean_get(struct store *store, int64_t run, enum mr_quantity quantity,
                              struct store_mean *mean, struct error *error);
/* A row that is there already gets its time when it had none, no more. */
enum mr_status store_slow_put(struct store *store, const struct store_slow *row,
                              struct error *error);
/* Rows of a board, or of all (NULL), in order. */
enum mr_status store_slow_rows(struct store *store, const char *board_uid, struct store_slow **rows,
                               size_t *count, struct error *error);

enum mr_status store_edge_put(struct store *store, int64_t run, const struct store_edge *edge,
                              struct error *error);
/* The board found that an edge it told of is no gate of the landing: its row loses its switch; the
 * event keeps it. */
enum mr_status store_edge_refuse(struct store *store, int64_t run, int64_t count,
                                 struct error *error);
enum mr_status store_event_put(struct store *store, const struct store_event *event,
                               struct error *error);
enum mr_status store_motion_put(struct store *store, int64_t run, const struct store_motion *motion,
                                struct error *error);
enum mr_status store_zone_put(struct store *store, int64_t run, const struct store_zone *zone,
                              struct error *error);
/* Fields that are NaN or STORE_NONE leave what is there. */
enum mr_status store_result_put(struct store *store, int64_t run, const struct store_result *result,
                                struct error *error);
enum mr_status store_edges(struct store *store, int64_t run, struct store_edge **rows,
                           size_t *count, struct error *error);
enum mr_status store_motions(struct store *store, int64_t run, struct store_motion **rows,
                             size_t *count, struct error *error);
enum mr_status store_zones(struct store *store, int64_t run, struct store_zone **rows,
                           size_t *count, struct error *error);
enum mr_status store_result_get(struct store *store, int64_t run, struct store_result *result,
                                bool *found, struct error *error);
/* Faults of the landing's board and session up to the landing's end: the newest row of each
 * fault. */
enum mr_status store_faults(struct store *store, const struct store_landing *landing,
                            struct store_fault **rows, size_t *count, struct error *error);

/* What the board found wrong with switches in the landing: code is the reason (common/switches.h),
 * detail the switch, 0 when not known, count how many times. */
enum mr_status store_switch_events(struct store *store, int64_t run, struct store_fault **rows,
                                   size_t *count, struct error *error);

/* What the board found of channels in the landing, in order of time: code is the validity
 * (common/channels.h), detail the channel, board_us since when. */
enum mr_status store_channel_events(struct store *store, int64_t run, struct store_fault **rows,
                                    size_t *count, struct error *error);

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
enum mr_status store_gaps(struct store *store, int64_t run, struct store_gap **rows, size_t *count,
                          struct error *error);

/* The board's clock against this computer's, by one link: of a landing, or of all that was heard of
 * the board until it began again or the session ended (run STORE_NONE). host/link/timemap.h says
 * how it comes about. */
enum mr_status store_time_map_put(struct store *store, const struct store_time_map *map,
                                  struct error *error);
enum mr_status store_time_maps(struct store *store, int64_t run, struct store_time_map **rows,
                               size_t *count, struct error *error);

/* A frame pulse of the film camera. */
enum mr_status store_film_frame_put(struct store *store, int64_t run,
                                    const struct store_film_frame *frame, struct error *error);
enum mr_status store_film_frames(struct store *store, int64_t run, struct store_film_frame **rows,
                                 size_t *count, struct error *error);

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
 * landing's that came from the state that serial said first of it to the one that it said last, if
 * it said the end (`ended`). */
enum mr_status store_frames_place(struct store *store, int64_t session, int64_t run, int64_t mark,
                                  bool ended, struct error *error);

/* ---- bands: figures and findings of each landing as the board told them, shunt calibrations ----
 *
 * A shunt calibration belongs to no landing: it is before one and after another. */

/* Completes what is there: NaN and STORE_NONE leave a value as it is. */
enum mr_status store_band_put(struct store *store, int64_t run, const struct store_band *band,
                              struct error *error);
enum mr_status store_bands(struct store *store, int64_t run, struct store_band **rows,
                           size_t *count, struct error *error);
enum mr_status store_band_event_put(struct store *store, int64_t run,
                                    const struct store_band_event *event, struct error *error);
enum mr_status store_band_events(struct store *store, int64_t run, struct store_band_event **rows,
                                 size_t *count, struct error *error);
enum mr_status store_shunt_put(struct store *store, int64_t session, int64_t boot,
                               const struct store_shunt *shunt, struct error *error);
/* The last calibration before `block` of a session's boot, and the first from there on; none:
 * *count 0. */
enum mr_status store_shunts_before(struct store *store, int64_t session, int64_t boot,
                                   int64_t block, struct store_shunt **rows, size_t *count,
                                   struct error *error);
enum mr_status store_shunts_after(struct store *store, int64_t session, int64_t boot, int64_t block,
                                  struct store_shunt **rows, size_t *count, struct error *error);

#endif
