#include "host/store/store_digest.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_readiness.h"
#include "host/store/store_sql.h"

#define SQL_MAX 300
#define DOING   "look for changes in"

/* The landings of the same board before and after landing l. */
#define BEFORE                                                                                 \
    "(SELECT max(b.id) FROM landings AS b WHERE b.id<l.id AND b.board_uid IS l.board_uid AND " \
    "b.id>=l.id-1000)"
#define AFTER                                                                                  \
    "(SELECT min(a.id) FROM landings AS a WHERE a.id>l.id AND a.board_uid IS l.board_uid AND " \
    "a.id<=l.id+1000)"
#define ARMED(which) "(SELECT n.armed_us FROM landings AS n WHERE n.id=" which ")"

/* What no column `landing` leads to; the first column is the landing. A session goes on counting
 * after the landing, so that of its own row only what is told of the landing is here. */
static const char *const around[] = {
    "SELECT id, * FROM landings ORDER BY id",
    "SELECT l.id, s.started_us, s.can_link, s.serial_link, s.ended_by IS 'black box'"
    " FROM landings AS l JOIN sessions AS s ON s.id=l.session ORDER BY l.id",
    "SELECT l.id, c.crc FROM landings AS l JOIN configurations AS c ON c.crc=l.config_crc",
    "SELECT l.id, x.* FROM landings AS l JOIN shunts AS x ON x.session=l.session",
    "SELECT l.id, x.* FROM landings AS l JOIN imports AS x ON x.session=l.session",
    "SELECT l.id, x.* FROM landings AS l JOIN events AS x ON x.session=l.session"
    " WHERE x.landing IS NULL AND x.kind IN ('fault', 'doubt')",
    "SELECT v.landing, k.* FROM surveys AS v JOIN slack AS k ON k.survey=v.id",
    "SELECT m.landing, k.* FROM simulations AS m JOIN simulation_channels AS k"
    " ON k.simulation=m.id",
    "SELECT l.id, x.* FROM landings AS l JOIN readiness AS x ON x.board_uid=l.board_uid"
    " AND l.armed_us BETWEEN x.made_us AND x.made_us+" STORE_READINESS_TEXT,
    /* a series that was begun before it, or that it was put into */
    "SELECT l.id, x.* FROM landings AS l JOIN series AS x ON x.made_us<=l.armed_us OR x.name IN"
    " (SELECT value FROM landing_changes WHERE landing=l.id AND field='series')",
    "SELECT l.id, x.* FROM landings AS l JOIN advices AS x ON x.after_run<l.id AND x.after_run>="
    "coalesce((SELECT max(b.id) FROM landings AS b WHERE b.id<l.id), 0)",
    "SELECT l.id, n.id, n.session, n.boot, n.armed_block, n.armed_us FROM landings AS l"
    " JOIN landings AS n ON n.id IN (" BEFORE ", " AFTER ")",
    "SELECT l.id, k.* FROM landings AS l JOIN surveys AS v ON v.landing IN (" BEFORE ", " AFTER ")"
    " JOIN slack AS k ON k.survey=v.id",
    "SELECT l.id, x.*, (SELECT max(r.id) FROM gage_readings AS r WHERE r.survey=x.id)"
    " FROM (SELECT l.id, coalesce(" ARMED(
        BEFORE) ", -9e18) AS from_us,"
                " coalesce(" ARMED(
                    AFTER) ", 9e18) AS to_us FROM landings AS l) AS l"
                           " JOIN gage_surveys AS x ON x.made_us BETWEEN l.from_us AND l.to_us",
};

static int by_run(const void *a, const void *b)
{
    int64_t x = ((const struct store_digest *)a)->run, y = ((const struct store_digest *)b)->run;
    return (x > y) - (x < y);
}

struct store_digest *store_digest_find(struct store_digest *digest, size_t count, int64_t run)
{
    const struct store_digest key = {.run = run};
    return count ? bsearch(&key, digest, count, sizeof *digest, by_run) : NULL;
}

