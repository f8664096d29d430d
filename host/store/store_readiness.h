/* Results of `matrig ready`, stored in the campaign: one row per run of the command, to which later
 * landings refer by board and time. Also the functions with which `matrig ready` checks a campaign.
 * Conventions as in store.h. */
#ifndef MATRIG_HOST_STORE_STORE_READINESS_H
#define MATRIG_HOST_STORE_STORE_READINESS_H

#include "host/store/store.h"

#define STORE_READINESS_US   43200000000 /* 12 h: a result applies to landings within this time */
#define STORE_READINESS_TEXT "43200000000"

struct store_readiness {
    int64_t made_us; /* host time */
    char verdict[8]; /* go, no-go */
    char *checks;    /* JSON; a read allocates it, the caller frees it */
};

/* Stores a result. `kind`: "ready" or "walk". */
enum mr_status store_readiness_put(struct store *store, const char *board_uid, const char *kind,
                                   const struct store_readiness *row, struct error *error);
/* The newest result of a board and kind made at most STORE_READINESS_US before `until_us` (`hours`
 * false: at any time before). */
enum mr_status store_readiness_get(struct store *store, const char *board_uid, const char *kind,
                                   int64_t until_us, bool hours, struct store_readiness *row,
                                   bool *found, struct error *error);

/* The board that was last logged or checked; empty: none. */
enum mr_status store_board_newest(struct store *store, char board_uid[25], struct error *error);

/* store_certificate_add stores a certificate of a sensor in a separate transaction.
 * store_certificates reads the valid certificate of each channel of a board. */
enum mr_status store_certificate_add(struct store *store, const struct store_certificate *row,
                                     struct error *error);
enum mr_status store_certificates(struct store *store, const char *board_uid,
                                  struct store_certificate **rows, size_t *count,
                                  struct error *error);

/* Spans of the last shunt calibration stored by a log of this board, NaN: none; and the start of
 * that log, STORE_NONE: none. */
enum mr_status store_last_shunt_spans(struct store *store, const char *board_uid,
                                      float span_lb[MR_GAGES], int64_t *started_us,
                                      struct error *error);
enum mr_status store_size(struct store *store, int64_t *bytes, int64_t *landings,
                          struct error *error);
/* Sets how long to wait for another program that writes. */
void store_wait(struct store *store, double most_s);
/* Checks the pages of the database for at most `most_s`. `*whole`: all pages were checked.
 * MR_MALFORMED: damaged; `error` has the details. */
enum mr_status store_check(struct store *store, double most_s, bool *whole, struct error *error);

#endif
