/* Fault counters. Drivers and application count here; telemetry reports. May be called from
 * interrupts. */
#ifndef MATRIG_FIRMWARE_HEALTH_H
#define MATRIG_FIRMWARE_HEALTH_H

#include <stdbool.h>
#include <stdint.h>

#include "common/fault.h"

struct health_counter {
    uint16_t count; /* since reset; stays at 65535 */
    uint8_t detail; /* of the last one */
    uint8_t changed;
    uint32_t block; /* of the last one */
};

/* Count one fault. `detail` as in the fault table, else 0. */
void health_count(enum mr_fault_code fault, uint8_t detail);
/* The block that faults counted from now on belong to. */
void health_set_block(uint32_t block);
uint32_t health_block(void);
/* Times since reset; stays at 65535. */
uint16_t health_counted(enum mr_fault_code fault);
/* Bit n: fault n has occurred since reset. */
uint32_t health_faults(void);
/* Copy of a counter; clears its `changed`. */
struct health_counter health_take(enum mr_fault_code fault);

/* ---- tasks ---- */

/* Who has run: the parts of the main loop check in, and the watchdog is fed only while each did so
 * within its own limit (common/fault.h). A part that has nothing to do checks in when it has seen
 * that: a board without scans goes on speaking. */

#define TASKS_GOOD_TICKS 1000u /* 10 s without a late task: restarts before are no row any more */

/* A task begins: if the board then hangs, this task is named. */
void tasks_begin(enum mr_task task);
/* It has done what was to do. */
void tasks_done(enum mr_task task);
/* 10 ms have passed; from the supervision interrupt. `pc`: what was interrupted. A task that has
 * become late is counted, and noted for the time after the reset. */
void tasks_tick(uint32_t pc);
bool tasks_well(void);
/* The part that runs, or ran when the board was reset: kept through resets. 0: not known. */
enum mr_task tasks_current(void);
/* Begin counting, and forget who ran before. */
void tasks_start(void);

#endif
