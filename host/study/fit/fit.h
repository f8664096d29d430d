/* Fit: estimation of the parameters of a simulation with random parts, from statistics of measured
 * data.
 *
 * The gaps and closing resistances of single joints are not known. Two landings with equal
 * parameters differ by far more than the instruments' noise. A set of parameters therefore predicts
 * a distribution of data sets and not one data set. Samples 1 ms apart are not independent. The fit
 * is therefore based on an ensemble of simulated data sets, each with random joints, noise and
 * calibration errors. The same statistics are computed from each of them and from the measured data
 * set.
 *
 * README.md describes the method step by step.
 *
 * Parameters are stored as z: deviations from the middle of their prior in units of its standard
 * deviation; the priors are independent. Deterministic: the same seed gives the same answer for any
 * number of threads. */
#ifndef MATRIG_HOST_STUDY_FIT_FIT_H
#define MATRIG_HOST_STUDY_FIT_FIT_H

#include <gsl/gsl_matrix.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"

#define FIT_PARAMETERS_MAX 6
#define FIT_STATISTICS_MAX 1200
#define ENSEMBLE_DRAWS_MIN 60u
#define FIT_ROUNDS_MAX     8u
#define FIT_BATCH_MAX      8u

/* The model that is fitted. simulate() computes the statistics of 1 to FIT_BATCH_MAX data sets, one
 * row for each row of z, and marks the valid rows. All random values of a data set depend only on
 * its `draw`, so equal calls give equal results. simulate() is called from several threads. The
 * division of the data sets among calls does not depend on the number of threads. */
struct fit_model {
    size_t parameter_count, statistic_count;
    void (*simulate)(const void *context, size_t count, const double *z, const uint64_t *draw,
                     double *statistics, bool *good);
    const void *context;
};

struct fit_options {
    size_t draw_count;     /* data sets per ensemble; 0: 300 */
    size_t replica_count;  /* replicas of the data set, for checking the model; 0: 99 */
    unsigned thread_count; /* number of threads; 0: one per processor */
    uint64_t seed;
    /* called from one thread only; NULL: no progress is reported */
    void (*progress)(void *context, unsigned round, size_t done, size_t total);
    void *progress_context;
};

struct fit_result {
    size_t parameter_count, statistic_count;
    double z[FIT_PARAMETERS_MAX];
    double low[FIT_PARAMETERS_MAX], high[FIT_PARAMETERS_MAX]; /* 95 % interval of each parameter */
    /* bias of the estimate, from the bootstrap */
    double bias[FIT_PARAMETERS_MAX];
    /* covariance of the estimate, with the priors */
    double covariance[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];
    /* information matrix of the data, without the priors */
    double information[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];
    unsigned round_count; /* number of ensembles that were simulated */
    size_t simulated_draw_count, failed_draw_count;
    bool has_not_converged; /* the estimate did not converge within the maximum number of rounds */
    double *expected;       /* expected value of each statistic at the estimate */
    double *scatter;        /* standard deviation of each statistic */
    /* 1 + replica_count rows of residuals of the statistics, in standard deviations: first of the
     * measured data set, then of the replicas. `replica_count` is 0 if their simulations failed. */
    size_t replica_count;
    double *residual;
};

/* Runs the fit. MR_TOO_FEW: fewer statistics than parameters. MR_NUMERICS: too many draws failed,
 * or no parameter changes a statistic. The caller releases `answer` with fit_free, also after an
 * error. */
enum mr_status fit_run(const struct fit_model *model, const double *measured,
                       const struct fit_options *options, struct fit_result *answer,
                       struct error *error);
void fit_free(struct fit_result *answer);

/* An ensemble is many simulated data sets with parameters spread about a point. Its parameters are
 * z = middle + spread w, with w uniform over +-ENSEMBLE_HALF_WIDTH in each direction (standard
 * deviation 1), or normal. */
#define ENSEMBLE_HALF_WIDTH 1.7320508075688772
struct ensemble_region {
    size_t parameter_count;
    bool is_normal;
    double middle[FIT_PARAMETERS_MAX];
    double spread[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX]; /* lower triangular matrix */
};

struct ensemble {
    size_t draw_count, parameter_count, statistic_count;
    double *w;         /* `draw_count` rows of parameters */
    double *statistic; /* `draw_count` rows of statistics */
    /* number of each draw; draws with the same number have the same joints */
    uint64_t *draw_numbers;
    size_t failed_draw_count; /* number of draws that failed and have no rows */
};

