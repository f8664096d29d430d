/* Marching: classical Runge-Kutta with frozen regimes, cut at every switch by bisection. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/sim_reference/model.h"

#define SWITCHES_MOST 20000ul
#define FOLD_RAD      (85 * M_PI / 180)

struct state {
    double q[REF_COORDINATES], v[REF_COORDINATES];
};

static void weighted(int size, const struct state *from, double h, const double *dq,
                     const double *dv, struct state *to)
{
    for (int i = 0; i < size; i++) {
        to->q[i] = from->q[i] + h * dq[i];
        to->v[i] = from->v[i] + h * dv[i];
    }
}

static void rk4(const struct ref_scene *s, const struct ref_regime *regime,
                const struct ref_wheel *wheel, double t, double h, const struct state *from,
                struct state *to)
{
    static const double at[4] = {0, 0.5, 0.5, 1}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    double k[4][REF_COORDINATES], speed[4][REF_COORDINATES];
    int size = 2 * s->mats + 1;
    struct state stage = *from;
    for (int i = 0; i < 4; i++) {
        if (i > 0)
            weighted(size, from, at[i] * h, speed[i - 1], k[i - 1], &stage);
        ref_accelerations(s, regime, wheel, t + at[i] * h, stage.q, stage.v, k[i]);
        memcpy(speed[i], stage.v, (size_t)size * sizeof(double));
    }
    *to = *from;
    for (int i = 0; i < 4; i++)
        weighted(size, to, weight[i] * h, speed[i], k[i], to);
}

/* Whether the state is no longer what the regime says. */
static bool left(const struct ref_scene *s, const struct ref_regime *regime,
                 const struct ref_wheel *wheel, double t, const struct state *state)
{
    struct ref_regime now;
    ref_regime_of(s, wheel, t, state->q, state->v, &now);
    size_t nodes = (size_t)s->mats + 1;
    bool uses_apex = s->model == REF_REPORT && s->shear != REF_NONE;
    if (memcmp(now.contact, regime->contact, nodes) || memcmp(now.tad, regime->tad, nodes) ||
        memcmp(now.slack, regime->slack, nodes) || (uses_apex && now.apex != regime->apex) ||
        (s->model == REF_CONSISTENT && memcmp(now.pushes, regime->pushes, nodes)))
        return true;
    for (int n = 0; s->friction == REF_STICK && n < s->mats; n++) {
        double speed = state->v[ref_u(s, n)];
        if (regime->slip[n] == 0 ? now.slip[n] != 0 : speed * regime->slip[n] < 0)
            return true;
    }
    return false;
}

/* Stop the mats that turned round, then find out what holds from here on. */
static void settle(const struct ref_scene *s, struct ref_regime *regime,
                   const struct ref_wheel *wheel, double t, struct state *state)
{
    for (int n = 0; s->friction == REF_STICK && n < s->mats; n++) {
        double *speed = &state->v[ref_u(s, n)];
        if (*speed * regime->slip[n] < 0)
            *speed = 0;
    }
    ref_regime_of(s, wheel, t, state->q, state->v, regime);
}

struct ref_wheel ref_wheel_between(const struct ref_scene *s, double t0, double t1)
{
    double t = 0.5 * (t0 + t1), x = (s->s0 + s->Vac * t) / s->L;
    return (struct ref_wheel){(int)floor(x + 1e-12), (int)floor(x - 0.5), t < s->F_tstop};
}

/* Next time at which the wheel changes mat (or the pair it stands between), the thrust stops, or a
 * result is wanted. */
static double next_break(const struct ref_scene *s, double t)
{
    double next = s->tend;
    double least = t * (1 + 1e-13) + 1e-15;
    for (int i = 0; i < s->outputs; i++) {
        if (s->t_out[i] > least && s->t_out[i] < next)
            next = s->t_out[i];
    }
    if (s->F_tstop > least && s->F_tstop < next)
        next = s->F_tstop;
    for (int half = 0; s->Vac > 0 && half <= 2 * s->mats + 1; half++) {
        double hop = (0.5 * half * s->L - s->s0) / s->Vac;
        if (hop > least && hop < next)
            next = hop;
    }
    return next;
}

