/* Several boards on one CAN bus (hil/board/canbus.h), with a test image (images/canbus.c): who
 * begins, how long frames hold the bus, who hears them, and what happens when one of them fails.
 * The lengths are counted here, from the standard (ISO 11898-1, 10.4 and 10.5; CRC 10.4.2.6). */
#include "common/catalogue.h"
#include "hil/board/canbus.h"
#include "hil/board/parts.h"
#include "tests/hil/bench.h"

#define FRAMES       64u
#define MAILBOX      0x180u
#define INTERMISSION 3u
#define ERROR_FRAME  14u /* flag of 6, delimiter of 8 */

struct heard {
    unsigned count;
    struct hil_can_frame frame[FRAMES];
    uint64_t t_ps[FRAMES];
};

struct several {
    struct hil_canbus *bus;
    struct hil_board *board[HIL_CANBUS_BOARDS];
    unsigned boards;
    struct heard heard;
};

static void hear(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct heard *heard = ctx;
    assert_true(heard->count < FRAMES);
    heard->frame[heard->count] = *frame;
    heard->t_ps[heard->count++] = t_ps;
}

static void run(struct several *s, uint64_t t_ps)
{
    unsigned stopped = 0;
    if (hil_canbus_run_until(s->bus, t_ps, &stopped) != MR_OK)
        fail_msg("board %u stopped: %s", stopped, hil_board_reason(s->board[stopped]));
    assert_int_equal(hil_canbus_now_ps(s->bus), t_ps);
}

static void run_on(struct several *s, uint64_t for_ps)
{
    run(s, hil_canbus_now_ps(s->bus) + for_ps);
}

static void start(struct several *s, unsigned boards)
{
    struct hil_options options;
    hil_options_default(&options);
    *s = (struct several){.bus = hil_canbus_create(), .boards = boards};
    for (unsigned i = 0; i < boards; i++, options.uid[0]++) {
        struct hil_callbacks callbacks = {&s->heard, hear, NULL};
        s->board[i] = bench_board("canbus", &options);
        hil_board_set_callbacks(s->board[i], &callbacks);
        assert_int_equal(hil_canbus_join(s->bus, s->board[i]), MR_OK);
    }
    run(s, 5 * HIL_MS_PS);
    for (unsigned i = 0; i < boards; i++)
        assert_int_equal(bench_result(s->board[i], 1), 0x100); /* on the bus */
}

static void end(struct several *s)
{
    for (unsigned i = 0; i < s->boards; i++)
        hil_board_destroy(s->board[i]);
    hil_canbus_destroy(s->bus);
}

/* As the firmware would, now: a frame of so many bytes, each of them `byte`. */
static void send(struct several *s, unsigned board, unsigned mailbox, uint32_t id, unsigned length,
                 uint8_t byte)
{
    struct hil_can_device *can = &s->board[board]->mcu.can;
    uint32_t at = MAILBOX + 16u * mailbox;
    hil_can_write(can, 0, at + 4u, length);
    hil_can_write(can, 0, at + 8u, 0x01010101u * byte);
    hil_can_write(can, 0, at + 12u, 0x01010101u * byte);
    hil_can_write(can, 0, at, id << 21 | 1u);
}

static void put(bool bits[128], unsigned *n, uint32_t value, unsigned width)
{
    while (width--)
        bits[(*n)++] = value >> width & 1u;
}

/* Bits of a standard data frame, from start of frame to the end of end of frame. */
static unsigned bits_of(const struct hil_can_frame *frame)
{
    bool bits[128] = {false};
    static const bool polynomial[16] = {1, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1};
    unsigned n = 0, stuffed = 0, equal = 1;
    put(bits, &n, 0, 1);
    put(bits, &n, frame->id, 11);
    put(bits, &n, 0, 3);
    put(bits, &n, frame->length, 4);
    for (unsigned i = 0; i < frame->length; i++)
        put(bits, &n, frame->data[i], 8);
    bool rest[128] = {false}; /* of the long division by the polynomial */
    memcpy(rest, bits, n);
    for (unsigned i = 0; i < n; i++) {
        for (unsigned k = 0; rest[i] && k < 16; k++) /* the first bit, k = 0, ends it */
            rest[i + 15u - k] ^= polynomial[15u - k];
    }
    memcpy(bits + n, rest + n, 15);
    n += 15;
    bool last = bits[0];
    for (unsigned i = 1; i < n; i++) {
        equal = bits[i] == last ? equal + 1u : 1u;
        last = bits[i];
        if (equal == 5) {
            stuffed++;
            last = !last;
            equal = 1;
        }
    }
    return n + stuffed + 1u + 2u + 7u; /* delimiter, acknowledge, end of frame */
}

