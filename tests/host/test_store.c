/* The campaign database: made, refused, killed. */
#include <math.h>
#include <signal.h>
#include <sqlite3.h>
#include <stdlib.h>
#include <sys/wait.h>

#include "host/store/store.h"
#include "tests/host/scratch.h"

static char path[200];

static struct store *fresh(const char *name)
{
    struct store *store = NULL;
    struct error error = {0};
    scratch_path(path, sizeof path, name);
    store_open(path, STORE_CREATE, &store, &error);
    assert_no_error(&error);
    return store;
}

static void sql(const char *file, const char *statement)
{
    sqlite3 *database;
    assert_int_equal(sqlite3_open(file, &database), SQLITE_OK);
    assert_int_equal(sqlite3_exec(database, statement, NULL, NULL, NULL), SQLITE_OK);
    sqlite3_close(database);
}

static int64_t sql_number(const char *file, const char *statement)
{
    sqlite3 *database;
    sqlite3_stmt *prepared;
    assert_int_equal(sqlite3_open(file, &database), SQLITE_OK);
    assert_int_equal(sqlite3_prepare_v2(database, statement, -1, &prepared, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_step(prepared), SQLITE_ROW);
    int64_t value = sqlite3_column_int64(prepared, 0);
    sqlite3_finalize(prepared);
    sqlite3_close(database);
    return value;
}

static int64_t add_session(struct store *store)
{
    struct store_session session = {.started_us = 1000, .can_link = "file:a", .serial_link = NULL};
    struct error error = {0};
    assert_int_equal(store_session_add(store, &session, &error), MR_OK);
    return session.id;
}

static struct store_landing add_landing(struct store *store, int64_t session)
{
    struct store_landing landing = {.session = session,
                                    .board_landing = 5,
                                    .armed_block = 800,
                                    .armed_us = 77,
                                    .state = 1,
                                    .board_uid = "AB",
                                    .firmware = "1.2.3",
                                    .image_crc = STORE_NONE,
                                    .config_crc = 9,
                                    .clock_source = 0,
                                    .touchdown_ft = 3.0,
                                    .image_commit = "c7a3136ab3a3",
                                    .switch_error_ft = (double)NAN};
    struct error error = {0};
    assert_int_equal(store_landing_add(store, &landing, &error), MR_OK);
    return landing;
}

TEST(made_with_its_marks)
{
    store_close(fresh("store.db"));
    assert_int_equal(sql_number(path, "PRAGMA application_id"), STORE_APPLICATION_ID);
    assert_int_equal(sql_number(path, "PRAGMA user_version"), STORE_VERSION);
    assert_int_equal(
        sql_number(path, "SELECT count(*) FROM pragma_journal_mode WHERE journal_mode='wal'"), 1);
}

TEST(rows_come_back)
{
    struct error error = {0};
    struct store *store = fresh("store.db");
    struct store_landing back, landing;
    assert_int_equal(store_begin(store, &error), MR_OK);
    landing = add_landing(store, add_session(store));
    assert_int_equal(landing.id, 1);
    struct store_edge edge = {.count = 1,
                              .position = 3,
                              .step_codes = 120.5,
                              .tick = 4000000000,
                              .board_us = 1234.5,
                              .links = 1};
    assert_int_equal(store_edge_put(store, 1, &edge, &error), MR_OK);
    edge.links = 2; /* the other link brings the same edge */
    assert_int_equal(store_edge_put(store, 1, &edge, &error), MR_OK);
    struct store_zone zone = {.block = 900,
                              .mats = 31,
                              .start_ft = 80,
                              .end_ft = 90,
                              .lead_s = (double)NAN,
                              .wheel_ft = (double)NAN,
                              .warning = STORE_NONE,
                              .inferred_percent = STORE_NONE,
                              .links = 1};
    assert_int_equal(store_zone_put(store, 1, &zone, &error), MR_OK);
    zone.warning = 1;
    zone.lead_s = 0.5;
    assert_int_equal(store_zone_put(store, 1, &zone, &error), MR_OK);
    assert_int_equal(store_commit(store, &error), MR_OK);

    assert_int_equal(store_landing_get(store, 1, &back, &error), MR_OK);
    assert_int_equal(back.armed_block, 800);
    assert_string_equal(back.firmware, "1.2.3");
    assert_true(back.image_crc == STORE_NONE);
    assert_string_equal(back.image_commit, "c7a3136ab3a3");
    assert_true(isnan(back.switch_error_ft));
    struct store_edge *edges;
    struct store_zone *zones;
    size_t count;
    assert_int_equal(store_edges_get(store, 1, &edges, &count, &error), MR_OK);
    assert_int_equal(count, 1);
    assert_int_equal(edges[0].links, 3);
    assert_int_equal(edges[0].tick, 4000000000);
    assert_near(edges[0].board_us, 1234.5, 0.0);
    free(edges);
    assert_int_equal(store_zones_get(store, 1, &zones, &count, &error), MR_OK);
    assert_int_equal(count, 1);
    assert_int_equal(zones[0].warning, 1);
    assert_near(zones[0].lead_s, 0.5, 0.0);
    free(zones);
    assert_int_equal(store_landing_get(store, 2, &back, &error), MR_UNKNOWN);
    assert_error(&error, MR_UNKNOWN, "RUN 2");
    store_close(store);
}

static void refuse(const char *name, enum store_mode mode, enum mr_status status, const char *what)
{
    struct store *store = NULL;
    struct error error = {0};
    assert_int_equal(store_open(name, mode, &store, &error), status);
    assert_error(&error, status, what);
    assert_null(store);
}

TEST(another_version_is_refused)
{
    store_close(fresh("store.db"));
    sql(path, "PRAGMA user_version=7; INSERT INTO sessions(started_us, matrig) VALUES(1, '9.8.7')");
    refuse(path, STORE_OPEN, MR_VERSION, "version 7, written by matrig 9.8.7");
    refuse(path, STORE_CREATE, MR_VERSION, "version 7, written by matrig 9.8.7");
    sql(path, "DROP TABLE sessions");
    refuse(path, STORE_READ, MR_VERSION, "version 7, written by matrig (unknown)");
    assert_int_equal(sql_number(path, "PRAGMA user_version"), 7);
}

TEST(foreign_files_are_refused_and_left_alone)
{
    scratch_path(path, sizeof path, "foreign.db");
    sql(path, "CREATE TABLE recipes(name TEXT)");
    refuse(path, STORE_OPEN, MR_MALFORMED, "foreign.db");
    refuse(path, STORE_CREATE, MR_MALFORMED, "not a campaign database");
    assert_int_equal(sql_number(path, "SELECT count(*) FROM sqlite_schema"), 1);

    char text[3000];
    memset(text, 'x', sizeof text);
    scratch_path(path, sizeof path, "text.db");
    scratch_write(path, text, sizeof text);
    refuse(path, STORE_OPEN, MR_MALFORMED, "text.db");
    refuse("build/test-tmp/none.db", STORE_OPEN, MR_IO, "no such database");
    refuse("build/test-tmp/no/folder/a.db", STORE_CREATE, MR_IO, "no/folder");
    refuse("build", STORE_CREATE, MR_IO, "build");
}

/* A logger killed at any moment: what it committed is there, what it had begun is not, and the file
 * opens. */
TEST(killed_in_a_transaction)
{
    int ready[2];
    char byte;
    store_close(fresh("kill.db"));
    assert_int_equal(pipe(ready), 0);
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        struct store *store = NULL;
        struct error error = {0};
        uint8_t record[75] = {0};
        store_open(path, STORE_CREATE, &store, &error);
        store_begin(store, &error);
        int64_t session = add_session(store);
        for (int64_t i = 0; i < 100; i++)
            store_block_put(store, session, 0, STORE_NONE, 1, i, 0, record, sizeof record, &error);
        store_commit(store, &error);
        store_begin(store, &error);
        for (int64_t i = 100; i < 200; i++)
            store_block_put(store, session, 0, STORE_NONE, 1, i, 0, record, sizeof record, &error);
        byte = error.status == MR_OK ? 'k' : 'x';
        if (write(ready[1], &byte, 1) != 1)
            _exit(1);
        pause();
        _exit(0);
    }
    assert_int_equal(read(ready[0], &byte, 1), 1);
    assert_int_equal(byte, 'k');
    kill(child, SIGKILL);
    assert_int_equal(waitpid(child, NULL, 0), child);
    struct store *store = NULL;
    struct error error = {0};
    store_open(path, STORE_OPEN, &store, &error);
    assert_no_error(&error);
    store_close(store);
    assert_int_equal(sql_number(path, "SELECT count(*) FROM blocks"), 100);
    assert_int_equal(sql_number(path, "SELECT count(*) FROM sessions WHERE ended_us IS NULL"), 1);
    assert_int_equal(
        sql_number(path, "SELECT count(*) FROM pragma_integrity_check WHERE integrity_check='ok'"),
        1);
}

