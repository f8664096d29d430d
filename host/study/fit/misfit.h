/* Misfit: whether the fitted model can be the data's at all (posterior predictive checks).
 *
 * The measured data set and its replicas (replicas.h) are rows of residuals; each row gives the
 * figures below, and each figure how far the row lies from the middle of all rows, in standard
 * deviations by a tenth of the rows at that end. The farthest figure of a row is the row's
 * distance, or the root of all their squares, taken as one more figure. If the model is the
 * data's, the measured row is one among equals, and its rank by that distance is even: "cannot be"
 * is said when no more than MISFIT_FALSE of all rows lie so far out, so it is said of that share
 * of right models, however many figures there are and however they hang together.
 *
 * Four figures look for one thing each: replicas are simulated again with it, draw by draw, and
 * the combination of residuals that shows it best is the figure. The others look for whatever
 * there is.
 *
 * A figure that is a group weighs several means of residuals together, by Mahalanobis' distance
 * among the rows: of each landing and place of the wheel one. */
#ifndef MATRIG_HOST_STUDY_FIT_MISFIT_H
#define MATRIG_HOST_STUDY_FIT_MISFIT_H

#include "host/study/fit/landings.h"

#define MISFIT_FALSE 0.05
#define MISFIT_LEAST 39u /* replicas, fewer tell nothing */

enum misfit_figure {
    MISFIT_SCATTER,      /* mean square of what transducers leave */
    MISFIT_LARGEST,      /* largest of all residuals */
    MISFIT_KURTOSIS,     /* mean fourth power over squared mean square */
    MISFIT_NEIGHBOURS,   /* transducers beside each other */
    MISFIT_LEVEL,        /* group: means by landing and place of the wheel */
    MISFIT_HALVES,       /* group: their difference between the runway's halves */
    MISFIT_STATION,      /* group: their slope and bend along the runway */
    MISFIT_TIME,         /* group: slope and bend over each landing's time */
    MISFIT_LANDING,      /* group: means of each landing less that of all */
    MISFIT_SUMS,         /* mean square of what sums after the landings leave */
    MISFIT_SUMS_LARGEST, /* largest of them */
    MISFIT_SUMS_ALONG,   /* segments beside each other */
    MISFIT_ZONES,        /* group: means over sixths of the runway */
    MISFIT_CLOSED,       /* segments that the survey finds closed */
    MISFIT_LAID,         /* spread of the sums before, between segments */
    MISFIT_LAID_ALONG,   /* sums before, of segments beside each other */
    MISFIT_ODD_BEYOND,   /* what dirt on one half would do (fit_odd), in the direction that shows */
    MISFIT_ODD_BEFORE,   /* likewise on the other */
    MISFIT_ODD_TAIL,     /* likewise a heavy tail of the resistances */
    MISFIT_ODD_THRUST,   /* likewise thrust that grows or falls within a landing */
    MISFITS
};
extern const struct misfit_word {
    const char *key;
    const char *words;  /* "resistance ... " what is odd when it is too large */
    const char *reason; /* what it may come from, and what to do */
} misfit_words[MISFITS];

struct misfit_found {
    bool known;              /* there is what it is made of */
    double measured, middle; /* the figure, and the median of the replicas */
    double low, high;        /* 95 % of the replicas */
    double away;             /* robust standard deviations, in the direction that counts */
    size_t where; /* statistic, the most odd of those in it; SIZE_MAX: of no single one */
};

struct misfit {
    bool checked; /* there were replicas enough */
    bool cannot;  /* the model cannot be the data's */
    double share; /* of all rows that lie so far out: what `cannot` rests on */
    size_t replicas;
    enum misfit_figure worst;
    struct misfit_found found[MISFITS];
};

/* The odd models that fit_run needs in its options for that: of copies of the list, which stay as
 * long as the models. */
struct misfit_odd {
    struct fit_landings list[FIT_ODD_END - 1];
    struct fit_model model[FIT_ODD_END - 1];
};
void misfit_odd(const struct fit_landings *list, struct misfit_odd *odd,
                struct fit_options *options);

/* MR_FULL. `answer` with its replicas; `seed` for the sums that a survey of the model's own gaps
 * would have read. */
enum mr_status misfit_check(const struct fit_landings *list, const struct fit_answer *answer,
                            uint64_t seed, struct misfit *misfit, struct error *error);

#endif
