/* The brake release: when it is asked for, and each thing that refuses it. Braking is the safe
 * state. */
#include <math.h>
#include <string.h>

#include "common/onboard/release.h"
#include "tests/cmocka_all.h"

static struct release release;
static struct mr_predictor predictor;
static struct mr_predictor_zone zone;
static struct mr_risk_said said;
static struct landing landing;
static struct release_settings settings;
static uint32_t now;
static unsigned lost; /* gates, the newest */

/* At 40 ft with 20 ft/s: by 4 ft/s2 alone it stops 50 ft further on, of a runway of 120. */
static int start(void **state)
{
    (void)state;
    struct mr_config config = {.risk = {{.lamp_cost_ratio = NAN,
                                         .release = 1,
                                         .release_cost_ratio = 1.0f,
                                         .release_hold_ms = 100,
                                         .release_most_ms = 1000,
                                         .coasting_ft_s2 = 4.0f,
                                         .spare_ft = 5.0f}}};
    memset(&predictor, 0, sizeof predictor);
    memset(&zone, 0, sizeof zone);
    landing_start(&landing);
    landing.state = LANDING_LANDING;
    predictor.config.chain.mats = 420;
    predictor.config.chain.mat_length_ft = 2.0f / 7.0f;
    predictor.braking = true;
    predictor.wheel_ft = 40.0f;
    predictor.speed_ft_s = 20.0f;
    predictor.deceleration_ft_s2 = 8.0f;
    lost = 0;
    said = (struct mr_risk_said){.risk = 0.8f};
    release_settings_of(&config, true, &settings);
    now = 1000;
    release_arm(&release, &settings, now);
    return 0;
}

/* Gates 5 ft apart, from -2.5 ft to the last before the wheel, but for the newest `lost`. */
static void open_gates(void)
{
    struct mr_passage *passage = &landing.passage;
    passage->state = MR_PASSAGE_ROLLING;
    passage->gates = 0;
    for (float at = -2.5f; at <= predictor.wheel_ft && passage->gates < 24u; at += 5.0f)
        passage->gate[passage->gates++].station_ft = (double)at;
    passage->gates -= lost < passage->gates ? lost : passage->gates;
    landing.gates_on_track = 2;
}

/* Looks each 10 ms; true: something was told. */
static bool look_for(unsigned ms)
{
    bool told = false;
    open_gates();
    for (unsigned i = 0; i < ms; i += 10)
        told |= release_look(&release, &predictor, &zone, &said, &landing, now += 10);
    return told;
}

static void asked_when_it_has_stayed_so(void **state)
{
    (void)state;
    assert_false(look_for(100)); /* its first look is at 10 ms */
    assert_int_equal(release.reason, MR_RELEASE_WAITS);
    assert_true(look_for(10));
    assert_true(release_asked(&release));
    assert_int_equal(release.reason, MR_RELEASE_BY_RISK);
    assert_int_equal(release.changed_block, 1110);
    said.risk = 0.0f; /* it stays asked for: a brake is no lamp */
    assert_false(look_for(500));
    assert_true(release_asked(&release));
}

static void a_moment_is_not_enough(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 20; i++) {
        said.risk = 0.8f;
        assert_false(look_for(90));
        said.risk = 0.49f;
        assert_false(look_for(10));
    }
    said.risk = NAN; /* nor is it when nobody knows */
    assert_false(look_for(1000));
    assert_false(release_asked(&release));
}

static void the_limit_is_set_by_costs(void **state)
{
    (void)state;
    struct mr_config config = {.risk = {{.lamp_cost_ratio = 4.0f, .release_cost_ratio = 3.0f}}};
    release_settings_of(&config, true, &settings);
    assert_true(isnan(settings.release_limit)); /* none is wired */
    assert_true(fabsf(settings.lamp_limit - 0.2f) < 1e-6f);
    config.risk[0].release = 1;
    release_settings_of(&config, true, &settings);
    assert_true(fabsf(settings.release_limit - 0.25f) < 1e-6f && settings.eases == 0.0f);
    config.risk[0].release = 2;
    release_settings_of(&config, true, &settings);
    assert_true(fabsf(settings.release_limit - 0.25f) < 1e-6f && settings.eases == 1.0f);
}

static void never_where_none_is_wired(void **state)
{
    (void)state;
    settings.release_limit = NAN;
    release_arm(&release, &settings, now);
    said.risk = 1.0f;
    assert_false(look_for(5000));
    assert_false(release_asked(&release));
}

