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

/* The series that a landing belongs to: that of its correction, else the newest one begun before it
 * was armed; id 0: none. */
enum mr_status store_series_of(struct store *store, const struct store_landing *landing,
                               struct store_series *series, struct error *error);

/* How many landings were armed here since; neither imported ones, nor such as were disarmed before
 * the gear came. */
enum mr_status store_day_count(struct store *store, int64_t since_us, int64_t *count,
                               struct error *error);

/* ---- one landing twice in a campaign ---- */

/* The earliest RUN before `run` that is the same landing: logged or imported twice, or read by
 * another instrument, and not void; 0: none. */
enum mr_status store_find_twin(struct store *store, int64_t run, int64_t *twin,
                               struct error *error);
/* Board (another instrument's readings have none), number and the captures of switches agree: of
 * the edges that both have, two at least, each is the same. */

/* ---- corrected calibrations for landings that are recorded ----
 *
 * Readings come from the stored integers, so a landing that has another calibration reads
 * differently from then on. What was in force when it was recorded is kept, as a row each that
 * stays. */

#define STORE_ITEM_UNIT (-1) /* unit_per_code; items from 0 on are enum mr_calibration_item */
#define STORE_ITEM_ZERO (-2) /* zero_code */

struct store_recalibration {
    int64_t made_us;
    const char *who, *reason;
    bool zeros; /* those of gages too, which were measured before the landing */
};
/* Gives channel `index` of a landing another calibration, in the caller's transaction. *changed:
 * how many values are different. */
enum mr_status store_recalibrate(struct store *store, int64_t run, unsigned index,
                                 const struct mr_channel_config *old,
                                 const struct mr_channel_config *new,
                                 const struct store_recalibration *how, unsigned *changed,
                                 struct error *error);
/* Which channels of a landing have another calibration than it was recorded with: bit of index. */
enum mr_status store_recalibrated(struct store *store, int64_t run, int64_t *channels,
                                  struct error *error);

/* ---- surveys of the mat by gage points, as they were read ----
 *
 * A reading is a row of its own, written and on disk when store_gage_reading_add returns (outside a
 * transaction); readings are never changed, the newest of a place holds. */

enum mr_status store_gage_survey_add(struct store *store, struct store_gage_survey *survey,
                                     struct error *error);
enum mr_status store_gage_survey_end(struct store *store, int64_t survey, int64_t ended_us,
                                     struct error *error);
enum mr_status store_gage_reading_add(struct store *store, int64_t survey,
                                      const struct store_gage_reading *reading,
                                      struct error *error);
/* That a board was given the survey. */
enum mr_status store_gage_load_add(struct store *store, int64_t survey, int64_t made_us,
                                   const char *link, int64_t segments, struct error *error);
/* From now on a commit is on disk when it returns, also for a campaign that was not opened to be
 * created. */
enum mr_status store_durable(struct store *store, struct error *error);

#endif
