/* Configuration of the instrument: channels with their calibration, switches, site. Constant in this version. */
#ifndef MATRIG_FIRMWARE_CONFIG_H
#define MATRIG_FIRMWARE_CONFIG_H

#include <stdint.h>

#include "common/channels.h"

#define CONFIG_SWITCHES 24u

struct config_switch {
    float station_ft;
    uint16_t step_codes; /* what it adds to the staircase when it opens */
};

enum config_wheel { CONFIG_WHEEL_MAIN = 0, CONFIG_WHEEL_NOSE = 1, CONFIG_WHEEL_OTHER = 2 };

struct config {
    struct mr_channel_config channel[MR_CHANNELS];
    struct config_switch gate[CONFIG_SWITCHES]; /* in order along the runway */
    float touchdown_ft;
    float switch_error_ft; /* standard error of a switch's position */
    float wheel_ahead_ft;  /* the wheel that trips the switches is so far ahead of the main bogie's lead wheel */
    uint8_t wheel;         /* enum config_wheel: which it is */
};

extern const struct config config;

/* Station of the main bogie's lead wheel when switch `i` (from 0) opens: what every station of the gear means. */
static inline float config_gate_ft(unsigned i)
{
    return config.gate[i].station_ft - config.wheel_ahead_ft;
}

#endif
