/* Sections about the campaign: one row per landing, sums over landings, advice, observations and
 * notes. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/journal.h"
#include "host/analyse/rig.h"
#include "host/analyse/outcome.h"
#include "host/base/answer.h"
#include "host/base/html.h"
#include "host/base/xmalloc.h"
#include "host/report/chart.h"
#include "host/report/report.h"
#include "host/store/store_journal.h"

static const double unknown_value = (double)NAN;

/* ---- one row per landing ---- */

/* Adds the columns "start of zone" and "end of zone"; dashes if they are not known (NaN). */
static void add_zone_ends(struct answer *answer, const char *label, const struct report_zone *zone)
{
    char head[CHART_LABEL_SIZE];
    snprintf(head, sizeof head, "start of %s", label);
    answer_add_estimate(answer, NULL, head, UNIT_STATION, zone->start_ft, zone->start_error_ft, 1);
    snprintf(head, sizeof head, "end of %s", label);
    answer_add_estimate(answer, NULL, head, UNIT_STATION, zone->end_ft, zone->end_error_ft, 1);
}

static void add_summary_row(const struct report_facts *facts, struct answer *answer)
{
    const struct zone_warning *warning = &facts->warning;
    const struct report_movement *largest = report_find_largest_movement(facts);
    answer_open_row(answer);
    answer_add_count(answer, NULL, "RUN", facts->landing.id)->is_run_number = true;
    answer_add_count(answer, NULL, "landing", facts->landing.board_landing);
    answer_add_text(answer, NULL, "state", "%s%s",
                    mr_landing_state_text((unsigned)facts->landing.state),
                    facts->is_incomplete ? ", incomplete" : "");
    answer_add_text(answer, NULL, "switches", "%zu of %zu", facts->gate_count, facts->switch_count);
    answer_add_estimate(answer, NULL, "touchdown speed", UNIT_SPEED, facts->speed_ft_s.value,
                        facts->speed_ft_s.error, 3);
    answer_add_estimate(answer, NULL, "mean deceleration", UNIT_DECELERATION,
                        facts->deceleration_ft_s2.value, facts->deceleration_ft_s2.error, 3);
    answer_add_estimate(answer, NULL, "stop", UNIT_STATION, facts->stop_ft.value,
                        facts->stop_ft.error, 3);
    answer_add_estimate(answer, NULL, "largest movement", UNIT_DISPLACEMENT,
                        largest ? largest->peak_in : unknown_value,
                        largest ? largest->peak_error_in : unknown_value, 3);
    answer_add_value(answer, NULL, "at station", UNIT_STATION,
                     largest ? largest->station_ft : unknown_value, 0);
    answer_add_text(answer, NULL, "warning", "%s",
                    warning->has_warning               ? "yes"
                    : facts->source == MEASURED_IMPORT ? "no board"
                    : facts->may_have_missed_warning   ? "not known"
                                                       : "none")
        ->is_warning = warning->has_warning;
    add_zone_ends(answer, "zone", &facts->longest_warned_zone);
    answer_add_count(answer, NULL, "frames lost", facts->lost_frames);
}

/* Writes a table with the rows that `row` adds for each landing. */
static void write_landings_table(const struct report *report, FILE *out, const char *note,
                                 void (*row)(const struct report_facts *facts,
                                             struct answer *answer))
{
    struct answer *answer = answer_new(report->si);
    answer_open_table(answer, NULL, "");
    for (size_t i = 0; i < report->landings; i++)
        row(&report->facts[i], answer);
    answer_close_group(answer);
    answer_add_sentence(answer, NULL, "%s", note);
    report_write_answer(answer, out);
}

/* A sentence about the landings whose marks contain `mark`; it lists them unless all are meant. */
static void write_mark_note(const struct report *report, const char *mark, const char *meaning,
                            FILE *out)
{
    size_t count = 0;
    bool *of = xcalloc(report->landings + 1, sizeof *of);
    for (size_t i = 0; i < report->landings; i++) {
        of[i] = strstr(report->facts[i].quality_text, mark) != NULL;
        count += of[i];
    }
    if (count) {
        fprintf(out, "<p>%s", meaning);
        if (count < report->landings) {
            fputs(" (", out);
            report_write_runs(report, of, out);
            fputs(")", out);
        }
        fputs(".</p>\n", out);
    }
    free(of);
}

static void write_summary(const struct report *report, FILE *out)
{
    if (report->landings)
        write_landings_table(report, out,
                             "\xc2\xb1 is one standard error. Zone: the longest zone that the "
                             "board reported while the warning was on.",
                             add_summary_row);
    write_mark_note(
        report, "UNCALIBRATED",
        "UNCALIBRATED: a sensor has no calibration date. Its \xc2\xb1 contains the scale "
        "error that the configuration states; this error was not measured",
        out);
    write_mark_note(report, "calibration unknown",
                    "Calibration unknown, because the configuration of the board was not read",
                    out);
}

/* ---- cumulative displacement (figs. 4.5, 4.6, 5.2 of the 1973 report) ---- */

/* maximum number of lines with a name and a style of their own; further lines are thin */
#define NAMED_PROFILES_MAX 8u

