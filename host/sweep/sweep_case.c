#include "host/sweep/sweep_case.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
#include "host/landing_series/summary.h"
#include "host/base/progress.h"
#include "host/sim/sim_answer.h"
#include "host/sweep/sweep.h"

/* ---- one simulation ---- */

static enum mr_status read_scene(struct sim_scene *scene, const json_t *input, const char *where,
                                 struct error *error)
{
    char *text = json_dumps(input, JSON_COMPACT | JSON_REAL_PRECISION(17));
    sim_scene_parse(scene, where, text, strlen(text), error);
    free(text);
    return error->status;
}

static json_t *refused(const struct error *error)
{
    return json_pack("{s:s,s:s}", "status", "refused", "reason", error->text);
}

static json_t *simulate_scene(const struct sweep *sweep, const json_t *input)
{
    struct sim_options options = {.solver = sweep->solver, .rtol = sweep->rtol};
    struct sim_result result = {0};
    struct sim_scene scene;
    struct error error = {0};
    if (read_scene(&scene, input, "scene", &error) != MR_OK)
        return refused(&error);
    struct progress progress;
    progress_begin(&progress, "sweep",
                   "an earlier tend, fewer mats, a looser rtol or another solver", false);
    options.go_on = sim_progress;
    options.go_on_ctx = &progress;
    sim_run(&scene, &options, &result, &error);
    progress_end(&progress);
    bool tried = error.status == MR_OK || result.status != SIM_OK;
    json_t *object = tried ? answer_into_json(sim_answer(&scene, &result, false)) : refused(&error);
    /* of all mats at all times; `matrig sim` shows what is asked for, when it is asked for */
    if (tried)
        json_object_set_new(object, "peak_u_ft", json_real(result.peak_u_ft));
    if (tried && error.status != MR_OK)
        json_object_set_new(object, "reason", json_string(error.text));
    sim_result_free(&result);
    sim_scene_free(&scene);
    return object;
}

/* One runway after the other: a case stays on one core. Its seeds are the series'. */
static json_t *play_series(const struct landing_series *series, struct series_run *runs)
{
    struct series_summary summary;
    series_ensemble(series, 1, NULL, NULL, runs);
    series_summarise(&summary, series, runs);
    json_t *object = answer_into_json(series_answer(series, runs, &summary, false));
    json_object_set_new(object, "status", json_string(summary.failed > 0 ? "incomplete" : "ok"));
    for (size_t i = 0; i < series->seeds && summary.failed > 0; i++) {
        if (runs[i].error.status != MR_OK) {
            json_object_set_new(
                object, "reason",
                json_sprintf("%zu of %zu runways could not be played; seed %llu: %s",
                             summary.failed, series->seeds, (unsigned long long)runs[i].seed,
                             runs[i].error.text));
            break;
        }
    }
    series_summary_free(&summary);
    return object;
}

static json_t *simulate_study(const struct sweep *sweep, const json_t *input)
{
    (void)sweep;
    struct error error = {0};
    struct landing_series series;
    if (series_from_json(&series, "study", input, &error) != MR_OK)
        return refused(&error);
    struct series_run *runs = xcalloc(series.seeds, sizeof *runs);
    json_t *object = play_series(&series, runs);
    for (size_t i = 0; i < series.seeds; i++)
        series_run_free(&runs[i]);
    free(runs);
    series_free(&series);
    return object;
}

sweep_simulate *sweep_simulation(enum sweep_kind kind)
{
    switch (kind) {
    case SWEEP_SCENE: return simulate_scene;
    case SWEEP_STUDY: return simulate_study;
    }
    return NULL;
}

enum mr_status sweep_case_check(const struct sweep *sweep, const json_t *input, const char *where,
                                struct error *error)
{
    struct sim_scene scene;
    struct landing_series series;
    if (sweep->kind == SWEEP_STUDY) {
        if (series_from_json(&series, where, input, error) == MR_OK)
            series_free(&series);
        return error->status;
    }
    if (read_scene(&scene, input, where, error) == MR_OK)
        sim_scene_free(&scene);
    return error->status;
}

/* ---- what is kept of it ---- */

static bool is_ok(const json_t *result)
{
    const char *status = json_string_value(json_object_get(result, "status"));
    return status && strcmp(status, "ok") == 0;
}

static json_t *failure(const char *status, const char *format, const char *what)
{
    return json_pack("{s:s,s:o}", "status", status, "reason", json_sprintf(format, what));
}

static json_t *no_field(const struct sweep *sweep, const char *what, const char *name)
{
    return json_pack("{s:s,s:o}", "status", "refused", "reason",
                     json_sprintf("the result has no %s \"%s\"; see matrig --json %s", what, name,
                                  sweep->kind == SWEEP_STUDY ? "study FILE" : "sim SCENE"));
}

/* status, reason, result of a finished simulation; a field that is missing fails the case: nothing
 * is made up. */
static json_t *kept(const struct sweep *sweep, const json_t *result)
{
    const json_t *outputs = sweep_outputs(sweep);
    json_t *values = json_object();
    if (!is_ok(result)) {
        json_t *outcome = json_pack("{s:O}", "status", json_object_get(result, "status"));
        json_object_set(outcome, "reason", json_object_get(result, "reason"));
        json_decref(values);
        return outcome;
    }
    for (size_t i = 0; i < json_array_size(outputs); i++) {
        const char *name = json_string_value(json_array_get(outputs, i));
        json_t *value = jsonpath_get(result, name);
        if (!value) {
            json_decref(values);
            return no_field(sweep, "field", name);
        }
        json_object_set(values, name, value);
    }
    return json_pack("{s:s,s:o}", "status", "ok", "result", values);
}

