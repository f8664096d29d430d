/* Sends the configuration as a sequence of items: channels (two messages each), switches, survey
 * segments, calibrations, parameters of the predictor. Normally one item is sent at each time in
 * the schedule; in a burst, one per block; to the black box's record, all at once. */
#ifndef MATRIG_FIRMWARE_CONFIGROUND_H
#define MATRIG_FIRMWARE_CONFIGROUND_H

#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

/* Sends the identity of the board and of its configuration to `sinks` (enum telemetry_sink). The
 * storage of the configuration is not part of a record, because it may change later. */
void configround_send_hello(struct telemetry *telemetry, unsigned sinks,
                            const struct landing *landing);
/* Sends hello now, and the whole configuration from the next block on. */
void configround_start_burst(struct telemetry *telemetry, const struct landing *landing);
/* Call in each block, or at each phase of the round while there are no scans. `slack_in`: the
 * survey, MR_SEGMENTS values; NaN: not surveyed. */
void configround_on_block(struct telemetry *telemetry, const float *slack_in, uint32_t index);
/* Writes the whole configuration, including hello and site, into the black box's record of a
 * landing that was just armed. Call only if there is a black box. */
void configround_store(struct telemetry *telemetry, const struct landing *landing,
                       const float *slack_in);

#endif