/* one value per transducer; NaN: not known */
struct profile {
    char name[90];
    double station[MR_TRANSDUCERS], value[MR_TRANSDUCERS], error[MR_TRANSDUCERS];
};

/* Makes the displacement after a landing: that of the landing plus `before`, the sum over earlier
 * landings (NULL: 0). With `peak`: the peak displacement of the landing. */
static void make_displacement_profile(const struct report_facts *facts,
                                      const struct profile *before, bool peak,
                                      struct profile *profile)
{
    snprintf(profile->name, sizeof profile->name, "RUN %lld", (long long)facts->landing.id);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct report_movement *moved = &facts->movement[i];
        profile->station[i] = moved->station_ft;
        profile->value[i] = (before ? before->value[i] : 0.0) +
                            (peak ? moved->peak_in : moved->end_in);
        profile->error[i] = hypot(before ? before->error[i] : 0.0,
                                  peak ? moved->peak_error_in : moved->end_error_in);
    }
}

/* Draws the profiles. Evenly spaced profiles and the last one get labels. */
static void draw_profiles(FILE *out, const struct profile *profiles, size_t count, const char *what,
                          const char *title, const char *caption, bool si)
{
    const size_t step = (count + NAMED_PROFILES_MAX - 1) / NAMED_PROFILES_MAX;
    unsigned look = 0;
    struct figure figure = figure_begin(out, si, title, 1, FIGURE_RANGE_WITH_ZERO);
    figure_begin_plot(&figure, &(struct chart_axes){.x = "station",
                                                    .x_unit = UNIT_STATION,
                                                    .y = what,
                                                    .y_unit = UNIT_DISPLACEMENT,
                                                    .x_high = RIG_RUNWAY_FT,
                                                    .height_px = 230});
    for (size_t i = 0; i < count; i++) {
        const struct profile *profile = &profiles[i];
        bool named = (count - 1 - i) % step == 0;
        double half[MR_TRANSDUCERS];
        for (unsigned k = 0; k < MR_TRANSDUCERS; k++)
            half[k] = SUMMARY_HALF_WIDTH_95 * profile->error[k];
        figure_add_series(&figure, &(struct chart_series){named ? profile->name : NULL, look % 6u,
                                                          named ? "whiskers" : "faint",
                                                          profile->station, profile->value,
                                                          named ? half : NULL, MR_TRANSDUCERS});
        look += named;
    }
    figure_end(&figure, NULL, "%s%s", caption,
               step > 1 ? " Thin lines are landings that the legend omits." : "");
}

static void write_profile_table(FILE *out, const struct profile *profiles, size_t count, bool si)
{
    struct answer *answer = answer_new(si);
    answer_open_table(answer, NULL, "");
    for (size_t k = 0; k < count; k++) {
        answer_open_row(answer);
        answer_add_text(answer, NULL, "after", "%s", profiles[k].name);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            char head[40];
            snprintf(head, sizeof head, "at %.*f %s", si ? 1 : 0,
                     profiles[0].station[i] * unit_get(UNIT_STATION, si)->factor,
                     unit_get(UNIT_STATION, si)->text);
            if (!isnan(profiles[0].station[i]))
                answer_add_estimate(answer, NULL, head, UNIT_DISPLACEMENT, profiles[k].value[i],
                                    profiles[k].error[i], 4);
        }
    }
    answer_close_group(answer);
    answer_add_sentence(answer, NULL,
                        "Cumulative displacement by station; \xc2\xb1 is one standard error.");
    report_write_answer(answer, out);
}

static const char *get_series_name(const struct report_facts *facts)
{
    return facts->series.id ? facts->series.name : "none named";
}

/* Returns the number of consecutive landings in one series, beginning with `first`. */
static size_t count_series_landings(const struct report *report, size_t first)
{
    size_t count = 1;
    while (first + count < report->landings &&
           report->facts[first + count].series.id == report->facts[first].series.id)
        count++;
    return count;
}

/* Returns the number of earlier landings of the series to which a landing adds: those before it or,
 * if its runway was restored, those before the landing that began on the same runway. */
static size_t count_landings_before(const struct report_facts *series, size_t at)
{
    for (size_t i = 0; i < at; i++) {
        if (series[i].landing.id == series[at].warning_record.first_run_on_runway)
            return count_landings_before(series, i);
    }
    return at;
}

static void write_restored_runways(FILE *out, const struct report_facts *series, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        size_t before = count_landings_before(series, i);
        if (before == i)
            continue;
        fprintf(out, "<p class=\"say\">RUN %lld started on the same runway as RUN %lld, restored",
                (long long)series[i].landing.id,
                (long long)series[i].warning_record.first_run_on_runway);
        if (before)
            fprintf(out, ": the cumulative displacement continues from RUN %lld",
                    (long long)series[before - 1].landing.id);
        fputs(".</p>\n", out);
    }
}

