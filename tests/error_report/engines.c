/* The two landing engines of campaigns: error against run time of single passes, on the first
 * landing of the standard series. The measure is what a campaign keeps: movements at 64 stations. A
 * landing is badly conditioned (whether a joint just closes decides where its mats come to rest),
 * so errors do not fall with the step as far as they would elsewhere: how far they can is measured,
 * by a change of friction that no measurement would see. */
#include <math.h>
#include <stdlib.h>

#include "host/landing_series/play.h"
#include "host/base/html.h"
#include "host/base/svg.h"
#include "tests/error_report/report.h"

#define SEEDS     3
#define STEPS     5    /* 2 / 3 of the longest, and halves of it */
#define NUDGE     1e-9 /* of friction, relative */
#define REFERENCE 1    /* the reference's step: so many halvings below the last */

struct engine {
    const char *name;
    enum series_engine use;
    double longest_s; /* stability limit on this runway */
};

struct point {
    double dt_s, ms, rms_in, worst_in;
};

static const struct engine engines[] = {{"chain", SERIES_CHAIN, 2.0e-4},
                                        {"planar", SERIES_PLANAR, 2.0e-4}};
#define ENGINES (sizeof engines / sizeof engines[0])

static enum mr_status play(struct landing_series *series, const struct engine *engine, double dt_s,
                           struct series_run *runs, struct error *error)
{
    series->engine = engine->use;
    series->chain_dt_s = series->planar_dt_s = dt_s;
    if (series_ensemble(series, 1, false, NULL, NULL, runs, error) != MR_OK)
        return error->status;
    for (size_t i = 0; i < SEEDS; i++) {
        if (runs[i].error.status != MR_OK)
            *error = runs[i].error;
    }
    return error->status;
}

static void release(struct series_run *runs)
{
    for (size_t i = 0; i < SEEDS; i++)
        series_run_free(&runs[i]);
}

static struct point measure(const struct landing_series *series, double dt_s,
                            const struct series_run *runs, const struct series_run *reference)
{
    struct point p = {.dt_s = dt_s};
    double sum = 0.0;
    for (size_t i = 0; i < SEEDS; i++) {
        p.ms += runs[i].ms / SEEDS;
        for (size_t s = 0; s < series->station_count; s++) {
            double apart =
                fabs(runs[i].outcomes[0].movement_in[s] - reference[i].outcomes[0].movement_in[s]);
            p.worst_in = fmax(p.worst_in, apart);
            sum += apart * apart;
        }
    }
    p.rms_in = sqrt(sum / (double)(SEEDS * series->station_count));
    return p;
}

/* `nudged`: the reference once more with friction changed by NUDGE. */
static enum mr_status study(struct landing_series *series, const struct engine *engine,
                            struct point *points, struct point *nudged, struct error *error)
{
    struct series_run reference[SEEDS] = {0}, runs[SEEDS] = {0};
    double finest_s = engine->longest_s / 1.5 / (double)(1 << (STEPS - 1 + REFERENCE)),
           friction = series->landings[0].scene.friction;
    play(series, engine, finest_s, reference, error);
    if (error->status == MR_OK) {
        series->landings[0].scene.friction = friction * (1.0 + NUDGE);
        if (play(series, engine, finest_s, runs, error) == MR_OK)
            *nudged = measure(series, finest_s, runs, reference);
        series->landings[0].scene.friction = friction;
        release(runs);
    }
    for (int k = 0; k < STEPS && error->status == MR_OK; k++) {
        double dt_s = engine->longest_s / 1.5 / (double)(1 << k);
        if (play(series, engine, dt_s, runs, error) == MR_OK)
            points[k] = measure(series, dt_s, runs, reference);
        release(runs);
    }
    release(reference);
    return error->status;
}

static void table(FILE *out, const struct point points[ENGINES][STEPS])
{
    static const char *const heads[] = {
        "engine", "dt, s", "ms a landing", "rms error, in", "largest error, in", NULL};
    html_table(out, heads);
    for (size_t e = 0; e < ENGINES; e++) {
        for (int k = 0; k < STEPS; k++) {
            fputs("<tr>", out);
            html_cell(out, "%s", engines[e].name);
            html_cell(out, "%.2e", points[e][k].dt_s);
            html_cell(out, "%.1f", points[e][k].ms);
            html_cell(out, "%.1e", points[e][k].rms_in);
            html_cell(out, "%.1e", points[e][k].worst_in);
            fputs("</tr>\n", out);
        }
    }
    fputs("</tbody></table></div>\n", out);
}

