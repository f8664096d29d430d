/* The access in progress: which instruction of the running block makes it, when, and its refusal.
 *
 * Everything else of the emulator happens at the start of a basic block. Here an access has the
 * time of its own instruction: the start of its block plus one cycle for every instruction before
 * it. An instruction of silicon takes one cycle or more (an IT instruction or a NOP can take none),
 * so the time between two accesses is a lower bound of that on silicon. */
#ifndef MATRIG_HIL_ACCESS_H
#define MATRIG_HIL_ACCESS_H

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

/* A moment, and who made it. */
struct hil_moment {
    uint64_t ps;    /* since power on */
    uint32_t pc;    /* 0: no instruction, but the hardware */
    double slew_ns; /* of the edge that was made then: so long until its level is reached */
};

/* Of the access in progress, from a peripheral that is read or written; several may ask at one. Ask
 * at every access to the same address, or the first of a block is taken for a later one. Zero when
 * no instruction of the running block makes it: a debugger does, or nobody can tell. */
struct hil_moment hil_stamp(struct hil_core *core);
/* Of what happens without the core, at a cycle. */
struct hil_moment hil_stamp_at(const struct hil_core *core, uint64_t cycle);

/* Refusals: an access that nothing models ends the run, and says which. */

/* Called by a peripheral that is asked for something it does not model, with what it is: "TIM4:
 * centre-aligned mode". Returns 0, so that a read can return it; the run stops. */
uint32_t hil_bus_refuse(struct hil_core *core, const char *what);
/* The same for a register that is not modelled. */
uint32_t hil_bus_no_register(struct hil_core *core);
/* The run stops at the access in progress: `why`, what it is, and `what` (NULL: no more to say). */
void hil_bus_stop(struct hil_core *core, const char *why, const char *what);

#endif
