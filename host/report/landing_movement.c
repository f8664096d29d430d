/* Displacement of each station while the gear comes down the runway, measured and simulated. */
#include <stdlib.h>

#include "host/report/chart.h"
#include "host/report/report.h"
#include "host/base/svg_words.h"

static const struct store_simulation *find_simulation(const struct report_landing *landing,
                                                      unsigned number)
{
    for (size_t i = 0; i < landing->simulations; i++) {
        if (landing->simulation[i].number == number)
            return &landing->simulation[i];
    }
    return NULL;
}

static void draw_simulated(const struct svg_plot *plot, const struct measured *measured,
                           const struct store_simulation *simulation, double end_s, bool si)
{
    double *x = malloc(2 * (simulation->length + 1) * sizeof *x);
    size_t count = 0;
    if (!x)
        return;
    double *y = x + simulation->length + 1;
    for (size_t i = 0; i < simulation->length; i++) {
        double t_s = simulation->t0_s + (double)i * simulation->dt_s;
        if (t_s > end_s)
            break;
        x[count] = unit_of(UNIT_STATION, si)->factor * measured_station_ft(measured, t_s);
        y[count++] = unit_of(UNIT_DISPLACEMENT, si)->factor * (double)simulation->series_in[i];
    }
    svg_line(plot, "line sim", x, y, count);
    free(x);
}

static void draw_displacement(struct svg_plot *plot, const struct report_landing *landing,
                              const struct measured_channel *channel, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    double end_s = measured->summary.stop_t_s.value + CHART_SETTLED_S;
    double station = unit_of(UNIT_STATION, si)->factor * (double)channel->config.station_ft;
    struct chart_trace trace = chart_trace(measured, channel, 0.0, end_s,
                                           unit_of(UNIT_DISPLACEMENT, si)->factor);
    const struct store_simulation *simulation = find_simulation(landing, channel->config.number);
    char title[60];
    svg_axes(plot);
    /* Where the wheel passes the transducer. */
    if (station >= plot->x.low && station <= plot->x.high)
        fprintf(plot->out, "<path class=\"mark\" d=\"M%.1f %.1fV%.1f\"/>", svg_x(plot, station),
                plot->top + 22.0, plot->top + plot->height);
    if (simulation)
        draw_simulated(plot, measured, simulation, end_s, si);
    if (trace.t_s) {
        chart_to_stations(measured, &trace, unit_of(UNIT_STATION, si)->factor);
        svg_line(plot, "line a", trace.t_s, trace.value, trace.count);
    }
    snprintf(title, sizeof title, "%u: station %.*f %s%s", channel->config.number, si ? 1 : 0,
             station, unit_of(UNIT_STATION, si)->text, channel->valid ? "" : ", not valid");
    svg_text(plot, "name", "start", plot->x.low, plot->y.high, 6.0, 15.0, title);
    free(trace.t_s);
}

/* The range all displacement plots share, so that stations compare at a glance. */
static void displacement_range(const struct report_landing *landing, bool si, double *low,
                               double *high)
{
    const struct measured *measured = &landing->summary.measured;
    double factor = unit_of(UNIT_DISPLACEMENT, si)->factor;
    *low = 0.0;
    *high = 0.0;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_DISPLACEMENT)
            continue;
        const double extremes[] = {factor * channel->low, factor * channel->high};
        chart_extend(extremes, 2, low, high);
        const struct store_simulation *simulation = find_simulation(landing,
                                                                    channel->config.number);
        if (simulation) {
            double peak = factor * simulation->peak_simulated_in;
            chart_extend(&peak, 1, low, high);
        }
    }
    svg_widen(low, high, 0.02 * factor);
    *high += 0.12 * (*high - *low); /* room for the name */
}

static void draw_all(FILE *out, const struct report_landing *landing, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    const double height = 150.0;
    const struct svg_key keys[] = {{"line a", "measured"},
                                   {"mark", "the wheel is at the transducer"},
                                   {"line sim", "simulated"}};
    struct chart_text x_label = chart_label("gear position", UNIT_STATION, si),
                      y_label = chart_label("moved", UNIT_DISPLACEMENT, si);
    double low, high;
    size_t shown = 0;
    displacement_range(landing, si, &low, &high);
    svg_open(out, CHART_WIDTH, 26.0 + 2 * (height + 24.0) + 26.0,
             "displacement of eight stations against gear position");
    for (unsigned number = 1; number <= MR_TRANSDUCERS; number++) {
        int c = measured_find(measured, MR_KIND_DISPLACEMENT, number);
        if (c < 0)
            continue;
        struct svg_plot plot = chart_small(out, shown, 26.0, height);
        plot.x = (struct svg_axis){0.0, CHART_RUNWAY_FT * unit_of(UNIT_STATION, si)->factor,
                                   shown >= 4 ? x_label.text : NULL, true};
        plot.y = (struct svg_axis){low, high, shown % 4 == 0 ? y_label.text : NULL, shown % 4 == 0};
        draw_displacement(&plot, landing, &measured->channel[c], si);
        shown++;
    }
    svg_legend(out, CHART_LEFT, CHART_WIDTH - CHART_RIGHT, 14.0, keys,
               landing->simulations ? 3 : 2);
    svg_close(out);
}

enum mr_status landing_movement(const struct report *report, const struct report_landing *landing,
                                FILE *out, struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    (void)error;
    if (measured->fit_status != MR_OK || measured->samples == 0)
        return MR_OK;
    fputs("<figure>", out);
    draw_all(out, landing, report->si);
    fputs("<figcaption>Displacement against gear position (as report fig. 2.13). Downfield is "
          "positive, since the mean of the half second before the first "
          "switch opened.</figcaption></figure>\n",
          out);
    return MR_OK;
}
