/* What each command is answered in each state of the board, by each link, with the maintenance
 * jumper and without, on a board that was started for a replay and on one that was not, without a
 * key and with one, with a proof that is right, wrong or absent: a table, against the application
 * with a black box and a camera. */
#include "tests/firmware/fake_nor.h"
#include "tests/firmware/play.h"

#include "firmware/health.h"

enum state { IDLE, TESTING, BUSY, ARMED, LANDING, SETTLING, CLOSING, DONE, STATES };
static const char *const state_name[STATES] = {
    "idle", "self-test", "zero", "armed", "landing", "settling", "done, the box writing", "done"};

#define LATER             1 /* taken, and answered when it is over */
#define ANYBODY           MR_OK
#define MAINTENANCE       MR_CABLE  /* not over CAN without the jumper */
#define STARTS            MR_JUMPER /* over serial with the jumper alone */
#define REPLAYS           MR_REPLAY /* to a board that replays alone */
#define OPERATOR          MR_PROOF  /* where a key is set, with a proof alone */
#define RECORDING(status) [ARMED] = (status), [LANDING] = (status), [SETTLING] = (status)

static const struct row {
    const char *words;
    int right;          /* what it is answered without it, where its state is right */
    int status[STATES]; /* MR_OK: 0 */
} table[] = {
    {"state", ANYBODY, {0}},
    {"arm", OPERATOR, {[BUSY] = MR_WAIT, RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT}},
    {"disarm", OPERATOR, {0}},
    {"mark 1", ANYBODY, {0}},
    {"survey 3 0.1", OPERATOR, {RECORDING(MR_NOT_NOW)}},
    {"bootrom", MAINTENANCE, {RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT}},
    {"reset", MAINTENANCE, {RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT}},
    {"replay",
     STARTS,
     {LATER, LATER, LATER, RECORDING(MR_NOT_NOW), [CLOSING] = LATER, [DONE] = LATER}},
    {"self-test", ANYBODY, {[TESTING] = MR_WAIT, RECORDING(MR_NOT_NOW)}},
    {"zero",
     OPERATOR,
     {LATER, LATER, MR_NOT_NOW, RECORDING(MR_NOT_NOW), [CLOSING] = LATER, [DONE] = LATER}},
    {"shunt",
     OPERATOR,
     {LATER, LATER, MR_NOT_NOW, RECORDING(MR_NOT_NOW), [CLOSING] = LATER, [DONE] = LATER}},
    {"config-apply 1",
     MAINTENANCE,
     {MR_TOO_FEW, MR_TOO_FEW, MR_WAIT,
      RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT, [DONE] = MR_TOO_FEW}},
    {"config-read", ANYBODY, {RECORDING(MR_NOT_NOW)}},
    {"camera", ANYBODY, {0}},
    {"box-list", ANYBODY, {[CLOSING] = MR_WAIT}},
    {/* record 1 */ "box-read 32768",
     ANYBODY,
     {MR_UNKNOWN, MR_UNKNOWN, MR_UNKNOWN, RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT}},
    {"box-free 9",
     MAINTENANCE,
     {MR_UNKNOWN, MR_UNKNOWN, MR_UNKNOWN,
      RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT, [DONE] = MR_UNKNOWN}},
    {"live 1", ANYBODY, {RECORDING(MR_NOT_NOW), [CLOSING] = MR_NOT_NOW, [DONE] = MR_NOT_NOW}},
    {"backlog 9",
     REPLAYS,
     {MR_NOT_NOW, MR_NOT_NOW, MR_NOT_NOW,
      RECORDING(LATER), [CLOSING] = MR_NOT_NOW, [DONE] = MR_NOT_NOW}},
    {"runway-read", ANYBODY, {RECORDING(MR_NOT_NOW)}},
    {"runway-word 0 1", OPERATOR, {RECORDING(MR_NOT_NOW)}},
    {"runway-joints 0 1", OPERATOR, {RECORDING(MR_NOT_NOW)}},
    {"runway-take 1",
     OPERATOR,
     {MR_CRC, MR_CRC, MR_CRC, RECORDING(MR_NOT_NOW), [CLOSING] = MR_CRC, [DONE] = MR_CRC}},
    {"chart-word 0 1", OPERATOR, {RECORDING(MR_NOT_NOW)}},
    {"chart-take 1",
     OPERATOR,
     {MR_CRC, MR_CRC, MR_CRC, RECORDING(MR_NOT_NOW), [CLOSING] = MR_CRC, [DONE] = MR_CRC}},
    {"chart-forget", OPERATOR, {RECORDING(MR_NOT_NOW)}},
    {"runway-forget", OPERATOR, {RECORDING(MR_NOT_NOW)}},
    {"key-set 1",
     STARTS,
     {MR_TOO_FEW, MR_TOO_FEW, MR_TOO_FEW,
      RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT, [DONE] = MR_TOO_FEW}},
    {"key-clear",
     STARTS,
     {LATER, LATER, LATER, RECORDING(MR_NOT_NOW), [CLOSING] = MR_WAIT, [DONE] = LATER}},
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
    for (unsigned n = 0; n < 5000 && blackbox_check_ready(&app.box) != MR_OK; n++)
        pass(1);
    pass(1000); /* the runway is looked for */
    assert_int_equal(blackbox_check_ready(&app.box), MR_OK);
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

/* The circumstances, as bits. */
enum { BY_SERIAL = 1, JUMPER = 2, REPLAYING = 4, KEY = 8, PROOF = 16, RIGHT = 32, ALL_WAYS = 64 };

static bool has_right(int right, unsigned way)
{
    if (right == OPERATOR)
        return !(way & KEY) || (way & (PROOF | RIGHT)) == (PROOF | RIGHT);
    return right == MAINTENANCE ? way & (BY_SERIAL | JUMPER)
         : right == STARTS      ? (way & (BY_SERIAL | JUMPER)) == (BY_SERIAL | JUMPER)
         : right == REPLAYS     ? way & REPLAYING
                                : true;
}

/* The command, and the proof before it, go out by serial in place of CAN. */
static void move_to_serial(void)
{
    fake.serial_in_taken = fake.serial_in_count = 0;
    for (size_t i = 0; i < fake.received_count; i++) {
        const struct board_can_frame *frame = &fake.received[i];
        fake.serial_in_count += mr_frame_encode(0, frame->id, frame->data, frame->length,
                                                fake.serial_in + fake.serial_in_count);
    }
    fake.received_count = 0;
}

static void prove(bool right)
{
    const struct board_can_frame *order = &fake.received[0];
    struct board_can_frame *frame = &fake.received[fake.received_count++];
    frame[0] = *order;
    frame = &fake.received[0];
    frame->id = MR_ID_PROOF;
    frame->length = MR_PROOF_BYTES;
    mr_proof_compute(frame->data, app.keystore.key, app.proof.nonce, frame[1].data,
                     app.telemetry.identity.uid);
    frame->data[3] ^= !right;
}

/* The board as it was kept is given a command; its answer, or LATER. */
static int answer_to(const char *words, unsigned way)
{
    struct mr_ack ack;
    app = kept_app;
    fake = kept_fake;
    index_now = kept_index;
    fake.jumper = way & JUMPER;
    app.is_replay = way & REPLAYING;
    if (way & KEY) {
        app.keystore.state = MR_KEY_SET;
        memset(app.keystore.key, 0x5a, MR_KEY_BYTES);
        proof_on_second(&app.proof, &app.keystore, &app.telemetry);
    }
    fake.sent_count = 0;
    fake.received_count = fake.received_taken = 0;
    command(words);
    if (way & PROOF)
        prove(way & RIGHT);
    if (way & BY_SERIAL)
        move_to_serial();
    play(1);
    if (app.keystore.is_in_progress) /* the kept board knows nothing of it */
        fake_nor.operation = 0;
    if (!count_frames(MR_ID_ACK))
        return LATER;
    GET_LAST(ack, ACK, &ack);
    return ack.status;
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
        for (unsigned i = 0; i < COUNT_OF(table) * ALL_WAYS; i++) {
            const struct row *row = &table[i / ALL_WAYS];
            unsigned way = i % ALL_WAYS;
            bool told = has_right(row->right, way) ||
                        (row->status[s] == MR_NOT_NOW && row->right != OPERATOR);
            int answer = answer_to(row->words, way), wanted = told ? row->status[s] : row->right;
            if (answer != wanted)
                fail_msg("%s while %s, circumstances %u: %d, not %d", row->words, state_name[s],
                         way, answer, wanted);
        }
    }
}

/* A word of a configuration that comes over CAN is taken with the jumper alone. */
TEST_IN(words_of_a_configuration_are_maintenance, start_whole, put_back)
{
    for (unsigned jumper = 0; jumper < 2; jumper++) {
        const struct mr_config_word word = {.offset = 15, .tag = 7, .value = 1};
        struct board_can_frame *frame = &fake.received[fake.received_count++];
        struct mr_config_staged staged;
        fake.jumper = jumper;
        frame->id = MR_ID_CONFIG_WORD;
        frame->length = (uint8_t)mr_config_word_put(&word, frame->data);
        pass(1);
        GET_LAST(config_staged, CONFIG_STAGED, &staged);
        assert_int_equal(staged.locked, jumper ? 0 : 2);
        assert_int_equal(staged.words, jumper);
    }
}

/* Every code of the catalogue is a row above. */
TEST(the_table_is_whole)
{
    for (unsigned code = 1; code < 256; code++) {
        const char *name = mr_command_name(code);
        bool found = strcmp(name, "unknown") == 0;
        for (unsigned r = 0; r < COUNT_OF(table); r++)
            found |= strncmp(table[r].words, name, strlen(name)) == 0;
        if (!found)
            fail_msg("%s", name);
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
