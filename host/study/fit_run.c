/* The command matrig fit: estimates parameters of the runway from the landings of a campaign. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/commands/studies.h"
#include "host/base/answer.h"
#include "host/base/output.h"
#include "host/base/plot.h"
#include "host/base/quantity.h"
#include "host/base/data_dir.h"
#include "host/base/command.h"
#include "host/base/progress.h"
#include "host/base/xmalloc.h"
#include "host/study/fit/landings.h"

_Static_assert(ENSEMBLE_DRAWS_MIN == FIT_DRAWS_MIN, "the option and the fit have the same limit");

static void read_request(int argc, char **argv, const struct cli *cli, struct fit_request *request)
{
    command_parse(&command_fit, argc, argv, cli, request, request->words, fatal);
    if (!request->scene) {
        data_dir_find(DATA_RUNWAY_SCENE, request->model_runway, sizeof request->model_runway);
        request->scene = request->model_runway;
    }
    plot_check(request->plot, request->scene, fatal);
    if (request->plot && request->out_scene && strcmp(request->plot, request->out_scene) == 0)
        error_set(fatal, MR_USAGE, "same file for --plot and -o: %s; give two different files",
                  request->plot);
    output_check_new(request->out_scene, request->force, fatal);
    output_check(request->out_scene, request->scene, fatal);
}

static int find_fit_key(const char *option, const char *name, size_t length)
{
    for (int k = 0; k < FIT_KEYS; k++) {
        if (strlen(fit_parameter_names[k].key) == length &&
            strncmp(fit_parameter_names[k].key, name, length) == 0)
            return k;
    }
    error_set(fatal, MR_USAGE, "unknown parameter: '%.*s' for %s; give gap, grit, f, share, KL",
              (int)length, name, option);
    return 0;
}

/* Reads the names of the parameters to be fitted: "gap,f". The others keep the values of their
 * priors. */
static void set_fitted_keys(const char *text, struct fit_landings *list)
{
    for (int k = 0; k < FIT_KEYS && text; k++)
        list->parameter[k].is_fitted = false;
    while (text) {
        size_t length = strcspn(text, ",");
        list->parameter[find_fit_key("--fit", text, length)].is_fitted = true;
        text = text[length] == ',' ? text + length + 1 : NULL;
    }
}

/* Reads a value and its standard error, such as "=0.4mm:0.1mm", from the first `length`
 * characters. */
static bool read_prior(const char *text, size_t length, const char *unit, double *value,
                       double *spread)
{
    char word[80];
    struct quantity_error wrong;
    if (*text != '=' || length >= sizeof word)
        return false;
    snprintf(word, sizeof word, "%.*s", (int)length - 1, text + 1);
    char *colon = strchr(word, ':');
    if (!colon)
        return false;
    *colon = '\0';
    return quantity_parse(word, unit, NULL, value, &wrong) &&
           quantity_parse(colon + 1, unit, NULL, spread, &wrong) && *value > 0.0 && *spread > 0.0 &&
         *spread <= 3.0 * *value;
}

/* Reads the priors, values and standard errors: "f=0.5:0.02,KL=2.9e5:3e4". */
static void set_priors(const char *text, struct fit_landings *list)
{
    bool given[FIT_KEYS] = {false};
    while (text) {
        size_t length = strcspn(text, "=,"), whole = strcspn(text, ",");
        int key = find_fit_key("--prior", text, length);
        double value, spread;
        const char *unit = unit_get(fit_parameter_names[key].unit, false)->text;
        if (!read_prior(text + length, whole - length, unit, &value, &spread))
            error_set(fatal, MR_USAGE,
                      "not a prior: '%.*s'; give NAME=VALUE:ERROR, both above 0 and in %s, such as "
                      "f=0.5:0.02",
                      (int)whole, text, *unit ? unit : "no unit");
        if (given[key])
            error_set(fatal, MR_USAGE, "--prior gives %s twice; leave one out",
                      fit_parameter_names[key].key);
        given[key] = true;
        list->parameter[key].value = value;
        list->parameter[key].spread = spread / value;
        text = text[whole] == ',' ? text + whole + 1 : NULL;
    }
}

