#include "host/sweep/sweep_plot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/html.h"
#include "host/base/svg.h"
#include "host/base/svg_words.h"

#define WIDTH        900.0
#define RIGHT        14.0
#define LEFT         74.0
#define PLOT_HEIGHT  300.0
#define SMALL_WIDTH  248.0
#define SMALL_HEIGHT 180.0
#define ACROSS       3 /* small pictures in a row */
#define LOG_RATIO    50.0
#define RADIUS       3.4

/* ---- values ---- */

static int compare_values(const json_t *a, const json_t *b)
{
    if (json_is_number(a) && json_is_number(b)) {
        double x = json_number_value(a), y = json_number_value(b);
        return x < y ? -1 : x > y;
    }
    if (json_is_string(a) && json_is_string(b))
        return strcmp(json_string_value(a), json_string_value(b));
    return (int)json_typeof(a) - (int)json_typeof(b);
}

static int by_value(const void *a, const void *b)
{
    return compare_values(*(const json_t *const *)a, *(const json_t *const *)b);
}

static int by_levels(const void *a, const void *b)
{
    const struct sweep_levels *p = a, *q = b;
    if (p->sampled != q->sampled)
        return p->sampled ? 1 : -1;
    if (p->numeric != q->numeric)
        return p->numeric ? -1 : 1;
    return p->count > q->count ? -1 : p->count < q->count;
}

static bool is_sampled(const struct sweep_table *table, const struct sweep_levels *levels)
{
    for (size_t i = 0; i < table->study.axis_count; i++) {
        if (strcmp(table->study.axis[i].name, levels->key) == 0)
            return table->study.axis[i].u != NULL;
    }
    return levels->numeric && table->count > 12 && levels->count > table->count / 2;
}

static void fill_levels(const struct sweep_table *table, struct sweep_levels *levels)
{
    size_t kept = 0;
    levels->value = calloc(table->count + 1, sizeof *levels->value);
    levels->numeric = true;
    for (size_t i = 0; levels->value && i < table->count; i++) {
        const json_t *value = sweep_table_value(&table->rows[i], levels->key);
        if (!value)
            continue;
        levels->value[levels->count++] = value;
        levels->numeric &= json_is_number(value);
    }
    if (!levels->value || levels->count == 0)
        return;
    qsort(levels->value, levels->count, sizeof *levels->value, by_value);
    for (size_t i = 0; i < levels->count; i++) {
        if (kept == 0 || compare_values(levels->value[kept - 1], levels->value[i]) != 0)
            levels->value[kept++] = levels->value[i];
    }
    levels->count = kept;
    levels->sampled = is_sampled(table, levels);
}

struct sweep_levels *sweep_levels_of(const struct sweep_table *table, size_t *count)
{
    *count = json_array_size(table->keys);
    struct sweep_levels *levels = calloc(*count + 1, sizeof *levels);
    if (!levels)
        *count = 0;
    for (size_t i = 0; i < *count; i++) {
        levels[i].key = json_string_value(json_array_get(table->keys, i));
        fill_levels(table, &levels[i]);
    }
    if (levels)
        qsort(levels, *count, sizeof *levels, by_levels);
    return levels;
}

void sweep_levels_free(struct sweep_levels *levels, size_t count)
{
    for (size_t i = 0; i < count; i++)
        free(levels[i].value);
    free(levels);
}

static const char *verdict_of(const struct table_row *row)
{
    const char *verdict =
        json_string_value(json_object_get(json_object_get(row->line, "find"), "verdict"));
    return verdict ? verdict : "";
}

double sweep_quantity_of(const struct table_row *row, const struct sweep_quantity *quantity,
                         double *low)
{
    const json_t *find = json_object_get(row->line, "find");
    if (quantity->field) {
        double value = sweep_table_number(sweep_table_field(row, quantity->field));
        if (low)
            *low = value;
        return value;
    }
    double from = sweep_table_number(json_object_get(find, "low")),
           to = sweep_table_number(json_object_get(find, "high"));
    if (low)
        *low = isnan(from) ? to : from;
    return isnan(to) ? from : to;
}

static const char *label_of(const struct sweep_table *table, const char *name)
{
    return json_string_value(json_object_get(json_object_get(table->study.root, "labels"), name));
}

