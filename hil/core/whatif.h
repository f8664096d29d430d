/* Tests whether the program would behave differently if bits that the core is reading had other
 * values.
 *
 * The program is continued from the load in progress, in a copy of the processor and its memory,
 * once for each of several values of the bits in question. The runs are compared: instructions,
 * stores to peripherals, and memory at the end must be the same. The state of the board itself does
 * not change.
 *
 * Limitations: a run is followed for HIL_WHATIF_INSTRUCTIONS_MAX instructions, or until it sleeps,
 * ends an exception or faults. Later decisions are not detected, nor are values that are stored in
 * memory and overwritten before the end. In the copy, the register being read keeps its value and
 * every other read of a peripheral gives 0, so the run may follow a path that the program would not
 * take. Stores to the stack do not count as differences (compilers save registers that are never
 * read again); their consequences do. A load inside an IT block is followed as if the block ended
 * after it.
 *
 * After a change of code or a reset, a load with the same bits in question and the same LR is
 * tested HIL_WHATIF_TESTS_PER_LOAD times. If the bits never mattered, later loads are assumed not
 * to matter: a program that ignores the value at first and uses it later is not detected. */
#ifndef MATRIG_HIL_WHATIF_H
#define MATRIG_HIL_WHATIF_H

#include <stdbool.h>
#include <stdint.h>

#define HIL_WHATIF_INSTRUCTIONS_MAX 2000u
#define HIL_WHATIF_TESTS_PER_LOAD   16u

struct hil_core;
struct hil_whatif; /* state of the copy; created at its first use */

struct hil_whatif_difference {
    /* bit of the read word that affects the program by itself, or else the lowest unknown bit */
    unsigned bit;
    /* instruction at which the runs differ: a branch or store; for a difference in memory, the
     * load */
    uint32_t pc;
};

/* During a read by the instruction at `pc`: true if the values of the bits `unknown` of the word
 * `value` matter. `difference` then has the details. */
bool hil_whatif_has_effect(struct hil_core *core, uint32_t pc, uint32_t value, uint32_t unknown,
                           struct hil_whatif_difference *difference);
/* Call after a change of time or state: discards all results so far. */
void hil_whatif_reset(struct hil_core *core);
/* Call when the code has changed or the core is destroyed. */
void hil_whatif_destroy(struct hil_core *core);

#endif
