/* The steps of a day: what is next, for facts made by hand; what is expected is what a person at
 * the runway would say. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <string.h>

#include "common/catalogue.h"
#include "host/day/steps.h"
#include "host/day/walk.h"
#include "host/store/store.h"

#define MINUTE_US ((int64_t)60000000)
#define NOON_US   ((int64_t)1790000000000000)

/* A day in which all is done up to arming, one minute for each step; landing 3 was looked at. */
static struct day_facts all_ready(void)
{
    return (struct day_facts){.now_us = NOON_US + 10 * MINUTE_US,
                              .serial = "serial:/dev/ttyUSB0",
                              .can = "none",
                              .series = "standard",
                              .run = 3,
                              .armed_us = NOON_US,
                              .state = MR_LANDING_DONE,
                              .looked = true,
                              .survey = 4,
                              .survey_ended_us = NOON_US + 2 * MINUTE_US,
                              .survey_us = NOON_US + MINUTE_US,
                              .survey_read = 168,
                              .survey_of = 168,
                              .loaded_us = NOON_US + 3 * MINUTE_US,
                              .advised_us = NOON_US + 4 * MINUTE_US,
                              .advice = "clear",
                              .ready_us = NOON_US + 5 * MINUTE_US,
                              .go = true};
}

static enum day_step next(const struct day_facts *facts)
{
    struct day_plan plan;
    day_plan_make(facts, &plan);
    unsigned is_next = 0;
    for (enum day_step step = 0; step < DAY_STEPS; step++) {
        is_next += plan.state[step] == DAY_NEXT;
        assert_true(plan.reason[step][0] != '\0');
    }
    assert_int_equal(is_next, 1);
    assert_int_equal(plan.state[plan.next], DAY_NEXT);
    return plan.next;
}

static void an_empty_campaign_begins_with_a_series(void **state)
{
    (void)state;
    const struct day_facts nothing = {.now_us = NOON_US, .survey_ended_us = STORE_NONE};
    struct day_plan plan;
    day_plan_make(&nothing, &plan);
    assert_int_equal(plan.next, DAY_SERIES);
    assert_int_equal(plan.state[DAY_LOOK], DAY_NOT_NEEDED);
    assert_int_equal(plan.state[DAY_ADVISE], DAY_NOT_NEEDED); /* it learns from landings */
    assert_int_equal(plan.state[DAY_SURVEY], DAY_LATER);
}

static void each_step_follows_from_what_is_missing(void **state)
{
    (void)state;
    struct day_facts f = all_ready();
    assert_int_equal(next(&f), DAY_LAND);
    f.ready_us = 0;
    assert_int_equal(next(&f), DAY_READY);
    f.advised_us = NOON_US + MINUTE_US; /* before the survey was there */
    assert_int_equal(next(&f), DAY_ADVISE);
    f.loaded_us = 0;
    assert_int_equal(next(&f), DAY_LOAD);
    f.survey_us = NOON_US - 1; /* read before the last landing */
    assert_int_equal(next(&f), DAY_SURVEY);
    f.looked = false;
    assert_int_equal(next(&f), DAY_LOOK);
}

static void what_is_of_before_does_not_hold(void **state)
{
    (void)state;
    struct day_facts f = all_ready();
    f.ready_us = f.loaded_us - 1; /* the board knew another runway then */
    assert_int_equal(next(&f), DAY_READY);
    f = all_ready();
    f.survey_us = NOON_US - 1; /* without a survey, the landing alone counts */
    f.skipped[DAY_SURVEY] = true;
    f.ready_us = f.armed_us - 1;
    assert_int_equal(next(&f), DAY_READY);
    f = all_ready();
    f.go = false;
    strcpy(f.no_go, "noise: d3");
    assert_int_equal(next(&f), DAY_READY);
    f.calibration_due = true;
    assert_int_equal(next(&f), DAY_CALIBRATE);
    f.calibrated_us = f.ready_us + 1; /* what ready said is of before it */
    assert_int_equal(next(&f), DAY_READY);
}

static void a_survey_that_was_broken_off_goes_on(void **state)
{
    (void)state;
    struct day_facts f = all_ready();
    f.survey_ended_us = STORE_NONE;
    f.survey_read = 50;
    struct day_plan plan;
    day_plan_make(&f, &plan);
    assert_int_equal(plan.next, DAY_SURVEY);
    assert_non_null(strstr(plan.reason[DAY_SURVEY], "50 of 168"));
}

static void a_skipped_step_is_passed_and_the_rest_is_not(void **state)
{
    (void)state;
    struct day_facts f = all_ready();
    f.survey_us = NOON_US - 1;
    f.skipped[DAY_SURVEY] = true;
    f.loaded_us = 0; /* there is nothing to load then */
    assert_int_equal(next(&f), DAY_LAND);
    f.ready_us = 0;
    assert_int_equal(next(&f), DAY_READY);
}

static void a_log_that_runs_is_next_whatever_is_open(void **state)
{
    (void)state;
    struct day_facts f = all_ready();
    f.logging = true;
    f.run = 4;
    f.state = MR_LANDING_LANDING;
    f.looked = false;
    assert_int_equal(next(&f), DAY_LAND);
    f.logging = false; /* it was killed in the landing */
    assert_int_equal(next(&f), DAY_LOOK);
}

static void a_channel_is_due_from_the_day_on_which_it_expires(void **state)
{
    (void)state;
    static struct mr_config config;
    config.channel[0] = (struct mr_channel_config){
        .kind = MR_KIND_DISPLACEMENT, .calibrated_day = 20000, .expires_day = 20365};
    assert_false(day_walk_is_due(&config, 0, 20364));
    assert_true(day_walk_is_due(&config, 0, 20365));
    config.channel[0].expires_day = 0; /* never */
    assert_false(day_walk_is_due(&config, 0, 99999));
    config.channel[0].calibrated_day = 0;
    assert_true(day_walk_is_due(&config, 0, 20364));
    assert_false(day_walk_is_due(&config, 1, 20364)); /* not fitted */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_empty_campaign_begins_with_a_series),
        cmocka_unit_test(each_step_follows_from_what_is_missing),
        cmocka_unit_test(what_is_of_before_does_not_hold),
        cmocka_unit_test(a_survey_that_was_broken_off_goes_on),
        cmocka_unit_test(a_skipped_step_is_passed_and_the_rest_is_not),
        cmocka_unit_test(a_log_that_runs_is_next_whatever_is_open),
        cmocka_unit_test(a_channel_is_due_from_the_day_on_which_it_expires),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
