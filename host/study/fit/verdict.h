/* Verdict: which parameters the data say nothing of, and which they cannot tell apart.
 *
 * Everything is weighed against the priors. A parameter is `silent` when, even with all others
 * known, the data would say less of it than its prior does (information below 1 in z). Of the
 * others, with the silent ones left to their priors, each principal direction of the data's
 * information below 1 is a combination that the data leave to the priors although each of its
 * members alone could be told: they are confounded. The profile checks it where the information is
 * only a slope: a prior's standard deviation along the direction, either way, must cost less than a
 * 95 % limit (3.84) in squared misfit. */
#ifndef MATRIG_HOST_STUDY_FIT_VERDICT_H
#define MATRIG_HOST_STUDY_FIT_VERDICT_H

#include "host/study/fit/solve.h"

#define VERDICT_LIMIT  3.84
#define VERDICT_MEMBER 0.1 /* least square of a member's component */

/* Fills silent, confounded and their count of `answer`, which has z and information, from the
 * surface it rests on. */
void verdict_make(const struct solve *solve, const double *w, struct fit_answer *answer);

#endif
