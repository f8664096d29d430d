/* The tables of host/store/tables.def: each field lies in its own
 * column, and rows of one key are put together by the rules. What is expected is asked of
 * SQLite by the columns' names, not by way of the store. */
#include <math.h>
#include <stdlib.h>

#include "host/store/store.h"
#include "host/store/table.h"
#include "tests/host/scratch.h"

static struct store *store;
static struct error error;

static void begin(const char *name)
{
    char path[200];
    error = (struct error){0};
    store_open(scratch_path(path, sizeof path, name), STORE_CREATE, &store, &error);
    assert_no_error(&error);
}

TEST(every_statement_fits_its_struct)
{
    begin("statements.db");
    store_prepare_all(store, &error); /* one that does not ends the program */
    assert_no_error(&error);
    store_close(store);
}

/* ---- each field in its column ---- */

enum { ROOM = 4096 };

/* A value that no other column has. */
static void fill_field(const struct store_column *column, unsigned i, void *field)
{
    static char texts[64][16];
    snprintf(texts[i], sizeof texts[i], "text%u", i);
    switch ((enum store_field_kind)column->kind) {
    case STORE_INT64: *(int64_t *)field = 1000 + i; break;
    case STORE_INT: *(int *)field = (int)(1000 + i); break;
    case STORE_DOUBLE: *(double *)field = i + 0.5; break;
    case STORE_TEXT_ARRAY: snprintf(field, column->field_size, "%s", texts[i]); break;
    case STORE_TEXT_POINTER: *(const char **)field = texts[i]; break;
    case STORE_BLOB:
        *(struct store_bytes *)field = (struct store_bytes){texts[i], strlen(texts[i])};
        break;
    default: break;
    }
}

static void expect_column(sqlite3_stmt *s, int at, const struct store_column *column, unsigned i,
                          int64_t owner)
{
    char text[16];
    snprintf(text, sizeof text, "text%u", i);
    if (column->kind == STORE_OWNER)
        assert_int_equal(sqlite3_column_int64(s, at), owner);
    else if (column->kind == STORE_INT64 || column->kind == STORE_INT)
        assert_int_equal(sqlite3_column_int64(s, at),
                         column->merge == STORE_MERGE_READ_ONLY ? 1 : 1000 + i);
    else if (column->kind == STORE_DOUBLE)
        assert_true(sqlite3_column_double(s, at) == i + 0.5);
    else
        assert_memory_equal(sqlite3_column_blob(s, at), text, (size_t)sqlite3_column_bytes(s, at));
    assert_int_not_equal(sqlite3_column_type(s, at), SQLITE_NULL);
}

