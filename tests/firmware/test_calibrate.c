/* Zero and shunt by command, and what the bands' watch says, on the fake board: codes are worked
 * out here from the rig's volts. */
#include "tests/firmware/play.h"

#include "common/bands.h"
#include "common/channels.h"
#include "common/wire.h"
#include "firmware/channels.h"

#define CODES_PER_LB (0.005 * 4096.0 / 3.3)

/* Blocks with these tensions, the shunts when the relay is on, and a gain of each gage. */
static double tension_lb[MR_GAGES], gain[MR_GAGES];
static double wobble_lb; /* of gage 3, in each second half of 256 blocks */
static bool broken;      /* gage 4 saturates */
static double scale;     /* of the converter: all codes, the reference's too */

static void play_gages(unsigned blocks)
{
    while (blocks--) {
        struct mr_block *block = &fake.block;
        memset(block, 0, sizeof *block);
        block->index = index_now;
        block->tick = 2352u + 84000u * index_now;
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            double codes = (0.050 + 0.5 * (double)moved_in[i]) / 3.3 * 4096.0;
            block->forward_sum[i] = (uint16_t)lround(4.0 * (2048.0 + codes));
            block->reversed_sum[i] = (uint16_t)lround(4.0 * (2048.0 - codes));
        }
        for (unsigned i = 0; i < MR_GAGES; i++) {
            double lb = gain[i] * (tension_lb[i] + (fake.shunted ? 40.0 : 0.0));
            if (i == 2 && index_now % 256 >= 128)
                lb += wobble_lb;
            block->sum[i] =
                (uint16_t)lround(8.0 * scale * (0.4 * 4096.0 / 3.3 + lb * CODES_PER_LB));
        }
        block->high_count[MR_TRANSDUCERS + 3] = broken;
        block->sum[MR_ADC1_STAIRCASE] = 8u * 62u;
        block->sum[MR_ADC1_REFERENCE] = (uint16_t)lround(scale * 8.0 * 3103.0);
        fake.block_ready = true;
        assert_true(app_poll(&app));
        index_now++;
    }
}

/* `config` outlives a test. */
static void configured_zeros(void)
{
    zero_swap();
    zero_reset();
}

static int start_rig(void **state)
{
    configured_zeros();
    start(state);
    for (unsigned i = 0; i < MR_GAGES; i++) {
        tension_lb[i] = 0.0;
        gain[i] = 1.0;
    }
    wobble_lb = 0.0;
    broken = false;
    scale = 1.0;
    return 0;
}

static int end_rig(void **state)
{
    (void)state;
    configured_zeros();
    return 0;
}

static struct mr_ack last_ack(void)
{
    struct mr_ack ack = {0};
    GET_LAST(ack, ACK, &ack);
    return ack;
}

static struct mr_shunt_result result_of(unsigned gage)
{
    struct mr_shunt_result result = {0};
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_shunt_result each;
        if (fake.sent[i].id == MR_ID_SHUNT_RESULT &&
            mr_shunt_result_get(&each, fake.sent[i].data, 8) == MR_OK && each.gage == gage)
            result = each;
    }
    assert_int_equal(result.gage, gage);
    return result;
}

