/* Law: the force of an element, written so that every engine can use it in its loops.
 *
 * Each law has four parts: the force; its derivatives (Jacobian); a bound of the rate that the law
 * adds, for the longest stable step; and a margin, the distance to a change of mode or to the start
 * of a mat's motion. A part of the scene with a positive margin need not be integrated. Functions
 * are inlined into loops over mats, and code that constant arguments exclude is removed by the
 * compiler. Units are ft, lb, s, slug and rad. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_LAW_H
#define MATRIG_HOST_SIM_ELEMENTS_LAW_H

#include <math.h>
#include <stdbool.h>

#include "host/sim/scene/scene.h"

/* Names for doubles, such as struct law_joint and law_mat_slip. Engines that compute with floats
 * define other names. */
#define LAW(name)                law_##name
#define LAW_REAL                 double
#define LAW_ABS(x)               fabs(x)
#define LAW_COPYSIGN(size, sign) copysign(size, sign)
#include "common/chain_law.h"

#define LAW_INLINE static inline __attribute__((always_inline))

/* Attribute of a function that is compiled for two kinds of processors, with bit-identical
 * results. */
/* Not with clang: the clones of clang 14 have names that callers do not use. */
#if defined __x86_64__ && !defined __clang__
#define TARGET_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define TARGET_CLONES
#endif

/* Bounds on the rates that a law adds to a mat: `rate_squared` is due to restoring forces, 1/s2;
 * `damping` to damping forces, 1/s. The bounds of several laws are added. */
struct law_rate_bound {
    double rate_squared, damping;
};

/* Faster than fmin and fmax, which are function calls because they must handle NaN. */
LAW_INLINE double law_min(double a, double b)
{
    return a < b ? a : b;
}

LAW_INLINE double law_max(double a, double b)
{
    return a > b ? a : b;
}

/* ---- joint ---- */

/* Joint: the force between two mats along the runway. README.md, "Joint force" and "Chain and
 * landings".
 *
 * There are two forms. joint_pull determines the case (pressed, open or hooked) from the opening at
 * each step; solvers with fixed steps use it (solvers/chain.h, landing.h). joint_mode_force_lb is
 * given the case as a mode, which is valid while joint_margin_ft is not negative; the planar models
 * use it. */

/* The joint laws, from the simplest to the most general. A scene uses the simplest law that covers
 * all its joints. */
enum joint_law { JOINT_LINEAR, JOINT_SLACK, JOINT_GRIT };

/* Grit (dirt) between the plates of one joint: its force, the compression (grit/KL) at which it
 * yields, and the depth to which it extends. */
struct joint_grit {
    double resistance_lb, yield_ft, grit_extent_ft;
};

LAW_INLINE enum joint_law joint_law(double slack_ft, bool gritty)
{
    return slack_ft <= 0.0 ? JOINT_LINEAR : gritty ? JOINT_GRIT : JOINT_SLACK;
}

LAW_INLINE struct law_pull joint_pull(enum joint_law law, struct law_joint joint, double g_ft,
                                      double rate_ft_s, struct joint_grit grit)
{
    if (law == JOINT_LINEAR)
        return law_pulled(joint.kl_lb_ft * g_ft + joint.cl_lb_s_ft * rate_ft_s, 0.0);
    if (law == JOINT_SLACK)
        grit = (struct joint_grit){0};
    return law_joint_pull(joint, grit.resistance_lb, grit.yield_ft, grit.grit_extent_ft, g_ft,
                          rate_ft_s);
}

/* Depth to which the grit initially extends in a joint with opening g. */
LAW_INLINE double joint_initial_grit_extent_ft(double g_ft, double slack_ft)
{
    return fmin(fmax(g_ft, 0.0), slack_ft);
}

/* Stretch (negative: compression) of the spring in a joint, for its elastic energy. */
LAW_INLINE double joint_stretch_ft(enum joint_law law, double g_ft, double slack_ft,
                                   double grit_extent_ft)
{
    if (law == JOINT_LINEAR)
        return g_ft;
    if (g_ft > slack_ft)
        return g_ft - slack_ft;
    return law_min(g_ft - (law == JOINT_GRIT ? grit_extent_ft : 0.0), 0.0);
}

