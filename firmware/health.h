/* Fault counters. Drivers and application count faults here; telemetry reports them. May be called
 * from interrupts. */
#ifndef MATRIG_FIRMWARE_HEALTH_H
#define MATRIG_FIRMWARE_HEALTH_H

#include <stdbool.h>
#include <stdint.h>

#include "common/fault.h"

struct health_counter {
    uint16_t count; /* faults since reset; saturates at 65535 */
    uint8_t detail; /* detail of the last fault */
    uint8_t changed;
    uint32_t block; /* block of the last fault */
};

/* Counts one fault. `detail` as in the fault table, else 0. */
void health_count_fault(enum mr_fault_code fault, uint8_t detail);
/* Sets the block that is recorded with the following faults. */
void health_set_block(uint32_t block);
uint32_t health_get_block(void);
/* Number of faults since reset; saturates at 65535. */
uint16_t health_get_count(enum mr_fault_code fault);
/* Bit n: fault n has occurred since reset. */
uint32_t health_get_faults(void);
/* Returns a copy of a counter and clears its `changed`. */
struct health_counter health_get_counter(enum mr_fault_code fault);

/* ---- tasks ---- */

/* Supervision of the tasks: the parts of the main loop check in, and the watchdog is fed only while
 * each part has done so within its limit (common/fault.h). A part that has nothing to do checks in
 * too, so that a board without scans is not reset. */

/* after 10 s without a late task, a restart counts as the first in a row */
#define TASKS_GOOD_TICKS 1000u

/* Call at the start of a task: if the board hangs, this task is reported. */
void tasks_begin(enum mr_task task);
/* Call at the end of a task. */
void tasks_done(enum mr_task task);
/* Call every 10 ms from the supervision interrupt. `pc`: the interrupted address. A late task is
 * counted and recorded for the report after the reset. */
void tasks_tick(uint32_t pc);
bool tasks_are_healthy(void);
/* Returns the task that is running, or the one that was running at a reset, whose number survives
 * resets; 0: unknown. */
enum mr_task tasks_current(void);
/* Starts the supervision and discards the task that ran before the reset. */
void tasks_start(void);

#endif
