#include <jansson.h>
#include <stdbool.h>
#include <string.h>

#include "docs/reference/reference.h"
#include "host/sim/scene/scene.h"

static void write_default(FILE *out, const json_t *value)
{
    if (!value)
        fputs("-", out);
    else if (json_is_string(value))
        fputs(json_string_value(value), out);
    else
        fprintf(out, "%.6g", json_number_value(value));
}

/* The keys of the second group of bands repeat those of the first. */
static bool is_second_group(const char *name)
{
    return strncmp(name, "band2_", strlen("band2_")) == 0 || strcmp(name, "bands2") == 0;
}

/* Keys of restraints that differ in the restraint alone share a row: anchor_K, tie_K. */
static bool is_alike(const struct sim_key *a, const struct sim_key *b)
{
    const char *end_a = strchr(a->name, '_'), *end_b = strchr(b->name, '_');
    json_t *default_a = sim_key_default(a), *default_b = sim_key_default(b);
    bool alike = end_a && end_b && strcmp(end_a, end_b) == 0 &&
                 strcmp(a->meaning, b->meaning) == 0 && strcmp(a->unit, b->unit) == 0 &&
                 (default_a == default_b || json_equal(default_a, default_b));
    json_decref(default_a);
    json_decref(default_b);
    return alike;
}

static bool is_in_row_above(size_t key)
{
    size_t i = 0;
    while (i < key && !is_alike(sim_key_at(i), sim_key_at(key)))
        i++;
    return i < key;
}

void reference_scene(FILE *out)
{
    const struct sim_key *key;
    reference_head(out, "Scene",
                   "the table of keys in `host/sim/scene/scene.c` and `host/sim/elements/`");
    fputs(
        "A scene is a JSON file for `matrig sim`. Keys that begin with `_` are comments. A number "
        "may be text with a unit ([units](units.md)): `\"ground_damping\": \"175 N s/m\"`. `matrig "
        "sim --keys` prints this table. Equations: "
        "[host/sim/README.md](../../host/sim/README.md).\n\nThe keys `bands2` and `band2_*` "
        "describe a second group of bands, as `bands` and `band_*` describe the first. "
        "Default `-`: not set.\n\n"
        "| Key | Default | Meaning; unit |\n|---|---|---|\n",
        out);
    for (size_t i = 0; (key = sim_key_at(i)); i++) {
        if (is_second_group(key->name) || is_in_row_above(i))
            continue;
        json_t *standard = sim_key_default(key);
        fprintf(out, "| `%s`", key->name);
        for (size_t n = i + 1; sim_key_at(n); n++) {
            if (!is_second_group(sim_key_at(n)->name) && is_alike(key, sim_key_at(n)))
                fprintf(out, ", `%s`", sim_key_at(n)->name);
        }
        fputs(" | ", out);
        write_default(out, standard);
        fputs(" | ", out);
        reference_cell(out, key->meaning);
        fputs(key->unit[0] ? "; " : "", out);
        reference_cell(out, key->unit);
        for (size_t c = 0; key->choices && key->choices[c]; c++)
            fprintf(out, "%s`%s`", c == 0 ? ": " : ", ", key->choices[c]);
        fputs(" |\n", out);
        json_decref(standard);
    }
}
