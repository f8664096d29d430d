/* What matrig log rests on when the campaign takes nothing: a transaction that was taken back is
 * written again as if nothing had been, and a campaign that somebody took away is found out and
 * copied. */
#include "tests/host/session.h"

#include <sqlite3.h>

#include "host/store/store.h"

#define FRAMES_A_TRANSACTION 300

static int64_t number(const char *path, const char *sql)
{
    sqlite3 *database;
    sqlite3_stmt *statement;
    assert_int_equal(sqlite3_open(path, &database), SQLITE_OK);
    if (sqlite3_prepare_v2(database, sql, -1, &statement, NULL) != SQLITE_OK)
        fail_msg("%s: %s", sql, sqlite3_errmsg(database));
    assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
    int64_t value = sqlite3_column_int64(statement, 0);
    sqlite3_finalize(statement);
    sqlite3_close(database);
    return value;
}

static void feed_frames(struct session *s, const char **at, int count)
{
    for (int i = 0; i < count && **at; i++)
        session_feed_line(s, at);
}

/* Logs CAN in many transactions. `failing`: each is taken back twice, after another length, before
 * it is written. */
static void log_in_transactions(const char *db, bool failing, char path[200])
{
    struct session s;
    struct stream_truth truth = {.v0_ft_s = 28.0, .a_ft_s2 = 8.0, .peak_in = 0.4};
    session_begin(&s, true, false);
    stream_hello(&s.stream, MR_LAYOUT);
    stream_configuration(&s.stream);
    stream_idle(&s.stream, 500);
    stream_landing(&s.stream, &truth, 3);
    stream_idle(&s.stream, 1200);
    fclose(s.stream.can);
    store_open(scratch_path(path, 200, db), STORE_CREATE, &s.store, &s.error);
    store_begin(s.store, &s.error);
    collector_open(s.store, "file:can", 0, NULL, &s.collector, &s.error);
    store_commit(s.store, &s.error);
    assert_no_error(&s.error);
    for (const char *at = s.can; *at;) {
        for (int i = 1; failing && i <= 2; i++) {
            const char *again = at;
            store_begin(s.store, &s.error);
            collector_save_state(s.collector, &s.error);
            feed_frames(&s, &again, FRAMES_A_TRANSACTION * i / 2 + 1);
            collector_store_counts(s.collector, &s.error);
            assert_no_error(&s.error);
            store_roll_back(s.store);
            collector_restore_state(s.collector);
        }
        store_begin(s.store, &s.error);
        collector_save_state(s.collector, &s.error);
        feed_frames(&s, &at, FRAMES_A_TRANSACTION);
        collector_store_counts(s.collector, &s.error);
        store_commit(s.store, &s.error);
        assert_no_error(&s.error);
    }
    store_begin(s.store, &s.error);
    collector_end(s.collector, "end", &s.error);
    store_commit(s.store, &s.error);
    assert_no_error(&s.error);
    session_end(&s);
}

TEST(taken_back_and_written_again)
{
    static const char *const tables[] = {
        "landings", "links",  "missing", "channels", "calibration", "switches", "frames",
        "edges",    "events", "motion",  "zones",    "results",     "gaps",     "time_maps"};
    char plain[200], failing[200], sql[600];
    log_in_transactions("writing-plain.db", false, plain);
    log_in_transactions("writing-failing.db", true, failing);
    assert_true(number(plain, "SELECT count(*) FROM frames") > 10 * FRAMES_A_TRANSACTION);
    assert_int_equal(number(plain, "SELECT state FROM landings"), 4);
    for (size_t i = 0; i < COUNT_OF(tables); i++) {
        sqlite3 *both;
        sqlite3_stmt *statement;
        assert_int_equal(sqlite3_open(plain, &both), SQLITE_OK);
        snprintf(sql, sizeof sql, "ATTACH '%s' AS other", failing);
        assert_int_equal(sqlite3_exec(both, sql, NULL, NULL, NULL), SQLITE_OK);
        snprintf(sql, sizeof sql,
                 "SELECT (SELECT count(*) FROM main.%1$s) = (SELECT count(*) FROM other.%1$s), "
                 "(SELECT count(*) FROM (SELECT * FROM main.%1$s EXCEPT SELECT * FROM other.%1$s))",
                 tables[i]);
        if (sqlite3_prepare_v2(both, sql, -1, &statement, NULL) != SQLITE_OK)
            fail_msg("%s: %s", tables[i], sqlite3_errmsg(both));
        assert_int_equal(sqlite3_step(statement), SQLITE_ROW);
        if (!sqlite3_column_int(statement, 0) || sqlite3_column_int(statement, 1) != 0)
            fail_msg("%s differ", tables[i]);
        sqlite3_finalize(statement);
        sqlite3_close(both);
    }
}

