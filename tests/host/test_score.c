/* What `make score` counts with: areas by hand, zones drawn by hand, and that a series is the same
 * each time. */

#include "tests/score/advised.c"
#include "tests/score/play.c"
#include "tests/score/stats.c"
#include "tests/score/table.c"
#include "tests/score/truth.c"
#include "tests/cmocka_all.h"

TEST(areas_by_hand)
{
    const bool event[4] = {false, false, true, true};
    assert_true(score_auc((const float[]){1, 2, 3, 4}, event, 4) == 1.0);
    assert_true(score_auc((const float[]){3, 4, 1, 2}, event, 4) == 0.0);
    assert_true(score_auc((const float[]){1, 5, 3, 4}, event, 4) == 0.5);   /* 2 of 4 pairs */
    assert_true(score_auc((const float[]){1, 2, 2, 3}, event, 4) == 0.875); /* 3 and a tie */
    assert_true(isnan(score_auc((const float[]){1, 2}, event, 2)));
}

/* '.' closed, 'o' open, from the runway's edge; beyond the text all is open. */
static struct score_zone longest_in(const char *joints, double from_ft)
{
    static uint16_t gap[SCORE_JOINTS];
    for (size_t j = 0; j < SCORE_JOINTS; j++)
        gap[j] = j < strlen(joints) && joints[j] == '.' ? CLOSED_HMIL : CLOSED_HMIL + 1;
    return score_longest(gap, from_ft);
}

TEST(zones_drawn_by_hand)
{
    /* open: 7, 17 (ten on), 22 (five on: ends it) */
    struct score_zone zone = longest_in("oo.....o.........o....o..", 0.0);
    assert_int_equal(zone.first, 2);
    assert_int_equal(zone.last, 21);
    zone = longest_in("oo.....o.........o....o..", 9 * SCORE_MAT_FT);
    assert_int_equal(zone.first, 9);
    assert_int_equal(zone.last, 21);
    zone = longest_in("o.o.o.o", 0.0); /* one joint is no mat */
    assert_int_equal(mats_of(zone), 2);
    zone = longest_in("", 0.0);
    assert_int_equal(mats_of(zone), 0);
    assert_true(same((struct score_zone){10, 30}, (struct score_zone){20, 60}));
    assert_false(same((struct score_zone){10, 30}, (struct score_zone){21, 60}));
    assert_false(same((struct score_zone){10, 30}, (struct score_zone){0, 0}));
}

/* The stop follows from speed and distance: v^2 = 2 a d for the mean deceleration over distance,
 * within onset and ripple. */
TEST(a_series_is_drawn_from_its_number)
{
    struct score_series one, two;
    uint64_t first = 7, second = 7;
    draw_series(&one, 3, &first);
    draw_series(&two, 3, &second);
    assert_memory_equal(&one, &two, sizeof one);
    for (int i = 0; i < 50; i++) {
        static struct sim_path_row rows[SCORE_ROWS_MAX];
        static struct score_landing landing;
        struct gear gear;
        size_t count;
        memset(&landing, 0, sizeof landing);
        draw_gear(&gear, &one, &first);
        roll(&landing, &gear, &one, rows, &count, &first);
        assert_true(landing.stop_ft > 45.0 && landing.stop_ft < 140.0);
        assert_true(landing.edges >= 10 && rows[count - 1].force_lb == 0.0);
        double braked = 0.0; /* momentum: the integral of the deceleration is the speed */
        for (double t_s = 0.0; t_s < landing.stop_s; t_s += 1e-4)
            braked += 1e-4 * braking_ft_s2(&gear, t_s);
        assert_true(fabs(braked - gear.v0_ft_s) < 0.05);
    }
}

/* Twenty looks whose ends are off by 0 to 19 mats: 95 % of them by 18 at most. Others of the class
 * are held back, missed or too short. */
