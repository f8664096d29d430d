/* Section of the report about surveys of the mat. */
#include <math.h>
#include <stdlib.h>

#include "host/analyse/rig.h"
#include "host/base/answer.h"
#include "host/base/xmalloc.h"
#include "host/report/chart.h"
#include "host/report/report.h"
#include "host/survey/survey.h"

#define PLOTTED_SURVEYS_MAX 6u /* number of newest surveys that are drawn */

static const double unknown_value = (double)NAN;

static struct chart_axes make_survey_axes(double x[SURVEY_POINTS])
{
    for (unsigned k = 0; k < SURVEY_POINTS; k++)
        x[k] = SURVEY_SPAN_LENGTH_FT * k;
    return (struct chart_axes){.x_unit = UNIT_STATION,
                               .y_unit = UNIT_DISPLACEMENT,
                               .x_high = RIG_RUNWAY_FT,
                               .height_px = 150};
}

/* Draws the opening of the joints, or the movement of the mats, along each gage line. */
static void draw_gage_lines(struct figure *figure, const struct survey_results *found, bool moved)
{
    double x[SURVEY_POINTS], y[SURVEY_POINTS];
    struct chart_axes axes = make_survey_axes(x);
    size_t count = moved ? SURVEY_POINTS : SURVEY_SPANS;
    axes.y = moved ? "moved" : "opened";
    figure_begin_plot(figure, &axes);
    for (unsigned k = 0; k < SURVEY_SPANS && !moved; k++)
        x[k] = 0.5 * (x[k] + x[k + 1]);
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        for (size_t k = 0; k < count; k++)
            y[k] = moved ? found->since_previous.movement[line][k].value_in
                         : found->since_previous.change.gap_in[line][k];
        figure_add_series(figure, &(struct chart_series){survey_describe_line(line + 1), line,
                                                         "marks", x, y, NULL, count});
    }
}

static double compute_mean_movement_in(const struct survey_change *change, unsigned point)
{
    double sum_in = 0.0;
    for (unsigned line = 0; line < SURVEY_LINES; line++)
        sum_in += change->movement[line][point].value_in;
    return sum_in / SURVEY_LINES;
}

/* Change of the mat since the first survey. */
struct survey_change_since_first {
    int64_t survey_id;
    double moved_in[SURVEY_POINTS]; /* mean of the lines */
    double bow_in[SURVEY_POINTS];
};

/* Loads the newest surveys, in descending order of time; returns their number. */
static unsigned load_changes_since_first(
    const struct report *report, const struct store_gage_survey *rows, size_t count,
    struct survey_change_since_first since[PLOTTED_SURVEYS_MAX])
{
    unsigned loaded = 0;
    struct survey *survey = xmalloc(sizeof *survey);
    struct survey_results *found = xmalloc(sizeof *found);
    for (size_t i = count; i-- > 0 && loaded < PLOTTED_SURVEYS_MAX;) {
        if (survey_load(report->store, rows[i].id, survey, report->error) != MR_OK ||
            survey_evaluate(report->store, survey, found, report->error) != MR_OK)
            break;
        if (!found->first_survey)
            continue;
        since[loaded].survey_id = rows[i].id;
        for (unsigned k = 0; k < SURVEY_POINTS; k++) {
            since[loaded].moved_in[k] = compute_mean_movement_in(&found->since_first, k);
            since[loaded].bow_in[k] = found->since_first.bow[k].value_in;
        }
        loaded++;
    }
    free(survey);
    free(found);
    return loaded;
}

/* Draws the movement, or the in-plane bow with its limits. */
static void draw_changes_since_first(struct figure *figure,
                                     const struct survey_change_since_first *since, unsigned count,
                                     bool bow)
{
    const double limit = SURVEY_BOW_LIMIT_IN;
    double x[SURVEY_POINTS];
    struct chart_axes axes = make_survey_axes(x);
    axes.x = bow ? "station" : NULL;
    axes.y = bow ? "bow" : "total movement";
    figure_begin_plot(figure, &axes);
    if (bow) {
        figure_add_shape(figure, "mark", unknown_value, unknown_value, limit, limit, NULL);
        figure_add_shape(figure, "mark", unknown_value, unknown_value, -limit, -limit, NULL);
    }
    for (unsigned i = 0; i < count; i++) {
        char name[40];
        snprintf(name, sizeof name, "survey %lld", (long long)since[i].survey_id);
        figure_add_series(figure, &(struct chart_series){name, i, "marks", x,
                                                         bow ? since[i].bow_in : since[i].moved_in,
                                                         NULL, SURVEY_POINTS});
    }
}

