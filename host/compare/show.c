#include "host/compare/show.h"

#include "host/compare/agree.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "host/base/units.h"

#define COLUMNS 100

/* A number in a column, or a dash. */
static void cell(FILE *out, int width, int decimals, double value)
{
    if (!isfinite(value))
        fprintf(out, " %*s", width - 1, isinf(value) ? "inf" : "-");
    else
        fprintf(out, " %*.*f", width - 1, decimals, unit_tidy(value, pow(10.0, -decimals)));
}

/* En or chi: a hundred is as good as a thousand. */
static void ratio(FILE *out, int width, double value)
{
    if (value >= 999.5)
        fprintf(out, " %*s", width - 1, ">999");
    else
        cell(out, width, value < 99.95 ? 1 : 0, value);
}

static void estimate(FILE *out, int width, int decimals, double value, double error)
{
    char text[60] = "-";
    if (isfinite(value))
        snprintf(text, sizeof text, "%.*f +- %.*f", decimals, unit_tidy(value, pow(10.0, -decimals)), decimals, error);
    fprintf(out, " %*s", width - 1, text);
}

static void show_values(FILE *out, const struct compare_figures *figures, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si), *station = unit_of(UNIT_STATION, si);
    double in = length->factor;
    int d = si ? 2 : 4;
    fprintf(out, "              difference, %-2s                           peak, %-2s\n", length->text, length->text);
    fprintf(out, "  no %4s, %s    bias     rms   chi       measured         simulated    En  end: meas.   sim.    En\n", "at", station->text);
    for (size_t i = 0; i < figures->channels; i++) {
        const struct compare_channel *c = &figures->channel[i];
        fprintf(out, "  %2" PRId64 " %7.1f", c->number, c->station_ft * station->factor);
        if (!c->compared) {
            fprintf(out, "   not compared: %s\n", c->why);
            continue;
        }
        cell(out, 9, d, c->f.bias * in);
        cell(out, 8, d, c->f.rms * in);
        ratio(out, 6, c->f.chi);
        estimate(out, 18, d, c->f.peak_measured.value * in, c->f.peak_measured.error * in);
        estimate(out, 18, d, c->f.peak_simulated.value * in, c->f.peak_simulated.error * in);
        ratio(out, 6, c->peak_en);
        cell(out, 9, d, c->end_measured.value * in);
        cell(out, 8, d, c->end_simulated.value * in);
        ratio(out, 6, c->end_en);
        fputc('\n', out);
    }
}

static void show_times(FILE *out, const struct compare_figures *figures, bool si)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    fprintf(out, "     peak at, s     arrival (%.0f %% of the peak), s       wheel ahead, %-2s       correlation\n", 100.0 * SIGNAL_ARRIVAL,
            station->text);
    fprintf(out, "  no  meas.   sim.         measured        simulated   meas.  sim.    En  at lag 0   best, s  there\n");
    for (size_t i = 0; i < figures->channels; i++) {
        const struct compare_channel *c = &figures->channel[i];
        if (!c->compared)
            continue;
        fprintf(out, "  %2" PRId64, c->number);
        cell(out, 7, 3, c->f.peak_measured.t_s);
        cell(out, 7, 3, c->f.peak_simulated.t_s);
        estimate(out, 17, 4, c->f.arrival_measured.t_s, c->f.arrival_measured.t_error_s);
        estimate(out, 17, 4, c->f.arrival_simulated.t_s, c->f.arrival_simulated.t_error_s);
        cell(out, 8, 1, c->ahead_measured_ft * station->factor);
        cell(out, 6, 1, c->ahead_simulated_ft * station->factor);
        ratio(out, 6, c->arrival_en);
        cell(out, 10, 4, c->f.correlation);
        cell(out, 10, 4, c->f.lag_s);
        cell(out, 7, 4, c->f.lag_correlation);
        if (c->why[0])
            fprintf(out, "\n      %s", c->why);
        fputc('\n', out);
    }
}

