#include "host/sweep/sweep.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/splitmix.h"
#include "host/base/elementary.h"
#include "host/base/quantity.h"
#include "host/base/xmalloc.h"
#include "host/sim/scene/scene.h"
#include "host/landing_series/series.h"

/* ---- jsonpath ---- */

/* Reads the next part of a path, up to a dot. Returns false at the end of the path, or if the part
 * is empty or too long. */
static bool read_next_part(const char **path, char part[JSONPATH_MAX])
{
    size_t length = strcspn(*path, ".");
    if (length == 0 || length >= JSONPATH_MAX)
        return false;
    memcpy(part, *path, length);
    part[length] = '\0';
    *path += length;
    if (**path == '.')
        (*path)++;
    return true;
}

static bool parse_list_index(const json_t *list, const char *part, size_t *place)
{
    char *end;
    long number = strtol(part, &end, 10);
    long size = (long)json_array_size(list);
    if (*end != '\0' || end == part || number >= size || number < -size)
        return false;
    *place = (size_t)(number < 0 ? number + size : number);
    return true;
}

static json_t *get_child(const json_t *parent, const char *part)
{
    size_t place;
    if (json_is_object(parent))
        return json_object_get(parent, part);
    return json_is_array(parent) && parse_list_index(parent, part, &place)
             ? json_array_get(parent, place)
             : NULL;
}

static bool set_child(json_t *parent, const char *part, json_t *value)
{
    size_t place;
    if (json_is_object(parent))
        return json_object_set_new(parent, part, value) == 0;
    if (json_is_array(parent) && parse_list_index(parent, part, &place))
        return json_array_set_new(parent, place, value) == 0;
    json_decref(value);
    return false;
}

json_t *jsonpath_get(const json_t *root, const char *path)
{
    char part[JSONPATH_MAX];
    json_t *found = NULL;
    while (*path) {
        if (!read_next_part(&path, part))
            return NULL;
        found = get_child(root, part);
        if (!found)
            return NULL;
        root = found;
    }
    return found;
}

bool jsonpath_set(json_t *object, const char *path, json_t *value)
{
    char part[JSONPATH_MAX];
    json_t *at = object;
    while (read_next_part(&path, part)) {
        if (!*path)
            return set_child(at, part, json_deep_copy(value));
        json_t *inner = json_copy(get_child(at, part));
        if (!inner)
            return false;
        if (!set_child(at, part, inner))
            return false;
        at = inner; /* the parent object now owns the new one */
    }
    return false;
}

/* ---- sweep design ---- */

#define LEVELS_MAX 1000000

uint64_t fnv1a_hash(uint64_t hash, const void *bytes, size_t size)
{
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ byte[i]) * 0x100000001b3u;
    return hash;
}

static double round_design_value(double value)
{
    char text[40];
    snprintf(text, sizeof text, "%.12g", value);
    return strtod(text, NULL);
}

/* Returns whole numbers as JSON integers, other numbers as reals. */
static json_t *make_design_json(double value)
{
    return value == floor(value) && fabs(value) < 1e15 ? json_integer((json_int_t)value)
                                                       : json_real(value);
}

static enum mr_status read_number(const json_t *object, const char *key, const char *unit,
                                  const char *where, double *number, struct error *error)
{
    const json_t *value = json_object_get(object, key);
    struct quantity_error wrong;
    if (quantity_read_json(value, unit, number, &wrong))
        return MR_OK;
    bool text = json_is_string(value) && *unit;
    return error_set(error, MR_MALFORMED, "%s: %s: \"%s\" is not a number%s%s; %s",
                     !value ? "key missing"
                     : text ? wrong.what
                            : "wrong type",
                     where, key, *unit ? " in " : "", unit,
                     text ? wrong.advice
                          : "give a list, or {\"from\": A, \"to\": B, \"count\": N}");
}

