#include "host/base/svg.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

#include "host/base/html.h"
#include "host/base/svg_words.h"

#define TICKS_PER_PX_X (1.0 / 70.0)
#define TICKS_PER_PX_Y (1.0 / 36.0)

struct svg_ticks svg_choose_ticks(double low, double high, unsigned most)
{
    struct svg_ticks ticks = {0};
    if (!(high > low) || !isfinite(high - low) || most == 0)
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

static void open_picture(FILE *out, const char *attributes, double width, double height,
                         const char *title)
{
    fprintf(out, "<svg %sviewBox=\"0 0 %.0f %.0f\" role=\"img\" aria-label=\"", attributes, width,
            height);
    html_text(out, title);
    fprintf(out, "\">\n");
}

void svg_open(FILE *out, double width, double height, const char *title)
{
    open_picture(out, "", width, height, title);
}

void svg_open_file(FILE *out, double width, double height, const char *title)
{
    open_picture(out, "xmlns=\"http://www.w3.org/2000/svg\" ", width, height, title);
}

void svg_close(FILE *out)
{
    fputs("</svg>\n", out);
}

static double share(const struct svg_axis *axis, bool logarithmic, double value)
{
    if (logarithmic)
        return log(value / axis->low) / log(axis->high / axis->low);
    double span = axis->high - axis->low; /* below 0: the axis runs the other way */
    return fabs(span) > 0.0 ? (value - axis->low) / span : 0.0;
}

/* Pixels far outside are as good as any others there, and an infinite one is none. */
static double bounded(double px)
{
    return fmin(fmax(px, -1e5), 1e5);
}

double svg_x(const struct svg_plot *plot, double x)
{
    return bounded(plot->left + plot->width * share(&plot->x, plot->log_x, x));
}

double svg_y(const struct svg_plot *plot, double y)
{
    return bounded(plot->top + plot->height * (1.0 - share(&plot->y, plot->log_y, y)));
}

/* -0.0 and what rounds to it print as 0. */
static void print_tick(FILE *out, double value, int decimals)
{
    fprintf(out, "%.*f", decimals, fabs(value) < 0.5 * pow(10.0, -decimals) ? 0.0 : value);
}

/* Decades of a logarithmic axis, at most `most` of them numbered. */
struct decades {
    int first, last, every;
};

static struct decades decades_of(const struct svg_axis *axis, unsigned most)
{
    struct decades d = {(int)ceil(log10(axis->low) - 1e-9), (int)floor(log10(axis->high) + 1e-9),
                        1};
    while ((unsigned)((d.last - d.first) / d.every) + 1 > most)
        d.every++;
    return d;
}

static void print_decade(FILE *out, int exponent)
{
    fprintf(out, "10<tspan dy=\"-4\" font-size=\"75%%\">%s%d</tspan></text>",
            exponent < 0 ? "\xe2\x88\x92" : "", exponent < 0 ? -exponent : exponent);
}

/* A line of the grid through the plot at a value. `to`: V or H, or with the length alone v or h. */
static void line_at(const struct svg_plot *plot, bool is_x, double value, char to)
{
    double end = (is_x ? plot->height : plot->width) + (to == 'V'   ? plot->top
                                                        : to == 'H' ? plot->left
                                                                    : 0.0);
    fprintf(plot->out, "M%.1f %.1f%c%.1f", is_x ? svg_x(plot, value) : plot->left,
            is_x ? plot->top : svg_y(plot, value), to, end);
}

/* Begins the number at a value, `below` the plot or left of it. */
static void begin_number(const struct svg_plot *plot, bool is_x, double value, double below,
                         const char *attributes)
{
    fprintf(plot->out, "<text%s x=\"%.1f\" y=\"%.1f\">", attributes,
            is_x ? svg_x(plot, value) : plot->left - 5.0,
            is_x ? plot->top + plot->height + below : svg_y(plot, value) + 4.0);
}

/* Twos to nines between decades: where they stand apart. */
static void minor_lines(const struct svg_plot *plot, bool is_x)
{
    const struct svg_axis *axis = is_x ? &plot->x : &plot->y;
    double decades = log10(axis->high / axis->low);
    if ((is_x ? plot->width : plot->height) / decades < 60.0)
        return;
    for (int e = (int)floor(log10(axis->low)); e <= (int)ceil(log10(axis->high)); e++) {
        for (int digit = 2; digit < 10; digit++) {
            double value = digit * pow(10.0, e);
            if (value <= axis->low || value >= axis->high)
                continue;
            fputs("<path class=\"minor\" d=\"", plot->out);
            line_at(plot, is_x, value, is_x ? 'v' : 'h');
            fputs("\"/>", plot->out);
        }
    }
}

static void log_ticks(const struct svg_plot *plot, bool is_x)
{
    const struct svg_axis *axis = is_x ? &plot->x : &plot->y;
    struct decades d = decades_of(axis,
                                  (unsigned)(is_x ? plot->width / 40.0 : plot->height / 18.0) + 1);
    minor_lines(plot, is_x);
    for (int e = d.first; e <= d.last; e += d.every) {
        double value = pow(10.0, e);
        fputs("<path class=\"grid\" d=\"", plot->out);
        line_at(plot, is_x, value, is_x ? 'V' : 'H');
        fputs("\"/>", plot->out);
        if (!axis->ticks)
            continue;
        begin_number(plot, is_x, value, 16.0,
                     is_x ? " class=\"tick\" text-anchor=\"middle\""
                          : " class=\"tick\" text-anchor=\"end\"");
        print_decade(plot->out, e);
    }
}

static struct svg_ticks ticks_of(const struct svg_plot *plot, bool is_x)
{
    const struct svg_axis *axis = is_x ? &plot->x : &plot->y;
    double most = is_x ? plot->width * TICKS_PER_PX_X : plot->height * TICKS_PER_PX_Y;
    return svg_choose_ticks(axis->low, axis->high, (unsigned)most + 2);
}

/* Lines of the grid at the ticks, in one path, and the numbers beside them, in one group. */
static void linear_ticks(const struct svg_plot *plot, bool is_x)
{
    FILE *out = plot->out;
    struct svg_ticks ticks = ticks_of(plot, is_x);
    fputs("<path class=\"grid\" d=\"", out);
    for (unsigned i = 0; i < ticks.count; i++)
        line_at(plot, is_x, ticks.first + (double)i * ticks.step, is_x ? 'V' : 'h');
    fputs("\"/>", out);
    if (!(is_x ? plot->x.ticks : plot->y.ticks))
        return;
    fprintf(out, "<g class=\"tick\" text-anchor=\"%s\">", is_x ? "middle" : "end");
    for (unsigned i = 0; i < ticks.count; i++) {
        double value = ticks.first + (double)i * ticks.step;
        begin_number(plot, is_x, value, 14.0, "");
        print_tick(out, value, ticks.decimals);
        fputs("</text>", out);
    }
    fputs("</g>", out);
}

/* How far left of the axis its label stands: beyond the numbers, and inside the picture. */
static double y_label_px(const struct svg_plot *plot)
{
    struct svg_ticks ticks = ticks_of(plot, false);
    double widest = 0.0;
    for (unsigned i = 0; i < ticks.count && plot->y.ticks && !plot->log_y; i++) {
        char text[40];
        snprintf(text, sizeof text, "%.*f", ticks.decimals, ticks.first + (double)i * ticks.step);
        widest = fmax(widest, svg_text_width(text, SVG_KEY_SIZE_PX));
    }
    return fmin(fmax(plot->log_y ? 46.0 : 40.0, widest + 10.0), plot->left - 11.0);
}

static void axis(const struct svg_plot *plot, bool is_x)
{
    FILE *out = plot->out;
    const char *label = is_x ? plot->x.label : plot->y.label;
    if (is_x ? plot->log_x : plot->log_y)
        log_ticks(plot, is_x);
    else
        linear_ticks(plot, is_x);
    if (!label)
        return;
    fputs("<text class=\"label\" text-anchor=\"middle\" ", out);
    if (is_x)
        fprintf(out, "x=\"%.1f\" y=\"%.1f\">", plot->left + plot->width / 2,
                plot->top + plot->height + 32.0);
    else
        fprintf(out, "transform=\"translate(%.1f %.1f) rotate(-90)\">",
                plot->left - y_label_px(plot), plot->top + plot->height / 2);
    html_text(out, label);
    fputs("</text>", out);
}

/* What the frame's edges stand for, where they are written: for who reads the picture
 * (host/report/closer.js). */
static void print_scale(FILE *out, const char *name, const struct svg_axis *axis, double before_px,
                        double after_px, double size_px)
{
    double per_px = (axis->high - axis->low) / size_px;
    fprintf(out, " data-%s=\"%.7g %.7g\"", name, axis->low - before_px * per_px,
            axis->high + after_px * per_px);
}

static double written_px(double px)
{
    return round(10.0 * px) / 10.0;
}

void svg_axes(const struct svg_plot *plot)
{
    axis(plot, true);
    axis(plot, false);
    fprintf(plot->out, "<rect class=\"frame\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"",
            plot->left, plot->top, plot->width, plot->height);
    if (!plot->log_x && !plot->log_y) {
        double left = plot->left - written_px(plot->left), top = plot->top - written_px(plot->top);
        double right = written_px(plot->width) - plot->width - left,
               foot = written_px(plot->height) - plot->height - top;
        print_scale(plot->out, "x", &plot->x, left, right, plot->width);
        print_scale(plot->out, "y", &plot->y, foot, top, plot->height);
    }
    fputs("/>\n", plot->out);
}

static double clip(double value, double low, double high)
{
    return value < low ? low : value > high ? high : value;
}

#define NO_COLUMN LONG_MIN

struct pixel {
    double x, y;
    unsigned long seen; /* it is the how manieth of its path */
};

/* The points of a path as they come, thinned twice: of a column of pixels the least and the
 * greatest stay, as they follow each other, and of these a point is left out where the straight
 * line past it stays within SVG_THINNED_PX of every one it stands for. What is written is always a
 * point that was given. */
struct pen {
    const struct svg_plot *plot;
    bool down, stepping;
    long column; /* NO_COLUMN: none */
    struct pixel least, most, last;
    struct pixel anchor;       /* last point written */
    long written_x, written_y; /* as it stands there, tenths of a pixel */
    bool held;                 /* a point that may yet be left out */
    struct pixel hold;
    double low_slope, high_slope; /* lines from the anchor that are near enough to all since */
};

/* Tenths of a pixel, as short as a path may have it: "-12.5", ".5", "3"; a blank before what has no
 * minus to part it. */
static void print_tenths(FILE *out, long tenths, bool parted)
{
    long size = labs(tenths);
    fputs(tenths < 0 ? "-" : parted ? "" : " ", out);
    if (size >= 10 || size == 0)
        fprintf(out, "%ld", size / 10);
    if (size % 10)
        fprintf(out, ".%ld", size % 10);
}

/* The first point as it is, the others as steps between the tenths that are written, so that
 * roundings do not add up. */
static void pen_write(struct pen *pen, struct pixel p)
{
    FILE *out = pen->plot->out;
    long x = lround(10.0 * p.x), y = lround(10.0 * p.y);
    if (!pen->down)
        fputc('M', out);
    else if (!pen->stepping)
        fputc('l', out); /* it holds for all that follow */
    print_tenths(out, pen->down ? x - pen->written_x : x, !pen->stepping);
    pen->stepping = pen->down;
    print_tenths(out, pen->down ? y - pen->written_y : y, false);
    pen->written_x = x;
    pen->written_y = y;
    pen->down = true;
    pen->held = false;
    pen->anchor = p;
    pen->low_slope = -HUGE_VAL;
    pen->high_slope = HUGE_VAL;
}

static void pen_release(struct pen *pen)
{
    if (pen->held)
        pen_write(pen, pen->hold);
}

/* Whether the point that is held can be left out when the line goes on to p. */
static bool pen_passes(const struct pen *pen, struct pixel p)
{
    double slope = (p.y - pen->anchor.y) / (p.x - pen->anchor.x);
    bool onward = (p.x - pen->hold.x) * (pen->hold.x - pen->anchor.x) > 0.0; /* no way back */
    return onward && slope >= pen->low_slope && slope <= pen->high_slope;
}

static void pen_point(struct pen *pen, struct pixel p)
{
    if (pen->held && !pen_passes(pen, p))
        pen_release(pen);
    double dx = p.x - pen->anchor.x;
    if (pen->down && fabs(dx) < 0.05 && fabs(p.y - pen->anchor.y) < 0.05)
        return; /* it stands there */
    if (!pen->down || !(fabs(dx) > 0.0)) {
        pen_write(pen, p);
        return;
    }
    double one = (p.y - SVG_THINNED_PX - pen->anchor.y) / dx,
           other = (p.y + SVG_THINNED_PX - pen->anchor.y) / dx;
    pen->low_slope = fmax(pen->low_slope, fmin(one, other));
    pen->high_slope = fmin(pen->high_slope, fmax(one, other));
    pen->held = true;
    pen->hold = p;
}

/* x alone does not order them: a line may go back. `seen` counts instead. */
static void pen_flush(struct pen *pen)
{
    if (pen->column == NO_COLUMN)
        return;
    bool fell = pen->least.seen > pen->most.seen;
    pen_point(pen, fell ? pen->most : pen->least);
    if (pen->most.y - pen->least.y > SVG_THINNED_PX)
        pen_point(pen, fell ? pen->least : pen->most);
    pen->column = NO_COLUMN;
}

/* The line ends where it ends. */
static void pen_lift(struct pen *pen)
{
    bool any = pen->column != NO_COLUMN;
    pen_flush(pen);
    pen_release(pen);
    if (any && (fabs(pen->last.x - pen->anchor.x) > SVG_THINNED_PX ||
                fabs(pen->last.y - pen->anchor.y) > SVG_THINNED_PX))
        pen_write(pen, pen->last);
}

static void pen_move(struct pen *pen, double x, double y)
{
    if (isnan(x) || isnan(y)) {
        pen_lift(pen);
        pen->down = pen->stepping = false;
        return;
    }
    const struct svg_plot *plot = pen->plot;
    struct pixel p = {clip(svg_x(plot, x), plot->left, plot->left + plot->width),
                      clip(svg_y(plot, y), plot->top, plot->top + plot->height),
                      pen->last.seen + 1};
    long column = (long)(p.x / (plot->column_px > 0.0 ? plot->column_px : 1.0));
    if (pen->down && column != pen->column)
        pen_flush(pen);
    if (!pen->down) {
        pen_write(pen, p); /* and it begins where it begins */
        pen->column = NO_COLUMN;
    }
    if (column != pen->column)
        pen->least = pen->most = p;
    pen->column = column;
    if (p.y < pen->least.y)
        pen->least = p;
    if (p.y > pen->most.y)
        pen->most = p;
    pen->last = p;
}

void svg_line(const struct svg_plot *plot, const char *class, const double *x, const double *y,
              size_t count)
{
    struct pen pen = {.plot = plot, .column = NO_COLUMN};
    fprintf(plot->out, "<path class=\"%s\" d=\"", class);
    for (size_t i = 0; i < count; i++)
        pen_move(&pen, x[i], y[i]);
    pen_lift(&pen);
    fputs("\"/>\n", plot->out);
}

void svg_band(const struct svg_plot *plot, const char *class, const double *x, const double *low,
              const double *high, size_t count)
{
    struct pen pen = {.plot = plot, .column = NO_COLUMN};
    fprintf(plot->out, "<path class=\"%s\" d=\"", class);
    for (size_t i = 0; i < count; i++)
        pen_move(&pen, isnan(low[i]) ? (double)NAN : x[i], high[i]);
    pen_lift(&pen);
    for (size_t i = count; i-- > 0;) {
        if (!isnan(low[i]) && !isnan(x[i]) && !isnan(high[i]))
            pen_move(&pen, x[i], low[i]);
    }
    pen_lift(&pen);
    fputs("Z\"/>\n", plot->out);
}

void svg_rect(const struct svg_plot *plot, const char *class, double x0, double y0, double x1,
              double y1)
{
    double left = clip(svg_x(plot, x0), plot->left, plot->left + plot->width);
    double right = clip(svg_x(plot, x1), plot->left, plot->left + plot->width);
    double top = clip(svg_y(plot, y1), plot->top, plot->top + plot->height);
    double bottom = clip(svg_y(plot, y0), plot->top, plot->top + plot->height);
    if (right > left && bottom > top)
        fprintf(plot->out,
                "<rect class=\"%s\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>\n",
                class, left, top, right - left, bottom - top);
}

void svg_dot(const struct svg_plot *plot, const char *class, double x, double y)
{
    if (!isnan(x) && !isnan(y))
        fprintf(plot->out, "<circle class=\"%s\" cx=\"%.1f\" cy=\"%.1f\" r=\"2.6\"/>\n", class,
                svg_x(plot, x), svg_y(plot, y));
}

void svg_dots(const struct svg_plot *plot, const char *class, const double *x, const double *y,
              size_t count)
{
    fprintf(plot->out, "<path class=\"%s\" d=\"", class);
    for (size_t i = 0; i < count; i++) {
        if (!(x[i] >= plot->x.low && x[i] <= plot->x.high && y[i] >= plot->y.low &&
              y[i] <= plot->y.high))
            continue;
        fputc('M', plot->out);
        print_tenths(plot->out, lround(10.0 * svg_x(plot, x[i])), true);
        print_tenths(plot->out, lround(10.0 * svg_y(plot, y[i])), false);
        fputs("h0", plot->out);
    }
    fputs("\"/>\n", plot->out);
}

void svg_mark(FILE *out, const char *class, unsigned shape, double px, double py, double radius)
{
    static const struct {
        int corners;
        double turn; /* of the first corner from upwards, in circles */
        double size; /* so that all look equally large */
    } shapes[SVG_SHAPES] = {{0, 0, 1},      {4, 0.125, 1.25}, {3, 0, 1.35}, {4, 0, 1.3},
                            {3, 0.5, 1.35}, {5, 0, 1.2},      {0, 0, 1}};
    const double circle = 6.283185307179586;
    unsigned i = shape % SVG_SHAPES;
    if (i == 0) {
        fprintf(out, "<circle class=\"%s\" cx=\"%.2f\" cy=\"%.2f\" r=\"%.2f\"/>\n", class, px, py,
                radius);
        return;
    }
    fprintf(out, "<path class=\"%s\" d=\"", class);
    if (shapes[i].corners == 0)
        fprintf(out, "M%.2f %.2fl%.2f %.2fm0 %.2fl%.2f %.2f\"/>\n", px - radius, py - radius,
                2 * radius, 2 * radius, -2 * radius, -2 * radius, 2 * radius);
    for (int k = 0; k < shapes[i].corners; k++) {
        double angle = circle * (shapes[i].turn + (double)k / shapes[i].corners);
        fprintf(out, "%s%.2f %.2f", k == 0 ? "M" : "L", px + radius * shapes[i].size * sin(angle),
                py - radius * shapes[i].size * cos(angle));
    }
    if (shapes[i].corners > 0)
        fputs("Z\"/>\n", out);
}

void svg_text(const struct svg_plot *plot, const char *class, const char *anchor, double x,
              double y, double dx, double dy, const char *text)
{
    fprintf(plot->out, "<text class=\"%s\" text-anchor=\"%s\" x=\"%.1f\" y=\"%.1f\">", class,
            anchor, svg_x(plot, x) + dx, svg_y(plot, y) + dy);
    html_text(plot->out, text);
    fputs("</text>\n", plot->out);
}
