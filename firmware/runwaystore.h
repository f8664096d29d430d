/* The predictor's runway in two sectors of the black box's memory, so that it survives a reset.
 *
 * A runway that has changed (a landing, a survey, the host's) is written half a second later, when
 * nothing is armed and the black box does not have the memory: the copy that does not hold the
 * newest is erased and written, its first page last, and read back. Whenever the power goes, one
 * copy is whole, and the CRC over all of it (common/runway.h) lets no mixture of two pass. At start
 * the newer whole copy is loaded, before anything can be armed; a damaged copy is reported
 * (runway_store), and when none is left it is a fault too, NOR_FAILED with RUNWAYSTORE_DETAIL, and
 * the runway is an unmeasured one. Without the memory it is unmeasured after each reset.
 *
 * Pure but for the calls of board.h. */
#ifndef MATRIG_FIRMWARE_RUNWAYSTORE_H
#define MATRIG_FIRMWARE_RUNWAYSTORE_H

#include "firmware/board.h"
#include "firmware/predict.h"

#define RUNWAYSTORE_DETAIL       6u   /* of MR_FAULT_NOR_FAILED */
#define RUNWAYSTORE_QUIET_BLOCKS 500u /* a survey of 42 segments is one change */
#define RUNWAYSTORE_BLANK        255u
#define RUNWAYSTORE_NO_MEMORY    254u
#define RUNWAYSTORE_NOT_READ     253u

struct runwaystore {
    bool missing, loaded;        /* no memory, or none configured; what there was to load is */
    uint8_t copy[RUNWAY_COPIES]; /* as in the message runway_store */
    uint32_t sequence[RUNWAY_COPIES];
    unsigned step, at, tries; /* what is going on, and with which copy */
    unsigned page;
    bool under_way; /* the memory has an operation of ours */
    uint32_t crc;   /* of the runway being written */
    uint8_t image[MR_RUNWAY_IMAGE];
    uint8_t buffer[NOR_PAGE];
};

void runwaystore_start(struct runwaystore *store);
/* Whether there is a memory, now. */
void runwaystore_follow(struct runwaystore *store, bool memory);
/* An operation that was begun: go on with it; true: it still holds the memory. */
bool runwaystore_busy(struct runwaystore *store, struct predict *predict, const float *slack_in);
/* Begin the next one; false: there is none. `quiet`: neither armed nor in a landing. */
bool runwaystore_begin(struct runwaystore *store, struct predict *predict, bool quiet,
                       uint32_t now_ms);
bool runwaystore_erasing(const struct runwaystore *store);
/* What there was to load is loaded: a landing may be armed. */
bool runwaystore_loaded(const struct runwaystore *store);

#endif
