/* The advice: its smoother against the exact Kalman solution, members against the chain alone,
 * shares against counting, and how plans are met against an integral. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/advise/members.h"
#include "host/base/statistics.h"

#define MANY   20000u
#define MATS   120u
#define MAT_FT (2.0f / 7.0f)
#define COUNT  64u

/* --- the smoother --- */

/* x ~ N((1, -2), (4 1; 1 2)), read are x0 and x0 + x1. The solutions are Kalman's
 * equations in fractions. */
struct linear {
    double state[MANY][2], predicted[MANY][2];
};

static void draw_linear(struct linear *linear, struct rng *chance)
{
    for (size_t m = 0; m < MANY; m++) { /* Cholesky's factor of the covariance */
        double a = rng_normal(chance), b = rng_normal(chance);
        linear->state[m][0] = 1.0 + 2.0 * a;
        linear->state[m][1] = -2.0 + 0.5 * a + sqrt(1.75) * b;
    }
}

static void predict_linear(struct linear *linear)
{
    for (size_t m = 0; m < MANY; m++) {
        linear->predicted[m][0] = linear->state[m][0];
        linear->predicted[m][1] = linear->state[m][0] + linear->state[m][1];
    }
}

static double covariance(const struct linear *linear, int i, int j)
{
    double mean[2] = {0.0, 0.0}, sum = 0.0;
    for (size_t m = 0; m < MANY; m++) {
        mean[0] += linear->state[m][0] / MANY;
        mean[1] += linear->state[m][1] / MANY;
    }
    for (size_t m = 0; m < MANY; m++)
        sum += (linear->state[m][i] - mean[i]) * (linear->state[m][j] - mean[j]) / (MANY - 1);
    return sum;
}

static void take_linear(struct linear *linear, const double read[2], unsigned passes,
                        double (*nearness)(const void *, size_t, size_t))
{
    static const double error[2] = {1.0, 0.5};
    struct rng chance = rng_init(7, 0);
    for (unsigned pass = 0; pass < passes; pass++) {
        predict_linear(linear);
        const struct smoother smoother = {.member_count = MANY,
                                          .state_count = 2,
                                          .reading_count = 2,
                                          .state = &linear->state[0][0],
                                          .predicted = &linear->predicted[0][0],
                                          .reading = read,
                                          .reading_error = error,
                                          .reading_error_factor = passes,
                                          .taper_weight = nearness};
        smoother_update(&smoother, &chance);
    }
}

static void is_kalmans(const struct linear *linear, const double mean[2], const double p[3])
{
    for (size_t k = 0; k < 2; k++) {
        double is, deviation;
        smoother_moments(&linear->state[0][0], MANY, 2, k, &is, &deviation);
        assert_near(is, mean[k], 0.03);
    }
    assert_near(covariance(linear, 0, 0), p[0], 0.03);
    assert_near(covariance(linear, 0, 1), p[1], 0.03);
    assert_near(covariance(linear, 1, 1), p[2], 0.03);
}

TEST(the_smoother_comes_to_the_kalman_filter)
{
    static struct linear linear;
    static const double read[2] = {3.0, 0.5}, one[2] = {(double)NAN, 0.5};
    for (unsigned passes = 1; passes <= 4; passes *= 2) {
        struct rng chance = rng_init(3, passes);
        draw_linear(&linear, &chance);
        take_linear(&linear, read, passes, NULL);
        is_kalmans(&linear, (const double[]){159.0 / 65.0, -124.0 / 65.0},
                   (const double[]){32.0 / 65.0, -27.0 / 65.0, 37.0 / 65.0});
        draw_linear(&linear, &chance);
        take_linear(&linear, one, passes, NULL);
        is_kalmans(&linear, (const double[]){21.0 / 11.0, -16.0 / 11.0},
                   (const double[]){32.0 / 33.0, -9.0 / 11.0, 10.0 / 11.0});
    }
}

static double first_alone(const void *context, size_t unknown, size_t datum)
{
    (void)context;
    return unknown == 0 && datum == 0 ? 1.0 : 0.0;
}

