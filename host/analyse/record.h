/* The record of a campaign: for each landing the stored advice, the warnings and risk reported by
 * the board, and the outcome; and the totals.
 *
 * A landing with an unknown outcome is never counted as a success. Voided landings are counted
 * separately. The record is not stored. It is computed from the campaign each time, so that
 * later surveys and corrections are included. */
#ifndef MATRIG_HOST_ANALYSE_RECORD_H
#define MATRIG_HOST_ANALYSE_RECORD_H

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
    OUTCOME_BASES
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
enum record_reach_limit {
    RECORD_REACH_EARLIEST,
    RECORD_REACH_BEST,
    RECORD_REACH_LATEST,
    RECORD_REACH_LIMITS
};
struct record_reach {
    unsigned longest_mats;
    double longest_start_ft;                 /* NaN: the wheel reached no zone */
    double reached_t_s[RECORD_REACH_LIMITS]; /* NaN: it reached no such zone */
    double since_s
        /* time since which the wheel has been at such a zone; NaN: it is not at one now */
        [RECORD_REACH_LIMITS];
};
/* distance ahead of the wheel within which the zone of record_reach_add must begin: the largest
 * that any of the limits allows */
#define RECORD_REACH_WITHIN_FT (OUTCOME_REACHED_DISTANCE_FT + (double)MR_SEGMENT_LENGTH_FT)
void record_reach_init(struct record_reach *reach);
/* Adds the longest zone that begins within RECORD_REACH_WITHIN_FT of the wheel at a time. Call in
 * order of time, at least every 0.05 s, while the wheel rolls. */
void record_reach_add(struct record_reach *reach, double t_s, double wheel_ft,
                      const struct mr_closure_zone *zone);

/* Returns the basis as text for tables, such as "transducers and survey". Static storage. */
const char *outcome_basis_text(enum outcome_basis basis);

/* A landing is off plan if its braking or speed differs from the plan by more than this share. The
 * advice does not apply to it. */
#define RECORD_OFF_PLAN_BRAKING_SHARE 0.25
#define RECORD_OFF_PLAN_SPEED_SHARE   0.10

enum record_warned {
    RECORD_NO_BOARD, /* the readings are from another instrument: no board could warn */
    RECORD_WARNED,
    RECORD_NO_WARNING,
    RECORD_NOT_RECEIVED /* no warning was received, but the board may have sent one */
};
enum record_verdict {
    RECORD_NOT_KNOWN,
    RECORD_HIT,           /* warned before the wheel reached the zone */
    RECORD_LATE,          /* warned after the wheel reached the zone */
    RECORD_MISS,          /* no warning, but the wheel reached a zone */
    RECORD_FALSE_ALARM,   /* warning, but the wheel reached no zone */
    RECORD_TRUE_NEGATIVE, /* no warning, and the wheel reached no zone */
    RECORD_VERDICTS
};
enum record_advice { RECORD_CLEAR, RECORD_CAUTION, RECORD_AGAINST, RECORD_ADVICES };

struct record_row {
    int64_t run;
    bool is_judged; /* false: the fields after `advice` have not been computed yet */
    bool is_void;
    enum record_warned warned;
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
    int64_t same_runway_run;
    bool has_advice;
    /* newest advice before the landing, for the runway of the landing */
    struct store_advice advice;
    bool has_motion; /* the motion is known, so the next two fields are valid */
    bool is_off_plan;
    /* the advice was against the plan, and the landing braked no harder than the advice
     * recommended */
    bool followed_advice_against;
    struct outcome outcome;
    enum record_verdict verdict;
    const char *unknown_reason; /* reason for the outcome RECORD_NOT_KNOWN; static storage */
};

struct record {
    struct record_row *row; /* rows in ascending order of RUN */
    size_t row_count;
    struct store_landing *landing; /* landing of each row */
    /* Totals over the landings that are not void. */
    size_t landing_count, void_count;
    size_t verdict_count[RECORD_VERDICTS];
    size_t advice_count[RECORD_ADVICES]
                       [3]; /* number of landings by advice and by enum outcome_reached */
    /* number of landings that differed from their plan or followed the advice against it; not
     * counted in `advice` */
    size_t off_plan_count;
};

/* A loaded landing, with its samples. */
struct record_landing {
    const struct measured_landing *measured;
    const struct zones *zones;
};

/* Makes one row per landing; the rows are not judged yet. Call record_free in every case. */
enum mr_status record_begin(struct store *store, struct record *record, struct error *error);
/* Finds the row of a landing; NULL if there is none. */
struct record_row *record_find_row(struct record *record, int64_t run);
/* Judges a landing that the caller has loaded. */
enum mr_status record_judge(struct store *store, struct record *record,
                            const struct record_landing *loaded, struct error *error);
/* Judges a loaded landing without the other rows of the record. */
enum mr_status record_judge_one(struct store *store, const struct record_landing *loaded,
                                struct record_row *row, struct error *error);
/* Loads and judges the rows that are not judged yet, and computes the totals. */
enum mr_status record_end(struct store *store, struct record *record, struct error *error);
/* record_begin and record_end in one call. */
enum mr_status record_load(struct store *store, struct record *record, struct error *error);
void record_free(struct record *record);

const char *record_verdict_text(enum record_verdict verdict);
/* Writes the outcome with its lead time, in the form used in all output: "hit, lead time about 1.6
 * s (75 % interval: 1.2 to 1.9 s)". */
#define RECORD_TEXT_SIZE 400
const char *record_format_outcome(const struct record_row *row, char out[RECORD_TEXT_SIZE]);
/* Writes the evidence for the outcome: when the board warned, and what the wheel reached. */
const char *record_format_evidence(const struct record_row *row, char out[RECORD_TEXT_SIZE]);
/* Writes outcome and evidence: "hit, lead time about 1.6 s (...): the board warned 0.434 s after
 * ...". */
#define RECORD_LINE_SIZE (2 * RECORD_TEXT_SIZE)
const char *record_format_line(const struct record_row *row, char out[RECORD_LINE_SIZE]);
/* Adds the line of record_format_line as text for people, and the JSON object "outcome" with the
 * same facts. */
void record_add_outcome(const struct record_row *row, struct answer *answer);
/* True if the outcome depends on the resolution: the difference between OUTCOME_MIN_ZONE_MATS and
 * the longest zone that the wheel reached is within the resolution. */
bool record_is_marginal(const struct record_row *row);
/* Writes the advice before a landing and whether it was followed: "against, followed"; "none". */
#define RECORD_ADVICE_SIZE 48
const char *record_advice_text(const struct record_row *row, char out[RECORD_ADVICE_SIZE]);
/* Adds the totals as JSON. Text output has one line with `brief` (for `matrig show`), otherwise all
 * totals. */
void record_to_answer(const struct record *record, bool brief, struct answer *answer);

#endif
