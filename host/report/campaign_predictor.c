/* What the board's predictor said of each landing, and what came of it. */
#include <math.h>

#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

static void span_cell(FILE *out, bool known, double start_ft, double end_ft, double station)
{
    if (known)
        html_cell(out, "%.1f to %.1f", station * start_ft, station * end_ft);
    else
        html_number(out, (double)NAN, 0);
}

static void row(FILE *out, const struct report_landing *landing, double station)
{
    const struct zones *zones = &landing->summary.zones;
    const struct zone_warning *w = &zones->warning;
    const struct store_zone *last = zones->count ? &zones->row[zones->count - 1] : NULL;
    int64_t worst = STORE_NONE;
    char why[ZONES_HEARD_TEXT];
    for (size_t i = 0; i < landing->predictions; i++)
        worst = landing->prediction[i].verdict > worst ? landing->prediction[i].verdict : worst;
    fputs("<tr>", out);
    const struct measured *measured = &landing->summary.measured;
    html_cell(out, "%lld", (long long)measured->landing.id);
    html_cell(out, "%zu", zones->count);
    if (w->warned)
        fputs("<td class=\"warn\">warning</td>", out);
    else
        html_cell(out, "%s%s",
                  measured->source == MEASURED_IMPORT ? "no board watched"
                  : worst == STORE_NONE               ? "no warning"
                                                      : mr_predictor_verdict_text((unsigned)worst),
                  measured->source != MEASURED_IMPORT &&
                          zones_heard_doubt(&zones->heard, (double)INFINITY, why)
                      ? ", as far as it was heard"
                      : "");
    html_number(out, w->warned ? w->t_s : (double)NAN, 3);
    html_cell(out, "%s",
              w->warned && w->reason != STORE_NONE ? mr_predictor_reason_text((unsigned)w->reason)
                                                   : "");
    span_cell(out, w->warned, w->start_ft, w->end_ft, station);
    html_number(out, w->warned && w->reached ? w->true_lead_s : (double)NAN, 3);
    html_number(out, w->warned ? w->lead_s : (double)NAN, 3);
    html_number(out, w->warned ? w->lead_became_s : (double)NAN, 3);
    if (w->warned)
        html_cell(out, "%lld mats, %.1f to %.1f", (long long)w->most_mats,
                  station * w->most_start_ft, station * w->most_end_ft);
    else
        html_number(out, (double)NAN, 0);
    span_cell(out, last && last->mats > 0, last ? last->start_ft : 0.0, last ? last->end_ft : 0.0,
              station);
    fputs("</tr>\n", out);
}

enum mr_status campaign_predictor(const struct report *report, FILE *out, struct error *error)
{
    const struct unit *station = unit_of(UNIT_STATION, report->si);
    char zone[60], last[60];
    size_t statements = 0;
    (void)error;
    for (size_t i = 0; i < report->landings; i++)
        statements += report->landing[i].summary.zones.count;
    if (statements == 0)
        return MR_OK;
    snprintf(zone, sizeof zone, "zone then, %s", station->text);
    snprintf(last, sizeof last, "last told of, %s", station->text);
    html_table(out,
               (const char *const[]){"RUN", "statements", "worst", "first warning, s", "because",
                                     zone, "wheel there after, s", "first lead given, s",
                                     "it became, s", "at its longest", last, NULL});
    for (size_t i = 0; i < report->landings; i++)
        row(out, &report->landing[i], station->factor);
    fputs("</tbody></table></div>\n<p>Times since touchdown, by the board's clock, at the "
          "beginning of the block that decided. A dash: none was given, or the wheel did not come "
          "there in the record. No warning is no "
          "clearance.</p>\n",
          out);
    return MR_OK;
}
