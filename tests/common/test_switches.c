/* Switches: edges of one circuit as the staircase names them, over whole blocks of 1 ms. */
#include "common/switches.h"

#include <math.h>
#include <string.h>

#include "tests/cmocka_all.h"

#define BLOCK_TICKS 84000u /* 1 ms of 84 MHz */
#define MS(ms)      ((uint32_t)(84000.0 * (ms)))

static const uint16_t steps[] = {64, 120, 176, 232};
static struct mr_switches switches;
static struct mr_switch_edge answered[64];
static unsigned answers;
static uint32_t block;
static double level_codes;

static int begin(void **state)
{
    (void)state;
    mr_switches_start(&switches);
    answers = 0;
    block = 0;
    level_codes = 62.0;
    return 0;
}

/* One block with a mean level, and `edges` within it. */
static void block_of(double codes, const double *edges_ms, unsigned edges)
{
    mr_switches_add_level(&switches, block * BLOCK_TICKS, (float)codes);
    for (unsigned i = 0; i < edges; i++)
        assert_true(mr_switches_add_edge(&switches, block * BLOCK_TICKS + MS(edges_ms[i])));
    while (mr_switches_next_edge(&switches, steps, 4, &answered[answers]))
        answers++;
    block++;
}

static void rest(unsigned blocks)
{
    for (unsigned n = 0; n < blocks; n++)
        block_of(level_codes, NULL, 0);
}

/* An edge in the middle of a block; the level is `step_codes` higher from there on. */
static void edge(double step_codes)
{
    block_of(level_codes + 0.5 * step_codes, (const double[]){0.5}, 1);
    level_codes += step_codes;
}

static void check(unsigned i, unsigned position, enum mr_switch_reason reason)
{
    assert_true(i < answers);
    assert_int_equal(answered[i].reason, reason);
    assert_int_equal(answered[i].position, position);
}

TEST_IN(every_reason_has_its_own_text, begin, NULL)
{
    for (unsigned a = 0; a <= MR_SWITCH_SINGLE; a++) {
        assert_string_not_equal(mr_switch_reason_text(a), "unknown");
        for (unsigned b = 0; b < a; b++)
            assert_string_not_equal(mr_switch_reason_text(a), mr_switch_reason_text(b));
    }
    assert_string_equal(mr_switch_reason_text(MR_SWITCH_SINGLE + 1), "unknown");
}

TEST_IN(a_single_edge_is_named_by_its_step, begin, NULL)
{
    rest(8);
    edge(176);
    assert_int_equal(answers, 0); /* 5 ms after it, not before */
    rest(3);
    assert_int_equal(answers, 0);
    rest(3);
    check(0, 3, MR_SWITCH_GOOD);
    assert_near(answered[0].step_codes, 176.0, 0.01);
    assert_int_equal(answered[0].tick, 8 * BLOCK_TICKS + MS(0.5));
    assert_int_equal(answers, 1);
}

TEST_IN(an_edge_without_a_step_is_none_of_the_table, begin, NULL)
{
    rest(8);
    edge(0);
    rest(30);
    edge(90); /* between 64 and 120: more than 4 codes from both */
    rest(30);
    edge(-176); /* a switch closes: no step of the table either */
    rest(30);
    check(0, 0, MR_SWITCH_NO_STEP);
    check(1, 0, MR_SWITCH_UNKNOWN_STEP);
    check(2, 0, MR_SWITCH_UNKNOWN_STEP);
    assert_int_equal(answers, 3);
}

TEST_IN(opening_again_is_a_bounce_for_50_ms_and_then_double, begin, NULL)
{
    rest(8);
    edge(120);
    rest(30);
    level_codes -= 120; /* it closed without an edge: only openings are captured */
    rest(9);
    edge(120); /* 40 ms after the first */
    rest(30);
    level_codes -= 120;
    rest(30);
    edge(120); /* 61 ms after the second, but 101 after the first, which named it */
    rest(30);
    check(0, 2, MR_SWITCH_GOOD);
    check(1, 2, MR_SWITCH_BOUNCE);
    check(2, 2, MR_SWITCH_DOUBLE);
    edge(176); /* another one in between: then the same again was no bounce, however soon */
    rest(12);
    level_codes -= 120;
    rest(6);
    edge(120);
    rest(30);
    check(3, 3, MR_SWITCH_GOOD);
    check(4, 2, MR_SWITCH_DOUBLE);
    mr_switches_reset(&switches); /* somebody closed them all */
    level_codes = 62.0;
    rest(30);
    edge(120);
    rest(30);
    check(5, 2, MR_SWITCH_GOOD);
    assert_int_equal(answers, 6);
}

TEST_IN(a_bouncing_contact_is_one_opening, begin, NULL)
{
    rest(8);
    block_of(level_codes + 100, (const double[]){0.1, 0.5, 0.8}, 3);
    level_codes += 176;
    block_of(level_codes - 40, (const double[]){0.3}, 1);
    rest(9);
    assert_int_equal(answers, 0); /* 10 ms after the last of them */
    rest(4);
    check(0, 3, MR_SWITCH_GOOD);
    for (unsigned i = 1; i < 4; i++)
        check(i, 3, MR_SWITCH_BOUNCE);
    assert_int_equal(answers, 4);
}

