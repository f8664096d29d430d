/* hamming: Hamming's modified predictor-corrector (R. W. Hamming, J. ACM 6, 1959) with halving and
 * doubling:
 *     P = y[-3] + 4h/3 (2 f[0] - f[-1] + 2 f[-2])
 *     M = P - 112/121 (P - C of the last step)
 *     C = (9 y[0] - y[-2])/8 + 3h/8 (f(M) + 2 f[0] - f[-1])
 *     y = C + 9/121 (P - C)
 * The test value is the largest of 9/121 |P - C| over its tolerance: above 1 the step is halved,
 * below 0.02 doubled. The three values that a start needs come from the classical Runge-Kutta
 * method, as does a start at a new step size (the library's own halving interpolates instead).
 * Switches are sampled. */
#include <math.h>
#include <string.h>

#include "host/sim/solvers/stepper.h"

#define PAST 7 /* points kept: enough to go on at double the step */

struct work {
    double *y[PAST], *f[PAST]; /* [0] the present point, then backwards; 2 size values each */
    double *apart;             /* P - C of the last step */
    double *predicted, *modified, *rate, *k[3];
    int known; /* points in y and f, equidistant */
    int at_h;  /* steps since the step size was changed */
    bool apart_known;
    double h_s; /* their distance */
};

static void restart(struct stepper *s)
{
    struct work *w = s->work;
    w->known = 0;
    w->apart_known = false;
}

/* Make room for a new present point. */
static void rotate(struct work *w)
{
    double *y = w->y[PAST - 1], *f = w->f[PAST - 1];
    for (int i = PAST - 1; i > 0; i--) {
        w->y[i] = w->y[i - 1];
        w->f[i] = w->f[i - 1];
    }
    w->y[0] = y;
    w->f[0] = f;
    w->known = w->known < PAST ? w->known + 1 : PAST;
}

#define FOR_STATE(s, k)                                         \
    for (int half_ = 0; half_ < 2; half_++)                     \
        for (int k = half_ * (s)->model->size + stepper_low(s); \
             k < half_ * (s)->model->size + stepper_high(s); k++)

/* One classical Runge-Kutta step from y[0], f[0] to z_new. */
static void runge_kutta(struct stepper *s, double h)
{
    struct work *w = s->work;
    const double *y = w->y[0], *f = w->f[0];
    FOR_STATE(s, k) w->modified[k] = y[k] + 0.5 * h * f[k];
    stepper_rates(s, s->t_s + 0.5 * h, w->modified, w->k[0]);
    FOR_STATE(s, k) w->modified[k] = y[k] + 0.5 * h * w->k[0][k];
    stepper_rates(s, s->t_s + 0.5 * h, w->modified, w->k[1]);
    FOR_STATE(s, k) w->modified[k] = y[k] + h * w->k[1][k];
    stepper_rates(s, s->t_s + h, w->modified, w->k[2]);
    FOR_STATE(s, k)
    s->z_new[k] = y[k] + h / 6.0 * (f[k] + 2.0 * (w->k[0][k] + w->k[1][k]) + w->k[2][k]);
}

/* One Hamming step to z_new; its test value. */
static double predict_correct(struct stepper *s, double h)
{
    struct work *w = s->work;
    double *const *y = w->y, *const *f = w->f;
    double most = 0.0;
    FOR_STATE(s, k)
    {
        w->predicted[k] = y[3][k] + 4.0 * h / 3.0 * (2.0 * f[0][k] - f[1][k] + 2.0 * f[2][k]);
        w->modified[k] = w->predicted[k] - (w->apart_known ? 112.0 / 121.0 * w->apart[k] : 0.0);
    }
    stepper_rates(s, s->t_s + h, w->modified, w->rate);
    for (int half = 0; half < 2; half++) {
        double atol = half == 0 ? s->atol_ft : s->atol_ft_s;
        for (int k = half * s->model->size + stepper_low(s);
             k < half * s->model->size + stepper_high(s); k++) {
            double c = 0.125 * (9.0 * y[0][k] - y[2][k]) +
                       0.375 * h * (w->rate[k] + 2.0 * f[0][k] - f[1][k]);
            w->rate[k] = w->predicted[k] - c; /* kept when the step is accepted */
            s->z_new[k] = c + 9.0 / 121.0 * w->rate[k];
            if (!(fabs(s->z_new[k]) < 1e300))
                return (double)NAN;
            double scale = atol + s->rtol * fmax(fabs(y[0][k]), fabs(s->z_new[k]));
            most = fmax(most, 9.0 / 121.0 * fabs(w->rate[k]) / scale);
        }
    }
    return most;
}

