/* bxCAN and its bus on a test image (images/canbus.c): lengths in time, order, FIFO, error
 * states. */
#include "hil/board/board.h"
#include "hil/periph/canbits.h"
#include "tests/hil/bench.h"

#define FRAMES 64

struct heard {
    unsigned count;
    struct hil_can_frame frame[FRAMES];
    uint64_t t_ps[FRAMES];
};

static void hear(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct heard *heard = ctx;
    assert_true(heard->count < FRAMES);
    heard->frame[heard->count] = *frame;
    heard->t_ps[heard->count++] = t_ps;
}

static struct hil_board *on_the_bus(uint32_t control, enum hil_can_bus bus, struct heard *heard)
{
    struct hil_options options;
    hil_options_default(&options);
    options.can_bus = bus;
    struct hil_board *board = bench_board("canbus", &options);
    struct hil_callbacks callbacks = {heard, hear, NULL};
    heard->count = 0;
    hil_board_set_callbacks(board, &callbacks);
    bench_control(board, 0, control);
    bench_run(board, 5 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 1), 0x100);
    return board;
}

static void queue(struct hil_board *board, uint32_t a, uint32_t b, uint32_t c)
{
    bench_control(board, 2, a);
    bench_control(board, 3, b);
    bench_control(board, 4, c);
    bench_control(board, 1, 3);
}

/* Mailboxes 0, 1, 2 are filled in that order within microseconds. The first starts at once; of the
 * two that wait, the lower identifier goes first, or the earlier request. */
TEST(test_mailbox_order)
{
    struct heard heard;
    struct hil_board *board = on_the_bus(0, HIL_CAN_CONNECTED, &heard);
    queue(board, 0x300, 0x200, 0x100);
    bench_run(board, 10 * HIL_PS_PER_MS);
    assert_int_equal(heard.count, 3);
    assert_int_equal(heard.frame[0].id, 0x300);
    assert_int_equal(heard.frame[1].id, 0x100);
    assert_int_equal(heard.frame[2].id, 0x200);
    assert_int_equal(bench_result(board, 6), 3); /* one interrupt each */
    hil_board_destroy(board);
    board = on_the_bus(1, HIL_CAN_CONNECTED, &heard);
    queue(board, 0x300, 0x200, 0x100);
    bench_run(board, 10 * HIL_PS_PER_MS);
    assert_int_equal(heard.count, 3);
    assert_int_equal(heard.frame[1].id, 0x200);
    assert_int_equal(heard.frame[2].id, 0x100);
    hil_board_destroy(board);
}

/* Frames back to back: the end of each is its own length plus three bits of intermission after the
 * end of the one before. */
TEST(test_time_on_the_bus)
{
    struct heard heard;
    struct hil_board *board = on_the_bus(0, HIL_CAN_CONNECTED, &heard);
    queue(board, 0x000, 0x155, 0x7ff);
    bench_run(board, 10 * HIL_PS_PER_MS);
    assert_int_equal(heard.count, 3);
    for (unsigned i = 1; i < 3; i++) {
        uint64_t bits = hil_can_frame_bits(&heard.frame[i]).length + 3u;
        assert_true(llabs((long long)(heard.t_ps[i] - heard.t_ps[i - 1]) -
                          (long long)(bits * HIL_PS_PER_US)) <= 1);
    }
    assert_int_equal(heard.frame[0].length, 8);
    for (unsigned i = 0; i < 8; i++)
        assert_int_equal(heard.frame[0].data[i], 0x11 * i);
    hil_board_destroy(board);
}

TEST(test_receive)
{
    struct heard heard;
    struct hil_board *board = on_the_bus(0, HIL_CAN_CONNECTED, &heard);
    struct hil_can_frame frame = {.id = 0x400, .length = 3, .data = {0xaa, 0xbb, 0xcc}};
    for (unsigned i = 0; i < 5; i++, frame.id++)
        assert_int_equal(hil_can_inject(&board->mcu.can, &frame), MR_OK);
    bench_run(board, 10 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 2), 5);
    for (unsigned i = 0; i < 5; i++)
        assert_int_equal(bench_result(board, 8 + i), 0x400 + i);
    assert_int_equal(bench_result(board, 3) & 15u, 3);
    assert_int_equal(bench_result(board, 4) & 0xffffffu, 0xccbbaa);
    hil_board_destroy(board);
}

/* Nobody takes frames out: three stay, the fourth overruns. */
TEST(test_overrun)
{
    struct heard heard;
    struct hil_board *board = on_the_bus(2, HIL_CAN_CONNECTED, &heard);
    struct hil_can_frame frame = {.id = 0x400};
    for (unsigned i = 0; i < 3; i++)
        hil_can_inject(&board->mcu.can, &frame);
    bench_run(board, 8 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 40), 3u | 8u); /* FMP, FULL */
    hil_can_inject(&board->mcu.can, &frame);
    bench_run(board, 10 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 40), 3u | 8u | 16u); /* and FOVR */
    hil_board_destroy(board);
}

/* A lower identifier of the other node wins against the board's waiting one, and the board sends
 * right after. */
TEST(test_arbitration)
{
    struct heard heard;
    struct hil_board *board = on_the_bus(0, HIL_CAN_CONNECTED, &heard);
    struct hil_can_frame first = {.id = 0x010, .length = 8}, second = {.id = 0x020};
    hil_can_inject(&board->mcu.can, &first); /* holds the bus while the board queues */
    hil_can_inject(&board->mcu.can, &second);
    queue(board, 0x030, 0x031, 0x005);
    bench_run(board, 10 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 2), 2);
    assert_int_equal(heard.count, 3);
    assert_int_equal(heard.frame[0].id, 0x005);
    assert_int_equal(heard.frame[1].id, 0x030);
    /* first, 5, second, 30, 31: between 5 and 30 lies `second` */
    uint64_t bits = hil_can_frame_bits(&second).length + 3u +
                    hil_can_frame_bits(&heard.frame[1]).length + 3u;
    assert_true(
        llabs((long long)(heard.t_ps[1] - heard.t_ps[0]) - (long long)(bits * HIL_PS_PER_US)) <= 1);
    hil_board_destroy(board);
}

