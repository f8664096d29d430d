/* What firmware/schedule.def makes of itself: rounds, bursts, without scans. That each message has
 * its block, the golden landings see (tests/golden). */
#include "firmware/schedule.h"
#include "tests/firmware/play.h"

#define SUPERVISIONS_PER_S 100u

/* A configuration goes round, an item each 40 blocks, in blocks in which nothing else of it
 * goes. */
TEST_IN(the_configuration_goes_round, start, NULL)
{
    play(20000);
    fake.sent_count = fake.serial_count = 0;
    play(9000);
    unsigned items = 0;
    for (size_t i = 0; i < fake.sent_count; i++) {
        uint16_t id = fake.sent[i].id;
        if (id != MR_ID_CHANNEL && id != MR_ID_SWITCH_PLACE && id != MR_ID_SLACK &&
            id != MR_ID_CALIBRATION && id != MR_ID_PREDICT_ITEM)
            continue;
        assert_int_equal(fake.sent_block[i] % 40u, 7);
        items++;
    }
    assert_true(items >= 225);
}

/* Without scans the same round each second, but for what a block is needed for. */
TEST_IN(without_scans_a_round_is_told_each_second, start, NULL)
{
    static const struct {
        uint16_t id;
        unsigned times;
    } round[] = {
        /* every other count of messages falls into the round */
        {MR_ID_HEALTH, 10},   {MR_ID_CAN_HEALTH, 10},  {MR_ID_SERIAL_HEALTH, 10}, {MR_ID_HELLO, 1},
        {MR_ID_LANDING, 1},   {MR_ID_CAN_ALARM, 1},    {MR_ID_CAN_DROPS, 1},      {MR_ID_UPKEEP, 1},
        {MR_ID_RESTARTS, 1},  {MR_ID_CLOCK, 0},        {MR_ID_MESSAGE_COUNT, 10}, {MR_ID_SYNC, 0},
        {MR_ID_BOX_STATE, 0}, {MR_ID_RUNWAY_STORE, 0}, {MR_ID_CHANNEL, 0},
    };
    /* of each tenth */
    static const uint16_t order[] = {MR_ID_HEALTH, MR_ID_CAN_HEALTH, MR_ID_SERIAL_HEALTH};
    play(20000);
    for (unsigned i = 0; i < SUPERVISIONS_PER_S - 1; i++)
        app_supervise(&app);
    fake.sent_count = fake.serial_count = 0;
    app_supervise(&app);
    for (size_t i = 0; i < COUNT_OF(round); i++)
        assert_int_equal(count_frames(round[i].id), round[i].times);
    for (size_t i = 0, next = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id != order[0] && fake.sent[i].id != order[1] &&
            fake.sent[i].id != order[2])
            continue;
        assert_int_equal(fake.sent[i].id, order[next++ % 3]);
    }
    size_t sent = fake.sent_count;
    for (unsigned i = 0; i < SUPERVISIONS_PER_S - 1; i++)
        app_supervise(&app);
    unsigned between = (unsigned)(fake.sent_count - sent);
    app_supervise(&app);
    assert_int_equal(count_frames(MR_ID_HELLO), 2);
    assert_true(between <= 1); /* a state of CAN that changed */
}

/* A burst goes on without scans: 42 items a second. */
TEST_IN(a_burst_goes_on_without_scans, start, NULL)
{
    play(20000);
    command("state");
    for (unsigned i = 0; i < SUPERVISIONS_PER_S - 1; i++)
        app_supervise(&app);
    fake.sent_count = fake.serial_count = 0;
    app_supervise(&app);
    assert_int_equal(count_frames(MR_ID_CHANNEL) + count_frames(MR_ID_SWITCH_PLACE) +
                         count_frames(MR_ID_SLACK),
                     42);
    assert_int_equal(count_frames(MR_ID_CHANNEL), 24);
}

/* While other boards fill the bus, what is told in a row waits, and readings go on; then it is told
 * to its end. */
TEST_IN(a_burst_waits_for_the_bus, start, NULL)
{
    play(20000);
    command("state");
    play(1); /* hello, and the first item */
    fake.can_waiting = 65;
    fake.sent_count = fake.serial_count = 0;
    play(300);
    assert_int_equal(count_frames(MR_ID_CHANNEL), 0);
    assert_int_equal(count_frames(MR_ID_DISPLACEMENT_1_3), 3); /* ten a second while idle */
    fake.can_waiting = 0;
    play(1);
    fake.can_waiting = 64;
    fake.sent_count = fake.serial_count = 0;
    play(300);
    assert_in_range(count_frames(MR_ID_CHANNEL), 23, 32); /* and the slow round behind it */
    assert_in_range(count_frames(MR_ID_SWITCH_PLACE), 24, 32);
    /* a bus that stays full: serial has it after 2 s */
    command("state");
    play(1);
    fake.can_waiting = 200;
    fake.sent_count = fake.serial_count = 0;
    play(2500);
    assert_in_range(count_frames(MR_ID_CHANNEL), 23, 60);
}

/* Regular messages are spread: two rows in a block at most, three in one block of a second. */
TEST(no_block_has_a_burst_of_its_own)
{
    unsigned crowded = 0;
    for (uint32_t index = 0; index < 1000; index++) {
        const char *first = "none";
        unsigned due = 0;
#define BLOCKS(NAME, period, phase, stalled, who, why)                                       \
    if ((period) >= 40 && SCHEDULE_##NAME##_PHASE > 1 && strcmp(#NAME, "ALL_FAULTS") != 0 && \
        DUE(NAME, index))                                                                    \
        due++, first = #NAME;
#define TICKS(NAME, period, phase, who, why)
#include "firmware/schedule.def"
        if (due > 3)
            fail_msg("%u rows in block %u, one of them %s", due, index, first);
        crowded += due == 3;
    }
    assert_int_equal(crowded, 1);
}
