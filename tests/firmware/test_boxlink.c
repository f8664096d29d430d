/* The black box over the links: refusals, a landing armed, recorded, listed, read out and freed, as
 * a host sees it. */
#include "tests/firmware/play.h"

#include "common/boxpage.h"
#include "common/framing.h"
#include "firmware/config.h"
#include "tests/firmware/fake_nor.h"

#define PAGES_MAX 2000u

static uint8_t pages[PAGES_MAX][MR_BOXPAGE_BYTES], present[PAGES_MAX];
static size_t page_count;

/* The memory's clock goes with the blocks. */
static void pass(unsigned blocks)
{
    while (blocks--) {
        play_block();
        fake_nor.now_us += 1000;
        app_poll(&app);
    }
}

static enum mr_status ask(const char *words)
{
    struct mr_ack ack;
    fake.received_count = fake.received_taken = 0;
    command(words);
    pass(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.tag, 1);
    return (enum mr_status)ack.status;
}

static int begin(void **state)
{
    fake_nor_reset();
    start(state);
    memset(present, 0, sizeof present);
    page_count = 0;
    return 0;
}

/* Arming waits for space and says so. */
static void arm_when_ready(const char *words)
{
    for (unsigned n = 0; n < 10000; n++) {
        unsigned told = count_frames(MR_ID_BOX_STATE);
        enum mr_status status = ask(words);
        if (status == MR_OK)
            return;
        assert_int_equal(status, MR_WAIT);
        assert_true(count_frames(MR_ID_BOX_STATE) > told); /* with the time remaining */
    }
    fail_msg("never ready");
}

/* Seven switches at 28 ft/s and slower, then rest: a landing. */
static void land(void)
{
    for (unsigned position = 1; position < 8; position++) {
        pass_switch(position, ((double)index_now - 0.5) * 1e-3);
        pass(position < 3 ? 178 : 178 + 20 * position);
    }
    pass(8000);
    assert_int_equal(app.landing.state, MR_LANDING_DONE);
}

/* Pages and the end from what serial carried. Returns the pages that the end told; 0: no end. */
static unsigned collect(void)
{
    static struct mr_deframer deframer;
    unsigned told = 0;
    mr_deframer_init(&deframer);
    for (size_t i = 0; i < fake.serial_count; i++) {
        struct mr_frame frame;
        struct mr_box_end end;
        if (mr_deframer_push(&deframer, fake.serial[i], &frame) != MR_OK)
            continue;
        if (frame.type == MR_ID_BOX_PART) {
            unsigned record = frame.payload[0] | (unsigned)frame.payload[1] << 8,
                     page = frame.payload[2] | (unsigned)frame.payload[3] << 8;
            assert_int_equal(frame.length, MR_BOX_PART_BYTES);
            assert_int_equal(record, 1);
            assert_true(page < PAGES_MAX && frame.payload[4] < 2);
            memcpy(pages[page] + 128 * frame.payload[4], frame.payload + 6, 128);
            present[page] = (uint8_t)(present[page] | 1u << frame.payload[4]);
            page_count = page + 1u > page_count ? page + 1u : page_count;
        } else if (frame.type == MR_ID_BOX_END) {
            assert_int_equal(mr_box_end_get(&end, frame.payload, frame.length), MR_OK);
            assert_int_equal(end.record, 1);
            told = end.pages;
        }
    }
    return told;
}

static unsigned check_pages(uint32_t trigger)
{
    struct mr_boxpage_header header;
    struct mr_boxpage_start_page first;
    struct mr_box_reader reader;
    struct mr_record record;
    unsigned blocks = 0;
    for (size_t i = 0; i < page_count; i++) {
        assert_int_equal(present[i], 3);
        assert_int_equal(mr_boxpage_check(pages[i], &header), MR_OK);
        assert_int_equal(header.record, 1);
    }
    mr_boxpage_get_start(pages[0], &first);
    assert_int_equal(first.landing, 7);
    /* with the second edge */
    assert_true(first.trigger_block >= trigger && first.trigger_block < trigger + 400);
    mr_box_reader_begin(&reader, pages[0], present, page_count);
    while (mr_box_reader_next(&reader, &record) == MR_OK)
        blocks += record.kind == MR_RECORD_BLOCK;
    return blocks;
}

