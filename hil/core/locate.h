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

/* An instruction of the running block. */
struct hil_place {
    uint32_t pc;
    unsigned before; /* instructions of the block before it */
};
/* The first instruction behind `after` (0: of the whole block) that accesses `address` with the
 * registers as they are now and whose condition holds. During an access that is the instruction
 * that makes it, when `after` is the one that made the last such access of the block. (An
 * instruction that was passed over, and whose base register or flags have changed since, may be
 * mistaken for it.) False: none. */
bool hil_cpu_access_place(const struct hil_core *core, uint32_t address, bool write, uint32_t after,
                          struct hil_place *place);

#endif
