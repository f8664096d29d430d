#include "host/report/plots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/report/svg.h"
#include "host/units.h"

#define WIDTH 1040.0
#define MARGIN_LEFT 58.0
#define CURVE_POINTS 400
#define SETTLED_S 0.6 /* how long after the stop traces are shown */

static void unit_label(char *out, size_t size, const char *what, enum unit_kind kind, bool si)
{
    snprintf(out, size, "%s, %s", what, unit_of(kind, si)->text);
}

/* ---- speed ---- */

static void draw_speed_curve(const struct svg_plot *plot, const struct measured *measured, double factor)
{
    double t[CURVE_POINTS + 1], v[CURVE_POINTS + 1], low[CURVE_POINTS + 1], high[CURVE_POINTS + 1];
    double stop_s = measured->summary.stop_t_s.value;
    for (size_t i = 0; i <= CURVE_POINTS; i++) {
        double error_ft_s;
        t[i] = stop_s * (double)i / CURVE_POINTS;
        v[i] = factor * measured_speed_ft_s(measured, t[i], &error_ft_s);
        low[i] = v[i] - factor * SUMMARY_95 * error_ft_s;
        high[i] = v[i] + factor * SUMMARY_95 * error_ft_s;
    }
    svg_band(plot, "band", t, low, high, CURVE_POINTS + 1);
    svg_line(plot, "line a", t, v, CURVE_POINTS + 1);
}

static void draw_gate_speeds(const struct svg_plot *plot, const struct measured *measured, double factor)
{
    for (size_t i = 1; i < measured->gates; i++) {
        const struct mr_gate *from = &measured->gate[i - 1];
        const struct mr_gate *to = &measured->gate[i];
        double t_s = 0.5 * (from->t_s + to->t_s);
        if (t_s >= plot->x.low)
            svg_dot(plot, "dot b", t_s, factor * (to->station_ft - from->station_ft) / (to->t_s - from->t_s));
    }
}

static void draw_online_speeds(const struct svg_plot *plot, const struct report_landing *landing,
                               double factor)
{
    const struct measured *measured = &landing->summary.measured;
    for (size_t i = 0; i < landing->motions; i++) {
        const struct store_motion *motion = &landing->motion[i];
        double t_s = (double)(1000 * motion->block - measured->t0_us) / 1e6;
        double v = factor * motion->speed_ft_s;
        if (t_s < plot->x.low || t_s > plot->x.high || isnan(v) || v > plot->y.high)
            continue;
        double half = isnan(motion->speed_error_ft_s) ? 0.0 : factor * SUMMARY_95 * motion->speed_error_ft_s;
        double x = svg_x(plot, t_s);
        fprintf(plot->out, "<path class=\"line c\" d=\"M%.1f %.1fV%.1f\"/>", x,
                svg_y(plot, fmax(v - half, plot->y.low)), svg_y(plot, fmin(v + half, plot->y.high)));
        svg_dot(plot, "dot c", t_s, v);
    }
}

void plot_speed(FILE *out, const struct report_landing *landing, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    const struct svg_key keys[] = {{"line a", "fit, with its 95 % band"},
                                   {"dot b", "mean between switches"},
                                   {"dot c", "the board, as it went"}};
    char label[60];
    double factor = unit_of(UNIT_SPEED, si)->factor;
    unit_label(label, sizeof label, "speed", UNIT_SPEED, si);
    struct svg_plot plot = {
        .out = out, .left = MARGIN_LEFT, .top = 26.0, .width = WIDTH - MARGIN_LEFT - 12.0, .height = 210.0};
    plot.x =
        (struct svg_axis){-0.3, measured->summary.stop_t_s.value * 1.03, "time since touchdown, s", true};
    plot.y =
        (struct svg_axis){0.0, 1.12 * factor * measured->summary.touchdown_speed_ft_s.value, label, true};
    svg_open(out, WIDTH, 280.0, "speed of the gear against time");
    svg_axes(&plot);
    draw_speed_curve(&plot, measured, factor);
    draw_gate_speeds(&plot, measured, factor);
    draw_online_speeds(&plot, landing, factor);
    svg_legend(out, MARGIN_LEFT, 14.0, keys, 3);
    svg_close(out);
}

/* ---- small multiples ---- */

/* Time and one channel between two times, in the unit shown. The caller frees t. */
struct trace {
    double *t_s;
    double *value;
    size_t count;
};

static struct trace make_trace(const struct measured *measured, const struct measured_channel *channel,
                               double from_s, double to_s, double factor)
{
    struct trace trace = {.t_s = malloc(2 * (measured->samples + 1) * sizeof(double))};
    if (!trace.t_s)
        return trace;
    trace.value = trace.t_s + measured->samples + 1;
    for (size_t i = 0; i < measured->samples; i++) {
        double t_s = measured_time_s(measured, i);
        if (t_s < from_s || t_s > to_s)
            continue;
        trace.t_s[trace.count] = t_s;
        trace.value[trace.count++] = factor * measured_value(channel, i);
    }
    return trace;
}