static void write_surveys_table(FILE *out, const struct store_gage_survey *rows, size_t count)
{
    struct answer *answer = answer_new(false);
    answer_open_table(answer, NULL, "");
    for (size_t i = 0; i < count; i++) {
        char when[40];
        survey_format_time(rows[i].made_us, when, sizeof when);
        answer_open_row(answer);
        answer_add_text(answer, NULL, "survey", "%lld%s", (long long)rows[i].id,
                        rows[i].ended_us == STORE_NONE ? ", in progress" : "");
        answer_add_text(answer, NULL, "started", "%s", when);
        answer_add_count(answer, NULL, "after RUN", rows[i].after_run);
        answer_add_text(answer, NULL, "by", "%s", rows[i].who);
        answer_add_text(answer, NULL, "note", "%s", rows[i].note);
    }
    answer_close_group(answer);
    report_write_answer(answer, out);
}

static void write_survey_text(FILE *out, const struct survey *survey,
                              const struct survey_results *found, bool si)
{
    const struct unit *length = unit_get(UNIT_DISPLACEMENT, si),
                      *station = unit_get(UNIT_STATION, si);
    fprintf(out,
            "<p class=\"say\">Survey %lld: %zu of %zu gage points read, %zu confirmed; opening "
            "known for %zu of %u segments.",
            (long long)survey->row.id, survey_progress_count_read(&survey->progress),
            survey->progress.plan.count, survey->confirmed_readings,
            found->slack.surveyed_segment_count, SURVEY_SPANS);
    if (!isnan(found->worst_bow_in))
        fprintf(out,
                " Largest in-plane bow since survey %lld: <span class=\"%s\">%.3f &plusmn; %.3f "
                "%s</span> at %.1f %s, %s the limit of %.3f %s.",
                (long long)found->first_survey,
                fabs(found->worst_bow_in) > SURVEY_BOW_LIMIT_IN ? "warn" : "say",
                found->worst_bow_in * length->factor, found->worst_bow_error_in * length->factor,
                length->text, found->worst_bow_station_ft * station->factor, station->text,
                survey_describe_bow(found), SURVEY_BOW_LIMIT_IN * length->factor, length->text);
    fputs("</p>\n", out);
}

void report_write_surveys(const struct report *report, FILE *out)
{
    struct store_gage_survey *rows = NULL;
    struct survey *survey = xmalloc(sizeof *survey);
    struct survey_results *found = xmalloc(sizeof *found);
    size_t count = 0;
    bool any = store_gage_surveys_get(report->store, &rows, &count, report->error) == MR_OK &&
               count && survey_load(report->store, 0, survey, report->error) == MR_OK &&
               survey_evaluate(report->store, survey, found, report->error) == MR_OK;
    if (any) {
        write_surveys_table(out, rows, count);
        write_survey_text(out, survey, found, report->si);
    }
    if (any && found->previous_survey) {
        struct figure figure = figure_begin(
            out, report->si, "opening of joints, movement and in-plane bow against station", 1,
            FIGURE_RANGE_PER_PLOT);
        draw_gage_lines(&figure, found, false);
        draw_gage_lines(&figure, found, true);
        struct survey_change_since_first since[PLOTTED_SURVEYS_MAX];
        unsigned loaded = load_changes_since_first(report, rows, count, since);
        draw_changes_since_first(&figure, since, loaded, false);
        draw_changes_since_first(&figure, since, loaded, true);
        figure_end(&figure, NULL,
                   "The first two plots show the change from survey %lld to survey %lld on each "
                   "gage line: length of ten mats, and movement downfield. The last two plots show "
                   "the change from survey %lld to the newest surveys: total movement (mean of the "
                   "lines), and in-plane bow (dotted: limits).",
                   (long long)found->previous_survey, (long long)survey->row.id,
                   (long long)found->first_survey);
    }
    free(rows);
    free(survey);
    free(found);
}
