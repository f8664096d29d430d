/* What kept a landing's campaign from being written while it was logged, as text and as JSON. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_HELD_H
#define MATRIG_HOST_ANALYSE_SUMMARY_HELD_H

#include <jansson.h>
#include <stdio.h>

#include "host/store/store_log.h"

void summary_held_print(const struct store_held *held, FILE *out); /* nothing when nothing did */
json_t *summary_held_json(const struct store_held *held);          /* null when nothing did */

#endif
