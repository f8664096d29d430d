/* Error study: what each solver's answer to a scene is worth and what it costs, against a reference
 * that two different methods agree on.
 *
 * Every run is a single pass, without the second one that checks an answer (planar.h), at
 * tolerances a decade apart or steps a factor sqrt 2 apart. Errors are largest differences to the
 * reference over all mats at 64 even times and t_out (u), and over the same times and the run's
 * largest lift (lift). A run's time is the processor time of its pass, the least of up to five.
 * Model chain: `event` over tolerances and `staggered` over steps, against `event` at 1e-13, with
 * which it agrees at 1e-12; what is asked is u, as nothing lifts.
 *
 * Reference: `event` and `implicit` (an explicit method of order 8 and a linearly implicit one of
 * order 4, with Jacobians of its own), both at 1e-9 and 1e-12, and at 1e-13 when they do not agree
 * to 1e-10 ft yet. Where the explicit one gets stuck, `implicit` and `cvode`. When they differ by
 * more than the limits below there is no reference and no table: MR_NUMERICS.
 *
 * Units ft, s; run times in ms. */
#ifndef MATRIG_HOST_SIM_CHECK_ERROR_STUDY_H
#define MATRIG_HOST_SIM_CHECK_ERROR_STUDY_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

#define ERROR_RUNS_MAX      96
#define ERROR_ORDERS_MAX    16
#define ERROR_NOTES_MAX     8
#define ERROR_LIMIT_U_FT    1e-6 /* more disagreement about u: no reference */
#define ERROR_LIMIT_LIFT_FT 1e-5 /* the same about lift */
/* errors below this many times the disagreement are not told from it */
#define ERROR_FLOOR         2.0

struct error_run {
    const char *solver; /* static text */
    double rtol;        /* of a solver that chooses its step, else 0 */
    double dt_s;        /* of one that does not, else 0 */
    uint64_t steps, rhs;
    double ms;
    enum sim_status status;
    int mat; /* where and when it failed, when not SIM_OK */
    double t_s;
    double u_ft, lift_ft; /* errors; NaN unless SIM_OK */
    double max_lift_ft;   /* the run's own; NaN unless SIM_OK */
    bool beyond;          /* fixed step beyond the stability limit: sim_run would have refused it */
};

/* Least-squares slope of log error over log step or log tolerance, over the runs within the
 * stability limit whose error is between ten times the reference's disagreement (and what rounding
 * can sum up to) and a tenth of the largest value. */
struct error_slope {
    double slope;
    double scatter;  /* rms of what the line misses, in decades */
    double from, to; /* of what it is fitted over */
    int points;      /* 0: fewer than 3, or over less than a factor 3: no slope */
};
#define ERROR_NO_LAW 0.6 /* decades of scatter beyond which a slope says nothing */

struct error_order {
    const char *solver;
    bool of_step; /* error ~ dt^slope; else error ~ rtol^slope */
    struct error_slope u, lift;
};

typedef void error_told(void *ctx, size_t runs_begun);

struct error_study {
    char method[240]; /* of the reference, for people */
    double agreement_u_ft, agreement_lift_ft;
    double peak_u_ft, max_lift_ft; /* of the reference */
    double end_s;
    bool lifts;                            /* false: model chain; lift errors are NaN */
    double dt_limit_s;                     /* of the fixed-step solver */
    struct error_run runs[ERROR_RUNS_MAX]; /* by solver, coarse to fine */
    size_t run_count;
    struct error_order orders[ERROR_ORDERS_MAX];
    size_t order_count;
    char notes[ERROR_NOTES_MAX][160]; /* empty text at the end */
    error_told *told;                 /* of error_study_run */
    void *told_ctx;
};

/* Lift errors for which the cheapest solver is asked, ft. */
extern const double error_levels_ft[];
extern const size_t error_level_count;

/* `told` hears how many runs have begun, 0 while the references are made; NULL: nobody does.
 * MR_OK: the study is complete. MR_NUMERICS: the references failed or disagree. Else what sim_run
 * says of a wrong scene. The scene is only read. Nothing to free. */
enum mr_status error_study_run(struct error_study *study, const struct sim_scene *scene,
                               error_told *told, void *told_ctx, struct error *error);

/* Error of lift (chain: of u) by which run i is judged: its own; of a fixed step the worst of it
 * and both neighbours, because such an error can be small by luck. NaN: failed, beyond the limit,
 * or no neighbour. */
double error_study_judged_ft(const struct error_study *study, size_t i);

/* The cheapest run of `solver` (NULL: of any) that is judged to be within level_ft. NULL: none, or
 * the level is below what the reference can tell. */
const struct error_run *error_study_cheapest(const struct error_study *study, const char *solver,
                                             double level_ft);

/* The names of the solvers in the study, in order; returns how many, at most `room`. */
size_t error_study_solvers(const struct error_study *study, const char **names, size_t room);

/* Fits study->orders, one for each solver; error_study_run has done it. */
void error_study_fit(struct error_study *study);

#endif
