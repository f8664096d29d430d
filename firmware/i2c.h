/* The seam to the bus of the thermometer: one transfer at a time, a step at each poll; nothing
 * waits.
 *
 * firmware/f407/i2c.c implements it on I2C1 (PB6 SCL, PB7 SDA); tests link a bus that fails
 * (fake_i2c.h). */
#ifndef MATRIG_FIRMWARE_I2C_H
#define MATRIG_FIRMWARE_I2C_H

#include <stddef.h>
#include <stdint.h>

enum i2c_status {
    I2C_IDLE, /* the last transfer is over, and was acknowledged */
    I2C_BUSY,
    I2C_NO_ANSWER, /* it was not acknowledged; the next may be tried */
    /* a line was held, or it took too long: nine clocks and a stop were tried; likewise */
    I2C_STUCK,
};

/* Clock and pins; before that, and after the stop, the bus costs nothing and its pins are
 * inputs. */
void i2c_start(void);
void i2c_stop(void);
/* Write `out_length` bytes (1 to 4) to a device, then, behind a repeated start, read `in_length` (0
 * or 2). Begun when i2c_poll did not say busy; the buffers stay the driver's until it says
 * something else again. */
void i2c_begin(uint8_t address, const uint8_t *out, size_t out_length, uint8_t *in,
               size_t in_length);
enum i2c_status i2c_poll(void);

#endif
