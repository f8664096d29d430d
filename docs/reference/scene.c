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
        if (is_second_group(key->name))
            continue;
        json_t *standard = sim_key_default(key);
        fprintf(out, "| `%s` | ", key->name);
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
