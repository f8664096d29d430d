/* The command matrig sim: runs a scene and prints the result. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/commands/commands.h"
#include "host/base/output.h"
#include "host/base/progress.h"
#include "host/sim/scene/scene.h"
#include "host/sim/sim.h"
#include "host/commands/studies.h"
#include "host/base/xmalloc.h"

#define M_PER_FT 0.3048
#define HISTORY_INTERVAL_S \
    0.001 /* interval between rows of --csv, s; a thousandth of the duration if that is shorter */

struct request {
    const char *scene_path;
    const char *csv_path;
    bool keys;
    struct sim_options options;
};

static void read_request(int argc, char **argv, const struct cli *cli, struct request *request)
{
    command_parse(&command_sim, argc, argv, cli, request, &request->scene_path, fatal);
    if (request->keys && argc > 2)
        error_set(fatal, MR_USAGE,
                  "unexpected argument: --keys lists the keys of every scene; leave SCENE out");
    if (!request->keys && !request->scene_path)
        error_set(fatal, MR_USAGE,
                  "argument missing: matrig sim needs SCENE; see matrig sim --help");
    output_check(request->csv_path, request->scene_path, fatal);
}

static volatile sig_atomic_t interrupted;

static void handle_interrupt(int number)
{
    (void)number;
    interrupted = 1;
}

static bool show_progress(void *progress, int pass, double part)
{
    return sim_report_progress(progress, pass, part) && !interrupted;
}

/* Runs the scene. The first Ctrl-C ends the run, and the results so far are printed; the second
 * ends the program. */
static enum mr_status run_scene(struct request *request, const struct sim_scene *scene,
                                const struct cli *cli, struct sim_result *result,
                                struct error *error)
{
    struct progress progress;
    progress_begin(&progress, "sim", "a smaller tend, fewer mats, a looser rtol or --limit S",
                   cli->quiet);
    struct sigaction action = {.sa_handler = handle_interrupt, .sa_flags = (int)SA_RESETHAND},
                     before;
    request->options.in_parallel = true;
    request->options.may_continue = show_progress;
    request->options.may_continue_ctx = &progress;
    interrupted = 0;
    sigaction(SIGINT, &action, &before);
    sim_run(scene, &request->options, result, error);
    sigaction(SIGINT, &before, NULL);
    progress_end(&progress);
    return error->status;
}

/* Writes the history of the requested mats, one row per sample: displacements, and in planar models
 * also the height of each mat's left end. */
static enum mr_status write_csv(const struct request *request, const struct sim_scene *scene,
                                const struct sim_result *result, const struct cli *cli,
                                struct error *error)
{
    double unit = cli->si ? M_PER_FT : 1.0;
    struct output output;
    if (output_begin(&output, request->csv_path, error) != MR_OK)
        return error->status;
    FILE *file = output.file;
    int digits = sim_time_digits(result->start_s, 9);
    fputs("t_s", file);
    for (size_t i = 0; i < result->station_count; i++)
        fprintf(file, ",u_%d_%s", sim_output_mat(scene, i), cli->si ? "m" : "ft");
    for (size_t i = 0; result->sample_y_ft && i < result->station_count; i++)
        fprintf(file, ",y_%d_%s", sim_output_mat(scene, i), cli->si ? "m" : "ft");
    fputc('\n', file);
    for (size_t k = 0; k < result->sample_count; k++) {
        fprintf(file, "%.*g", digits, result->start_s + (double)k * result->sample_dt_s);
        for (size_t i = 0; i < result->station_count; i++)
            fprintf(file, ",%.9g", unit * result->sample_u_ft[k * result->station_count + i]);
        for (size_t i = 0; result->sample_y_ft && i < result->station_count; i++)
            fprintf(file, ",%.9g", unit * result->sample_y_ft[k * result->station_count + i]);
        fputc('\n', file);
    }
    return output_end(&output, error);
}

