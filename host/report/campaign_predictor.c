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

static void row(FILE *out, const struct report_facts *facts, double station)
{
    const struct zone_warning *w = &facts->warning;
    int64_t worst = facts->worst_verdict;
    fputs("<tr>", out);
    html_cell(out, "%lld", (long long)facts->landing.id);
    html_cell(out, "%zu", facts->statements);
    if (w->warned)
        fputs("<td class=\"warn\">warning</td>", out);
    else
        html_cell(out, "%s%s",
                  facts->source == MEASURED_IMPORT ? "no board watched"
                  : worst == STORE_NONE            ? "no warning"
                                                   : mr_predictor_verdict_text((unsigned)worst),
                  facts->source != MEASURED_IMPORT && facts->unheard ? ", as far as it was heard"
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
    span_cell(out, facts->last.mats > 0, facts->last.start_ft, facts->last.end_ft, station);
    fputs("</tr>\n", out);
}

enum mr_status campaign_predictor(const struct report *report, FILE *out, struct error *error)
{
    const struct unit *station = unit_of(UNIT_STATION, report->si);
    char zone[60], last[60];
    size_t statements = 0;
    (void)error;
    for (size_t i = 0; i < report->landings; i++)
        statements += report->facts[i].statements;
    if (statements == 0)
        return MR_OK;
    snprintf(zone, sizeof zone, "zone then, %s", station->text);
    snprintf(last, sizeof last, "last told of, %s", station->text);
    html_table(out,
               (const char *const[]){"RUN", "statements", "worst", "first warning, s", "because",
                                     zone, "wheel there after, s", "first lead given, s",
                                     "it became, s", "at its longest", last, NULL});
    for (size_t i = 0; i < report->landings; i++)
        row(out, &report->facts[i], station->factor);
    fputs("</tbody></table></div>\n<p>Times since touchdown, by the board's clock, at the "
          "beginning of the block that decided. A dash: none was given, or the wheel did not come "
          "there in the record. No warning is no "
          "clearance.</p>\n",
          out);
    return MR_OK;
}
