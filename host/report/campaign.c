/* The campaign's sections: a row per landing, sums over them, advice, observations and notes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/journal.h"
#include "host/analyse/record.h"
#include "host/base/html.h"
#include "host/base/xmalloc.h"
#include "host/report/chart.h"
#include "host/report/report.h"
#include "host/store/store_journal.h"

static const double none = (double)NAN;

/* ---- a row for each landing ---- */

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

static void run_link(FILE *out, int64_t run)
{
    fprintf(out, "<tr><td><a href=\"#run%lld\">%lld</a></td>", (long long)run, (long long)run);
}

static void summary_row(FILE *out, const struct report_facts *facts, bool si)
{
    const struct zone_warning *warning = &facts->warning;
    const struct report_moved *largest = largest_movement(facts);
    double station = unit_of(UNIT_STATION, si)->factor;
    run_link(out, facts->landing.id);
    html_cell(out, "%lld, %s%s", (long long)facts->landing.board_landing,
              mr_landing_state_text((unsigned)facts->landing.state), facts->torn ? ", torn" : "");
    html_cell(out, "%zu of %zu", facts->gates, facts->switches);
    estimate(out, facts->speed_ft_s, UNIT_SPEED, si);
    estimate(out, facts->deceleration_ft_s2, UNIT_DECELERATION, si);
    html_number(out, station * facts->stop_ft.value, 1);
    if (largest)
        html_cell(out, "%.3f at %.0f", largest->peak * unit_of(UNIT_DISPLACEMENT, si)->factor,
                  station * largest->station_ft);
    else
        html_number(out, none, 0);
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

static enum mr_status summary(const struct report *report, FILE *out, struct error *error)
{
    char heads[4][CHART_LABEL], largest[CHART_LABEL], rms[CHART_LABEL];
    const bool si = report->si;
    (void)error;
    if (report->landings == 0)
        return MR_OK;
    snprintf(largest, sizeof largest, "largest movement, %s at %s",
             unit_of(UNIT_DISPLACEMENT, si)->text, unit_of(UNIT_STATION, si)->text);
    html_table(out,
               (const char *const[]){
                   "RUN", "landing", "switches",
                   chart_label(heads[0], "touchdown speed", UNIT_SPEED, si),
                   chart_label(heads[1], "mean deceleration", UNIT_DECELERATION, si),
                   chart_label(heads[2], "stop", UNIT_STATION, si), largest,
                   chart_label(heads[3], "zone warned of", UNIT_STATION, si), "frames lost",
                   chart_label(rms, "worst rms against simulation", UNIT_DISPLACEMENT, si), NULL});
    for (size_t i = 0; i < report->landings; i++)
        summary_row(out, &report->facts[i], si);
    fputs("</tbody></table></div>\n<p>&plusmn; is one standard error.</p>\n", out);
    return MR_OK;
}

/* ---- cumulative displacement (report figs. 4.5, 4.6, 5.2) ---- */

#define NAMED_MAX \
    8u /* so many lines of a plot have a name and a look of their own; the others are thin */

/* A value for each transducer. NaN: not known. */
struct profile {
    char name[90];
    double station[MR_TRANSDUCERS], value[MR_TRANSDUCERS], error[MR_TRANSDUCERS];
};

/* What a landing left, added to what the mat had come to `before` (NULL: nothing); or its peak. */
static void profile_of(const struct report_facts *facts, const struct profile *before, bool peak,
                       bool si, struct profile *profile)
{
    double length = unit_of(UNIT_DISPLACEMENT, si)->factor;
    snprintf(profile->name, sizeof profile->name, "RUN %lld", (long long)facts->landing.id);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct report_moved *moved = &facts->moved[i];
        profile->station[i] = unit_of(UNIT_STATION, si)->factor * moved->station_ft;
        profile->value[i] = (before ? before->value[i] : 0.0) +
                            length * (peak ? moved->peak : moved->end);
        profile->error[i] = hypot(before ? before->error[i] : 0.0,
                                  length * (peak ? moved->error : moved->end_error));
    }
}