static void write_cumulative_displacement(const struct report *report, FILE *out)
{
    const bool si = report->si;
    struct profile *profile = xcalloc(report->landings + 1, sizeof *profile),
                   *last = xcalloc(report->landings + 1, sizeof *last);
    size_t series = 0;
    for (size_t first = 0, count; first < report->landings; first += count, series++) {
        count = count_series_landings(report, first);
        for (size_t i = 0; i < count; i++) {
            size_t before = count_landings_before(&report->facts[first], i);
            make_displacement_profile(&report->facts[first + i],
                                      before ? &profile[before - 1] : NULL, false, &profile[i]);
        }
        if (count < report->landings) {
            fputs("<h3>Series: ", out);
            html_write_text(out, get_series_name(&report->facts[first]));
            fputs("</h3>\n", out);
        }
        draw_profiles(out, profile, count, "cumulative displacement",
                      "cumulative displacement against station, after each landing",
                      "Sum of the displacements that remained after each landing, with 95 % "
                      "intervals; downfield is positive. The sum ends where a reading is missing. "
                      "Compare figs. 4.5 and 4.6 of the 1973 report.",
                      si);
        write_profile_table(out, profile, count, si);
        write_restored_runways(out, &report->facts[first], count);
        last[series] = profile[count - 1];
        snprintf(last[series].name, sizeof last[series].name, "%.15s",
                 get_series_name(&report->facts[first]));
    }
    if (series > 1) {
        fputs("<h3>Comparison of the series</h3>\n", out);
        draw_profiles(
            out, last, series, "cumulative displacement",
            "cumulative displacement against station, of each series",
            "Sum of the displacements in each series. Compare fig. 5.2 of the 1973 report.", si);
    }
    for (size_t i = 0; i < report->landings; i++)
        make_displacement_profile(&report->facts[i], NULL, true, &profile[i]);
    fputs("<h3>Peak movement</h3>\n", out);
    draw_profiles(out, profile, report->landings, "peak movement",
                  "peak movement against station, one line per landing",
                  "Largest movement during each landing, plotted over the station.", si);
    free(profile);
    free(last);
}

/* ---- two landings on one axis: the page takes the curves from the figures of the landings ---- */

static void write_landing_overlay(const struct report *report, FILE *out)
{
    struct figure figure = figure_begin(out, report->si, "two landings in one plot", 2,
                                        FIGURE_RANGE_PER_PLOT);
    figure_end(&figure, NULL,
               "Speed against time since touchdown, and displacement against gear position.");
}

/* ---- zones of all landings ---- */

#define ZONE_ROWS_PER_PLOT 20u /* landings per plot */

struct zone_rows {
    const struct report_facts *facts;
    size_t count;
    struct figure *figure;
};

/* Returns the name of row i of a plot; the first landing is at the top. */
static const char *get_zone_row_name(void *context, size_t i)
{
    static char name[30];
    const struct zone_rows *rows = context;
    snprintf(name, sizeof name, "RUN %lld", (long long)rows->facts[rows->count - 1 - i].landing.id);
    return name;
}

/* Draws a bar in one third of a row. */
static void draw_bar(const struct zone_rows *rows, double top, unsigned third, const char *kind,
                     double from_ft, double to_ft)
{
    double y = top - 0.12 - 0.26 * third;
    figure_add_shape(rows->figure, kind, from_ft, to_ft, y - 0.23, y, NULL);
}

static void draw_zone_row(const struct zone_rows *rows, size_t row, const struct report *report)
{
    const struct report_facts *facts = &rows->facts[row];
    const double top = (double)(rows->count - row);
    struct store_observation *seen = NULL;
    size_t count = 0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        if (facts->closed_segments & 1ull << s)
            draw_bar(rows, top, 1, "closed", (double)MR_SEGMENT_LENGTH_FT * s,
                     (double)MR_SEGMENT_LENGTH_FT * (s + 1));
    }
    if (facts->warning.has_warning)
        draw_bar(rows, top, 0, "warned", facts->longest_warned_zone.start_ft,
                 facts->longest_warned_zone.end_ft);
    else if (facts->longest_zone.mats > 0)
        draw_bar(rows, top, 0, "reported", facts->longest_zone.start_ft,
                 facts->longest_zone.end_ft);
    if (facts->last_zone.mats > 0)
        draw_bar(rows, top, 2, "behind", facts->last_zone.start_ft, facts->last_zone.end_ft);
    if (facts->has_motion_fit)
        figure_add_shape(rows->figure, "stop", facts->stop_ft.value, facts->stop_ft.value,
                         top - 0.95, top - 0.05, NULL);
    store_observations_get(report->store, facts->landing.id, &seen, &count, report->error);
    for (size_t i = 0; i < count; i++) {
        char panels[30] = "";
        if (seen[i].withdrawn || isnan(seen[i].station_ft))
            continue;
        if (seen[i].panels != STORE_NONE)
            snprintf(panels, sizeof panels, "%lld", (long long)seen[i].panels);
        double x = seen[i].station_ft;
        figure_add_shape(rows->figure, "seen", x, x, top - 0.5, top - 0.5, panels);
    }
    free(seen);
}

