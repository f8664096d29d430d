/* event at loose tolerances: Dormand and Prince's method of order 5 with embedded order 4 and dense
 * output of order 4, six evaluations a step (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary
 * Differential Equations I, II.5 and II.6). Where stability and not accuracy sets the step, half
 * the evaluations of the order 8 method give the same step. */
#include <math.h>

#include "host/sim/models/vector.h"
#include "host/sim/solvers/stepper.h"

#define STAGES 7 /* the last is the first of the next step */

static const double nodes[STAGES] = {0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0};
static const double stage[STAGES][STAGES - 1] = {
    [1] = {1.0 / 5.0},
    [2] = {3.0 / 40.0, 9.0 / 40.0},
    [3] = {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
    [4] = {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
    [5] = {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
    [6] = {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0},
};
static const double fourth[STAGES] = {
    71.0 / 57600.0,      0.0,          -71.0 / 16695.0, 71.0 / 1920.0,
    -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};
static const double dense_term[STAGES] = {
    -12715105075.0 / 11282082432.0,  0.0,
    87487479700.0 / 32700410799.0,   -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0};

struct work {
    double *rate[STAGES]; /* 2 size values each */
    double *at;           /* a stage's state */
    bool begun;           /* rate[6] belongs to the start of the next step */
    double error_before;  /* of the last accepted step */
    double h_s;           /* of the last step */
};

static void restart(struct stepper *s)
{
    struct work *w = s->work;
    w->begun = false;
    w->error_before = 1e-4;
}

VECTOR static void combine(const struct stepper *s, int i, double h, double *to)
{
    const struct work *w = s->work;
    const double *row = stage[i];
    double a[STAGES - 1];
    for (int j = 0; j < STAGES - 1; j++)
        a[j] = j < i ? h * row[j] : 0.0;
    for (int half = 0; half <= s->model->size; half += s->model->size) {
        int from = half + stepper_low(s), end = half + stepper_high(s);
        const double *z = s->z, *r0 = w->rate[0], *r1 = w->rate[1], *r2 = w->rate[2],
                     *r3 = w->rate[3], *r4 = w->rate[4], *r5 = w->rate[5];
        switch (i) {
        case 1:
            for (int k = from; k < end; k++)
                to[k] = z[k] + a[0] * r0[k];
            break;
        case 2:
            for (int k = from; k < end; k++)
                to[k] = z[k] + (a[0] * r0[k] + a[1] * r1[k]);
            break;
        case 3:
            for (int k = from; k < end; k++)
                to[k] = z[k] + (a[0] * r0[k] + a[1] * r1[k] + a[2] * r2[k]);
            break;
        case 4:
            for (int k = from; k < end; k++)
                to[k] = z[k] + (a[0] * r0[k] + a[1] * r1[k] + a[2] * r2[k] + a[3] * r3[k]);
            break;
        case 5:
            for (int k = from; k < end; k++)
                to[k] = z[k] +
                        (a[0] * r0[k] + a[1] * r1[k] + a[2] * r2[k] + a[3] * r3[k] + a[4] * r4[k]);
            break;
        default:
            for (int k = from; k < end; k++)
                to[k] = z[k] +
                        (a[0] * r0[k] + a[2] * r2[k] + a[3] * r3[k] + a[4] * r4[k] + a[5] * r5[k]);
            break;
        }
    }
}

/* Largest error over tolerance of a step that is in z_new. */
static double error_of(const struct stepper *s, double h)
{
    const struct work *w = s->work;
    double most = 0.0;
    for (int half = 0; half < 2; half++) {
        double atol = half == 0 ? s->atol_ft : s->atol_ft_s;
        int start = half * s->model->size;
        for (int k = start + stepper_low(s); k < start + stepper_high(s); k++) {
            double e = fourth[0] * w->rate[0][k] + fourth[2] * w->rate[2][k] +
                       fourth[3] * w->rate[3][k] + fourth[4] * w->rate[4][k] +
                       fourth[5] * w->rate[5][k] + fourth[6] * w->rate[6][k];
            double old = fabs(s->z[k]), new = fabs(s->z_new[k]);
            double part = fabs(e) / (atol + s->rtol * (old > new ? old : new));
            if (!(new < 1e300))
                return (double)NAN;
            most = part > most ? part : most;
        }
    }
    return h * most;
}

static bool advance(struct stepper *s, double limit_s)
{
    struct work *w = s->work;
    bool rejected = false;
    if (w->begun && s->t_s == s->t_new_s) {
        double *first = w->rate[0];
        w->rate[0] = w->rate[6];
        w->rate[6] = first;
    } else {
        stepper_rates(s, s->t_s, s->z, w->rate[0]);
    }
    for (;;) {
        double h;
        bool last;
        if (!stepper_try(s, limit_s, &h, &last))
            return false;
        bool turns = stepper_turns(s, w->rate[0], &h);
        last = last && !turns;
        for (int i = 1; i < STAGES; i++) {
            double *to = i < STAGES - 1 ? w->at : s->z_new;
            combine(s, i, h, to);
            stepper_rates(s, s->t_s + nodes[i] * h, to, w->rate[i]);
        }
        double error = error_of(s, h);
        if (error <= 1.0) {
            /* with some of the last error, the step settles where stability limits it instead of
             * failing there */
            double grow = error > 0.0 ? 0.9 * pow(error, -0.17) * pow(w->error_before, 0.04) : 6.0;
            w->error_before = fmax(error, 1e-4);
            stepper_accept(s, h, last ? limit_s : s->t_s + h, last || turns,
                           fmin(rejected ? 1.0 : 6.0, fmax(0.2, grow)));
            w->h_s = h;
            w->begun = true;
            s->rate = w->rate[0];
            s->rate_new = w->rate[6];
            return true;
        }
        rejected = true;
        stepper_reject(s, h * (isfinite(error) ? fmax(0.2, 0.9 * pow(error, -0.2)) : 0.2));
    }
}

VECTOR static void dense(struct stepper *s, double t_s, int low, int high, double *z)
{
    const struct work *w = s->work;
    double h = w->h_s, x = (t_s - s->t_s) / h, y = 1.0 - x;
    for (int half = 0; half <= s->model->size; half += s->model->size) {
        for (int k = half + low; k < half + high; k++) {
            double change = s->z_new[k] - s->z[k];
            double c2 = h * w->rate[0][k] - change, c3 = change - h * w->rate[6][k] - c2;
            double c4 = h * (dense_term[0] * w->rate[0][k] + dense_term[2] * w->rate[2][k] +
                             dense_term[3] * w->rate[3][k] + dense_term[4] * w->rate[4][k] +
                             dense_term[5] * w->rate[5][k] + dense_term[6] * w->rate[6][k]);
            z[k] = s->z[k] + x * (change + y * (c2 + x * (c3 + y * c4)));
        }
    }
}

const struct stepper_kind stepper_event5 = {
    .name = "event",
    .prunes = true,
    .long_steps = true,
    .turn_veps = 6.0,
    .rtol = 1e-5,
    .method = "Dormand-Prince 5(4), every switch located",
    .work_bytes = sizeof(struct work),
    .rows = STAGES + 1,
    .restart = restart,
    .advance = advance,
    .dense = dense,
};
