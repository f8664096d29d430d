/* A landing's newest comparison that the campaign keeps: table, zones and picture. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "host/compare/figures.h"
#include "host/compare/show.h"
#include "host/base/html.h"
#include "host/base/svg.h"
#include "host/base/svg_words.h"
#include "host/report/report.h"
#include "host/base/units.h"

#define WIDTH      1040.0
#define COLUMNS    2
#define MARGIN     58.0
#define ROW        200.0
#define TOP        40.0
#define POINTS     300
#define Z95        1.959964
#define DRAWN_MOST 4u /* transducers of a picture: half a page of paper */

static const struct measured_channel *channel_of(const struct measured *measured,
                                                 const struct store_simulation *row)
{
    int c = measured_find(measured, MR_KIND_DISPLACEMENT, (unsigned)row->number);
    return c >= 0 && measured->channel[c].raw ? &measured->channel[c] : NULL;
}

static double solver_error(const struct store_simulation_head *head,
                           const struct store_simulation *row)
{
    return isnan(head->error_in) ? row->peak_simulated_error_in : head->error_in;
}

/* Thinned to POINTS: every step-th sample. */
struct curve {
    double t_s[POINTS + 1], value[POINTS + 1], low[POINTS + 1], high[POINTS + 1];
    size_t count;
};

static void take(struct curve *curve, const struct compare_curves *s, const double *values,
                 const double *errors, size_t from, size_t to, double in, double *least,
                 double *most)
{
    size_t step = (to - from) / POINTS + 1;
    curve->count = 0;
    for (size_t i = from; i < to; i += step) {
        size_t k = curve->count++;
        curve->t_s[k] = s->t_s[i];
        curve->value[k] = in * values[i];
        curve->low[k] = in * (values[i] - Z95 * errors[i]);
        curve->high[k] = in * (values[i] + Z95 * errors[i]);
        *least = fmin(*least, curve->low[k]);
        *most = fmax(*most, curve->high[k]);
    }
}

/* Runs without NaN: a band has no holes. */
static void draw_band(const struct svg_plot *plot, const char *class, const struct curve *c)
{
    for (size_t from = 0; from < c->count; from++) {
        size_t to = from;
        while (to < c->count && !isnan(c->low[to]))
            to++;
        if (to > from + 1)
            svg_band(plot, class, c->t_s + from, c->low + from, c->high + from, to - from);
        from = to;
    }
}

static void draw_channel(FILE *out, const struct compare_curves *s, size_t samples,
                         const struct store_simulation *row, size_t place, bool si)
{
    struct curve measured, simulated;
    double least = 0.0, most = 0.0, in = unit_of(UNIT_DISPLACEMENT, si)->factor;
    size_t from = 0, to = samples;
    while (from < to && s->t_s[from] < 0.0)
        from++;
    while (to > from && isnan(s->simulated_in[to - 1]))
        to--;
    if (to <= from)
        return;
    take(&measured, s, s->measured_in, s->measured_error_in, from, to, in, &least, &most);
    take(&simulated, s, s->simulated_in, s->simulated_error_in, from, to, in, &least, &most);
    svg_widen(&least, &most, 0.05 * in);
    char label[40], name[60];
    snprintf(label, sizeof label, "movement, %s", unit_of(UNIT_DISPLACEMENT, si)->text);
    snprintf(name, sizeof name, "transducer %" PRId64 ", %.1f %s", row->number,
             row->station_ft * unit_of(UNIT_STATION, si)->factor, unit_of(UNIT_STATION, si)->text);
    double column = (double)(place % COLUMNS), line = (double)(place / COLUMNS),
           width = WIDTH / COLUMNS;
    struct svg_plot plot = {.out = out,
                            .left = column * width + MARGIN,
                            .top = TOP + line * ROW,
                            .width = width - MARGIN - 14.0,
                            .height = ROW - 52.0};
    plot.x = (struct svg_axis){s->t_s[from], s->t_s[to - 1], "time since touchdown, s", true};
    plot.y = (struct svg_axis){least, most, column < 0.5 ? label : NULL, true};
    svg_axes(&plot);
    draw_band(&plot, "band", &measured);
    draw_band(&plot, "band sims", &simulated);
    svg_line(&plot, "line a", measured.t_s, measured.value, measured.count);
    svg_line(&plot, "line sim", simulated.t_s, simulated.value, simulated.count);
    /* movements end high */
    svg_text(&plot, "name", "end", plot.x.high, plot.y.low, -6.0, -8.0, name);
}