TEST(errors_by_hand)
{
    struct score_look looks[23];
    for (int16_t i = 0; i < 23; i++)
        looks[i] = (struct score_look){.truth = {100, 200},
                                       .said = {100, (int16_t)(200 - i)},
                                       .start_error = 1.0f,
                                       .end_error = 10.0f,
                                       .series = 1,
                                       .end_class = 2};
    looks[20].series = SCORE_TRAINED;
    looks[21].said = (struct score_zone){10, 60};
    looks[22].truth = looks[22].said = (struct score_zone){100, 100 + SCORE_ZONE_MATS - 1};
    assert_true(fabs(calibrate(looks, 23, true, 2) - 18.5 / 1.96) < 1e-9);
    assert_true(calibrate(looks, 23, true, 3) == 0.0);
    assert_true(fabs(wider(looks, 23, true, 2, false) - 18.0 / 19.6) < 1e-6);
    assert_true(fabs(wider(looks, 23, true, MR_PREDICTOR_END_CLASSES, true) - 20.0 / 19.6) < 1e-6);
}

/* A series of two landings drawn again keeps both: with a rank that is the event in one and its
 * opposite in the other, the lead is certain. */
TEST(bootstraps_by_hand)
{
    struct ranked ranked = make_ranked(40);
    double low, high;
    for (unsigned i = 0; i < 40; i++) {
        ranked.event[i] = i % 2 == 0;
        ranked.own[i] = ranked.event[i];
        ranked.other[i] = !ranked.event[i];
        ranked.series[i] = (uint16_t)(i / 2);
    }
    ranked.count = 40;
    bootstrap(&ranked, &low, &high);
    assert_true(low == 1.0 && high == 1.0);
    for (unsigned i = 0; i < 40; i++)
        /* right in half of the series, silent in the others */
        ranked.other[i] = i < 20 ? ranked.own[i] : 0.5f;
    bootstrap(&ranked, &low, &high);
    assert_true(low > 0.0 && low < 0.25 && high > low && high < 0.5);
    free_ranked(&ranked);
}

/* Perturbed kinds change what they name, and leave what else the series draws. */
TEST(kinds_change_what_they_name)
{
    static double gap_ft[SCORE_JOINTS], grit_lb[SCORE_JOINTS];
    const struct score_series series = {.number = 7, .grit_mean_lb = 10.0};
    unsigned shut = 0, runs = 0;
    double sum_lb = 0.0, most_lb = 0.0;
    for (int j = 0; j < SCORE_JOINTS; j++)
        gap_ft[j] = grit_lb[j] = 1.0;
    change_joints(&kinds[SCORE_CHAIN], &series, gap_ft, grit_lb);
    for (int j = 0; j < SCORE_JOINTS; j++)
        assert_true(gap_ft[j] == 1.0 && grit_lb[j] == 1.0);
    change_joints(&kinds[SCORE_SHUT], &series, gap_ft, grit_lb);
    for (int j = 0; j < SCORE_JOINTS; j++)
        shut += gap_ft[j] <= 0.004 / 12.0;
    assert_true(shut > 310 && shut < 365 && grit_lb[0] == 1.0); /* 0.8 of 421, 3 deviations */
    change_joints(&kinds[SCORE_PATCHY], &series, gap_ft, grit_lb);
    for (int j = 1; j < SCORE_JOINTS; j++)
        runs += (gap_ft[j] < 0.015 / 12.0) != (gap_ft[j - 1] < 0.015 / 12.0);
    assert_true(runs > 10 && runs < 85);
    for (uint32_t n = 0; n < 100; n++) {
        change_joints(&kinds[SCORE_HEAVY],
                      &(struct score_series){.number = n, .grit_mean_lb = 10.0}, gap_ft, grit_lb);
        for (int j = 0; j < SCORE_JOINTS; j++) {
            sum_lb += grit_lb[j] / (100.0 * SCORE_JOINTS);
            most_lb = fmax(most_lb, grit_lb[j]);
        }
    }
    /* the cap at 20 means takes 2 (1/3 / 20)^(1/2) / 3 = 9 % of the mean */
    assert_true(sum_lb > 8.8 && sum_lb < 9.4 && most_lb == 200.0);
    assert_int_equal(score_kind_find("pulsed"), SCORE_PULSED);
    assert_int_equal(score_kind_find("puls"), SCORE_KINDS);
}

/* A pulsing brake brakes as much as it would. */
TEST(pulses_keep_the_mean)
{
    const struct gear gear = {.pulse_hz = 4.0, .pulse_left = 0.3, .pulse_part = 0.4};
    double mean = 0.0, least = 2.0;
    for (int i = 0; i < 10000; i++) {
        mean += pulse_of(&gear, 1e-4 * i) / 1e4;
        least = fmin(least, pulse_of(&gear, 1e-4 * i));
    }
    assert_true(fabs(mean - 1.0) < 1e-3 && fabs(least - 0.3) < 1e-9);
}

