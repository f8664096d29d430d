/* Displacement against station: what each landing added, what it came to by then, and its peak
 * (report figs. 4.5, 4.6, 5.2). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/report/chart.h"
#include "host/base/html.h"
#include "host/report/report.h"

#define NAMED_MAX    8u /* so many lines of a picture are named and told apart, the others thin */
#define HEIGHT       210.0
#define NAME_PX      90.0
#define NAME_STEP_PX 12.0

/* A line of a picture: a value for each transducer. NaN: not known. */
struct profile {
    char name[90];
    double station[MR_TRANSDUCERS], value[MR_TRANSDUCERS], error[MR_TRANSDUCERS];
};

/* In the unit shown, added to what `before` had come to (NULL: nothing). */
static void add_landing(const struct report_facts *facts, const struct profile *before, bool si,
                        struct profile *profile)
{
    double length = unit_of(UNIT_DISPLACEMENT, si)->factor;
    snprintf(profile->name, sizeof profile->name, "RUN %lld", (long long)facts->landing.id);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct report_moved *moved = &facts->moved[i];
        profile->station[i] = unit_of(UNIT_STATION, si)->factor * moved->station_ft;
        profile->value[i] = (before ? before->value[i] : 0.0) + length * moved->end;
        profile->error[i] = hypot(before ? before->error[i] : 0.0, length * moved->end_error);
    }
}

static void peaks_of(const struct report_facts *facts, bool si, struct profile *profile)
{
    double length = unit_of(UNIT_DISPLACEMENT, si)->factor;
    add_landing(facts, NULL, si, profile);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        profile->value[i] = length * facts->moved[i].peak;
        profile->error[i] = length * facts->moved[i].error;
    }
}

/* Evenly spread over them, the last among them. */
static bool is_named(size_t i, size_t count)
{
    size_t step = (count + NAMED_MAX - 1) / NAMED_MAX;
    return (count - 1 - i) % step == 0;
}

/* Where the last value that is known ends; -1: nowhere. */
static int last_known(const struct profile *profile)
{
    int last = -1;
    for (int i = 0; i < (int)MR_TRANSDUCERS; i++) {
        if (!isnan(profile->value[i]) && !isnan(profile->station[i]))
            last = i;
    }
    return last;
}

/* Names at the ends of the lines, pushed apart. */
static void draw_names(const struct svg_plot *plot, const struct profile *profiles, size_t count)
{
    size_t order[NAMED_MAX + 1], named = 0;
    double at_px[NAMED_MAX + 1];
    for (size_t i = 0; i < count; i++) {
        int last = last_known(&profiles[i]);
        if (!is_named(i, count) || last < 0 || named > NAMED_MAX)
            continue;
        double y = svg_y(plot, profiles[i].value[last]);
        size_t k = named++;
        for (; k > 0 && at_px[k - 1] > y; k--) {
            at_px[k] = at_px[k - 1];
            order[k] = order[k - 1];
        }
        at_px[k] = y;
        order[k] = i;
    }
    for (size_t k = 1; k < named; k++)
        at_px[k] = fmax(at_px[k], at_px[k - 1] + NAME_STEP_PX);
    for (size_t k = named; k-- > 0;) { /* and back where they ran out of the picture */
        double most_px = k + 1 < named ? at_px[k + 1] - NAME_STEP_PX : plot->top + plot->height;
        at_px[k] = fmin(at_px[k], most_px);
    }
    for (size_t k = 0; k < named; k++) {
        const struct profile *profile = &profiles[order[k]];
        int last = last_known(profile);
        double dy = at_px[k] - svg_y(plot, profile->value[last]);
        svg_text(plot, "label", "start", profile->station[last], profile->value[last], 9.0,
                 dy + 4.0, profile->name);
    }
}

static void draw_profile(const struct svg_plot *plot, const struct profile *profile, unsigned look,
                         bool named)
{
    char class[16];
    if (!named) {
        svg_line(plot, "line faint", profile->station, profile->value, MR_TRANSDUCERS);
        return;
    }
    snprintf(class, sizeof class, "line s%u", look % 6);
    chart_line(plot, look, profile->station, profile->value, MR_TRANSDUCERS, 1);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        chart_whisker(plot, class, profile->station[i],
                      profile->value[i] - SUMMARY_95 * profile->error[i],
                      profile->value[i] + SUMMARY_95 * profile->error[i]);
}

/* A picture with a line for each. */
static void draw_profiles(FILE *out, const struct profile *profiles, size_t count, const char *what,
                          const char *title, bool si)
{
    struct chart_text x_label = chart_label("station", UNIT_STATION, si),
                      y_label = chart_label(what, UNIT_DISPLACEMENT, si);
    struct svg_plot plot = {.out = out,
                            .left = CHART_LEFT,
                            .top = 10.0,
                            .width = CHART_WIDTH - CHART_LEFT - NAME_PX,
                            .height = HEIGHT};
    double low = 0.0, high = 0.0;
    unsigned look = 0;
    for (size_t i = 0; i < count; i++)
        chart_extend(profiles[i].value, MR_TRANSDUCERS, &low, &high);
    svg_widen(&low, &high, 0.02 * unit_of(UNIT_DISPLACEMENT, si)->factor);
    plot.x = (struct svg_axis){0.0, CHART_RUNWAY_FT * unit_of(UNIT_STATION, si)->factor,
                               x_label.text, true};
    plot.y = (struct svg_axis){low, high, y_label.text, true};
    svg_open(out, CHART_WIDTH, HEIGHT + 52.0, title);
    svg_axes(&plot);
    for (size_t i = 0; i < count; i++) {
        bool named = is_named(i, count);
        draw_profile(&plot, &profiles[i], look, named);
        look += named;
    }
    draw_names(&plot, profiles, count);
    svg_close(out);
}

