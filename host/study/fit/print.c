#include "host/study/fit/print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/base/cli.h"
#include "host/base/output.h"
#include "host/base/plot.h"
#include "host/base/xmalloc.h"

#define NORMAL_95  1.959963984540054
#define IN_PER_FT  12.0
#define NEAREST_OF 50u
#define LIMIT      1.96 /* of the plot's band, in standard deviations */

/* A parameter in its own unit: estimate, 95 % interval, prior. */
struct fit_row {
    enum fit_key key;
    double value, low, high;
    double prior, prior_low, prior_high; /* 95 % */
    double narrowed;                     /* standard error, as a share of the prior's */
};

/* Factor and unit shown. */
static double shown_unit(enum fit_key key, bool si, const char **unit)
{
    static const struct {
        const char *unit;
        double factor;
    } metric[FIT_KEYS] = {[FIT_GAP] = {"mm", 25.4},
                          [FIT_GRIT] = {"N", 4.4482216152605},
                          [FIT_FRICTION] = {"", 1.0},
                          [FIT_SHARE] = {"", 1.0},
                          [FIT_STIFFNESS] = {"N/m", 14.593902937206}};
    *unit = si ? metric[key].unit : fit_names[key].unit;
    return si ? metric[key].factor : 1.0;
}

static size_t fit_rows(const struct fit_landings *list, const struct fit_answer *answer,
                       struct fit_row row[FIT_KEYS])
{
    enum fit_key key[FIT_KEYS];
    size_t count = fit_landings_fitted(list, key);
    for (size_t i = 0; i < count; i++) {
        const struct fit_parameter *p = &list->parameter[key[i]];
        row[i] = (struct fit_row){
            .key = key[i],
            .value = p->value * exp(p->spread * answer->z[i]),
            .low = p->value * exp(p->spread * answer->low[i]),
            .high = p->value * exp(p->spread * answer->high[i]),
            .prior = p->value,
            .prior_low = p->value * exp(-p->spread * NORMAL_95),
            .prior_high = p->value * exp(p->spread * NORMAL_95),
            .narrowed = sqrt(answer->covariance[i][i]),
        };
    }
    return count;
}

static void add_landings(struct answer *answer, const struct fit_landings *list)
{
    json_t *runs = json_array();
    for (size_t l = 0; l < list->count; l++) {
        const struct fit_landing *landing = &list->landing[l];
        size_t before = 0, after = 0;
        char run[32];
        for (size_t s = 0; s < MR_SEGMENTS; s++) {
            before += isnan(landing->survey_in[s]) ? 0 : 1;
            after += isnan(landing->after_in[s]) ? 0 : 1;
        }
        snprintf(run, sizeof run, "RUN %lld", (long long)landing->run);
        answer_words(answer, NULL, run,
                     "%zu transducers, %zu statistics, %zu segments surveyed before (%zu by gage "
                     "points), %zu after%s",
                     landing->channels, landing->windows, before, landing->gages, after,
                     landing->follows ? "; gaps as the landing before left them" : "");
        json_array_append_new(runs, json_integer(landing->run));
    }
    answer_json_value(answer, "runs", runs);
}

