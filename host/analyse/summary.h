/* Summary of a landing: printed by `matrig log` at the end of a landing and by `matrig report` at
 * the head of its page. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_H
#define MATRIG_HOST_ANALYSE_SUMMARY_H

#include <jansson.h>
#include <stdio.h>

#include "common/quantity.h"
#include "host/analyse/braking.h"
#include "host/analyse/bands.h"
#include "host/analyse/outcome.h"
#include "host/analyse/track.h"
#include "host/analyse/zones.h"
#include "host/analyse/measured.h"
#include "host/base/answer.h"
#include "host/link/link.h"
#include "host/store/store.h"

/* Result of `matrig ready` before a landing: the newest check and the newest walk test of its
 * board, if within 12 h before arming. */

#define SUMMARY_READY_CHECK_COUNT 2

struct summary_ready_check {
    bool is_known;
    bool is_go;
    double minutes_before_arming; /* age of the result when the board was armed */
    char failed_checks[400];      /* "switch 12: did not answer; ..." */
};

/* Half width of a 95 % interval in standard errors. The errors of switch positions are assumed to
 * be normal with known standard deviation. */
#define SUMMARY_HALF_WIDTH_95 1.959964

struct summary_link {
    bool is_used;
    int64_t received_frames; /* frames received during the landing */
    int64_t lost_frames;     /* frames sent by the board and not received */
    int64_t dropped_frames;  /* frames that the board reports as dropped from its queue */
    int64_t error_count[LINK_FAULT_COUNT]; /* errors that the link itself counted */
    /* the link was silent from the start or became silent during the landing, so its losses cannot
     * be counted */
    bool was_silent;
};

struct summary {
    struct measured_landing measured;
    struct zones zones;
    struct predictor_inputs predictor_inputs;
    struct bands_summary bands;
    struct summary_link link[LINK_KINDS];
    struct store_session_row session;
    bool is_imported; /* the session was an import, described by `import` */
    struct store_import import;
    struct store_gap *gap;
    size_t gap_count;
    struct film film;
    struct braking braking;
    /* best clock among the links; `refusal` shows whether it can be used */
    struct store_time_map clock;
    bool is_clock_known;
    struct store_fault *fault;
    size_t fault_count;
    struct store_fault *switch_event; /* switch faults that the board reported */
    size_t switch_event_count;
    /* channel faults that the board reported, in order of time */
    struct store_fault *channel_event;
    size_t channel_event_count;
    struct store_fault *restart; /* restarts of the board during the landing */
    size_t restart_count;
    /* commands from another program (count 0), and refused commands of matrig log (count 1) */
    struct store_fault *command;
    size_t command_count;
    struct store_fault *key_state; /* states of the board key; code: enum mr_key_state */
    size_t key_state_count;        /* number of states; 0: not reported */
    /* means over the landing of the quantities that the board sends repeatedly */
    struct store_mean mean[MR_QUANTITY_COUNT];
    struct summary_ready_check ready_check[SUMMARY_READY_CHECK_COUNT];
    int64_t duplicate_run; /* earlier RUN of the same landing; 0: none */
    /* outcome of the landing; is_evaluated: it was loaded by summary_load_outcome */
    struct outcome_record_row outcome;
};

enum mr_status summary_load(struct store *store, int64_t run, struct summary *summary,
                            struct error *error);
/* Loads the outcome of a loaded landing. The report does not need this, because it loads the whole
 * record. */
enum mr_status summary_load_outcome(struct store *store, struct summary *summary,
                                    struct error *error);
void summary_free(struct summary *summary); /* may also be called after an error */

/* Writes the heading: "RUN 5: landing 5, done". */
#define SUMMARY_HEADING_SIZE 140
void summary_format_heading(const struct summary *summary, char out[SUMMARY_HEADING_SIZE]);
/* Adds "uncalibrated" to the JSON: true, false, or null if the configuration was not read. */
void summary_add_calibration(const struct measured_landing *measured, struct answer *answer);
/* Adds the whole summary under its heading, with the outcome if it is loaded. The functions below
 * add single parts, for the sections of a page. */
void summary_to_answer(const struct summary *summary, struct answer *answer);
/* Adds the facts that make the landing doubtful: incomplete, recorded twice, restarted, commands
 * received, or not ready. */
void summary_add_alerts(const struct summary *summary, struct answer *answer);
/* Adds alerts, motion, events, sources of the data, and the board. */
void summary_add_facts(const struct summary *summary, struct answer *answer);
void summary_add_zone(const struct summary *summary, struct answer *answer);
/* Adds clock, film, links, gaps and faults. */
void summary_add_health(const struct summary *summary, struct answer *answer);
/* Adds the channels of one kind as a table. */
void summary_add_channels(const struct measured_landing *measured, enum mr_channel_kind kind,
                          const char *label, struct answer *answer);

/* Returns the content of summary_to_answer as JSON. The caller owns the object. */
json_t *summary_to_json(const struct summary *summary, bool si);
const char *summary_link_name(int link);
/* Writes the state of the switches: "all 24 seen" or "22 of 24 seen, missing 3, 17". */
void summary_format_switches(const struct measured_landing *measured, char *out, size_t size);
/* Writes LINK_FAULT_COUNT counts: "bus off 1, no acknowledgement 12"; "" if all are 0. */
void summary_format_link_errors(const int64_t *trouble, char *out, size_t size);
/* Returns LINK_FAULT_COUNT counts as a JSON object: {"bus off": 1, ...}. The caller owns the
 * object. */
json_t *summary_link_errors_to_json(const int64_t *trouble);

/* Sums the gaps of each link: lost frames, dropped frames, silence. */
void summary_count_gaps(const struct store_gap *gaps, size_t count,
                        struct summary_link link[LINK_KINDS]);

/* Host time of a board time: Unix microseconds, and half the 95 % interval. NaN: not known. */
struct summary_moment {
    double host_us;
    double half_width_us;
};
struct summary_moment summary_convert_to_time_of_day(const struct summary *summary,
                                                     double board_us);
/* Loads the best clock of a landing's links, as in summary->clock. `*known` is false if no link has
 * a clock. summary_convert_to_host_time converts a board time with this clock. */
enum mr_status summary_load_clock(struct store *store, int64_t run, struct store_time_map *clock,
                                  bool *known, struct error *error);
struct summary_moment summary_convert_to_host_time(const struct store_time_map *clock,
                                                   double board_us);

void summary_add_times(const struct summary *summary, struct answer *answer);

#endif
