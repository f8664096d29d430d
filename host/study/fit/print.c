#include "host/study/fit/print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/cli.h"
#include "host/study/fit/verdict.h"
#include "host/base/output.h"

#define NORMAL_95     1.959963984540054
#define IN_PER_FT     12.0
#define TEXT_SIZE     400
#define POOR_FIT      0.05
#define NEAREST_OF    50u
#define FARTHEST      3   /* statistics that a poor fit names, */
#define FARTHEST_FROM 2.5 /* standard deviations and more away */

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

/* "f x share^-0.98": of two, what stays the same along a direction in which the data say
 * nothing. */
static void determined(const struct fit_landings *list, const enum fit_key *key,
                       const double *direction, char *text, size_t size)
{
    size_t member[2], count = 0;
    for (size_t i = 0; i < FIT_PARAMETERS_MAX && count < 2; i++) {
        if (direction[i] * direction[i] >= VERDICT_MEMBER)
            member[count++] = i;
    }
    double first = list->parameter[key[member[0]]].spread * direction[member[0]];
    double second = list->parameter[key[member[1]]].spread * direction[member[1]];
    snprintf(text, size, "; what they tell is %s x %s^%.2g", fit_names[key[member[0]]].key,
             fit_names[key[member[1]]].key, -first / second);
}

static void confounded_text(const struct fit_landings *list, const enum fit_key *key,
                            const struct fit_confounded *found, char *text)
{
    unsigned named = 0;
    char same[80] = "";
    size_t length = (size_t)snprintf(text, TEXT_SIZE, "the data cannot tell ");
    for (size_t i = 0; i < FIT_PARAMETERS_MAX && length < TEXT_SIZE; i++) {
        if (found->direction[i] * found->direction[i] < VERDICT_MEMBER)
            continue;
        named++;
        length += (size_t)snprintf(text + length, TEXT_SIZE - length, "%s%s",
                                   named == 1   ? ""
                                   : named == 2 ? " from "
                                                : " and ",
                                   fit_names[key[i]].key);
    }
    if (found->members == 2)
        determined(list, key, found->direction, same, sizeof same);
    length += length < TEXT_SIZE
                ? (size_t)snprintf(text + length, TEXT_SIZE - length, "%s (together by", same)
                : 0;
    for (size_t i = 0; i < FIT_PARAMETERS_MAX && length < TEXT_SIZE; i++) {
        if (found->direction[i] * found->direction[i] >= VERDICT_MEMBER)
            length += (size_t)snprintf(
                text + length, TEXT_SIZE - length, " %s %+.0f %%", fit_names[key[i]].key,
                100.0 * (exp(list->parameter[key[i]].spread * found->direction[i]) - 1.0));
    }
    if (length < TEXT_SIZE)
        snprintf(text + length, TEXT_SIZE - length, ": misfit +%.1f, %.2f would show)",
                 fmax(found->rise, 0.0), VERDICT_LIMIT);
}

static double away(const struct fit_landings *list, const struct fit_answer *answer,
                   size_t statistic)
{
    return (list->measured[statistic] - answer->expected[statistic]) / answer->scatter[statistic];
}

/* The farthest statistic that is nearer than `below`; false: none is far. */
static bool next_farthest(const struct fit_landings *list, const struct fit_answer *answer,
                          double below, size_t *landing, size_t *window)
{
    double most = FARTHEST_FROM;
    bool found = false;
    for (size_t l = 0; l < list->count; l++) {
        for (size_t w = 0; w < list->landing[l].windows; w++) {
            double far = fabs(away(list, answer, list->landing[l].first + w));
            if (!(far >= most && far < below))
                continue;
            most = far;
            *landing = l;
            *window = w;
            found = true;
        }
    }
    return found;
}

/* "RUN 2, transducer 6 at 90 ft, end: 0.024 in, expected 0.118 (-5.1)". */
static void where_it_fails(const struct fit_landings *list, const struct fit_answer *answer,
                           char *text)
{
    double below = HUGE_VAL;
    size_t l = 0, w = 0,
           length = (size_t)snprintf(text, TEXT_SIZE, "farthest off (in standard deviations):");
    for (int i = 0;
         i < FARTHEST && next_farthest(list, answer, below, &l, &w) && length < TEXT_SIZE; i++) {
        const struct fit_landing *landing = &list->landing[l];
        const struct fit_window *window = &landing->window[w];
        size_t s = landing->first + w;
        bool transducer = window->channel != SIZE_MAX;
        char place[60];
        if (transducer)
            snprintf(place, sizeof place, "transducer %lld at %g ft",
                     (long long)landing->channel[window->channel].number,
                     landing->channel[window->channel].station_ft);
        else
            snprintf(place, sizeof place, "segment %zu", window->segment + 1);
        below = fabs(away(list, answer, s));
        length += (size_t)snprintf(
            text + length, TEXT_SIZE - length, "%s RUN %lld %s, %s: %.3f in, expected %.3f (%+.1f)",
            i ? ";" : "", (long long)landing->run, place, window->name,
            transducer ? fit_movement_in(list->measured[s]) : list->measured[s],
            transducer ? fit_movement_in(answer->expected[s]) : answer->expected[s],
            away(list, answer, s));
    }
}

