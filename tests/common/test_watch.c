/* Watch over the channels: noise, rate, stuck, and what is told of it. Three transducers at 40, 50
 * and 60 ft and three gages play readings that are written down here. */
#include <math.h>
#include <string.h>

#include "common/channels.h"
#include "common/splitmix.h"
#include "common/watch.h"
#include "tests/cmocka_all.h"

#define FIRST 1000u /* block */

static struct mr_channel_config config[MR_CHANNELS];
static struct mr_watch watch;
static float reading_in[3];
static uint8_t wiring[3]; /* what the block itself says */
static float got_in[3];
static uint8_t got[3];
static uint32_t block;
static unsigned told[3];
static struct mr_watch_change news[3];
static double noise_in;
static uint64_t seed;

static double uniform(void)
{
    return mr_splitmix64_uniform(&seed);
}

static double normal(void)
{
    double sum = -6.0;
    for (unsigned i = 0; i < 12; i++)
        sum += uniform();
    return sum;
}

static int start(void **state)
{
    (void)state;
    memset(config, 0, sizeof config);
    for (unsigned c = 0; c < 3; c++) {
        config[c] = (struct mr_channel_config){.kind = MR_KIND_DISPLACEMENT,
                                               .number = (uint8_t)(c + 1),
                                               .station_ft = 40.0f + 10.0f * (float)c,
                                               .unit_per_code = 0.0016f,
                                               .rate_limit_per_s = 100.0f};
        reading_in[c] = 0.0f;
        wiring[c] = MR_VALID;
        told[c] = 0;
    }
    noise_in = 0.0;
    seed = 7;
    block = FIRST;
    mr_watch_begin(&watch, config, FIRST);
    return 0;
}

static void play_block(void)
{
    for (unsigned c = 0; c < 3; c++) {
        float value = wiring[c] == MR_VALID ? reading_in[c] + (float)(noise_in * normal()) : NAN;
        struct mr_reading reading = {value, value / 0.0016f, wiring[c]};
        mr_watch_check(&watch, &config[c], c, block, &reading);
        got_in[c] = reading.value;
        got[c] = reading.validity;
        assert_int_equal(isnan(reading.value), reading.validity != MR_VALID);
    }
    for (unsigned c = 0; c < 3; c++)
        told[c] += mr_watch_get_change(&watch, c, block, &news[c]);
    block++;
}

static void play(unsigned blocks)
{
    while (blocks--)
        play_block();
}

/* ---- noise ---- */

TEST_IN(noise_is_what_was_put_in, start, NULL)
{
    noise_in = 0.002;
    assert_true(isnan(mr_watch_noise(&watch, 0)));
    play(10);
    assert_true(mr_watch_noise(&watch, 0) > 0.0f);
    double mean = 0.0;
    for (unsigned i = 0; i < 100; i++) {
        play(520); /* as long as the mean reaches */
        double noise = (double)mr_watch_noise(&watch, 0);
        assert_near(noise, 0.002, 0.0009); /* 64 second differences: 9 % each time */
        mean += noise / 100.0;
    }
    assert_near(mean, 0.002, 0.0001);
}

TEST_IN(movement_is_no_noise, start, NULL)
{
    noise_in = 0.001;
    for (unsigned i = 0; i < 1500; i++) {
        /* 5 in/s, turning round: as fast as mats were seen to move */
        for (unsigned c = 0; c < 3; c++)
            reading_in[c] = (float)(0.2 * sin((double)i * 0.025));
        play_block();
    }
    assert_near(mr_watch_noise(&watch, 1), 0.001, 0.0004);
    for (unsigned i = 0; i < 8; i++) {
        /* jumps, at each place in its turn: two of them fall into a second difference */
        reading_in[1] += 0.05f;
        play(9);
    }
    assert_near(mr_watch_noise(&watch, 1), 0.001, 0.0009);
}

/* ---- rate ---- */

TEST_IN(a_spike_is_refused_and_told_at_once, start, NULL)
{
    play(100);
    reading_in[1] = 0.5f;
    play_block();
    assert_int_equal(got[1], MR_INVALID_RATE);
    assert_int_equal(told[1], 1);
    assert_int_equal(news[1].validity, MR_INVALID_RATE);
    assert_int_equal(news[1].block, FIRST + 100);
    reading_in[1] = 0.0f;
    play_block();
    assert_int_equal(got[1], MR_VALID);
    assert_int_equal(watch.channel[1].invalid_count, 1);
    assert_int_equal(told[0] + told[2], 0);
}