TEST_IN(shunts_are_measured_and_a_wrong_gain_is_named, start_rig, end_rig)
{
    struct mr_shunt begun;
    struct mr_shunt_check check;
    for (unsigned i = 0; i < MR_GAGES; i++)
        tension_lb[i] = 100.0 + i;
    gain[4] = 1.03;
    command("shunt");
    play_gages(1);
    assert_int_equal(count_frames(MR_ID_ACK), 0); /* answered at the end */
    play_gages(300);
    assert_true(fake.shunted);
    play_gages(256 + 64);
    assert_false(fake.shunted);
    play_gages(320);
    assert_int_equal(last_ack().code, MR_COMMAND_SHUNT);
    assert_int_equal(last_ack().status, MR_LIMIT);
    GET_LAST(shunt, SHUNT, &begun);
    assert_int_equal(begun.number, 1);
    assert_int_equal(begun.block, 0);
    assert_int_equal(count_frames(MR_ID_SHUNT_RESULT), 14);
    for (unsigned g = 1; g <= MR_GAGES; g++) {
        struct mr_shunt_result result = result_of(g);
        assert_int_equal(result.verdict, g == 5 ? 3 : 0);
        /* codes are whole eighths: 0.02 lb */
        assert_near(result.span_lb, g == 5 ? 41.2 : 40.0, 0.03);
        assert_near(result.noise_lb, 0.0, 1e-3);
    }
    GET_LAST(shunt_check, SHUNT_CHECK, &check);
    assert_near(check.expected_lb, 40.0, 1e-3);
    assert_true(isnan(check.change_lb)); /* there was none before */

    /* A second one, after a landing say: gage 14 has drifted by 2 %, all have lost 3 lb. */
    for (unsigned i = 0; i < MR_GAGES; i++)
        tension_lb[i] -= 3.0;
    gain[4] = 1.0;
    gain[13] = 1.02;
    command("shunt");
    play_gages(1000);
    assert_int_equal(last_ack().status, MR_LIMIT);
    GET_LAST(shunt, SHUNT, &begun);
    assert_int_equal(begun.number, 2);
    GET_LAST(shunt_check, SHUNT_CHECK, &check);
    assert_int_equal(check.gage, 14);
    assert_near(check.change_lb, 0.8, 0.05);
    assert_near(check.zero_change_lb, 1.02 * 110.0 - 113.0, 0.05);
    assert_int_equal(result_of(5).verdict, 0);
}

TEST_IN(a_gage_that_moves_or_fails_is_not_measured, start_rig, end_rig)
{
    wobble_lb = 3.0;
    broken = true;
    command("shunt");
    play_gages(1000);
    assert_int_equal(last_ack().status, MR_LIMIT);
    assert_int_equal(result_of(3).verdict, 2);
    assert_int_equal(result_of(4).verdict, 1);
    assert_true(isnan(result_of(4).span_lb));
    assert_int_equal(result_of(1).verdict, 0);
}

TEST_IN(neither_goes_on_in_a_landing_nor_beside_the_other, start_rig, end_rig)
{
    command("shunt");
    command("zero");
    play_gages(1);
    assert_int_equal(last_ack().code, MR_COMMAND_ZERO);
    assert_int_equal(last_ack().status, MR_NOT_NOW);
    command("arm 3");
    play_gages(1);
    assert_int_equal(last_ack().code, MR_COMMAND_ARM);
    assert_int_equal(last_ack().status, MR_WAIT);
    play_gages(1000);
    command("arm 3");
    play_gages(1);
    assert_int_equal(last_ack().status, MR_OK);
    command("shunt");
    play_gages(1);
    assert_int_equal(last_ack().status, MR_NOT_NOW);
    command("zero 1");
    play_gages(1);
    assert_int_equal(last_ack().status, MR_NOT_NOW);
    command("disarm");
    command("zero 3");
    play_gages(1);
    assert_int_equal(last_ack().status, MR_USAGE);
}

TEST_IN(scans_that_stop_end_it_with_the_relay_off, start_rig, end_rig)
{
    command("shunt");
    play_gages(300);
    assert_true(fake.shunted);
    for (unsigned i = 0; i < 5; i++)
        app_supervise(&app);
    assert_false(fake.shunted);
    assert_int_equal(last_ack().code, MR_COMMAND_SHUNT);
    assert_int_equal(last_ack().status, MR_TIMEOUT);
    command("zero 1");
    play_gages(300);
    assert_int_equal(last_ack().status, MR_OK);
}

static struct mr_channel_zero zero_of(unsigned index)
{
    struct mr_channel_zero zero = {.index = 99};
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_channel_zero each;
        if (fake.sent[i].id == MR_ID_CHANNEL_ZERO &&
            mr_channel_zero_get(&each, fake.sent[i].data, 8) == MR_OK && each.index == index)
            zero = each;
    }
    assert_int_equal(zero.index, index);
    return zero;
}