static enum mr_status read_scale(struct design_range *range, const json_t *value, const char *where,
                                 struct error *error)
{
    const json_t *scale = json_object_get(value, "scale");
    const char *name = scale ? json_string_value(scale) : "linear";
    if (!name ||
        (strcmp(name, "linear") != 0 && strcmp(name, "log") != 0 && strcmp(name, "whole") != 0))
        return error_set(error, MR_MALFORMED,
                         "unknown scale: %s; give \"linear\", \"log\" or \"whole\"", where);
    range->is_logarithmic = strcmp(name, "log") == 0;
    range->is_integer = strcmp(name, "whole") == 0;
    if (range->from == range->to ||
        (range->is_integer &&
         (range->from != floor(range->from) || range->to != floor(range->to))) ||
        (range->is_logarithmic && !(range->from > 0.0 && range->to > 0.0)))
        return error_set(error, MR_MALFORMED,
                         "value out of range: %s has the range %g to %g; give two different ends "
                         "(whole numbers for scale whole; above 0 for scale log)",
                         where, range->from, range->to);
    return MR_OK;
}

static enum mr_status read_count(struct design_range *range, const json_t *value, const char *where,
                                 struct error *error)
{
    const json_t *count = json_object_get(value, "count");
    if (!count)
        return MR_OK;
    if (!json_is_integer(count) || json_integer_value(count) < 2 ||
        json_integer_value(count) > LEVELS_MAX)
        return error_set(error, MR_MALFORMED,
                         "value out of range: %s: count; give a whole number, 2 to %d", where,
                         LEVELS_MAX);
    range->count = (size_t)json_integer_value(count);
    return MR_OK;
}

enum mr_status design_range_read(struct design_range *range, const json_t *value, const char *unit,
                                 const char *where, struct error *error)
{
    *range = (struct design_range){0};
    if (json_is_array(value)) {
        if (json_array_size(value) == 0 || json_array_size(value) > LEVELS_MAX)
            return error_set(error, MR_MALFORMED,
                             "list of the wrong length: %s has %zu values; give 1 to %d", where,
                             json_array_size(value), LEVELS_MAX);
        range->levels = json_incref((json_t *)(uintptr_t)value);
        return MR_OK;
    }
    if (!json_is_object(value))
        return error_set(error, MR_MALFORMED,
                         "wrong type: %s; give a list, or {\"from\": A, \"to\": B, \"count\": N}",
                         where);
    if (read_number(value, "from", unit, where, &range->from, error) != MR_OK ||
        read_number(value, "to", unit, where, &range->to, error) != MR_OK ||
        read_scale(range, value, where, error) != MR_OK)
        return error->status;
    return read_count(range, value, where, error);
}

static void design_range_free(struct design_range *range)
{
    json_decref(range->levels);
    range->levels = NULL;
}

/* Returns the number of levels: the length of the list, or else `count`. */
static size_t count_design_levels(const struct design_range *range)
{
    return range->levels ? json_array_size(range->levels) : range->count;
}

double design_number(const struct design_range *range, double u)
{
    if (range->is_integer) {
        double low = fmin(range->from, range->to), high = fmax(range->from, range->to);
        double part = range->from < range->to ? u : 1.0 - u;
        return fmin(low + floor(part * (high - low + 1.0)), high);
    }
    double value = range->is_logarithmic ? range->from * elementary_pow(range->to / range->from, u)
                                         : range->from + (range->to - range->from) * u;
    return round_design_value(u <= 0.0 ? range->from : u >= 1.0 ? range->to : value);
}

json_t *design_level(const struct design_range *range, size_t i)
{
    if (range->levels)
        return json_incref(json_array_get(range->levels, i));
    return make_design_json(design_number(range, (double)i / (double)(range->count - 1)));
}

/* Returns the value at the fraction u (0 to 1) of the range; for a list, the level at u. The caller
 * owns the reference. */
static json_t *get_design_value(const struct design_range *range, double u)
{
    if (!range->levels)
        return make_design_json(design_number(range, u));
    size_t count = json_array_size(range->levels);
    size_t i = (size_t)(u * (double)count);
    return json_incref(json_array_get(range->levels, i < count ? i : count - 1));
}

/* Fills u with a Latin hypercube: n values in [0, 1), one from each of n equal intervals, in random
 * order. They depend only on seed and name, so another key, or another order of the keys, does not
 * change them. */
