#include "host/sim/scene/scene_schema.h"

#include <jansson.h>
#include <math.h>
#include <string.h>

#include "host/sim/scene/scene_keys.h"
#include "host/sim/scene/scene_units.h"

static const struct sim_scene *plain_scene(void)
{
    static struct sim_scene scene;
    sim_scene_defaults(&scene);
    return &scene;
}

static const void *default_of(const struct sim_key *key)
{
    return (const char *)plain_scene() + key->offset;
}

static json_t *number_schema(const struct sim_key *key, const char *type)
{
    json_t *schema = json_pack("{s:s}", "type", type);
    if (key->low > -SIM_LARGEST)
        json_object_set_new(schema, key->above ? "exclusiveMinimum" : "minimum",
                            json_real(key->low));
    if (key->high < SIM_LARGEST)
        json_object_set_new(schema, "maximum", json_real(key->high));
    return schema;
}

/* A number in the key's unit, or text that says which unit. */
static json_t *real_schema(const struct sim_key *key)
{
    const struct quantity_kind *kind = quantity_kind_of(key->unit);
    json_t *number = number_schema(key, "number");
    if (!kind)
        return number;
    char pattern[160] = "^ *[-+0-9.eE]+ *(";
    size_t used = strlen(pattern);
    for (const char *at = kind->units; *at && used + 4 < sizeof pattern; at++) {
        if (*at == ',')
            at++; /* and the blank behind it */
        pattern[used++] = at > kind->units && at[-1] == ',' ? '|' : *at;
    }
    memcpy(pattern + used, ")$", 3);
    return json_pack("{s:[o,o]}", "anyOf", number,
                     json_pack("{s:s,s:s}", "type", "string", "pattern", pattern));
}

static json_t *list_schema(json_t *items)
{
    return json_pack("{s:s,s:o}", "type", "array", "items", items);
}

static json_t *choice_schema(const struct sim_key *key)
{
    json_t *names = json_array();
    for (size_t i = 0; key->choices[i]; i++)
        json_array_append_new(names, json_string(key->choices[i]));
    return json_pack("{s:o}", "enum", names);
}

static json_t *value_schema(const struct sim_key *key)
{
    switch (key->kind) {
    case SIM_KEY_TEXT: return json_pack("{s:s}", "type", "string");
    case SIM_KEY_REAL: return real_schema(key);
    case SIM_KEY_INTEGER: return number_schema(key, "integer");
    case SIM_KEY_CHOICE: return choice_schema(key);
    case SIM_KEY_LIST: return list_schema(real_schema(key));
    case SIM_KEY_MATS: return list_schema(number_schema(key, "integer"));
    case SIM_KEY_JOINTS:
    case SIM_KEY_PARTS:
        return json_pack("{s:[o,o]}", "anyOf", real_schema(key), list_schema(real_schema(key)));
    case SIM_KEY_PATH: break;
    }
    json_t *row = list_schema(json_pack("{s:[s,s]}", "type", "number", "string"));
    json_object_update_new(row, json_pack("{s:i,s:i}", "minItems", 3, "maxItems", 3));
    json_t *path = list_schema(row);
    json_object_set_new(path, "minItems", json_integer(2));
    return path;
}

/* Those that a file can hold: no infinity, no list. NULL: none. */
static json_t *default_json(const struct sim_key *key)
{
    const void *field = default_of(key);
    unsigned choice;
    switch (key->kind) {
    case SIM_KEY_REAL: {
        double value = *(const double *)field;
        return isfinite(value) && value >= key->low && strcmp(key->name, "t_dwell") != 0
                 ? json_real(value)
                 : NULL;
    }
    case SIM_KEY_INTEGER: return json_integer(*(const int *)field);
    case SIM_KEY_CHOICE:
        memcpy(&choice, field, sizeof choice);
        return json_string(key->choices[choice]);
    case SIM_KEY_TEXT:
    case SIM_KEY_LIST:
    case SIM_KEY_MATS:
    case SIM_KEY_JOINTS:
    case SIM_KEY_PARTS:
    case SIM_KEY_PATH: break;
    }
    return NULL;
}

json_t *sim_scene_schema(void)
{
    json_t *properties = json_object();
    for (size_t i = 0; sim_key_at(i); i++) {
        const struct sim_key *key = sim_key_at(i);
        json_t *schema = value_schema(key), *standard = default_json(key);
        char text[200];
        snprintf(text, sizeof text, key->unit[0] ? "%s; %s" : "%s", key->meaning, key->unit);
        json_object_set_new(schema, "description", json_string(text));
        if (standard)
            json_object_set_new(schema, "default", standard);
        json_object_set_new(properties, key->name, schema);
    }
    return json_pack("{s:s,s:s,s:s,s:o,s:{s:{}},s:b}", "$schema",
                     "https://json-schema.org/draft/2020-12/schema", "title", "matrig scene",
                     "type", "object", "properties", properties, "patternProperties", "^_",
                     "additionalProperties", 0);
}

void sim_scene_print_keys(FILE *to)
{
    for (size_t i = 0; sim_key_at(i); i++) {
        const struct sim_key *key = sim_key_at(i);
        json_t *standard = default_json(key);
        char text[32] = "-";
        if (json_is_number(standard))
            snprintf(text, sizeof text, "%g", json_number_value(standard));
        else if (standard)
            snprintf(text, sizeof text, "%s", json_string_value(standard));
        fprintf(to, "%-15s %-11s %-11s %s", key->name, text, key->unit[0] ? key->unit : "-",
                key->meaning);
        for (size_t c = 0; key->choices && key->choices[c]; c++)
            fprintf(to, "%s%s", c == 0 ? ": " : ", ", key->choices[c]);
        fputc('\n', to);
        json_decref(standard);
    }
}
