/* The campaign before a landing: the runway as the board's predictor has it, the landings so far
 * with their readings and surveys, their plans, and the survey since the last one. */
#ifndef MATRIG_HOST_ADVISE_PAST_H
#define MATRIG_HOST_ADVISE_PAST_H

#include "host/advise/members.h"
#include "host/store/store.h"

struct past_landing {
    int64_t run;
    bool measured;                 /* with a stop: it can be learned from */
    bool relaid;                   /* the mats were laid anew before it: another series */
    struct advise_seen seen;       /* its braking's profile points to `profile` */
    struct advise_profile profile; /* as measured */
    double planned_ft_s2;          /* NaN: no advice was kept */
};

struct past {
    struct advise_runway runway;
    double touchdown_ft; /* as configured, or corrected, for the last landing */
    struct past_landing *landing;
    size_t landings;
    int64_t newest_run;          /* of the campaign, also one that is left out */
    size_t voided;               /* left out: their effect on the mats is unknown */
    bool relaid;                 /* a series was begun since the last landing */
    double sum_in[MR_SEGMENTS];  /* survey since the last landing; NaN: not read */
    unsigned surveyed, segments; /* of so many; the runway's */
    double survey_error_in;
};

/* Reads the landings of the board that landed last; with `before` (a RUN) those before it, as if
 * it were still to come, and its survey. MR_TOO_FEW: no landing with the predictor's parameters,
 * from which the runway is known; MR_UNKNOWN: no RUN `before`. past_free in every case. */
enum mr_status past_load(struct store *store, int64_t before, struct past *past,
                         struct error *error);
void past_free(struct past *past);

#endif