/* The length of the shortest and of the longest frame, from elsewhere: without stuffing 44 bits and
 * 8 for each byte; a stuff bit at most after each four of the first 34 + 64. */
static void test_counting(void **state)
{
    struct hil_can_frame frame = {.id = 0x555};
    (void)state;
    assert_in_range(bits_of(&frame), 44, 44 + 8);
    frame = (struct hil_can_frame){.id = 0, .length = 8};
    assert_in_range(bits_of(&frame), 108 + 15, 108 + 24);
}

/* Both boards fill three mailboxes while a frame of the host holds the bus: then the lowest
 * identifier of all goes first, whose it is. No pause between them, no overlap, and the bus counts
 * exactly their bits. */
static void test_arbitration(void **state)
{
    static const uint32_t order[] = {0x050, 0x100, 0x150, 0x200, 0x250, 0x300};
    struct hil_can_frame host = {.id = 0x7ff, .length = 8};
    struct several s;
    (void)state;
    start(&s, 2);
    assert_int_equal(hil_board_can_inject(s.board[0], &host), MR_OK);
    uint64_t free_ps = hil_canbus_now_ps(s.bus), busy_us = bits_of(&host);
    run_on(&s, 20 * HIL_US_PS);
    send(&s, 0, 0, 0x300, 8, 0x55);
    send(&s, 1, 2, 0x150, 8, 0x00);
    send(&s, 0, 1, 0x100, 3, 0xff);
    send(&s, 1, 1, 0x250, 0, 0x00);
    send(&s, 0, 2, 0x200, 1, 0x0f);
    send(&s, 1, 0, 0x050, 5, 0x81);
    run(&s, free_ps + (bits_of(&host) + 50u) * HIL_US_PS); /* in the first of them */
    assert_int_equal(hil_can_tsr(&s.board[0]->state.mcu.can) & 0x040404u, 4u << 8); /* ALST1 */
    assert_int_equal(hil_can_tsr(&s.board[1]->state.mcu.can) & 0x040404u, 0);
    run_on(&s, 2 * HIL_MS_PS);
    assert_int_equal(s.heard.count, 6);
    free_ps += (bits_of(&host) + INTERMISSION) * HIL_US_PS;
    for (unsigned i = 0; i < 6; i++) {
        unsigned bits = bits_of(&s.heard.frame[i]);
        assert_int_equal(s.heard.frame[i].id, order[i]);
        /* clocks count 6 ns; the first instruction after the injection comes within some more */
        assert_near(s.heard.t_ps[i], free_ps + bits * HIL_US_PS, i ? 12000 : 100000);
        if (i)
            assert_true(s.heard.t_ps[i] + 12000 >=
                        s.heard.t_ps[i - 1] + (bits + INTERMISSION) * HIL_US_PS);
        free_ps = s.heard.t_ps[i] + INTERMISSION * HIL_US_PS;
        busy_us += bits;
    }
    const struct hil_canbus_counts *counts = hil_canbus_counts(s.bus);
    assert_int_equal(counts->frames, 7);
    assert_int_equal(counts->bad, 0);
    assert_near(counts->busy_ps, busy_us * HIL_US_PS, 7 * 12000);
    end(&s);
}

/* On a free bus the first that is ready goes first, even if another's identifier is lower, unless
 * that comes within a bit. */
