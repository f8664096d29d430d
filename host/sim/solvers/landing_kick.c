#include <math.h>

#include "host/sim/models/kernel.h"
#include "host/sim/solvers/landing_engine.h"
#include "host/sim/elements/friction.h"

/* times that a step is taken again as the soil lets go of nodes or holds others */
#define MOST_CONTACTS 8

/* Bands and cleats before a kick; a riveted mat that its band moves is taken in. */
void landing_brace_slides(struct landing *l, const struct sim_touch *touch, int count, double h_s)
{
    struct mods *mods = l->mods;
    const struct model *m = &l->model;
    struct mods_view view = landing_view(l);
    if (mods->cleated) {
        mods_press_cleats(mods, touch, count);
        mods_wear_cleats(mods, &view, h_s, l->slides.first + 1, l->slides.last + 1);
    }
    if (!mods->banded)
        return;
    mods_pull_bands(mods, &view, touch, count);
    for (int c = 0; c < mods->braces; c++) {
        int n = mods->brace_mat[c] - 1;
        double push_lb = l->tension_lb[n + 1] - l->tension_lb[n] + mods->carried_lb[c];
        double limit_lb = m->law == SIM_NONE ? 0.0
                                             : m->weight_limit_lb + mods_cleat_lb(mods, n + 1);
        if ((n < l->slides.first || n > l->slides.last) && fabs(push_lb) > limit_lb)
            landing_take_in(&l->slides, m, n - 1, n + 1);
    }
}

/* The bands hold waves down, and stiffeners bend: forces on nodes and moments on joints of the
 * heaving part. */
void landing_brace_heaves(struct landing *l)
{
    const struct model *m = &l->model;
    struct mods_heave heave = {.z = l->z,
                               .tilt_ft = m->tilt_ft,
                               .ground_ft = l->scene->ground_ft.values,
                               .mats = m->mats,
                               .length_ft = m->length_ft,
                               .rest_y_ft = m->rest_y_ft,
                               .first = l->heaves.first,
                               .last = l->heaves.last,
                               .down_lb = l->brace_lb,
                               .moment_lb_ft = l->brace_lb_ft};
    mods_brace_heave(l->mods, &heave);
}

double landing_soil_lb(const struct model *m, const double *z, int node)
{
    return kernel_soil_lb(m, z, z + m->size, node);
}

/* What the soil pushes a node with while its mats are kicked, in a step in parts and in the one
 * after it. */
static double rubbing_lb(const struct landing *l, int node)
{
    if (l->in_parts)
        return l->rub_lb[node];
    double now_lb = fmax(0.0, landing_soil_lb(&l->model, l->z, node));
    bool known = node >= l->rub_first && node <= l->rub_last;
    return known ? l->rub_next_lb[node] + l->rub_share * now_lb : now_lb;
}

/* What the soil holds a heaving mat with: the reaction that its nodes have just been kicked with,
 * dampers at the end of the step. A foot that lands faster than the step can follow so rubs with
 * the impulse it lands with. */
static double soil_limit_lb(const struct landing *l, int n)
{
    const struct model *m = &l->model;
    const double *z = l->z;
    if (l->in_parts || l->rub_share < 1.0)
        return m->friction * (rubbing_lb(l, n) + rubbing_lb(l, n + 1));
    const double *v = z + m->size;
    const struct parting *parting = m->parting;
    double right_lb = !parting || !parting->apart[n + 1] ? kernel_soil_lb(m, z, v, n + 1)
                    : parting->contact[n + 1]
                        ? soil_lb(m->kv, m->cv, parting->y_ft[n + 1], parting->v_ft_s[n + 1])
                        : 0.0;
    return m->friction * (fmax(0.0, kernel_soil_lb(m, z, v, n)) + fmax(0.0, right_lb));
}

/* A mat under the gear: the ground holds it, up to the Coulomb limit of its load beside its own. */
static void ride(struct landing *l, int n, double thrust_lb, double limit_lb, double h_s)
{
    const struct model *m = &l->model;
    const struct gear *gear = l->gear;
    double *v = &l->z[m->size + 2 * n + 1];
    bool grounded = n < l->heaves.first || n > l->heaves.last || m->contact[n] || m->contact[n + 1];
    struct element_step step = element_step(&gear->others, (struct element_mat){*v, grounded}, h_s,
                                            m->mass_slug);
    if (!m->soil_normal && m->law != SIM_NONE)
        limit_lb += m->friction * l->scene->wheel_load_lb * gear->share[n + 1];
    *v = gear_speed_ft_s(l->gear, n + 1, step.keep * *v, thrust_lb + step.push_lb, limit_lb,
                         step.as_if_s);
}

