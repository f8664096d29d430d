/* Who is on a CAN bus: frames of boards and of others, written out from the numbers of the message
 * catalogue (docs/reference/messages.md): hello 0x1f0, board_uid 0x1f1, board_image 0x1f2,
 * board_config 0x1f3, config_state 0x1e2, clock 0x180, config_word 0x401. */
#include <stdlib.h>
#include <string.h>

#include "host/board/busscan.h"
#include "tests/host/scratch.h"

#define MS          1000u
#define CATALOGUE   92u /* messages of it */
#define NO_CONFLICT 0u

static struct busscan *scan;
static struct busscan_found *found;
static uint64_t now_us;

static int begin(void **state)
{
    (void)state;
    scan = calloc(1, sizeof *scan);
    found = calloc(1, sizeof *found);
    now_us = 1764000000000000u;
    return !scan || !found;
}

static int end(void **state)
{
    (void)state;
    free(scan);
    free(found);
    return 0;
}

static void hear(uint32_t id, unsigned length, const uint8_t *data)
{
    struct link_frame frame = {.host_us = now_us, .id = id, .length = (uint8_t)length};
    if (data)
        memcpy(frame.data, data, length);
    busscan_frame(scan, &frame);
}

/* Firmware 1.2.3 of layout 5, or another one, runs from the crystal, power restarted it; idle. */
static void hello(unsigned base, uint8_t layout)
{
    const uint8_t data[8] = {layout, 0, 1, 2, 3, 0, 1, 0};
    hear(0x1f0 + base, 8, data);
}

/* Of a chip: its place 0031 00xx, wafer 0F, lot "PGXV56x". */
static void uid(unsigned base, uint8_t first)
{
    const uint8_t data[8] = {first, 0, 0x31, 0, 0x0f, 'P', 'G', 'X'};
    hear(0x1f1 + base, 8, data);
}

/* And what follows it. */
static void image(unsigned base, uint8_t last)
{
    const uint8_t data[8] = {'V', '5', '6', last, 0x3f, 0xa5, 0x15, 0x09};
    hear(0x1f2 + base, 8, data);
    hear(0x1f3 + base, 8, NULL);
    hear(0x1e2 + base, 8, NULL);
}

static void clock_message(unsigned base)
{
    hear(0x180 + base, 8, NULL);
}

/* A second of a board: who it is, and ten times its clock. */
static void second_of(unsigned base, uint8_t first)
{
    hello(base, 5);
    uid(base, first);
    image(base, ' ');
    for (int i = 0; i < 10; i++) {
        now_us += 100 * MS;
        clock_message(base);
    }
}

static void find(void)
{
    now_us += 500 * MS;
    hear(0x7ff, 0, NULL); /* so much later is the end */
    busscan_find(scan, found);
}

static const char *uid_of(unsigned board, unsigned which)
{
    static char text[IDENTITY_UID_TEXT];
    identity_uid_text(&found->board[board].who[which], text);
    return text;
}

static void two_boards_and_others(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++) {
        second_of(0, 0x42);
        second_of(400, 0x27);
        hear(0x123, 4, NULL);
        hear(0x123, 8, NULL);
        hear(0x123 | LINK_ID_EXTENDED, 8, NULL);
        hear(0x124 | LINK_ID_REMOTE, 8, NULL);
        hear(LINK_ID_ERROR | 0x8, 8, NULL);
    }
    find();
    assert_int_equal(found->count, 2);
    assert_int_equal(found->board[0].base, 0);
    assert_int_equal(found->board[1].base, 400);
    assert_int_equal(found->board[0].uids, 1);
    assert_string_equal(uid_of(0, 0), "003100425847500F20363556");
    assert_string_equal(uid_of(1, 0), "003100275847500F20363556");
    assert_int_equal(found->board[1].hello.layout, 5);
    assert_int_equal(found->board[1].hello.minor, 2);
    assert_int_equal(found->board[0].frames, 45);
    assert_int_equal(found->board[1].frames, 45);
    assert_int_equal(found->stray[0x123], 6);
    assert_int_equal(found->stray[0x124], 3);
    assert_int_equal(found->stray[0x1f0], 0);
    assert_int_equal(scan->extended, 3);
    assert_int_equal(scan->remote, 3);
    assert_int_equal(scan->errors, 3);
    assert_int_equal(scan->frames, 90 + 6 + 3 + 1);
    /* three times 2 s, and the end */
    assert_true(busscan_heard_s(scan) == 6.5);
    for (unsigned i = 0; i < 2; i++)
        assert_int_equal(busscan_conflicts_of(found, &found->board[i], NULL, 0), NO_CONFLICT);
}

