/* The record of a campaign: every advice kept before a landing, every warning and risk in it, with
 * the outcome, and their sums.
 *
 * A landing with an unknown outcome is counted as unknown, never as a success. Voided landings are
 * counted separately. Nothing here is stored: it is computed from the campaign each time, so that a
 * later survey or correction counts. */
#ifndef MATRIG_HOST_ANALYSE_RECORD_H
#define MATRIG_HOST_ANALYSE_RECORD_H

#include "host/analyse/measured.h"
#include "host/analyse/zones.h"
#include "host/base/answer.h"
#include "host/store/store_journal.h"

/* The outcome of a landing, by measurement: whether the wheel reached a zone of 50 closed mats
 * before it stopped. No predictor is used: the judge of a warning must not be its source.
 *
 * It is based, in this order, on
 * - a wave or a break that a person observed; a two-panel wave that the gear crosses is no
 *   failure (report 2.1)
 * - the survey before it and the transducers since (common/closure.h): at each moment the
 *   longest closed run ahead of the wheel, from within OUTCOME_NEAR_FT of the wheel, for 0.1 s.
 *   Segments of ten mats make its length and its time coarse (by how much: tests/score)
 * - the survey after it: a closed run of that length which begins at the stopped wheel.
 *   This can only give "yes": joints open again behind the wheel.
 *
 * The outcome is "no" when the stop is known, the survey before was made after the previous
 * landing, even its unread segments could not form a zone, and transducers cover at least half of
 * the way from touchdown to 50 mats beyond the stop. Otherwise it is unknown, and `why` has the
 * reason. */

#define OUTCOME_MATS    50  /* where buckling begins (report 6.1.4) */
#define OUTCOME_NEAR_FT 2.0 /* seven mats; as in tests/score */

enum outcome_came { OUTCOME_UNKNOWN, OUTCOME_CAME, OUTCOME_DID_NOT };
enum outcome_basis {
    OUTCOME_NOTHING,
    OUTCOME_SEEN,
    OUTCOME_TRANSDUCERS,
    OUTCOME_SURVEY_AFTER,
    OUTCOME_BASES
};

struct outcome {
    enum outcome_came came;
    enum outcome_basis basis;
    const char *why; /* why the outcome is unknown; static */
    /* the longest zone that the wheel reached, by transducers and survey; STORE_NONE: not known */
    int64_t mats;
    double start_ft; /* of that one */
    double t_s; /* from when on the wheel was at one of 50 mats; NaN: it was not, or not known */
    double watched; /* share of its way that transducers bound */
    /* closed run at the wheel by the survey after it; STORE_NONE: none was read */
    int64_t left_mats;
    size_t waves, breaks; /* seen, and not withdrawn */
};

/* "transducers and survey", for tables. Static storage. */
const char *outcome_basis_text(enum outcome_basis basis);

/* a landing whose braking or speed differed by this much is not the one that was advised on */
#define RECORD_OFF_BRAKING 0.25
#define RECORD_OFF_SPEED   0.10

enum record_warned {
    RECORD_UNWATCHED, /* another instrument's readings: no board could warn */
    RECORD_WARNED,
    RECORD_QUIET,
    RECORD_UNHEARD /* none was received, but one may have been sent */
};
enum record_verdict {
    RECORD_NOT_KNOWN,
    RECORD_HIT,     /* warned before the wheel reached it */
    RECORD_LATE,    /* warned after */
    RECORD_MISS,    /* no warning */
    RECORD_FALSE,   /* warned, and it did not come */
    RECORD_SILENCE, /* no warning, and it did not come */
    RECORD_VERDICTS
};
enum record_advised { RECORD_CLEAR, RECORD_CAUTION, RECORD_AGAINST, RECORD_ADVICES };

struct record_row {
    int64_t run;
    bool judged; /* else what follows `advice` is still to be found */
    bool is_void;
    enum record_warned warned;
    double warned_t_s, warned_ft, wheel_ft; /* first warning; NaN: none */
    double lead_s;                          /* until the wheel reached a zone; NaN */
    double risk_most;                       /* reported during it; NaN: none */
    bool advised;
    struct store_advice advice; /* the newest before it */
    bool off_plan;
    struct outcome outcome;
    enum record_verdict verdict;
    const char *why; /* RECORD_NOT_KNOWN; static */
};

struct record {
    struct record_row *row; /* by rising RUN */
    size_t rows;
    struct store_landing *landing; /* of each row */
    /* sums over those that are not void */
    size_t landings, voided;
    size_t verdict[RECORD_VERDICTS];
    size_t advice[RECORD_ADVICES][3]; /* by enum outcome_came */
    size_t off_plan;                  /* landings that were others than planned: not in `advice` */
};

/* A landing that is loaded, with its series. */
struct record_given {
    const struct measured *measured;
    const struct zones *zones;
};

/* A row for each landing, none judged. The caller releases it with record_free, also after an
 * error. */
enum mr_status record_begin(struct store *store, struct record *record, struct error *error);
/* The row of a landing; NULL: there is none. */
struct record_row *record_find(struct record *record, int64_t run);
/* Judges a landing that the caller has loaded. */
enum mr_status record_judge(struct store *store, struct record *record,
                            const struct record_given *given, struct error *error);
/* Loads and judges those that are not, and adds up. */
enum mr_status record_end(struct store *store, struct record *record, struct error *error);
/* All of it. */
enum mr_status record_load(struct store *store, struct record *record, struct error *error);
void record_free(struct record *record);

const char *record_verdict_text(enum record_verdict verdict);
/* The sums, for programs; people see one line of `matrig show` with `brief`, else all. */
void record_answer(const struct record *record, bool brief, struct answer *answer);

#endif