KERNEL_INLINE unsigned kick(struct landing *l, const struct sim_touch *touch, int count, double h_s,
                            bool cleated, bool elements, bool geared)
{
    const struct model *m = &l->model;
    double *v = l->z + m->size, *thrust = l->u; /* spare until outputs are taken */
    unsigned stops = 0;
    for (int n = l->slides.first; n <= l->slides.last; n++)
        thrust[n] = l->tension_lb[n + 1] - l->tension_lb[n];
    for (int i = 0; i < count; i++)
        thrust[touch[i].mat - 1] += touch[i].thrust_lb;
    for (int c = 0; l->mods && c < l->mods->braces; c++)
        /* those outside are not looked at */
        thrust[l->mods->brace_mat[c] - 1] += l->mods->carried_lb[c];
    for (int n = l->slides.first; n <= l->slides.last; n++) {
        double limit = m->weight_limit_lb;
        if (m->soil_normal && n >= l->heaves.first && n <= l->heaves.last)
            limit = soil_limit_lb(l, n);
        for (int i = 0; i < count && !m->soil_normal && m->wheel_load_lb > 0.0; i++) {
            if (touch[i].mat - 1 == n)
                limit += m->friction * m->wheel_load_lb * touch[i].load_share;
        }
        if (cleated)
            limit += mods_raised_cleat_lb(l->mods, n + 1, l->z[2 * n], l->z[2 * n + 2]);
        if (m->law == SIM_NONE)
            limit = 0.0;
        if (geared && l->gear->share[n + 1] > 0.0) {
            ride(l, n, thrust[n], limit, h_s);
        } else if (elements) {
            struct element_mat mat = {v[2 * n + 1], n < l->heaves.first || n > l->heaves.last ||
                                                        m->contact[n] || m->contact[n + 1]};
            struct element_step step = element_step(geared ? &l->gear->others : &m->elements, mat,
                                                    h_s, m->mass_slug);
            v[2 * n + 1] = friction_speed_ft_s(step.keep * mat.v_ft_s, thrust[n] + step.push_lb,
                                               limit, step.as_if_s, m->mass_slug, &stops);
        } else {
            v[2 * n + 1] = friction_speed_ft_s(v[2 * n + 1], thrust[n], limit, h_s, m->mass_slug,
                                               &stops);
        }
    }
    return stops;
}

static __attribute__((noinline)) unsigned kick_geared(struct landing *l,
                                                      const struct sim_touch *touch, int count,
                                                      double h_s, bool cleated)
{
    model_ride(&l->model, l->gear->lead_mat - 1); /* whose waves are noted */
    if (l->gear->others.count > 0)
        return cleated ? kick(l, touch, count, h_s, true, true, true)
                       : kick(l, touch, count, h_s, false, true, true);
    return cleated ? kick(l, touch, count, h_s, true, false, true)
                   : kick(l, touch, count, h_s, false, false, true);
}

/* Runways without cleats get a loop without, and so do those without elements. */
unsigned landing_kick_slides(struct landing *l, const struct sim_touch *touch, int count,
                             double h_s)
{
    bool cleated = l->mods && l->mods->cleated;
    if (l->model.elements.count > 0 && l->gear)
        return kick_geared(l, touch, count, h_s, cleated);
    if (l->model.elements.count > 0)
        return cleated ? kick(l, touch, count, h_s, true, true, false)
                       : kick(l, touch, count, h_s, false, true, false);
    return cleated ? kick(l, touch, count, h_s, true, false, false)
                   : kick(l, touch, count, h_s, false, false, false);
}

/* The soil pushes and never pulls, at the end of the step: let go of nodes that it would pull, hold
 * those that it would push. True when a node has changed. */
static bool settle_contacts(struct landing *l, double h_s)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->size;
    bool changed = false;
    for (int j = m->first; j <= m->last + 1; j++) {
        double y_ft = l->z[2 * j];
        bool pushed = y_ft > 0.0 && m->kv * y_ft + m->cv * (v[2 * j] + h_s * l->accel[2 * j]) > 0.0;
        changed = changed || pushed != m->contact[j];
        m->contact[j] = pushed;
    }
    if (l->parting)
        changed = landing_settle_ends(l, h_s) || changed;
    return changed;
}

double landing_kick_heaves(struct landing *l, double h_s)
{
    const struct model *m = &l->model;
    double *v = l->z + m->size;
    consistent_heave(m, h_s, l->z, l->accel);
    for (int i = 0; i < MOST_CONTACTS && settle_contacts(l, h_s); i++)
        consistent_heave(m, h_s, l->z, l->accel);
    double jolt_ft_s = 0.0;
    for (int j = m->first; j <= m->last + 1; j++) {
        double change_ft_s = h_s * l->accel[2 * j];
        v[2 * j] += change_ft_s;
        if (m->contact[j] && fabs(change_ft_s) > jolt_ft_s)
            jolt_ft_s = fabs(change_ft_s);
    }
    return l->parting ? fmax(jolt_ft_s, landing_kick_ends(l, h_s)) : jolt_ft_s;
}
