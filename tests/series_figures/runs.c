/* Playing a figure's campaign, and what the text's facts come to on it. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/statistics.h"
#include "host/landing_series/summary.h"
#include "tests/series_figures/figures.h"

#define STATIONS 60 /* shown, evenly; the rig's own are every 10 ft */

enum mr_status figure_play(struct figure_run *run, const struct figure *figure, const char *folder,
                           size_t seeds, struct error *error)
{
    char path[600];
    bool made = figure->series[0] == '+';
    *run = (struct figure_run){0};
    snprintf(path, sizeof path, "%s/%s", made ? folder : "host/landing_series/series",
             figure->series + made);
    if (series_load(&run->series, path, error) != MR_OK)
        return error->status;
    struct landing_series *c = &run->series;
    double runway_ft = c->landings[0].scene.mats * c->landings[0].scene.length_ft;
    c->seeds = seeds;
    c->engine = figure->engine;
    c->station_count = STATIONS - 1;
    for (size_t i = 0; i < c->station_count; i++)
        c->stations_ft[i] = runway_ft * (double)(i + 1) / STATIONS;
    while (figure->landings > 0 && c->landing_count > figure->landings)
        sim_scene_free(&c->landings[--c->landing_count].scene);
    run->runs = calloc(seeds, sizeof *run->runs);
    if (!run->runs)
        return error_set(error, MR_FULL, "out of memory: %zu seeds; give fewer", seeds);
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    series_ensemble(c, cores > 0 ? (unsigned)cores : 1, NULL, NULL, run->runs);
    for (size_t i = 0; i < seeds && error->status == MR_OK; i++) {
        if (run->runs[i].error.status != MR_OK)
            *error = run->runs[i].error;
    }
    return error->status;
}

void figure_run_free(struct figure_run *run)
{
    for (size_t i = 0; run->runs && i < run->series.seeds; i++)
        series_run_free(&run->runs[i]);
    free(run->runs);
    series_free(&run->series);
}

bool figure_curve_of(const struct landing_series *c, const struct series_run *run,
                     const struct figure_curve *curve, double *movement_in)
{
    int to = curve->to == FIGURE_LAST ? run->buckled : curve->to;
    int from = curve->to == FIGURE_LAST ? to - 1 : curve->from;
    if (to < 1 || (size_t)to > run->played)
        return false;
    for (size_t k = 0; k < c->station_count; k++)
        movement_in[k] = run->outcomes[to - 1].total_in[k] -
                         (from > 0 ? run->outcomes[from - 1].total_in[k] : 0.0);
    return true;
}

static double at_station(const struct landing_series *c, const double *movement_in,
                         double station_ft)
{
    size_t nearest = 0;
    for (size_t k = 1; k < c->station_count; k++) {
        if (fabs(c->stations_ft[k] - station_ft) < fabs(c->stations_ft[nearest] - station_ft))
            nearest = k;
    }
    return movement_in[nearest];
}

static size_t largest(const struct landing_series *c, const double *movement_in)
{
    size_t most = 0;
    for (size_t k = 1; k < c->station_count; k++)
        most = movement_in[k] > movement_in[most] ? k : most;
    return most;
}

static double along_curve(const struct figure *figure, const struct figure_fact *fact,
                          const struct landing_series *c, const struct series_run *run)
{
    double moved[SERIES_STATIONS_MAX], other[SERIES_STATIONS_MAX];
    if (!figure_curve_of(c, run, &figure->curves[(int)fact->a], moved))
        return (double)NAN;
    double most_in = moved[largest(c, moved)];
    switch (fact->kind) {
    case FACT_PEAK_STATION: return c->stations_ft[largest(c, moved)] + figure->zero_ft;
    case FACT_PEAK: return most_in;
    case FACT_RISE:
        return at_station(c, moved, fact->c - figure->zero_ft) -
               at_station(c, moved, fact->b - figure->zero_ft);
    case FACT_AT: return at_station(c, moved, fact->b - figure->zero_ft);
    case FACT_FAR_SHARE: return at_station(c, moved, fact->b - figure->zero_ft) / most_in;
    case FACT_RATIO:
        return figure_curve_of(c, run, &figure->curves[(int)fact->b], other)
                 ? most_in / other[largest(c, other)]
                 : (double)NAN;
    default: return (double)NAN;
    }
}

/* Of a landing; 0: the one before the buckle, or the last. */
static double zone_of(const struct figure_fact *fact, const struct series_run *run, double zero_ft)
{
    int landing = fact->a > 0      ? (int)fact->a
                : run->buckled > 1 ? run->buckled - 1
                                   : (int)run->played;
    if (landing < 1 || (size_t)landing > run->played)
        return (double)NAN;
    const struct series_outcome *o = &run->outcomes[landing - 1];
    return fact->kind == FACT_ZONE ? o->zone_mats : o->zone_to_ft + zero_ft;
}

static double band_of(const struct figure_fact *fact, const struct series_run *run)
{
    double slack = 0.0, ahead_lb = 0.0, behind_lb = 0.0;
    size_t turn = (size_t)fabs(fact->a);
    for (size_t i = 0; i < run->played; i++) {
        bool counts = fact->a > 0 ? i < turn : i >= turn;
        slack += counts && run->outcomes[i].band_slack > 0;
        ahead_lb += run->outcomes[i].band_ahead_lb / (double)run->played;
        behind_lb += run->outcomes[i].band_behind_lb / (double)run->played;
    }
    return fact->kind == FACT_SLACK ? slack : fact->kind == FACT_AHEAD ? ahead_lb : behind_lb;
}

static double on_runway(const struct figure *figure, const struct figure_fact *fact,
                        const struct landing_series *c, const struct series_run *run)
{
    switch (fact->kind) {
    case FACT_LANDING: return run->buckled > 0 ? run->buckled : (double)INFINITY;
    case FACT_STATION: return run->buckled > 0 ? run->buckle_ft + figure->zero_ft : (double)NAN;
    case FACT_ZONE:
    case FACT_ZONE_REACH: return zone_of(fact, run, figure->zero_ft);
    case FACT_SLACK:
    case FACT_AHEAD:
    case FACT_BEHIND: return band_of(fact, run);
    default: return along_curve(figure, fact, c, run);
    }
}

struct fact_value figure_fact_of(const struct figure *figure, const struct figure_fact *fact,
                                 const struct figure_run *run)
{
    struct fact_value value = {(double)NAN, (double)NAN, (double)NAN, 0, 0};
    double *values = calloc(run->series.seeds, sizeof *values);
    for (size_t i = 0; values && i < run->series.seeds; i++) {
        double v = on_runway(figure, fact, &run->series, &run->runs[i]);
        if (isnan(v))
            continue;
        values[value.of++] = v;
        value.agree += v >= fact->low && v <= fact->high;
    }
    if (value.of > 0) {
        /* few runways: all of them, and the middle one (the lower of two: never is infinite) */
        sort_numbers(values, value.of);
        value.low = values[0];
        value.middle = values[(value.of - 1) / 2];
        value.high = values[value.of - 1];
    }
    free(values);
    return value;
}
