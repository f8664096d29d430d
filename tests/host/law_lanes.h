/* For test_sim_laws.c, for one kind of processor (lanes_each.h): a vector and one number by itself
 * come to the same bits, joint by joint and mat by mat. */
#include "host/sim/elements/lanes_kernel.h"

static void LANES(lanes_agree)(void)
{
    const struct law_joint joint = {3000.0, 0.2, 0.004};
    const struct LANES(joint) all = {LAW_VALUE(3000.0), LAW_VALUE(0.2), LAW_VALUE(0.004)};
    for (int i = 0; i < DRAWS; i++) {
        lanes grit_lb, grit_yield_ft, grit_extent_ft, g_ft, rate_ft_s, v_ft_s, x_lb, limit_lb;
        for (unsigned k = 0; k < LANES_COUNT; k++) {
            grit_lb[k] = uniform() < 0.2 ? 0.0 : 20.0 * uniform();
            grit_yield_ft[k] = grit_lb[k] / joint.kl_lb_ft;
            grit_extent_ft[k] = uniform() < 0.2 ? 0.0 : 0.004 * uniform();
            const double edges[] = {0.0, joint.slack_ft, grit_extent_ft[k],
                                    grit_extent_ft[k] - grit_yield_ft[k], -grit_yield_ft[k]};
            g_ft[k] = around(edges, 5, 0.01);
            rate_ft_s[k] = uniform() < 0.3 ? 0.0 : 40.0 * uniform() - 20.0;
            v_ft_s[k] = uniform() < 0.3 ? 0.0 : 2.0 * uniform() - 1.0;
            limit_lb[k] = uniform() < 0.1 ? 0.0 : 3.0 * uniform();
            const double ends[] = {0.0, limit_lb[k], -limit_lb[k]};
            x_lb[k] = around(ends, 3, 4.0);
        }
        struct LANES(pull)
            pulls = LANES(joint_pull)(all, grit_lb, grit_yield_ft, grit_extent_ft, g_ft, rate_ft_s);
        struct LANES(slip) slips = LANES(mat_slip)(v_ft_s, x_lb, limit_lb, LAW_VALUE(0.3));
        for (unsigned k = 0; k < LANES_COUNT; k++) {
            struct law_pull pull = law_joint_pull(joint, grit_lb[k], grit_yield_ft[k],
                                                  grit_extent_ft[k], g_ft[k], rate_ft_s[k]);
            struct law_slip slip = law_mat_slip(v_ft_s[k], x_lb[k], limit_lb[k], 0.3);
            assert_true(pull.lb == pulls.lb[k] && pull.grit_extent_ft == pulls.grit_extent_ft[k]);
            assert_true(slip.v_ft_s == slips.v_ft_s[k] &&
                        slip.stops == LANES(is_set)(slips.stops, (int)k));
        }
    }
}
