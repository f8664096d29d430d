/* Loss accounting and board time against sequences made by hand. */
#include <math.h>

#include "host/collect/loss_tracker.h"
#include "host/collect/timebase.h"
#include "tests/host/scratch.h"

static struct mr_can_health health(uint32_t sent, uint16_t dropped)
{
    return (struct mr_can_health){.sent = sent, .dropped = dropped};
}

static void can_frames(struct loss_tracker *loss_tracker, unsigned count)
{
    for (unsigned i = 0; i < count; i++)
        loss_tracker_add_can_frame(loss_tracker);
}

/* `count` frames arrive, then a can_health that is itself frame number `sent` (from 0). */
static void can_interval(struct loss_tracker *loss_tracker, unsigned count, uint32_t sent,
                         uint16_t dropped, int64_t block)
{
    struct mr_can_health message = health(sent, dropped);
    can_frames(loss_tracker, count + 1);
    loss_tracker_apply_can_health(loss_tracker, &message, block);
}

TEST(serial_sequence)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_SERIAL);
    loss_tracker_add_serial_frame(&loss_tracker, 65534, 10); /* joins anywhere: no loss */
    loss_tracker_add_serial_frame(&loss_tracker, 65535, 11);
    loss_tracker_add_serial_frame(&loss_tracker, 0, 12);
    assert_int_equal(loss_tracker.counts.lost, 0);
    loss_tracker_add_serial_frame(&loss_tracker, 5, 16); /* 1, 2, 3, 4 are missing */
    assert_int_equal(loss_tracker.counts.lost, 4);
    assert_int_equal(loss_tracker.counts.received, 4);
    assert_int_equal(loss_tracker.gap_count, 1);
    assert_string_equal(loss_tracker.gap[0].message, "frame");
    assert_string_equal(loss_tracker.gap[0].cause, "link");
    assert_int_equal(loss_tracker.gap[0].count, 4);
    assert_int_equal(loss_tracker.gap[0].from_block, 12);
    assert_int_equal(loss_tracker.gap[0].to_block, 16);
    loss_tracker_add_serial_frame(&loss_tracker, 5,
                                  17); /* a step back is a sender that began again */
    assert_int_equal(loss_tracker.counts.lost, 4);
}

TEST(serial_drops_are_the_boards)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_SERIAL);
    loss_tracker_apply_dropped_count(&loss_tracker, 3, 100); /* before logging began */
    assert_int_equal(loss_tracker.counts.dropped, 0);
    loss_tracker_apply_dropped_count(&loss_tracker, 10, 200);
    assert_int_equal(loss_tracker.counts.dropped, 7);
    assert_string_equal(loss_tracker.gap[0].cause, "board");
    assert_int_equal(loss_tracker.gap[0].from_block, 100);
    assert_int_equal(loss_tracker.gap[0].to_block, 200);
}

TEST(blocks_lost_on_the_way_or_never_sent)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_SERIAL);
    loss_tracker_add_serial_frame(&loss_tracker, 0, 100);
    loss_tracker_add_block(&loss_tracker, 100);
    loss_tracker_add_serial_frame(&loss_tracker, 3, 103);
    loss_tracker_add_block(&loss_tracker, 103);
    loss_tracker_add_serial_frame(&loss_tracker, 4, 110);
    loss_tracker_add_block(&loss_tracker, 110);
    assert_int_equal(loss_tracker.gap_count, 3);
    assert_string_equal(loss_tracker.gap[1].message, "block");
    assert_string_equal(loss_tracker.gap[1].cause, "link");
    assert_int_equal(loss_tracker.gap[1].from_block, 101);
    assert_int_equal(loss_tracker.gap[1].to_block, 102);
    assert_string_equal(loss_tracker.gap[2].cause, "board");
    assert_int_equal(loss_tracker.gap[2].count, 6);
}

TEST(can_without_loss)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 7, 7, 0, 43); /* frames 0..6, then number 7 */
    assert_int_equal(loss_tracker.frames_before_log, 0);
    can_interval(&loss_tracker, 99, 107, 0, 143);
    can_interval(&loss_tracker, 0, 108, 0, 243);
    loss_tracker_end(&loss_tracker);
    assert_int_equal(loss_tracker.counts.lost, 0);
    assert_int_equal(loss_tracker.counts.received, 109);
    assert_int_equal(loss_tracker.gap_count, 0);
}