static void write_zone_maps(const struct report *report, FILE *out)
{
    static const char *const keys[] = {"warned",   "zone warned of",
                                       "reported", "longest reported zone, without a warning",
                                       "closed",   "mats measured as closed at the end",
                                       "behind",   "last zone reported",
                                       "stop",     "stop of the wheel",
                                       "seen",     "panels with an observed wave or break",
                                       NULL};
    for (size_t first = 0; first < report->landings; first += ZONE_ROWS_PER_PLOT) {
        size_t left = report->landings - first;
        struct figure figure = figure_begin(
            out, report->si, "zones of each landing against station", 1, FIGURE_RANGE_PER_PLOT);
        struct zone_rows rows = {&report->facts[first],
                                 left < ZONE_ROWS_PER_PLOT ? left : ZONE_ROWS_PER_PLOT, &figure};
        figure_begin_plot(&figure, &(struct chart_axes){.x = "station",
                                                        .x_unit = UNIT_STATION,
                                                        .y_unit = UNIT_NUMBER,
                                                        .x_high = RIG_RUNWAY_FT,
                                                        .y_high = (double)rows.count,
                                                        .height_px = 40 + 34 * (unsigned)rows.count,
                                                        .tick_name = get_zone_row_name,
                                                        .context = &rows,
                                                        .tick_count = rows.count});
        for (size_t i = 0; i < rows.count; i++)
            draw_zone_row(&rows, i, report);
        figure_end(&figure, keys, "%s",
                   left > ZONE_ROWS_PER_PLOT
                       ? ""
                       : "Reported: by the board's predictor. Measured: from survey and "
                         "transducers; no bar: the joints were open or not surveyed.");
    }
}

/* ---- band tension against deceleration (fig. 5.3 of the 1973 report) ---- */

static unsigned find_band_count(const struct report *report)
{
    unsigned bands = 0;
    for (size_t i = 0; i < report->landings; i++) {
        for (unsigned b = 0; report->facts[i].has_motion_fit && b < REPORT_BANDS_MAX; b++)
            bands = report->facts[i].band[b].gage_count && b + 1 > bands ? b + 1 : bands;
    }
    return bands;
}

static void draw_band_tension(const struct report *report, unsigned bands, FILE *out)
{
    const size_t most = report->landings + 1;
    double *x = xmalloc(3 * most * sizeof *x), *y = x + most, *half = y + most;
    char name[20];
    struct figure figure = figure_begin(out, report->si,
                                        "average change of band tension against deceleration", 1,
                                        FIGURE_RANGE_WITH_ZERO);
    figure_begin_plot(&figure, &(struct chart_axes){.x = "mean deceleration",
                                                    .x_unit = UNIT_DECELERATION,
                                                    .y = "average change",
                                                    .y_unit = UNIT_TENSION,
                                                    .height_px = 240});
    figure_add_shape(&figure, "mark", unknown_value, unknown_value, 0.0, 0.0, NULL);
    for (unsigned b = 0; b < bands; b++) {
        snprintf(name, sizeof name, "band %u", b + 1);
        for (int rose = 0; rose < 2; rose++) {
            size_t count = 0;
            for (size_t i = 0; i < report->landings; i++) {
                const struct report_facts *facts = &report->facts[i];
                if (!facts->has_motion_fit || facts->band[b].gage_count == 0)
                    continue;
                x[count] = facts->deceleration_ft_s2.value;
                half[count] = SUMMARY_HALF_WIDTH_95 * (rose ? facts->band[b].tension_rise_error_lb
                                                            : facts->band[b].tension_fall_error_lb);
                y[count++] = rose ? facts->band[b].rise_lb : facts->band[b].fall_lb;
            }
            figure_add_series(&figure, &(struct chart_series){name, b, "apart", x, y, half, count});
        }
    }
    figure_end(
        &figure, NULL,
        "Change of tension after the first switch, mean over the gages of a band, with 95 %% "
        "intervals: largest fall (below 0) and largest rise (above 0). Marks of different bands "
        "are shifted sideways. Compare fig. 5.3 of the 1973 report.");
    free(x);
}

static void add_tension_row(const struct report_facts *facts, struct answer *answer)
{
    if (!facts->has_motion_fit)
        return;
    answer_open_row(answer);
    answer_add_count(answer, NULL, "RUN", facts->landing.id)->is_run_number = true;
    answer_add_estimate(answer, NULL, "mean deceleration", UNIT_DECELERATION,
                        facts->deceleration_ft_s2.value, facts->deceleration_ft_s2.error, 3);
    for (unsigned b = 0; b < REPORT_BANDS_MAX; b++) {
        char head[CHART_LABEL_SIZE];
        if (facts->band[b].gage_count == 0)
            continue;
        snprintf(head, sizeof head, "band %u: largest fall", b + 1);
        answer_add_estimate(answer, NULL, head, UNIT_TENSION, facts->band[b].fall_lb,
                            facts->band[b].tension_fall_error_lb, 2);
        snprintf(head, sizeof head, "band %u: largest rise", b + 1);
        answer_add_estimate(answer, NULL, head, UNIT_TENSION, facts->band[b].rise_lb,
                            facts->band[b].tension_rise_error_lb, 2);
    }
}