/* channel_zero of the reference, switch_place and slack of a board at 0, as they stand in a log:
 * read as a board at 6, they are a hello of layout 23, and an identity. */
static void what_looks_like_three_messages_of_a_board_is_none(void **state)
{
    static const uint8_t zero[8] = {23}, place[8] = {23, 0, 0x3c}, slack[8] = {1, 0, 0x40};
    (void)state;
    for (int s = 0; s < 3; s++) {
        second_of(0, 1);
        hear(0x1f6, 8, zero);
        hear(0x1f7, 8, place);
        hear(0x1f8, 8, slack);
        now_us += 200 * MS;
    }
    find();
    assert_int_equal(found->count, 1);
    assert_int_equal(found->board[0].base, 0);
}

/* Of a board that speaks another layout it is told; what only looks like a hello is none. */
static void what_a_hello_is(void **state)
{
    (void)state;
    hello(0x10, 4);
    uid(0x10, 1);
    image(0x10, ' ');
    now_us += 200 * MS;
    hello(0x20, 5); /* nothing follows */
    now_us += 200 * MS;
    hello(0x30, 5); /* one of the three */
    uid(0x30, 1);
    now_us += 200 * MS;
    hello(0x3fe, 5); /* as far as it goes: config_word is 0x7ff */
    uid(0x3fe, 1);
    image(0x3fe, ' ');
    now_us += 200 * MS;
    hello(0x3ff, 5); /* no base */
    uid(0x3ff, 1);
    image(0x3ff, ' ');
    now_us += 200 * MS;
    static const uint8_t wrong[][8] = {{0, 0, 1, 2, 3, 0, 1, 0}, /* layout 0, 261 */
                                       {5, 1, 1, 2, 3, 0, 1, 0},
                                       {5, 0, 1, 2, 3, 3, 1, 0}, /* no such clock, cause, state */
                                       {5, 0, 1, 2, 3, 0, 64, 0},
                                       {5, 0, 1, 2, 3, 0, 1, 5}};
    for (unsigned i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        hear(0x1f0 + 0x100, 8, wrong[i]);
        uid(0x100, 1);
        image(0x100, ' ');
        now_us += 200 * MS;
    }
    static const uint8_t shorter[7] = {5, 0, 1, 2, 3, 0, 1};
    hear(0x1f0 + 0x110, 7, shorter);
    uid(0x110, 1);
    image(0x110, ' ');
    find();
    assert_int_equal(found->count, 2);
    assert_int_equal(found->board[0].base, 0x10);
    assert_int_equal(found->board[0].hello.layout, 4);
    assert_int_equal(found->board[1].base, 0x3fe);
}

static void two_boards_of_one_base(void **state)
{
    (void)state;
    for (int s = 0; s < 2; s++) {
        second_of(0x190, 1);
        second_of(0x190, 2);
    }
    find();
    assert_int_equal(found->count, 1);
    assert_int_equal(found->board[0].uids, 2);
    assert_string_equal(uid_of(0, 0), "003100015847500F20363556");
    assert_string_equal(uid_of(0, 1), "003100025847500F20363556");
}

/* As those that were switched on together. */
static void speak_at_once(unsigned boards)
{
    for (unsigned i = 0; i < boards; i++)
        hello(0, 5);
    for (unsigned i = 0; i < boards; i++)
        uid(0, (uint8_t)(i + 1));
    for (unsigned i = 0; i < boards; i++)
        image(0, (uint8_t)('A' + i));
    now_us += 1000 * MS;
}

static void two_boards_of_one_base_at_once(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++)
        speak_at_once(2);
    find();
    assert_int_equal(found->count, 1);
    assert_int_equal(found->board[0].uids, 2);
    assert_string_equal(uid_of(0, 0), "003100015847500F41363556");
    assert_string_equal(uid_of(0, 1), "003100025847500F42363556");
}

static void more_boards_of_one_base_at_once(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++)
        speak_at_once(4);
    find();
    assert_int_equal(found->count, 1);
    assert_int_equal(found->board[0].uids, 4);
    assert_false(found->board[0].more);
    assert_true(busscan_is_shared(&found->board[0]));
    assert_string_equal(uid_of(0, 2), "003100035847500F43363556");
}

static void more_boards_than_are_told_apart(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++)
        speak_at_once(BUSSCAN_UIDS + 1);
    find();
    assert_int_equal(found->count, 1);
    assert_true(found->board[0].more);
    assert_true(busscan_is_shared(&found->board[0]));
}