static unsigned list(struct mr_box_record *record)
{
    unsigned count = 0;
    fake.sent_count = 0;
    assert_int_equal(ask("box-list"), MR_OK);
    pass(100);
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_box_record each;
        if (fake.sent[i].id != MR_ID_BOX_RECORD)
            continue;
        assert_int_equal(mr_box_record_get(&each, fake.sent[i].data, fake.sent[i].length), MR_OK);
        if (each.record) {
            *record = each;
            count++;
        }
    }
    assert_int_equal(count_frames(MR_ID_BOX_RECORD), count + 1); /* and one that ends the list */
    return count;
}

TEST_IN(a_landing_is_listed_read_out_and_freed, begin, NULL)
{
    struct mr_box_record record = {0};
    struct mr_box_span span;
    arm_when_ready("arm 7");
    /* what there is can be told at any time; the memory is the landing's from arm to done */
    assert_int_equal(list(&record), 0);
    assert_int_equal(ask("box-read 32768"), MR_NOT_NOW);
    assert_int_equal(ask("box-free 1"), MR_NOT_NOW);
    /* a configuration leaves two pages free */
    assert_true(app.box.is_configuring && app.box.config_pages_closed + 2 < BLACKBOX_CONFIG_PAGES);
    pass(1500);
    uint32_t trigger = index_now;
    land();
    assert_int_equal(ask("disarm"), MR_OK);
    assert_int_equal(list(&record), 1);
    assert_int_equal(record.record, 1);
    assert_int_equal(record.landing, 7);
    assert_int_equal(record.complete, 1);
    GET_LAST(box_span, BOX_SPAN, &span);
    assert_int_equal(span.lost, 0);

    fake.serial_count = 0;
    assert_int_equal(ask("box-read 32768"), MR_OK); /* record 1 from page 0 on */
    pass(2 * PAGES_MAX);
    assert_int_equal(collect(), record.pages);
    assert_int_equal(page_count, record.pages);
    assert_in_range(span.blocks, 5000, 12000);
    assert_int_equal(check_pages(trigger), span.blocks);

    /* and once more from page 5 on: what a host asks for after a pulled cable */
    fake.serial_count = 0;
    memset(present, 0, sizeof present);
    assert_int_equal(ask("box-read 32773"), MR_OK);
    pass(2 * PAGES_MAX);
    assert_int_equal(collect(), record.pages);
    for (size_t i = 0; i < page_count; i++)
        assert_int_equal(present[i], i < 5 ? 0 : 3);

    assert_int_equal(ask("box-free 2"), MR_UNKNOWN);
    assert_int_equal(ask("box-free 1"), MR_OK);
    pass(3000);
    assert_int_equal(list(&record), 0);
    assert_int_equal(ask("box-read 32768"), MR_UNKNOWN);
}

/* What the record of a landing has, and CAN in the same time: each message that a replay needs is
 * in both, as often; what the board says of itself by the way is in none of the record. */
