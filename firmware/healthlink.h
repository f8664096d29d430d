/* Health and the links: the state of CAN, what went before this start, background tests, the
 * commands `reset` and `self-test`. None of its messages follows from blocks and commands alone, so
 * a replay does not compare them. */
#ifndef MATRIG_FIRMWARE_HEALTHLINK_H
#define MATRIG_FIRMWARE_HEALTHLINK_H

#include <stdbool.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/fault.h"
#include "firmware/telemetry.h"

/* ---- selftest ---- */

/* The self-test on command: everything that can be tested without moving the rig. RAM and program
 * once through, the reference channel, the excitation, the black box's memory, the warning output
 * lit for 200 ms and read back. Not from arm to done; arming breaks it off. */

#define SELFTEST_LAMP_TICKS  20u /* 200 ms lit */
#define SELFTEST_DARK_TICKS  5u  /* and 50 ms for its current to stop */
#define SELFTEST_LIMIT_TICKS 450u
#define SELFTEST_BLOCKS      100u /* looked at */

struct selftest {
    bool running;
    uint16_t tag, done, failed;
    unsigned ticks;
    uint16_t ram_rounds, flash_rounds; /* when it began */
    uint16_t polarity_faults;
    unsigned blocks;
    bool reference_bad, excited;
};

/* ---- healthlink ---- */

#define HEALTHLINK_RESET_TICKS 5u /* for the acknowledgement to get out */
/* of background tests for each block, while a self-test goes on */
#define HEALTHLINK_SLICES      8u

struct healthlink {
    struct selftest test;
    struct board_restart restart;
    unsigned crash_next;     /* word to be sent; MR_CRASH_ITEMS: none */
    unsigned ticks;          /* of background tests */
    unsigned ticks_to_reset; /* 0: not asked for */
};

void healthlink_start(struct healthlink *link);
/* Tell once more what a processor fault left behind, if one did. */
void healthlink_tell_crash(struct healthlink *link);
/* The commands reset and self-test, while nothing is recorded. MR_WAIT: a self-test goes on. */
void healthlink_reset(struct healthlink *link);
enum mr_status healthlink_self_test(struct healthlink *link, uint16_t tag);
/* A landing is armed: a self-test ends here. The warning output is the caller's again. */
void healthlink_arm(struct healthlink *link, struct telemetry *telemetry);
void healthlink_block(struct healthlink *link, const struct mr_block *block);
/* Once a block, or in place of one: what is due at this index. */
void healthlink_regular(struct healthlink *link, struct telemetry *telemetry, uint32_t index);
/* Once a pass of the main loop while nothing is recorded. */
void healthlink_idle(struct healthlink *link);
/* 10 ms have passed. */
void healthlink_tick(struct healthlink *link, struct telemetry *telemetry, bool idle);

#endif
