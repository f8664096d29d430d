/* Values inside JSON by a path of keys and places: "max_lift_ft", "outputs.-1.u_ft.4". In a list a
 * whole number is a place from 0, a negative one counts from the end. Keys that hold a dot cannot
 * be named. */
#ifndef MATRIG_HOST_SWEEP_JSONPATH_H
#define MATRIG_HOST_SWEEP_JSONPATH_H

#include <jansson.h>
#include <stdbool.h>

#define JSONPATH_MAX 100

/* Borrowed; NULL when there is nothing. */
json_t *jsonpath_get(const json_t *root, const char *path);

/* Puts a copy of `value` there. The object keeps sharing what it shared: only what the path goes
 * through is copied. A last key that is not there yet is added to its object. False: the path leads
 * nowhere. */
bool jsonpath_set(json_t *object, const char *path, json_t *value);

#endif
