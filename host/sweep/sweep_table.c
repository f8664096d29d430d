#include "host/sweep/sweep_table.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/csv.h"
#include "host/base/progress.h"
#include "host/base/statistics.h"
#include "host/base/xmalloc.h"
#include "host/landing_series/ensemble.h"
#include "host/sim/sim.h"

#define INDEX_POINTS_MIN 8
#define BOOTSTRAP_DRAWS  1000
#define REASONS_MAX      20

/* ---- one simulation ---- */

static json_t *make_refused_json(const struct error *error)
{
    return json_pack("{s:s,s:s}", "status", "refused", "reason", error->text);
}

static json_t *simulate_scene(const json_t *input)
{
    struct sim_options options = {0};
    struct sim_result result = {0};
    struct sim_scene scene;
    struct error error = {0};
    if (sim_scene_from_json(&scene, "scene", (json_t *)(uintptr_t)input, &error) != MR_OK)
        return make_refused_json(&error);
    struct progress progress;
    progress_begin(&progress, "sweep",
                   "a smaller tend, fewer mats, a looser rtol or a different solver", false);
    options.may_continue = sim_report_progress;
    options.may_continue_ctx = &progress;
    sim_run(&scene, &options, &result, &error);
    progress_end(&progress);
    bool tried = error.status == MR_OK || result.status != SIM_OK;
    json_t *object = tried ? answer_make_json_and_free(sim_to_answer(&scene, &result, false))
                           : make_refused_json(&error);
    /* use the peak over all mats and times; `matrig sim` shows only the requested outputs */
    if (tried)
        json_object_set_new(object, "peak_u_ft", json_real(result.peak_u_ft));
    if (tried && error.status != MR_OK)
        json_object_set_new(object, "reason", json_string(error.text));
    sim_result_free(&result);
    sim_scene_free(&scene);
    return object;
}

/* Simulates a series on one core, because the cases of a sweep already run in parallel. The seeds
 * are those of the series. */
static json_t *simulate_series(const struct landing_series *series, struct series_run *runs)
{
    struct series_summary summary;
    series_simulate_all(series, 1, NULL, NULL, runs);
    series_summarise(&summary, series, runs);
    json_t *object = answer_make_json_and_free(series_to_answer(series, runs, &summary, false));
    json_object_set_new(object, "status",
                        json_string(summary.failed_count > 0 ? "incomplete" : "ok"));
    for (size_t i = 0; i < series->seed_count && summary.failed_count > 0; i++) {
        if (runs[i].error.status != MR_OK) {
            json_object_set_new(
                object, "reason",
                json_sprintf("%zu of %zu runways could not be simulated; seed %llu: %s",
                             summary.failed_count, series->seed_count,
                             (unsigned long long)runs[i].seed, runs[i].error.text));
            break;
        }
    }
    series_summary_free(&summary);
    return object;
}

static json_t *simulate_study(const json_t *input)
{
    struct error error = {0};
    struct landing_series series;
    if (series_from_json(&series, "study", input, &error) != MR_OK)
        return make_refused_json(&error);
    struct series_run *runs = xcalloc(series.seed_count, sizeof *runs);
    json_t *object = simulate_series(&series, runs);
    for (size_t i = 0; i < series.seed_count; i++)
        series_run_free(&runs[i]);
    free(runs);
    series_free(&series);
    return object;
}

sweep_simulator *sweep_get_simulator(const struct sweep *sweep)
{
    return sweep->is_study ? simulate_study : simulate_scene;
}

/* ---- stored part of a result ---- */

static bool is_result_ok(const json_t *result)
{
    const char *status = json_string_value(json_object_get(result, "status"));
    return status && strcmp(status, "ok") == 0;
}

static json_t *make_failure_json(const char *status, const char *format, const char *what)
{
    return json_pack("{s:s,s:o}", "status", status, "reason", json_sprintf(format, what));
}

