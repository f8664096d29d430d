/* What matrig study answers: an ensemble's outcome, in words and tables, and for programs every
 * landing of every runway. */
#ifndef MATRIG_HOST_CAMPAIGN_ANSWER_H
#define MATRIG_HOST_CAMPAIGN_ANSWER_H

#include "host/base/answer.h"
#include "host/campaign/summary.h"

/* What came out of it, and what the answer is worth. */
void campaign_answer_outcome(struct answer *answer, const struct campaign *campaign,
                             const struct campaign_run *runs,
                             const struct campaign_summary *summary);
/* Landing by landing. */
void campaign_answer_landings(struct answer *answer, const struct campaign *campaign,
                              const struct campaign_run *runs,
                              const struct campaign_summary *summary);
/* Both. A new answer, the caller's; for programs in the units of the keys' names, also with `si`.
 * `apart`: of --check; NULL: none. */
struct answer *campaign_answer(const struct campaign *campaign, const struct campaign_run *runs,
                               const struct campaign_summary *summary,
                               const struct campaign_difference *apart, bool si);

#endif