static void fill_design_latin(double *u, size_t n, uint64_t seed, const char *name)
{
    uint64_t state = fnv1a_hash(fnv1a_hash(FNV_BASIS, &seed, sizeof seed), name, strlen(name));
    for (size_t i = 0; i < n; i++)
        u[i] = (double)i;
    for (size_t i = n; i > 1; i--) { /* Fisher-Yates shuffle */
        size_t k = (size_t)(mr_splitmix64_uniform(&state) * (double)i);
        double swapped = u[i - 1];
        u[i - 1] = u[k];
        u[k] = swapped;
    }
    for (size_t i = 0; i < n; i++)
        u[i] = (u[i] + mr_splitmix64_uniform(&state)) / (double)n;
}

void design_fill_radial(double *u, size_t n, size_t keys, size_t key, uint64_t seed,
                        const char *name)
{
    fill_design_latin(u, n, seed, name);
    fill_design_latin(u + n, n, ~seed, name);
    for (size_t k = 0; k < keys; k++)
        memcpy(u + (2 + k) * n, k == key ? u + n : u, n * sizeof *u);
}

/* ---- sweep ---- */

#define SCAN_PARTS_MAX 1000

/* ---- base and keys ---- */

/* Inserts the scene and the elastic ground that a study names, and its optional parts, so that
 * their keys can be varied too. */
static enum mr_status insert_study_parts(struct sweep *sweep, const char *file, struct error *error)
{
    static const char *const parts[] = {"runway", "aircraft", "engine"};
    static const char *const named[] = {"scene", "elastic"};
    for (size_t i = 0; i < sizeof named / sizeof named[0]; i++) {
        json_t *part = json_object_get(sweep->base, named[i]);
        if (!json_is_string(part))
            continue;
        part = series_read_json(file, json_string_value(part), named[i], error);
        if (!part)
            return error->status;
        json_object_set_new(sweep->base, named[i], part);
    }
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++) {
        if (!json_object_get(sweep->base, parts[i]))
            json_object_set_new(sweep->base, parts[i], json_object());
    }
    return MR_OK;
}

/* If the base is a file name, inserts the file, so that the sweep is complete. */
static enum mr_status read_base(struct sweep *sweep, const char *path, struct error *error)
{
    json_t *base = json_object_get(sweep->root, "base");
    char file[PATH_MAX]; /* path of the file with the scene of a study */
    snprintf(file, sizeof file, "%s", path);
    if (json_is_string(base)) {
        json_object_set_new(sweep->root, "_base_file", json_copy(base));
        series_make_sibling_path(path, json_string_value(base), file);
        base = series_read_json(path, json_string_value(base), "base", error);
        if (!base)
            return error->status;
        json_object_set_new(sweep->root, "base", base);
    }
    if (!json_is_object(base))
        return error_set(error, MR_MALFORMED,
                         "%s: %s: base; give the name of a scene or study file, or its content",
                         base ? "wrong type" : "key missing", path);
    sweep->base = base;
    sweep->is_study = json_object_get(base, "landings") != NULL;
    return sweep->is_study ? insert_study_parts(sweep, file, error) : MR_OK;
}

/* Refuses an unknown key of a scene, because every case would fail. Keys of a study are paths; the
 * first case shows whether they are valid. */
static enum mr_status check_varied_key(const struct sweep *sweep, const char *where,
                                       const char *key, struct error *error)
{
    char first[JSONPATH_MAX];
    snprintf(first, sizeof first, "%.*s", (int)strcspn(key, "."), key);
    if (!sweep->is_study && !sim_key_find(first))
        return error_set(error, MR_MALFORMED,
                         "unknown key: %s: a scene has no key \"%s\"; correct the key, or use "
                         "\"set\" to name the keys of the scene that this name sets",
                         where, key);
    return MR_OK;
}

static bool is_scale_factor(const json_t *factor)
{
    if (json_is_number(factor))
        return true;
    for (size_t i = 0; i < json_array_size(factor); i++) {
        if (!json_is_number(json_array_get(factor, i)))
            return false;
    }
    return json_array_size(factor) > 0;
}