static double lift_of(const struct ref_scene *s, const struct state *state, int *node,
                      double *rising)
{
    double y[REF_NODES], rate[REF_NODES];
    ref_heights(s, state->q, state->v, y, rate);
    *node = 0;
    for (int j = 0; j <= s->mats; j++) {
        if (y[j] < y[*node])
            *node = j;
    }
    *rising = -rate[*node];
    return fmax(0, -y[*node]);
}

/* The largest lift within a step that a node begins rising and ends falling lies between them. */
static double top_of(double from_ft, double rising, double to_ft, double falling, double h)
{
    double ends = fmax(from_ft, to_ft);
    if (!(rising > 0 && falling < 0))
        return ends;
    return fmax(ends, from_ft + 0.5 * h * rising * rising / (rising - falling));
}

static void note(const struct ref_scene *s, double t, const struct state *state,
                 struct ref_run *run)
{
    for (int i = 0; i < s->outputs; i++) {
        if (fabs(s->t_out[i] - t) > 1e-13 * (1 + t))
            continue;
        struct ref_output *output = &run->output[i];
        double rising;
        output->t_s = t;
        output->lift_ft = lift_of(s, state, &output->lift_node, &rising);
        output->lift_node++;
        for (int n = 0; n < s->mats; n++)
            output->u_ft[n] = state->q[ref_u(s, n)];
    }
}

/* One piece of at most h with a single regime; returns its length. */
static double piece(const struct ref_scene *s, struct ref_regime *regime,
                    const struct ref_wheel *wheel, double t, double h, struct state *state,
                    struct ref_run *run)
{
    struct state next;
    rk4(s, regime, wheel, t, h, state, &next);
    if (left(s, regime, wheel, t + h, &next)) {
        double before = 0, after = h;
        while (after - before > 1e-16) {
            double middle = 0.5 * (before + after);
            if (middle == before || middle == after)
                break;
            rk4(s, regime, wheel, t, middle, state, &next);
            if (left(s, regime, wheel, t + middle, &next))
                after = middle;
            else
                before = middle;
        }
        h = after;
        rk4(s, regime, wheel, t, h, state, &next);
        settle(s, regime, wheel, t + h, &next);
        run->switches++;
    }
    *state = next;
    run->steps++;
    return h;
}

bool ref_march(const struct ref_scene *s, double h_s, struct ref_run *run)
{
    struct state state;
    struct ref_regime regime = {0};
    double th[REF_MATS], rate[REF_MATS], t = 0;
    double lift_ft, rising;
    int node;
    *run = (struct ref_run){0};
    ref_start(s, state.q, state.v);
    run->max_lift_ft = lift_ft = lift_of(s, &state, &node, &rising);
    note(s, t, &state, run);
    while (t < s->tend) {
        double t1 = next_break(s, t);
        struct ref_wheel wheel = ref_wheel_between(s, t, t1);
        settle(s, &regime, &wheel, t, &state);
        while (t < t1) {
            double h = fmin(h_s, t1 - t);
            double done = piece(s, &regime, &wheel, t, h, &state, run);
            t = t1 - t <= done ? t1 : t + done;
            double before_ft = lift_ft, rose = rising;
            int same = node;
            lift_ft = lift_of(s, &state, &node, &rising);
            double top_ft = node == same ? top_of(before_ft, rose, lift_ft, rising, done) : lift_ft;
            run->max_lift_ft = fmax(run->max_lift_ft, top_ft);
            ref_angles(s, state.q, state.v, th, rate);
            for (int n = 0; n < s->mats; n++) {
                if (!(fabs(th[n]) < FOLD_RAD)) {
                    fprintf(stderr, "reference: %s: mat %d folds at %.9g s\n", s->name, n + 1, t);
                    return false;
                }
            }
            if (run->switches > SWITCHES_MOST) {
                fprintf(stderr, "reference: %s: switches without end at %.9g s\n", s->name, t);
                return false;
            }
        }
        note(s, t, &state, run);
    }
    return true;
}
