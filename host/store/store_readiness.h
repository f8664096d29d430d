/* What `matrig ready` found, in the campaign: a row for each time, which the landings after it
 * refer to by board and time. And what it asks of a campaign. Conventions as in store.h. */
#ifndef MATRIG_HOST_STORE_STORE_READINESS_H
#define MATRIG_HOST_STORE_STORE_READINESS_H

#include "host/store/store.h"

#define STORE_READINESS_US   43200000000 /* 12 h: for so long it is the landings' that follow */
#define STORE_READINESS_TEXT "43200000000"

struct store_readiness {
    int64_t made_us; /* host time */
    char verdict[8]; /* go, no-go */
    char *checks;    /* JSON; a read allocates it, the caller frees it */
};

/* `kind`: "ready" or "walk". */
enum mr_status store_readiness_put(struct store *store, const char *board_uid, const char *kind,
                                   const struct store_readiness *row, struct error *error);
/* The newest of a board and kind made at `until_us` or within STORE_READINESS_US before (`hours`
 * false: at any time before). */
enum mr_status store_readiness_get(struct store *store, const char *board_uid, const char *kind,
                                   int64_t until_us, bool hours, struct store_readiness *row,
                                   bool *found, struct error *error);

/* The board that was logged or checked last; empty: none. */
enum mr_status store_board_newest(struct store *store, char board_uid[25], struct error *error);

/* Adds a certificate of a sensor, in a transaction of its own; and the one that holds of each
 * channel of a board. */
enum mr_status store_certificate_add(struct store *store, const struct store_certificate *row,
                                     struct error *error);
enum mr_status store_certificates(struct store *store, const char *board_uid,
                                  struct store_certificate **rows, size_t *count,
                                  struct error *error);

/* Spans of the last shunt calibration that a log of this board kept, NaN: none; and when that log
 * began, STORE_NONE. */
enum mr_status store_board_spans(struct store *store, const char *board_uid,
                                 float span_lb[MR_GAGES], int64_t *started_us, struct error *error);
enum mr_status store_size(struct store *store, int64_t *bytes, int64_t *landings,
                          struct error *error);
/* From now on wait at most so long for another program that writes. */
void store_wait(struct store *store, double most_s);
/* Goes through the pages for `most_s` at most. `*whole`: it came to the end. MR_MALFORMED: damaged,
 * `error` says how. */
enum mr_status store_check(struct store *store, double most_s, bool *whole, struct error *error);

#endif
