/* Results of `matrig ready`, sensor certificates, and functions with which `matrig ready` checks a
 * campaign. Conventions as in store.h.
 *
 * Each run of `matrig ready` stores one result. A landing uses the newest result of its board. */
#ifndef MATRIG_HOST_STORE_STORE_READINESS_H
#define MATRIG_HOST_STORE_STORE_READINESS_H

#include "host/store/store.h"

/* 12 h: how long after `matrig ready` its result is valid for a landing */
#define STORE_READINESS_VALID_US      43200000000
#define STORE_READINESS_VALID_US_TEXT "43200000000"

struct store_readiness {
    int64_t made_us; /* host time */
    char verdict[8]; /* go, no-go */
    char *checks;    /* JSON; a read allocates it, the caller frees it */
};

/* Stores a result. `kind`: "ready" or "walk". */
enum mr_status store_readiness_put(struct store *store, const char *board_uid, const char *kind,
                                   const struct store_readiness *row, struct error *error);
/* Reads the newest result of a board and kind at the time `until_us`. If `only_valid` is true,
 * ignores a result older than STORE_READINESS_VALID_US. */
enum mr_status store_readiness_get(struct store *store, const char *board_uid, const char *kind,
                                   int64_t until_us, bool only_valid, struct store_readiness *row,
                                   bool *found, struct error *error);

/* Reads the unique number of the board that was last logged or checked; empty: none. */
enum mr_status store_newest_board_get(struct store *store, char board_uid[25], struct error *error);

/* store_certificate_add stores a sensor certificate in its own transaction. store_certificates_get
 * reads the newest certificate of each channel of a board. */
enum mr_status store_certificate_add(struct store *store, const struct store_certificate *row,
                                     struct error *error);
enum mr_status store_certificates_get(struct store *store, const char *board_uid,
                                      struct store_certificate **rows, size_t *count,
                                      struct error *error);

/* Reads the newest shunt span of each gage of a board (NaN: none), and the start of the session
 * with the newest one (STORE_NONE: none). */
enum mr_status store_newest_shunt_spans_get(struct store *store, const char *board_uid,
                                            float span_lb[MR_GAGES], int64_t *started_us,
                                            struct error *error);
/* Reads the size of the database and the number of landings. */
enum mr_status store_size_get(struct store *store, int64_t *bytes, int64_t *landings,
                              struct error *error);
/* As store_set_wait_ms, in seconds. */
void store_set_wait_s(struct store *store, double wait_s);
/* Checks the database for damage, for at most `duration_max_s`. *complete is true if the time was
 * enough for all pages. Fails with MR_MALFORMED and the details if the database is damaged. */
enum mr_status store_check_integrity(struct store *store, double duration_max_s, bool *complete,
                                     struct error *error);

#endif
