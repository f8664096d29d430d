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
    struct series_spread stop_ft, deceleration_ft_s2, peak_in, reach_ft, zone_mats, push_lb,
        pull_lb;
    struct series_spread movement_in[SERIES_STATIONS_MAX], total_in[SERIES_STATIONS_MAX];
};

struct series_fact_summary {
    size_t agree;               /* runways */
    bool enough;                /* as many as the fact needs */
    struct series_spread value; /* of those that have one */
};

struct series_summary {
    size_t runways;                                   /* that were played to their end */
    size_t failed;                                    /* that could not be */
    size_t survived;                                  /* did not buckle */
    size_t landings;                                  /* played, over all runways */
    size_t planar;                                    /* of them with the planar engine */
    struct series_spread station_ft, buckle_landing;  /* of those that buckled */
    struct series_spread zone_before, peak_before_in; /* of them, in the landing before */
    struct series_landing_summary *landing;           /* landing_count */
    struct series_fact_summary fact[SERIES_FACTS_MAX];
    double ms_chain, ms_planar;
};

/* The caller frees. */
void series_summarise(struct series_summary *summary, const struct landing_series *series,
                      const struct series_run *runs);
void series_summary_free(struct series_summary *summary);

/* Runways that agree with what was observed (landing, within); of those that were played to their
 * end. */
size_t series_agree(const struct landing_series *series, const struct series_run *runs);

/* How well the runways foretold where the observed one buckled: -log2 of the share that they give
 * that landing (never: that too), with one runway spread over all that could have happened, so that
 * none is impossible. 0: certain and right. NaN where nothing is stated. */
double series_log_score_bits(const struct landing_series *series, const struct series_run *runs);

/* Facts: what a report says of a series besides where the runway buckled, and how a runway of the
 * series compares. */

/* The key `facts` of a series whose landings and stations have been read. */
void facts_read(const struct keys *keys, const json_t *root, struct landing_series *series);

/* The fact's quantity on one runway; NaN where it has none, as its landings were not reached. A
 * landing in which the runway buckled counts for SERIES_AT_BUCKLING alone. */
double facts_value(const struct landing_series *series, const struct series_fact *fact,
                   const struct series_run *run);

/* "0.25 to 0.33 in", "at least 3 times", "35 mats or more": the range that agrees. */
void facts_range_text(const struct series_fact *fact, char *text, size_t size);

/* What matrig study answers: an ensemble's outcome, in words and tables, and for programs every
 * landing of every runway. */

/* Both. A new answer, the caller's; for programs in the units of the keys' names, also with `si`.
 */
struct answer *series_answer(const struct landing_series *series, const struct series_run *runs,
                             const struct series_summary *summary, bool si);

#endif
