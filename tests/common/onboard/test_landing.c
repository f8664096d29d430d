/* The landing from blocks and edges alone: the model pushed back, edges of interference, a counter
 * that wraps; and two of them at a time, each with a configuration of its own. */
#include "common/onboard/landing.h"

#include <math.h>

#include "tests/cmocka_all.h"
#include "tests/common/seeded_landing.h"

/* Steps 64 + 8 i, i = 7 (p - 1) mod 24; every 5 ft from -2.5 ft on. */
static unsigned step_of(unsigned position)
{
    return 64 + 8 * (7 * (position - 1) % 24);
}

static struct mr_config rig_of(float first_ft, float apart_ft)
{
    struct mr_config config = {.site = {{.touchdown_ft = 3.0f, .switch_error_ft = 0.001f}}};
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++)
        config.gate[i] = (struct mr_gate_config){.station_ft = first_ft + apart_ft * (float)i,
                                                 .step_codes = (uint16_t)step_of(i + 1)};
    return config;
}

static struct mr_config rig;
static struct landing landing;
static double open_codes;
static uint64_t seed_state;
static unsigned pushed_told, landing_states;

static void next_block(uint32_t index, const uint32_t *ticks, unsigned count)
{
    struct landing_block_changes news = landing_on_block(
        &landing, &rig, index, 4000000000u + 84000u * index,
        (float)(62.0 + open_codes + 0.5 * seeded_normal(&seed_state)), ticks, count);
    pushed_told += (unsigned)news.has_new_pushback;
    landing_states += (unsigned)(landing.state == MR_LANDING_LANDING ||
                                 landing.state == MR_LANDING_SETTLING);
    assert_true(!(landing.passage.state == MR_PASSAGE_PUSHED && landing_can_warn(&landing, index)));
}

/* One edge in the middle of a block. */
static void open_switch(uint32_t *index, unsigned position)
{
    uint32_t tick = 4000000000u + 84000u * *index + 42000u;
    next_block((*index)++, &tick, 1);
    open_codes += step_of(position);
}

static void wait(uint32_t *index, double s)
{
    for (unsigned n = (unsigned)(1000.0 * s); n > 0; n--)
        next_block((*index)++, NULL, 0);
}

/* Backward at 0.3 to 8 ft/s or forward at 0.3 to 1.9 ft/s over some of the switches, stopping now
 * and then. */
static void push(uint32_t *index)
{
    bool forward = seeded_uniform(&seed_state) < 0.3;
    unsigned first = 2 + (unsigned)(12.0 * seeded_uniform(&seed_state));
    unsigned count = 2 + (unsigned)(6.0 * seeded_uniform(&seed_state));
    double speed_ft_s = 0.3 + (forward ? 1.6 : 7.7) * seeded_uniform(&seed_state);
    for (unsigned i = 0; i < count; i++) {
        open_switch(index, forward ? first + i : first + count - 1 - i);
        wait(index, 5.0 / speed_ft_s + (seeded_uniform(&seed_state) < 0.2 ? 3.0 : 0.0));
    }
    wait(index, 31.0);
    open_codes = 0.0; /* somebody closes the switches again */
    wait(index, 0.1);
}

static int rig_before(void **state)
{
    (void)state;
    rig = rig_of(-2.5f, 5.0f);
    return 0;
}

TEST_IN(a_hundred_pushbacks_are_no_landing, rig_before, NULL)
{
    uint32_t index = 0;
    seed_state = 1973;
    open_codes = 0.0;
    pushed_told = landing_states = 0;
    landing_start(&landing);
    wait(&index, 0.1);
    for (unsigned n = 0; n < 100; n++) {
        if (n == 20)
            assert_int_equal(landing_arm(&landing, 7, index), MR_OK); /* before: idle */
        push(&index);
        assert_int_equal(pushed_told, n + 1);
    }
    assert_int_equal(landing.passage.pushback_count, 100);
    assert_int_equal(landing_states, 0);
    assert_int_equal(landing.state, MR_LANDING_ARMED);
    assert_int_equal(landing.number, 7);
    assert_false(landing.is_summary_known);
    /* and the landing that was waited for is one: 28 ft/s */
    for (unsigned position = 1; position < 4; position++) {
        open_switch(&index, position);
        wait(&index, 5.0 / 28.0);
    }
    assert_int_equal(landing.state, MR_LANDING_LANDING);
    assert_near(landing.motion.speed_ft_s.value, 28.0, 0.2);
    assert_int_equal(landing_arm(&landing, 8, index), MR_NOT_NOW); /* not in the middle of it */
    assert_int_equal(landing.number, 7);
}

