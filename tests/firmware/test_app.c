/* The application: readings, rates, commands, links, faults. */
#include "common/boxpage.h"
#include "common/wire.h"
#include "tests/firmware/play.h"

#include "common/framing.h"
#include "firmware/config.h"
#include "firmware/health.h"

TEST_IN(it_says_hello_first, start, NULL)
{
    struct mr_hello hello;
    assert_true(fake.sent_count >= 5);
    assert_int_equal(fake.sent[0].id, MR_ID_HELLO);
    GET_LAST(hello, HELLO, &hello);
    assert_int_equal(hello.layout, MR_LAYOUT);
    play(1000);
    assert_int_equal(count_frames(MR_ID_HELLO), 2);
    assert_true(count_frames(MR_ID_CHANNEL) >= 24);
    assert_true(count_frames(MR_ID_SWITCH_PLACE) >= 24);
    assert_true(count_frames(MR_ID_SLACK) >= 42);
}

TEST_IN(rates_are_those_of_the_design, start, NULL)
{
    play(200);
    command("arm 5");
    play(1000);
    fake.sent_count = 0;
    play(1000);
    assert_int_equal(count_frames(MR_ID_DISPLACEMENT_1_3), 500);
    assert_int_equal(count_frames(MR_ID_DISPLACEMENT_7_8), 500);
    assert_int_equal(count_frames(MR_ID_TENSION_1_3), 250);
    assert_int_equal(count_frames(MR_ID_TENSION_13_14), 250);
    for (uint16_t id = MR_ID_ZONE; id <= MR_ID_VERDICT; id++) /* no zone: nothing of its errors */
        assert_int_equal(count_frames(id), id == MR_ID_ZONE_ERROR ? 0 : 20);
    assert_int_equal(count_frames(MR_ID_TRUST), 1);
    assert_int_equal(count_frames(MR_ID_HEALTH), 10);
    assert_int_equal(count_frames(MR_ID_LANDING), 1);
    assert_in_range(fake.sent_count, 2950, 3060); /* of 131 bits at most, 1 Mbit/s: 40 % */
}

TEST_IN(readings_are_in_inches_and_pounds, start, NULL)
{
    struct mr_displacement_1_3 d;
    struct mr_tension_13_14 t;
    moved_in[1] = 0.3312f;
    moved_in[2] = -0.05f;
    command("arm 1");
    play(10);
    GET_LAST(displacement_1_3, DISPLACEMENT_1_3, &d);
    assert_near(d.d1_in, 0.0, 0.0005);
    assert_near(d.d2_in, 0.3312, 0.0005);
    assert_near(d.d3_in, -0.05, 0.0005);
    GET_LAST(tension_13_14, TENSION_13_14, &t);
    assert_near(t.t14_lb, 113.0, 0.05);
    assert_int_equal(t.invalid, 0);
}

/* No message may tell of a displacement that never was: not of the time before the first block, nor
 * mixed across a loss. */
TEST_IN(a_reading_is_whole_or_missing, start, NULL)
{
    struct mr_health health;
    struct mr_tension_13_14 t;
    unsigned whole = 0;
    moved_in[0] = 1.0f;
    play(2);
    GET_LAST(tension_13_14, TENSION_13_14, &t); /* means of four blocks, of which two have been */
    assert_true(isnan(t.t14_lb));
    assert_int_equal(t.invalid, 0x3fff);
    command("arm 1");
    play(50);
    /* 52 to 55: the message of block 56 would mix 56 with what stood in 55's place */
    index_now += 4;
    moved_in[0] = 2.0f;
    play(200);
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_displacement_1_3 d;
        if (fake.sent[i].id != MR_ID_DISPLACEMENT_1_3)
            continue;
        assert_int_equal(mr_displacement_1_3_get(&d, fake.sent[i].data, 8), MR_OK);
        if (isnan(d.d1_in))
            continue;
        assert_near(d.d1_in, d.block16 < 54 ? 1.0 : 2.0, 0.0005);
        whole++;
    }
    assert_in_range(whole, 120, 127);
    GET_LAST(health, HEALTH, &health);
    assert_int_equal(health.blocks_lost, 4);
}

