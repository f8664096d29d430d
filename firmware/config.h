/* The active configuration: the built-in one at reset, then the stored one (configstore.h). It is
 * constant from arming to the end of a landing. */
#ifndef MATRIG_FIRMWARE_CONFIG_H
#define MATRIG_FIRMWARE_CONFIG_H

#include <stdint.h>

#include "common/config.h"

extern struct mr_config config;

/* Adapts the built-in configuration, which assumes all inputs and a supply of 3.3 V, to this board.
 * Channels without an input (bits as in common/block.h) are marked as not fitted, and the converter
 * range is limited to the supply. Call before anything else. */
void config_adapt_to_board(uint32_t inputs, uint32_t supply_mv);

/* Bit c: channel c is fitted (common/block.h). Staircase and reference are always fitted. */
uint32_t config_fitted_channels(void);

#endif
