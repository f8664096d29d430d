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
/* What these do is told at hil_board_cut_power, hil_board_power_off and hil_board_brown_out. */
void hil_supply_cut(struct hil_supply_device *dev);
void hil_supply_off(struct hil_supply_device *dev, uint64_t duration_ps);
void hil_supply_dip(struct hil_supply_device *dev, double volts, uint64_t duration_ps);
/* The chip was reset: hold it in reset until the supply is back, if it is not. */
void hil_supply_hold(struct hil_supply_device *dev);

#endif