static json_t *make_missing_field_json(const struct sweep *sweep, const char *what,
                                       const char *name)
{
    return json_pack(
        "{s:s,s:o}", "status", "refused", "reason",
        json_sprintf("the result has no %s \"%s\"; list its fields with matrig --json %s", what,
                     name, sweep->is_study ? "study FILE" : "sim SCENE"));
}

/* Reduces a finished simulation to status, reason and result. If a field is missing, the case
 * fails. */
static json_t *collect_output_values(const struct sweep *sweep, const json_t *result)
{
    const json_t *outputs = sweep_outputs(sweep);
    json_t *values = json_object();
    if (!is_result_ok(result)) {
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
            return make_missing_field_json(sweep, "field", name);
        }
        json_object_set(values, name, value);
    }
    return json_pack("{s:s,s:o}", "status", "ok", "result", values);
}

/* ---- the search of a case ---- */

struct search {
    const struct sweep *sweep;
    const json_t *input;
    sweep_simulator *simulate;
    int run_count;
    json_t *failed_outcome; /* outcome of the failed run that ended the search */
    /* result at the lowest value so far at which the field has passed the level */
    json_t *first_passed_result;
    /* field at the lowest value at which it has passed the level, and at the highest value at which
     * it has not */
    json_t *first_passed_field, *last_not_passed_field;
};

static bool is_passing_status(const struct sweep_search *find, const json_t *result)
{
    for (size_t i = 0; i < json_array_size(find->passing_statuses); i++) {
        if (json_equal(json_array_get(find->passing_statuses, i),
                       json_object_get(result, "status")))
            return true;
    }
    return false;
}

static void replace_json(json_t **where, json_t *value)
{
    json_t *before = *where;
    *where = json_incref(value);
    json_decref(before);
}

/* Returns true if the field has passed its level at a value of the key. If the run fails, sets
 * s->failed and returns false. */
static bool has_field_passed_level(struct search *s, double value)
{
    const struct sweep_search *find = &s->sweep->search;
    json_t *input = sweep_input_with_value(s->sweep, s->input, value);
    json_t *result = input ? s->simulate(input)
                           : make_failure_json("refused", "%s cannot be set", find->key.name);
    json_t *field = jsonpath_get(result, find->field);
    double number = json_is_boolean(field) ? (json_is_true(field) ? 1.0 : 0.0)
                  : json_is_number(field)  ? json_number_value(field)
                                           : (double)NAN;
    bool counts = is_passing_status(find, result), is = counts;
    s->run_count++;
    if (!counts && !is_result_ok(result)) {
        s->failed_outcome = collect_output_values(s->sweep, result);
        json_object_set_new(s->failed_outcome, "reason",
                            json_sprintf("at %s = %.12g: %s", find->key.name, value,
                                         json_string_value(json_object_get(result, "reason"))));
    } else if (!counts && isnan(number)) {
        s->failed_outcome = make_missing_field_json(s->sweep, "number", find->field);
    } else if (!counts) {
        is = find->is_passed_downward ? number < find->level : number > find->level;
    }
    if (!s->failed_outcome && is) {
        replace_json(&s->first_passed_result, result);
        replace_json(&s->first_passed_field, counts ? json_object_get(result, "status") : field);
    } else if (!s->failed_outcome) {
        replace_json(&s->last_not_passed_field, field);
    }
    json_decref(result);
    json_decref(input);
    return is;
}

/* Returns the middle between two values, on the linear or logarithmic scale of the range. */
static double range_midpoint(const struct design_range *range, double low, double high)
{
    return range->is_logarithmic ? sqrt(low * high) : low + (high - low) / 2.0;
}

/* Goes upwards through the range until the field has passed its level, then bisects. Returns false
 * if it never does, or if a run failed. */
