/* Zones of a landing: the board's warnings, their times, and whether the wheel reached the zones;
 * also the closed segments over time, which the host computes from displacements and survey
 * (common/closure.h). */
#ifndef MATRIG_HOST_ANALYSE_ZONES_H
#define MATRIG_HOST_ANALYSE_ZONES_H

#include "common/block.h"
#include "host/analyse/measured.h"
#include "host/base/answer.h"

/* Completeness of the recorded zone messages. The board sends them 20 times a second from arming
 * until the end of the landing; a warning may have been sent during a longer gap. */

/* The times of this struct are t_s of the landing. */
struct zones_completeness {
    bool has_messages; /* at least one zone message was received */
    /* the first message was received late, because the record begins after arming */
    bool is_first_message_late;
    bool has_end;
    double first_s, last_s;
    double pause_from_s, pause_to_s; /* longest pause between two zone messages; NaN: none */
    const char *origin;              /* origin of t_s as text */
};

#define ZONES_REASON_SIZE 300
/* Writes the reason why a warning before `before_s` may have been missed (INFINITY: any warning).
 * Returns false if there is no such reason. */
bool zones_format_missed_warning_reason(const struct zones_completeness *received, double before_s,
                                        char out[ZONES_REASON_SIZE]);

struct zone_warning {
    bool has_warning;
    /* The next fields describe the first warning. Its time, by the board's clock, is the start of
     * the block that led to it, which is also the time stamp of the frame. The board switches on
     * the lamp and sends the frame when the block is complete, 1 ms later. summary.h has the time
     * at which the frame was received. */
    int64_t block;
    /* Time since touchdown, as shown by log and report and in series. The live page, which has no
     * fit yet, shows the block instead. */
    double t_s;
    int64_t mats;
    double start_ft, end_ft;
    double wheel_ft; /* position of the wheel; NaN: not known yet */
    int64_t inferred_percent;
    /* From the predictor, at the time of the first warning. STORE_NONE, NaN: not sent, for example
     * by an older board. */
    int64_t reason, level;
    double start_error_ft, end_error_ft; /* standard errors */
    int64_t predicted_mats;              /* length of the longest zone that the predictor expects */
    /* station of the wheel at which the predictor expects that zone */
    double predicted_wheel_ft;
    /* time from the warning until the wheel reached predicted_wheel_ft; NaN: it stopped before */
    double predicted_wheel_delay_s;
    /* Zone of the warning: the longest run of closed mats reported during the warning. */
    int64_t longest_mats;
    double longest_start_ft, longest_end_ft;
    bool is_path_known; /* the path of the wheel is known up to the stop */
    /* The first time to the zone that the board predicted during a warning, and the actual time. */
    double predicted_lead_s; /* predicted time to the zone; NaN: never sent */
    /* standard error, from that of the zone's start; NaN: not known */
    double predicted_lead_error_s;
    int64_t predicted_lead_block;
    double predicted_lead_made_t_s;
    double predicted_lead_start_ft; /* start of the zone in the message with predicted_lead_s */
    /* actual time until the wheel reached predicted_lead_start_ft; NaN: it stopped before, or the
     * time is not known */
    double actual_lead_s;
};

struct zones {
    struct store_zone *row;
    size_t count;
    struct zone_warning warning;
    struct zones_completeness received;
};

enum mr_status zones_load(struct store *store, const struct measured_landing *measured,
                          struct zones *zones, struct error *error);
void zones_free(struct zones *zones);
/* Adds the first warning. `has_board`: a board was connected that could have
 * warned. */
void zones_to_answer(const struct zones *zones, bool has_board, struct answer *answer);
/* Adds whether and when the board warned, only as text. */
void zones_add_warning_status(const struct zones *zones, bool has_board, struct answer *answer);
/* Writes the reason why a warning before the first recorded one may have been missed. Returns false
 * if there is no reason, or no warning. */
bool zones_format_earlier_warning_reason(const struct zones *zones, char out[ZONES_REASON_SIZE]);
double zones_time_s(const struct measured_landing *measured, const struct store_zone *zone);
/* Finds the message of the predictor for a block, which has the errors of the zone reported for
 * that block. NULL: there is none. */
