/* Drawing a figure: curves over stations (fig 5.3: points over deceleration) with what the text
 * states marked by the letters of the table's rows. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/statistics.h"
#include "host/base/plot.h"
#include "tests/series_figures/figures.h"

#define RIG_BANDS 4.0 /* that share the braking force: report 5.1.3.1, C.1 */

static size_t facts_of(const struct figure *figure)
{
    size_t count = 0;
    while (count < FIGURE_FACTS && figure->facts[count].kind != FACT_NONE)
        count++;
    return count;
}

static size_t curves_of(const struct figure *figure)
{
    size_t count = 0;
    while (count < FIGURE_CURVES && figure->curves[count].text)
        count++;
    return count;
}

/* A curve over the runways that have it: least, middle and most at every station. */
struct bundle {
    double x_ft[SERIES_STATIONS_MAX], low[SERIES_STATIONS_MAX], middle[SERIES_STATIONS_MAX],
        high[SERIES_STATIONS_MAX];
    size_t runways;
};

static void bundle_curve(struct bundle *bundle, const struct figure *figure,
                         const struct figure_run *run, size_t curve)
{
    const struct landing_series *c = &run->series;
    double(*moved)[SERIES_STATIONS_MAX] = calloc(c->seeds, sizeof *moved),
    *column = calloc(c->seeds, sizeof *column);
    bundle->runways = 0;
    for (size_t i = 0; moved && column && i < c->seeds; i++)
        bundle->runways += figure_curve_of(c, &run->runs[i], &figure->curves[curve],
                                           moved[bundle->runways]);
    for (size_t k = 0; k < c->station_count && bundle->runways > 0; k++) {
        size_t n = bundle->runways;
        for (size_t i = 0; i < n; i++)
            column[i] = moved[i][k];
        sort_numbers(column, n);
        bundle->x_ft[k] = c->stations_ft[k] + figure->zero_ft;
        bundle->low[k] = column[0];
        bundle->middle[k] = 0.5 * (column[(n - 1) / 2] + column[n / 2]);
        bundle->high[k] = column[n - 1];
    }
    free(moved);
    free(column);
}

/* Stations that the text names, and displacements that it states. */
static void mark_facts(struct plot *plot, const struct figure *figure, double top_in)
{
    for (size_t i = 0; i < facts_of(figure); i++) {
        const struct figure_fact *fact = &figure->facts[i];
        const char letter[2] = {(char)('a' + i), 0};
        const double ends[2] = {fact->at_ft, fact->to_ft};
        struct plot_series series = {.colour = 5, .dashed = true, .x = ends, .y = &fact->mark_in};
        if (fact->mark_in != 0.0) {
            series.kind = fact->at_ft > 0.0 ? PLOT_POINTS : PLOT_LEVELS;
            series.count = 1;
            plot_label(plot, fact->at_ft > 0.0 ? fact->at_ft : figure->zero_ft, fact->mark_in,
                       false, letter);
        } else if (fact->at_ft > 0.0) {
            series.kind = PLOT_RULES;
            series.count = fact->to_ft > 0.0 ? 2 : 1;
            plot_label(plot, fact->at_ft, top_in, false, letter);
        }
        plot_draw(plot, &series);
    }
}

static void mark_buckles(struct plot *plot, const struct figure *figure,
                         const struct figure_run *run)
{
    for (size_t i = 0; i < run->series.seeds; i++) {
        const double at_ft = run->runs[i].buckle_ft + figure->zero_ft, zero = 0.0;
        if (run->runs[i].buckled > 0)
            plot_draw(plot, &(struct plot_series){.kind = PLOT_POINTS,
                                                  .colour = 5,
                                                  .shape = 2,
                                                  .x = &at_ft,
                                                  .y = &zero,
                                                  .count = 1});
    }
}

static void draw_curves(struct plot *plot, const struct figure *figure,
                        const struct figure_run *run)
{
    static struct bundle bundle;
    const struct landing_series *c = &run->series;
    double runway_ft = c->landings[0].scene.mats * c->landings[0].scene.length_ft, top_in = 0.0;
    plot_panel(
        plot, NULL,
        (struct plot_axis){"station (ft)", figure->zero_ft, figure->zero_ft + runway_ft, false},
        (struct plot_axis){.label = "displacement downfield (in)"});
    for (unsigned i = 0; i < curves_of(figure); i++) {
        char key[120];
        bundle_curve(&bundle, figure, run, i);
        snprintf(key, sizeof key, "%s (%zu of %zu)", figure->curves[i].text, bundle.runways,
                 c->seeds);
        if (bundle.runways == 0)
            continue;
        struct plot_series series = {.kind = PLOT_BAND,
                                     .colour = i,
                                     .x = bundle.x_ft,
                                     .y = bundle.low,
                                     .high = bundle.high,
                                     .count = c->station_count};
        plot_draw(plot, &series);
        series.kind = PLOT_LINE;
        series.key = key;
        series.y = bundle.middle;
        series.high = NULL;
        plot_draw(plot, &series);
        for (size_t k = 0; k < c->station_count; k++)
            top_in = fmax(top_in, bundle.high[k]);
    }
    mark_facts(plot, figure, top_in);
    mark_buckles(plot, figure, run);
}

