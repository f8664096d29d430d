/* What people said of a landing: the facts of a row for each. */
#ifndef MATRIG_HOST_ANALYSE_JOURNAL_H
#define MATRIG_HOST_ANALYSE_JOURNAL_H

#include "host/base/answer.h"
#include "host/store/store_journal.h"

/* A wave, a break or something else that was seen. */
void journal_observation_answer(const struct store_observation *observation, struct answer *answer);
/* A note, a correction, a landing that was voided. */
void journal_change_answer(const struct store_change *change, struct answer *answer);
/* Both as tables. */
void journal_tables_answer(const struct store_observation *observation, size_t observations,
                           const struct store_change *change, size_t changes,
                           struct answer *answer);

#endif
