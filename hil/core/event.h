/* Event queue: one fixed slot per source, so that the whole queue is a few words without pointers.
 *
 * A slot holds either an HCLK cycle (peripherals: they count clocks, whatever the clock's rate is)
 * or a physical time in picoseconds (the rig, oscillators, the watchdog's own clock), which is
 * converted again whenever HCLK changes. */
#ifndef MATRIG_HIL_EVENT_H
#define MATRIG_HIL_EVENT_H

#include <stdint.h>

#include "hil/core/state.h"

struct hil_core;

/* An empty queue. */
void hil_event_create(struct hil_core *core);
void hil_event_wire(struct hil_core *core, enum hil_event_slot slot,
                    void (*handler)(void *device, uint64_t at), void *device);
/* Set, move or (HIL_NEVER) clear a slot. A past moment is due at once. */
void hil_event_set_cycle(struct hil_core *core, enum hil_event_slot slot, uint64_t cycle);
void hil_event_set_ps(struct hil_core *core, enum hil_event_slot slot, uint64_t t_ps);
/* Treat everything due up to the present cycle, in order of time. */
void hil_event_run(struct hil_core *core);

/* HCLK becomes hclk_hz now. */
void hil_hclk_change(struct hil_core *core, uint32_t hclk_hz);
/* No clock: physical time goes to the next event that is in physical time, while cycles stand
 * still. */
void hil_hclk_stand_still(struct hil_core *core);

#endif