static void put_and_look(enum store_table_number which)
{
    const struct store_table *table = store_table_get(which);
    _Alignas(16) char row[ROOM] = {0}, back[ROOM] = {0};
    int64_t owners[8], owner = 0;
    sqlite3_stmt *s;
    assert_in_range(table->row_size, 1, ROOM);
    for (unsigned i = 0; i < 8; i++)
        owners[i] = 7 + i;
    for (unsigned i = 0; i < table->column_count; i++)
        fill_field(&table->columns[i], i, row + table->columns[i].field_offset);
    assert_int_equal(store_insert(store, &error, which, row, owners), MR_OK);
    for (unsigned i = 0; i < table->column_count; i++) {
        const struct store_column *column = &table->columns[i];
        if (!column->name)
            continue;
        char *sql = sqlite3_mprintf("SELECT \"%w\" FROM \"%w\"", column->name, table->name);
        assert_int_equal(sqlite3_prepare_v2(store->database, sql, -1, &s, NULL), SQLITE_OK);
        assert_int_equal(sqlite3_step(s), SQLITE_ROW);
        expect_column(s, 0, column, i, 7 + owner);
        owner += column->kind == STORE_OWNER;
        assert_int_equal(sqlite3_step(s), SQLITE_DONE);
        sqlite3_finalize(s);
        sqlite3_free(sql);
    }
    char *list = store_make_column_list(table),
         *sql = sqlite3_mprintf("SELECT %s FROM \"%w\"", list, table->name);
    assert_int_equal(sqlite3_prepare_v2(store->database, sql, -1, &s, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_step(s), SQLITE_ROW);
    store_read_row(s, table, back);
    for (unsigned i = 0; i < table->column_count; i++) {
        const struct store_column *column = &table->columns[i];
        bool there = column->kind == STORE_INT64 || column->kind == STORE_INT ||
                     column->kind == STORE_DOUBLE || column->kind == STORE_TEXT_ARRAY;
        if (there && column->merge != STORE_MERGE_READ_ONLY)
            assert_memory_equal(back + column->field_offset, row + column->field_offset,
                                column->kind == STORE_TEXT_ARRAY
                                    ? strlen(row + column->field_offset) + 1
                                    : column->field_size);
    }
    sqlite3_finalize(s);
    sqlite3_free(list);
    sqlite3_free(sql);
}

TEST(every_field_goes_to_its_column_and_comes_back)
{
    unsigned tables = 0;
    begin("fields.db");
    for (int which = 0; which < STORE_TABLE_COUNT; which++) {
        if (store_table_get((enum store_table_number)which)->name) {
            put_and_look((enum store_table_number)which);
            tables++;
        }
    }
    assert_int_equal(tables, 49);
    store_close(store);
}

/* ---- rows of one key ---- */

static double number(const char *sql)
{
    sqlite3_stmt *s;
    assert_int_equal(sqlite3_prepare_v2(store->database, sql, -1, &s, NULL), SQLITE_OK);
    assert_int_equal(sqlite3_step(s), SQLITE_ROW);
    double value = sqlite3_column_type(s, 0) == SQLITE_NULL ? (double)NAN
                                                            : sqlite3_column_double(s, 0);
    sqlite3_finalize(s);
    return value;
}

TEST(both_links_fill_one_row)
{
    const double none = (double)NAN;
    const struct store_zone can = {.block = 5,
                                   .mats = 3,
                                   .start_ft = 10.0,
                                   .end_ft = 14.0,
                                   .lead_s = 0.5,
                                   .wheel_ft = none,
                                   .warning = STORE_NONE,
                                   .inferred_percent = 40,
                                   .links = 1};
    const struct store_zone serial = {.block = 5,
                                      .mats = STORE_NONE,
                                      .start_ft = 11.0,
                                      .end_ft = none,
                                      .lead_s = none,
                                      .wheel_ft = 2.0,
                                      .warning = 1,
                                      .inferred_percent = 60,
                                      .links = 2};
    const struct store_edge nameless = {
        .count = 1, .position = 4, .tick = 100, .step_codes = 2.0, .board_us = none, .links = 2};
    const struct store_edge known = {
        .count = 1, .position = 9, .tick = 900, .step_codes = 9.0, .board_us = 70.0, .links = 1};
    const struct store_edge later = {
        .count = 1, .position = 9, .tick = 900, .step_codes = 9.0, .board_us = 90.0, .links = 1};
    begin("merge.db");
    store_zone_put(store, 1, &can, &error);
    store_zone_put(store, 1, &serial, &error);
    store_edge_put(store, 1, &nameless, &error);
    store_edge_put(store, 1, &known, &error);
    store_edge_put(store, 1, &later, &error);
    assert_no_error(&error);
    assert_true(number("SELECT links FROM zones") == 3);     /* BITS */
    assert_true(number("SELECT start_ft FROM zones") == 11); /* REPLACE */
    /* REPLACE, also by a missing value */
    assert_true(isnan(number("SELECT end_ft FROM zones")));
    assert_true(isnan(number("SELECT mats FROM zones")));
    /* PRESENT: a missing value does not replace the old one */
    assert_true(number("SELECT lead_s FROM zones") == 0.5);
    assert_true(number("SELECT inferred_percent FROM zones") == 60); /* PRESENT */
    assert_true(number("SELECT warning FROM zones") == 1);
    assert_true(number("SELECT position FROM edges") == 4);  /* KEEP */
    assert_true(number("SELECT board_us FROM edges") == 70); /* FILL: only the first value */
    assert_true(number("SELECT links FROM edges") == 3);
    assert_true(number("SELECT count(*) FROM zones") == 1);
    store_close(store);
}

/* A message says a part of a row; the other columns are NULL, and take nothing away from what was
 * said. */
TEST(a_blank_row_says_nothing)
{
    struct store_band row = store_blank_band;
    begin("blank.db");
    row.band = 2;
    row.links = 1;
    store_band_put(store, 1, &row, &error);
    assert_no_error(&error);
    assert_true(number("SELECT count(*) FROM bands WHERE coalesce(gages, before_lb, "
                       "before_error_lb, spread_lb, least_lb, least_error_lb, least_gage,"
                       " least_block, most_lb, most_error_lb, most_gage, most_block, after_lb, "
                       "change_lb, change_error_lb) IS NULL") == 1);
    row.after_lb = 90.5;
    row.change_lb = -3.0;
    row.change_error_lb = 0.25;
    store_band_put(store, 1, &row, &error);
    row = store_blank_band;
    row.band = 2;
    row.links = 2;
    store_band_put(store, 1, &row, &error);
    assert_no_error(&error);
    assert_true(number("SELECT after_lb FROM bands WHERE band=2") == 90.5);
    assert_true(number("SELECT change_lb FROM bands WHERE band=2") == -3.0);
    assert_true(number("SELECT change_error_lb FROM bands WHERE band=2") == 0.25);
    assert_true(number("SELECT links FROM bands WHERE band=2") == 3);
    assert_true(isnan(number("SELECT least_gage FROM bands WHERE band=2")));
    store_close(store);
}

TEST(a_configuration_stays_and_a_channel_is_replaced)
{
    const struct mr_channel_config first = {.kind = 1, .number = 2, .station_ft = 3.0f},
                                   second = {.kind = 1, .number = 8, .station_ft = 9.0f};
    begin("put.db");
    store_configuration_put(store, 7, "1", &error);
    store_configuration_put(store, 7, "2", &error);
    store_channel_put(store, 1, 0, &first, &error);
    store_channel_put(store, 1, 0, &second, &error);
    assert_no_error(&error);
    assert_true(number("SELECT text FROM configurations") == 1);
    assert_true(number("SELECT number FROM channels") == 8);
    store_close(store);
}

TEST(a_change_of_a_landing_leaves_who_it_is)
{
    struct store_landing landing = {.session = 3,
                                    .boot = 1,
                                    .board_landing = 5,
                                    .armed_us = 77,
                                    .state = 1,
                                    .touchdown_ft = 100.0};
    begin("change.db");
    store_landing_add(store, &landing, &error);
    landing.session = 4;
    landing.board_landing = 6;
    landing.state = 4;
    landing.touchdown_ft = 120.0;
    store_landing_put(store, &landing, &error);
    assert_no_error(&error);
    assert_true(number("SELECT session FROM landings") == 3);
    assert_true(number("SELECT board_landing FROM landings") == 5);
    assert_true(number("SELECT state FROM landings") == 4);
    assert_true(number("SELECT touchdown_ft FROM landings") == 120);
    store_close(store);
}
