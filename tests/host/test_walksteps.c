/* Learning the steps of the staircase: what is taken, and what is refused by name. */
#include <math.h>
#include <string.h>

#include "host/board/walksteps.h"
#include "tests/cmocka_all.h"
#include "tests/common/sound_config.h"

/* Switch 6 of the sound configuration is not fitted: 23 are. */
#define FITTED 23u

static void walk_all(struct walk_steps *steps, const struct mr_config *config, double scale)
{
    unsigned number = 0;
    memset(steps, 0, sizeof *steps);
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++) {
        if (!config->gate[i].step_codes)
            continue;
        number++;
        assert_int_equal(
            walk_steps_take(steps, config, (uint8_t)number, scale * config->gate[i].step_codes),
            i + 1);
    }
    assert_int_equal(number, FITTED);
}

static bool learns(const struct walk_steps *steps, const struct mr_config *config,
                   struct mr_config *learned, struct walk_steps_found *found, char why[300])
{
    return walk_steps_learn(steps, config, learned, found, why, 300);
}

/* Resistors 3.2 % off: the steps are theirs, and nothing else of the configuration
 * changes. */
static void the_steps_are_taken(void **state)
{
    struct mr_config config = sound_config(), learned;
    struct walk_steps steps;
    struct walk_steps_found found;
    char why[300];
    (void)state;
    walk_all(&steps, &config, 1.032);
    assert_true(walk_steps_over(&steps, &config));
    assert_true(learns(&steps, &config, &learned, &found, why));
    assert_int_equal(found.count, FITTED);
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++) {
        assert_int_equal(learned.gate[i].step_codes, lround(1.032 * config.gate[i].step_codes));
        learned.gate[i].step_codes = config.gate[i].step_codes;
    }
    assert_memory_equal(&learned, &config, sizeof config);
}

/* A contact that bounced, and an edge without a step, are no switch. */
static void bounces_do_not_count(void **state)
{
    struct mr_config config = sound_config(), learned;
    struct walk_steps steps = {0};
    struct walk_steps_found found;
    char why[300];
    unsigned number = 0;
    (void)state;
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++) {
        if (!config.gate[i].step_codes)
            continue;
        walk_steps_take(&steps, &config, (uint8_t)++number, config.gate[i].step_codes);
        assert_int_equal(walk_steps_take(&steps, &config, (uint8_t)++number, 0.5), 0);
        assert_int_equal(walk_steps_take(&steps, &config, (uint8_t)++number, (double)NAN), 0);
        walk_steps_take(&steps, &config, (uint8_t)++number, config.gate[i].step_codes);
        walk_steps_bounced(&steps, (uint8_t)number);
        walk_steps_bounced(&steps, (uint8_t)(number - 1)); /* the first edge was none */
    }
    assert_true(learns(&steps, &config, &learned, &found, why));
    assert_memory_equal(&learned, &config, sizeof config);
}

static void refused(const struct walk_steps *steps, const struct mr_config *config,
                    const char *says)
{
    struct mr_config learned;
    struct walk_steps_found found;
    char why[300];
    assert_false(learns(steps, config, &learned, &found, why));
    if (!strstr(why, says))
        fail_msg("`%s` does not say `%s`", why, says);
}

/* Switches 1 and 2 of the rig add 64 and 120: no. 1 and 8 are 8 apart (64 and 72): a 1 that adds
 * 65.9 is 6.1 from it. One that adds 66.4 is 5.6 from it and 2.4 from what is configured, which is
 * better then; with 2.6 it is not known whether curve or resistor. */
static void two_that_are_near_are_named(void **state)
{
    struct mr_config config = sound_config(), learned;
    struct walk_steps steps;
    struct walk_steps_found found;
    char why[300];
    (void)state;
    assert_int_equal(config.gate[0].step_codes, 64);
    assert_int_equal(config.gate[7].step_codes, 72);
    walk_all(&steps, &config, 1.0);
    steps.codes[0] = 65.9;
    assert_true(learns(&steps, &config, &learned, &found, why));
    assert_int_equal(found.near, 1);
    assert_int_equal(found.near_other, 8);
    assert_near(found.apart_codes, 6.1, 1e-9);
    assert_false(found.configured_stay);
    assert_int_equal(learned.gate[0].step_codes, 66);
    steps.codes[0] = 66.4;
    assert_true(learns(&steps, &config, &learned, &found, why));
    assert_true(found.configured_stay);
    assert_near(found.apart_codes, 5.6, 1e-9);
    assert_memory_equal(&learned, &config, sizeof config);
    config.gate[0].step_codes = 65; /* learned before, 7 apart: nobody knows that these are right */
    refused(&steps, &config, "switches 1 and 8: their steps are 5.6 codes apart, 6 are needed");
    config.gate[0].step_codes = 64;
    steps.codes[0] = 66.6;
    refused(&steps, &config, "switches 1 and 8: their steps are 5.4 codes apart, 6 are needed");
}

static void one_out_of_turn_is_named(void **state)
{
    struct mr_config config = sound_config();
    struct walk_steps steps;
    (void)state;
    walk_all(&steps, &config, 1.0);
    double second = steps.codes[1];
    steps.codes[1] = steps.codes[2];
    steps.codes[2] = second;
    refused(&steps, &config, "switch 2: a step of 176.0 codes, configured 120");
    walk_all(&steps, &config, 1.0);
    steps.count--;
    assert_false(walk_steps_over(&steps, &config));
    refused(&steps, &config, "22 steps of 23 switches");
    walk_all(&steps, &config, 1.0);
    walk_steps_take(&steps, &config, 99, 100.0);
    refused(&steps, &config, "24 steps of 23 switches");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_steps_are_taken),
        cmocka_unit_test(bounces_do_not_count),
        cmocka_unit_test(two_that_are_near_are_named),
        cmocka_unit_test(one_out_of_turn_is_named),
    };
    return cmocka_run_group_tests_name("host/walksteps", tests, NULL, NULL);
}
