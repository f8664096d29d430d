/* Campaigns of older versions brought forward, read as they are, refused, and cut off at every
 * write. */
#include <math.h>
#include <sqlite3.h>
#include <stdlib.h>
#include <sys/wait.h>

#include "host/store/store.h"
#include "tests/host/scratch.h"

#define FIXTURES "tests/host/campaigns"
/* by version, as FIXTURES/README.md says */
static const int64_t old_blocks[] = {0, 1404, 1404, 1403};
static int unpacked;

static char path[200];

static const char *beside(const char *suffix)
{
    static char name[300];
    snprintf(name, sizeof name, "%s%s", path, suffix);
    return name;
}

static void unpack(int version, const char *name)
{
    char line[500];
    unpacked = version;
    scratch_path(path, sizeof path, name);
    snprintf(line, sizeof line, "rm -f %s?* && gzip -dc " FIXTURES "/v%d.db.gz >%s", path, version,
             path);
    assert_int_equal(system(line), 0);
}

static int64_t number(const char *file, const char *statement)
{
    sqlite3 *database;
    sqlite3_stmt *prepared;
    assert_int_equal(sqlite3_open_v2(file, &database, SQLITE_OPEN_READONLY, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_prepare_v2(database, statement, -1, &prepared, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_step(prepared), SQLITE_ROW);
    int64_t value = sqlite3_column_int64(prepared, 0);
    sqlite3_finalize(prepared);
    sqlite3_close(database);
    return value;
}

static void sql(const char *file, const char *statement)
{
    sqlite3 *database;
    assert_int_equal(sqlite3_open(file, &database), SQLITE_OK);
    assert_int_equal(sqlite3_exec(database, statement, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(database);
}

/* Every table's columns in order: what a statement without column names meets. The caller frees
 * it. */
static char *columns(const char *file)
{
    sqlite3 *database;
    sqlite3_stmt *prepared;
    assert_int_equal(sqlite3_open(file, &database), SQLITE_OK);
    assert_int_equal(sqlite3_prepare_v2(database,
                                        "SELECT group_concat(line, x'0a') FROM (SELECT m.name||': "
                                        "'||(SELECT group_concat(name) FROM"
                                        " pragma_table_info(m.name)) AS line FROM sqlite_schema AS "
                                        "m WHERE type='table' AND name NOT LIKE"
                                        " 'sqlite_%' ORDER BY m.name)",
                                        -1, &prepared, NULL),
                     SQLITE_OK);
    assert_int_equal(sqlite3_step(prepared), SQLITE_ROW);
    char *text = strdup((const char *)sqlite3_column_text(prepared, 0));
    sqlite3_finalize(prepared);
    sqlite3_close(database);
    return text;
}

static struct store *open_as(enum store_mode mode)
{
    struct store *store = NULL;
    struct error error = {0};
    store_open(path, mode, &store, &error);
    assert_no_error(&error);
    return store;
}

static enum mr_status count_block(void *context, const uint8_t *record, size_t length)
{
    struct mr_block block;
    assert_int_equal(mr_block_get(&block, record, length), MR_OK);
    ++*(int64_t *)context;
    return MR_OK;
}

static void expect_the_landing(struct store *store)
{
    struct store_landing landing;
    struct store_edge *edges;
    size_t count;
    int64_t blocks = 0;
    struct error error = {0};
    store_landing_get(store, 1, &landing, &error);
    assert_no_error(&error);
    assert_int_equal(landing.board_landing, 5);
    assert_string_equal(landing.board_uid, "003100425847500F20343635");
    store_edges(store, 1, &edges, &count, &error);
    assert_no_error(&error);
    assert_int_equal(count, 5);
    free(edges);
    store_blocks_each(store, 1, count_block, &blocks, &error);
    assert_no_error(&error);
    assert_int_equal(blocks, old_blocks[unpacked]);
}

static char told[9000];
static void remember(const char *line)
{
    snprintf(told, sizeof told, "%s", line);
}

static void forward_from(int version)
{
    char fresh[200], suffix[20], second[24];
    struct error error = {0};
    unpack(version, "forward.db");
    told[0] = '\0';
    store_on_migration(remember);
    struct store *store = open_as(STORE_OPEN);
    store_on_migration(NULL);
    snprintf(suffix, sizeof suffix, ".v%d", version);
    snprintf(second, sizeof second, "%s-2", suffix);
    assert_non_null(strstr(told, suffix));
    expect_the_landing(store);
    struct store_session session = {.started_us = 1, .can_link = "file:new"};
    struct store_zone zone = {
        .block = 3, .mats = 30, .start_ft = 88.6, .end_ft = 97.1, .warning = 1, .links = 1};
    assert_int_equal(store_session_add(store, &session, &error), MR_OK);
    assert_int_equal(store_zone_put(store, 1, &zone, &error), MR_OK);
    store_close(store);
    assert_int_equal(number(path, "PRAGMA user_version"), STORE_VERSION);
    assert_int_equal(
        number(path, "SELECT count(*) FROM pragma_integrity_check WHERE integrity_check='ok'"), 1);

    scratch_path(fresh, sizeof fresh, "fresh.db");
    struct store *other = NULL;
    store_open(fresh, STORE_CREATE, &other, &error);
    store_close(other);
    char *now = columns(path), *wanted = columns(fresh);
    assert_string_equal(now, wanted);
    free(now);
    free(wanted);

    assert_int_equal(number(beside(suffix), "PRAGMA user_version"), version);
    assert_int_equal(number(beside(suffix), "SELECT count(*) FROM blocks WHERE landing=1"),
                     old_blocks[unpacked]);
    store_close(open_as(STORE_OPEN)); /* nothing left to do: no second copy */
    assert_int_not_equal(access(beside(second), F_OK), 0);
}

static void every_version_comes_forward(void **state)
{
    (void)state;
    for (int version = 1; version < STORE_VERSION; version++)
        forward_from(version);
}

static void reading_leaves_the_file_alone(void **state)
{
    (void)state;
    for (int version = 1; version < STORE_VERSION; version++) {
        char line[500];
        bool older = false;
        struct error error = {0};
        unpack(version, "read.db");
        struct store *store = open_as(STORE_READ);
        assert_int_equal(store_version(store, &older), version);
        assert_true(older);
        expect_the_landing(store);
        struct store_session session = {.started_us = 1};
        assert_int_not_equal(store_session_add(store, &session, &error), MR_OK);
        store_close(store);
        snprintf(line, sizeof line, "gzip -dc " FIXTURES "/v%d.db.gz | cmp - %s", version, path);
        assert_int_equal(system(line), 0);
    }
}

static void without_a_copy(void **state)
{
    (void)state;
    unpack(2, "bare.db");
    store_close(open_as(STORE_BARE));
    assert_int_not_equal(access(beside(".v2"), F_OK), 0);
    assert_int_equal(number(path, "PRAGMA user_version"), STORE_VERSION);
}

static void a_copy_takes_no_files_place(void **state)
{
    (void)state;
    unpack(2, "copies.db");
    scratch_write(beside(".v2"), "mine", 4);
    store_close(open_as(STORE_OPEN));
    assert_int_equal(number(beside(".v2-2"), "PRAGMA user_version"), 2);
    assert_int_not_equal(number(path, "PRAGMA user_version"), 2);
    FILE *file = fopen(beside(".v2"), "r");
    char text[10] = "";
    assert_int_equal(fread(text, 1, sizeof text, file), 4);
    fclose(file);
    assert_string_equal(text, "mine");
}

static void no_copy_no_change(void **state)
{
    struct store *store = NULL;
    struct error error = {0};
    (void)state;
    unpack(2, "nocopy.db");
    mkdir(beside(".v2-partial"), 0777);
    store_open(path, STORE_OPEN, &store, &error);
    assert_error(&error, MR_IO, "--no-backup");
    assert_null(store);
    rmdir(beside(".v2-partial"));
    assert_int_equal(number(path, "PRAGMA user_version"), 2);
}

/* What other versions may have been: a column that stands in the middle, one of a key, an index, a
 * whole table. */
static void whatever_is_missing_is_made(void **state)
{
    struct error error = {0};
    struct store_zone zone = {.block = 3,
                              .mats = 30,
                              .start_ft = 88.6,
                              .end_ft = 97.1,
                              .lead_s = 2.5,
                              .warning = 1,
                              .links = 1};
    struct store_zone *zones;
    size_t count;
    (void)state;
    unpack(2, "missing.db");
    sql(path,
        "DELETE FROM zones; INSERT INTO zones(landing, block, mats, start_ft, end_ft, links) "
        "VALUES(1, 2, 20, 1, 2, 3);"
        "ALTER TABLE zones DROP COLUMN lead_s; DROP INDEX frames_by_landing; DROP TABLE slow_log;"
        "CREATE TABLE slow_log(id INTEGER PRIMARY KEY, board_uid TEXT NOT NULL, seq INTEGER, boot "
        "INTEGER NOT NULL, block INTEGER"
        /* without UNIQUE(board_uid, seq) */
        " NOT NULL); INSERT INTO slow_log VALUES(1, 'a', 2, 3, 4);"
        "DROP TABLE gaps");
    struct store *store = open_as(STORE_READ);
    assert_int_equal(store_zones(store, 1, &zones, &count, &error), MR_OK);
    assert_int_equal(count, 1);
    assert_true(isnan(zones[0].lead_s));
    free(zones);
    store_close(store);
    store = open_as(STORE_OPEN);
    assert_int_equal(store_zone_put(store, 1, &zone, &error), MR_OK);
    struct store_slow slow = {.board_uid = "a", .seq = 2, .boot = 3, .block = 4, .time_us = 99};
    assert_int_equal(store_slow_put(store, &slow, &error), MR_OK);
    assert_no_error(&error);
    assert_int_equal(store_zones(store, 1, &zones, &count, &error), MR_OK);
    assert_int_equal(count, 2);
    assert_true(isnan(zones[0].lead_s));
    assert_true(zones[1].lead_s == 2.5 && zones[1].warning == 1);
    free(zones);
    store_close(store);
    assert_int_equal(number(path, "SELECT count(*) FROM slow_log WHERE time_us=99"), 1);
    assert_int_equal(
        number(path,
               "SELECT count(*) FROM sqlite_schema WHERE name IN ('frames_by_landing', 'gaps')"),
        2);
}

static void a_foreign_column_is_not_dropped(void **state)
{
    struct store *store = NULL;
    struct error error = {0};
    (void)state;
    unpack(2, "foreign.db");
    sql(path, "ALTER TABLE landings ADD COLUMN pilot TEXT");
    store_open(path, STORE_OPEN, &store, &error);
    assert_error(&error, MR_VERSION, "column pilot of table landings");
    assert_int_equal(number(path, "PRAGMA user_version"), 2);
}

/* ---- the power fails at the n-th write ---- */

static int writes_left;
/* SQLite has others for files that it does not lock: they write alike */
static const sqlite3_io_methods *real_methods;
static sqlite3_io_methods cut_methods[2];
static sqlite3_vfs cut_vfs, *real_vfs;

static int cut_write(sqlite3_file *file, const void *bytes, int length, sqlite3_int64 offset)
{
    if (--writes_left < 0) {
        real_methods->xWrite(file, bytes, length / 2, offset); /* half of it got there */
        _exit(9);
    }
    return real_methods->xWrite(file, bytes, length, offset);
}

static int cut_open(sqlite3_vfs *vfs, sqlite3_filename name, sqlite3_file *file, int flags,
                    int *out)
{
    (void)vfs;
    int code = real_vfs->xOpen(real_vfs, name, file, flags, out);
    if (code == SQLITE_OK && file->pMethods) {
        sqlite3_io_methods *methods = &cut_methods[(flags & SQLITE_OPEN_MAIN_DB) != 0];
        real_methods = file->pMethods;
        *methods = *real_methods;
        methods->xWrite = cut_write;
        file->pMethods = methods;
    }
    return code;
}

/* Whether it got to the end. */
static bool migrate_until(int writes)
{
    int how;
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct store *store = NULL;
        struct error error = {0};
        real_vfs = sqlite3_vfs_find(NULL);
        cut_vfs = *real_vfs;
        cut_vfs.zName = "cut";
        cut_vfs.xOpen = cut_open;
        sqlite3_vfs_register(&cut_vfs, 1);
        writes_left = writes;
        store_open(path, STORE_OPEN, &store, &error);
        _exit(store ? 0 : 1);
    }
    assert_int_equal(waitpid(child, &how, 0), child);
    assert_true(WIFEXITED(how));
    assert_true(WEXITSTATUS(how) == 9 || WEXITSTATUS(how) == 0);
    return WEXITSTATUS(how) == 0;
}

static void cut_off_at_any_write_one_of_the_two_is_whole(void **state)
{
    int cuts = 0;
    bool done = false;
    (void)state;
    for (int writes = 0; !done; writes += writes < 6 ? 1 : 7) {
        unpack(1, "cut.db");
        done = migrate_until(writes);
        cuts += !done;
        struct store *store = open_as(STORE_READ); /* whichever it is */
        expect_the_landing(store);
        bool older = false;
        int64_t version = store_version(store, &older);
        assert_true((version == 1 && older) || (version == STORE_VERSION && !older));
        store_close(store);
        assert_int_equal(
            number(path, "SELECT count(*) FROM pragma_integrity_check WHERE integrity_check='ok'"),
            1);
        store_close(open_as(STORE_OPEN)); /* and it can be done again */
        assert_int_equal(number(path, "PRAGMA user_version"), STORE_VERSION);
    }
    assert_true(cuts > 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_version_comes_forward),
        cmocka_unit_test(reading_leaves_the_file_alone),
        cmocka_unit_test(without_a_copy),
        cmocka_unit_test(a_copy_takes_no_files_place),
        cmocka_unit_test(no_copy_no_change),
        cmocka_unit_test(whatever_is_missing_is_made),
        cmocka_unit_test(a_foreign_column_is_not_dropped),
        cmocka_unit_test(cut_off_at_any_write_one_of_the_two_is_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
