#include "host/report/chart.h"

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/html.h"
#include "host/base/xmalloc.h"

#define COLUMNS_FULL_WIDTH 120u /* number of columns of a plot that has a row of its own */
#define COLUMNS_SHARED_ROW 80u
/* number of steps of a coordinate across the plot, finer than a pixel */
#define COORDINATE_STEPS   2500.0
#define DECIMALS_MAX       9
/* height of title, label and margin of a plot, which the page reserves until the plot is drawn */
#define MARGIN_PX          40u

/* ---- JSON inside <script> ---- */

static void write_json_text(FILE *out, const char *text)
{
    putc('"', out);
    for (; *text; text++) {
        unsigned char c = (unsigned char)*text;
        if (c < 0x20 || c == '"' || c == '\\' || c == '<' || c == '>' || c == '&')
            fprintf(out, "\\u%04x", c);
        else
            putc(c, out);
    }
    putc('"', out);
}

static void write_json_text_member(FILE *out, const char *name, const char *text)
{
    fprintf(out, ",\"%s\":", name);
    write_json_text(out, text ? text : "");
}

/* Writes the axis label, such as "displacement (in)"; "" if the axis has no name. */
static void write_axis(FILE *out, const char *name, const char *what, const struct unit *unit)
{
    char label[CHART_LABEL_SIZE] = "";
    if (what)
        snprintf(label, sizeof label, unit->text[0] ? "%s (%s)" : "%s", what, unit->text);
    write_json_text_member(out, name, label);
}

static void write_number(FILE *out, double value)
{
    if (isfinite(value))
        fprintf(out, "%.6g", value);
    else
        fputs("null", out);
}

/* Writes an integer. Faster than fprintf, because a page of 400 landings has about ten million
 * integers. */
static void write_integer(FILE *out, int64_t value)
{
    char digits[24];
    size_t at = sizeof digits;
    uint64_t left = value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
    do
        digits[--at] = (char)('0' + left % 10);
    while (left /= 10);
    if (value < 0)
        digits[--at] = '-';
    fwrite(digits + at, 1, sizeof digits - at, out);
}

/* ---- thinning ---- */

struct points {
    size_t *index, count;
};

/* Keeps points of a column: the lowest, the highest, and one gap, so that gaps remain visible. The
 * points keep their order, and each is kept once. */
static void select_column_points(struct points *kept, const double *y, size_t from, size_t to)
{
    size_t least = to, most = to, hole = to;
    for (size_t i = from; i < to; i++) {
        if (isnan(y[i])) {
            hole = i;
            continue;
        }
        least = least == to || y[i] < y[least] ? i : least;
        most = most == to || y[i] > y[most] ? i : most;
    }
    for (size_t i = from; i < to; i++) {
        if (i == least || i == most || i == hole)
            kept->index[kept->count++] = i;
    }
}

/* Reduces a series to the given number of columns of equal width in x. */
static struct points thin_series(const struct chart_series *s, size_t columns)
{
    struct points kept = {xmalloc((s->count + 1) * sizeof *kept.index), 0};
    if (s->count <= 2 * columns) {
        for (; kept.count < s->count; kept.count++)
            kept.index[kept.count] = kept.count;
        return kept;
    }
    size_t begin = 0;
    while (begin + 1 < s->count && isnan(s->x[begin]))
        begin++;
    double from = s->x[begin], width = (s->x[s->count - 1] - from) / (double)columns;
    for (size_t first = begin, next; first < s->count; first = next) {
        double column = floor((s->x[first] - from) / width);
        for (next = first + 1; next < s->count; next++) {
            if (floor((s->x[next] - from) / width) != column)
                break;
        }
        select_column_points(&kept, s->y, first, next);
    }
    if (kept.index[kept.count - 1] != s->count - 1)
        kept.index[kept.count++] = s->count - 1;
    return kept;
}

/* ---- numbers ---- */

static int choose_decimals(const struct chart_series *s, const double *values, double factor)
{
    double low = (double)INFINITY, high = -(double)INFINITY;
    for (size_t i = 0; i < s->count; i++) {
        low = fmin(low, factor * values[i]);
        high = fmax(high, factor * values[i]);
    }
    double size = high > low ? high - low : fabs(high) > 0.0 && isfinite(high) ? fabs(high) : 1.0;
    int decimals = (int)ceil(log10(COORDINATE_STEPS / size));
    return decimals < 0 ? 0 : decimals > DECIMALS_MAX ? DECIMALS_MAX : decimals;
}

/* Writes the number of decimals, then integers. Each integer is the difference from the previous
 * value, which is short because curves are smooth. */
static void write_values(FILE *out, const char *name, const struct points *kept,
                         const double *values, double factor, int decimals)
{
    const double scale = factor * pow(10.0, decimals);
    int64_t before = 0;
    fprintf(out, ",\"%s\":[%d", name, decimals);
    for (size_t k = 0; k < kept->count; k++) {
        double value = scale * values[kept->index[k]];
        putc(',', out);
        if (!(fabs(value) < 9e15)) {
            fputs("null", out);
            continue;
        }
        write_integer(out, llround(value) - before);
        before = llround(value);
    }
    putc(']', out);
}