static void write_band_tension(const struct report *report, FILE *out)
{
    unsigned bands = find_band_count(report);
    if (bands == 0)
        return;
    draw_band_tension(report, bands, out);
    write_landings_table(report, out, "\xc2\xb1 is one standard error.", add_tension_row);
}

/* ---- measured against simulated: the newest comparison of each landing ---- */

static void add_overlap(struct answer *answer, const char *label,
                        const struct compare_overlap *overlap)
{
    if (!overlap->is_known)
        answer_add_text(answer, NULL, label, "\xe2\x80\x93");
    else if (overlap->all_mats > 0.0)
        answer_add_text(answer, NULL, label, "%.0f of %.0f", overlap->common_mats,
                        overlap->all_mats);
    else
        answer_add_text(answer, NULL, label, "both none");
}

static void add_comparison_row(const struct report_facts *facts, struct answer *answer)
{
    const struct report_comparison *compared = &facts->comparison;
    const struct compare_channel_means *mean = &compared->mean;
    answer_open_row(answer);
    answer_add_count(answer, NULL, "RUN", facts->landing.id)->is_run_number = true;
    answer_add_text(answer, NULL, "simulation", "%s", compared->compared_with);
    answer_add_text(answer, NULL, "channels", "%zu of %zu", mean->channel_count,
                    compared->channel_count);
    answer_add_value(answer, NULL, "mean difference", UNIT_DISPLACEMENT, mean->bias_in, 4);
    answer_add_value(answer, NULL, "RMS difference", UNIT_DISPLACEMENT, mean->rms_in, 4);
    answer_add_value(answer, NULL, "worst channel, RMS", UNIT_DISPLACEMENT, mean->worst_rms_in, 4);
    answer_add_value(answer, NULL, "largest En of a peak", UNIT_NUMBER, mean->worst_peak_en_score,
                     1)
        ->is_capped = true;
    add_overlap(answer, "longest zone (mats)", &compared->at_longest_zone);
    add_overlap(answer, "longest zone by the board (mats)", &compared->board_at_longest_zone);
    add_overlap(answer, "zone at rest (mats)", &compared->at_rest);
    answer_add_value(answer, NULL, "simulation error", UNIT_DISPLACEMENT, compared->solver_error_in,
                     4);
}

static void write_comparisons(const struct report *report, FILE *out)
{
    double samples = 0.0, sum = 0.0, squares = 0.0;
    size_t rows = 0;
    struct answer *answer = answer_new(report->si);
    answer_open_table(answer, NULL, "");
    for (size_t i = 0; i < report->landings; i++) {
        const struct compare_channel_means *mean = &report->facts[i].comparison.mean;
        if (mean->channel_count == 0)
            continue;
        rows++;
        add_comparison_row(&report->facts[i], answer);
        samples += mean->sample_count;
        sum += mean->sample_count * mean->bias_in;
        squares += mean->sample_count * mean->rms_in * mean->rms_in;
    }
    if (rows > 1) { /* add a row for all landings, weighted by their numbers of samples */
        answer_open_row(answer);
        answer_add_text(answer, NULL, "RUN", "all");
        answer_add_value(answer, NULL, "mean difference", UNIT_DISPLACEMENT, sum / samples, 4);
        answer_add_value(answer, NULL, "RMS difference", UNIT_DISPLACEMENT, sqrt(squares / samples),
                         4);
    }
    answer_close_group(answer);
    if (rows)
        answer_add_sentence(
            answer, NULL,
            "Newest comparison of each landing. Differences are measured minus simulated, over all "
            "samples of all channels. En: difference divided by its expanded (95 %%) uncertainty; "
            "up to 1 means agreement. Zones: \"3 of 5\" means that 3 mats are closed in both "
            "measurement and simulation, and 5 in at least one of them. Simulation error: the "
            "solver's own estimate, one standard error.");
    report_write_answer(answer, out);
}

/* ---- predictions and outcomes ---- */

static void add_predictor_row(const struct report_facts *facts, struct answer *answer)
{
    const struct zone_warning *w = &facts->warning;
    int64_t worst = facts->worst_predictor_verdict;
    const bool watched = facts->source != MEASURED_IMPORT;
    struct report_zone first = {0, unknown_value, unknown_value, unknown_value, unknown_value};
    if (w->has_warning)
        first = (struct report_zone){w->mats, w->start_ft, w->end_ft, w->start_error_ft,
                                     w->end_error_ft};
    answer_open_row(answer);
    answer_add_count(answer, NULL, "RUN", facts->landing.id)->is_run_number = true;
    answer_add_count(answer, NULL, "zone reports", (int64_t)facts->zone_report_count);
    answer_add_text(
        answer, NULL, "highest level", "%s%s",
        w->has_warning        ? "warning"
        : !watched            ? "no board"
        : worst == STORE_NONE ? "no warning"
                              : mr_predictor_verdict_text((unsigned)worst),
        !w->has_warning && watched && facts->may_have_missed_warning ? ", as far as received" : "")
        ->is_warning = w->has_warning;
    answer_add_value(answer, NULL, "first warning", UNIT_TIME,
                     w->has_warning ? w->t_s : unknown_value, 3);
    answer_add_text(answer, NULL, "reason", "%s",
                    w->has_warning && w->reason != STORE_NONE
                        ? mr_predictor_reason_text((unsigned)w->reason)
                        : "");
    add_zone_ends(answer, "first zone", &first);
    answer_add_count(answer, NULL, "zone warned of (mats)",
                     w->has_warning ? w->longest_mats : ANSWER_COUNT_UNKNOWN);
    add_zone_ends(answer, "last zone", &facts->last_zone);
}

