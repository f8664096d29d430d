/* What each command is answered in each state of the board: a table, against the application with a
 * black box and a camera. */
#include "tests/firmware/fake_nor.h"
#include "tests/firmware/play.h"

#include "firmware/health.h"

enum state { IDLE, TESTING, BUSY, ARMED, LANDING, SETTLING, CLOSING, DONE, STATES };
static const char *const state_name[STATES] = {
    "idle", "self-test", "zero", "armed", "landing", "settling", "done, the box writing", "done"};

#define LATER             1 /* taken, and answered when it is over */
#define RECORDING(status) [ARMED] = (status), [LANDING] = (status), [SETTLING] = (status)

static const struct row {
    const char *words;
    int status[STATES]; /* MR_OK: 0 */
} table[] = {
    {"state", {0}},
    {"arm", {[BUSY] = MR_WAIT, RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT}},
    {"disarm", {0}},
    {"mark 1", {0}},
    {"survey 3 0.1", {RECORDING(MR_NOT_NOW)}},
    {"bootrom", {RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT}},
    {"reset", {RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT}},
    {"self-test", {[TESTING] = MR_WAIT, RECORDING(MR_NOT_NOW)}},
    {"zero", {LATER, LATER, MR_NOT_NOW, RECORDING(MR_NOT_NOW), [CLOSING] = LATER, [DONE] = LATER}},
    {"shunt", {LATER, LATER, MR_NOT_NOW, RECORDING(MR_NOT_NOW), [CLOSING] = LATER, [DONE] = LATER}},
    {"config-apply 1",
     {MR_TOO_FEW, MR_TOO_FEW, MR_WAIT,
      RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT, [DONE] = MR_TOO_FEW}},
    {"config-read", {RECORDING(MR_NOT_NOW)}},
    {"camera", {0}},
    {"box-list", {[CLOSING] = MR_WAIT}},
    /* record 1 */
    {"box-read 32768",
     {MR_UNKNOWN, MR_UNKNOWN, MR_UNKNOWN, RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT}},
    {"box-free 9",
     {MR_UNKNOWN, MR_UNKNOWN, MR_UNKNOWN,
      RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT, [DONE] = MR_UNKNOWN}},
    {"live 1", {RECORDING(MR_NOT_NOW), [CLOSING] = MR_NOT_NOW, [DONE] = MR_NOT_NOW}},
    {"backlog 9",
     {MR_NOT_NOW, MR_NOT_NOW, MR_NOT_NOW,
      RECORDING(LATER), [CLOSING] = MR_NOT_NOW, [DONE] = MR_NOT_NOW}},
    {"runway-read", {RECORDING(MR_NOT_NOW)}},
    {"runway-word 0 1", {RECORDING(MR_NOT_NOW)}},
    {"runway-joints 0 1", {RECORDING(MR_NOT_NOW)}},
    {"runway-take 1",
     {MR_CRC, MR_CRC, MR_CRC, RECORDING(MR_NOT_NOW), [CLOSING] = MR_CRC, [DONE] = MR_CRC}},
    {"chart-word 0 1", {RECORDING(MR_NOT_NOW)}},
    {"chart-take 1",
     {MR_CRC, MR_CRC, MR_CRC, RECORDING(MR_NOT_NOW), [CLOSING] = MR_CRC, [DONE] = MR_CRC}},
    {"chart-forget", {RECORDING(MR_NOT_NOW)}},
    {"runway-forget", {RECORDING(MR_NOT_NOW)}},
};

static struct app kept_app;
static struct fake_board kept_fake;
static uint32_t kept_index;
static struct mr_config kept_config;

static void pass(unsigned blocks)
{
    while (blocks--) {
        for (unsigned i = 0; i < 4; i++) { /* the memory answers within the block too */
            fake_nor.now_us += 250;
            app_poll(&app);
        }
        play(1);
    }
}

static int start_whole(void **state)
{
    kept_config = config;
    fake_nor_reset();
    config.site[0].camera = 1;
    config.site[0].camera_station_ft = 200.0f; /* not in this landing */
    return start(state);
}

static int put_back(void **state)
{
    (void)state;
    config = kept_config;
    return 0;
}

/* 30 ft/s past the switches 1 to 8, each 5 ft. */
static void roll(void)
{
    for (unsigned p = 1; p <= 8; p++) {
        pass(167);
        pass_switch(p, (double)index_now * 0.001 - 0.0002);
    }
}

static void until(enum mr_landing_state wanted)
{
    for (unsigned n = 0; n < 20000 && app.landing.state != wanted; n++)
        pass(1);
    assert_int_equal(app.landing.state, wanted);
}

static void reach(enum state wanted)
{
    for (unsigned n = 0; n < 5000 && blackbox_ready(&app.box) != MR_OK; n++)
        pass(1);
    pass(1000); /* the runway is looked for */
    assert_int_equal(blackbox_ready(&app.box), MR_OK);
    if (wanted == IDLE)
        return;
    if (wanted == TESTING || wanted == BUSY) {
        command(wanted == TESTING ? "self-test" : "zero 1");
        pass(2);
        return;
    }
    command("arm 5");
    pass(600);
    if (wanted == ARMED)
        return;
    roll();
    until(MR_LANDING_LANDING);
    if (wanted == LANDING)
        return;
    until(MR_LANDING_SETTLING);
    if (wanted == SETTLING)
        return;
    until(MR_LANDING_DONE);
    assert_int_equal(app.box.state, MR_BOX_CLOSING);
    for (unsigned n = 0; wanted == DONE && n < 5000 && app.box.state == MR_BOX_CLOSING; n++)
        pass(1);
}

TEST_IN(each_command_is_answered_in_each_state, start_whole, put_back)
{
    for (unsigned s = 0; s < STATES; s++) {
        start(NULL);
        fake_nor_reset();
        app_start(&app);
        reach((enum state)s);
        kept_app = app;
        kept_fake = fake;
        kept_index = index_now;
        for (unsigned r = 0; r < COUNT_OF(table); r++) {
            struct mr_ack ack;
            app = kept_app;
            fake = kept_fake;
            index_now = kept_index;
            fake.sent_count = 0;
            fake.received_count = fake.received_taken = 0;
            command(table[r].words);
            play(1);
            bool answered = count_frames(MR_ID_ACK) > 0;
            if (answered)
                GET_LAST(ack, ACK, &ack);
            if (answered != (table[r].status[s] != LATER) ||
                (answered && ack.status != table[r].status[s]))
                fail_msg("%s while %s: %d, not %d", table[r].words, state_name[s],
                         answered ? ack.status : LATER, table[r].status[s]);
        }
    }
}

/* A board whose scans stand obeys, but does not promise to record a landing; when they go on, it
 * does. */
TEST_IN(without_scans_it_is_not_armed, start_whole, put_back)
{
    struct mr_ack ack;
    reach(IDLE);
    for (unsigned n = 0; n < 5; n++)
        app_supervise(&app);
    command("arm 1");
    app_supervise(&app);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_NOT_NOW);
    assert_int_equal(app.landing.state, MR_LANDING_IDLE);
    pass(1);
    command("arm 1");
    pass(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_OK);
}

/* disarm, whatever for, while the self-test has the lamp lit. */
TEST_IN(nothing_puts_out_the_lamp_of_a_self_test, start_whole, put_back)
{
    reach(TESTING);
    assert_true(fake.warning);
    command("disarm");
    pass(1);
    assert_true(fake.warning);
    for (unsigned n = 0; n < 30; n++)
        app_supervise(&app);
    assert_false(fake.warning);
}