static void draw(FILE *out, const struct measured *measured,
                 const struct store_simulation_head *head, const struct store_simulation *rows,
                 size_t count, bool si)
{
    const struct svg_key keys[] = {{"line a", "measured, with its 95 % band"},
                                   {"line sim", "simulated, with its 95 % band"}};
    struct compare_clock clock;
    double height = TOP + ROW * (double)((count + COLUMNS - 1) / COLUMNS);
    compare_clock_make(measured, &clock);
    svg_open(out, WIDTH, height, "movement of the mat, measured and simulated");
    for (size_t i = 0; i < count; i++) {
        struct compare_curves series;
        const struct measured_channel *channel = channel_of(measured, &rows[i]);
        if (!channel || rows[i].length == 0)
            continue;
        compare_curves(measured, &clock, channel, &rows[i], solver_error(head, &rows[i]), &series);
        draw_channel(out, &series, measured->samples, &rows[i], i, si);
        free(series.storage);
    }
    svg_legend(out, MARGIN, WIDTH - MARGIN, 16.0, keys, 2);
    svg_close(out);
}

/* As `matrig compare` has them. */
static void tables(const struct compare_figures *figures, bool si, FILE *out)
{
    struct answer *answer = answer_new(si);
    compare_channels_answer(figures, answer);
    compare_zones_answer(&figures->zones, answer);
    answer_html(answer, out);
    answer_free(answer);
}

static void words(FILE *out, const struct compare_figures *figures, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    fputs("<p class=\"say\">", out);
    if (figures->against[0]) {
        fputs("Against ", out);
        html_text(out, figures->against);
        fputs(": ", out);
    }
    if (figures->seeds > 1)
        fprintf(out, "%lld runways, ", (long long)figures->seeds);
    if (!isnan(figures->run_ms))
        fprintf(out, "simulated in %.0f ms, ", figures->run_ms);
    if (!isnan(figures->error_in))
        fprintf(out, "the simulation's own error estimate %.*f %s, ", si ? 2 : 4,
                figures->error_in * length->factor, length->text);
    if (figures->edges > 0)
        fprintf(out, "aligned on %lld switch edges, ", (long long)figures->edges);
    fprintf(out, "%zu of %u segments surveyed.</p>\n", figures->surveyed, MR_SEGMENTS);
}

/* From what is measured now: a calibration may have changed since. */
bool landing_compared(const struct report_landing *landing, struct compare_figures *figures,
                      struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    const struct compare_said said = {.zone = landing->summary.zones.row,
                                      .zones = landing->summary.zones.count};
    (void)error;
    if (landing->simulations == 0 || measured->fit_status != MR_OK || measured->samples == 0)
        return false;
    compare_figures(measured, &landing->survey, &said, &landing->head, landing->simulation,
                    landing->simulations, figures);
    return true;
}

enum mr_status landing_compare(const struct report *report, const struct report_landing *landing,
                               FILE *out, struct error *error)
{
    const bool si = report->si;
    const struct measured *measured = &landing->summary.measured;
    struct compare_figures figures;
    struct compare_agreement agreement;
    char sentence[COMPARE_SENTENCE];
    if (!landing_compared(landing, &figures, error))
        return error->status;
    words(out, &figures, si);
    compare_agreement(&figures, &agreement);
    compare_sentence(&agreement, si, sentence);
    fputs("<p class=\"say\"><strong>", out);
    html_text(out, sentence);
    fputs(".</strong></p>\n", out);
    tables(&figures, si, out);
    for (size_t i = 0; i < landing->simulations && error->status == MR_OK; i += DRAWN_MOST) {
        size_t left = landing->simulations - i, count = left < DRAWN_MOST ? left : DRAWN_MOST;
        fputs("<figure>", out);
        draw(out, measured, &landing->head, landing->simulation + i, count, si);
        if (count == left)
            fputs("<figcaption>Movement against time, each with its 95 % band.</figcaption>", out);
        fputs("</figure>\n", out);
    }
    return error->status;
}
