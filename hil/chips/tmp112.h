/* TMP112 digital thermometer (data sheet SBOS473) at address 0x48 (ADD0 at ground), a slave of I2C
 * (hil/periph/i2c.h): the mat's.
 *
 * Registers by the pointer's two low bits: 0 temperature (read only), 1 configuration, 2 low limit,
 * 3 high limit; two bytes, the upper one first. Temperature: 12 bits (EM: 13), two's complement,
 * left-justified, 0.0625 C a count; 0 after power-up until the first conversion is over.
 * Configuration: OS R1 R0 F1 F0 POL TM SD | CR1 CR0 AL EM 0 0 0 0, 0x60a0 at power-up: converting
 * four times a second. SD stops that; OS written as 1 while SD is set makes one conversion (26 ms,
 * at most 35), OS reads 0 meanwhile and 1 behind it. Not modelled: the alert pin and what the
 * limits do, general call, high-speed mode, the 30 ms timeout of the bus.
 *
 * Its truth is hil_options.temperature_c + temperature_c_per_h; NaN: none is fitted. */
#ifndef MATRIG_HIL_TMP112_H
#define MATRIG_HIL_TMP112_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/periph/i2c.h"

struct hil_core;
struct hil_options;

#define HIL_TMP112_ADDRESS 0x48u

struct hil_tmp112 {
    uint8_t pointer;
    uint8_t config[2]; /* as written, OS apart */
    uint8_t limit[2][2];
    int32_t code;      /* of the last conversion, 0.0625 C */
    bool done;         /* a conversion that OS asked for is over */
    uint64_t begun_ps; /* of continuous conversion, or of the single one */
    uint64_t took_ps;  /* a conversion takes */
    bool converting;   /* the single one */
    bool addressed;
    unsigned bytes; /* since it was addressed */
    uint64_t random;

    /* what is wrong with it: hil/rig/faults.h */
    bool dead;
    struct hil_i2c_hold hold;
};

struct hil_tmp112_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_tmp112 *state;
};

struct hil_i2c_slave hil_tmp112_slave(struct hil_tmp112_device *dev);
/* Power on. */
void hil_tmp112_power(struct hil_tmp112_device *dev);

#endif