TEST_IN(a_pushback_leaves_the_landing_before_as_it_was, rig_before, NULL)
{
    uint32_t index = 0;
    seed_state = 2;
    open_codes = 0.0;
    pushed_told = landing_states = 0;
    landing_start(&landing);
    wait(&index, 0.1);
    assert_int_equal(landing_arm(&landing, 3, index), MR_OK);
    for (unsigned position = 1; position < 8; position++) {
        open_switch(&index, position);
        wait(&index, position < 3 ? 0.178 : 0.178 + 0.02 * position);
    }
    wait(&index, 6.0);
    assert_int_equal(landing.state, MR_LANDING_DONE);
    struct mr_gates_summary summary = landing.summary;
    assert_true(landing.is_summary_known);
    open_codes = 0.0;
    wait(&index, 0.1);
    unsigned states = landing_states;
    for (unsigned n = 0; n < 5; n++)
        push(&index);
    assert_int_equal(landing.passage.pushback_count, 5);
    assert_int_equal(landing.state, MR_LANDING_DONE);
    assert_int_equal(landing_states, states);
    assert_memory_equal(&summary, &landing.summary, sizeof summary);
}

/* 200 edges without a step, as a loose plug makes them: 96 are told, then no more until there was a
 * pause of 30 s. */
TEST_IN(interference_does_not_fill_the_links, rig_before, NULL)
{
    uint32_t index = 0;
    unsigned told = 0;
    seed_state = 3;
    open_codes = 0.0;
    landing_start(&landing);
    wait(&index, 0.1);
    assert_int_equal(landing_arm(&landing, 1, index), MR_OK);
    for (unsigned round = 0; round < 2; round++) {
        told = 0;
        for (unsigned n = 0; n < 200; n++) {
            uint32_t tick = 4000000000u + 84000u * index + 42000u;
            next_block(index++, &tick, 1);
            told += landing.changes.edge_count;
            for (unsigned k = 0; k < 19; k++) {
                next_block(index++, NULL, 0);
                told += landing.changes.edge_count;
            }
        }
        assert_int_equal(told, LANDING_EDGES_MAX);
        wait(&index, 30.1);
    }
    assert_int_equal(landing.edge_count, 2 * LANDING_EDGES_MAX);
    assert_int_equal(landing.state, MR_LANDING_ARMED);
    for (unsigned position = 1; position < 4; position++) {
        /* 20 ft/s: what comes then is a landing */
        open_switch(&index, position);
        wait(&index, 0.25);
    }
    assert_int_equal(landing.state, MR_LANDING_LANDING);
    for (unsigned n = 0; n < 100; n++) /* and 255 edges are "255 or more" */
        open_switch(&index, 24), open_codes -= step_of(24), wait(&index, 0.02);
    assert_int_equal(landing.edge_count, UINT8_MAX);
}

/* 40 edges in one block, more than wait: 32 are answered, the rest are not taken, and nothing was a
 * landing. */
TEST_IN(a_burst_beyond_what_waits_is_cut, rig_before, NULL)
{
    uint32_t index = 0, ticks[40];
    unsigned told = 0;
    seed_state = 6;
    open_codes = 0.0;
    landing_start(&landing);
    wait(&index, 0.1);
    assert_int_equal(landing_arm(&landing, 1, index), MR_OK);
    for (unsigned i = 0; i < 40; i++)
        ticks[i] = 4000000000u + 84000u * index + 2000u * i;
    next_block(index++, ticks, 40);
    for (unsigned n = 0; n < 60; n++) {
        next_block(index++, NULL, 0);
        told += landing.changes.edge_count;
    }
    assert_int_equal(told, MR_SWITCHES_WAITING_MAX);
    assert_int_equal(landing.state, MR_LANDING_ARMED);
    assert_int_equal(landing.passage.state, MR_PASSAGE_NONE);
}

/* Armed, the model is pushed to and fro over the same switches, which stay open: that opened twice
 * is no news then. */
