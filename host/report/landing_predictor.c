/* What the board's predictor said in a landing: the warning in words, zone and lead time over time,
 * each change of its verdict. */
#include <math.h>
#include <stdlib.h>

#include "host/report/chart.h"
#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/svg_words.h"

#define MATS_PX     140.0
#define LEAD_PX     110.0
#define TOP_PX      26.0
#define BETWEEN_PX  16.0
#define STATEMENT_S 0.05
#define CHANGES_MAX 12u /* rows of the table */

static void draw_zones(const struct svg_plot *plot, const struct zones *zones,
                       const struct measured *measured)
{
    for (size_t i = 0, next; i < zones->count; i = next) {
        const struct store_zone *row = &zones->row[i];
        double to_s = zones_time_s(measured, row);
        for (next = i; next < zones->count; next++) {
            const struct store_zone *other = &zones->row[next];
            double t_s = zones_time_s(measured, other);
            if (other->mats != row->mats || (other->warning == 1) != (row->warning == 1) ||
                t_s > to_s + 0.001)
                break;
            double until_s = next + 1 < zones->count ? zones_time_s(measured, other + 1)
                                                     : t_s + STATEMENT_S;
            to_s = fmin(until_s, t_s + 2.0 * STATEMENT_S);
        }
        svg_rect(plot, row->warning == 1 ? "warned edge" : "told",
                 fmax(zones_time_s(measured, row), plot->x.low), 0.0, to_s, (double)row->mats);
    }
}

static void draw_coming(const struct svg_plot *plot, const struct report_landing *landing)
{
    double *t_s = malloc(2 * (landing->predictions + 1) * sizeof *t_s),
           *mats = t_s + landing->predictions + 1;
    if (!t_s)
        return;
    for (size_t i = 0; i < landing->predictions; i++) {
        t_s[i] = measured_block_s(&landing->summary.measured, landing->prediction[i].block);
        mats[i] = landing->prediction[i].coming_mats > 0
                    ? (double)landing->prediction[i].coming_mats
                    : (double)NAN;
    }
    svg_dots(plot, "dots c", t_s, mats, landing->predictions);
    free(t_s);
}

static void mats_panel(FILE *out, const struct report_landing *landing, struct svg_axis time)
{
    const struct zones *zones = &landing->summary.zones;
    const struct measured *measured = &landing->summary.measured;
    double high = 60.0;
    struct svg_plot plot = {.out = out,
                            .left = CHART_LEFT,
                            .top = TOP_PX,
                            .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                            .height = MATS_PX};
    for (size_t i = 0; i < zones->count; i++)
        high = fmax(high, 1.05 * (double)zones->row[i].mats);
    time.label = NULL;
    time.ticks = false;
    plot.x = time;
    plot.y = (struct svg_axis){0.0, high, "mats in the zone", true};
    svg_axes(&plot);
    draw_zones(&plot, zones, measured);
    draw_coming(&plot, landing);
    svg_line(&plot, "mark", (const double[]){time.low, time.high},
             (const double[]){MR_PREDICTOR_WARNING_MATS, MR_PREDICTOR_WARNING_MATS}, 2);
    svg_line(&plot, "mark", (const double[]){time.low, time.high},
             (const double[]){MR_PREDICTOR_ADVISORY_MATS, MR_PREDICTOR_ADVISORY_MATS}, 2);
}

/* What the board gave as lead time, and how long the wheel then took to the start of that zone. */
static void draw_leads(const struct svg_plot *plot, const struct report_landing *landing)
{
    const struct zones *zones = &landing->summary.zones;
    const struct measured *measured = &landing->summary.measured;
    double *t_s = malloc(3 * (zones->count + 1) * sizeof *t_s), *given_s = t_s + zones->count + 1,
           *became_s = given_s + zones->count + 1;
    if (!t_s)
        return;
    for (size_t i = 0; i < zones->count; i++) {
        const struct store_zone *row = &zones->row[i];
        t_s[i] = zones_time_s(measured, row);
        given_s[i] = row->mats > 0 ? row->lead_s : (double)NAN;
        became_s[i] = isnan(given_s[i]) ? (double)NAN
                                        : measured_reach_s(measured, row->start_ft) - t_s[i];
    }
    svg_dots(plot, "dots given", t_s, given_s, zones->count);
    svg_dots(plot, "dots a", t_s, became_s, zones->count);
    free(t_s);
}

