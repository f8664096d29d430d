/* Misfit: one posterior predictive check of whether the fitted model can be the data's.
 *
 * The measured data set and its replicas (replicas.h) are rows of residuals. The figure of a row is
 * the square of its Mahalanobis distance, by the covariance of all rows (shrunk as Ledoit and Wolf,
 * 2004); where every segment was surveyed before the runway's first landing, plus the square of how
 * far the spread of these sums exceeds what gaps laid alike have, in standard deviations. If the
 * model is the data's, the measured row is one among equals: `share` of the rows, itself among
 * them, are at least as far out, and a share of MISFIT_FALSE or less is found for that share of
 * right models. */
#ifndef MATRIG_HOST_STUDY_FIT_MISFIT_H
#define MATRIG_HOST_STUDY_FIT_MISFIT_H

#include "host/study/fit/fit.h"
#include "host/study/fit/landings.h"

#define MISFIT_FALSE 0.05
#define MISFIT_LEAST 39u /* replicas; fewer decide nothing */

struct misfit {
    bool checked; /* there were replicas enough */
    bool cannot;  /* share <= MISFIT_FALSE: the model cannot be the data's */
    double share;
    size_t replicas;
};

/* `answer` with its replicas; `seed` for the sums that a survey of gaps laid alike would read. */
struct misfit misfit_check(const struct fit_landings *list, const struct fit_answer *answer,
                           uint64_t seed);

/* Replicas: data sets that the fitted model could have given, to hold the measured one against.
 *
 * Parameters are drawn from the posterior (normal in z, by the estimate and its covariance),
 * everything else anew as in any ensemble. Then each replica goes through what the measured data
 * set went through: scores, estimate, and what is left of each statistic, in standard deviations.
 * So both have lost alike what a fit takes away, and the measured one is one more replica if the
 * model is the data's: whatever is made of the rows, its rank among them is even. */

struct replicas {
    const struct fit_model *model;
    const double *measured;
    const struct fit_options *options;
    double until_s;
    const gsl_matrix *weight;      /* statistics x parameters: scores */
    const struct solve *solve;     /* of the last ensemble's scores */
    const struct surface *surface; /* of all statistics, of that ensemble */
};

/* Fills replicas and residual of `answer`, which has all else. When time runs out,
 * or when the posterior reaches where simulations fail, there are no replicas, and that is no
 * error. */
enum mr_status replicas_make(const struct replicas *replicas, struct fit_answer *answer,
                             struct error *error);

#endif
