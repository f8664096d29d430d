/* Times at pins: what the firmware's drivers do against what the chips around the board demand. */
#include "tests/hil/pin_times.h"
#include "hil/symbols.h"
#include "tests/hil/ear.h"

#define PORT_B       1u
#define CYCLE_NS     62.5 /* of 16 MHz */
#define FAST_NS      4.0  /* slew at OSPEEDR 3 */
#define USED_SECTORS 4u   /* erased in half a second */

/* What outside chips demand of pins that the firmware drives itself. */
static const struct hil_pin_rule rules[] = {
    {"black box /CS high", PORT_B, 12, true, 50.0,
     "W25Q128JV data sheet rev. F, 9.6: tSHSL2, before and after an erase, program or status"},
};
enum { SELECT, RULES };

/* An image that stores at known distances. */
static void each_store_is_placed_at_its_instruction(void **state)
{
    static const double cycles[] = {5, 1, 4, 30};
    static struct hil_pin_times times;
    (void)state;
    for (unsigned round = 0; round < 5; round++) {
        unsigned least = round ? round - 1u : 0; /* the first learns */
        struct hil_pin_rule rule = {
            "a pin", PORT_B, 12, true, cycles[least] * CYCLE_NS - FAST_NS, "this test"};
        struct hil_board *board = bench_board("pins", NULL);
        hil_pin_times_watch(board, &times, &rule, 1);
        bench_run(board, HIL_MS_PS);
        assert_int_equal(bench_result(board, 0), 1);
        if (!round) {
            assert_int_equal(times.of[0].pulses, 0);
            assert_int_equal(times.unlocated, 9); /* low, then four times high and low */
            hil_board_destroy(board);
            continue;
        }
        assert_int_equal(times.unlocated, 0);
        assert_int_equal(times.of[0].pulses, 4);
        assert_near(times.of[0].shortest_ns, CYCLE_NS - FAST_NS, 1e-6);
        assert_near(times.of[0].slew_ns, FAST_NS, 0);
        assert_int_equal(times.of[0].end_pc - times.of[0].begin_pc, 2);
        unsigned shorter = 0;
        for (unsigned i = 0; i < 4; i++)
            shorter += cycles[i] < cycles[least];
        assert_int_equal(times.of[0].too_short, shorter);
        hil_board_destroy(board);
    }
}

static void tell_function(uint32_t pc, char *text, size_t size)
{
    struct mr_symbols symbols;
    char error[256];
    assert_int_equal(hil_symbols_read(&symbols, EAR_ELF, error, sizeof error), MR_OK);
    const struct mr_symbol *symbol = mr_symbols_at(&symbols, pc);
    snprintf(text, size, "%s (0x%08x)", symbol ? symbol->name : "?", (unsigned)pc);
    hil_symbols_free(&symbols);
}

static void check_rules(const struct hil_pin_times *times, const char *when,
                        uint64_t pulses_at_least)
{
    assert_int_equal(times->unlocated, 0);
    for (unsigned i = 0; i < times->count; i++) {
        const struct hil_pin_rule *rule = &times->rules[i];
        const struct hil_pin_time *time = &times->of[i];
        char begin[80], end[80];
        tell_function(time->begin_pc, begin, sizeof begin);
        tell_function(time->end_pc, end, sizeof end);
        print_message("# %s, %s: %llu pulses, %llu too short; the shortest %.1f ns of %.0f, slew "
                      "of %.0f ns taken off, from %s to %s\n",
                      when, rule->name, (unsigned long long)time->pulses,
                      (unsigned long long)time->too_short, time->shortest_ns, rule->least_ns,
                      time->slew_ns, begin, end);
        if (time->too_short)
            fail_msg("%s lasts %.1f ns, less than the %.0f ns of %s", rule->name, time->shortest_ns,
                     rule->least_ns, rule->source);
        assert_true(time->pulses >= pulses_at_least);
    }
}

/* Everything that the black box does: looks for its chip, reads, erases a used chip, programs
 * through a landing, tells itself. */
static struct ear *work_the_black_box(const struct hil_options *options,
                                      struct hil_pin_times *times)
{
    static uint8_t used[HIL_NOR_SECTOR];
    struct ear *ear = ear_open(options, 5);
    memset(used, 0x5a, sizeof used);
    for (uint32_t sector = 0; sector < USED_SECTORS; sector++)
        hil_w25q_poke(&ear->board->w25q, sector * HIL_NOR_SECTOR, used, sizeof used);
    if (times)
        hil_pin_times_watch(ear->board, times, rules, RULES);
    ear_until(ear, 1.0);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_SELF_TEST, 0, 1);
    ear_until(ear, 3.0);
    return ear;
}

static void the_black_box_is_deselected_long_enough(void **state)
{
    static struct hil_pin_times times;
    struct hil_options options = ear_options();
    (void)state;
    ear_close(work_the_black_box(&options, &times));
    ear_close(work_the_black_box(&options, &times));
    check_rules(&times, "crystal", 1000);
}

/* The internal oscillator, 1 % fast here; its data sheet allows 4.5 % (ACC_HSI). */
static void also_on_the_internal_oscillator(void **state)
{
    static struct hil_pin_times times;
    struct hil_options options = ear_options();
    (void)state;
    options.hse_hz = 0;
    options.hsi_error_ppm = 10000;
    ear_close(work_the_black_box(&options, &times));
    ear_close(work_the_black_box(&options, &times));
    check_rules(&times, "internal oscillator", 1000);
    const struct hil_pin_time *select = &times.of[SELECT];
    double at_fastest_ns = (select->shortest_ns + select->slew_ns) * 1.01 / 1.045 - select->slew_ns;
    print_message("# %.1f ns when that oscillator is 4.5 %% fast\n", at_fastest_ns);
    assert_true(at_fastest_ns >= rules[SELECT].least_ns);
}

static void watching_changes_nothing(void **state)
{
    static struct hil_pin_times times;
    struct hil_options options = ear_options();
    struct ear *alone = work_the_black_box(&options, NULL), *watched = NULL;
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        watched = work_the_black_box(&options, &times);
        assert_int_equal(hil_board_now_cycles(alone->board), hil_board_now_cycles(watched->board));
        assert_memory_equal(hil_board_counters(alone->board), hil_board_counters(watched->board),
                            sizeof(struct hil_counters));
        assert_memory_equal(alone->heard, watched->heard, sizeof alone->heard);
        assert_memory_equal(alone->last, watched->last, sizeof alone->last);
        ear_close(watched);
    }
    assert_true(times.of[SELECT].pulses > 1000);
    ear_close(alone);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_store_is_placed_at_its_instruction),
        cmocka_unit_test(the_black_box_is_deselected_long_enough),
        cmocka_unit_test(also_on_the_internal_oscillator),
        cmocka_unit_test(watching_changes_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
