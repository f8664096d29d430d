/* Instruction counts of a run by function, and how many of them are divisions and roots of the
 * floating-point unit.
 *
 * Counted are basic blocks, so the counts add up to hil_counters.instructions exactly. A block that
 * faults counts whole, as there. Instruction counts are what the emulator knows; they are no cycle
 * counts. */
#ifndef MATRIG_HIL_PROFILE_H
#define MATRIG_HIL_PROFILE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"
#include "hil/core/elf.h"

struct hil_board;

/* Is a 32-bit instruction a VDIV or VSQRT (ARMv7-M A6.4)? */
bool hil_profile_is_slow(uint16_t first, uint16_t second);

void hil_profile_begin(struct hil_board *board);
/* The counts as text; nothing is counted any more. MR_IO when not all could be written. */
enum mr_status hil_profile_end(struct hil_board *board, const struct mr_symbols *symbols,
                               FILE *file);

#endif
