/* The channels on the board: reads them, watches them while a landing is recorded, tells what
 * changed and how good they are. */
#ifndef MATRIG_FIRMWARE_CHANNELS_H
#define MATRIG_FIRMWARE_CHANNELS_H

#include "common/onboard/landing.h"
#include "common/watch.h"
#include "firmware/telemetry.h"

struct channels {
    struct mr_watch watch;
    uint32_t zero_block[MR_WATCHED]; /* hours of drift count from here: power on, or a later zero */
};

void channels_start(struct channels *channels);
/* A landing is armed: its record begins with block `index`, and with it all that is known of the
 * channels. */
void channels_arm(struct channels *channels, uint32_t index);

/* The zeros of these channels, a bit each, were measured just before block `index`. */
void channels_zeroed(struct channels *channels, uint32_t which, uint32_t index);

/* Reading of channel 0..MR_WATCHED-1 of a block; call for each block, channels rising. */
float channels_read(struct channels *channels, const struct mr_block *block, unsigned channel,
                    float ratio);

/* After a block's readings and its landing's step: events, and quality in turn. `moved_in`,
 * `tension_lb`: the newest readings (movement since `baseline_in`, NaN: none). */
void channels_tell(struct channels *channels, struct telemetry *telemetry,
                   const struct landing *landing, uint32_t index, const float *displacement_in,
                   const float *baseline_in, const float *tension_lb);

#endif
