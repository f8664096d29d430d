/* How the firmware starts: pins that float until then, clocks that somebody else left on. */
#include <unicorn/unicorn.h>

#include "hil/board/board.h"
#include "hil/core/nvic.h"
#include "tests/hil/ear.h"

#define PORT_B 1u
#define PORT_D 3u
#define PORT_E 4u

static bool drives(const struct hil_board *board, unsigned port, unsigned pin)
{
    enum hil_pin_mode mode = hil_gpio_mode(&board->mcu.gpio, port, pin);
    return mode == HIL_PIN_OUTPUT || mode == HIL_PIN_ALTERNATE;
}

/* Without a crystal the wait for it takes 100 ms: the lamp, the shunts' relay, the camera and the
 * memory's select must not float so long. */
TEST(outputs_are_driven_before_the_crystal_is_waited_for)
{
    struct hil_options options = ear_options();
    options.hse_hz = 0;
    struct ear *ear = ear_open(&options, 0);
    assert_int_equal(hil_board_run_until(ear->board, 15 * HIL_PS_PER_MS), MR_OK);
    assert_int_equal(ear->board->core.state.clock.hclk_hz, 16000000);
    for (unsigned pin = 0; pin < 3; pin++)
        assert_true(drives(ear->board, PORT_E, pin));
    for (unsigned pin = 12; pin < 16; pin++)
        assert_true(pin == 14 || drives(ear->board, PORT_B, pin));
    assert_true(hil_gpio_level(&ear->board->mcu.gpio, PORT_B, 12)); /* not selected */
    assert_false(
        hil_gpio_level(&ear->board->mcu.gpio, PORT_E, 0)); /* a board that is not up warns */
    ear_close(ear);
}

/* The same clocks, and the same board, as after a reset. PLLCFGR cannot be written while the PLL
 * runs (RM0090 7.3.2): the emulated board ends with a message where that is tried. */
TEST(clocks_left_on_by_another_program_are_taken_back)
{
    struct hil_options options = ear_options();
    options.has_clocks_left_on = true;
    struct ear *ear = ear_open(&options, 0);
    assert_int_equal(ear->board->core.state.clock.hclk_hz, 168000000);
    if (hil_board_run_until(ear->board, 300 * HIL_PS_PER_MS) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(ear->board));
    assert_int_equal(ear->board->core.state.clock.hclk_hz, 168000000);
    assert_true(ear->heard[EAR_CAN][MR_ID_HELLO] > 0);
    struct mr_hello hello;
    assert_int_equal(mr_hello_get(&hello, ear->last[EAR_CAN][MR_ID_HELLO], MR_MESSAGE_BYTES_MAX),
                     MR_OK);
    assert_int_equal(hello.clock_source, MR_CLOCK_CRYSTAL);
    ear_close(ear);
}

/* The internal oscillator may be 8 % slow or 4.5 % fast, and the crystal still be the right one.
 * Another one is named, and nothing runs from it: 12 MHz would drive the PLL to 504 MHz, which ends
 * the emulated board. */
TEST(another_crystal_is_recognised)
{
    static const struct {
        uint32_t hse_hz;
        int32_t hsi_ppm;
        int told_mhz; /* -1: it is taken */
    } cases[] = {
        {8000000, 0, -1},  {8000000, -49999, -1}, {8000000, 45000, -1},
        {4000000, 0, 4},   {10000000, 0, 10},     {12000000, 0, 12},
        {16000000, 0, 16}, {25000000, 0, 25},     {26000000, 0, 26},
        {0, 0, 0},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct hil_options options = ear_options();
        options.hse_hz = cases[i].hse_hz;
        options.hsi_error_ppm = cases[i].hsi_ppm;
        struct ear *ear = ear_open(&options, 0);
        if (hil_board_run_until(ear->board, 400 * HIL_PS_PER_MS) != MR_OK)
            fail_msg("%u Hz: %s", cases[i].hse_hz, hil_board_failure_reason(ear->board));
        bool taken = cases[i].told_mhz < 0;
        print_message("# %u Hz, HSI %d ppm: clock %u, fault %u\n", cases[i].hse_hz,
                      cases[i].hsi_ppm, ear_hello(ear, EAR_SERIAL).clock_source,
                      ear->fault[MR_FAULT_CLOCK_FALLBACK].detail);
        assert_int_equal(ear_hello(ear, EAR_SERIAL).clock_source,
                         taken ? MR_CLOCK_CRYSTAL : MR_CLOCK_INTERNAL_PLL);
        assert_int_equal(ear_faults(ear, EAR_SERIAL) & EAR_BIT(CLOCK_FALLBACK),
                         taken ? 0 : EAR_BIT(CLOCK_FALLBACK));
        if (!taken)
            assert_int_equal(ear->fault[MR_FAULT_CLOCK_FALLBACK].detail, cases[i].told_mhz);
        ear_close(ear);
    }
}

