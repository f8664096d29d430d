#include "host/store/store_bringup.h"

#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"

enum mr_status store_bringup_put(struct store *store, const char *board_uid, const char *section,
                                 const struct store_bringup *row, struct error *error)
{
    struct store_bringup_row kept = {
        .made_us = row->made_us, .board_uid = board_uid, .section = section, .text = row->text};
    memcpy(kept.verdict, row->verdict, sizeof kept.verdict);
    return STORE_PUT(store, error, bringup_row, &kept);
}

enum mr_status store_bringup_get(struct store *store, const char *board_uid, const char *section,
                                 struct store_bringup *row, bool *found, struct error *error)
{
    sqlite3_stmt *s;
    struct store_bringup_row kept;
    *row = (struct store_bringup){0};
    *found = false;
    enum mr_status status = STORE_QUERY(store, error, BRINGUP_GET, &s, BIND(board_uid),
                                        BIND(section));
    if (status == MR_OK)
        status = STORE_NEXT(store, error, BRINGUP_GET, s, &kept);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    row->made_us = kept.made_us;
    memcpy(row->verdict, kept.verdict, sizeof row->verdict);
    row->text = strdup(kept.text ? kept.text : "");
    sqlite3_reset(s);
    if (!row->text)
        abort();
    *found = true;
    return MR_OK;
}