const struct store_prediction *zones_find_prediction(const struct store_prediction *row,
                                                     size_t count, int64_t block);

/* Slack of each segment according to the survey, inches; NaN: not surveyed. */
struct zones_slack {
    float slack_in[MR_SEGMENTS];
    size_t surveyed_segment_count; /* number of segments with a slack */
};
enum mr_status zones_load_survey(struct store *store, int64_t run, struct zones_slack *slack,
                                 struct error *error);

/* A segment counts as closed if its remaining slack is below this limit, in inches: nine joints
 * closed to 0.001 in each, the survey's error of 0.005 in, and 0.016 in of open joints. The board's
 * limit (common/closure.h) is twice as large, because a board must not miss a zone. If zones are
 * measured with the board's limit, their lengths are too large by 16 mats (median;
 * tests/score/outcome.c). */
#define ZONES_CLOSED_SEGMENT_MAX_IN 0.03f
/* Standard error of the length of a measured zone, and of an end that is not at the wheel, in mats:
 * 68 % of the errors are smaller, 90 % are below 30 mats (tests/score/outcome.c). */
#define ZONES_ERROR_MATS            10

/* Finds the longest run of closed segments that ends ahead of the wheel and begins at most
 * `within_ft` ahead of it (INFINITY: anywhere); of equally long runs, the nearest. A run that
 * contains the wheel begins at the wheel. A run may end inside a segment that closed only partly:
 * movement closes joints from the upfield end, so the fraction of its joints that are closed equals
 * the fraction of its slack that is used up. `slack_in` is the slack before the movement, and
 * `remaining_in` the slack that is left (MR_SEGMENTS values each; NaN: not known). */
void zones_find_longest_zone(const float *slack_in, const float *remaining_in, double wheel_ft,
                             double within_ft, struct mr_closure_zone *zone);
/* Computes the remaining slack of each segment at a sample of the landing; NaN: not surveyed. */
void zones_compute_remaining_slack(const struct measured_landing *measured,
                                   const struct zones_slack *slack, size_t sample,
                                   float remaining_in[MR_SEGMENTS]);

/* Inputs of the board's predictor in a landing: the runway with which it began, and inputs that
 * were missing. */

enum predictor_condition {
    PREDICTOR_WITHOUT_TRANSDUCERS,
    PREDICTOR_WITHOUT_MOTION,
    PREDICTOR_COARSE_MODEL,
    PREDICTOR_RESTARTED,
    PREDICTOR_CONDITION_COUNT
};

/* Seconds since touchdown; NaN: the condition never occurred. */
struct predictor_span {
    double from_s, to_s;
};

struct predictor_inputs {
    /* number of predictor messages; 0: the board has no predictor, or sent none */
    size_t message_count;
    int64_t runway_source;     /* enum mr_runway_source; STORE_NONE: not reported */
    unsigned history_landings; /* number of landings in the history of the board's runway */
    /* joint resistance, relative to the configured one; NaN: not reported */
    double resistance_ratio;
    struct predictor_span condition_span[PREDICTOR_CONDITION_COUNT];
    int64_t worst_level; /* simplest model that the predictor had to use */
    /* reason for which a transducer was last excluded; 0: it was never excluded */
    unsigned exclusion_reason[MR_TRANSDUCERS];
    /* time during which a transducer was excluded; reported once a second and on change */
    struct predictor_span excluded_span[MR_TRANSDUCERS];
    /* the transducer was still excluded in the last report */
    bool is_still_excluded[MR_TRANSDUCERS];
    double max_risk, max_risk_s; /* largest risk and its time; NaN: no risk was reported */
    unsigned risk_basis;         /* bit mask of the data on which the largest risk was based */
    double off_plan_s;           /* time from which the landing was off plan; NaN: never */
    bool is_chart_outdated;
};

enum mr_status predictor_inputs_load(struct store *store, const struct measured_landing *measured,
                                     struct predictor_inputs *inputs, struct error *error);
/* Adds one line per fact of `predictor_inputs`. */
void predictor_inputs_to_answer(const struct predictor_inputs *inputs,
                                const struct measured_landing *measured, struct answer *answer);

#endif
