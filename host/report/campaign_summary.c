/* A row for each landing. */
#include <math.h>

#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

static double worst_rms_in(const struct report_landing *landing)
{
    double worst = (double)NAN;
    for (size_t i = 0; i < landing->simulations; i++)
        worst = fmax(worst, landing->simulation[i].rms_in);
    return worst;
}

static const struct measured_channel *largest_movement(const struct measured *measured)
{
    const struct measured_channel *largest = NULL;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind == MR_KIND_DISPLACEMENT && !isnan(channel->peak) &&
            (!largest || fabs(channel->peak) > fabs(largest->peak)))
            largest = channel;
    }
    return largest;
}

static void campaign_row(FILE *out, const struct report_landing *landing, bool si)
{
    const struct summary *summary = &landing->summary;
    const struct measured *measured = &summary->measured;
    const struct zone_warning *warning = &summary->zones.warning;
    const struct measured_channel *largest = largest_movement(measured);
    bool fitted = measured->fit_status == MR_OK;
    const struct mr_estimate none = {(double)NAN, (double)NAN};
    const struct mr_estimate speed = fitted ? measured->summary.touchdown_speed_ft_s : none;
    const struct mr_estimate deceleration = fitted ? measured->summary.mean_deceleration_ft_s2
                                                   : none;
    double station = unit_of(UNIT_STATION, si)->factor;
    char why[ZONES_HEARD_TEXT];
    fprintf(out, "<tr><td><a href=\"#run%lld\">%lld</a></td>", (long long)measured->landing.id,
            (long long)measured->landing.id);
    html_cell(out, "%lld, %s%s", (long long)measured->landing.board_landing,
              mr_landing_state_text((unsigned)measured->landing.state),
              measured->doubts.torn       ? ", torn"
              : measured->doubts.doubtful ? ", doubtful"
                                          : "");
    html_cell(out, "%zu of %zu", measured->gates, measured->switches);
    html_estimate(out, speed.value * unit_of(UNIT_SPEED, si)->factor,
                  speed.error * unit_of(UNIT_SPEED, si)->factor, 3);
    html_estimate(out, deceleration.value * unit_of(UNIT_DECELERATION, si)->factor,
                  deceleration.error * unit_of(UNIT_DECELERATION, si)->factor, 3);
    html_number(out, fitted ? station * measured->summary.stop_station_ft.value : (double)NAN, 1);
    if (largest)
        html_cell(out, "%.3f at %.0f", largest->peak * unit_of(UNIT_DISPLACEMENT, si)->factor,
                  station * (double)largest->config.station_ft);
    else
        html_number(out, (double)NAN, 0);
    if (warning->warned)
        fprintf(out, "<td class=\"warn\">%.1f to %.1f</td>", station * warning->start_ft,
                station * warning->end_ft);
    else
        html_cell(out, "%s",
                  measured->source == MEASURED_IMPORT ? "no board watched"
                  : zones_heard_doubt(&summary->zones.heard, (double)INFINITY, why) ? "not known"
                                                                                    : "none");
    html_cell(out, "%lld",
              (long long)(summary->link[LINK_CAN].lost + summary->link[LINK_SERIAL].lost));
    html_number(out, worst_rms_in(landing) * unit_of(UNIT_DISPLACEMENT, si)->factor, 3);
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
        campaign_row(out, &report->landing[i], si);
    fputs("</tbody></table></div>\n<p>&plusmn; is one standard error.</p>\n", out);
    return MR_OK;
}
