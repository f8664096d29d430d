/* The board's supply: when it goes, when it dips, and when the chip runs again. */
#ifndef MATRIG_HIL_SUPPLY_H
#define MATRIG_HIL_SUPPLY_H

#include <stdbool.h>
#include <stdint.h>

struct hil_core;
struct hil_flash_device;
struct hil_rcc_device;
struct hil_tmp112_device;
struct hil_w25q_device;

#define HIL_CSR_POWER_ON 0x0e000000u /* flags of RCC_CSR at power on: POR, pin, brown-out */

struct hil_supply {
    bool held_in_reset; /* no supply, or too little */
};

struct hil_supply_device {
    struct hil_core *core;
    struct hil_supply *state;
    struct hil_flash_device *flash;
    struct hil_rcc_device *rcc;
    struct hil_w25q_device *nor;
    struct hil_tmp112_device *thermometer;
};

void hil_supply_create(struct hil_supply_device *dev);
/* The supply goes and comes back at once. Operations of flash and NOR stop half done, and RAM holds
 * noise; everything else is as at power on. Time, rig and what is on the links go on. Callable
 * while the board runs or between. */
void hil_supply_cut(struct hil_supply_device *dev);
/* The same for a time: nothing runs until the supply is back. */
void hil_supply_off(struct hil_supply_device *dev, uint64_t duration_ps);
/* The supply dips to `volts` for a time. Below the brown-out level of the option bytes (factory:
 * off) the chip is held in reset and RAM stays; below 1.68 V it is a power cut. Otherwise the run
 * ends when silicon could not go on at that supply with the clock and wait states set, and nothing
 * happens when it could. */
void hil_supply_dip(struct hil_supply_device *dev, double volts, uint64_t duration_ps);
/* The chip was reset: hold it in reset until the supply is back, if it is not. */
void hil_supply_hold(struct hil_supply_device *dev);

#endif