static void widen_by(const double *values, size_t count, double *low, double *high)
{
    for (size_t i = 0; i < count; i++) {
        if (isnan(values[i]))
            continue;
        *low = fmin(*low, values[i]);
        *high = fmax(*high, values[i]);
    }
}

static const struct store_simulation *find_simulation(const struct report_landing *landing, unsigned number)
{
    for (size_t i = 0; i < landing->simulations; i++) {
        if (landing->simulation[i].number == number)
            return &landing->simulation[i];
    }
    return NULL;
}

/* Replaces times by stations of the wheel. */
static void to_stations(const struct measured *measured, double *t_s, size_t count, double factor)
{
    for (size_t i = 0; i < count; i++)
        t_s[i] = factor * measured_station_ft(measured, t_s[i]);
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
    double end_s = measured->summary.stop_t_s.value + SETTLED_S;
    double station = unit_of(UNIT_STATION, si)->factor * (double)channel->config.station_ft;
    struct trace trace = make_trace(measured, channel, 0.0, end_s, unit_of(UNIT_DISPLACEMENT, si)->factor);
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
        to_stations(measured, trace.t_s, trace.count, unit_of(UNIT_STATION, si)->factor);
        svg_line(plot, "line a", trace.t_s, trace.value, trace.count);
    }
    snprintf(title, sizeof title, "%u: station %.*f %s%s", channel->config.number, si ? 1 : 0, station,
             unit_of(UNIT_STATION, si)->text, channel->valid ? "" : ", not valid");
    svg_text(plot, "name", "start", plot->x.low, plot->y.high, 6.0, 15.0, title);
    free(trace.t_s);
}

/* The range all displacement plots share, so that stations compare at a glance. */
static void displacement_range(const struct report_landing *landing, bool si, double *low, double *high)
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
        widen_by(extremes, 2, low, high);
        const struct store_simulation *simulation = find_simulation(landing, channel->config.number);
        if (simulation) {
            double peak = factor * simulation->peak_simulated_in;
            widen_by(&peak, 1, low, high);
        }
    }
    svg_widen(low, high, 0.02 * factor);
    *high += 0.12 * (*high - *low); /* room for the name */
}

void plot_displacements(FILE *out, const struct report_landing *landing, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    const double width = (WIDTH - MARGIN_LEFT - 12.0 - 3 * 14.0) / 4.0, height = 150.0;
    const struct svg_key keys[] = {
        {"line a", "measured"}, {"line sim", "simulated"}, {"mark", "the wheel is at the transducer"}};
    char x_label[60], y_label[60];
    double low, high;
    unsigned shown = 0;
    unit_label(x_label, sizeof x_label, "gear position", UNIT_STATION, si);
    unit_label(y_label, sizeof y_label, "moved", UNIT_DISPLACEMENT, si);
    displacement_range(landing, si, &low, &high);
    svg_open(out, WIDTH, 26.0 + 2 * (height + 24.0) + 26.0,
             "displacement of eight stations against gear position");
    for (unsigned number = 1; number <= MR_TRANSDUCERS; number++) {
        int c = measured_find(measured, MR_KIND_DISPLACEMENT, number);
        if (c < 0)
            continue;
        unsigned column = shown % 4, row = shown / 4;
        shown++;
        struct svg_plot plot = {.out = out,
                                .left = MARGIN_LEFT + column * (width + 14.0),
                                .top = 26.0 + row * (height + 24.0),
                                .width = width,
                                .height = height};
        plot.x = (struct svg_axis){0.0, 120.0 * unit_of(UNIT_STATION, si)->factor, row == 1 ? x_label : NULL,
                                   true};
        plot.y = (struct svg_axis){low, high, column == 0 ? y_label : NULL, column == 0};
        draw_displacement(&plot, landing, &measured->channel[c], si);
    }
    if (landing->simulations)
        svg_legend(out, MARGIN_LEFT, 14.0, keys, 3);
    else
        svg_legend(out, MARGIN_LEFT, 14.0, (const struct svg_key[]){keys[0], keys[2]}, 2);
    svg_close(out);
}

/* ---- tensions ---- */

static void draw_tensions_at(struct svg_plot *plot, const struct measured *measured, float station_ft,
                             bool si)
{
    static const char *const classes[] = {"line a", "line b", "line c", "line sim"};
    const double factor = unit_of(UNIT_TENSION, si)->factor;
    char title[60];
    svg_axes(plot);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_TENSION || channel->config.station_ft != station_ft)
            continue;
        struct trace trace = make_trace(measured, channel, plot->x.low, plot->x.high, factor);
        if (trace.t_s)
            svg_line(plot, classes[(channel->config.band + 3u) % 4u], trace.t_s, trace.value, trace.count);
        free(trace.t_s);
    }
    snprintf(title, sizeof title, "station %.*f %s", si ? 1 : 0,
             (double)station_ft * unit_of(UNIT_STATION, si)->factor, unit_of(UNIT_STATION, si)->text);
    svg_text(plot, "name", "start", plot->x.low, plot->y.high, 6.0, 15.0, title);
}