/* Each block moved by 0.004 in and pulled by 1 lb: the first messages after arming, at any phase of
 * the idle ones, are means of the newest two. */
TEST_IN(the_first_means_after_arming_reach_back, start, NULL)
{
    for (unsigned before = 96; before < 108; before++) {
        struct mr_displacement_1_3 d;
        start(NULL);
        for (unsigned n = 0; n < before + 6; n++) {
            moved_in[0] = 0.004f * (float)index_now;
            pulled_lb = (float)index_now;
            if (n == before)
                command("arm 1");
            fake.sent_count = 0;
            play(1);
            bool told = n >= before ? n % 2 == 0 : n % 100 == 0;
            assert_int_equal(count_frames(MR_ID_DISPLACEMENT_1_3), told);
            if (n == 101 && before > n) {
                struct mr_tension_13_14 t;
                GET_LAST(tension_13_14, TENSION_13_14, &t);
                assert_near(t.t14_lb, 113.0 + 98.0 + 1.5, 0.05); /* the mean of 98 to 101 */
            }
            if (!told || n < 2)
                continue;
            GET_LAST(displacement_1_3, DISPLACEMENT_1_3, &d);
            assert_near(d.d1_in, 0.004 * ((double)n - 0.5), 0.0006);
        }
    }
}

TEST_IN(commands_are_answered_with_the_reason, start, NULL)
{
    struct mr_ack ack;
    command("arm 3");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_OK);
    command("arm 4");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_NOT_NOW);
    assert_int_equal(ack.tag, 2);
    command("survey 3 0.1");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_NOT_NOW);
    command("disarm");
    command("survey 42 0.1");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_USAGE);
    const char *const too_much[] = {"survey 3 6.5535", "survey 3 -0.1", "mark 65536",
                                    "mark -1",         "arm 65536",     "arm -1"};
    for (unsigned i = 0; i < COUNT_OF(too_much); i++) {
        /* more than the message that repeats it can hold */
        command(too_much[i]);
        play(1);
        GET_LAST(ack, ACK, &ack);
        assert_int_equal(ack.status, MR_USAGE);
    }
    assert_null(last_frame(MR_ID_MARK));
    command("survey 3 0.1");
    fake.received[fake.received_count - 1].data[0] = 99;
    fake.received_taken--;
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_UNKNOWN);
}

/* Not while a landing could be lost; and only after the answer had 50 ms to go out. */
TEST_IN(the_boot_rom_is_entered_when_idle, start, NULL)
{
    struct mr_ack ack;
    command("arm 3");
    command("bootrom");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_NOT_NOW);
    for (unsigned i = 0; i < 100; i++)
        app_supervise(&app);
    assert_int_equal(fake.rom_entries, 0);
    command("disarm");
    command("bootrom");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_OK);
    for (unsigned i = 0; i < 4; i++)
        app_supervise(&app);
    assert_int_equal(fake.rom_entries, 0);
    app_supervise(&app);
    assert_int_equal(fake.rom_entries, 1);
}

/* Commands that come faster than the answers could go out wait; blocks go on. */
TEST_IN(a_flood_of_commands_is_taken_in_portions, start, NULL)
{
    struct mr_command message;
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    for (unsigned i = 0; i < 64; i++)
        command("mark 1");
    assert_int_equal(mr_command_parse("mark 2", 9, &message), MR_OK);
    size_t length = mr_command_put(&message, payload);
    for (unsigned i = 0; i < 100; i++)
        fake.serial_in_count += mr_frame_encode(0, MR_ID_COMMAND, payload, length,
                                                fake.serial_in + fake.serial_in_count);
    unsigned before = 0;
    for (unsigned i = 0; i < 60; i++) {
        play(1);
        assert_in_range(count_frames(MR_ID_ACK) - before, 0, 4);
        before = count_frames(MR_ID_ACK);
    }
    assert_int_equal(before, 164);
}

