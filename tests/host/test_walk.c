/* Learning the steps of the staircase: what is taken, and what is refused by name. */
#include <math.h>
#include <string.h>

#include "host/board/walk.h"
#include "tests/cmocka_all.h"
#include "tests/common/sound_config.h"

/* Switch 6 of the sound configuration is not fitted: 23 are. */
#define FITTED 23u

static struct walk walk;
static struct ready_report report;

static void edge(unsigned number, double codes)
{
    walk_take_edge(&walk, &(struct mr_edge){.count = (uint8_t)number, .step_codes = (float)codes});
}

static void walk_all(const struct mr_config *config, double scale)
{
    unsigned number = 0;
    walk_start(&walk, config);
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++) {
        if (config->gate[i].step_codes)
            edge(++number, scale * config->gate[i].step_codes);
    }
    assert_int_equal(number, FITTED);
}

static bool learns(struct mr_config *learned)
{
    memset(&report, 0, sizeof report);
    bool good = walk_learn(&walk, learned, &report);
    assert_int_equal(report.count, 1);
    assert_int_equal(report.check[0].verdict, good ? READY_GO : READY_NO_GO);
    return good;
}

static void says(const char *text)
{
    if (!strstr(report.check[0].value, text))
        fail_msg("`%s` does not say `%s`", report.check[0].value, text);
}

static void refused(const char *text)
{
    struct mr_config learned;
    assert_false(learns(&learned));
    says(text);
}

/* Resistors 3.2 % off: the steps are theirs, and nothing else of the configuration
 * changes. */
TEST(the_steps_are_taken)
{
    struct mr_config config = sound_config(), learned;
    walk_all(&config, 1.032);
    assert_true(walk_is_over(&walk, true));
    assert_true(learns(&learned));
    says("23 learned");
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++) {
        assert_int_equal(learned.gate[i].step_codes, lround(1.032 * config.gate[i].step_codes));
        learned.gate[i].step_codes = config.gate[i].step_codes;
    }
    assert_memory_equal(&learned, &config, sizeof config);
}

/* A contact that bounced, and an edge without a step, are no switch. */
TEST(bounces_do_not_count)
{
    struct mr_config config = sound_config(), learned;
    unsigned number = 0;
    walk_start(&walk, &config);
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++) {
        if (!config.gate[i].step_codes)
            continue;
        edge(++number, config.gate[i].step_codes);
        edge(++number, 0.5);
        edge(++number, (double)NAN);
        edge(++number, config.gate[i].step_codes);
        const struct mr_switch_event bounce = {.reason = MR_SWITCH_BOUNCE,
                                               .count = (uint8_t)number},
                                     none = {.reason = MR_SWITCH_BOUNCE,
                                             .count = (uint8_t)(number - 1)};
        walk_take_event(&walk, &bounce);
        walk_take_event(&walk, &none);
    }
    assert_true(learns(&learned));
    assert_memory_equal(&learned, &config, sizeof config);
}

/* Switches 1 and 2 of the rig add 64 and 120: no. 1 and 8 are 8 apart (64 and 72): a 1 that adds
 * 65.9 is 6.1 from it. One that adds 66.4 is 5.6 from it and 2.4 from what is configured, which is
 * better then; with 2.6 it is not known whether curve or resistor. */
TEST(two_that_are_near_are_named)
{
    struct mr_config config = sound_config(), learned;
    assert_int_equal(config.gate[0].step_codes, 64);
    assert_int_equal(config.gate[7].step_codes, 72);
    walk_all(&config, 1.0);
    walk.answer[WALK_SWITCH][0].codes = 65.9;
    assert_true(learns(&learned));
    says("23 learned, at most 1.9 codes from those configured; nearest to each other are 1 and 8, "
         "6.1 codes apart");
    assert_int_equal(learned.gate[0].step_codes, 66);
    walk.answer[WALK_SWITCH][0].codes = 66.4;
    assert_true(learns(&learned));
    says("the configured steps stay");
    says("5.6 codes apart");
    assert_memory_equal(&learned, &config, sizeof config);
    config.gate[0].step_codes = 65; /* learned before, 7 apart: nobody knows that these are right */
    refused("switches 1 and 8: their steps are 5.6 codes apart, 6 are needed");
    config.gate[0].step_codes = 64;
    walk.answer[WALK_SWITCH][0].codes = 66.6;
    refused("switches 1 and 8: their steps are 5.4 codes apart, 6 are needed");
}

TEST(one_out_of_turn_is_named)
{
    struct mr_config config = sound_config();
    walk_all(&config, 1.0);
    double second = walk.answer[WALK_SWITCH][1].codes;
    walk.answer[WALK_SWITCH][1].codes = walk.answer[WALK_SWITCH][2].codes;
    walk.answer[WALK_SWITCH][2].codes = second;
    refused("switch 2: a step of 176.0 codes, configured 120");
    walk_all(&config, 1.0);
    walk.count[WALK_SWITCH]--;
    assert_false(walk_is_over(&walk, true));
    refused("22 steps of 23 switches");
    walk_all(&config, 1.0);
    edge(99, 100.0);
    refused("24 steps of 23 switches");
}
