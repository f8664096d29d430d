/* Two landings of a campaign that are one, and who is left alone. */
#include <math.h>

#include "host/store/store_journal.h"
#include "tests/host/scratch.h"

enum { NOW_US = 5000 };

static struct store *store;
static struct error error;

static int64_t add_landing(void)
{
    struct store_session session = {.started_us = 1000, .can_link = "a", .serial_link = "b"};
    store_session_add(store, &session, &error);
    struct store_landing landing = {.session = session.id,
                                    .board_landing = 5,
                                    .armed_block = 800,
                                    .armed_us = 77,
                                    .state = 4,
                                    .board_uid = "AB",
                                    .firmware = "1",
                                    .image_crc = STORE_NONE,
                                    .config_crc = STORE_NONE,
                                    .clock_source = STORE_NONE,
                                    .touchdown_ft = (double)NAN,
                                    .switch_error_ft = (double)NAN};
    store_landing_add(store, &landing, &error);
    assert_no_error(&error);
    return landing.id;
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
    store_find_duplicate(store, run, &twin, &error);
    assert_no_error(&error);
    return twin;
}

/* Logged twice is told by the captures of the switches: all that both have, and two at least. */
TEST(a_twin_has_the_same_captures)
{
    char path[200];
    scratch_path(path, sizeof path, "same-twin.db");
    store_open(path, STORE_CREATE, &store, &error);
    store_begin(store, &error);
    assert_no_error(&error);
    int64_t first = add_landing();
    put_edges(first, 1, 9, 0);
    assert_int_equal(twin_of(first), 0);
    int64_t later = add_landing();
    put_edges(later, 1, 9, 1);
    assert_int_equal(twin_of(later), 0); /* 12 ns later: another landing */
    int64_t part = add_landing();
    put_edges(part, 8, 12, 0);
    assert_int_equal(twin_of(part), first);
    int64_t one = add_landing();
    put_edges(one, 1, 1, 0);
    assert_int_equal(twin_of(one), 0); /* one may be by chance */
    int64_t none = add_landing();
    assert_int_equal(twin_of(none), 0);
    struct store_change change = {.run = first, .made_us = NOW_US};
    snprintf(change.field, sizeof change.field, "void");
    snprintf(change.value, sizeof change.value, "yes");
    store_change_add(store, &change, &error);
    assert_no_error(&error);
    assert_int_equal(twin_of(part), 0); /* what is void is nobody's twin */
    store_commit(store, &error);
    assert_no_error(&error);
    store_close(store);
}
