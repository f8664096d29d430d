/* Zeros that were measured, and those of the configuration that they stand in for.
 *
 * A measured zero is in force at once: it is config.channel[].zero_code, so that whatever reads a
 * channel uses it, and the message channel_zero tells it, with `measured`, to the host and into
 * every record. Its standard error is in force with it: config.channel[].zero_error becomes
 * ZERO_ERROR_LB or ZERO_ERROR_IN, unless the configured one is less already. It is volatile: the
 * configured one is kept here, comes back with reset, and is what a stored
 * configuration must hold. */
#ifndef MATRIG_FIRMWARE_ZERO_H
#define MATRIG_FIRMWARE_ZERO_H

#include <stdbool.h>
#include <stdint.h>

/* What a zero measured over 256 blocks leaves: noise, and the mat or band that was not quite at
 * rest. Drawn boards (tests/electronics) leave 0.03 lb and 0.0003 in of it; what the converter's
 * curve does between the zero and a reading is linearity_error. */
#define ZERO_ERROR_LB 0.1f
#define ZERO_ERROR_IN 0.0005f

/* Nothing is measured: what the configuration holds is configured. After each change of the
 * configuration. */
void zero_start(void);
/* `channel` 0 to MR_CHANNELS - 1. */
void zero_measure(unsigned channel, float zero_code);
bool zero_is_measured(unsigned channel);
/* Bit per channel: measured since the last call. Its readings of before are of another zero. */
uint32_t zero_take_changed(void);
float zero_configured(unsigned channel);
/* Swap: the configured zeros and their errors in force, and back again, doing it twice. For whoever
 * tells the configuration. */
void zero_exchange(void);

#endif