TEST(what_is_far_stays)
{
    static struct linear linear, before;
    static const double read[2] = {3.0, 0.5}, none[2] = {(double)NAN, (double)NAN};
    struct rng chance = rng_init(5, 0);
    draw_linear(&linear, &chance);
    before = linear;
    take_linear(&linear, none, 1, NULL);
    assert_memory_equal(linear.state, before.state, sizeof linear.state);
    take_linear(&linear, read, 1, first_alone);
    for (size_t m = 0; m < MANY; m++) {
        assert_true(linear.state[m][1] >= before.state[m][1] &&
                    linear.state[m][1] <= before.state[m][1]);
        assert_false(fabs(linear.state[m][0] - before.state[m][0]) < 1e-12);
    }
}

/* Gaspari and Cohn's polynomial at points that are worked out by hand. */
TEST(the_taper_is_gaspari_and_cohns)
{
    assert_near(smoother_taper(0.0, 3.0), 1.0, 1e-15);
    assert_near(smoother_taper(-1.5, 3.0), 263.0 / 384.0, 1e-14);
    assert_near(smoother_taper(3.0, 3.0), 5.0 / 24.0, 1e-14);
    assert_near(smoother_taper(6.0, 3.0), 0.0, 1e-15);
    assert_near(smoother_taper(5.999999, 3.0), 0.0, 1e-12);
}

TEST(spread_is_given_back)
{
    double x[6] = {9.0, 1.0, 9.0, 2.0, 9.0, 3.0}, mean, deviation;
    smoother_restore_spread(x, 3, 2, 1, 5.0, 0.5, 0.0); /* half of what 5 lost to 1 */
    smoother_moments(x, 3, 2, 1, &mean, &deviation);
    assert_near(mean, 2.0, 1e-14);
    assert_near(deviation, 3.0, 1e-14);
    smoother_restore_spread(x, 3, 2, 1, 3.0, 0.5, 4.0); /* and no less than this */
    smoother_moments(x, 3, 2, 1, &mean, &deviation);
    assert_near(deviation, 4.0, 1e-14);
    assert_near(x[0], 9.0, 1e-15);
}

/* --- members --- */

static struct advise_runway rig(void)
{
    struct advise_runway runway = {.chain = {.mats = MATS,
                                             .mat_length_ft = MAT_FT,
                                             .mass_slug = 0.466f / 32.174f,
                                             .friction_lb = 0.6f * 0.466f,
                                             .kl_lb_ft = 2.9e5f,
                                             .cl_lb_s_ft = 5.0f,
                                             .slack_ft = 0.0025f},
                                   .grit_lb = 6.0,
                                   .thrust_lb_per_g = 1300.0 / 12.0};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        runway.transducer_station_ft[i] = i < 4 ? 8.0f + 7.0f * (float)i : NAN;
    return runway;
}

/* A zone by its definition: every pair of closed joints, every ten between. */
static unsigned longest_by_trying(const float *opening_ft, unsigned joints, unsigned from)
{
    unsigned most = 0;
    for (unsigned a = from; a < joints; a++) {
        for (unsigned b = a + 1; b < joints; b++) {
            bool zone = !(opening_ft[a] > 0.001f / 12.0f) && !(opening_ft[b] > 0.001f / 12.0f);
            for (unsigned i = a; zone && i <= b; i++) {
                unsigned open = 0;
                for (unsigned j = i; j < i + 10 && j <= b; j++)
                    open += opening_ft[j] > 0.001f / 12.0f;
                zone = open < 2;
            }
            if (zone && b - a > most)
                most = b - a;
        }
    }
    return most;
}

TEST(the_longest_zone_is_found)
{
    float opening_ft[90];
    struct rng chance = rng_init(11, 0);
    unsigned longest = 0;
    for (unsigned trial = 0; trial < 300; trial++) {
        double closed = 0.7 + 0.3 * rng_uniform(&chance);
        for (unsigned j = 0; j < 90; j++)
            opening_ft[j] = rng_uniform(&chance) < closed ? 0.00005f : 0.001f;
        struct advise_zone zone = advise_find_longest_zone(opening_ft, 90, trial % 40);
        assert_int_equal(zone.mat_count, longest_by_trying(opening_ft, 90, trial % 40));
        longest = zone.mat_count > longest ? zone.mat_count : longest;
    }
    assert_true(longest > 60);
}

