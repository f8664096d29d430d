/* What each transducer and gage read, as tables. */
#include <math.h>

#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

static void channel_table(FILE *out, const struct report_landing *landing, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    double length = unit_of(UNIT_DISPLACEMENT, si)->factor;
    static const char *const names[] = {"peak measured", "peak simulated", "rms difference", "end measured", "end simulated"};
    char heads[6][60];
    snprintf(heads[5], sizeof heads[5], "station, %s", unit_of(UNIT_STATION, si)->text);
    for (int i = 0; i < 5; i++)
        snprintf(heads[i], sizeof heads[i], "%s, %s", names[i], unit_of(UNIT_DISPLACEMENT, si)->text);
    html_table(out, (const char *const[]){"transducer", heads[5], heads[0], heads[1], heads[2], heads[3], heads[4], "valid", NULL});
    for (unsigned number = 1; number <= MR_TRANSDUCERS; number++) {
        int c = measured_find(measured, MR_KIND_DISPLACEMENT, number);
        if (c < 0)
            continue;
        const struct measured_channel *channel = &measured->channel[c];
        const struct store_simulation *row = NULL;
        for (size_t i = 0; i < landing->simulations; i++)
            row = landing->simulation[i].number == number ? &landing->simulation[i] : row;
        fputs("<tr>", out);
        html_cell(out, "%u", number);
        html_number(out, (double)channel->config.station_ft * unit_of(UNIT_STATION, si)->factor, 1);
        html_estimate(out, channel->peak * length, channel->error * length, 4);
        html_estimate(out, row ? row->peak_simulated_in * length : (double)NAN,
                      row ? row->peak_simulated_error_in * length : 0.0, 4);
        html_number(out, row ? row->rms_in * length : (double)NAN, 4);
        html_number(out, channel->end * length, 4);
        html_number(out, row ? row->end_simulated_in * length : (double)NAN, 4);
        html_cell(out, "%.1f %%",
                  measured->samples ? 100.0 * (double)channel->valid / (double)measured->samples : 0.0);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

static void gage_table(FILE *out, const struct measured *measured, bool si)
{
    double force = unit_of(UNIT_TENSION, si)->factor;
    static const char *const names[] = {"before", "least", "most", "at the end"};
    char heads[5][60];
    snprintf(heads[4], sizeof heads[4], "station, %s", unit_of(UNIT_STATION, si)->text);
    for (int i = 0; i < 4; i++)
        snprintf(heads[i], sizeof heads[i], "%s, %s", names[i], unit_of(UNIT_TENSION, si)->text);
    html_table(out, (const char *const[]){"gage", "band", heads[4], heads[0], heads[1], heads[2], heads[3], "valid", NULL});
    for (unsigned number = 1; number <= MR_GAGES; number++) {
        int c = measured_find(measured, MR_KIND_TENSION, number);
        if (c < 0)
            continue;
        const struct measured_channel *channel = &measured->channel[c];
        fputs("<tr>", out);
        html_cell(out, "%u", number);
        html_cell(out, "%u", channel->config.band);
        html_number(out, (double)channel->config.station_ft * unit_of(UNIT_STATION, si)->factor, 1);
        html_number(out, channel->baseline * force, 1);
        html_estimate(out, channel->low * force, channel->low_error * force, 2);
        html_estimate(out, channel->high * force, channel->high_error * force, 2);
        html_number(out, channel->end * force, 1);
        html_cell(out, "%.1f %%",
                  measured->samples ? 100.0 * (double)channel->valid / (double)measured->samples : 0.0);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

enum mr_status landing_channels(const struct report *report, const struct report_landing *landing, FILE *out, struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    (void)error;
    if (measured->samples == 0)
        return MR_OK;
    channel_table(out, landing, report->si);
    fprintf(out,
            "<p>Peaks are extremes of an %d ms moving mean; &plusmn; is one standard error, calibration and noise together, or the "
            "simulation's own estimate%s.</p>\n",
            MEASURED_WINDOW, landing->simulations ? "" : ". No comparison has been run: matrig compare");
    gage_table(out, measured, report->si);
    return MR_OK;
}
