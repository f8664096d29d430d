/* A board whose configuration gives it a base on the CAN bus: what is on the bus, what it obeys,
 * and when it moves. The firmware as it is, with its driver. */
#include "common/canbase.h"
#include "common/config.h"
#include "common/fault.h"
#include "common/wire.h"
#include "firmware/config.h"
#include "hil/board/board.h"
#include "tests/hil/ear.h"

#define COPY_A 0x08008000u
#define BASE   0x1d0u

static struct on_bus {
    unsigned frames, strange; /* of no message of the catalogue, at the base that is heard */
    bool follows;             /* from the answer to config-apply on, to the base `then` */
    uint16_t then;
    uint16_t first_id; /* behind it */
    uint64_t answered_ps;
} bus;

static void on_can(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct ear *ear = ctx;
    /* by hand, not as the firmware does it */
    int id = (int)frame->id - (int)ear->can_base;
    const struct mr_message_info *info = id < 0 ? NULL : mr_message_find((uint16_t)id);
    bus.frames++;
    if (frame->is_extended || frame->is_remote || !info || info->length != frame->length ||
        info->direction == MR_DIRECTION_HOST)
        bus.strange++;
    ear_can(ctx, t_ps, frame);
    if (bus.answered_ps && !bus.first_id)
        bus.first_id = (uint16_t)id;
    if (bus.follows && id == MR_ID_ACK && frame->data[0] == MR_COMMAND_CONFIG_APPLY) {
        ear->can_base = bus.then;
        bus.follows = false;
        bus.answered_ps = t_ps;
    }
}

static struct ear *open_at(unsigned base, bool stored)
{
    struct ear *ear = ear_open(NULL, 0);
    struct hil_callbacks callbacks = {ear, on_can, ear_serial};
    static uint8_t image[MR_CONFIG_IMAGE_BYTES];
    bus = (struct on_bus){0};
    hil_board_set_callbacks(ear->board, &callbacks);
    struct mr_config given = config; /* what is built in */
    given.site[0].revision = 1;
    given.site[0].can_base = (uint16_t)base;
    mr_config_encode(&given, image);
    if (stored)
        assert_int_equal(hil_board_poke(ear->board, COPY_A, image, sizeof image), MR_OK);
    ear->can_base = (uint16_t)base;
    return ear;
}

static void pass(struct ear *ear, double s)
{
    ear_until(ear, (double)hil_board_now_ps(ear->board) * 1e-12 + s);
}

static void forget(struct ear *ear)
{
    memset(ear->heard, 0, sizeof ear->heard);
    bus.frames = 0;
}

/* A mark over CAN at `base`: did the board obey? It answers on both links, or on none. */
static bool obeys_at(struct ear *ear, unsigned base)
{
    static uint16_t tag = 900;
    uint16_t own = ear->can_base;
    struct mr_ack ack;
    unsigned before[EAR_LINKS] = {ear->heard[EAR_CAN][MR_ID_ACK],
                                  ear->heard[EAR_SERIAL][MR_ID_ACK]};
    ear->can_base = (uint16_t)base;
    ear_command(ear, EAR_CAN, MR_COMMAND_MARK, 1, ++tag);
    ear->can_base = own;
    pass(ear, 0.03);
    bool answered = ear->heard[EAR_SERIAL][MR_ID_ACK] != before[EAR_SERIAL];
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_ACK] != before[EAR_CAN], answered);
    if (answered) {
        assert_int_equal(mr_ack_get(&ack, ear->last[EAR_CAN][MR_ID_ACK], MR_MESSAGE_BYTES_MAX),
                         MR_OK);
        assert_int_equal(ack.tag, tag);
    }
    return answered;
}

/* All that serial says is on CAN too, at the base: the links lose nothing here. */
static void says_all_at_its_base(struct ear *ear)
{
    size_t count;
    const struct mr_message_info *messages = mr_catalogue_messages(&count);
    for (size_t i = 0; i < count; i++) {
        int more = (int)ear->heard[EAR_SERIAL][messages[i].id] -
                   (int)ear->heard[EAR_CAN][messages[i].id];
        if (more > 1 || (more < -1 && messages[i].direction == MR_DIRECTION_BOTH))
            fail_msg("%s: %u times on CAN, %u times on serial", messages[i].name,
                     ear->heard[EAR_CAN][messages[i].id], ear->heard[EAR_SERIAL][messages[i].id]);
    }
    assert_int_equal(bus.strange, 0);
    assert_true(bus.frames > 100);
    assert_true(ear->heard[EAR_CAN][MR_ID_HELLO] > 0);
}

TEST(a_stored_base_is_that_of_every_frame)
{
    struct ear *ear = open_at(BASE, true);
    /* they wait for the bus: the first comes as soon as the controller is on it */
    struct hil_can_frame other = {.id = MR_ID_COMMAND, .length = 8};
    struct mr_command message = {.code = MR_COMMAND_MARK, .argument = 1, .tag = 1};
    other.length = (uint8_t)mr_command_put(&message, other.data);
    for (unsigned i = 0; i < 40; i++)
        assert_int_equal(hil_can_inject(&ear->board->mcu.can, &other), MR_OK);
    ear_until(ear, 2.5);
    assert_int_equal(hil_board_counters(ear->board)->can_frames_in, 40);
    assert_int_equal(ear->heard[EAR_SERIAL][MR_ID_ACK], 0); /* they are for another board */
    says_all_at_its_base(ear);
    struct mr_sync_at sync_at;
    assert_true(ear->heard[EAR_CAN][MR_ID_SYNC_AT] > 0);
    assert_int_equal(mr_sync_at_get(&sync_at, ear->last[EAR_CAN][MR_ID_SYNC_AT], 8), MR_OK);
    assert_int_equal(sync_at.sent, 1);
    assert_false(obeys_at(ear, 0));
    assert_false(obeys_at(ear, BASE - 1));
    assert_false(obeys_at(ear, BASE + 1)); /* config_word here */
    assert_true(obeys_at(ear, BASE));
    ear_close(ear);
}

