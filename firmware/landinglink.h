/* What the board says of a landing as it happens: block records, means, state, motion, results. */
#ifndef MATRIG_FIRMWARE_LANDINGLINK_H
#define MATRIG_FIRMWARE_LANDINGLINK_H

#include "common/block.h"
#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

/* The block's record, on serial. */
void landinglink_block(struct telemetry *telemetry, const struct mr_block *block);
/* Means, on CAN: serial has the block records. `fitted`: bit i, transducer or gage i is there.
 * Messages without any that is are not sent. */
void landinglink_displacements(struct telemetry *telemetry, const float value_in[MR_TRANSDUCERS],
                               uint32_t fitted, uint32_t index);
void landinglink_tensions(struct telemetry *telemetry, const float value_lb[MR_GAGES],
                          uint32_t fitted, uint32_t index);
void landinglink_state(struct telemetry *telemetry, const struct landing *landing);
/* The motion that follows from the gates so far, at block `index`; of the whole landing, when it is
 * over. With standard errors, the clock's in them. */
void landinglink_motion(struct telemetry *telemetry, const struct mr_motion_estimate *motion,
                        uint32_t index);
void landinglink_summary(struct telemetry *telemetry, const struct mr_gates_summary *summary);
/* What block `index` made of the landing: edges, push-back, motion, summary, state, in this
 * order. */
void landinglink_news(struct telemetry *telemetry, const struct landing *landing,
                      const struct landing_news *news, uint32_t index);

#endif
