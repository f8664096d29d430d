/* The command matrig study: simulates a series of landings on an ensemble of runways. */
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "host/base/plot.h"
#include "host/base/progress.h"
#include "host/base/xmalloc.h"
#include "host/landing_series/ensemble.h"
#include "host/commands/studies.h"
#include "host/commands/commands.h"

static void show_progress(void *ctx, size_t done, size_t total)
{
    progress_set(ctx, "%zu of %zu runways done", done, total);
}

/* Largest number of landings in the plot; if there are more, every n-th is plotted */
#define PLOT_LINES_MAX 8

static void plot_movement(struct plot *plot, const struct landing_series *c,
                          const struct series_summary *s)
{
    double middle[SERIES_STATIONS_MAX];
    size_t played = 0;
    while (played < c->landing_count && s->landing[played].runway_count > 0)
        played++;
    size_t every = (played + PLOT_LINES_MAX - 1) / PLOT_LINES_MAX;
    for (size_t i = 0; i < played; i++) {
        char key[32];
        if (i + 1 != played && (i + 1) % every != 0)
            continue;
        for (size_t k = 0; k < c->station_count; k++)
            middle[k] = s->landing[i].total_movement_in[k].median;
        snprintf(key, sizeof key, "landing %zu", i + 1);
        plot_add_series(plot, &(struct plot_series){.kind = PLOT_LINE,
                                                    .key = key,
                                                    .colour = (unsigned)(i / every),
                                                    .x = c->stations_ft,
                                                    .y = middle,
                                                    .count = c->station_count});
    }
}

/* Plots the landing in which each runway buckles. Runways that buckle in the same landing are
 * plotted at different heights. */
static void plot_buckles(struct plot *plot, const struct landing_series *c,
                         const struct series_run *runs)
{
    double *station_ft = xcalloc(2 * c->seed_count, sizeof *station_ft),
           *landing = station_ft + c->seed_count;
    size_t count = 0;
    for (size_t i = 0; i < c->seed_count; i++) {
        if (runs[i].buckled_landing == 0)
            continue;
        station_ft[count] = runs[i].buckle_station_ft;
        landing[count++] = runs[i].buckled_landing + 0.6 * ((double)(i % 9) / 8.0 - 0.5);
    }
    plot_add_series(
        plot, &(struct plot_series){
                  .kind = PLOT_POINTS, .colour = 1, .x = station_ft, .y = landing, .count = count});
    free(station_ft);
}

static enum mr_status write_plot(const char *path, const struct landing_series *c,
                                 const struct series_run *runs, const struct series_summary *s,
                                 struct error *error)
{
    const struct plot_axis station = {
        "station (ft)", 0.0, c->landings[0].scene.mats * c->landings[0].scene.length_ft, false};
    struct plot *plot = plot_new(c->name, 1000, 420, 2);
    plot_begin_panel(plot, NULL, station,
                     (struct plot_axis){.label = "total movement, median (in)"});
    plot_movement(plot, c, s);
    plot_begin_panel(
        plot, NULL, station,
        (struct plot_axis){"buckles in landing", 0.5, (double)c->landing_count + 0.5, false});
    plot_buckles(plot, c, runs);
    return plot_write(plot, path, error);
}

static int write_outputs(const struct landing_series *c, const struct study_request *request,
                         const struct series_run *runs, const struct cli *cli, struct error *error)
{
    struct series_summary summary;
    int code = 0;
    series_summarise(&summary, c, runs);
    if (request->plot)
        write_plot(request->plot, c, runs, &summary, error);
    if (error->status == MR_OK && summary.failed_count > 0)
        error_set(error, MR_NUMERICS,
                  "%zu of %zu runways could not be simulated to their end: %s; see FAILED above",
                  summary.failed_count, c->seed_count, request->path);
    if (error->status != MR_OK)
        code = cli_fail(error);
    code = answer_print(cli, series_to_answer(c, runs, &summary, cli->si), code);
    series_summary_free(&summary);
    return code;
}

int study_command(int argc, char **argv, const struct cli *cli)
{
    struct error error = {0};
    struct study_request request = {0};
    struct landing_series series;
    struct progress progress;
    command_parse(&command_study, argc, argv, cli, &request, &request.path, fatal);
    plot_check(request.plot, request.path, fatal);
    series_load_on_ground(&series, request.path, request.ground, fatal);
    if (request.seeds)
        series.seed_count = (size_t)request.seeds;
    struct series_run *runs = xcalloc(series.seed_count, sizeof *runs);
    progress_begin(&progress, "study", "fewer --seeds", cli->quiet);
    progress_set(&progress, "0 of %zu runways done", series.seed_count);
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    series_simulate_all(&series, cores > 1 ? (unsigned)cores : 1u, show_progress, &progress, runs);
    progress_end(&progress);
    int code = write_outputs(&series, &request, runs, cli, &error);
    for (size_t i = 0; i < series.seed_count; i++)
        series_run_free(&runs[i]);
    free(runs);
    series_free(&series);
    return code;
}
