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

/* Must the multiple, double or exclusive transfer at `pc` fault for its address, as the registers
 * are now? One with a general base register. */
bool hil_transfer_is_unaligned(const struct hil_core *core, uint32_t pc);
/* Does a condition code hold with these flags? */
bool hil_condition_holds(uint32_t xpsr, unsigned condition);
/* How many instructions begin from `from` to before `to`. */
unsigned hil_instructions_between(const struct hil_core *core, uint32_t from, uint32_t to);

/* PC of the instruction that makes the bus access in progress; where the core stands, when somebody
 * else makes it. */
uint32_t hil_access_pc(const struct hil_core *core);

/* A moment, and who made it. */
struct hil_moment {
    uint64_t ps;    /* since power on */
    uint32_t pc;    /* 0: no instruction, but the hardware */
    double slew_ns; /* of the edge that was made then: so long until its level is reached */
};

/* Of the access in progress, from a peripheral that is read or written. Zero when no instruction of
 * the firmware makes it: a debugger, DMA or the boot ROM does. */
struct hil_moment hil_stamp(const struct hil_core *core);
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