static void show_zone(FILE *out, const char *who, const struct compare_zone *zone, const struct compare_overlap *overlap, bool si)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    double ft = station->factor;
    fprintf(out, "      %-10s", who);
    if (!zone->known)
        fputs("not known", out);
    else if (!(zone->mats > 0.0))
        fputs("none", out);
    else
        fprintf(out, "%5.1f to %5.1f %s, %2.0f mats", zone->start_ft * ft, zone->end_ft * ft, station->text, zone->mats);
    if (zone->known && zone->mats > 0.0 && !isnan(zone->start_error_ft))
        fprintf(out, " (+- %.1f, %.1f)", zone->start_error_ft * ft, zone->end_error_ft * ft);
    if (overlap && overlap->known && overlap->all_mats > 0.0)
        fprintf(out, "; %.0f of %.0f in common", overlap->common_mats, overlap->all_mats);
    if (overlap && !isnan(overlap->start_ft))
        fprintf(out, "; start %+.1f, end %+.1f", overlap->start_ft * ft, overlap->end_ft * ft);
    fputc('\n', out);
}

static void show_zones(FILE *out, const struct compare_zones *zones, bool si)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    for (size_t i = 0; i < zones->count; i++) {
        const struct compare_zone_moment *m = &zones->moment[i];
        fprintf(out, "  zone, %s: at %.3f s, the wheel at %.1f %s (differences: measured less the other)\n", m->what, m->t_s,
                m->wheel_ft * station->factor, station->text);
        show_zone(out, "measured", &m->zone[COMPARE_MEASURED], NULL, si);
        show_zone(out, "board", &m->zone[COMPARE_BOARD], &m->board, si);
        show_zone(out, "simulated", &m->zone[COMPARE_SIMULATED], &m->simulated, si);
    }
}

/* A sentence in lines that fit a terminal. */
static void show_sentence(FILE *out, const char *text)
{
    size_t column = 0;
    while (*text) {
        size_t length = strcspn(text, " ");
        if (column > 0 && column + 1 + length > COLUMNS) {
            fputs("\n ", out);
            column = 1;
        }
        column += (size_t)fprintf(out, "%s%.*s", column > 0 ? " " : "", (int)length, text);
        text += length + strspn(text + length, " ");
    }
    fputc('\n', out);
}

void compare_show(FILE *out, const struct compare_figures *figures, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    double alignment_in = 0.0;
    for (size_t i = 0; i < figures->channels; i++)
        alignment_in = fmax(alignment_in, figures->channel[i].alignment_in);
    fprintf(out, "RUN %" PRId64 " against %s: simulated in %.0f ms, its own error estimate %.*f %s\n", figures->run, figures->against,
            figures->run_ms, si ? 2 : 4, figures->error_in * length->factor, length->text);
    if (figures->doubt[0])
        fprintf(out, "  %s\n", figures->doubt);
    if (figures->seeds > 1)
        fprintf(out, "  %" PRId64 " runways: their mean, with their spread as part of its error\n", figures->seeds);
    fprintf(out, "  aligned on %" PRId64 " switch edges: simulated %.4f s later, rms %.4f s, worth up to %.*f %s\n",
            figures->edges, unit_tidy(figures->offset_s, 1e-4), figures->scatter_s, si ? 2 : 4, alignment_in * length->factor, length->text);
    fprintf(out, "  %zu of %u segments surveyed\n", figures->surveyed, MR_SEGMENTS);
    show_values(out, figures, si);
    show_times(out, figures, si);
    show_zones(out, &figures->zones, si);
    struct compare_agreement agreement;
    char sentence[COMPARE_SENTENCE];
    compare_agreement(figures, &agreement);
    compare_sentence(&agreement, si, sentence);
    show_sentence(out, sentence);
    fputs("+- is one standard error. chi: rms of the difference in standard errors. En up to 1: they agree.\n", out);
}

void compare_show_verdict(FILE *out, const struct compare_verdict *verdict)
{
    if (verdict->checked > 0)
        fprintf(out, "limits: %zu checked, %zu failed: %s\n", verdict->checked, verdict->failed, verdict->failed ? "FAIL" : "pass");
}

/* ---- a series ---- */

static void show_overlap(FILE *out, const struct compare_zone_moment *moment, const struct compare_overlap *overlap)
{
    char text[20] = "-";
    if (moment && overlap->known && overlap->all_mats > 0.0)
        snprintf(text, sizeof text, "%.0f/%.0f", overlap->common_mats, overlap->all_mats);
    else if (moment && overlap->known)
        snprintf(text, sizeof text, "none");
    fprintf(out, " %8s", text);
}

