#include "host/sim/solvers/stepper.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
const struct stepper_kind *stepper_find(const char *name)
{
    static const struct stepper_kind *const kinds[] = {
        &stepper_event, &stepper_implicit, &stepper_cvode, &stepper_rk4,
        &stepper_rkgs,  &stepper_hamming,  &stepper_moreau};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (kinds[i] && strcmp(kinds[i]->name, name) == 0)
            return kinds[i];
    }
    return NULL;
}

void stepper_make(struct stepper *s)
{
    size_t size = (size_t)s->model->coordinate_count;
    s->work = xcalloc(1, s->kind->work_bytes);
    s->storage = xcalloc((2 * s->kind->row_count + s->kind->extra_value_rows) * size,
                         sizeof *s->storage);
    for (size_t i = 0; i < s->kind->row_count; i++) {
        double *row = s->storage + 2 * i * size;
        memcpy((char *)s->work + i * sizeof row, &row, sizeof row);
    }
    double *more = s->storage + 2 * s->kind->row_count * size;
    if (s->kind->make)
        s->kind->make(s, more);
}

void stepper_free(struct stepper *s)
{
    if (s->work && s->kind->free)
        s->kind->free(s);
    free(s->work);
    free(s->storage);
    s->work = s->storage = NULL;
}

bool stepper_choose_step(const struct stepper *s, double limit_s, double *h_s, bool *last)
{
    *last = s->t_s + 1.01 * s->h_s >= limit_s;
    *h_s = *last ? limit_s - s->t_s : s->h_s;
    return s->h_s >= s->min_step_s;
}

bool stepper_end_at_reversal(const struct stepper *s, const double *rate, double *h_s)
{
    const struct model *m = s->model;
    const double veps = m->veps_ft_s, edge = s->kind->reversal_speed_veps * veps;
    double h = *h_s;
    if (m->friction_law != SIM_FRICTION_TANH || !(edge > 0.0))
        return false;
    for (int k = m->coordinate_count + stepper_first_index(s) + 1;
         k < m->coordinate_count + stepper_end_index(s); k += 2) {
        /* assume the sign with which the speed increases */
        double a = fabs(rate[k]), v = rate[k] < 0.0 ? -s->z[k] : s->z[k];
        if (a * h < veps || v > edge || v + a * h < -edge)
            continue;
        /* do not end the step at an edge that is so near that the step would be too short */
        double to_s = (v < -1.25 * edge ? -edge - v : edge) / a;
        if (to_s < h && to_s > s->min_step_s)
            h = to_s;
    }
    bool cut = h < *h_s;
    *h_s = h;
    return cut;
}

void stepper_accept(struct stepper *s, double h_s, double t_new_s, bool last, double grow)
{
    if (!last || h_s * grow < s->h_s)
        s->h_s = h_s * grow;
    s->t_new_s = t_new_s;
}

void stepper_reject(struct stepper *s, double next_s)
{
    s->rejected_steps++;
    s->h_s = next_s;
}

double stepper_doubling_error(const struct stepper *s, const double *whole)
{
    double most = 0.0;
    for (int half = 0; half < 2; half++) {
        double atol = half == 0 ? s->atol_ft : s->atol_ft_s;
        int from = half * s->model->coordinate_count;
        for (int k = from + stepper_first_index(s); k < from + stepper_end_index(s); k++) {
            double scale = atol + s->rtol * fmax(fabs(s->z[k]), fabs(s->z_new[k]));
            if (!(fabs(s->z_new[k]) < 1e300) || !(fabs(whole[k]) < 1e300))
                return (double)NAN;
            most = fmax(most, fabs(s->z_new[k] - whole[k]) / (15.0 * scale));
        }
    }
    return most;
}

void stepper_copy(const struct stepper *s, const double *from, double *to)
{
    int low = stepper_first_index(s), high = stepper_end_index(s);
    for (int half = 0; half <= s->model->coordinate_count; half += s->model->coordinate_count)
        memcpy(to + half + low, from + half + low, (size_t)(high - low) * sizeof *to);
}

void stepper_rates(struct stepper *s, double t_s, const double *z, double *rate)
{
    int size = s->model->coordinate_count, low = stepper_first_index(s),
        high = stepper_end_index(s);
    if (s->kind->samples_switches)
        model_sample_modes(s->model, t_s, z);
    else if (s->kind->samples_shape_switches)
        model_sample_shape_modes(s->model, z);
    memcpy(rate + low, z + size + low, (size_t)(high - low) * sizeof *rate);
    model_rates(s->model, t_s, z, rate + size);
}

void stepper_interpolate_cubic(const struct stepper *s, const double *z0, const double *rate0,
                               const double *z1, const double *rate1, double t_s, int low, int high,
                               double *z)
{
    double h = s->t_new_s - s->t_s, x = (t_s - s->t_s) / h;
    double a = x * x * (3.0 - 2.0 * x), b = x * (1.0 - x) * (1.0 - x), c = -x * x * (1.0 - x);
    for (int half = 0; half < 2; half++) {
        for (int k = half * s->model->coordinate_count + low;
             k < half * s->model->coordinate_count + high; k++)
            z[k] = z0[k] + a * (z1[k] - z0[k]) + h * (b * rate0[k] + c * rate1[k]);
    }
}

void stepper_interpolate_last_step(struct stepper *s, double *rate0, double *rate1, double t_s,
                                   int low, int high, double *z)
{
    stepper_rates(s, s->t_s, s->z, rate0);
    stepper_rates(s, s->t_new_s, s->z_new, rate1);
    stepper_interpolate_cubic(s, s->z, rate0, s->z_new, rate1, t_s, low, high, z);
}
