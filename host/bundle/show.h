/* What was found in a bundle, for people and as JSON. */
#ifndef MATRIG_HOST_BUNDLE_SHOW_H
#define MATRIG_HOST_BUNDLE_SHOW_H

#include <jansson.h>
#include <stdio.h>

#include "host/bundle/bundle.h"

/* The verdict, every file, and those tables that are not whole (`saved` NULL: nothing was to be saved). */
void bundle_print(const struct bundle_check *check, const bool saved[BUNDLE_FILES], FILE *out);
/* The caller's to release. */
json_t *bundle_json(const struct bundle_check *check, const bool saved[BUNDLE_FILES]);

#endif
