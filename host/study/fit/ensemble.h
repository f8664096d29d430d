/* Ensemble: many simulated data sets at parameters spread about a place, on several threads. */
#ifndef MATRIG_HOST_STUDY_FIT_ENSEMBLE_H
#define MATRIG_HOST_STUDY_FIT_ENSEMBLE_H

#include "host/study/fit/fit.h"

/* An ellipsoid-like region: z = middle + spread w, w even over +-ENSEMBLE_REACH in each direction
 * (standard deviation 1), or normal. */
#define ENSEMBLE_REACH 1.7320508075688772
struct ensemble_place {
    size_t parameters;
    bool normal;
    double middle[FIT_PARAMETERS_MAX];
    double spread[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX]; /* lower triangle */
};

struct ensemble {
    size_t draws, parameters, statistics;
    double *w;         /* draws rows of parameters */
    double *statistic; /* draws rows of statistics */
    uint64_t *draw;    /* number of each: the same gives the same joints */
    size_t failed;     /* left out of the rows */
};

/* `round` keeps the draws of one ensemble apart from those of the next. `until_s`: by
 * monotonic_s(); INFINITY: no limit. MR_TIMEOUT, MR_NUMERICS (more than a tenth failed), MR_FULL.
 * Released with ensemble_free, also after an error. */
enum mr_status ensemble_make(const struct fit_model *model, const struct ensemble_place *place,
                             const struct fit_options *options, unsigned round, double until_s,
                             struct ensemble *ensemble, struct error *error);
void ensemble_free(struct ensemble *ensemble);

/* z of a w. */
void ensemble_at(const struct ensemble_place *place, const double *w, double *z);

#endif
