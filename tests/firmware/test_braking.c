/* Brake edge and wheel pulses above a fake board: edges and pulses since arming are reported, and
 * an input that is not fitted is not captured. */
#include "tests/firmware/play.h"

static int with_both(void **state)
{
    config.site[0].brake_edge = 1;
    config.site[0].wheel_pulses = 8;
    return start(state);
}

static int with_none(void **state)
{
    config.site[0].brake_edge = config.site[0].wheel_pulses = 0;
    return start(state);
}

static void pulse_at(enum board_pulse_input input, double t_s)
{
    fake.pulses[input].tick[fake.pulses[input].count++] = (uint32_t)llround(t_s * 84e6);
}

TEST_IN(edge_and_pulses_since_arming_are_reported, with_both, NULL)
{
    play(20);
    pulse_at(BOARD_BRAKE_PULSES, 0.025);
    pulse_at(BOARD_WHEEL_PULSES, 0.025);
    play(40);
    assert_int_equal(count_frames(MR_ID_BRAKING_EDGE), 0);
    command("arm 5");
    play(1);
    for (unsigned i = 0; i < 40; i++)
        pulse_at(BOARD_WHEEL_PULSES, 0.1 + 0.003 * i);
    pulse_at(BOARD_WHEEL_PULSES, 0.1 + 0.003 * 39 + 0.0005); /* noise */
    pulse_at(BOARD_BRAKE_PULSES, 0.15);
    pulse_at(BOARD_BRAKE_PULSES, 0.17); /* once more */
    play(300);
    assert_int_equal(count_frames(MR_ID_BRAKING_EDGE), 42);
    unsigned number = 0, brakes = 0;
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_braking_edge edge;
        if (fake.sent[i].id != MR_ID_BRAKING_EDGE)
            continue;
        assert_int_equal(mr_braking_edge_get(&edge, fake.sent[i].data, fake.sent[i].length), MR_OK);
        if (edge.number == 0) {
            assert_int_equal(edge.tick, (150000 + 20000 * brakes++) * 84);
            continue;
        }
        assert_int_equal(edge.number, ++number);
        assert_int_equal(edge.tick, (100000 + 3000 * (number - 1)) * 84);
    }
    assert_int_equal(number, 40);
}

TEST_IN(the_next_landing_counts_anew, with_both, NULL)
{
    struct mr_braking_edge edge;
    command("arm 5");
    play(20);
    pulse_at(BOARD_BRAKE_PULSES, 0.03);
    pulse_at(BOARD_WHEEL_PULSES, 0.04);
    play(40);
    command("disarm");
    play(5);
    command("arm 6");
    play(5);
    pulse_at(BOARD_WHEEL_PULSES, 0.09);
    play(40);
    GET_LAST(braking_edge, BRAKING_EDGE, &edge);
    assert_int_equal(edge.number, 1);
    pulse_at(BOARD_BRAKE_PULSES, 0.13);
    play(40);
    GET_LAST(braking_edge, BRAKING_EDGE, &edge);
    assert_int_equal(edge.number, 0);
    assert_int_equal(edge.tick, 130000 * 84);
}

TEST_IN(what_is_not_fitted_is_not_captured, with_none, NULL)
{
    command("arm 5");
    pulse_at(BOARD_BRAKE_PULSES, 0.03);
    pulse_at(BOARD_WHEEL_PULSES, 0.03);
    play(100);
    assert_false(fake.pulses[BOARD_BRAKE_PULSES].captured ||
                 fake.pulses[BOARD_WHEEL_PULSES].captured);
    assert_int_equal(count_frames(MR_ID_BRAKING_EDGE), 0);
}
