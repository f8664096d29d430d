/* System control block and the rest of the private peripheral bus: CPUID to CPACR, FPU control, DWT
 * cycle counter, debug identification (ARMv7-M B3.2, RM0090 38). */
#ifndef MATRIG_HIL_SCB_H
#define MATRIG_HIL_SCB_H

#include <stdint.h>

#include "hil/core/state.h"

struct hil_core;

/* `idcode`: of the chip, for DBGMCU. */
void hil_scb_reset(struct hil_scb *scb, uint32_t idcode);
/* Anything from 0xE0000000 to 0xE00FFFFF; hands on to NVIC and SysTick. */
uint32_t hil_scb_read(struct hil_core *core, uint32_t address, unsigned size);
void hil_scb_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value);

#endif
