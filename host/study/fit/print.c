#include "host/study/fit/print.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/cli.h"
#include "host/study/fit/verdict.h"
#include "host/base/output.h"

#define NORMAL_95 1.959963984540054
#define IN_PER_FT 12.0
#define TEXT_SIZE 400
#define POOR_FIT 0.05
#define NEAREST_OF 50u
#define FARTHEST 3    /* statistics that a poor fit names, */
#define FARTHEST_FROM 2.5 /* standard deviations and more away */

/* Factor and unit shown. */
static double shown_unit(enum fit_key key, bool si, const char **unit)
{
    static const struct {
        const char *unit;
        double factor;
    } metric[FIT_KEYS] = {[FIT_GAP] = {"mm", 25.4}, [FIT_GRIT] = {"N", 4.4482216152605}, [FIT_FRICTION] = {"", 1.0},
                          [FIT_SHARE] = {"", 1.0}, [FIT_STIFFNESS] = {"N/m", 14.593902937206}};
    *unit = si ? metric[key].unit : fit_names[key].unit;
    return si ? metric[key].factor : 1.0;
}

size_t fit_rows(const struct fit_landings *list, const struct fit_answer *answer, struct fit_row row[FIT_KEYS])
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

/* "f x share^-0.98": of two, what stays the same along a direction in which the data say nothing. */
static void determined(const struct fit_landings *list, const enum fit_key *key, const double *direction, char *text, size_t size)
{
    size_t member[2], count = 0;
    for (size_t i = 0; i < FIT_PARAMETERS_MAX && count < 2; i++) {
        if (direction[i] * direction[i] >= VERDICT_MEMBER)
            member[count++] = i;
    }
    double first = list->parameter[key[member[0]]].spread * direction[member[0]];
    double second = list->parameter[key[member[1]]].spread * direction[member[1]];
    snprintf(text, size, "; what they tell is %s x %s^%.2g", fit_names[key[member[0]]].key, fit_names[key[member[1]]].key,
             -first / second);
}

static void confounded_text(const struct fit_landings *list, const enum fit_key *key, const struct fit_confounded *found, char *text)
{
    unsigned named = 0;
    char same[80] = "";
    size_t length = (size_t)snprintf(text, TEXT_SIZE, "the data cannot tell ");
    for (size_t i = 0; i < FIT_PARAMETERS_MAX && length < TEXT_SIZE; i++) {
        if (found->direction[i] * found->direction[i] < VERDICT_MEMBER)
            continue;
        named++;
        length += (size_t)snprintf(text + length, TEXT_SIZE - length, "%s%s", named == 1 ? "" : named == 2 ? " from " : " and ",
                                   fit_names[key[i]].key);
    }
    if (found->members == 2)
        determined(list, key, found->direction, same, sizeof same);
    length += length < TEXT_SIZE ? (size_t)snprintf(text + length, TEXT_SIZE - length, "%s (together by", same) : 0;
    for (size_t i = 0; i < FIT_PARAMETERS_MAX && length < TEXT_SIZE; i++) {
        if (found->direction[i] * found->direction[i] >= VERDICT_MEMBER)
            length += (size_t)snprintf(text + length, TEXT_SIZE - length, " %s %+.0f %%", fit_names[key[i]].key,
                                       100.0 * (exp(list->parameter[key[i]].spread * found->direction[i]) - 1.0));
    }
    if (length < TEXT_SIZE)
        snprintf(text + length, TEXT_SIZE - length, ": misfit +%.1f, %.2f would show)", fmax(found->rise, 0.0), VERDICT_LIMIT);
}

static double away(const struct fit_landings *list, const struct fit_answer *answer, size_t statistic)
{
    return (list->measured[statistic] - answer->expected[statistic]) / answer->scatter[statistic];
}