TEST_IN(a_full_queue_drops_and_counts, start, NULL)
{
    struct mr_can_health can;
    struct mr_serial_health serial;
    command("arm 1");
    play(100);
    fake.can_full = fake.serial_full = true;
    play(100);
    fake.can_full = fake.serial_full = false;
    play(100);
    GET_LAST(can_health, CAN_HEALTH, &can);
    GET_LAST(serial_health, SERIAL_HEALTH, &serial);
    assert_in_range(can.dropped, 275, 500);
    assert_in_range(serial.dropped, 100, 350);
    assert_true(health_get_faults() & 1u << MR_FAULT_CAN_QUEUE_FULL);
    assert_true(health_get_faults() & 1u << MR_FAULT_SERIAL_QUEUE_FULL);
    /* what it says was sent before each can_health was indeed sent before it */
    size_t before = 0;
    for (size_t i = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id == MR_ID_CAN_HEALTH) {
            assert_int_equal(mr_can_health_get(&can, fake.sent[i].data, 8), MR_OK);
            assert_int_equal(can.sent, before);
        }
        before++;
    }
}

/* Block records on serial so far: `*first` is the index of the first one, and the others follow
 * it. */
static unsigned count_blocks(uint32_t *first)
{
    struct mr_deframer deframer;
    struct mr_frame frame;
    struct mr_block block;
    unsigned blocks = 0, frames = 0;
    mr_deframer_init(&deframer);
    for (size_t i = 0; i < fake.serial_count; i++) {
        enum mr_status status = mr_deframer_push(&deframer, fake.serial[i], &frame);
        if (status == MR_TOO_FEW)
            continue;
        assert_int_equal(status, MR_OK);
        assert_int_equal(frame.seq, frames++);
        if (frame.type == MR_ID_BLOCK) {
            assert_int_equal(mr_block_decode(&block, frame.payload, frame.length), MR_OK);
            if (blocks == 0)
                *first = block.index;
            assert_int_equal(block.index, *first + blocks);
            blocks++;
        }
    }
    return blocks;
}

TEST_IN(serial_carries_every_block_and_no_gap, start, NULL)
{
    uint32_t first;
    command("arm 1");
    play(500);
    assert_int_equal(count_blocks(&first), 500);
}

/* The first means of a landing reach back before arming: the blocks they are of are told too. */
TEST_IN(the_record_begins_four_blocks_before_arming, start, NULL)
{
    struct mr_ack ack;
    uint32_t first;
    play(20);
    command("arm 1");
    play(10);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(count_blocks(&first), 14);
    assert_int_equal(first, ack.block - 4);
}

TEST_IN(a_lost_block_before_arming_cuts_the_record, start, NULL)
{
    uint32_t first;
    play(20);
    index_now++; /* one is lost */
    play(2);
    command("arm 1");
    play(10);
    assert_int_equal(count_blocks(&first), 12);
}

TEST_IN(a_bad_serial_frame_is_counted_and_the_next_one_obeyed, start, NULL)
{
    struct mr_command message;
    struct mr_ack ack;
    uint8_t payload[MR_MESSAGE_BYTES_MAX], out[MR_FRAME_BYTES_MAX];
    assert_int_equal(mr_command_parse("mark 77", 9, &message), MR_OK);
    size_t n = mr_frame_encode(0, MR_ID_COMMAND, payload, mr_command_put(&message, payload), out);
    memcpy(fake.serial_in, out, n);
    fake.serial_in[3] ^= 0x10;
    memcpy(fake.serial_in + n, out, n);
    fake.serial_in_count = 2 * n;
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.tag, 9);
    assert_int_equal(count_frames(MR_ID_MARK), 1);
    assert_int_equal(app.telemetry.serial_refused_count, 1);
    assert_true(health_get_faults() & 1u << MR_FAULT_SERIAL_BAD_FRAME);

    /* a whole frame of a command that is too short is refused as well */
    n = mr_frame_encode(0, MR_ID_COMMAND, payload, 7, out);
    memcpy(fake.serial_in + fake.serial_in_count, out, n);
    fake.serial_in_count += n;
    play(1);
    assert_int_equal(app.telemetry.serial_refused_count, 2);
    app.telemetry.serial_refused_count = UINT16_MAX;
    memcpy(fake.serial_in + fake.serial_in_count, out, n);
    fake.serial_in_count += n;
    play(1);
    assert_int_equal(app.telemetry.serial_refused_count, UINT16_MAX);
}

