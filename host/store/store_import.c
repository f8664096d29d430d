#include "host/store/store_import.h"

#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"

enum mr_status store_import_put(struct store *store, const struct store_import *import, struct error *error)
{
    return store_run(store, error, STORE_IMPORT_PUT, import->session, import->file, import->sha256, import->bytes, import->format,
                     import->mapping, import->verdict, import->made_us);
}

enum mr_status store_import_get(struct store *store, int64_t session, struct store_import *import, bool *found, struct error *error)
{
    sqlite3_stmt *s;
    *import = (struct store_import){.session = session};
    *found = false;
    enum mr_status status = store_query(store, error, &s, STORE_IMPORT_GET, session);
    if (status == MR_OK)
        status = store_step(store, s, error);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *found = true;
    store_text(s, 0, import->file, sizeof import->file);
    store_text(s, 1, import->sha256, sizeof import->sha256);
    import->bytes = store_integer(s, 2);
    store_text(s, 3, import->format, sizeof import->format);
    const char *mapping = (const char *)sqlite3_column_text(s, 4);
    import->mapping = mapping ? strdup(mapping) : NULL;
    store_text(s, 5, import->verdict, sizeof import->verdict);
    import->made_us = store_integer(s, 6);
    store_reset(s);
    return MR_OK;
}

enum mr_status store_import_find(struct store *store, const char *sha256, const char *mapping, int64_t *session, struct error *error)
{
    sqlite3_stmt *s;
    *session = 0;
    enum mr_status status = store_query(store, error, &s, STORE_IMPORT_FIND, sha256, mapping);
    if (status == MR_OK)
        status = store_step(store, s, error);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *session = store_integer(s, 0);
    store_reset(s);
    return MR_OK;
}

enum mr_status store_imported_put(struct store *store, int64_t run, const struct store_imported *readings, struct error *error)
{
    return store_run(store, error, STORE_IMPORTED_PUT, run, readings->index, readings->first_block, readings->stride,
                     (const void *)readings->reading, readings->count * sizeof *readings->reading);
}

static enum mr_status take_row(struct store *store, sqlite3_stmt *s, struct store_imported **rows, size_t *count, struct error *error)
{
    size_t bytes = (size_t)sqlite3_column_bytes(s, 3);
    if (bytes == 0 || bytes % sizeof(float) != 0)
        return MR_OK;
    struct store_imported *larger = realloc(*rows, (*count + 1) * sizeof **rows);
    float *reading = malloc(bytes);
    if (larger)
        *rows = larger;
    if (!larger || !reading) {
        free(reading);
        return error_set(error, MR_FULL, "no memory: reading %s; close other programs", store->path);
    }
    memcpy(reading, sqlite3_column_blob(s, 3), bytes);
    (*rows)[(*count)++] = (struct store_imported){.index = store_integer(s, 0), .first_block = store_integer(s, 1),
                                                  .stride = store_integer(s, 2), .count = bytes / sizeof(float), .reading = reading};
    return MR_OK;
}

enum mr_status store_imported(struct store *store, int64_t run, struct store_imported **rows, size_t *count, struct error *error)
{
    sqlite3_stmt *s;
    *rows = NULL;
    *count = 0;
    enum mr_status status = store_query(store, error, &s, STORE_IMPORTED, run);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        status = take_row(store, s, rows, count, error);
        if (status != MR_OK)
            store_reset(s);
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