/* Adds all landings of the campaign. Landings without a known motion are skipped with a note. */
static void add_all_landings(struct store *store, const struct fit_request *request,
                             const struct cli *cli, struct fit_landings *list)
{
    struct store_landing *rows;
    size_t count;
    store_landings_get(store, &rows, &count, fatal);
    struct error last = {0};
    size_t left_out = 0;
    for (size_t i = 0; i < count; i++) {
        struct error why = {0};
        enum mr_status status = fit_campaign_add(store, rows[i].id, request->scene, list, &why);
        if (status == MR_TOO_FEW || status == MR_TRUNCATED) {
            last = why;
            left_out++;
        } else if (status != MR_OK) {
            error_set(fatal, status, "%s", why.text);
        }
    }
    free(rows);
    if (list->count == 0)
        error_set(fatal, left_out ? last.status : MR_TOO_FEW, "no landing to fit: %s: %s",
                  request->words[0],
                  left_out ? last.text
                           : "the campaign has no landing; log a landing with at least 3 switches, "
                             "a stop and a transducer");
    else if (left_out)
        cli_note(cli, "landings left out: %zu; reason for the last one: %s", left_out, last.text);
}

/* Adds the landings that the user named. Refuses a landing that is named twice, which would make
 * the computed error too small. */
static void add_named_landings(struct store *store, const struct fit_request *request,
                               struct fit_landings *list)
{
    int64_t runs[FIT_RUNS_MAX];
    for (size_t i = 0; i < FIT_RUNS_MAX && request->words[i + 1]; i++) {
        parse_run(request->words[i + 1], &runs[i], fatal);
        store_find_run(store, &runs[i], fatal);
        for (size_t k = 0; k < i; k++) {
            if (runs[k] == runs[i])
                error_set(fatal, MR_USAGE, "RUN %s is given twice; leave one out",
                          request->words[i + 1]);
        }
        fit_campaign_add(store, runs[i], request->scene, list, fatal);
    }
}

static void load_landings(const struct fit_request *request, const struct cli *cli,
                          struct fit_landings *list)
{
    struct sim_scene scene;
    struct store *store = program_open_campaign(request->words[0], STORE_OPEN);
    sim_scene_load(&scene, request->scene, fatal);
    fit_landings_begin(list, &scene);
    sim_scene_free(&scene);
    add_named_landings(store, request, list);
    if (!request->words[1])
        add_all_landings(store, request, cli, list);
    fit_campaign_set_gap(list);
    set_fitted_keys(request->fitted, list);
    set_priors(request->prior, list);
}

/* ---- output: an answer, a scene, a plot ---- */

#define NORMAL_95_QUANTILE 1.959963984540054
#define NEAREST_DRAWS      50u
#define PLOT_BAND_SIGMAS   1.96 /* half width of the plotted band, in standard deviations */

static void add_landings(struct answer *answer, const struct fit_landings *list)
{
    json_t *runs = json_array();
    for (size_t l = 0; l < list->count; l++) {
        const struct fit_landing *landing = &list->landing[l];
        size_t before = 0, after = 0;
        char run[32];
        for (size_t s = 0; s < MR_SEGMENTS; s++) {
            before += isnan(landing->survey_in[s]) ? 0 : 1;
            after += isnan(landing->survey_after_in[s]) ? 0 : 1;
        }
        snprintf(run, sizeof run, "RUN %lld", (long long)landing->run);
        answer_add_text(
            answer, NULL, run,
            "%zu transducers, %zu statistics, %zu segments surveyed before the landing (%zu from "
            "gage points), %zu segments after it%s",
            landing->channels, landing->window_count, before, landing->gage_segment_count, after,
            landing->is_consecutive ? "; the initial gaps are the gaps after the previous landing"
                                    : "");
        json_array_append_new(runs, json_integer(landing->run));
    }
    answer_add_json(answer, "runs", runs);
}

/* Adds each parameter in its own unit: estimate, 95 % interval, prior. */
static void add_parameters(struct answer *answer, const struct fit_landings *list,
                           const struct fit_result *fit, const struct misfit *misfit)
{
    enum fit_key key[FIT_KEYS];
    size_t count = fit_landings_list_keys(list, key);
    answer_open_table(answer, "parameters",
                      misfit->is_rejected
                          ? "parameters, with 95 % intervals (not reliable, see below)"
                          : "parameters, with 95 % intervals");
    for (size_t i = 0; i < count; i++) {
        const struct fit_parameter *p = &list->parameter[key[i]];
        const struct fit_parameter_name *name = &fit_parameter_names[key[i]];
        const struct unit *unit = unit_get(name->unit, answer_is_si(answer));
        const struct {
            const char *name, *label;
            double z;
        } values[] = {{"value", "value", fit->z[i]},
                      {"low", "from", fit->low[i]},
                      {"high", "to", fit->high[i]},
                      {"prior", NULL, 0.0},
                      {"prior_low", "prior|from", -NORMAL_95_QUANTILE},
                      {"prior_high", "prior|to", NORMAL_95_QUANTILE}};
        answer_open_row(answer);
        answer_add_text(answer, "name", NULL, "%s", name->key);
        answer_add_text(answer, NULL, "parameter", "%-5s %s", name->key, name->description);
        answer_add_text(answer, "unit", "unit", "%s", unit->text);
        for (size_t k = 0; k < sizeof values / sizeof values[0]; k++)
            answer_add_value(answer, values[k].name, values[k].label, UNIT_NUMBER,
                             unit->factor * p->value * exp(p->spread * values[k].z), -4);
        answer_add_value(answer, "error_of_prior", "error of|the prior", UNIT_NUMBER,
                         sqrt(fit->covariance[i][i]), 2)
            ->digits = 4;
    }
    answer_close_group(answer);
}

