/* The predictor in the campaign: what the board said of the mats, the runway and the parameters
 * that a landing was armed with.
 *
 * Conventions as in store.h. A row that came in parts is completed by the next one put. */
#ifndef MATRIG_HOST_STORE_STORE_PREDICT_H
#define MATRIG_HOST_STORE_STORE_PREDICT_H

#include "common/risk.h"
#include "common/runway.h"
#include "host/store/store.h"

/* One statement, but what `zones` has of it. STORE_NONE, NaN: not said, or it did not come. */

/* Blocks in which others waited for the predictor, ascending. */
enum mr_status store_backlogs(struct store *store, int64_t run, struct store_backlog **rows,
                              size_t *count, struct error *error);

enum mr_status store_prediction_put(struct store *store, int64_t run,
                                    const struct store_prediction *row, struct error *error);
enum mr_status store_predictions(struct store *store, int64_t run, struct store_prediction **rows,
                                 size_t *count, struct error *error);
enum mr_status store_trust_put(struct store *store, int64_t run, const struct store_trust *row,
                               struct error *error);
enum mr_status store_trusts(struct store *store, int64_t run, struct store_trust **rows,
                            size_t *count, struct error *error);

enum mr_status store_risk_put(struct store *store, int64_t run, const struct store_risk *row,
                              struct error *error);
enum mr_status store_risks(struct store *store, int64_t run, struct store_risk **rows,
                           size_t *count, struct error *error);
enum mr_status store_risk_item_put(struct store *store, int64_t run, int64_t item, double value,
                                   struct error *error);
/* `*lamp_limit`: NaN: none. `*items`: how many there are; 0: the board sent none. */
enum mr_status store_risk_get(struct store *store, int64_t run, struct mr_risk_plan *plan,
                              float *lamp_limit, size_t *items, struct error *error);

/* Whole runways only. `*there` false: the landing has none. */
enum mr_status store_runway_put(struct store *store, int64_t run,
                                const struct mr_predictor_state *state, int64_t source,
                                struct error *error);
enum mr_status store_runway_get(struct store *store, int64_t run, struct mr_predictor_state *state,
                                int64_t *source, bool *there, struct error *error);
enum mr_status store_predict_item_put(struct store *store, int64_t run, int64_t item, double value,
                                      struct error *error);
/* `*items`: how many there are; all MR_PREDICT_ITEMS are needed. */
enum mr_status store_predict_config(struct store *store, int64_t run,
                                    struct mr_predictor_config *config, size_t *items,
                                    struct error *error);

#endif
