/* The risk: its rule against libm, what it makes of a plan against the parabola by hand, and what
 * it does without. */
#include <math.h>
#include <string.h>

#include "common/risk.h"
#include "tests/cmocka_all.h"

static struct mr_predictor predictor;
static struct mr_risk_state risk;

static const struct mr_predictor_config rig = {.chain = {.mats = 420,
                                                         .mat_length_ft = 2.0f / 7.0f,
                                                         .mass_slug = 0.466f / 32.174f,
                                                         .friction_lb = 0.5f * 0.466f,
                                                         .kl_lb_ft = 2.9e5f,
                                                         .cl_lb_s_ft = 5.0f,
                                                         .slack_ft = 0.0025f,
                                                         .step_s = 1e-3f / 6.0f},
                                               .grit_lb = 10.0f,
                                               .thrust_lb_per_g = 1300.0f / 12.0f,
                                               .deceleration_ft_s2 = 5.0f,
                                               .bump_ft = 0.0036f,
                                               .mat_weight_lb = 0.466f,
                                               .updates_per_block = 1u << 20,
                                               .station_ft = {40, 50, 60, 70, 80, 90, 100, 110}};

static void is_near(double a, double b, double within)
{
    if (!(fabs(a - b) <= within))
        fail_msg("%.9g is not %.9g within %g", a, b, within);
}

/* Braking at 6 ft/s2 from 30 ft/s: 75 ft. */
static struct mr_risk_plan even(void)
{
    struct mr_risk_plan plan;
    mr_risk_plan_clear(&plan);
    plan.speed_ft_s = 30.0f;
    plan.plan_time_s[0] = 0.0f;
    plan.plan_deceleration_ft_s2[0] = 6.0f;
    return plan;
}

static struct mr_risk_plan charted(float landings)
{
    struct mr_risk_plan plan = even();
    plan.landing_count = landings;
    plan.chart_deceleration_ft_s2[0] = 4.0f;
    plan.chart_deceleration_ft_s2[1] = 8.0f;
    plan.chart_log_odds[0] = -1.0f;
    plan.chart_log_odds[1] = 2.0f;
    plan.chart_zone_ft[1] = 70.0f;
    return plan;
}

static void begin(const struct mr_risk_plan *plan)
{
    assert_int_equal(mr_predictor_start(&predictor, &rig), MR_OK);
    mr_predictor_arm(&predictor);
    mr_risk_arm(&risk, plan, &predictor, 3.0f);
}

/* From touchdown on at `a`, for so many blocks; what is said then. */
static struct mr_risk_report roll(double v, double a, unsigned blocks)
{
    struct mr_risk_report said;
    struct mr_predictor_zone zone;
    for (unsigned i = 0; i < blocks; i++) {
        double t = 1e-3 * i, stop = v / a;
        t = t > stop ? stop : t;
        struct mr_predictor_input input = {.wheel_ft = (float)(3.0 + (v - 0.5 * a * t) * t),
                                           .speed_ft_s = (float)(v - a * t),
                                           .deceleration_ft_s2 = (float)a,
                                           .is_braking_known = i > 400,
                                           .is_on_runway = true};
        mr_predictor_on_block(&predictor, &input);
        mr_risk_on_block(&risk, &predictor, &input);
    }
    mr_predictor_get_zone(&predictor, &zone);
    mr_risk_compute(&risk, &predictor, &zone, &said);
    return said;
}

TEST(the_rule_is_logistic)
{
    for (int i = -3000; i <= 3000; i++) {
        double x = 0.01 * i;
        is_near((double)mr_risk_logistic((float)x), 1.0 / (1.0 + exp(-(double)(float)x)), 1e-6);
    }
    assert_true(mr_risk_logistic(1e30f) <= 1.0f && mr_risk_logistic(-1e30f) >= 0.0f);
}

