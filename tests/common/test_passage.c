/* Passage: edges with a station and a time become a landing's gates, a push-back, or nothing.
 * Expected speeds by hand. */
#include "common/passage.h"

#include <math.h>
#include <string.h>

#include "tests/cmocka_all.h"

#define SWITCHES 40

static float stations[SWITCHES];
static struct mr_passage passage;
static double now_s;

static int begin(void **state)
{
    (void)state;
    for (unsigned i = 0; i < SWITCHES; i++)
        stations[i] = -2.5f + 5.0f * (float)i;
    mr_passage_start(&passage);
    now_s = 10.0;
    return 0;
}

/* Switch `position` opens `after_s` later, while the last estimate says `speed_ft_s`. */
static struct mr_passage_changes open_at(unsigned position, double after_s, double speed_ft_s)
{
    now_s += after_s;
    struct mr_passage_edge edge = {.tick = (uint32_t)(uint64_t)llround(now_s * 84e6), /* wraps */
                                   .block = (uint32_t)(now_s * 1000.0),
                                   .station_ft = (double)stations[position - 1],
                                   .position = (uint8_t)position,
                                   .number = (uint8_t)position};
    return mr_passage_on_edge(&passage, &edge, speed_ft_s, stations, SWITCHES);
}

static struct mr_passage_changes open_after(unsigned position, double after_s)
{
    return open_at(position, after_s, (double)NAN);
}

static unsigned notes_of(unsigned position, enum mr_switch_reason reason)
{
    unsigned count = 0;
    for (unsigned i = 0; i < passage.event_count; i++)
        count += passage.event[i].position == position && passage.event[i].reason == reason;
    return count;
}

static uint32_t block_after(double s)
{
    return (uint32_t)((now_s + s) * 1000.0);
}

TEST_IN(two_edges_along_the_runway_are_a_landing, begin, NULL)
{
    struct mr_passage_changes news = open_after(1, 0.0);
    assert_false(news.has_started_landing || news.has_new_gate || news.has_new_pushback);
    assert_true(mr_passage_is_ambiguous(&passage, block_after(2.9)));
    /* 5 ft at 2 ft/s take 2.5 s: nothing is coming */
    assert_false(mr_passage_is_ambiguous(&passage, block_after(3.1)));
    news = open_after(2, 0.25); /* 20 ft/s */
    assert_true(news.has_started_landing && news.has_new_gate);
    assert_int_equal(passage.gate_count, 2);
    assert_near(passage.gate[1].t_s, 0.25, 1e-7);
    assert_near(passage.entry_speed_ft_s, 20.0, 1e-5);
    assert_int_equal(passage.event_count, 0);
    assert_false(mr_passage_is_ambiguous(&passage, block_after(0.1)));
    /* a landing is not given up by waiting */
    assert_false(mr_passage_on_block(&passage, block_after(31.0)));
    assert_int_equal(passage.state, MR_PASSAGE_ROLLING);
}

TEST_IN(switches_that_did_not_open_are_missing, begin, NULL)
{
    open_after(3, 0.0);
    open_after(6, 0.75);
    assert_int_equal(notes_of(1, MR_SWITCH_MISSING), 1);
    assert_int_equal(notes_of(2, MR_SWITCH_MISSING), 1);
    assert_int_equal(notes_of(4, MR_SWITCH_MISSING), 1);
    assert_int_equal(notes_of(5, MR_SWITCH_MISSING), 1);
    assert_int_equal(passage.event_count, 4);
    open_after(8, 0.5);
    assert_int_equal(notes_of(7, MR_SWITCH_MISSING), 1);
    assert_int_equal(passage.event_count, 1);
}

/* 1.9 and 81 ft/s are no gear; 2.1 and 79 are. */
TEST_IN(the_speeds_of_a_landing_are_bounded, begin, NULL)
{
    const struct {
        double speed_ft_s;
        bool lands;
    } cases[] = {{1.9, false}, {2.1, true}, {79.0, true}, {81.0, false}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        begin(NULL);
        open_after(1, 0.0);
        assert_int_equal(open_after(2, 5.0 / cases[i].speed_ft_s).has_started_landing,
                         cases[i].lands);
    }
    begin(NULL);
    open_after(1, 0.0);
    assert_false(open_after(2, 0.0).has_started_landing); /* in the same tick */
}