/* Those named are evenly spread, the last among them. */
static void draw_profiles(FILE *out, const struct profile *profiles, size_t count, const char *what,
                          const char *title, const char *caption, bool si)
{
    const size_t step = (count + NAMED_MAX - 1) / NAMED_MAX;
    char x[CHART_LABEL], y[CHART_LABEL];
    unsigned look = 0;
    struct figure figure = figure_begin(out, title, 1, FIGURE_ZERO);
    figure_plot(&figure,
                &(struct chart_axes){.x = chart_label(x, "station", UNIT_STATION, si),
                                     .y = chart_label(y, what, UNIT_DISPLACEMENT, si),
                                     .x_high = CHART_RUNWAY_FT * unit_of(UNIT_STATION, si)->factor,
                                     .height_px = 230});
    for (size_t i = 0; i < count; i++) {
        const struct profile *profile = &profiles[i];
        bool named = (count - 1 - i) % step == 0;
        double half[MR_TRANSDUCERS];
        for (unsigned k = 0; k < MR_TRANSDUCERS; k++)
            half[k] = SUMMARY_95 * profile->error[k];
        figure_series(&figure,
                      &(struct chart_series){named ? profile->name : NULL, look % 6u,
                                             named ? "whiskers" : "faint", profile->station,
                                             profile->value, named ? half : NULL, MR_TRANSDUCERS});
        look += named;
    }
    figure_end(&figure, NULL, "%s%s", caption, step > 1 ? " Not every line is named." : "");
}

static void profile_table(FILE *out, const struct profile *profiles, size_t count, bool si)
{
    char heads[MR_TRANSDUCERS][40];
    const char *list[MR_TRANSDUCERS + 2] = {"after"};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        snprintf(heads[i], sizeof heads[i], "%.*f %s", si ? 1 : 0, profiles[0].station[i],
                 unit_of(UNIT_STATION, si)->text);
        list[i + 1] = isnan(profiles[0].station[i]) ? "not fitted" : heads[i];
    }
    fprintf(out, "<p>Cumulative displacement by station, %s; &plusmn; is one standard error.</p>\n",
            unit_of(UNIT_DISPLACEMENT, si)->text);
    html_table(out, list);
    for (size_t k = 0; k < count; k++) {
        fputs("<tr>", out);
        html_cell(out, "%s", profiles[k].name);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            html_estimate(out, profiles[k].value[i], profiles[k].error[i], si ? 2 : 4);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

static const char *series_name(const struct report_facts *facts)
{
    return facts->series.id ? facts->series.name : "none named";
}

/* Landings that follow each other in one series. */
static size_t in_series(const struct report *report, size_t first)
{
    size_t count = 1;
    while (first + count < report->landings &&
           report->facts[first + count].series.id == report->facts[first].series.id)
        count++;
    return count;
}

static enum mr_status cumulative(const struct report *report, FILE *out, struct error *error)
{
    const bool si = report->si;
    struct profile *profile = xcalloc(report->landings + 1, sizeof *profile),
                   *last = xcalloc(report->landings + 1, sizeof *last);
    size_t series = 0;
    (void)error;
    for (size_t first = 0, count; first < report->landings; first += count, series++) {
        count = in_series(report, first);
        for (size_t i = 0; i < count; i++)
            profile_of(&report->facts[first + i], i ? &profile[i - 1] : NULL, false, si,
                       &profile[i]);
        if (count < report->landings) {
            fputs("<h3>Series: ", out);
            html_text(out, series_name(&report->facts[first]));
            fputs("</h3>\n", out);
        }
        draw_profiles(out, profile, count, "cumulative displacement",
                      "cumulative displacement against station, after each landing",
                      "Downfield is positive; the sum of what each landing left, with 95 % "
                      "errors; where a reading is missing it is not known from then on. As report "
                      "figs. 4.5 and 4.6.",
                      si);
        profile_table(out, profile, count, si);
        last[series] = profile[count - 1];
        snprintf(last[series].name, sizeof last[series].name, "%.15s",
                 series_name(&report->facts[first]));
    }
    if (series > 1) {
        fputs("<h3>Series against each other</h3>\n", out);
        draw_profiles(out, last, series, "cumulative displacement",
                      "cumulative displacement against station, of each series",
                      "What each series left in all. As report fig. 5.2.", si);
    }
    for (size_t i = 0; i < report->landings; i++)
        profile_of(&report->facts[i], NULL, true, si, &profile[i]);
    fputs("<h3>Peak movement</h3>\n", out);
    draw_profiles(out, profile, report->landings, "peak movement",
                  "peak movement against station, a line per landing",
                  "Largest movement within each landing, by station.", si);
    free(profile);
    free(last);
    return MR_OK;
}

/* ---- zones over the landings ---- */

#define ZONE_ROWS 20u /* landings in a plot */

struct zone_rows {
    const struct report_facts *facts;
    size_t count;
    struct figure *figure;
    double station; /* factor */
};

/* The first uppermost. */
static const char *zone_row_name(void *context, size_t i)
{
    static char name[30];
    const struct zone_rows *rows = context;
    snprintf(name, sizeof name, "RUN %lld", (long long)rows->facts[rows->count - 1 - i].landing.id);
    return name;
}

/* A bar in a third of a row. */
static void bar(const struct zone_rows *rows, double top, unsigned third, const char *kind,
                double from_ft, double to_ft)
{
    double y = top - 0.12 - 0.26 * third;
    figure_shape(rows->figure, kind, rows->station * from_ft, rows->station * to_ft, y - 0.23, y,
                 NULL);
}

static enum mr_status zone_row(const struct zone_rows *rows, size_t row, struct store *store,
                               struct error *error)
{
    const struct report_facts *facts = &rows->facts[row];
    const double top = (double)(rows->count - row);
    struct store_observation *seen = NULL;
    size_t count = 0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        if (facts->closed & 1ull << s)
            bar(rows, top, 1, "closed", (double)MR_SEGMENT_LENGTH_FT * s,
                (double)MR_SEGMENT_LENGTH_FT * (s + 1));
    }
    if (facts->warning.warned)
        bar(rows, top, 0, "warned", facts->warning.most_start_ft, facts->warning.most_end_ft);
    else if (facts->longest.mats > 0)
        bar(rows, top, 0, "reported", facts->longest.start_ft, facts->longest.end_ft);
    if (facts->last.mats > 0)
        bar(rows, top, 2, "behind", facts->last.start_ft, facts->last.end_ft);
    if (facts->fitted)
        figure_shape(rows->figure, "stop", rows->station * facts->stop_ft.value,
                     rows->station * facts->stop_ft.value, top - 0.95, top - 0.05, NULL);
    enum mr_status status = store_observations(store, facts->landing.id, &seen, &count, error);
    for (size_t i = 0; i < count; i++) {
        char panels[30] = "";
        if (seen[i].withdrawn || isnan(seen[i].station_ft))
            continue;
        if (seen[i].panels != STORE_NONE)
            snprintf(panels, sizeof panels, "%lld", (long long)seen[i].panels);
        double x = rows->station * seen[i].station_ft;
        figure_shape(rows->figure, "seen", x, x, top - 0.5, top - 0.5, panels);
    }
    free(seen);
    return status;
}

