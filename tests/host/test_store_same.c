/* Two landings of a campaign that are one: which is recognised, by what, and what is said of it;
 * and who is left alone. */
#include <math.h>

#include "host/store/store_journal.h"
#include "host/store/store_same.h"
#include "tests/host/scratch.h"

enum { CAN_ALONE, SERIAL_ALONE };
enum { NOW_US = 5000 };

static struct store *store;
static struct error error;

static void put_reading(int64_t session, int64_t run, int link, int64_t number, int64_t host_us)
{
    uint8_t bytes[8] = {(uint8_t)number, (uint8_t)(number >> 8), 7};
    struct store_frame frame = {.run = run,
                                .link = 0,
                                .seq = number,
                                .board_us = 1000 * number,
                                .host_us = host_us,
                                .id = 0x100,
                                .length = sizeof bytes,
                                .data = bytes};
    if (link == CAN_ALONE)
        store_frame_put(store, session, &frame, &error);
    else
        store_block_put(store, session, 0, run, 1, number, host_us, bytes, sizeof bytes, &error);
    assert_no_error(&error);
}

/* A landing with the readings of these numbers; what came later by `later_us` has other stamps. */
static int64_t add_landing(int link, unsigned state, int64_t armed_block, int64_t from, int64_t to,
                           int64_t later_us)
{
    struct store_session session = {.started_us = 1000, .can_link = "a", .serial_link = "b"};
    store_session_add(store, &session, &error);
    struct store_landing landing = {.session = session.id,
                                    .board_landing = 5,
                                    .armed_block = armed_block,
                                    .armed_us = 77,
                                    .state = state,
                                    .board_uid = "AB",
                                    .firmware = "1",
                                    .image_crc = STORE_NONE,
                                    .config_crc = STORE_NONE,
                                    .clock_source = STORE_NONE,
                                    .touchdown_ft = (double)NAN,
                                    .switch_error_ft = (double)NAN};
    store_landing_add(store, &landing, &error);
    assert_no_error(&error);
    for (int64_t i = from; i <= to; i++)
        put_reading(session.id, landing.id, link, i, 10000 + i + later_us);
    return landing.id;
}

static void begin(const char *name)
{
    char path[200];
    scratch_path(path, sizeof path, name);
    error = (struct error){0};
    store_open(path, STORE_CREATE, &store, &error);
    store_begin(store, &error);
    assert_no_error(&error);
}

static void end(void)
{
    store_commit(store, &error);
    assert_no_error(&error);
    store_close(store);
}

static struct store_same found(int64_t run)
{
    struct store_same same;
    store_find_same(store, run, NOW_US, &same, &error);
    assert_no_error(&error);
    return same;
}

static void expect_said(int64_t run, const char *field, const char *value, const char *reason)
{
    char said[STORE_JOURNAL_TEXT], why[STORE_JOURNAL_TEXT];
    store_change_get(store, run, field, said, why, &error);
    assert_no_error(&error);
    assert_string_equal(said, value);
    assert_string_equal(why, reason);
}

TEST(the_whole_makes_its_part_void)
{
    for (int link = CAN_ALONE; link <= SERIAL_ALONE; link++) {
        begin("same-whole.db");
        int64_t part = add_landing(link, 2, 800, 800, 1200, 0),
                whole = add_landing(link, 2, 800, 800, 1900, 0);
        struct store_same same = found(whole);
        assert_int_equal(same.cut, part);
        assert_true(same.whole);
        expect_said(part, "void", "yes", "cut off; RUN 2 has all of it");
        expect_said(whole, "void", "", "");
        assert_int_equal(found(whole).cut, 0); /* what is void is not cut off again */
        end();
    }
}

TEST(what_begins_later_goes_on)
{
    begin("same-rest.db");
    int64_t part = add_landing(CAN_ALONE, 2, 800, 800, 1200, 0),
            rest = add_landing(CAN_ALONE, 4, STORE_NONE, 1100, 1900, 0);
    struct store_same same = found(rest);
    assert_int_equal(same.cut, part);
    assert_false(same.whole);
    expect_said(part, "void", "", "");
    expect_said(part, "note", "cut off; RUN 2 goes on with it", "");
    expect_said(rest, "note", "goes on with RUN 1, which was cut off", "");
    end();
}

/* The next landing of a board that counts from 1 again, to the millisecond the same; one that is
 * over; one of which a part is missing. */
TEST(others_are_left_alone)
{
    begin("same-none.db");
    add_landing(CAN_ALONE, 2, 800, 800, 1200, 0);
    assert_int_equal(found(add_landing(CAN_ALONE, 4, 800, 800, 1900, 1000000)).cut, 0);
    assert_int_equal(found(add_landing(CAN_ALONE, 4, STORE_NONE, 1400, 1900, 0)).cut, 0);
    end();
    for (int link = CAN_ALONE; link <= SERIAL_ALONE; link++) {
        /* a recording that ends while the mat settles, logged twice */
        begin("same-twice.db");
        add_landing(link, 3, 800, 800, 1200, 0);
        assert_int_equal(found(add_landing(link, 3, 800, 800, 1200, 0)).cut, 0);
        end();
    }
    begin("same-over.db");
    add_landing(CAN_ALONE, 4, 800, 800, 1900, 0);
    assert_int_equal(found(add_landing(CAN_ALONE, 4, 800, 800, 1900, 0)).cut, 0);
    end();
}

static void put_edges(int64_t run, int64_t from, int64_t to, int64_t shift_ticks)
{
    for (int64_t i = from; i <= to; i++) {
        struct store_edge edge = {
            .count = i, .position = i, .tick = 84000 * i + shift_ticks, .links = 1};
        store_edge_put(store, run, &edge, &error);
        assert_no_error(&error);
    }
}

static int64_t twin_of(int64_t run)
{
    int64_t twin = -1;
    store_find_twin(store, run, &twin, &error);
    assert_no_error(&error);
    return twin;
}

/* Logged twice is told by the captures of the switches: all that both have, and two at least. */
TEST(a_twin_has_the_same_captures)
{
    begin("same-twin.db");
    int64_t first = add_landing(CAN_ALONE, 4, 800, 800, 810, 0);
    put_edges(first, 1, 9, 0);
    assert_int_equal(twin_of(first), 0);
    int64_t later = add_landing(CAN_ALONE, 4, 800, 800, 810, 0);
    put_edges(later, 1, 9, 1);
    assert_int_equal(twin_of(later), 0); /* 12 ns later: another landing */
    int64_t part = add_landing(CAN_ALONE, 4, 800, 800, 810, 0);
    put_edges(part, 8, 12, 0);
    assert_int_equal(twin_of(part), first);
    int64_t one = add_landing(CAN_ALONE, 4, 800, 800, 810, 0);
    put_edges(one, 1, 1, 0);
    assert_int_equal(twin_of(one), 0); /* one may be by chance */
    int64_t none = add_landing(CAN_ALONE, 4, 800, 800, 810, 0);
    assert_int_equal(twin_of(none), 0);
    struct store_change change = {.run = first, .made_us = NOW_US};
    snprintf(change.field, sizeof change.field, "void");
    snprintf(change.value, sizeof change.value, "yes");
    store_change_add(store, &change, &error);
    assert_no_error(&error);
    assert_int_equal(twin_of(part), 0); /* what is void is nobody's twin */
    end();
}