/* ---- a figure ---- */

struct figure figure_begin(FILE *out, bool si, const char *what, unsigned columns, unsigned range)
{
    fprintf(out,
            "<figure class=\"chart\" role=\"group\" aria-label=\"%s\"><script "
            "type=\"application/json\">{\"share\":%u,\"zero\":%u,\"p\":[",
            what, range & FIGURE_RANGE_SHARED, range & FIGURE_RANGE_WITH_ZERO);
    return (struct figure){.out = out, .si = si, .plots_per_row = columns};
}

static void end_plot(struct figure *figure)
{
    if (figure->plot_count)
        fputs("]}", figure->out);
    figure->has_items = false;
}

static void write_range(FILE *out, const char *name, double low, double high)
{
    if (low == high)
        return;
    fprintf(out, ",\"%s\":[", name);
    write_number(out, low);
    putc(',', out);
    write_number(out, high);
    putc(']', out);
}

void figure_begin_plot(struct figure *figure, const struct chart_axes *axes)
{
    FILE *out = figure->out;
    end_plot(figure);
    fprintf(out, "%s{\"h\":%u", figure->plot_count ? "," : "", axes->height_px);
    figure->plot_count++;
    figure->height_px += axes->height_px + MARGIN_PX;
    write_json_text_member(out, "t", axes->title);
    figure->x = unit_get(axes->x_unit, figure->si);
    figure->y = unit_get(axes->y_unit, figure->si);
    write_axis(out, "x", axes->x, figure->x);
    write_axis(out, "y", axes->y, figure->y);
    write_range(out, "xr", figure->x->factor * axes->x_low, figure->x->factor * axes->x_high);
    write_range(out, "yr", figure->y->factor * axes->y_low, figure->y->factor * axes->y_high);
    for (size_t i = 0; i < axes->tick_count; i++) {
        if (i == 0)
            fputs(",\"yt\":[", out);
        fprintf(out, "%s[%.1f,", i ? "," : "", (double)i + 0.5);
        write_json_text(out, axes->tick_name(axes->context, i));
        putc(']', out);
    }
    fputs(axes->tick_count ? "],\"i\":[" : ",\"i\":[", out);
}

static void begin_item(struct figure *figure)
{
    if (figure->has_items)
        fputs(",\n", figure->out);
    figure->has_items = true;
}

void figure_add_series(struct figure *figure, const struct chart_series *s)
{
    FILE *out = figure->out;
    struct points kept = thin_series(s, figure->plots_per_row > 2 ? COLUMNS_SHARED_ROW
                                                                  : COLUMNS_FULL_WIDTH);
    begin_item(figure);
    fprintf(out, "{\"l\":%u,\"k\":\"%s\"", s->style, s->kind);
    if (s->name)
        write_json_text_member(out, "n", s->name);
    const double x = figure->x->factor, y = figure->y->factor;
    const int decimals = choose_decimals(s, s->y, y);
    write_values(out, "x", &kept, s->x, x, choose_decimals(s, s->x, x));
    write_values(out, "y", &kept, s->y, y, decimals);
    if (s->half_width)
        write_values(out, "e", &kept, s->half_width, y, decimals + 1);
    putc('}', out);
    free(kept.index);
}

/* Returns the place of a kind of shape among those written so far, or the first free place. */
static const char **find_shape_kind(struct figure *figure, const char *kind)
{
    const char **place = figure->shape_kind;
    while (*place && strcmp(*place, kind) != 0)
        place++;
    return place;
}

void figure_add_shape(struct figure *figure, const char *kind, double x0, double x1, double y0,
                      double y1, const char *text)
{
    FILE *out = figure->out;
    const double x = figure->x->factor, y = figure->y->factor,
                 corner[4] = {x * x0, x * x1, y * y0, y * y1};
    *find_shape_kind(figure, kind) = kind;
    begin_item(figure);
    fprintf(out, "[\"%s\"", kind);
    for (int i = 0; i < 4; i++) {
        putc(',', out);
        write_number(out, corner[i]);
    }
    if (text) {
        putc(',', out);
        write_json_text(out, text);
    }
    putc(']', out);
}

void figure_end(struct figure *figure, const char *const *keys, const char *caption, ...)
{
    FILE *out = figure->out;
    va_list arguments;
    end_plot(figure);
    fputs("],\"k\":[", out);
    const char *separator = "";
    for (size_t i = 0; keys && keys[i]; i += 2) {
        if (!*find_shape_kind(figure, keys[i]))
            continue;
        fprintf(out, "%s[", separator);
        separator = ",";
        write_json_text(out, keys[i]);
        putc(',', out);
        write_json_text(out, keys[i + 1]);
        putc(']', out);
    }
    fprintf(
        out,
        "]}</script><p class=\"keys\"></p><div class=\"plots c%u\" style=\"--n:%u;--h:%upx\"></div>"
        "<figcaption>",
        figure->plots_per_row, figure->plot_count,
        figure->plot_count ? figure->height_px / figure->plot_count : 0);
    va_start(arguments, caption);
    vfprintf(out, caption, arguments);
    va_end(arguments);
    fputs("</figcaption></figure>\n", out);
}
