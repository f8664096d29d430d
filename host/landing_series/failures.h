/* Failures: the stations at which mats rose in one landing: a two-panel wave, which the aircraft
 * presses flat, or more. */
#ifndef MATRIG_HOST_LANDING_SERIES_FAILURES_H
#define MATRIG_HOST_LANDING_SERIES_FAILURES_H

#include <stddef.h>

#include "host/landing_series/series.h"

/* Each stretch of nodes that rose by `limit_ft` or more, between nodes that did not, is a failure:
 * the aircraft presses flat what lies between. `rise_ft` as sim_result has it, by node 1..nodes,
 * [0] unused; the runway's ends do not count. Its station: where the wheel first met it (`met_ft`,
 * in order of time), else its highest node. Returns how many, at most SERIES_FAILURES_MAX,
 * downfield in `failure_ft`. */
int failures_find(const double *rise_ft, size_t nodes, double length_ft, double limit_ft,
                  const double *met_ft, int met, double failure_ft[SERIES_FAILURES_MAX]);

/* Where joints come apart during a landing (`unhinged_s`: when, by joint 1..joints; 0: not), those
 * farther apart than the longest wave of the report (seven panels, 5.6) are failures of their own.
 * The station of each, and `first_ft` of all, is the joint that came apart first. */
int failures_apart(const double *unhinged_s, size_t joints, double length_ft,
                   double failure_ft[SERIES_FAILURES_MAX], double *first_ft);

#endif
