/* The laws of host/sim/elements: that a law's two shapes, for loops over mats and for one mat, have
 * the same bits; that located modes and sampled cases are one law; that slopes are those of the
 * forces. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "host/sim/elements/law.h"

#pragma GCC diagnostic ignored "-Wpsabi"
#define LANES_DOUBLE
#include "host/sim/elements/lanes.h"
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
    near(given.grit_extent_ft, 0.006, 1e-12);
    near(joint_pull(JOINT_GRIT, joint, -0.02, 0.0, grit).lb, -20.0, 1e-12);
}

#define LANES_FILE "tests/host/law_lanes.h"
#include "host/sim/elements/lanes_each.h"

/* On each kind of processor that this one can be. */
TEST(lanes_have_the_bits_of_one)
{
    lanes_agree_plain();
#if LANES_HAVE_AVX2
    if (__builtin_cpu_supports("avx2"))
        lanes_agree_avx2();
    if (LANES_CPU_HAS_AVX512)
        lanes_agree_avx512();
#endif
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
        same_bits(joint_mode_force_lb(&joint, true, mode, g_ft, rate), sampled.lb, "tension", g_ft);
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
        double up = friction_force_lb(SIM_FRICTION_TANH, c_lb, v + d, 0, tanh((v + d) / veps));
        double down = friction_force_lb(SIM_FRICTION_TANH, c_lb, v - d, 0, tanh((v - d) / veps));
        double share = friction_share(SIM_FRICTION_TANH, v, 0, tanh(v / veps));
        near(friction_slope_lb_s_ft(SIM_FRICTION_TANH, c_lb, share, veps), -(up - down) / (2.0 * d),
             1e-3 * c_lb / veps);
        assert_true(-friction_slope_lb_s_ft(SIM_FRICTION_TANH, c_lb, share, veps) / 5.0 <=
                    friction_rate_bound(SIM_FRICTION_TANH, c_lb, 5.0, veps).damping);
    }
    near(hinge_margin_rad(hinge_mode(0.3, 0.2), 0.3, 0.2), 0.1, 1e-15);
    near(hinge_margin_rad(hinge_mode(-0.1, 0.2), -0.1, 0.2), 0.1, 1e-15);
    /* on the ground, and leaving faster than it would push */
    assert_true(soil_contact_depth_ft(true, 1e7, 2e4, 1e-6, -1.0) < 0.0);
    assert_true(soil_contact_depth_ft(false, 1e7, 2e4, 0.0, -1.0) > 0.0);
}
