/* Structs for the rows of a campaign's tables, generated from tables.def: struct store_edge is a
 * row of the table `edges`. tables.def lists the fields with their units.
 *
 * An INTEGER is an int64_t, and NULL is STORE_NONE. A REAL is a double, and NULL is NaN. A TEXT is
 * an array of characters, and NULL is an empty string. A put function copies the data to which
 * pointers point. */
#ifndef MATRIG_HOST_STORE_ROWS_H
#define MATRIG_HOST_STORE_ROWS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/image.h"

#define STORE_NONE              INT64_MIN
#define STORE_TEXT_SIZE         200
#define STORE_JOURNAL_TEXT_SIZE 400
#define STORE_RECORD_TEXT_SIZE  2000

struct store_bytes {
    const void *data;
    size_t length;
};

/* clang-format off */
#define TABLE(row, table) struct store_##row {
#define COLUMN(row, column, declaration, field, type, constraint, merge, empty, read) declaration;
#define COMPUTED(row, declaration, field, read) declaration;
#define TABLE_END(row, key, put) };
/* clang-format on */
#include "host/store/tables.def"

/* Rows in which every field is missing, one for each struct: store_blank_edge is a store_edge. */
#define NO_VIEWS
#define TABLE(row, table) extern const struct store_##row store_blank_##row;
#include "host/store/tables.def"

#endif
