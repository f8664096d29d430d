/* What a live view sends to its viewers, as JSON. All numbers are in the report's units (in, lb,
 * ft, s); the configuration has the units to show them in and their factors. */
#ifndef MATRIG_HOST_LIVE_JSON_H
#define MATRIG_HOST_LIVE_JSON_H

#include <jansson.h>
#include <stdio.h>

#include "host/collect/collect.h"
#include "host/live/buckets.h"

/* Where it comes from, for people. Owned by the caller. */
struct live_source {
    const char *db;
    const char *can, *serial; /* links; NULL: not used, or not known */
    bool commands;            /* arm and disarm can be given here */
    const char *no_commands;  /* why not, one line */
    bool si;
};

/* What is the same for every board: {"units", "source", "layout", "quantities", "faults",
 * "can_states", "statuses", "bucket_s", "transducers"}. */
json_t *live_json_configuration(const struct live_source *source);

/* A message of the catalogue, one object: {"m": its name, "t": host time in us, "l": link, "b":
 * block or null, each field by its name, "FIELD_text" of a code, "notice" and "severity" of a line
 * that is told, "quantity", "value" and "error" of a number that people watch}. */
void live_json_message(FILE *out, const struct collector_event *event);

/* {"epoch": "which hub, which boot", "b": [[bucket, least x 22, most x 22] ..]}: 0.0001 in and 0.01
 * lb, null where there is no reading. To be freed. */
char *live_json_buckets(uint32_t run, uint64_t restarts, const struct live_bucket *buckets,
                        unsigned count);

/* Least, most and newest of each channel: [[value, least, most, why there is no value] x 22]. */
json_t *live_json_readings(const struct live_buckets *buckets);

#endif