/* Between a look at the file and the checkpoint of a commit, or of the end, another program puts
 * its own content there. */
TEST(a_checkpoint_leaves_what_another_program_put_there)
{
    struct store *store = NULL;
    struct error error = {0};
    uint8_t record[75] = {0};
    static uint8_t others[400000] = "somebody's"; /* a much shorter one SQLite refuses */
    scratch_path(path, sizeof path, "put.db");
    store_open(path, STORE_LOG, &store, &error);
    assert_no_error(&error);
    store_watch_file(store);
    store_begin(store, &error);
    int64_t session = add_session(store);
    for (int64_t i = 0; i < 60000; i++) /* more than SQLite leaves in its journal */
        store_block_put(store, session, 0, STORE_NONE, 1, i, 0, record, sizeof record, &error);
    assert_no_error(&error);
    scratch_write(path, others, sizeof others);
    store_commit(store, &error);
    store_close(store);
    static uint8_t back[sizeof others + 1];
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(back, 1, sizeof back, file), sizeof others);
    fclose(file);
    assert_memory_equal(back, others, sizeof others);
}

/* Another program sets up the same new file between two questions of store_open to it, when it
 * can. */
static int another_sets_it_up(void *context, int action, const char *pragma, const char *value,
                              const char *database, const char *view)
{
    (void)context, (void)value, (void)database, (void)view;
    if (action != SQLITE_PRAGMA || strcmp(pragma, "user_version") != 0)
        return SQLITE_OK;
    sqlite3_reset_auto_extension(); /* the other one is left in peace */
    sqlite3 *other;
    assert_int_equal(sqlite3_open(path, &other), SQLITE_OK);
    if (sqlite3_exec(other,
                     "BEGIN IMMEDIATE; CREATE TABLE sessions(id); PRAGMA user_version=1; PRAGMA "
                     "application_id=7; COMMIT",
                     NULL, NULL, NULL) != SQLITE_OK)
        sqlite3_exec(other, "ROLLBACK", NULL, NULL, NULL);
    sqlite3_close(other);
    return SQLITE_OK;
}
static int watched(sqlite3 *database, const char **message,
                   const struct sqlite3_api_routines *routines)
{
    (void)message, (void)routines;
    return sqlite3_set_authorizer(database, another_sets_it_up, NULL);
}
TEST(a_new_file_is_seen_whole_or_not_at_all)
{
    struct store *store = NULL;
    struct error error = {0};
    scratch_path(path, sizeof path, "race.db");
    sqlite3_auto_extension((void (*)(void))watched);
    store_open(path, STORE_CREATE, &store, &error);
    sqlite3_reset_auto_extension();
    assert_no_error(&error);
    store_close(store);
}