static enum mr_status read_axis_factors(struct sweep *sweep, struct sweep_axis *axis,
                                        const json_t *value, const char *where, struct error *error)
{
    const char *key;
    json_t *factor;
    axis->factors = json_is_object(value) ? json_object_get(value, "set") : NULL;
    if (!axis->factors)
        return check_varied_key(sweep, where, axis->name, error);
    if (!json_is_object(axis->factors) || json_object_size(axis->factors) == 0)
        return error_set(error, MR_MALFORMED,
                         "wrong type: %s: value of the key set; give {\"KEY\": FACTOR} or "
                         "{\"KEY\": [FACTOR, ...]}",
                         where);
    json_object_foreach(axis->factors, key, factor)
    {
        if (!is_scale_factor(factor))
            return error_set(error, MR_MALFORMED,
                             "wrong type: %s: key %s of set; give a number or a list of numbers",
                             where, key);
        if (check_varied_key(sweep, where, key, error) != MR_OK)
            return error->status;
    }
    for (size_t i = 0; i < json_array_size(axis->range.levels); i++) {
        if (!json_is_number(json_array_get(axis->range.levels, i)))
            return error_set(error, MR_MALFORMED,
                             "wrong type: %s: value %zu; give numbers, because \"set\" multiplies",
                             where, i);
    }
    return MR_OK;
}

/* Returns the unit of a scene's key; of another key, the unit with which its name ends
 * ("aircraft.weight_lb"). */
static const char *get_axis_unit(const struct sweep *sweep, const char *name)
{
    const struct sim_key *key = !sweep->is_study ? sim_key_find(name) : NULL;
    const char *unit = key ? key->unit : quantity_unit_from_name(name);
    return quantity_kind_find(unit) ? unit : "";
}

/* Reads an axis: a list of values, or an object with "values" (required for a list with "set") or a
 * range. */
static enum mr_status read_axis(struct sweep *sweep, struct sweep_axis *axis, const char *path,
                                const char *part, const char *name, const json_t *value,
                                struct error *error)
{
    char where[PATH_MAX + 100];
    const json_t *values = json_is_object(value) ? json_object_get(value, "values") : NULL;
    *axis = (struct sweep_axis){0};
    snprintf(where, sizeof where, "%s: %s %s", path, part, name);
    if (strlen(name) >= sizeof axis->name || name[0] == '\0')
        return error_set(error, MR_MALFORMED, "name too long: %s; give 1 to %d letters", where,
                         SWEEP_NAME_MAX - 1);
    snprintf(axis->name, sizeof axis->name, "%s", name);
    if (design_range_read(&axis->range, values ? values : value, get_axis_unit(sweep, name), where,
                          error) != MR_OK)
        return error->status;
    return read_axis_factors(sweep, axis, value, where, error);
}

static enum mr_status add_axis(struct sweep *sweep, const char *path, const char *part,
                               const char *name, const json_t *value, struct error *error)
{
    if (sweep->axis_count == SWEEP_AXES_MAX)
        return error_set(error, MR_MALFORMED,
                         "too many keys: %s: %s varies more than %d keys; vary fewer", path, part,
                         SWEEP_AXES_MAX);
    for (size_t i = 0; i < sweep->axis_count; i++) {
        if (strcmp(sweep->axis[i].name, name) == 0)
            return error_set(
                error, MR_MALFORMED,
                "given twice: %s: \"%s\" is in vary and in %s; give this key only once", path, name,
                part);
    }
    return read_axis(sweep, &sweep->axis[sweep->axis_count++], path, part, name, value, error);
}

static enum mr_status read_varied_axes(struct sweep *sweep, const char *path, struct error *error)
{
    const json_t *vary = json_object_get(sweep->root, "vary");
    const char *name;
    json_t *value;
    sweep->grid_case_count = 1;
    if (vary && !json_is_object(vary))
        return error_set(error, MR_MALFORMED,
                         "wrong type: %s: the value of \"vary\"; give {\"KEY\": [VALUE, ...], ...}",
                         path);
    json_object_foreach((json_t *)(uintptr_t)vary, name, value)
    {
        if (name[0] == '_')
            continue;
        if (add_axis(sweep, path, "vary", name, value, error) != MR_OK)
            return error->status;
        size_t levels = count_design_levels(&sweep->axis[sweep->axis_count - 1].range);
        if (levels == 0)
            return error_set(error, MR_MALFORMED, "key missing: %s: vary %s; give \"count\"", path,
                             name);
        if (sweep->grid_case_count > SWEEP_CASES_MAX / levels)
            return error_set(error, MR_MALFORMED,
                             "too many cases: %s: more than %d; split the sweep", path,
                             SWEEP_CASES_MAX);
        sweep->grid_case_count *= levels;
    }
    return MR_OK;
}

