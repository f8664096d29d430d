/* What the report says of a series, and how the runways of the series compare: comments
 * _observed_landing, _within, _needed and _facts of a study file. */
#ifndef MATRIG_TESTS_SCOREBOARD_FACTS_H
#define MATRIG_TESTS_SCOREBOARD_FACTS_H

#include "host/landing_series/ensemble.h"

#define SERIES_FACTS_MAX 12

/* What else was seen than where the runway buckled: a quantity over some landings, and its
 * range. */
enum series_quantity {
    SERIES_MOVED_IN,  /* sum of the movements */
    SERIES_EACH_IN,   /* their mean */
    SERIES_MOST_IN,   /* their largest */
    SERIES_MEAN_IN,   /* their mean, of the mean over all stations */
    SERIES_ZONE_MATS, /* longest closed zone */
    SERIES_WAVES,     /* landings with a wave */
    SERIES_SLACK,     /* landings in which a band went slack */
    SERIES_TORN,      /* landings in which joints tore */
    SERIES_FAILURES,  /* most stations that one landing buckled at */
    /* from the first of them to the second, downfield; none where there is one */
    SERIES_APART_FT
};
enum series_when { SERIES_IN_LANDINGS, SERIES_BEFORE_BUCKLING, SERIES_AT_BUCKLING };

struct series_fact {
    char says[160];
    enum series_quantity quantity;
    enum series_when when;
    size_t first, last; /* landings, from 1 */
    /* the quantity is divided by what it is over these; 0: not */
    size_t against_first, against_last;
    double station_ft; /* of movements; NaN: wherever they are largest */
    double low, high;
    double needed; /* share of the runways that has to agree */
};

struct series_fact_summary {
    size_t agree;               /* runways */
    bool enough;                /* as many as the fact needs */
    struct series_spread value; /* of those that have one */
};

struct facts {
    int observed_landing; /* 0: not stated; -1: never */
    int within;           /* landings: a runway that buckles so near to it agrees */
    double needed;        /* share of the runways that has to agree */
    struct series_fact fact[SERIES_FACTS_MAX];
    size_t count;
};

/* The keys of a study file whose series is loaded. MR_MALFORMED names the key. */
enum mr_status facts_read(const char *path, const json_t *root, const struct landing_series *series,
                          struct facts *facts, struct error *error);

/* The fact's quantity on one runway; NaN where its landings were not reached. A landing in which
 * the runway buckled counts for SERIES_AT_BUCKLING alone. */
double facts_value(const struct landing_series *series, const struct series_fact *fact,
                   const struct series_run *run);
struct series_fact_summary facts_summarise(const struct landing_series *series,
                                           const struct series_fact *fact,
                                           const struct series_run *runs);

/* "0.25 to 0.33 in", "at least 3 times", "35 mats or more": the range that agrees. */
void facts_range_text(const struct series_fact *fact, char *text, size_t size);

/* Runways that agree with what was observed (landing, within); of those that were played to their
 * end. */
size_t series_agree(const struct landing_series *series, const struct facts *facts,
                    const struct series_run *runs);

/* How well the runways predicted where the observed one buckled: -log2 of the share that they give
 * that landing (never: that too), with one runway spread over all that could have happened, so that
 * none is impossible. 0: certain and right. NaN where nothing is stated. */
double series_log_score_bits(const struct landing_series *series, const struct facts *facts,
                             const struct series_run *runs);

#endif