static double correlation(const struct fit_result *fit, size_t i, size_t k)
{
    return fit->covariance[i][k] / sqrt(fit->covariance[i][i] * fit->covariance[k][k]);
}

static void add_correlations(struct answer *answer, const struct fit_landings *list,
                             const struct fit_result *fit)
{
    enum fit_key key[FIT_KEYS];
    size_t count = fit_landings_list_keys(list, key);
    json_t *correlations = json_array();
    answer_open_table(answer, NULL, "correlation of the estimates");
    for (size_t i = 0; i < count; i++) {
        json_t *row = json_array();
        answer_open_row(answer);
        answer_add_text(answer, NULL, "of", "%s", fit_parameter_names[key[i]].key);
        for (size_t k = 0; k < count; k++) {
            answer_add_value(answer, NULL, fit_parameter_names[key[k]].key, UNIT_NUMBER,
                             correlation(fit, i, k), 2);
            json_array_append_new(row, cli_json_number(correlation(fit, i, k), 6));
        }
        json_array_append_new(correlations, row);
    }
    answer_close_group(answer);
    answer_add_json(answer, "correlation", correlations);
}

static void format_misfit(const struct misfit *misfit, char *text, size_t size)
{
    if (!misfit->is_checked)
        snprintf(text, size,
                 "the model was not checked, because only %zu data sets were simulated and the "
                 "check needs %u; narrow the priors",
                 misfit->replica_count, MISFIT_REPLICAS_MIN);
    else
        snprintf(text, size,
                 "the model %s describe the data: p = %.0f %% (share of simulated data sets that "
                 "fit no better than the measurements; a model is rejected at %.0f %% or below)",
                 misfit->is_rejected ? "cannot" : "can", 100.0 * misfit->p_value,
                 100.0 * MISFIT_LEVEL);
}

static void add_misfit(struct answer *answer, const struct fit_landings *list,
                       const struct misfit *misfit)
{
    char text[200];
    format_misfit(misfit, text, sizeof text);
    answer_add_sentence(answer, NULL, "%s", text);
    if (misfit->is_rejected)
        answer_add_sentence(answer, NULL,
                            "Do not use the intervals. Check transducers, dirt, gear path and "
                            "elastic ground where --plot shows large residuals");
    if (misfit->is_rejected && list->landing[0].has_earlier_landings)
        answer_add_sentence(answer, NULL,
                            "start the fit with the first landing, because earlier landings moved "
                            "the joints of RUN %lld",
                            (long long)list->landing[0].run);
    answer_open_group(answer, "misfit", NULL);
    answer_add_flag(answer, "checked", NULL, misfit->is_checked);
    answer_add_flag(answer, "cannot_be", NULL, misfit->is_rejected);
    answer_add_value(answer, "share", NULL, UNIT_NUMBER,
                     misfit->is_checked ? misfit->p_value : (double)NAN, 2);
    answer_add_value(answer, "false_alarms", NULL, UNIT_NUMBER, MISFIT_LEVEL, 2);
    answer_add_count(answer, "replicas", NULL, (int64_t)misfit->replica_count);
    answer_close_group(answer);
}

static struct answer *describe_fit(const struct fit_landings *list, const struct fit_result *fit,
                                   const struct misfit *misfit, bool si)
{
    struct answer *answer = answer_new(si);
    add_landings(answer, list);
    answer_add_count(answer, "simulated", "simulated", (int64_t)fit->simulated_draw_count);
    answer_append_remark(answer, " data sets in %u rounds%s", fit->round_count,
                         fit->failed_draw_count ? "; some data sets failed" : "");
    answer_add_count(answer, "rounds", NULL, fit->round_count);
    answer_add_flag(answer, "stopped", NULL, fit->has_not_converged);
    answer_add_flag(answer, "intervals_trusted", NULL, misfit->is_checked && !misfit->is_rejected);
    add_parameters(answer, list, fit, misfit);
    add_correlations(answer, list, fit);
    if (fit->has_not_converged)
        answer_add_sentence(answer, NULL,
                            "the fit did not converge in %u rounds: give narrower priors",
                            fit->round_count);
    add_misfit(answer, list, misfit);
    return answer;
}