TEST(can_loss_by_count)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 10, 1010, 5, 43); /* joins late: 1000 went before */
    assert_int_equal(loss_tracker.frames_before_log, 1000);
    assert_int_equal(loss_tracker.counts.lost, 0);
    can_interval(&loss_tracker, 50, 1071, 5, 143); /* 60 were sent between the two */
    assert_int_equal(loss_tracker.counts.lost, 10);
    assert_int_equal(loss_tracker.gap_count, 1);
    assert_int_equal(loss_tracker.gap[0].count, 10);
    assert_int_equal(loss_tracker.gap[0].from_block, 43);
    assert_int_equal(loss_tracker.gap[0].to_block, 143);
    can_interval(&loss_tracker, 8, 1080, 9, 243);
    assert_int_equal(loss_tracker.counts.lost, 10);
    assert_int_equal(loss_tracker.counts.dropped, 4);
}

TEST(counter_wraps)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 0, 0xfffffff0u, 0, 43);
    can_interval(&loss_tracker, 20, 0x00000006u, 0, 143); /* 22 later: 21 between, 20 came */
    assert_int_equal(loss_tracker.counts.lost, 1);
}

TEST(steps_are_believed_only_with_a_loss)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 0, 0, 0, 43);
    loss_tracker_add_can_frame(&loss_tracker);
    loss_tracker_add_series_message(&loss_tracker, MR_PACK_TENSION_4_6, 101);
    loss_tracker_add_can_frame(&loss_tracker);
    loss_tracker_add_series_message(&loss_tracker, MR_PACK_TENSION_4_6,
                                    113);      /* 105 and 109 are missing, perhaps */
    can_interval(&loss_tracker, 0, 5, 0, 143); /* 1..4 were sent, two came */
    assert_int_equal(loss_tracker.counts.lost, 2);
    assert_int_equal(loss_tracker.gap_count, 2);
    assert_string_equal(loss_tracker.gap[0].message, "tension_4_6");
    assert_string_equal(loss_tracker.gap[0].channels, "t4-t6");
    assert_int_equal(loss_tracker.gap[0].count, 2);
    assert_int_equal(loss_tracker.gap[0].from_block, 105);
    assert_int_equal(loss_tracker.gap[0].to_block, 109);

    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 0, 0, 0, 43);
    loss_tracker_add_can_frame(&loss_tracker);
    loss_tracker_add_series_message(&loss_tracker, MR_PACK_DISPLACEMENT_1_3, 100);
    loss_tracker_add_can_frame(&loss_tracker);
    loss_tracker_add_series_message(&loss_tracker, MR_PACK_DISPLACEMENT_1_3,
                                    200); /* the board was idle in between: all it sent has come */
    can_interval(&loss_tracker, 0, 3, 0, 243);
    assert_int_equal(loss_tracker.counts.lost, 0);
    assert_int_equal(loss_tracker.gap_count, 0);
}

TEST(steps_count_when_no_health_comes_any_more)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 0, 0, 0, 43);
    loss_tracker_add_series_message(&loss_tracker, MR_PACK_DISPLACEMENT_7_8, 100);
    loss_tracker_add_series_message(&loss_tracker, MR_PACK_DISPLACEMENT_7_8, 110);
    loss_tracker_end(&loss_tracker);
    assert_int_equal(loss_tracker.counts.lost, 4);
    assert_string_equal(loss_tracker.gap[0].channels, "d7-d8");

    /* and the last reading before the end may be one of an idle board: ten a second */
    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 0, 0, 0, 43);
    loss_tracker_add_series_message(&loss_tracker, MR_PACK_DISPLACEMENT_7_8, 11500);
    loss_tracker_add_series_message(&loss_tracker, MR_PACK_DISPLACEMENT_7_8, 11600);
    loss_tracker_end(&loss_tracker);
    assert_int_equal(loss_tracker.counts.lost, 0);
    assert_int_equal(loss_tracker.gap_count, 0);
}