static size_t count_keys(const json_t *keys)
{
    size_t count = 0;
    const char *name;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)keys, name, value) count += name[0] != '_';
    return count;
}

/* Reads the sampled keys from the part `lhs` or `sobol`. */
static enum mr_status read_sampled_axes(struct sweep *sweep, const char *path, const char *part,
                                        struct error *error)
{
    const json_t *sampled = json_object_get(sweep->root, part), *n = json_object_get(sampled, "n"),
                 *seed = json_object_get(sampled, "seed");
    const json_t *keys = json_object_get(sampled, "keys");
    const char *name;
    json_t *value;
    bool indices = strcmp(part, "sobol") == 0;
    size_t count = json_is_object(keys) ? count_keys(keys) : 0, key = 0;
    if (count == 0 || !json_is_integer(n) || json_integer_value(n) < 1 ||
        json_integer_value(n) > SWEEP_CASES_MAX || !json_is_integer(seed))
        return error_set(error, MR_MALFORMED,
                         "wrong type: %s: %s; give {\"n\": SAMPLES, \"seed\": NUMBER, \"keys\": "
                         "{\"KEY\": {\"from\": A, \"to\": B}}}",
                         path, part);
    size_t points = (size_t)json_integer_value(n);
    sweep->sensitivity_point_count = indices ? points : 0;
    sweep->sample_count = indices ? points * (count + 2) : points;
    if (sweep->grid_case_count > SWEEP_CASES_MAX / sweep->sample_count)
        return error_set(error, MR_MALFORMED, "too many cases: %s: more than %d; split the sweep",
                         path, SWEEP_CASES_MAX);
    json_object_foreach((json_t *)(uintptr_t)keys, name, value)
    {
        if (name[0] == '_')
            continue;
        if (add_axis(sweep, path, part, name, value, error) != MR_OK)
            return error->status;
        struct sweep_axis *axis = &sweep->axis[sweep->axis_count - 1];
        if (indices && axis->range.levels)
            return error_set(error, MR_MALFORMED,
                             "wrong type: %s: %s is a list; give a range, which a Sobol sweep "
                             "needs so that all cases differ",
                             path, name);
        axis->sample_fractions = xcalloc(sweep->sample_count, sizeof *axis->sample_fractions);
        if (indices)
            design_fill_radial(axis->sample_fractions, points, count, key++,
                               (uint64_t)json_integer_value(seed), name);
        else
            fill_design_latin(axis->sample_fractions, points, (uint64_t)json_integer_value(seed),
                              name);
    }
    return MR_OK;
}

static enum mr_status read_sampling_design(struct sweep *sweep, const char *path,
                                           struct error *error)
{
    bool lhs = json_object_get(sweep->root, "lhs"), sobol = json_object_get(sweep->root, "sobol");
    sweep->sample_count = 1;
    if (lhs && sobol)
        return error_set(error, MR_MALFORMED, "given twice: %s: lhs and sobol; give only one",
                         path);
    return lhs || sobol ? read_sampled_axes(sweep, path, lhs ? "lhs" : "sobol", error) : MR_OK;
}

/* ---- the search ---- */

