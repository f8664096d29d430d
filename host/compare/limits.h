/* Limits on a comparison: a JSON file whose keys are paths into the JSON of the answer, and the
 * result of checking them.
 *
 *     {"channels.*.rms_in": 0.05, "channels.3.rms_in": 0.1, "channels.*.chi": 2,
 *      "zones.*.overlap_simulated.share": 0.5, "zones.*.overlap_board.end_difference_ft": 6,
 *      "missing_channels": 0, "series.within": 0.8, "series.rms_in": 0.05}
 *
 * A path names keys from the outside in. * stands for every element of a list; a number stands for
 * the element whose key "number" has that value. A path with a number overrides the path with *.
 * Paths that begin with series. refer to a series' answer, all others to each landing's answer. The
 * path may end with the unit of either answer (rms_in, rms_mm), and a limit may be a text with a
 * unit.
 *
 * A limit is the maximum magnitude of a value, except for share and within, where it is the
 * minimum. A value that is null or absent fails its limit, with two exceptions: values of a channel
 * that was not compared, which counts as missing; and values of an overlap in which one side has no
 * zone, where only the share is checked. The default limit of missing_channels is 0 if channels
 * have limits. Keys that begin with _ are comments. */
#ifndef MATRIG_HOST_COMPARE_LIMITS_H
#define MATRIG_HOST_COMPARE_LIMITS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"

struct compare_limits {
    json_t *limit_by_path; /* limit by path, in file order; NULL: no limits */
};

struct compare_verdict {
    size_t checked_limit_count, failed_limit_count;
    char worst_failure[300]; /* description of the failure that is largest relative to its limit */
    double worst_excess;
};

/* Adds the limits of a file. MR_IO: the file cannot be read. MR_MALFORMED: it is not a file of
 * limits. */
enum mr_status compare_limits_load(struct compare_limits *limits, const char *path,
                                   struct error *error);
void compare_limits_add(struct compare_limits *limits, const char *path, double most);
bool compare_has_limits(const struct compare_limits *limits);
void compare_limits_free(struct compare_limits *limits);

/* Checks an answer in the report's units and in SI, and adds the failures to the verdict. `where`:
 * the place named in the text, such as "RUN 5". */
void compare_limits_check(const struct compare_limits *limits, bool of_series, const json_t *answer,
                          const json_t *si, const char *where, struct compare_verdict *verdict);

#endif
