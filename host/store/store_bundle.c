#include <sha2.h>
#include <stdio.h>
#include <string.h>
#include <sys/types.h>

#include "host/store/store_readiness.h"
#include "host/store/table.h"

#define SQL_SIZE    4000
#define COPY_ACTION "copy the landing from"

/* part of the slow log that a bundle contains: from a day before the landing to an hour after it */
#define SLOW_LOG_BEFORE_US "86400000000"
#define SLOW_LOG_AFTER_US  "3600000000"
#define SELECT_ARMED_US    "(SELECT armed_us FROM main.landings WHERE id=?1)"
#define SELECT_BOARD_UID   "(SELECT board_uid FROM main.landings WHERE id=?1)"
/* Times of the three surveys between the previous and the next landing of the board that a bundle
 * contains: the first one, from which mat movement is measured; the last one before the landing;
 * and the first one after it. With other surveys, the results of the landing would differ
 * (host/analyse/outcome.h). */
#define SELECT_NEIGHBOUR_US(which, side, none)                              \
    "coalesce((SELECT " which "(armed_us) FROM main.landings WHERE id" side \
    "?1 AND board_uid=" SELECT_BOARD_UID "), " none ")"
#define NOT_WITHDRAWN(kind) "id NOT IN (SELECT item FROM main.withdrawals WHERE kind='" kind "')"
#define SELECT_SURVEY(which)                                                           \
    " SELECT " which "(id) FROM main.gage_surveys WHERE made_us>" SELECT_NEIGHBOUR_US( \
        "max", "<",                                                                    \
        "-1") " AND made_us<" SELECT_NEIGHBOUR_US("min", ">",                          \
                                                  "9e18") " AND " NOT_WITHDRAWN("survey")
#define SELECT_SURVEYS                               \
    "(" SELECT_SURVEY("min") " UNION" SELECT_SURVEY( \
        "max") " AND made_us<=" SELECT_ARMED_US      \
               " UNION" SELECT_SURVEY("min") " AND made_us>" SELECT_ARMED_US ")"

/* Returns the SQL condition for the rows of a table that belong to the landing: ?1 is the RUN, ?2
 * its session, ?3 its boot. Most tables have a column `landing` or `session`. For the other tables
 * the function has a condition each. */
static const char *make_row_condition(const char *table, bool has_landing, bool has_session)
{
    if (strcmp(table, "landings") == 0)
        return "id=?1";
    if (strcmp(table, "sessions") == 0)
        return "id=?2";
    if (strcmp(table, "events") == 0)
        return "landing=?1 OR (landing IS NULL AND session=?2 AND boot=?3"
               " AND id<=coalesce((SELECT max(id) FROM main.events WHERE landing=?1), 0))";
    if (strcmp(table, "slack") == 0)
        return "survey IN (SELECT id FROM main.surveys WHERE landing=?1)";
    if (strcmp(table, "simulation_channels") == 0)
        return "simulation IN (SELECT id FROM main.simulations WHERE landing=?1)";
    /* results of `matrig ready` that are valid for the landing */
    if (strcmp(table, "readiness") == 0)
        return "board_uid=" SELECT_BOARD_UID " AND " SELECT_ARMED_US
               " BETWEEN made_us AND made_us + " STORE_READINESS_VALID_US_TEXT;
    /* as in store_landing_series_get: the entered series, otherwise the newest one before the
     * landing */
    if (strcmp(table, "series") == 0)
        return "id=(SELECT max(id) FROM main.series AS s WHERE " NOT_WITHDRAWN(
            "series") " AND CASE WHEN coalesce((SELECT value "
                      "FROM main.landing_changes WHERE landing=?1"
                      " AND field='series' ORDER BY id DESC LIMIT 1), '')<>'' THEN s.name=(SELECT "
                      "value "
                      "FROM main.landing_changes WHERE"
                      " landing=?1 AND field='series' ORDER BY id DESC LIMIT 1) ELSE "
                      "s.made_us<=" SELECT_ARMED_US " END)";
    if (strcmp(table, "advices") == 0) /* the newest advice after the previous landing */
        return "id=(SELECT max(id) FROM main.advices WHERE after_run=coalesce((SELECT max(id) FROM "
               "main.landings WHERE id<?1), 0))";
    if (strcmp(table, "records") == 0) /* include records that belong to no landing */
        return "landing=?1 OR landing IS NULL";
    if (strcmp(table, "certificates") == 0) /* include certificates entered after the landing */
        return "board_uid=" SELECT_BOARD_UID;
    if (strcmp(table, "gage_surveys") == 0)
        return "id IN " SELECT_SURVEYS;
    if (strcmp(table, "gage_readings") == 0 || strcmp(table, "gage_loads") == 0)
        return "survey IN " SELECT_SURVEYS;
    if (strcmp(table, "slow_log") == 0)
        return "board_uid=" SELECT_BOARD_UID " AND time_us BETWEEN " SELECT_ARMED_US
               "-" SLOW_LOG_BEFORE_US " AND " SELECT_ARMED_US "+" SLOW_LOG_AFTER_US;
    if (strcmp(table, "configurations") == 0)
        return "crc=(SELECT config_crc FROM main.landings WHERE id=?1)";
    return has_landing ? "landing=?1" : has_session ? "session=?2" : "0";
}

