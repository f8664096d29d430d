/* Error study: the error and the cost of each solver for a scene, relative to a reference, which is
 * a solution on which two different methods agree.
 *
 * Every run is a single pass, without the second pass that checks a result (planar.h); the
 * tolerances of the runs differ by a factor of 10, the steps by sqrt 2. Errors are the largest
 * differences from the reference: for u over all mats, at 64 equally spaced times and at t_out; for
 * lift over the same times and the run's largest lift. The time of a run is the processor time of
 * its pass, the smallest of up to five. Model chain: `event` over tolerances and `staggered` over
 * steps, against `event` at 1e-13, which agrees with its run at 1e-12. Only u is evaluated, because
 * nothing lifts.
 *
 * Reference: `event` (explicit, order 8) and `implicit` (linearly implicit, order 4, with separate
 * Jacobians), both at 1e-9 and 1e-12, and at 1e-13 if they do not yet agree to 1e-10 ft. If `event`
 * makes no progress, the reference is `implicit` and `cvode`. If the two differ by more than the
 * limits below, there is no reference and no table: MR_NUMERICS.
 *
 * Units are ft and s; run times in ms. */
#ifndef MATRIG_HOST_SIM_CHECK_ERROR_STUDY_H
#define MATRIG_HOST_SIM_CHECK_ERROR_STUDY_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

#define ERROR_RUNS_MAX          96
#define ERROR_ORDERS_MAX        16
#define ERROR_NOTES_MAX         8
/* in ft; if the reference runs differ more in u, there is no reference */
#define ERROR_LIMIT_U_FT        1e-6
/* in ft; if the reference runs differ more in lift, there is no reference */
#define ERROR_LIMIT_LIFT_FT     1e-5
/* Errors below this multiple of the difference between the two reference runs cannot be
 * resolved. */
#define ERROR_RESOLUTION_FACTOR 2.0

struct error_run {
    const char *solver; /* static text */
    double rtol;        /* tolerance of a solver that chooses its step, otherwise 0 */
    double dt_s;        /* step of a solver with a fixed step, otherwise 0 */
    uint64_t steps, evaluations;
    double ms;
    enum sim_status status;
    int mat; /* mat and time at which the run failed */
    double t_s;
    double u_ft, lift_ft; /* errors of u and lift; NaN unless SIM_OK */
    double max_lift_ft;   /* largest lift in the run; NaN unless SIM_OK */
    /* the fixed step is beyond the stability limit; sim_run would refuse the run */
    bool is_unstable;
};

/* Slope of a straight line through log error over log step or log tolerance, by least squares. Uses
 * only runs within the stability limit whose error is at most a tenth of the largest value and at
 * least ten times the larger of two numbers: the difference of the reference runs and the possible
 * sum of rounding errors. */
struct error_slope {
    double slope;
    double scatter;          /* rms deviation from the line, decades */
    double fit_min, fit_max; /* smallest and largest step or tolerance of the fit */
    /* number of points; 0: no slope, because there are fewer than 3 points or their largest and
     * smallest step or tolerance differ by less than a factor of 3 */
    int point_count;
};
#define ERROR_SCATTER_MAX 0.6 /* in decades; a slope with more scatter is not meaningful */

struct error_order {
    const char *solver;
    bool is_step_order; /* true: error ~ dt^slope; false: error ~ rtol^slope */
    struct error_slope u, lift;
};

typedef void error_study_progress(void *ctx, size_t started_run_count);

struct error_study {
    char reference_method[240]; /* description of the reference, as text */
    double disagreement_u_ft, disagreement_lift_ft;
    double peak_u_ft, max_lift_ft; /* largest values of the reference */
    double end_s;
    bool has_lift;     /* false: model chain, which has no lift; errors of lift are NaN */
    double dt_limit_s; /* stability limit of the solver with a fixed step */
    struct error_run runs[ERROR_RUNS_MAX]; /* runs by solver, from coarse to fine */
    size_t run_count;
    struct error_order orders[ERROR_ORDERS_MAX];
    size_t order_count;
    char notes[ERROR_NOTES_MAX][160]; /* an empty text ends the list */
    /* progress function of the caller, as passed to error_study_run */
    error_study_progress *progress;
    void *progress_ctx;
};

/* Levels of the lift error, ft. For each level, the study finds the cheapest solver. */
extern const double error_levels_ft[];
extern const size_t error_level_count;

/* Runs the study. `progress` is called with the number of runs begun so far, 0 during the
 * references; NULL: not called. MR_OK: the study is complete. MR_NUMERICS: the references failed or
 * disagree. Other statuses: those of sim_run for an invalid scene. The scene is not changed. There
 * is nothing to free. */
enum mr_status error_study_run(struct error_study *study, const struct sim_scene *scene,
                               error_study_progress *progress, void *progress_ctx,
                               struct error *error);

/* Error of lift (model chain: of u) of run i. For a fixed step, this is the largest error among the
 * run and its two neighbours, because a single error can be small by chance. NaN: the run failed,
 * is beyond the stability limit, or has no neighbour. */
double error_study_smoothed_error_ft(const struct error_study *study, size_t i);

/* Finds the cheapest run of `solver` (NULL: of any solver) whose error
 * (error_study_smoothed_error_ft) is at most level_ft. NULL: there is none, or the level is below
 * the resolution of the reference. */
const struct error_run *error_study_find_cheapest(const struct error_study *study,
                                                  const char *solver, double level_ft);

/* Writes the names of the solvers in the study, in order. Returns their number, at most `room`. */
size_t error_study_solvers(const struct error_study *study, const char **names, size_t room);

/* Fits study->orders, one slope per solver. Called by error_study_run. */
void error_study_fit_slopes(struct error_study *study);

#endif
