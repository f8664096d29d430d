/* What people say of landings: notes, corrections, voidings, waves and breaks they saw; and series.
 * Rows are only ever added: the newest of a field holds, all of them are the history. Conventions
 * as in store.h; texts that are absent are empty. */
#ifndef MATRIG_HOST_STORE_STORE_JOURNAL_H
#define MATRIG_HOST_STORE_STORE_JOURNAL_H

#include "host/store/store.h"

/* `was` is found by itself. Fields: note, void ("yes", "no"), and those of a correction;
 * touchdown_ft is used in place of what the board said from then on. */
enum mr_status store_change_add(struct store *store, const struct store_change *change,
                                struct error *error);
enum mr_status store_changes(struct store *store, int64_t run, struct store_change **rows,
                             size_t *count, struct error *error);
/* The newest value of a field; empty: never said. `reason` may be NULL. */
enum mr_status store_change_get(struct store *store, int64_t run, const char *field,
                                char value[STORE_JOURNAL_TEXT], char reason[STORE_JOURNAL_TEXT],
                                struct error *error);
enum mr_status store_is_void(struct store *store, int64_t run, bool *is_void,
                             char reason[STORE_JOURNAL_TEXT], struct error *error);
/* MR_LIMIT, with the reason, when the landing is void and `allowed` is not set. */
enum mr_status store_refuse_void(struct store *store, int64_t run, bool allowed,
                                 struct error *error);

enum mr_status store_observation_add(struct store *store,
                                     const struct store_observation *observation,
                                     struct error *error);
enum mr_status store_observation_withdraw(struct store *store, int64_t run, int64_t id,
                                          int64_t made_us, const char *who, const char *reason,
                                          struct error *error);
enum mr_status store_observations(struct store *store, int64_t run, struct store_observation **rows,
                                  size_t *count, struct error *error);

enum mr_status store_series_add(struct store *store, const struct store_series *series,
                                struct error *error);
enum mr_status store_series_all(struct store *store, struct store_series **rows, size_t *count,
                                struct error *error);
/* The series that a landing belongs to: that of its correction, else the newest one begun before it
 * was armed; id 0: none. */
enum mr_status store_series_of(struct store *store, const struct store_landing *landing,
                               struct store_series *series, struct error *error);

/* What was advised before landings, and kept. */
enum mr_status store_advice_add(struct store *store, const struct store_advice *advice,
                                struct error *error);
enum mr_status store_advices(struct store *store, struct store_advice **rows, size_t *count,
                             struct error *error);

/* The newest landing that happened here, 0: none; and how many were armed since. Neither imported
 * ones, nor such as were disarmed before the gear came. */
enum mr_status store_day_newest(struct store *store, int64_t *run, struct error *error);
enum mr_status store_day_count(struct store *store, int64_t since_us, int64_t *count,
                               struct error *error);
/* The newest session that was logged here; 0: none. */
enum mr_status store_day_session(struct store *store, int64_t *session, struct error *error);

#endif
