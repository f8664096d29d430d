/* Notes and corrections of a landing, with the facts of each entry. */
#ifndef MATRIG_HOST_ANALYSE_JOURNAL_H
#define MATRIG_HOST_ANALYSE_JOURNAL_H

#include "host/base/answer.h"
#include "host/store/store_journal.h"

/* Adds the facts of one observation: a wave, a break or another event that a person saw. */
void journal_add_observation(const struct store_observation *observation, struct answer *answer);
/* Adds the facts of one change: a note, a correction or a voided landing. */
void journal_add_change(const struct store_change *change, struct answer *answer);
/* All entries of a landing, and the series that the landing belongs to (id 0: none). */
struct journal {
    struct store_series series;
    struct store_change *change;
    size_t change_count;
    struct store_observation *observation;
    size_t observation_count;
    bool is_void;
    char void_reason[STORE_JOURNAL_TEXT_SIZE];
};
/* The caller releases the journal with journal_free, also after an error. */
enum mr_status journal_load(struct store *store, const struct store_landing *landing,
                            struct journal *journal, struct error *error);
void journal_free(struct journal *journal);
/* Adds observations and changes as tables. */
void journal_add_tables(const struct journal *journal, struct answer *answer);

#endif
