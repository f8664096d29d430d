#include <math.h>
#include <string.h>

#include "host/sim/solvers/stepper.h"

#define FOR_STATE_VALUES(s, k)                                                      \
    for (int half_ = 0; half_ < 2; half_++)                                         \
        for (int k = half_ * (s)->model->coordinate_count + stepper_first_index(s); \
             k < half_ * (s)->model->coordinate_count + stepper_end_index(s); k++)

/* Computes one step of the classical method from y, with rates f, to z_new. k3: memory for the
 * other stages. `at`: memory for a state. */
static void runge_kutta_step(struct stepper *s, double h, const double *y, const double *f,
                             double *const k3[3], double *at)
{
    static const double part[3] = {0.5, 0.5, 1.0};
    for (int i = 0; i < 3; i++) {
        const double *rate = i == 0 ? f : k3[i - 1];
        FOR_STATE_VALUES(s, k) at[k] = y[k] + part[i] * h * rate[k];
        stepper_rates(s, s->t_s + part[i] * h, at, k3[i]);
    }
    FOR_STATE_VALUES(s, k)
    s->z_new[k] = y[k] + h / 6.0 * (f[k] + 2.0 * (k3[0][k] + k3[1][k]) + k3[2][k]);
}

/* ---- rk4 ---- */

/* rk4: the classical Runge-Kutta method with a fixed step. Switches (changes of mode) are sampled,
 * not located in time. A mat whose speed changes sign within a step is brought to rest at the end
 * of the step (pass.c). rk4 is a check of the other solvers with another method; the right-hand
 * side is the same. */

struct rk4_work {
    double *k[5]; /* four stages, and the rates at the end */
    double *stage_state;
};

static void rk4_restart(struct stepper *s)
{
    (void)s;
}

static bool rk4_advance(struct stepper *s, double limit_s)
{
    struct rk4_work *w = s->work;
    double h = s->dt_s;
    bool last = s->t_s + h * (1.0 + 1e-9) >= limit_s;
    if (last)
        h = limit_s - s->t_s;
    stepper_rates(s, s->t_s, s->z, w->k[0]);
    runge_kutta_step(s, h, s->z, w->k[0], w->k + 1, w->stage_state);
    s->t_new_s = last ? limit_s : s->t_s + h;
    return true;
}

static void rk4_interpolate(struct stepper *s, double t_s, int low, int high, double *z)
{
    struct rk4_work *w = s->work;
    stepper_rates(s, s->t_new_s, s->z_new, w->k[4]);
    stepper_interpolate_cubic(s, s->z, w->k[0], s->z_new, w->k[4], t_s, low, high, z);
}

const struct stepper_kind stepper_rk4 = {
    .name = "rk4",
    .samples_switches = true,
    .has_fixed_step = true,
    .description = "classical Runge-Kutta, fixed step, events sampled",
    .work_bytes = sizeof(struct rk4_work),
    .row_count = 6,
    .restart = rk4_restart,
    .advance = rk4_advance,
    .interpolate = rk4_interpolate,
};

/* ---- rkgs ---- */

/* rkgs: the Runge-Kutta method in Gill's form with halving and doubling, as in IBM's Scientific
 * Subroutine Package (S. Gill, Proc. Cambridge Phil. Soc. 47, 1951; A. Ralston, H. S. Wilf,
 * Mathematical Methods for Digital Computers, 1960).
 *
 * A pair of steps is checked against one of double size. The test value is the largest
 * |difference|/15 over its tolerance. Above 1 the step is halved and the pair repeated; below 0.02
 * the step is doubled for the next pair. Each call of `advance` computes one pair. Gill's form
 * passes q, the rounding error of a step, on to the next step. Switches are sampled. */

#define RKGS_ROOT_HALF 0.70710678118654752440

static const double rkgs_gill_a[4] = {0.5, 1.0 - RKGS_ROOT_HALF, 1.0 + RKGS_ROOT_HALF, 1.0 / 6.0};
static const double rkgs_gill_b[4] = {2.0, 1.0, 1.0, 2.0};
static const double rkgs_gill_c[4] = {0.5, 1.0 - RKGS_ROOT_HALF, 1.0 + RKGS_ROOT_HALF, 0.5};
static const double rkgs_gill_time[4] = {0.0, 0.5, 0.5, 1.0};

struct rkgs_work {
    double *rate, *q, *q_start, *middle, *whole, *rate0, *rate1; /* 2 size values in each array */
};

static void rkgs_restart(struct stepper *s)
{
    struct rkgs_work *w = s->work;
    memset(w->q, 0, 2 * (size_t)s->model->coordinate_count * sizeof *w->q);
}

static void rkgs_gill(struct stepper *s, double t_s, double h, double *z)
{
    struct rkgs_work *w = s->work;
    for (int i = 0; i < 4; i++) {
        stepper_rates(s, t_s + rkgs_gill_time[i] * h, z, w->rate);
        FOR_STATE_VALUES(s, k)
        {
            double step = h * w->rate[k];
            double move = rkgs_gill_a[i] * (step - rkgs_gill_b[i] * w->q[k]);
            z[k] += move;
            w->q[k] += 3.0 * move - rkgs_gill_c[i] * step;
        }
    }
}

