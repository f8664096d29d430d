/* Surface: statistics as polynomials of second degree of w, and their scatter about it, from an
 * ensemble. */
#ifndef MATRIG_HOST_STUDY_FIT_SURFACE_H
#define MATRIG_HOST_STUDY_FIT_SURFACE_H

#include <gsl/gsl_matrix.h>

#include "host/study/fit/ensemble.h"

#define SURFACE_TERMS_MAX \
    (1 + FIT_PARAMETERS_MAX + FIT_PARAMETERS_MAX * (FIT_PARAMETERS_MAX + 1) / 2)

struct surface {
    size_t parameters, statistics, terms, draws;
    gsl_matrix *factor; /* terms x statistics: 1; w; products w_i w_k, i <= k */
    /* draws x statistics: left over, each divided by sqrt(1 - its leverage), mean 0 */
    gsl_matrix *departure;
    gsl_matrix *covariance; /* statistics x statistics, of a data set at given parameters */
    gsl_matrix *spread;     /* terms x terms: inverse of the normal matrix */
};

size_t surface_terms(size_t parameters);
/* MR_TOO_FEW when the draws do not exceed twice the terms. Released with surface_free, also after
 * an error. */
enum mr_status surface_make(const struct ensemble *ensemble, struct surface *surface,
                            struct error *error);
void surface_free(struct surface *surface);

/* Expected statistics at w, and their derivatives (statistics rows of parameters; NULL: not
 * wanted). */
void surface_at(const struct surface *surface, const double *w, double *statistic, double *slope);
/* Variance of what surface_at says, as a share of a data set's. */
double surface_leverage(const struct surface *surface, const double *w);

/* A covariance estimated from n data sets, moved towards its own diagonal as far as its
 * correlations are scatter (Ledoit and Wolf, J. Multivariate Analysis 88, 2004, on standardised
 * data; Schaefer and Strimmer, 2005, for this target). Gives the weight of the diagonal. */
double surface_shrink(const gsl_matrix *departure, gsl_matrix *covariance);

/* The ensemble with each data set's statistics replaced by their combinations, the columns of
 * `weight`. */
enum mr_status surface_combine(const struct ensemble *ensemble, const gsl_matrix *weight,
                               struct ensemble *combined, struct error *error);

#endif
