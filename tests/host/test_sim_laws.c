/* The laws of host/sim/elements: that a law's two shapes, for loops over mats and for one mat, have
 * the same bits; that located modes and sampled cases are one law; that slopes are those of the
 * forces. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "host/sim/elements/law.h"

#pragma GCC diagnostic ignored "-Wpsabi"
#define LANES_DOUBLE
#define LANES(name) name##_plain
#include "host/sim/elements/lanes.h"
#include "host/sim/elements/lanes_kernel.h"
#include "tests/cmocka_all.h"

#define DRAWS 400000

static uint64_t seed = 20;

static double uniform(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(seed >> 11) / 9007199254740992.0;
}

/* One of the edges of a law, or somewhere between and a little beyond. */
static double around(const double *edges, size_t count, double reach)
{
    double at = edges[(size_t)(uniform() * (double)count)];
    return uniform() < 0.3 ? at : at + reach * (2.0 * uniform() - 1.0);
}

static void same_bits(double a, double b, const char *what, double x)
{
    if (memcmp(&a, &b, sizeof a) != 0)
        fail_msg("%s at %.17g: %.17g is not %.17g", what, x, a, b);
}

static void near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.12g is not %.12g to %g", value, expected, tolerance);
}

/* README.md, "Chain and landings", in words: up to its grit an open joint holds, then it gives way
 * at that force and stays closed. */
TEST(grit_holds_and_gives_way)
{
    const struct law_joint joint = {1000.0, 0.0, 0.01};
    struct joint_grit grit = {10.0, 0.01, 0.008};
    assert_true(joint_pull(JOINT_GRIT, joint, 0.009, 0.0, grit).lb == 0.0);
    near(joint_pull(JOINT_GRIT, joint, 0.003, 0.0, grit).lb, -5.0, 1e-12);
    struct law_pull given = joint_pull(JOINT_GRIT, joint, -0.004, 0.0, grit);
    near(given.lb, -10.0, 1e-12);
    near(given.reach_ft, 0.006, 1e-12);
    near(joint_pull(JOINT_GRIT, joint, -0.02, 0.0, grit).lb, -20.0, 1e-12);
}

/* A vector and one number by itself come to the same bits, joint by joint and mat by mat. */
TEST(lanes_have_the_bits_of_one)
{
    const struct law_joint joint = {3000.0, 0.2, 0.004};
    const struct joint_plain all = {LAW_VALUE(3000.0), LAW_VALUE(0.2), LAW_VALUE(0.004)};
    for (int i = 0; i < DRAWS; i++) {
        lanes grit_lb, give_ft, reach_ft, g_ft, rate_ft_s, v_ft_s, x_lb, limit_lb;
        for (unsigned k = 0; k < LANES_COUNT; k++) {
            grit_lb[k] = uniform() < 0.2 ? 0.0 : 20.0 * uniform();
            give_ft[k] = grit_lb[k] / joint.kl_lb_ft;
            reach_ft[k] = uniform() < 0.2 ? 0.0 : 0.004 * uniform();
            const double edges[] = {0.0, joint.slack_ft, reach_ft[k], reach_ft[k] - give_ft[k],
                                    -give_ft[k]};
            g_ft[k] = around(edges, 5, 0.01);
            rate_ft_s[k] = uniform() < 0.3 ? 0.0 : 40.0 * uniform() - 20.0;
            v_ft_s[k] = uniform() < 0.3 ? 0.0 : 2.0 * uniform() - 1.0;
            limit_lb[k] = uniform() < 0.1 ? 0.0 : 3.0 * uniform();
            const double ends[] = {0.0, limit_lb[k], -limit_lb[k]};
            x_lb[k] = around(ends, 3, 4.0);
        }
        struct pull_plain pulls = joint_pull_plain(all, grit_lb, give_ft, reach_ft, g_ft,
                                                   rate_ft_s);
        struct slip_plain slips = mat_slip_plain(v_ft_s, x_lb, limit_lb, LAW_VALUE(0.3));
        for (unsigned k = 0; k < LANES_COUNT; k++) {
            struct law_pull pull = law_joint_pull(joint, grit_lb[k], give_ft[k], reach_ft[k],
                                                  g_ft[k], rate_ft_s[k]);
            struct law_slip slip = law_mat_slip(v_ft_s[k], x_lb[k], limit_lb[k], 0.3);
            assert_true(pull.lb == pulls.lb[k] && pull.reach_ft == pulls.reach_ft[k]);
            assert_true(slip.v_ft_s == slips.v_ft_s[k] && slip.stops == (slips.stops[k] != 0));
        }
    }
}

TEST(located_joints_are_sampled_ones)
{
    const struct law_joint joint = {3000.0, 0.2, 0.004};
    const double edges[] = {0.0, 0.004};
    for (int i = 0; i < DRAWS; i++) {
        double g_ft = around(edges, 2, 0.01), rate = 2.0 * uniform() - 1.0;
        signed char mode = joint_mode(g_ft, joint.slack_ft);
        struct law_pull sampled = joint_pull(JOINT_SLACK, joint, g_ft, rate,
                                             (struct joint_grit){0});
        same_bits(joint_located_lb(&joint, true, mode, g_ft, rate), sampled.lb, "tension", g_ft);
        assert_true(joint_margin_ft(mode, g_ft, joint.slack_ft, 0.0) >= 0.0);
        for (signed char other = -1; other <= 1; other++) { /* no other mode fits, but at an edge */
            if (other != mode && g_ft != 0.0 && g_ft != joint.slack_ft)
                assert_true(joint_margin_ft(other, g_ft, joint.slack_ft, 0.0) < 0.0);
        }
    }
}

TEST(slopes_are_those_of_the_forces)
{
    const double veps = 1e-3, c_lb = 80.0, d = 1e-9;
    for (double v = -3e-3; v < 3e-3; v += 1.7e-4) {
        double up = friction_rub_lb(SIM_TANH, c_lb, v + d, 0, tanh((v + d) / veps));
        double down = friction_rub_lb(SIM_TANH, c_lb, v - d, 0, tanh((v - d) / veps));
        double share = friction_share(SIM_TANH, v, 0, tanh(v / veps));
        near(friction_slope_lb_s_ft(SIM_TANH, c_lb, share, veps), -(up - down) / (2.0 * d),
             1e-3 * c_lb / veps);
        assert_true(-friction_slope_lb_s_ft(SIM_TANH, c_lb, share, veps) / 5.0 <=
                    friction_bound(SIM_TANH, c_lb, 5.0, veps).damping);
    }
    near(hinge_margin_rad(hinge_side(0.3, 0.2), 0.3, 0.2), 0.1, 1e-15);
    near(hinge_margin_rad(hinge_side(-0.1, 0.2), -0.1, 0.2), 0.1, 1e-15);
    /* on the ground, and leaving faster than it would push */
    assert_true(soil_touch_ft(true, 1e7, 2e4, 1e-6, -1.0) < 0.0);
    assert_true(soil_touch_ft(false, 1e7, 2e4, 0.0, -1.0) > 0.0);
}
