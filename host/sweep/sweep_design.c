#include "host/sweep/sweep_design.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/splitmix.h"
#include "host/base/quantity.h"

#define LEVELS_MAX 1000000

uint64_t fnv1a(uint64_t hash, const void *bytes, size_t size)
{
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ byte[i]) * 0x100000001b3u;
    return hash;
}

static double design_round(double value)
{
    char text[40];
    snprintf(text, sizeof text, "%.12g", value);
    return strtod(text, NULL);
}

json_t *design_json(double value)
{
    return value == floor(value) && fabs(value) < 1e15 ? json_integer((json_int_t)value)
                                                       : json_real(value);
}

static enum mr_status read_number(const json_t *object, const char *key, const char *unit,
                                  const char *where, double *number, struct error *error)
{
    const json_t *value = json_object_get(object, key);
    struct quantity_wrong wrong;
    if (quantity_json(value, unit, number, &wrong))
        return MR_OK;
    if (json_is_string(value) && *unit)
        return error_set(error, MR_MALFORMED, "%s: %s: %s is \"%s\"; %s", wrong.what, where, key,
                         json_string_value(value), wrong.advice);
    return error_set(
        error, MR_MALFORMED,
        "%s: %s has no number \"%s\"; give a list, or {\"from\": A, \"to\": B, \"count\": N}",
        value ? "wrong type" : "something is missing", where, key);
}

static enum mr_status read_scale(struct design_range *range, const json_t *value, const char *where,
                                 struct error *error)
{
    const json_t *scale = json_object_get(value, "scale");
    const char *name = scale ? json_string_value(scale) : "linear";
    if (!name ||
        (strcmp(name, "linear") != 0 && strcmp(name, "log") != 0 && strcmp(name, "whole") != 0))
        return error_set(error, MR_MALFORMED,
                         "unknown choice: %s: scale; give \"linear\", \"log\" or \"whole\"", where);
    range->log = strcmp(name, "log") == 0;
    range->whole = strcmp(name, "whole") == 0;
    if (range->whole && (range->from != floor(range->from) || range->to != floor(range->to)))
        return error_set(error, MR_MALFORMED,
                         "value out of range: %s goes from %g to %g; give whole ends", where,
                         range->from, range->to);
    if (range->log && !(range->from > 0.0 && range->to > 0.0))
        return error_set(error, MR_MALFORMED,
                         "value out of range: %s goes from %g to %g; a log range lies above 0",
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
    if (range->from == range->to)
        return error_set(error, MR_MALFORMED,
                         "value out of range: %s goes from %g to %g; give two different ends",
                         where, range->from, range->to);
    return read_count(range, value, where, error);
}

void design_range_free(struct design_range *range)
{
    json_decref(range->levels);
    range->levels = NULL;
}

size_t design_levels(const struct design_range *range)
{
    return range->levels ? json_array_size(range->levels) : range->count;
}

double design_number(const struct design_range *range, double u)
{
    if (range->whole) {
        double low = fmin(range->from, range->to), high = fmax(range->from, range->to);
        double part = range->from < range->to ? u : 1.0 - u;
        return fmin(low + floor(part * (high - low + 1.0)), high);
    }
    double value = range->log ? range->from * pow(range->to / range->from, u)
                              : range->from + (range->to - range->from) * u;
    return design_round(u <= 0.0 ? range->from : u >= 1.0 ? range->to : value);
}

json_t *design_level(const struct design_range *range, size_t i)
{
    if (range->levels)
        return json_incref(json_array_get(range->levels, i));
    return design_json(design_number(range, (double)i / (double)(range->count - 1)));
}

json_t *design_at(const struct design_range *range, double u)
{
    if (!range->levels)
        return design_json(design_number(range, u));
    size_t count = json_array_size(range->levels);
    size_t i = (size_t)(u * (double)count);
    return json_incref(json_array_get(range->levels, i < count ? i : count - 1));
}

void design_latin(double *u, size_t n, uint64_t seed, const char *name)
{
    uint64_t state = fnv1a(fnv1a(FNV_BASIS, &seed, sizeof seed), name, strlen(name));
    for (size_t i = 0; i < n; i++)
        u[i] = (double)i;
    for (size_t i = n; i > 1; i--) { /* Fisher and Yates */
        size_t k = (size_t)(mr_splitmix64_uniform(&state) * (double)i);
        double swapped = u[i - 1];
        u[i - 1] = u[k];
        u[k] = swapped;
    }
    for (size_t i = 0; i < n; i++)
        u[i] = (u[i] + mr_splitmix64_uniform(&state)) / (double)n;
}

void design_radial(double *u, size_t n, size_t keys, size_t key, uint64_t seed, const char *name)
{
    design_latin(u, n, seed, name);
    design_latin(u + n, n, ~seed, name);
    for (size_t k = 0; k < keys; k++)
        memcpy(u + (2 + k) * n, k == key ? u + n : u, n * sizeof *u);
}
