/* The Cortex-M4F core: Unicorn runs the instructions, this file counts them, keeps virtual time and
 * stops where an exception is due. Everything above single instructions (exceptions, system control
 * space) is our own. */
#ifndef MATRIG_HIL_CPU_H
#define MATRIG_HIL_CPU_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

struct hil_core;

/* Create the core and map its memories. Aborts when Unicorn cannot. */
void hil_cpu_create(struct hil_core *core);
void hil_cpu_destroy(struct hil_core *core);
/* Forget translated code and what is known of its blocks, after memory was written from outside. */
void hil_cpu_forget_code(struct hil_core *core);
/* The same for n bytes at an address. */
void hil_cpu_forget_range(struct hil_core *core, uint32_t address, uint32_t n);
/* Run instructions until something is due (event, exception, stop). */
void hil_cpu_run(struct hil_core *core);
/* From Unicorn's hook of an access: the block is walked through from its instruction on, which
 * makes the access again, and alone. Returns when it does so now. */
void hil_cpu_walk_to_access(struct hil_core *core);
/* A debugger jumps out of the block that is walked through: what was run of it counts. */
void hil_cpu_leave_block(struct hil_core *core);
/* Write bytes of flash, SRAM or CCM from outside, and forget the code that was there. MR_UNKNOWN
 * when the range is not in one memory. */
enum mr_status hil_cpu_poke(struct hil_core *core, uint32_t address, const void *bytes, size_t n);

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

/* ---- address space ---- */

/* Map at address 0 what the state requires: flash, or after BOOT0 the ROM. */
void hil_map_follow_boot_pin(struct hil_core *core);

/* Cells of RAM that do not hold: a bit that reads as 0 or as 1, whatever is written. Seen by the
 * core; DMA still sees what was written. A board with one is slower, for every load is looked
 * at. */

/* From now on. False: no more room. */
bool hil_stuck_add(struct hil_core *core, uint32_t address, unsigned bit, bool level);
/* After a snapshot was restored: look at loads, if there is something to see. */
void hil_stuck_look(struct hil_core *core);

#endif