TEST(restart_begins_afresh)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 5, 500, 3, 43);
    loss_tracker_restart(&loss_tracker, true);
    can_interval(&loss_tracker, 4, 4, 0, 43);
    can_interval(&loss_tracker, 4, 9, 0, 143);
    assert_int_equal(loss_tracker.counts.lost, 0);
    assert_int_equal(loss_tracker.counts.dropped, 0);
}

static bool count(struct loss_tracker *loss_tracker, uint16_t id, uint32_t sent)
{
    loss_tracker_add_message(loss_tracker, MR_INDEX_MESSAGE_COUNT);
    return loss_tracker_apply_message_count(loss_tracker,
                                            &(struct mr_message_count){.id = id, .count = sent});
}

/* What a board counts anew is no loss of what it had counted, whether its restart has been noticed
 * or not. */
TEST(counts_of_a_board_that_begins_again)
{
    struct loss_tracker loss_tracker;
    unsigned zone = mr_message_index(MR_ID_ZONE), motion = mr_message_index(MR_ID_MOTION);
    loss_tracker_start(&loss_tracker, LINK_SERIAL);
    loss_tracker_add_serial_frame(&loss_tracker, 0, 1);
    for (unsigned i = 0; i < 122; i++)
        loss_tracker_add_message(&loss_tracker, MR_INDEX_ZONE);
    assert_true(count(&loss_tracker, MR_ID_ZONE, 122));
    assert_true(count(&loss_tracker, MR_ID_MOTION, 0));
    /* 1 to 6 are lost: the hello of a board that begins again may be among them */
    loss_tracker_add_serial_frame(&loss_tracker, 7, 1);
    loss_tracker_add_message(&loss_tracker, MR_INDEX_MOTION);
    assert_false(count(&loss_tracker, MR_ID_ZONE, 0));
    assert_false(count(&loss_tracker, MR_ID_MOTION, 3));
    loss_tracker_confirm_board_time(&loss_tracker); /* it was none */
    assert_true(count(&loss_tracker, MR_ID_MOTION, 3));
    assert_int_equal(loss_tracker.missing_count[motion], 2);
    assert_false(count(&loss_tracker, MR_ID_ZONE, 0)); /* now it has: no count goes back */
    assert_int_equal(loss_tracker.missing_count[zone], 0);
    assert_int_equal(loss_tracker.repeated_count[zone], 0);
    loss_tracker_restart(&loss_tracker, false);
    assert_true(
        count(&loss_tracker, MR_ID_ZONE, 1)); /* of what came before that nothing is known */
    loss_tracker_add_message(&loss_tracker, MR_INDEX_ZONE);
    assert_true(count(&loss_tracker, MR_ID_ZONE, 4));
    assert_int_equal(loss_tracker.missing_count[zone], 2);
}

TEST(time_unwraps)
{
    struct timebase time = {0};
    assert_int_equal(timebase_unwrap(&time, 5), -1);
    assert_false(timebase_apply_clock(&time, 65530, 1000));
    assert_int_equal(timebase_unwrap(&time, 65535), 65535);
    assert_int_equal(timebase_unwrap(&time, 2), 65538);
    assert_int_equal(timebase_unwrap(&time, 65534), 65534); /* one that waited in a queue */
    assert_int_equal(timebase_now_us(&time), 65538000);
    /* 84 ticks to a microsecond, forwards, backwards and over the wrap of the counter */
    assert_near(timebase_tick_to_us(&time, 1000 + 84 * 1500), 65530000.0 + 1500.0, 1e-6);
    assert_near(timebase_tick_to_us(&time, 1000u - 2000u), 65530000.0 - 2000.0 / 84.0, 1e-6);
    assert_true(timebase_apply_block(&time, 64000)); /* more than a second back: began again */
    assert_false(timebase_apply_block(&time, 64600));
}

/* Frames 1 to 99 and can_health 100 arrive; of the 99 after it 9 are lost, and the queue owns up to
 * 5. */
