/* Instruction counts of a run: by function, by what they ran in (thread, each exception) and by
 * kind.
 *
 * Counted are basic blocks, so the counts add up to hil_counters.instructions exactly. A block that
 * faults counts whole, as there. Instruction counts are what the emulator knows; they are no cycle
 * counts. */
#ifndef MATRIG_HIL_PROFILE_H
#define MATRIG_HIL_PROFILE_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"
#include "hil/symbols.h"

struct hil_board;

enum hil_kind {
    HIL_KIND_ALU, /* moves, arithmetic, logic, shifts, bit fields, comparisons, IT */
    HIL_KIND_MULTIPLY,
    HIL_KIND_DIVIDE,
    HIL_KIND_LOAD,
    HIL_KIND_STORE,
    HIL_KIND_BRANCH,  /* calls, returns by BX, table branches */
    HIL_KIND_FP,      /* floating-point arithmetic, comparisons, conversions, moves */
    HIL_KIND_FP_SLOW, /* division, square root */
    HIL_KIND_FP_LOAD,
    HIL_KIND_FP_STORE,
    HIL_KIND_SYSTEM, /* SVC, barriers, masks, special registers, hints */
    HIL_KINDS
};

/* Kind of one instruction from its encoding (ARMv7-M A5); `second` counts for 32-bit ones only. */
enum hil_kind hil_profile_kind(uint16_t first, uint16_t second);
const char *hil_profile_kind_name(enum hil_kind kind);

/* Begin to count. Ends with hil_profile_end, which frees it. */
void hil_profile_begin(struct hil_board *board);
void hil_profile_end(struct hil_board *board);
/* The counts so far as text. MR_IO when not all could be written. */
enum mr_status hil_profile_print(const struct hil_board *board, const struct mr_symbols *symbols,
                                 FILE *file);

#endif
