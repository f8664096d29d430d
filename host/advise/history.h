/* The history of a campaign before a landing: the runway properties that the board's predictor
 * uses, the previous landings with their measurements, surveys and plans, and the survey since the
 * last landing. */
#ifndef MATRIG_HOST_ADVISE_HISTORY_H
#define MATRIG_HOST_ADVISE_HISTORY_H

#include "host/advise/members.h"
#include "host/analyse/braking.h"
#include "host/analyse/inspection.h"
#include "host/store/store.h"

struct history_landing {
    int64_t run;
    bool is_measured; /* the stop was measured, so the ensemble can be updated from this landing */
    bool is_relaid;   /* the mats were relaid before this landing, and a new series began */
    struct advise_observation observation; /* observation.braking.profile points to `profile` */
    struct advise_profile profile;         /* measured braking over time */
    double planned_deceleration_ft_s2; /* planned mean deceleration; NaN: no advice was stored */
};

struct history {
    struct advise_runway runway;
    /* braking of the last landing, from the edge of the brake signal to the stop; NaN: no edge was
     * recorded */
    struct braking braking;
    /* touchdown station of the last landing, as configured or as corrected by the user */
    double touchdown_ft;
    struct history_landing *landing;
    size_t landing_count;
    int64_t newest_run; /* newest RUN of the campaign, even if it is not among the landings here */
    /* voided landings, excluded because their effect on the mats is unknown */
    size_t voided_landing_count;
    bool is_relaid_since_landing; /* a series was started since the last landing */
    /* surveyed opening of each segment (sum over its joints) since the last landing; NaN: not
     * read */
    double segment_sum_in[MR_SEGMENTS];
    unsigned surveyed_segment_count,
        segment_count; /* number of surveyed segments, and number of segments of the runway */
    double survey_error_in;
    struct inspections inspections; /* inspection records of the campaign */
};

/* Loads the landings of the board that landed last. With `before` (a RUN), loads only the landings
 * before it, and the last survey before it. MR_TOO_FEW: no landing has the parameters of the
 * predictor, which describe the runway. MR_UNKNOWN: there is no RUN `before`. Call history_free in
 * every case. */
enum mr_status history_load(struct store *store, int64_t before, struct history *history,
                            struct error *error);
void history_free(struct history *history);

#endif
