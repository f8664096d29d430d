/* What `matrig advise --keep` said before the landings, and what came of it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/html.h"
#include "host/report/chart.h"
#include "host/report/report.h"

#define HEIGHT 240.0
#define TOP    12.0
#define LOW    34.0

/* The landing that an advice was kept for: the first one after it; NULL: still to come, or not in
 * this report. */
static const struct report_facts *landing_of(const struct report *report,
                                             const struct store_advice *advice)
{
    for (size_t i = 0; i < report->landings; i++) {
        if (report->facts[i].landing.id > advice->after_run)
            return &report->facts[i];
    }
    return NULL;
}

static void draw(const struct store_advice *advice, size_t count, FILE *out)
{
    struct svg_plot plot = {.out = out,
                            .left = CHART_LEFT,
                            .top = TOP,
                            .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                            .height = HEIGHT - TOP - LOW,
                            .x = {0.5, (double)count + 0.5, "advice", false},
                            .y = {0.0, 100.0, "probability, %", true}};
    fputs("<figure>", out);
    svg_open(out, CHART_WIDTH, HEIGHT, "Advice before landings: probabilities against the limit");
    svg_axes(&plot);
    for (size_t i = 0; i < count; i++) {
        const struct store_advice *a = &advice[i];
        double x = (double)i + 1.0, limit[] = {100.0 * a->most, 100.0 * a->most},
               at[] = {x - 0.45, x + 0.45};
        char name[40];
        svg_line(&plot, "line mark", at, limit, 2);
        chart_whisker(&plot, "line a", x - 0.05, 100.0 * a->zone_low, 100.0 * a->zone_high);
        chart_mark(&plot, 0, x - 0.05, 100.0 * a->zone);
        snprintf(name, sizeof name, "%zu: %s", i + 1, a->verdict);
        svg_text(&plot, "tick", "middle", x, 0.0, 0.0, 14.0, name);
    }
    svg_close(out);
    fputs("<figcaption>Probability of a zone of 50 mats with its sampling interval; "
          "dashed: the limit.</figcaption></figure>\n",
          out);
}

static void row(const struct report *report, const struct store_advice *advice, size_t number,
                FILE *out)
{
    const struct report_facts *facts = landing_of(report, advice);
    const double speed = unit_of(UNIT_SPEED, report->si)->factor,
                 braking = unit_of(UNIT_DECELERATION, report->si)->factor;
    fputs("<tr>", out);
    html_cell(out, "%zu", number);
    if (strcmp(advice->verdict, "against") == 0)
        fputs("<td class=\"warn\">against</td>", out);
    else
        html_cell(out, "%s", advice->verdict);
    html_number(out, speed * advice->speed_ft_s, 1);
    html_number(out, braking * advice->deceleration_ft_s2, 2);
    html_number(out, 100.0 * advice->zone, 0);
    html_number(out, braking * advice->hardest_ft_s2, 1);
    if (facts) {
        const struct zone_warning *warning = &facts->warning;
        html_cell(out, "%lld", (long long)facts->landing.id);
        html_number(out, speed * facts->speed_ft_s.value, 1);
        html_number(out, braking * facts->deceleration_ft_s2.value, 2);
        html_cell(out, "%s",
                  !warning->warned      ? "no warning"
                  : warning->reached    ? "warned, the wheel came to the zone"
                  : warning->path_known ? "warned, the wheel did not come to it"
                                        : "warned");
    } else {
        html_cell(out, "to come");
        html_number(out, (double)NAN, 1);
        html_number(out, (double)NAN, 2);
        html_cell(out, "%s", "");
    }
    html_cell(out, "%s", advice->reason);
    fputs("</tr>\n", out);
}

enum mr_status campaign_advice(const struct report *report, FILE *out, struct error *error)
{
    struct store_advice *advice = NULL;
    size_t count = 0;
    char speed[40], braking[40], hardest[40], was[40], had[40];
    enum mr_status status = store_advices(report->store, &advice, &count, error);
    if (status == MR_OK && count) {
        const char *v = unit_of(UNIT_SPEED, report->si)->text,
                   *a = unit_of(UNIT_DECELERATION, report->si)->text;
        snprintf(speed, sizeof speed, "planned, %s", v);
        snprintf(braking, sizeof braking, "braking, %s", a);
        snprintf(hardest, sizeof hardest, "hardest, %s", a);
        snprintf(was, sizeof was, "it had, %s", v);
        snprintf(had, sizeof had, "braking, %s", a);
        draw(advice, count, out);
        html_table(out,
                   (const char *const[]){"advice", "verdict", speed, braking, "zone, %", hardest,
                                         "RUN", was, had, "the board then", "why", NULL});
        for (size_t i = 0; i < count; i++)
            row(report, &advice[i], i + 1, out);
        fputs("</tbody></table></div>\n<p>Said by matrig advise before the landing beside it. No "
              "warning is no clearance.</p>\n",
              out);
    }
    free(advice);
    return status;
}
