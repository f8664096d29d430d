/* Corrected calibrations for landings that are recorded: their readings come from the stored
 * integers, so a landing that has another calibration reads differently from then on. What was in
 * force when it was recorded is kept, as a row each that stays. Conventions as in store.h. */
#ifndef MATRIG_HOST_STORE_STORE_RECALIBRATE_H
#define MATRIG_HOST_STORE_STORE_RECALIBRATE_H

#include "host/store/store.h"

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
/* Whether a landing has another calibration than it was recorded with. */
enum mr_status store_is_recalibrated(struct store *store, int64_t run, bool *is,
                                     struct error *error);

#endif
