/* Health and the links: CAN state, restarts before this start, background tests, and the commands
 * `reset` and `self-test`. These messages depend on more than blocks and commands, so a replay does
 * not compare them. */
#ifndef MATRIG_FIRMWARE_HEALTHLINK_H
#define MATRIG_FIRMWARE_HEALTHLINK_H

#include <stdbool.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/fault.h"
#include "firmware/telemetry.h"

/* ---- self-test ---- */

/* The self-test on command tests everything that can be tested without moving the rig: RAM,
 * program, reference channel, excitation, the memory of the black box, and the warning output. The
 * lamp is lit for 200 ms, and its current is read back. The self-test is refused between arming and
 * the end of a landing; arming aborts it. */

#define SELFTEST_LAMP_TICKS  20u /* 200 ms lit */
#define SELFTEST_DARK_TICKS  5u  /* 50 ms for the lamp's current to stop */
#define SELFTEST_LIMIT_TICKS 450u
#define SELFTEST_BLOCKS      100u /* blocks that the self-test examines */

struct selftest {
    bool is_running;
    uint16_t tag, done_tests, failed_tests;
    unsigned ticks;
    uint16_t ram_test_count,
        flash_check_count; /* values of the counters at the start of the self-test */
    uint16_t polarity_faults;
    unsigned blocks;
    bool is_reference_bad, is_excited;
};

/* ---- health on the links ---- */

#define HEALTHLINK_RESET_TICKS 5u /* 50 ms for sending the acknowledgement */
/* number of steps of the background tests per block during a self-test */
#define HEALTHLINK_SLICES      8u

struct healthlink {
    struct selftest test;
    struct board_restart restart;
    unsigned next_crash_word; /* next word to be sent; MR_CRASH_ITEM_COUNT: none */
    unsigned ticks;           /* supervision ticks, which pace the background tests */
    unsigned ticks_to_reset;  /* number of ticks until the requested reset; 0: none requested */
};

void healthlink_start(struct healthlink *link);
/* Sends the words of the last processor fault again, if there are any. */
void healthlink_report_crash(struct healthlink *link);
/* Execute the commands reset and self-test while nothing is recorded. MR_WAIT: a self-test is in
 * progress. */
void healthlink_schedule_restart(struct healthlink *link);
enum mr_status healthlink_self_test(struct healthlink *link, uint16_t tag);
/* Call when a landing is armed: aborts a self-test. After this call, the caller controls the
 * warning output again. */
void healthlink_arm(struct healthlink *link, struct telemetry *telemetry);
void healthlink_on_block(struct healthlink *link, const struct mr_block *block);
/* Call once per block, or in place of a block: sends the messages that are due at this index. */
void healthlink_send_regular(struct healthlink *link, struct telemetry *telemetry, uint32_t index);
/* Call once per pass of the main loop while nothing is recorded. */
void healthlink_run_idle(struct healthlink *link);
/* Call every 10 ms. */
void healthlink_tick(struct healthlink *link, struct telemetry *telemetry, bool idle);

#endif