static void write_predictor(const struct report *report, FILE *out)
{
    size_t statements = 0;
    for (size_t i = 0; i < report->landings; i++)
        statements += report->facts[i].zone_report_count;
    if (statements)
        write_landings_table(
            report, out,
            "First warning: seconds after touchdown on the board's clock, exact to 1 ms. First "
            "zone: the zone of any length that the board reported with its first warning; the "
            "reason for the warning may be a zone that the model expects later. For the lead time "
            "to 50 closed mats, see Warnings and their outcome. A landing without a warning is not "
            "necessarily safe.",
            add_predictor_row);
}

/* Adds a row with advice, warnings and outcome of a landing. */
static void add_record_row(const struct outcome_record_row *row, struct answer *answer)
{
    static const char *const warned[] = {[WARNING_NO_BOARD] = "no board",
                                         [WARNING_SENT] = "yes",
                                         [WARNING_NOT_SENT] = "none",
                                         [WARNING_NOT_RECEIVED] = "not known"};
    static const char *const came[] = {"not known", "yes", "no"};
    const struct outcome *outcome = &row->outcome;
    char advice[OUTCOME_ADVICE_SIZE], lead[OUTCOME_LEAD_TIME_SIZE];
    answer_open_row(answer);
    answer_add_count(answer, NULL, "RUN", row->run)->is_run_number = !row->is_void;
    answer_add_text(answer, NULL, "outcome", "%s", warning_outcome_text(row->warning_outcome));
    answer_add_text(answer, NULL, "advice", "%s", outcome_record_format_advice(row, advice));
    answer_add_value(answer, NULL, "zone probability (%)", UNIT_NUMBER,
                     row->has_advice ? 100.0 * row->advice.zone : unknown_value, 0);
    answer_add_text(answer, NULL, "warning", "%s", warned[row->warning_status])->is_warning =
        row->warning_status == WARNING_SENT;
    answer_add_value(answer, NULL, "warning at", UNIT_TIME, row->warned_t_s, 3);
    answer_add_value(answer, NULL, "highest risk", UNIT_NUMBER, row->max_risk, 2);
    answer_add_text(answer, NULL, "zone reached", "%s",
                    row->is_void ? "void" : came[outcome->reached]);
    answer_add_count(answer, NULL, "measured zone (mats)", outcome->longest_mats);
    answer_add_value(answer, NULL, "50 mats reached at about", UNIT_TIME, outcome->reached_t_s, 1);
    answer_add_count(answer, NULL, "closed mats after", outcome->closed_after_mats);
    answer_add_count(answer, NULL, "waves observed", (int64_t)outcome->wave_count);
    answer_add_count(answer, NULL, "breaks observed", (int64_t)outcome->break_count);
    answer_add_text(answer, NULL, "lead time, about (s)", "%s",
                    outcome_record_format_lead_time(row, true, lead))
        ->is_number = true;
    answer_add_text(answer, NULL, "evidence", "%s",
                    row->warning_outcome == WARNING_OUTCOME_UNKNOWN
                        ? row->unknown_reason
                        : outcome_basis_text(outcome->basis));
}

static void write_warnings(const struct report *report, FILE *out)
{
    const struct outcome_record *record = &report->record;
    if (report->run || record->landing_count == 0)
        return;
    struct answer *answer = answer_new(report->si);
    outcome_record_to_answer(record, false, answer);
    answer_open_table(answer, NULL, "");
    for (size_t i = 0; i < record->row_count; i++)
        add_record_row(&record->row[i], answer);
    answer_close_group(answer);
    answer_add_sentence(
        answer, NULL,
        "Zone reached: the wheel reached at least 50 closed mats before it stopped, as shown by "
        "survey and transducers or by an observation, never by the predictor. Hit: the board "
        "warned before the wheel reached the zone; too late: it warned later; missed: a zone "
        "without a warning; false: a warning without a zone; correctly quiet: neither. Measured "
        "zone: the longest one that the wheel reached. Closed mats after: closed mats at the wheel "
        "in the survey after the landing. Times count from touchdown. Lead time: time from the "
        "first "
        "warning until the wheel reached 50 closed mats, negative if the warning was later; in "
        "brackets: 75 %% interval. A measured zone has a standard error of ten mats, so an outcome "
        "is uncertain if the zone has 40 to 60 mats.");
    report_write_answer(answer, out);
}

/* ---- advice ---- */

/* Returns the first landing after an advice, to which the advice applies. NULL: it has not taken
 * place yet, or is not in this report. */