void sweep_key_label(const struct sweep_table *table, const char *key, char *text)
{
    const char *label = label_of(table, key);
    snprintf(text, 200, "%s", label ? label : key);
}

void sweep_quantity_label(const struct sweep_table *table, const struct sweep_quantity *quantity,
                          char *text)
{
    const char *key = NULL;
    if (quantity->field) {
        sweep_key_label(table, quantity->field, text);
        return;
    }
    for (size_t i = 0; i < table->count && !key; i++)
        key =
            json_string_value(json_object_get(json_object_get(table->rows[i].line, "find"), "key"));
    const char *label = key ? label_of(table, key) : NULL;
    snprintf(text, 200, "threshold of %s", label ? label : key ? key : "?");
}

/* ---- axes ---- */

struct axis_range {
    double low, high;
    bool log;
    double scale; /* values are multiplied by it */
    char label[240];
};

static void cover(struct axis_range *range, double value)
{
    if (isnan(value))
        return;
    range->low = fmin(range->low, value);
    range->high = fmax(range->high, value);
}

/* Logarithmic when the values lie over decades (two of them to be numbered), unless the study steps
 * through them evenly, or when it steps through them so; else in thousands or millions when they
 * are large. */
static void settle(struct axis_range *range, const char *label, const struct design_range *stepped)
{
    double low = range->low, high = range->high;
    bool even = stepped && !stepped->levels && !stepped->log, by_ratio = stepped && stepped->log;
    range->scale = 1.0;
    range->log = low > 0.0 && !even && (by_ratio || high / low >= LOG_RATIO) &&
                 floor(log10(high * 1.1)) - ceil(log10(low / 1.1)) >= 1.0;
    snprintf(range->label, sizeof range->label, "%.200s", label);
    if (range->log) {
        range->low = low / 1.15;
        range->high = high * 1.15;
        return;
    }
    double most = fmax(fabs(low), fabs(high));
    if (most >= 1e4) {
        range->scale = most >= 1e7 ? 1e-6 : 1e-3;
        snprintf(range->label, sizeof range->label, "%.200s, %s", label,
                 most >= 1e7 ? "millions" : "thousands");
    }
    range->low = low * range->scale;
    range->high = high * range->scale;
    svg_widen(&range->low, &range->high, fmax(1e-9, 1e-3 * most * range->scale));
}

static struct axis_range empty_range(void)
{
    return (struct axis_range){HUGE_VAL, -HUGE_VAL, false, 1.0, ""};
}

/* The range of a quantity over all cases: pictures of one quantity share it. */
static bool quantity_range(const struct sweep_table *table, const struct sweep_quantity *quantity,
                           struct axis_range *range)
{
    char label[200];
    *range = empty_range();
    for (size_t i = 0; i < table->count; i++) {
        double low, value = sweep_quantity_of(&table->rows[i], quantity, &low);
        cover(range, value);
        cover(range, low);
    }
    if (!(range->high >= range->low))
        return false;
    sweep_quantity_label(table, quantity, label);
    settle(range, label,
           quantity->field || !table->study.find.wanted ? NULL : &table->study.find.key.range);
    return true;
}

static void key_range(const struct sweep_table *table, const struct sweep_levels *levels,
                      struct axis_range *range)
{
    char label[200];
    *range = empty_range();
    for (size_t i = 0; i < levels->count; i++)
        cover(range, sweep_table_number(levels->value[i]));
    const struct design_range *stepped = NULL;
    for (size_t i = 0; i < table->study.axis_count; i++) {
        if (strcmp(table->study.axis[i].name, levels->key) == 0)
            stepped = &table->study.axis[i].range;
    }
    sweep_key_label(table, levels->key, label);
    settle(range, label, stepped);
}

static void set_axes(struct svg_plot *plot, const struct axis_range *x, const struct axis_range *y)
{
    plot->x = (struct svg_axis){x->low, x->high, x->label, true};
    plot->y = (struct svg_axis){y->low, y->high, y->label, true};
    plot->log_x = x->log;
    plot->log_y = y->log;
}

/* ---- drawing ---- */

struct drawing {
    const struct sweep_table *table;
    const struct sweep_levels *levels; /* [0]: x, [1]: series */
    size_t level_count;
    const struct sweep_quantity *quantity;
    struct axis_range x, y;
};

