#include "host/compare/limits.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/base/quantity.h"

#define PATH_MAX_LENGTH 200
#define SERIES_PREFIX   "series."

static enum mr_status refuse_limit(struct error *error, const char *file, const char *path,
                                   const char *what, const char *wanted)
{
    return error_set(error, MR_MALFORMED, "%s: %s: \"%.80s\"; give %s", what, file, path, wanted);
}

/* Returns the last part of a path. */
static const char *find_path_leaf(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot ? dot + 1 : path;
}

static bool is_lower_limit(const char *path)
{
    static const char *const names[] = {"share", "within"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (strcmp(find_path_leaf(path), names[i]) == 0)
            return true;
    }
    return false;
}

enum mr_status compare_limits_load(struct compare_limits *limits, const char *file,
                                   struct error *error)
{
    json_error_t where;
    const char *path;
    json_t *value, *root = json_load_file(file, JSON_REJECT_DUPLICATES, &where);
    if (!root && json_error_code(&where) == json_error_cannot_open_file)
        return error_set(error, MR_IO, "cannot read limits: %s; name a JSON file", file);
    if (!root)
        return error_set(error, MR_MALFORMED, "not valid JSON: %s line %d: %s; correct that line",
                         file, where.line, where.text);
    if (!json_is_object(root))
        refuse_limit(error, file, "", "not an object", "{\"channels.*.rms_in\": 0.05}");
    json_object_foreach(root, path, value)
    {
        double number;
        struct quantity_error no_number;
        if (path[0] == '_' || error->status != MR_OK)
            continue;
        if (json_is_object(value))
            refuse_limit(error, file, path, "not a limit",
                         "give a path and a number: \"channels.*.rms_in\": 0.05");
        else if (!quantity_read_json(value, quantity_unit_from_name(path), &number, &no_number))
            refuse_limit(error, file, path, no_number.what, no_number.advice);
        else if (!isfinite(number) || (number < 0.0 && !is_lower_limit(path)))
            refuse_limit(error, file, path, "not a limit", "a number, 0 or more");
        else if (strlen(path) >= PATH_MAX_LENGTH)
            refuse_limit(error, file, path, "no such path",
                         "give a path in the JSON output of matrig compare");
        else
            compare_limits_add(limits, path, number);
    }
    json_decref(root);
    if (error->status == MR_OK && !compare_has_limits(limits))
        error_set(error, MR_MALFORMED,
                  "no limits: %s; give at least one, such as {\"channels.*.rms_in\": 0.05}", file);
    return error->status;
}

void compare_limits_add(struct compare_limits *limits, const char *path, double most)
{
    limits->limit_by_path = limits->limit_by_path ? limits->limit_by_path : json_object();
    json_object_set_new(limits->limit_by_path, path, json_real(most));
}

bool compare_has_limits(const struct compare_limits *limits)
{
    return json_object_size(limits->limit_by_path) > 0;
}

void compare_limits_free(struct compare_limits *limits)
{
    json_decref(limits->limit_by_path);
    limits->limit_by_path = NULL;
}

/* ---- the result ---- */

struct limit_check {
    const struct compare_limits *limits;
    const char *pattern; /* path of the limit, with its wildcards */
    double limit;
    const char *answer_name;
    size_t found_value_count, skipped_value_count;
    struct compare_verdict *verdict;
};

/* Counts a failed limit. `beyond`: how far the value exceeds the limit; NaN: unknown. */
static void count_failed_limit(struct limit_check *check, double beyond, const char *text)
{
    struct compare_verdict *v = check->verdict;
    double size = isnan(beyond) ? (double)INFINITY : beyond / fmax(fabs(check->limit), 1e-12);
    if (v->failed_limit_count++ > 0 && !(size > v->worst_excess))
        return;
    v->worst_excess = size;
    snprintf(v->worst_failure, sizeof v->worst_failure, "%s", text);
}

