/* What a live view sends to its viewers, as JSON. All numbers are in the report's units (in, lb,
 * ft, s); the configuration has the units to show them in and their factors. */
#ifndef MATRIG_HOST_LIVE_JSON_H
#define MATRIG_HOST_LIVE_JSON_H

#include <jansson.h>

#include "host/live/model.h"

/* Where it comes from, for people. Owned by the caller. */
struct live_source {
    const char *db;
    const char *can, *serial; /* links; NULL: not used, or not known */
    bool commands;            /* arm and disarm can be given here */
    const char *no_commands;  /* why not, one line */
    bool si;
};

/* {"units": .., "source": .., "board": .., "channels": [{"name", "kind", "station_ft", "band"} x
 * 22], "switches": [ft ..], "segments": [{"start_ft", "end_ft", "joints", "slack_in"} ..],
 * "touchdown_ft", "bucket_s"} */
json_t *live_json_configuration(const struct live_model *model, const struct live_source *source);

/* {"now_us", "heard_us", "block", "state": .., "warning": .., "verdict": the predictor's or null,
 * "gear": .., "zone": .., "readings": [[value, least, most, validity] ..], "links": [..], "health":
 * .., "notices": [..]} */
json_t *live_json_state(const struct live_model *model, int64_t now_us);

/* {"epoch": "which hub, which boot", "b": [[bucket, least x 22, most x 22] ..]}: 0.0001 in and 0.01
 * lb, null where there is no reading. To be freed. */
char *live_json_buckets(uint32_t run, uint64_t restarts, const struct live_bucket *buckets,
                        unsigned count);

#endif
