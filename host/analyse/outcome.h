/* The record of a campaign: for each landing the stored advice, the warnings and risk reported by
 * the board, and the outcome; and the totals.
 *
 * A landing with an unknown outcome is never counted as a success. Voided landings are counted
 * separately. The record is not stored. It is computed from the campaign each time, so that
 * later surveys and corrections are included. */
#ifndef MATRIG_HOST_ANALYSE_OUTCOME_H
#define MATRIG_HOST_ANALYSE_OUTCOME_H

#include "common/closure.h"
#include "host/analyse/measured.h"
#include "host/analyse/zones.h"
#include "host/base/answer.h"
#include "host/store/store_journal.h"

/* The measured outcome of a landing: whether the wheel reached a zone of 50 closed mats before it
 * stopped. The predictor is not used: it is the source of warnings, so it must not decide whether
 * they were right.
 *
 * The outcome is based on the following evidence, in this order:
 * - A wave or a break that a person observed. A two-panel wave that the gear crosses is not a
 * failure (report 2.1).
 * - The survey before the landing and the transducers during it (zones.h): the longest closed run
 * ahead of the wheel that begins within OUTCOME_REACHED_DISTANCE_FT of the wheel and exists for
 * 0.1 s. Its length has the standard error ZONES_ERROR_MATS.
 * - The survey after the landing: a closed run of that length which begins at the stopped wheel.
 * This survey can only give "yes", because joints open again behind the wheel.
 *
 * The outcome is "no" if the stop is known, there is a survey since the previous landing, its
 * unread segments could not form a zone, and transducers cover at least half of the distance from
 * touchdown to 50 mats beyond the stop. Otherwise the outcome is unknown, and `reason` has the
 * reason. */

/* length of a zone at which buckling begins (report 6.1.4) */
#define OUTCOME_MIN_ZONE_MATS       50
/* distance (seven mats) at which a zone counts as reached, as in tests/score */
#define OUTCOME_REACHED_DISTANCE_FT 2.0

enum outcome_reached { OUTCOME_UNKNOWN, OUTCOME_REACHED, OUTCOME_NOT_REACHED };
enum outcome_basis {
    OUTCOME_NO_BASIS,
    OUTCOME_OBSERVATION,
    OUTCOME_TRANSDUCERS,
    OUTCOME_SURVEY_AFTER,
    OUTCOME_BASIS_COUNT
};

struct outcome {
    enum outcome_reached reached;
    enum outcome_basis basis;
    const char *unknown_reason; /* why the outcome is unknown; static storage */
    /* Longest zone that the wheel reached, by transducers and survey; STORE_NONE: not known. */
    int64_t longest_mats;
    double longest_start_ft; /* start of the longest zone */
    /* time at which the wheel reached a zone of 50 mats; NaN: it reached none, or the time is not
     * known */
    double reached_t_s;
    /* Range of reached_t_s that contains the true time in three of four simulated landings
     * (tests/score/outcome.c): it begins when the wheel reaches a zone that may be shorter by
     * ZONES_ERROR_MATS and farther away by a segment, and ends when the wheel is inside the zone.
     * NaN: it reached none. */
    double reached_earliest_s, reached_latest_s;
    double covered_share; /* share of the gear's path that lies between transducers */
    /* Length of the closed run at the wheel in the survey after the landing; STORE_NONE: no survey
     * was read. */
    int64_t closed_after_mats;
    /* numbers of waves and breaks that were observed and not withdrawn */
    size_t wave_count, break_count;
};

/* The longest zone that the wheel reached, and the time at which it first reached a zone of
 * OUTCOME_MIN_ZONE_MATS: best estimate, and earliest and latest time within the errors of the
 * zone. */
