/* When each periodic message goes out: idle, armed, without scans. The blocks are written here once
 * more, as a candump log of the board shows them, so that a row of firmware/schedule.def that moves
 * is seen. */
#include "firmware/schedule.h"
#include "tests/firmware/play.h"

#define SECONDS            4u
#define SUPERVISIONS_PER_S 100u

struct expected {
    uint16_t id;
    unsigned period, phase;
};

/* In every state. */
static const struct expected always[] = {
    {MR_ID_CLOCK, 100, 3},          {MR_ID_HEALTH, 100, 23},         {MR_ID_CAN_HEALTH, 100, 43},
    {MR_ID_SERIAL_HEALTH, 100, 63}, {MR_ID_MESSAGE_COUNT, 50, 33},   {MR_ID_SYNC, 1000, 253},
    {MR_ID_SYNC_AT, 1000, 263},     {MR_ID_BOX_STATE, 1000, 313},    {MR_ID_CAN_ALARM, 1000, 323},
    {MR_ID_CAN_DROPS, 1000, 343},   {MR_ID_UPKEEP, 1000, 363},       {MR_ID_RESTARTS, 1000, 383},
    {MR_ID_HELLO, 1000, 513},       {MR_ID_RUNWAY_STORE, 1000, 613}, {MR_ID_LANDING, 1000, 713},
};
static const struct expected idle[] = {
    {MR_ID_DISPLACEMENT_1_3, 100, 0},
    {MR_ID_TENSION_1_3, 100, 1},
    {MR_ID_BAND_STATE, 1000, 1},
};
static const struct expected armed[] = {
    {MR_ID_DISPLACEMENT_1_3, 2, 0},
    {MR_ID_TENSION_1_3, 4, 1},
    {MR_ID_BAND_STATE, 100, 1},
    {MR_ID_ZONE, 50, 0},
};

/* From block `from` on, so many seconds: at each block it is due, at no other. Two bands: two
 * frames of BAND_STATE. */
static void check(const struct expected *e, uint32_t from)
{
    unsigned due = 0, told = 0;
    for (uint32_t index = from; index < from + 1000u * SECONDS; index++)
        due += index % e->period == e->phase;
    for (size_t i = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id != e->id || fake.sent_block[i] < from)
            continue;
        if (fake.sent_block[i] % e->period != e->phase)
            fail_msg("message 0x%03x in block %u, expected in %u of each %u", e->id,
                     fake.sent_block[i], e->phase, e->period);
        told++;
    }
    assert_int_equal(told, due * (e->id == MR_ID_BAND_STATE ? 2u : 1u));
}

TEST_IN(each_message_has_its_block, start, NULL)
{
    uint32_t from = 20000; /* the start's burst is over */
    play(from);
    fake.sent_count = fake.serial_count = 0;
    play(1000 * SECONDS);
    for (size_t i = 0; i < COUNT_OF(always); i++)
        check(&always[i], from);
    for (size_t i = 0; i < COUNT_OF(idle); i++)
        check(&idle[i], from);
    assert_int_equal(count_frames(MR_ID_CHANNEL_QUALITY), 0);
    command("arm 7");
    play(2000);
    from = index_now;
    fake.sent_count = fake.serial_count = 0;
    play(1000 * SECONDS);
    for (size_t i = 0; i < COUNT_OF(always); i++)
        check(&always[i], from);
    for (size_t i = 0; i < COUNT_OF(armed); i++)
        check(&armed[i], from);
    /* 8 transducers, 14 gages, each once a second */
    assert_int_equal(count_frames(MR_ID_CHANNEL_QUALITY), 22 * SECONDS);
    for (size_t i = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id == MR_ID_CHANNEL_QUALITY)
            assert_int_equal(fake.sent_block[i] % 40u, 14);
    }
}

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