static const struct report_facts *find_next_landing(const struct report *report,
                                                    const struct store_advice *advice)
{
    for (size_t i = 0; i < report->landings; i++) {
        if (report->facts[i].landing.id > advice->after_run)
            return &report->facts[i];
    }
    return NULL;
}

/* Adds a row for an advice. `facts`: its landing; NULL: none yet. */
static void add_advice_row(const struct store_advice *advice, const struct report_facts *facts,
                           size_t number, const char *reason, struct answer *answer)
{
    answer_open_row(answer);
    answer_add_count(answer, NULL, "advice", (int64_t)number);
    answer_add_text(answer, NULL, "recommendation", "%s", advice->verdict)->is_warning =
        strcmp(advice->verdict, "against") == 0;
    answer_add_value(answer, NULL, "planned speed", UNIT_SPEED, advice->speed_ft_s, 1);
    answer_add_value(answer, NULL, "planned braking", UNIT_DECELERATION, advice->deceleration_ft_s2,
                     2);
    answer_add_value(answer, NULL, "zone probability (%)", UNIT_NUMBER, 100.0 * advice->zone, 0);
    answer_add_text(answer, NULL, "95 % interval (%)", "%.0f to %.0f", 100.0 * advice->zone_low,
                    100.0 * advice->zone_high);
    answer_add_value(answer, NULL, "limit (%)", UNIT_NUMBER, 100.0 * advice->most, 0);
    answer_add_value(answer, NULL, "hardest braking allowed", UNIT_DECELERATION,
                     advice->hardest_ft_s2, 1);
    answer_add_count(answer, NULL, "RUN", facts ? facts->landing.id : ANSWER_COUNT_UNKNOWN);
    answer_add_value(answer, NULL, "speed", UNIT_SPEED,
                     facts ? facts->speed_ft_s.value : unknown_value, 1);
    answer_add_value(answer, NULL, "braking", UNIT_DECELERATION,
                     facts ? facts->deceleration_ft_s2.value : unknown_value, 2);
    answer_add_text(answer, NULL, "followed", "%s",
                    !facts || facts->warning_record.advice.id != advice->id ? "\xe2\x80\x93"
                    : facts->warning_record.followed_advice_against         ? "yes"
                    : facts->warning_record.is_off_plan                     ? "plan not followed"
                    : strcmp(advice->verdict, "against") == 0               ? "no"
                                                                            : "\xe2\x80\x93");
    answer_add_text(answer, NULL, "warning in the landing", "%s",
                    !facts ? "no landing yet"
                    : facts->warning.has_warning
                        ? warning_outcome_text(facts->warning_record.warning_outcome)
                        : "none");
    answer_add_text(answer, NULL, "reason", "%s", reason);
}

/* Adds a row for each landing that began on the runway of the advice. */
static void add_advice_rows(const struct report *report, const struct store_advice *advice,
                            size_t number, struct answer *answer)
{
    const struct report_facts *first = find_next_landing(report, advice);
    add_advice_row(advice, first, number, advice->reason, answer);
    for (size_t i = 0; first && i < report->landings; i++) {
        const struct report_facts *facts = &report->facts[i];
        if (facts != first && facts->warning_record.has_advice &&
            facts->warning_record.advice.id == advice->id)
            add_advice_row(advice, facts, number, "as above", answer);
    }
}

static void write_advice(const struct report *report, FILE *out)
{
    struct store_advice *advice = NULL;
    size_t count = 0;
    struct answer *answer = answer_new(report->si);
    store_advices_get(report->store, &advice, &count, report->error);
    answer_open_table(answer, NULL, "");
    for (size_t i = 0; i < count; i++)
        add_advice_rows(report, &advice[i], i + 1, answer);
    answer_close_group(answer);
    if (count)
        answer_add_sentence(
            answer, NULL,
            "Recommendations of matrig advise. Each is shown with the next landing and with later "
            "landings on the same, restored runway. \"Followed: yes\": the advice was "
            "against the plan, and the landing braked no harder than advised. Zone probability: "
            "probability of a zone of 50 closed mats, with its sampling interval. At or above the "
            "limit, matrig advises against a landing.");
    report_write_answer(answer, out);
    free(advice);
}

/* ---- observations and notes ---- */

static void add_journal_row(const struct store_landing *landing, const struct journal *journal,
                            bool recalibrated, struct answer *answer)
{
    const struct store_series *series = &journal->series;
    if (!series->name[0] && !series->pattern[0] && !series->runway[0] && !series->modification[0] &&
        !journal->is_void && !recalibrated)
        return;
    answer_open_row(answer);
    answer_add_count(answer, NULL, "RUN", landing->id);
    answer_add_count(answer, NULL, "landing", landing->board_landing);
    answer_add_text(answer, NULL, "series", "%s", series->name);
    answer_add_text(answer, NULL, "runway", "%s", series->runway);
    answer_add_text(answer, NULL, "pattern", "%s", series->pattern);
    answer_add_text(answer, NULL, "modification", "%s", series->modification);
    if (journal->is_void)
        answer_add_text(answer, NULL, "valid", "void: %s", journal->void_reason)->is_warning = true;
    else
        answer_add_text(answer, NULL, "valid", recalibrated ? "yes, recalibrated" : "yes");
}

