/* matrig compare: measured against simulated, per transducer. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/cli.h"
#include "host/compare.h"
#include "host/link/link.h"
#include "host/place.h"
#include "host/run.h"
#include "host/store/store_journal.h"
#include "host/units.h"


static double scaled(double value_in, bool si)
{
    return value_in * unit_of(UNIT_DISPLACEMENT, si)->factor;
}

/* As printed with four decimals. */
static double shown(double value_in, bool si)
{
    return unit_tidy(scaled(value_in, si), 1e-4);
}

static void print_comparison(const struct comparison *comparison, int64_t run, const char *scene, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    const struct unit *station = unit_of(UNIT_STATION, si);
    printf("RUN %lld against %s: simulated in %.0f ms, its own error estimate %.4f %s; %zu of %u segments "
           "surveyed\n",
           (long long)run, scene, comparison->run_ms, shown(comparison->error_in, si), length->text,
           comparison->surveyed, MR_SEGMENTS);
    printf("  transducer   station      peak measured     peak simulated          rms   end measured  "
           "simulated  difference, %s\n",
           length->text);
    for (size_t i = 0; i < comparison->count; i++) {
        const struct store_simulation *row = &comparison->row[i];
        printf("  %10lld %6.1f %2s  %8.4f +- %.4f  %8.4f +- %.4f  %11.4f  %13.4f  %9.4f  %10.4f\n",
               (long long)row->number, row->station_ft * station->factor, station->text,
               shown(row->peak_measured_in, si), shown(row->peak_measured_error_in, si),
               shown(row->peak_simulated_in, si), shown(row->peak_simulated_error_in, si),
               shown(row->rms_in, si), shown(row->end_measured_in, si), shown(row->end_simulated_in, si),
               shown(row->end_measured_in - row->end_simulated_in, si));
    }
}

static json_t *comparison_json(const struct comparison *comparison, int64_t run, const char *scene, bool si)
{
    const char *unit = unit_of(UNIT_DISPLACEMENT, si)->suffix;
    json_t *channels = json_array();
    for (size_t i = 0; i < comparison->count; i++) {
        const struct store_simulation *row = &comparison->row[i];
        const struct {
            const char *name;
            double value_in;
        } values[] = {
            {"peak_measured", row->peak_measured_in},
            {"peak_measured_error", row->peak_measured_error_in},
            {"peak_simulated", row->peak_simulated_in},
            {"peak_simulated_error", row->peak_simulated_error_in},
            {"rms", row->rms_in},
            {"end_measured", row->end_measured_in},
            {"end_simulated", row->end_simulated_in},
            {"end_difference", row->end_measured_in - row->end_simulated_in},
        };
        json_t *channel = json_pack("{sI}", "number", (json_int_t)row->number);
        const struct unit *station = unit_of(UNIT_STATION, si);
        char key[60];
        snprintf(key, sizeof key, "station_%s", station->suffix);
        json_object_set_new(channel, key, cli_json_number(row->station_ft * station->factor, 9));
        for (size_t v = 0; v < sizeof values / sizeof values[0]; v++) {
            snprintf(key, sizeof key, "%s_%s", values[v].name, unit);
            json_object_set_new(channel, key, cli_json_number(scaled(values[v].value_in, si), 6));
        }
        json_array_append_new(channels, channel);
    }
    json_t *object =
        json_pack("{sIsssi}", "run", (json_int_t)run, "scene", scene, "surveyed", (int)comparison->surveyed);
    json_object_set_new(object, "run_ms", cli_json_number(comparison->run_ms, 6));
    json_object_set_new(object, "channels", channels);
    return object;
}

/* Keeps the comparison in the database; it replaces no earlier one. */
static enum mr_status keep(struct store *store, int64_t run, const struct comparison *comparison,
                           struct error *error)
{
    enum mr_status status = store_begin(store, error);
    if (status == MR_OK)
        status = store_simulation_put(store, run, comparison->scene_json, (int64_t)link_now_us(),
                                      comparison->row, comparison->count, error);
    return status == MR_OK ? store_commit(store, error) : status;
}

static enum mr_status check_limit(const struct comparison *comparison, int64_t run, double limit_in,
                                  struct error *error)
{
    const struct store_simulation *worst = &comparison->row[0];
    for (size_t i = 1; i < comparison->count; i++) {
        if (!(comparison->row[i].rms_in <= worst->rms_in))
            worst = &comparison->row[i];
    }
    if (worst->rms_in <= limit_in)
        return MR_OK;
    return error_set(error, MR_LIMIT,
                     "rms difference %.4f in exceeds %.4f in: transducer %lld of RUN %lld; see the table, or "
                     "raise --limit",
                     worst->rms_in, limit_in, (long long)worst->number, (long long)run);
}

static enum mr_status compare(struct store *store, int64_t run, struct sim_scene *scene,
                              struct comparison *comparison, struct error *error)
{
    struct measured measured;
    struct zones_closure survey;
    enum mr_status status = measured_load(store, run, &measured, error);
    if (status == MR_OK)
        status = zones_load_survey(store, run, &survey, error);
    if (status == MR_OK)
        status = compare_scene(&measured, &survey, scene, error);
    if (status == MR_OK)
        status = compare_run(&measured, scene, comparison, error);
    if (status == MR_OK) {
        comparison->surveyed = survey.surveyed;
        status = keep(store, run, comparison, error);
    }
    measured_free(&measured);
    return status;
}

int compare_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2] = {NULL, NULL}, *scene_path = NULL, *limit_text = NULL;
    bool voided = false;
    const struct cli_option options[] = {{"--scene", &scene_path, NULL}, {"--limit", &limit_text, NULL}, {"--void", NULL, &voided}};
    char model_runway[500];
    struct error error = {0};
    struct store *store = NULL;
    struct sim_scene scene;
    struct comparison comparison = {.count = 0};
    int64_t run = 0;
    double limit_in = (double)INFINITY;
    enum mr_status status = cli_parse(argc, argv, options, 3, words, 2, 2, "DB RUN", &error);
    if (status == MR_OK)
        status = run_parse(words[1], &run, &error);
    if (status == MR_OK && limit_text)
        status = cli_number(limit_text, "--limit", 0.0, 1e6, &limit_in, &error);
    if (status == MR_OK)
        status = store_open(words[0], STORE_OPEN, &store, &error);
    if (status == MR_OK)
        status = store_refuse_void(store, run, voided, &error);
    if (status == MR_OK && !scene_path) {
        place_find(PLACE_RUNWAY, model_runway, sizeof model_runway);
        scene_path = model_runway;
    }
    if (status == MR_OK)
        status = sim_scene_load(&scene, scene_path, &error);
    if (status == MR_OK) {
        status = compare(store, run, &scene, &comparison, &error);
        sim_scene_free(&scene);
    }
    store_close(store);
    int exit_code = 0;
    if (status == MR_OK) {
        const char *name = strrchr(scene_path, '/') ? strrchr(scene_path, '/') + 1 : scene_path;
        check_limit(&comparison, run, limit_in, &error);
        if (cli->json)
            exit_code = cli_print_json(comparison_json(&comparison, run, name, cli->si), 0);
        else
            print_comparison(&comparison, run, name, cli->si);
    }
    compare_free(&comparison);
    return error.status != MR_OK ? cli_fail(&error) : exit_code;
}
