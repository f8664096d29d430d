/* What came into the campaign from a file: the file, and readings of other instruments. A session
 * of matrig import is a session like that of matrig log; its row in `imports` says from which
 * file. */
#ifndef MATRIG_HOST_STORE_STORE_IMPORT_H
#define MATRIG_HOST_STORE_STORE_IMPORT_H

#include "host/store/store.h"

struct store_import {
    int64_t session;
    char file[400];
    char sha256[65]; /* of its bytes */
    int64_t bytes;
    char format[16]; /* candump, csv, signals (frames of other instruments) */
    char verdict[300];
    int64_t made_us;
    char *mapping; /* the mapping as used; NULL: none. A read allocates it */
};
enum mr_status store_import_put(struct store *store, const struct store_import *import,
                                struct error *error);
/* Of a session; `*found` false: it was logged. The caller frees import->mapping. */
enum mr_status store_import_get(struct store *store, int64_t session, struct store_import *import,
                                bool *found, struct error *error);
/* The session that took in a file of this hash with this mapping (NULL: none), and of the board at
 * this base, to its end; 0: none has. */
enum mr_status store_import_find(struct store *store, const char *sha256, const char *mapping,
                                 uint16_t can_base, int64_t *session, struct error *error);

/* Readings of one channel by 1 ms blocks, in its unit. */
struct store_imported {
    int64_t index; /* channel */
    int64_t first_block;
    int64_t stride; /* blocks from one sample of the instrument to the next */
    size_t count;
    float *reading; /* NaN: missing; a read allocates it */
};
enum mr_status store_imported_put(struct store *store, int64_t run,
                                  const struct store_imported *readings, struct error *error);
/* store_imported_free releases them. A row whose readings are no whole floats is left out. */
enum mr_status store_imported(struct store *store, int64_t run, struct store_imported **rows,
                              size_t *count, struct error *error);
void store_imported_free(struct store_imported *rows, size_t count);

#endif
