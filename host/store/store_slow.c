/* Mat temperature of landings, and rows of the slow log. */
#include <stdlib.h>

#include "host/store/store_sql.h"

enum mr_status store_temperature_put(struct store *store, int64_t run, int64_t block, double temperature_c, double error_c,
                                     int64_t links, struct error *error)
{
    return store_run(store, error, STORE_TEMPERATURE_PUT, run, block, temperature_c, error_c, links);
}

enum mr_status store_temperature_get(struct store *store, int64_t run, struct store_temperature *temperature, struct error *error)
{
    sqlite3_stmt *s;
    *temperature = (struct store_temperature){0};
    enum mr_status status = store_query(store, error, &s, STORE_TEMPERATURE_GET, run);
    if (status == MR_OK)
        status = store_step(store, s, error);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    temperature->told = store_integer(s, 0);
    temperature->readings = store_integer(s, 1);
    temperature->mean_c = store_real(s, 2);
    temperature->error_c = store_real(s, 3);
    store_reset(s);
    return MR_OK;
}

enum mr_status store_slow_put(struct store *store, const struct store_slow *row, struct error *error)
{
    const double *d = row->displacement_in, *t = row->tension_lb;
    return store_run(store, error, STORE_SLOW_PUT, row->board_uid, row->seq, row->boot, row->block, row->time_us, row->faults,
                     row->state, row->temperature_c, d[0], d[1], d[2], d[3], d[4], d[5], d[6], d[7], t[0], t[1], t[2], t[3], t[4],
                     t[5], t[6], t[7], t[8], t[9], t[10], t[11], t[12], t[13]);
}

static void take_row(sqlite3_stmt *s, struct store_slow *row)
{
    store_text(s, 0, row->board_uid, sizeof row->board_uid);
    row->seq = store_integer(s, 1);
    row->boot = store_integer(s, 2);
    row->block = store_integer(s, 3);
    row->time_us = store_integer(s, 4);
    row->faults = store_integer(s, 5);
    row->state = store_integer(s, 6);
    row->temperature_c = store_real(s, 7);
    for (int i = 0; i < (int)MR_TRANSDUCERS; i++)
        row->displacement_in[i] = store_real(s, 8 + i);
    for (int i = 0; i < (int)MR_GAGES; i++)
        row->tension_lb[i] = store_real(s, 8 + (int)MR_TRANSDUCERS + i);
}

enum mr_status store_slow_rows(struct store *store, const char *board_uid, struct store_slow **rows, size_t *count,
                               struct error *error)
{
    sqlite3_stmt *s;
    size_t room = 0;
    *rows = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, &s, STORE_SLOW_ROWS, board_uid);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        if (*count == room) {
            room = room ? 2 * room : 256;
            *rows = realloc(*rows, room * sizeof **rows);
            if (!*rows)
                abort();
        }
        take_row(s, &(*rows)[(*count)++]);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}