/* Fig 5.3, and Appendix C beside it: R = W a/(4 g) a band, half of it ahead and half behind at the
 * middle of a band. */
static void draw_tensions(struct plot *plot, const struct figure_run *run)
{
    const struct landing_series *c = &run->series;
    const double to_ft_s2 = 14.0, theory_lb = 0.5 * c->weight_lb / RIG_BANDS * to_ft_s2 /
                                              c->landings[0].scene.g_ft_s2;
    plot_panel(
        plot, NULL,
        (struct plot_axis){"mean deceleration of the landing (ft/s\u00b2)", 0.0, to_ft_s2, false},
        (struct plot_axis){.label = "change in band tension (lb)"});
    for (int end = -1; end <= 1; end += 2)
        plot_draw(plot,
                  &(struct plot_series){.kind = PLOT_LINE,
                                        .key = end > 0 ? "\u00b1R/2, R = W a/(4 g) (C.1)" : NULL,
                                        .colour = PLOT_GREY,
                                        .dashed = true,
                                        .x = (double[]){0.0, to_ft_s2},
                                        .y = (double[]){0.0, end * theory_lb},
                                        .count = 2});
    for (int first = 0; first < 2; first++) {
        double x[2 * SERIES_LANDINGS_MAX], least[2 * SERIES_LANDINGS_MAX],
            most[2 * SERIES_LANDINGS_MAX];
        for (size_t i = 0; i < c->seeds; i++) {
            size_t count = 0;
            for (size_t k = first ? 0 : 13; k < run->runs[i].played && (!first || k < 13); k++) {
                const struct series_outcome *o = &run->runs[i].outcomes[k];
                x[count] = o->deceleration_ft_s2;
                least[count] = o->band_ahead_lb;
                most[count++] = o->band_behind_lb;
            }
            struct plot_series series = {
                .kind = PLOT_POINTS, .colour = first ? 0u : 1u, .x = x, .y = least, .count = count};
            if (i == 0)
                series.key = first ? "least, landings 1 to 13 (100 lb)"
                                   : "least, landings 14 to 26 (140 lb)";
            plot_draw(plot, &series);
            series.key = i == 0 ? "most" : NULL;
            series.open = true;
            series.y = most;
            plot_draw(plot, &series);
        }
    }
}

enum mr_status figure_draw(const char *path, const struct figure *figure,
                           const struct figure_run *run, struct error *error)
{
    char title[200];
    snprintf(title, sizeof title, "Figure %s. %s", figure->number, figure->title);
    struct plot *plot = plot_new(title, 900, 520, 1);
    if (figure->tension)
        draw_tensions(plot, run);
    else
        draw_curves(plot, figure, run);
    return plot_write(plot, path, error);
}

static const char *unit_of(enum fact_kind kind)
{
    switch (kind) {
    case FACT_STATION:
    case FACT_PEAK_STATION:
    case FACT_ZONE_REACH: return " ft";
    case FACT_PEAK:
    case FACT_RISE:
    case FACT_AT: return " in";
    case FACT_ZONE: return " mats";
    case FACT_SLACK: return " landings";
    case FACT_AHEAD:
    case FACT_BEHIND: return " lb";
    default: return "";
    }
}

static void put(char *text, size_t size, double value)
{
    if (isinf(value))
        snprintf(text, size, value > 0.0 ? "never" : "any");
    else
        snprintf(text, size, fabs(value) >= 100.0 ? "%.0f" : "%.3g", value);
}

void figure_table(FILE *out, const struct figure *figure, const struct figure_run *run)
{
    fputs(
        "| | observed: the report's text | computed: middle (all) | runways that agree | verdict | "
        "judged by |\n|---|---|---|---|---|---|\n",
        out);
    for (size_t i = 0; i < facts_of(figure); i++) {
        const struct figure_fact *fact = &figure->facts[i];
        struct fact_value v = figure_fact_of(figure, fact, run);
        char low[24], middle[24], high[24];
        put(low, sizeof low, v.low);
        put(middle, sizeof middle, v.middle);
        put(high, sizeof high, v.high);
        fprintf(out, "| %c | %s | ", (char)('a' + i), fact->text);
        if (v.of == 0)
            fputs("no runway gets there", out);
        else
            fprintf(out, "%s%s (%s to %s)", middle, unit_of(fact->kind), low, high);
        fprintf(out, " | %zu of %zu | %s | %s |\n", v.agree, v.of,
                2 * v.agree > v.of ? "agrees" : "DIFFERS", fact->note);
    }
}
