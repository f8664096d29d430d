/* When the running instruction accesses a peripheral.
 *
 * Everything else of the emulator happens at the start of a basic block. Here an access has the
 * time of its own instruction: the start of its block plus one cycle for every instruction before
 * it. An instruction of silicon takes one cycle or more (an IT instruction or a NOP can take none),
 * so the time between two accesses is a lower bound of that on silicon. */
#ifndef MATRIG_HIL_STAMP_H
#define MATRIG_HIL_STAMP_H

#include <stdint.h>

struct hil_core;

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

#endif
