/* Summary: distributions of what an ensemble's runways did. */
#ifndef MATRIG_HOST_LANDING_SERIES_SUMMARY_H
#define MATRIG_HOST_LANDING_SERIES_SUMMARY_H

#include "host/base/answer.h"
#include "host/landing_series/play.h"
#include "host/landing_series/series.h"

/* 5th, 50th and 95th percentile (linear between order statistics); count 0: NaN. */
struct series_spread {
    double low, middle, high;
    size_t count;
};

struct series_spread series_spread_of(double *values, size_t count); /* sorts them */

/* Of the runways that took this landing. */
struct series_landing_summary {
    size_t played;
    size_t buckled;
    size_t planar, waved, unhinged, torn;
    struct series_spread stop_ft, peak_in, reach_ft, zone_mats;
    struct series_spread movement_in[SERIES_STATIONS_MAX], total_in[SERIES_STATIONS_MAX];
};

struct series_summary {
    size_t runways;                                   /* that were played to their end */
    size_t failed;                                    /* that could not be */
    size_t survived;                                  /* did not buckle */
    struct series_spread station_ft, buckle_landing;  /* of those that buckled */
    struct series_spread zone_before, peak_before_in; /* of them, in the landing before */
    struct series_landing_summary *landing;           /* landing_count */
};

/* The caller frees. */
void series_summarise(struct series_summary *summary, const struct landing_series *series,
                      const struct series_run *runs);
void series_summary_free(struct series_summary *summary);

/* What matrig study answers: an ensemble's outcome, in words and tables, and for programs every
 * landing of every runway. */

/* Both. A new answer, the caller's; for programs in the units of the keys' names, also with `si`.
 */
struct answer *series_answer(const struct landing_series *series, const struct series_run *runs,
                             const struct series_summary *summary, bool si);

#endif
