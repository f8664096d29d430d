/* A row for each landing. */
#include <math.h>

#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

static const struct report_moved *largest_movement(const struct report_facts *facts)
{
    const struct report_moved *largest = NULL;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct report_moved *moved = &facts->moved[i];
        if (!isnan(moved->peak) && (!largest || fabs(moved->peak) > fabs(largest->peak)))
            largest = moved;
    }
    return largest;
}

static void estimate(FILE *out, struct mr_estimate value, enum unit_kind kind, bool si)
{
    double factor = unit_of(kind, si)->factor;
    html_estimate(out, value.value * factor, value.error * factor, 3);
}

static void campaign_row(FILE *out, const struct report *report, const struct report_facts *facts)
{
    const struct zone_warning *warning = &facts->warning;
    const struct report_moved *largest = largest_movement(facts);
    const bool si = report->si;
    double station = unit_of(UNIT_STATION, si)->factor;
    fprintf(out, "<tr><td><a href=\"#run%lld\">%lld</a></td>", (long long)facts->landing.id,
            (long long)facts->landing.id);
    html_cell(out, "%lld, %s%s", (long long)facts->landing.board_landing,
              mr_landing_state_text((unsigned)facts->landing.state),
              facts->torn       ? ", torn"
              : facts->doubtful ? ", doubtful"
                                : "");
    html_cell(out, "%zu of %zu", facts->gates, facts->switches);
    estimate(out, facts->speed_ft_s, UNIT_SPEED, si);
    estimate(out, facts->deceleration_ft_s2, UNIT_DECELERATION, si);
    html_number(out, station * facts->stop_ft.value, 1);
    if (largest)
        html_cell(out, "%.3f at %.0f", largest->peak * unit_of(UNIT_DISPLACEMENT, si)->factor,
                  station * largest->station_ft);
    else
        html_number(out, (double)NAN, 0);
    if (warning->warned)
        fprintf(out, "<td class=\"warn\">%.1f to %.1f</td>", station * warning->start_ft,
                station * warning->end_ft);
    else
        html_cell(out, "%s",
                  facts->source == MEASURED_IMPORT ? "no board watched"
                  : facts->unheard                 ? "not known"
                                                   : "none");
    html_cell(out, "%lld", (long long)facts->lost);
    html_number(out, facts->worst_rms_in * unit_of(UNIT_DISPLACEMENT, si)->factor, 3);
    fputs("</tr>\n", out);
}

enum mr_status campaign_summary(const struct report *report, FILE *out, struct error *error)
{
    const bool si = report->si;
    char heads[7][60];
    (void)error;
    if (report->landings == 0)
        return MR_OK;
    snprintf(heads[0], sizeof heads[0], "touchdown speed, %s", unit_of(UNIT_SPEED, si)->text);
    snprintf(heads[1], sizeof heads[1], "mean deceleration, %s",
             unit_of(UNIT_DECELERATION, si)->text);
    snprintf(heads[2], sizeof heads[2], "stop, %s", unit_of(UNIT_STATION, si)->text);
    snprintf(heads[3], sizeof heads[3], "largest movement, %s at %s",
             unit_of(UNIT_DISPLACEMENT, si)->text, unit_of(UNIT_STATION, si)->text);
    snprintf(heads[4], sizeof heads[4], "zone warned of, %s", unit_of(UNIT_STATION, si)->text);
    snprintf(heads[5], sizeof heads[5], "worst rms against simulation, %s",
             unit_of(UNIT_DISPLACEMENT, si)->text);
    html_table(out,
               (const char *const[]){"RUN", "landing", "switches", heads[0], heads[1], heads[2],
                                     heads[3], heads[4], "frames lost", heads[5], NULL});
    for (size_t i = 0; i < report->landings; i++)
        campaign_row(out, report, &report->facts[i]);
    fputs("</tbody></table></div>\n<p>&plusmn; is one standard error.</p>\n", out);
    return MR_OK;
}