/* Requests samples in the middle of each mat of --csv. */
static void request_history(struct request *request, const struct sim_scene *scene,
                            double **stations)
{
    size_t count = sim_output_mat_count(scene);
    *stations = xcalloc(count, sizeof **stations);
    for (size_t i = 0; i < count; i++)
        (*stations)[i] = (sim_output_mat(scene, i) - 0.5) * scene->length_ft;
    request->options.station_ft = *stations;
    request->options.station_count = count;
    request->options.sample_dt_s =
        fmin(HISTORY_INTERVAL_S, (sim_scene_end_s(scene) - sim_scene_start_s(scene)) / 1000.0);
}

static int show_keys(const struct cli *cli)
{
    if (cli->json)
        return cli_print_json(sim_scene_keys_to_json(), 0);
    sim_scene_print_keys(stdout);
    return 0;
}

static int sim_command(int argc, char **argv, const struct cli *cli)
{
    struct request request = {0};
    struct error error = {0};
    struct sim_scene scene;
    struct sim_result result = {0};
    double *stations = NULL;
    int code = 0;

    read_request(argc, argv, cli, &request);
    if (request.keys)
        return show_keys(cli);
    if (request.options.solver && sim_solver_is_missing(request.options.solver))
        return study_exec(argc, argv, cli);
    sim_scene_load(&scene, request.scene_path, fatal);
    if (!scene.name[0])
        snprintf(scene.name, sizeof scene.name, "%s", request.scene_path);
    if (request.csv_path)
        request_history(&request, &scene, &stations);
    run_scene(&request, &scene, cli, &result, &error);
    bool usable = error.status == MR_OK || result.status == SIM_INTERRUPTED ||
                  result.status == SIM_UNPREDICTABLE;
    if (usable && request.csv_path) {
        struct error failed = {0};
        if (write_csv(&request, &scene, &result, cli, &failed) != MR_OK)
            error = failed;
    }
    if (error.status != MR_OK)
        code = cli_fail(&error);
    if (error.status == MR_OK || result.status != SIM_OK) {
        if (cli->json || usable)
            code = answer_print(cli, sim_to_answer(&scene, &result, cli->si), code);
    }
    sim_result_free(&result);
    sim_scene_free(&scene);
    free(stations);
    return code;
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM(
        "SCENE",
        "scene file, JSON; a number may be text with a unit: \"ground_damping\": \"175 N s/m\""),
    OPTION_FLAG("--keys", keys, "list the keys of a scene with default, unit and meaning"),
    OPTION_TEXT(
        "--solver", "S", options.solver,
        "solver; default: auto, which chooses a solver and states the reason. Planar models: "
        "event, implicit, cvode, rk4, rkgs, hamming, moreau. Chain: event, staggered. Each solver "
        "computes the result twice, and the difference gives the error estimate"),
    OPTION_NUMBER("--rtol", "R", options.rtol, NULL, 1e-13, 1.0, 0.0,
                  "tolerance of the solver; for model chain, the largest error estimate allowed, "
                  "as a share of the largest movement"),
    OPTION_NUMBER("--dt", "H", options.dt_s, "s", 1e-12, 1e6, 0.0,
                  "time step of the solvers rk4 and staggered"),
    OPTION_TEXT("--csv", "F.csv", csv_path,
                "write displacement and left-end height over time, for the mats in the scene key "
                "u_mats; default: all"),
    OPTION_NUMBER("--limit", "S", options.time_limit_s, "s", 1e-3, 1e7, 0.0,
                  "stop after S seconds and print the results so far; default: no limit"),
    HELP_NOTE("A long run prints its progress every 30 s. Ctrl-C stops it and prints the results "
              "so far (status interrupted, exit 5)."),
    HELP_EXAMPLE("matrig sim host/scenes/consistent_fig3_11_12000.json --csv mats.csv"),
};

const struct command command_sim = {
    "sim",
    sim_command,
    "SCENE [--solver S] [--rtol R] [--dt H] [--csv F] [--limit S]\n--keys",
    "simulate the mat described in a scene file",
    COMMAND_PARTS(parts),
    {0, 1, "SCENE"},
};