TEST_IN(a_fault_is_told_when_it_comes_and_each_second, start, NULL)
{
    struct mr_fault fault;
    unsigned told = 0;
    fake.can_errors = (struct board_can_errors){.tec = 200, .is_passive = true, .is_bus_off = true};
    app_supervise(&app); /* looks at CAN every 10 ms */
    play(100);
    memset(&fake.can_errors, 0, sizeof fake.can_errors);
    fake.sent_count = 0;
    play(5000);
    for (size_t i = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id != MR_ID_FAULT)
            continue;
        assert_int_equal(mr_fault_get(&fault, fake.sent[i].data, 8), MR_OK);
        told += fault.code == MR_FAULT_CAN_BUS_OFF && fault.detail == 200 && fault.count == 1;
    }
    assert_int_equal(told, 5);
    for (unsigned i = 0; i < 70000; i++)
        health_count_fault(MR_FAULT_CAN_MISSING, 0);
    assert_int_equal(health_get_counter(MR_FAULT_CAN_MISSING).count, UINT16_MAX);
}

/* On the internal oscillator all times may be 1 % out: speeds by 1 %, decelerations by 2 %. */
TEST_IN(an_inexact_clock_is_part_of_the_errors, start, NULL)
{
    struct mr_deframer deframer;
    struct mr_frame frame;
    struct mr_touchdown touchdown = {0};
    fake_reset();
    fake.clock_source = MR_CLOCK_INTERNAL_PLL;
    app_start(&app);
    play(100);
    command("arm 7");
    fly(9.0);
    mr_deframer_init(&deframer);
    for (size_t i = 0; i < fake.serial_count; i++) {
        if (mr_deframer_push(&deframer, fake.serial[i], &frame) == MR_OK &&
            frame.type == MR_ID_TOUCHDOWN)
            assert_int_equal(mr_touchdown_get(&touchdown, frame.payload, frame.length), MR_OK);
    }
    assert_near(touchdown.speed_ft_s, 30.0, 0.0011);
    assert_near(touchdown.speed_error_ft_s, 0.30, 0.005);
    assert_near(touchdown.deceleration_error_ft_s2, 0.12, 0.005);
}

TEST_IN(can_is_silent_on_the_internal_oscillator, start, NULL)
{
    fake_reset();
    fake.clock_source = MR_CLOCK_INTERNAL_PLL;
    app_start(&app);
    play(100);
    assert_int_equal(fake.sent_count, 0);
    assert_true(fake.serial_count > 0);
}

static int start_with_four(void **state)
{
    static struct mr_config full;
    *state = &full;
    full = config;
    for (unsigned c = 4; c < MR_TRANSDUCERS + MR_GAGES; c++)
        config.channel[c] = (struct mr_channel_config){0};
    config.gate[23].step_codes = 0;
    return start(NULL);
}

static int start_with_switches(void **state)
{
    start_with_four(state);
    for (unsigned c = 0; c < 4; c++)
        config.channel[c].kind = 0;
    config.site[0].black_box = 0;
    return start(NULL);
}

static int put_back(void **state)
{
    config = *(struct mr_config *)*state;
    return 0;
}

