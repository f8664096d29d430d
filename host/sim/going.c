#include "host/sim/going.h"

#include "host/base/monotonic_clock.h"

static double clock_s(const struct sim_going *g)
{
    return g->options->clock_s ? g->options->clock_s(g->options->clock_ctx) : monotonic_s();
}

void sim_going_begin(struct sim_going *g, const struct sim_options *options,
                     const struct sim_scene *scene)
{
    g->options = options;
    g->begin_s = clock_s(g);
    g->next_s = g->begin_s + SIM_GOING_S;
    g->end_s = sim_scene_end_s(scene);
}

bool sim_going_on(void *going, int pass, double part)
{
    struct sim_going *g = going;
    double now_s = clock_s(g);
    if (!g->to || now_s < g->next_s)
        return true;
    fprintf(g->to,
            "matrig: %s: goes on after %.0f s: run %d is at %.4g of %.4g s; an earlier tend, fewer "
            "mats or a looser rtol is quicker%s%s\n",
            g->who, now_s - g->begin_s, pass, part * g->end_s, g->end_s, *g->quicker ? "; " : "",
            g->quicker);
    g->next_s = now_s + SIM_GOING_S;
    return true;
}