/* Hellos that are the same bits at the same time are one on the wire: no round is whole. */
static void two_boards_whose_hellos_are_one(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++) {
        hello(0, 5);
        uid(0, 1);
        uid(0, 2);
        image(0, 'B');
        image(0, 'A');
        now_us += 1000 * MS;
    }
    find();
    assert_int_equal(found->count, 1);
    assert_true(busscan_is_shared(&found->board[0]));
}

/* One board_uid alone gets through: two hellos 0.2 ms apart are of two boards. */
static void hellos_of_boards_that_are_not_told_apart(void **state)
{
    (void)state;
    for (int s = 0; s < 3; s++) {
        hello(0, 5);
        now_us += 200;
        hello(0, 5);
        uid(0, 1);
        image(0, ' ');
        now_us += 1000 * MS;
    }
    find();
    assert_int_equal(found->board[0].uids, 1);
    assert_true(busscan_is_shared(&found->board[0]));
}

/* It says hello again 19 ms after its reset, whatever it had said before. */
static void a_board_that_restarts_is_one(void **state)
{
    (void)state;
    for (int s = 0; s < 5; s++) {
        hello(0, 5);
        now_us += 19 * MS;
        hello(0, 5);
        uid(0, 1);
        now_us += 19 * MS;
        hello(0, 5);
        uid(0, 1);
        image(0, ' ');
        now_us += 19 * MS;
        second_of(0, 1);
        now_us += (s % 2 ? 0 : 1000) * MS;
    }
    find();
    assert_int_equal(found->count, 1);
    assert_false(busscan_is_shared(&found->board[0]));
}

/* Readings of a board at 0xf0, 250 a second, have the identifiers of hello and what follows it. */
static void a_board_whose_identifiers_are_shared(void **state)
{
    uint8_t reading[8] = {0x10, 0x27, 0x78, 0xEC, 0x01, 0x7f, 0x34, 0x12};
    (void)state;
    for (int s = 0; s < 3; s++) {
        hello(0, 5);
        uid(0, 1);
        image(0, ' ');
        hello(0xf0, 5);
        uid(0xf0, 2);
        image(0xf0, ' ');
        for (int i = 0; i < 250; i++) {
            now_us += 4 * MS;
            reading[6]++;
            for (unsigned k = 0; k < 3; k++)
                hear(0x100 + 0xf0 + k, 8, reading);
        }
    }
    find();
    assert_int_equal(found->count, 2);
    assert_string_equal(uid_of(0, 0), "003100015847500F20363556");
    assert_int_equal(found->board[1].base, 0xf0);
    for (unsigned i = 0; i < 2; i++)
        assert_false(busscan_is_shared(&found->board[i]));
    assert_true(busscan_conflicts_of(found, &found->board[0], NULL, 0) > 3);
    struct busscan_conflict conflict[CATALOGUE];
    size_t there = busscan_conflicts_of(found, &found->board[1], conflict, CATALOGUE);
    bool hello_told = false;
    for (size_t i = 0; i < there; i++)
        hello_told |= conflict[i].id == 0x1f0 && conflict[i].message == 0x100 &&
                      conflict[i].other == 0x1f0 && conflict[i].board == &found->board[0];
    assert_true(hello_told);
}

static void conflicts_of_a_base(void **state)
{
    struct busscan_conflict conflict[CATALOGUE];
    char text[300];
    (void)state;
    second_of(0, 1);
    hear(0x200, 8, NULL); /* as sync 0x070 of a board at 0x190 has it */
    hear(0x200, 8, NULL);
    find();
    /* the whole catalogue of the board that is there, heard or not */
    assert_int_equal(busscan_conflicts(found, 0, NULL, 0), CATALOGUE);
    assert_int_equal(busscan_conflicts(found, 0x190, conflict, CATALOGUE), 1);
    assert_int_equal(conflict[0].id, 0x200);
    assert_int_equal(conflict[0].message, 0x70);
    assert_null(conflict[0].board);
    assert_int_equal(conflict[0].frames, 2);
    busscan_conflicts_text(conflict, 1, 1, text, sizeof text);
    assert_string_equal(text, "0x200 sync (2 frames of no board)");
    /* its command and config_word, which nobody has sent: temperature 0x0e0, slow_row 0x0e1 */
    assert_int_equal(busscan_conflicts(found, 0x320, conflict, CATALOGUE), 2);
    assert_int_equal(conflict[1].id, 0x401);
    assert_int_equal(conflict[1].message, 0xe1);
    assert_int_equal(conflict[1].other, 0x401);
    assert_ptr_equal(conflict[1].board, &found->board[0]);
    busscan_conflicts_text(conflict, 1, 7, text, sizeof text);
    assert_string_equal(text, "0x400 temperature (command of the board at 0x000) and 6 more");
    assert_int_equal(busscan_conflicts(found, 0x3c0, conflict, CATALOGUE), NO_CONFLICT);
}

