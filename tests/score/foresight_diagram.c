#include <math.h>

#include "host/base/plot.h"
#include "host/base/statistics.h"
#include "tests/score/foresight.h"

#define SHOWN 3u
#define APART 0.014 /* intervals beside each other */

static const char *const names[SHOWN] = {"advise, before touchdown", "board",
                                         "all facts in one rule"};

/* Predicted against observed, with its interval (95 %, Wilson). */
static void draw_points(struct plot *plot, const struct foresight_moment *moment, unsigned by)
{
    struct stats_held held;
    stats_held(moment->by[by], moment->event, moment->count, &held);
    struct plot_series series = {.kind = PLOT_POINTS, .key = names[by], .colour = by, .shape = by};
    for (unsigned b = 0; b < STATS_BINS; b++) {
        struct wilson interval = wilson_of(held.events[b], held.count[b]);
        const double at = held.said[b] + APART * ((double)by - 1.0), x[2] = {at, at},
                     ends[2] = {interval.low, interval.high}, seen = held.seen[b];
        if (!held.count[b])
            continue;
        plot_draw(plot, &(struct plot_series){
                            .kind = PLOT_LINE, .colour = by, .x = x, .y = ends, .count = 2});
        series.x = x;
        series.y = &seen;
        series.count = 1;
        plot_draw(plot, &series);
        series.key = NULL;
    }
}

enum mr_status foresight_draw(const char *path, const struct foresight_row *row,
                              const struct foresight_moment *moment, struct error *error)
{
    struct plot *plot = plot_new(row->text, 320 * WHENS, 380, WHENS);
    for (unsigned w = 0; w < WHENS; w++) {
        char text[80];
        snprintf(text, sizeof text, "%s: %zu landings, %zu events", foresight_when_names[w],
                 moment[w].count, moment[w].events);
        plot_panel(plot, text, (struct plot_axis){"predicted", 0.0, 1.0, false},
                   (struct plot_axis){"observed", 0.0, 1.0, false});
        plot_draw(plot, &(struct plot_series){.kind = PLOT_LINE,
                                              .colour = PLOT_GREY,
                                              .dashed = true,
                                              .x = (double[]){0.0, 1.0},
                                              .y = (double[]){0.0, 1.0},
                                              .count = 2});
        for (unsigned by = 0; by < SHOWN; by++)
            draw_points(plot, &moment[w], by);
    }
    return plot_write(plot, path, error);
}
