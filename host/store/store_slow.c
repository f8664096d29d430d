/* What the board tells each second of a landing, and rows of the slow log. */
#include "host/store/store_sql.h"

STORE_PUT_OF_LANDING(mat_temperature)

enum mr_status store_mean_get(struct store *store, int64_t run, enum mr_quantity quantity,
                              struct store_mean *mean, struct error *error)
{
    *mean = (struct store_mean){0};
    switch ((int)quantity) {
/* clang-format off */
#define MEAN(name, NAME, quantity, table, column, error_column, why) \
    case MR_QUANTITY_##quantity: return STORE_ONE(store, error, MEAN_##quantity, mean, BIND(run));
/* clang-format on */
#include "common/catalogue.def"
    default: return MR_OK;
    }
}

enum mr_status store_slow_put(struct store *store, const struct store_slow *row,
                              struct error *error)
{
    return STORE_PUT(store, error, slow, row);
}

enum mr_status store_slow_rows(struct store *store, const char *board_uid, struct store_slow **rows,
                               size_t *count, struct error *error)
{
    STORE_ROWS(SLOW_ROWS, BIND(board_uid));
}