/* Mode of a joint with opening g: -1 pressed, 0 open, 1 hooked. */
LAW_INLINE signed char joint_mode(double g_ft, double slack_ft)
{
    return g_ft < 0.0 ? -1 : g_ft > slack_ft ? 1 : 0;
}

/* True if a joint in this mode transmits force. The slopes of the force are then KL and CL,
 * otherwise 0. */
LAW_INLINE bool joint_can_transmit_force(bool slack, int mode)
{
    return !slack || mode != 0;
}

LAW_INLINE double joint_mode_force_lb(const struct law_joint *joint, bool slack, int mode,
                                      double g_ft, double rate_ft_s)
{
    if (slack) {
        if (mode == 0)
            return 0.0;
        if (mode > 0)
            g_ft -= joint->slack_ft;
    }
    return joint->kl_lb_ft * g_ft + joint->cl_lb_s_ft * rate_ft_s;
}

/* Distance of a joint from the end of its mode. The mode ends only when the joint is `edge_ft` past
 * that point. */
LAW_INLINE double joint_margin_ft(int mode, double g_ft, double slack_ft, double edge_ft)
{
    if (mode < 0)
        return edge_ft - g_ft;
    return edge_ft + (mode > 0 ? g_ft - slack_ft : fmin(g_ft, slack_ft - g_ft));
}

/* Bound for a mat in a row of equal mats. `joined`: number of spring ends at the mat and its
 * neighbours; 4 in a chain, fewer for a single mat. */
LAW_INLINE struct law_rate_bound joint_rate_bound(const struct law_joint *joint, double joined,
                                                  double mass_slug)
{
    return (struct law_rate_bound){joined * joint->kl_lb_ft / mass_slug,
                                   joined * joint->cl_lb_s_ft / mass_slug};
}

/* Extension of the spring of a joint without grit; negative: compression. */
LAW_INLINE double law_spring_extension_ft(double g_ft, double slack_ft)
{
    return g_ft < 0.0 ? g_ft : law_max(0.0, g_ft - slack_ft);
}

/* Relative speed for a joint's damper, averaged over a step. Only the part of the last step in
 * which the joint was closed counts. Without this weighting, the damper would act during the whole
 * step in which the joint closes, or not at all, and the error of its impulse would not decrease
 * with the step size. */
LAW_INLINE double law_damper_speed_ft_s(double g_ft, double rate_ft_s, double slack_ft,
                                        double step_s)
{
    double now_ft = law_spring_extension_ft(g_ft, slack_ft),
           before_ft = law_spring_extension_ft(g_ft - rate_ft_s * step_s, slack_ft);
    return now_ft * before_ft > 0.0 ? rate_ft_s : (now_ft - before_ft) / step_s;
}

/* ---- hinge ---- */

/* Hinge: the moment between two mats that are turned by d relative to each other. README.md, "Joint
 * moment". There is no moment while |d| is at most TAD. Beyond it, the moment is KT (d - TAD sgn d)
 * + CT d' with torsion `deadband`, KT d + CT d' with `switched`. */

/* Mode of a hinge that is turned by d: the sign of d if |d| is above TAD, otherwise 0. */
LAW_INLINE signed char hinge_mode(double angle_rad, double tad_rad)
{
    return angle_rad > tad_rad ? 1 : angle_rad < -tad_rad ? -1 : 0;
}

/* The angle that causes the moment: d, or the part of d beyond the free rotation TAD. */
LAW_INLINE double hinge_effective_angle_rad(bool jumps, int side, double angle_rad, double tad_rad)
{
    if (!jumps)
        angle_rad -= tad_rad * side;
    return angle_rad;
}

/* Moment of an engaged hinge; its slopes are KT and CT. */
LAW_INLINE double hinge_moment_lb_ft(double kt, double ct, double angle_rad, double rate_rad_s)
{
    return kt * angle_rad + ct * rate_rad_s;
}

LAW_INLINE double hinge_margin_rad(int side, double angle_rad, double tad_rad)
{
    return side ? side * angle_rad - tad_rad : tad_rad - fabs(angle_rad);
}

/* ---- soil ---- */

