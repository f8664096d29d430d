/* How the firmware starts: pins that float until then, clocks that somebody else left on. */
#include "hil/board/board.h"
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
    assert_int_equal(hil_board_run_until(ear->board, 15 * HIL_MS_PS), MR_OK);
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
    options.left_on = true;
    struct ear *ear = ear_open(&options, 0);
    assert_int_equal(ear->board->core.state.clock.hclk_hz, 168000000);
    if (hil_board_run_until(ear->board, 300 * HIL_MS_PS) != MR_OK)
        fail_msg("%s", hil_board_reason(ear->board));
    assert_int_equal(ear->board->core.state.clock.hclk_hz, 168000000);
    assert_true(ear->heard[EAR_CAN][MR_ID_HELLO] > 0);
    struct mr_hello hello;
    assert_int_equal(mr_hello_get(&hello, ear->last[EAR_CAN][MR_ID_HELLO], MR_MESSAGE_MAX), MR_OK);
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
        if (hil_board_run_until(ear->board, 400 * HIL_MS_PS) != MR_OK)
            fail_msg("%u Hz: %s", cases[i].hse_hz, hil_board_reason(ear->board));
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
    assert_int_equal(hil_board_run_until(ear->board, 300 * HIL_MS_PS), MR_OK);
    ear_command(ear, EAR_SERIAL, MR_COMMAND_BOOTROM, 0, 1);
    if (hil_board_run_until(ear->board, 700 * HIL_MS_PS) != MR_OK)
        fail_msg("%s", hil_board_reason(ear->board));
    assert_int_equal(hil_board_peek(ear->board, 0, at_zero, sizeof at_zero), MR_OK);
    assert_int_equal(hil_board_peek(ear->board, 0x1fff0000u, of_rom, sizeof of_rom), MR_OK);
    assert_int_equal(ear->board->core.state.clock.hclk_hz, 24000000);
    assert_memory_equal(at_zero, of_rom, sizeof of_rom);
    ear_close(ear);
}