static void refused(enum mr_release_reason reason)
{
    assert_true(look_for(200));
    assert_int_equal(release.state, MR_RELEASE_REFUSED);
    assert_int_equal(release.reason, reason);
}

static void what_refuses(void **state)
{
    (void)state;
#define REFUSES(change, reason) \
    do {                        \
        start(state);           \
        change;                 \
        refused(reason);        \
    } while (0)
    REFUSES(predictor.wheel_ft = 66.0f, MR_RELEASE_NO_RUNWAY);   /* 66 + 50 + 5 > 120 */
    REFUSES(predictor.speed_ft_s = 25.0f, MR_RELEASE_NO_RUNWAY); /* 40 + 78 + 5 > 120 */
    REFUSES(predictor.braking = false, MR_RELEASE_NO_MOTION);
    REFUSES(lost = 1, MR_RELEASE_NO_MOTION); /* last seen at 32.5, overdue from 39 on */
    REFUSES(predictor.wheel_ft = 11.0f, MR_RELEASE_NO_MOTION); /* two gates beyond touchdown */
    REFUSES(predictor.wheel_ft = NAN, MR_RELEASE_NO_MOTION);
    REFUSES(predictor.speed_ft_s = NAN, MR_RELEASE_NO_MOTION);
    REFUSES(predictor.speed_ft_s = 1.0f, MR_RELEASE_NO_ROLL);
    REFUSES(landing.state = LANDING_ARMED, MR_RELEASE_NO_ROLL);
    REFUSES(landing.state = LANDING_SETTLING, MR_RELEASE_NO_ROLL);
    REFUSES(landing.state = LANDING_DONE, MR_RELEASE_NO_ROLL);
    REFUSES(landing.state = LANDING_IDLE, MR_RELEASE_NO_ROLL);
    REFUSES(zone.basis = MR_PREDICTOR_BLIND, MR_RELEASE_NO_MODEL);
    REFUSES(zone.basis = MR_PREDICTOR_FELL_BACK, MR_RELEASE_NO_MODEL);
    REFUSES(zone.level = MR_PREDICTOR_KINEMATIC, MR_RELEASE_NO_MODEL);
    REFUSES(release.settings.crystal = 0.0f, MR_RELEASE_NO_CLOCK);
    REFUSES(release.settings.coasting_ft_s2 = NAN, MR_RELEASE_NO_RUNWAY);
    start(state);
    predictor.wheel_ft = 64.9f;
    assert_true(look_for(200));
    assert_true(release_asked(&release));
    start(state); /* what is over no longer refuses */
    zone.basis = MR_PREDICTOR_BLIND;
    refused(MR_RELEASE_NO_MODEL);
    zone.basis = 0;
    assert_true(look_for(10));
    assert_true(release_asked(&release));
}

/* With 30 ft/s at 40 ft, 75 ft to go: 30 x 30 / (2 x 75) = 6 ft/s2 stops it there. */
static void eased_to_what_still_stops(void **state)
{
    (void)state;
    predictor.speed_ft_s = 30.0f;
    refused(MR_RELEASE_NO_RUNWAY); /* by 4 alone it would not */
    start(state);
    release.settings.eases = 1.0f;
    predictor.speed_ft_s = 30.0f;
    assert_true(look_for(110));
    assert_true(release_asked(&release));
    assert_true(fabsf(release.ease_ft_s2 - 6.0f) < 1e-4f);
    /* 28 x 28 / (2 x 65); the deceleration that it has by now does not count */
    predictor.wheel_ft = 50.0f;
    predictor.speed_ft_s = 28.0f;
    predictor.deceleration_ft_s2 = 6.0f;
    assert_false(look_for(10));
    assert_true(fabsf(release.ease_ft_s2 - 6.0308f) < 1e-3f);
    /* 20 x 20 / (2 x 65) is less than what is left without brakes */
    predictor.speed_ft_s = 20.0f;
    assert_false(look_for(10));
    assert_true(release_asked(&release) && isnan(release.ease_ft_s2));
    /* 29 x 29 / (2 x 55) = 7.6 is more than 0.9 of the 8 before: all of the brake again */
    predictor.wheel_ft = 60.0f;
    predictor.speed_ft_s = 29.0f;
    assert_true(look_for(10));
    assert_int_equal(release.state, MR_RELEASE_OVER);
    assert_int_equal(release.reason, MR_RELEASE_NO_RUNWAY);
    assert_true(isnan(release.ease_ft_s2));
    start(state); /* 6 is no easing of 6.5 */
    release.settings.eases = 1.0f;
    predictor.speed_ft_s = 30.0f;
    predictor.deceleration_ft_s2 = 6.5f;
    refused(MR_RELEASE_NO_RUNWAY);
    start(state); /* beyond where it has to have stopped */
    release.settings.eases = 1.0f;
    predictor.wheel_ft = 116.0f;
    refused(MR_RELEASE_NO_RUNWAY);
}