TEST_IN(a_step_is_believed_when_it_lasts, start, NULL)
{
    play(100);
    reading_in[1] = 0.55f; /* 100 in/s: after 6 ms anything may be there */
    play(5);
    assert_int_equal(got[1], MR_INVALID_RATE);
    play(1);
    assert_int_equal(got[1], MR_VALID);
    assert_near(got_in[1], 0.55, 1e-6);
}

TEST_IN(as_fast_as_allowed_is_valid_and_no_limit_none, start, NULL)
{
    for (unsigned i = 0; i < 100; i++) {
        reading_in[0] += 0.099f;
        play_block();
        assert_int_equal(got[0], MR_VALID);
    }
    config[2].rate_limit_per_s = 0.0f;
    reading_in[2] = 50.0f;
    play_block();
    assert_int_equal(got[2], MR_VALID);
}

/* ---- stuck ---- */

static void all_move_but(int stuck, unsigned blocks)
{
    for (unsigned i = 0; i < blocks; i++) {
        for (int c = 0; c < 3; c++)
            reading_in[c] += c == stuck ? 0.0f : 0.0005f; /* half an inch a second */
        play_block();
    }
}

TEST_IN(a_channel_that_stays_between_two_that_move_is_stuck, start, NULL)
{
    noise_in = 0.001;
    play(600);
    all_move_but(-1, 100);
    uint32_t stops = block;
    all_move_but(1, 200); /* 0.1 in */
    assert_int_equal(got[1], MR_INVALID_STUCK);
    assert_int_equal(told[1], 1);
    assert_int_equal(news[1].validity, MR_INVALID_STUCK);
    /* since it left its band last: 0.008 in at 0.5 in/s, and looked at every eighth block */
    assert_in_range(news[1].block, stops - 40, stops + 8);
    assert_int_equal(told[0] + told[2], 0);
    all_move_but(-1, 40);
    assert_int_equal(got[1], MR_VALID); /* it got loose */
    play(1000);
    assert_int_equal(news[1].validity, MR_VALID);
}

TEST_IN(with_one_neighbour_or_none_moving_it_is_not, start, NULL)
{
    noise_in = 0.001;
    play(600);
    all_move_but(0, 400); /* the first one has neighbours on one side only */
    assert_int_equal(got[0], MR_VALID);
    for (unsigned i = 0; i < 400; i++) {
        reading_in[0] += 0.0005f;
        play_block();
    }
    assert_int_equal(got[1], MR_VALID);
    assert_int_equal(told[0] + told[1] + told[2], 0);
}

TEST_IN(before_half_a_second_nothing_is_judged, start, NULL)
{
    all_move_but(1, 500);
    assert_int_equal(got[1], MR_VALID);
}

TEST_IN(an_invalid_neighbour_is_passed_over, start, NULL)
{
    config[3] = config[2];
    config[3].station_ft = 70.0f;
    mr_watch_begin(&watch, config, FIRST);
    wiring[2] = MR_INVALID_OPEN;
    float fourth_in = 0.0f;
    for (unsigned i = 0; i < 900; i++) {
        struct mr_reading reading = {fourth_in, 0.0f, MR_VALID};
        if (i >= 600) {
            reading_in[0] += 0.0005f;
            fourth_in += 0.0005f;
        }
        play_block();
        mr_watch_check(&watch, &config[3], 3, block - 1, &reading);
    }
    assert_int_equal(got[1], MR_INVALID_STUCK);
    config[3] = (struct mr_channel_config){0};
}

TEST_IN(codes_that_end_to_change_are_stuck, start, NULL)
{
    noise_in = 0.001; /* 0.6 codes */
    play(800);
    noise_in = 0.0;
    play(195);
    assert_int_equal(got[0], MR_VALID);
    play(20);
    assert_int_equal(got[0], MR_INVALID_STUCK);
    assert_int_equal(news[0].validity, MR_INVALID_STUCK);
    assert_in_range(news[0].block, FIRST + 799, FIRST + 801);
}

TEST_IN(a_quiet_channel_without_noise_is_healthy, start, NULL)
{
    play(5000);
    for (unsigned c = 0; c < 3; c++) {
        assert_int_equal(got[c], MR_VALID);
        assert_int_equal(told[c], 0);
    }
    all_move_but(-1, 1000);
    play(5000);
    assert_int_equal(told[0] + told[1] + told[2], 0);
}