TEST_IN(a_zero_is_in_force_and_told_and_the_configured_one_kept, start_rig, end_rig)
{
    struct mr_displacement_1_3 d;
    struct mr_tension_1_3 t;
    moved_in[1] = 0.25f;
    tension_lb[0] = 4.0;
    play_gages(200);
    assert_int_equal(zero_of(1).measured, 0);
    command("zero");
    play_gages(257);
    assert_int_equal(last_ack().code, MR_COMMAND_ZERO);
    assert_int_equal(last_ack().status, MR_OK);
    play_gages(200);
    GET_LAST(displacement_1_3, DISPLACEMENT_1_3, &d);
    GET_LAST(tension_1_3, TENSION_1_3, &t);
    assert_near(d.d2_in, 0.0, 0.0005);
    assert_near(t.t1_lb, 0.0, 0.03);
    /* 0.25 in at 0.5 V/in on 0.050 V of 3.3 V; 4 lb at 5 mV/lb on 0.4 V */
    assert_near(zero_of(1).zero_code, 0.175 * 4096.0 / 3.3, 0.2);
    assert_int_equal(zero_of(1).measured, 1);
    assert_near(zero_of(8).zero_code, 0.42 * 4096.0 / 3.3, 0.2);
    assert_near(zero_get_configured(1), 0.050 * 4096.0 / 3.3, 1e-3);
    configured_zeros();
    assert_near(config.channel[1].zero_code, 0.050 * 4096.0 / 3.3, 1e-3);
    assert_false(zero_is_measured(1));
}

/* A converter whose scale is 1 % off: the zero is what it reads there, and pounds are pounds
 * still. */
TEST_IN(a_zero_holds_whatever_the_converters_scale, start_rig, end_rig)
{
    struct mr_tension_1_3 t;
    scale = 0.99;
    tension_lb[0] = 4.0;
    command("zero 2");
    play_gages(400);
    assert_int_equal(last_ack().status, MR_OK);
    GET_LAST(tension_1_3, TENSION_1_3, &t);
    assert_near(t.t1_lb, 0.0, 0.03);
    tension_lb[0] = 54.0;
    play_gages(200);
    GET_LAST(tension_1_3, TENSION_1_3, &t);
    assert_near(t.t1_lb, 50.0, 0.05);
    command("shunt");
    play_gages(1000);
    assert_int_equal(last_ack().status, MR_OK);
    assert_near(result_of(1).span_lb, 40.0, 0.03);
}

static unsigned verdict_of_zero(unsigned index)
{
    unsigned verdict = 99;
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_zero_result result;
        if (fake.sent[i].id == MR_ID_ZERO_RESULT &&
            mr_zero_result_get(&result, fake.sent[i].data, 8) == MR_OK && result.index == index)
            verdict = result.verdict;
    }
    return verdict;
}

TEST_IN(a_zero_of_what_moves_fails_or_is_under_tension_is_refused, start_rig, end_rig)
{
    float before = config.channel[0].zero_code;
    wobble_lb = 3.0;
    broken = true;
    tension_lb[6] = 100.0;
    moved_in[0] = 0.1f;
    command("zero 0");
    play_gages(300);
    assert_int_equal(last_ack().status, MR_LIMIT);
    assert_int_equal(verdict_of_zero(0), 0);
    assert_int_equal(verdict_of_zero(8 + 2), 2);
    assert_int_equal(verdict_of_zero(8 + 3), 1);
    assert_int_equal(verdict_of_zero(8 + 6), 3);
    assert_true(config.channel[0].zero_code == before); /* none was taken */
    fake.sent_count = 0;
    command("zero 1"); /* the gages do not matter to the transducers */
    play_gages(300);
    assert_int_equal(last_ack().status, MR_OK);
    assert_int_equal(verdict_of_zero(8), 99);
    assert_true(config.channel[0].zero_code != before);
}

