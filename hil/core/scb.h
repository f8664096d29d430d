/* System control block and the rest of the private peripheral bus: CPUID to CPACR, FPU control, DWT cycle
 * counter, debug identification (ARMv7-M B3.2, RM0090 38). */
#ifndef MATRIG_HIL_SCB_H
#define MATRIG_HIL_SCB_H

#include <stdint.h>

struct hil_core;

struct hil_scb {
    uint32_t vtor, scr, ccr, cfsr, hfsr, mmfar, bfar, cpacr;
    uint32_t fpccr, fpcar, fpdscr, demcr;
    uint32_t dwt_ctrl, dwt_offset; /* CYCCNT = cycles + offset while enabled, offset alone while not */
    uint32_t dbgmcu_cr, dbgmcu_apb1_fz, dbgmcu_apb2_fz;
};

void hil_scb_reset(struct hil_scb *scb);
/* Anything from 0xE0000000 to 0xE00FFFFF; hands on to NVIC and SysTick. */
uint32_t hil_scb_read(struct hil_core *core, uint32_t address, unsigned size);
void hil_scb_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value);

#endif