static void test_first_come(void **state)
{
    struct several s;
    (void)state;
    start(&s, 2);
    send(&s, 0, 0, 0x700, 0, 0);
    run_on(&s, 2 * HIL_US_PS);
    send(&s, 1, 0, 0x001, 0, 0);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(s.heard.frame[0].id, 0x700);
    assert_int_equal(s.heard.frame[1].id, 0x001);
    send(&s, 0, 0, 0x700, 0, 0);
    run_on(&s, HIL_US_PS / 2);
    send(&s, 1, 0, 0x001, 0, 0);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(s.heard.count, 4);
    assert_int_equal(s.heard.frame[2].id, 0x001);
    assert_int_equal(s.heard.frame[3].id, 0x700);
    end(&s);
}

/* A frame of a board reaches another when that one's filter lets it pass, and not itself. */
static void test_filter(void **state)
{
    struct several s;
    (void)state;
    start(&s, 3);
    s.board[2]->state.mcu.can.filter[0][0] = 0x200u << 21;
    s.board[2]->state.mcu.can.filter[0][1] = 0x7f0u << 21; /* 0x200 to 0x20f alone */
    send(&s, 0, 0, 0x1ff, 2, 0xa5);
    send(&s, 0, 1, 0x207, 2, 0x5a);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(bench_result(s.board[0], 2), 0);
    assert_int_equal(bench_result(s.board[1], 2), 2);
    assert_int_equal(bench_result(s.board[2], 2), 1);
    assert_int_equal(bench_result(s.board[2], 8), 0x207);
    assert_int_equal(bench_result(s.board[2], 4) & 0xffffu, 0x5a5a);
    assert_int_equal(hil_board_counters(s.board[2])->can_frames_in, 2);
    assert_int_equal(hil_board_counters(s.board[2])->can_frames_filtered, 1);
    end(&s);
}

/* What the host sends reaches all who listen, and waits while nobody does. */
static void test_host(void **state)
{
    struct hil_can_frame frame = {.id = 0x400, .length = 1, .data = {7}};
    struct several s;
    (void)state;
    start(&s, 2);
    hil_can_set_bus(&s.board[1]->mcu.can, HIL_CAN_UNPLUGGED);
    hil_board_can_inject(s.board[1], &frame); /* of the bus, whoever it is given to */
    run_on(&s, HIL_MS_PS);
    assert_int_equal(bench_result(s.board[0], 2), 1);
    assert_int_equal(bench_result(s.board[1], 2), 0);
    hil_can_set_bus(&s.board[0]->mcu.can, HIL_CAN_UNPLUGGED);
    hil_board_can_inject(s.board[0], &frame);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(bench_result(s.board[0], 2), 1);
    hil_can_set_bus(&s.board[1]->mcu.can, HIL_CAN_CONNECTED);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(bench_result(s.board[0], 2), 1);
    assert_int_equal(bench_result(s.board[1], 2), 1);
    end(&s);
}

/* A silent board hears what another acknowledges, and nothing that nobody does. */
static void test_silent(void **state)
{
    struct hil_can_frame frame = {.id = 0x400};
    struct several s;
    (void)state;
    start(&s, 2);
    s.board[1]->state.mcu.can.btr |= 1u << 31;
    hil_can_set_bus(&s.board[0]->mcu.can, HIL_CAN_UNPLUGGED);
    hil_board_can_inject(s.board[0], &frame);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(bench_result(s.board[1], 2), 0);
    hil_can_set_bus(&s.board[0]->mcu.can, HIL_CAN_CONNECTED);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(bench_result(s.board[0], 2), 1);
    assert_int_equal(bench_result(s.board[1], 2), 1);
    end(&s);
}

/* A command of a run file goes to its board's base. */
static void test_base(void **state)
{
    struct hil_run_command command = {.t_ps = 7 * HIL_MS_PS};
    struct hil_options options;
    struct hil_run still;
    struct several s;
    (void)state;
    start(&s, 1);
    hil_options_default(&options);
    options.uid[0]++;
    options.can_base = 0x40;
    still_run(&still, 1.0);
    still.commands = &command;
    still.command_count = 1;
    s.boards = 2;
    s.board[1] = bench_board("canbus", &options);
    assert_int_equal(hil_canbus_join(s.bus, s.board[1]), MR_OK);
    hil_board_attach_rig(s.board[1], &still);
    run(&s, 8 * HIL_MS_PS);
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(bench_result(s.board[i], 2), 1);
        assert_int_equal(bench_result(s.board[i], 8), MR_ID_COMMAND + 0x40);
    }
    end(&s);
    free(still.samples);
}