static bool has(const struct table_row *row, const struct sweep_levels *levels, size_t level)
{
    const json_t *value = sweep_table_value(row, levels->key);
    return value && compare_values(value, levels->value[level]) == 0;
}

/* Which levels of a key are drawn when there are more than can be told apart: even steps, the ends
 * among them. */
static size_t shown_level(const struct sweep_levels *levels, size_t k, size_t most)
{
    if (levels->count <= most)
        return k;
    return (size_t)lround((double)k * (double)(levels->count - 1) / (double)(most - 1));
}

static size_t shown_count(const struct sweep_levels *levels, size_t most)
{
    return levels->count < most ? levels->count : most;
}

/* A mark, with the bracket of a threshold; where the search met an end of its range a triangle says
 * on which side it lies. */
static void mark(const struct svg_plot *plot, const struct drawing *d, const struct table_row *row,
                 unsigned series)
{
    char dot[20], line[20];
    double low, value = sweep_quantity_of(row, d->quantity, &low);
    double x = sweep_table_number(sweep_table_value(row, d->levels[0].key));
    if (isnan(value) || isnan(x))
        return;
    double px = svg_x(plot, x * d->x.scale), py = svg_y(plot, value * d->y.scale),
           low_py = svg_y(plot, low * d->y.scale);
    snprintf(dot, sizeof dot, "dot s%u", series);
    snprintf(line, sizeof line, "line s%u", series);
    const char *verdict = d->quantity->field ? "" : verdict_of(row);
    if (strcmp(verdict, "none") == 0)
        svg_mark(plot->out, line, 2, px, py, RADIUS + 1.0);
    else if (strcmp(verdict, "at_most") == 0)
        svg_mark(plot->out, line, 4, px, py, RADIUS + 1.0);
    else
        svg_mark(plot->out, dot, 0, px, py, RADIUS);
    if (fabs(low_py - py) > 0.5)
        fprintf(plot->out, "<path class=\"%s\" d=\"M%.1f %.1fV%.1f\"/>\n", line, px, py, low_py);
}

/* One line for a series: the mean where several cases share an x (sampled keys). Thresholds beyond
 * the range break it. */
static void draw_series(const struct svg_plot *plot, const struct drawing *d, const bool *shown,
                        unsigned series)
{
    const struct sweep_levels *x = &d->levels[0];
    double *xs = calloc(x->count, sizeof *xs), *ys = calloc(x->count, sizeof *ys);
    char class[20];
    snprintf(class, sizeof class, "line s%u", series);
    for (size_t k = 0; xs && ys && k < x->count; k++) {
        double sum = 0.0;
        size_t count = 0;
        for (size_t i = 0; i < d->table->count; i++) {
            const struct table_row *row = &d->table->rows[i];
            double value = sweep_quantity_of(row, d->quantity, NULL);
            if (!shown[i] || !has(row, x, k) || isnan(value) ||
                (!d->quantity->field && strcmp(verdict_of(row), "between") != 0))
                continue;
            sum += value;
            count++;
        }
        xs[k] = sweep_table_number(x->value[k]) * d->x.scale;
        ys[k] = count ? sum / (double)count * d->y.scale : (double)NAN;
    }
    if (xs && ys)
        svg_line(plot, class, xs, ys, x->count);
    free(xs);
    free(ys);
    for (size_t i = 0; i < d->table->count; i++) {
        if (shown[i])
            mark(plot, d, &d->table->rows[i], series);
    }
}

void sweep_value_text(const json_t *value, char *text, size_t size)
{
    if (json_is_string(value)) {
        snprintf(text, size, "%s", json_string_value(value));
    } else if (json_is_number(value)) {
        snprintf(text, size, "%.6g", json_number_value(value));
    } else {
        char *dumped = json_dumps(value, JSON_ENCODE_ANY | JSON_COMPACT | JSON_REAL_PRECISION(6));
        snprintf(text, size, "%s", dumped ? dumped : "");
        free(dumped);
    }
}

/* Of a place deep inside a campaign the last part is the telling one:
 * landings.0.apply.cleat_every. */
static const char *short_key(const char *key)
{
    const char *dot = strrchr(key, '.');
    return dot && (dot[1] < '0' || dot[1] > '9') ? dot + 1 : key;
}

struct legend {
    char text[SWEEP_SERIES_MAX][60], class[SWEEP_SERIES_MAX][20];
    struct svg_key key[SWEEP_SERIES_MAX];
    size_t count;
};

