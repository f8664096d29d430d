/* Mat temperature of landings, and rows of the slow log. */
#include "host/store/store_sql.h"

enum mr_status store_temperature_put(struct store *store, int64_t run, int64_t block, double temperature_c, double error_c,
                                     int64_t links, struct error *error)
{
    const struct store_mat_temperature row = {.block = block, .temperature_c = temperature_c, .error_c = error_c, .links = links};
    return STORE_PUT(store, error, mat_temperature, &row, run);
}

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
