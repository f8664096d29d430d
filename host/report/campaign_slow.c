/* The slow log as three plots over one another: how far the mat has moved since the first row, mean
 * tension of the gages, temperature. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/report/chart.h"
#include "host/report/report.h"

#define HEIGHT  120.0
#define STEP    (HEIGHT + 14.0)
#define HOUR_US 3600e6

/* Whose time is known, else those of the boot that has most of them. */
static bool belongs(const struct store_slow *row, bool dated, int64_t boot)
{
    return dated ? row->time_us != STORE_NONE : row->boot == boot;
}

static int64_t longest_boot(const struct store_slow *rows, size_t count)
{
    size_t in_boot[256] = {0}, best = 0;
    for (size_t i = 0; i < count; i++)
        in_boot[rows[i].boot & 255]++;
    for (size_t i = 1; i < 256; i++) {
        if (in_boot[i] > in_boot[best])
            best = i;
    }
    return (int64_t)best;
}

/* The rows that are drawn, of the first board among them, with their hours. */
static size_t choose(const struct store_slow *rows, size_t count, const struct store_slow **chosen,
                     double *hours, bool *dated)
{
    size_t n = 0, with_time = 0;
    for (size_t i = 0; i < count; i++)
        with_time += rows[i].time_us != STORE_NONE;
    *dated = with_time >= 2;
    int64_t boot = longest_boot(rows, count);
    for (size_t i = 0; i < count; i++) {
        if (!belongs(&rows[i], *dated, boot) ||
            (n && strcmp(rows[i].board_uid, chosen[0]->board_uid) != 0))
            continue;
        chosen[n] = &rows[i];
        hours[n] = *dated ? (double)(rows[i].time_us - chosen[0]->time_us) / HOUR_US
                          : (double)(rows[i].block - chosen[0]->block) * 1000.0 / HOUR_US;
        n++;
    }
    return n;
}

static double mean_tension(const struct store_slow *row)
{
    double sum = 0.0;
    unsigned count = 0;
    for (unsigned i = 0; i < MR_GAGES; i++) {
        if (isnan(row->tension_lb[i]))
            continue;
        sum += row->tension_lb[i];
        count++;
    }
    return count ? sum / count : (double)NAN;
}

static struct svg_plot panel(FILE *out, unsigned place, const double *hours, size_t count,
                             double low, double high, double least, const char *y_label,
                             const char *x_label)
{
    if (!(low <= high))
        low = high = 0.0;
    svg_widen(&low, &high, least);
    struct svg_plot plot = {.out = out,
                            .left = CHART_LEFT,
                            .top = 26.0 + STEP * place,
                            .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                            .height = HEIGHT};
    plot.x = (struct svg_axis){0.0, hours[count - 1], x_label, x_label != NULL};
    plot.y = (struct svg_axis){low, high, y_label, true};
    svg_axes(&plot);
    return plot;
}

static void draw_movement(FILE *out, const struct store_slow *const *rows, const double *hours,
                          size_t count, double *values, bool si)
{
    const struct unit *unit = unit_of(UNIT_DISPLACEMENT, si);
    char label[60];
    double low = (double)INFINITY, high = -(double)INFINITY;
    for (unsigned c = 0; c < MR_TRANSDUCERS; c++) {
        for (size_t i = 0; i < count; i++)
            values[c * count + i] = unit->factor *
                                    (rows[i]->displacement_in[c] - rows[0]->displacement_in[c]);
        chart_extend(values + c * count, count, &low, &high);
    }
    snprintf(label, sizeof label, "moved, %s", unit->text);
    struct svg_plot plot = panel(out, 0, hours, count, low, high, 0.01 * unit->factor, label, NULL);
    for (unsigned c = 0; c < MR_TRANSDUCERS; c++) {
        chart_line(&plot, c, hours, values + c * count, count, count / 10 + 1);
        double last = values[c * count + count - 1];
        snprintf(label, sizeof label, "%u", c + 1);
        if (!isnan(last))
            svg_text(&plot, "label", "start", hours[count - 1], last, 3.0, 4.0, label);
    }
}

static void draw_one(FILE *out, unsigned place, const double *hours, const double *values,
                     size_t count, double least, const char *label, const char *x_label)
{
    double low = (double)INFINITY, high = -(double)INFINITY;
    chart_extend(values, count, &low, &high);
    struct svg_plot plot = panel(out, place, hours, count, low, high, least, label, x_label);
    svg_line(&plot, "line a", hours, values, count);
}

/* False: fewer than two rows of one board whose time, or boot, is known; nothing was drawn. */
static bool draw(FILE *out, const struct store_slow *rows, size_t count, bool si)
{
    const struct unit *unit = unit_of(UNIT_TENSION, si);
    const struct store_slow **chosen = calloc(count + 1, sizeof *chosen);
    double *hours = calloc(count + 1, sizeof *hours),
           *values = calloc(MR_TRANSDUCERS * (count + 1), sizeof *values);
    char label[60];
    bool dated;
    if (!chosen || !hours || !values)
        abort();
    size_t n = choose(rows, count, chosen, hours, &dated);
    bool draws = n >= 2 && hours[n - 1] > 0.0;
    if (draws) {
        svg_open(out, CHART_WIDTH, 26.0 + 3 * STEP + 26.0,
                 "movement, tension and temperature against time");
        draw_movement(out, chosen, hours, n, values, si);
        for (size_t i = 0; i < n; i++)
            values[i] = unit->factor * mean_tension(chosen[i]);
        snprintf(label, sizeof label, "mean tension, %s", unit->text);
        draw_one(out, 1, hours, values, n, unit->factor, label, NULL);
        for (size_t i = 0; i < n; i++)
            values[i] = chosen[i]->temperature_c;
        draw_one(out, 2, hours, values, n, 0.5, "temperature, C",
                 dated ? "time since the first row, h" : "board time since the first row, h");
        svg_close(out);
    }
    free(chosen);
    free(hours);
    free(values);
    return draws;
}

enum mr_status campaign_slow(const struct report *report, FILE *out, struct error *error)
{
    char *picture = NULL;
    size_t size = 0;
    FILE *into = open_memstream(&picture, &size);
    (void)error;
    if (!into)
        abort();
    bool drawn = draw(into, report->slow, report->slow_rows, report->si);
    fclose(into);
    if (drawn)
        fprintf(out,
                "<figure>%s<figcaption>The slow log, a row a minute: each transducer (its number "
                "at the right) against its first row, the mean of the "
                "gages, the mat's temperature.</figcaption></figure>\n",
                picture);
    free(picture);
    return MR_OK;
}
