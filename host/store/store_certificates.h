/* Certificates of sensors, and whether the campaign demands them. Rows are only ever added: the
 * ones that are not `gone` hold, all of them are the history. Conventions as in store.h; texts that
 * are absent are empty. */
#ifndef MATRIG_HOST_STORE_STORE_CERTIFICATES_H
#define MATRIG_HOST_STORE_STORE_CERTIFICATES_H

#include "host/store/store.h"

/* `withdraws`: STORE_NONE. In a transaction of its own, as the next two. */
enum mr_status store_certificate_add(struct store *store, const struct store_certificate *row,
                                     struct error *error);
/* Takes certificate `id` back; MR_UNKNOWN: there is none, or it is gone already. */
enum mr_status store_certificate_withdraw(struct store *store, int64_t id, int64_t made_us,
                                          const char *who, const char *reason, struct error *error);
enum mr_status store_certificates_demand(struct store *store, bool required, int64_t made_us,
                                         const char *who, struct error *error);

/* All rows of a board (NULL: of all boards), by channel, oldest first; withdrawals too. */
enum mr_status store_certificates(struct store *store, const char *board_uid,
                                  struct store_certificate **rows, size_t *count,
                                  struct error *error);
enum mr_status store_certificates_required(struct store *store, bool *required,
                                           struct error *error);

#endif
