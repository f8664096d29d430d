/* The registers of the core as a whole: for a reset, for a copy of the board. */
#ifndef MATRIG_HIL_CONTEXT_H
#define MATRIG_HIL_CONTEXT_H

#include <stdint.h>

struct hil_core;

/* All of the core that software can see. Valid while the core is stopped. */
struct hil_cpu_registers {
    uint32_t r[13];
    uint32_t msp, psp, lr, pc, xpsr;
    uint32_t control, primask, basepri, faultmask, fpscr;
    uint64_t d[16];
};

/* Vector table's SP and PC, everything else at its reset value. */
void hil_cpu_reset(struct hil_core *core);
/* Copy the registers into the core. */
void hil_cpu_load(struct hil_core *core, const struct hil_cpu_registers *registers);

#endif
