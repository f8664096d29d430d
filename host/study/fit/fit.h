/* Fit: parameters of a simulation that draws part of what it simulates, from statistics of what was
 * measured.
 *
 * The gaps and closing resistances of single joints are not known: two landings with equal
 * parameters differ, by far more than the instruments' noise. So a set of parameters does not
 * predict a series but a distribution of it, and samples 1 ms apart say the same thing over and
 * over. Everything here therefore rests on an ensemble of simulated data sets, each with joints,
 * noise and calibration errors of its own, that go through the same statistics as the measured one:
 *
 * The method step by step: README.md.
 *
 * Parameters here are z: in units of their prior's standard deviation, from its middle; the priors
 * are independent. Deterministic: the same seed gives the same answer, however many threads. */
#ifndef MATRIG_HOST_STUDY_FIT_FIT_H
#define MATRIG_HOST_STUDY_FIT_FIT_H

#include <gsl/gsl_matrix.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"

#define FIT_PARAMETERS_MAX 6
#define FIT_STATISTICS_MAX 1200
#define FIT_DRAWS_LEAST    60u
#define FIT_ROUNDS_MAX     8u
#define FIT_SOME           8u

/* What is fitted. simulate() writes the statistics of 1 to FIT_SOME data sets, rows of z and of
 * statistics, and which are good; everything that is drawn comes from each one's `draw` alone, so
 * that equal calls give equal answers; it is called from several threads. Which ones are asked for
 * together does not depend on the threads. */
struct fit_model {
    size_t parameters, statistics;
    void (*simulate)(const void *context, size_t count, const double *z, const uint64_t *draw,
                     double *statistics, bool *good);
    const void *context;
};

struct fit_options {
    size_t draws;     /* of each ensemble; 0: 300 */
    size_t replicas;  /* of the data set, to check the model with; 0: 99 */
    unsigned threads; /* 0: as many as processors */
    uint64_t seed;
    /* called by one thread; NULL: none */
    void (*progress)(void *context, unsigned round, size_t done, size_t of);
    void *progress_context;
};

struct fit_answer {
    size_t parameters, statistics;
    double z[FIT_PARAMETERS_MAX];
    double low[FIT_PARAMETERS_MAX], high[FIT_PARAMETERS_MAX]; /* 95 % interval */
    /* of the estimate, by the bootstrap */
    double bias[FIT_PARAMETERS_MAX];
    /* of the estimate, priors included */
    double covariance[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];
    double information[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX]; /* of the data alone */
    unsigned rounds;                                            /* ensembles */
    size_t simulated, failed;
    bool stopped;     /* the estimate did not come to stand still in the rounds there were */
    double *expected; /* per statistic, at z */
    double *scatter;  /* its standard deviation */
    /* 1 + replicas rows of statistics: what is left, in standard deviations, of the measured data
     * set and of replicas. No replicas: simulations of them failed */
    size_t replicas;
    double *residual;
};

/* MR_TOO_FEW: fewer statistics than parameters. MR_NUMERICS: too many draws failed, or a statistic
 * that nothing changes. The caller releases with fit_free, also after an error. */
enum mr_status fit_run(const struct fit_model *model, const double *measured,
                       const struct fit_options *options, struct fit_answer *answer,
                       struct error *error);
void fit_free(struct fit_answer *answer);

/* Ensemble: many simulated data sets at parameters spread about a place, on several threads. */

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

/* `round` keeps the draws of one ensemble apart from those of the next. MR_NUMERICS: more than a
 * tenth failed. Released with ensemble_free, also after an error. */
enum mr_status ensemble_make(const struct fit_model *model, const struct ensemble_place *place,
                             const struct fit_options *options, unsigned round,
                             struct ensemble *ensemble, struct error *error);
void ensemble_free(struct ensemble *ensemble);

/* Surface: statistics as polynomials of second degree of w, and their scatter about it, from an
 * ensemble. */

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

/* MR_TOO_FEW when the draws do not exceed twice the terms. Released with surface_free, also after
 * an error. */
enum mr_status surface_make(const struct ensemble *ensemble, struct surface *surface,
                            struct error *error);
void surface_free(struct surface *surface);

/* Expected statistics at w, and their derivatives (statistics rows of parameters; NULL: not
 * wanted). */
void surface_at(const struct surface *surface, const double *w, double *statistic, double *slope);

/* A covariance estimated from n data sets, moved towards its own diagonal as far as its
 * correlations are scatter (Ledoit and Wolf, J. Multivariate Analysis 88, 2004, on standardised
 * data; Schaefer and Strimmer, 2005, for this target). Gives the weight of the diagonal. */
double surface_shrink(const gsl_matrix *departure, gsl_matrix *covariance);

/* The ensemble with each data set's statistics replaced by their combinations, the columns of
 * `weight`. */
void surface_combine(const struct ensemble *ensemble, const gsl_matrix *weight,
                     struct ensemble *combined);

/* Solve: the parameters at which a surface of scores and the priors come closest to what was
 * measured. Nonlinear least squares by GSL's multifit_nlinear (Levenberg-Marquardt, analytic
 * derivatives). */

/* Beyond this in w the surface goes on straight: a polynomial turns round where nothing was
 * simulated. */
#define SOLVE_STRAIGHT (1.3 * ENSEMBLE_REACH)

/* What is minimised over w: |root (surface(w) - score)|^2 + |z(w) - prior|^2. */
struct solve {
    const struct surface *surface; /* as many statistics as parameters */
    const struct ensemble_place *place;
    /* root' root = (covariance (1 + leverage))^-1 */
    double root[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];
    double score[FIT_PARAMETERS_MAX];
    double prior[FIT_PARAMETERS_MAX];
};

/* Prepares for a surface: root at the middle, priors 0. False: its
 * covariance is singular. */
bool solve_begin(struct solve *solve, const struct surface *surface,
                 const struct ensemble_place *place);
/* From w (start) to w (least). Gives the least sum of squares; NaN: no convergence. */
double solve_least(const struct solve *solve, double *w);
/* residual: 2 q; slope: 2 q rows of q: what multifit_nlinear is given. For tests. */
void solve_residual(const struct solve *solve, const double *w, double *residual, double *slope);
/* Information of the data alone at w, about z. */
void solve_information(const struct solve *solve, const double *w,
                       double information[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX]);
/* Lower Cholesky factor; false when it is not positive definite. */
bool solve_cholesky(size_t n, double matrix[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX],
                    double factor[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX]);

#endif
