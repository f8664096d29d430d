/* Braking of a landing: onset, slip, locked wheel and thrust, from the edge of the brake and the
 * pulses of the wheel-speed pick-up. Without them, the results are not known.
 *
 * Slip is 1 - rolled / travelled. The rolled distance is the number of pulses times the distance
 * per pulse; the travelled distance is that of the gear between the switches (track.h). The error
 * of the slip includes the rolling radius, the travelled distance, and the rotation after the last
 * pulse, which is only known to be less than one pulse.
 *
 * The wheel counts as locked between two pulses if the gear travels at least five distances per
 * pulse, which is a slip of 80 %. Between these pulses the wheel still turns by one pulse in total.
 * A wheel that locks abruptly turns for another 0 to 1 periods (times between the previous pulses);
 * one that slows down evenly turns for up to 1 / (sqrt 2 - 1) = 2.4 periods. The lock therefore
 * begins 1.2 +- 0.7 periods after the first pulse (uniform), and ends as long before the second
 * one.
 *
 * The thrust is that of the lead axle on the strip at the mean deceleration from the brake's edge
 * to the stop. The share that the strip carries is not measured; it is taken as 1 +- 0.17 (uniform
 * from 0.7 to 1.3, as in host/advise). Pure functions. */
#ifndef MATRIG_HOST_ANALYSE_BRAKING_H
#define MATRIG_HOST_ANALYSE_BRAKING_H

#include "host/analyse/track.h"
#include "host/base/answer.h"

#define BRAKING_LOCKS_MAX          16u
#define BRAKING_THRUST_SHARE_ERROR 0.1732051 /* standard error of the share: 0.3 / sqrt 3 */

struct braking {
    bool has_brake_edge; /* the edge of the brake was recorded */
    size_t pulse_count;  /* number of pulses of the wheel */
    /* NaN: not known. Times are t_s of measured.h. */
    struct mr_estimate brake_onset_s; /* edge of the brake */
    struct mr_estimate slip; /* mean slip from the brake's edge (or from touchdown) to the stop */
    struct mr_estimate locked_duration_s;
    struct wheel_lock {
        struct mr_estimate from_s, to_s;
    } lock[BRAKING_LOCKS_MAX];
    size_t lock_count; /* number of all locks; the array has the first BRAKING_LOCKS_MAX */
    /* mean values from the brake's edge to the stop */
    struct mr_estimate deceleration_ft_s2, thrust_lb;
};

enum mr_status braking_load(struct store *store, const struct measured_landing *measured,
                            struct braking *braking, struct error *error);
void braking_to_answer(const struct braking *braking, struct answer *answer);

#endif