static void show_series_landing(FILE *out, const struct compare_series_landing *landing, double in, int d)
{
    const struct compare_figures *figures = &landing->figures;
    const struct compare_zone_moment *longest = compare_moment_of(&figures->zones, false), *rest = compare_moment_of(&figures->zones, true);
    const struct compare_mean mean = compare_mean_of(figures);
    fprintf(out, "  %3" PRId64, landing->run);
    if (!landing->compared) {
        fprintf(out, "  not compared: %s\n", landing->why);
        return;
    }
    fprintf(out, "  %zu of %zu", mean.channels, figures->channels);
    cell(out, 8, d, mean.bias_in * in);
    cell(out, 8, d, mean.rms_in * in);
    cell(out, 8, d, mean.worst_rms_in * in);
    ratio(out, 8, mean.peak_en);
    show_overlap(out, longest, longest ? &longest->simulated : NULL);
    show_overlap(out, longest, longest ? &longest->board : NULL);
    show_overlap(out, rest, rest ? &rest->simulated : NULL);
    cell(out, 8, d, figures->error_in * in);
    cell(out, 8, 0, figures->run_ms);
    fprintf(out, "  %s\n", landing->verdict.checked == 0 ? "-" : landing->verdict.failed ? "FAIL" : "pass");
}

static void show_moved(FILE *out, const struct compare_moved *moved, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si), *station = unit_of(UNIT_STATION, si);
    double in = length->factor;
    int d = si ? 2 : 4;
    fprintf(out, "moved from survey %" PRId64 " to %" PRId64 ", %zu landing%s, %s: ", moved->from_survey, moved->to_survey, moved->landings,
            moved->landings == 1 ? "" : "s", length->text);
    if (!moved->simulated) {
        fputs("not compared: a landing between them was not simulated\n", out);
        return;
    }
    fprintf(out, "bias %.*f, rms %.*f, chi %.1f of %zu gage points\n", d, moved->bias_in * in, d, moved->rms_in * in, moved->chi, moved->points);
    fprintf(out, "  at, %-2s      measured         simulated    difference\n", station->text);
    for (size_t p = 0; p < SURVEY_POINTS; p += 4) {
        fprintf(out, "  %6.1f", (double)p * SURVEY_SPAN_FT * station->factor);
        estimate(out, 18, d, moved->point[p].measured_in * in, moved->point[p].error_in * in);
        estimate(out, 18, d, moved->point[p].simulated_in * in, moved->point[p].spread_in * in);
        cell(out, 12, d, (moved->point[p].measured_in - moved->point[p].simulated_in) * in);
        fputc('\n', out);
    }
}

void compare_show_series(FILE *out, const struct compare_series *set, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si), *station = unit_of(UNIT_STATION, si);
    double in = length->factor;
    int d = si ? 2 : 4;
    fprintf(out, "%s%s against %s: %zu landing%s, %zu compared\n  simulated in %.0f ms, their own error estimates up to %.*f %s\n",
            set->name[0] ? "series " : "all landings", set->name, set->against, set->count, set->count == 1 ? "" : "s", set->compared, set->run_ms, d,
            set->error_in * in, length->text);
    fprintf(out, "                difference, %-2s                 zones: common/all mats\n", length->text);
    fprintf(out, "  RUN channels    bias     rms   worst peak En  longest    board  at rest   error      ms  limits\n");
    for (size_t i = 0; i < set->count; i++)
        show_series_landing(out, &set->landing[i], in, d);
    fprintf(out, "over the landings, by samples, %s:\n  no  at, %-2s landings     bias      rms\n", length->text, station->text);
    for (size_t c = 0; c < MR_TRANSDUCERS; c++) {
        if (set->channel[c].landings == 0)
            continue;
        fprintf(out, "  %2" PRId64 " %7.1f %8zu", set->channel[c].number, set->channel[c].station_ft * station->factor, set->channel[c].landings);
        cell(out, 9, d, set->channel[c].bias_in * in);
        cell(out, 9, d, set->channel[c].rms_in * in);
        fputc('\n', out);
    }
    fprintf(out, "  all %15zu", set->compared);
    cell(out, 9, d, set->pooled.bias_in * in);
    cell(out, 9, d, set->pooled.rms_in * in);
    fputc('\n', out);
    for (size_t i = 0; i < set->moves; i++)
        show_moved(out, &set->moved[i], si);
    char sentence[COMPARE_SENTENCE];
    compare_series_sentence(set, si, sentence);
    show_sentence(out, sentence);
    if (set->verdict.checked > 0)
        fprintf(out, "within limits: %.0f %% of the landings\n", 100.0 * set->pooled.within);
}