static json_t *path_to_json(const struct fit_landing *landing, double share)
{
    json_t *path = json_array();
    for (size_t i = 0; i < landing->scene.path_count; i++) {
        const struct sim_path_row *row = &landing->scene.path[i];
        json_array_append_new(path, json_pack("[ooo]", cli_json_number(row->t_s, 9),
                                              cli_json_number(row->x_ft, 9),
                                              cli_json_number(share * row->force_lb, 9)));
    }
    return path;
}

static json_t *list_to_json(const struct sim_list *list)
{
    json_t *values = json_array();
    for (size_t i = 0; i < list->count; i++)
        json_array_append_new(values, cli_json_number(list->values[i], 6));
    return values;
}

/* Finds the draw whose statistics are nearest to the measured ones, among NEAREST_DRAWS draws at
 * the estimate. Returns its number. */
static uint64_t find_nearest_draw(const struct fit_landings *list, const struct fit_result *answer)
{
    struct fit_model model = fit_landings_model(list);
    double *statistic = xcalloc(FIT_BATCH_MAX * list->statistics, sizeof *statistic),
           z[FIT_BATCH_MAX * FIT_PARAMETERS_MAX], least = (double)INFINITY;
    uint64_t best = 1, draw[FIT_BATCH_MAX];
    bool good[FIT_BATCH_MAX];
    for (uint64_t first = 1; first <= NEAREST_DRAWS; first += FIT_BATCH_MAX) {
        size_t count = NEAREST_DRAWS + 1 - first < FIT_BATCH_MAX ? NEAREST_DRAWS + 1 - first
                                                                 : FIT_BATCH_MAX;
        for (size_t i = 0; i < count; i++) {
            draw[i] = first + i;
            memcpy(z + i * model.parameter_count, answer->z, model.parameter_count * sizeof *z);
        }
        model.simulate(model.context, count, z, draw, statistic, good);
        for (size_t i = 0; i < count; i++) {
            double squares = good[i] ? 0.0 : (double)INFINITY;
            for (size_t s = 0; s < list->statistics; s++)
                squares += pow((statistic[i * list->statistics + s] - list->measured[s]) /
                                   answer->scatter[s],
                               2.0);
            if (squares < least) {
                least = squares;
                best = draw[i];
            }
        }
    }
    free(statistic);
    return best;
}

static void set_scene_values(json_t *scene, const struct fit_landings *list,
                             const double value[FIT_KEYS], const struct sim_scene *joints,
                             double share)
{
    char note[240];
    snprintf(note, sizeof note,
             "matrig fit determined f, KL, gap0, grit and the thrust in path from RUN %lld: mean "
             "gap %.4g in, mean resistance %.4g lb, share %.4g. Of %u draws of the joints, these "
             "values fit the measurements best",
             (long long)list->landing[0].run, value[FIT_GAP], value[FIT_GRIT],
             value[FIT_THRUST_SHARE], NEAREST_DRAWS);
    json_object_set_new(scene, "_fit", json_string(note));
    json_object_set_new(scene, "gap0", list_to_json(&joints->gap0_ft));
    json_object_set_new(scene, "grit", list_to_json(&joints->grit_lb));
    json_object_set_new(scene, "f", cli_json_number(value[FIT_FRICTION], 6));
    json_object_set_new(scene, "KL", cli_json_number(value[FIT_STIFFNESS], 6));
    json_object_set_new(scene, "path", path_to_json(&list->landing[0], share));
}

/* Writes a scene with the fitted values, and with the path and thrust of the first landing. The
 * joints are those of the draw nearest to the measurement. Equal joints would not do: they would
 * hardly move, because a landing closes the weakest joints first. */
