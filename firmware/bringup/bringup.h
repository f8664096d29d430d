/* The bring-up image: a small program that says on the serial port what a new board is and does,
 * with the firmware's own drivers and tasks. docs/howto/bring-up.md tells how it is used,
 * docs/reference/bring-up.md what each line means.
 *
 * Each function says its lines (say.h). None waits without a bound, all feed the watchdog; what is
 * not there is said: the value `none`. */
#ifndef MATRIG_FIRMWARE_BRINGUP_BRINGUP_H
#define MATRIG_FIRMWARE_BRINGUP_BRINGUP_H

#include <stdbool.h>
#include <stdint.h>

/* chip.c: which board and image, in every section; the chip, why it started; its option bytes */
void bringup_identity(void);
void bringup_chip(void);
void bringup_options(void);
/* clocks.c: clocks against each other, timers against each other, conversions against the timers.
 * After the scans have begun. */
void bringup_clocks(void);
/* noise.c: level and noise of each input, with prefetch and without */
void bringup_noise(void);
/* cost.c: the flash's prefetch, which is on elsewhere */
void bringup_prefetch(bool on);
/* cycles of the firmware's tasks beside what the budget assumes (tasks.def) */
void bringup_cost(void);
/* canloop.c: frames from the controller to itself; the bus sees none */
void bringup_can(void);
/* memorytest.c: who the black box's memory is, then so many rounds of erase, program and verify in
 * a sector that is empty, and empty afterwards. No sector is: it is left alone, and said. */
void bringup_memory(uint32_t rounds);
/* brownout.c: sets the brown-out level that this board's supply allows, reads it back. Takes force
 * with the next power on or reset. */
void bringup_set_brown_out(void);

/* falls.c: what ends in a reset, and what it was like afterwards. Neither returns where the board
 * does what it should. */
void bringup_overflow_stack(void);
void bringup_say_overflow(void);
void bringup_starve_watchdog(void);
void bringup_say_watchdog(void);

#endif