/* ---- the search ---- */

struct search {
    const struct sweep *sweep;
    const json_t *input;
    sweep_simulate *simulate;
    int runs;
    json_t *failed; /* outcome of the run that ended the search */
    json_t *first;  /* result of the lowest value that is beyond so far */
    /* the field there, and at the highest value that is not beyond */
    json_t *first_field, *last_field;
};

static bool counts_as_beyond(const struct sweep_find *find, const json_t *result)
{
    for (size_t i = 0; i < json_array_size(find->beyond_when); i++) {
        if (json_equal(json_array_get(find->beyond_when, i), json_object_get(result, "status")))
            return true;
    }
    return false;
}

static void keep(json_t **where, json_t *value)
{
    json_t *before = *where;
    *where = json_incref(value);
    json_decref(before);
}

/* Whether the field is beyond its level at a value of the key. False also when the run failed:
 * s->failed is set then. */
static bool beyond(struct search *s, double value)
{
    const struct sweep_find *find = &s->sweep->find;
    json_t *input = sweep_input_at(s->sweep, s->input, value);
    json_t *result = input ? s->simulate(s->sweep, input)
                           : failure("refused", "%s cannot be set", find->key.name);
    json_t *field = jsonpath_get(result, find->field);
    double number = json_is_boolean(field) ? (json_is_true(field) ? 1.0 : 0.0)
                  : json_is_number(field)  ? json_number_value(field)
                                           : (double)NAN;
    bool counts = counts_as_beyond(find, result), is = counts;
    s->runs++;
    if (!counts && !is_ok(result)) {
        s->failed = kept(s->sweep, result);
        json_object_set_new(s->failed, "reason",
                            json_sprintf("at %s = %.12g: %s", find->key.name, value,
                                         json_string_value(json_object_get(result, "reason"))));
    } else if (!counts && isnan(number)) {
        s->failed = no_field(s->sweep, "number", find->field);
    } else if (!counts) {
        is = find->below ? number < find->level : number > find->level;
    }
    if (!s->failed && is) {
        keep(&s->first, result);
        keep(&s->first_field, counts ? json_object_get(result, "status") : field);
    } else if (!s->failed) {
        keep(&s->last_field, field);
    }
    json_decref(result);
    json_decref(input);
    return is;
}

/* Half way, on the range's scale. */
static double between(const struct design_range *range, double low, double high)
{
    return range->log ? sqrt(low * high) : low + (high - low) / 2.0;
}

/* Upwards through the range until the field is beyond, then halving. False: it is beyond nowhere,
 * or a run failed. */
static bool search_range(struct search *s, double *low, double *high)
{
    const struct sweep_find *find = &s->sweep->find;
    const struct design_range *range = &find->key.range;
    bool found = false;
    *low = (double)NAN;
    for (unsigned i = 0; i <= find->scan && !found && !s->failed; i++) {
        double value = design_number(range, (double)i / find->scan);
        found = beyond(s, value);
        *(found ? high : low) = value;
    }
    while (found && !s->failed && !isnan(*low) && *high - *low > find->tolerance * fabs(*high)) {
        double middle = between(range, *low, *high);
        if (middle <= *low || middle >= *high)
            break;
        bool is = beyond(s, middle);
        *(is ? high : low) = middle;
    }
    return found && !s->failed;
}

static json_t *run_search(struct search *s)
{
    const struct design_range *range = &s->sweep->find.key.range;
    double low = (double)NAN, high = (double)NAN;
    bool found = search_range(s, &low, &high);
    if (s->failed)
        return s->failed;
    json_t *outcome = found ? counts_as_beyond(&s->sweep->find, s->first)
                                ? json_pack("{s:s}", "status", "ok")
                                : kept(s->sweep, s->first)
                            : json_pack("{s:s}", "status", "ok");
    json_t *bracket = json_object();
    json_object_set_new(bracket, "key", json_string(s->sweep->find.key.name));
    json_object_set_new(bracket, "verdict",
                        json_string(!found       ? "none"
                                    : isnan(low) ? "at_most"
                                                 : "between"));
    json_object_set_new(bracket, "low",
                        found && isnan(low) ? json_null() : json_real(found ? low : range->to));
    json_object_set_new(bracket, "high", found ? json_real(high) : json_null());
    json_object_set(bracket, "field_low", s->last_field ? s->last_field : json_null());
    json_object_set(bracket, "field_high", s->first_field ? s->first_field : json_null());
    json_object_set_new(bracket, "runs", json_integer(s->runs));
    json_object_set_new(outcome, "find", bracket);
    return outcome;
}

json_t *sweep_case_run(const struct sweep *sweep, size_t index, sweep_simulate *simulate)
{
    json_t *outcome, *input = sweep_input(sweep, index);
    if (!input)
        return failure("refused", "%s cannot be made",
                       sweep->kind == SWEEP_STUDY ? "the study" : "the scene");
    if (sweep->find.wanted) {
        struct search s = {.sweep = sweep, .input = input, .simulate = simulate};
        outcome = run_search(&s);
        json_decref(s.first);
        json_decref(s.first_field);
        json_decref(s.last_field);
    } else {
        json_t *result = simulate(sweep, input);
        outcome = kept(sweep, result);
        json_decref(result);
    }
    json_decref(input);
    return outcome;
}
