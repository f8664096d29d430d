#include "host/sim/solvers/landing_engine.h"

/* What the gear loads slides and heaves from now on. The model carries no wheel of its own. */
static int span_of_rider(struct sim_wheel *wheel, double t0_s, double t1_s, struct sim_touch *touch)
{
    struct landing *l = wheel->rider;
    const struct model *m = &l->model;
    int count = gear_span(l->gear, t0_s, t1_s, touch);
    for (int i = 0; i < l->gear->loaded_count && l->scene->wheel_load_lb > 0.0; i++) {
        int n = l->gear->loaded[i] - 1;
        landing_take_in(&l->heaves, m, n - m->tail, n + m->tail);
    }
    return count;
}

void landing_mount(struct landing *l, struct sim_wheel *wheel, double h_s)
{
    gear_start(l->gear, wheel, h_s);
    l->model.wheel_load_lb = 0.0;
    sim_wheel_yield(wheel, span_of_rider, l);
}

void landing_load_heaves(struct landing *l)
{
    const struct gear *gear = l->gear;
    if (l->mods && (l->mods->banded || l->mods->stiffened)) {
        landing_brace_heaves(l);
    } else {
        for (int j = l->heaves.first; j <= l->heaves.last + 1; j++)
            l->brace_lb[j] = 0.0;
    }
    for (int i = 0; l->parting && i < l->parting->count; i++)
        l->parting->down_lb[l->parting->joint[i]] = 0.0;
    for (int i = 0; i < gear->loaded_count; i++) {
        int n = gear->loaded[i] - 1;
        double half_lb = 0.5 * l->scene->wheel_load_lb * gear->share[n + 1];
        bool apart = l->parting && l->parting->apart[n + 1];
        l->brace_lb[n] += half_lb;
        *(apart ? &l->parting->down_lb[n + 1] : &l->brace_lb[n + 1]) += half_lb;
    }
}
