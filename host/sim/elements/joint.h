/* Joint: what two mats pull each other with along the runway. README.md, "Joint force" and "Chain
 * and landings".
 *
 * At opening g (ft, positive: open), tension positive:
 *   slack 0:   T = KL g + CL g'
 *   slack s:   g > s    KL (g - s) + CL g'        hooked
 *              g < 0    KL g + CL g'              pressed together
 *              between  0, or what grit gives
 *   grit G > 0 (with slack): a rigid-plastic stop at `reach`, the opening down to which the grit
 *   has been compacted. Rigid is as stiff as the joint itself: compression held = -KL (g - reach) -
 *   CL g', never below 0, never above G. When the spring's part exceeds G, reach moves towards
 *   closed and the joint transmits G while it closes; at reach = 0 the joint is closed and can
 *   transmit more. Up to G an open joint gives way by G/KL only (0.0004 in for 10 lb). Pulled open
 *   again: nothing resists, and reach goes along with the opening; to close it again takes G again.
 *   Loose grit is not carried away: it falls back into an opened joint. So a joint's state is its
 *   opening alone, and the final gaps are all that the next landing needs; the compression that
 *   grit still held at the end is dropped with it (G/KL).
 *
 * Sampled (joint_pull, joint_pull_one): the case is looked up from the opening; fixed steps,
 * solvers/chain.h and landing.h. Located (joint_located_lb): the case is a mode, which holds
 * while
 * joint_margin_ft is not negative; the planar models. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_JOINT_H
#define MATRIG_HOST_SIM_ELEMENTS_JOINT_H

#include <math.h>
#include <stdbool.h>

#include "host/sim/elements/law.h"

/* What the joints of a scene need; the least is evaluated. */
enum joint_law { JOINT_LINEAR, JOINT_SLACK, JOINT_GRIT };

/* Parameters that all joints share. */
struct joint {
    double kl_lb_ft, cl_lb_s_ft, slack_ft;
};

/* One joint's grit: the tension down to which grit holds it open (minus its grit), grit/KL, and
 * reach. */
struct joint_grit {
    double hold_lb, give_ft, reach_ft;
};

struct joint_pull {
    double lb;
    double reach_ft; /* from now on; with grit only */
};

LAW_INLINE enum joint_law joint_law(double slack_ft, bool gritty)
{
    return slack_ft <= 0.0 ? JOINT_LINEAR : gritty ? JOINT_GRIT : JOINT_SLACK;
}

/* Tension at opening g with the damper's part given. Nothing branches, so that a loop over joints
 * takes several at a time: all cases are computed, and the one that holds is picked. */
LAW_INLINE struct joint_pull joint_pull(enum joint_law law, const struct joint *joint, double g_ft,
                                        double damper_lb, struct joint_grit grit)
{
    const double kl = joint->kl_lb_ft, slack = joint->slack_ft;
    double pressed_lb = kl * g_ft + damper_lb;
    if (law == JOINT_LINEAR)
        return (struct joint_pull){pressed_lb, 0.0};
    double bare_lb = g_ft < 0.0 ? pressed_lb : 0.0;
    double hooked_lb = kl * (g_ft - slack) + damper_lb;
    if (law == JOINT_SLACK)
        return (struct joint_pull){g_ft > slack ? hooked_lb : bare_lb, 0.0};
    double r_ft = grit.reach_ft, hold_lb = grit.hold_lb;
    double held_lb = kl * (g_ft - r_ft);
    double yielded_ft = LAW_PICKED(law_most(0.0, g_ft + grit.give_ft));
    double kept_lb = LAW_PICKED(law_least(0.0, LAW_PICKED(law_most(hold_lb, held_lb + damper_lb))));
    double yielding_lb = LAW_PICKED(yielded_ft > 0.0 ? hold_lb : bare_lb);
    double gritty_lb = LAW_PICKED(held_lb < hold_lb ? yielding_lb : kept_lb);
    double gritty_ft = LAW_PICKED(held_lb < hold_lb ? yielded_ft : r_ft);
    double closing_lb = LAW_PICKED(r_ft > 0.0 ? gritty_lb : bare_lb);
    double closing_ft = LAW_PICKED(r_ft > 0.0 ? gritty_ft : 0.0);
    double free_lb = LAW_PICKED(g_ft >= r_ft ? 0.0 : closing_lb);
    return (struct joint_pull){g_ft > slack ? hooked_lb : free_lb,
                               law_least(slack, LAW_PICKED(law_most(g_ft, closing_ft)))};
}