/* What a replay does: the very bits of a zero that was measured. */
TEST_IN(a_zero_can_be_given, start_rig, end_rig)
{
    float code = 71.3125f;
    struct mr_command message = {.code = MR_COMMAND_ZERO, .index = 3, .tag = 9};
    struct board_can_frame *frame = &fake.received[fake.received_count++];
    memcpy(&message.argument, &code, sizeof code);
    app.is_replay = true;
    frame->id = MR_ID_COMMAND;
    frame->length = (uint8_t)mr_command_put(&message, frame->data);
    play_gages(1);
    assert_int_equal(last_ack().status, MR_OK);
    play_gages(60);
    assert_true(zero_of(2).zero_code == code);
    assert_int_equal(zero_of(2).measured, 1);
}

/* What is read out is to be edited and sent back: a measured zero must not become a configured one
 * on the way. It stays in force. */
TEST_IN(the_configuration_read_out_has_the_configured_zeros, start_rig, end_rig)
{
    static struct mr_config told;
    static uint8_t image[MR_CONFIG_IMAGE_BYTES];
    moved_in[1] = 0.25f;
    command("zero 1");
    play_gages(257);
    assert_int_equal(last_ack().status, MR_OK);
    float in_force = config.channel[1].zero_code;
    fake.sent_count = 0;
    command("config-read");
    play_gages(MR_CONFIG_WORDS);
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_config_image word;
        if (fake.sent[i].id == MR_ID_CONFIG_IMAGE &&
            mr_config_image_get(&word, fake.sent[i].data, 8) == MR_OK)
            mr_put_u32(image + 4u * word.offset, word.value);
    }
    assert_int_equal(mr_config_decode(image, sizeof image, &told), MR_OK);
    assert_near(told.channel[1].zero_code, 0.050 * 4096.0 / 3.3, 1e-3);
    assert_near(in_force, 0.175 * 4096.0 / 3.3, 0.2);
    assert_true(config.channel[1].zero_code == in_force);
    assert_true(zero_is_measured(1));
}

/* A band that creeps by half a pound while its shunt is on: the span is taken from the middle of
 * before and after. */
TEST_IN(creep_is_taken_out_of_a_span, start_rig, end_rig)
{
    command("shunt");
    play_gages(256 + 64); /* the first rest, and the relay settles */
    tension_lb[6] += 0.25;
    play_gages(256);
    tension_lb[6] += 0.25;
    play_gages(400);
    assert_int_equal(result_of(7).verdict, 0);
    assert_near(result_of(7).span_lb, 40.0, 0.03); /* not 40.25 */
}

/* A movement since the baseline: as built in, zero and drift drop out and 0.002 in of linearity
 * near the zero is left; an absolute reading of a gage keeps its zero's pound. */
TEST_IN(a_movement_is_without_the_error_of_the_zero, start_rig, end_rig)
{
    double error_in = 0.0;
    command("arm 1");
    play_gages(2100);
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_channel_quality each;
        if (fake.sent[i].id == MR_ID_CHANNEL_QUALITY &&
            mr_channel_quality_get(&each, fake.sent[i].data, 8) == MR_OK && each.index == 3)
            error_in = (double)each.error_codes * 3.3 / 2048.0;
    }
    assert_in_range((unsigned)lround(error_in * 1e6), 1, 2000); /* the zero's error alone is 5800 */
}

/* Ten pounds are the new zero: what is told after it is ten, nothing or missing, never in
 * between. */
TEST_IN(no_mean_goes_over_two_zeros, start_rig, end_rig)
{
    struct mr_tension_1_3 tension;
    struct mr_slow_tension slow;
    for (unsigned i = 0; i < MR_GAGES; i++)
        tension_lb[i] = 10.0;
    play_gages(144);
    command("zero 2");
    play_gages(256); /* up to block 399 */
    assert_int_equal(last_ack().status, MR_OK);
    GET_LAST(tension_1_3, TENSION_1_3, &tension);
    assert_near(tension.t1_lb, 10.0, 0.05);
    play_gages(2); /* the mean of blocks 398 to 401 */
    GET_LAST(tension_1_3, TENSION_1_3, &tension);
    assert_true(isnan(tension.t1_lb));
    play_gages(100);
    GET_LAST(tension_1_3, TENSION_1_3, &tension);
    assert_near(tension.t1_lb, 0.0, 0.05);

    configured_zeros();
    /* 3 s before a row of the slow log: its mean would begin 1.1 s before the zero */
    index_now = 57000;
    fake.sent_count = 0;
    command("zero 2");
    play_gages(3010);
    assert_int_equal(last_ack().status, MR_OK);
    assert_int_equal(count_frames(MR_ID_SLOW_TENSION), 5);
    GET_LAST(slow_tension, SLOW_TENSION, &slow);
    assert_near(slow.a_lb, 0.0, 0.05);
}