TEST_IN(an_edge_out_of_order_before_the_landing_does_not_hide_it, begin, NULL)
{
    open_after(2, 0.0);
    open_after(9, 0.05);                                  /* 700 ft/s: no gear */
    assert_true(open_after(3, 0.15).has_started_landing); /* 25 ft/s from the first */
    assert_int_equal(notes_of(9, MR_SWITCH_OUT_OF_ORDER), 1);
    assert_int_equal(passage.gate_edge[0].position, 2);
    assert_near(passage.entry_speed_ft_s, 25.0, 1e-4);
}

/* Four are held; the fifth pushes the oldest out. */
TEST_IN(a_handful_of_strays_is_remembered, begin, NULL)
{
    const unsigned strays[] = {2, 12, 22, 32};
    for (unsigned i = 0; i < 4; i++)
        assert_false(open_after(strays[i], 0.01).has_started_landing); /* 5000 ft/s */
    assert_int_equal(passage.event_count, 0);
    assert_false(open_after(40, 0.01).has_started_landing);
    assert_int_equal(notes_of(2, MR_SWITCH_OUT_OF_ORDER), 1);
    assert_true(mr_passage_on_block(&passage, block_after(30.001)));
    for (unsigned i = 1; i < 4; i++)
        assert_int_equal(notes_of(strays[i], MR_SWITCH_SINGLE), 1);
    assert_int_equal(passage.event_count, 4);
    assert_int_equal(passage.state, MR_PASSAGE_NONE);
    assert_int_equal(passage.pushback_count, 0);
}

TEST_IN(pushed_backward_is_one_pushback, begin, NULL)
{
    open_after(8, 0.0);
    struct mr_passage_changes news = open_after(7, 5.0); /* -1 ft/s */
    assert_true(news.has_new_pushback);
    assert_int_equal(notes_of(8, MR_SWITCH_REVERSE), 1);
    assert_near(passage.pushback_speed_ft_s, -1.0, 1e-6);
    assert_int_equal(passage.pushback_position, 7);
    assert_false(open_after(6, 5.0).has_new_pushback); /* the same one */
    assert_int_equal(passage.pushback_count, 1);
    assert_true(mr_passage_is_ambiguous(&passage, block_after(29.0)));
    assert_false(mr_passage_on_block(&passage, block_after(29.9)));
    assert_true(mr_passage_on_block(&passage, block_after(30.1)));
    assert_int_equal(notes_of(6, MR_SWITCH_REVERSE), 1);
    assert_false(mr_passage_is_ambiguous(&passage, block_after(30.2)));
    open_after(8, 40.0);
    assert_true(open_after(7, 5.0).has_new_pushback); /* another one */
    assert_int_equal(passage.pushback_count, 2);
}

TEST_IN(pushed_slowly_forward_is_one_too, begin, NULL)
{
    open_after(4, 0.0);
    assert_true(open_after(5, 5.0).has_new_pushback); /* 1 ft/s */
    assert_int_equal(notes_of(4, MR_SWITCH_SLOW), 1);
    assert_true(mr_passage_on_block(&passage, block_after(30.1)));
    assert_int_equal(notes_of(5, MR_SWITCH_SLOW), 1);
}

TEST_IN(the_count_of_pushbacks_stays_at_its_end, begin, NULL)
{
    passage.pushback_count = UINT16_MAX;
    open_after(8, 0.0);
    assert_true(open_after(7, 5.0).has_new_pushback);
    assert_int_equal(passage.pushback_count, UINT16_MAX);
}

/* Nobody pushes at 25 ft/s backward: a switch was late, and the landing may still come. */
TEST_IN(fast_backward_is_no_pushback, begin, NULL)
{
    open_after(2, 0.0);
    assert_false(open_after(1, 0.2).has_new_pushback);
    assert_int_equal(passage.pushback_count, 0);
    /* 33 ft/s since the second switch, 0.3 s for 5 ft from it */
    assert_true(open_after(3, 0.1).has_started_landing);
}

