#include <math.h>

#include "host/sim/models/kernel.h"
#include "host/sim/solvers/landing_engine.h"

/* What a mat's turning takes from its length on either side, and its rate. */
struct shortening {
    double ft, ft_s;
};

static inline struct shortening shortening_of(const struct landing *l, int n)
{
    const struct model *m = &l->model;
    if (!m->full || n < l->heaves.first || n > l->heaves.last)
        return (struct shortening){0.0, 0.0};
    const double *p = l->z, *v = l->z + m->size;
    struct kernel_mat mat = l->parting ? kernel_parted_mat(m, p, v, n, 1.0 / m->length_ft)
                          : m->tilt_ft ? kernel_tilted_mat(m, p, v, n, 1.0 / m->length_ft)
                                       : kernel_mat(p, v, n, 1.0 / m->length_ft);
    return (struct shortening){m->half_ft * (l->rest_cos[n] - mat.c), m->half_ft * mat.w * mat.s};
}

/* The rate that a joint's damper has, when the joint was open a step ago: what of the step it was
 * closed for has moved it, not the whole step. Else the damper brakes what lies before its slack,
 * by the same amount at every step that is longer than that. */
LAW_INLINE double damped_rate_ft_s(double g_ft, double rate_ft_s, double slack_ft, double step_s)
{
    double over_ft = g_ft < 0.0 ? g_ft : fmax(0.0, g_ft - slack_ft);
    bool closing = over_ft * rate_ft_s > 0.0;
    return closing && fabs(over_ft) < fabs(rate_ft_s) * step_s ? over_ft / step_s : rate_ft_s;
}

/* What of a joint's force passes where mats come apart: nothing beside a mat that was pushed over,
 * and compression alone where it is torn. The runway's ends tear too, and have one mat. */
static double passed_lb(const struct landing *l, int j, double g_ft, double t_lb)
{
    struct parting *p = l->parting;
    if (p->gone[j] || (p->apart[j] && !parting_abuts(p, j, g_ft, l->z[2 * j])))
        return 0.0;
    return p->apart[j] || mods_is_torn(l->mods, j + 1) ? fmin(0.0, t_lb) : t_lb;
}

LAW_INLINE void stretch(struct landing *l, enum joint_law law, bool parts)
{
    const struct model *m = &l->model;
    const double *p = l->z, *v = l->z + m->size;
    const struct joint joint = {m->kl, m->cl, l->slack_ft};
    struct shortening left, right = shortening_of(l, l->slides.first - 1);
    for (int j = l->slides.first; j <= l->slides.last + 1; j++) {
        left = right; /* also past an end that pulls nothing */
        right = shortening_of(l, j);
        if ((j == 0 && m->left_free) || (j == m->mats && m->right_free)) {
            l->tension_lb[j] = 0.0;
            continue;
        }
        double u_l = j > 0 ? p[2 * j - 1] : 0.0, u_r = j < m->mats ? p[2 * j + 1] : 0.0;
        double v_l = j > 0 ? v[2 * j - 1] : 0.0, v_r = j < m->mats ? v[2 * j + 1] : 0.0;
        double g = l->gap0_ft[j] + (u_r - u_l) + left.ft + right.ft,
               rate = v_r - v_l + left.ft_s + right.ft_s;
        if (law == JOINT_SLACK && l->closing_step_s > 0.0)
            rate = damped_rate_ft_s(g, rate, l->slack_ft, l->closing_step_s);
        struct joint_grit grit = {l->hold_lb[j], l->give_ft[j], l->reach_ft[j]};
        struct joint_pull pulled = joint_pull_one(law, &joint, g, joint.cl_lb_s_ft * rate, grit);
        double t_lb = pulled.lb;
        if (parts)
            t_lb = passed_lb(l, j, g, t_lb);
        if (law == JOINT_GRIT)
            l->reach_ft[j] = pulled.reach_ft;
        l->tension_lb[j] = t_lb;
        l->pull_lb[j] = t_lb > l->pull_lb[j] ? t_lb : l->pull_lb[j];
        l->push_lb[j] = -t_lb > l->push_lb[j] ? -t_lb : l->push_lb[j];
    }
}

/* Every law that occurs gets a loop of its own. */
LAW_INLINE void stretch_all(struct landing *l, bool parts)
{
    if (l->joints == JOINT_LINEAR)
        stretch(l, JOINT_LINEAR, parts);
    else if (l->joints == JOINT_SLACK)
        stretch(l, JOINT_SLACK, parts);
    else
        stretch(l, JOINT_GRIT, parts);
}

static __attribute__((noinline)) void stretch_parted(struct landing *l)
{
    stretch_all(l, true);
}

void landing_stretch_joints(struct landing *l)
{
    if (l->parting)
        stretch_parted(l);
    else
        stretch_all(l, false);
    if (l->mods && l->mods->jointed) {
        struct mods_view view = landing_view(l);
        mods_pull_joints(l->mods, &view, l->slides.first + 1, l->slides.last + 2);
    }
}
