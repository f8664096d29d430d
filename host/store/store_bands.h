/* Bands in the campaign: figures and findings of each landing as the board told them, shunt calibrations of a session.
 *
 * Conventions as in store.h. A shunt calibration belongs to no landing: it is before one and after another. */
#ifndef MATRIG_HOST_STORE_STORE_BANDS_H
#define MATRIG_HOST_STORE_STORE_BANDS_H

#include "host/store/store.h"

struct store_band {
    int64_t band; /* from 1 */
    int64_t gages;
    double before_lb, before_error_lb, spread_lb;
    double least_lb, least_error_lb;
    int64_t least_gage, least_block;
    double most_lb, most_error_lb;
    int64_t most_gage, most_block;
    double after_lb, change_lb, change_error_lb;
    int64_t links;
};

struct store_band_event {
    int64_t block, band, gage, reason, other;
    double value_lb;
    int64_t links;
};

struct store_shunt {
    int64_t number; /* of the calibration, since the board's reset */
    int64_t gage;
    int64_t block;  /* in which the calibration began */
    int64_t verdict;
    double span_lb, noise_lb, expected_lb;
    double change_lb, zero_change_lb; /* since the calibration before, as the board told */
    int64_t links;
};

/* Completes what is there: NaN and STORE_NONE leave a value as it is. */
enum mr_status store_band_put(struct store *store, int64_t run, const struct store_band *band, struct error *error);
enum mr_status store_bands(struct store *store, int64_t run, struct store_band **rows, size_t *count, struct error *error);
enum mr_status store_band_event_put(struct store *store, int64_t run, const struct store_band_event *event,
                                    struct error *error);
enum mr_status store_band_events(struct store *store, int64_t run, struct store_band_event **rows, size_t *count,
                                 struct error *error);
enum mr_status store_shunt_put(struct store *store, int64_t session, int64_t boot, const struct store_shunt *shunt,
                               struct error *error);
/* The last calibration before `block` of a session's boot, and the first from there on; none: *count 0. */
enum mr_status store_shunts_before(struct store *store, int64_t session, int64_t boot, int64_t block,
                                   struct store_shunt **rows, size_t *count, struct error *error);
enum mr_status store_shunts_after(struct store *store, int64_t session, int64_t boot, int64_t block,
                                  struct store_shunt **rows, size_t *count, struct error *error);

#endif
