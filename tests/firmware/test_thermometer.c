/* The thermometer's steps against a bus that answers, does not, or is stuck; readings by the
 * TMP112's own table (SBOS473). */
#include <math.h>

#include "tests/firmware/fake_i2c.h"
#include "tests/firmware/play.h"

#include "firmware/health.h"

static struct thermometer thermometer;
static uint32_t now;

static int begin(void **state)
{
    (void)state;
    fake_i2c_reset();
    thermometer_start(&thermometer);
    now = 0;
    return 0;
}

/* A second from the present block on; the reading told in it. */
static float second(void)
{
    float told = -1000.0f;
    for (unsigned n = 0; n < 1000; n++) {
        if (thermometer_on_block(&thermometer, now++, true)) {
            assert_true(told == -1000.0f); /* once */
            told = thermometer.temperature_c;
        }
    }
    assert_true(told != -1000.0f);
    return told;
}

static unsigned faults(void)
{
    return health_get_counter(MR_FAULT_THERMOMETER).count;
}

/* 12-bit temperature data format; the first row saturates there. */
TEST(counts_are_the_data_sheets)
{
    static const struct {
        uint16_t counts;
        double celsius;
    } format[] = {{0x7ff, 127.9375}, {0x640, 100.0},   {0x500, 80.0},  {0x4b0, 75.0},
                  {0x320, 50.0},     {0x190, 25.0},    {0x004, 0.25},  {0x001, 0.0625},
                  {0x000, 0.0},      {0xfff, -0.0625}, {0xffc, -0.25}, {0xe70, -25.0},
                  {0xc90, -55.0}};
    for (size_t i = 0; i < sizeof format / sizeof format[0]; i++) {
        uint8_t bytes[2] = {(uint8_t)(format[i].counts >> 4), (uint8_t)(format[i].counts << 4)};
        assert_true((double)thermometer_celsius(bytes) == format[i].celsius);
    }
}

TEST_IN(one_reading_a_second, begin, NULL)
{
    unsigned before = faults();
    assert_true((double)second() == 20.0);
    assert_near(thermometer.error_c, 0.289, 0.001); /* 0.5 C over the root of 3 */
    fake_i2c.temperature = 0xf670;                  /* -9.5625 */
    assert_true((double)second() == -9.5625);
    assert_near(thermometer.error_c, 0.577, 0.001);
    fake_i2c.temperature = 0x4600; /* 70 C */
    assert_true((double)second() == 70.0);
    assert_near(thermometer.error_c, 0.577, 0.001);
    assert_int_equal(fake_i2c.conversions, 3);
    assert_int_equal(faults(), before);
}

/* What the register holds after power-up is no temperature, and a conversion that does not end
 * gives none. */
TEST_IN(zero_of_power_up_is_not_told, begin, NULL)
{
    unsigned before = faults();
    fake_i2c.never_ready = 1;
    assert_true(isnan(second()));
    assert_int_equal(faults(), before + 1);
    assert_true((double)second() == 20.0);
    fake_i2c.config = 0x60; /* it lost its supply: converts by itself, and reads 0 again */
    fake_i2c.converted = 0;
    assert_true(isnan(second()));
    assert_int_equal(faults(), before + 2);
    assert_true((double)second() == 20.0);
}

TEST_IN(what_fails_is_missing_and_comes_back, begin, NULL)
{
    static const struct {
        enum fake_i2c_fault fault;
        unsigned detail;
    } cases[] = {{FAKE_I2C_DEAD, THERMOMETER_NO_ANSWER}, {FAKE_I2C_STUCK, THERMOMETER_BUS_STUCK}};
    for (unsigned i = 0; i < 2; i++) {
        assert_true((double)second() == 20.0);
        unsigned before = faults();
        fake_i2c.fault = cases[i].fault;
        for (unsigned n = 1; n <= 5; n++) {
            assert_true(isnan(second()));
            struct health_counter counter = health_get_counter(MR_FAULT_THERMOMETER);
            assert_int_equal(counter.count, before + n);
            assert_int_equal(counter.detail, cases[i].detail);
        }
        fake_i2c.fault = FAKE_I2C_GOOD;
    }
    assert_true((double)second() == 20.0);
    fake_i2c.address = 0x49; /* another part is fitted */
    assert_true(isnan(second()));
    assert_int_equal(health_get_counter(MR_FAULT_THERMOMETER).detail, THERMOMETER_NO_ANSWER);
}

TEST_IN(out_of_range, begin, NULL)
{
    /* 127.9 C, -55.1 C, a bit that is always 0 */
    static const uint16_t wrong[] = {0x7ff0, 0xc8f0, 0x1908};
    for (unsigned i = 0; i < 3; i++) {
        fake_i2c.temperature = wrong[i];
        assert_true(isnan(second()));
        assert_int_equal(health_get_counter(MR_FAULT_THERMOMETER).detail, THERMOMETER_OUT_OF_RANGE);
    }
    fake_i2c.temperature = 0xc900; /* -55 */
    assert_true((double)second() == -55.0);
}

TEST_IN(not_fitted_costs_nothing, begin, NULL)
{
    for (unsigned n = 0; n < 3000; n++)
        assert_false(thermometer_on_block(&thermometer, n, false));
    assert_int_equal(fake_i2c.starts + fake_i2c.transfers, 0);
    now = 3000;
    (void)second();
    assert_int_equal(fake_i2c.starts, 1);
    assert_false(thermometer_on_block(&thermometer, now, false));
    assert_int_equal(fake_i2c.stops, 1);
}

/* Through the application: message, and with a landing also in its record. */
TEST(it_is_told)
{
    struct mr_temperature temperature;
    start(NULL);
    fake_i2c_reset();
    fake_i2c.temperature = 0xffc0; /* -0.25 */
    play(3000);
    assert_int_equal(count_frames(MR_ID_TEMPERATURE), 3);
    GET_LAST(temperature, TEMPERATURE, &temperature);
    assert_true((double)temperature.temperature_c == -0.25);
    assert_near(temperature.error_c, 0.577, 0.001);
    assert_int_equal(temperature.block, 2453);
    fake_i2c.fault = FAKE_I2C_DEAD;
    play(1000);
    GET_LAST(temperature, TEMPERATURE, &temperature);
    assert_true(isnan(temperature.temperature_c) && isnan(temperature.error_c));
}
