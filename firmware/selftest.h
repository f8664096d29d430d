/* The self-test on command: everything that can be tested without moving the rig. RAM and program
 * once through, the reference channel, the excitation, the black box's memory, the warning output
 * lit for 200 ms and read back. Not from arm to done; arming breaks it off. */
#ifndef MATRIG_FIRMWARE_SELFTEST_H
#define MATRIG_FIRMWARE_SELFTEST_H

#include <stdbool.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/crash.h"

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

/* MR_OK: it has begun; MR_WAIT: one is going on. */
enum mr_status selftest_begin(struct selftest *test, uint16_t tag);
/* 10 ms have passed. True: it is over, `result` says how. */
bool selftest_tick(struct selftest *test, struct mr_self_test *result);
void selftest_block(struct selftest *test, const struct mr_block *block);
/* What was not done stays undone. True: there was one to be broken off. */
bool selftest_stop(struct selftest *test, struct mr_self_test *result);

#endif
