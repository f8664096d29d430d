#include <math.h>

#include "host/sim/elements/hinge.h"
#include "host/sim/solvers/landing_engine.h"

#define DEGREES (180.0 / 3.14159265358979323846)

/* How far joint j is turned; upwards (^) positive. */
static double turn_rad(const struct landing *l, int j)
{
    double left = j - 1 >= l->heaves.first ? landing_slope(l, j - 1) : 0.0;
    double right = j <= l->heaves.last ? landing_slope(l, j) : 0.0;
    return fabs(left) < 1.0 && fabs(right) < 1.0 ? asin(right) - asin(left) : 0.0;
}

static void part(struct landing *l, int j)
{
    const double *v = l->z + l->model.size;
    parting_part(l->parting, j, l->z[2 * j], v[2 * j]);
}

/* A line of stiffeners that is riveted on both sides of a joint holds it. */
static bool held_by_line(const struct mods *mods, int j)
{
    return mods->stiffened &&
           (mods->spring_lb_ft[j + 1] > 0.0 || mods->turn_lb_ft_rad[j + 1] > 0.0);
}

void landing_part_joints(struct landing *l, double t_s)
{
    struct parting *parting = l->parting;
    struct mods_state *state = l->mods->state;
    const struct model *m = &l->model;
    for (int j = l->slides.first > 0 ? l->slides.first : 1; j <= l->slides.last + 1 && j < m->mats;
         j++) {
        if (state->torn[j + 1] != 0.0)
            part(l, j);
    }
    for (int j = l->heaves.first + 1; j <= l->heaves.last; j++) {
        if (parting->apart[j] || turn_rad(l, j) > -parting->unhinge_rad || held_by_line(l->mods, j))
            continue;
        part(l, j);
        state->torn[j + 1] = 1.0;
        state->unhinged_s[j + 1] = t_s;
        l->tension_lb[j] = fmin(0.0, l->tension_lb[j]);
    }
}

void landing_shape_ends(struct landing *l)
{
    struct model *m = &l->model;
    for (int j = m->first; j <= m->last + 1; j++) {
        if (m->torsion[j] && turn_rad(l, j) <= 0.0)
            m->torsion[j] = 0; /* downwards it turns freely until it parts */
    }
    for (int i = 0; i < l->parting->count; i++) {
        int j = l->parting->joint[i];
        l->parting->contact[j] = l->parting->y_ft[j] > 0.0;
        if (j < m->first || j > m->last + 1)
            continue;
        m->torsion[j] = 0;
        if (j - 1 > m->first && !l->parting->apart[j - 1] && (m->kt > 0.0 || m->ct > 0.0))
            m->torsion[j - 1] = hinge_side(turn_rad(l, j - 1), m->tad_rad) > 0;
    }
}

/* Ends on the outermost nodes are held, as those are. */
static bool within(const struct model *m, int joint)
{
    return joint > m->first && joint <= m->last;
}

bool landing_settle_ends(struct landing *l, double h_s)
{
    const struct model *m = &l->model;
    struct parting *p = l->parting;
    bool changed = false;
    for (int i = 0; i < p->count; i++) {
        int j = p->joint[i];
        if (!within(m, j))
            continue;
        bool pushed = p->y_ft[j] > 0.0 &&
                      m->kv * p->y_ft[j] + m->cv * (p->v_ft_s[j] + h_s * p->accel[j]) > 0.0;
        changed = changed || pushed != p->contact[j];
        p->contact[j] = pushed;
    }
    return changed;
}

double landing_kick_ends(struct landing *l, double h_s)
{
    struct parting *p = l->parting;
    double jolt_ft_s = 0.0;
    for (int i = 0; i < p->count; i++) {
        int j = p->joint[i];
        if (!within(&l->model, j))
            continue;
        p->v_ft_s[j] += h_s * p->accel[j];
        if (p->contact[j])
            jolt_ft_s = fmax(jolt_ft_s, fabs(h_s * p->accel[j]));
    }
    return jolt_ft_s;
}

void landing_move_ends(struct landing *l, double h_s)
{
    for (int i = 0; i < l->parting->count; i++) {
        int j = l->parting->joint[i];
        if (within(&l->model, j))
            l->parting->y_ft[j] += h_s * l->parting->v_ft_s[j];
    }
}

double landing_worst_angle_deg(const struct landing *l, int *mat_from_1)
{
    double worst = 0.0;
    *mat_from_1 = 1;
    for (int n = l->heaves.first; n <= l->heaves.last; n++) {
        double s = fabs(landing_slope(l, n));
        if (!(s <= worst)) {
            worst = s;
            *mat_from_1 = n + 1;
        }
    }
    return worst < 1.0 ? asin(worst) * DEGREES : worst >= 1.0 ? 90.0 : worst;
}

/* What the wheels push over no longer takes part: it lies flat, and its neighbours' ends are
 * free. */
bool landing_topple(struct landing *l, int n, double t_s)
{
    const struct model *m = &l->model;
    struct parting *p = l->parting;
    struct mods_state *state = l->mods->state;
    double *v = l->z + m->size;
    if (!p->apart[n] && !p->apart[n + 1])
        return false;
    for (int j = n; j <= n + 1; j++) {
        p->gone[j] = true; /* at the runway's ends too: lying down, the mat is longer there */
        if (j == 0 || j == m->mats)
            continue;
        part(l, j);
        p->gone[j] = true;
        if (state->unhinged_s[j + 1] == 0.0)
            state->unhinged_s[j + 1] = t_s;
        state->torn[j + 1] = 1.0;
    }
    bool apart = p->apart[n + 1];
    l->z[2 * n] = m->rest_y_ft;
    *(apart ? &p->y_ft[n + 1] : &l->z[2 * n + 2]) = m->rest_y_ft;
    v[2 * n] = v[2 * n + 1] = *(apart ? &p->v_ft_s[n + 1] : &v[2 * n + 2]) = 0.0;
    return true;
}

void landing_hold_back(struct landing *l, const struct sim_wheel *wheel,
                       const struct sim_touch *touch, int count)
{
    const struct parting *p = l->parting;
    double *v = l->z + l->model.size, speed_ft_s = 0.0;
    if (p->count == 0 || wheel->count == 0)
        return;
    size_t at = wheel->cursor;
    if (at + 1 < wheel->count && wheel->rows[at + 1].t_s > wheel->rows[at].t_s)
        speed_ft_s = (wheel->rows[at + 1].x_ft - wheel->rows[at].x_ft) /
                     (wheel->rows[at + 1].t_s - wheel->rows[at].t_s);
    for (int i = 0; i < count; i++) {
        int n = touch[i].mat - 1;
        if (touch[i].thrust_lb > 0.0 && (p->apart[n] || p->apart[n + 1]))
            v[2 * n + 1] = fmin(v[2 * n + 1], fmax(0.0, speed_ft_s));
    }
}