/* Makes the statement that copies the landing's rows of one table into the bundle. The landing gets
 * the id 1 there. */
static enum mr_status make_copy_sql(struct store *store, const char *table, char sql[SQL_SIZE],
                                    struct error *error)
{
    char columns[SQL_SIZE / 4] = "", values[SQL_SIZE / 4] = "";
    bool has_landing = false, has_session = false;
    sqlite3_stmt *statement;
    if (sqlite3_prepare_v2(store->database, "SELECT name FROM pragma_table_info(?, 'main')", -1,
                           &statement, NULL) != SQLITE_OK)
        return store_set_error(store, COPY_ACTION, error);
    sqlite3_bind_text(statement, 1, table, -1, SQLITE_STATIC);
    bool fits = true;
    int code;
    while ((code = sqlite3_step(statement)) == SQLITE_ROW) {
        const char *name = (const char *)sqlite3_column_text(statement, 0);
        bool landing = strcmp(name, "landing") == 0;
        bool number = landing || (strcmp(table, "landings") == 0 && strcmp(name, "id") == 0);
        const char *comma = columns[0] ? "," : "";
        size_t at = strlen(columns), to = strlen(values);
        fits &= snprintf(columns + at, sizeof columns - at, "%s\"%s\"", comma, name) <
                (int)(sizeof columns - at);
        if (number) /* keep NULL, which means that the event happened outside landings */
            fits &= snprintf(values + to, sizeof values - to,
                             "%sCASE WHEN \"%s\" IS NULL THEN NULL ELSE 1 END", comma,
                             name) < (int)(sizeof values - to);
        /* records may contain a RUN in their text */
        else if (strcmp(table, "records") == 0 && strcmp(name, "fields") == 0)
            fits &= snprintf(values + to, sizeof values - to,
                             "%sCASE WHEN fields LIKE '%%\"repaired\":%%' THEN json_set(fields, "
                             "'$.repaired', fields->>'repaired'-landing+1) ELSE fields END",
                             comma) < (int)(sizeof values - to);
        else
            fits &= snprintf(values + to, sizeof values - to, "%s\"%s\"", comma, name) <
                    (int)(sizeof values - to);
        has_landing |= landing;
        has_session |= strcmp(name, "session") == 0;
    }
    if (code != SQLITE_DONE) /* ignore a missing column in the statement */
        store_set_error(store, COPY_ACTION, error);
    sqlite3_finalize(statement);
    if (code != SQLITE_DONE)
        return error->status;
    fits &= snprintf(sql, SQL_SIZE,
                     "INSERT INTO bundle.\"%s\"(%s) SELECT %s FROM main.\"%s\" WHERE %s", table,
                     columns, values, table,
                     make_row_condition(table, has_landing, has_session)) < SQL_SIZE;
    return fits
             ? MR_OK
             : error_set(error, MR_TOO_LONG,
                         "table %s has too many columns: %s; use the matrig version that wrote it",
                         table, store->path);
}

static enum mr_status copy_table(struct store *store, const char *table,
                                 const struct store_landing *landing, struct error *error)
{
    char sql[SQL_SIZE];
    sqlite3_stmt *statement;
    enum mr_status status = make_copy_sql(store, table, sql, error);
    if (status != MR_OK)
        return status;
    if (sqlite3_prepare_v2(store->database, sql, -1, &statement, NULL) != SQLITE_OK)
        return store_set_error(store, COPY_ACTION, error);
    int parameters = sqlite3_bind_parameter_count(statement);
    if (parameters >= 1)
        sqlite3_bind_int64(statement, 1, landing->id);
    if (parameters >= 2)
        sqlite3_bind_int64(statement, 2, landing->session);
    if (parameters >= 3)
        sqlite3_bind_int64(statement, 3, landing->boot);
    if (sqlite3_step(statement) != SQLITE_DONE)
        status = store_set_error(store, COPY_ACTION, error);
    sqlite3_finalize(statement);
    return status;
}

static enum mr_status copy_tables(struct store *store, const struct store_landing *landing,
                                  struct error *error)
{
    sqlite3_stmt *tables;
    enum mr_status status = MR_OK;
    /* create tables in the order of the campaign, because tables refer to earlier ones */
    if (sqlite3_prepare_v2(
            store->database,
            "SELECT name FROM main.sqlite_schema WHERE type='table' AND name NOT LIKE 'sql%'"
            /* leave out the user's own tables */
            " AND name IN (SELECT name FROM bundle.sqlite_schema WHERE type='table')"
            " AND name<>'bundles' ORDER BY rowid",
            -1, &tables, NULL) != SQLITE_OK)
        return store_set_error(store, COPY_ACTION, error);
    int code = SQLITE_ROW;
    while (status == MR_OK && (code = sqlite3_step(tables)) == SQLITE_ROW)
        status = copy_table(store, (const char *)sqlite3_column_text(tables, 0), landing, error);
    if (status == MR_OK && code != SQLITE_DONE)
        status = store_set_error(store, COPY_ACTION, error);
    sqlite3_finalize(tables);
    return status;
}