/* The farthest statistic that is nearer than `below`; false: none is far. */
static bool next_farthest(const struct fit_landings *list, const struct fit_answer *answer, double below, size_t *landing, size_t *window)
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
static void where_it_fails(const struct fit_landings *list, const struct fit_answer *answer, char *text)
{
    double below = HUGE_VAL;
    size_t l, w, length = (size_t)snprintf(text, TEXT_SIZE, "farthest off (in standard deviations):");
    for (int i = 0; i < FARTHEST && next_farthest(list, answer, below, &l, &w) && length < TEXT_SIZE; i++) {
        const struct fit_landing *landing = &list->landing[l];
        const struct fit_window *window = &landing->window[w];
        size_t s = landing->first + w;
        bool transducer = window->channel != SIZE_MAX;
        char place[60];
        if (transducer)
            snprintf(place, sizeof place, "transducer %lld at %g ft", (long long)landing->channel[window->channel].number,
                     landing->channel[window->channel].station_ft);
        else
            snprintf(place, sizeof place, "segment %zu", window->segment + 1);
        below = fabs(away(list, answer, s));
        length += (size_t)snprintf(text + length, TEXT_SIZE - length, "%s RUN %lld %s, %s: %.3f in, expected %.3f (%+.1f)", i ? ";" : "",
                                   (long long)landing->run, place, window->name,
                                   transducer ? fit_movement_in(list->measured[s]) : list->measured[s],
                                   transducer ? fit_movement_in(answer->expected[s]) : answer->expected[s], away(list, answer, s));
    }
}

/* Why a fit may be poor that the data do not say. */
static size_t poor_fit(const struct fit_landings *list, const struct fit_answer *answer, char *text[3])
{
    char line[TEXT_SIZE];
    size_t lines = 0, l, w;
    snprintf(line, sizeof line, "the model does not fit: only %.1f %% of simulated data sets lie further from it; the intervals do not "
                                "allow for that", 100.0 * answer->fits);
    text[lines++] = strdup(line);
    if (next_farthest(list, answer, HUGE_VAL, &l, &w)) {
        where_it_fails(list, answer, line);
        text[lines++] = strdup(line);
    }
    if (list->count > 0 && list->landing[0].later) {
        snprintf(line, sizeof line, "RUN %lld began on joints that earlier landings had closed or opened, but its gaps are drawn as those of a new "
                                    "runway: fit from the first landing on", (long long)list->landing[0].run);
        text[lines++] = strdup(line);
    }
    return lines;
}

size_t fit_verdicts(const struct fit_landings *list, const struct fit_answer *answer, char *text[FIT_VERDICTS])
{
    enum fit_key key[FIT_KEYS];
    char line[TEXT_SIZE];
    size_t count = fit_landings_fitted(list, key), lines = 0;
    for (size_t i = 0; i < count; i++) {
        if (!answer->silent[i])
            continue;
        snprintf(line, sizeof line, "the data say less of %s than its prior does: its interval is the prior's", fit_names[key[i]].key);
        text[lines++] = strdup(line);
    }
    for (size_t d = 0; d < answer->confounded_count; d++) {
        confounded_text(list, key, &answer->confounded[d], line);
        text[lines++] = strdup(line);
    }
    if (answer->fits < POOR_FIT)
        lines += poor_fit(list, answer, &text[lines]);
    if (answer->stopped) {
        snprintf(line, sizeof line, "the estimate did not come to stand still in %u rounds: give it more time, or narrower priors",
                 answer->rounds);
        text[lines++] = strdup(line);
    }
    text[lines] = NULL;
    return lines;
}

static void print_correlations(const struct fit_landings *list, const struct fit_answer *answer)
{
    enum fit_key key[FIT_KEYS];
    size_t count = fit_landings_fitted(list, key);
    printf("correlation of the estimates\n       ");
    for (size_t i = 0; i < count; i++)
        printf(" %6s", fit_names[key[i]].key);
    printf("\n");
    for (size_t i = 0; i < count; i++) {
        printf("  %-5s", fit_names[key[i]].key);
        for (size_t k = 0; k < count; k++)
            printf(" %6.2f", answer->covariance[i][k] / sqrt(answer->covariance[i][i] * answer->covariance[k][k]));
        printf("\n");
    }
}

