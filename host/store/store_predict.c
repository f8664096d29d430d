#include "host/store/store_predict.h"

#include <stdlib.h>
#include <string.h>

#include "common/wire.h"
#include "host/store/store_sql.h"

STORE_PUT_OF_LANDING(prediction)
STORE_PUT_OF_LANDING(trust)
STORE_PUT_OF_LANDING(risk)
STORE_ROWS_OF_LANDING(store_risks, RISKS)
STORE_ROWS_OF_LANDING(store_predictions, PREDICTIONS)
STORE_ROWS_OF_LANDING(store_backlogs, BACKLOGS)
STORE_ROWS_OF_LANDING(store_trusts, TRUSTS)

enum mr_status store_runway_put(struct store *store, int64_t run,
                                const struct mr_predictor_state *state, int64_t source,
                                struct error *error)
{
    uint8_t image[MR_RUNWAY_IMAGE];
    mr_runway_write(state, 0, image);
    const struct store_runway row = {.mats = state->mats,
                                     .landings = state->landings,
                                     .resistance = (double)state->scale,
                                     .source = source,
                                     .crc = mr_runway_crc(state),
                                     .state = {image, sizeof image}};
    return STORE_PUT(store, error, runway, &row, run);
}

enum mr_status store_runway_get(struct store *store, int64_t run, struct mr_predictor_state *state,
                                int64_t *source, bool *there, struct error *error)
{
    sqlite3_stmt *s;
    struct store_runway row;
    uint32_t sequence;
    *there = false;
    enum mr_status status = STORE_QUERY(store, error, RUNWAY_GET, &s, BIND(run));
    if (status == MR_OK)
        status = STORE_NEXT(store, error, RUNWAY_GET, s, &row);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *source = row.source;
    *there = row.state.length == MR_RUNWAY_IMAGE &&
             mr_runway_read(state, &sequence, row.state.data) == MR_OK;
    sqlite3_reset(s);
    return *there ? MR_OK
                  : error_set(error, MR_MALFORMED,
                              "the runway of RUN %lld is damaged: %s; take another copy",
                              (long long)run, store->path);
}

enum mr_status store_predict_item_put(struct store *store, int64_t run, int64_t item, double value,
                                      struct error *error)
{
    const struct store_predict_item row = {.item = item, .value = value};
    return STORE_PUT(store, error, predict_item, &row, run);
}

static enum mr_status predict_items(struct store *store, int64_t run,
                                    struct store_predict_item **rows, size_t *count,
                                    struct error *error)
{
    STORE_ROWS(PREDICT_ITEMS, BIND(run));
}

enum mr_status store_predict_config(struct store *store, int64_t run,
                                    struct mr_predictor_config *config, size_t *items,
                                    struct error *error)
{
    struct store_predict_item *rows;
    memset(config, 0, sizeof *config);
    enum mr_status status = predict_items(store, run, &rows, items, error);
    for (size_t i = 0; status == MR_OK && i < *items; i++)
        mr_predict_item_set(config, (unsigned)rows[i].item, (float)rows[i].value);
    free(rows);
    return status;
}

enum mr_status store_risk_item_put(struct store *store, int64_t run, int64_t item, double value,
                                   struct error *error)
{
    const struct store_risk_item row = {.item = item, .value = value};
    return STORE_PUT(store, error, risk_item, &row, run);
}

static enum mr_status risk_items(struct store *store, int64_t run, struct store_risk_item **rows,
                                 size_t *count, struct error *error)
{
    STORE_ROWS(RISK_ITEMS, BIND(run));
}

enum mr_status store_risk_get(struct store *store, int64_t run, struct mr_risk_plan *plan,
                              float *lamp_limit, size_t *items, struct error *error)
{
    struct store_risk_item *rows;
    mr_risk_plan_clear(plan);
    *lamp_limit = MR_NAN;
    enum mr_status status = risk_items(store, run, &rows, items, error);
    for (size_t i = 0; status == MR_OK && i < *items; i++) {
        if (!mr_risk_item_set(plan, (unsigned)rows[i].item, (float)rows[i].value))
            *lamp_limit = (float)rows[i].value;
    }
    free(rows);
    return status;
}