/* The ROM's interrupts take their vectors from address 0. */
TEST(the_boot_rom_finds_its_vectors_at_0)
{
    struct ear *ear = ear_open(NULL, 0);
    uint32_t at_zero[2], of_rom[2];
    assert_int_equal(hil_board_run_until(ear->board, 300 * HIL_PS_PER_MS), MR_OK);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_BOOTROM, 0, 1);
    if (hil_board_run_until(ear->board, 700 * HIL_PS_PER_MS) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(ear->board));
    assert_int_equal(hil_board_peek(ear->board, 0, at_zero, sizeof at_zero), MR_OK);
    assert_int_equal(hil_board_peek(ear->board, 0x1fff0000u, of_rom, sizeof of_rom), MR_OK);
    assert_int_equal(ear->board->core.state.clock.hclk_hz, 24000000);
    assert_memory_equal(at_zero, of_rom, sizeof of_rom);
    ear_close(ear);
}

/* APB at 42 and 84 MHz at most: its prescalers are in force before HCLK is 168 MHz, and in nothing
 * but one write they cannot be. RM0090 7.3.3 */
TEST(prescalers_come_before_the_clock)
{
    struct ear *ear = ear_open(NULL, 0);
    const struct hil_core_state *core = &ear->board->core.state;
    bool before = false;
    bench_run(ear->board, 2 * HIL_PS_PER_MS);
    for (uint64_t at_ps = 2 * HIL_PS_PER_MS; core->clock.hclk_hz == 16000000; at_ps += 62500) {
        assert_true(at_ps < 10 * HIL_PS_PER_MS);
        bench_run(ear->board, at_ps);
        before |= core->clock.hclk_hz == 16000000 &&
                  (ear->board->state.mcu.rcc.cfgr & 0xfc00u) == (4u << 13 | 5u << 10);
    }
    assert_true(before);
    ear_close(ear);
}

/* A PLL that does not lock, for a second, at the slowest watchdog: the reset tries again. */
TEST(a_start_that_hangs_ends_in_a_reset)
{
    struct hil_options options = ear_options();
    options.lsi_hz = 17000;
    struct ear *ear = ear_open(&options, 0);
    for (uint64_t t_us = 100; t_us < 1000000; t_us += 100) {
        hil_event_set_ps(&ear->board->core, HIL_EVENT_PLL, HIL_NEVER);
        bench_run(ear->board, t_us * HIL_PS_PER_US);
    }
    assert_int_equal(hil_board_counters(ear->board)->watchdog_resets, 1);
    bench_run(ear->board, 3 * HIL_PS_PER_S);
    assert_int_equal(ear_hello(ear, EAR_CAN).clock_source, MR_CLOCK_CRYSTAL);
    assert_int_equal(ear_hello(ear, EAR_CAN).reset_cause & 8u, 8u);
    ear_close(ear);
}

/* The longest start, that without a crystal, and the fastest watchdog: none. A debugger that halts
 * the core stops the watchdog, and the timers of the samples with it (RM0090 38.16.4: bits 12, 2,
 * 0). */
TEST(no_start_takes_too_long)
{
    struct hil_options options = ear_options();
    options.lsi_hz = 47000;
    options.hse_hz = 0;
    struct ear *ear = ear_open(&options, 0);
    bench_run(ear->board, 2 * HIL_PS_PER_S);
    assert_int_equal(hil_board_counters(ear->board)->resets, 0);
    assert_int_equal(ear->board->core.state.scb.apb1_fz, 1u << 12 | 1u << 2 | 1u << 0);
    ear_close(ear);
}

/* The boot ROM's Go and a debugger start the program, and no reset: with interrupts masked, on
 * another stack, with an interrupt that the program does not know enabled, and one that waits. */
TEST(what_another_program_left_in_the_core_is_taken_back)
{
    enum { MASKED, OTHER_STACK, PENDING, WAYS };
    for (unsigned way = 0; way < WAYS; way++) {
        struct ear *ear = ear_open(NULL, 0);
        struct hil_core *core = &ear->board->core;
        uint32_t one = 1, two = 2, away = 0x10000100u;
        unsigned tim2 = 16u + HIL_IRQ_TIM2;
        if (way == MASKED) {
            uc_reg_write(core->uc, UC_ARM_REG_PRIMASK, &one);
        } else if (way == OTHER_STACK) {
            uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &two);
            uc_reg_write(core->uc, UC_ARM_REG_SP, &away);
        } else {
            core->state.nvic.enabled[tim2 / 32u] |= 1u << tim2 % 32u;
            core->state.nvic.pending[15 / 32u] |= 1u << 15;
            uc_reg_write(core->uc, UC_ARM_REG_PRIMASK, &one);
        }
        bench_run(ear->board, HIL_PS_PER_S);
        uint32_t control = 0;
        uc_reg_read(core->uc, UC_ARM_REG_CONTROL, &control);
        assert_int_equal(control & 2u, 0);
        assert_int_equal(core->state.nvic.enabled[tim2 / 32u] >> tim2 % 32u & 1u, 0);
        assert_int_equal(hil_board_counters(ear->board)->resets, 0);
        assert_true(ear->heard[EAR_CAN][MR_ID_CLOCK] > 5);
        assert_int_equal(ear_faults(ear, EAR_CAN), 0);
        ear_close(ear);
    }
}
