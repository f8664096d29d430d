/* Entries by people: notes and corrections of landings, void landings, observed waves and breaks,
 * series, surveys. Rows are only added: the newest row of a field is valid, the older rows are its
 * history. Conventions as in store.h; missing texts are empty. */
#ifndef MATRIG_HOST_STORE_STORE_JOURNAL_H
#define MATRIG_HOST_STORE_STORE_JOURNAL_H

#include "host/store/store.h"

/* Adds a change of a field of a landing: "note", "void" (value "yes" or "no"), or a corrected
 * value. The function sets change.was in the stored row. After a change of touchdown_ft,
 * store_landing_get returns the new value instead of the board's. */
enum mr_status store_change_add(struct store *store, const struct store_change *change,
                                struct error *error);
/* Reads the newest value of a field; empty if there is none. `reason` may be NULL. */
enum mr_status store_change_get(struct store *store, int64_t run, const char *field,
                                char value[STORE_JOURNAL_TEXT_SIZE],
                                char reason[STORE_JOURNAL_TEXT_SIZE], struct error *error);
enum mr_status store_is_void(struct store *store, int64_t run, bool *is_void,
                             char reason[STORE_JOURNAL_TEXT_SIZE], struct error *error);
/* Fails with MR_NOT_NOW and the reason if the landing is void, unless `allowed` is true. */
enum mr_status store_check_not_void(struct store *store, int64_t run, bool allowed,
                                    struct error *error);

enum mr_status store_observation_add(struct store *store,
                                     const struct store_observation *observation,
                                     struct error *error);
enum mr_status store_observation_withdraw(struct store *store, int64_t run, int64_t id,
                                          int64_t made_us, const char *who, const char *reason,
                                          struct error *error);

/* Reads the series of a landing: the series entered for the landing, otherwise the newest series
 * that began before the landing was armed. series->id is 0 if there is none. */
enum mr_status store_landing_series_get(struct store *store, const struct store_landing *landing,
                                        struct store_series *series, struct error *error);

/* Counts the landings armed since `since_us`, except imported landings and landings that were
 * disarmed before the gear arrived. */
enum mr_status store_count_landings_since(struct store *store, int64_t since_us, int64_t *count,
                                          struct error *error);

/* ---- the same landing twice in a campaign ---- */

/* Finds the earliest RUN before `run` that is the same landing and not void; 0: none. A landing has
 * two RUNs if it was logged or imported twice, or recorded by another instrument. Two RUNs are the
 * same landing if they agree in board (if both are known), landing number and edges: at least two
 * edges have the same count, and all of these have the same tick. */
enum mr_status store_find_duplicate(struct store *store, int64_t run, int64_t *duplicate,
                                    struct error *error);

/* ---- corrected calibrations of recorded landings ----
 *
 * Readings are computed from the stored integers with the landing's calibration, so a new
 * calibration changes them. The replaced values are kept, one row per value. */

#define STORE_ITEM_UNIT_PER_CODE \
    (-1)                          /* unit_per_code; items 0 and higher: enum mr_calibration_item */
#define STORE_ITEM_ZERO_CODE (-2) /* zero_code */

struct store_recalibration {
    int64_t made_us;
    const char *who, *reason;
    /* also change the zeros of gages, although they were measured before the landing */
    bool changes_gage_zeros;
};
/* Changes the calibration of channel `index` of a landing, in the caller's transaction. *changed is
 * the number of changed values. */
enum mr_status store_recalibrate(struct store *store, int64_t run, unsigned index,
                                 const struct mr_channel_config *old,
                                 const struct mr_channel_config *new,
                                 const struct store_recalibration *how, unsigned *changed,
                                 struct error *error);
/* Reads which channels of a landing were recalibrated after the recording, as a bit mask by channel
 * index. */
enum mr_status store_recalibrated_channels_get(struct store *store, int64_t run, int64_t *channels,
                                               struct error *error);

/* ---- surveys of the mat by gage points ----
 *
 * Each reading is one row. Outside a transaction it is on disk when store_gage_reading_add returns.
 * Rows are never changed: the newest row of a place is valid. */

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
/* Makes every later commit wait until the data is on disk. Unnecessary after STORE_CREATE and
 * STORE_LOG. */
enum mr_status store_set_durable(struct store *store, struct error *error);

#endif