enum reached_zone_limit {
    REACHED_ZONE_EARLIEST,
    REACHED_ZONE_BEST,
    REACHED_ZONE_LATEST,
    REACHED_ZONE_LIMIT_COUNT
};
struct reached_zone {
    unsigned longest_mats;
    double longest_start_ft;                      /* NaN: the wheel reached no zone */
    double reached_t_s[REACHED_ZONE_LIMIT_COUNT]; /* NaN: it reached no such zone */
    double since_s
        /* time since which the wheel has been at such a zone; NaN: it is not at one now */
        [REACHED_ZONE_LIMIT_COUNT];
};
/* distance ahead of the wheel within which the zone of reached_zone_update must begin: the largest
 * that any of the limits allows */
#define REACHED_ZONE_DISTANCE_MAX_FT (OUTCOME_REACHED_DISTANCE_FT + (double)MR_SEGMENT_LENGTH_FT)
void reached_zone_init(struct reached_zone *reach);
/* Adds the longest zone that begins within REACHED_ZONE_DISTANCE_MAX_FT of the wheel at a time.
 * Call in order of time, at least every 0.05 s, while the wheel rolls. */
void reached_zone_update(struct reached_zone *reach, double t_s, double wheel_ft,
                         const struct mr_closure_zone *zone);

/* Returns the basis as text for tables, such as "transducers and survey". Static storage. */
const char *outcome_basis_text(enum outcome_basis basis);

/* A landing is off plan if its braking or speed differs from the plan by more than this share. The
 * advice does not apply to it. */
#define OUTCOME_OFF_PLAN_BRAKING_SHARE 0.25
#define OUTCOME_OFF_PLAN_SPEED_SHARE   0.10

enum warning_status {
    WARNING_NO_BOARD, /* the readings are from another instrument: no board could warn */
    WARNING_SENT,
    WARNING_NOT_SENT,
    WARNING_NOT_RECEIVED /* no warning was received, but the board may have sent one */
};
enum warning_outcome {
    WARNING_OUTCOME_UNKNOWN,
    WARNING_HIT,           /* warned before the wheel reached the zone */
    WARNING_LATE,          /* warned after the wheel reached the zone */
    WARNING_MISS,          /* no warning, but the wheel reached a zone */
    WARNING_FALSE_ALARM,   /* warning, but the wheel reached no zone */
    WARNING_TRUE_NEGATIVE, /* no warning, and the wheel reached no zone */
    WARNING_OUTCOME_COUNT
};
enum advice_level { ADVICE_CLEAR, ADVICE_CAUTION, ADVICE_AGAINST, ADVICE_LEVEL_COUNT };

struct outcome_record_row {
    int64_t run;
    bool is_evaluated; /* false: the fields after `advice` have not been computed yet */
    bool is_void;
    enum warning_status warning_status;
    /* time and start of the zone at the first warning, and position of the wheel; NaN: no
     * warning */
    double warned_t_s, warned_zone_start_ft, warned_wheel_ft;
    const char *time_origin; /* what warned_t_s is counted from, as text; static storage */
    /* time from the warning until the wheel reached a zone, negative if the warning was too late;
     * NaN: no warning, or no zone */
    double lead_time_s;
    /* lead time computed with outcome.reached_earliest_s and reached_latest_s */
    double lead_time_low_s, lead_time_high_s;
    double max_risk; /* largest risk reported during the landing; NaN: none */
    /* First landing that began on the same runway, if the runway was restored; STORE_NONE: none.
     * Only an emulated board can restore its runway, because its memory is a file. */
    int64_t first_run_on_runway;
    bool has_advice;
    /* newest advice before the landing, for the runway of the landing */
    struct store_advice advice;
    bool has_motion; /* the motion is known, so the next two fields are valid */
    bool is_off_plan;
    /* the advice was against the plan, and the landing braked no harder than the advice
     * recommended */
    bool followed_advice_against;
    struct outcome outcome;
    enum warning_outcome warning_outcome;
    const char *unknown_reason; /* reason for the outcome WARNING_OUTCOME_UNKNOWN; static storage */
};

