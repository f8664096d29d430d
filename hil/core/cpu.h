/* The Cortex-M4F core. Unicorn executes the instructions; this module counts them, maintains
 * virtual time and stops Unicorn where an exception is due. Exceptions and the system control space
 * are modelled here, not in Unicorn. */
#ifndef MATRIG_HIL_CPU_H
#define MATRIG_HIL_CPU_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

struct hil_core;

/* Creates the core and maps its memories. Aborts if Unicorn fails. */
void hil_cpu_create(struct hil_core *core);
void hil_cpu_destroy(struct hil_core *core);
/* Discards the translated code and the block cache after memory was written from outside. */
void hil_cpu_discard_code(struct hil_core *core);
/* As hil_cpu_discard_code, for n bytes at an address. */
void hil_cpu_discard_range(struct hil_core *core, uint32_t address, uint32_t n);
/* Runs instructions until an event, an exception or a stop is due. */
void hil_cpu_run(struct hil_core *core);
/* Call from Unicorn's hook of an access. Leaves the block; the instruction that makes the access is
 * then repeated as a single instruction, and the rest of the block is executed instruction by
 * instruction. Returns only if the access is already made by a single instruction. */
void hil_cpu_step_to_access(struct hil_core *core);
/* Call when a debugger jumps out of a block that is being executed instruction by instruction: the
 * instructions already executed are counted. */
void hil_cpu_leave_block(struct hil_core *core);
/* Writes bytes of flash, SRAM or CCM from outside and discards the translated code there.
 * MR_UNKNOWN: the range is not within one memory. */
enum mr_status hil_cpu_poke(struct hil_core *core, uint32_t address, const void *bytes, size_t n);

/* All registers of the core that software can see. Valid while the core is stopped. */
struct hil_cpu_registers {
    uint32_t r[13];
    uint32_t msp, psp, lr, pc, xpsr;
    uint32_t control, primask, basepri, faultmask, fpscr;
    uint64_t d[16];
};

/* Resets the core: SP and PC from the vector table, everything else at its reset value. */
void hil_cpu_reset(struct hil_core *core);
/* Copies the registers into the core. */
void hil_cpu_load_registers(struct hil_core *core, const struct hil_cpu_registers *registers);

/* ---- address space ---- */

/* Maps at address 0 the memory that the state requires: flash, or the boot ROM if BOOT0 selected
 * it. */
void hil_cpu_map_boot_memory(struct hil_core *core);

/* Stuck cells of RAM: a bit always reads as 0 or 1. Only the core reads the stuck value; DMA reads
 * the written value. A board with a stuck cell is slower, because every load is checked. */

/* Adds a stuck bit. Returns false if there is no room. */
bool hil_stuck_bit_add(struct hil_core *core, uint32_t address, unsigned bit, bool level);
/* Call after a snapshot was restored: enables the check of loads if there are stuck cells. */
void hil_stuck_bits_enable(struct hil_core *core);

#endif