static enum mr_status zones(const struct report *report, FILE *out, struct error *error)
{
    static const char *const keys[] = {"warned",   "longest zone while it warned",
                                       "reported", "longest zone reported, no warning",
                                       "closed",   "found closed at the end",
                                       "behind",   "reported last",
                                       "stop",     "the stop",
                                       "seen",     "wave or break seen, with its panels",
                                       NULL};
    const double station = unit_of(UNIT_STATION, report->si)->factor;
    enum mr_status status = MR_OK;
    char x[CHART_LABEL];
    for (size_t first = 0; first < report->landings && status == MR_OK; first += ZONE_ROWS) {
        size_t left = report->landings - first;
        struct figure figure = figure_begin(out, "zones of each landing against station", 1,
                                            FIGURE_EACH);
        struct zone_rows rows = {&report->facts[first], left < ZONE_ROWS ? left : ZONE_ROWS,
                                 &figure, station};
        figure_plot(&figure,
                    &(struct chart_axes){.x = chart_label(x, "station", UNIT_STATION, report->si),
                                         .x_high = CHART_RUNWAY_FT * station,
                                         .y_high = (double)rows.count,
                                         .height_px = 40 + 34 * (unsigned)rows.count,
                                         .tick = zone_row_name,
                                         .context = &rows,
                                         .ticks = rows.count});
        for (size_t i = 0; i < rows.count && status == MR_OK; i++)
            status = zone_row(&rows, i, report->store, error);
        figure_end(&figure, keys, "%s",
                   left > ZONE_ROWS ? ""
                                    : "Reported: by the board's predictor. Found: from survey and "
                                      "transducers (no bar: not surveyed, or open).");
    }
    return status;
}

