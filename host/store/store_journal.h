/* What people enter about landings: notes, corrections, voidings, observed waves and breaks; and
 * series. Rows are only added: the newest row of a field is valid, and all rows are the history.
 * Conventions as in store.h; missing texts are empty. */
#ifndef MATRIG_HOST_STORE_STORE_JOURNAL_H
#define MATRIG_HOST_STORE_STORE_JOURNAL_H

#include "host/store/store.h"

/* Adds a change. `was` is filled in by the function. Fields: note, void ("yes", "no"), and the
 * corrected values; a corrected touchdown_ft replaces the board's value from then on. */
enum mr_status store_change_add(struct store *store, const struct store_change *change,
                                struct error *error);
/* The newest value of a field; empty: never entered. `reason` may be NULL. */
enum mr_status store_change_get(struct store *store, int64_t run, const char *field,
                                char value[STORE_JOURNAL_TEXT], char reason[STORE_JOURNAL_TEXT],
                                struct error *error);
enum mr_status store_is_void(struct store *store, int64_t run, bool *is_void,
                             char reason[STORE_JOURNAL_TEXT], struct error *error);
/* Fails with MR_LIMIT and the reason if the landing is void and `allowed` is not set. */
enum mr_status store_refuse_void(struct store *store, int64_t run, bool allowed,
                                 struct error *error);

enum mr_status store_observation_add(struct store *store,
                                     const struct store_observation *observation,
                                     struct error *error);
enum mr_status store_observation_withdraw(struct store *store, int64_t run, int64_t id,
                                          int64_t made_us, const char *who, const char *reason,
                                          struct error *error);

/* The series of a landing: that of its correction, otherwise the newest one begun before it was
 * armed; id 0: none. */
enum mr_status store_series_of(struct store *store, const struct store_landing *landing,
                               struct store_series *series, struct error *error);

/* Number of landings armed here since `since_us`, except imported landings and landings that were
 * disarmed before the gear arrived. */
enum mr_status store_day_count(struct store *store, int64_t since_us, int64_t *count,
                               struct error *error);

/* ---- the same landing twice in a campaign ---- */

/* The earliest RUN before `run` that is the same landing and not void: logged or imported twice, or
 * recorded by another instrument; 0: none. Two RUNs are the same landing if board (not known for
 * another instrument), number and switch captures agree: they share at least two edges, and all
 * shared edges are equal. */
enum mr_status store_find_twin(struct store *store, int64_t run, int64_t *twin,
                               struct error *error);

/* ---- corrected calibrations of recorded landings ----
 *
 * Readings are computed from stored integers, so a landing with a new calibration gives different
 * values from then on. The calibration with which it was recorded is kept permanently, one row per
 * value. */

#define STORE_ITEM_UNIT (-1) /* unit_per_code; items from 0 on are enum mr_calibration_item */
#define STORE_ITEM_ZERO (-2) /* zero_code */

struct store_recalibration {
    int64_t made_us;
    const char *who, *reason;
    bool zeros; /* also change zeros of gages, which were measured before the landing */
};
/* Changes the calibration of channel `index` of a landing, in the caller's transaction. *changed:
 * number of changed values. */
enum mr_status store_recalibrate(struct store *store, int64_t run, unsigned index,
                                 const struct mr_channel_config *old,
                                 const struct mr_channel_config *new,
                                 const struct store_recalibration *how, unsigned *changed,
                                 struct error *error);
/* Channels of a landing whose calibration was changed since it was recorded: bit mask by channel
 * index. */
enum mr_status store_recalibrated(struct store *store, int64_t run, int64_t *channels,
                                  struct error *error);

/* ---- surveys of the mat by gage points, as read ----
 *
 * Each reading is a row, which is on disk when store_gage_reading_add returns (outside a
 * transaction). Readings are never changed; the newest reading of a place is valid. */

enum mr_status store_gage_survey_add(struct store *store, struct store_gage_survey *survey,
                                     struct error *error);
enum mr_status store_gage_survey_end(struct store *store, int64_t survey, int64_t ended_us,
                                     struct error *error);
enum mr_status store_gage_reading_add(struct store *store, int64_t survey,
                                      const struct store_gage_reading *reading,
                                      struct error *error);
/* Records that the survey was sent to a board. */
enum mr_status store_gage_load_add(struct store *store, int64_t survey, int64_t made_us,
                                   const char *link, int64_t segments, struct error *error);
/* Makes every later commit return only when it is on disk, also for a campaign that was not opened
 * with STORE_CREATE. */
enum mr_status store_durable(struct store *store, struct error *error);

#endif
