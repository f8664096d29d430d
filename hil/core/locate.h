/* Which instruction of a basic block makes a given access, and where a transfer begins. */
#ifndef MATRIG_HIL_LOCATE_H
#define MATRIG_HIL_LOCATE_H

#include <stdbool.h>
#include <stdint.h>

struct hil_core;

/* Address that the multiple, double or exclusive transfer at `pc` begins at, if it is one with a
 * general base register (as the registers are now). */
bool hil_cpu_transfer_address(const struct hil_core *core, uint32_t pc, uint32_t *address);
/* PC of the instruction in the running block that accesses `address`; the block's start when it
 * cannot be found. */
uint32_t hil_cpu_access_pc(const struct hil_core *core, uint32_t address, bool write);

#endif
