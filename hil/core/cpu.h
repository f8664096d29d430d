/* The Cortex-M4F core: Unicorn runs the instructions, this file counts them, keeps virtual time and
 * stops where an exception is due. Everything above single instructions (exceptions, system control
 * space) is our own. */
#ifndef MATRIG_HIL_CPU_H
#define MATRIG_HIL_CPU_H

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
/* What is known of the block at `address` is no longer true: look again when it comes. */
void hil_cpu_inspect_again(struct hil_core *core, uint32_t address);
/* Run instructions until something is due (event, exception, stop). */
void hil_cpu_run(struct hil_core *core);
/* A debugger jumps out of the block that is walked through: what was run of it counts. */
void hil_cpu_leave_block(struct hil_core *core);
/* Write bytes of flash, SRAM or CCM from outside, and forget the code that was there. MR_UNKNOWN
 * when the range is not in one memory. */
enum mr_status hil_cpu_poke(struct hil_core *core, uint32_t address, const void *bytes, size_t n);

#endif
