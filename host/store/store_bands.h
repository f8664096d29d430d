/* Bands in the campaign: figures and findings of each landing as the board told them, shunt
 * calibrations of a session.
 *
 * Conventions as in store.h. A shunt calibration belongs to no landing: it is before one and after
 * another. */
#ifndef MATRIG_HOST_STORE_STORE_BANDS_H
#define MATRIG_HOST_STORE_STORE_BANDS_H

#include "host/store/store.h"

/* Completes what is there: NaN and STORE_NONE leave a value as it is. */
enum mr_status store_band_put(struct store *store, int64_t run, const struct store_band *band,
                              struct error *error);
enum mr_status store_bands(struct store *store, int64_t run, struct store_band **rows,
                           size_t *count, struct error *error);
enum mr_status store_band_event_put(struct store *store, int64_t run,
                                    const struct store_band_event *event, struct error *error);
enum mr_status store_band_events(struct store *store, int64_t run, struct store_band_event **rows,
                                 size_t *count, struct error *error);
enum mr_status store_shunt_put(struct store *store, int64_t session, int64_t boot,
                               const struct store_shunt *shunt, struct error *error);
/* The last calibration before `block` of a session's boot, and the first from there on; none:
 * *count 0. */
enum mr_status store_shunts_before(struct store *store, int64_t session, int64_t boot,
                                   int64_t block, struct store_shunt **rows, size_t *count,
                                   struct error *error);
enum mr_status store_shunts_after(struct store *store, int64_t session, int64_t boot, int64_t block,
                                  struct store_shunt **rows, size_t *count, struct error *error);

#endif
