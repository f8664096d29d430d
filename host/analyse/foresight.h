/* What the board's predictor rested on in a landing, in words: the runway it began with, and what
 * it had to do without. */
#ifndef MATRIG_HOST_ANALYSE_FORESIGHT_H
#define MATRIG_HOST_ANALYSE_FORESIGHT_H

#include "common/block.h"
#include "host/analyse/measured.h"
#include "host/base/answer.h"

enum foresight_lack {
    FORESIGHT_BLIND,
    FORESIGHT_NO_MOTION,
    FORESIGHT_DEGRADED,
    FORESIGHT_BEGUN_AGAIN,
    FORESIGHT_LACKS
};

/* Seconds since touchdown, as elsewhere of a landing; NaN: not at all. */
struct foresight_span {
    double from_s, to_s;
};

struct foresight {
    size_t statements; /* 0: the board has no predictor, or said nothing */
    int64_t source;    /* enum mr_runway_source; STORE_NONE: it was not told */
    unsigned landings; /* that its runway has seen */
    double resistance; /* found, relative to the one configured; NaN: not told */
    struct foresight_span lack[FORESIGHT_LACKS];
    int64_t worst_level; /* cheapest model */
    /* why a transducer was left out last; 0: it was trusted throughout */
    unsigned doubt[MR_TRANSDUCERS];
    struct foresight_span left_out[MR_TRANSDUCERS]; /* as told once a second and on change */
    bool doubted_still[MR_TRANSDUCERS];             /* when last told */
    double risk_most, risk_most_s;                  /* NaN: no risk was told */
    unsigned risk_basis;                            /* then */
    double plan_left_s;                             /* from when on the plan was left; NaN: not */
    bool chart_old;
};

enum mr_status foresight_load(struct store *store, const struct measured *measured,
                              struct foresight *foresight, struct error *error);
/* A line for each of them. */
void foresight_answer(const struct foresight *foresight, const struct measured *measured,
                      struct answer *answer);

#endif
