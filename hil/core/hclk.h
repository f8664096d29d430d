/* HCLK changes, or stands still: the clock and all that waits in physical time together. */
#ifndef MATRIG_HIL_HCLK_H
#define MATRIG_HIL_HCLK_H

#include <stdint.h>

struct hil_core;

/* HCLK becomes hclk_hz now. */
void hil_hclk_change(struct hil_core *core, uint32_t hclk_hz);
/* No clock: physical time goes to the next event that is in physical time, while cycles stand
 * still. */
void hil_hclk_stand_still(struct hil_core *core);

#endif
