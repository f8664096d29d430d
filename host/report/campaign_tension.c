/* Average change of band tension against deceleration (report fig. 5.3). */
#include <math.h>
#include <stdio.h>

#include "host/report/chart.h"
#include "host/base/html.h"
#include "host/report/report.h"

#define NAMED_MAX 8u /* more landings than these are not named in the picture */
#define NAME_PX   44.0

static double factor_of(bool si)
{
    return unit_of(UNIT_TENSION, si)->factor;
}

static double deceleration_of(const struct report_facts *facts, bool si)
{
    return unit_of(UNIT_DECELERATION, si)->factor * facts->deceleration_ft_s2.value;
}

static double half_interval(const struct report_facts *facts, bool si)
{
    return unit_of(UNIT_DECELERATION, si)->factor * SUMMARY_95 * facts->deceleration_ft_s2.error;
}

/* Bands often change alike: each next one is drawn smaller and thinner over the one before, so
 * that the one before shows around it. */
static double larger_px(unsigned band, unsigned bands)
{
    return 2.6 * (double)(bands - 1 - band);
}

static void ring(FILE *out, unsigned band, unsigned bands, double px, double py)
{
    char class[16];
    bool last = band + 1 >= bands;
    snprintf(class, sizeof class, "%s s%u", last ? "dot" : "ring", band);
    svg_mark(out, class, band, px, py, 3.0 + larger_px(band, bands));
}

static void draw_landing(const struct svg_plot *plot, const struct report_facts *facts,
                         unsigned bands, bool si)
{
    double x = deceleration_of(facts, si);
    double half_px = plot->width * half_interval(facts, si) / (plot->x.high - plot->x.low);
    for (unsigned b = 0; b < REPORT_BANDS; b++) {
        const struct report_band *band = &facts->band[b];
        if (band->gages == 0)
            continue;
        const double y[] = {factor_of(si) * band->fell_lb, factor_of(si) * band->rose_lb};
        for (unsigned i = 0; i < 2; i++) {
            fprintf(plot->out,
                    "<path class=\"line s%u\" style=\"stroke-width:%.1f\" d=\"M%.1f %.1fh%.1f\"/>",
                    b, 1.5 + larger_px(b, bands), svg_x(plot, x) - half_px, svg_y(plot, y[i]),
                    2.0 * half_px);
            ring(plot->out, b, bands, svg_x(plot, x), svg_y(plot, y[i]));
        }
    }
}

/* Along the lower edge, one above the other where they would touch. */
static void draw_names(const struct svg_plot *plot, const struct report *report)
{
    double taken_px[NAMED_MAX] = {0.0};
    for (size_t i = 0; i < report->landings; i++) {
        const struct report_facts *facts = &report->facts[i];
        char name[40];
        unsigned above = 0;
        if (!facts->fitted)
            continue;
        double x = deceleration_of(facts, report->si), px = svg_x(plot, x);
        while (above + 1 < NAMED_MAX && taken_px[above] > 0.0 &&
               fabs(taken_px[above] - px) < NAME_PX)
            above++;
        taken_px[above] = px;
        snprintf(name, sizeof name, "RUN %lld", (long long)facts->landing.id);
        svg_text(plot, "tick", "middle", x, plot->y.low, 0.0, -5.0 - 12.0 * above, name);
    }
}

