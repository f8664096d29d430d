/* Displacement of each station against its distance from the front wheel of the main bogie (report
 * figs. 2.14 and 2.15). */
#include <stdlib.h>

#include "host/report/chart.h"
#include "host/report/report.h"

#define BEHIND_FT 30.0
#define AHEAD_FT  50.0
#define MARKS     7u

/* While the gear rolls: after the stop the distance says nothing. */
static void draw_station(const struct svg_plot *plot, const struct measured *measured,
                         const struct measured_channel *channel, unsigned look, bool si)
{
    double station = unit_of(UNIT_STATION, si)->factor;
    struct chart_trace trace = chart_trace(measured, channel, 0.0, measured->summary.stop_t_s.value,
                                           unit_of(UNIT_DISPLACEMENT, si)->factor);
    size_t shown = 0;
    if (!trace.t_s)
        return;
    chart_to_stations(measured, &trace, station);
    for (size_t i = 0; i < trace.count; i++) {
        double ahead = station * (double)channel->config.station_ft - trace.t_s[i];
        if (ahead < plot->x.low || ahead > plot->x.high)
            continue;
        trace.t_s[shown] = ahead;
        trace.value[shown++] = trace.value[i];
    }
    chart_line(plot, look, trace.t_s, trace.value, shown, shown / MARKS + 1);
    free(trace.t_s);
}

static void range(const struct measured *measured, bool si, double *low, double *high)
{
    double factor = unit_of(UNIT_DISPLACEMENT, si)->factor;
    *low = *high = 0.0;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const double extremes[] = {factor * measured->channel[c].low,
                                   factor * measured->channel[c].high};
        if (measured->channel[c].config.kind == MR_KIND_DISPLACEMENT)
            chart_extend(extremes, 2, low, high);
    }
    svg_widen(low, high, 0.02 * factor);
}

enum mr_status landing_wheel(const struct report *report, const struct report_landing *landing,
                             FILE *out, struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    const struct unit *station = unit_of(UNIT_STATION, report->si);
    struct chart_text x_label = chart_label("transducer ahead of the front wheel (behind it: -)",
                                            UNIT_STATION, report->si),
                      y_label = chart_label("moved", UNIT_DISPLACEMENT, report->si);
    struct svg_plot plot = {.out = out,
                            .left = CHART_LEFT,
                            .top = 26.0,
                            .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                            .height = 260.0,
                            .column_px = 5.0};
    double low, high, key_px = CHART_LEFT;
    (void)error;
    if (measured->fit_status != MR_OK || measured->samples == 0)
        return MR_OK;
    range(measured, report->si, &low, &high);
    plot.x = (struct svg_axis){-BEHIND_FT * station->factor, AHEAD_FT * station->factor,
                               x_label.text, true};
    plot.y = (struct svg_axis){low, high, y_label.text, true};
    fputs("<figure>", out);
    svg_open(out, CHART_WIDTH, 330.0,
             "displacement against distance from the front wheel of the main bogie");
    svg_axes(&plot);
    svg_line(&plot, "mark", (const double[]){0.0, 0.0}, (const double[]){low, high}, 2);
    for (unsigned number = 1; number <= MR_TRANSDUCERS; number++) {
        int c = measured_find(measured, MR_KIND_DISPLACEMENT, number);
        char name[40];
        if (c < 0 || measured->channel[c].valid == 0)
            continue;
        draw_station(&plot, measured, &measured->channel[c], number - 1, report->si);
        snprintf(name, sizeof name, "%.*f %s", report->si ? 1 : 0,
                 (double)measured->channel[c].config.station_ft * station->factor, station->text);
        key_px = chart_key(out, number - 1, key_px, 14.0, name);
    }
    svg_close(out);
    fputs("<figcaption>A line for each transducer, by its station; the wheel comes from the right. "
          "While the gear rolls.</figcaption></figure>\n",
          out);
    return MR_OK;
}
