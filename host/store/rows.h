/* The rows of a campaign's tables, one struct each: struct store_edge, store_event, ... tables.def
 * lists their fields, with units.
 *
 * An INTEGER is an int64_t, STORE_NONE for NULL; a REAL is a double, NaN for NULL; a TEXT is an
 * array of characters, empty for NULL. A put copies the data behind pointers. */
#ifndef MATRIG_HOST_STORE_ROWS_H
#define MATRIG_HOST_STORE_ROWS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/image.h"

#define STORE_NONE         INT64_MIN
#define STORE_TEXT         200
#define STORE_JOURNAL_TEXT 400
#define STORE_RECORD_TEXT  2000

struct store_bytes {
    const void *data;
    size_t length;
};

/* clang-format off */
#define TABLE(row, table) struct store_##row {
#define COLUMN(row, column, declaration, field, type, constraint, merge, empty, read) declaration;
#define COMPUTED(row, declaration, field, read) declaration;
#define END(row, key, put) };
/* clang-format on */
#include "host/store/tables.def"

/* store_blank_edge, ...: rows in which every field has its value for NULL. */
#define NO_VIEWS
#define TABLE(row, table) extern const struct store_##row store_blank_##row;
#include "host/store/tables.def"

#endif
