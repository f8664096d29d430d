/* The rows of a campaign's tables, one struct each: struct store_edge, store_event, ... Their
 * fields, with units, are in tables.def.
 *
 * An INTEGER is an int64_t, STORE_NONE where the file has NULL; a REAL a double, NaN likewise; a
 * TEXT an array of characters, empty likewise. A put copies what pointers point to. */
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

/* store_blank_edge, ...: a row of a table that says nothing yet. */
#define NO_VIEWS
#define TABLE(row, table) extern const struct store_##row store_blank_##row;
#include "host/store/tables.def"

#endif
