/* What if the bits that the core is reading were otherwise: would the program do something else?
 *
 * The program is run on from the load in progress, in a copy of the processor and its memory, once
 * with each of some values of the bits in question, and the runs are compared: the same
 * instructions, the same stores to peripherals, the same memory at the end. Nothing of the board
 * itself moves.
 *
 * Limits. A run is followed for HIL_WHATIF_INSTRUCTIONS instructions, or to where it sleeps, ends
 * an exception or faults: what is decided later is not seen, nor what is stored in memory and
 * overwritten before. In the copy the register that is read keeps its value and every other read of
 * a peripheral gives 0, so what is followed may be a way that the program would not take. Stores to
 * the stack do not count by themselves (compilers save registers that are never read again); what
 * is made of them does. A load inside an IT block is followed as if the block ended behind it.
 *
 * A load is tried HIL_WHATIF_TIMES times with the same bits in question and the same LR, since the
 * code changed or the chip was reset. If none of these mattered, later ones are assumed not to: a
 * program that ignores the value at first and decides by it later is not caught. */
#ifndef MATRIG_HIL_WHATIF_H
#define MATRIG_HIL_WHATIF_H

#include <stdbool.h>
#include <stdint.h>

#define HIL_WHATIF_INSTRUCTIONS 2000u
#define HIL_WHATIF_TIMES        16u

struct hil_core;
struct hil_whatif; /* the copy; made when it is first needed */

struct hil_difference {
    unsigned bit; /* of the word that is read: one that matters by itself, or the lowest */
    uint32_t pc;  /* the branch or store that comes out otherwise; of a value in memory: the load */
};

/* During a read by the core, of the instruction at `pc`: does it matter what the bits `unknown` of
 * the word `value` are? */
bool hil_whatif_matters(struct hil_core *core, uint32_t pc, uint32_t value, uint32_t unknown,
                        struct hil_difference *difference);
/* Another time, another state: what was judged so far counts no more. */
void hil_whatif_forget(struct hil_core *core);
/* The code has changed, or the core ends. */
void hil_whatif_destroy(struct hil_core *core);

#endif
