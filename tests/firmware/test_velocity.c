/* The velocity rig: what the landing makes of damaged switches, of a counter that wraps, and of the model pushed back. */
#include "tests/firmware/play.h"

#include <stdio.h>

#include "tests/common/seeded_landing.h"

static struct landing landing;
static double open_codes;
static uint64_t seed_state;
static unsigned pushed_told, landing_states;

static void next_block(uint32_t index, const uint32_t *ticks, unsigned count)
{
    struct landing_news news = landing_block(&landing, index, 4000000000u + 84000u * index,
                                             (float)(62.0 + open_codes + 0.5 * seeded_normal(&seed_state)), ticks, count);
    pushed_told += (unsigned)news.pushed;
    landing_states += (unsigned)(landing.state == LANDING_LANDING || landing.state == LANDING_SETTLING);
    assert_true(!(landing.passage.state == MR_PASSAGE_PUSHED && landing_may_warn(&landing, index)));
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

/* Backward at 0.3 to 8 ft/s or forward at 0.3 to 1.9 ft/s over some of the switches, stopping now and then. */
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

static void a_hundred_pushbacks_are_no_landing(void **state)
{
    (void)state;
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
    assert_int_equal(landing.passage.pushbacks, 100);
    assert_int_equal(landing_states, 0);
    assert_int_equal(landing.state, LANDING_ARMED);
    assert_int_equal(landing.number, 7);
    assert_false(landing.summary_known);
    /* and the landing that was waited for is one: 28 ft/s */
    for (unsigned position = 1; position < 4; position++) {
        open_switch(&index, position);
        wait(&index, 5.0 / 28.0);
    }
    assert_int_equal(landing.state, LANDING_LANDING);
    assert_near(landing.motion.speed_ft_s.value, 28.0, 0.2);
    assert_int_equal(landing_arm(&landing, 8, index), MR_NOT_NOW); /* not in the middle of it */
    assert_int_equal(landing.number, 7);
}

static void a_pushback_leaves_the_landing_before_as_it_was(void **state)
{
    (void)state;
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
    assert_int_equal(landing.state, LANDING_DONE);
    struct mr_gates_summary summary = landing.summary;
    assert_true(landing.summary_known);
    open_codes = 0.0;
    wait(&index, 0.1);
    unsigned states = landing_states;
    for (unsigned n = 0; n < 5; n++)
        push(&index);
    assert_int_equal(landing.passage.pushbacks, 5);
    assert_int_equal(landing.state, LANDING_DONE);
    assert_int_equal(landing_states, states);
    assert_memory_equal(&summary, &landing.summary, sizeof summary);
}

/* 200 edges without a step, as a loose plug makes them: 96 are told, then no more until there was a pause of 30 s. */
static void interference_does_not_fill_the_links(void **state)
{
    (void)state;
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
            told += landing.news.edges;
            for (unsigned k = 0; k < 19; k++) {
                next_block(index++, NULL, 0);
                told += landing.news.edges;
            }
        }
        assert_int_equal(told, LANDING_EDGES);
        wait(&index, 30.1);
    }
    assert_int_equal(landing.edges, 2 * LANDING_EDGES);
    assert_int_equal(landing.state, LANDING_ARMED);
    for (unsigned position = 1; position < 4; position++) { /* 20 ft/s: what comes then is a landing */
        open_switch(&index, position);
        wait(&index, 0.25);
    }
    assert_int_equal(landing.state, LANDING_LANDING);
    for (unsigned n = 0; n < 100; n++) /* and 255 edges are "255 or more" */
        open_switch(&index, 24), open_codes -= step_of(24), wait(&index, 0.02);
    assert_int_equal(landing.edges, UINT8_MAX);
}

/* 40 edges in one block, more than wait: 32 are answered, the rest are not taken, and nothing was a landing. */
static void a_burst_beyond_what_waits_is_cut(void **state)
{
    (void)state;
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
        told += landing.news.edges;
    }
    assert_int_equal(told, MR_SWITCHES_WAITING);
    assert_int_equal(landing.state, LANDING_ARMED);
    assert_int_equal(landing.passage.state, MR_PASSAGE_NONE);
}

/* Armed, the model is pushed to and fro over the same switches, which stay open: that opened twice is no news then. */
static void pushing_to_and_fro_is_followed(void **state)
{
    (void)state;
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
            wait(&index, 5.0); /* 1 ft/s backward */
            open_codes -= step_of(position); /* closed behind it by hand */
            wait(&index, 0.1);
        }
        wait(&index, 5.0); /* forward again, 15 ft in 10 s */
    }
    assert_int_equal(pushed_told, 1);
    assert_int_equal(landing.passage.pushbacks, 1);
    assert_int_equal(landing.passage.pushed_position, 5); /* of the last time round: each was seen again */
    assert_int_equal(landing_states, 0);
}