TEST(simulations_keep_the_newest)
{
    struct error error = {0};
    struct store *store = fresh("store.db");
    float series[3] = {0.0f, 0.5f, 1.0f};
    struct store_simulation row = {.number = 2,
                                   .station_ft = 50,
                                   .peak_measured_in = (double)NAN,
                                   .rms_in = 0.1,
                                   .dt_s = 0.002,
                                   .series_in = series,
                                   .length = 3};
    float spread[3] = {0.0f, 0.01f, 0.02f},
          segments[2 * MR_SEGMENTS] = {[1] = 0.25f, [2 * MR_SEGMENTS - 1] = 0.5f};
    struct store_simulation_summary head = {.run_ms = 35, .error_in = 0.01, .seeds = 1}, back;
    struct store_simulation *rows;
    size_t count;
    add_landing(store, add_session(store));
    assert_int_equal(store_simulation_summary_get(store, 1, &back, &error), MR_OK);
    assert_true(back.seeds == STORE_NONE && isnan(back.run_ms) && !back.segments_in);
    assert_int_equal(store_simulation_put(store, 1, "{}", 1, &head, &row, 1, &error), MR_OK);
    row.rms_in = 0.2;
    row.spread_in = spread;
    head = (struct store_simulation_summary){.run_ms = 70,
                                             .error_in = 0.02,
                                             .seeds = 4,
                                             .segments_dt_s = 0.02,
                                             .segments_in = segments,
                                             .segment_rows = 2};
    assert_int_equal(
        store_simulation_put(store, 1, "{\"file\":\"a.json\"}", 2, &head, &row, 1, &error), MR_OK);
    assert_int_equal(store_simulations_get(store, 1, &rows, &count, &error), MR_OK);
    assert_int_equal(count, 1);
    assert_near(rows[0].rms_in, 0.2, 0.0);
    assert_true(isnan(rows[0].peak_measured_in));
    assert_int_equal(rows[0].length, 3);
    assert_memory_equal(rows[0].series_in, series, sizeof series);
    assert_memory_equal(rows[0].spread_in, spread, sizeof spread);
    store_simulations_free(rows, count);
    assert_int_equal(store_simulation_summary_get(store, 1, &back, &error), MR_OK);
    assert_near(back.run_ms, 70.0, 0.0);
    assert_near(back.error_in, 0.02, 0.0);
    assert_true(back.seeds == 4 && back.segments_dt_s == 0.02);
    assert_int_equal(back.segment_rows, 2);
    assert_memory_equal(back.segments_in, segments, sizeof segments);
    assert_string_equal(back.file, "a.json");
    free(back.segments_in);
    store_close(store);
}
