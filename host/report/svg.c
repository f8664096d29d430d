#include "host/report/svg.h"

#include <math.h>
#include <string.h>

#include "host/report/html.h"

#define TICKS_PER_PX_X (1.0 / 70.0)
#define TICKS_PER_PX_Y (1.0 / 36.0)

struct svg_ticks svg_choose_ticks(double low, double high, unsigned most)
{
    struct svg_ticks ticks = {0};
    if (!(high > low) || !isfinite(low) || !isfinite(high) || most == 0)
        return ticks;
    int exponent = (int)floor(log10((high - low) / (double)most));
    static const double mantissas[] = {1.0, 2.0, 5.0, 10.0};
    double power = pow(10.0, exponent);
    for (int m = 0; m < 4; m++) {
        double step = mantissas[m] * power;
        /* A hair of tolerance, so that 0.3 is a tick of 0 to 0.3. */
        double first = ceil(low / step - 1e-9);
        double last = floor(high / step + 1e-9);
        unsigned count = last >= first ? (unsigned)(last - first) + 1 : 0;
        if (count > most)
            continue;
        ticks.first = first * step;
        ticks.step = step;
        ticks.count = count;
        int places = m == 3 ? exponent + 1 : exponent;
        ticks.decimals = places < 0 ? -places : 0;
        return ticks;
    }
    return ticks;
}

void svg_widen(double *low, double *high, double least)
{
    if (!isfinite(*low) || !isfinite(*high) || *low > *high) {
        *low = 0.0;
        *high = least;
        return;
    }
    double margin = 0.05 * (*high - *low);
    *low -= margin;
    *high += margin;
    if (*high - *low < least) {
        double middle = 0.5 * (*low + *high);
        *low = middle - 0.5 * least;
        *high = middle + 0.5 * least;
    }
}

void svg_open(FILE *out, double width, double height, const char *title)
{
    fprintf(out, "<svg viewBox=\"0 0 %.0f %.0f\" role=\"img\" aria-label=\"", width, height);
    html_text(out, title);
    fprintf(out, "\">\n");
}

void svg_close(FILE *out)
{
    fputs("</svg>\n", out);
}

double svg_x(const struct svg_plot *plot, double x)
{
    return plot->left + plot->width * (x - plot->x.low) / (plot->x.high - plot->x.low);
}

double svg_y(const struct svg_plot *plot, double y)
{
    return plot->top + plot->height * (plot->y.high - y) / (plot->y.high - plot->y.low);
}

/* -0.0 and what rounds to it print as 0. */
static void print_tick(FILE *out, double value, int decimals)
{
    fprintf(out, "%.*f", decimals, fabs(value) < 0.5 * pow(10.0, -decimals) ? 0.0 : value);
}

static void x_axis(const struct svg_plot *plot)
{
    FILE *out = plot->out;
    double bottom = plot->top + plot->height;
    struct svg_ticks ticks =
        svg_choose_ticks(plot->x.low, plot->x.high, (unsigned)(plot->width * TICKS_PER_PX_X) + 2);
    for (unsigned i = 0; i < ticks.count; i++) {
        double value = ticks.first + (double)i * ticks.step;
        double x = svg_x(plot, value);
        fprintf(out, "<path class=\"grid\" d=\"M%.1f %.1fV%.1f\"/>", x, plot->top, bottom);
        if (!plot->x.ticks)
            continue;
        fprintf(out, "<text class=\"tick\" text-anchor=\"middle\" x=\"%.1f\" y=\"%.1f\">", x, bottom + 14.0);
        print_tick(out, value, ticks.decimals);
        fputs("</text>", out);
    }
    if (plot->x.label) {
        fprintf(out, "<text class=\"label\" text-anchor=\"middle\" x=\"%.1f\" y=\"%.1f\">",
                plot->left + plot->width / 2, bottom + 32.0);
        html_text(out, plot->x.label);
        fputs("</text>", out);
    }
}

static void y_axis(const struct svg_plot *plot)
{
    FILE *out = plot->out;
    struct svg_ticks ticks =
        svg_choose_ticks(plot->y.low, plot->y.high, (unsigned)(plot->height * TICKS_PER_PX_Y) + 2);
    for (unsigned i = 0; i < ticks.count; i++) {
        double value = ticks.first + (double)i * ticks.step;
        double y = svg_y(plot, value);
        fprintf(out, "<path class=\"grid\" d=\"M%.1f %.1fH%.1f\"/>", plot->left, y, plot->left + plot->width);
        if (!plot->y.ticks)
            continue;
        fprintf(out, "<text class=\"tick\" text-anchor=\"end\" x=\"%.1f\" y=\"%.1f\">", plot->left - 5.0,
                y + 4.0);
        print_tick(out, value, ticks.decimals);
        fputs("</text>", out);
    }
    if (plot->y.label) {
        double x = plot->left - 40.0;
        double y = plot->top + plot->height / 2;
        fprintf(
            out,
            "<text class=\"label\" text-anchor=\"middle\" transform=\"translate(%.1f %.1f) rotate(-90)\">", x,
            y);
        html_text(out, plot->y.label);
        fputs("</text>", out);
    }
}