static void roll_in(void)
{
    open_after(1, 0.0);
    open_after(2, 0.2);
    open_after(3, 0.2); /* 25 ft/s */
    assert_int_equal(passage.gate_count, 3);
    assert_near(passage.entry_speed_ft_s, 25.0, 1e-4);
}

/* It came in at 25 ft/s: 25 * 1.25 + 3 = 34.25 ft/s is what a gear could have. */
TEST_IN(no_gear_gets_much_faster, begin, NULL)
{
    roll_in();
    assert_true(open_after(4, 5.0 / 34.0).has_new_gate);
    begin(NULL);
    roll_in();
    /* 40 ft/s, and 20 / 0.575 = 34.8 from the second on */
    assert_false(open_after(6, 15.0 / 40.0).has_new_gate);
    assert_int_equal(notes_of(6, MR_SWITCH_OUT_OF_ORDER), 1);
    assert_int_equal(passage.gate_count, 3);
}

/* With two gates nobody knows yet how fast it came in: what no gear does is refused all the same,
 * and neither gate is taken back. */
TEST_IN(the_third_edge_may_be_nonsense, begin, NULL)
{
    open_after(1, 0.0);
    open_after(2, 0.2);
    assert_false(open_after(9, 0.05).has_new_gate); /* 700 ft/s */
    assert_int_equal(notes_of(9, MR_SWITCH_OUT_OF_ORDER), 1);
    assert_int_equal(passage.gate_count, 2);
    assert_true(open_after(3, 0.15).has_new_gate);
}

TEST_IN(a_late_switch_is_taken_back, begin, NULL)
{
    roll_in();
    assert_true(open_after(4, 0.3).has_new_gate); /* 0.1 s late */
    assert_true(open_after(5, 0.1).has_new_gate); /* 50 ft/s from there, 25 ft/s from the third */
    assert_int_equal(notes_of(4, MR_SWITCH_LATE), 1);
    assert_int_equal(passage.gate_count, 4);
    assert_int_equal(passage.gate_edge[3].position, 5);
    assert_near(passage.gate[3].t_s, 0.8, 1e-6);
}

TEST_IN(passed_once_more_while_it_rolls_is_out_of_order, begin, NULL)
{
    roll_in();
    assert_false(open_at(1, 0.1, 24.0).has_new_gate);
    assert_int_equal(notes_of(1, MR_SWITCH_OUT_OF_ORDER), 1);
    assert_int_equal(passage.pushback_count, 0);
}

TEST_IN(pushed_after_the_stop_is_a_pushback_and_no_gate, begin, NULL)
{
    roll_in();
    struct mr_passage_changes news = open_at(2, 8.0, 0.0); /* at rest, then back */
    assert_true(news.has_new_pushback && !news.has_new_gate);
    assert_int_equal(notes_of(2, MR_SWITCH_REVERSE), 1);
    assert_int_equal(passage.state, MR_PASSAGE_ROLLING);
    news = open_at(4, 4.0, 0.0);         /* forward again: 5 ft since the last gate in 12 s */
    assert_false(news.has_new_pushback); /* the same one goes on */
    assert_int_equal(notes_of(4, MR_SWITCH_SLOW), 1);
    assert_int_equal(passage.gate_count, 3);
    assert_int_equal(passage.pushback_count, 1);
}

/* More switches than gates: those beyond are left out without a word that would be wrong. */
TEST_IN(there_are_32_gates, begin, NULL)
{
    for (unsigned position = 1; position <= MR_GATES_MAX; position++)
        assert_int_equal(open_after(position, 0.2).has_new_gate, position > 1);
    assert_int_equal(passage.gate_count, MR_GATES_MAX);
    assert_false(open_after(33, 0.2).has_new_gate);
    assert_int_equal(passage.gate_count, MR_GATES_MAX);
    assert_int_equal(passage.event_count, 0);
}

TEST_IN(the_next_landing_begins_without_the_last, begin, NULL)
{
    open_after(8, 0.0);
    open_after(7, 5.0);
    mr_passage_clear(&passage);
    assert_int_equal(passage.pushback_count, 1);
    assert_false(open_after(1, 0.1).has_started_landing);
    assert_true(open_after(2, 0.2).has_started_landing);
    assert_int_equal(passage.event_count, 0);
    assert_int_equal(passage.gate_count, 2);
}