/* By command, and by the power. */
TEST(it_survives_resets)
{
    struct ear *ear = open_at(BASE, true);
    ear_until(ear, 1.0);
    ear_command(ear, EAR_CAN, MR_COMMAND_RESET, 0, 5);
    pass(ear, 0.5);
    assert_int_equal(hil_board_counters(ear->board)->resets, 1);
    pass(ear, 1.0);
    assert_true(obeys_at(ear, BASE));
    hil_supply_cut(&ear->board->supply);
    pass(ear, 2.0);
    assert_int_equal(hil_board_counters(ear->board)->power_cuts, 1);
    assert_false(obeys_at(ear, 0));
    assert_true(obeys_at(ear, BASE));
    says_all_at_its_base(ear);
    ear_close(ear);
}

/* The bus is shorted until the controller is off, then mended: the filter is still the board's. */
TEST(it_survives_bus_off)
{
    struct ear *ear = open_at(BASE, true);
    ear_until(ear, 1.0);
    hil_can_set_bus(&ear->board->mcu.can, HIL_CAN_SHORTED);
    pass(ear, 1.0);
    struct mr_can_alarm alarm;
    assert_int_equal(mr_can_alarm_get(&alarm, ear->last[EAR_SERIAL][MR_ID_CAN_ALARM], 8), MR_OK);
    assert_int_equal(alarm.state, MR_CAN_OFF);
    hil_can_set_bus(&ear->board->mcu.can, HIL_CAN_CONNECTED);
    pass(ear, 1.0);
    assert_int_equal(bus.strange, 0);
    assert_false(obeys_at(ear, 0));
    assert_true(obeys_at(ear, BASE));
    ear_close(ear);
}

/* The words of a configuration at `base`, over either link, and its order to be in force. */
static void give(struct ear *ear, unsigned link, unsigned base)
{
    static uint8_t image[MR_CONFIG_IMAGE_BYTES];
    static uint16_t tag = 300, seq;
    struct mr_config next = config;
    tag++;
    next.site[0].revision = tag - 300u;
    next.site[0].can_base = (uint16_t)base;
    uint32_t crc = mr_config_encode(&next, image);
    for (unsigned i = 0; i < MR_CONFIG_WORDS; i++) {
        struct hil_can_frame frame = {.id = ear->can_base + MR_ID_CONFIG_WORD, .length = 8};
        uint8_t bytes[MR_FRAME_BYTES_MAX];
        const uint8_t *p = image + 4 * i;
        struct mr_config_word word = {.offset = (uint16_t)i, .tag = tag, .value = mr_get_u32(&p)};
        size_t n = mr_config_word_put(&word, frame.data);
        if (link == EAR_CAN)
            assert_int_equal(hil_can_inject(&ear->board->mcu.can, &frame), MR_OK);
        else
            assert_int_equal(
                hil_usart_inject(&ear->board->mcu.usart, bytes,
                                 mr_frame_encode(seq++, MR_ID_CONFIG_WORD, frame.data, n, bytes)),
                MR_OK);
        if (i % 16 == 15)
            pass(ear, 0.012);
    }
    pass(ear, 0.012);
    bus.follows = true;
    bus.then = (uint16_t)base;
    bus.first_id = 0;
    bus.answered_ps = 0;
    ear_command(ear, link, MR_COMMAND_CONFIG_APPLY, (int32_t)crc, tag);
    pass(ear, 0.75);
    struct mr_ack ack;
    assert_int_equal(mr_ack_get(&ack, ear->last[EAR_CAN][MR_ID_ACK], MR_MESSAGE_BYTES_MAX), MR_OK);
    assert_int_equal(ack.tag, tag);
    assert_int_equal(ack.status, MR_OK);
}

/* Everything up to the answer is at the old base, everything behind it at the new, hello first.
 * Bases move up, by one alone, to the last, and back. */
TEST(it_moves_behind_the_answer)
{
    static const unsigned bases[] = {BASE, BASE + 1, MR_CAN_BASE_MAX, 0};
    struct ear *ear = open_at(0, false);
    unsigned before = 0;
    ear_until(ear, 1.0);
    for (unsigned i = 0; i < COUNT_OF(bases); i++) {
        give(ear, i % 2 ? EAR_SERIAL : EAR_CAN, bases[i]);
        assert_int_equal(ear->can_base, bases[i]); /* the answer came at the old one */
        assert_int_equal(bus.first_id, MR_ID_HELLO);
        assert_int_equal(bus.strange, 0);
        forget(ear);
        assert_false(obeys_at(ear, before));
        assert_true(obeys_at(ear, bases[i]));
        pass(ear, 2.2);
        says_all_at_its_base(ear);
        before = bases[i];
    }
    ear_close(ear);
}