/* The same bits for a joint by itself (tests/host/test_sim_laws.c): most joints are free, and need
 * the first lines only. */
LAW_INLINE struct joint_pull joint_pull_one(enum joint_law law, const struct joint *joint,
                                            double g_ft, double damper_lb, struct joint_grit grit)
{
    const double kl = joint->kl_lb_ft, slack = joint->slack_ft;
    if (law == JOINT_LINEAR)
        return (struct joint_pull){kl * g_ft + damper_lb, 0.0};
    if (g_ft > slack)
        return (struct joint_pull){kl * (g_ft - slack) + damper_lb, slack};
    double reach_ft = 0.0;
    if (law == JOINT_GRIT) {
        if (g_ft >= grit.reach_ft)
            return (struct joint_pull){0.0, g_ft};
        if (grit.reach_ft > 0.0) {
            double held_lb = kl * (g_ft - grit.reach_ft);
            if (!(held_lb < grit.hold_lb))
                return (struct joint_pull){
                    law_least(0.0, law_most(grit.hold_lb, held_lb + damper_lb)), grit.reach_ft};
            reach_ft = law_most(0.0, g_ft + grit.give_ft);
            if (reach_ft > 0.0)
                return (struct joint_pull){grit.hold_lb, reach_ft};
        }
    }
    return (struct joint_pull){g_ft < 0.0 ? kl * g_ft + damper_lb : 0.0, reach_ft};
}

/* How far down grit reaches in a joint that is opened by g at the start. */
LAW_INLINE double joint_first_reach_ft(double g_ft, double slack_ft)
{
    return fmin(fmax(g_ft, 0.0), slack_ft);
}

/* How far the spring is stretched (or pressed), for its energy. */
LAW_INLINE double joint_stretch_ft(enum joint_law law, double g_ft, double slack_ft,
                                   double reach_ft)
{
    if (law == JOINT_LINEAR)
        return g_ft;
    if (g_ft > slack_ft)
        return g_ft - slack_ft;
    return fmin(0.0, g_ft - (law == JOINT_GRIT ? reach_ft : 0.0));
}

/* Mode at opening g: -1 pressed, 0 open, 1 hooked. */
LAW_INLINE signed char joint_mode(double g_ft, double slack_ft)
{
    return g_ft < 0.0 ? -1 : g_ft > slack_ft ? 1 : 0;
}

/* Whether the joint transmits anything in its mode: its slopes are KL and CL then, 0 else. */
LAW_INLINE bool joint_transmits(bool slack, int mode)
{
    return !slack || mode != 0;
}

LAW_INLINE double joint_located_lb(const struct joint *joint, bool slack, int mode, double g_ft,
                                   double rate_ft_s)
{
    if (slack) {
        if (mode == 0)
            return 0.0;
        if (mode > 0)
            g_ft -= joint->slack_ft;
    }
    return joint->kl_lb_ft * g_ft + joint->cl_lb_s_ft * rate_ft_s;
}

/* How far a mode is from its end; a joint keeps its mode until `edge` beyond. */
LAW_INLINE double joint_margin_ft(int mode, double g_ft, double slack_ft, double edge_ft)
{
    if (mode < 0)
        return edge_ft - g_ft;
    return edge_ft + (mode > 0 ? g_ft - slack_ft : fmin(g_ft, slack_ft - g_ft));
}

/* A mat among equal ones, `joined` ends of springs at it and its neighbours: 4 in a chain, fewer
 * for a single mat. */
LAW_INLINE struct law_bound joint_bound(const struct joint *joint, double joined, double mass_slug)
{
    return (struct law_bound){joined * joint->kl_lb_ft / mass_slug,
                              joined * joint->cl_lb_s_ft / mass_slug};
}

#endif
