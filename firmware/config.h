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

struct config {
    struct mr_channel_config channel[MR_CHANNELS];
    struct config_switch gate[CONFIG_SWITCHES]; /* in order along the runway */
    float touchdown_ft;
    float switch_error_ft; /* standard error of a switch's position */
};

extern const struct config config;

#endif
