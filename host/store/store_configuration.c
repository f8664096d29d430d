#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"

enum mr_status store_configuration_put(struct store *store, uint32_t crc, const char *text,
                                       struct error *error)
{
    const struct store_configuration row = {.crc = crc, .text = text};
    return STORE_PUT(store, error, configuration, &row);
}

enum mr_status store_configuration_get(struct store *store, uint32_t crc, char **text,
                                       struct error *error)
{
    sqlite3_stmt *statement;
    struct store_configuration row;
    *text = NULL;
    enum mr_status status = STORE_QUERY(store, error, CONFIGURATION_GET, &statement, BIND(crc));
    if (status == MR_OK)
        status = STORE_NEXT(store, error, CONFIGURATION_GET, statement, &row);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *text = strdup(row.text ? row.text : "");
    sqlite3_reset(statement);
    return *text ? MR_OK
                 : error_set(error, MR_FULL, "no memory: reading %s; close other programs",
                             store->path);
}
