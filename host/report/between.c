/* Sections of the campaign: measurements between the landings, by surveys and by the slow log. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
#include "host/report/chart.h"
#include "host/report/report.h"
#include "host/survey/survey.h"

static const double none = (double)NAN;

/* ---- surveys of the mat ---- */

#define SURVEYS_DRAWN 6u /* bows of the newest ones */

static struct chart_axes survey_axes(double x[SURVEY_POINTS], bool si)
{
    const double station = unit_of(UNIT_STATION, si)->factor;
    for (unsigned k = 0; k < SURVEY_POINTS; k++)
        x[k] = SURVEY_SPAN_FT * k * station;
    return (struct chart_axes){.x_high = CHART_RUNWAY_FT * station, .height_px = 150};
}

/* How far joints opened, or mats moved, along each gage line. */
static void draw_lines(struct figure *figure, const struct survey_found *found, bool moved, bool si)
{
    const double length = unit_of(UNIT_DISPLACEMENT, si)->factor;
    double x[SURVEY_POINTS], y[SURVEY_POINTS];
    struct chart_axes axes = survey_axes(x, si);
    char label[CHART_LABEL];
    size_t count = moved ? SURVEY_POINTS : SURVEY_SPANS;
    axes.y = chart_label(label, moved ? "moved" : "opened", UNIT_DISPLACEMENT, si);
    figure_plot(figure, &axes);
    for (unsigned k = 0; k < SURVEY_SPANS && !moved; k++)
        x[k] = 0.5 * (x[k] + x[k + 1]);
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        for (size_t k = 0; k < count; k++)
            y[k] = length * (moved ? found->since_previous.moved[line][k].value_in
                                   : found->since_previous.change.gap_in[line][k]);
        figure_series(figure, &(struct chart_series){survey_line_text(line + 1), line, "marks", x,
                                                     y, NULL, count});
    }
}

/* In-plane bow since the first survey, of the newest ones, between the limits. */
static enum mr_status draw_bows(struct figure *figure, struct store *store,
                                const struct store_gage_survey *rows, size_t count, bool si,
                                struct error *error)
{
    const double length = unit_of(UNIT_DISPLACEMENT, si)->factor,
                 limit = SURVEY_BOW_LIMIT_IN * length;
    double x[SURVEY_POINTS], y[SURVEY_POINTS];
    struct chart_axes axes = survey_axes(x, si);
    char labels[2][CHART_LABEL], name[40];
    unsigned drawn = 0;
    enum mr_status status = MR_OK;
    struct survey *survey = xmalloc(sizeof *survey);
    struct survey_found *found = xmalloc(sizeof *found);
    axes.x = chart_label(labels[0], "station", UNIT_STATION, si);
    axes.y = chart_label(labels[1], "bow", UNIT_DISPLACEMENT, si);
    figure_plot(figure, &axes);
    figure_shape(figure, "mark", none, none, limit, limit, NULL);
    figure_shape(figure, "mark", none, none, -limit, -limit, NULL);
    for (size_t i = count; i-- > 0 && drawn < SURVEYS_DRAWN && status == MR_OK;) {
        status = survey_get(store, rows[i].id, survey, error);
        if (status == MR_OK)
            status = survey_find(store, survey, found, error);
        if (status != MR_OK || !found->first)
            continue;
        for (unsigned k = 0; k < SURVEY_POINTS; k++)
            y[k] = found->since_first.bow[k].value_in * length;
        snprintf(name, sizeof name, "survey %lld", (long long)rows[i].id);
        figure_series(figure,
                      &(struct chart_series){name, drawn++, "marks", x, y, NULL, SURVEY_POINTS});
    }
    free(survey);
    free(found);
    return status;
}

static void surveys_table(FILE *out, const struct store_gage_survey *rows, size_t count)
{
    struct answer *answer = answer_new(false);
    answer_table(answer, NULL, "");
    for (size_t i = 0; i < count; i++) {
        char when[40];
        survey_time_text(rows[i].made_us, when, sizeof when);
        answer_row(answer);
        answer_words(answer, NULL, "survey", "%lld%s", (long long)rows[i].id,
                     rows[i].ended_us == STORE_NONE ? ", goes on" : "");
        answer_words(answer, NULL, "begun", "%s", when);
        answer_count(answer, NULL, "after RUN", rows[i].after_run);
        answer_words(answer, NULL, "by", "%s", rows[i].who);
        answer_words(answer, NULL, "note", "%s", rows[i].note);
    }
    answer_close(answer);
    report_answer(answer, out);
}

