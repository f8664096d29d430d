/* Bands of a landing: figures, findings, shunt calibrations. Nothing where the board told nothing. */
#include <math.h>

#include "host/board/shunts.h"
#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

static void extreme_cell(FILE *out, const struct measured *measured, double lb, int64_t gage, int64_t block, bool si)
{
    char where[80];
    bands_where_text(measured, gage, block, si, where, sizeof where);
    if (isnan(lb))
        html_cell(out, "-");
    else
        html_cell(out, "%.1f%s", lb * unit_of(UNIT_TENSION, si)->factor, where);
}

static void shunt_table(const struct bands_summary *bands, bool si, FILE *out)
{
    const struct unit *force = unit_of(UNIT_TENSION, si);
    static const char *const names[] = {"shunt", "found before", "found after", "drift"};
    char heads[4][60];
    for (int i = 0; i < 4; i++)
        snprintf(heads[i], sizeof heads[i], "%s, %s", names[i], force->text);
    html_table(out, (const char *const[]){"gage", heads[0], heads[1], heads[2], heads[3], "before", "after", NULL});
    for (size_t i = 0; i < bands->shunts; i++) {
        const struct bands_shunt *s = &bands->shunt[i];
        fputs("<tr>", out);
        html_cell(out, "%u", s->gage);
        html_number(out, s->expected_lb * force->factor, 2);
        html_number(out, s->before_lb * force->factor, 2);
        html_number(out, s->after_lb * force->factor, 2);
        html_number(out, (s->after_lb - s->before_lb) * force->factor, 2);
        html_cell(out, "%s", shunts_verdict_text(s->before_verdict));
        html_cell(out, "%s", shunts_verdict_text(s->after_verdict));
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

enum mr_status landing_bands(const struct report *report, const struct report_landing *landing, FILE *out, struct error *error)
{
    const struct bands_summary *bands = &landing->summary.bands;
    const struct measured *measured = &landing->summary.measured;
    const bool si = report->si;
    const struct unit *force = unit_of(UNIT_TENSION, si);
    static const char *const names[] = {"before", "spread", "least", "most", "after"};
    char heads[5][60], text[400];
    (void)error;
    for (int i = 0; i < 5; i++)
        snprintf(heads[i], sizeof heads[i], "%s, %s", names[i], force->text);
    if (bands->bands) {
        html_table(out, (const char *const[]){"band", heads[0], heads[1], heads[2], heads[3], heads[4], "recovered", NULL});
        for (size_t i = 0; i < bands->bands; i++) {
            const struct store_band *band = &bands->band[i];
            fputs("<tr>", out);
            html_cell(out, "%lld", (long long)band->band);
            html_estimate(out, band->before_lb * force->factor, band->before_error_lb * force->factor, 2);
            html_number(out, band->spread_lb * force->factor, 1);
            extreme_cell(out, measured, band->least_lb, band->least_gage, band->least_block, si);
            extreme_cell(out, measured, band->most_lb, band->most_gage, band->most_block, si);
            html_number(out, band->after_lb * force->factor, 1);
            html_cell(out, "%.0f %%", 100.0 * bands_recovery(band));
            fputs("</tr>\n", out);
        }
        fputs("</tbody></table></div>\n", out);
    }
    for (size_t i = 0; i < bands->events; i++) {
        bands_event_text(&bands->event[i], si, text, sizeof text);
        fprintf(out, "<p class=\"say\">Band %lld: ", (long long)bands->event[i].band);
        html_text(out, text);
        fputs(".</p>\n", out);
    }
    if (bands->shunts)
        shunt_table(bands, si, out);
    return MR_OK;
}
