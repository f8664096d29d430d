/* The configuration in force: at reset what is built in, then what is stored (configstore.h);
 * constant from arming to the end of the landing. */
#ifndef MATRIG_FIRMWARE_CONFIG_H
#define MATRIG_FIRMWARE_CONFIG_H

#include <stdint.h>

#include "common/config.h"

extern struct mr_config config;

/* Bit c: channel c is fitted (common/block.h). Staircase and reference always are. */
uint32_t config_fitted(void);

#endif