static enum mr_status read_search(struct sweep *sweep, const char *path, struct error *error)
{
    json_t *root = json_object_get(sweep->root, "find"), *when = NULL;
    struct sweep_search *find = &sweep->search;
    const char *name;
    double above = (double)NAN, below = (double)NAN, scan = 8.0;
    int is = -1;
    json_error_t wrong = {.text = ""};
    if (!root)
        return MR_OK;
    find->tolerance = 0.01;
    if (json_unpack_ex(root, &wrong, 0, "{s:s,s:s,s?F,s?F,s?b,s?F,s?F,s?o}", "key", &name, "field",
                       &find->field, "above", &above, "below", &below, "is", &is, "scan", &scan,
                       "tolerance", &find->tolerance, "beyond_when", &when) != 0 ||
        !isnan(above) + !isnan(below) + (is >= 0) != 1 ||
        !(scan >= 1.0 && scan <= SCAN_PARTS_MAX) ||
        !(find->tolerance >= 1e-9 && find->tolerance <= 1.0) || (when && !json_is_array(when)))
        return error_set(error, MR_MALFORMED,
                         "wrong value: %s: find: %s; give {\"key\": KEY, \"from\": A, \"to\": B, "
                         "\"field\": FIELD, and one of \"above\": NUMBER, \"below\": NUMBER, "
                         "\"is\": true or false}; \"scan\" is 1 to %d, \"tolerance\" at most 1, "
                         "\"beyond_when\" a list",
                         path,
                         wrong.text[0]
                             ? wrong.text
                             : "the number of conditions is not one, or a value is out of range",
                         SCAN_PARTS_MAX);
    if (read_axis(sweep, &find->key, path, "find", name, root, error) != MR_OK)
        return error->status;
    if (find->key.range.levels || find->key.range.from > find->key.range.to)
        return error_set(error, MR_MALFORMED,
                         "value out of range: %s: find %s; give \"from\" below \"to\"", path, name);
    for (size_t i = 0; i < sweep->axis_count; i++) {
        if (strcmp(sweep->axis[i].name, name) == 0)
            return error_set(error, MR_MALFORMED,
                             "given twice: %s: \"%s\" is both varied and searched; remove one",
                             path, name);
    }
    find->passing_statuses = when;
    find->is_passed_downward = !isnan(below) || is == 0;
    find->level = is >= 0 ? 0.5 : isnan(above) ? below : above;
    find->part_count = (unsigned)scan;
    find->is_present = true;
    return MR_OK;
}

static enum mr_status read_outputs(struct sweep *sweep, const char *path, struct error *error)
{
    const json_t *outputs = json_object_get(sweep->root, "outputs");
    if (!outputs && sweep->search.is_present)
        return MR_OK;
    for (size_t i = 0; i < json_array_size(outputs); i++) {
        const char *name = json_string_value(json_array_get(outputs, i));
        if (!name || !*name || strlen(name) >= JSONPATH_MAX)
            return error_set(error, MR_MALFORMED,
                             "wrong type: %s: outputs[%zu]; give the name of a field of the result",
                             path, i);
    }
    if (json_array_size(outputs) > 0)
        return MR_OK;
    return error_set(error, MR_MALFORMED,
                     "key missing: %s: outputs; list fields that matrig --json %s prints, as "
                     "[\"FIELD\", ...]",
                     path, sweep->is_study ? "study" : "sim");
}

static enum mr_status check_key_names(const struct sweep *sweep, const char *path,
                                      struct error *error)
{
    static const char *const known[] = {"name", "base", "vary", "lhs", "sobol", "find", "outputs"};
    const char *name;
    json_t *value;
    json_object_foreach(sweep->root, name, value)
    {
        bool found = name[0] == '_';
        for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
            found |= strcmp(name, known[i]) == 0;
        if (!found)
            return error_set(error, MR_MALFORMED,
                             "unknown key: %s: \"%s\"; correct the key (host/sweep/README.md lists "
                             "the keys), or write _%s for a comment",
                             path, name, name);
    }
    return MR_OK;
}

/* ---- input of a case ---- */

/* Returns the value of an axis in a case. From case to case, the sample changes fastest, then the
 * last key of the Cartesian part. */
static json_t *get_axis_value(const struct sweep *sweep, size_t axis, size_t index)
{
    const struct sweep_axis *a = &sweep->axis[axis];
    if (a->sample_fractions)
        return get_design_value(&a->range, a->sample_fractions[index % sweep->sample_count]);
    size_t place = index / sweep->sample_count;
    for (size_t k = sweep->axis_count; k-- > axis + 1;) {
        if (!sweep->axis[k].sample_fractions)
            place /= count_design_levels(&sweep->axis[k].range);
    }
    return design_level(&a->range, place % count_design_levels(&a->range));
}

json_t *sweep_case_values(const struct sweep *sweep, size_t index)
{
    json_t *values = json_object();
    for (size_t i = 0; i < sweep->axis_count; i++)
        json_object_set_new(values, sweep->axis[i].name, get_axis_value(sweep, i, index));
    return values;
}

static json_t *multiply_json(const json_t *factor, double value)
{
    if (json_is_number(factor))
        return make_design_json(json_number_value(factor) * value);
    json_t *list = json_array();
    for (size_t i = 0; i < json_array_size(factor); i++)
        json_array_append_new(
            list, make_design_json(json_number_value(json_array_get(factor, i)) * value));
    return list;
}