/* Ten landings: five of 0.1, one of them an event; five of 0.9, four of them. */
TEST(brier_by_hand)
{
    float said[10];
    bool event[10];
    struct stats_held held;
    for (int i = 0; i < 10; i++) {
        said[i] = i < 5 ? 0.1f : 0.9f;
        event[i] = i == 0 || i > 5;
    }
    stats_held(said, event, 10, &held);
    assert_true(fabs(held.brier - (0.81 + 4 * 0.01 + 0.81 + 4 * 0.01) / 10.0) < 1e-6);
    assert_true(fabs(held.reliability - 0.01) < 1e-6 && fabs(held.resolution - 0.09) < 1e-6);
    assert_true(held.uncertainty == 0.25 && held.count[0] == 5 && held.events[4] == 4);
    assert_true(fabs(held.brier - held.reliability + held.resolution - 0.25) < 1e-6);
}

/* One input that is 1 in eight of ten events and in two of ten others: odds of 4 and of 1/4. */
TEST(a_rule_by_hand)
{
    float input[20][2];
    bool event[20];
    double weight[2];
    for (int i = 0; i < 20; i++) {
        event[i] = i < 10;
        input[i][0] = 1.0f;
        input[i][1] = (i < 8 || i >= 18) ? 1.0f : 0.0f;
    }
    stats_fit(input[0], event, 20, 2, 1e-9, weight);
    assert_true(fabs(weight[0] + log(4.0)) < 1e-6 && fabs(weight[1] - 2.0 * log(4.0)) < 1e-6);
    assert_true(fabs(stats_rule(weight, input[0], 2) - 0.8) < 1e-6);
}

/* As above, in pairs of a series: the lead is certain, or none. */
TEST(leads_by_hand)
{
    float own[40], other[40];
    bool event[40];
    uint16_t series[40];
    for (int i = 0; i < 40; i++) {
        event[i] = i % 2 == 0;
        own[i] = event[i];
        other[i] = !event[i];
        series[i] = (uint16_t)(700 + i / 2);
    }
    struct stats_lead lead = stats_lead(own, other, event, series, 40);
    assert_true(lead.area == 1.0 && lead.other == 0.0 && lead.low == 1.0 && lead.high == 1.0);
    lead = stats_lead(own, own, event, series, 40);
    assert_true(lead.low == 0.0 && lead.high == 0.0);
}

/* A survey of before the first landing alone, every second transducer: the rest is no number. */
TEST(what_is_lost_is_no_number)
{
    struct advised_told told = {.view = SCORE_SURVEYED | SCORE_ONCE | SCORE_HALF};
    for (unsigned landing = 0; landing < 2; landing++) {
        struct advised_known known = {.plan_ft_s2 = 1.0};
        forget(&told, landing, &known);
        for (unsigned s = 0; s < MR_SEGMENTS; s++)
            assert_true(isnan(known.sum_in[s]) == (landing == 1));
        for (unsigned s = 0; s < ADVISED_STATIONS; s++)
            assert_true(isnan(known.read_in[s]) == (s % 2 == 1));
    }
    struct rig rig;
    uint64_t noise = 1;
    draw_rig(&rig, SCORE_SURVEYED | SCORE_HALF, &noise);
    for (unsigned i = 1; i < MR_TRANSDUCERS; i += 2)
        assert_true(rig.missing[i]);
}

/* A plan that is told without an error is the braking; braked harder, it is less than that. */
TEST(a_plan_is_off_by_what_it_is_told_to_be)
{
    const struct score_landing landing = {.number = 2,
                                          .speed_ft_s = 30.0,
                                          .plan_time_s = {0.0f, 1.0f, 2.0f},
                                          .plan_deceleration_ft_s2 = {5.0f, 5.0f, 5.0f}};
    struct advised_told told = {.friction_times = 1.0, .harder = 1.0};
    struct mr_risk_plan plan;
    advised_draw_plan(&landing, 7, &told, &plan);
    assert_true(fabs(advised_plan_mean_ft_s2(&plan) - 5.0) < 0.01 && plan.landing_count == 1.0f);
    told.harder = 1.25;
    advised_draw_plan(&landing, 7, &told, &plan);
    assert_true(fabs(advised_plan_hardest_ft_s2(&plan) - 4.0) < 1e-6);
}
