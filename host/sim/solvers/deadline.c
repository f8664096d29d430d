#include "host/sim/solvers/deadline.h"

#include "host/base/monotonic_clock.h"

static double clock_s(const struct sim_options *options)
{
    return options->clock_s ? options->clock_s(options->clock_ctx) : monotonic_s();
}

static bool in_time(void *ctx, int pass, double part)
{
    struct deadline *w = ctx;
    if (clock_s(w->asked) >= w->until_s) {
        w->late = true;
        return false;
    }
    return !w->asked->go_on || w->asked->go_on(w->asked->go_on_ctx, pass, part);
}

void deadline_begin(struct deadline *w, const struct sim_options *asked, double limit_s)
{
    *w = (struct deadline){.asked = asked, .options = *asked};
    if (limit_s <= 0.0)
        return;
    w->until_s = clock_s(asked) + limit_s;
    w->options.go_on = in_time;
    w->options.go_on_ctx = w;
}