/* Stations that have gages, in order of the channels. */
static size_t gage_stations(const struct measured *measured, float stations_ft[MR_GAGES], double *low,
                            double *high, bool si)
{
    const double factor = unit_of(UNIT_TENSION, si)->factor;
    size_t count = 0;
    *low = (double)INFINITY;
    *high = -(double)INFINITY;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_TENSION || isnan(channel->config.station_ft))
            continue;
        const double extremes[] = {factor * channel->low, factor * channel->high, factor * channel->baseline};
        widen_by(extremes, 3, low, high);
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

void plot_tensions(FILE *out, const struct report_landing *landing, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    const double width = (WIDTH - MARGIN_LEFT - 12.0 - 3 * 14.0) / 4.0, height = 130.0;
    const struct svg_key keys[] = {
        {"line a", "band 1"}, {"line b", "band 2"}, {"line c", "band 3"}, {"line sim", "band 4"}};
    float stations_ft[MR_GAGES];
    char y_label[60];
    double low, high;
    unsigned bands = 1;
    size_t count = gage_stations(measured, stations_ft, &low, &high, si);
    size_t rows = (count + 3) / 4;
    unit_label(y_label, sizeof y_label, "tension", UNIT_TENSION, si);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        if (measured->channel[c].config.kind == MR_KIND_TENSION && measured->channel[c].config.band > bands)
            bands = measured->channel[c].config.band;
    }
    svg_open(out, WIDTH, 26.0 + (double)rows * (height + 24.0) + 26.0, "band tensions against time");
    for (size_t i = 0; i < count; i++) {
        size_t column = i % 4, row = i / 4;
        struct svg_plot plot = {.out = out,
                                .left = MARGIN_LEFT + (double)column * (width + 14.0),
                                .top = 26.0 + (double)row * (height + 24.0),
                                .width = width,
                                .height = height};
        plot.x = (struct svg_axis){-0.3, measured->summary.stop_t_s.value + SETTLED_S,
                                   i + 4 >= count ? "time since touchdown, s" : NULL, true};
        plot.y = (struct svg_axis){low, high, column == 0 ? y_label : NULL, column == 0};
        draw_tensions_at(&plot, measured, stations_ft[i], si);
    }
    svg_legend(out, MARGIN_LEFT, 14.0, keys, bands < 4 ? bands : 4);
    svg_close(out);
}

/* ---- campaign ---- */

void plot_campaign(FILE *out, const struct report_landing *landings, size_t count, bool si)
{
    const double station = unit_of(UNIT_STATION, si)->factor, length = unit_of(UNIT_DISPLACEMENT, si)->factor;
    char x_label[60], y_label[60];
    double low = 0.0, high = 0.0;
    unit_label(x_label, sizeof x_label, "station", UNIT_STATION, si);
    unit_label(y_label, sizeof y_label, "peak movement", UNIT_DISPLACEMENT, si);
    for (size_t i = 0; i < count; i++) {
        for (unsigned c = 0; c < MR_TRANSDUCERS; c++) {
            double peak = length * landings[i].summary.measured.channel[c].peak;
            if (landings[i].summary.measured.channel[c].config.kind == MR_KIND_DISPLACEMENT)
                widen_by(&peak, 1, &low, &high);
        }
    }
    svg_widen(&low, &high, 0.02 * length);
    struct svg_plot plot = {
        .out = out, .left = MARGIN_LEFT, .top = 10.0, .width = WIDTH - MARGIN_LEFT - 80.0, .height = 210.0};
    plot.x = (struct svg_axis){0.0, 120.0 * station, x_label, true};
    plot.y = (struct svg_axis){low, high, y_label, true};
    svg_open(out, WIDTH, 262.0, "peak movement against station, a line per landing");
    svg_axes(&plot);
    for (size_t i = 0; i < count; i++) {
        double x[MR_TRANSDUCERS], y[MR_TRANSDUCERS];
        size_t points = 0;
        char class[12], name[40];
        for (unsigned c = 0; c < MR_TRANSDUCERS; c++) {
            const struct measured_channel *channel = &landings[i].summary.measured.channel[c];
            if (channel->config.kind != MR_KIND_DISPLACEMENT || isnan(channel->peak))
                continue;
            x[points] = station * (double)channel->config.station_ft;
            y[points++] = length * channel->peak;
        }
        if (points == 0)
            continue;
        snprintf(class, sizeof class, "line s%zu", i % 6);
        svg_line(&plot, class, x, y, points);
        snprintf(name, sizeof name, "RUN %lld", (long long)landings[i].summary.measured.landing.id);
        snprintf(class, sizeof class, "dot s%zu", i % 6);
        for (size_t p = 0; p < points; p++)
            svg_dot(&plot, class, x[p], y[p]);
        svg_text(&plot, "name", "start", x[points - 1], y[points - 1], 7.0, 4.0, name);
    }
    svg_close(out);
}