/* ---- band tension against deceleration (report fig. 5.3) ---- */

static unsigned bands_of(const struct report *report)
{
    unsigned bands = 0;
    for (size_t i = 0; i < report->landings; i++) {
        for (unsigned b = 0; report->facts[i].fitted && b < REPORT_BANDS; b++)
            bands = report->facts[i].band[b].gages && b + 1 > bands ? b + 1 : bands;
    }
    return bands;
}

static void draw_tension(const struct report *report, unsigned bands, FILE *out)
{
    const double force = unit_of(UNIT_TENSION, report->si)->factor,
                 factor = unit_of(UNIT_DECELERATION, report->si)->factor;
    double *x = xmalloc(2 * (report->landings + 1) * sizeof *x), *y = x + report->landings + 1;
    char label[2][CHART_LABEL], name[20];
    struct figure figure = figure_begin(out, "average change of band tension against deceleration",
                                        1, FIGURE_ZERO);
    figure_plot(&figure,
                &(struct chart_axes){
                    .x = chart_label(label[0], "mean deceleration", UNIT_DECELERATION, report->si),
                    .y = chart_label(label[1], "average change", UNIT_TENSION, report->si),
                    .height_px = 240});
    figure_shape(&figure, "mark", none, none, 0.0, 0.0, NULL);
    for (unsigned b = 0; b < bands; b++) {
        snprintf(name, sizeof name, "band %u", b + 1);
        for (int rose = 0; rose < 2; rose++) {
            size_t count = 0;
            for (size_t i = 0; i < report->landings; i++) {
                const struct report_facts *facts = &report->facts[i];
                if (!facts->fitted || facts->band[b].gages == 0)
                    continue;
                x[count] = factor * facts->deceleration_ft_s2.value;
                y[count++] = force * (rose ? facts->band[b].rose_lb : facts->band[b].fell_lb);
            }
            figure_series(&figure, &(struct chart_series){name, b, "points", x, y, NULL, count});
        }
    }
    figure_end(&figure, NULL,
               "Change of tension after the first switch, mean over a band's gages: largest fall "
               "(below 0) and largest rise (above). As report fig. 5.3.");
    free(x);
}