static void table(FILE *out, const struct profile *profiles, size_t count, bool si)
{
    char heads[MR_TRANSDUCERS][40];
    const char *list[MR_TRANSDUCERS + 2] = {"after"};
    size_t columns = 0;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        snprintf(heads[i], sizeof heads[i], "%.*f %s", si ? 1 : 0, profiles[0].station[i],
                 unit_of(UNIT_STATION, si)->text);
        list[++columns] = isnan(profiles[0].station[i]) ? "not fitted" : heads[i];
    }
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

/* Landings that follow each other in one series. */
static size_t in_series(const struct report *report, size_t first)
{
    size_t count = 1;
    while (first + count < report->landings &&
           report->facts[first + count].series.id == report->facts[first].series.id)
        count++;
    return count;
}

/* Boards on one bus are logged side by side: what one's transducers saw is not added to another's.
 * Landings of which the board is not known, such as imports, go with the first that is, of those
 * from `first` on. */
static const char *board_of(const struct report *report, size_t first, size_t count, size_t at)
{
    const struct report_facts *facts = report->facts;
    for (size_t i = first; i < first + count && !facts[at].landing.board_uid[0]; i++) {
        if (facts[i].landing.board_uid[0])
            return facts[i].landing.board_uid;
    }
    return facts[at].landing.board_uid;
}

static bool is_same_board(const struct report *report, size_t first, size_t count, size_t one,
                          size_t other)
{
    return strcmp(board_of(report, first, count, one), board_of(report, first, count, other)) == 0;
}

static bool begins_board(const struct report *report, size_t first, size_t count, size_t at)
{
    for (size_t i = first; i < at; i++) {
        if (is_same_board(report, first, count, i, at))
            return false;
    }
    return true;
}

static const char *series_name(const struct report_facts *facts)
{
    return facts->series.id ? facts->series.name : "none named";
}

/* `board`: it is named, for there are others. */
static void write_series(const struct report *report, size_t first, bool board,
                         const struct profile *cumulative, size_t count, bool heading, FILE *out)
{
    if (heading) {
        fputs("<h3>Series: ", out);
        html_text(out, series_name(&report->facts[first]));
        if (board)
            fprintf(out, ", board %s", report->facts[first].landing.board_uid);
        fputs("</h3>\n", out);
    }
    fputs("<figure>", out);
    draw_profiles(out, cumulative, count, "cumulative displacement",
                  "cumulative displacement against station, after each landing", report->si);
    fprintf(out,
            "<figcaption>Downfield is positive; the sum of what each landing left, with 95 %% "
            "errors; where a reading is missing it is not known from then on.%s As report figs. "
            "4.5 and 4.6.</figcaption></figure>\n",
            count > NAMED_MAX ? " Not every line is named." : "");
    fprintf(out, "<p>Cumulative displacement by station, %s; &plusmn; is one standard error.</p>\n",
            unit_of(UNIT_DISPLACEMENT, report->si)->text);
    table(out, cumulative, count, report->si);
}

enum mr_status campaign_cumulative(const struct report *report, FILE *out, struct error *error)
{
    struct profile *profile = calloc(report->landings + 1, sizeof *profile),
                   *last = calloc(report->landings + 1, sizeof *last);
    size_t series = 0;
    if (!profile || !last) {
        free(profile);
        free(last);
        return error_set(error, MR_FULL, "no memory: %zu landings; close other programs",
                         report->landings);
    }
    for (size_t first = 0, count; first < report->landings; first += count) {
        count = in_series(report, first);
        for (size_t at = first; at < first + count; at++) {
            size_t own = 0;
            if (!begins_board(report, first, count, at))
                continue;
            for (size_t i = at; i < first + count; i++) {
                if (!is_same_board(report, first, count, at, i))
                    continue;
                add_landing(&report->facts[i], own ? &profile[own - 1] : NULL, report->si,
                            &profile[own]);
                own++;
            }
            write_series(report, at, own < count, profile, own, own < report->landings, out);
            last[series] = profile[own - 1];
            snprintf(last[series].name, sizeof last[series].name, "%.15s%s%.8s",
                     series_name(&report->facts[at]), own < count ? " " : "",
                     own < count ? report->facts[at].landing.board_uid : "");
            series++;
        }
    }
    if (series > 1) {
        fputs("<h3>Series against each other</h3>\n<figure>", out);
        draw_profiles(out, last, series, "cumulative displacement",
                      "cumulative displacement against station, of each series", report->si);
        fputs("<figcaption>What each series came to. As report fig. 5.2.</figcaption></figure>\n",
              out);
    }
    for (size_t i = 0; i < report->landings; i++)
        peaks_of(&report->facts[i], report->si, &profile[i]);
    if (report->landings) {
        fputs("<h3>Peak movement</h3>\n<figure>", out);
        draw_profiles(out, profile, report->landings, "peak movement",
                      "peak movement against station, a line per landing", report->si);
        fputs(
            "<figcaption>Largest movement within each landing, by station.</figcaption></figure>\n",
            out);
    }
    free(profile);
    free(last);
    return MR_OK;
}
