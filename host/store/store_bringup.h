/* What boards said at bring-up, in the campaign, by their identity. Conventions as in store.h. */
#ifndef MATRIG_HOST_STORE_STORE_BRINGUP_H
#define MATRIG_HOST_STORE_STORE_BRINGUP_H

#include "host/store/store.h"

struct store_bringup {
    int64_t made_us; /* host time */
    char verdict[8]; /* ok, look, wrong */
    char *text;      /* as the board said it; a read allocates it, the caller frees it */
};

enum mr_status store_bringup_put(struct store *store, const char *board_uid, const char *section,
                                 const struct store_bringup *row, struct error *error);
/* The newest of a board and section. */
enum mr_status store_bringup_get(struct store *store, const char *board_uid, const char *section,
                                 struct store_bringup *row, bool *found, struct error *error);

#endif
