/* Zones over the landings: a row for each, station across. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/report/chart.h"
#include "host/report/report.h"
#include "host/base/svg_words.h"

#define ROW_PX 34.0
#define TOP_PX 40.0
#define ROWS   20u /* landings in a picture */

struct rows {
    struct svg_plot plot;
    double station; /* factor */
    bool si;
};

/* A bar in a third of row `row`, 0 the uppermost. */
static void bar(const struct rows *rows, size_t row, unsigned third, const char *class,
                double from_ft, double to_ft)
{
    double top = (double)row + 0.12 + 0.26 * third;
    svg_rect(&rows->plot, class, rows->station * from_ft, top + 0.23, rows->station * to_ft, top);
}

/* Found closed by survey and transducers when the record ended. */
static void draw_closed(const struct rows *rows, size_t row, const struct report_facts *facts)
{
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        if (facts->closed & 1ull << s)
            bar(rows, row, 1, "closed", (double)MR_SEGMENT_LENGTH_FT * s,
                (double)MR_SEGMENT_LENGTH_FT * (s + 1));
    }
}

static void draw_said(const struct rows *rows, size_t row, const struct report_facts *facts)
{
    if (facts->warning.warned)
        bar(rows, row, 0, "warned edge", facts->warning.most_start_ft, facts->warning.most_end_ft);
    else if (facts->longest.mats > 0)
        bar(rows, row, 0, "told", facts->longest.start_ft, facts->longest.end_ft);
    if (facts->last.mats > 0)
        bar(rows, row, 2, "behind", facts->last.start_ft, facts->last.end_ft);
}

static enum mr_status draw_seen(const struct rows *rows, size_t row, struct store *store,
                                int64_t run, struct error *error)
{
    struct store_observation *seen = NULL;
    size_t count = 0;
    enum mr_status status = store_observations(store, run, &seen, &count, error);
    for (size_t i = 0; i < count; i++) {
        char panels[30];
        if (seen[i].withdrawn || isnan(seen[i].station_ft))
            continue;
        double x = rows->station * seen[i].station_ft, y = (double)row + 0.5;
        svg_mark(rows->plot.out, "open", 3, svg_x(&rows->plot, x), svg_y(&rows->plot, y), 4.5);
        if (seen[i].panels == STORE_NONE)
            continue;
        snprintf(panels, sizeof panels, "%lld", (long long)seen[i].panels);
        svg_text(&rows->plot, "tick", "start", x, y, 8.0, 4.0, panels);
    }
    free(seen);
    return status;
}

static void draw_stop(const struct rows *rows, size_t row, const struct report_facts *facts)
{
    if (!facts->fitted)
        return;
    double x = svg_x(&rows->plot, rows->station * facts->stop_ft.value);
    fprintf(rows->plot.out, "<path class=\"line a\" d=\"M%.1f %.1fV%.1f\"/>\n", x,
            svg_y(&rows->plot, (double)row + 0.95), svg_y(&rows->plot, (double)row + 0.05));
}

static enum mr_status draw_row(const struct rows *rows, size_t row, struct store *store,
                               const struct report_facts *facts, struct error *error)
{
    char name[40];
    snprintf(name, sizeof name, "RUN %lld", (long long)facts->landing.id);
    svg_text(&rows->plot, "tick", "end", 0.0, (double)row + 0.5, -6.0, 4.0, name);
    draw_closed(rows, row, facts);
    draw_said(rows, row, facts);
    draw_stop(rows, row, facts);
    fprintf(rows->plot.out, "<path class=\"grid\" d=\"M%.1f %.1fh%.1f\"/>\n", rows->plot.left,
            svg_y(&rows->plot, (double)row + 1.0), rows->plot.width);
    return draw_seen(rows, row, store, facts->landing.id, error);
}

static void draw_keys(FILE *out)
{
    static const struct svg_key keys[] = {{"key warned", "longest zone while it warned"},
                                          {"key told", "longest zone told, no warning"},
                                          {"key closed", "found closed at the end"},
                                          {"key behind", "told of last"},
                                          {"line a", "the stop"}};
    svg_legend(out, CHART_LEFT, CHART_WIDTH - CHART_RIGHT, 14.0, keys, 5);
    svg_mark(out, "open", 3, CHART_LEFT + 10.0, 27.0, 4.5);
    fprintf(out,
            "<text class=\"tick\" x=\"%.1f\" y=\"31\">wave or break seen, with its panels</text>\n",
            CHART_LEFT + 25.0);
}

/* `count` landings from `first` on, which a page of paper has room for. */
static enum mr_status draw_some(const struct report *report, size_t first, size_t count, FILE *out,
                                struct error *error)
{
    struct chart_text label = chart_label("station", UNIT_STATION, report->si);
    double station = unit_of(UNIT_STATION, report->si)->factor, height = ROW_PX * (double)count;
    struct rows rows = {.plot = {.out = out,
                                 .left = CHART_LEFT,
                                 .top = TOP_PX,
                                 .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                                 .height = height},
                        .station = station,
                        .si = report->si};
    enum mr_status status = MR_OK;
    rows.plot.x = (struct svg_axis){0.0, CHART_RUNWAY_FT * station, label.text, true};
    rows.plot.y = (struct svg_axis){(double)count, 0.0, NULL, false}; /* the first uppermost */
    fputs("<figure>", out);
    svg_open(out, CHART_WIDTH, TOP_PX + height + 42.0, "zones of each landing against station");
    svg_axes(&rows.plot);
    for (size_t i = 0; i < count && status == MR_OK; i++)
        status = draw_row(&rows, i, report->store, &report->facts[first + i], error);
    draw_keys(out);
    svg_close(out);
    if (first + count == report->landings)
        fputs("<figcaption>Told of: what the board's predictor said. Found: from survey and "
              "transducers (no bar: not surveyed, or open).</figcaption>",
              out);
    fputs("</figure>\n", out);
    return status;
}

enum mr_status campaign_zones(const struct report *report, FILE *out, struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t first = 0; first < report->landings && status == MR_OK; first += ROWS) {
        size_t left = report->landings - first;
        status = draw_some(report, first, left < ROWS ? left : ROWS, out, error);
    }
    return status;
}
