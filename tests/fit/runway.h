/* Campaigns with a known truth, for what the fit notices: two landings (light and hard braking),
 * eight transducers, a survey before the first landing and one after the last. Half of the model
 * runway, 210 mats, with ways half as long and the same decelerations, is a third of its cost; the
 * whole can be had. The joints' stiffness is known, as a test of a joint tells it; friction and the
 * share of the thrust are to 10 %, the resistance to 40 %, the sums of a survey to 3 % together and
 * 0.005 in each.
 *
 * One kind is what the fit takes a runway to be; the others are what it is not, each of them once
 * seen to spoil the intervals unnoticed, or to be likely on a strip of mats. What they are was
 * written down before any statistic was chosen by them:
 *
 * heavy     closing resistances with a heavy tail: Lomax's distribution of shape 2, of no finite
 *           variance, with the mean that the fit looks for; one joint in six has more than 1.5
 *           times the mean of all, one in 36 five times. Dirt comes in lumps, and intervals held in
 *           82 % of such runways.
 * half      half a dirty runway: resistances of half the mean before the middle and 1.5 times the
 *           mean beyond, or the other way round. One side of a field is dusty, or was swept.
 * patchy    gaps as laid by several people: stretches of 12 to 40 mats with 0.4 and 1.6 times the
 *           mean gap in turn.
 * braking   light, then hard: two thirds of the thrust that the stated deceleration says in the
 *           first half of the time, four thirds in the second; the way of the gear is told rightly.
 *           The foresight fails most under it, and a share of the thrust that changes within the
 *           landing looks the same.
 *
 * Simulated by host/sim, with a generator of its own (tests/fit/cheap.h), not by the code under
 * test. */
#ifndef MATRIG_TESTS_FIT_RUNWAY_H
#define MATRIG_TESTS_FIT_RUNWAY_H

#include "host/study/fit/landings.h"

enum runway_kind {
    RUNWAY_MODEL,
    RUNWAY_HEAVY,
    RUNWAY_HALF,
    RUNWAY_PATCHY,
    RUNWAY_BRAKING,
    RUNWAY_KINDS
};
extern const char *const runway_names[RUNWAY_KINDS];

#define RUNWAY_LANDINGS 2
#define RUNWAY_MATS     210

/* Which of it there is; all zero but `surveyed`: the study's. */
struct runway_wanted {
    enum runway_kind kind;
    bool surveyed;
    size_t landings; /* 0: RUNWAY_LANDINGS */
    int mats;        /* 0: RUNWAY_MATS; up to 420, whole segments */
};

/* A campaign; z, in units of the priors' spread, is drawn too, and says the truth. `list` is begun
 * here. False, with the error's text, when anything fails. */
bool runway_campaign(const struct runway_wanted *wanted, uint64_t seed, double z[FIT_KEYS],
                     struct fit_landings *list, struct error *error);

#endif
