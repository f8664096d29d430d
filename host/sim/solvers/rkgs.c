/* rkgs: the Runge-Kutta method in Gill's form with halving and doubling, as IBM's Scientific
 * Subroutine Package ran it (S. Gill, Proc. Cambridge Phil. Soc. 47, 1951; A. Ralston, H. S. Wilf,
 * Mathematical Methods for Digital Computers, 1960). A pair of steps is checked against one of
 * double size: the test value is the largest of |difference|/15 over its tolerance. Above 1 the
 * step is halved and the pair done again; below 0.02 it is doubled for the next pair. One advance
 * here is such a pair. Gill's form carries q, the rounding of the last step. Switches are
 * sampled. */
#include <string.h>

#include "host/sim/solvers/stepper.h"

#define ROOT_HALF 0.70710678118654752440

static const double gill_a[4] = {0.5, 1.0 - ROOT_HALF, 1.0 + ROOT_HALF, 1.0 / 6.0};
static const double gill_b[4] = {2.0, 1.0, 1.0, 2.0};
static const double gill_c[4] = {0.5, 1.0 - ROOT_HALF, 1.0 + ROOT_HALF, 0.5};
static const double gill_time[4] = {0.0, 0.5, 0.5, 1.0};

struct work {
    double *rate, *q, *q_start, *middle, *whole, *rate0, *rate1; /* 2 size each */
};

static void restart(struct stepper *s)
{
    struct work *w = s->work;
    memset(w->q, 0, 2 * (size_t)s->model->size * sizeof *w->q);
}

static void gill(struct stepper *s, double t_s, double h, double *z)
{
    struct work *w = s->work;
    for (int i = 0; i < 4; i++) {
        stepper_rates(s, t_s + gill_time[i] * h, z, w->rate);
        for (int half = 0; half < 2; half++) {
            int from = half * s->model->size;
            for (int k = from + stepper_low(s); k < from + stepper_high(s); k++) {
                double step = h * w->rate[k];
                double move = gill_a[i] * (step - gill_b[i] * w->q[k]);
                z[k] += move;
                w->q[k] += 3.0 * move - gill_c[i] * step;
            }
        }
    }
}

static bool advance(struct stepper *s, double limit_s)
{
    struct work *w = s->work;
    size_t bytes = 2 * (size_t)s->model->size * sizeof *s->z;
    memcpy(w->q_start, w->q, bytes);
    for (;;) {
        double h = s->h_s; /* of one step; a pair goes to t + 2 h */
        bool last = s->t_s + 2.0 * h * (1.0 + 1e-9) >= limit_s;
        if (last)
            h = 0.5 * (limit_s - s->t_s);
        if (!(s->h_s >= s->least_s))
            return false;
        memcpy(w->whole, s->z, bytes);
        gill(s, s->t_s, 2.0 * h, w->whole);
        memcpy(w->q, w->q_start, bytes);
        memcpy(s->z_new, s->z, bytes);
        gill(s, s->t_s, h, s->z_new);
        gill(s, s->t_s + h, h, s->z_new);
        double test = stepper_halves_error(s, w->whole);
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

static void dense(struct stepper *s, double t_s, int low, int high, double *z)
{
    struct work *w = s->work;
    stepper_cubic_anew(s, w->rate0, w->rate1, t_s, low, high, z);
}

const struct stepper_kind stepper_rkgs = {
    .name = "rkgs",
    .samples = true,
    .rtol = 1e-6,
    .method = "Runge-Kutta-Gill with halving and doubling, switches sampled",
    .work_bytes = sizeof(struct work),
    .rows = 7,
    .restart = restart,
    .advance = advance,
    .dense = dense,
};
