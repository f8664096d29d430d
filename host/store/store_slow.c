/* Mat temperature of landings, and rows of the slow log. */
#include "host/store/store_sql.h"

STORE_PUT_OF_LANDING(mat_temperature)

enum mr_status store_temperature_get(struct store *store, int64_t run, struct store_temperature *temperature, struct error *error)
{
    *temperature = (struct store_temperature){0};
    enum mr_status status = STORE_ONE(store, error, TEMPERATURE_GET, temperature, BIND(run));
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_slow_put(struct store *store, const struct store_slow *row, struct error *error)
{
    return STORE_PUT(store, error, slow, row);
}

enum mr_status store_slow_rows(struct store *store, const char *board_uid, struct store_slow **rows, size_t *count,
                               struct error *error)
{
    STORE_ROWS(SLOW_ROWS, BIND(board_uid));
}