/* A switch that closes by itself makes a step down: told as 0 codes, for the message has no negative ones, and named by none. */
static void a_closing_switch_has_no_name(void **state)
{
    (void)state;
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
    while (!landing.news.edges)
        next_block(index++, NULL, 0);
    assert_int_equal(landing.edge[0].position, 0);
    assert_near(landing.edge[0].step_codes, 0.0, 0.0);
    assert_int_equal(landing.event[0].reason, MR_SWITCH_OTHER_STEP);
}

/* ---- damaged switches, as messages ---- */

/* As fly(), with one switch that is missing, late, or one after another in the wrong place of the cable. */
static void fly_damaged(unsigned missing, unsigned late, double late_s, unsigned swapped)
{
    unsigned next = 1;
    const double t0 = touchdown_s, v = 30.0, a = 6.0;
    double pending_s = (double)NAN;
    play(100);
    command("arm 7");
    while ((double)index_now * 1e-3 < 9.0) {
        double station_ft = -2.5 + 5.0 * (next - 1), d = station_ft - 3.0, b = d - v * 0.025;
        double left = v * v - 2.0 * a * b;
        double t_s = left < 0.0 ? 1e9 : t0 + (d < 0.0 ? d / v : 0.025 + (v - sqrt(left)) / a);
        double now_s = (double)index_now * 1e-3;
        if (pending_s < now_s) {
            pass_switch(late, pending_s);
            pending_s = (double)NAN;
        }
        if (next <= 24 && t_s < now_s) {
            unsigned named = swapped && next == swapped ? swapped + 1 : swapped && next == swapped + 1 ? swapped : next;
            if (next == late)
                pending_s = t_s + late_s;
            else if (next != missing)
                pass_switch(named, t_s);
            next++;
        }
        play_block();
    }
}

static unsigned count_events(unsigned reason, unsigned position, float *late_ms)
{
    unsigned count = 0;
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_switch_event event;
        if (fake.sent[i].id != MR_ID_SWITCH_EVENT)
            continue;
        assert_int_equal(mr_switch_event_get(&event, fake.sent[i].data, fake.sent[i].length), MR_OK);
        if (event.reason != reason || event.position != position)
            continue;
        count++;
        if (late_ms)
            *late_ms = event.late_ms;
    }
    return count;
}

static void check_speed(void)
{
    struct mr_touchdown touchdown;
    GET_LAST(touchdown, TOUCHDOWN, &touchdown);
    assert_near(touchdown.speed_ft_s, 30.0, 0.03); /* a tenth of the 1 % asked for */
}

static void a_missing_switch_is_named(void **state)
{
    (void)state;
    fly_damaged(6, 0, 0.0, 0);
    assert_int_equal(count_events(MR_SWITCH_MISSING, 6, NULL), 1);
    assert_int_equal(count_frames(MR_ID_SWITCH_EVENT), 1);
    check_speed();
}

static void a_late_switch_is_named_with_its_lateness(void **state)
{
    (void)state;
    float late_ms = 0.0f;
    fly_damaged(0, 9, 0.004, 0);
    assert_int_equal(count_events(MR_SWITCH_LATE, 9, &late_ms), 1);
    assert_near(late_ms, 4.0, 0.3);
    check_speed();
}

static void a_switch_later_than_the_next_is_out_of_order(void **state)
{
    (void)state;
    fly_damaged(0, 5, 0.300, 0); /* 5 ft take 0.17 to 0.18 s there */
    assert_int_equal(count_events(MR_SWITCH_MISSING, 5, NULL), 1);
    assert_int_equal(count_events(MR_SWITCH_OUT_OF_ORDER, 5, NULL), 1);
    check_speed();
}

static void swapped_cables_are_survived(void **state)
{
    (void)state;
    fly_damaged(0, 0, 0.0, 7);
    assert_int_equal(count_events(MR_SWITCH_OUT_OF_ORDER, 7, NULL) + count_events(MR_SWITCH_OUT_OF_ORDER, 8, NULL) +
                     count_events(MR_SWITCH_LATE, 8, NULL) + count_events(MR_SWITCH_EARLY, 8, NULL), 2);
    check_speed();
}

int main(void)
{
#define TEST(name) cmocka_unit_test_setup(name, start)
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_hundred_pushbacks_are_no_landing),
        cmocka_unit_test(a_pushback_leaves_the_landing_before_as_it_was),
        TEST(a_missing_switch_is_named),
        TEST(a_late_switch_is_named_with_its_lateness),
        TEST(a_switch_later_than_the_next_is_out_of_order),
        TEST(swapped_cables_are_survived),
        cmocka_unit_test(interference_does_not_fill_the_links),
        cmocka_unit_test(pushing_to_and_fro_is_followed),
        cmocka_unit_test(a_closing_switch_has_no_name),
        cmocka_unit_test(a_burst_beyond_what_waits_is_cut),
    };
    return cmocka_run_group_tests_name("firmware/velocity", tests, NULL, NULL);
}