static void print_landings(const struct fit_landings *list)
{
    for (size_t l = 0; l < list->count; l++) {
        const struct fit_landing *landing = &list->landing[l];
        size_t segments = 0, after = 0;
        for (size_t s = 0; s < MR_SEGMENTS; s++) {
            segments += isnan(landing->survey_in[s]) ? 0 : 1;
            after += isnan(landing->after_in[s]) ? 0 : 1;
        }
        char gages[40] = "";
        if (landing->gages > 0)
            snprintf(gages, sizeof gages, " (%zu by gage points)", landing->gages);
        printf("RUN %lld: %zu transducers, %zu statistics, %zu segments surveyed before%s, %zu after%s\n", (long long)landing->run,
               landing->channels, landing->windows, segments, gages, after, landing->follows ? "; gaps as the landing before left them" : "");
    }
}

void fit_print(const struct fit_landings *list, const struct fit_answer *answer, bool si)
{
    struct fit_row row[FIT_KEYS];
    char *verdict[FIT_VERDICTS];
    size_t count = fit_rows(list, answer, row);
    print_landings(list);
    printf("%zu simulated data sets in %u rounds%s\n", answer->simulated, answer->rounds, answer->failed ? ", of which some failed" : "");
    printf("  %-28s %-6s %10s   %-23s %-23s %s\n", "parameter", "unit", "value", "95 % interval", "prior's", "error, of the prior's");
    for (size_t i = 0; i < count; i++) {
        const char *unit;
        char name[40], interval[40], prior[40];
        double factor = shown_unit(row[i].key, si, &unit);
        snprintf(name, sizeof name, "%-5s %s", fit_names[row[i].key].key, fit_names[row[i].key].words);
        snprintf(interval, sizeof interval, "%.4g to %.4g", factor * row[i].low, factor * row[i].high);
        snprintf(prior, sizeof prior, "%.4g to %.4g", factor * row[i].prior_low, factor * row[i].prior_high);
        printf("  %-28s %-6s %10.4g   %-23s %-23s %.2f\n", name, *unit ? unit : "-", factor * row[i].value, interval, prior, row[i].narrowed);
    }
    print_correlations(list, answer);
    printf("goodness of fit: %.0f %% of simulated data sets lie further from the model than the measured one (distance %.1f, %zu statistics)\n",
           100.0 * answer->fits, sqrt(answer->distance), answer->statistics);
    size_t lines = fit_verdicts(list, answer, verdict);
    printf("verdict: %s\n", lines ? "" : "the data tell every parameter from the others");
    for (size_t i = 0; i < lines; i++) {
        printf("  %s\n", verdict[i] ? verdict[i] : "");
        free(verdict[i]);
    }
}

static json_t *matrix_json(size_t count, const double matrix[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX], bool correlation)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < count; i++) {
        json_t *row = json_array();
        for (size_t k = 0; k < count; k++)
            json_array_append_new(row, cli_json_number(correlation ? matrix[i][k] / sqrt(matrix[i][i] * matrix[k][k]) : matrix[i][k], 6));
        json_array_append_new(rows, row);
    }
    return rows;
}

static json_t *residuals_json(const struct fit_landings *list, const struct fit_answer *answer)
{
    json_t *rows = json_array();
    for (size_t l = 0; l < list->count; l++) {
        const struct fit_landing *landing = &list->landing[l];
        for (size_t w = 0; w < landing->windows; w++) {
            const struct fit_window *window = &landing->window[w];
            size_t s = landing->first + w;
            bool transducer = window->channel != SIZE_MAX;
            json_t *row = json_pack("{s:I,s:s,s:o,s:o,s:o}", "run", (json_int_t)landing->run, "statistic", window->name, "measured",
                                    cli_json_number(list->measured[s], 6), "expected", cli_json_number(answer->expected[s], 6),
                                    "standard_deviation", cli_json_number(answer->scatter[s], 4));
            if (transducer)
                json_object_set_new(row, "transducer", json_integer(landing->channel[window->channel].number));
            json_array_append_new(rows, row);
        }
    }
    return rows;
}