TEST(a_plan_is_a_list_of_numbers)
{
    struct mr_risk_plan plan = charted(3.0f), copy;
    mr_risk_plan_clear(&copy);
    for (unsigned i = 0; i < MR_RISK_PLAN_ITEM_COUNT; i++)
        assert_true(mr_risk_plan_set_item(&copy, i, mr_risk_plan_get_item(&plan, i)));
    assert_false(mr_risk_plan_set_item(&copy, MR_RISK_PLAN_ITEM_COUNT, 1.0f));
    assert_true(isnan(mr_risk_plan_get_item(&copy, MR_RISK_PLAN_ITEM_COUNT)));
    assert_int_equal(mr_risk_plan_crc(&plan), mr_risk_plan_crc(&copy));
    assert_true(copy.chart_log_odds[1] == 2.0f && copy.plan_deceleration_ft_s2[0] == 6.0f &&
                copy.landing_count == 3.0f);
    copy.chart_log_odds[1] = 2.0000002f;
    assert_int_not_equal(mr_risk_plan_crc(&plan), mr_risk_plan_crc(&copy));
}

TEST(what_makes_no_sense_is_no_plan)
{
    struct mr_risk_plan plan = even();
    assert_int_equal(mr_risk_plan_check(&plan), MR_OK);
#define WRONG(change)                                       \
    do {                                                    \
        struct mr_risk_plan p = charted(0.0f);              \
        assert_int_equal(mr_risk_plan_check(&p), MR_OK);    \
        change;                                             \
        assert_int_equal(mr_risk_plan_check(&p), MR_USAGE); \
    } while (0)
    WRONG(p.speed_ft_s = NAN);
    WRONG(p.speed_ft_s = -30.0f);
    WRONG(p.plan_time_s[0] = NAN);
    WRONG(p.plan_deceleration_ft_s2[0] = 0.0f);
    WRONG(p.plan_deceleration_ft_s2[0] = 100.0f);
    WRONG(p.plan_time_s[1] = 0.0f; p.plan_deceleration_ft_s2[1] = 6.0f);
    WRONG(p.chart_deceleration_ft_s2[1] = 3.0f);
    WRONG(p.chart_log_odds[0] = NAN);
    WRONG(p.chart_log_odds[0] = INFINITY);
    WRONG(p.landing_count = NAN);
    WRONG(p.chart_zone_ft[0] = 1e9f);
}

TEST(nobody_knows_before_it_rolls)
{
    struct mr_risk_report said;
    struct mr_predictor_zone zone;
    begin(NULL);
    mr_predictor_get_zone(&predictor, &zone);
    mr_risk_compute(&risk, &predictor, &zone, &said);
    assert_true(isnan(said.risk));
    assert_int_equal(said.reason, MR_RISK_UNKNOWN);
    assert_int_equal(said.basis & (MR_RISK_PLAN_USED | MR_RISK_NO_MOTION), MR_RISK_NO_MOTION);
    struct mr_risk_plan plan = charted(0.0f);
    begin(&plan); /* but by chart and plan */
    mr_risk_compute(&risk, &predictor, &zone, &said);
    assert_true(said.risk > 0.0f && said.risk < 1.0f);
    assert_int_equal(said.basis & 15u, MR_RISK_PLAN_USED | MR_RISK_CHART_USED);
    /* 6 lies in the middle of 4 and 8 */
    is_near((double)said.input[MR_RISK_CHART], 0.5, 0.02);
}