static void make_legend(struct legend *legend, const struct sweep_levels *by)
{
    legend->count = shown_count(by, SWEEP_SERIES_MAX);
    for (size_t k = 0; k < legend->count; k++) {
        char value[40];
        sweep_value_text(by->value[shown_level(by, k, SWEEP_SERIES_MAX)], value, sizeof value);
        snprintf(legend->text[k], sizeof legend->text[k], "%.16s %s", short_key(by->key), value);
        snprintf(legend->class[k], sizeof legend->class[k], "line s%zu", k);
        legend->key[k] = (struct svg_key){legend->class[k], legend -> text[k]};
    }
}

/* Lines for the cases that `rest` lets through. */
static void draw_lines(FILE *out, const struct drawing *d, const bool *rest, const char *title)
{
    struct svg_plot plot = {.out = out,
                            .left = LEFT,
                            .top = 26.0,
                            .width = WIDTH - LEFT - RIGHT,
                            .height = PLOT_HEIGHT};
    struct legend legend = {.count = 0};
    bool *shown = calloc(d->table->count + 1, sizeof *shown);
    size_t series = d->level_count > 1 && !d->levels[1].sampled
                      ? shown_count(&d->levels[1], SWEEP_SERIES_MAX)
                      : 1;
    set_axes(&plot, &d->x, &d->y);
    if (series > 1)
        make_legend(&legend, &d->levels[1]);
    plot.top += SVG_KEY_ROW_PX *
                (double)(svg_legend_rows(LEFT, WIDTH - RIGHT, legend.key, legend.count) - 1);
    svg_open(out, WIDTH, plot.top + PLOT_HEIGHT + 44.0, title);
    svg_axes(&plot);
    for (size_t k = 0; shown && k < series; k++) {
        for (size_t i = 0; i < d->table->count; i++)
            shown[i] = rest[i] &&
                       (series == 1 || has(&d->table->rows[i], &d->levels[1],
                                           shown_level(&d->levels[1], k, SWEEP_SERIES_MAX)));
        draw_series(&plot, d, shown, (unsigned)k);
    }
    svg_legend(out, LEFT, WIDTH - RIGHT, 14.0, legend.key, legend.count);
    svg_close(out);
    free(shown);
}

static void caption(FILE *out, const struct drawing *d, const char *panel)
{
    char label[200];
    fputs("<figcaption>", out);
    sweep_quantity_label(d->table, d->quantity, label);
    html_text(out, label);
    fputs(" against ", out);
    sweep_key_label(d->table, d->levels[0].key, label);
    html_text(out, label);
    if (*panel) {
        fputs(", ", out);
        html_text(out, panel);
    }
    if (d->level_count > 1 && !d->levels[1].sampled && d->levels[1].count > SWEEP_SERIES_MAX)
        fprintf(out, "; %d of %zu values of the second key", SWEEP_SERIES_MAX, d->levels[1].count);
    if (!d->quantity->field)
        fputs(". A dot is the upper end of its bracket; a triangle pointing up: not beyond the "
              "level in the whole range; pointing down: "
              "beyond it at the low end already",
              out);
    fputs(".</figcaption></figure>\n", out);
}

/* The combination of the levels from [2] on, counted from 0; false: there is no such one. */
static bool panel_text(const struct drawing *d, size_t panel, bool *rest, char *text, size_t size)
{
    text[0] = '\0';
    for (size_t i = 0; i < d->table->count; i++)
        rest[i] = true;
    for (size_t k = 2; k < d->level_count; k++) {
        const struct sweep_levels *levels = &d->levels[k];
        char value[40];
        if (levels->sampled || levels->count == 0)
            continue;
        size_t level = panel % levels->count, used = strlen(text);
        panel /= levels->count;
        sweep_value_text(levels->value[level], value, sizeof value);
        snprintf(text + used, size - used, "%s%.40s %s", used ? ", " : "", levels->key, value);
        for (size_t i = 0; i < d->table->count; i++)
            rest[i] = rest[i] && has(&d->table->rows[i], levels, level);
    }
    return panel == 0;
}

