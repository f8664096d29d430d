/* The keys of a scene, told to programs (JSON Schema) and to people: from the table that reads and
 * checks them. */
#ifndef MATRIG_HOST_SIM_SCENE_SCENE_SCHEMA_H
#define MATRIG_HOST_SIM_SCENE_SCENE_SCHEMA_H

#include <stdio.h>

struct json_t;

/* JSON Schema (2020-12) of a scene file; the caller's. */
struct json_t *sim_scene_schema(void);

/* One line per key: name, default, unit, meaning. */
void sim_scene_print_keys(FILE *to);

#endif
