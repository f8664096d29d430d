/* Faster stores to RAM: stores.c tells what Unicorn does at each store, and how it is spared
 * that. */
#ifndef MATRIG_HIL_STORES_H
#define MATRIG_HIL_STORES_H

#include <stdbool.h>

struct CPUState;

struct hil_stores {
    bool code_in_ram;
    struct CPUState *core; /* Unicorn's; NULL: not met yet */
};

/* Of a new board. */
void hil_stores_start(struct hil_stores *stores);
/* Of the board that this thread runs now; NULL: none. */
void hil_stores_run(struct hil_stores *stores);
/* It runs code from RAM. */
void hil_stores_meet_code(struct hil_stores *stores);

#endif
