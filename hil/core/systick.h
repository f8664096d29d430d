/* SysTick: 24-bit down counter (ARMv7-M B3.3). The counter is computed when somebody looks; only
 * its zero is an event. */
#ifndef MATRIG_HIL_SYSTICK_H
#define MATRIG_HIL_SYSTICK_H

#include <stdint.h>

struct hil_core;

void hil_systick_create(struct hil_core *core);
void hil_systick_reset(struct hil_core *core);
uint32_t hil_systick_read(struct hil_core *core, uint32_t offset);
void hil_systick_write(struct hil_core *core, uint32_t offset, uint32_t value);

#endif