static bool rkgs_advance(struct stepper *s, double limit_s)
{
    struct rkgs_work *w = s->work;
    size_t bytes = 2 * (size_t)s->model->coordinate_count * sizeof *s->z;
    memcpy(w->q_start, w->q, bytes);
    for (;;) {
        double h = s->h_s; /* step size; a pair of steps ends at t + 2 h */
        bool last = s->t_s + 2.0 * h * (1.0 + 1e-9) >= limit_s;
        if (last)
            h = 0.5 * (limit_s - s->t_s);
        if (!(s->h_s >= s->min_step_s))
            return false;
        memcpy(w->whole, s->z, bytes);
        rkgs_gill(s, s->t_s, 2.0 * h, w->whole);
        memcpy(w->q, w->q_start, bytes);
        memcpy(s->z_new, s->z, bytes);
        rkgs_gill(s, s->t_s, h, s->z_new);
        rkgs_gill(s, s->t_s + h, h, s->z_new);
        double test = stepper_doubling_error(s, w->whole);
        if (test <= 1.0) {
            if (test < 0.02 && !last)
                s->h_s *= 2.0;
            s->t_new_s = last ? limit_s : s->t_s + 2.0 * h;
            return true;
        }
        stepper_reject(s, 0.5 * h);
        memcpy(w->q, w->q_start, bytes);
    }
}

static void rkgs_interpolate(struct stepper *s, double t_s, int low, int high, double *z)
{
    struct rkgs_work *w = s->work;
    stepper_interpolate_last_step(s, w->rate0, w->rate1, t_s, low, high, z);
}

const struct stepper_kind stepper_rkgs = {
    .name = "rkgs",
    .samples_switches = true,
    .rtol = 1e-6,
    .description = "Runge-Kutta-Gill with step halving and doubling, events sampled",
    .work_bytes = sizeof(struct rkgs_work),
    .row_count = 7,
    .restart = rkgs_restart,
    .advance = rkgs_advance,
    .interpolate = rkgs_interpolate,
};

/* ---- hamming ---- */

/* hamming: Hamming's modified predictor-corrector (R. W. Hamming, J. ACM 6, 1959) with halving and
 * doubling:
 *
 *     P = y[-3] + 4h/3 (2 f[0] - f[-1] + 2 f[-2])
 *     M = P - 112/121 (P - C of the last step)
 *     C = (9 y[0] - y[-2])/8 + 3h/8 (f(M) + 2 f[0] - f[-1])
 *     y = C + 9/121 (P - C)
 *
 * The test value is the largest 9/121 |P - C| over its tolerance. Above 1 the step is halved, below
 * 0.02 doubled. The classical Runge-Kutta method computes the first three values, also after each
 * change of the step. (The original library interpolates after halving.) Switches are sampled. */

/* Number of points that are kept: enough to continue with a step of double size. */
#define HAMMING_POINTS 7

struct hamming_work {
    double *y[HAMMING_POINTS],
        /* [0] is the present point, [1] the previous one, ...; 2 size values each */
        *f[HAMMING_POINTS];
    double *difference; /* P - C of the last step */
    double *predicted, *modified, *rate, *k[3];
    int known_point_count; /* number of equidistant points in y and f */
    int equal_step_count;  /* number of steps since the step size changed */
    bool has_difference;
    double h_s; /* step between the points */
};

static void hamming_restart(struct stepper *s)
{
    struct hamming_work *w = s->work;
    w->known_point_count = 0;
    w->has_difference = false;
}

/* Shifts the points by one, so that the present point can be overwritten. */
static void hamming_rotate(struct hamming_work *w)
{
    double *y = w->y[HAMMING_POINTS - 1], *f = w->f[HAMMING_POINTS - 1];
    for (int i = HAMMING_POINTS - 1; i > 0; i--) {
        w->y[i] = w->y[i - 1];
        w->f[i] = w->f[i - 1];
    }
    w->y[0] = y;
    w->f[0] = f;
    w->known_point_count = w->known_point_count < HAMMING_POINTS ? w->known_point_count + 1
                                                                 : HAMMING_POINTS;
}

static void hamming_runge_kutta(struct stepper *s, double h)
{
    struct hamming_work *w = s->work;
    runge_kutta_step(s, h, w->y[0], w->f[0], w->k, w->modified);
}