/* Interference: edges near each other that leave the level where it was. */
TEST_IN(a_burst_without_a_step_is_no_switch, begin, NULL)
{
    rest(8);
    block_of(level_codes + 20, (const double[]){0.2, 0.6}, 2);
    rest(30);
    check(0, 0, MR_SWITCH_NO_STEP);
    check(1, 0, MR_SWITCH_BOUNCE);
    assert_int_equal(answers, 2);
}

/* An edge without a step 7 ms after one that had its answer is that contact's bounce; 20 ms after
 * it, nobody's. */
TEST_IN(an_edge_without_a_step_soon_after_is_a_bounce, begin, NULL)
{
    for (unsigned n = 0; n < 2; n++) {
        begin(NULL);
        rest(8);
        edge(176);
        rest(n ? 19 : 6);
        assert_int_equal(answers, 1);
        edge(0);
        rest(30);
        check(0, 3, MR_SWITCH_GOOD);
        check(1, 0, n ? MR_SWITCH_NO_STEP : MR_SWITCH_BOUNCE);
    }
}

/* 6 ms apart: each is steady by itself, and together they are no switch of the table. */
TEST_IN(two_switches_near_each_other_are_told_apart_by_their_own_steps, begin, NULL)
{
    rest(8);
    edge(64);
    rest(5);
    edge(232);
    rest(30);
    check(0, 1, MR_SWITCH_GOOD);
    check(1, 4, MR_SWITCH_GOOD);
    assert_int_equal(answers, 2);
}

/* 2 ms apart no level between them holds still: neither has a name, and none is invented. */
TEST_IN(two_switches_too_near_have_no_names, begin, NULL)
{
    rest(8);
    edge(64);
    rest(1);
    edge(232);
    rest(30);
    check(0, 0, MR_SWITCH_TOO_SOON);
    check(1, 0, MR_SWITCH_TOO_SOON);
    assert_int_equal(answers, 2);
    edge(120); /* the next one is read against the level as it is now */
    rest(30);
    check(2, 2, MR_SWITCH_GOOD);
}

/* 64 + 176 at once are 240, a step of no switch: no name is invented. */
TEST_IN(two_in_the_same_moment_are_too_near, begin, NULL)
{
    rest(8);
    block_of(level_codes + 120, (const double[]){0.5, 0.50001}, 2);
    level_codes += 64 + 176;
    rest(30);
    check(0, 0, MR_SWITCH_TOO_SOON);
    check(1, 0, MR_SWITCH_TOO_SOON);
    assert_int_equal(answers, 2);
}

/* A switch that is open already and bounces once more, with two edges this time. */
TEST_IN(a_bouncing_switch_that_is_open_already_is_its_bounce, begin, NULL)
{
    rest(8);
    edge(176);
    rest(16);
    level_codes -= 176; /* closed a moment without an edge */
    rest(6);
    block_of(level_codes + 80, (const double[]){0.2, 0.6}, 2);
    level_codes += 176;
    rest(30);
    check(0, 3, MR_SWITCH_GOOD);
    check(1, 3, MR_SWITCH_BOUNCE);
    check(2, 0, MR_SWITCH_BOUNCE);
    assert_int_equal(answers, 3);
}

TEST_IN(edges_before_any_level_have_no_step, begin, NULL)
{
    block_of(level_codes, (const double[]){0.5}, 1);
    rest(30);
    check(0, 0, MR_SWITCH_TOO_SOON);
    assert_true(isnan(answered[0].step_codes));
    assert_int_equal(answers, 1);
}

/* 32 wait at most; the next is not taken, and the caller is told. A contact that never comes to
 * rest does not hold them for ever. */
TEST_IN(there_is_room_for_32, begin, NULL)
{
    struct mr_switch_edge ignored;
    rest(8);
    mr_switches_add_level(&switches, block * BLOCK_TICKS, 62.0f);
    for (unsigned i = 0; i < MR_SWITCHES_WAITING_MAX; i++)
        assert_true(mr_switches_add_edge(&switches, block * BLOCK_TICKS + 1000 * i));
    assert_false(mr_switches_add_edge(&switches, block * BLOCK_TICKS + 40000));
    assert_int_equal(switches.waiting_count, MR_SWITCHES_WAITING_MAX);
    block++;
    for (unsigned n = 0; n < 6; n++, block++) { /* ten would be needed after the last of fewer */
        mr_switches_add_level(&switches, block * BLOCK_TICKS, 62.0f);
        if (mr_switches_next_edge(&switches, steps, 4, &ignored))
            break;
    }
    assert_true(block < 15);
    for (unsigned i = 1; i < MR_SWITCHES_WAITING_MAX; i++)
        assert_true(mr_switches_next_edge(&switches, steps, 4, &ignored));
    assert_false(mr_switches_next_edge(&switches, steps, 4, &ignored));
}