void svg_axes(const struct svg_plot *plot)
{
    x_axis(plot);
    y_axis(plot);
    fprintf(plot->out, "<rect class=\"frame\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>\n",
            plot->left, plot->top, plot->width, plot->height);
}

static double clip(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

/* The points of a path, thinned by pixel column as they come. */
struct pen {
    const struct svg_plot *plot;
    bool down;
    long column; /* -1: none */
    double x, first, least, most, last;
};

static void pen_point(struct pen *pen, double x, double y)
{
    fprintf(pen->plot->out, "%s%.1f %.1f", pen->down ? "L" : "M", x, y);
    pen->down = true;
}

static void pen_flush(struct pen *pen)
{
    if (pen->column < 0)
        return;
    pen_point(pen, pen->x, pen->first);
    if (pen->least < pen->first && pen->least < pen->last)
        pen_point(pen, pen->x, pen->least);
    if (pen->most > pen->first && pen->most > pen->last)
        pen_point(pen, pen->x, pen->most);
    if (fabs(pen->last - pen->first) > 0.05)
        pen_point(pen, pen->x, pen->last);
    pen->column = -1;
}

static void pen_move(struct pen *pen, double x, double y)
{
    if (isnan(x) || isnan(y)) {
        pen_flush(pen);
        pen->down = false;
        return;
    }
    const struct svg_plot *plot = pen->plot;
    double px = clip(svg_x(plot, x), plot->left, plot->left + plot->width);
    double py = clip(svg_y(plot, y), plot->top, plot->top + plot->height);
    long column = (long)px;
    if (column != pen->column) {
        pen_flush(pen);
        pen->column = column;
        pen->x = px;
        pen->first = pen->least = pen->most = py;
    }
    pen->least = fmin(pen->least, py);
    pen->most = fmax(pen->most, py);
    pen->last = py;
}

void svg_line(const struct svg_plot *plot, const char *class, const double *x, const double *y, size_t count)
{
    struct pen pen = {.plot = plot, .column = -1};
    fprintf(plot->out, "<path class=\"%s\" d=\"", class);
    for (size_t i = 0; i < count; i++)
        pen_move(&pen, x[i], y[i]);
    pen_flush(&pen);
    fputs("\"/>\n", plot->out);
}

void svg_band(const struct svg_plot *plot, const char *class, const double *x, const double *low,
              const double *high, size_t count)
{
    struct pen pen = {.plot = plot, .column = -1};
    fprintf(plot->out, "<path class=\"%s\" d=\"", class);
    for (size_t i = 0; i < count; i++)
        pen_move(&pen, isnan(low[i]) ? (double)NAN : x[i], high[i]);
    pen_flush(&pen);
    for (size_t i = count; i-- > 0;) {
        if (!isnan(low[i]) && !isnan(x[i]) && !isnan(high[i]))
            pen_move(&pen, x[i], low[i]);
    }
    pen_flush(&pen);
    fputs("Z\"/>\n", plot->out);
}

void svg_rect(const struct svg_plot *plot, const char *class, double x0, double y0, double x1, double y1)
{
    double left = clip(svg_x(plot, x0), plot->left, plot->left + plot->width);
    double right = clip(svg_x(plot, x1), plot->left, plot->left + plot->width);
    double top = clip(svg_y(plot, y1), plot->top, plot->top + plot->height);
    double bottom = clip(svg_y(plot, y0), plot->top, plot->top + plot->height);
    if (right > left && bottom > top)
        fprintf(plot->out, "<rect class=\"%s\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>\n",
                class, left, top, right - left, bottom - top);
}

void svg_dot(const struct svg_plot *plot, const char *class, double x, double y)
{
    if (!isnan(x) && !isnan(y))
        fprintf(plot->out, "<circle class=\"%s\" cx=\"%.1f\" cy=\"%.1f\" r=\"2.6\"/>\n", class,
                svg_x(plot, x), svg_y(plot, y));
}

void svg_text(const struct svg_plot *plot, const char *class, const char *anchor, double x, double y,
              double dx, double dy, const char *text)
{
    fprintf(plot->out, "<text class=\"%s\" text-anchor=\"%s\" x=\"%.1f\" y=\"%.1f\">", class, anchor,
            svg_x(plot, x) + dx, svg_y(plot, y) + dy);
    html_text(plot->out, text);
    fputs("</text>\n", plot->out);
}

void svg_legend(FILE *out, double left, double y, const struct svg_key *keys, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        size_t length = 0;
        if (strncmp(keys[i].class, "dot", 3) == 0)
            fprintf(out, "<circle class=\"%s\" cx=\"%.1f\" cy=\"%.1f\" r=\"2.6\"/>", keys[i].class, left + 10.0, y - 4.0);
        else
            fprintf(out, "<path class=\"%s\" d=\"M%.1f %.1fh20\"/>", keys[i].class, left, y - 4.0);
        fprintf(out, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\">", left + 25.0, y);
        html_text(out, keys[i].text);
        fputs("</text>\n", out);
        while (keys[i].text[length])
            length++;
        left += 45.0 + 6.2 * (double)length; /* 11 px letters are about 6 px wide */
    }
}
