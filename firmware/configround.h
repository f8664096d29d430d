/* The configuration, told as a round of items: channels (two messages each), switches, survey
 * segments, calibrations, parameters of the predictor. One item at a time as the schedule says; one
 * each block in a burst; all at once into the black box's record. */
#ifndef MATRIG_FIRMWARE_CONFIGROUND_H
#define MATRIG_FIRMWARE_CONFIGROUND_H

#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

/* Who the board is and which configuration it has, into `sinks` (enum telemetry_sink). Where the
 * configuration is stored is of today, and not told into a record. */
void configround_hello(struct telemetry *telemetry, unsigned sinks, const struct landing *landing);
/* Hello now, and the whole configuration from the next block on. */
void configround_burst(struct telemetry *telemetry, const struct landing *landing);
/* A block, or a phase of the round without scans. `slack_in`: the survey, MR_SEGMENTS; NaN: not
 * surveyed. */
void configround_block(struct telemetry *telemetry, const float *slack_in, uint32_t index);
/* The whole configuration, hello and site included, into the box's record of a landing that was
 * armed. Only where there is a box. */
void configround_store(struct telemetry *telemetry, const struct landing *landing,
                       const float *slack_in);

#endif
