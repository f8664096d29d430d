/* What Linux tells beside a CAN frame, the board's filters as the kernel applies them, and an
 * adapter's own clock. */
#include <string.h>
#include <time.h>

#include <linux/errqueue.h> /* wants time.h before itself */

#include "host/link/can.h"
#include "tests/cmocka_all.h"

/* A message with one thing beside it, as recvmsg(2) leaves it: length, level and type by hand. */
static struct msghdr beside(uint8_t *room, int type, const void *data, size_t length)
{
    struct cmsghdr head = {
        .cmsg_len = sizeof head + length, .cmsg_level = SOL_SOCKET, .cmsg_type = type};
    memcpy(room, &head, sizeof head);
    memcpy(room + sizeof head, data, length);
    return (struct msghdr){.msg_control = room, .msg_controllen = sizeof head + length};
}

TEST(stamps_of_both_kinds)
{
    _Alignas(8) uint8_t room[CAN_CONTROL_BYTES];
    struct can_control control;
    struct timespec at = {.tv_sec = 1700000000, .tv_nsec = 123456789};
    struct scm_timestamping both = {.ts = {{1700000001, 500}, {9, 9}, {77, 250000999}}};
    struct msghdr message = beside(room, SO_TIMESTAMPNS, &at, sizeof at);
    can_control_take(&message, &control);
    assert_true(control.kernel_us == 1700000000123456u && control.hardware_us == 0 &&
                !control.lost_known);
    message = beside(room, SO_TIMESTAMPING, &both, sizeof both);
    can_control_take(&message, &control);
    assert_true(control.kernel_us == 1700000001000000u && control.hardware_us == 77250000u);
    memset(&both.ts[2], 0, sizeof both.ts[2]); /* an adapter without a clock */
    message = beside(room, SO_TIMESTAMPING, &both, sizeof both);
    can_control_take(&message, &control);
    assert_true(control.kernel_us == 1700000001000000u && control.hardware_us == 0);
    message = beside(room, SO_TIMESTAMPING, &both, 8); /* cut off */
    can_control_take(&message, &control);
    assert_true(control.kernel_us == 0 && control.hardware_us == 0);
}

TEST(what_the_queue_lost)
{
    _Alignas(8) uint8_t room[CAN_CONTROL_BYTES];
    struct can_control control;
    uint32_t lost = 0xfffffffeu;
    struct msghdr message = beside(room, SO_RXQ_OVFL, &lost, sizeof lost);
    can_control_take(&message, &control);
    assert_true(control.lost_known && control.lost == 0xfffffffeu && control.kernel_us == 0);
    message = (struct msghdr){0};
    can_control_take(&message, &control);
    assert_true(!control.lost_known);
}

/* can.rst: a filter passes what has (received & mask) == (filter & mask). */
static bool passes(const struct can_filter *filters, size_t count, uint32_t id)
{
    for (size_t i = 0; i < count; i++) {
        if ((id & filters[i].can_mask) == (filters[i].can_id & filters[i].can_mask))
            return true;
    }
    return false;
}

TEST(filters_pass_the_board)
{
    struct can_filter filters[512]; /* the kernel takes no more */
    size_t count = can_board_filters(0, filters, 512);
    /* alarms, landing, edges, readings, health, configuration, commands; then others, and what
     * cannot be of a board */
    static const uint32_t board[] = {0x070, 0x080, 0x0a0, 0x0e0, 0x100, 0x102,
                                     0x110, 0x114, 0x180, 0x1f0, 0x1fd, 0x400};
    static const uint32_t others[] = {
        0x001, 0x123, 0x555, 0x7ff, 0x300, 0x301, 0x100 | CAN_EFF_FLAG, 0x100 | CAN_RTR_FLAG};
    assert_true(count > 50 && count < 512);
    for (size_t i = 0; i < sizeof board / sizeof board[0]; i++) {
        if (!passes(filters, count, board[i]))
            fail_msg("%03x does not pass", board[i]);
    }
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        if (passes(filters, count, others[i]))
            fail_msg("%08x passes", others[i]);
    }
    assert_int_equal(can_board_filters(0, filters, 3), 3);
    assert_int_equal(can_board_filters(0x190, filters, 512), count);
    assert_true(passes(filters, count, 0x590) && passes(filters, count, 0x380));
    assert_true(!passes(filters, count, 0x400) && !passes(filters, count, 0x300));
}

/* An adapter whose clock is 100 ppm fast; frames every millisecond reach the host 200 us later at
 * least, mostly 20 ms at most, and all of them a second late for half a second. What is stamped is
 * right to those 200 us and what the clocks drift apart in 10 s. */
TEST(an_adapters_clock)
{
    struct adapter_clock clock = {0};
    uint32_t random = 1;
    for (uint64_t ms = 0; ms < 60000; ms++) {
        uint64_t truth_us = 5000000000u + 1000 * ms, adapter_us = 777 + 1000 * ms + ms / 10;
        random = random * 1664525u + 1013904223u;
        uint64_t delay_us = 200 + (random >> 24 < 16 ? 0 : (random >> 8) % 20000) +
                            (ms >= 30000 && ms < 30500 ? 1000000 : 0);
        uint64_t at_us = adapter_clock_time(&clock, adapter_us, truth_us + delay_us);
        assert_true(at_us <= truth_us + delay_us);
        if (ms > 200 && (at_us < truth_us - 1000 || at_us > truth_us + 1400))
            fail_msg("%llu ms: off by %lld us", (unsigned long long)ms,
                     (long long)(at_us - truth_us));
    }
}

TEST(an_adapter_that_begins_again)
{
    struct adapter_clock clock = {0};
    adapter_clock_time(&clock, 9000000, 100000000);
    assert_true(adapter_clock_time(&clock, 9001000, 100001500) == 100001000);
    assert_true(adapter_clock_time(&clock, 5000, 107000000) == 107000000);
    assert_true(adapter_clock_time(&clock, 6000, 107001700) == 107001000);
}
