/* Zones over the landings: a row for each, station across. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/report/chart.h"
#include "host/report/report.h"
#include "host/base/svg_words.h"

#define ROW_PX 34.0
#define TOP_PX 40.0

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
static void draw_closed(const struct rows *rows, size_t row, const struct report_landing *landing)
{
    const struct measured *measured = &landing->summary.measured;
    float remaining_in[MR_SEGMENTS];
    struct mr_closure_zone zone;
    if (measured->samples == 0)
        return;
    zones_closed(measured, &landing->survey, measured->samples - 1, remaining_in, &zone);
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        if (remaining_in[s] < MR_CLOSURE_OPEN_IN)
            bar(rows, row, 1, "closed", (double)MR_SEGMENT_LENGTH_FT * s,
                (double)MR_SEGMENT_LENGTH_FT * (s + 1));
    }
}

static void draw_said(const struct rows *rows, size_t row, const struct report_landing *landing)
{
    const struct zones *zones = &landing->summary.zones;
    if (zones->warning.warned) {
        bar(rows, row, 0, "warned edge", zones->warning.most_start_ft, zones->warning.most_end_ft);
    } else {
        const struct store_zone *longest = NULL;
        for (size_t i = 0; i < zones->count; i++) {
            if (zones->row[i].mats > 0 && (!longest || zones->row[i].mats > longest->mats))
                longest = &zones->row[i];
        }
        if (longest)
            bar(rows, row, 0, "told", longest->start_ft, longest->end_ft);
    }
    if (zones->count && zones->row[zones->count - 1].mats > 0)
        bar(rows, row, 2, "behind", zones->row[zones->count - 1].start_ft,
            zones->row[zones->count - 1].end_ft);
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

static void draw_stop(const struct rows *rows, size_t row, const struct measured *measured)
{
    if (measured->fit_status != MR_OK)
        return;
    double x = svg_x(&rows->plot, rows->station * measured->summary.stop_station_ft.value);
    fprintf(rows->plot.out, "<path class=\"line a\" d=\"M%.1f %.1fV%.1f\"/>\n", x,
            svg_y(&rows->plot, (double)row + 0.95), svg_y(&rows->plot, (double)row + 0.05));
}

static enum mr_status draw_row(const struct rows *rows, size_t row, const struct report *report,
                               struct error *error)
{
    const struct report_landing *landing = &report->landing[row];
    const struct measured *measured = &landing->summary.measured;
    char name[40];
    snprintf(name, sizeof name, "RUN %lld", (long long)measured->landing.id);
    svg_text(&rows->plot, "tick", "end", 0.0, (double)row + 0.5, -6.0, 4.0, name);
    draw_closed(rows, row, landing);
    draw_said(rows, row, landing);
    draw_stop(rows, row, measured);
    fprintf(rows->plot.out, "<path class=\"grid\" d=\"M%.1f %.1fh%.1f\"/>\n", rows->plot.left,
            svg_y(&rows->plot, (double)row + 1.0), rows->plot.width);
    return draw_seen(rows, row, report->store, measured->landing.id, error);
}

enum mr_status campaign_zones(const struct report *report, FILE *out, struct error *error)
{
    struct chart_text label = chart_label("station", UNIT_STATION, report->si);
    const struct svg_key keys[] = {{"key warned", "longest zone while it warned"},
                                   {"key told", "longest zone told, no warning"},
                                   {"key closed", "found closed at the end"},
                                   {"key behind", "told of last"},
                                   {"line a", "the stop"}};
    double station = unit_of(UNIT_STATION, report->si)->factor,
           height = ROW_PX * (double)report->landings;
    struct rows rows = {.plot = {.out = out,
                                 .left = CHART_LEFT,
                                 .top = TOP_PX,
                                 .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                                 .height = height},
                        .station = station,
                        .si = report->si};
    enum mr_status status = MR_OK;
    if (report->landings == 0)
        return MR_OK;
    rows.plot.x = (struct svg_axis){0.0, CHART_RUNWAY_FT * station, label.text, true};
    /* the first landing uppermost */
    rows.plot.y = (struct svg_axis){(double)report->landings, 0.0, NULL, false};
    fputs("<figure>", out);
    svg_open(out, CHART_WIDTH, TOP_PX + height + 42.0, "zones of each landing against station");
    svg_axes(&rows.plot);
    for (size_t i = 0; i < report->landings && status == MR_OK; i++)
        status = draw_row(&rows, i, report, error);
    svg_legend(out, CHART_LEFT, CHART_WIDTH - CHART_RIGHT, 14.0, keys, 5);
    svg_mark(out, "open", 3, CHART_LEFT + 10.0, 27.0, 4.5);
    fprintf(out,
            "<text class=\"tick\" x=\"%.1f\" y=\"31\">wave or break seen, with its panels</text>\n",
            CHART_LEFT + 25.0);
    svg_close(out);
    fputs("<figcaption>Told of: what the board's predictor said. Found: from survey and "
          "transducers (no bar: not surveyed, or open).</figcaption></figure>\n",
          out);
    return status;
}
