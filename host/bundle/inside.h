/* An opened bundle, for the files of this folder. */
#ifndef MATRIG_HOST_BUNDLE_INSIDE_H
#define MATRIG_HOST_BUNDLE_INSIDE_H

#include <sqlite3.h>

#include "host/bundle/bundle.h"

struct bundle {
    /* as read, but for the header's page count and journal mode: these so that it can be read */
    uint8_t *bytes;
    size_t size;
    sqlite3 *database;
    long turns;     /* of the progress handler */
    int64_t hashed; /* bytes of tables so far */
};

/* An enum bundle_file, or -1. */
int bundle_known_file(const char *name, size_t length);

/* The file unpacked, which the caller frees; NULL: `why` says why it is not there. */
uint8_t *bundle_unpack(struct bundle *bundle, const char *name, size_t *size, char *why,
                       size_t why_size);

#endif