TEST_IN(what_is_not_fitted_is_neither_scanned_nor_sent, start_with_four, put_back)
{
    assert_int_equal(fake.configurations, 1);
    assert_int_equal(fake.fitted & 0x3fffffu, 0x0f);
    moved_in[3] = 0.25f;
    play(100); /* the burst of the start */
    assert_int_equal(count_frames(MR_ID_CHANNEL), 24);
    assert_int_equal(count_frames(MR_ID_CHANNEL_ZERO), 6);
    assert_int_equal(count_frames(MR_ID_SWITCH_PLACE), 24);
    fake.sent_count = 0;
    play(40 * (6 + 23 + 42 + 23)); /* a round of what is there, and the predictor's parameters */
    assert_int_equal(count_frames(MR_ID_CHANNEL), 6);
    assert_int_equal(count_frames(MR_ID_CHANNEL_ZERO), 6);
    assert_int_equal(count_frames(MR_ID_SWITCH_PLACE), 23);
    assert_int_equal(count_frames(MR_ID_SLACK), 42);
    command("arm 1");
    fake.sent_count = 0;
    play(400);
    assert_int_equal(count_frames(MR_ID_DISPLACEMENT_1_3), 200);
    assert_int_equal(count_frames(MR_ID_DISPLACEMENT_4_6), 200);
    assert_int_equal(count_frames(MR_ID_DISPLACEMENT_7_8), 0);
    for (uint16_t id = MR_ID_TENSION_1_3; id <= MR_ID_TENSION_13_14; id++)
        assert_int_equal(count_frames(id), 0);
    struct mr_displacement_4_6 d;
    GET_LAST(displacement_4_6, DISPLACEMENT_4_6, &d);
    assert_near(d.d4_in, 0.25, 0.0005);
    assert_true(isnan(d.d5_in));
}

TEST_IN(switches_alone_send_neither_readings_nor_box, start_with_switches, put_back)
{
    assert_int_equal(fake.fitted & 0x3fffffu, 0);
    play(2000);
    command("arm 1");
    play(100);
    assert_int_equal(app.landing.state, MR_LANDING_ARMED);
    for (uint16_t id = MR_ID_DISPLACEMENT_1_3; id <= MR_ID_TENSION_13_14; id++)
        assert_int_equal(count_frames(id), 0);
    assert_int_equal(count_frames(MR_ID_BOX_STATE), 0);
    assert_int_equal(app.box.pages_closed, 0); /* no page of the ring */
    touchdown_s = 3.0;
    fly(11.0);
    assert_near(app.landing.summary.touchdown_speed_ft_s.value, 30.0, 0.05);
    assert_near(app.landing.summary.stop_station_ft.value, 78.0, 1.0);
}

/* From one configuration to another while idle: the scans begin again, readings of before are no
 * readings of now. */
TEST_IN(another_configuration_begins_the_scans_again, start_with_four, put_back)
{
    struct mr_displacement_1_3 d;
    moved_in[0] = moved_in[1] = 1.0f;
    play(199);
    config.channel[1].kind = 0;
    config.site[0].black_box = 0;
    app_apply_configuration(&app);
    assert_int_equal(fake.configurations, 2);
    assert_int_equal(fake.fitted & 0x3fffffu, 0x0d);
    assert_true(app.box.is_disabled);
    fake.sent_count = 0;
    play(102);
    GET_LAST(displacement_1_3, DISPLACEMENT_1_3, &d);
    assert_near(d.d1_in, 1.0, 0.0005);
    assert_true(isnan(d.d2_in));
    config.site[0].black_box = 1;
    app_apply_configuration(&app);
    assert_false(app.box.is_disabled);
}

static int start_and_keep(void **state)
{
    static struct mr_config kept;
    kept = config;
    *state = &kept;
    return start(NULL);
}

/* Every channel with a whole table, every segment surveyed: the box keeps all of it with the
 * landing. */
