#include "host/store/store_import.h"

#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"
#include "host/base/xmalloc.h"

enum mr_status store_import_put(struct store *store, const struct store_import *import,
                                struct error *error)
{
    struct store_import_row row = {
        .bytes = import->bytes, .mapping = import->mapping, .made_us = import->made_us};
    memcpy(row.file, import->file, sizeof row.file);
    memcpy(row.sha256, import->sha256, sizeof row.sha256);
    memcpy(row.format, import->format, sizeof row.format);
    memcpy(row.verdict, import->verdict, sizeof row.verdict);
    return STORE_PUT(store, error, import_row, &row, import->session);
}

enum mr_status store_import_get(struct store *store, int64_t session, struct store_import *import,
                                bool *found, struct error *error)
{
    sqlite3_stmt *s;
    struct store_import_row row;
    *import = (struct store_import){.session = session};
    *found = false;
    enum mr_status status = STORE_QUERY(store, error, IMPORT_GET, &s, BIND(session));
    if (status == MR_OK)
        status = STORE_NEXT(store, error, IMPORT_GET, s, &row);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *found = true;
    import->bytes = row.bytes;
    import->made_us = row.made_us;
    import->mapping = row.mapping ? strdup(row.mapping) : NULL;
    memcpy(import->file, row.file, sizeof row.file);
    memcpy(import->sha256, row.sha256, sizeof row.sha256);
    memcpy(import->format, row.format, sizeof row.format);
    memcpy(import->verdict, row.verdict, sizeof row.verdict);
    sqlite3_reset(s);
    return MR_OK;
}

enum mr_status store_import_find(struct store *store, const char *sha256, const char *mapping,
                                 uint16_t can_base, int64_t *session, struct error *error)
{
    *session = 0;
    enum mr_status status = STORE_NUMBER(store, error, IMPORT_FIND, session, BIND(sha256),
                                         BIND(mapping), BIND((int64_t)can_base));
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_imported_put(struct store *store, int64_t run,
                                  const struct store_imported *readings, struct error *error)
{
    const struct store_imported_row row = {
        .index = readings->index,
        .first_block = readings->first_block,
        .stride = readings->stride,
        .readings = {readings->reading, readings->count * sizeof *readings->reading}};
    return STORE_PUT(store, error, imported_row, &row, run);
}

static enum mr_status take_row(struct store *store, const struct store_imported_row *row,
                               struct store_imported **rows, size_t *count, struct error *error)
{
    size_t bytes = row->readings.length;
    if (bytes == 0 || bytes % sizeof(float) != 0)
        return MR_OK;
    float *reading = malloc(bytes);
    if (!reading || !list_grow(rows, *count, sizeof **rows)) {
        free(reading);
        return error_set(error, MR_FULL, "no memory: reading %s; close other programs",
                         store->path);
    }
    memcpy(reading, row->readings.data, bytes);
    (*rows)[(*count)++] = (struct store_imported){.index = row->index,
                                                  .first_block = row->first_block,
                                                  .stride = row->stride,
                                                  .count = bytes / sizeof(float),
                                                  .reading = reading};
    return MR_OK;
}

enum mr_status store_imported(struct store *store, int64_t run, struct store_imported **rows,
                              size_t *count, struct error *error)
{
    sqlite3_stmt *s;
    struct store_imported_row row;
    *rows = NULL;
    *count = 0;
    enum mr_status status = STORE_QUERY(store, error, IMPORTED, &s, BIND(run));
    while (status == MR_OK && (status = STORE_NEXT(store, error, IMPORTED, s, &row)) == MR_OK) {
        status = take_row(store, &row, rows, count, error);
        if (status != MR_OK)
            sqlite3_reset(s);
    }
    if (status == MR_TOO_FEW)
        return MR_OK;
    store_imported_free(*rows, *count);
    *rows = NULL;
    *count = 0;
    return status;
}

void store_imported_free(struct store_imported *rows, size_t count)
{
    for (size_t i = 0; i < count; i++)
        free(rows[i].reading);
    free(rows);
}