/* A member's landing on the chain of common/matchain.h by itself. */
static double play_alone(const struct advise_members *members, size_t m,
                         const struct advise_braking *braking, double step_s, double *moved_in)
{
    static struct mr_chain chain;
    float grit_lb[MATS + 1], opening_ft[MATS + 1];
    const struct advise_member *member = &members->member[m];
    struct mr_chain_params params = members->runway.chain;
    double at_ft = braking->touchdown_ft, v = braking->speed_ft_s, zone_ft = (double)NAN;
    params.friction_lb = (float)exp(member->unknown[ADVISE_UNKNOWN_FRICTION]);
    params.kl_lb_ft = (float)exp(member->unknown[ADVISE_UNKNOWN_STIFFNESS]);
    params.cl_lb_s_ft = (float)exp(member->unknown[ADVISE_UNKNOWN_DAMPING]);
    params.step_s = (float)step_s;
    for (unsigned j = 0; j <= MATS; j++)
        grit_lb[j] = (float)(exp(member->unknown[ADVISE_UNKNOWN_RESISTANCE]) *
                             (double)member->grit_ratio[j]);
    assert_int_equal(mr_chain_start(&chain, &params, 1, member->gap_ft, grit_lb), MR_OK);
    unsigned block = (unsigned)lround(1e-3 / step_s);
    for (unsigned step = 0; step < 8000 * block; step++) {
        double t_s = step * step_s, part = fmin(t_s / 0.06, 1.0);
        double a = part * part * (3.0 - 2.0 * part) * braking->mean_braking_ft_s2;
        bool on = v > 0.0 && at_ft < (double)MAT_FT * MATS;
        mr_chain_step(&chain, on ? (unsigned)(at_ft / (double)MAT_FT) + 1u : 1u,
                      on ? (float)(exp(member->unknown[ADVISE_UNKNOWN_THRUST_SHARE]) * 1300.0 /
                                   12.0 * a / 32.174)
                         : 0.0f);
        at_ft += fmax(v, 0.0) * step_s;
        v -= a * step_s;
        if (step % block == block - 1)
            assert_true(mr_chain_end_block(&chain));
        if (step % (50 * block) || !(v > 2.0))
            continue;
        for (unsigned j = 0; j <= MATS; j++)
            opening_ft[j] = mr_chain_opening_ft(&chain, j + 1);
        struct advise_zone zone = advise_find_longest_zone(opening_ft, MATS + 1,
                                                           (unsigned)ceil(at_ft / (double)MAT_FT));
        if (isnan(zone_ft) && zone.mat_count >= 50 && zone.first_mat * (double)MAT_FT - at_ft < 2.0)
            zone_ft = at_ft;
    }
    *moved_in = 12.0 * (double)mr_chain_displacement_ft(&chain, (unsigned)(15.0f / MAT_FT) + 1u);
    return zone_ft;
}

/* The step that members of a batch have: the largest whole part of a millisecond that is stable
 * for all eight. */
static double step_of(const struct advise_members *members, size_t batch)
{
    double limit_s = 1.0;
    for (size_t m = 8 * batch; m < 8 * batch + 8; m++) {
        struct mr_chain_params params = members->runway.chain;
        params.kl_lb_ft = (float)exp(members->member[m].unknown[ADVISE_UNKNOWN_STIFFNESS]);
        params.cl_lb_s_ft = (float)exp(members->member[m].unknown[ADVISE_UNKNOWN_DAMPING]);
        limit_s = fmin(limit_s, (double)mr_chain_step_limit_s(&params));
    }
    return 1e-3 / ceil(1e-3 / (0.98 * 0.9 * limit_s));
}