/* Simulates an ensemble on several threads. Ensembles of different rounds have different draws.
 * MR_NUMERICS: more than a tenth of the draws failed. Release with ensemble_free, also after an
 * error. */
enum mr_status ensemble_simulate(const struct fit_model *model,
                                 const struct ensemble_region *region,
                                 const struct fit_options *options, unsigned round,
                                 struct ensemble *ensemble, struct error *error);
void ensemble_free(struct ensemble *ensemble);

/* A surface describes the statistics as second-degree polynomials of w, fitted to an ensemble, and
 * their scatter about the polynomials. */

#define SURFACE_TERMS_MAX \
    (1 + FIT_PARAMETERS_MAX + FIT_PARAMETERS_MAX * (FIT_PARAMETERS_MAX + 1) / 2)

struct surface {
    size_t parameter_count, statistic_count, term_count, draw_count;
    /* terms x statistics: coefficients of 1, of w and of the products w_i w_k, i <= k */
    gsl_matrix *coefficients;
    /* draws x statistics: residuals with mean 0, each divided by sqrt(1 - its leverage). */
    gsl_matrix *scaled_residuals;
    /* statistics x statistics: covariance of a data set at given parameters */
    gsl_matrix *covariance;
    gsl_matrix *inverse_normal; /* terms x terms: inverse of the normal matrix */
};

/* Fits a surface. MR_TOO_FEW: the number of draws is not more than twice the number of terms.
 * Release with surface_free, also after an error. */
enum mr_status surface_make(const struct ensemble *ensemble, struct surface *surface,
                            struct error *error);
void surface_free(struct surface *surface);

/* Computes the expected statistics at w, and their derivatives: one row of parameters per
 * statistic. `slope` NULL: derivatives are not wanted. */
void surface_evaluate(const struct surface *surface, const double *w, double *statistic,
                      double *slope);

/* Shrinks a covariance that is estimated from n data sets towards its diagonal. The weight of the
 * diagonal depends on how much of the correlations is random scatter (Ledoit and Wolf, J.
 * Multivariate Analysis 88, 2004, on standardised data; Schaefer and Strimmer, 2005, for this
 * target). Returns this weight. */
double surface_shrink(const gsl_matrix *departure, gsl_matrix *covariance);

/* Copies an ensemble, with the statistics of each data set replaced by linear combinations of them.
 * Each column of `weight` has the coefficients of one combination. */
void surface_combine(const struct ensemble *ensemble, const gsl_matrix *weight,
                     struct ensemble *combined);

/* Solution of the fit: the parameters at which the scores of a surface and the priors are closest
 * to the measured values. It is found by nonlinear least squares with GSL's multifit_nlinear
 * (Levenberg-Marquardt, analytic derivatives). */

/* Distance from w = 0 beyond which the surface is continued linearly. The polynomials are not valid
 * outside the simulated range. */
#define SOLVE_LINEAR_FROM (1.3 * ENSEMBLE_HALF_WIDTH)

/* The minimised function of w is |root (surface(w) - score)|^2 + |z(w) - prior|^2. */
struct solve {
    const struct surface *surface; /* a surface with one statistic per parameter */
    const struct ensemble_region *region;
    /* root' root = (covariance (1 + leverage))^-1 */
    double root[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];
    double score[FIT_PARAMETERS_MAX];
    double prior[FIT_PARAMETERS_MAX];
};

/* Prepares the minimisation for a surface: `root` is set for the middle of the region, and the
 * priors are 0. Returns false if the covariance is singular. */
bool solve_begin(struct solve *solve, const struct surface *surface,
                 const struct ensemble_region *region);
/* Minimises the sum of squares. Starts at `w`, and stores the minimum there. Returns the minimum
 * sum of squares; NaN: no convergence. */
double solve_least_squares(const struct solve *solve, double *w);
/* Computes the residuals (2 q values, for q parameters) and their slopes (2 q rows of q), as passed
 * to multifit_nlinear. For tests. */
void solve_residual(const struct solve *solve, const double *w, double *residual, double *slope);
/* Computes the information matrix of the data at w in terms of z, without priors. */
void solve_information(const struct solve *solve, const double *w,
                       double information[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX]);
/* Replaces a matrix by its lower Cholesky factor. Returns false if the matrix is not positive
 * definite. */
bool solve_cholesky(size_t n, double matrix[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX],
                    double factor[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX]);

#endif