TEST(losses_have_their_causes)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 99, 100, 0, 1000);
    loss_tracker_add_link_fault(&loss_tracker, LINK_QUEUE_LOST, 5);
    loss_tracker_add_link_fault(&loss_tracker, LINK_RX_OVERFLOW, 1);
    can_interval(&loss_tracker, 90, 200, 0, 2000);
    assert_int_equal(loss_tracker.counts.lost, 9);
    assert_int_equal(loss_tracker.gap_count, 2);
    assert_string_equal(loss_tracker.gap[0].cause, "queue");
    assert_int_equal(loss_tracker.gap[0].count, 5);
    assert_int_equal(loss_tracker.gap[0].from_block, 1000);
    assert_int_equal(loss_tracker.gap[0].to_block, 2000);
    assert_string_equal(loss_tracker.gap[1].cause, "adapter");
    assert_int_equal(loss_tracker.gap[1].count, 4);
    /* The next loss has no known cause; what the queue lost of others' frames is no loss of the
     * board's. */
    can_interval(&loss_tracker, 98, 300, 0, 3000);
    assert_int_equal(loss_tracker.counts.lost, 10);
    assert_string_equal(loss_tracker.gap[2].cause, "link");
    loss_tracker_add_link_fault(&loss_tracker, LINK_QUEUE_LOST, 50);
    can_interval(&loss_tracker, 99, 400, 0, 4000);
    assert_int_equal(loss_tracker.counts.lost, 10);
    assert_int_equal(loss_tracker.gap_count, 3);
    loss_tracker_add_link_fault(&loss_tracker, LINK_BUS_OFF, 1);
    loss_tracker_add_link_fault(&loss_tracker, LINK_RX_OVERFLOW, 1);
    can_interval(&loss_tracker, 0, 500, 0, 5000);
    assert_int_equal(loss_tracker.counts.lost, 109);
    assert_string_equal(loss_tracker.gap[3].cause, "bus-off");
}

/* The queue to the campaign had no room: each reason is a gap of its own. On serial bytes are lost,
 * and a jump is theirs even when the number has wrapped: 100 frames of 100 bytes came, 7,000,000
 * bytes are lost, so 70,000 frames; the number says 4,464. */
TEST(losses_by_a_full_queue)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 99, 100, 0, 1000);
    loss_tracker_add_link_fault(&loss_tracker, LINK_LOST_LOCK, 6);
    loss_tracker_add_link_fault(&loss_tracker, LINK_LOST_FULL_DISK, 2);
    can_interval(&loss_tracker, 90, 200, 0, 2000);
    assert_int_equal(loss_tracker.counts.lost, 9);
    assert_int_equal(loss_tracker.gap_count, 3);
    assert_string_equal(loss_tracker.gap[0].cause, "lock");
    assert_int_equal(loss_tracker.gap[0].count, 6);
    assert_string_equal(loss_tracker.gap[1].cause, "full disk");
    assert_int_equal(loss_tracker.gap[1].count, 2);
    assert_string_equal(loss_tracker.gap[2].cause, "link");

    loss_tracker_start(&loss_tracker, LINK_SERIAL);
    for (unsigned seq = 0; seq < 100; seq++) {
        loss_tracker.received_bytes += 100;
        loss_tracker_add_serial_frame(&loss_tracker, (uint16_t)seq, seq);
    }
    loss_tracker_add_link_fault(&loss_tracker, LINK_LOST_SLOW_DISK, 7000000);
    loss_tracker.received_bytes += 100;
    loss_tracker_add_serial_frame(&loss_tracker, (uint16_t)(100u + 70000u), 200);
    assert_int_equal(loss_tracker.counts.lost, 70000);
    assert_int_equal(loss_tracker.gap_count, 1);
    assert_string_equal(loss_tracker.gap[0].cause, "slow disk");
    assert_int_equal(loss_tracker.gap[0].count, 70000);
    loss_tracker.received_bytes += 100;
    /* without such a loss a step back is a sender that began again */
    loss_tracker_add_serial_frame(&loss_tracker, 5, 201);
    assert_int_equal(loss_tracker.counts.lost, 70000);
}

