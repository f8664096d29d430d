/* Tension against time at each station that has gages. */
#include <math.h>
#include <stdlib.h>

#include "host/report/chart.h"
#include "host/report/report.h"

/* Band 1 has look 0 (+ 6: the same), and so on. */
static void draw_tensions_at(struct svg_plot *plot, const struct measured *measured,
                             float station_ft, bool si)
{
    const double factor = unit_of(UNIT_TENSION, si)->factor;
    char title[60];
    svg_axes(plot);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_TENSION || channel->config.station_ft != station_ft)
            continue;
        struct chart_trace trace = chart_trace(measured, channel, plot->x.low, plot->x.high,
                                               factor);
        if (trace.t_s)
            chart_line(plot, (channel->config.band + 5u) % 6u, trace.t_s, trace.value, trace.count,
                       trace.count / 6 + 1);
        free(trace.t_s);
    }
    snprintf(title, sizeof title, "station %.*f %s", si ? 1 : 0,
             (double)station_ft * unit_of(UNIT_STATION, si)->factor,
             unit_of(UNIT_STATION, si)->text);
    svg_text(plot, "name", "start", plot->x.low, plot->y.high, 6.0, 15.0, title);
}

/* Stations that have gages, in order of the channels. */
static size_t gage_stations(const struct measured *measured, float stations_ft[MR_GAGES],
                            double *low, double *high, bool si)
{
    const double factor = unit_of(UNIT_TENSION, si)->factor;
    size_t count = 0;
    *low = (double)INFINITY;
    *high = -(double)INFINITY;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_TENSION || isnan(channel->config.station_ft))
            continue;
        const double extremes[] = {factor * channel->low, factor * channel->high,
                                   factor * channel->baseline};
        chart_extend(extremes, 3, low, high);
        bool known = false;
        for (size_t i = 0; i < count; i++)
            known = known || stations_ft[i] == channel->config.station_ft;
        if (!known && count < MR_GAGES)
            stations_ft[count++] = channel->config.station_ft;
    }
    svg_widen(low, high, 5.0 * factor);
    *high += 0.12 * (*high - *low);
    return count;
}

static void draw_all(FILE *out, const struct measured *measured, const float *stations_ft,
                     size_t count, double low, double high, bool si)
{
    const double height = 130.0;
    struct chart_text y_label = chart_label("tension", UNIT_TENSION, si);
    unsigned bands = 1;
    double key_px = CHART_LEFT;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        if (measured->channel[c].config.kind == MR_KIND_TENSION &&
            measured->channel[c].config.band > bands)
            bands = measured->channel[c].config.band;
    }
    svg_open(out, CHART_WIDTH, 26.0 + (double)((count + 3) / 4) * (height + 24.0) + 26.0,
             "band tensions against time");
    for (size_t i = 0; i < count; i++) {
        struct svg_plot plot = chart_small(out, i, 26.0, height);
        plot.x = (struct svg_axis){-0.3, measured->summary.stop_t_s.value + CHART_SETTLED_S,
                                   i + 4 >= count ? "time since touchdown, s" : NULL, true};
        plot.y = (struct svg_axis){low, high, i % 4 == 0 ? y_label.text : NULL, i % 4 == 0};
        draw_tensions_at(&plot, measured, stations_ft[i], si);
    }
    for (unsigned band = 1; band <= bands; band++) {
        char name[20];
        snprintf(name, sizeof name, "band %u", band);
        key_px = chart_key(out, band - 1, key_px, 14.0, name);
    }
    svg_close(out);
}

enum mr_status landing_tensions(const struct report *report, const struct report_landing *landing,
                                FILE *out, struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    float stations_ft[MR_GAGES];
    double low, high;
    (void)error;
    if (measured->fit_status != MR_OK || measured->samples == 0)
        return MR_OK;
    size_t count = gage_stations(measured, stations_ft, &low, &high, report->si);
    if (count == 0)
        return MR_OK;
    fputs("<figure>", out);
    draw_all(out, measured, stations_ft, count, low, high, report->si);
    fputs("<figcaption>Tension against time, station by station, as read.</figcaption></figure>\n",
          out);
    return MR_OK;
}