static void asked_no_longer_than_it_may(void **state)
{
    (void)state;
    assert_true(look_for(110));
    assert_false(look_for(990));
    assert_true(release_asked(&release));
    assert_true(look_for(10));
    assert_int_equal(release.state, MR_RELEASE_OVER);
    assert_int_equal(release.reason, MR_RELEASE_TIME_UP);
    assert_false(look_for(5000)); /* nor again in this landing */
    assert_int_equal(release.state, MR_RELEASE_OVER);
    release_arm(&release, &settings, now);
    assert_true(look_for(110)); /* but in the next one */
    assert_true(release_asked(&release));
}

static void ends_when_something_speaks_against_it(void **state)
{
    (void)state;
#define ENDS(change, why)                                 \
    do {                                                  \
        start(state);                                     \
        assert_true(look_for(110));                       \
        change;                                           \
        assert_true(look_for(10));                        \
        assert_int_equal(release.state, MR_RELEASE_OVER); \
        assert_int_equal(release.reason, why);            \
    } while (0)
    ENDS(predictor.wheel_ft = 66.0f, MR_RELEASE_NO_RUNWAY);
    ENDS(predictor.wheel_ft = NAN, MR_RELEASE_NO_MOTION);
    ENDS((predictor.wheel_ft = 44.1f, lost = 1), MR_RELEASE_NO_MOTION); /* 37.5 + 6.5 */
    ENDS(landing.state = LANDING_SETTLING, MR_RELEASE_NO_ROLL);
    ENDS(zone.basis = MR_PREDICTOR_BLIND, MR_RELEASE_NO_MODEL);
    start(state);
    assert_true(look_for(110));
    assert_true(release_end(&release, now)); /* disarmed */
    assert_false(release_asked(&release));
    assert_false(release_end(&release, now));
}

static void the_lamp_has_a_limit_or_the_verdict(void **state)
{
    (void)state;
    zone.verdict = MR_PREDICTOR_WARNING;
    said.risk = 0.1f;
    assert_true(release_lamp(&settings, &zone, &said)); /* none set */
    settings.lamp_limit = 0.2f;
    assert_false(release_lamp(&settings, &zone, &said));
    zone.verdict = MR_PREDICTOR_QUIET;
    said.risk = 0.2f;
    assert_true(release_lamp(&settings, &zone, &said));
    said.risk = NAN; /* nobody knows: the verdict again */
    assert_false(release_lamp(&settings, &zone, &said));
    zone.verdict = MR_PREDICTOR_WARNING;
    assert_true(release_lamp(&settings, &zone, &said));
}

static void settings_are_a_list_of_numbers(void **state)
{
    (void)state;
    struct release_settings copy = {0};
    for (unsigned n = 0; n < RELEASE_SETTINGS; n++)
        assert_true(release_setting_set(&copy, n, release_setting(&settings, n)));
    assert_false(release_setting_set(&copy, RELEASE_SETTINGS, 1.0f));
    assert_true(isnan(copy.lamp_limit) && copy.release_limit == 0.5f && copy.spare_ft == 5.0f &&
                copy.hold_blocks == 100.0f && copy.most_blocks == 1000.0f &&
                copy.coasting_ft_s2 == 4.0f && copy.crystal == 1.0f && copy.eases == 0.0f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(asked_when_it_has_stayed_so, start),
        cmocka_unit_test_setup(a_moment_is_not_enough, start),
        cmocka_unit_test_setup(the_limit_is_set_by_costs, start),
        cmocka_unit_test_setup(never_where_none_is_wired, start),
        cmocka_unit_test_setup(what_refuses, start),
        cmocka_unit_test_setup(eased_to_what_still_stops, start),
        cmocka_unit_test_setup(asked_no_longer_than_it_may, start),
        cmocka_unit_test_setup(ends_when_something_speaks_against_it, start),
        cmocka_unit_test_setup(the_lamp_has_a_limit_or_the_verdict, start),
        cmocka_unit_test_setup(settings_are_a_list_of_numbers, start),
    };
    return cmocka_run_group_tests_name("common/onboard/release", tests, NULL, NULL);
}