static bool search_range(struct search *s, double *low, double *high)
{
    const struct sweep_search *find = &s->sweep->search;
    const struct design_range *range = &find->key.range;
    bool found = false;
    *low = (double)NAN;
    for (unsigned i = 0; i <= find->part_count && !found && !s->failed_outcome; i++) {
        double value = design_number(range, (double)i / find->part_count);
        found = has_field_passed_level(s, value);
        *(found ? high : low) = value;
    }
    while (found && !s->failed_outcome && !isnan(*low) &&
           *high - *low > find->tolerance * fabs(*high)) {
        double middle = range_midpoint(range, *low, *high);
        if (middle <= *low || middle >= *high)
            break;
        bool is = has_field_passed_level(s, middle);
        *(is ? high : low) = middle;
    }
    return found && !s->failed_outcome;
}

static json_t *run_search(struct search *s)
{
    const struct design_range *range = &s->sweep->search.key.range;
    double low = (double)NAN, high = (double)NAN;
    bool found = search_range(s, &low, &high);
    if (s->failed_outcome)
        return s->failed_outcome;
    json_t *outcome = found ? is_passing_status(&s->sweep->search, s->first_passed_result)
                                ? json_pack("{s:s}", "status", "ok")
                                : collect_output_values(s->sweep, s->first_passed_result)
                            : json_pack("{s:s}", "status", "ok");
    json_t *bracket = json_object();
    json_object_set_new(bracket, "key", json_string(s->sweep->search.key.name));
    json_object_set_new(bracket, "verdict",
                        json_string(!found       ? "none"
                                    : isnan(low) ? "at_most"
                                                 : "between"));
    json_object_set_new(bracket, "low",
                        found && isnan(low) ? json_null() : json_real(found ? low : range->to));
    json_object_set_new(bracket, "high", found ? json_real(high) : json_null());
    json_object_set(bracket, "field_low",
                    s->last_not_passed_field ? s->last_not_passed_field : json_null());
    json_object_set(bracket, "field_high",
                    s->first_passed_field ? s->first_passed_field : json_null());
    json_object_set_new(bracket, "runs", json_integer(s->run_count));
    json_object_set_new(outcome, "find", bracket);
    return outcome;
}

json_t *sweep_run_case(const struct sweep *sweep, size_t index, sweep_simulator *simulate)
{
    json_t *outcome, *input = sweep_case_input(sweep, index);
    if (!input)
        return make_failure_json("refused", "%s cannot be created",
                                 sweep->is_study ? "the study" : "the scene");
    if (sweep->search.is_present) {
        struct search s = {.sweep = sweep, .input = input, .simulate = simulate};
        outcome = run_search(&s);
        json_decref(s.first_passed_result);
        json_decref(s.first_passed_field);
        json_decref(s.last_not_passed_field);
    } else {
        json_t *result = simulate(input);
        outcome = collect_output_values(sweep, result);
        json_decref(result);
    }
    json_decref(input);
    return outcome;
}

/* ---- lines ---- */

static void write_hash_text(const struct sweep *sweep, char text[17])
{
    snprintf(text, 17, "%016llx", (unsigned long long)sweep->hash);
}

json_t *sweep_make_line(const struct sweep *sweep, size_t index, json_t *outcome)
{
    char hash[17];
    write_hash_text(sweep, hash);
    json_t *line = json_pack("{s:I,s:s,s:o}", "case", (json_int_t)index + 1, "sweep", hash,
                             "values", sweep_case_values(sweep, index));
    json_object_update(line, outcome);
    json_decref(outcome);
    return line;
}

static const char *get_status(const json_t *line)
{
    const char *status = json_string_value(json_object_get(line, "status"));
    return status ? status : "";
}