TEST_IN(the_box_has_room_for_the_longest_configuration, start_and_keep, put_back)
{
    static uint8_t present[BLACKBOX_CONFIG_PAGES];
    struct mr_box_reader reader;
    struct mr_record record;
    struct mr_calibration calibration = {0};
    unsigned calibrations = 0, channels = 0, segments = 0;
    for (unsigned c = 0; c < MR_TRANSDUCERS + MR_GAGES; c++) {
        config.channel[c].points = MR_CONFIG_POINTS;
        for (unsigned i = 0; i < MR_CONFIG_POINTS; i++)
            config.channel[c].point_reading[i] = config.channel[c].point_value[i] = (float)i;
    }
    for (unsigned i = 0; i < MR_SEGMENTS; i++)
        app.slack_in[i] = 0.3f;
    play(10);
    command("arm 1");
    play(1);
    assert_true(app.box.is_configuring);
    /* what is not in the page yet */
    mr_put_u32(app.box.config_writer.page + MR_BOXPAGE_HEADER_BYTES +
                   app.box.config_writer.next_bit / 32 * 4,
               app.box.config_writer.pending_bits);
    memset(present + 1, 1, app.box.config_pages_closed);
    mr_box_reader_begin(&reader, app.box.config_pages[0], present, app.box.config_pages_closed + 1);
    while (mr_box_reader_next(&reader, &record) == MR_OK) {
        channels += record.id == MR_ID_CHANNEL;
        segments += record.id == MR_ID_SLACK;
        calibrations += record.id == MR_ID_CALIBRATION &&
                        mr_calibration_get(&calibration, record.payload, record.length) == MR_OK;
    }
    assert_int_equal(channels, 24);
    assert_int_equal(segments, 42);
    /* and the reference's gain error, the last */
    assert_int_equal(calibrations, 22 * (8 + 16) + 1);
    assert_int_equal(calibration.index, 23);
}

/* Of the messages that hold several channels, only those are sent of which one is fitted: one
 * channel, one message. */
TEST_IN(one_channel_costs_one_message, start, NULL)
{
    static const uint16_t group[] = {MR_ID_DISPLACEMENT_1_3, MR_ID_DISPLACEMENT_4_6,
                                     MR_ID_DISPLACEMENT_7_8, MR_ID_TENSION_1_3,
                                     MR_ID_TENSION_4_6,      MR_ID_TENSION_7_9,
                                     MR_ID_TENSION_10_12,    MR_ID_TENSION_13_14};
    struct mr_config full = config;
    for (unsigned c = 0; c < MR_TRANSDUCERS + MR_GAGES; c++) {
        unsigned wanted = c < MR_TRANSDUCERS ? c / 3 : 3 + (c - MR_TRANSDUCERS) / 3;
        for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++)
            config.channel[i].kind = i == c ? full.channel[i].kind : 0;
        start(NULL);
        play(300);
        config = full;
        for (unsigned g = 0; g < sizeof group / sizeof group[0]; g++)
            assert_int_equal(count_frames(group[g]) > 0, g == wanted);
    }
}

/* The count of lost blocks ends at 65535, by one jump or by several. */
TEST_IN(lost_blocks_are_counted_to_the_end, start, NULL)
{
    static const uint32_t jumps[][3] = {
        {70000, 0, 65535}, {40000, 3, 40003}, {40000, 40000, 65535}};
    for (unsigned i = 0; i < 3; i++) {
        start(NULL);
        play(10);
        index_now += jumps[i][0];
        play(10);
        index_now += jumps[i][1];
        play(10);
        assert_int_equal(app.telemetry.blocks_lost, jumps[i][2]);
    }
}