/* Error of a starting step: what two halves of it say. Leaves the better answer in z_new. */
static double start_step(struct stepper *s, double h)
{
    struct work *w = s->work;
    runge_kutta(s, h);
    memcpy(w->predicted, s->z_new, 2 * (size_t)s->model->size * sizeof *s->z);
    runge_kutta(s, 0.5 * h);
    double *y = w->y[0], *f = w->f[0], start = s->t_s;
    w->y[0] = w->apart; /* a detour: the middle */
    w->f[0] = w->rate;
    memcpy(w->apart, s->z_new, 2 * (size_t)s->model->size * sizeof *s->z);
    s->t_s = start + 0.5 * h;
    stepper_rates(s, s->t_s, w->apart, w->rate);
    runge_kutta(s, 0.5 * h);
    s->t_s = start;
    w->y[0] = y;
    w->f[0] = f;
    w->apart_known = false;
    return stepper_halves_error(s, w->predicted);
}

static bool advance(struct stepper *s, double limit_s)
{
    struct work *w = s->work;
    size_t bytes = 2 * (size_t)s->model->size * sizeof *s->z;
    rotate(w);
    memcpy(w->y[0], s->z, bytes);
    stepper_rates(s, s->t_s, s->z, w->f[0]);
    for (;;) {
        double h = s->h_s;
        bool last = s->t_s + h * (1.0 + 1e-9) >= limit_s;
        if (last)
            h = limit_s - s->t_s;
        if (!(s->h_s >= s->least_s))
            return false;
        if (w->known > 1 && h != w->h_s) { /* another step size: a new start */
            w->known = 1;
            w->apart_known = false;
        }
        w->h_s = h;
        bool started = w->known >= 4;
        double test = started ? predict_correct(s, h) : start_step(s, h);
        if (test <= 1.0) {
            w->at_h++;
            if (started) {
                memcpy(w->apart, w->rate, bytes);
                w->apart_known = true;
                if (test < 0.02 && w->at_h > 6) {
                    s->h_s *= 2.0;
                    w->at_h = 0;
                    if (w->known >= PAST) {
                        /* every other of 7 points, the new one being the 8th: 8, 6, 4, 2 */
                        double *y[PAST], *f[PAST];
                        static const int order[PAST] = {1, 3, 5, 0, 2, 4, 6};
                        for (int i = 0; i < PAST; i++) {
                            y[i] = w->y[order[i]];
                            f[i] = w->f[order[i]];
                        }
                        memcpy(w->y, y, sizeof y);
                        memcpy(w->f, f, sizeof f);
                        w->known = 3;
                        w->h_s = s->h_s;
                        w->apart_known = false;
                    }
                }
            }
            s->t_new_s = last ? limit_s : s->t_s + h;
            return true;
        }
        stepper_reject(s, 0.5 * h);
        w->at_h = 0;
    }
}

static void dense(struct stepper *s, double t_s, int low, int high, double *z)
{
    struct work *w = s->work;
    stepper_cubic_anew(s, w->k[0], w->k[1], t_s, low, high, z);
}

const struct stepper_kind stepper_hamming = {
    .name = "hamming",
    .samples = true,
    .rtol = 1e-6,
    .method = "Hamming's predictor-corrector with halving and doubling, switches sampled",
    .work_bytes = sizeof(struct work),
    .rows = 2 * PAST + 7,
    .restart = restart,
    .advance = advance,
    .dense = dense,
};
