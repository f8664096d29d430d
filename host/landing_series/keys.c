#include "host/landing_series/keys.h"

#include <stdio.h>
#include <string.h>

#include "host/base/quantity.h"

bool keys_failed(const struct keys *keys)
{
    return keys->error->status != MR_OK;
}

void keys_wrong(const struct keys *keys, const char *where, const char *key, const char *wanted)
{
    error_set(keys->error, MR_MALFORMED, "wrong value: %s: %s%s%s; give %s", keys->path, where,
              where[0] ? "." : "", key, wanted);
}

void keys_check(const struct keys *keys, const char *where, const json_t *object,
                const char *const *known)
{
    const char *name;
    json_t *value;
    if (!json_is_object(object)) {
        keys_wrong(keys, where, "", "an object, {...}");
        return;
    }
    json_object_foreach((json_t *)object, name, value)
    {
        size_t i = 0;
        while (known[i] && strcmp(known[i], name) != 0)
            i++;
        if (!known[i] && name[0] != '_')
            error_set(
                keys->error, MR_MALFORMED,
                "unknown key: %s: %s%s\"%s\"; correct it (host/landing_series/README.md lists the "
                "keys), or write _%s "
                "for a comment",
                keys->path, where, where[0] ? "." : "", name, name);
    }
}

/* In the unit that the key's name ends with. False: no number, and not text with a unit of it. */
static bool read_number(const char *key, const json_t *entry, double *value)
{
    struct quantity_wrong wrong;
    return quantity_json(entry, quantity_unit_of_name(key), value, &wrong);
}

/* ", or text with a unit of a length": of a key that has a unit. */
static void wanted_text(const char *key, const char *what, double low, double high, char *out,
                        size_t size)
{
    const char *unit = quantity_unit_of_name(key);
    const struct quantity_kind *kind = quantity_kind_of(unit);
    snprintf(out, size, "%s from %g to %g%s%s%s%s", what, low, high, kind ? " " : "", unit,
             kind ? ", or as text with " : "", kind ? kind->units : "");
}

void keys_number(const struct keys *keys, const char *where, const json_t *object, const char *key,
                 double low, double high, double *value)
{
    const json_t *entry = json_object_get(object, key);
    char wanted[200];
    double given;
    if (!entry || keys_failed(keys))
        return;
    wanted_text(key, "a number", low, high, wanted, sizeof wanted);
    if (!read_number(key, entry, &given) || !(given >= low && given <= high))
        keys_wrong(keys, where, key, wanted);
    else
        *value = given; /* a caller may make an integer of it, failed or not */
}

static void range_of(const struct keys *keys, const char *where, const char *key,
                     const json_t *entry, double low, double high, struct series_range *range)
{
    char wanted[240];
    bool pair = json_is_array(entry) && json_array_size(entry) == 2;
    bool numbers = read_number(key, pair ? json_array_get(entry, 0) : entry, &range->low) &&
                   read_number(key, pair ? json_array_get(entry, 1) : entry, &range->high);
    wanted_text(key, "a number or [from, to] to draw between,", low, high, wanted, sizeof wanted);
    if (!numbers || !(range->low >= low && range->high <= high && range->low <= range->high))
        keys_wrong(keys, where, key, wanted);
}

void keys_range(const struct keys *keys, const char *where, const json_t *object, const char *key,
                double low, double high, struct series_range *value)
{
    const json_t *entry = json_object_get(object, key);
    if (entry && !keys_failed(keys))
        range_of(keys, where, key, entry, low, high, value);
}

unsigned keys_choice(const struct keys *keys, const char *where, const json_t *object,
                     const char *key, const char *const *choices, unsigned now)
{
    const json_t *entry = json_object_get(object, key);
    char wanted[120] = "one of";
    if (!entry || keys_failed(keys))
        return now;
    for (unsigned i = 0; choices[i]; i++) {
        if (json_is_string(entry) && strcmp(json_string_value(entry), choices[i]) == 0)
            return i;
        strcat(strcat(wanted, i > 0 ? ", " : " "), choices[i]); /* short words */
    }
    keys_wrong(keys, where, key, wanted);
    return now;
}

void keys_text(const struct keys *keys, const char *where, const json_t *object, const char *key,
               char *to, size_t size)
{
    const json_t *entry = json_object_get(object, key);
    if (!entry || keys_failed(keys))
        return;
    if (!json_is_string(entry) || strlen(json_string_value(entry)) >= size) {
        keys_wrong(keys, where, key, "a short text");
        return;
    }
    snprintf(to, size, "%s", json_string_value(entry));
}
