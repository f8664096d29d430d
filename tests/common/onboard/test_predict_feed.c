/* What the predictor is given: the wheel carried on from the last gate, readings less their zero;
 * and that zero. Expected values from v^2 = v0^2 - 2 a x and means by hand. */
#include "common/onboard/predict_feed.h"

#include <math.h>

#include "common/wire.h"
#include "tests/cmocka_all.h"

#define TICKS_PER_S 84000000u

static float readings_in[MR_TRANSDUCERS], zero_in[MR_TRANSDUCERS];

/* A gear that passed a gate at 10 ft, at 20 ft/s, braking at 4 ft/s2, at tick 1000. */
static struct landing rolling(void)
{
    struct landing landing = {
        .state = MR_LANDING_LANDING, .is_motion_known = true, .gates_before_braking = 2};
    landing.passage.state = MR_PASSAGE_ROLLING;
    landing.passage.gate_count = 5;
    landing.passage.gate[4].station_ft = 10.0;
    landing.passage.gate_edge[4].tick = 1000u;
    landing.motion.position_ft.value = 10.0;
    landing.motion.speed_ft_s.value = 20.0;
    landing.motion.deceleration_ft_s2.value = 4.0;
    return landing;
}

static struct mr_predictor_input feed(const struct landing *landing, float touchdown_ft,
                                      double after_s)
{
    struct predict_motion motion = {0};
    struct mr_predictor_input input;
    struct predict_block block = {.tick = 1000u + (uint32_t)(after_s * TICKS_PER_S),
                                  .displacement_in = readings_in,
                                  .baseline_in = zero_in};
    predict_compute_input(&motion, landing, touchdown_ft, &block, &input);
    return input;
}

TEST(the_wheel_is_carried_on)
{
    struct landing landing = rolling();
    struct mr_predictor_input input = feed(&landing, 3.0f, 1.5);
    assert_near(input.wheel_ft, 10.0 + 20.0 * 1.5 - 2.0 * 1.5 * 1.5, 1e-4);
    assert_near(input.speed_ft_s, 14.0, 1e-4);
    assert_near(input.deceleration_ft_s2, 4.0, 0.0);
    assert_true(input.is_on_runway);
    assert_true(input.is_braking_known); /* three gates beyond touchdown */
    input = feed(&landing, 3.0f, 9.0);   /* it stopped after 5 s, 50 ft on */
    assert_near(input.wheel_ft, 60.0, 1e-4);
    assert_near(input.speed_ft_s, 0.0, 0.0);
    landing.gates_before_braking = 3;
    assert_false(feed(&landing, 3.0f, 1.5).is_braking_known);
}

TEST(the_runway_begins_where_it_is_told)
{
    struct landing landing = rolling();
    assert_true(feed(&landing, 29.5f, 1.0).is_on_runway == false); /* the wheel is at 28 ft */
    assert_true(feed(&landing, 27.5f, 1.0).is_on_runway);
}

TEST(without_a_wheel_there_is_none)
{
    struct landing landing = rolling();
    landing.passage.state = MR_PASSAGE_PUSHED;
    struct mr_predictor_input input = feed(&landing, 3.0f, 1.0);
    assert_true(isnan(input.wheel_ft) && isnan(input.speed_ft_s));
    assert_false(input.is_on_runway);
    landing = rolling();
    landing.is_motion_known = false; /* one gate alone */
    input = feed(&landing, 3.0f, 1.0);
    assert_near(input.wheel_ft, 10.0, 0.0);
    assert_true(isnan(input.speed_ft_s));
}

TEST(readings_go_in_less_their_zero)
{
    struct landing landing = rolling();
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        readings_in[i] = 0.5f * (float)i;
        zero_in[i] = i == 7 ? MR_NAN : 0.25f;
    }
    struct mr_predictor_input input = feed(&landing, 3.0f, 0.0);
    for (unsigned i = 0; i < 7; i++)
        assert_near(input.displacement_in[i], 0.5 * i - 0.25, 0.0);
    assert_true(isnan(input.displacement_in[7]));
}

TEST(a_zero_is_the_mean_of_a_full_quiet_group)
{
    struct baseline baseline;
    float in[MR_TRANSDUCERS] = {0};
    baseline_discard(&baseline);
    for (unsigned n = 0; n < BASELINE_BLOCKS - 1; n++) {
        in[0] = n % 2 ? 0.75f : 0.25f;
        baseline_update(&baseline, in, true, 0);
    }
    assert_true(isnan(baseline.zero_in[0]));  /* one block short */
    baseline_update(&baseline, in, false, 0); /* something rolls: the group is void */
    for (unsigned n = 0; n < BASELINE_BLOCKS; n++) {
        in[0] = n % 2 ? 0.75f : 0.25f;
        in[1] = 2.0f;
        baseline_update(&baseline, in, true, 0);
    }
    assert_near(baseline.zero_in[0], 0.5, 1e-6);
    for (unsigned n = 0; n < BASELINE_BLOCKS; n++) {
        in[0] = in[1] = 3.0f;
        /* transducer 2 has moved: it keeps what it has */
        baseline_update(&baseline, in, true, 1u << 1);
    }
    assert_near(baseline.zero_in[0], 3.0, 1e-6);
    assert_near(baseline.zero_in[1], 2.0, 1e-6);
}

TEST(what_moved_is_held_until_a_switch_speaks)
{
    static struct mr_predictor predictor;
    struct landing landing = rolling();
    predictor.moved_mask = 5;
    assert_int_equal(predict_find_frozen_zeros(&predictor, &landing), 5);
    landing.edge_count = 1;
    assert_int_equal(predict_find_frozen_zeros(&predictor, &landing), 0);
}