/* Computes one step of Hamming's method to z_new. Returns its test value. */
static double hamming_predict_correct(struct stepper *s, double h)
{
    struct hamming_work *w = s->work;
    double *const *y = w->y, *const *f = w->f;
    double most = 0.0;
    FOR_STATE_VALUES(s, k)
    {
        w->predicted[k] = y[3][k] + 4.0 * h / 3.0 * (2.0 * f[0][k] - f[1][k] + 2.0 * f[2][k]);
        w->modified[k] = w->predicted[k] -
                         (w->has_difference ? 112.0 / 121.0 * w->difference[k] : 0.0);
    }
    stepper_rates(s, s->t_s + h, w->modified, w->rate);
    for (int half = 0; half < 2; half++) {
        double atol = half == 0 ? s->atol_ft : s->atol_ft_s;
        for (int k = half * s->model->coordinate_count + stepper_first_index(s);
             k < half * s->model->coordinate_count + stepper_end_index(s); k++) {
            double c = 0.125 * (9.0 * y[0][k] - y[2][k]) +
                       0.375 * h * (w->rate[k] + 2.0 * f[0][k] - f[1][k]);
            /* P - C, which becomes `difference` if the step is accepted */
            w->rate[k] = w->predicted[k] - c;
            s->z_new[k] = c + 9.0 / 121.0 * w->rate[k];
            if (!(fabs(s->z_new[k]) < 1e300))
                return (double)NAN;
            double scale = atol + s->rtol * fmax(fabs(y[0][k]), fabs(s->z_new[k]));
            most = fmax(most, 9.0 / 121.0 * fabs(w->rate[k]) / scale);
        }
    }
    return most;
}

/* Error of a starting step, by comparison with two steps of half the size. Leaves the better result
 * in z_new. */
static double hamming_start_step(struct stepper *s, double h)
{
    struct hamming_work *w = s->work;
    hamming_runge_kutta(s, h);
    memcpy(w->predicted, s->z_new, 2 * (size_t)s->model->coordinate_count * sizeof *s->z);
    hamming_runge_kutta(s, 0.5 * h);
    double *y = w->y[0], *f = w->f[0], start = s->t_s;
    w->y[0] = w->difference; /* holds the middle point until the end of this function */
    w->f[0] = w->rate;
    memcpy(w->difference, s->z_new, 2 * (size_t)s->model->coordinate_count * sizeof *s->z);
    s->t_s = start + 0.5 * h;
    stepper_rates(s, s->t_s, w->difference, w->rate);
    hamming_runge_kutta(s, 0.5 * h);
    s->t_s = start;
    w->y[0] = y;
    w->f[0] = f;
    w->has_difference = false;
    return stepper_doubling_error(s, w->predicted);
}

static bool hamming_advance(struct stepper *s, double limit_s)
{
    struct hamming_work *w = s->work;
    size_t bytes = 2 * (size_t)s->model->coordinate_count * sizeof *s->z;
    hamming_rotate(w);
    memcpy(w->y[0], s->z, bytes);
    stepper_rates(s, s->t_s, s->z, w->f[0]);
    for (;;) {
        double h = s->h_s;
        bool last = s->t_s + h * (1.0 + 1e-9) >= limit_s;
        if (last)
            h = limit_s - s->t_s;
        if (!(s->h_s >= s->min_step_s))
            return false;
        if (w->known_point_count > 1 &&
            h != w->h_s) { /* a new step size requires new starting values */
            w->known_point_count = 1;
            w->has_difference = false;
        }
        w->h_s = h;
        bool started = w->known_point_count >= 4;
        double test = started ? hamming_predict_correct(s, h) : hamming_start_step(s, h);
        if (test <= 1.0) {
            w->equal_step_count++;
            if (started) {
                memcpy(w->difference, w->rate, bytes);
                w->has_difference = true;
                if (test < 0.02 && w->equal_step_count > 6) {
                    s->h_s *= 2.0;
                    w->equal_step_count = 0;
                    if (w->known_point_count >= HAMMING_POINTS) {
                        /* keep every second of the last 8 points (the new one is the 8th): 8, 6, 4,
                         * 2 */
                        double *y[HAMMING_POINTS], *f[HAMMING_POINTS];
                        static const int order[HAMMING_POINTS] = {1, 3, 5, 0, 2, 4, 6};
                        for (int i = 0; i < HAMMING_POINTS; i++) {
                            y[i] = w->y[order[i]];
                            f[i] = w->f[order[i]];
                        }
                        memcpy(w->y, y, sizeof y);
                        memcpy(w->f, f, sizeof f);
                        w->known_point_count = 3;
                        w->h_s = s->h_s;
                        w->has_difference = false;
                    }
                }
            }
            s->t_new_s = last ? limit_s : s->t_s + h;
            return true;
        }
        stepper_reject(s, 0.5 * h);
        w->equal_step_count = 0;
    }
}

static void hamming_interpolate(struct stepper *s, double t_s, int low, int high, double *z)
{
    struct hamming_work *w = s->work;
    stepper_interpolate_last_step(s, w->k[0], w->k[1], t_s, low, high, z);
}

const struct stepper_kind stepper_hamming = {
    .name = "hamming",
    .samples_switches = true,
    .rtol = 1e-6,
    .description = "Hamming's predictor-corrector with step halving and doubling, events sampled",
    .work_bytes = sizeof(struct hamming_work),
    .row_count = 2 * HAMMING_POINTS + 7,
    .restart = hamming_restart,
    .advance = hamming_advance,
    .interpolate = hamming_interpolate,
};