/* Without the reference nothing can be said in inches or pounds: missing, and a fault. */
TEST_IN(without_reference_there_are_no_readings, start, NULL)
{
    struct mr_displacement_1_3 d;
    struct mr_tension_1_3 t;
    uint16_t before = health_get_count(MR_FAULT_REFERENCE);
    play(100);
    assert_int_equal(health_get_count(MR_FAULT_REFERENCE), before);
    for (unsigned n = 0; n < 100; n++) {
        play_block();
        fake.block.index = index_now++;
        fake.block.tick = 2352u + 84000u * fake.block.index;
        fake.block.sum[MR_ADC1_REFERENCE] = 8u * 1000u;
        fake.block_ready = true;
        app_poll(&app);
    }
    assert_int_equal(health_get_count(MR_FAULT_REFERENCE), before + 100);
    fake.sent_count = 0;
    for (unsigned n = 0; n < 50; n++) { /* every block without */
        fake.block.index = index_now++;
        fake.block.tick += 84000u;
        fake.block_ready = true;
        app_poll(&app);
    }
    GET_LAST(displacement_1_3, DISPLACEMENT_1_3, &d);
    GET_LAST(tension_1_3, TENSION_1_3, &t);
    assert_true(isnan(d.d1_in) && isnan(d.d2_in) && isnan(t.t1_lb) && isnan(t.t3_lb));
}

/* Frames of others on either link are none of the board's business: neither answered nor a
 * fault. */
TEST_IN(messages_that_are_not_for_it_are_passed_over, start, NULL)
{
    struct board_can_frame *frame = &fake.received[fake.received_count++];
    *frame = (struct board_can_frame){.id = MR_ID_HELLO, .length = 8};
    fake.serial_in_count = mr_frame_encode(0, MR_ID_HELLO, (const uint8_t[8]){0}, 8,
                                           fake.serial_in);
    play(5);
    assert_int_equal(count_frames(MR_ID_ACK), 0);
    assert_int_equal(app.telemetry.serial_refused_count, 0);
    assert_int_equal(fake.received_taken, 1);
    assert_int_equal(fake.serial_in_taken, fake.serial_in_count);
}

/* Neither beyond the table nor while gages are being calibrated, and half a word is none. */
TEST_IN(configuration_commands_that_are_refused, start, NULL)
{
    struct mr_ack ack;
    struct board_can_frame *frame;
    command("config-read 99999");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_USAGE);
    command("zero 1");
    command("config-apply 1");
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.code, MR_COMMAND_CONFIG_APPLY);
    assert_int_equal(ack.status, MR_WAIT);
    play(300);
    frame = &fake.received[fake.received_count++];
    *frame = (struct board_can_frame){.id = MR_ID_CONFIG_WORD, .length = 3};
    play(1);
    assert_false(app.configstore.is_staging);
    frame = &fake.received[fake.received_count++];
    frame->id = MR_ID_CONFIG_WORD;
    frame->length = (uint8_t)mr_config_word_put(
        &(struct mr_config_word){.tag = 1, .offset = MR_CONFIG_WORDS}, frame->data);
    play(1);
    assert_false(app.configstore.is_staging);
}

/* Backward over two switches while idle: told once, with speed and place, on CAN. */
TEST_IN(a_pushback_is_told, start, NULL)
{
    struct mr_pushback pushback;
    play(50);
    for (unsigned position = 9; position > 6; position--) {
        pass_switch(position, ((double)index_now - 0.5) * 1e-3);
        play(2500); /* -2 ft/s */
    }
    assert_int_equal(count_frames(MR_ID_PUSHBACK), 1);
    GET_LAST(pushback, PUSHBACK, &pushback);
    assert_int_equal(pushback.count, 1);
    assert_int_equal(pushback.position, 8);
    assert_int_equal(pushback.state, MR_LANDING_IDLE);
    assert_near(pushback.speed_ft_s, -2.0, 0.003);
}

TEST_IN(stopped_scans_are_started_again_and_said, start, NULL)
{
    for (unsigned i = 0; i < 6; i++)
        app_supervise(&app);
    assert_int_equal(fake.restarts, 1);
    fake.sent_count = 0;
    for (unsigned i = 0; i < 100; i++)
        app_supervise(&app);
    assert_int_equal(count_frames(MR_ID_HELLO), 1);
    assert_int_equal(count_frames(MR_ID_CLOCK), 0); /* no block, no time base */
    command("mark 5");
    app_supervise(&app);
    assert_int_equal(count_frames(MR_ID_MARK), 1);
    assert_true(count_frames(MR_ID_FAULT) >= 1);
}
