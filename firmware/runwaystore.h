/* The predictor's runway in two sectors of the black box's memory, so that it survives a reset.
 *
 * A runway changed by a landing, a survey or the host is written half a second after the change,
 * when nothing is armed and the black box is not using the memory. The older copy is erased,
 * written with its first page last, and read back. One copy is therefore intact after a power
 * failure at any time, and the CRC over the whole copy (common/runway.h) detects a partly written
 * one. At start the newer intact copy is loaded before a landing can be armed. A damaged copy is
 * reported (runway_store). If no intact copy is left, the fault NOR_FAILED with
 * RUNWAYSTORE_FAULT_DETAIL is counted too, and the runway starts unmeasured. Without the memory the
 * runway is unmeasured after each reset.
 *
 * Pure except for the calls of board.h. */
#ifndef MATRIG_FIRMWARE_RUNWAYSTORE_H
#define MATRIG_FIRMWARE_RUNWAYSTORE_H

#include "firmware/board.h"
#include "firmware/predict.h"

#define RUNWAYSTORE_FAULT_DETAIL 6u /* detail of MR_FAULT_NOR_FAILED for this module */
/* number of blocks without a further change before the runway is written, so that a survey of 42
 * segments is written once */
#define RUNWAYSTORE_QUIET_BLOCKS 500u
#define RUNWAYSTORE_BLANK        255u
#define RUNWAYSTORE_NO_MEMORY    254u
#define RUNWAYSTORE_NOT_READ     253u

struct runwaystore {
    /* has_no_memory: there is no memory, or none is configured; is_loaded: the stored runway, if
     * any, has been loaded */
    bool has_no_memory, is_loaded;
    uint8_t copy_state[RUNWAY_COPIES]; /* states of the copies, as in the message runway_store */
    uint32_t sequence[RUNWAY_COPIES];
    unsigned step, step_copy, tries; /* step in progress, and the copy that it reads or writes */
    unsigned page;
    bool is_in_progress; /* the memory is executing an operation of this module */
    uint32_t crc;        /* CRC of the runway being written */
    uint8_t image[MR_RUNWAY_IMAGE_BYTES];
    uint8_t buffer[NOR_PAGE_BYTES];
};

void runwaystore_start(struct runwaystore *store);
/* Sets whether the store has a memory. */
void runwaystore_set_memory(struct runwaystore *store, bool memory);
/* Continues an operation in progress. True: it still uses the memory. */
bool runwaystore_poll(struct runwaystore *store, struct predict *predict, const float *slack_in);
/* Begins the next operation. Returns false if there is none. `quiet`: no landing is armed or in
 * progress. */
bool runwaystore_begin(struct runwaystore *store, struct predict *predict, bool quiet,
                       uint32_t now_ms);
bool runwaystore_is_erasing(const struct runwaystore *store);
/* True if the stored runway, if any, has been loaded and a landing may be armed. */
bool runwaystore_is_loaded(const struct runwaystore *store);

#endif
