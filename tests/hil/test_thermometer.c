/* The firmware's thermometer and slow log on the emulated board: readings against its truth, each
 * fault of the bus, what it costs. */
#include <math.h>

#include "hil/core/bus.h"
#include "hil/core/elf.h"
#include "tests/hil/ear.h"

#include "common/config.h"

#define MODER_B 0x40020400u
#define APB1ENR 0x40023840u

static float told_c(const struct ear *ear, unsigned link)
{
    struct mr_temperature message;
    assert_true(ear->heard[link][MR_ID_TEMPERATURE] > 0);
    assert_int_equal(
        mr_temperature_get(&message, ear->last[link][MR_ID_TEMPERATURE], MR_MESSAGE_BYTES_MAX),
        MR_OK);
    return message.temperature_c;
}

static struct ear *open_at(double temperature_c, double per_h)
{
    struct hil_options options = ear_options();
    options.temperature_c = temperature_c;
    options.temperature_c_per_h = per_h;
    return ear_open(&options, 0);
}

TEST(readings_follow_the_truth)
{
    static const double truth_c[] = {20.0, -0.0625, -17.8, 0.0, 54.3, 124.9};
    for (unsigned i = 0; i < sizeof truth_c / sizeof truth_c[0]; i++) {
        struct ear *ear = open_at(truth_c[i], 0.0);
        ear_until(ear, 1.9);
        assert_int_equal(ear->heard[EAR_CAN][MR_ID_TEMPERATURE], 2);
        assert_int_equal(ear->heard[EAR_SERIAL][MR_ID_TEMPERATURE], 2);
        assert_true(fabs((double)told_c(ear, EAR_CAN) - truth_c[i]) <= 0.0313);
        assert_true(told_c(ear, EAR_CAN) == told_c(ear, EAR_SERIAL));
        assert_int_equal(ear_faults(ear, EAR_SERIAL), 0);
        ear_close(ear);
    }
    struct ear *ear = open_at(10.0, 3600.0); /* a degree a second */
    ear_until(ear, 9.9);
    /* converted at 9.12 to 9.17 s by the board's blocks */
    assert_true(fabs((double)told_c(ear, EAR_CAN) - 19.18) < 0.05);
    ear_close(ear);
}

/* `order` at 1.6 s, mended at 4.6: nothing is told in between, `detail` is counted once a second,
 * and then it is there again. */
TEST(what_fails_is_told_and_comes_back)
{
    static const struct {
        const char *order;
        unsigned detail, missing;
    } cases[] = {
        {"thermometer dead", 1, 3},      {"thermometer stuck", 2, 3},
        {"thermometer hang", 2, 1},      {"thermometer stretch 50", 2, 1},
        {"thermometer stretch 5", 0, 0}, {"thermometer berr", 0, 0},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char order[128];
        unsigned missing = 0;
        struct ear *ear = open_at(21.5, 0.0);
        snprintf(order, sizeof order, "at 1.6 %s\nat 4.6 thermometer mend", cases[i].order);
        ear_order(ear, order);
        for (double t_s = 1.9; t_s < 7.0; t_s += 1.0) {
            ear_until(ear, t_s);
            float celsius = told_c(ear, EAR_SERIAL);
            missing += isnan(celsius) ? 1u : 0u;
            if (!isnan(celsius))
                assert_true((double)celsius == 21.5);
        }
        if (missing != cases[i].missing || ear->fault[MR_FAULT_THERMOMETER].count != missing ||
            ear->fault[MR_FAULT_THERMOMETER].detail != cases[i].detail)
            fail_msg("%s: %u readings missing, fault %u times, detail %u", cases[i].order, missing,
                     ear->fault[MR_FAULT_THERMOMETER].count,
                     ear->fault[MR_FAULT_THERMOMETER].detail);
        assert_true((double)told_c(ear, EAR_CAN) == 21.5);
        ear_close(ear);
    }
}

