#include "firmware/app.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/command.h"
#include "common/framing.h"
#include "firmware/health.h"
#include "tests/cmocka_all.h"
#include "tests/firmware/fake_board.h"

static struct app app;
static uint32_t index_now;
static float moved_in[MR_TRANSDUCERS];
static unsigned opened_codes; /* of the staircase */

static int start(void **state)
{
    (void)state;
    fake_reset();
    app_start(&app);
    index_now = 0;
    opened_codes = 0;
    memset(moved_in, 0, sizeof moved_in);
    return 0;
}

/* Codes from the rig's volts (0.5 V/in about a zero of 50 mV; 0.4 V + 5 mV/lb; 2.5 V), worked out apart from config.c. */
static void play_block(void)
{
    struct mr_block *block = &fake.block;
    memset(block, 0, sizeof *block);
    block->index = index_now;
    block->tick = 2352u + 84000u * index_now;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        double codes = (0.050 + 0.5 * (double)moved_in[i]) / 3.3 * 4096.0;
        block->plus[i] = (uint16_t)lround(4.0 * (2048.0 + codes));
        block->minus[i] = (uint16_t)lround(4.0 * (2048.0 - codes));
    }
    for (unsigned i = 0; i < MR_GAGES; i++)
        block->sum[i] = (uint16_t)lround(8.0 * (0.4 + 0.005 * (100.0 + i)) / 3.3 * 4096.0);
    block->sum[MR_ADC1_STAIRCASE] = (uint16_t)(8u * (62u + opened_codes));
    block->sum[MR_ADC1_REFERENCE] = 8u * 3103u;
    fake.block_ready = true;
    assert_true(app_poll(&app));
    index_now++;
}

static void play(unsigned blocks)
{
    while (blocks--)
        play_block();
}

static void command(const char *words)
{
    struct mr_command message;
    struct board_can_frame *frame = &fake.received[fake.received_count++];
    assert_int_equal(mr_command_parse(words, (uint16_t)fake.received_count, &message), MR_OK);
    frame->id = MR_ID_COMMAND;
    frame->length = (uint8_t)mr_command_put(&message, frame->data);
}

/* Steps 64 + 8 i, i = 7 (p - 1) mod 24. */
static unsigned step_of(unsigned position)
{
    return 64 + 8 * (7 * (position - 1) % 24);
}

/* The gear passes switch `position` now: the edge falls in the block just before the step is seen. */
static void pass_switch(unsigned position, double t_s)
{
    fake.edge_tick[fake.edges++] = (uint32_t)(uint64_t)llround(t_s * 84e6);
    opened_codes += step_of(position);
}

static const struct board_can_frame *last_frame(uint16_t id)
{
    for (size_t i = fake.sent_count; i-- > 0;) {
        if (fake.sent[i].id == id)
            return &fake.sent[i];
    }
    return NULL;
}

static unsigned count_frames(uint16_t id)
{
    unsigned count = 0;
    for (size_t i = 0; i < fake.sent_count; i++)
        count += fake.sent[i].id == id;
    return count;
}

#define GET_LAST(name, NAME, into)                                                    \
    do {                                                                              \
        const struct board_can_frame *frame_ = last_frame(MR_ID_##NAME);              \
        assert_non_null(frame_);                                                      \
        assert_int_equal(mr_##name##_get(into, frame_->data, frame_->length), MR_OK); \
    } while (0)

/* Touchdown at 3 ft, 1.0 s, 30 ft/s, braking at 6 ft/s2: rest after 5 s at 78 ft. Runs until `end_s`. */
static double fly(double end_s)
{
    unsigned next = 1;
    const double t0 = 1.0, v = 30.0, a = 6.0;
    while ((double)index_now * 1e-3 < end_s) {
        double station_ft = -2.5 + 5.0 * (next - 1);
        double d = station_ft - 3.0, left = v * v - 2.0 * a * d;
        double t_s = left < 0.0 ? 1e9 : t0 + (d < 0.0 ? d / v : (v - sqrt(left)) / a);
        if (next <= 24 && t_s < (double)index_now * 1e-3) {
            pass_switch(next, t_s);
            next++;
        }
        play_block();
    }
    return t0 + v / a;
}

static void it_says_hello_first(void **state)
{
    (void)state;
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

static void rates_are_those_of_the_design(void **state)
{
    (void)state;
    play(200);
    command("arm 5");
    play(1000);
    fake.sent_count = 0;
    play(1000);
    assert_int_equal(count_frames(MR_ID_DISPLACEMENT_1_3), 500);
    assert_int_equal(count_frames(MR_ID_DISPLACEMENT_7_8), 500);
    assert_int_equal(count_frames(MR_ID_TENSION_1_3), 250);
    assert_int_equal(count_frames(MR_ID_TENSION_13_14), 250);
    assert_int_equal(count_frames(MR_ID_ZONE), 20);
    assert_int_equal(count_frames(MR_ID_HEALTH), 10);
    assert_true(fake.sent_count < 3000);
}

static void readings_are_in_inches_and_pounds(void **state)
{
    (void)state;
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

static void a_landing_goes_through_its_states(void **state)
{
    (void)state;
    struct mr_landing message;
    struct mr_touchdown touchdown;
    struct mr_stop stop;
    play(100);
    command("arm 7");
    double rest_s = fly(9.0);
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, LANDING_DONE);
    assert_int_equal(message.landing, 7);
    assert_int_equal(count_frames(MR_ID_EDGE), 17); /* -2.5, 2.5, ... 77.5 */
    GET_LAST(touchdown, TOUCHDOWN, &touchdown);
    assert_near(touchdown.speed_ft_s, 30.0, 0.0011);
    assert_near(touchdown.deceleration_ft_s2, 6.0, 0.0011);
    GET_LAST(stop, STOP, &stop);
    assert_near(stop.station_ft, 78.0, 0.003);
    assert_near(stop.after_touchdown_s, 5.0, 0.0011);
    assert_int_equal(stop.switches, 17);
    /* half a second after rest it settles, two seconds later it is done */
    assert_near(message.block, 1000.0 * (rest_s + 0.5 + 2.0), 5.0);
    command("disarm");
    play(1);
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, LANDING_IDLE);
}

static void every_switch_is_named(void **state)
{
    (void)state;
    unsigned next = 1;
    command("arm 1");
    play(10);
    fly(8.0);
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_edge edge;
        if (fake.sent[i].id != MR_ID_EDGE)
            continue;
        assert_int_equal(mr_edge_get(&edge, fake.sent[i].data, fake.sent[i].length), MR_OK);
        assert_int_equal(edge.position, next);
        assert_near(edge.step_codes, step_of(next), 0.2);
        next++;
    }
}

static void survey(float slack_in)
{
    char words[64];
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        snprintf(words, sizeof words, "survey %u %.4f", s, (double)slack_in);
        command(words);
    }
}

