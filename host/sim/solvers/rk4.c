/* rk4: the classical Runge-Kutta method with a fixed step. Switches are sampled; a mat whose speed
 * changes sign within a step is brought to rest at its end (pass.c). As a check of the other
 * solvers: another method on the model's own right-hand side. */

#include "host/sim/solvers/stepper.h"

struct work {
    double *k[5]; /* four stages and the rates at the end */
    double *at;
};

static void restart(struct stepper *s)
{
    (void)s;
}

static void shift(const struct stepper *s, double h, const double *rate, double *to)
{
    for (int half = 0; half < 2; half++) {
        int from = half * s->model->size;
        for (int k = from + stepper_low(s); k < from + stepper_high(s); k++)
            to[k] = s->z[k] + h * rate[k];
    }
}

static bool advance(struct stepper *s, double limit_s)
{
    struct work *w = s->work;
    double h = s->dt_s;
    bool last = s->t_s + h * (1.0 + 1e-9) >= limit_s;
    if (last)
        h = limit_s - s->t_s;
    stepper_rates(s, s->t_s, s->z, w->k[0]);
    shift(s, 0.5 * h, w->k[0], w->at);
    stepper_rates(s, s->t_s + 0.5 * h, w->at, w->k[1]);
    shift(s, 0.5 * h, w->k[1], w->at);
    stepper_rates(s, s->t_s + 0.5 * h, w->at, w->k[2]);
    shift(s, h, w->k[2], w->at);
    stepper_rates(s, s->t_s + h, w->at, w->k[3]);
    for (int half = 0; half < 2; half++) {
        int from = half * s->model->size;
        for (int k = from + stepper_low(s); k < from + stepper_high(s); k++)
            s->z_new[k] = s->z[k] +
                          h / 6.0 * (w->k[0][k] + 2.0 * (w->k[1][k] + w->k[2][k]) + w->k[3][k]);
    }
    s->t_new_s = last ? limit_s : s->t_s + h;
    return true;
}

static void dense(struct stepper *s, double t_s, int low, int high, double *z)
{
    struct work *w = s->work;
    stepper_rates(s, s->t_new_s, s->z_new, w->k[4]);
    stepper_cubic(s, s->z, w->k[0], s->z_new, w->k[4], t_s, low, high, z);
}

const struct stepper_kind stepper_rk4 = {
    .name = "rk4",
    .samples = true,
    .fixed = true,
    .method = "classical Runge-Kutta, fixed step, switches sampled",
    .work_bytes = sizeof(struct work),
    .rows = 6,
    .restart = restart,
    .advance = advance,
    .dense = dense,
};