/* A session that is open, with a row that is only in the journal. */
static struct store *open_campaign(const char *path, struct store_file_identity *identity)
{
    struct store *store = NULL;
    struct error error = {0};
    struct store_session session = {.started_us = 5};
    store_open(path, STORE_LOG, &store, &error);
    store_begin(store, &error);
    store_session_add(store, &session, &error);
    store_commit(store, &error);
    assert_no_error(&error);
    store_file_identity_get(path, identity);
    assert_int_equal(store_check_file_identity(path, identity), STORE_FILE_UNCHANGED);
    return store;
}

static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

TEST(a_campaign_taken_away_is_found_out)
{
    char path[200], elsewhere[200], copy[200], journal[220], where[4096];
    struct store_file_identity identity;
    struct error error = {0};
    scratch_path(elsewhere, sizeof elsewhere, "writing-elsewhere.db");
    scratch_path(copy, sizeof copy, "writing-copy.db");
    struct store *store = open_campaign(scratch_path(path, sizeof path, "writing-away.db"),
                                        &identity);
    assert_int_equal(rename(path, elsewhere), 0);
    assert_int_equal(store_check_file_identity(path, &identity), STORE_FILE_MISSING);
    store_find_current_path(store, where, sizeof where);
    assert_non_null(strstr(where, "/writing-elsewhere.db"));
    write_text(path, "somebody's");
    assert_int_equal(store_check_file_identity(path, &identity), STORE_FILE_REPLACED);
    assert_int_equal(rename(elsewhere, path), 0);
    assert_int_equal(store_check_file_identity(path, &identity),
                     STORE_FILE_UNCHANGED); /* put back */
    snprintf(journal, sizeof journal, "%s-wal", path);
    assert_int_equal(unlink(journal), 0);
    assert_int_equal(store_check_file_identity(path, &identity), STORE_FILE_NO_JOURNAL);
    assert_int_equal(unlink(path), 0);
    store_find_current_path(store, where, sizeof where);
    assert_string_equal(where, "");

    write_text(copy, "somebody's"); /* nothing is overwritten */
    assert_int_equal(store_copy_to(store, copy, &error), MR_IO);
    error = (struct error){0};
    assert_int_equal(unlink(copy), 0);
    assert_int_equal(store_copy_to(store, copy, &error), MR_OK);
    write_text(path, "another");
    write_text(journal, "its journal");
    store_close_detached(store, true);
    assert_int_equal(access(path, F_OK), 0); /* what is there now is somebody else's */
    assert_int_equal(access(journal, F_OK), 0);
    assert_int_equal(number(copy, "SELECT started_us FROM sessions"), 5);
}

/* Which refusals pass when one waits. */
TEST(refusals)
{
    char path[200];
    struct store *first = NULL, *second = NULL;
    struct error error = {0}, busy = {0};
    store_open(scratch_path(path, sizeof path, "writing-busy.db"), STORE_CREATE, &first, &error);
    store_open(path, STORE_OPEN, &second, &error);
    assert_no_error(&error);
    store_set_wait_ms(second, 0);
    store_begin(first, &error);
    assert_int_equal(store_begin(second, &busy), MR_IO);
    assert_int_equal(store_refusal_pop(second), STORE_LOCKED);
    assert_int_equal(store_refusal_pop(second), STORE_NO_RETRY);
    store_roll_back(second); /* there is nothing */
    store_roll_back(first);
    busy = (struct error){0};
    assert_int_equal(store_begin(second, &busy), MR_OK);
    store_close(second);
    store_close(first);
}