/* The firmware restarts while the chip is being read: the bus is found stuck, and clocked free. */
TEST(a_reset_while_it_is_read)
{
    struct ear *ear = open_at(0.0, 0.0); /* zeroes: SDA is low */
    bool seen = false;
    ear_until(ear, 1.0);
    for (unsigned n = 0; n < 1000000 && !seen; n++) {
        bench_run(ear->board, hil_board_now_ps(ear->board) + 20 * HIL_PS_PER_US);
        seen = ear->board->state.mcu.i2c.phase == HIL_I2C_RECEIVING &&
               ear->board->state.tmp112.register_pointer == 0;
    }
    assert_true(seen);
    hil_core_request_reset(&ear->board->core, 0);
    double t_s = (double)hil_board_now_ps(ear->board) * 1e-12;
    ear_until(ear, t_s + 0.001);
    assert_true(ear->board->state.tmp112.bus_faults.clocks_until_release > 0);
    ear_until(ear, t_s + 2.9);
    assert_int_equal(ear->fault[MR_FAULT_THERMOMETER].detail, 2);
    assert_int_equal(ear->fault[MR_FAULT_THERMOMETER].count, 1);
    assert_true((double)told_c(ear, EAR_CAN) == 0.0);
    ear_close(ear);
}

/* site.thermometer 0, in the image's own configuration. */
TEST(not_fitted_costs_nothing)
{
    uint32_t load, begin, place;
    uint8_t fitted = 0;
    uint64_t instructions[2];
    unsigned frames[2];
    for (unsigned with = 0; with < 2; with++) {
        struct ear *ear = open_at(20.0, 0.0);
        assert_int_equal(hil_elf_find_symbol(EAR_ELF, "data_load", &load), MR_OK);
        assert_int_equal(hil_elf_find_symbol(EAR_ELF, "data_start", &begin), MR_OK);
        assert_int_equal(hil_elf_find_symbol(EAR_ELF, "config", &place), MR_OK);
        place += load - begin + (uint32_t)offsetof(struct mr_config, site[0].thermometer);
        assert_int_equal(hil_board_peek(ear->board, place, &fitted, 1), MR_OK);
        assert_int_equal(fitted, 1); /* the built-in default */
        fitted = (uint8_t)with;
        assert_int_equal(hil_board_poke(ear->board, place, &fitted, 1), MR_OK);
        ear_until(ear, 1.0);
        uint64_t before = hil_board_counters(ear->board)->instructions;
        unsigned said = ear->can_frames - ear->heard[EAR_CAN][MR_ID_FAULT];
        ear_until(ear, 11.0);
        instructions[with] = hil_board_counters(ear->board)->instructions - before;
        frames[with] = ear->can_frames - ear->heard[EAR_CAN][MR_ID_FAULT] - said;
        assert_int_equal(hil_bus_read(&ear->board->core, APB1ENR, 4) >> 21 & 1u, with);
        assert_int_equal(hil_bus_read(&ear->board->core, MODER_B, 4) >> 12 & 15u, with ? 0xau : 0u);
        assert_int_equal(ear->heard[EAR_CAN][MR_ID_TEMPERATURE], with ? 11 : 0);
        /* the poke shows: another image */
        assert_int_equal(ear_faults(ear, EAR_SERIAL) & ~(with ? 0u : EAR_BIT(SELFTEST)), 0);
        ear_close(ear);
    }
    print_message("# thermometer: %lld instructions and %u CAN frames in 10 s\n",
                  (long long)(instructions[1] - instructions[0]), frames[1] - frames[0]);
    assert_int_equal(frames[1] - frames[0], 10);
}

/* A row a minute, on both links: temperature and means. */
TEST(a_row_a_minute)
{
    struct hil_options options = ear_options();
    options.temperature_c = 5.0;
    options.temperature_c_per_h = -300.0; /* 5 C a minute */
    struct ear *ear = ear_open(&options, 0);
    ear_until(ear, 61.0);
    for (unsigned link = 0; link < EAR_LINKS; link++) {
        struct mr_slow_row row;
        struct mr_slow_tension last;
        assert_int_equal(ear->heard[link][MR_ID_SLOW_ROW], 1);
        assert_int_equal(ear->heard[link][MR_ID_SLOW_TENSION], 5);
        assert_int_equal(
            mr_slow_row_get(&row, ear->last[link][MR_ID_SLOW_ROW], MR_MESSAGE_BYTES_MAX), MR_OK);
        assert_int_equal(
            mr_slow_tension_get(&last, ear->last[link][MR_ID_SLOW_TENSION], MR_MESSAGE_BYTES_MAX),
            MR_OK);
        assert_int_equal(row.block, 60000);
        assert_true(fabsf(row.temperature_c) < 0.15f);
        assert_int_equal(last.row, row.row);
        assert_int_equal(last.first, 13);
        assert_true(isfinite(last.a_lb) && isfinite(last.b_lb) && isnan(last.c_lb));
    }
    ear_close(ear);
}