static void write_journal(const struct report *report, FILE *out)
{
    struct store_landing *landing = NULL;
    size_t count = 0;
    struct answer *tables[3];
    static const char *const titles[] = {"Series and validity", "Waves and breaks",
                                         "Notes and corrections"};
    for (size_t t = 0; t < 3; t++) {
        tables[t] = answer_new(report->si);
        answer_open_table(tables[t], NULL, titles[t]);
    }
    store_landings_get(report->store, &landing, &count, report->error);
    for (size_t i = 0; i < count && report->error->status == MR_OK; i++) {
        struct journal said;
        int64_t recalibrated = 0;
        if (report->run && landing[i].id != report->run)
            continue;
        journal_load(report->store, &landing[i], &said, report->error);
        store_recalibrated_channels_get(report->store, landing[i].id, &recalibrated, report->error);
        add_journal_row(&landing[i], &said, recalibrated != 0, tables[0]);
        for (size_t k = 0; k < said.observation_count; k++) {
            if (said.observation[k].withdrawn)
                continue;
            answer_open_row(tables[1]);
            answer_add_count(tables[1], NULL, "RUN", landing[i].id);
            journal_add_observation(&said.observation[k], tables[1]);
        }
        for (size_t k = 0; k < said.change_count; k++) {
            answer_open_row(tables[2]);
            answer_add_count(tables[2], NULL, "RUN", landing[i].id);
            journal_add_change(&said.change[k], tables[2]);
        }
        journal_free(&said);
    }
    for (size_t t = 0; t < 3; t++) {
        answer_close_group(tables[t]);
        report_write_answer(tables[t], out);
    }
    free(landing);
}

/* ---- the slow log ---- */

#define HOUR_US 3600e6

/* Selects the rows of the first board, and computes their times in hours. Returns their number. */
static size_t select_board_rows(const struct store_slow *rows, size_t count, double *hours)
{
    size_t n = 0;
    while (n < count && strcmp(rows[n].board_uid, rows[0].board_uid) == 0) {
        hours[n] = (double)(rows[n].time_us - rows[0].time_us) / HOUR_US;
        n++;
    }
    return n;
}

static double compute_mean_tension_lb(const struct store_slow *row)
{
    double sum = 0.0;
    unsigned count = 0;
    for (unsigned i = 0; i < MR_GAGES; i++) {
        if (isnan(row->tension_lb[i]))
            continue;
        sum += row->tension_lb[i];
        count++;
    }
    return count ? sum / count : unknown_value;
}

static void draw_slow_readings(FILE *out, const struct store_slow *rows, const double *hours,
                               double *values, size_t count, bool si)
{
    struct figure figure = figure_begin(out, si, "tension and temperature against time", 1,
                                        FIGURE_RANGE_PER_PLOT);
    struct chart_axes axes = {.x_unit = UNIT_NUMBER, .x_high = hours[count - 1], .height_px = 130};
    for (int warm = 0; warm < 2; warm++) {
        axes.y = warm ? "temperature (\xc2\xb0"
                        "C)"
                      : "mean tension";
        axes.y_unit = warm ? UNIT_NUMBER : UNIT_TENSION;
        axes.x = warm ? "time since the first row (h)" : NULL;
        figure_begin_plot(&figure, &axes);
        for (size_t i = 0; i < count; i++)
            values[i] = warm ? rows[i].temperature_c : compute_mean_tension_lb(&rows[i]);
        figure_add_series(&figure,
                          &(struct chart_series){NULL, 0, "line", hours, values, NULL, count});
    }
    figure_end(&figure, NULL,
               "One row per minute between the landings: mean gage tension and mat temperature.");
}

static void write_slow_readings(const struct report *report, FILE *out)
{
    double *hours = xcalloc(2 * (report->slow_count + 1), sizeof *hours);
    size_t n = select_board_rows(report->slow_reading, report->slow_count, hours);
    if (n >= 2 && hours[n - 1] > 0.0)
        draw_slow_readings(out, report->slow_reading, hours, hours + report->slow_count + 1, n,
                           report->si);
    free(hours);
}

/* ---- the sections, in the order of the page ---- */

const struct report_section report_sections[] = {
    {"summary", "Summary", write_summary, 1},
    {"cumulative", "Cumulative displacement", write_cumulative_displacement, 2},
    {"zones", "Zone map of all landings", write_zone_maps, 2},
    {"overlay", "Two landings compared", write_landing_overlay, 2},
    {"tension", "Band tension against deceleration", write_band_tension, 2},
    {"advice", "Advice before the landings", write_advice, 0},
    {"record", "Warnings and their outcome", write_warnings, 0},
    {"predictor", "Predictions", write_predictor, 2},
    {"compared", "Measured against simulated", write_comparisons, 2},
    {"slow", "Tension and temperature between landings", write_slow_readings, 0},
    {"journal", "Observations and notes", write_journal, 0},
    {"records", "Acceptance and damage", report_write_records, 0},
    {"survey", "Surveys of the mat", report_write_surveys, 0},
    {NULL, NULL, NULL, 0},
};