/* A frame at an identifier of a board, that is none of its messages, is somebody else's. */
static void another_length_or_a_remote_frame_is_of_no_board(void **state)
{
    struct busscan_conflict conflict[CATALOGUE];
    (void)state;
    second_of(0, 1);
    hear(0x180, 3, NULL);
    hear(0x181 | LINK_ID_REMOTE, 8, NULL);
    find();
    assert_int_equal(busscan_conflicts_of(found, &found->board[0], conflict, CATALOGUE), 2);
    assert_int_equal(conflict[0].id, 0x180);
    assert_int_equal(conflict[0].frames, 1);
    assert_int_equal(conflict[1].id, 0x181);
}

/* A board that gets another base is not in its own way; one of two at a base is. */
static void who_leaves_is_in_nobodys_way(void **state)
{
    struct identity who = {.uid = {0x00310001, 0x5847500f, 0x20363556}};
    struct identity other = {.uid = {0x00310002, 0x5847500f, 0x20363556}};
    (void)state;
    second_of(0, 1);
    find();
    busscan_leave(found, 0, &other);
    assert_int_equal(busscan_conflicts(found, 0x10, NULL, 0), 32);
    busscan_leave(found, 0x10, &who);
    assert_int_equal(busscan_conflicts(found, 0x10, NULL, 0), 32);
    busscan_leave(found, 0, &who);
    assert_int_equal(busscan_conflicts(found, 0x10, NULL, 0), NO_CONFLICT);
    second_of(0, 2);
    find();
    busscan_leave(found, 0, &who);
    assert_int_equal(busscan_conflicts(found, 0x10, NULL, 0), 32);
}

/* Expected: by the identifiers of `matrig export --format dbc`, in Python. */
static void free_bases(void **state)
{
    uint16_t bases[400];
    char text[64];
    (void)state;
    second_of(0, 1);
    second_of(0x190, 2);
    find();
    /* 151 bases have no identifier of these two; 0x7ff, which find() heard, is config_word's at
     * 0x3fe */
    assert_int_equal(busscan_free(found, bases, 400), 150);
    assert_int_equal(bases[0], 0x3c0);
    assert_int_equal(bases[3], 0x3f0);
    assert_int_equal(bases[4], 0x225);
    assert_int_equal(busscan_free(found, bases, 2), 2);
    busscan_free_text(found, text, sizeof text);
    assert_string_equal(text, "0x3c0, 0x3d0, 0x3e0, 0x3f0");
    /* each identifier that is left, once: nothing is free */
    for (uint32_t id = 0; id <= 0x7ff; id++)
        hear(id, 1, NULL);
    busscan_find(scan, found);
    assert_int_equal(busscan_free(found, bases, 400), 0);
    busscan_free_text(found, text, sizeof text);
    assert_string_equal(text, "none");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(two_boards_and_others, begin, end),
        cmocka_unit_test_setup_teardown(what_looks_like_three_messages_of_a_board_is_none, begin,
                                        end),
        cmocka_unit_test_setup_teardown(what_a_hello_is, begin, end),
        cmocka_unit_test_setup_teardown(two_boards_of_one_base, begin, end),
        cmocka_unit_test_setup_teardown(two_boards_of_one_base_at_once, begin, end),
        cmocka_unit_test_setup_teardown(more_boards_of_one_base_at_once, begin, end),
        cmocka_unit_test_setup_teardown(more_boards_than_are_told_apart, begin, end),
        cmocka_unit_test_setup_teardown(two_boards_whose_hellos_are_one, begin, end),
        cmocka_unit_test_setup_teardown(hellos_of_boards_that_are_not_told_apart, begin, end),
        cmocka_unit_test_setup_teardown(a_board_that_restarts_is_one, begin, end),
        cmocka_unit_test_setup_teardown(a_board_whose_identifiers_are_shared, begin, end),
        cmocka_unit_test_setup_teardown(conflicts_of_a_base, begin, end),
        cmocka_unit_test_setup_teardown(another_length_or_a_remote_frame_is_of_no_board, begin,
                                        end),
        cmocka_unit_test_setup_teardown(who_leaves_is_in_nobodys_way, begin, end),
        cmocka_unit_test_setup_teardown(free_bases, begin, end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
