/* Measured against simulated, a row for each landing: their newest comparisons, as the campaign
 * keeps them. */
#include <math.h>
#include <stdlib.h>

#include "host/compare/figures.h"
#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

static void overlap_cell(FILE *out, const struct compare_overlap *overlap)
{
    if (!overlap->known)
        html_cell(out, "-");
    else if (overlap->all_mats > 0.0)
        html_cell(out, "%.0f of %.0f", overlap->common_mats, overlap->all_mats);
    else
        html_cell(out, "both none");
}

static void row(FILE *out, const struct report *report, const struct report_facts *facts)
{
    const struct report_compared *compared = &facts->compared;
    const bool si = report->si;
    const double in = unit_of(UNIT_DISPLACEMENT, si)->factor;
    const int d = si ? 2 : 4;
    const struct compare_mean mean = compared->mean;
    fprintf(out, "<tr><td><a href=\"#run%lld\">%lld</a></td><td>", (long long)facts->landing.id,
            (long long)facts->landing.id);
    html_text(out, compared->against);
    fputs("</td>", out);
    html_cell(out, "%zu of %zu", mean.channels, compared->channels);
    html_number(out, mean.bias_in * in, d);
    html_number(out, mean.rms_in * in, d);
    html_number(out, mean.worst_rms_in * in, d);
    if (isinf(mean.peak_en))
        html_cell(out, "inf");
    else
        html_number(out, mean.peak_en, 1);
    overlap_cell(out, &compared->longest);
    overlap_cell(out, &compared->longest_board);
    overlap_cell(out, &compared->rest);
    html_number(out, compared->error_in * in, d);
    fputs("</tr>\n", out);
}

/* All landings together, weighted by their samples. */
static void last_row(FILE *out, double samples, double sum, double squares, bool si)
{
    const double in = unit_of(UNIT_DISPLACEMENT, si)->factor;
    fputs("<tr><td>all</td><td></td><td></td>", out);
    html_number(out, sum / samples * in, si ? 2 : 4);
    html_number(out, sqrt(squares / samples) * in, si ? 2 : 4);
    fputs("<td></td><td></td><td></td><td></td><td></td><td></td></tr>\n", out);
}

static void head(FILE *out, bool si)
{
    static const char *const names[] = {"bias", "rms", "worst rms", "own error"};
    char heads[4][60];
    for (int i = 0; i < 4; i++)
        snprintf(heads[i], sizeof heads[i], "%s, %s", names[i],
                 unit_of(UNIT_DISPLACEMENT, si)->text);
    html_table(out,
               (const char *const[]){"RUN", "against", "channels", heads[0], heads[1], heads[2],
                                     "worst En of a peak", "longest zone, mats",
                                     "of the board, mats", "zone at rest, mats", heads[3], NULL});
}

enum mr_status campaign_compared(const struct report *report, FILE *out, struct error *error)
{
    double samples = 0.0, sum = 0.0, squares = 0.0;
    size_t rows = 0;
    (void)error;
    for (size_t i = 0; i < report->landings; i++) {
        const struct report_facts *facts = &report->facts[i];
        const struct compare_mean mean = facts->compared.mean;
        if (mean.channels == 0)
            continue;
        if (rows++ == 0)
            head(out, report->si);
        row(out, report, facts);
        samples += mean.samples;
        sum += mean.samples * mean.bias_in;
        squares += mean.samples * mean.rms_in * mean.rms_in;
    }
    if (rows > 1)
        last_row(out, samples, sum, squares, report->si);
    if (rows)
        fputs("</tbody></table></div>\n<p>Each landing with the newest comparison that the "
              "campaign keeps. Differences are measured less simulated, over "
              "all samples of all channels. Zones: mats that measured and simulated (or what the "
              "board said) both have, of those that either has. "
              "Own error: what the simulation says of itself.</p>\n",
              out);
    return MR_OK;
}