/* Two frames of the host back to back, then a board's that waits for them: an intermission
 * behind each. */
static void test_intermission(void **state)
{
    struct hil_can_frame frame = {.id = 0x001, .length = 3, .data = {0xff, 0, 0x3c}};
    struct several s;
    (void)state;
    start(&s, 2);
    uint64_t began_ps = hil_canbus_now_ps(s.bus);
    hil_board_can_inject(s.board[0], &frame);
    hil_board_can_inject(s.board[0], &frame);
    run_on(&s, 20 * HIL_US_PS);
    send(&s, 1, 0, 0x7f0, 2, 0);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(s.heard.count, 1);
    assert_near(s.heard.t_ps[0],
                began_ps + (2u * (bits_of(&frame) + INTERMISSION) + bits_of(&s.heard.frame[0])) *
                               HIL_US_PS,
                100000);
    end(&s);
}

/* A board whose cable is out sends to nobody, and the others go on. */
static void test_unplugged(void **state)
{
    struct several s;
    (void)state;
    start(&s, 2);
    hil_can_set_bus(&s.board[0]->mcu.can, HIL_CAN_UNPLUGGED);
    send(&s, 0, 0, 0x001, 8, 0);
    run_on(&s, 10 * HIL_MS_PS);
    send(&s, 1, 0, 0x100, 8, 0);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(s.heard.count, 1);
    assert_int_equal(s.heard.frame[0].id, 0x100);
    assert_int_equal(s.board[0]->state.mcu.can.tec, 128); /* nobody acknowledges */
    hil_can_set_bus(&s.board[0]->mcu.can, HIL_CAN_CONNECTED);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(s.heard.count, 2);
    assert_int_equal(bench_result(s.board[1], 8), 0x001);
    end(&s);
}

/* Reset in the middle of its frame: the frame is none, the listener counts an error, the bus is
 * free again after the error frame; the board comes back. */
static void test_reset(void **state)
{
    struct several s;
    (void)state;
    start(&s, 2);
    send(&s, 0, 0, 0x100, 8, 0x55);
    uint64_t began_ps = hil_canbus_now_ps(s.bus);
    run_on(&s, 50 * HIL_US_PS);
    hil_board_reset(s.board[0]);
    send(&s, 1, 0, 0x200, 8, 0x55);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(s.heard.count, 1);
    assert_int_equal(s.heard.frame[0].id, 0x200);
    /* six recessive bits, the error frame, intermission; then its own bits */
    assert_near(s.heard.t_ps[0],
                began_ps + (50u + 6u + ERROR_FRAME + INTERMISSION + bits_of(&s.heard.frame[0])) *
                               HIL_US_PS,
                HIL_US_PS);
    assert_int_equal(hil_board_counters(s.board[1])->can_errors, 1);
    assert_int_equal(bench_result(s.board[1], 2), 0);
    assert_int_equal(hil_canbus_counts(s.bus)->bad, 1);
    run_on(&s, 5 * HIL_MS_PS);
    send(&s, 0, 0, 0x101, 8, 0x55);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(bench_result(s.board[1], 8), 0x101);
    end(&s);
}

/* A listener's fault destroys the frame for all; it is sent again. TEC 8 up and one down, REC one
 * up and one down (fault confinement, rules 3, 7 and 8). */
static void test_corrupted(void **state)
{
    struct hil_line_effect once = {.left = 1, .probability = 1.0};
    struct several s;
    (void)state;
    start(&s, 3);
    hil_lines_order(&s.board[1]->lines, HIL_CAN_IN, HIL_CORRUPT, &once);
    send(&s, 0, 0, 0x123, 4, 0x3c);
    run_on(&s, HIL_MS_PS);
    assert_int_equal(s.heard.count, 1);
    assert_int_equal(hil_canbus_counts(s.bus)->frames, 2);
    assert_int_equal(hil_canbus_counts(s.bus)->bad, 1);
    assert_int_equal(s.board[0]->state.mcu.can.tec, 7);
    for (unsigned i = 1; i < 3; i++) {
        assert_int_equal(hil_board_counters(s.board[i])->can_errors, 1);
        assert_int_equal(s.board[i]->state.mcu.can.rec, 0);
        assert_int_equal(bench_result(s.board[i], 2), 1);
    }
    end(&s);
}

