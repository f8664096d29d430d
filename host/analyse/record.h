/* The record of a campaign: every advice that was kept before a landing, every warning and risk in
 * it, with what came of it (outcome.h), and their sums.
 *
 * A landing with an unknown outcome is counted as unknown, never as a success. Voided landings
 * stand apart. Nothing here is stored: it is read from the campaign anew, so that a later survey or
 * correction counts. */
#ifndef MATRIG_HOST_ANALYSE_RECORD_H
#define MATRIG_HOST_ANALYSE_RECORD_H

#include "host/analyse/outcome.h"
#include "host/base/answer.h"
#include "host/store/store_journal.h"

#define RECORD_SCORED      10 /* fewer stated probabilities than these have no score */
/* a landing that was braked so much otherwise, or came so much faster or slower, is another than
 * the advice was of */
#define RECORD_OFF_BRAKING 0.25
#define RECORD_OFF_SPEED   0.10
#define RECORD_RISK_AT_S   1.0 /* the risk that is scored is the last one told up to then */

enum record_warned {
    RECORD_UNWATCHED, /* another instrument's readings: no board could warn */
    RECORD_WARNED,
    RECORD_QUIET,
    RECORD_UNHEARD /* none was heard, and one may have come */
};
enum record_verdict {
    RECORD_NOT_KNOWN,
    RECORD_HIT,     /* warned before the wheel came to it */
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
    double lead_s;                          /* to when the wheel came to a zone; NaN */
    double risk_most, risk_most_t_s;        /* told in it; NaN: none */
    double risk_early;                      /* at RECORD_RISK_AT_S; NaN */
    bool advised;
    struct store_advice advice; /* the newest before it */
    size_t replaced;            /* advices before that one, after the landing before */
    double met;                 /* its braking over the planned one; NaN: not known */
    bool off_plan;
    struct outcome outcome;
    enum record_verdict verdict;
    const char *why; /* RECORD_NOT_KNOWN; static */
};

/* Stated probabilities against what came. */
struct record_score {
    size_t count;
    double brier, climatology; /* the same of always saying the share that came; NaN: too few */
};

struct record {
    struct record_row *row; /* by rising RUN */
    size_t rows;
    struct store_landing *landing; /* of each row */
    size_t to_come_advices;        /* kept after the newest landing */
    /* sums over those that are not void */
    size_t landings, voided, unwatched;
    size_t verdict[RECORD_VERDICTS];
    size_t unknown_warned; /* of those not known */
    size_t basis[OUTCOME_BASES];
    double lead_least_s, lead_median_s; /* of hits with a time; NaN: none */
    size_t leads;
    size_t advices, advice[RECORD_ADVICES][3]; /* the latter by enum outcome_came */
    size_t off_plan, to_come, replaced, advice_voided;
    struct record_score said, risk; /* of advice, and of the board RECORD_RISK_AT_S on */
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
/* Judges a landing that somebody has loaded. */
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
