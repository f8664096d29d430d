/* Limits on a comparison: a JSON file whose keys are paths into the answer's JSON, and the result.
 *
 *     {"channels.*.rms_in": 0.05, "channels.3.rms_in": 0.1, "channels.*.chi": 2,
 *      "zones.*.overlap_simulated.share": 0.5, "zones.*.overlap_board.end_difference_ft": 6,
 *      "missing_channels": 0, "series.within": 0.8, "series.rms_in": 0.05}
 *
 * A path names keys from the outside in; * is every element of a list, a number the element whose
 * "number" it is. A path with a number takes the place of the one with *. Paths that begin with
 * series. are of a series' answer, the others of each landing's. The path may end in the unit of
 * either answer (rms_in, rms_mm), and a limit may be text with a unit.
 *
 * A limit is the most that is allowed of the size of a value; of share and within it is the
 * least. A value that is null, or that is not there, fails its limit; but not in a
 * channel that was not compared, which counts as missing, and not where one side has no zone, which
 * is the share's to judge. missing_channels is 0 where channels have limits and it is not given.
 * Keys that begin with _ are comments. */
#ifndef MATRIG_HOST_COMPARE_LIMITS_H
#define MATRIG_HOST_COMPARE_LIMITS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"

struct compare_limits {
    json_t *paths; /* path: number, in file order; NULL: none */
};

struct compare_verdict {
    size_t checked, failed;
    char text[300]; /* of the failure that is largest, relative to its limit */
    double worst;
};

/* Adds what the file says. MR_IO, MR_MALFORMED. */
enum mr_status compare_limits_load(struct compare_limits *limits, const char *path,
                                   struct error *error);
void compare_limits_add(struct compare_limits *limits, const char *path, double most);
bool compare_limits_any(const struct compare_limits *limits);
void compare_limits_free(struct compare_limits *limits);

/* Judges an answer, in the report's units and in SI; adds to the verdict. `where`: "RUN 5", for
 * people. */
void compare_limits_check(const struct compare_limits *limits, bool of_series, const json_t *answer,
                          const json_t *si, const char *where, struct compare_verdict *verdict);

#endif
