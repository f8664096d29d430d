/* Writes the keys of a scene as text and as JSON. */
#include <jansson.h>
#include <math.h>
#include <string.h>

#include "host/sim/scene/scene.h"

json_t *sim_key_default(const struct sim_key *key)
{
    struct sim_scene scene;
    const void *field = (const char *)&scene + key->offset;
    unsigned choice;
    sim_scene_set_defaults(&scene);
    if (key->kind == SIM_KEY_INTEGER)
        return json_integer(*(const int *)field);
    if (key->kind == SIM_KEY_CHOICE) {
        memcpy(&choice, field, sizeof choice);
        return json_string(key->choices[choice]);
    }
    double value = key->kind == SIM_KEY_REAL ? *(const double *)field : (double)NAN;
    bool given = isfinite(value) && value >= key->min && strcmp(key->name, "t_dwell") != 0;
    return given ? json_real(value) : NULL;
}

json_t *sim_scene_keys_to_json(void)
{
    json_t *keys_json = json_object();
    const struct sim_key *key;
    for (size_t i = 0; (key = sim_key_at(i)); i++) {
        json_t *one = json_pack("{s:o*,s:s,s:s}", "default", sim_key_default(key), "unit",
                                key->unit, "meaning", key->meaning);
        for (size_t c = 0; key->choices && key->choices[c]; c++) {
            if (c == 0)
                json_object_set_new(one, "choices", json_array());
            json_array_append_new(json_object_get(one, "choices"), json_string(key->choices[c]));
        }
        json_object_set_new(keys_json, key->name, one);
    }
    return keys_json;
}

void sim_scene_print_keys(FILE *to)
{
    const struct sim_key *key;
    for (size_t i = 0; (key = sim_key_at(i)); i++) {
        json_t *standard = sim_key_default(key);
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