static void draw_panels(FILE *out, const struct drawing *d)
{
    bool *rest = calloc(d->table->count + 1, sizeof *rest);
    char text[200], title[200];
    sweep_quantity_label(d->table, d->quantity, title);
    for (size_t panel = 0; rest && panel_text(d, panel, rest, text, sizeof text); panel++) {
        if (panel == SWEEP_PANELS_MAX) {
            fprintf(out, "<p>Further combinations of the other keys are in the table only.</p>\n");
            break;
        }
        fputs("<figure>", out);
        draw_lines(out, d, rest, title);
        caption(out, d, text);
    }
    free(rest);
}

/* Which of the series a row is of: by its value of a key, of those that are shown.
 * SWEEP_SERIES_MAX: none. */
static unsigned series_of(const struct table_row *row, const struct sweep_levels *by)
{
    for (size_t k = 0; by && k < shown_count(by, SWEEP_SERIES_MAX); k++) {
        if (has(row, by, shown_level(by, k, SWEEP_SERIES_MAX)))
            return (unsigned)k;
    }
    return by ? SWEEP_SERIES_MAX : 0;
}

static void draw_dots(FILE *out, const struct sweep_table *table, const struct sweep_levels *levels,
                      size_t place, double top, const struct sweep_levels *by,
                      const struct sweep_quantity *quantity, const struct axis_range *y)
{
    struct drawing d = {table, levels, 1, quantity, empty_range(), *y};
    struct svg_plot plot = {.out = out,
                            .left = 62.0 + (double)(place % ACROSS) * (SMALL_WIDTH + 40.0),
                            .width = SMALL_WIDTH - 20.0,
                            .top = top + (double)(place / ACROSS) * (SMALL_HEIGHT + 56.0),
                            .height = SMALL_HEIGHT};
    key_range(table, levels, &d.x);
    if (place % ACROSS)
        d.y.label[0] = '\0';
    set_axes(&plot, &d.x, &d.y);
    svg_axes(&plot);
    for (size_t i = 0; i < table->count; i++) {
        unsigned series = series_of(&table->rows[i], by);
        if (series < SWEEP_SERIES_MAX)
            mark(&plot, &d, &table->rows[i], series);
    }
}

/* Sampled keys: dots against each of them, pictures in rows, coloured by a stepped key if there is
 * one. */
static void draw_scatter(FILE *out, const struct sweep_table *table,
                         const struct sweep_levels *levels, size_t count,
                         const struct sweep_levels *by, const struct sweep_quantity *quantity,
                         const struct axis_range *y)
{
    char title[200];
    struct legend legend = {.count = 0};
    size_t rows = (count + ACROSS - 1) / ACROSS;
    sweep_quantity_label(table, quantity, title);
    fputs("<figure>", out);
    if (by)
        make_legend(&legend, by);
    double top = 26.0 +
                 SVG_KEY_ROW_PX *
                     (double)(svg_legend_rows(LEFT, WIDTH - RIGHT, legend.key, legend.count) - 1);
    svg_open(out, WIDTH, top - 2.0 + (double)rows * (SMALL_HEIGHT + 56.0), title);
    svg_legend(out, LEFT, WIDTH - RIGHT, 14.0, legend.key, legend.count);
    for (size_t k = 0; k < count; k++)
        draw_dots(out, table, &levels[k], k, top, by, quantity, y);
    svg_close(out);
    fputs("<figcaption>", out);
    html_text(out, title);
    fputs(" against each sampled key; all of them vary at once.</figcaption></figure>\n", out);
}

void sweep_plot(FILE *out, const struct sweep_table *table, const struct sweep_levels *levels,
                size_t level_count, const struct sweep_quantity *quantity)
{
    struct drawing d = {
        .table = table, .levels = levels, .level_count = level_count, .quantity = quantity};
    size_t stepped = 0;
    while (stepped < level_count && !levels[stepped].sampled)
        stepped++;
    if (level_count == 0 || !quantity_range(table, quantity, &d.y))
        return;
    if (stepped > 0 && levels[0].numeric && levels[0].count > 1) {
        key_range(table, &levels[0], &d.x);
        draw_panels(out, &d);
    }
    size_t numeric = stepped;
    while (numeric < level_count && levels[numeric].numeric)
        numeric++;
    if (numeric > stepped)
        draw_scatter(out, table, &levels[stepped], numeric - stepped,
                     stepped > 0 ? &levels[0] : NULL, quantity, &d.y);
}