static void table(const struct report *report, unsigned bands, FILE *out)
{
    char heads[2 + 2 * REPORT_BANDS][60];
    const char *list[3 + 2 * REPORT_BANDS] = {"RUN", heads[1]};
    size_t n = 2;
    snprintf(heads[1], sizeof heads[1], "mean deceleration, %s",
             unit_of(UNIT_DECELERATION, report->si)->text);
    for (unsigned b = 0; b < bands; b++) {
        snprintf(heads[n], sizeof heads[n], "band %u: largest fall, %s", b + 1,
                 unit_of(UNIT_TENSION, report->si)->text);
        list[n] = heads[n];
        n++;
        snprintf(heads[n], sizeof heads[n], "band %u: largest rise, %s", b + 1,
                 unit_of(UNIT_TENSION, report->si)->text);
        list[n] = heads[n];
        n++;
    }
    html_table(out, list);
    for (size_t i = 0; i < report->landings; i++) {
        const struct report_facts *facts = &report->facts[i];
        if (!facts->fitted)
            continue;
        fputs("<tr>", out);
        html_cell(out, "%lld", (long long)facts->landing.id);
        html_estimate(
            out, deceleration_of(facts, report->si),
            facts->deceleration_ft_s2.error * unit_of(UNIT_DECELERATION, report->si)->factor, 3);
        for (unsigned b = 0; b < bands; b++) {
            const struct report_band *band = &facts->band[b];
            html_number(out, factor_of(report->si) * band->fell_lb, 2);
            html_number(out, factor_of(report->si) * band->rose_lb, 2);
        }
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

/* Range of both axes; how many bands there are. */
static unsigned ranges(const struct report *report, struct svg_plot *plot)
{
    double left = (double)INFINITY, right = -(double)INFINITY, low = 0.0, high = 0.0;
    unsigned bands = 0;
    for (size_t i = 0; i < report->landings; i++) {
        const struct report_facts *facts = &report->facts[i];
        double x = deceleration_of(facts, report->si);
        for (unsigned b = 0; facts->fitted && b < REPORT_BANDS; b++) {
            const struct report_band *band = &facts->band[b];
            const double both[] = {factor_of(report->si) * band->fell_lb,
                                   factor_of(report->si) * band->rose_lb};
            if (band->gages == 0)
                continue;
            bands = b + 1 > bands ? b + 1 : bands;
            chart_extend(both, 2, &low, &high);
            chart_extend((const double[]){x - half_interval(facts, report->si),
                                          x + half_interval(facts, report->si)},
                         2, &left, &right);
        }
    }
    svg_widen(&left, &right, unit_of(UNIT_DECELERATION, report->si)->factor);
    svg_widen(&low, &high, unit_of(UNIT_TENSION, report->si)->factor);
    plot->x = (struct svg_axis){left, right, NULL, true};
    plot->y = (struct svg_axis){low - 0.16 * (high - low), high, NULL, true};
    return bands;
}

enum mr_status campaign_tension(const struct report *report, FILE *out, struct error *error)
{
    struct chart_text x_label = chart_label("mean deceleration", UNIT_DECELERATION, report->si),
                      y_label = chart_label("average change", UNIT_TENSION, report->si);
    struct svg_plot plot = {.out = out,
                            .left = CHART_LEFT,
                            .top = 26.0,
                            .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                            .height = 240.0};
    double key_px = CHART_LEFT;
    unsigned bands = ranges(report, &plot);
    (void)error;
    if (bands == 0)
        return MR_OK;
    plot.x.label = x_label.text;
    plot.y.label = y_label.text;
    fputs("<figure>", out);
    svg_open(out, CHART_WIDTH, 308.0, "average change of band tension against deceleration");
    svg_axes(&plot);
    svg_line(&plot, "mark", (const double[]){plot.x.low, plot.x.high}, (const double[]){0.0, 0.0},
             2);
    for (size_t i = 0; i < report->landings; i++) {
        if (report->facts[i].fitted)
            draw_landing(&plot, &report->facts[i], bands, report->si);
    }
    if (report->landings <= NAMED_MAX)
        draw_names(&plot, report);
    for (unsigned b = 0; b < bands; b++) {
        char name[20];
        snprintf(name, sizeof name, "band %u", b + 1);
        double mark_px = key_px + 14.0;
        key_px = chart_key(out, b, key_px, 14.0, name);
        ring(out, b, bands, mark_px, 10.0);
    }
    svg_close(out);
    fputs("<figcaption>Change of tension after the first switch, mean over a band's gages: largest "
          "fall (below 0) and largest rise (above). Across: 95 % of the deceleration. Where bands "
          "change alike the mark of one lies inside that of the other. As report fig. "
          "5.3.</figcaption></figure>\n",
          out);
    table(report, bands, out);
    return MR_OK;
}
