/* What the board says of itself by the schedule (schedule.def): clock, health, links, faults,
 * counts, hello, state. */
#ifndef MATRIG_FIRMWARE_REGULAR_H
#define MATRIG_FIRMWARE_REGULAR_H

#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

/* The regular messages of one block, then what is due of the configuration (configround.h). Also
 * without scans, at the phases that schedule_due_without_scans names. */
void regular_block(struct telemetry *telemetry, const struct landing *landing,
                   const float *slack_in, uint32_t index, uint32_t tick);

#endif
