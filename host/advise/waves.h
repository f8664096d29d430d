/* Bow waves of a landing that is planned. In host/sim's planar landing they are a threshold in the
 * thrust, against the critical compression P_c = W L / (2 h) of the ground's irregularity h: what
 * else is known of mats and joints says next to nothing of them (tests/score/README.md, "Bow waves
 * before touchdown"). So a law that is fitted once gives a member's probability of a wave from its
 * own share of the thrust, and the members' mean is the advice. Members to whom a landing that
 * raised no wave was likely to raise one count less. */
#ifndef MATRIG_HOST_ADVISE_WAVES_H
#define MATRIG_HOST_ADVISE_WAVES_H

#include "host/advise/forecast.h"
#include "host/base/error.h"

/* The law: log odds are the sum of these, each times its constant: 1, log(thrust / P_c),
 * log(speed / 32 ft/s). Thrust is of the mean deceleration. */
#define ADVISE_WAVE_INPUTS 3
void advise_wave_inputs(double thrust_lb, double critical_lb, double speed_ft_s,
                        double input[ADVISE_WAVE_INPUTS]);

/* P_c of the irregularity that the runway is told, lb; infinite: none is told. */
double advise_wave_critical_lb(const struct advise_runway *runway);

/* Fills wave of all rows, of a landing that stops on the runway: without an irregularity it is left
 * as it is. `stood`: braking of `count` landings after which this lie of the mats still lay; the
 * hardest four count. The interval (95 %) is of the law's constants and the number of members.
 * False: no memory. */
bool advise_waves(const struct advise_members *members, const struct advise_plan *plan,
                  const struct advise_braking *stood, size_t count, struct advise_row *row,
                  size_t rows);

/* --- the same in the planar model, for mats that are not those of the law --- */

#define ADVISE_WAVES_MOST 256u

/* Fills row[].played of every second row and of the plan's: the share of the first `count` members
 * (1 on, at most as many as there are) whose landing raises a wave in the planar model, on ground
 * that is uneven under the joints by up to what the runway is told, drawn by member; the interval
 * is Wilson's. *played: runs of the planar engine. Members that it has no answer for are left out.
 * MR_FULL: no memory; MR_NUMERICS: it has an answer for none. */
enum mr_status advise_waves_played(const struct advise_members *members,
                                   const struct advise_plan *plan, size_t count,
                                   struct advise_row *row, size_t rows, size_t plan_row,
                                   size_t *played, struct error *error);

/* One run: a wave came of it. MR_NUMERICS: it has no answer. */
enum mr_status advise_wave(const struct advise_members *members, size_t member,
                           const struct advise_braking *braking, uint64_t seed, bool *wave,
                           struct error *error);

#endif
