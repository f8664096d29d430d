/* Who has run: the parts of the main loop check in, and the watchdog is fed only while each did so
 * within its own limit (common/crash.h). A part that has nothing to do checks in when it has seen
 * that: a board without scans goes on speaking. */
#ifndef MATRIG_FIRMWARE_TASKS_H
#define MATRIG_FIRMWARE_TASKS_H

#include <stdbool.h>
#include <stdint.h>

#include "common/crash.h"

#define TASKS_GOOD_TICKS 1000u /* 10 s without a late task: restarts before are no row any more */

/* A part begins: should nothing ever be heard again, it was this one. */
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
