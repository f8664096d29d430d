#include "host/report/chart.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/base/html.h"
#include "host/base/svg_words.h"

#define LOOKS   6u /* classes s0 to s5 of style.c */
#define BETWEEN 14.0

struct chart_text chart_label(const char *what, enum unit_kind kind, bool si)
{
    struct chart_text label;
    snprintf(label.text, sizeof label.text, "%s, %s", what, unit_of(kind, si)->text);
    return label;
}

void chart_extend(const double *values, size_t count, double *low, double *high)
{
    for (size_t i = 0; i < count; i++) {
        *low = fmin(*low, values[i]); /* fmin leaves out what is missing */
        *high = fmax(*high, values[i]);
    }
}

void chart_mark(const struct svg_plot *plot, unsigned number, double x, double y)
{
    char class[16];
    if (isnan(x) || isnan(y))
        return;
    snprintf(class, sizeof class, "dot s%u", number % LOOKS);
    svg_mark(plot->out, class, number % SVG_SHAPES, svg_x(plot, x), svg_y(plot, y), 3.0);
}

void chart_line(const struct svg_plot *plot, unsigned number, const double *x, const double *y,
                size_t count, size_t every)
{
    char class[16];
    snprintf(class, sizeof class, "line s%u", number % LOOKS);
    svg_line(plot, class, x, y, count);
    for (size_t i = number % every; i < count; i += every)
        chart_mark(plot, number, x[i], y[i]);
}

void chart_whisker(const struct svg_plot *plot, const char *class, double x, double low,
                   double high)
{
    if (isfinite(x) && isfinite(low) && isfinite(high))
        fprintf(plot->out, "<path class=\"%s\" d=\"M%.1f %.1fV%.1f\"/>\n", class, svg_x(plot, x),
                svg_y(plot, fmax(low, plot->y.low)), svg_y(plot, fmin(high, plot->y.high)));
}

double chart_key(FILE *out, unsigned number, double left, double y, const char *text)
{
    char line[16], mark[16];
    snprintf(line, sizeof line, "line s%u", number % LOOKS);
    snprintf(mark, sizeof mark, "dot s%u", number % LOOKS);
    fprintf(out, "<path class=\"%s\" d=\"M%.1f %.1fh28\"/>", line, left, y - 4.0);
    svg_mark(out, mark, number % SVG_SHAPES, left + 14.0, y - 4.0, 3.0);
    fprintf(out, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\">", left + 33.0, y);
    html_text(out, text);
    fputs("</text>\n", out);
    return left + 48.0 + svg_text_width(text, SVG_KEY_SIZE_PX);
}

void chart_mark_key(FILE *out, const char *class, unsigned shape, double left, double y,
                    const char *text)
{
    svg_mark(out, class, shape, left, y - 4.0, 3.0);
    fprintf(out, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\">", left + 9.0, y);
    html_text(out, text);
    fputs("</text>\n", out);
}

struct svg_plot chart_small(FILE *out, size_t place, double top, double height)
{
    double width = (CHART_WIDTH - CHART_LEFT - CHART_RIGHT - 3.0 * BETWEEN) / 4.0;
    return (struct svg_plot){.out = out,
                             .left = CHART_LEFT + (double)(place % 4) * (width + BETWEEN),
                             .top = top + (double)(place / 4) * (height + 24.0),
                             .width = width,
                             .height = height,
                             .column_px = CHART_COLUMN_PX};
}

struct chart_trace chart_trace(const struct measured *measured,
                               const struct measured_channel *channel, double from_s, double to_s,
                               double factor)
{
    struct chart_trace trace = {.t_s = malloc(2 * (measured->samples + 1) * sizeof(double))};
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

void chart_to_stations(const struct measured *measured, struct chart_trace *trace, double factor)
{
    for (size_t i = 0; i < trace->count; i++)
        trace->t_s[i] = factor * measured_station_ft(measured, trace->t_s[i]);
}
