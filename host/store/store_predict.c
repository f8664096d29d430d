#include "host/store/store_predict.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"

#define MISSING ((double)NAN)

struct store_prediction store_prediction_blank(int64_t block, int64_t links)
{
    return (struct store_prediction){.block = block, .verdict = STORE_NONE, .reason = STORE_NONE, .level = STORE_NONE,
                                     .basis = STORE_NONE, .age_blocks = STORE_NONE, .start_error_ft = MISSING, .end_error_ft = MISSING,
                                     .mean_gap_in = MISSING, .closed_joints = STORE_NONE, .coming_mats = STORE_NONE,
                                     .coming_wheel_ft = MISSING, .compression_lb = MISSING, .critical_lb = MISSING,
                                     .distance_ft = MISSING, .links = links};
}

enum mr_status store_prediction_put(struct store *store, int64_t run, const struct store_prediction *p, struct error *error)
{
    return store_run(store, error, STORE_PREDICTION_PUT, run, p->block, p->verdict, p->reason, p->level, p->basis, p->age_blocks,
                     p->start_error_ft, p->end_error_ft, p->mean_gap_in, p->closed_joints, p->coming_mats, p->coming_wheel_ft,
                     p->compression_lb, p->critical_lb, p->distance_ft, p->links);
}

static void prediction_row(sqlite3_stmt *s, void *to)
{
    *(struct store_prediction *)to = (struct store_prediction){
        .block = store_integer(s, 0), .verdict = store_integer(s, 1), .reason = store_integer(s, 2), .level = store_integer(s, 3),
        .basis = store_integer(s, 4), .age_blocks = store_integer(s, 5), .start_error_ft = store_real(s, 6),
        .end_error_ft = store_real(s, 7), .mean_gap_in = store_real(s, 8), .closed_joints = store_integer(s, 9),
        .coming_mats = store_integer(s, 10), .coming_wheel_ft = store_real(s, 11), .compression_lb = store_real(s, 12),
        .critical_lb = store_real(s, 13), .distance_ft = store_real(s, 14), .links = store_integer(s, 15)};
}

static void trust_row(sqlite3_stmt *s, void *to)
{
    *(struct store_trust *)to = (struct store_trust){.block = store_integer(s, 0), .doubts = store_integer(s, 1),
                                                     .resistance = store_real(s, 2), .updates = store_real(s, 3),
                                                     .links = store_integer(s, 4)};
}

/* All rows of a landing. */
static enum mr_status read_all(struct store *store, enum store_statement which, int64_t run, size_t size,
                               void (*read)(sqlite3_stmt *statement, void *row), void **rows, size_t *count, struct error *error)
{
    sqlite3_stmt *statement;
    size_t room = 0;
    *rows = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, &statement, which, run);
    while (status == MR_OK && (status = store_step(store, statement, error)) == MR_OK) {
        if (*count == room) {
            room = room ? 2 * room : 256;
            *rows = realloc(*rows, room * size);
            if (!*rows)
                abort();
        }
        read(statement, (char *)*rows + (*count)++ * size);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_predictions(struct store *store, int64_t run, struct store_prediction **rows, size_t *count, struct error *error)
{
    void *made;
    enum mr_status status = read_all(store, STORE_PREDICTIONS, run, sizeof **rows, prediction_row, &made, count, error);
    *rows = made;
    return status;
}

static void backlog_row(sqlite3_stmt *s, void *to)
{
    *(struct store_backlog *)to = (struct store_backlog){store_integer(s, 0), store_integer(s, 1)};
}

enum mr_status store_backlogs(struct store *store, int64_t run, struct store_backlog **rows, size_t *count, struct error *error)
{
    void *made;
    enum mr_status status = read_all(store, STORE_BACKLOGS, run, sizeof **rows, backlog_row, &made, count, error);
    *rows = made;
    return status;
}

enum mr_status store_trust_put(struct store *store, int64_t run, const struct store_trust *row, struct error *error)
{
    return store_run(store, error, STORE_TRUST_PUT, run, row->block, row->doubts, row->resistance, row->updates, row->links);
}

enum mr_status store_trusts(struct store *store, int64_t run, struct store_trust **rows, size_t *count, struct error *error)
{
    void *made;
    enum mr_status status = read_all(store, STORE_TRUSTS, run, sizeof **rows, trust_row, &made, count, error);
    *rows = made;
    return status;
}

enum mr_status store_runway_put(struct store *store, int64_t run, const struct mr_predictor_state *state, int64_t source, struct error *error)
{
    uint8_t image[MR_RUNWAY_IMAGE];
    mr_runway_write(state, 0, image);
    return store_run(store, error, STORE_RUNWAY_PUT, run, (int64_t)state->mats, (int64_t)state->landings, (double)state->scale, source,
                     (int64_t)mr_runway_crc(state), image, sizeof image);
}

enum mr_status store_runway_get(struct store *store, int64_t run, struct mr_predictor_state *state, int64_t *source, bool *there,
                                struct error *error)
{
    sqlite3_stmt *s;
    uint32_t sequence;
    *there = false;
    enum mr_status status = store_query(store, error, &s, STORE_RUNWAY_GET, run);
    if (status == MR_OK)
        status = store_step(store, s, error);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *source = store_integer(s, 0);
    *there = sqlite3_column_bytes(s, 1) == (int)MR_RUNWAY_IMAGE && mr_runway_read(state, &sequence, sqlite3_column_blob(s, 1)) == MR_OK;
    store_reset(s);
    return *there ? MR_OK
                  : error_set(error, MR_MALFORMED, "the runway of RUN %lld is damaged: %s; take another copy", (long long)run, store->path);
}

enum mr_status store_predict_item_put(struct store *store, int64_t run, int64_t item, double value, struct error *error)
{
    return store_run(store, error, STORE_PREDICT_ITEM_PUT, run, item, value);
}

struct item {
    int64_t item;
    double value;
};

static void item_row(sqlite3_stmt *s, void *to)
{
    *(struct item *)to = (struct item){store_integer(s, 0), store_real(s, 1)};
}

enum mr_status store_predict_config(struct store *store, int64_t run, struct mr_predictor_config *config, size_t *items,
                                    struct error *error)
{
    void *made;
    memset(config, 0, sizeof *config);
    enum mr_status status = read_all(store, STORE_PREDICT_ITEMS, run, sizeof(struct item), item_row, &made, items, error);
    for (size_t i = 0; status == MR_OK && i < *items; i++)
        mr_predict_item_set(config, (unsigned)((struct item *)made)[i].item, (float)((struct item *)made)[i].value);
    free(made);
    return status;
}