TEST(a_plan_that_is_met_tells_the_way)
{
    struct mr_risk_plan plan = even();
    begin(&plan);
    struct mr_risk_report said = roll(30.0, 6.0, 2001);
    /* 18 ft/s are left: 27 ft */
    is_near((double)risk.stopping_distance_ft, 27.0, 0.3);
    is_near((double)said.input[MR_RISK_BRAKING] * 6.0, 6.0, 0.1);
    assert_int_equal(said.basis & (MR_RISK_PLAN_USED | MR_RISK_PLAN_NOT_FOLLOWED),
                     MR_RISK_PLAN_USED);
    begin(&plan); /* a quarter harder than planned: so is what is to come */
    said = roll(30.0, 7.5, 2001);
    is_near((double)said.input[MR_RISK_BRAKING] * 6.0, 7.5, 0.1);
    is_near((double)risk.stopping_distance_ft, 15.0, 0.3);
    assert_int_equal(said.basis & (MR_RISK_PLAN_USED | MR_RISK_PLAN_NOT_FOLLOWED),
                     MR_RISK_PLAN_USED);
}

TEST(hard_braking_that_is_planned_counts)
{
    struct mr_risk_plan plan = even();
    plan.plan_deceleration_ft_s2[0] = 3.0f;
    plan.plan_time_s[1] = 3.0f;
    plan.plan_deceleration_ft_s2[1] = 3.0f;
    plan.plan_time_s[2] = 3.2f;
    plan.plan_deceleration_ft_s2[2] = 12.0f;
    begin(&plan);
    struct mr_risk_report said = roll(30.0, 3.0, 2001);
    is_near((double)said.input[MR_RISK_BRAKING] * 6.0, 12.0, 0.2);
    /* 24 ft/s at 2 s, 21 at 3 s after 22.5 ft, and 20^2 / 24 or so from there */
    is_near((double)risk.stopping_distance_ft, 22.5 + 4.1 + 15.9, 1.0);
}

TEST(a_plan_that_is_not_met_is_left)
{
    struct mr_risk_plan plan = charted(0.0f);
    begin(&plan);
    struct mr_risk_report said = roll(30.0, 12.0,
                                      601); /* by then the plan would have lost 3.6 ft/s */
    assert_int_equal(said.basis & MR_RISK_PLAN_NOT_FOLLOWED, 0);
    begin(&plan);
    said = roll(30.0, 12.0, 901);
    assert_int_equal(said.basis &
                         (MR_RISK_PLAN_USED | MR_RISK_CHART_USED | MR_RISK_PLAN_NOT_FOLLOWED),
                     MR_RISK_PLAN_NOT_FOLLOWED);
    assert_true(said.weight_set < MR_RISK_WEIGHTS_PLAN && said.input[MR_RISK_CHART] == 0.0f);
    begin(&plan); /* another speed than planned */
    said = roll(40.0, 6.0, 901);
    assert_int_equal(said.basis & MR_RISK_PLAN_NOT_FOLLOWED, MR_RISK_PLAN_NOT_FOLLOWED);
}

TEST(a_chart_of_another_runway_is_ignored)
{
    struct mr_risk_plan plan = charted(2.0f);
    begin(&plan); /* that has had none */
    struct mr_risk_report said = roll(30.0, 6.0, 1001);
    assert_int_equal(said.basis & 15u, MR_RISK_PLAN_USED | MR_RISK_CHART_OUTDATED);
    assert_true(said.input[MR_RISK_CHART] == 0.0f);
}

TEST(who_stands_comes_to_no_zone)
{
    begin(NULL);
    struct mr_risk_report said = roll(30.0, 6.0, 5200);
    assert_true(said.risk == 0.0f);
    assert_int_equal(said.basis & MR_RISK_STOPPED, MR_RISK_STOPPED);
    assert_int_equal(said.reason, MR_RISK_REASON_NONE);
}

