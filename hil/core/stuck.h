/* Cells of RAM that do not hold: a bit that reads as 0 or as 1, whatever is written. Seen by the
 * core; DMA still sees what was written. A board with one is slower, for every load is looked
 * at. */
#ifndef MATRIG_HIL_STUCK_H
#define MATRIG_HIL_STUCK_H

#include <stdbool.h>
#include <stdint.h>

struct hil_core;

/* From now on. False: no more room. */
bool hil_stuck_add(struct hil_core *core, uint32_t address, unsigned bit, bool level);
/* After a snapshot was restored: look at loads, if there is something to see. */
void hil_stuck_look(struct hil_core *core);

#endif