static enum mr_status add_result_line(struct sweep_table *table, const char *path, size_t number,
                                      json_t *line, struct error *error)
{
    char hash[17];
    const char *of = json_string_value(json_object_get(line, "sweep"));
    json_int_t index = json_integer_value(json_object_get(line, "case"));
    write_hash_text(table->sweep, hash);
    if (!of || !*get_status(line) || !json_is_object(json_object_get(line, "values")))
        return error_set(
            error, MR_MALFORMED,
            "not a line of results: %s line %zu; give files that matrig sweep --cases wrote", path,
            number);
    if (strcmp(of, hash) != 0 || index < 1 || (size_t)index > table->sweep->case_count)
        return error_set(error, MR_MALFORMED,
                         "the results are of a different sweep: %s line %zu; run the cases again, "
                         "or give the original sweep file",
                         path, number);
    if (table->line[index - 1]) {
        table->repeated_count++;
        return MR_OK;
    }
    table->line[index - 1] = json_incref(line);
    table->line_count++;
    table->failed_count += strcmp(get_status(line), "ok") != 0;
    return MR_OK;
}

static enum mr_status read_lines(struct sweep_table *table, const char *path, FILE *file,
                                 struct error *error)
{
    char *text = NULL;
    size_t size = 0;
    for (size_t number = 1; getline(&text, &size, file) > 0 && error->status == MR_OK; number++) {
        json_t *line = json_loads(text, JSON_REJECT_DUPLICATES, NULL);
        add_result_line(table, path, number, line, error);
        json_decref(line);
    }
    free(text);
    return error->status;
}

enum mr_status sweep_table_load(struct sweep_table *table, const struct sweep *sweep,
                                const char *const *paths, struct error *error)
{
    *table = (struct sweep_table){.sweep = sweep};
    table->line = xcalloc(sweep->case_count, sizeof *table->line);
    for (; *paths && error->status == MR_OK; paths++) {
        FILE *file = fopen(*paths, "r");
        if (!file)
            return error_set(error, MR_IO, "cannot open results: %s: %s; check the path", *paths,
                             strerror(errno));
        read_lines(table, *paths, file, error);
        fclose(file);
    }
    table->missing_count = sweep->case_count - table->line_count;
    return error->status;
}

void sweep_table_free(struct sweep_table *table)
{
    for (size_t i = 0; i < table->sweep->case_count; i++)
        json_decref(table->line[i]);
    free(table->line);
    *table = (struct sweep_table){0};
}

/* ---- sensitivity indices ---- */

/* Draws an index with xorshift64 (Marsaglia 2003), which gives the same numbers in every run. */
static size_t draw_random_index(uint64_t *state, size_t count)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (size_t)((double)(*state >> 11) * 0x1p-53 * (double)count);
}

/* Sensitivity indices of one key: first-order and total. */
struct sensitivity_pair {
    double first, total;
};

/* Computes the indices from the points `row`; NaN if the values do not vary. */
static struct sensitivity_pair compute_sensitivities(const double *values, size_t points,
                                                     size_t key, const size_t *row, size_t count)
{
    const double *a = values, *b = values + points, *ab = values + (2 + key) * points;
    double sum = 0.0, squares = 0.0, first = 0.0, total = 0.0, n = 2.0 * (double)count;
    for (size_t i = 0; i < count; i++) {
        size_t r = row[i];
        sum += a[r] + b[r];
        first += (b[r] - ab[r]) * (b[r] - ab[r]);
        total += (a[r] - ab[r]) * (a[r] - ab[r]);
    }
    for (size_t i = 0; i < count; i++) {
        double from_a = a[row[i]] - sum / n, from_b = b[row[i]] - sum / n;
        squares += from_a * from_a + from_b * from_b;
    }
    if (!(squares > 0.0))
        return (struct sensitivity_pair){(double)NAN, (double)NAN};
    double twice_variance = 2.0 * squares / n;
    return (struct sensitivity_pair){1.0 - first / (double)count / twice_variance,
                                     total / (double)count / twice_variance};
}