/* As built in: 0.5 lb an hour of drift. Ten hours after power on, and just after a zero of the
 * gages alone: what is left is the measured zero's 0.1 lb. */
TEST_IN(drift_counts_from_the_zero, start_rig, end_rig)
{
    double error_lb[MR_GAGES] = {0};
    index_now = 36000000;
    command("zero 2");
    play_gages(300);
    assert_int_equal(last_ack().status, MR_OK);
    command("arm 1");
    play_gages(1100);
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_channel_quality each;
        if (fake.sent[i].id == MR_ID_CHANNEL_QUALITY &&
            mr_channel_quality_get(&each, fake.sent[i].data, 8) == MR_OK &&
            each.index >= MR_TRANSDUCERS)
            error_lb[each.index - MR_TRANSDUCERS] = (double)each.error_codes / CODES_PER_LB;
    }
    for (unsigned g = 0; g < MR_GAGES; g++)
        assert_near(error_lb[g], 0.115, 0.02); /* not 5 lb, nor the 1 lb configured */
}

/* Gage 5 has no shunt, gage 14 is none at all: neither is told, and the others are good. */
TEST_IN(a_gage_without_a_shunt_is_left_out, start_rig, end_rig)
{
    const struct mr_channel_config without = config.channel[MR_TRANSDUCERS + 4],
                                   none = config.channel[MR_TRANSDUCERS + 13];
    config.channel[MR_TRANSDUCERS + 4].shunt_lb = 0.0f;
    config.channel[MR_TRANSDUCERS + 13].kind = MR_KIND_NONE;
    fake.sent_count = 0;
    command("shunt");
    play_gages(1000);
    config.channel[MR_TRANSDUCERS + 4] = without;
    config.channel[MR_TRANSDUCERS + 13] = none;
    assert_int_equal(last_ack().status, MR_OK);
    assert_int_equal(count_frames(MR_ID_SHUNT_RESULT), MR_GAGES - 2);
    assert_int_equal(count_frames(MR_ID_SHUNT_CHECK), MR_GAGES - 2);
}

/* It goes from 0 to 2 lb while the shunts are on, and stays: not a span. */
TEST_IN(a_gage_that_moves_between_is_not_measured, start_rig, end_rig)
{
    command("shunt");
    play_gages(300);
    assert_true(fake.shunted);
    while (fake.shunted)
        play_gages(1);
    tension_lb[6] = 2.0;
    play_gages(600);
    assert_int_equal(last_ack().status, MR_LIMIT);
    assert_int_equal(result_of(7).verdict, 2);
    assert_int_equal(result_of(8).verdict, 0);
}

TEST_IN(nonsense_is_refused, start_rig, end_rig)
{
    const float codes[] = {5000.0f, -5000.0f, NAN};
    app.is_replay = true;
    for (unsigned i = 0; i < 4; i++) {
        struct mr_command message = {.code = MR_COMMAND_ZERO,
                                     .index = i < 3 ? 3 : MR_TRANSDUCERS + MR_GAGES + 1,
                                     .tag = (uint16_t)(90 + i)};
        struct board_can_frame *frame = &fake.received[fake.received_count++];
        if (i < 3)
            memcpy(&message.argument, &codes[i], sizeof codes[i]);
        frame->id = MR_ID_COMMAND;
        frame->length = (uint8_t)mr_command_put(&message, frame->data);
        play_gages(1);
        assert_int_equal(last_ack().tag, 90 + i);
        assert_int_equal(last_ack().status, MR_USAGE);
    }
    command("zero -1");
    play_gages(1);
    assert_int_equal(last_ack().status, MR_USAGE);
    command("shunt 1");
    play_gages(1);
    assert_int_equal(last_ack().status, MR_USAGE);
    assert_false(zero_is_measured(2));
}