/* When no can_health comes any more, what the link saw stands for the loss. */
TEST(troubles_at_the_end)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 10, 11, 0, 1000);
    loss_tracker_add_link_fault(&loss_tracker, LINK_QUEUE_LOST, 7);
    loss_tracker_end(&loss_tracker);
    assert_int_equal(loss_tracker.counts.lost, 7);
    assert_int_equal(loss_tracker.gap_count, 1);
    assert_string_equal(loss_tracker.gap[0].cause, "queue");
    assert_int_equal(loss_tracker.gap[0].count, 7);

    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 10, 11, 0, 1000);
    loss_tracker_add_link_fault(&loss_tracker, LINK_BUS_OFF, 1);
    loss_tracker_end(&loss_tracker);
    assert_int_equal(loss_tracker.counts.lost, 0);
    assert_int_equal(loss_tracker.gap_count, 1);
    assert_string_equal(loss_tracker.gap[0].cause, "bus-off");
    assert_int_equal(loss_tracker.gap[0].count, STORE_NONE); /* nobody knows how many */
    assert_int_equal(loss_tracker.gap[0].from_block, 1000);

    loss_tracker_start(&loss_tracker, LINK_CAN);
    can_interval(&loss_tracker, 10, 11, 0, 1000);
    loss_tracker_add_link_fault(&loss_tracker, LINK_ARBITRATION_LOST,
                                1); /* part of every busy bus */
    loss_tracker_end(&loss_tracker);
    assert_int_equal(loss_tracker.gap_count, 0);
}

/* The queue loses frames before the first can_health: they are lost, not sent before logging
 * began. */
TEST(queue_losses_while_joining)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_CAN);
    loss_tracker_add_link_fault(&loss_tracker, LINK_QUEUE_LOST, 20);
    can_interval(&loss_tracker, 30, 1050, 0,
                 500); /* 1050 before it: 30 came, 20 lost, 1000 earlier */
    assert_int_equal(loss_tracker.frames_before_log, 1000);
    assert_int_equal(loss_tracker.counts.lost, 20);
    assert_string_equal(loss_tracker.gap[0].cause, "queue");
}

/* Of a stranger: counts that the bus cannot have carried are not taken. */
TEST(counts_of_nobody)
{
    const uint32_t strange[] = {0, 17, 123456789, UINT32_MAX};
    for (size_t i = 0; i < sizeof strange / sizeof strange[0]; i++) {
        struct loss_tracker loss_tracker;
        loss_tracker_start(&loss_tracker, LINK_CAN);
        can_interval(&loss_tracker, 99, 99, 0, 43);
        can_interval(&loss_tracker, 99, 199, 0, 143);
        can_interval(&loss_tracker, 49, strange[i], 0, 190);
        can_interval(&loss_tracker, 50, 299, 0, 243);
        can_interval(&loss_tracker, 99, 399, 0, 343);
        assert_int_equal(loss_tracker.counts.lost, 0);
        assert_int_equal(loss_tracker.counts.dropped, 0);
        struct mr_message_count count = {.id = MR_ID_EDGE, .count = 0};
        loss_tracker_apply_message_count(&loss_tracker, &count);
        count.count = 4000000000u;
        assert_false(loss_tracker_apply_message_count(&loss_tracker, &count));
        assert_int_equal(loss_tracker.missing_count[mr_message_index(MR_ID_EDGE)], 0);
    }
}

/* 100 frames of 20 bytes came, 400 bytes were lost here, and the board began again meanwhile. */
TEST(bytes_lost_before_a_restart)
{
    struct loss_tracker loss_tracker;
    loss_tracker_start(&loss_tracker, LINK_SERIAL);
    loss_tracker.received_bytes = 2000;
    for (uint16_t seq = 0; seq < 100; seq++)
        loss_tracker_add_serial_frame(&loss_tracker, seq, 700 + seq);
    loss_tracker_add_link_fault(&loss_tracker, LINK_LOST_LOCK, 400);
    loss_tracker_restart(&loss_tracker, true);
    loss_tracker_add_serial_frame(&loss_tracker, 0, -1);
    assert_int_equal(loss_tracker.counts.lost, 20);
    assert_int_equal(loss_tracker.gap_count, 1);
    assert_string_equal(loss_tracker.gap[0].cause, "lock");
    assert_int_equal(loss_tracker.gap[0].count, 20);
    assert_int_equal(loss_tracker.gap[0].from_block, 799);
}