TEST(a_share_is_what_chains_alone_count)
{
    static struct advise_braking braking[COUNT];
    static struct advise_outcome met[COUNT];
    struct advise_members members;
    struct advise_plan plan = {.speed_ft_s = 18.0,
                               .speed_spread = 0.01,
                               .braking_spread = 0.1,
                               .mean_braking_ft_s2 = 6.0,
                               .touchdown_ft = 3.0,
                               .touchdown_spread_ft = 0.5,
                               .seed = 9};
    struct advise_runway runway = rig();
    struct advise_row row;
    unsigned events = 0, by_half = 0;
    double sum_in[MR_SEGMENTS];
    for (unsigned i = 0; i < MR_SEGMENTS; i++)
        sum_in[i] = 0.1;
    assert_int_equal(advise_members_draw(&members, &runway, COUNT, 1), MR_OK);
    advise_apply_survey(&members, sum_in, 0.0);
    assert_true(advise_compute_row(&members, &plan, 6.0, braking, met, &row));
    for (size_t m = 0; m < COUNT; m++) {
        double moved_in,
            zone_ft = play_alone(&members, m, &braking[m], step_of(&members, m / 8), &moved_in);
        assert_near((double)met[m].movement_in[1], moved_in, 1e-6);
        assert_int_equal(isnan(met[m].zone_station_ft), isnan(zone_ft));
        if (!isnan(zone_ft))
            assert_near((double)met[m].zone_station_ft, zone_ft, 1e-4);
        events += isnan(zone_ft) ? 0u : 1u;
        by_half += (unsigned)(zone_ft <= 0.5 * (double)MAT_FT * MATS);
    }
    print_message("%u of %u members come to a zone\n", events, COUNT);
    assert_true(events > 5 && events < COUNT - 5);
    assert_near(row.zone_share, (double)events / COUNT, 1e-12);
    assert_near(row.zone_probability_by_part[2].probability,
                advise_calibrate_share((double)by_half / COUNT, members.is_surveyed), 1e-12);
    advise_members_free(&members);
}

TEST(a_seed_says_the_same_whatever_the_threads)
{
    static struct advise_braking braking[COUNT];
    static struct advise_outcome met[3][COUNT];
    struct advise_plan plan = {
        .speed_ft_s = 15.0, .braking_spread = 0.1, .touchdown_ft = 3.0, .seed = 2};
    struct advise_runway runway = rig();
    struct advise_row row;
    for (unsigned i = 0; i < 3; i++) {
        struct advise_members members;
        assert_int_equal(advise_members_draw(&members, &runway, COUNT, i < 2 ? 4 : 5), MR_OK);
        members.thread_count = i ? 3 : 1;
        assert_true(advise_compute_row(&members, &plan, 5.0, braking, met[i], &row));
        advise_members_free(&members);
    }
    assert_memory_equal(met[0], met[1], sizeof met[0]);
    assert_memory_not_equal(met[0], met[2], sizeof met[0]);
}

TEST(a_survey_gives_the_sums)
{
    struct advise_members members;
    struct advise_runway runway = rig();
    double sum_in[MR_SEGMENTS];
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        sum_in[s] = s % 3 ? 0.02 * s : (double)NAN;
    assert_int_equal(advise_members_draw(&members, &runway, COUNT, 1), MR_OK);
    float was = members.member[5].gap_ft[3];
    advise_apply_survey(&members, sum_in, 0.0);
    assert_true(members.member[5].gap_ft[3] >= was && members.member[5].gap_ft[3] <= was);
    for (size_t m = 0; m < COUNT; m++) {
        for (unsigned s = 1; s < MATS / 10; s++) {
            double is_in = 0.0;
            for (unsigned j = 10 * s; j < 10 * s + 10; j++) {
                float gap_ft = members.member[m].gap_ft[j];
                assert_true(gap_ft >= 0.0f && gap_ft <= 0.002500001f);
                is_in += 12.0 * (double)gap_ft;
            }
            if (s % 3)
                assert_near(is_in, sum_in[s], 1e-6);
        }
    }
    advise_members_free(&members);
}

/* Newly laid: uniform up to 1.2 slacks and at most one slack, a mean of 0.7/1.2; resistance uniform
 * up to twice the mean. All other joints stay. */
TEST(a_repair_resets_its_joints)
{
    struct advise_members members;
    struct advise_runway runway = rig();
    double slack = (double)runway.chain.slack_ft, gap = 0.0, grit = 0.0;
    unsigned full = 0;
    assert_int_equal(advise_members_draw(&members, &runway, COUNT, 1), MR_OK);
    for (size_t m = 0; m < COUNT; m++)
        for (unsigned j = 0; j <= MATS; j++) {
            members.member[m].gap_ft[j] = -1.0f;
            members.member[m].grit_ratio[j] = 9.0f;
        }
    advise_redraw_joints(&members, 10, 19);
    for (size_t m = 0; m < COUNT; m++)
        for (unsigned j = 0; j <= MATS; j++) {
            double is = (double)members.member[m].gap_ft[j],
                   g = (double)members.member[m].grit_ratio[j];
            bool repaired = j >= 10 && j <= 19;
            assert_int_equal(repaired, is >= 0.0 && is <= slack * 1.000001);
            assert_int_equal(repaired, g >= 0.0 && g <= 2.0);
            gap += repaired ? is : 0.0;
            grit += repaired ? g : 0.0;
            full += is > 0.999999 * slack;
        }
    assert_near(gap / (10 * COUNT), slack * 0.7 / 1.2, 0.05 * slack);
    assert_near(grit / (10 * COUNT), 1.0, 0.1);
    assert_near((double)full / (10 * COUNT), 1.0 / 6.0, 0.06);
    advise_members_free(&members);
}