/* The same identifier with other data: each try is an error to both, 8 up each time, until both are
 * error passive after 16 (128). Then who sends the recessive bit gives way, and sends after the
 * other. */
static void test_collision(void **state)
{
    struct several s;
    (void)state;
    start(&s, 2);
    send(&s, 0, 0, 0x123, 8, 0xf0);
    send(&s, 1, 0, 0x123, 8, 0x0f);
    run_on(&s, 10 * HIL_MS_PS);
    const struct hil_canbus_counts *counts = hil_canbus_counts(s.bus);
    assert_int_equal(counts->collisions, 17);
    assert_int_equal(counts->bad, 16);
    assert_int_equal(s.heard.count, 2);
    assert_int_equal(s.heard.frame[0].data[0], 0x0f);
    assert_int_equal(s.heard.frame[1].data[0], 0xf0);
    assert_int_equal(s.board[1]->state.mcu.can.tec, 16 * 8 - 1);
    assert_int_equal(s.board[0]->state.mcu.can.tec, 17 * 8 - 1);
    end(&s);
}

/* Traffic of both and of the host, the run cut into pieces of this length. */
static void traffic(uint64_t piece_ps, struct heard *heard, struct hil_canbus_counts *counts)
{
    struct hil_can_frame host = {.id = 0x2aa, .length = 2};
    struct several s;
    start(&s, 2);
    for (unsigned i = 0; i < 8; i++) {
        send(&s, 0, 0, 0x100 + 0x20 * i, i, 0x11);
        send(&s, 1, 0, 0x310 - 0x30 * i, 8 - i, 0x77);
        hil_board_can_inject(s.board[i & 1u], &host);
        uint64_t until_ps = hil_canbus_now_ps(s.bus) + 500 * HIL_US_PS;
        while (hil_canbus_now_ps(s.bus) < until_ps) {
            uint64_t next_ps = hil_canbus_now_ps(s.bus) + piece_ps;
            run(&s, next_ps < until_ps ? next_ps : until_ps);
        }
    }
    *heard = s.heard;
    *counts = *hil_canbus_counts(s.bus);
    end(&s);
}

static void test_same_again(void **state)
{
    static struct heard one, other;
    struct hil_canbus_counts one_counts, other_counts;
    (void)state;
    traffic(500 * HIL_US_PS, &one, &one_counts);
    traffic(500 * HIL_US_PS, &other, &other_counts);
    assert_int_equal(one.count, 16);
    assert_memory_equal(&one, &other, sizeof one);
    traffic(7300 * HIL_NS_PS, &other, &other_counts); /* where it is cut changes nothing */
    assert_memory_equal(&one, &other, sizeof one);
    assert_memory_equal(&one_counts, &other_counts, sizeof one_counts);
}

static void test_identity(void **state)
{
    struct hil_canbus *bus = hil_canbus_create();
    struct hil_board *one = bench_board("canbus", NULL), *other = bench_board("canbus", NULL);
    (void)state;
    assert_int_equal(hil_canbus_join(bus, one), MR_OK);
    assert_int_equal(hil_canbus_join(bus, other), MR_USAGE);
    hil_board_destroy(one);
    hil_board_destroy(other);
    hil_canbus_destroy(bus);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counting),     cmocka_unit_test(test_arbitration),
        cmocka_unit_test(test_first_come),   cmocka_unit_test(test_filter),
        cmocka_unit_test(test_host),         cmocka_unit_test(test_base),
        cmocka_unit_test(test_intermission), cmocka_unit_test(test_silent),
        cmocka_unit_test(test_unplugged),    cmocka_unit_test(test_reset),
        cmocka_unit_test(test_corrupted),    cmocka_unit_test(test_collision),
        cmocka_unit_test(test_same_again),   cmocka_unit_test(test_identity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
