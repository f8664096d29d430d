/* Closed segments over station and time, the wheel, and the zone warned of. */
#include <math.h>

#include "host/report/chart.h"
#include "host/report/report.h"
#include "host/base/svg_words.h"

#define STEP         20 /* blocks between looks at the closure */
#define AFTER_STOP_S 0.8

/* Segments that are closed from one look to the next become one rectangle each; what the wheel has
 * not reached yet is drawn stronger than what lies behind it. */
static void draw_run(const struct svg_plot *plot, const struct measured *measured, unsigned segment,
                     double from_s, double to_s, double station)
{
    double start_ft = (double)MR_SEGMENT_LENGTH_FT * segment;
    double end_ft = start_ft + (double)MR_SEGMENT_LENGTH_FT;
    double passed_s = to_s;
    for (double t_s = from_s; t_s < to_s; t_s += STEP / 1000.0) {
        if (measured_station_ft(measured, t_s) > end_ft) {
            passed_s = t_s;
            break;
        }
    }
    svg_rect(plot, "closed", station * start_ft, from_s, station * end_ft, passed_s);
    svg_rect(plot, "behind", station * start_ft, passed_s, station * end_ft, to_s);
}

static void draw_closed(const struct svg_plot *plot, const struct report_landing *landing,
                        double station)
{
    const struct measured *measured = &landing->summary.measured;
    double since_s[MR_SEGMENTS];
    double t_s = 0.0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        since_s[s] = (double)NAN;
    for (size_t i = 0; i < measured->samples; i += STEP) {
        float remaining_in[MR_SEGMENTS];
        struct mr_closure_zone zone;
        t_s = measured_time_s(measured, i);
        if (t_s < plot->y.low || t_s > plot->y.high)
            continue;
        zones_closed(measured, &landing->survey, i, remaining_in, &zone);
        for (unsigned s = 0; s < MR_SEGMENTS; s++) {
            bool closed = remaining_in[s] < MR_CLOSURE_OPEN_IN;
            if (closed && isnan(since_s[s])) {
                since_s[s] = t_s;
            } else if (!closed && !isnan(since_s[s])) {
                draw_run(plot, measured, s, since_s[s], t_s, station);
                since_s[s] = (double)NAN;
            }
        }
    }
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(since_s[s]))
            draw_run(plot, measured, s, since_s[s], fmin(t_s, plot->y.high), station);
    }
}

static void draw_warned(const struct svg_plot *plot, const struct report_landing *landing,
                        double station)
{
    const struct summary *summary = &landing->summary;
    for (size_t i = 0; i < summary->zones.count; i++) {
        const struct store_zone *row = &summary->zones.row[i];
        double t_s = zones_time_s(&summary->measured, row);
        if (row->warning != 1)
            continue;
        double until_s = i + 1 < summary->zones.count
                           ? zones_time_s(&summary->measured, &summary->zones.row[i + 1])
                           : t_s + 0.05;
        svg_rect(plot, "warned", station * row->start_ft, t_s, station * row->end_ft,
                 fmin(until_s, t_s + 0.1));
    }
}

static void draw_first_warning(const struct svg_plot *plot, const struct report_landing *landing,
                               double station)
{
    const struct zone_warning *warning = &landing->summary.zones.warning;
    char text[80], doubt[ZONES_HEARD_TEXT];
    if (!warning->warned)
        return;
    const char *heard = zones_earlier_text(&landing->summary.zones, doubt) ? " that was heard" : "";
    /* A warning raised while still armed lies below the picture; its words stand at the lower
     * edge. */
    double t_s = fmax(warning->t_s, plot->y.low + 0.02 * (plot->y.high - plot->y.low));
    double wheel_ft = measured_station_ft(&landing->summary.measured, warning->t_s);
    double from_ft = isnan(wheel_ft) ? warning->start_ft : wheel_ft;
    fprintf(plot->out, "<path class=\"line c\" d=\"M%.1f %.1fH%.1f\"/>",
            svg_x(plot, station * from_ft), svg_y(plot, t_s),
            svg_x(plot, station * warning->end_ft));
    if (warning->reached)
        snprintf(text, sizeof text, "first warning%s: %lld mats, %.2f s before the wheel", heard,
                 (long long)warning->mats, warning->true_lead_s);
    else
        snprintf(text, sizeof text, "first warning%s: %lld mats%s", heard, (long long)warning->mats,
                 warning->path_known ? "; the wheel stops before" : "");
    svg_text(plot, "name", "end", station * from_ft, t_s, -8.0, 4.0, text);
}

static void draw_wheel(const struct svg_plot *plot, const struct measured *measured, double station)
{
    double x[401], t_s[401];
    for (size_t i = 0; i <= 400; i++) {
        t_s[i] = plot->y.high * (double)i / 400.0;
        x[i] = station * measured_station_ft(measured, t_s[i]);
    }
    svg_line(plot, "line a", x, t_s, 401);
    for (size_t i = 0; i < measured->gates; i++) {
        if (measured->gate[i].t_s >= plot->y.low && measured->gate[i].station_ft >= 0.0)
            svg_dot(plot, "dot a", station * measured->gate[i].station_ft, measured->gate[i].t_s);
    }
}

static void draw_transducers(const struct svg_plot *plot, const struct measured *measured,
                             double station)
{
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_DISPLACEMENT)
            continue;
        double x = svg_x(plot, station * (double)channel->config.station_ft);
        fprintf(plot->out, "<path class=\"sensor\" d=\"M%.1f %.1fl-5 -9h10Z\"/>\n", x,
                plot->top - 1.0);
    }
}

static void draw_map(FILE *out, const struct report_landing *landing, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    const double station = unit_of(UNIT_STATION, si)->factor;
    const struct svg_key keys[] = {{"line a", "wheel, and switches it opened"},
                                   {"key closed", "closed segments ahead of it"},
                                   {"key behind", "behind it"},
                                   {"key warned", "zone warned of"},
                                   {"key sensor", "transducers"}};
    struct chart_text label = chart_label("station", UNIT_STATION, si);
    struct svg_plot plot = {
        .out = out, .left = 58.0, .top = 40.0, .width = CHART_WIDTH - 70.0, .height = 330.0};
    plot.x = (struct svg_axis){0.0, CHART_RUNWAY_FT * station, label.text, true};
    plot.y = (struct svg_axis){-0.2, measured->summary.stop_t_s.value + AFTER_STOP_S,
                               "time since touchdown, s", true};
    svg_open(out, CHART_WIDTH, 412.0,
             "zone map: closed segments, wheel and warning over station and time");
    svg_axes(&plot);
    draw_closed(&plot, landing, station);
    draw_warned(&plot, landing, station);
    draw_wheel(&plot, measured, station);
    draw_first_warning(&plot, landing, station);
    draw_transducers(&plot, measured, station);
    svg_legend(out, plot.left, CHART_WIDTH - CHART_RIGHT, 14.0, keys, 5);
    svg_close(out);
}

enum mr_status landing_zones(const struct report *report, const struct report_landing *landing,
                             FILE *out, struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    (void)error;
    if (measured->fit_status != MR_OK || measured->samples == 0)
        return MR_OK;
    fputs("<figure>", out);
    draw_map(out, landing, report->si);
    fputs("<figcaption>Closed segments are found here from survey and transducers, the zone warned "
          "of is what the board said.</figcaption></figure>\n",
          out);
    return MR_OK;
}
