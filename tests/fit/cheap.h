/* Cheap synthetic landings with known parameters, for the fit's tests and its coverage.
 *
 * A runway of 30 mats, joints soft enough (KL 4e3) that a landing costs a quarter of a millisecond,
 * one landing of 8 ft/s and 10 ft/s2 that touches down at 1.5 ft, transducers at 3, 4.2, 5.4 and
 * 6.6 ft with 0.003 in of noise in each sample, 2 ms apart. Gaps, closing resistances, survey and
 * noise are drawn here, with a generator of its own (SplitMix64), not by the code under test. */
#ifndef MATRIG_TESTS_FIT_CHEAP_H
#define MATRIG_TESTS_FIT_CHEAP_H

#include "host/study/fit/landings.h"

#define CHEAP_NOISE_IN 0.003

struct cheap_random {
    uint64_t state;
};
double cheap_uniform(struct cheap_random *random);
double cheap_normal(struct cheap_random *random);

/* Priors: values and spreads of the cheap runway. */
void cheap_priors(struct fit_parameter parameter[FIT_KEYS]);
/* One landing at z (parameters in units of the priors' spread); `list` is begun here. Surveyed:
 * each ten joints' sum is read with 0.005 in of error, and with a common factor, which z[FIT_GAP]
 * says in units of CHEAP_SURVEY_SPREAD. False, with the error's text, when anything fails. */
#define CHEAP_SURVEY_SPREAD 0.03
bool cheap_landing(const double z[FIT_KEYS], uint64_t seed, bool surveyed,
                   struct fit_landings *list, struct error *error);

#endif
