/* The campaign before a landing: the runway as configured in the board's predictor; the previous
 * landings with their readings, surveys and plans; and the survey since the last landing. */
#ifndef MATRIG_HOST_ADVISE_HISTORY_H
#define MATRIG_HOST_ADVISE_HISTORY_H

#include "host/advise/members.h"
#include "host/analyse/braking.h"
#include "host/analyse/inspection.h"
#include "host/store/store.h"

struct history_landing {
    int64_t run;
    bool is_measured; /* the stop is known, so the ensemble can be updated from this landing */
    bool is_relaid;   /* the mats were relaid before this landing, and a new series began */
    struct advise_observation observation; /* observation.braking.profile points to `profile` */
    struct advise_profile profile;         /* measured braking over time */
    double planned_ft_s2;                  /* NaN: no advice was stored */
};

struct history {
    struct advise_runway runway;
    /* braking of the last landing, from the edge of the brake to the stop; NaN: no edge was
     * recorded */
    struct braking braking; /* of the last landing */
    double touchdown_ft;    /* touchdown of the last landing, as configured or corrected */
    struct history_landing *landing;
    size_t landings;
    int64_t newest_run; /* newest RUN of the campaign, which may be excluded here */
    size_t voided;      /* voided landings, excluded because their effect on the mats is unknown */
    bool is_relaid;     /* a series was started since the last landing */
    double segment_sum_in[MR_SEGMENTS]; /* surveyed since the last landing; NaN: not read */
    unsigned surveyed_segments,
        segments; /* numbers of surveyed segments and of the runway's segments */
    double survey_error_in;
    struct inspections inspections; /* records of the crew */
};

/* Loads the landings of the board that landed last. With `before` (a RUN), loads only the landings
 * before it, and the survey that preceded it. MR_TOO_FEW: no landing has the predictor's
 * parameters, which describe the runway. MR_UNKNOWN: there is no RUN `before`. Call history_free in
 * every case. */
enum mr_status history_load(struct store *store, int64_t before, struct history *history,
                            struct error *error);
void history_free(struct history *history);

#endif
