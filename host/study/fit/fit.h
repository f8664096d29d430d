/* Fit: parameters of a simulation that draws part of what it simulates, from statistics of what was
 * measured.
 *
 * The gaps and closing resistances of single joints are not known: two landings with equal
 * parameters differ, by far more than the instruments' noise. So a set of parameters does not
 * predict a series but a distribution of it, and samples 1 ms apart say the same thing over and
 * over. Everything here therefore rests on an ensemble of simulated data sets, each with joints,
 * noise and calibration errors of its own, that go through the same statistics as the measured one:
 *
 * 1. A design: parameters spread evenly (a Sobol sequence) about the present estimate, one draw of
 * everything else for each.
 * 2. A response surface: each statistic, by least squares, as a polynomial of second degree of the
 * parameters. What is left is
 *    the scatter at given parameters, with its covariance (shrunk as Ledoit and Wolf, 2004). No
 *    difference quotient of the simulation itself is ever taken: it sticks and closes, so it has
 *    none that means anything.
 * 3. Scores: the q combinations of the statistics that say most about the q parameters, B' S^-1 s
 * (B slopes, S covariance).
 * 4. The estimate: least squares of scores and priors, weighted with their covariance (GSL
 * multifit_nlinear). Two or more rounds of this find the place, each with the scores that the
 * ensemble before it chose. A last ensemble, about that place, gives surface and covariance of the
 * scores, the estimate, and its errors:
 *
 * - information of the data alone: B' S^-1 B, B and S of the scores, S with what the surface itself
 * is uncertain by.
 * - error and interval: a bootstrap at the estimate. Each left-over of the ensemble is a fresh data
 * set's departure; with it, and
 *   with priors drawn alike, the fit is done again. The spread of these estimates is the error of
 *   the fit, Student's t of it the interval (in z, so that the interval of a parameter is as wide
 *   upwards as downwards by its factor), their offset the bias.
 * - replicas: data sets from the posterior, fitted again, for misfit.h to hold the measured one
 * against.
 *
 * Parameters here are z: in units of their prior's standard deviation, from its middle; the priors
 * are independent. Deterministic: the same seed gives the same answer, however many threads. */
#ifndef MATRIG_HOST_STUDY_FIT_FIT_H
#define MATRIG_HOST_STUDY_FIT_FIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"

#define FIT_PARAMETERS_MAX 6
#define FIT_STATISTICS_MAX 1200
#define FIT_DRAWS_LEAST    60u
#define FIT_ROUNDS_MAX     8u
#define FIT_SOME           8u

/* What is fitted. simulate() writes the statistics of one data set at z; everything that is drawn
 * comes from `draw` alone, so that equal calls give equal answers; it is called from several
 * threads. False: this draw failed. */
struct fit_model {
    size_t parameters, statistics;
    bool (*simulate)(const void *context, const double *z, uint64_t draw, double *statistics);
    const void *context;
    /* 1 to FIT_SOME of them at once: rows of z and of statistics, and which are good. NULL: one
     * after the other. Which ones are asked for together does not depend on the threads. */
    void (*simulate_some)(const void *context, size_t count, const double *z, const uint64_t *draw,
                          double *statistics, bool *good);
};

struct fit_options {
    size_t draws;     /* of each ensemble; 0: 300 */
    size_t replicas;  /* of the data set, to check the model with; 0: 99 */
    unsigned threads; /* 0: as many as processors */
    uint64_t seed;
    double max_s; /* wall clock; 0: without limit */
    /* called by one thread; false: stop. NULL: none */
    bool (*go_on)(void *context, unsigned round, size_t done, size_t of);
    void *go_on_context;
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
    /* the estimate did not come to stand still in the rounds or the time there were */
    bool stopped;
    double *expected; /* per statistic, at z */
    double *scatter;  /* its standard deviation */
    /* 1 + replicas rows of statistics: what is left, in standard deviations, of the measured data
     * set and of replicas (replicas.h). No replicas: there was no time for them */
    size_t replicas;
    double *residual;
};

/* MR_TOO_FEW: fewer statistics than parameters. MR_NUMERICS: too many draws failed, or a statistic
 * that nothing changes. MR_TIMEOUT: time ran out, or go_on said no, before there was any answer.
 * The caller releases with fit_free, also after an error. */
enum mr_status fit_run(const struct fit_model *model, const double *measured,
                       const struct fit_options *options, struct fit_answer *answer,
                       struct error *error);
void fit_free(struct fit_answer *answer);

#endif
