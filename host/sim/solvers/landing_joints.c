#include "host/sim/models/kernel.h"
#include "host/sim/solvers/landing_engine.h"

/* Tension of a joint at opening g; the law of chain.h. */
static inline double joint_lb(struct landing *l, int j, double g_ft, double damper_lb)
{
    const struct model *m = &l->model;
    if (l->slack_ft <= 0.0)
        return m->kl * g_ft + damper_lb;
    if (g_ft > l->slack_ft) {
        l->reach_ft[j] = l->slack_ft;
        return m->kl * (g_ft - l->slack_ft) + damper_lb;
    }
    if (l->gritty) {
        double reach_ft = l->reach_ft[j], grit_lb = l->grit_lb[j];
        if (g_ft >= reach_ft) {
            l->reach_ft[j] = g_ft;
            return 0.0;
        }
        if (reach_ft > 0.0) {
            double held_lb = m->kl * (g_ft - reach_ft);
            if (held_lb >= -grit_lb) {
                double sum = held_lb + damper_lb;
                return sum > 0.0 ? 0.0 : sum < -grit_lb ? -grit_lb : sum;
            }
            reach_ft = g_ft + grit_lb / m->kl;
            l->reach_ft[j] = reach_ft = reach_ft > 0.0 ? reach_ft : 0.0;
            if (reach_ft > 0.0)
                return -grit_lb;
        }
    }
    return g_ft < 0.0 ? m->kl * g_ft + damper_lb : 0.0;
}

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
    struct kernel_mat mat = m->tilt_ft ? kernel_tilted_mat(m, p, v, n, 1.0 / m->length_ft)
                                       : kernel_mat(p, v, n, 1.0 / m->length_ft);
    return (struct shortening){m->half_ft * (l->rest_cos[n] - mat.c), m->half_ft * mat.w * mat.s};
}

void landing_stretch_joints(struct landing *l)
{
    const struct model *m = &l->model;
    const double *p = l->z, *v = l->z + m->size;
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
        double g = l->gap0_ft[j] + (u_r - u_l) + left.ft + right.ft, rate = v_r - v_l + left.ft_s + right.ft_s;
        double t_lb = joint_lb(l, j, g, m->cl * rate);
        l->tension_lb[j] = t_lb;
        l->pull_lb[j] = t_lb > l->pull_lb[j] ? t_lb : l->pull_lb[j];
        l->push_lb[j] = -t_lb > l->push_lb[j] ? -t_lb : l->push_lb[j];
    }
    if (l->mods && l->mods->jointed) {
        struct mods_view view = {p, v, 2, -1, l->tension_lb, 1};
        mods_pull_joints(l->mods, &view, l->slides.first + 1, l->slides.last + 2);
    }
}
