/* The two landing engines of campaigns: error against run time of single passes, on the first
 * landing of the standard series. The measure is what a campaign keeps: movements at 64 stations. A
 * landing is badly conditioned (whether a joint just closes decides where its mats come to rest),
 * so errors do not fall with the step as far as they would elsewhere: how far they can is measured,
 * by a change of friction that no measurement would see. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/landing_series/ensemble.h"
#include "host/base/monotonic_clock.h"
#include "host/base/plot.h"
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

static double played_ms; /* processor time of a landing, in the last play */

static enum mr_status play(struct landing_series *series, const struct engine *engine, double dt_s,
                           struct series_run *runs, struct error *error)
{
    series->engine = engine->use;
    series->chain_dt_s = series->planar_dt_s = dt_s;
    double begin_ms = processor_ms();
    series_ensemble(series, 1, NULL, NULL, runs);
    played_ms = (processor_ms() - begin_ms) / SEEDS;
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
    struct point p = {.dt_s = dt_s, .ms = played_ms};
    double sum = 0.0;
    for (size_t i = 0; i < SEEDS; i++) {
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

static void table(const struct point points[ENGINES][STEPS])
{
    puts("| engine | dt (s) | ms a landing | rms error (in) | largest error (in) |\n"
         "|---|---|---|---|---|");
    for (size_t e = 0; e < ENGINES; e++) {
        for (int k = 0; k < STEPS; k++)
            printf("| %s | %.2e | %.1f | %.1e | %.1e |\n", engines[e].name, points[e][k].dt_s,
                   points[e][k].ms, points[e][k].rms_in, points[e][k].worst_in);
    }
}

static enum mr_status draw(const char *folder, const struct point points[ENGINES][STEPS],
                           struct error *error)
{
    char path[400];
    struct plot *plot = plot_new("landing engines", 640, 420, 1);
    snprintf(path, sizeof path, "%s/engines.svg", folder);
    plot_panel(plot, NULL, (struct plot_axis){.label = "run time of a landing (ms)", .log = true},
               (struct plot_axis){.label = "rms error of movement (in)", .log = true});
    for (unsigned e = 0; e < ENGINES; e++) {
        double x[STEPS], y[STEPS];
        for (int k = 0; k < STEPS; k++) {
            x[k] = points[e][k].ms;
            y[k] = fmax(points[e][k].rms_in, 1e-8);
        }
        plot_draw(plot, &(struct plot_series){.kind = PLOT_LINE_POINTS,
                                              .key = engines[e].name,
                                              .colour = e,
                                              .shape = e,
                                              .x = x,
                                              .y = y,
                                              .count = STEPS});
    }
    return plot_write(plot, path, error);
}

enum mr_status write_engines(const char *folder, const char *path, struct error *error)
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
        printf("\n## The landing engines of series\n\n%s, first landing, %d runways, "
               "single passes; errors of the "
               "movement at %d stations against a step of 1/%d of the longest one here, of the "
               "same engine.\n\n",
               series.name, SEEDS, SERIES_STATIONS_MAX, 1 << (STEPS - 1 + REFERENCE));
        printf("Landings are badly conditioned: whether a joint just closes decides where its "
               "mats come to rest. Friction changed "
               "by a part in %.0e moves the reference itself by %.1e in rms (chain) and %.1e in "
               "(planar): no step makes errors much "
               "smaller than that, and none below it is worth its time.\n\n",
               1.0 / NUDGE, nudged[0].rms_in, nudged[1].rms_in);
        table(points);
        draw(folder, points, error);
    }
    series.landing_count = landings;
    series_free(&series);
    return error->status;
}
