/* The base of the CAN identifiers: before anything is sent, and behind the answer to the command
 * that changes it. */
#include "tests/firmware/play.h"

#include "common/canbase.h"
#include "common/framing.h"
#include "tests/firmware/fake_flash.h"

static struct mr_config built_in;
static bool built_in_known;

static int fresh(void **state)
{
    (void)state;
    if (!built_in_known)
        built_in = config;
    built_in_known = true;
    config = built_in;
    fake_flash_reset();
    fake_reset();
    index_now = 0;
    return 0;
}

/* As at reset. */
static void restart(void)
{
    config = built_in;
    fake_reset();
    app_start(&app);
    index_now = 0;
}

static void store_base(unsigned base)
{
    struct mr_config stored = built_in;
    stored.site[0].revision = 1;
    stored.site[0].can_base = (uint16_t)base;
    mr_config_encode(&stored, fake_flash.cell[0]);
}

/* As if all its words had come. */
static enum mr_status apply(unsigned base, bool serial)
{
    struct mr_config next = config;
    uint8_t payload[MR_MESSAGE_MAX];
    struct mr_ack ack;
    next.site[0].revision++;
    next.site[0].can_base = (uint16_t)base;
    struct mr_command message = {.code = MR_COMMAND_CONFIG_APPLY, .tag = 77};
    message.argument = (int32_t)mr_config_encode(&next, app.configstore.image);
    app.configstore.words = MR_CONFIG_WORDS;
    app.configstore.staging = true;
    size_t length = mr_command_put(&message, payload);
    fake.received_count = fake.received_taken = fake.serial_in_count = fake.serial_in_taken = 0;
    if (serial) {
        fake.serial_in_count = mr_frame_encode(0, MR_ID_COMMAND, payload, length, fake.serial_in);
    } else {
        struct board_can_frame *frame = &fake.received[fake.received_count++];
        *frame = (struct board_can_frame){.id = MR_ID_COMMAND, .length = (uint8_t)length};
        memcpy(frame->data, payload, length);
    }
    fake.sent_count = 0;
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.tag, 77);
    return (enum mr_status)ack.status;
}

static size_t place_of_ack(void)
{
    size_t i = 0;
    while (i < fake.sent_count && fake.sent[i].id != MR_ID_ACK)
        i++;
    assert_true(i < fake.sent_count);
    return i;
}

static void all_are_at(size_t from, size_t to, unsigned base)
{
    assert_true(from < to);
    for (size_t i = from; i < to; i++)
        assert_int_equal(fake.sent_base[i], base);
}

TEST_IN(what_is_built_in_is_0, fresh, NULL)
{
    restart();
    play(100);
    assert_int_equal(fake.moves, 1); /* or the controller lets nothing in */
    all_are_at(0, fake.sent_count, 0);
}

TEST_IN(a_stored_base_is_there_before_the_first_message, fresh, NULL)
{
    store_base(0x1d0);
    for (unsigned round = 0; round < 2; round++) { /* whatever the restart was for */
        restart();
        play(100);
        assert_int_equal(fake.moves, 1);
        assert_true(count_frames(MR_ID_HELLO) > 0);
        all_are_at(0, fake.sent_count, 0x1d0);
    }
}

/* Over either link: the answer is the last message at the old base, hello the first at the new. */
TEST_IN(the_answer_goes_where_the_command_came, fresh, NULL)
{
    static const unsigned bases[] = {0x190, 0x3c0, 0, MR_CAN_BASE_MOST};
    unsigned before = 0;
    restart();
    for (unsigned i = 0; i < COUNT_OF(bases); i++) {
        assert_int_equal(apply(bases[i], i % 2), MR_OK);
        size_t ack = place_of_ack();
        play(50);
        assert_int_equal(fake.moves, 2 + i);
        all_are_at(0, ack + 1, before);
        all_are_at(ack + 1, fake.sent_count, bases[i]);
        assert_int_equal(fake.sent[ack + 1].id, MR_ID_HELLO);
        before = bases[i];
    }
    restart();
    all_are_at(0, fake.sent_count, MR_CAN_BASE_MOST);
}

TEST_IN(another_change_moves_nothing, fresh, NULL)
{
    store_base(0x190);
    restart();
    assert_int_equal(apply(0x190, false), MR_OK);
    play(50);
    assert_int_equal(fake.moves, 1);
    assert_int_equal(count_frames(MR_ID_HELLO), 1);
}

TEST_IN(what_is_refused_moves_nothing, fresh, NULL)
{
    struct mr_config_refused refused;
    restart();
    assert_int_equal(apply(MR_CAN_BASE_MOST + 1u, false), MR_LIMIT);
    GET_LAST(config_refused, CONFIG_REFUSED, &refused);
    assert_int_equal(refused.group, MR_GROUP_site);
    assert_int_equal(refused.field, MR_FIELD_site_can_base);
    fake_flash.broken = true;
    assert_int_equal(apply(0x190, true), MR_IO);
    play(50);
    assert_int_equal(fake.moves, 1);
    all_are_at(0, fake.sent_count, 0);
}

/* Serial has no base, and a board that keeps off the bus none either. */
TEST_IN(a_silent_board_is_silent_at_any_base, fresh, NULL)
{
    store_base(0x190);
    config = built_in;
    fake_reset();
    fake.clock_source = BOARD_CLOCK_INTERNAL;
    app_start(&app);
    index_now = 0;
    play(50);
    assert_int_equal(fake.sent_count, 0);
    assert_true(fake.serial_count > 0);
}
