/* What matrig study answers: an ensemble's outcome, in words and tables, and for programs every
 * landing of every runway. */
#ifndef MATRIG_HOST_LANDING_SERIES_ANSWER_H
#define MATRIG_HOST_LANDING_SERIES_ANSWER_H

#include "host/base/answer.h"
#include "host/landing_series/summary.h"

/* What came out of it, and what the answer is worth. */
void series_answer_outcome(struct answer *answer, const struct landing_series *series,
                           const struct series_run *runs, const struct series_summary *summary);
/* Landing by landing. */
void series_answer_landings(struct answer *answer, const struct landing_series *series,
                            const struct series_run *runs, const struct series_summary *summary);
/* Both. A new answer, the caller's; for programs in the units of the keys' names, also with `si`.
 * `apart`: of --check; NULL: none. */
struct answer *series_answer(const struct landing_series *series, const struct series_run *runs,
                             const struct series_summary *summary,
                             const struct series_difference *apart, bool si);

#endif