static void add_parameters(struct answer *answer, const struct fit_landings *list,
                           const struct fit_answer *fit, const struct misfit *misfit, bool si)
{
    struct fit_row row[FIT_KEYS];
    size_t count = fit_rows(list, fit, row);
    answer_table(answer, "parameters",
                 misfit->cannot ? "parameters, with 95 % intervals that are not to be trusted"
                                : "parameters, with 95 % intervals");
    for (size_t i = 0; i < count; i++) {
        const char *unit;
        double factor = shown_unit(row[i].key, si, &unit);
        answer_row(answer);
        answer_words(answer, "name", NULL, "%s", fit_names[row[i].key].key);
        answer_words(answer, NULL, "parameter", "%-5s %s", fit_names[row[i].key].key,
                     fit_names[row[i].key].words);
        answer_words(answer, "unit", "unit", "%s", unit);
        answer_value(answer, "value", "value", UNIT_NUMBER, factor * row[i].value, -4);
        answer_value(answer, "low", "from", UNIT_NUMBER, factor * row[i].low, -4);
        answer_value(answer, "high", "to", UNIT_NUMBER, factor * row[i].high, -4);
        answer_value(answer, "prior", NULL, UNIT_NUMBER, factor * row[i].prior, -4);
        answer_value(answer, "prior_low", "prior|from", UNIT_NUMBER, factor * row[i].prior_low, -4);
        answer_value(answer, "prior_high", "prior|to", UNIT_NUMBER, factor * row[i].prior_high, -4);
        answer_value(answer, "error_of_prior", "error, of|the prior's", UNIT_NUMBER,
                     row[i].narrowed, 2)
            ->digits = 4;
        answer_value(answer, "bias_of_prior", NULL, UNIT_NUMBER, fit->bias[i], 2)->digits = 4;
    }
    answer_close(answer);
}

static double correlation(const struct fit_answer *fit, size_t i, size_t k)
{
    return fit->covariance[i][k] / sqrt(fit->covariance[i][i] * fit->covariance[k][k]);
}

static void add_correlations(struct answer *answer, const struct fit_landings *list,
                             const struct fit_answer *fit)
{
    enum fit_key key[FIT_KEYS];
    size_t count = fit_landings_fitted(list, key);
    json_t *correlations = json_array(), *informations = json_array();
    answer_table(answer, NULL, "correlation of the estimates");
    for (size_t i = 0; i < count; i++) {
        json_t *row = json_array(), *information = json_array();
        answer_row(answer);
        answer_words(answer, NULL, "of", "%s", fit_names[key[i]].key);
        for (size_t k = 0; k < count; k++) {
            answer_value(answer, NULL, fit_names[key[k]].key, UNIT_NUMBER, correlation(fit, i, k),
                         2);
            json_array_append_new(row, cli_json_number(correlation(fit, i, k), 6));
            json_array_append_new(information, cli_json_number(fit->information[i][k], 6));
        }
        json_array_append_new(correlations, row);
        json_array_append_new(informations, information);
    }
    answer_close(answer);
    answer_json_value(answer, "correlation", correlations);
    answer_json_value(answer, "information", informations);
}

static void add_residuals(struct answer *answer, const struct fit_landings *list,
                          const struct fit_answer *fit)
{
    answer_list(answer, "residuals", NULL);
    for (size_t l = 0; l < list->count; l++) {
        const struct fit_landing *landing = &list->landing[l];
        for (size_t w = 0; w < landing->windows; w++) {
            const struct fit_window *window = &landing->window[w];
            size_t s = landing->first + w;
            answer_row(answer);
            answer_count(answer, "run", NULL, landing->run);
            answer_words(answer, "statistic", NULL, "%s", window->name);
            answer_value(answer, "measured", NULL, UNIT_NUMBER, list->measured[s], 3);
            answer_value(answer, "expected", NULL, UNIT_NUMBER, fit->expected[s], 3);
            answer_value(answer, "standard_deviation", NULL, UNIT_NUMBER, fit->scatter[s], 3)
                ->digits = 4;
            if (window->channel != SIZE_MAX)
                answer_count(answer, "transducer", NULL, landing->channel[window->channel].number);
        }
    }
    answer_close(answer);
}

static void misfit_text(const struct misfit *misfit, char *text, size_t size)
{
    if (!misfit->checked)
        snprintf(text, size,
                 "the model was not checked: %zu replicated data sets, %u are needed; allow more "
                 "time",
                 misfit->replicas, MISFIT_LEAST);
    else
        snprintf(text, size,
                 "the model %s describe the data: %.0f %% of replicated data sets are as far from "
                 "it (%.0f %% or less: it cannot)",
                 misfit->cannot ? "cannot" : "can", 100.0 * misfit->share, 100.0 * MISFIT_FALSE);
}

