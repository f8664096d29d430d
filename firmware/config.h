/* The configuration in force. Built in for now; constant from arming to the end of the landing. */
#ifndef MATRIG_FIRMWARE_CONFIG_H
#define MATRIG_FIRMWARE_CONFIG_H

#include <stdint.h>

#include "common/config.h"

extern struct mr_config config;

/* Station of the main bogie's lead wheel when switch `i` (from 0) opens: what every station of the gear means. */
static inline float config_gate_ft(unsigned i)
{
    return config.gate[i].station_ft - config.site[0].wheel_ahead_ft;
}

/* Bit c: channel c is fitted (common/block.h). Staircase and reference always are. */
uint32_t config_fitted(void);

#endif