static bool apply_value(const struct sweep_axis *axis, json_t *input, json_t *value)
{
    const char *key;
    json_t *factor;
    if (!axis->factors)
        return jsonpath_set(input, axis->name, value);
    bool done = true;
    json_object_foreach(axis->factors, key, factor)
    {
        json_t *product = multiply_json(factor, json_number_value(value));
        done &= jsonpath_set(input, key, product);
        json_decref(product);
    }
    return done;
}

json_t *sweep_case_input(const struct sweep *sweep, size_t index)
{
    json_t *input = json_copy(sweep->base);
    bool done = true;
    for (size_t i = 0; i < sweep->axis_count; i++) {
        json_t *value = get_axis_value(sweep, i, index);
        done &= apply_value(&sweep->axis[i], input, value);
        json_decref(value);
    }
    if (done)
        return input;
    json_decref(input);
    return NULL;
}

json_t *sweep_input_with_value(const struct sweep *sweep, const json_t *input, double value)
{
    json_t *at = json_copy((json_t *)(uintptr_t)input), *number = make_design_json(value);
    bool done = apply_value(&sweep->search.key, at, number);
    json_decref(number);
    if (done)
        return at;
    json_decref(at);
    return NULL;
}

const json_t *sweep_outputs(const struct sweep *sweep)
{
    return json_object_get(sweep->root, "outputs");
}

/* ---- loading a sweep ---- */

static uint64_t hash_json(const json_t *root)
{
    char *text = json_dumps(root, JSON_COMPACT | JSON_SORT_KEYS | JSON_REAL_PRECISION(17));
    uint64_t hash = fnv1a_hash(FNV_BASIS, text, strlen(text));
    free(text);
    return hash;
}

static enum mr_status check_first_case(const struct sweep *sweep, const char *path,
                                       struct error *error)
{
    char where[PATH_MAX + 40];
    struct sim_scene scene;
    struct landing_series series;
    json_t *input = sweep_case_input(sweep, 0);
    if (input && sweep->search.is_present) {
        json_t *at = sweep_input_with_value(sweep, input, sweep->search.key.range.from);
        json_decref(input);
        input = at;
    }
    if (!input)
        return error_set(
            error, MR_MALFORMED,
            "no such key: %s: the base has no value at the path of this key; correct the key",
            path);
    snprintf(where, sizeof where, "%s: first case", path);
    if (sweep->is_study) {
        if (series_from_json(&series, where, input, error) == MR_OK)
            series_free(&series);
    } else if (sim_scene_from_json(&scene, where, input, error) == MR_OK) {
        sim_scene_free(&scene);
    }
    json_decref(input);
    return error->status;
}

static enum mr_status read_file(struct sweep *sweep, const char *path, struct error *error)
{
    if (check_key_names(sweep, path, error) != MR_OK || read_base(sweep, path, error) != MR_OK ||
        read_varied_axes(sweep, path, error) != MR_OK ||
        read_sampling_design(sweep, path, error) != MR_OK ||
        read_search(sweep, path, error) != MR_OK || read_outputs(sweep, path, error) != MR_OK)
        return error->status;
    if (sweep->axis_count == 0)
        return error_set(error, MR_MALFORMED,
                         "key missing: %s varies no key; give \"vary\", \"lhs\" or \"sobol\"",
                         path);
    sweep->case_count = sweep->grid_case_count * sweep->sample_count;
    sweep->hash = hash_json(sweep->root);
    return check_first_case(sweep, path, error);
}

enum mr_status sweep_load(struct sweep *sweep, const char *path, struct error *error)
{
    *sweep = (struct sweep){0};
    sweep->root = series_read_json(NULL, path, "sweep", error);
    if (!sweep->root || read_file(sweep, path, error) != MR_OK)
        sweep_free(sweep);
    return error->status;
}

void sweep_free(struct sweep *sweep)
{
    for (size_t i = 0; i < sweep->axis_count; i++) {
        design_range_free(&sweep->axis[i].range);
        free(sweep->axis[i].sample_fractions);
    }
    design_range_free(&sweep->search.key.range);
    json_decref(sweep->root);
    *sweep = (struct sweep){0};
}