/* Soil: the force under a foot of a mat at depth Y (positive down). README.md, "Report model" and
 * "Consistent model". In contact it is KV Y + CV Y', with slopes KV and CV, otherwise 0. In the
 * report model a foot is in contact below SOIL_TOUCH_FT above the ground, and the soil may pull it;
 * in the consistent model the soil only pushes. The fastest rate is that of a mat's end on KV and
 * CV, from the linearised model (model_fastest_rate), because the mass that a foot moves depends on
 * the neighbouring mats. */

/* In ft. Flat mats are at height 0 except for rounding errors, so a smaller lift is ignored. */
#define SOIL_TOUCH_FT 1e-9

LAW_INLINE double soil_force_lb(double kv, double cv, double y_ft, double rate_ft_s)
{
    return kv * y_ft + cv * rate_ft_s;
}

/* Depth of a foot; positive if the soil acts on it. */
LAW_INLINE double soil_contact_depth_ft(bool pushes_only, double kv, double cv, double y_ft,
                                        double rate_ft_s)
{
    if (!pushes_only)
        return y_ft + SOIL_TOUCH_FT;
    return fmin(y_ft, y_ft + cv / kv * rate_ft_s);
}

LAW_INLINE double soil_margin_ft(bool contact, double touch_ft)
{
    return contact ? touch_ft : -touch_ft;
}

/* ---- friction ---- */

/* Friction: Coulomb friction of a mat on the ground, with the limit C = f N. README.md, "Friction".
 * It acts along the runway and causes no moment.
 *
 * In continuous time (friction_force_lb) a mat slides in one direction or sticks. In a step with
 * constant force, the law `stick` is solved exactly (friction_speed_ft_s). The holding force of a
 * cleat is added to C. */

/* Friction force divided by C; positive if it acts against a positive speed. `slide`: direction of
 * sliding, for law stick. `smooth`: tanh(speed / veps), for law tanh. */
LAW_INLINE double friction_share(enum sim_friction law, double v_ft_s, int slide, double smooth)
{
    switch (law) {
    case SIM_FRICTION_STICK: return slide;
    case SIM_FRICTION_TANH: return smooth;
    case SIM_FRICTION_SIGN: return v_ft_s > 0.0 ? 1.0 : v_ft_s < 0.0 ? -1.0 : 0.0;
    case SIM_FRICTION_NONE: break;
    }
    return 0.0;
}

/* Friction force on a moving mat, to be subtracted from the other forces. */
LAW_INLINE double friction_force_lb(enum sim_friction law, double c_lb, double v_ft_s, int slide,
                                    double smooth)
{
    switch (law) {
    case SIM_FRICTION_STICK: return slide * c_lb;
    case SIM_FRICTION_TANH: return c_lb * smooth;
    case SIM_FRICTION_SIGN: return v_ft_s == 0.0 ? 0.0 : copysign(c_lb, v_ft_s);
    case SIM_FRICTION_NONE: break;
    }
    return 0.0;
}

/* Derivative of the friction force with respect to the speed. */
LAW_INLINE double friction_slope_lb_s_ft(enum sim_friction law, double c_lb, double share,
                                         double veps_ft_s)
{
    return law == SIM_FRICTION_TANH ? -c_lb * (1.0 - share * share) / veps_ft_s : 0.0;
}

/* Returns the force by which the push on a mat at rest may increase before the mat slides. */
LAW_INLINE double friction_margin_lb(double c_lb, double push_lb)
{
    return c_lb - fabs(push_lb);
}

/* Bound from the largest slope of the force, which only the law tanh has. */
LAW_INLINE struct law_rate_bound friction_rate_bound(enum sim_friction law, double c_lb,
                                                     double mass_slug, double veps_ft_s)
{
    return (struct law_rate_bound){0.0,
                                   law == SIM_FRICTION_TANH ? c_lb / (mass_slug * veps_ft_s) : 0.0};
}

/* Returns the speed, after the time h, of a mat with speed v under the force x and the Coulomb
 * limit c. A mat at rest stays at rest while |x| <= c; a mat whose speed reaches 0 within h is
 * tested again at that time. `stops` is incremented at each stop. */
LAW_INLINE double friction_speed_ft_s(double v_ft_s, double x_lb, double c_lb, double h_s,
                                      double mass_slug, unsigned *stops)
{
    struct law_slip slip = law_mat_slip(v_ft_s, x_lb, c_lb, h_s / mass_slug);
    *stops += slip.stops;
    return slip.v_ft_s;
}

#endif
