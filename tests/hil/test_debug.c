/* The core under a debugger: it does the same as without, holds where asked, shows and takes registers and
 * memory. */
#include "hil/debug.h"
#include "tests/hil/bench.h"

#define SRAM 0x20000000u
#define SRAM_BYTES 0x20000u
#define FIRMWARE "build/firmware/matrig.elf"

static struct hil_board *firmware_board(void)
{
    struct hil_options options;
    hil_options_default(&options);
    struct hil_board *board = hil_board_create(&options);
    if (hil_board_load_elf(board, FIRMWARE) != MR_OK)
        fail_msg("%s", hil_board_reason(board));
    return board;
}

static void assert_same(struct hil_board *a, struct hil_board *b)
{
    static uint8_t of_a[SRAM_BYTES], of_b[SRAM_BYTES];
    assert_int_equal(hil_board_now_cycles(a), hil_board_now_cycles(b));
    assert_memory_equal(hil_board_counters(a), hil_board_counters(b), sizeof(struct hil_counters));
    hil_board_peek(a, SRAM, of_a, sizeof of_a);
    hil_board_peek(b, SRAM, of_b, sizeof of_b);
    assert_memory_equal(of_a, of_b, sizeof of_a);
    for (unsigned i = 0; i <= 17; i++)
        assert_int_equal(hil_board_register(a, i), hil_board_register(b, i));
}

/* Single steps all the way: as the board runs alone, to the last bit. */
static void stepped_equals_run(struct hil_board *alone, struct hil_board *stepped, uint64_t from_ps,
                               uint64_t to_ps, bool into, unsigned at_least)
{
    struct hil_debug debug;
    unsigned steps = 0;
    bench_run(alone, from_ps);
    bench_run(stepped, from_ps);
    hil_debug_attach(stepped, &debug);
    debug.step_into_interrupts = into;
    for (; hil_board_now_ps(stepped) < to_ps; steps++) {
        hil_debug_step(stepped, 0, 0);
        bench_run(stepped, to_ps);
    }
    assert_in_range(steps, at_least, UINT32_MAX);
    hil_debug_detach(stepped);
    bench_run(stepped, to_ps + 5 * HIL_MS_PS); /* a block it was in is finished */
    bench_run(alone, to_ps + 5 * HIL_MS_PS);
    assert_same(alone, stepped);
}

static void test_steps_change_nothing(void **state)
{
    static const char *const images[] = {"core", "serial", "canbus"};
    (void)state;
    for (unsigned i = 0; i < sizeof images / sizeof images[0]; i++) {
        struct hil_board *alone = bench_board(images[i], NULL), *stepped = bench_board(images[i], NULL);
        stepped_equals_run(alone, stepped, 0, HIL_MS_PS / 4, i != 1, 500);
        hil_board_destroy(alone);
        hil_board_destroy(stepped);
    }
    struct hil_board *alone = firmware_board(), *stepped = firmware_board();
    stepped_equals_run(alone, stepped, 20 * HIL_MS_PS, 23 * HIL_MS_PS, true, 10000);
    hil_board_destroy(alone);
    hil_board_destroy(stepped);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_steps_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