static enum mr_status fill_bundle(struct store *store, const struct store_landing *landing,
                                  const char *path, struct error *error)
{
    char *attach = sqlite3_mprintf("ATTACH %Q AS bundle", path);
    if (!attach)
        return error_set(error, MR_FULL, "out of memory, writing bundle %s; close other programs",
                         path);
    enum mr_status status = store_execute(store, attach, COPY_ACTION, error);
    sqlite3_free(attach);
    if (status != MR_OK)
        return status;
    status = store_execute(store, "BEGIN", COPY_ACTION, error);
    if (status == MR_OK)
        status = copy_tables(store, landing, error);
    if (status == MR_OK)
        status = store_execute(store, "COMMIT", COPY_ACTION, error);
    else
        sqlite3_exec(store->database, "ROLLBACK", NULL, NULL, NULL);
    sqlite3_exec(store->database, "DETACH bundle", NULL, NULL, NULL);
    return status;
}

/* ---- image and digests ---- */

static enum mr_status compute_record_digest(struct store *store, int64_t run, char hex[65],
                                            struct error *error)
{
    struct store_block_record row;
    SHA2_CTX hash;
    sqlite3_stmt *s;
    SHA256Init(&hash);
    enum mr_status status = STORE_QUERY(store, error, BLOCKS, &s, STORE_BIND(run));
    while (status == MR_OK && (status = STORE_READ_NEXT(store, error, BLOCKS, s, &row)) == MR_OK)
        SHA256Update(&hash, row.record.data, row.record.length);
    SHA256End(&hash, hex);
    return status == MR_TOO_FEW ? MR_OK : status;
}

static enum mr_status put_bundle_row(const char *path, const uint8_t *image, size_t length,
                                     struct error *error)
{
    struct store_bundled row = {.image = {image, length}};
    struct store *bundle = NULL;
    enum mr_status status = store_open(path, STORE_OPEN, &bundle, error);
    SHA256Data(length ? image : (const uint8_t *)"", length, row.image_sha256);
    if (status == MR_OK)
        status = compute_record_digest(bundle, 1, row.record_sha256, error);
    if (status == MR_OK)
        status = STORE_PUT(bundle, error, bundled, &row, 1);
    /* journal mode DELETE, because a bundle must be one file */
    if (status == MR_OK)
        status = store_execute(bundle, "PRAGMA journal_mode=DELETE", COPY_ACTION, error);
    store_close(bundle);
    return status;
}

enum mr_status store_bundle_make(struct store *store, int64_t run, const char *path,
                                 const uint8_t *image, size_t length, struct error *error)
{
    struct store_landing landing;
    struct store *empty = NULL;
    enum mr_status status = store_landing_get(store, run, &landing, error);
    if (status == MR_OK)
        status = store_open(path, STORE_CREATE, &empty, error);
    if (status == MR_OK && store_has_on_demand_tables(store->database) &&
        store_create_tables(empty->database, true) != SQLITE_OK)
        status = store_set_error(empty, "set up", error);
    store_close(empty);
    if (status == MR_OK)
        status = fill_bundle(store, &landing, path, error);
    return status == MR_OK ? put_bundle_row(path, image, length, error) : status;
}

static enum mr_status write_image(const struct store_bundled *row, const char *path,
                                  struct error *error)
{
    FILE *file = fopen(path, "wb");
    bool written = file && fwrite(row->image.data, row->image.length, 1, file) == 1;
    if ((file && fclose(file) != 0) || !written)
        return error_set(error, MR_IO, "cannot write the bundle: %s; check the free disk space",
                         path);
    return MR_OK;
}

enum mr_status store_bundle_extract(struct store *store, int64_t run, const char *path, bool *found,
                                    struct error *error)
{
    struct store_bundled row;
    char record[65], image[65];
    sqlite3_stmt *s;
    *found = false;
    enum mr_status status = compute_record_digest(store, run, record, error);
    if (status == MR_OK)
        status = STORE_QUERY(store, error, BUNDLED, &s, STORE_BIND(run));
    if (status == MR_OK)
        status = STORE_READ_NEXT(store, error, BUNDLED, s, &row);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    SHA256Data(row.image.length ? row.image.data : "", row.image.length, image);
    bool record_changed = strcmp(record, row.record_sha256) != 0;
    if (record_changed || strcmp(image, row.image_sha256) != 0)
        status = error_set(error, MR_CRC,
                           "the %s of the bundle was changed after the bundle was written: %s; get "
                           "the bundle again",
                           record_changed ? "record" : "image", store->path);
    *found = status == MR_OK && row.image.length > 0;
    if (*found)
        status = write_image(&row, path, error);
    sqlite3_reset(s);
    return status;
}
