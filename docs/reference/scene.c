#include <jansson.h>

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

void reference_scene(FILE *out)
{
    const struct sim_key *key;
    reference_head(out, "Scene",
                   "the table of keys in `host/sim/scene/scene.c` and `host/sim/elements/`");
    fputs("A scene is a JSON file that `matrig sim` runs. Keys that begin with `_` are comments. A "
          "number, also in a list, may be text with any unit of its kind ([units](units.md)):\n"
          "`\"ground_damping\": \"175 N s/m\"`. `matrig sim --keys` prints this table, `matrig "
          "--json sim --keys` as JSON. The equations are in\n"
          "[host/sim/README.md](../../host/sim/README.md).\n\n| key | default | meaning; unit "
          "|\n|---|---|---|\n",
          out);
    for (size_t i = 0; (key = sim_key_at(i)); i++) {
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
