/* A bus with a TMP112 on it, for tests: a transfer takes some polls, the chip answers, or not, or
 * the bus is stuck. */
#ifndef MATRIG_TESTS_FIRMWARE_FAKE_I2C_H
#define MATRIG_TESTS_FIRMWARE_FAKE_I2C_H

#include <stdbool.h>

#include "firmware/board.h"

enum fake_i2c_fault { FAKE_I2C_GOOD, FAKE_I2C_DEAD, FAKE_I2C_STUCK };

struct fake_i2c {
    bool on;
    unsigned starts, stops;
    uint16_t temperature; /* the chip's register; what a conversion gives */
    uint16_t converted;   /* of the last one; 0 after power-up */
    uint8_t config;       /* upper byte */
    uint8_t pointer;
    unsigned conversions;
    uint8_t address;      /* at which the chip answers */
    unsigned never_ready; /* conversions that do not end */
    enum fake_i2c_fault fault;
    unsigned transfers, left;
    enum i2c_status result;
};

extern struct fake_i2c fake_i2c;

/* A chip at 0x48, 20 C, just powered up. */
void fake_i2c_reset(void);

#endif