struct outcome_record {
    struct outcome_record_row *row; /* rows in ascending order of RUN */
    size_t row_count;
    struct store_landing *landing; /* landing of each row */
    /* Totals over the landings that are not void. */
    size_t landing_count, void_count;
    size_t warning_outcome_count[WARNING_OUTCOME_COUNT];
    size_t advice_count[ADVICE_LEVEL_COUNT]
                       [3]; /* number of landings by advice and by enum outcome_reached */
    /* number of landings that differed from their plan or followed the advice against it; not
     * counted in `advice` */
    size_t off_plan_count;
};

/* A loaded landing, with its samples. */
struct outcome_record_landing {
    const struct measured_landing *measured;
    const struct zones *zones;
};

/* Makes one row per landing; the rows are not judged yet. Call outcome_record_free in every
 * case. */
enum mr_status outcome_record_begin(struct store *store, struct outcome_record *record,
                                    struct error *error);
/* Finds the row of a landing; NULL if there is none. */
struct outcome_record_row *outcome_record_find_row(struct outcome_record *record, int64_t run);
/* Judges a landing that the caller has loaded. */
enum mr_status outcome_record_evaluate(struct store *store, struct outcome_record *record,
                                       const struct outcome_record_landing *loaded,
                                       struct error *error);
/* Judges a loaded landing without the other rows of the record. */
enum mr_status outcome_record_evaluate_one(struct store *store,
                                           const struct outcome_record_landing *loaded,
                                           struct outcome_record_row *row, struct error *error);
/* Loads and judges the rows that are not judged yet, and computes the totals. */
enum mr_status outcome_record_end(struct store *store, struct outcome_record *record,
                                  struct error *error);
/* outcome_record_begin and outcome_record_end in one call. */
enum mr_status outcome_record_load(struct store *store, struct outcome_record *record,
                                   struct error *error);
void outcome_record_free(struct outcome_record *record);

const char *warning_outcome_text(enum warning_outcome verdict);
/* Writes the lead time with its interval: "1.6 s (75 % interval: 1.2 to 1.9 s)"; in a table "1.6
 * (1.2 to 1.9)"; "-" if there is none. */
#define OUTCOME_LEAD_TIME_SIZE 80
const char *outcome_record_format_lead_time(const struct outcome_record_row *row, bool in_table,
                                            char out[OUTCOME_LEAD_TIME_SIZE]);
/* Writes the outcome with its lead time, in the form used in all output: "hit, lead time about 1.6
 * s (75 % interval: 1.2 to 1.9 s)". */
#define OUTCOME_TEXT_SIZE 400
const char *outcome_record_format_outcome(const struct outcome_record_row *row,
                                          char out[OUTCOME_TEXT_SIZE]);
/* Writes the evidence for the outcome: when the board warned, and what the wheel reached. */
const char *outcome_record_format_evidence(const struct outcome_record_row *row,
                                           char out[OUTCOME_TEXT_SIZE]);
/* Writes outcome and evidence: "hit, lead time about 1.6 s (...): the board warned 0.434 s after
 * ...". */
#define OUTCOME_LINE_SIZE (2 * OUTCOME_TEXT_SIZE)
const char *outcome_record_format_line(const struct outcome_record_row *row,
                                       char out[OUTCOME_LINE_SIZE]);
/* Adds the line of outcome_record_format_line as text for people, and the JSON object "outcome"
 * with the same facts. */
void outcome_record_add_outcome(const struct outcome_record_row *row, struct answer *answer);
/* True if the outcome depends on the resolution: the difference between OUTCOME_MIN_ZONE_MATS and
 * the longest zone that the wheel reached is within the resolution. */
bool outcome_record_is_marginal(const struct outcome_record_row *row);
/* Writes the advice before a landing and whether it was followed: "against, followed"; "none". */
#define OUTCOME_ADVICE_SIZE 48
const char *outcome_record_format_advice(const struct outcome_record_row *row,
                                         char out[OUTCOME_ADVICE_SIZE]);
/* Adds the totals as JSON. Text output has one line with `brief` (for `matrig show`), otherwise all
 * totals. */
void outcome_record_to_answer(const struct outcome_record *record, bool brief,
                              struct answer *answer);

#endif
