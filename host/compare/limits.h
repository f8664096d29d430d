/* Limits on a comparison: a JSON file, and the verdict.
 *
 *     {"channels": {"all": {"rms_in": 0.05, "correlation": 0.99}, "3": {"rms_in": 0.1}},
 *      "zones": {"simulated": {"overlap": 0.5, "start_ft": 6}, "board": {"end_ft": 6}},
 *      "missing_channels": 0,
 *      "series": {"within": 0.8, "rms_in": 0.05, "moved_in": 0.1}}
 *
 * Each quantity has its unit in its key. Limits are the most that is allowed of the size of a
 * value, but for overlap, correlation, inside and within: the least. A number for one channel takes
 * the place of that for all. What is not known fails its limit, but for the ends of zones where one
 * side has none (overlap says that). missing_channels: how many fitted channels may be without a
 * comparison, 0 unless given. Keys that begin with _ are comments. */
#ifndef MATRIG_HOST_COMPARE_LIMITS_H
#define MATRIG_HOST_COMPARE_LIMITS_H

#include "host/compare/figures.h"

#define COMPARE_LIMITS_MAX 160u

enum compare_scope {
    COMPARE_CHANNELS,
    COMPARE_ZONES_SIMULATED,
    COMPARE_ZONES_BOARD,
    COMPARE_SERIES,
    COMPARE_SCOPES
};

struct compare_limit {
    enum compare_scope scope;
    int64_t channel; /* 0: all */
    size_t quantity; /* of its scope */
    double value;    /* in the report's units */
};

struct compare_limits {
    struct compare_limit limit[COMPARE_LIMITS_MAX];
    size_t count;
    size_t missing_channels;
};

/* Of a series, for its limits. */
struct compare_pooled {
    double within; /* share of landings within their limits */
    double bias_in, rms_in;
    double moved_in; /* rms of the movements between surveys, measured less simulated */
};

struct compare_verdict {
    size_t checked, failed;
    char text[300]; /* of the failure that is largest, relative to its limit */
    double worst;
};

/* Adds what the file says. MR_IO, MR_MALFORMED: names line and key. */
enum mr_status compare_limits_load(struct compare_limits *limits, const char *path,
                                   struct error *error);
/* As {"channels": {"all": {"rms_in": V}}}. */
void compare_limits_add_rms(struct compare_limits *limits, double rms_in);
bool compare_limits_any(const struct compare_limits *limits);

/* All but those of a series; adds to the verdict. */
void compare_limits_check(const struct compare_limits *limits,
                          const struct compare_figures *figures, bool si,
                          struct compare_verdict *verdict);
void compare_limits_check_series(const struct compare_limits *limits,
                                 const struct compare_pooled *pooled, bool si,
                                 struct compare_verdict *verdict);

#endif
