#include "host/store/store_certificates.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"

#define FIELD "certificates"

static enum mr_status add(struct store *store, const struct store_certificate *row,
                          struct error *error)
{
    enum mr_status status = store_begin(store, error);
    if (status == MR_OK)
        status = STORE_PUT(store, error, certificate, row);
    return status == MR_OK ? store_commit(store, error) : status;
}

enum mr_status store_certificate_add(struct store *store, const struct store_certificate *row,
                                     struct error *error)
{
    struct store_certificate kept = *row;
    kept.withdraws = STORE_NONE;
    return add(store, &kept, error);
}

enum mr_status store_certificate_withdraw(struct store *store, int64_t id, int64_t made_us,
                                          const char *who, const char *reason, struct error *error)
{
    struct store_certificate *rows, row = {.made_us = made_us, .withdraws = id};
    size_t count;
    bool there = false;
    enum mr_status status = store_certificates(store, NULL, &rows, &count, error);
    for (size_t i = 0; i < count; i++) {
        if (rows[i].id != id || rows[i].gone || rows[i].withdraws != STORE_NONE)
            continue;
        there = true;
        row.index = rows[i].index;
        memcpy(row.board_uid, rows[i].board_uid, sizeof row.board_uid);
        memcpy(row.number, rows[i].number, sizeof row.number);
    }
    free(rows);
    if (status == MR_OK && !there)
        status = error_set(error, MR_UNKNOWN,
                           "no certificate %lld to withdraw: %s; matrig certificate DB lists them",
                           (long long)id, store->path);
    if (status != MR_OK)
        return status;
    row.calibrated_day = row.due_day = STORE_NONE;
    row.expanded = row.expanded_rel = row.coverage_factor = row.coverage_percent = (double)NAN;
    snprintf(row.who, sizeof row.who, "%.*s", (int)sizeof row.who - 1, who);
    snprintf(row.note, sizeof row.note, "%.*s", (int)sizeof row.note - 1, reason);
    return add(store, &row, error);
}

enum mr_status store_certificates_demand(struct store *store, bool required, int64_t made_us,
                                         const char *who, struct error *error)
{
    struct store_demand row = {.made_us = made_us, .field = FIELD};
    snprintf(row.value, sizeof row.value, "%s", required ? "required" : "optional");
    snprintf(row.who, sizeof row.who, "%.*s", (int)sizeof row.who - 1, who);
    enum mr_status status = store_begin(store, error);
    if (status == MR_OK)
        status = STORE_PUT(store, error, demand, &row);
    return status == MR_OK ? store_commit(store, error) : status;
}

enum mr_status store_certificates(struct store *store, const char *board_uid,
                                  struct store_certificate **rows, size_t *count,
                                  struct error *error)
{
    STORE_ROWS(CERTIFICATES, BIND(board_uid));
}

enum mr_status store_certificates_required(struct store *store, bool *required, struct error *error)
{
    struct store_demand row = {.value = ""};
    enum mr_status status = STORE_ONE(store, error, DEMAND_NEWEST, &row, BIND(FIELD));
    *required = status == MR_OK && strcmp(row.value, "required") == 0;
    return status == MR_TOO_FEW ? MR_OK : status;
}