TEST_IN(pushing_to_and_fro_is_followed, rig_before, NULL)
{
    uint32_t index = 0;
    seed_state = 4;
    open_codes = 0.0;
    pushed_told = landing_states = 0;
    landing_start(&landing);
    wait(&index, 0.1);
    assert_int_equal(landing_arm(&landing, 1, index), MR_OK);
    for (unsigned n = 0; n < 3; n++) {
        for (unsigned position = 8; position > 4; position--) {
            open_switch(&index, position);
            wait(&index, 5.0);               /* 1 ft/s backward */
            open_codes -= step_of(position); /* closed behind it by hand */
            wait(&index, 0.1);
        }
        wait(&index, 5.0); /* forward again, 15 ft in 10 s */
    }
    assert_int_equal(pushed_told, 1);
    assert_int_equal(landing.passage.pushback_count, 1);
    /* of the last time round: each was seen again */
    assert_int_equal(landing.passage.pushback_position, 5);
    assert_int_equal(landing_states, 0);
}

/* A switch that closes by itself makes a step down: told as 0 codes, for the message has no
 * negative ones, and named by none. */
TEST_IN(a_closing_switch_has_no_name, rig_before, NULL)
{
    uint32_t index = 0;
    seed_state = 5;
    open_codes = 0.0;
    landing_start(&landing);
    wait(&index, 0.1);
    assert_int_equal(landing_arm(&landing, 1, index), MR_OK);
    open_switch(&index, 3);
    wait(&index, 1.0);
    uint32_t tick = 4000000000u + 84000u * index + 42000u;
    next_block(index++, &tick, 1);
    open_codes -= step_of(3);
    while (!landing.changes.edge_count)
        next_block(index++, NULL, 0);
    assert_int_equal(landing.edge[0].position, 0);
    assert_near(landing.edge[0].step_codes, 0.0, 0.0);
    assert_int_equal(landing.event[0].reason, MR_SWITCH_UNKNOWN_STEP);
}

/* The same edges, a block at a time in turn, to two rigs: switches 5 ft apart, and 10 ft apart with
 * their wheel 2 ft ahead. The second landing is twice as fast, and its wheel where its own switches
 * are. */
TEST_IN(two_rigs_do_not_know_of_each_other, rig_before, NULL)
{
    static struct landing near_one, far_one;
    struct mr_config far = rig_of(-5.0f, 10.0f);
    far.site[0].wheel_ahead_ft = 2.0f;
    far.site[0].touchdown_ft = 12.0f;
    unsigned next = 1;
    double codes = 62.0;
    landing_start(&near_one);
    landing_start(&far_one);
    assert_int_equal(landing_arm(&near_one, 1, 0), MR_OK);
    assert_int_equal(landing_arm(&far_one, 2, 0), MR_OK);
    for (uint32_t index = 0; index < 1000; index++) {
        uint32_t tick = 84000u * index, edge = tick + 42000u;
        bool opens = index % 180 == 100 && next <= 5; /* 5 ft in 180 ms */
        landing_on_block(&near_one, &rig, index, tick, (float)codes, &edge, opens);
        landing_on_block(&far_one, &far, index, tick, (float)codes, &edge, opens);
        codes += opens ? step_of(next++) : 0.0;
    }
    assert_int_equal(near_one.state, MR_LANDING_LANDING);
    assert_int_equal(far_one.state, MR_LANDING_LANDING);
    assert_near(near_one.motion.speed_ft_s.value, 5.0 / 0.18, 0.1);
    assert_near(far_one.motion.speed_ft_s.value, 10.0 / 0.18, 0.2);
    assert_near(near_one.passage.gate[4].station_ft, -2.5 + 4 * 5.0, 1e-6);
    assert_near(far_one.passage.gate[4].station_ft, -5.0 + 4 * 10.0 - 2.0, 1e-6);
    assert_int_equal(near_one.gates_before_braking, 2); /* -2.5 and 2.5 of 3 ft */
    assert_int_equal(far_one.gates_before_braking, 2);  /* -7 and 3 of 12 ft */
}

