/* What a link has heard: rates by the lengths of bits, against a UART computed here bit by bit. */
#include "host/link/hearing.h"

#include <math.h>
#include <stdlib.h>

#include "tests/cmocka_all.h"

#define SENT 4000

/* Samples a line of random bytes, 8N1, `slower` samples a bit, and gives what a receiver makes of
 * it to the hearing. */
static void hear(struct hearing *hearing, double slower, int baud)
{
    static uint8_t bit[SENT * 11];
    size_t bits = 0;
    uint32_t dice = 12345;
    hearing_start(hearing, 0, baud);
    for (int i = 0; i < SENT; i++) {
        dice = dice * 1664525u + 1013904223u;
        bit[bits++] = 0;
        for (int k = 0; k < 8; k++)
            bit[bits++] = dice >> (24 - k) & 1u;
        bit[bits++] = 1;
        bit[bits++] = 1;
    }
    double step = 1.0 / slower, at = 0.0;
    while (at + 10.0 * step < (double)bits) {
        if (bit[(size_t)at]) { /* idle */
            at = floor(at) + 1.0;
            continue;
        }
        uint8_t byte = 0;
        for (int k = 0; k < 8; k++)
            byte = (uint8_t)(byte | bit[(size_t)(at + (k + 1.5) * step)] << k);
        bool framed = bit[(size_t)(at + 9.5 * step)];
        hearing_bytes(hearing, &byte, 1);
        at += 9.5 * step;
        while (!framed && at < (double)bits && !bit[(size_t)at])
            at = floor(at) + 1.0;
    }
}

static void slower_senders_are_named(void **state)
{
    static const struct {
        int sender, receiver;
    } cases[] = {{1000000, 2000000}, {921600, 2000000}, {115200, 230400},
                 {460800, 921600},   {500000, 1500000}, {460800, 2000000}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct hearing hearing;
        int near[HEARING_USUAL];
        hear(&hearing, (double)cases[i].receiver / cases[i].sender, cases[i].receiver);
        double slower = hearing_times_slower(&hearing);
        unsigned count = hearing_usual_near(cases[i].receiver, slower, near);
        bool named = false;
        for (unsigned k = 0; k < count; k++)
            named |= near[k] == cases[i].sender;
        if (!named)
            print_error("%d heard at %d: %.2f times slower\n", cases[i].sender, cases[i].receiver,
                        slower);
        assert_true(named);
        assert_int_equal(hearing.frames, 0);
    }
}

static void much_slower_and_not_slower(void **state)
{
    struct hearing hearing;
    (void)state;
    hear(&hearing, 17.36, 2000000);
    assert_true(isinf(hearing_times_slower(&hearing)));
    hear(&hearing, 1.0, 2000000);
    assert_true(hearing_times_slower(&hearing) == 1.0);
    hear(&hearing, 115200.0 / 2000000.0, 115200);
    assert_true(hearing_times_slower(&hearing) == 1.0);
}

static void too_little_says_nothing(void **state)
{
    struct hearing hearing;
    const uint8_t few[20] = {0};
    (void)state;
    hearing_start(&hearing, 0, 2000000);
    hearing_bytes(&hearing, few, sizeof few);
    assert_true(hearing_times_slower(&hearing) == 0.0);
}

static void a_frame_is_one(void **state)
{
    struct hearing hearing;
    uint8_t frame[MR_FRAME_MAX];
    (void)state;
    hearing_start(&hearing, 0, 2000000);
    size_t size = mr_frame_encode(7, 0x1f0, (const uint8_t *)"12345678", 8, frame);
    hearing_bytes(&hearing, frame, size);
    assert_int_equal(hearing.frames, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slower_senders_are_named),
        cmocka_unit_test(much_slower_and_not_slower),
        cmocka_unit_test(too_little_says_nothing),
        cmocka_unit_test(a_frame_is_one),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
