/* Braking of a landing from the edge of the brake and the pulses of the wheel-speed pick-up: onset,
 * slip, locked wheel, thrust. A landing without them has none of it.
 *
 * Slip is 1 - rolled / travelled: the wheel's pulses times the distance that it rolls per pulse,
 * and the gear's way by the switches (track.h). Its error comes from the rolling radius, the gear's
 * way, and the part of a pulse after the last one, of which only the range is known.
 *
 * The wheel is locked between two pulses if the gear travels five distances per pulse or more: a
 * slip of 80 %, which no tyre holds. It still turns by one pulse in all there. A wheel that locks
 * at once needs 0 to 1 of the pulse before for its share; one that slows down evenly, up to 1 /
 * (sqrt 2 - 1) = 2.4. The lock therefore begins 1.2 +- 0.7 such pulses after the last one
 * (uniform), and ends likewise before the next one.
 *
 * The thrust is that of the lead axle on the strip at the mean deceleration from the brake's edge
 * to the stop. What share of it the strip carries is not measured: 1 +- 0.17 (uniform from 0.7 to
 * 1.3, as in host/advise). Pure functions. */
#ifndef MATRIG_HOST_ANALYSE_BRAKING_H
#define MATRIG_HOST_ANALYSE_BRAKING_H

#include "host/analyse/track.h"
#include "host/base/answer.h"

#define BRAKING_LOCKS       16u
#define BRAKING_SHARE_ERROR 0.1732051 /* 0.3 / sqrt 3 */

struct braking {
    bool has_edge; /* the edge of the brake was recorded */
    size_t pulses; /* of the wheel */
    /* NaN: not known. Times are t_s of measured.h. */
    struct mr_estimate onset_s; /* edge of the brake after touchdown */
    struct mr_estimate slip;    /* mean from the edge, without one from touchdown, to the stop */
    struct mr_estimate locked_s;
    struct braking_lock {
        struct mr_estimate from_s, to_s;
    } lock[BRAKING_LOCKS];
    size_t locks; /* all; the array has the first BRAKING_LOCKS */
    struct mr_estimate deceleration_ft_s2, thrust_lb; /* from the edge to the stop */
};

enum mr_status braking_load(struct store *store, const struct measured *measured,
                            struct braking *braking, struct error *error);
void braking_to_answer(const struct braking *braking, struct answer *answer);

#endif