/* Of a switch that is not fitted nobody says that it is missing; of one that is, somebody does. */
TEST_IN(a_switch_that_is_not_fitted_is_not_missing, rig_before, NULL)
{
    for (unsigned fitted = 0; fitted < 2; fitted++) {
        uint32_t index = 0;
        unsigned missing = 0;
        struct mr_config kept = rig;
        rig.gate[3].step_codes = (uint16_t)(fitted ? rig.gate[3].step_codes : 0);
        seed_state = 7;
        open_codes = 0.0;
        landing_start(&landing);
        wait(&index, 0.1);
        assert_int_equal(landing_arm(&landing, 1, index), MR_OK);
        for (unsigned position = 1; position < 8; position++) {
            if (position != 4)
                open_switch(&index, position);
            for (unsigned n = 0; n < 180; n++) {
                next_block(index++, NULL, 0);
                for (unsigned i = 0; i < landing.changes.event_count; i++)
                    missing += landing.event[i].reason == MR_SWITCH_MISSING &&
                               landing.event[i].position == 4;
            }
        }
        rig = kept;
        assert_int_equal(missing, fitted);
        assert_near(landing.motion.speed_ft_s.value, 5.0 / 0.18, 0.2);
    }
}

/* 30 ft/s up to 11 ft, where the brake is applied; then 9 ft/s2. When a switch at `station_ft`
 * opens, in seconds. */
static double braked_s(double station_ft)
{
    double beyond_ft = station_ft - 11.0;
    return 1.0 +
           (beyond_ft <= 0.0 ? beyond_ft / 30.0 : (30.0 - sqrt(900.0 - 18.0 * beyond_ft)) / 9.0);
}

/* With its edge, a brake applied late does not bend the motion: gates before it are left out. */
TEST_IN(a_late_brake_is_known_by_its_edge, rig_before, NULL)
{
    for (unsigned told = 0; told < 2; told++) {
        unsigned position = 1;
        seed_state = 7;
        open_codes = 0.0;
        landing_start(&landing);
        assert_int_equal(landing_arm(&landing, 1, 0), MR_OK);
        landing_set_brake(&landing, 4000000000u); /* tried out while armed: not of the landing */
        for (uint32_t index = 0; position < 8; index++) {
            double open_s = braked_s(-2.5 + 5.0 * (position - 1));
            uint32_t tick = 4000000000u + (uint32_t)llround(open_s * 84e6);
            bool opens = open_s < 1e-3 * (index + 1);
            next_block(index, &tick, opens);
            if (opens)
                open_codes += step_of(position++);
            if (told && index == 1000)
                landing_set_brake(&landing, 4000000000u + 84000000u);
        }
        for (unsigned i = 0; i < 50; i++) /* the last switch is identified */
            next_block((uint32_t)(1000.0 * braked_s(27.5)) + 1 + i, NULL, 0);
        assert_int_equal(landing.passage.gate_count, 7);
        assert_int_equal(landing.gates_before_braking, told ? 3 : 2); /* 7.5 ft too */
        if (told)
            assert_near(landing.motion.deceleration_ft_s2.value, 9.0, 0.2);
        else
            assert_true(fabs(landing.motion.deceleration_ft_s2.value - 9.0) > 0.5);
    }
}

/* 30 ft/s, 9 ft/s2 from touchdown at 3 ft: the errors hold from the first gate under braking on. */
TEST_IN(the_errors_hold_when_braking_begins, rig_before, NULL)
{
    unsigned position = 1, checked = 0;
    seed_state = 7;
    open_codes = 0.0;
    landing_start(&landing);
    assert_int_equal(landing_arm(&landing, 1, 0), MR_OK);
    for (uint32_t index = 0; checked < 7; index++) {
        double beyond_ft = -2.5 + 5.0 * (position - 1) - 3.0,
               open_s = 1.0 + (beyond_ft <= 0.0 ? beyond_ft / 30.0
                                                : (30.0 - sqrt(900.0 - 18.0 * beyond_ft)) / 9.0);
        uint32_t tick = 4000000000u + (uint32_t)llround(open_s * 84e6);
        bool opens = open_s < 1e-3 * (index + 1);
        next_block(index, &tick, opens);
        if (opens)
            open_codes += step_of(position++);
        if (landing.passage.gate_count <= checked || ++checked < 3)
            continue; /* no gate under braking yet */
        const struct mr_motion_estimate *motion = &landing.motion;
        double speed_ft_s = sqrt(900.0 - 18.0 * (5.0 * (checked - 1) - 5.5));
        assert_near(motion->speed_ft_s.value, speed_ft_s, 1.96 * motion->speed_ft_s.error);
        assert_true(checked == 4 || fabs(motion->deceleration_ft_s2.value - 9.0) <=
                                        1.96 * motion->deceleration_ft_s2.error);
        assert_true(checked < 5 || motion->speed_ft_s.error < 0.1);
    }
}