/* A twin: one member is the truth. What its readings teach lies nearer to it than what was drawn,
 * and is not without spread. */
TEST(a_landing_teaches)
{
    static struct advise_outcome met[8];
    struct advise_members truth, members;
    struct advise_runway runway = rig();
    struct advise_observation seen = {
        .braking = {.speed_ft_s = 18.0, .touchdown_ft = 3.0, .mean_braking_ft_s2 = 6.0},
        .movement_error_in = 0.003,
        .survey_error_in = 0.003};
    struct advise_braking braking[8];
    double before, spread_before, after, spread_after;
    assert_int_equal(advise_members_draw(&truth, &runway, 8, 77), MR_OK);
    assert_int_equal(advise_members_draw(&members, &runway, 128, 5), MR_OK);
    for (unsigned k = 0; k < 8; k++) {
        braking[k] = seen.braking;
        truth.member[k].unknown[ADVISE_UNKNOWN_THRUST_SHARE] = log(1.3);
        truth.member[k].unknown[ADVISE_UNKNOWN_FRICTION] = log(0.6 * 0.466);
        truth.member[k].unknown[ADVISE_UNKNOWN_RESISTANCE] = log(4.0);
    }
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        seen.survey_before_in[s] = 0.0;
        for (unsigned j = 10 * s; s < MATS / 10 && j < 10 * s + 10; j++)
            seen.survey_before_in[s] += 12.0 * (double)truth.member[0].gap_ft[j];
    }
    assert_true(advise_simulate(&truth, braking, true, met));
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        seen.movement_in[i] = (double)met[0].movement_in[i];
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        seen.survey_after_in[s] = (double)met[0].segment_sum_in[s];
    advise_parameter_moments(&members, ADVISE_UNKNOWN_RESISTANCE, &before, &spread_before);
    assert_true(advise_update(&members, &seen));
    advise_parameter_moments(&members, ADVISE_UNKNOWN_RESISTANCE, &after, &spread_after);
    print_message("resistance %.2f +- %.0f %%, then %.2f +- %.0f %%; true 4\n", before,
                  100.0 * spread_before, after, 100.0 * spread_after);
    assert_true(fabs(log(after / 4.0)) < fabs(log(before / 4.0)));
    assert_true(spread_after < spread_before);
    assert_true(spread_after > 0.09);
    advise_members_free(&truth);
    advise_members_free(&members);
}

TEST(parameters_without_sense_are_refused)
{
    struct advise_members members;
    struct advise_runway runway = rig();
    runway.chain.friction_lb = NAN;
    assert_int_equal(advise_members_draw(&members, &runway, COUNT, 1), MR_USAGE);
    advise_members_free(&members);
    runway = rig();
    runway.chain.mats = 0;
    assert_int_equal(advise_members_draw(&members, &runway, COUNT, 1), MR_USAGE);
    advise_members_free(&members);
}

/* --- the forecast --- */

/* Roots of |x - p| = z sqrt(x (1 - x) / n), which the interval is: of 0 in 10, z^2 / (10 + z^2);
 * for 5 in 10 symmetric about 0.5. */
TEST(wilsons_interval)
{
    struct proportion_interval half = compute_proportion_interval(5, 10),
                               none = compute_proportion_interval(0, 10);
    assert_near(half.low, 0.2365931, 1e-6);
    assert_near(half.high, 0.7634069, 1e-6);
    assert_near(none.low, 0.0, 1e-12);
    assert_near(none.high, 0.2775328, 1e-6);
}

TEST(probabilities_rise_with_shares)
{
    double last = 0.0;
    for (unsigned i = 0; i <= 64; i++) {
        double p = advise_calibrate_share(i / 64.0, true),
               unsurveyed = advise_calibrate_share(i / 64.0, false);
        assert_true(p > last && p < 1.0);
        assert_true(i < 33 || unsurveyed < p); /* less sure */
        last = p;
    }
}