TEST_IN(the_record_holds_what_a_landing_needs, begin, NULL)
{
    static const uint16_t needed[] = {MR_ID_ZONE,
                                      MR_ID_ZONE_LEAD,
                                      MR_ID_VERDICT,
                                      MR_ID_TRUST,
                                      MR_ID_EDGE,
                                      MR_ID_MOTION,
                                      MR_ID_MOTION_ERROR,
                                      MR_ID_LANDING,
                                      MR_ID_TOUCHDOWN,
                                      MR_ID_STOP,
                                      MR_ID_MARK,
                                      MR_ID_ACK,
                                      MR_ID_CHANNEL_QUALITY,
                                      MR_ID_BAND_BEFORE,
                                      MR_ID_BAND_AFTER,
                                      MR_ID_FAULT,
                                      MR_ID_TEMPERATURE,
                                      MR_ID_CHANNEL_EVENT};
    static const uint16_t configuration[] = {
        MR_ID_HELLO,        MR_ID_BOARD_UID,    MR_ID_BOARD_CONFIG,  MR_ID_SITE,
        MR_ID_CHANNEL,      MR_ID_CHANNEL_ZERO, MR_ID_SWITCH_PLACE,  MR_ID_CALIBRATION,
        MR_ID_PREDICT_ITEM, MR_ID_RUNWAY,       MR_ID_RUNWAY_JOINTS, MR_ID_RUNWAY_STORE};
    static const uint16_t left_out[] = {MR_ID_CLOCK,         MR_ID_HEALTH,
                                        MR_ID_CAN_HEALTH,    MR_ID_SERIAL_HEALTH,
                                        MR_ID_MESSAGE_COUNT, MR_ID_SYNC,
                                        MR_ID_BOX_STATE,     MR_ID_CAN_ALARM,
                                        MR_ID_BAND_STATE,    MR_ID_DISPLACEMENT_1_3,
                                        MR_ID_TENSION_1_3,   MR_ID_CONFIG_STATE,
                                        MR_ID_SLOW_ROW};
    static unsigned kept[2048];
    struct mr_box_reader reader;
    struct mr_record record;
    arm_when_ready("arm 7");
    pass(1500);
    uint32_t from = index_now;
    command("mark 5");
    land();
    assert_int_equal(ask("disarm"), MR_OK);
    fake.serial_count = 0;
    assert_int_equal(ask("box-read 32768"), MR_OK);
    pass(2 * PAGES_MAX);
    assert_true(collect() > 0);
    memset(kept, 0, sizeof kept);
    mr_box_reader_begin(&reader, pages[0], present, page_count);
    while (mr_box_reader_next(&reader, &record) == MR_OK) {
        if (record.kind == MR_RECORD_MESSAGE)
            kept[record.id & 2047u]++;
    }
    for (size_t i = 0; i < COUNT_OF(left_out); i++)
        assert_int_equal(kept[left_out[i]], 0);
    for (size_t i = 0; i < COUNT_OF(configuration); i++)
        assert_in_range(kept[configuration[i]], 1, 1000);
    /* each once, though the links have a burst of them too */
    assert_int_equal(kept[MR_ID_CHANNEL], 24);
    unsigned edges = 0;
    for (size_t i = 0; i < fake.sent_count; i++)
        edges += fake.sent[i].id == MR_ID_EDGE && fake.sent_block[i] >= from;
    assert_int_equal(edges, 7);
    assert_int_equal(kept[MR_ID_EDGE], edges);
    for (size_t i = 0; i < COUNT_OF(needed); i++) {
        bool told = count_frames(needed[i]) > 0;
        if (told != (kept[needed[i]] > 0))
            fail_msg("message 0x%03x: %u on CAN, %u in the record", needed[i],
                     count_frames(needed[i]), kept[needed[i]]);
    }
    assert_int_equal(kept[MR_ID_TOUCHDOWN], 1);
    assert_int_equal(kept[MR_ID_STOP], 1);
    assert_int_equal(kept[MR_ID_MARK], 1);
}

/* All places taken: arming is refused, and that waiting does not help is told. */
TEST_IN(a_full_box_refuses_arming, begin, NULL)
{
    struct mr_box_state told;
    arm_when_ready("arm 7");
    assert_int_equal(ask("disarm"), MR_OK);
    for (unsigned i = 0; i < BLACKBOX_RECORDS_MAX; i++)
        app.box.records[i] = (struct blackbox_record){.is_used = true, .record = (uint16_t)(i + 1)};
    fake.sent_count = 0;
    assert_int_equal(ask("arm 8"), MR_FULL);
    GET_LAST(box_state, BOX_STATE, &told);
    assert_int_equal(told.records, BLACKBOX_RECORDS_MAX);
    assert_true(isnan(told.wait_s));
    assert_int_equal(app.landing.state, MR_LANDING_IDLE);
}

/* A configuration that keeps the black box does not make it look through its memory again. */
TEST_IN(another_configuration_leaves_the_box_as_it_is, begin, NULL)
{
    arm_when_ready("arm 7");
    assert_int_equal(ask("disarm"), MR_OK);
    app_apply_configuration(&app);
    assert_int_equal(app.box.state, MR_BOX_READY);
    assert_int_equal(ask("arm 8"), MR_OK);
}

/* Before anybody knows what the memory holds. */
TEST_IN(before_the_memory_is_known_it_says_wait, begin, NULL)
{
    assert_int_equal(ask("box-list"), MR_WAIT);
    assert_true(count_frames(MR_ID_BOX_STATE) > 0);
    assert_int_equal(ask("box-free 1"), MR_WAIT);
    assert_int_equal(ask("box-read 32768"), MR_WAIT);
}

TEST_IN(nonsense_is_refused, begin, NULL)
{
    assert_int_equal(ask("box-free -1"), MR_USAGE);
    assert_int_equal(ask("box-list -1"), MR_USAGE);
    assert_int_equal(ask("box-free 65536"), MR_USAGE); /* record 0 it is not */
    struct mr_ack ack;
    struct board_can_frame *frame = &fake.received[fake.received_count++];
    frame->id = MR_ID_COMMAND;
    frame->length = (uint8_t)mr_command_put(&(struct mr_command){.code = 200, .tag = 77},
                                            frame->data);
    pass(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.tag, 77);
    assert_int_equal(ack.status, MR_UNKNOWN);
}
