#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"

enum mr_status store_configuration_put(struct store *store, uint32_t crc, const char *text, struct error *error)
{
    return store_run(store, error, STORE_CONFIGURATION_PUT, (int64_t)crc, text);
}

enum mr_status store_configuration_get(struct store *store, uint32_t crc, char **text, struct error *error)
{
    sqlite3_stmt *statement;
    *text = NULL;
    enum mr_status status = store_query(store, error, &statement, STORE_CONFIGURATION_GET, (int64_t)crc);
    if (status == MR_OK)
        status = store_step(store, statement, error);
    if (status == MR_TOO_FEW)
        return MR_OK;
    if (status != MR_OK)
        return status;
    const char *found = (const char *)sqlite3_column_text(statement, 0);
    *text = strdup(found ? found : "");
    store_reset(statement);
    return *text ? MR_OK : error_set(error, MR_FULL, "no memory: reading %s; close other programs", store->path);
}