/* Nobody acknowledges: TEC rises by 8 to 128 and stays; never bus-off; plugged in, the frame leaves
 * and TEC falls. */
TEST(test_unplugged)
{
    struct heard heard;
    struct hil_board *board = on_the_bus(0, HIL_CAN_UNPLUGGED, &heard);
    bench_control(board, 2, 0x123);
    bench_control(board, 1, 1);
    bench_run(board, 500 * HIL_PS_PER_MS);
    uint32_t esr = bench_result(board, 7);
    assert_int_equal(esr >> 16 & 0xffu, 128);
    assert_int_equal(esr & 7u, 3u);      /* warning, passive, not off */
    assert_int_equal(esr >> 4 & 7u, 3u); /* acknowledge error */
    assert_int_equal(heard.count, 0);
    assert_true(hil_board_counters(board)->can_errors > 1000); /* it goes on trying */
    hil_can_set_bus(&board->mcu.can, HIL_CAN_CONNECTED);
    bench_run(board, 501 * HIL_PS_PER_MS);
    assert_int_equal(heard.count, 1);
    assert_int_equal(bench_result(board, 7) >> 16 & 0xffu, 127);
    hil_board_destroy(board);
}

/* Wires touching: TEC 8 a try, bus-off at 256 after 32 tries; with automatic recovery it tries
 * again, else it stays off. */
TEST(test_bus_off)
{
    struct heard heard;
    struct hil_board *board = on_the_bus(0, HIL_CAN_SHORTED, &heard);
    bench_control(board, 2, 0x123);
    bench_control(board, 1, 1);
    bench_run(board, 100 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 7) & 7u, 7u);
    assert_int_equal(hil_board_counters(board)->can_errors, 32);
    hil_board_destroy(board);
    board = on_the_bus(4, HIL_CAN_SHORTED, &heard);
    bench_control(board, 2, 0x123);
    bench_control(board, 1, 1);
    bench_run(board, 100 * HIL_PS_PER_MS);
    assert_true(hil_board_counters(board)->can_errors > 32);
    hil_can_set_bus(&board->mcu.can, HIL_CAN_CONNECTED);
    bench_run(board, 110 * HIL_PS_PER_MS);
    assert_int_equal(heard.count, 1);
    hil_board_destroy(board);
}

/* Filters: list before mask, numbers counted per FIFO over all banks. Bank 0: a mask to FIFO 0 (1
 * filter), bank 1: a list to FIFO 1 (2), bank 2: a mask to FIFO 0 (1). */
TEST(test_filters)
{
    struct hil_can can = {.fmr = 14u << 8, .fs1r = 7, .fm1r = 2, .ffa1r = 2, .fa1r = 7};
    struct hil_can_frame frame = {.id = 0x123};
    unsigned fifo, match;
    can.filter[0][0] = 0x600u << 21;
    can.filter[0][1] = 0x700u << 21; /* 0x600 to 0x6ff */
    can.filter[1][0] = 0x123u << 21;
    can.filter[1][1] = 0x1abcdefu << 3 | 4u; /* extended */
    can.filter[2][0] = 0x120u << 21;
    can.filter[2][1] = 0x7f0u << 21 | 4u; /* 0x120 to 0x12f, standard */
    can.fmr |= 1u;                        /* FINIT: reception is deactivated */
    assert_false(hil_can_match_filters(&can, &frame, &fifo, &match));
    can.fmr &= ~1u;
    assert_true(hil_can_match_filters(&can, &frame, &fifo, &match));
    assert_int_equal(fifo, 1);
    assert_int_equal(match, 0);
    frame.id = 0x124;
    assert_true(hil_can_match_filters(&can, &frame, &fifo, &match));
    assert_int_equal(fifo, 0);
    assert_int_equal(match, 1);
    frame.id = 0x6aa;
    assert_true(hil_can_match_filters(&can, &frame, &fifo, &match));
    assert_int_equal(match, 0);
    frame = (struct hil_can_frame){.id = 0x1abcdef, .is_extended = true};
    assert_true(hil_can_match_filters(&can, &frame, &fifo, &match));
    assert_int_equal(fifo, 1);
    assert_int_equal(match, 1);
    frame = (struct hil_can_frame){.id = 0x101};
    assert_false(hil_can_match_filters(&can, &frame, &fifo, &match));
}

/* What silicon ignores, or takes for more than was meant, ends the run. */
TEST(test_wrong_drivers)
{
    static const struct {
        uint32_t control;
        const char *reason;
    } cases[] = {
        {8, "BTR is written outside initialisation"},
        {16, "the value that was read is written back"},
        {32, "a priority in the lower four bits"},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct hil_board *board = bench_board("canbus", NULL);
        bench_control(board, 0, cases[i].control);
        bench_control(board, 1, 1);
        bench_control(board, 2, 0x100);
        assert_int_equal(hil_board_run_until(board, 5 * HIL_PS_PER_MS), MR_UNMODELLED);
        if (!strstr(hil_board_failure_reason(board), cases[i].reason))
            fail_msg("%s: %s", cases[i].reason, hil_board_failure_reason(board));
        hil_board_destroy(board);
    }
}