static void check_value(struct limit_check *check, const char *path, const json_t *value)
{
    char text[300];
    bool least = is_lower_limit(path);
    double is = json_number_value(value),
           beyond = least ? check->limit - is : fabs(is) - check->limit;
    check->verdict->checked_limit_count++;
    if (!json_is_number(value)) {
        snprintf(text, sizeof text, "%s of %s is not known; the limit is %.4g", path,
                 check->answer_name, check->limit);
        count_failed_limit(check, (double)NAN, text);
    } else if (beyond > 0.0) {
        snprintf(text, sizeof text, "%s of %s is %.4f; the limit %.4f is %s by %.4f", path,
                 check->answer_name, is, check->limit, least ? "missed" : "exceeded", beyond);
        count_failed_limit(check, beyond, text);
    }
}

static void check_values(struct limit_check *check, const char *rest, const char *so_far,
                         const json_t *node);

/* Checks an element or a key of a value. `name` is added to the path in messages. */
static void check_members(struct limit_check *check, const char *rest, const char *so_far,
                          const char *name, const json_t *node)
{
    char path[2 * PATH_MAX_LENGTH];
    snprintf(path, sizeof path, "%s%s%s", so_far, so_far[0] ? "." : "", name);
    check_values(check, rest, path, node);
}

/* Writes the channel's number; without one, its position. */
static void format_element_name(const json_t *element, size_t index, char *name, size_t size)
{
    const json_t *number = json_object_get(element, "number");
    if (json_is_integer(number))
        snprintf(name, size, "%lld", (long long)json_integer_value(number));
    else
        snprintf(name, size, "%zu", index + 1);
}

static void check_values(struct limit_check *check, const char *rest, const char *so_far,
                         const json_t *node)
{
    char name[PATH_MAX_LENGTH], element_name[24];
    size_t length = strcspn(rest, "."), i;
    json_t *element;
    if (json_is_false(json_object_get(node, "compared"))) {
        check->skipped_value_count++; /* a channel that was not compared is reported as missing */
        return;
    }
    if (length == 0) {
        bool no_zone = json_is_null(node) && strstr(so_far, "overlap_") &&
                       strstr(so_far, "_difference");
        bool replaced = strcmp(so_far, check->pattern) != 0 &&
                        json_object_get(check->limits->limit_by_path, so_far);
        check->found_value_count++;
        if (!no_zone && !replaced)
            check_value(check, so_far, node);
        return;
    }
    snprintf(name, sizeof name, "%.*s", (int)length, rest);
    rest += length + (rest[length] == '.');
    if (json_is_object(node) && json_object_get(node, name)) {
        element = json_object_get(node, name);
        if (json_is_null(element) && *rest) { /* without a zone on one side there is no overlap */
            check->found_value_count++;
            if (!strstr(rest, "_difference"))
                check_value(check, so_far, element);
        } else {
            check_members(check, rest, so_far, name, element);
        }
    }
    json_array_foreach((json_t *)node, i, element)
    {
        format_element_name(element, i, element_name, sizeof element_name);
        if (strcmp(name, "*") == 0 || strcmp(name, element_name) == 0)
            check_members(check, rest, so_far, element_name, element);
    }
}

void compare_limits_check(const struct compare_limits *limits, bool of_series, const json_t *answer,
                          const json_t *si, const char *where, struct compare_verdict *verdict)
{
    const char *path;
    json_t *limit;
    bool channels = false;
    struct limit_check check = {.limits = limits, .answer_name = where, .verdict = verdict};
    json_object_foreach(limits->limit_by_path, path, limit)
    {
        bool series = strncmp(path, SERIES_PREFIX, strlen(SERIES_PREFIX)) == 0;
        if (series != of_series)
            continue;
        channels = channels || strncmp(path, "channels.", 9) == 0;
        check.pattern = path;
        check.limit = json_number_value(limit);
        check.found_value_count = check.skipped_value_count = 0;
        for (int pass = 0; pass < 2 && check.found_value_count == 0; pass++)
            check_values(&check, series ? path + strlen(SERIES_PREFIX) : path, "",
                         pass == 0 ? answer : si);
        if (check.found_value_count + check.skipped_value_count == 0) {
            char text[300];
            snprintf(
                text, sizeof text,
                "the result has no value %s: %s; matrig --json compare shows the possible paths",
                path, where);
            verdict->checked_limit_count++;
            count_failed_limit(&check, (double)NAN, text);
        }
    }
    check.pattern = "missing_channels";
    check.limit = 0.0;
    if (channels && !json_object_get(limits->limit_by_path, check.pattern))
        check_value(&check, check.pattern, json_object_get(answer, check.pattern));
}
