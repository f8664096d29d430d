#include "host/sim/solvers/stepper.h"

#include <string.h>

const struct stepper_kind *stepper_find(const char *name)
{
    static const struct stepper_kind *const kinds[] = {&stepper_event, &stepper_implicit, &stepper_cvode,
                                                       &stepper_rk4,   &stepper_rkgs,     &stepper_hamming};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (kinds[i] && strcmp(kinds[i]->name, name) == 0)
            return kinds[i];
    }
    return NULL;
}

bool stepper_try(const struct stepper *s, double limit_s, double *h_s, bool *last)
{
    *last = s->t_s + 1.01 * s->h_s >= limit_s;
    *h_s = *last ? limit_s - s->t_s : s->h_s;
    return s->h_s >= s->least_s;
}

void stepper_copy(const struct stepper *s, const double *from, double *to)
{
    int low = stepper_low(s), high = stepper_high(s);
    for (int half = 0; half <= s->model->size; half += s->model->size)
        memcpy(to + half + low, from + half + low, (size_t)(high - low) * sizeof *to);
}

void stepper_rates(struct stepper *s, double t_s, const double *z, double *rate)
{
    int size = s->model->size, low = stepper_low(s), high = stepper_high(s);
    if (s->kind->samples)
        model_sample(s->model, t_s, z);
    else if (s->kind->samples_shape)
        model_sample_shape(s->model, z);
    memcpy(rate + low, z + size + low, (size_t)(high - low) * sizeof *rate);
    model_rates(s->model, t_s, z, rate + size);
}

void stepper_cubic(const struct stepper *s, const double *z0, const double *rate0, const double *z1, const double *rate1,
                   double t_s, int low, int high, double *z)
{
    double h = s->t_new_s - s->t_s, x = (t_s - s->t_s) / h;
    double a = x * x * (3.0 - 2.0 * x), b = x * (1.0 - x) * (1.0 - x), c = -x * x * (1.0 - x);
    for (int half = 0; half < 2; half++) {
        for (int k = half * s->model->size + low; k < half * s->model->size + high; k++)
            z[k] = z0[k] + a * (z1[k] - z0[k]) + h * (b * rate0[k] + c * rate1[k]);
    }
}