static enum mr_status fit_write_scene(const struct fit_landings *list,
                                      const struct fit_result *answer, const char *from,
                                      const char *path, struct error *error)
{
    json_error_t where;
    double value[FIT_KEYS], share;
    struct sim_scene joints;
    json_t *scene = json_load_file(from, 0, &where);
    if (!scene)
        return error_set(error, MR_IO,
                         "cannot read the scene again: %s; check that the file exists", from);
    sim_scene_set_defaults(&joints);
    joints.mats = list->landing[0].scene.mats;
    fit_landings_values(list, answer->z, value);
    fit_landings_sample_joints(list, answer->z, find_nearest_draw(list, answer), &joints, &share);
    set_scene_values(scene, list, value, &joints, share);
    output_write_json(path, scene, 9, error);
    sim_scene_free(&joints);
    json_decref(scene);
    return error->status;
}

static double window_station_ft(const struct fit_landing *landing, const struct fit_window *window)
{
    return window->channel != SIZE_MAX
             ? landing->channel[window->channel].station_ft
             : ((double)window->segment + 0.5) * (double)MR_SEGMENT_LENGTH_FT;
}

/* Plots the residual of each statistic, in standard deviations, over the station. */
static enum mr_status fit_write_plot(const struct fit_landings *list,
                                     const struct fit_result *answer, const struct misfit *misfit,
                                     const char *path, struct error *error)
{
    char text[200], key[60];
    double *station_ft = xcalloc(2 * list->statistics, sizeof *station_ft),
           *residual = station_ft + list->statistics;
    const double limits[] = {-PLOT_BAND_SIGMAS, PLOT_BAND_SIGMAS};
    format_misfit(misfit, text, sizeof text);
    struct plot *plot = plot_new("residuals of a fit", 900, 420, 1);
    plot_begin_panel(plot, text, (struct plot_axis){.label = "station (ft)"},
                     (struct plot_axis){.label = "(measured - expected) / standard deviation"});
    for (size_t l = 0; l < list->count; l++) {
        const struct fit_landing *landing = &list->landing[l];
        for (int sums = 0; sums < 2; sums++) {
            size_t count = 0;
            for (size_t w = 0; w < landing->window_count; w++) {
                size_t s = landing->first_statistic + w;
                if ((landing->window[w].channel == SIZE_MAX) != sums)
                    continue;
                station_ft[count] = window_station_ft(landing, &landing->window[w]);
                residual[count++] = (list->measured[s] - answer->expected[s]) / answer->scatter[s];
            }
            snprintf(key, sizeof key, "RUN %lld, %s", (long long)landing->run,
                     sums ? "sums of gaps after" : "movements");
            plot_add_series(plot, &(struct plot_series){.kind = PLOT_POINTS,
                                                        .key = key,
                                                        .colour = (unsigned)l,
                                                        .shape = (unsigned)l,
                                                        .is_hollow = sums,
                                                        .x = station_ft,
                                                        .y = residual,
                                                        .count = count});
        }
    }
    plot_add_series(plot, &(struct plot_series){.kind = PLOT_HORIZONTAL_LINES,
                                                .key = "95 % of data sets",
                                                .colour = PLOT_GREY,
                                                .is_dashed = true,
                                                .x = limits,
                                                .y = limits,
                                                .count = 2});
    free(station_ft);
    return plot_write(plot, path, error);
}

static void show_progress(void *progress, unsigned round, size_t done, size_t total)
{
    progress_set(progress, "round %u: %zu of %zu data sets done", round + 1, done, total);
}

int fit_command(int argc, char **argv, const struct cli *cli)
{
    struct fit_request request = {0};
    struct fit_landings list = {0};
    struct fit_result answer = {0};
    struct misfit misfit = {0};
    struct error error = {0};
    struct progress progress;
    read_request(argc, argv, cli, &request);
    load_landings(&request, cli, &list);
    struct fit_model model = fit_landings_model(&list);
    struct fit_options options = {.draw_count = (size_t)request.draws,
                                  .seed = (uint64_t)request.seed,
                                  .progress = show_progress,
                                  .progress_context = &progress};
    progress_begin(&progress, "fit", "fewer --draws", cli->quiet);
    if (fit_run(&model, list.measured, &options, &answer, &error) == MR_OK)
        misfit = misfit_check(&list, &answer, (uint64_t)request.seed);
    progress_end(&progress);
    if (error.status != MR_OK)
        return cli_fail(&error);
    if (request.plot)
        fit_write_plot(&list, &answer, &misfit, request.plot, fatal);
    if (request.out_scene)
        fit_write_scene(&list, &answer, request.scene, request.out_scene, fatal);
    int exit_code = answer_print(cli, describe_fit(&list, &answer, &misfit, cli->si),
                                 misfit.is_rejected ? 1 : 0);
    fit_free(&answer);
    fit_landings_free(&list);
    return exit_code;
}
