/* A landing's newest comparison that the campaign keeps: table, zones and picture. */
#include <math.h>

#include "host/compare/agree.h"
#include "host/compare/picture.h"
#include "host/compare/figures.h"
#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

/* En, or a dash. */
static void en_cell(FILE *out, double en)
{
    if (isinf(en))
        html_cell(out, "inf");
    else
        html_number(out, en, en < 100.0 ? 1 : 0);
}

static void channel_row(FILE *out, const struct compare_channel *c, bool si)
{
    double in = unit_of(UNIT_DISPLACEMENT, si)->factor, ft = unit_of(UNIT_STATION, si)->factor;
    int d = si ? 2 : 4;
    fputs("<tr>", out);
    html_cell(out, "%lld", (long long)c->number);
    html_number(out, c->station_ft * ft, 1);
    if (!c->compared) {
        fputs("<td colspan=\"11\">not compared: ", out);
        html_text(out, c->why);
        fputs("</td></tr>\n", out);
        return;
    }
    html_estimate(out, c->f.bias * in, c->f.bias_error * in, d);
    html_number(out, c->f.rms * in, d);
    html_number(out, c->f.chi, 1);
    en_cell(out, c->peak_en);
    en_cell(out, c->end_en);
    html_estimate(out, c->f.arrival_measured.t_s, c->f.arrival_measured.t_error_s, 4);
    html_estimate(out, c->f.arrival_simulated.t_s, c->f.arrival_simulated.t_error_s, 4);
    en_cell(out, c->arrival_en);
    html_number(out, c->f.correlation, 4);
    html_number(out, c->f.lag_s, 3);
    html_number(out, c->f.lag_correlation, 4);
    fputs("</tr>\n", out);
}

static void zone_cell(FILE *out, const struct compare_zone *zone, double ft)
{
    if (!zone->known)
        html_cell(out, "not known");
    else if (!(zone->mats > 0.0))
        html_cell(out, "none");
    else
        html_cell(out, "%.1f to %.1f, %.0f mats", zone->start_ft * ft, zone->end_ft * ft, zone->mats);
}

static void overlap_cell(FILE *out, const struct compare_overlap *overlap)
{
    if (overlap->known && overlap->all_mats > 0.0)
        html_cell(out, "%.0f of %.0f mats", overlap->common_mats, overlap->all_mats);
    else
        html_cell(out, overlap->known ? "both none" : "not known");
}

static void zone_table(FILE *out, const struct compare_zones *zones, bool si)
{
    double ft = unit_of(UNIT_STATION, si)->factor;
    char heads[4][60];
    static const char *const names[] = {"wheel at", "measured", "board", "simulated"};
    for (int i = 0; i < 4; i++)
        snprintf(heads[i], sizeof heads[i], "%s, %s", names[i], unit_of(UNIT_STATION, si)->text);
    html_table(out, (const char *const[]){"zone", "time, s", heads[0], heads[1], heads[2], "measured and board", heads[3], "measured and simulated", NULL});
    for (size_t i = 0; i < zones->count; i++) {
        const struct compare_zone_moment *m = &zones->moment[i];
        fputs("<tr>", out);
        html_cell(out, "%s", m->what);
        html_number(out, m->t_s, 3);
        html_number(out, m->wheel_ft * ft, 1);
        zone_cell(out, &m->zone[COMPARE_MEASURED], ft);
        zone_cell(out, &m->zone[COMPARE_BOARD], ft);
        overlap_cell(out, &m->board);
        zone_cell(out, &m->zone[COMPARE_SIMULATED], ft);
        overlap_cell(out, &m->simulated);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

static void words(FILE *out, const struct compare_figures *figures, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    fputs("<p class=\"say\">", out);
    if (figures->against[0]) {
        fputs("Against ", out);
        html_text(out, figures->against);
        fputs(": ", out);
    }
    if (figures->seeds > 1)
        fprintf(out, "%lld runways, ", (long long)figures->seeds);
    if (!isnan(figures->run_ms))
        fprintf(out, "simulated in %.0f ms, ", figures->run_ms);
    if (!isnan(figures->error_in))
        fprintf(out, "the simulation's own error estimate %.*f %s, ", si ? 2 : 4, figures->error_in * length->factor, length->text);
    if (figures->edges > 0)
        fprintf(out, "aligned on %lld switch edges, ", (long long)figures->edges);
    fprintf(out, "%zu of %u segments surveyed.</p>\n", figures->surveyed, MR_SEGMENTS);
}

/* From what is measured now: a calibration may have changed since. */
bool landing_compared(const struct report_landing *landing, struct compare_figures *figures, struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    const struct compare_said said = {.zone = landing->summary.zones.row, .zones = landing->summary.zones.count};
    return landing->simulations > 0 && measured->fit_status == MR_OK && measured->samples > 0 &&
           compare_figures(measured, &landing->survey, &said, &landing->head, landing->simulation, landing->simulations, figures, error) == MR_OK;
}

enum mr_status landing_compare(const struct report *report, const struct report_landing *landing, FILE *out, struct error *error)
{
    const bool si = report->si;
    const struct measured *measured = &landing->summary.measured;
    struct compare_figures figures;
    struct compare_agreement agreement;
    char heads[3][60], sentence[COMPARE_SENTENCE];
    if (!landing_compared(landing, &figures, error))
        return error->status;
    words(out, &figures, si);
    compare_agreement(&figures, &agreement);
    compare_sentence(&agreement, si, sentence);
    fputs("<p class=\"say\"><strong>", out);
    html_text(out, sentence);
    fputs(".</strong></p>\n", out);
    snprintf(heads[0], sizeof heads[0], "station, %s", unit_of(UNIT_STATION, si)->text);
    snprintf(heads[1], sizeof heads[1], "bias, %s", unit_of(UNIT_DISPLACEMENT, si)->text);
    snprintf(heads[2], sizeof heads[2], "rms, %s", unit_of(UNIT_DISPLACEMENT, si)->text);
    html_table(out, (const char *const[]){"transducer", heads[0], heads[1], heads[2], "chi", "En, peak", "En, end", "arrival measured, s",
                                          "simulated, s", "En", "correlation", "best lag, s", "there", NULL});
    for (size_t i = 0; i < figures.channels; i++)
        channel_row(out, &figures.channel[i], si);
    fputs("</tbody></table></div>\n", out);
    fprintf(out,
            "<p>Differences are measured less simulated. &plusmn; is one standard error: noise, calibration and edge timing; the solver's estimate "
            "and the spread over the runways. chi is the rms difference in standard errors; En is the difference in two of them: up to 1 both "
            "agree. Arrival: %.0f %% of the peak. Best lag: positive when the measured is later. Zones: mats that both have, of those that either has.</p>\n",
            100.0 * SIGNAL_ARRIVAL);
    zone_table(out, &figures.zones, si);
    fputs("<figure>", out);
    compare_draw(out, measured, &landing->head, landing->simulation, landing->simulations, false, si, error);
    fputs("<figcaption>Movement against time, each with its 95 % band.</figcaption></figure>\n", out);
    return error->status;
}