/* ---- what is told ---- */

TEST_IN(a_change_is_told_once_when_it_holds, start, NULL)
{
    play(100);
    wiring[0] = MR_INVALID_OPEN;
    play(9);
    assert_int_equal(told[0], 0);
    play(1);
    assert_int_equal(told[0], 1);
    assert_int_equal(news[0].validity, MR_INVALID_OPEN);
    assert_int_equal(news[0].block, FIRST + 100);
    play(2000);
    assert_int_equal(told[0], 1);
    wiring[0] = MR_VALID;
    play(99);
    assert_int_equal(told[0], 1);
    play(1);
    assert_int_equal(told[0], 2);
    assert_int_equal(news[0].validity, MR_VALID);
    assert_int_equal(news[0].block, FIRST + 2110);
    assert_int_equal(watch.channel[0].invalid_count, 2010);
}

TEST_IN(a_fluttering_contact_floods_nobody, start, NULL)
{
    for (unsigned i = 0; i < 10000; i++) {
        wiring[1] = i / 15 % 2 ? MR_INVALID_SATURATED : MR_VALID;
        wiring[2] = i / 150 % 2 ? MR_INVALID_OPEN : MR_VALID;
        play_block();
    }
    assert_int_equal(told[1], 1);     /* it is never good for long */
    assert_in_range(told[2], 15, 20); /* two a second, as they come */
}

TEST_IN(between_landings_only_the_wiring_is_looked_at, start, NULL)
{
    noise_in = 0.001;
    play(600);
    all_move_but(1, 200);
    assert_int_equal(got[1], MR_INVALID_STUCK);
    mr_watch_end(&watch);
    play(1000);
    assert_int_equal(got[1], MR_VALID);
    assert_int_equal(told[1], 1); /* nothing is known of it now: nothing is told */
    wiring[1] = MR_INVALID_OPEN;
    play(10);
    assert_int_equal(told[1], 2);
    mr_watch_begin(&watch, config, block); /* and is told anew with the next landing */
    play(10);
    assert_int_equal(told[1], 3);
}

/* ---- the standard error ---- */

/* sqrt(0.003^2/9 + 0.01^2 + (0.005*2)^2 + (0.004*1)^2 + 0.02^2 + (0.001*2.1)^2), by hand. */
TEST(the_terms_of_an_error_add_up)
{
    const struct mr_channel_config c = {.unit_per_code = 0.001f,
                                        .zero_code = 100.0f,
                                        .gain_error = 0.005f,
                                        .zero_error = 0.02f,
                                        .linearity_error = 0.01f,
                                        .drift_error_per_h = 0.004f};
    struct mr_error_conditions reading = {.value = 2.0f,
                                          .noise = 0.003f,
                                          .averaged_blocks = 9.0f,
                                          .hours = 1.0f,
                                          .reference_error = 0.001f};
    assert_near(mr_reading_error(&c, &reading), 0.024928, 0.000001);
    /* of a movement: sqrt(0.003^2/9 + 0.003^2/100 + 0.01^2 + (0.005*2)^2 + (0.004*0.5)^2 +
     * (0.001*2)^2) */
    reading.baseline_blocks = 100.0f;
    reading.hours = 0.5f;
    assert_near(mr_reading_error(&c, &reading), 0.014460, 0.000001);
    reading.noise = NAN;
    assert_true(isnan(mr_reading_error(&c, &reading)));
}

/* Without noise a reading is one of steps of a code, 0.289 codes from the truth; and the curve is
 * right at the zero. */
TEST(at_rest_without_noise_rounding_is_left)
{
    const struct mr_channel_config c = {
        .unit_per_code = 0.001f, .linearity_error = 0.01f, .low = -1.0f, .high = 7.0f};
    struct mr_error_conditions still = {
        .value = 0.0f, .noise = 0.0f, .averaged_blocks = 100.0f, .baseline_blocks = 256.0f};
    assert_near(mr_reading_error(&c, &still), 0.000289, 1e-6);
    still.value = -0.4082483f; /* half of sqrt(2/3) of an eighth of the range, 1 in */
    assert_near(mr_reading_error(&c, &still), 0.005008, 1e-5);
    still.value = 3.0f;
    assert_near(mr_reading_error(&c, &still), 0.010004, 1e-5);
}
