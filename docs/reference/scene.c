#include <jansson.h>
#include <string.h>

#include "docs/reference/reference.h"
#include "host/sim/scene/scene_keys.h"

static void write_default(FILE *out, const json_t *key)
{
    const json_t *value = json_object_get(key, "default");
    if (!value)
        fputs("-", out);
    else if (json_is_string(value))
        fputs(json_string_value(value), out);
    else if (json_is_number(value))
        fprintf(out, "%.6g", json_number_value(value));
}

/* The schema's description is "meaning; unit". */
static void write_meaning(FILE *out, const json_t *key)
{
    const json_t *choice;
    size_t i;
    reference_cell(out, json_string_value(json_object_get(key, "description")));
    json_array_foreach(json_object_get(key, "enum"), i, choice)
        fprintf(out, "%s`%s`", i == 0 ? ": " : ", ", json_string_value(choice));
}

void reference_scene(FILE *out)
{
    json_t *schema = sim_scene_schema();
    const char *name;
    json_t *key;
    reference_head(out, "Scene",
                   "the table of keys in `host/sim/scene/scene_keys.c` and `host/sim/elements/`");
    fputs("A scene is a JSON file that `matrig sim` runs. Keys that begin with `_` are comments. A "
          "number, also in a list, may be text with any unit of its kind ([units](units.md)):\n"
          "`\"ground_damping\": \"175 N s/m\"`. `matrig sim --keys` prints this table, `matrig "
          "--json sim --keys` a JSON Schema. The equations are in\n"
          "[host/sim/README.md](../../host/sim/README.md).\n\n| key | default | meaning; unit "
          "|\n|---|---|---|\n",
          out);
    json_object_foreach(json_object_get(schema, "properties"), name, key)
    {
        fprintf(out, "| `%s` | ", name);
        write_default(out, key);
        fputs(" | ", out);
        write_meaning(out, key);
        fputs(" |\n", out);
    }
    json_decref(schema);
}