/* The posterior integrated over a grid of mean and variance (the sums by another program). */
TEST(how_plans_are_met)
{
    static const double ratio[] = {0.10, 0.05, 0.20};
    double bias, spread;
    advise_predict_plan_deviation(NULL, 0, &bias, &spread);
    assert_near(bias, 0.0, 1e-15);
    assert_near(spread, 0.1, 1e-12);
    advise_predict_plan_deviation(ratio, 3, &bias, &spread);
    assert_near(bias, 0.05000, 1e-4);
    assert_near(spread, 0.10797, 1e-4);
}

TEST(harder_braking_stops_before_closed_mats)
{
    struct advise_row row[4] = {
        {.mean_braking_ft_s2 = 4.0, .zone_probability = {.probability = 0.1}},
        {.mean_braking_ft_s2 = 5.0, .zone_probability = {.probability = 0.3}},
        {.mean_braking_ft_s2 = 6.0, .zone_probability = {.probability = 0.6}},
        {.mean_braking_ft_s2 = 7.0, .zone_probability = {.probability = 0.1}}};
    assert_near(advise_find_stop_short_ft_s2(row, 4, 0.2), 7.0, 1e-12);
    assert_true(isnan(advise_find_stop_short_ft_s2(row, 4, 0.7)));
    assert_true(isnan(advise_find_stop_short_ft_s2(row, 3, 0.05)));
}

/* Of the same rows: up to where the first part is below, though the last row is again. */
TEST(the_hardest_braking)
{
    static const double mean_ft_s2[] = {4.0, 5.0, 6.0, 7.0};
    const struct advise_row row[4] = {{.zone_probability = {.probability = 0.1}},
                                      {.zone_probability = {.probability = 0.3}},
                                      {.zone_probability = {.probability = 0.6}},
                                      {.zone_probability = {.probability = 0.1}}};
    struct advise_limit_crossing hardest = advise_find_limit_crossing(mean_ft_s2, row, 4, 0.2);
    assert_near(hardest.value, 4.5, 1e-12);
    assert_false(hardest.is_unbounded);
    hardest = advise_find_limit_crossing(mean_ft_s2, row, 4, 0.7);
    assert_near(hardest.value, 7.0, 1e-12);
    assert_true(hardest.is_unbounded);
    assert_true(isnan(advise_find_limit_crossing(mean_ft_s2, row, 3, 0.05).value));
}

/* By hand, in proportion between rows. */
TEST(the_reach_and_its_interval)
{
    static const double x[] = {10.0, 20.0, 30.0};
    struct advise_row row[] = {
        {.zone_probability = {.probability = 0.1, .low = 0.05, .high = 0.15}},
        {.zone_probability = {.probability = 0.3, .low = 0.25, .high = 0.35}},
        {.zone_probability = {.probability = 0.6, .low = 0.55, .high = 0.65}}};
    struct advise_limit_crossing reach = advise_find_limit_crossing(x, row, 3, 0.2);
    assert_near(reach.value, 15.0, 1e-12);
    assert_near(reach.low, 12.5, 1e-12);
    assert_near(reach.high, 17.5, 1e-12);
    assert_false(reach.is_unbounded);
    assert_int_equal(advise_find_wide_row_step(x, row, 3, 0.2, 5.0), 0);
    assert_int_equal(advise_find_wide_row_step(x, row, 3, 0.32, 5.0), 1);
    assert_int_equal(advise_find_wide_row_step(x, row, 3, 0.2, 10.0), 3);
    reach = advise_find_limit_crossing(x, row, 3, 0.62); /* the upper end alone is beyond */
    assert_true(reach.is_unbounded && isnan(reach.high));
    assert_near(reach.value, 30.0, 1e-12);
    assert_near(reach.low, 29.0, 1e-12);
    reach = advise_find_limit_crossing(x, row, 3,
                                       0.12); /* the first row's upper end is not below */
    assert_near(reach.value, 11.0, 1e-12);
    assert_true(isnan(reach.low));
    reach = advise_find_limit_crossing(x, row, 3, 0.1);
    assert_true(isnan(reach.value) && !reach.is_unbounded);
    row[1].off_runway_share = 0.5; /* who rolls off is not below either */
    assert_near(advise_find_limit_crossing(x, row, 3, 0.2).value, 12.5, 1e-12);
}
