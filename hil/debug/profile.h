/* Instruction counts of a run by function, with the number of divisions and square roots in the
 * floating-point unit.
 *
 * Basic blocks are counted, so the sum of the counts equals hil_counters.instructions exactly; a
 * block that faults is counted completely in both. The counts are instructions, not cycles. */
#ifndef MATRIG_HIL_PROFILE_H
#define MATRIG_HIL_PROFILE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"
#include "hil/core/elf.h"

struct hil_board;

/* True if a 32-bit instruction is a VDIV or VSQRT (ARMv7-M A6.4). */
bool hil_profile_is_slow_instruction(uint16_t first, uint16_t second);

void hil_profile_begin(struct hil_board *board);
/* Ends the profile and writes the counts as text. MR_IO: the output is incomplete. */
enum mr_status hil_profile_end(struct hil_board *board, const struct mr_symbols *symbols,
                               FILE *file);

#endif