static void set_interval(struct sweep_sensitivity *index, double *drawn, size_t count)
{
    sort_numbers(drawn, count);
    index->low = count ? drawn[(size_t)(0.025 * (double)count)] : (double)NAN;
    index->high = count ? drawn[(size_t)(0.975 * (double)count)] : (double)NAN;
}

static void estimate_sensitivities(const double *values, size_t points, size_t key,
                                   const size_t *row, size_t count, size_t *picked, double *drawn,
                                   struct sweep_key_sensitivities *result)
{
    uint64_t state = 0x9e3779b97f4a7c15u;
    size_t good = 0;
    struct sensitivity_pair pair = compute_sensitivities(values, points, key, row, count);
    result->first.value = pair.first;
    result->total.value = pair.total;
    for (size_t d = 0; d < BOOTSTRAP_DRAWS; d++) {
        for (size_t i = 0; i < count; i++)
            picked[i] = row[draw_random_index(&state, count)];
        pair = compute_sensitivities(values, points, key, picked, count);
        if (isnan(pair.first))
            continue;
        drawn[good] = pair.first;
        drawn[BOOTSTRAP_DRAWS + good++] = pair.total;
    }
    set_interval(&result->first, drawn, good);
    set_interval(&result->total, drawn + BOOTSTRAP_DRAWS, good);
}

/* Lists the points for which all values exist. Returns their number. */
static size_t select_complete_points(const double *values, size_t points, size_t keys, size_t *row)
{
    size_t count = 0;
    for (size_t i = 0; i < points; i++) {
        bool whole = true;
        for (size_t block = 0; block < keys + 2; block++)
            whole &= isfinite(values[block * points + i]) != 0;
        if (whole)
            row[count++] = i;
    }
    return count;
}

bool sweep_compute_sensitivities(const double *values, size_t points, size_t keys,
                                 struct sweep_key_sensitivities *influence, size_t *used)
{
    size_t *row = xcalloc(2 * points + 1, sizeof *row);
    double *drawn = xcalloc(2 * (size_t)BOOTSTRAP_DRAWS, sizeof *drawn);
    *used = select_complete_points(values, points, keys, row);
    bool good = *used >= INDEX_POINTS_MIN &&
                !isnan(compute_sensitivities(values, points, 0, row, *used).first);
    for (size_t k = 0; good && k < keys; k++)
        estimate_sensitivities(values, points, k, row, *used, row + points, drawn, &influence[k]);
    free(row);
    free(drawn);
    return good;
}

/* Returns the threshold found by a search, the upper end of the bracket. JSON null or NULL: there
 * is none. */
static const json_t *get_threshold(const json_t *line)
{
    return json_object_get(json_object_get(line, "find"), "high");
}