TEST(no_transducer_is_told)
{
    begin(NULL);
    struct mr_predictor_input input = {.wheel_ft = 20.0f,
                                       .speed_ft_s = 25.0f,
                                       .deceleration_ft_s2 = 6.0f,
                                       .is_braking_known = true,
                                       .is_on_runway = true};
    struct mr_predictor_zone zone;
    struct mr_risk_report said;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        input.displacement_in[i] = NAN;
    mr_predictor_on_block(&predictor, &input);
    mr_risk_on_block(&risk, &predictor, &input);
    mr_predictor_get_zone(&predictor, &zone);
    mr_risk_compute(&risk, &predictor, &zone, &said);
    assert_int_equal(said.basis, MR_RISK_NO_TRANSDUCER | MR_RISK_BRAKING_KNOWN);
    assert_int_equal(said.weight_set, MR_RISK_WEIGHTS_IF_BRAKING + MR_RISK_WEIGHTS_IF_NO_SENSOR);
}

/* 60 mats from 40 ft on, the wheel at 20 ft with 25 ft/s and 5 ft/s2. */
TEST(failure_is_expected_inside_the_zone)
{
    begin(NULL);
    struct mr_predictor_input input = {
        .wheel_ft = 20.0f, .speed_ft_s = 25.0f, .deceleration_ft_s2 = 5.0f, .is_on_runway = true};
    struct mr_risk_report said;
    mr_predictor_on_block(&predictor, &input);
    mr_risk_on_block(&risk, &predictor, &input);
    const struct mr_predictor_zone zone = {.mats = 60, .start_ft = 40.0f, .end_ft = 57.14f};
    mr_risk_compute(&risk, &predictor, &zone, &said);
    assert_int_equal(said.reason, MR_RISK_ZONE_AHEAD);
    /* 20 = 25 t - 2.5 t^2; 12.5 mats are 3.571 ft */
    is_near((double)said.start_s, 5.0 - sqrt(17.0), 1e-4);
    is_near((double)said.failure_ft, 43.571, 1e-3);
    is_near((double)said.failure_s, 5.0 - sqrt(25.0 - 23.571 / 2.5), 1e-3);
}

/* By the plan and the chart nothing was to be expected. */
TEST(a_zone_that_is_there_outweighs_the_chart)
{
    struct mr_risk_plan plan = charted(0.0f);
    const struct mr_predictor_zone none = {.future_mats = 60, .future_wheel_ft = 60.0f},
                                   there = {.mats = 60,
                                            .start_ft = 40.0f,
                                            .end_ft = 57.14f,
                                            .future_mats = 60,
                                            .future_wheel_ft = 40.0f};
    struct mr_risk_report expected, seen, plain;
    plan.chart_log_odds[0] = plan.chart_log_odds[1] = -6.0f;
    begin(&plan);
    (void)roll(30.0, 6.0, 700);
    mr_risk_compute(&risk, &predictor, &none, &expected);
    mr_risk_compute(&risk, &predictor, &there, &seen);
    begin(NULL);
    (void)roll(30.0, 6.0, 700);
    mr_risk_compute(&risk, &predictor, &there, &plain);
    assert_true(expected.basis & MR_RISK_CHART_USED && expected.risk < 0.1f);
    assert_true(plain.risk > 0.5f && seen.risk == plain.risk);
}

TEST(the_lamp_has_a_limit_or_the_verdict)
{
    struct mr_predictor_zone zone = {.verdict = MR_PREDICTOR_WARNING};
    struct mr_risk_report said = {.risk = 0.1f};
    assert_true(mr_risk_is_lamp_on(NAN, &zone, &said)); /* none set */
    assert_true(isnan(mr_risk_lamp_limit(NAN)));
    assert_true(mr_risk_lamp_limit(4.0f) == 0.2f);
    assert_false(mr_risk_is_lamp_on(0.2f, &zone, &said));
    zone.verdict = MR_PREDICTOR_QUIET;
    said.risk = 0.2f;
    assert_true(mr_risk_is_lamp_on(0.2f, &zone, &said));
    said.risk = NAN; /* nobody knows: the verdict again */
    assert_false(mr_risk_is_lamp_on(0.2f, &zone, &said));
    zone.verdict = MR_PREDICTOR_WARNING;
    assert_true(mr_risk_is_lamp_on(0.2f, &zone, &said));
}
