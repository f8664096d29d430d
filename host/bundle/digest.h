/* SHA-256 of what a bundle holds (bundle.h says of what bytes). */
#ifndef MATRIG_HOST_BUNDLE_DIGEST_H
#define MATRIG_HOST_BUNDLE_DIGEST_H

#include <sqlite3.h>

#include "host/bundle/bundle.h"

void digest_bytes(const void *bytes, size_t size, char hex[BUNDLE_DIGEST]);

struct digest_sum {
    char hex[BUNDLE_DIGEST];
    int64_t bytes, rows;
};
/* Of a table, or of the schema with `table` NULL. SQLITE_OK, or SQLite's code: what there is cannot
 * be read; SQLITE_TOOBIG: more than `bytes_max`. */
int digest_table(sqlite3 *database, const char *table, int64_t bytes_max, struct digest_sum *sum);

/* Of a whole file with its seal's digits as zeros; `*at`: where they are, 0: there is no seal, or
 * more than one. */
void digest_sealed(const uint8_t *bytes, size_t size, char hex[BUNDLE_DIGEST], size_t *at);

#endif