static void add_misfit(struct answer *answer, const struct fit_landings *list,
                       const struct misfit *misfit)
{
    char text[200];
    misfit_text(misfit, text, sizeof text);
    answer_sentence(answer, NULL, "%s", text);
    if (misfit->cannot)
        answer_sentence(answer, NULL,
                        "Do not trust the intervals. --plot shows where the residuals are large: "
                        "check the transducers, dirt, the gear's way and elastic ground there");
    if (misfit->cannot && list->landing[0].later)
        answer_sentence(answer, NULL,
                        "RUN %lld began on joints that earlier landings had moved: fit from the "
                        "first landing on",
                        (long long)list->landing[0].run);
    answer_open(answer, "misfit", NULL);
    answer_flag(answer, "checked", NULL, misfit->checked);
    answer_flag(answer, "cannot_be", NULL, misfit->cannot);
    answer_value(answer, "share", NULL, UNIT_NUMBER, misfit->checked ? misfit->share : (double)NAN,
                 2);
    answer_value(answer, "false_alarms", NULL, UNIT_NUMBER, MISFIT_FALSE, 2);
    answer_count(answer, "replicas", NULL, (int64_t)misfit->replicas);
    answer_close(answer);
}

struct answer *fit_described(const struct fit_landings *list, const struct fit_answer *fit,
                             const struct misfit *misfit, bool si)
{
    struct answer *answer = answer_new(si);
    add_landings(answer, list);
    answer_count(answer, "simulated", "simulated", (int64_t)fit->simulated);
    answer_remark(answer, " data sets in %u rounds%s", fit->rounds,
                  fit->failed ? ", of which some failed" : "");
    answer_count(answer, "rounds", NULL, fit->rounds);
    answer_flag(answer, "stopped", NULL, fit->stopped);
    answer_flag(answer, "intervals_trusted", NULL, misfit->checked && !misfit->cannot);
    add_parameters(answer, list, fit, misfit, si);
    add_correlations(answer, list, fit);
    if (fit->stopped)
        answer_sentence(answer, NULL,
                        "the estimate did not settle in %u rounds: allow more time, or narrower "
                        "priors",
                        fit->rounds);
    add_misfit(answer, list, misfit);
    add_residuals(answer, list, fit);
    return answer;
}

static json_t *path_json(const struct fit_landing *landing, double share)
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

static json_t *list_json(const struct sim_list *list)
{
    json_t *values = json_array();
    for (size_t i = 0; i < list->count; i++)
        json_array_append_new(values, cli_json_number(list->values[i], 6));
    return values;
}

/* Of NEAREST_OF draws at the estimate the one whose statistics lie nearest to the measured ones. */
static uint64_t nearest(const struct fit_landings *list, const struct fit_answer *answer)
{
    struct fit_model model = fit_landings_model(list);
    double *statistic = xcalloc(list->statistics, sizeof *statistic), least = (double)INFINITY;
    uint64_t best = 1;
    for (uint64_t draw = 1; draw <= NEAREST_OF; draw++) {
        double squares = 0.0;
        if (!model.simulate(model.context, answer->z, draw, statistic))
            continue;
        for (size_t s = 0; s < list->statistics; s++)
            squares += pow((statistic[s] - list->measured[s]) / answer->scatter[s], 2.0);
        if (squares < least) {
            least = squares;
            best = draw;
        }
    }
    free(statistic);
    return best;
}

