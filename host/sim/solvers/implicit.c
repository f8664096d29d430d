/* implicit: RODAS, a Rosenbrock method of order 4 with embedded order 3, L-stable and stiffly
 * accurate (E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, IV.7). Every switch
 * is located in time.
 *
 * Each stage solves (1/(h gamma) - J) k = r for the state (p, v). As p' = v, the p half is
 * eliminated:
 *
 *     k_p = h gamma (r_p + k_v)
 *     [M/(h gamma) - R_v - h gamma R_p] k_v = M r_v + h gamma R_p r_p
 *
 * model_linearise gives M, R_p and R_v. Each step needs one factorisation of a banded matrix,
 * O(N). */
#include <math.h>

#include "host/base/elementary.h"
#include "host/sim/models/model.h"
#include "host/sim/solvers/stepper.h"

#define STAGE_COUNT 6
#define GAMMA       0.25

static const double stage_nodes[STAGE_COUNT] = {0.0, 0.386, 0.21, 0.63, 1.0, 1.0};
/* factors of df/dt in each stage */
static const double time_derivative_factors[STAGE_COUNT] = {0.25,    -0.1043, 0.1035,
                                                            -0.0362, 0.0,     0.0};
static const double stage_state_weights[STAGE_COUNT][STAGE_COUNT - 1] = {
    [1] = {1.544},
    [2] = {0.9466785280815826, 0.2557011698983284},
    [3] = {3.314825187068521, 2.896124015972201, 0.9986419139977817},
    [4] = {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
    [5] = {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1.0},
};
static const double stage_sum_weights[STAGE_COUNT][STAGE_COUNT - 1] = {
    [1] = {-5.6688},
    [2] = {-2.430093356833875, -0.2063599157091915},
    [3] = {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
    [4] = {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
    [5] = {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136,
           -6.058818238834054},
};
struct implicit_work {
    double *k[STAGE_COUNT];
    double *rate, *stage_state, *stage_sum; /* 2 size values in each array */
    double *mass, *dr_dp, *dr_dv, *lu;
    double *dr_dt; /* `size` values: dR/dt, later M^-1 dR/dt */
    double *rhs;   /* `size` values */
    int *pivot;
    double *mass_lu;
    int *mass_pivot;
    bool has_end_rates;      /* `stage_state` contains the rates at the end of the last step */
    double fastest_spring_s; /* time constant of the fastest spring; 0: not computed yet */
};

static void make(struct stepper *s, double *more)
{
    struct implicit_work *w = s->work;
    size_t size = (size_t)s->model->coordinate_count;
    w->mass = more;
    w->dr_dp = w->mass + MODEL_ROW_LENGTH * size;
    w->dr_dv = w->dr_dp + MODEL_ROW_LENGTH * size;
    w->lu = w->dr_dv + MODEL_ROW_LENGTH * size;
    w->mass_lu = w->lu + BANDED_ROW_LENGTH * size;
    w->dr_dt = w->mass_lu + BANDED_ROW_LENGTH * size;
    w->rhs = w->dr_dt + size;
    w->pivot = (int *)(w->rhs + size);
    w->mass_pivot = w->pivot + size;
}

/* After a switch, or when the wheel reaches the next mat, restarts with a step no longer than one
 * oscillation of the fastest spring. The method damps out oscillations that are much shorter than
 * the step, so a body that hits a spring would stay there instead of rebounding, and the error
 * estimate would not show it. With the short step the estimate includes the oscillation; the step
 * grows when the oscillation has decayed. */
static void restart(struct stepper *s)
{
    struct implicit_work *w = s->work;
    w->has_end_rates = false;
    if (w->fastest_spring_s <= 0.0) {
        double rate = model_fastest_rate(s->model, s->z, MODEL_RATE_SPRINGS_ONLY);
        w->fastest_spring_s = rate > 0.0 ? 1.0 / rate : (double)INFINITY;
    }
    s->h_s = fmin(s->h_s, w->fastest_spring_s);
}

static void add_weighted_stages(const struct stepper *s, const double *weights, int count,
                                double scale, const double *from, double *to)
{
    const struct implicit_work *w = s->work;
    for (int half = 0; half < 2; half++) {
        int start = half * s->model->coordinate_count;
        for (int i = start + stepper_first_index(s); i < start + stepper_end_index(s); i++) {
            double sum = 0.0;
            for (int j = 0; j < count; j++)
                sum += weights[j] * w->k[j][i];
            to[i] = (from ? from[i] : 0.0) + scale * sum;
        }
    }
}

/* Solves a stage for k with r = rate + mix (+ h d df/dt). The matrix must be factored already. */
static void solve_stage(const struct stepper *s, double h, double drift, double *k)
{
    struct implicit_work *w = s->work;
    int size = s->model->coordinate_count, low = stepper_first_index(s),
        high = stepper_end_index(s), count = high - low;
    size_t row = (size_t)low * MODEL_ROW_LENGTH;
    double *r = w->stage_sum; /* right-hand side of the stage: r_p and r_v */
    for (int half = 0; half < 2; half++) {
        for (int i = half * size + low; i < half * size + high; i++)
            r[i] += w->rate[i];
    }
    for (int i = low; drift != 0.0 && i < high; i++)
        r[size + i] += drift * h * w->dr_dt[i];
    banded_multiply(count, w->dr_dp + row, r + low, w->rhs + low);
    banded_multiply(count, w->mass + row, r + size + low, k + size + low);
    for (int i = low; i < high; i++)
        k[size + i] += h * GAMMA * w->rhs[i];
    banded_solve(count, w->lu + (size_t)low * BANDED_ROW_LENGTH, w->pivot + low, k + size + low);
    for (int i = low; i < high; i++)
        k[i] = h * GAMMA * (r[i] + k[size + i]);
}

static bool factor_step_matrix(struct stepper *s)
{
    struct implicit_work *w = s->work;
    int size = s->model->coordinate_count, low = stepper_first_index(s),
        count = stepper_end_index(s) - low;
    stepper_rates(s, s->t_s, s->z, w->rate);
    model_linearise(s->model, s->t_s, s->z, w->rate + size, w->mass, w->dr_dp, w->dr_dv, w->dr_dt);
    bool drifts_at_all = false;
    for (int i = low; i < low + count; i++)
        drifts_at_all = drifts_at_all || w->dr_dt[i] != 0.0;
    if (drifts_at_all) {
        size_t row = (size_t)low * MODEL_ROW_LENGTH;
        banded_combine(count, 1.0, w->mass + row, 0.0, w->dr_dp + row, 0.0, w->dr_dv + row,
                       w->mass_lu + (size_t)low * BANDED_ROW_LENGTH);
        if (!banded_factor(count, w->mass_lu + (size_t)low * BANDED_ROW_LENGTH,
                           w->mass_pivot + low))
            return false;
        banded_solve(count, w->mass_lu + (size_t)low * BANDED_ROW_LENGTH, w->mass_pivot + low,
                     w->dr_dt + low);
    }
    return true;
}

/* Computes the six stages of a step h. The last stage is the error estimate. Returns false if the
 * matrix is singular. */
static bool solve_stages(struct stepper *s, double h)
{
    struct implicit_work *w = s->work;
    int low = stepper_first_index(s), count = stepper_end_index(s) - low;
    size_t row = (size_t)low * MODEL_ROW_LENGTH;
    banded_combine(count, 1.0 / (h * GAMMA), w->mass + row, -h * GAMMA, w->dr_dp + row, -1.0,
                   w->dr_dv + row, w->lu + (size_t)low * BANDED_ROW_LENGTH);
    if (!banded_factor(count, w->lu + (size_t)low * BANDED_ROW_LENGTH, w->pivot + low))
        return false;
    double *first = w->rate, *kept = w->stage_state;
    for (int i = 0; i < STAGE_COUNT; i++) {
        add_weighted_stages(s, stage_sum_weights[i], i, 1.0 / h, NULL, w->stage_sum);
        if (i > 0) {
            add_weighted_stages(s, stage_state_weights[i], i, 1.0, s->z, kept);
            /* w->k[i] is free until the stage is solved, so it can hold the rates */
            w->rate = w->k[i];
            stepper_rates(s, s->t_s + stage_nodes[i] * h, kept, w->rate);
        }
        solve_stage(s, h, time_derivative_factors[i], w->k[i]);
        w->rate = first;
    }
    static const double one[STAGE_COUNT] = {0, 0, 0, 0, 0, 1};
    double *last = w->stage_sum; /* the solution is the state at the last stage plus the last k */
    add_weighted_stages(s, one, STAGE_COUNT, 1.0, kept, last);
    stepper_copy(s, last, s->z_new);
    return true;
}

static double step_error(const struct stepper *s)
{
    const struct implicit_work *w = s->work;
    double most = 0.0;
    for (int half = 0; half < 2; half++) {
        double atol = half == 0 ? s->atol_ft : s->atol_ft_s;
        int start = half * s->model->coordinate_count;
        for (int k = start + stepper_first_index(s); k < start + stepper_end_index(s); k++) {
            double scale = atol + s->rtol * fmax(fabs(s->z[k]), fabs(s->z_new[k]));
            if (!(fabs(s->z_new[k]) < 1e300))
                return (double)NAN;
            most = fmax(most, fabs(w->k[STAGE_COUNT - 1][k]) / scale);
        }
    }
    return most;
}

static bool advance(struct stepper *s, double limit_s)
{
    struct implicit_work *w = s->work;
    bool rejected = false;
    w->has_end_rates = false;
    if (!factor_step_matrix(s))
        return false;
    for (;;) {
        double h;
        bool last;
        if (!stepper_choose_step(s, limit_s, &h, &last))
            return false;
        double error = solve_stages(s, h) ? step_error(s) : (double)NAN;
        if (error <= 1.0) {
            double grow = error > 0.0 ? 0.9 * elementary_pow(error, -0.25) : 6.0;
            stepper_accept(s, h, last ? limit_s : s->t_s + h, last,
                           fmin(rejected ? 1.0 : 6.0, fmax(0.2, grow)));
            return true;
        }
        rejected = true;
        stepper_reject(s,
                       h * (isfinite(error) ? fmax(0.2, 0.9 * elementary_pow(error, -0.25)) : 0.2));
    }
}

/* Interpolates with the cubic through both ends of the step and the rates there. The method's own
 * interpolant is not used: its slopes at the ends have errors of tolerance / step, which would
 * cause false switches. */
static void interpolate(struct stepper *s, double t_s, int low, int high, double *z)
{
    struct implicit_work *w = s->work;
    if (!w->has_end_rates) {
        stepper_rates(s, s->t_new_s, s->z_new, w->stage_state);
        w->has_end_rates = true;
    }
    stepper_interpolate_cubic(s, s->z, w->rate, s->z_new, w->stage_state, t_s, low, high, z);
}

const struct stepper_kind stepper_implicit = {
    .name = "implicit",
    .can_omit_mats = true,
    .has_long_steps = true,
    .rtol = 1e-7,
    .description = "RODAS, linearly implicit of order 4(3), banded, every event located",
    .work_bytes = sizeof(struct implicit_work),
    .row_count = STAGE_COUNT + 3,
    .extra_value_rows = 3 * MODEL_ROW_LENGTH + 2 * BANDED_ROW_LENGTH + 4,
    .make = make,
    .restart = restart,
    .advance = advance,
    .interpolate = interpolate,
};
