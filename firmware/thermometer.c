#include "firmware/thermometer.h"

#include "common/wire.h"
#include "firmware/health.h"
#include "firmware/board.h"
#include "firmware/schedule.h"

enum step { STEP_WAIT, STEP_SHUT_DOWN, STEP_CONVERT, STEP_CONVERTING, STEP_READ_STATUS, STEP_READ };

enum { REGISTER_TEMPERATURE = 0, REGISTER_CONFIG = 1 };
#define CONFIG_ONE_SHOT 0x80u /* upper byte: starts a conversion; reads 1 when it has ended */
#define CONFIG_UPPER    0x61u /* 12 bits; shut down */
/* lower byte as at power-up: 4 Hz (when not shut down), alert inactive, not extended */
#define CONFIG_LOWER    0xa0u
#define C_PER_COUNT     0.0625f
#define LOWEST_C        (-55.0f) /* lowest temperature in the range of the part */
#define HIGHEST_C       125.0f
/* Standard error: data sheet limits divided by the root of 3 (0.5 C between 0 and 65 C, 1 C
 * elsewhere). Rounding to 0.0625 C is negligible. */
#define ERROR_C         0.289f
#define ERROR_OUTSIDE_C 0.577f

float thermometer_celsius(const uint8_t bytes[2])
{
    int16_t word = (int16_t)(bytes[0] << 8 | bytes[1]);
    return (float)(word / 16) * C_PER_COUNT; /* the lower four bits are 0 */
}

static void discard_reading(struct thermometer *t)
{
    t->temperature_c = MR_NAN;
    t->error_c = MR_NAN;
}

void thermometer_start(struct thermometer *t)
{
    *t = (struct thermometer){.step = STEP_WAIT};
    discard_reading(t);
    t->last_temperature_c = MR_NAN;
}

static void begin_transfer(struct thermometer *t, enum step step, uint32_t index, unsigned bytes,
                           unsigned answer)
{
    t->step = step;
    t->step_block = index;
    i2c_begin(THERMOMETER_ADDRESS, t->tx_bytes, bytes, t->rx_bytes, answer);
}

static void write_config(struct thermometer *t, enum step step, uint32_t index, uint8_t upper)
{
    t->tx_bytes[0] = REGISTER_CONFIG;
    t->tx_bytes[1] = upper;
    t->tx_bytes[2] = CONFIG_LOWER;
    begin_transfer(t, step, index, 3, 0);
}

static void read_register(struct thermometer *t, enum step step, uint32_t index, uint8_t number)
{
    t->tx_bytes[0] = number;
    begin_transfer(t, step, index, 1, 2);
}

/* After an error, the chip may have lost its supply or its register pointer. It is set up again in
 * the next second. */
static void handle_failure(struct thermometer *t, enum thermometer_fault detail)
{
    health_count_fault(MR_FAULT_THERMOMETER, (uint8_t)detail);
    t->is_shut_down = false;
    t->step = STEP_WAIT;
}

static void convert_reading(struct thermometer *t)
{
    float celsius = thermometer_celsius(t->rx_bytes);
    if (t->rx_bytes[1] & 0x0fu || celsius < LOWEST_C || celsius > HIGHEST_C) {
        handle_failure(t, THERMOMETER_OUT_OF_RANGE);
        return;
    }
    t->temperature_c = celsius;
    t->error_c = celsius >= 0.0f && celsius <= 65.0f ? ERROR_C : ERROR_OUTSIDE_C;
    t->step = STEP_WAIT;
}

static void continue_transfer(struct thermometer *t, uint32_t index)
{
    switch ((enum step)t->step) {
    case STEP_WAIT:
        if (!DUE(THERMOMETER, index))
            break;
        discard_reading(t);
        if (t->is_shut_down)
            write_config(t, STEP_CONVERT, index, CONFIG_ONE_SHOT | CONFIG_UPPER);
        else
            write_config(t, STEP_SHUT_DOWN, index, CONFIG_UPPER);
        break;
    case STEP_SHUT_DOWN: /* a single conversion is possible only in the shut-down state */
        t->is_shut_down = true;
        write_config(t, STEP_CONVERT, index, CONFIG_ONE_SHOT | CONFIG_UPPER);
        break;
    case STEP_CONVERT:
        t->step_block = index;
        t->step = STEP_CONVERTING;
        break;
    case STEP_CONVERTING:
        if (index - t->step_block >= THERMOMETER_CONVERSION_BLOCKS)
            read_register(t, STEP_READ_STATUS, index, REGISTER_CONFIG);
        break;
    /* check that the conversion has ended and the configuration is still the one that was set */
    case STEP_READ_STATUS:
        if (t->rx_bytes[0] == (CONFIG_ONE_SHOT | CONFIG_UPPER))
            read_register(t, STEP_READ, index, REGISTER_TEMPERATURE);
        else
            handle_failure(t, THERMOMETER_NO_ANSWER);
        break;
    case STEP_READ: convert_reading(t); break;
    }
}

static void update_power(struct thermometer *t, bool fitted)
{
    thermometer_start(t);
    t->is_on = fitted;
    if (fitted)
        i2c_start();
    else
        i2c_stop();
}

bool thermometer_on_block(struct thermometer *t, uint32_t index, bool fitted)
{
    if (fitted != t->is_on)
        update_power(t, fitted);
    if (!fitted)
        return false;
    enum i2c_status status = i2c_poll();
    bool in_transfer = t->step != STEP_WAIT && t->step != STEP_CONVERTING;
    if (in_transfer && status == I2C_NO_ANSWER)
        handle_failure(t, THERMOMETER_NO_ANSWER);
    else if (in_transfer && status == I2C_STUCK)
        handle_failure(t, THERMOMETER_BUS_STUCK);
    else if (status != I2C_BUSY)
        continue_transfer(t, index);
    bool tells = DUE(THERMOMETER_REPORT, index);
    if (tells)
        t->last_temperature_c = t->temperature_c;
    return tells;
}