static void survey_words(FILE *out, const struct survey *survey, const struct survey_found *found,
                         bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si),
                      *station = unit_of(UNIT_STATION, si);
    fprintf(out,
            "<p class=\"say\">Survey %lld: %zu of %zu places read, %zu confirmed; %zu of %u "
            "segments have an opening.",
            (long long)survey->row.id, survey_desk_read(&survey->desk), survey->desk.plan.count,
            survey->confirmed, found->slack.surveyed, SURVEY_SPANS);
    if (!isnan(found->worst_bow_in))
        fprintf(out,
                " Largest in-plane bow since survey %lld: <span class=\"%s\">%.3f &plusmn; %.3f "
                "%s</span> at %.1f %s, %s the limit of %.3f %s.",
                (long long)found->first,
                fabs(found->worst_bow_in) > SURVEY_BOW_LIMIT_IN ? "warn" : "say",
                found->worst_bow_in * length->factor, found->worst_bow_error_in * length->factor,
                length->text, found->worst_bow_ft * station->factor, station->text,
                survey_bow_verdict(found), SURVEY_BOW_LIMIT_IN * length->factor, length->text);
    fputs("</p>\n", out);
}

enum mr_status report_surveys(const struct report *report, FILE *out, struct error *error)
{
    struct store_gage_survey *rows = NULL;
    struct survey *survey = xmalloc(sizeof *survey);
    struct survey_found *found = xmalloc(sizeof *found);
    size_t count = 0;
    enum mr_status status = store_gage_surveys(report->store, &rows, &count, error);
    if (status == MR_OK && count)
        status = survey_get(report->store, 0, survey, error);
    if (status == MR_OK && count)
        status = survey_find(report->store, survey, found, error);
    if (status == MR_OK && count) {
        surveys_table(out, rows, count);
        survey_words(out, survey, found, report->si);
    }
    if (status == MR_OK && count && found->previous) {
        struct figure figure = figure_begin(
            out, "opening of joints, movement and in-plane bow against station", 1, FIGURE_EACH);
        draw_lines(&figure, found, false, report->si);
        draw_lines(&figure, found, true, report->si);
        status = draw_bows(&figure, report->store, rows, count, report->si, error);
        figure_end(&figure, NULL,
                   "Survey %lld against %lld, by gage line: opening (+) and closing (-) of ten "
                   "mats; movement downfield; in-plane bow of the newest surveys since survey "
                   "%lld, between the limits (dotted).",
                   (long long)survey->row.id, (long long)found->previous, (long long)found->first);
    }
    free(rows);
    free(survey);
    free(found);
    return status;
}

/* ---- the slow log ---- */

#define HOUR_US 3600e6

/* The rows of the first board, with their hours. */
static size_t choose(const struct store_slow *rows, size_t count, double *hours)
{
    size_t n = 0;
    while (n < count && strcmp(rows[n].board_uid, rows[0].board_uid) == 0) {
        hours[n] = (double)(rows[n].time_us - rows[0].time_us) / HOUR_US;
        n++;
    }
    return n;
}

static double mean_tension(const struct store_slow *row)
{
    double sum = 0.0;
    unsigned count = 0;
    for (unsigned i = 0; i < MR_GAGES; i++) {
        if (isnan(row->tension_lb[i]))
            continue;
        sum += row->tension_lb[i];
        count++;
    }
    return count ? sum / count : none;
}

static void draw_slow(FILE *out, const struct store_slow *rows, const double *hours, double *values,
                      size_t count, bool si)
{
    const double force = unit_of(UNIT_TENSION, si)->factor;
    struct figure figure = figure_begin(out, "tension and temperature against time", 1,
                                        FIGURE_EACH);
    struct chart_axes axes = {.x_high = hours[count - 1], .height_px = 130};
    char label[CHART_LABEL];
    for (int warm = 0; warm < 2; warm++) {
        axes.y = warm ? "temperature, C" : chart_label(label, "mean tension", UNIT_TENSION, si);
        axes.x = warm ? "time since the first row, h" : NULL;
        figure_plot(&figure, &axes);
        for (size_t i = 0; i < count; i++)
            values[i] = warm ? rows[i].temperature_c : force * mean_tension(&rows[i]);
        figure_series(&figure, &(struct chart_series){NULL, 0, "line", hours, values, NULL, count});
    }
    figure_end(&figure, NULL,
               "The slow log, a row a minute: mean of the gages, temperature of the mat.");
}

enum mr_status report_slow(const struct report *report, FILE *out, struct error *error)
{
    double *hours = xcalloc(2 * (report->slow_rows + 1), sizeof *hours);
    (void)error;
    size_t n = choose(report->slow, report->slow_rows, hours);
    if (n >= 2 && hours[n - 1] > 0.0)
        draw_slow(out, report->slow, hours, hours + report->slow_rows + 1, n, report->si);
    free(hours);
    return MR_OK;
}
