/* Notes and corrections of a landing: the facts of a row for each. */
#ifndef MATRIG_HOST_ANALYSE_JOURNAL_H
#define MATRIG_HOST_ANALYSE_JOURNAL_H

#include "host/base/answer.h"
#include "host/store/store_journal.h"

/* A wave, a break or something else that was seen. */
void journal_observation_answer(const struct store_observation *observation, struct answer *answer);
/* A note, a correction, a landing that was voided. */
void journal_change_answer(const struct store_change *change, struct answer *answer);
/* All entries of a landing, and the series it belongs to (id 0: none). */
struct journal {
    struct store_series series;
    struct store_change *change;
    size_t changes;
    struct store_observation *observation;
    size_t observations;
    bool is_void;
    char void_reason[STORE_JOURNAL_TEXT];
};
/* The caller releases it with journal_free, also after an error. */
enum mr_status journal_load(struct store *store, const struct store_landing *landing,
                            struct journal *journal, struct error *error);
void journal_free(struct journal *journal);
/* Observations and changes as tables. */
void journal_tables_answer(const struct journal *journal, struct answer *answer);

#endif