/* A row, so that no two rows are the same bytes. */
static void add_row(SHA2_CTX *hash, sqlite3_stmt *statement)
{
    int columns = sqlite3_column_count(statement);
    SHA256Update(hash, (const uint8_t *)"", 1); /* no kind of a column */
    for (int i = 1; i < columns; i++) {
        int type = sqlite3_column_type(statement, i);
        int64_t integer = sqlite3_column_int64(statement, i);
        double real = sqlite3_column_double(statement, i);
        uint8_t kind = (uint8_t)type;
        SHA256Update(hash, &kind, 1);
        if (type == SQLITE_INTEGER)
            SHA256Update(hash, (const uint8_t *)&integer, sizeof integer);
        else if (type == SQLITE_FLOAT)
            SHA256Update(hash, (const uint8_t *)&real, sizeof real);
        else if (type != SQLITE_NULL) {
            const uint8_t *bytes = sqlite3_column_blob(statement, i);
            int length = sqlite3_column_bytes(statement, i);
            SHA256Update(hash, (const uint8_t *)&length, sizeof length);
            SHA256Update(hash, bytes, (size_t)length);
        }
    }
}

/* Rows of any order; those of landings that are not there belong to none. */
static enum mr_status add_rows(struct store *store, const char *sql, struct store_digest *digest,
                               size_t count, struct error *error)
{
    sqlite3_stmt *statement;
    struct store_digest *last = NULL;
    int code;
    if (sqlite3_prepare_v2(store->database, sql, -1, &statement, NULL) != SQLITE_OK)
        return store_failed(store, DOING, error);
    while ((code = sqlite3_step(statement)) == SQLITE_ROW) {
        int64_t run = sqlite3_column_int64(statement, 0);
        if (!last || last->run != run)
            last = store_digest_find(digest, count, run);
        if (last)
            add_row(&last->hash, statement);
    }
    sqlite3_finalize(statement);
    return code == SQLITE_DONE ? MR_OK : store_failed(store, DOING, error);
}

static bool has_landing(const struct store_table *table)
{
    for (unsigned i = 0; i < table->count; i++) {
        if (table->columns[i].name && strcmp(table->columns[i].name, "landing") == 0)
            return true;
    }
    return false;
}

/* Of a table that says whose its rows are. */
static enum mr_status add_table(struct store *store, const struct store_table *table,
                                struct store_digest *digest, size_t count, struct error *error)
{
    char sql[SQL_MAX];
    if (!table->name || !table->name[0] || !has_landing(table))
        return MR_OK;
    if (strcmp(table->name, "blocks") == 0)
        snprintf(sql, sizeof sql,
                 "SELECT landing, count(*), min(idx), max(idx) FROM blocks GROUP BY landing");
    else if (strcmp(table->name, "frames") == 0)
        snprintf(sql, sizeof sql,
                 "SELECT landing, count(*), min(id), max(id) FROM frames GROUP BY landing");
    else
        snprintf(sql, sizeof sql, "SELECT landing, * FROM \"%s\"", table->name);
    return add_rows(store, sql, digest, count, error);
}

enum mr_status store_digests(struct store *store, struct store_digest **digest, size_t *count,
                             struct error *error)
{
    struct store_landing *landing = NULL;
    enum mr_status status = store_landings(store, &landing, count, error);
    *digest = calloc(*count ? *count : 1, sizeof **digest);
    if (status == MR_OK && !*digest)
        status = error_set(error, MR_FULL, "no memory: %zu landings; close other programs", *count);
    for (size_t i = 0; status == MR_OK && i < *count; i++) {
        (*digest)[i].run = landing[i].id;
        SHA256Init(&(*digest)[i].hash);
    }
    free(landing);
    if (status == MR_OK)
        qsort(*digest, *count, sizeof **digest, by_run);
    for (size_t i = 0; status == MR_OK && i < sizeof around / sizeof around[0]; i++)
        status = add_rows(store, around[i], *digest, *count, error);
    for (int i = 0; status == MR_OK && i < STORE_TABLE_COUNT; i++)
        status = add_table(store, store_table((enum store_table_number)i), *digest, *count, error);
    return status;
}