json_t *fit_json(const struct fit_landings *list, const struct fit_answer *answer, bool si)
{
    struct fit_row row[FIT_KEYS];
    char *verdict[FIT_VERDICTS];
    json_t *parameters = json_array(), *verdicts = json_array(), *runs = json_array();
    size_t count = fit_rows(list, answer, row), lines = fit_verdicts(list, answer, verdict);
    for (size_t l = 0; l < list->count; l++)
        json_array_append_new(runs, json_integer(list->landing[l].run));
    for (size_t i = 0; i < count; i++) {
        const char *unit;
        double factor = shown_unit(row[i].key, si, &unit);
        json_array_append_new(
            parameters,
            json_pack("{s:s,s:s,s:o,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "name", fit_names[row[i].key].key, "unit", unit, "value",
                      cli_json_number(factor * row[i].value, 6), "low", cli_json_number(factor * row[i].low, 6), "high",
                      cli_json_number(factor * row[i].high, 6), "prior", cli_json_number(factor * row[i].prior, 6), "prior_low",
                      cli_json_number(factor * row[i].prior_low, 6), "prior_high", cli_json_number(factor * row[i].prior_high, 6),
                      "error_of_prior", cli_json_number(row[i].narrowed, 4), "bias_of_prior", cli_json_number(answer->bias[i], 4)));
    }
    for (size_t i = 0; i < lines; i++) {
        json_array_append_new(verdicts, json_string(verdict[i] ? verdict[i] : ""));
        free(verdict[i]);
    }
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:I,s:i,s:b,s:o,s:o}", "runs", runs, "parameters", parameters, "correlation",
                     matrix_json(count, answer->covariance, true), "information", matrix_json(count, answer->information, false),
                     "fits", cli_json_number(answer->fits, 4), "distance", cli_json_number(sqrt(answer->distance), 6), "simulated",
                     (json_int_t)answer->simulated, "rounds", (int)answer->rounds, "stopped", answer->stopped, "verdict", verdicts,
                     "residuals", residuals_json(list, answer));
}

static json_t *path_json(const struct fit_landing *landing, double share)
{
    json_t *path = json_array();
    for (size_t i = 0; i < landing->scene.path_count; i++) {
        const struct sim_path_row *row = &landing->scene.path[i];
        json_array_append_new(path, json_pack("[ooo]", cli_json_number(row->t_s, 9), cli_json_number(row->x_ft, 9),
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

static void set_scene(json_t *scene, const struct fit_landings *list, const double value[FIT_KEYS], const struct sim_scene *joints,
                      double share)
{
    char note[240];
    snprintf(note, sizeof note,
             "f, KL, gap0, grit and the thrust in path by matrig fit, RUN %lld: mean gap %.4g in, mean resistance %.4g lb, share %.4g; "
             "of %u draws of the joints this one comes nearest to what was measured",
             (long long)list->landing[0].run, value[FIT_GAP], value[FIT_GRIT], value[FIT_SHARE], NEAREST_OF);
    json_object_set_new(scene, "_fit", json_string(note));
    json_object_set_new(scene, "gap0", list_json(&joints->gap0_ft));
    json_object_set_new(scene, "grit", list_json(&joints->grit_lb));
    json_object_set_new(scene, "f", cli_json_number(value[FIT_FRICTION], 6));
    json_object_set_new(scene, "KL", cli_json_number(value[FIT_STIFFNESS], 6));
    json_object_set_new(scene, "path", path_json(&list->landing[0], share));
}

enum mr_status fit_write_scene(const struct fit_landings *list, const struct fit_answer *answer, const char *from, const char *path, bool force,
                               struct error *error)
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
        if (output_begin(&output, path, force, error) == MR_OK) {
            json_dumpf(scene, output.file, JSON_INDENT(1) | JSON_REAL_PRECISION(9));
            fputc('\n', output.file);
            output_end(&output, error);
        }
    }
    sim_scene_free(&joints);
    json_decref(scene);
    return error->status;
}
