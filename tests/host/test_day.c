/* The steps of a day: what is next, for facts made by hand; the expectation is what a person at the
 * runway would answer. */
#include <string.h>

#include "common/catalogue.h"
#include "host/day/day.h"
#include "tests/cmocka_all.h"

#define MINUTE_US ((int64_t)60000000)
#define NOON_US   ((int64_t)1790000000000000)

/* A day in which all is done up to arming, one minute for each step; landing 3 has a note. */
static struct day_facts all_ready(void)
{
    return (struct day_facts){.now_us = NOON_US + 10 * MINUTE_US,
                              .serial = "serial:/dev/ttyUSB0",
                              .can = "none",
                              .series = "standard",
                              .run = 3,
                              .armed_us = NOON_US,
                              .state = MR_LANDING_DONE,
                              .noted = true,
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

TEST(an_empty_campaign_begins_with_a_series)
{
    const struct day_facts nothing = {.now_us = NOON_US, .survey_ended_us = STORE_NONE};
    struct day_plan plan;
    day_plan_make(&nothing, &plan);
    assert_int_equal(plan.next, DAY_SERIES);
    assert_int_equal(plan.state[DAY_LOOK], DAY_NOT_NEEDED);
    assert_int_equal(plan.state[DAY_ADVISE], DAY_NOT_NEEDED); /* it learns from landings */
    assert_int_equal(plan.state[DAY_SURVEY], DAY_LATER);
}

TEST(each_step_follows_from_what_is_missing)
{
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
    f.noted = false;
    assert_int_equal(next(&f), DAY_LOOK);
}

TEST(a_check_that_predates_a_change_does_not_hold)
{
    struct day_facts f = all_ready();
    f.ready_us = f.loaded_us - 1; /* the board had another runway then */
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
    f.calibrated_us = f.ready_us + 1;
    assert_int_equal(next(&f), DAY_READY);
}

TEST(a_survey_that_is_not_finished_goes_on)
{
    struct day_facts f = all_ready();
    f.survey_ended_us = STORE_NONE;
    f.survey_read = 50;
    struct day_plan plan;
    day_plan_make(&f, &plan);
    assert_int_equal(plan.next, DAY_SURVEY);
    assert_non_null(strstr(plan.reason[DAY_SURVEY], "50 of 168"));
}

TEST(a_skipped_step_is_passed_and_the_rest_is_not)
{
    struct day_facts f = all_ready();
    f.survey_us = NOON_US - 1;
    f.skipped[DAY_SURVEY] = true;
    f.loaded_us = 0; /* there is nothing to load then */
    assert_int_equal(next(&f), DAY_LAND);
    f.ready_us = 0;
    assert_int_equal(next(&f), DAY_READY);
}

TEST(while_a_log_runs_the_landing_is_next)
{
    struct day_facts f = all_ready();
    struct day_plan plan;
    f.logging = true;
    f.logging_since_us = f.now_us;
    f.ready_us = 0;
    day_plan_make(&f, &plan);
    assert_int_equal(next(&f), DAY_LAND);
    assert_non_null(strstr(plan.reason[DAY_LAND], "nothing is armed"));
    f.run = 4;
    f.armed_us = f.now_us + 1;
    f.state = MR_LANDING_LANDING;
    f.noted = false;
    assert_int_equal(next(&f), DAY_LAND);
    f.state = MR_LANDING_DONE;
    day_plan_make(&f, &plan);
    assert_int_equal(next(&f), DAY_LAND);
    assert_non_null(strstr(plan.reason[DAY_LAND], "end the log"));
    f.logging = false;
    assert_int_equal(next(&f), DAY_LOOK);
    f.state = MR_LANDING_LANDING; /* the log was killed in the landing */
    assert_int_equal(next(&f), DAY_LOOK);
}