static void set_scene(json_t *scene, const struct fit_landings *list, const double value[FIT_KEYS],
                      const struct sim_scene *joints, double share)
{
    char note[240];
    snprintf(note, sizeof note,
             "f, KL, gap0, grit and the thrust in path by matrig fit, RUN %lld: mean gap %.4g in, "
             "mean resistance %.4g lb, share %.4g; "
             "of %u draws of the joints this one comes nearest to what was measured",
             (long long)list->landing[0].run, value[FIT_GAP], value[FIT_GRIT], value[FIT_SHARE],
             NEAREST_OF);
    json_object_set_new(scene, "_fit", json_string(note));
    json_object_set_new(scene, "gap0", list_json(&joints->gap0_ft));
    json_object_set_new(scene, "grit", list_json(&joints->grit_lb));
    json_object_set_new(scene, "f", cli_json_number(value[FIT_FRICTION], 6));
    json_object_set_new(scene, "KL", cli_json_number(value[FIT_STIFFNESS], 6));
    json_object_set_new(scene, "path", path_json(&list->landing[0], share));
}

enum mr_status fit_write_scene(const struct fit_landings *list, const struct fit_answer *answer,
                               const char *from, const char *path, struct error *error)
{
    json_error_t where;
    double value[FIT_KEYS], share;
    struct sim_scene joints;
    json_t *scene = json_load_file(from, 0, &where);
    if (!scene)
        return error_set(error, MR_IO, "cannot read the scene again: %s; is it still there?", from);
    sim_scene_defaults(&joints);
    joints.mats = list->landing[0].scene.mats;
    fit_landings_values(list, answer->z, value);
    fit_landings_joints(list, answer->z, nearest(list, answer), &joints, &share);
    set_scene(scene, list, value, &joints, share);
    struct output output;
    if (output_begin(&output, path, error) == MR_OK) {
        json_dumpf(scene, output.file, JSON_INDENT(1) | JSON_REAL_PRECISION(9));
        fputc('\n', output.file);
        output_end(&output, error);
    }
    sim_scene_free(&joints);
    json_decref(scene);
    return error->status;
}

static double station_of(const struct fit_landing *landing, const struct fit_window *window)
{
    return window->channel != SIZE_MAX
             ? landing->channel[window->channel].station_ft
             : ((double)window->segment + 0.5) * (double)MR_SEGMENT_LENGTH_FT;
}

enum mr_status fit_write_plot(const struct fit_landings *list, const struct fit_answer *answer,
                              const struct misfit *misfit, const char *path, struct error *error)
{
    char text[200], key[60];
    double *station_ft = xcalloc(2 * list->statistics, sizeof *station_ft),
           *residual = station_ft + list->statistics;
    const double limits[] = {-LIMIT, LIMIT};
    misfit_text(misfit, text, sizeof text);
    struct plot *plot = plot_new("residuals of a fit", 900, 420, 1);
    plot_panel(plot, text, (struct plot_axis){.label = "station (ft)"},
               (struct plot_axis){.label = "(measured - expected) / standard deviation"});
    for (size_t l = 0; l < list->count; l++) {
        const struct fit_landing *landing = &list->landing[l];
        for (int sums = 0; sums < 2; sums++) {
            size_t count = 0;
            for (size_t w = 0; w < landing->windows; w++) {
                size_t s = landing->first + w;
                if ((landing->window[w].channel == SIZE_MAX) != sums)
                    continue;
                station_ft[count] = station_of(landing, &landing->window[w]);
                residual[count++] = (list->measured[s] - answer->expected[s]) / answer->scatter[s];
            }
            snprintf(key, sizeof key, "RUN %lld, %s", (long long)landing->run,
                     sums ? "sums of gaps after" : "movements");
            plot_draw(plot, &(struct plot_series){.kind = PLOT_POINTS,
                                                  .key = key,
                                                  .colour = (unsigned)l,
                                                  .shape = (unsigned)l,
                                                  .open = sums,
                                                  .x = station_ft,
                                                  .y = residual,
                                                  .count = count});
        }
    }
    plot_draw(plot, &(struct plot_series){.kind = PLOT_LEVELS,
                                          .key = "95 % of data sets",
                                          .colour = PLOT_GREY,
                                          .dashed = true,
                                          .x = limits,
                                          .y = limits,
                                          .count = 2});
    free(station_ft);
    return plot_write(plot, path, error);
}