static enum mr_status tension(const struct report *report, FILE *out, struct error *error)
{
    const struct unit *unit = unit_of(UNIT_TENSION, report->si),
                      *braking = unit_of(UNIT_DECELERATION, report->si);
    char heads[1 + 2 * REPORT_BANDS][CHART_LABEL];
    const char *list[3 + 2 * REPORT_BANDS] = {"RUN"};
    unsigned bands = bands_of(report);
    (void)error;
    if (bands == 0)
        return MR_OK;
    draw_tension(report, bands, out);
    list[1] = chart_label(heads[0], "mean deceleration", UNIT_DECELERATION, report->si);
    for (unsigned k = 0; k < 2 * bands; k++) {
        snprintf(heads[1 + k], sizeof heads[0], "band %u: largest %s, %s", k / 2 + 1,
                 k % 2 ? "rise" : "fall", unit->text);
        list[2 + k] = heads[1 + k];
    }
    html_table(out, list);
    for (size_t i = 0; i < report->landings; i++) {
        const struct report_facts *facts = &report->facts[i];
        if (!facts->fitted)
            continue;
        fputs("<tr>", out);
        html_cell(out, "%lld", (long long)facts->landing.id);
        html_estimate(out, braking->factor * facts->deceleration_ft_s2.value,
                      braking->factor * facts->deceleration_ft_s2.error, 3);
        for (unsigned b = 0; b < bands; b++) {
            html_number(out, unit->factor * facts->band[b].fell_lb, 2);
            html_number(out, unit->factor * facts->band[b].rose_lb, 2);
        }
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
    return MR_OK;
}

/* ---- measured against simulated: the newest comparison of each landing ---- */

static void overlap_cell(FILE *out, const struct compare_overlap *overlap)
{
    if (!overlap->known)
        html_cell(out, "-");
    else if (overlap->all_mats > 0.0)
        html_cell(out, "%.0f of %.0f", overlap->common_mats, overlap->all_mats);
    else
        html_cell(out, "both none");
}

static void compared_row(FILE *out, const struct report_facts *facts, bool si)
{
    const struct report_compared *compared = &facts->compared;
    const struct compare_mean *mean = &compared->mean;
    const double in = unit_of(UNIT_DISPLACEMENT, si)->factor;
    const int d = si ? 2 : 4;
    run_link(out, facts->landing.id);
    html_cell(out, "%s", compared->against);
    html_cell(out, "%zu of %zu", mean->channels, compared->channels);
    html_number(out, mean->bias_in * in, d);
    html_number(out, mean->rms_in * in, d);
    html_number(out, mean->worst_rms_in * in, d);
    if (isinf(mean->peak_en))
        html_cell(out, "inf");
    else
        html_number(out, mean->peak_en, 1);
    overlap_cell(out, &compared->longest);
    overlap_cell(out, &compared->longest_board);
    overlap_cell(out, &compared->rest);
    html_number(out, compared->error_in * in, d);
    fputs("</tr>\n", out);
}

static enum mr_status compared(const struct report *report, FILE *out, struct error *error)
{
    static const char *const names[] = {"bias", "rms", "worst rms", "own error"};
    const double in = unit_of(UNIT_DISPLACEMENT, report->si)->factor;
    const int d = report->si ? 2 : 4;
    double samples = 0.0, sum = 0.0, squares = 0.0;
    char heads[4][CHART_LABEL];
    size_t rows = 0;
    (void)error;
    for (size_t i = 0; i < report->landings; i++) {
        const struct report_facts *facts = &report->facts[i];
        const struct compare_mean *mean = &facts->compared.mean;
        if (mean->channels == 0)
            continue;
        for (int k = 0; k < 4; k++)
            chart_label(heads[k], names[k], UNIT_DISPLACEMENT, report->si);
        if (rows++ == 0)
            html_table(out, (const char *const[]){"RUN", "against", "channels", heads[0], heads[1],
                                                  heads[2], "worst En of a peak",
                                                  "longest zone, mats", "of the board, mats",
                                                  "zone at rest, mats", heads[3], NULL});
        compared_row(out, facts, report->si);
        samples += mean->samples;
        sum += mean->samples * mean->bias_in;
        squares += mean->samples * mean->rms_in * mean->rms_in;
    }
    if (rows == 0)
        return MR_OK;
    if (rows > 1) { /* all together, weighted by their samples */
        fputs("<tr><td>all</td><td></td><td></td>", out);
        html_number(out, sum / samples * in, d);
        html_number(out, sqrt(squares / samples) * in, d);
        fputs("<td></td><td></td><td></td><td></td><td></td><td></td></tr>\n", out);
    }
    fputs("</tbody></table></div>\n<p>Each landing with the newest comparison that the campaign "
          "keeps. Differences are measured less simulated, over all samples of all channels. "
          "Zones: mats that measured and simulated (or the board) both have, of those that either "
          "has. Own error: the simulation's own estimate.</p>\n",
          out);
    return MR_OK;
}

/* ---- predictions and their outcome ---- */

static void span_cell(FILE *out, bool known, double start_ft, double end_ft, double station)
{
    if (known)
        html_cell(out, "%.1f to %.1f", station * start_ft, station * end_ft);
    else
        html_number(out, none, 0);
}

static void predictor_row(FILE *out, const struct report_facts *facts, double station)
{
    const struct zone_warning *w = &facts->warning;
    int64_t worst = facts->worst_verdict;
    const bool watched = facts->source != MEASURED_IMPORT;
    fputs("<tr>", out);
    html_cell(out, "%lld", (long long)facts->landing.id);
    html_cell(out, "%zu", facts->statements);
    if (w->warned)
        fputs("<td class=\"warn\">warning</td>", out);
    else
        html_cell(out, "%s%s",
                  !watched              ? "no board watched"
                  : worst == STORE_NONE ? "no warning"
                                        : mr_predictor_verdict_text((unsigned)worst),
                  watched && facts->unheard ? ", as far as it was heard" : "");
    html_number(out, w->warned ? w->t_s : none, 3);
    html_cell(out, "%s",
              w->warned && w->reason != STORE_NONE ? mr_predictor_reason_text((unsigned)w->reason)
                                                   : "");
    span_cell(out, w->warned, w->start_ft, w->end_ft, station);
    html_number(out, w->warned && w->reached ? w->true_lead_s : none, 3);
    html_number(out, w->warned ? w->lead_s : none, 3);
    html_number(out, w->warned ? w->lead_became_s : none, 3);
    if (w->warned)
        html_cell(out, "%lld mats, %.1f to %.1f", (long long)w->most_mats,
                  station * w->most_start_ft, station * w->most_end_ft);
    else
        html_number(out, none, 0);
    span_cell(out, facts->last.mats > 0, facts->last.start_ft, facts->last.end_ft, station);
    fputs("</tr>\n", out);
}

static enum mr_status predictor(const struct report *report, FILE *out, struct error *error)
{
    char zone[CHART_LABEL], last[CHART_LABEL];
    size_t statements = 0;
    (void)error;
    for (size_t i = 0; i < report->landings; i++)
        statements += report->facts[i].statements;
    if (statements == 0)
        return MR_OK;
    html_table(out,
               (const char *const[]){
                   "RUN", "statements", "worst", "first warning, s", "because",
                   chart_label(zone, "zone then", UNIT_STATION, report->si), "wheel there after, s",
                   "first lead given, s", "it became, s", "at its longest",
                   chart_label(last, "last reported", UNIT_STATION, report->si), NULL});
    for (size_t i = 0; i < report->landings; i++)
        predictor_row(out, &report->facts[i], unit_of(UNIT_STATION, report->si)->factor);
    fputs("</tbody></table></div>\n<p>Times since touchdown, by the board's clock, at the "
          "beginning of the block that decided. A dash: none was given, or the wheel did not reach "
          "it in the record. No warning is no clearance.</p>\n",
          out);
    return MR_OK;
}

/* Advice, warnings and outcomes. */
static void record_row(const struct record_row *row, double station, FILE *out)
{
    static const char *const warned[] = {[RECORD_UNWATCHED] = "no board watched",
                                         [RECORD_WARNED] = "warned",
                                         [RECORD_QUIET] = "quiet",
                                         [RECORD_UNHEARD] = "not all heard"};
    static const char *const came[] = {"not known", "came", "did not come"};
    const struct outcome *outcome = &row->outcome;
    fputs("<tr>", out);
    html_cell(out, "%lld", (long long)row->run);
    html_cell(out, "%s%s", row->advised ? row->advice.verdict : "none",
              row->advised && row->off_plan ? ", landed otherwise" : "");
    html_number(out, row->advised ? 100.0 * row->advice.zone : none, 0);
    if (row->warned == RECORD_WARNED)
        fputs("<td class=\"warn\">warned</td>", out);
    else
        html_cell(out, "%s", warned[row->warned]);
    html_number(out, row->warned_t_s, 3);
    html_number(out, station * row->warned_ft, 1);
    html_number(out, row->risk_most, 2);
    html_cell(out, "%s", row->is_void ? "void" : came[outcome->came]);
    html_number(out, outcome->mats == STORE_NONE ? none : (double)outcome->mats, 0);
    html_number(out, station * (outcome->mats > 0 ? outcome->start_ft : none), 1);
    html_number(out, outcome->t_s, 2);
    html_number(out, outcome->left_mats == STORE_NONE ? none : (double)outcome->left_mats, 0);
    html_cell(out, "%zu, %zu", outcome->waves, outcome->breaks);
    html_cell(out, "%s", record_verdict_text(row->verdict));
    html_number(out, row->lead_s, 2);
    html_cell(out, "%s",
              row->verdict == RECORD_NOT_KNOWN ? row->why : outcome_basis_text(outcome->basis));
    fputs("</tr>\n", out);
}

static enum mr_status warnings(const struct report *report, FILE *out, struct error *error)
{
    const struct record *record = &report->record;
    char at[CHART_LABEL], longest[CHART_LABEL];
    (void)error;
    if (report->run || record->landings == 0)
        return MR_OK;
    struct answer *answer = answer_new(report->si);
    record_answer(record, false, answer);
    report_answer(answer, out);
    if (record->rows == 0)
        return MR_OK;
    html_table(out,
               (const char *const[]){"RUN", "advice", "zone, %", "the board", "at, s",
                                     chart_label(at, "zone start", UNIT_STATION, report->si),
                                     "risk, most", "a zone", "longest, mats",
                                     chart_label(longest, "start", UNIT_STATION, report->si),
                                     "50 mats at, s", "left at the wheel, mats",
                                     "waves, breaks seen", "outcome", "lead, s", "known by", NULL});
    for (size_t i = 0; i < record->rows; i++)
        record_row(&record->row[i], unit_of(UNIT_STATION, report->si)->factor, out);
    fputs("</tbody></table></div>\n<p>A zone: 50 closed mats or more that the wheel reached before "
          "it stopped, by survey and transducers or by what people saw, never by the predictor. "
          "Longest: of those that the wheel reached. Times since touchdown. Left at the wheel: by "
          "the survey after the landing.</p>\n",
          out);
    return MR_OK;
}

/* ---- advice ---- */

/* The landing that an advice was kept for: the first one after it; NULL: still to come, or not in
 * this report. */
static const struct report_facts *landing_after(const struct report *report,
                                                const struct store_advice *advice)
{
    for (size_t i = 0; i < report->landings; i++) {
        if (report->facts[i].landing.id > advice->after_run)
            return &report->facts[i];
    }
    return NULL;
}

static const char *advice_name(void *context, size_t i)
{
    static char name[60];
    snprintf(name, sizeof name, "%zu: %s", i + 1,
             ((const struct store_advice *)context)[i].verdict);
    return name;
}

static void draw_advice(struct store_advice *advice, size_t count, FILE *out)
{
    static const char *const keys[] = {"mark", "the limit", NULL};
    double *x = xmalloc(3 * count * sizeof *x), *y = x + count, *half = y + count;
    struct figure figure = figure_begin(
        out, "advice before landings: probabilities against the limit", 1, FIGURE_EACH);
    figure_plot(&figure, &(struct chart_axes){.x = "advice",
                                              .y = "probability, %",
                                              .x_high = (double)count,
                                              .y_high = 104.0,
                                              .height_px = 240,
                                              .tick = advice_name,
                                              .context = advice,
                                              .ticks = count,
                                              .on_x = true});
    for (size_t i = 0; i < count; i++) {
        x[i] = (double)i + 0.5;
        y[i] = 50.0 * (advice[i].zone_low + advice[i].zone_high);
        half[i] = 50.0 * (advice[i].zone_high - advice[i].zone_low);
        figure_shape(&figure, "mark", x[i] - 0.45, x[i] + 0.45, 100.0 * advice[i].most,
                     100.0 * advice[i].most, NULL);
    }
    figure_series(
        &figure, &(struct chart_series){"its sampling interval", 0, "whiskers", x, y, half, count});
    for (size_t i = 0; i < count; i++)
        y[i] = 100.0 * advice[i].zone;
    figure_series(&figure, &(struct chart_series){"probability of a zone of 50 mats", 1, "points",
                                                  x, y, NULL, count});
    figure_end(&figure, keys, "Probability of a zone of 50 mats with its sampling interval.");
    free(x);
}

static void advice_row(const struct report *report, const struct store_advice *advice,
                       size_t number, FILE *out)
{
    const struct report_facts *facts = landing_after(report, advice);
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
    if (facts)
        html_cell(out, "%lld", (long long)facts->landing.id);
    else
        html_cell(out, "to come");
    html_number(out, facts ? speed * facts->speed_ft_s.value : none, 1);
    html_number(out, facts ? braking * facts->deceleration_ft_s2.value : none, 2);
    html_cell(out, "%s",
              !facts                      ? ""
              : !facts->warning.warned    ? "no warning"
              : facts->warning.reached    ? "warned, the wheel reached the zone"
              : facts->warning.path_known ? "warned, the wheel did not reach it"
                                          : "warned");
    html_cell(out, "%s", advice->reason);
    fputs("</tr>\n", out);
}

static enum mr_status advice(const struct report *report, FILE *out, struct error *error)
{
    struct store_advice *advice = NULL;
    size_t count = 0;
    char planned[CHART_LABEL], braking[CHART_LABEL], hardest[CHART_LABEL], had[CHART_LABEL];
    enum mr_status status = store_advices(report->store, &advice, &count, error);
    if (status == MR_OK && count) {
        draw_advice(advice, count, out);
        chart_label(braking, "braking", UNIT_DECELERATION, report->si);
        html_table(out, (const char *const[]){
                            "advice", "verdict",
                            chart_label(planned, "planned speed", UNIT_SPEED, report->si), braking,
                            "zone, %",
                            chart_label(hardest, "hardest braking", UNIT_DECELERATION, report->si),
                            "RUN", chart_label(had, "its speed", UNIT_SPEED, report->si), braking,
                            "the board then", "why", NULL});
        for (size_t i = 0; i < count; i++)
            advice_row(report, &advice[i], i + 1, out);
        fputs("</tbody></table></div>\n<p>By matrig advise before the landing beside it. No "
              "warning is no clearance.</p>\n",
              out);
    }
    free(advice);
    return status;
}

/* ---- observations and notes ---- */

static enum mr_status series_answer(struct store *store, const struct store_landing *landing,
                                    struct answer *answer, struct error *error)
{
    struct store_series series;
    char reason[STORE_JOURNAL_TEXT];
    bool is_void, recalibrated = false;
    enum mr_status status = store_series_of(store, landing, &series, error);
    if (status == MR_OK)
        status = store_is_void(store, landing->id, &is_void, reason, error);
    if (status == MR_OK)
        status = store_is_recalibrated(store, landing->id, &recalibrated, error);
    if (status != MR_OK || (!series.name[0] && !series.pattern[0] && !series.runway[0] &&
                            !series.modification[0] && !is_void && !recalibrated))
        return status;
    answer_row(answer);
    answer_count(answer, NULL, "RUN", landing->id);
    answer_count(answer, NULL, "landing", landing->board_landing);
    answer_words(answer, NULL, "series", "%s", series.name);
    answer_words(answer, NULL, "runway", "%s", series.runway);
    answer_words(answer, NULL, "pattern", "%s", series.pattern);
    answer_words(answer, NULL, "modification", "%s", series.modification);
    if (is_void)
        answer_words(answer, NULL, "counts", "void: %s", reason)->warn = true;
    else
        answer_words(answer, NULL, "counts",
                     recalibrated ? "yes; with a corrected calibration" : "yes");
    return status;
}

static enum mr_status observations_answer(struct store *store, const struct store_landing *landing,
                                          struct answer *answer, struct error *error)
{
    struct store_observation *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_observations(store, landing->id, &rows, &count, error);
    for (size_t i = 0; i < count; i++) {
        if (rows[i].withdrawn)
            continue;
        answer_row(answer);
        answer_count(answer, NULL, "RUN", landing->id);
        journal_observation_answer(&rows[i], answer);
    }
    free(rows);
    return status;
}

static enum mr_status changes_answer(struct store *store, const struct store_landing *landing,
                                     struct answer *answer, struct error *error)
{
    struct store_change *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_changes(store, landing->id, &rows, &count, error);
    for (size_t i = 0; i < count; i++) {
        answer_row(answer);
        answer_count(answer, NULL, "RUN", landing->id);
        journal_change_answer(&rows[i], answer);
    }
    free(rows);
    return status;
}

static enum mr_status journal(const struct report *report, FILE *out, struct error *error)
{
    static const struct {
        const char *title;
        enum mr_status (*rows)(struct store *store, const struct store_landing *landing,
                               struct answer *answer, struct error *error);
    } tables[] = {{"Series and validity", series_answer},
                  {"Waves and breaks", observations_answer},
                  {"Notes and corrections", changes_answer}};
    struct store_landing *landing = NULL;
    size_t count = 0;
    struct answer *answer = answer_new(report->si);
    enum mr_status status = store_landings(report->store, &landing, &count, error);
    for (size_t t = 0; t < sizeof tables / sizeof *tables; t++) {
        answer_table(answer, NULL, tables[t].title);
        for (size_t i = 0; i < count && status == MR_OK; i++) {
            if (!report->run || landing[i].id == report->run)
                status = tables[t].rows(report->store, &landing[i], answer, error);
        }
        answer_close(answer);
    }
    report_answer(answer, out);
    free(landing);
    return status;
}

/* ---- the sections, in the order of the page ---- */

const struct report_section report_sections[] = {
    {"summary", "Summary", summary, 1},
    {"cumulative", "Cumulative displacement", cumulative, 2},
    {"zones", "Zone map over the landings", zones, 2},
    {"tension", "Band tension against deceleration", tension, 2},
    {"advice", "Advice before the landings", advice, 0},
    {"record", "Warnings and their outcome", warnings, 0},
    {"predictor", "Predictions", predictor, 2},
    {"compared", "Measured against simulated", compared, 2},
    {"slow", "Between the landings", report_slow, 0},
    {"journal", "Observations and notes", journal, 0},
    {"survey", "Surveys of the mat", report_surveys, 0},
    {NULL, NULL, NULL, 0},
};
