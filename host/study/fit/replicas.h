/* Replicas: data sets that the fitted model could have given, to hold the measured one against.
 *
 * Parameters are drawn from the posterior (normal in z, by the estimate and its covariance),
 * everything else anew as in any ensemble. Then each replica goes through what the measured data
 * set went through: scores, estimate, and what is left of each statistic, in standard deviations.
 * So both have lost alike what a fit takes away, and the measured one is one more replica if the
 * model is the data's: whatever is made of the rows, its rank among them is even. */
#ifndef MATRIG_HOST_STUDY_FIT_REPLICAS_H
#define MATRIG_HOST_STUDY_FIT_REPLICAS_H

#include "host/study/fit/solve.h"

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