static void draw(FILE *out, const struct point points[ENGINES][STEPS])
{
    static const char *const classes[] = {"e0", "e1"};
    double low = HUGE_VAL, high = 0.0, fast = HUGE_VAL, slow = 0.0;
    for (size_t e = 0; e < ENGINES; e++) {
        for (int k = 0; k < STEPS; k++) {
            low = fmin(low, fmax(points[e][k].rms_in, 1e-8));
            high = fmax(high, points[e][k].rms_in);
            fast = fmin(fast, points[e][k].ms);
            slow = fmax(slow, points[e][k].ms);
        }
    }
    struct svg_plot plot = {.out = out,
                            .left = 70,
                            .top = 20,
                            .width = 500,
                            .height = 240,
                            .log_x = true,
                            .log_y = true,
                            .x = {fast / 1.3, slow * 1.3, "run time of a landing, ms", true},
                            .y = {low / 1.5, high * 1.5, "rms error of movement, in", true}};
    svg_open(out, 600, 310, "error against run time of the landing engines");
    fputs("<style>.e0,.e1{fill:none;stroke-width:1.6}.e0{stroke:#3465a4}.e1{stroke:#cc0000}.frame,."
          "grid{fill:none;stroke:#ccc}"
          "text{font:12px sans-serif}</style>",
          out);
    svg_axes(&plot);
    for (size_t e = 0; e < ENGINES; e++) {
        double x[STEPS], y[STEPS];
        for (int k = 0; k < STEPS; k++) {
            x[k] = points[e][k].ms;
            y[k] = fmax(points[e][k].rms_in, 1e-8);
            svg_mark(out, classes[e], (unsigned)e, svg_x(&plot, x[k]), svg_y(&plot, y[k]), 4);
        }
        svg_line(&plot, classes[e], x, y, STEPS);
        svg_text(&plot, "label", "start", x[STEPS - 1], y[STEPS - 1], 6, -6, engines[e].name);
    }
    svg_close(out);
}

enum mr_status write_engines(FILE *out, const char *path, struct error *error)
{
    struct landing_series series;
    struct point points[ENGINES][STEPS] = {0}, nudged[ENGINES] = {0};
    if (series_load(&series, path, error) != MR_OK)
        return error->status;
    size_t landings = series.landing_count;
    series.seeds = SEEDS;
    series.landing_count = 1;
    series.station_count = SERIES_STATIONS_MAX;
    double runway_ft = series.landings[0].scene.mats * series.landings[0].scene.length_ft;
    for (size_t s = 0; s < series.station_count; s++)
        series.stations_ft[s] = runway_ft * ((double)s + 0.5) / SERIES_STATIONS_MAX;
    for (size_t e = 0; e < ENGINES && error->status == MR_OK; e++)
        study(&series, &engines[e], points[e], &nudged[e], error);
    if (error->status == MR_OK) {
        fprintf(out,
                "<h2>The landing engines of campaigns</h2>\n<p>%s, first landing, %d runways, "
                "single passes; errors of the "
                "movement at %d stations against a step of 1/%d of the longest one here, of the "
                "same engine.</p>\n",
                series.name, SEEDS, SERIES_STATIONS_MAX, 1 << (STEPS - 1 + REFERENCE));
        fprintf(out,
                "<p>Landings are badly conditioned: whether a joint just closes decides where its "
                "mats come to rest. Friction changed "
                "by a part in %.0e moves the reference itself by %.1e in rms (chain) and %.1e in "
                "(planar): no step makes errors much "
                "smaller than that, and none below it is worth its time.</p>\n",
                1.0 / NUDGE, nudged[0].rms_in, nudged[1].rms_in);
        draw(out, points);
        table(out, points);
    }
    series.landing_count = landings;
    series_free(&series);
    return error->status;
}
