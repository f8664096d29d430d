/* TMP112 digital thermometer of the mat (data sheet SBOS473), an I2C slave (hil/periph/i2c.h) at
 * address 0x48 (ADD0 at ground).
 *
 * The two low bits of the pointer select a register: 0 temperature (read only), 1 configuration, 2
 * low limit, 3 high limit. Registers have two bytes, upper byte first. Temperature: 12 bits (13
 * with EM), two's complement, left-justified, 0.0625 C per count; 0 from power-up to the end of the
 * first conversion. Configuration: OS R1 R0 F1 F0 POL TM SD | CR1 CR0 AL EM 0 0 0 0, 0x60a0 at
 * power-up, with four conversions per second. SD stops the conversions. Writing OS as 1 while SD is
 * set starts a single conversion (26 ms, at most 35 ms); OS reads 0 during this conversion and 1
 * after it. Not modelled: the alert pin and the effect of the limits, general call, high-speed
 * mode, the 30 ms timeout of the bus.
 *
 * The true temperature is hil_options.temperature_c, rising by temperature_c_per_h; NaN: no
 * thermometer is fitted. */
#ifndef MATRIG_HIL_TMP112_H
#define MATRIG_HIL_TMP112_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/periph/i2c.h"

struct hil_core;
struct hil_options;

#define HIL_TMP112_ADDRESS 0x48u

struct hil_tmp112 {
    uint8_t register_pointer;
    uint8_t config[2]; /* bytes as written; OS is computed when it is read */
    uint8_t limit[2][2];
    int32_t result_code;          /* result of the last conversion, in 0.0625 C */
    bool is_one_shot_done;        /* a conversion started by OS has ended */
    uint64_t conversion_begin_ps; /* start of the continuous or the single conversion */
    uint64_t conversion_ps;       /* duration of each conversion */
    bool is_one_shot_running;     /* a single conversion is in progress */
    bool is_addressed;
    unsigned byte_count; /* number of bytes since the chip was addressed */
    uint64_t random_state;

    /* set by faults: hil/rig/faults.h */
    bool is_dead;
    struct hil_i2c_bus_faults bus_faults;
};

struct hil_tmp112_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_tmp112 *state;
};

struct hil_i2c_slave hil_tmp112_slave(struct hil_tmp112_device *dev);
/* Resets the chip to its state at power on. */
void hil_tmp112_power_on(struct hil_tmp112_device *dev);

#endif
