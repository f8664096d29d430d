/* Solve: the parameters at which a surface of scores and the priors come closest to what was
 * measured. Nonlinear least squares by GSL's multifit_nlinear (Levenberg-Marquardt, analytic
 * derivatives). */
#ifndef MATRIG_HOST_STUDY_FIT_SOLVE_H
#define MATRIG_HOST_STUDY_FIT_SOLVE_H

#include "host/study/fit/surface.h"

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
/* (information + priors)^-1. */
void solve_covariance(size_t parameters, double information[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX],
                      double covariance[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX]);
/* Lower Cholesky factor; false when it is not positive definite. */
bool solve_cholesky(size_t n, double matrix[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX],
                    double factor[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX]);

#endif
