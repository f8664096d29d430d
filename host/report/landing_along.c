/* How far tension fell and rose along each band. */
#include <math.h>
#include <stdio.h>

#include "host/report/chart.h"
#include "host/report/report.h"

#define BANDS_MAX 4u
#define HEIGHT    150.0

struct along {
    double station[MR_GAGES], fell[MR_GAGES], fell_error[MR_GAGES], rose[MR_GAGES],
        rose_error[MR_GAGES], after[MR_GAGES];
    size_t gages;
};

/* Gages of a band by rising station. */
static void collect(const struct measured *measured, unsigned band, bool si, struct along *along)
{
    double station = unit_of(UNIT_STATION, si)->factor, force = unit_of(UNIT_TENSION, si)->factor;
    along->gages = 0;
    for (unsigned number = 1; number <= MR_GAGES; number++) {
        int c = measured_find(measured, MR_KIND_TENSION, number);
        if (c < 0 || measured->channel[c].config.band != band ||
            isnan(measured->channel[c].baseline))
            continue;
        const struct measured_channel *channel = &measured->channel[c];
        size_t at = along->gages++;
        for (; at > 0 && along->station[at - 1] > station * (double)channel->config.station_ft;
             at--) {
            along->station[at] = along->station[at - 1];
            along->fell[at] = along->fell[at - 1];
            along->fell_error[at] = along->fell_error[at - 1];
            along->rose[at] = along->rose[at - 1];
            along->rose_error[at] = along->rose_error[at - 1];
            along->after[at] = along->after[at - 1];
        }
        along->station[at] = station * (double)channel->config.station_ft;
        along->fell[at] = force * (channel->low - channel->baseline);
        along->fell_error[at] = force * channel->low_error;
        along->rose[at] = force * (channel->high - channel->baseline);
        along->rose_error[at] = force * channel->high_error;
        along->after[at] = force * (channel->end - channel->baseline);
    }
}

static void draw_band(FILE *out, const struct along *along, size_t place, unsigned band, double low,
                      double high, bool si)
{
    struct chart_text x_label = chart_label("station", UNIT_STATION, si),
                      y_label = chart_label("change", UNIT_TENSION, si);
    struct svg_plot plot = chart_small(out, place, 26.0, HEIGHT);
    char name[20];
    plot.x = (struct svg_axis){0.0, CHART_RUNWAY_FT * unit_of(UNIT_STATION, si)->factor,
                               x_label.text, true};
    plot.y = (struct svg_axis){low, high, place ? NULL : y_label.text, place == 0};
    svg_axes(&plot);
    svg_line(&plot, "mark", (const double[]){plot.x.low, plot.x.high}, (const double[]){0.0, 0.0},
             2);
    chart_line(&plot, 0, along->station, along->fell, along->gages, 1);
    chart_line(&plot, 1, along->station, along->rose, along->gages, 1);
    chart_line(&plot, 2, along->station, along->after, along->gages, 1);
    for (size_t i = 0; i < along->gages; i++) {
        chart_whisker(&plot, "line s0", along->station[i],
                      along->fell[i] - SUMMARY_95 * along->fell_error[i],
                      along->fell[i] + SUMMARY_95 * along->fell_error[i]);
        chart_whisker(&plot, "line s1", along->station[i],
                      along->rose[i] - SUMMARY_95 * along->rose_error[i],
                      along->rose[i] + SUMMARY_95 * along->rose_error[i]);
    }
    snprintf(name, sizeof name, "band %u", band);
    svg_text(&plot, "name", "start", plot.x.low, plot.y.high, 6.0, 15.0, name);
}

enum mr_status landing_along(const struct report *report, const struct report_landing *landing,
                             FILE *out, struct error *error)
{
    static const char *const names[] = {"least", "most", "at the end"};
    struct along bands[BANDS_MAX];
    double low = 0.0, high = 0.0, key_px = CHART_LEFT;
    size_t shown = 0;
    (void)error;
    for (unsigned b = 0; b < BANDS_MAX; b++) {
        collect(&landing->summary.measured, b + 1, report->si, &bands[b]);
        chart_extend(bands[b].fell, bands[b].gages, &low, &high);
        chart_extend(bands[b].rose, bands[b].gages, &low, &high);
        shown += bands[b].gages > 0;
    }
    if (shown == 0)
        return MR_OK;
    svg_widen(&low, &high, unit_of(UNIT_TENSION, report->si)->factor);
    high += 0.12 * (high - low); /* room for the name */
    fputs("<figure>", out);
    svg_open(out, CHART_WIDTH, 26.0 + HEIGHT + 42.0, "change of tension along the bands");
    shown = 0;
    for (unsigned b = 0; b < BANDS_MAX; b++) {
        if (bands[b].gages)
            draw_band(out, &bands[b], shown++, b + 1, low, high, report->si);
    }
    for (unsigned i = 0; i < 3; i++)
        key_px = chart_key(out, i, key_px, 14.0, names[i]);
    svg_close(out);
    fputs("<figcaption>Against the half second before the first switch opened: least and most "
          "after it, with 95 % errors, and how it ended."
          "</figcaption></figure>\n",
          out);
    return MR_OK;
}
