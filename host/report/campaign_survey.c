/* Surveys: opening and closing per ten mats, movement and in-plane bow against station. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/report/chart.h"
#include "host/base/html.h"
#include "host/report/report.h"
#include "host/survey/show.h"
#include "host/base/units.h"

#define HEIGHT        150.0
#define STEP          (HEIGHT + 16.0)
#define TOP           26.0
#define SURVEYS_DRAWN 6u /* bows of the newest ones */

struct panel {
    struct svg_plot plot;
    double x[SURVEY_POINTS];
};

static void axes(struct panel *panel, FILE *out, unsigned place, double low, double high,
                 double least, const char *label, bool last, bool si)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    static char x_label[2][40];
    snprintf(x_label[si], sizeof x_label[si], "station, %s", station->text);
    if (!(low <= high))
        low = high = 0.0;
    svg_widen(&low, &high, least);
    panel->plot =
        (struct svg_plot){.out = out,
                          .left = CHART_LEFT,
                          .top = TOP + STEP * place,
                          .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                          .height = HEIGHT,
                          .x = {0.0, 120.0 * station->factor, last ? x_label[si] : NULL, last},
                          .y = {low, high, label, true}};
    for (unsigned k = 0; k < SURVEY_POINTS; k++)
        panel->x[k] = SURVEY_SPAN_FT * k * station->factor;
    svg_axes(&panel->plot);
}

static void draw_lines(struct panel *panel, FILE *out, unsigned place,
                       const struct survey_found *found, bool moved, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    double y[SURVEY_LINES][SURVEY_POINTS], middle[SURVEY_SPANS], low = (double)INFINITY,
                                                                 high = -(double)INFINITY;
    size_t count = moved ? SURVEY_POINTS : SURVEY_SPANS;
    double key_px = CHART_LEFT;
    char label[60];
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        for (unsigned k = 0; k < count; k++)
            y[line][k] = length->factor * (moved ? found->since_previous.moved[line][k].value_in
                                                 : found->since_previous.change.gap_in[line][k]);
        chart_extend(y[line], count, &low, &high);
    }
    snprintf(label, sizeof label, moved ? "moved, %s" : "opened, %s", length->text);
    axes(panel, out, place, low, high, 0.02 * length->factor, label, false, si);
    for (unsigned k = 0; k < SURVEY_SPANS; k++)
        middle[k] = 0.5 * (panel->x[k] + panel->x[k + 1]);
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        chart_line(&panel->plot, line, moved ? panel->x : middle, y[line], count, 3);
        key_px = moved ? key_px : chart_key(out, line, key_px, 16.0, survey_line_text(line + 1));
    }
}

/* In-plane bow since the first survey, of the newest ones, between the limits. */
static enum mr_status draw_bows(struct panel *panel, FILE *out, unsigned place, struct store *store,
                                const struct store_gage_survey *rows, size_t count,
                                const char *pattern, bool si, struct error *error)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    double limit = SURVEY_BOW_LIMIT_IN * length->factor, y[SURVEY_POINTS];
    double key_px = CHART_LEFT + 8.0;
    char label[60], name[40];
    unsigned drawn = 0;
    enum mr_status status = MR_OK;
    struct survey *survey = malloc(sizeof *survey);
    struct survey_found *found = malloc(sizeof *found);
    if (!survey || !found)
        abort();
    snprintf(label, sizeof label, "bow, %s", length->text);
    axes(panel, out, place, -limit, limit, limit, label, true, si);
    const double ends[2] = {panel->plot.x.low, panel->plot.x.high}, up[2] = {limit, limit},
                 down[2] = {-limit, -limit};
    svg_line(&panel->plot, "mark", ends, up, 2);
    svg_line(&panel->plot, "mark", ends, down, 2);
    for (size_t i = count; i-- > 0 && drawn < SURVEYS_DRAWN && status == MR_OK;) {
        if (strcmp(rows[i].pattern, pattern) != 0)
            continue;
        status = survey_get(store, rows[i].id, survey, error);
        if (status == MR_OK)
            status = survey_find(store, survey, found, error);
        if (status != MR_OK || !found->first)
            continue;
        for (unsigned k = 0; k < SURVEY_POINTS; k++)
            y[k] = found->since_first.bow[k].value_in * length->factor;
        snprintf(name, sizeof name, "survey %lld", (long long)rows[i].id);
        chart_line(&panel->plot, drawn, panel->x, y, SURVEY_POINTS, 3);
        key_px = chart_key(out, drawn++, key_px, panel->plot.top + HEIGHT - 20.0, name);
    }
    free(survey);
    free(found);
    return status;
}

static void rows_table(FILE *out, const struct store_gage_survey *rows, size_t count)
{
    html_table(
        out, (const char *const[]){"survey", "begun", "pattern", "after RUN", "by", "note", NULL});
    for (size_t i = 0; i < count; i++) {
        char when[40];
        survey_time_text(rows[i].made_us, when, sizeof when);
        fputs("<tr>", out);
        html_cell(out, "%lld%s", (long long)rows[i].id,
                  rows[i].ended_us == STORE_NONE ? ", goes on" : "");
        html_cell(out, "%s", when);
        html_cell(out, "%s", rows[i].pattern);
        if (rows[i].after_run == STORE_NONE)
            html_cell(out, "-");
        else
            html_cell(out, "%lld", (long long)rows[i].after_run);
        html_cell(out, "%s", rows[i].who);
        html_cell(out, "%s", rows[i].note);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

static void words(FILE *out, const struct survey *survey, const struct survey_found *found, bool si)
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

enum mr_status campaign_survey(const struct report *report, FILE *out, struct error *error)
{
    struct store *store = report->store;
    const bool si = report->si;
    struct store_gage_survey *rows = NULL;
    struct survey *survey = malloc(sizeof *survey);
    struct survey_found *found = malloc(sizeof *found);
    struct panel panel;
    size_t count = 0;
    if (!survey || !found)
        abort();
    enum mr_status status = store_gage_surveys(store, &rows, &count, error);
    if (status == MR_OK && count) {
        status = survey_get(store, 0, survey, error);
        if (status == MR_OK)
            status = survey_find(store, survey, found, error);
    }
    if (status == MR_OK && count) {
        rows_table(out, rows, count);
        words(out, survey, found, si);
    }
    if (status == MR_OK && count && found->previous) {
        fputs("<figure>", out);
        svg_open(out, CHART_WIDTH, TOP + 3 * STEP + 30.0,
                 "opening of joints, movement and in-plane bow against station");
        draw_lines(&panel, out, 0, found, false, si);
        draw_lines(&panel, out, 1, found, true, si);
        status = draw_bows(&panel, out, 2, store, rows, count, survey->row.pattern, si, error);
        svg_close(out);
        fprintf(out,
                "<figcaption>Survey %lld against %lld, by gage line: opening (+) and closing (-) "
                "of ten mats; movement downfield; in-plane bow of the "
                "newest surveys since survey %lld, between the limits "
                "(dotted).</figcaption></figure>\n",
                (long long)survey->row.id, (long long)found->previous, (long long)found->first);
    }
    free(rows);
    free(survey);
    free(found);
    return status;
}