/* Why a fit may be poor that the data do not say. */
static size_t poor_fit(const struct fit_landings *list, const struct fit_answer *answer,
                       char *text[3])
{
    char line[TEXT_SIZE];
    size_t lines = 0, l, w;
    if (answer->fits < POOR_FIT) {
        snprintf(line, sizeof line,
                 "the model does not fit: only %.1f %% of simulated data sets lie further from it; "
                 "the intervals do not allow for that",
                 100.0 * answer->fits);
        text[lines++] = strdup(line);
    }
    if (next_farthest(list, answer, HUGE_VAL, &l, &w)) {
        where_it_fails(list, answer, line);
        text[lines++] = strdup(line);
    }
    if (list->count > 0 && list->landing[0].later) {
        snprintf(line, sizeof line,
                 "RUN %lld began on joints that earlier landings had closed or opened, but its "
                 "gaps are drawn as those of a new "
                 "runway: fit from the first landing on",
                 (long long)list->landing[0].run);
        text[lines++] = strdup(line);
    }
    return lines;
}

size_t fit_verdicts(const struct fit_landings *list, const struct fit_answer *answer,
                    const struct misfit *misfit, char *text[FIT_VERDICTS])
{
    enum fit_key key[FIT_KEYS];
    char line[TEXT_SIZE];
    size_t count = fit_landings_fitted(list, key), lines = 0;
    for (size_t i = 0; i < count; i++) {
        if (!answer->silent[i])
            continue;
        snprintf(line, sizeof line,
                 "the data say less of %s than its prior does: its interval is the prior's",
                 fit_names[key[i]].key);
        text[lines++] = strdup(line);
    }
    for (size_t d = 0; d < answer->confounded_count; d++) {
        confounded_text(list, key, &answer->confounded[d], line);
        text[lines++] = strdup(line);
    }
    if (misfit->checked ? misfit->cannot : answer->fits < POOR_FIT)
        lines += poor_fit(list, answer, &text[lines]);
    if (answer->stopped) {
        snprintf(line, sizeof line,
                 "the estimate did not come to stand still in %u rounds: give it more time, or "
                 "narrower priors",
                 answer->rounds);
        text[lines++] = strdup(line);
    }
    text[lines] = NULL;
    return lines;
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

static void add_verdicts(struct answer *answer, const struct fit_landings *list,
                         const struct fit_answer *fit, const struct misfit *misfit)
{
    char *verdict[FIT_VERDICTS];
    size_t lines = fit_verdicts(list, fit, misfit, verdict);
    if (lines == 0)
        answer_words(answer, NULL, "verdict", "the data tell every parameter from the others");
    answer_list(answer, "verdict", "verdict");
    for (size_t i = 0; i < lines; i++) {
        answer_sentence(answer, NULL, "%s", verdict[i] ? verdict[i] : "");
        free(verdict[i]);
    }
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
    answer_sentence(answer, NULL,
                    "goodness of fit: %.0f %% of simulated data sets lie further from the model "
                    "than the measured one (distance %.1f, %zu statistics)",
                    100.0 * fit->fits, sqrt(fit->distance), fit->statistics);
    answer_value(answer, "fits", NULL, UNIT_NUMBER, fit->fits, 2)->digits = 4;
    answer_value(answer, "distance", NULL, UNIT_NUMBER, sqrt(fit->distance), 1);
    misfit_describe(answer, list, misfit);
    add_verdicts(answer, list, fit, misfit);
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
    double *statistic = calloc(list->statistics, sizeof *statistic), least = (double)INFINITY;
    uint64_t best = 1;
    for (uint64_t draw = 1; draw <= NEAREST_OF && statistic; draw++) {
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
    if (fit_landings_joints(list, answer->z, nearest(list, answer), &joints, &share, error)) {
        set_scene(scene, list, value, &joints, share);
        struct output output;
        if (output_begin(&output, path, error) == MR_OK) {
            json_dumpf(scene, output.file, JSON_INDENT(1) | JSON_REAL_PRECISION(9));
            fputc('\n', output.file);
            output_end(&output, error);
        }
    }
    sim_scene_free(&joints);
    json_decref(scene);
    return error->status;
}
