/* The configuration in force: at reset what is built in, then what is stored (configstore.h);
 * constant from arming to the end of the landing. */
#ifndef MATRIG_FIRMWARE_CONFIG_H
#define MATRIG_FIRMWARE_CONFIG_H

#include <stdint.h>

#include "common/config.h"

extern struct mr_config config;

/* Fit what is built in, which is of a board with all inputs at 3.3 V, to another: channels without
 * an input (bits as in common/block.h) are not fitted, and what the converters reach ends at the
 * supply. Before anything else. */
void config_for_board(uint32_t inputs, uint32_t supply_mv);

/* Bit c: channel c is fitted (common/block.h). Staircase and reference always are. */
uint32_t config_fitted(void);

#endif