/* Returns a result as a number (true is 1, false is 0; NaN: none). `field` NULL: the threshold. */
static double get_result_number(const json_t *line, const char *field)
{
    const json_t *value = field ? json_object_get(json_object_get(line, "result"), field)
                                : get_threshold(line);
    if (json_is_boolean(value))
        return json_is_true(value) ? 1.0 : 0.0;
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

static void add_sensitivity(struct answer *answer, const char *name, const char *label,
                            const struct sweep_sensitivity *index)
{
    char words[80];
    snprintf(words, sizeof words, "%.2f (%.2f to %.2f)", index->value, index->low, index->high);
    answer_add_text(answer, NULL, label, "%s", words);
    answer_add_json(answer, name, json_pack("[f,f,f]", index->value, index->low, index->high));
}

/* Returns the values of the stepped keys in one combination. */
static json_t *make_combination_json(const struct sweep *sweep, size_t place)
{
    json_t *values = sweep_case_values(sweep, place * sweep->sample_count);
    for (size_t i = 0; i < sweep->axis_count; i++) {
        if (sweep->axis[i].sample_fractions)
            json_object_del(values, sweep->axis[i].name);
    }
    return values;
}

/* Adds the indices of one field for one combination of the stepped keys, one row per sampled
 * key. */
static void add_sensitivities(struct answer *answer, const struct sweep_table *table,
                              const char *field, size_t place)
{
    const struct sweep *sweep = table->sweep;
    size_t first = place * sweep->sample_count,
           keys = sweep->sample_count / sweep->sensitivity_point_count - 2, used, key = 0;
    double *values = xcalloc(sweep->sample_count, sizeof *values);
    struct sweep_key_sensitivities *influence = xcalloc(keys, sizeof *influence);
    for (size_t i = 0; i < sweep->sample_count; i++)
        values[i] = get_result_number(table->line[first + i], field);
    bool known = sweep_compute_sensitivities(values, sweep->sensitivity_point_count, keys,
                                             influence, &used);
    json_t *at = make_combination_json(sweep, place);
    char *where = json_dumps(at, JSON_COMPACT | JSON_REAL_PRECISION(6));
    for (size_t i = 0; known && i < sweep->axis_count; i++) {
        if (!sweep->axis[i].sample_fractions)
            continue;
        answer_open_row(answer);
        answer_add_text(answer, "output", "output", "%s", field ? field : "threshold");
        answer_add_json(answer, "at", json_incref(at));
        if (sweep->grid_case_count > 1)
            answer_add_text(answer, NULL, "at", "%s", where);
        answer_add_text(answer, "key", "key", "%s", sweep->axis[i].name);
        add_sensitivity(answer, "first", "first order (95 %)", &influence[key].first);
        add_sensitivity(answer, "total", "total (95 %)", &influence[key].total);
        answer_add_count(answer, "points", "points", (int64_t)used);
        key++;
    }
    free(where);
    json_decref(at);
    free(influence);
    free(values);
}

static void add_all_sensitivities(struct answer *answer, const struct sweep_table *table)
{
    const json_t *outputs = sweep_outputs(table->sweep);
    answer_open_table(answer, "indices",
                      "sensitivity indices: share of the variance that the key causes alone (first "
                      "order) and together with other keys (total)");
    for (size_t place = 0; place < table->sweep->grid_case_count; place++) {
        if (table->sweep->search.is_present)
            add_sensitivities(answer, table, NULL, place);
        for (size_t i = 0; i < json_array_size(outputs); i++)
            add_sensitivities(answer, table, json_string_value(json_array_get(outputs, i)), place);
    }
    answer_close_group(answer);
}

/* ---- the table ---- */

struct failure_reason {
    const char *status, *text;
    size_t first_case, count;
};

static void add_failures(struct answer *answer, const struct sweep_table *table)
{
    struct failure_reason reasons[REASONS_MAX];
    size_t count = 0;
    for (size_t i = 0; i < table->sweep->case_count; i++) {
        const char *status = get_status(table->line[i]);
        const char *text = json_string_value(json_object_get(table->line[i], "reason"));
        size_t k = 0;
        if (!table->line[i] || strcmp(status, "ok") == 0)
            continue;
        text = text ? text : "";
        while (k < count &&
               (strcmp(reasons[k].status, status) != 0 || strcmp(reasons[k].text, text) != 0))
            k++;
        if (k == REASONS_MAX)
            continue;
        if (k == count)
            reasons[count++] = (struct failure_reason){status, text, i + 1, 0};
        reasons[k].count++;
    }
    answer_open_table(answer, NULL, "failed cases");
    for (size_t k = 0; k < count; k++) {
        answer_open_row(answer);
        answer_add_text(answer, NULL, "status", "%s", reasons[k].status);
        answer_add_count(answer, NULL, "cases", (int64_t)reasons[k].count);
        answer_add_count(answer, NULL, "first", (int64_t)reasons[k].first_case);
        answer_add_text(answer, NULL, "reason", "%s", reasons[k].text);
    }
    answer_close_group(answer);
}

/* Returns a value as the text of a cell. The caller frees it. */
static char *make_cell_text(const json_t *value)
{
    if (json_is_string(value))
        return xstrdup(json_string_value(value));
    return !value || json_is_null(value)
             ? xstrdup("")
             : json_dumps(value, JSON_COMPACT | JSON_ENCODE_ANY | JSON_REAL_PRECISION(9));
}

/* Called for each column of a case, with heading and value. */
typedef void sweep_cell(void *ctx, const char *head, const json_t *value);

static void for_each_cell(const struct sweep *sweep, const json_t *line, sweep_cell *cell,
                          void *ctx)
{
    const json_t *outputs = sweep_outputs(sweep), *find = json_object_get(line, "find");
    cell(ctx, "case", json_object_get(line, "case"));
    for (size_t i = 0; i < sweep->axis_count; i++)
        cell(ctx, sweep->axis[i].name,
             json_object_get(json_object_get(line, "values"), sweep->axis[i].name));
    cell(ctx, "status", json_object_get(line, "status"));
    if (sweep->search.is_present) {
        cell(ctx, "above", json_object_get(find, "low"));
        cell(ctx, "threshold", json_object_get(find, "high"));
    }
    for (size_t i = 0; i < json_array_size(outputs); i++) {
        const char *field = json_string_value(json_array_get(outputs, i));
        cell(ctx, field, json_object_get(json_object_get(line, "result"), field));
    }
}

static void add_cell(void *ctx, const char *head, const json_t *value)
{
    char *text = make_cell_text(value);
    answer_add_text(ctx, NULL, head, "%s", text);
    free(text);
}

struct answer *sweep_table_to_answer(const struct sweep_table *table, bool rows)
{
    struct answer *answer = answer_new(false);
    const char *name = json_string_value(json_object_get(table->sweep->root, "name"));
    json_t *lines = json_array();
    answer_add_text(answer, NULL, "sweep", "%s", name ? name : "no name");
    answer_add_count(answer, "cases", "cases", (int64_t)table->line_count);
    answer_append_remark(answer, " of %zu", table->sweep->case_count);
    answer_add_count(answer, "failed", "failed", (int64_t)table->failed_count);
    answer_add_count(answer, "missing", "missing", (int64_t)table->missing_count);
    answer_add_count(answer, "repeated", table->repeated_count ? "repeated" : NULL,
                     (int64_t)table->repeated_count);
    add_failures(answer, table);
    if (table->sweep->sensitivity_point_count)
        add_all_sensitivities(answer, table);
    answer_open_table(answer, NULL, "all cases");
    for (size_t i = 0; i < table->sweep->case_count; i++) {
        if (!table->line[i])
            continue;
        json_array_append(lines, table->line[i]);
        if (!rows)
            continue;
        answer_open_row(answer);
        for_each_cell(table->sweep, table->line[i], add_cell, answer);
    }
    answer_close_group(answer);
    answer_add_json(answer, "rows", lines);
    return answer;
}

struct csv_writer {
    FILE *out;
    bool is_writing_header, has_cells;
};

static void write_csv_cell(void *ctx, const char *head, const json_t *value)
{
    struct csv_writer *csv = ctx;
    char *text = csv->is_writing_header ? xstrdup(head) : make_cell_text(value);
    fputs(csv->has_cells ? "," : "", csv->out);
    csv_write_cell(csv->out, text);
    csv->has_cells = true;
    free(text);
}

void sweep_table_write_csv(const struct sweep_table *table, FILE *out)
{
    for_each_cell(table->sweep, NULL, write_csv_cell,
                  &(struct csv_writer){.out = out, .is_writing_header = true});
    fputc('\n', out);
    for (size_t i = 0; i < table->sweep->case_count; i++) {
        if (!table->line[i])
            continue;
        for_each_cell(table->sweep, table->line[i], write_csv_cell,
                      &(struct csv_writer){.out = out});
        fputc('\n', out);
    }
}