/* For what a landing records, the zeros as configured stand for a moment in place of the measured
 * ones, and come back. A zero that is measured twice has the configured one behind it still. */
TEST_IN(measured_zeros_change_places_with_the_configured, start_rig, end_rig)
{
    float configured = config.channel[9].zero_code, untouched = config.channel[4].zero_code;
    float error_lb = config.channel[9].zero_error;
    zero_set_measured(9, 500.0f);
    zero_set_measured(9, 510.0f);
    assert_true(zero_get_configured(9) == configured);
    assert_true(error_lb > ZERO_ERROR_LB && config.channel[9].zero_error == ZERO_ERROR_LB);
    zero_swap();
    assert_true(config.channel[9].zero_code == configured);
    assert_true(config.channel[9].zero_error == error_lb);
    assert_true(config.channel[4].zero_code == untouched);
    zero_swap();
    assert_true(config.channel[9].zero_code == 510.0f);
    assert_true(config.channel[9].zero_error == ZERO_ERROR_LB);
    assert_true(zero_get_configured(9) == configured);
    assert_true(config.channel[4].zero_code == untouched);
}

/* A calibration may know a zero better than a slack band shows it: measuring does not make it
 * worse. */
TEST_IN(a_measured_zero_is_known_no_worse_than_the_configured, start_rig, end_rig)
{
    float error_lb = config.channel[10].zero_error;
    config.channel[10].zero_error = 0.02f;
    zero_set_measured(10, 500.0f);
    assert_true(config.channel[10].zero_error == 0.02f);
    config.channel[10].zero_error = error_lb;
}

TEST_IN(a_band_that_gives_way_is_told_with_its_figures, start_rig, end_rig)
{
    struct mr_band_state band;
    struct mr_band_event event;
    struct mr_band_before before;
    struct mr_band_after after;
    for (unsigned i = 0; i < MR_GAGES; i++)
        tension_lb[i] = 100.0;
    play_gages(1100);
    GET_LAST(band_state, BAND_STATE, &band);
    assert_int_equal(band.band, 2);
    assert_int_equal(band.gages, 7);
    assert_near(band.mean_lb, 100.0, 0.05);
    assert_int_equal(count_frames(MR_ID_BAND_STATE), 2 * 2);
    command("arm 4");
    play_gages(700);
    for (unsigned i = 7; i < MR_GAGES; i++) /* band 2 lets go by 20 lb, most at gage 10 */
        tension_lb[i] -= i == 9 ? 20.0 : 12.0;
    play_gages(400);
    assert_int_equal(count_frames(MR_ID_BAND_EVENT), 1);
    GET_LAST(band_event, BAND_EVENT, &event);
    assert_int_equal(event.band, 2);
    assert_int_equal(event.gage, 10);
    assert_int_equal(event.reason, MR_BAND_SLIP);
    assert_near(event.value_lb, 20.0, 0.1);
    assert_in_range(event.at_block16, 1796, 1805); /* 1101 blocks before arming and 700 after */
    fake.sent_count = 0;
    command("disarm");
    play_gages(1);
    assert_int_equal(fake.sent[0].id, MR_ID_BAND_BEFORE);
    assert_int_equal(count_frames(MR_ID_BAND_LEAST), 2);
    GET_LAST(band_before, BAND_BEFORE, &before);
    assert_int_equal(before.band, 2);
    assert_near(before.before_lb, 100.0, 0.05);
    GET_LAST(band_after, BAND_AFTER, &after);
    assert_near(after.after_lb, 100.0 - (6 * 12.0 + 20.0) / 7.0, 0.1);
    assert_near(after.change_lb, -(6 * 12.0 + 20.0) / 7.0, 0.1);
}