static void closing_joints_ahead_are_warned_of(void **state)
{
    (void)state;
    struct mr_zone zone;
    struct mr_zone_lead lead;
    survey(0.1f);
    play(2);
    command("arm 2");
    play(600);
    GET_LAST(zone_lead, ZONE_LEAD, &lead);
    assert_int_equal(lead.warning, 0);
    assert_false(fake.warning);
    /* stations 40 and 50 approach each other by 0.35 in: the joints of three segments and a half, 30 whole mats */
    moved_in[0] = 0.36f;
    moved_in[1] = 0.01f;
    play(30);
    assert_true(fake.warning);
    GET_LAST(zone, ZONE, &zone);
    assert_near(zone.start_ft, 40.0, 0.011);
    assert_in_range(zone.mats, 30, 40);
    GET_LAST(zone_lead, ZONE_LEAD, &lead);
    assert_int_equal(lead.warning, 1);
    assert_true(isnan(lead.lead_s)); /* no wheel yet */
    command("disarm");
    play(1);
    assert_false(fake.warning);
}

static void commands_are_answered_with_the_reason(void **state)
{
    (void)state;
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
    fake.received[fake.received_count - 1].data[0] = 99;
    fake.received_taken--;
    play(1);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_UNKNOWN);
}

static void a_full_queue_drops_and_counts(void **state)
{
    (void)state;
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
    assert_in_range(serial.dropped, 100, 300);
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

static void serial_carries_every_block_and_no_gap(void **state)
{
    (void)state;
    struct mr_deframer deframer;
    struct mr_frame frame;
    struct mr_block block;
    unsigned blocks = 0, frames = 0;
    uint32_t first = 0;
    command("arm 1");
    play(500);
    mr_deframer_init(&deframer);
    for (size_t i = 0; i < fake.serial_count; i++) {
        enum mr_status status = mr_deframer_push(&deframer, fake.serial[i], &frame);
        if (status == MR_TOO_FEW)
            continue;
        assert_int_equal(status, MR_OK);
        assert_int_equal(frame.seq, frames++);
        if (frame.type == MR_ID_BLOCK) {
            assert_int_equal(mr_block_get(&block, frame.payload, frame.length), MR_OK);
            if (blocks == 0)
                first = block.index;
            assert_int_equal(block.index, first + blocks);
            blocks++;
        }
    }
    assert_int_equal(blocks, 500);
}

static void a_bad_serial_frame_is_counted_and_the_next_one_obeyed(void **state)
{
    (void)state;
    struct mr_command message;
    struct mr_ack ack;
    uint8_t payload[MR_MESSAGE_MAX], out[MR_FRAME_MAX];
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
    assert_int_equal(app.telemetry.serial_bad, 1);
    assert_true(health_faults() & 1u << MR_FAULT_SERIAL_BAD_FRAME);
}

static void can_is_silent_on_the_internal_oscillator(void **state)
{
    (void)state;
    fake_reset();
    fake.clock_source = BOARD_CLOCK_INTERNAL;
    app_start(&app);
    play(100);
    assert_int_equal(fake.sent_count, 0);
    assert_true(fake.serial_count > 0);
}

static void stopped_scans_are_started_again_and_said(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 6; i++)
        app_supervise(&app);
    assert_int_equal(fake.restarts, 1);
    fake.sent_count = 0;
    for (unsigned i = 0; i < 100; i++)
        app_supervise(&app);
    assert_int_equal(count_frames(MR_ID_HELLO), 1);
    assert_true(count_frames(MR_ID_FAULT) >= 1);
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup(name, start)
    const struct CMUnitTest tests[] = {
        TEST(it_says_hello_first),
        TEST(rates_are_those_of_the_design),
        TEST(readings_are_in_inches_and_pounds),
        TEST(a_landing_goes_through_its_states),
        TEST(every_switch_is_named),
        TEST(closing_joints_ahead_are_warned_of),
        TEST(commands_are_answered_with_the_reason),
        TEST(a_full_queue_drops_and_counts),
        TEST(serial_carries_every_block_and_no_gap),
        TEST(a_bad_serial_frame_is_counted_and_the_next_one_obeyed),
        TEST(can_is_silent_on_the_internal_oscillator),
        TEST(stopped_scans_are_started_again_and_said),
    };
    return cmocka_run_group_tests_name("firmware/app", tests, NULL, NULL);
}