static void lead_panel(FILE *out, const struct report_landing *landing, struct svg_axis time)
{
    const struct zones *zones = &landing->summary.zones;
    double high = 0.5;
    struct svg_plot plot = {.out = out,
                            .left = CHART_LEFT,
                            .top = TOP_PX + MATS_PX + BETWEEN_PX,
                            .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                            .height = LEAD_PX};
    for (size_t i = 0; i < zones->count; i++)
        high = zones->row[i].mats > 0 ? fmax(high, 1.25 * zones->row[i].lead_s) : high;
    plot.x = time;
    plot.y = (struct svg_axis){0.0, high, "lead time, s", true};
    svg_axes(&plot);
    draw_leads(&plot, landing);
}

static void draw_all(FILE *out, const struct report_landing *landing)
{
    const struct measured *measured = &landing->summary.measured;
    const struct svg_key keys[] = {{"key warned", "closed zone ahead, warning"},
                                   {"key told", "the same, no warning"},
                                   {"mark", "limits: 30 and 50 mats"}};
    struct svg_axis time = {-0.3, measured->summary.stop_t_s.value + CHART_SETTLED_S,
                            "time since touchdown, s", true};
    svg_open(out, CHART_WIDTH, TOP_PX + MATS_PX + LEAD_PX + BETWEEN_PX + 40.0,
             "zone that the board told of, and its lead time, against time");
    mats_panel(out, landing, time);
    lead_panel(out, landing, time);
    svg_legend(out, CHART_LEFT, CHART_WIDTH - CHART_RIGHT, 14.0, keys, 3);
    chart_mark_key(out, "dot c", 0, 640.0, 14.0, "longest zone that it saw coming");
    chart_mark_key(out, "dot given", 1, CHART_WIDTH - 230.0, TOP_PX + MATS_PX + BETWEEN_PX + 16.0,
                   "given");
    chart_mark_key(out, "dot a", 0, CHART_WIDTH - 150.0, TOP_PX + MATS_PX + BETWEEN_PX + 16.0,
                   "what it became");
    svg_close(out);
}

/* The first of them; how many there were. */
static size_t changes(FILE *out, const struct report_landing *landing, const struct unit *station)
{
    const struct measured *measured = &landing->summary.measured;
    int64_t verdict = STORE_NONE;
    size_t told = 0;
    char zone[60];
    snprintf(zone, sizeof zone, "zone, %s", station->text);
    html_table(out, (const char *const[]){"time, s", "verdict", "because", "mats", zone,
                                          "lead time, s", "it became, s", "model", NULL});
    for (size_t i = 0; i < landing->predictions; i++) {
        const struct store_prediction *said = &landing->prediction[i];
        const struct store_zone *row = NULL;
        if (said->verdict == STORE_NONE || said->verdict == verdict)
            continue;
        verdict = said->verdict;
        if (++told > CHANGES_MAX)
            continue;
        for (size_t k = 0; k < landing->summary.zones.count && !row; k++)
            row = landing->summary.zones.row[k].block == said->block
                    ? &landing->summary.zones.row[k]
                    : NULL;
        double t_s = measured_block_s(measured, said->block);
        bool zoned = row && row->mats > 0;
        double became_s = zoned ? measured_reach_s(measured, row->start_ft) - t_s : (double)NAN;
        fputs("<tr>", out);
        html_number(out, t_s, 3);
        html_cell(out, "%s", mr_predictor_verdict_text((unsigned)verdict));
        html_cell(out, "%s",
                  said->reason == STORE_NONE ? ""
                                             : mr_predictor_reason_text((unsigned)said->reason));
        html_number(out, row ? (double)row->mats : (double)NAN, 0);
        if (zoned)
            html_cell(out, "%.1f to %.1f", station->factor * row->start_ft,
                      station->factor * row->end_ft);
        else
            html_number(out, (double)NAN, 0);
        html_number(out, zoned ? row->lead_s : (double)NAN, 3);
        html_number(out, became_s >= 0.0 ? became_s : (double)NAN, 3);
        html_cell(out, "%s",
                  said->level == STORE_NONE ? "" : mr_predictor_level_text((unsigned)said->level));
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
    return told;
}

enum mr_status landing_predictor(const struct report *report, const struct report_landing *landing,
                                 FILE *out, struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    (void)error;
    struct answer *answer = answer_new(report->si);
    summary_zone_answer(&landing->summary, answer);
    report_answer(answer, out);
    if (measured->fit_status != MR_OK || landing->summary.zones.count == 0)
        return MR_OK;
    fputs("<figure>", out);
    draw_all(out, landing);
    fputs("<figcaption>Every statement of the board, and what came of it: the wheel's way to the "
          "start of the zone from the final fit of its motion."
          "</figcaption></figure>\n",
          out);
    size_t told = landing->predictions ? changes(out, landing, unit_of(UNIT_STATION, report->si))
                                       : 0;
    if (told > CHANGES_MAX)
        fprintf(out, "<p>And %zu more changes of the verdict.</p>\n", told - CHANGES_MAX);
    return MR_OK;
}
