#include "host/sim/solvers/planar_engine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/elementary.h"
#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"
#include "host/sim/elements/law.h"
#include "host/sim/models/kernel.h"

/* ---- the moving parts ---- */

#define UNEVEN_REST_SPEED_MAX \
    1e-6 /* speed / sqrt(g L) below which a node on uneven ground counts as at rest */
/* number of mats at rest that are included at each end of the heaving part */
#define GUARD_MATS              4
#define HEAVING_GROWTH_MATS_MIN 8  /* smallest number of mats by which the heaving part grows */
#define REST_STEPS_TO_SHRINK    16 /* number of steps at rest before a part may become smaller */
/* Number of steps at rest before the outermost mat leaves the sliding part: one for its damper, one
 * for the grit, one in reserve. */
#define JOINT_SETTLING_STEPS    3
/* A node higher than this (height / L) is supported by its mats, not by the ground. */
#define AIRBORNE_HEIGHT_MIN     1e-3
/* a node below both limits is at rest: height / L, and rate of the height / sqrt(g L) */
#define REST_TOLERANCE          1e-13

/* Extends a part to cover mats `low` to `high`. */
static void extend_part(struct moving_part *part, const struct model *m, int low, int high)
{
    low = low < 0 ? 0 : low;
    high = high > m->mats - 1 ? m->mats - 1 : high;
    if (part->last < part->first)
        *part = (struct moving_part){low, high, 0, 0};
    if (low < part->first) {
        part->first = low;
        part->first_rest_steps = 0;
    }
    if (high > part->last) {
        part->last = high;
        part->last_rest_steps = 0;
    }
}

/* Before a step, extends the sliding part to the mats that the wheel touches or that move. Shrinks
 * it where mats are at rest. */
static void update_sliding_part(struct planar_engine *l, const struct sim_touch *touch, int count)
{
    struct moving_part *s = &l->sliding;
    const double *v = l->z + l->model.coordinate_count;
    for (int i = 0; i < count; i++) {
        bool idle = s->last - s->first <= 2 && s->first_rest_steps >= REST_STEPS_TO_SHRINK &&
                    s->last_rest_steps >= REST_STEPS_TO_SHRINK;
        if (idle)
            s->last = s->first -
                      1; /* all mats are at rest, so the part begins again at the wheel */
        extend_part(s, &l->model, touch[i].mat - 2, touch[i].mat);
    }
    if (s->last < s->first)
        return;
    if (v[2 * s->first + 1] != 0.0 || v[2 * s->last + 1] != 0.0)
        extend_part(s, &l->model, v[2 * s->first + 1] != 0.0 ? s->first - 1 : s->first,
                    v[2 * s->last + 1] != 0.0 ? s->last + 1 : s->last);
    bool still_first = v[2 * s->first + 1] == 0.0 && v[2 * s->first + 3] == 0.0;
    bool still_last = v[2 * s->last + 1] == 0.0 && s->last > 0 && v[2 * s->last - 1] == 0.0;
    s->first_rest_steps = still_first ? s->first_rest_steps + 1 : 0;
    s->last_rest_steps = still_last ? s->last_rest_steps + 1 : 0;
    if (s->first_rest_steps >= REST_STEPS_TO_SHRINK && s->last - s->first > 2) {
        s->first++;
        s->first_rest_steps = REST_STEPS_TO_SHRINK - JOINT_SETTLING_STEPS;
    }
    if (s->last_rest_steps >= REST_STEPS_TO_SHRINK && s->last - s->first > 2) {
        s->last--;
        s->last_rest_steps = REST_STEPS_TO_SHRINK - JOINT_SETTLING_STEPS;
    }
}

/* Returns whether a node on uneven ground is at rest. Its height may differ from the settled one,
 * because the joints may be compressed. A node in the air never counts as at rest: mats outside the
 * heaving part count as flat, so a standing wave would become shorter. */
static bool is_node_at_rest(const struct planar_engine *l, int node)
{
    const struct model *m = &l->model;
    if (m->tilt_ft)
        return fabs(l->z[m->coordinate_count + 2 * node]) <=
                   UNEVEN_REST_SPEED_MAX * sqrt(m->scene->g_ft_s2 * m->length_ft) &&
               l->z[2 * node] >= -AIRBORNE_HEIGHT_MIN * m->length_ft;
    return fabs(l->z[2 * node] - m->rest_y_ft) <= REST_TOLERANCE * m->length_ft &&
           fabs(l->z[m->coordinate_count + 2 * node]) <=
               REST_TOLERANCE * sqrt(m->scene->g_ft_s2 * m->length_ft);
}

static bool is_mat_at_rest(const struct planar_engine *l, int n)
{
    return is_node_at_rest(l, n) && is_node_at_rest(l, n + 1);
}

/* On uneven ground, a joint whose force changes lifts its mats or presses them down. Adds these
 * mats to the heaving part. */
static void add_sliding_mats_to_heaving(struct planar_engine *l, int chunk)
{
    const double *v = l->z + l->model.coordinate_count;
    int first = l->sliding.first, last = l->sliding.last;
    while (first <= last && v[2 * first + 1] == 0.0)
        first++;
    while (last > first && v[2 * last + 1] == 0.0)
        last--;
    if (first <= last)
        extend_part(&l->heaving, &l->model, first - chunk, last + chunk);
}

/* Updates the heaving part: mats that are not flat or not at rest, mats under the wheel, and
 * GUARD_MATS mats at rest at each end, so that motion outside the part is below REST_TOLERANCE. */
static void update_heaving_part(struct planar_engine *l)
{
    struct model *m = &l->model;
    struct moving_part *h = &l->heaving;
    /* number of mats over which a sudden load acts, as in model.c */
    int chunk = m->load_tail_mats > GUARD_MATS + HEAVING_GROWTH_MATS_MIN
                  ? m->load_tail_mats - GUARD_MATS
                  : HEAVING_GROWTH_MATS_MIN;
    if (m->wheel_load_lb > 0.0 && m->span.mat >= 0)
        extend_part(h, m, m->span.mat - m->load_tail_mats, m->span.mat + m->load_tail_mats);
    if (m->tilt_ft)
        add_sliding_mats_to_heaving(l, GUARD_MATS);
    if (h->last < h->first)
        return;
    bool first = h->first == 0, last = h->last == m->mats - 1;
    for (int k = 0; k < GUARD_MATS && !first; k++)
        first = h->first + k <= h->last && !is_mat_at_rest(l, h->first + k);
    for (int k = 0; k < GUARD_MATS && !last; k++)
        last = h->last - k >= h->first && !is_mat_at_rest(l, h->last - k);
    if (first && h->first > 0)
        extend_part(h, m, h->first - chunk, h->last);
    if (last && h->last < m->mats - 1)
        extend_part(h, m, h->first, h->last + chunk);
    if (++h->first_rest_steps >= REST_STEPS_TO_SHRINK) {
        h->first_rest_steps = 0;
        int low = h->first, high = h->last;
        while (low <= high && is_mat_at_rest(l, low))
            low++;
        while (high >= low && is_mat_at_rest(l, high))
            high--;
        bool loaded = m->wheel_load_lb > 0.0 && m->span.mat >= 0;
        if (low > high && !loaded)
            h->last = h->first - 1;
        else if (low <= high) {
            int from = low - chunk, to = high + chunk;
            if (loaded) {
                from = m->span.mat - m->load_tail_mats < from ? m->span.mat - m->load_tail_mats
                                                              : from;
                to = m->span.mat + m->load_tail_mats > to ? m->span.mat + m->load_tail_mats : to;
            }
            h->first = from > h->first ? from : h->first;
            h->last = to < h->last ? to : h->last;
        }
    }
}

/* Adds heaving mats to the sliding part if their vertical motion moves them along the runway:
 * through the joints with profile `full`, or through a change of the friction on soil. */
static void add_heaving_mats_to_sliding(struct planar_engine *l)
{
    const struct model *m = &l->model;
    if ((m->has_full_profile || m->has_soil_normal) && l->heaving.last >= l->heaving.first)
        extend_part(&l->sliding, m, l->heaving.first - 1, l->heaving.last + 1);
}

/* ---- tensions ---- */

/* Shortening of the mat on either side of a joint due to its rotation, and its rate of change. */
struct shortening {
    double ft, ft_s;
};

static inline struct shortening compute_shortening(const struct planar_engine *l, int n)
{
    const struct model *m = &l->model;
    if (!m->has_full_profile || n < l->heaving.first || n > l->heaving.last)
        return (struct shortening){0.0, 0.0};
    const double *p = l->z, *v = l->z + m->coordinate_count;
    struct kernel_mat mat = m->tilt_ft ? kernel_tilted_mat(m, p, v, n, 1.0 / m->length_ft)
                                       : kernel_mat(p, v, n, 1.0 / m->length_ft);
    return (struct shortening){m->half_ft * (l->rest_cos[n] - mat.c), m->half_ft * mat.w * mat.s};
}

LAW_INLINE void update_tensions_by_law(struct planar_engine *l, enum joint_law law)
{
    const struct model *m = &l->model;
    const double *p = l->z, *v = l->z + m->coordinate_count;
    struct law_joint joint = {m->kl_lb_ft, m->cl_lb_s_ft, l->slack_ft};
    struct shortening left, right = compute_shortening(l, l->sliding.first - 1);
    for (int j = l->sliding.first; j <= l->sliding.last + 1; j++) {
        left = right; /* set before the test for free ends, because the next joint needs it too */
        right = compute_shortening(l, j);
        if ((j == 0 && m->is_left_free) || (j == m->mats && m->is_right_free)) {
            l->tension_lb[j] = 0.0;
            continue;
        }
        double u_l = j > 0 ? p[2 * j - 1] : 0.0, u_r = j < m->mats ? p[2 * j + 1] : 0.0;
        double v_l = j > 0 ? v[2 * j - 1] : 0.0, v_r = j < m->mats ? v[2 * j + 1] : 0.0;
        double g = l->gap0_ft[j] + (u_r - u_l) + left.ft + right.ft,
               rate = v_r - v_l + left.ft_s + right.ft_s;
        if (law == JOINT_SLACK && l->last_step_s > 0.0)
            rate = law_damper_speed_ft_s(g, rate, l->slack_ft, l->last_step_s);
        joint.kl_lb_ft = l->kl_lb_ft[j];
        struct joint_grit grit = {l->grit_lb[j], l->grit_yield_ft[j], l->grit_extent_ft[j]};
        struct law_pull pulled = joint_pull(law, joint, g, rate, grit);
        if (law == JOINT_SLACK && l->last_step_s > 0.0 && joint_mode(g, l->slack_ft) == 0)
            /* damper force, only for the part of the last step in which the joint was closed */
            pulled.lb = joint.cl_lb_s_ft * rate;
        double t_lb = pulled.lb;
        if (l->mods && mods_is_torn(l->mods, j + 1))
            t_lb = fmin(0.0, t_lb);
        if (law == JOINT_GRIT)
            l->grit_extent_ft[j] = pulled.grit_extent_ft;
        l->tension_lb[j] = t_lb;
        l->max_tension_lb[j] = t_lb > l->max_tension_lb[j] ? t_lb : l->max_tension_lb[j];
        l->max_compression_lb[j] = -t_lb > l->max_compression_lb[j] ? -t_lb
                                                                    : l->max_compression_lb[j];
    }
}

/* Computes the tensions, in a separate loop for each joint law. */
static void update_tensions(struct planar_engine *l)
{
    if (l->joint_law == JOINT_LINEAR)
        update_tensions_by_law(l, JOINT_LINEAR);
    else if (l->joint_law == JOINT_SLACK)
        update_tensions_by_law(l, JOINT_SLACK);
    else
        update_tensions_by_law(l, JOINT_GRIT);
    if (l->mods && l->mods->has_joint_springs) {
        struct mods_view view = planar_engine_view(l);
        mods_add_joint_forces(l->mods, &view, l->sliding.first + 1, l->sliding.last + 2);
    }
}

/* ---- speeds ---- */

/* Largest number of times that a step is repeated because nodes leave or touch the soil. */
#define MAX_CONTACT_ROUNDS 8

/* Applies bands and cleats before a kick. Adds mats that a band moves to the sliding part. */
static void brace_sliding_part(struct planar_engine *l, const struct sim_touch *touch, int count,
                               double h_s)
{
    struct mods *mods = l->mods;
    const struct model *m = &l->model;
    struct mods_view view = planar_engine_view(l);
    if (mods->has_cleats) {
        mods_bend_raised_cleats(mods, touch, count);
        mods_wear_cleats(mods, &view, h_s, l->sliding.first + 1, l->sliding.last + 1);
    }
    if (!mods->has_bands)
        return;
    mods_apply_bands(mods, &view, touch, count);
    for (int c = 0; c < mods->brace_count; c++) {
        int n = mods->brace_mat[c] - 1;
        double push_lb = l->tension_lb[n + 1] - l->tension_lb[n] + mods->brace_force_lb[n + 1];
        double limit_lb = m->friction_law == SIM_FRICTION_NONE
                            ? 0.0
                            : l->limit_lb[n] + mods_cleat_hold_lb(mods, n + 1);
        if ((n < l->sliding.first || n > l->sliding.last) && fabs(push_lb) > limit_lb)
            extend_part(&l->sliding, m, n - 1, n + 1);
    }
}

/* Computes the forces of bands on the nodes of the heaving part, and the moments of stiffeners on
 * its joints. */
static void brace_heaving_part(struct planar_engine *l)
{
    const struct model *m = &l->model;
    struct mods_heaving_part heave = {.z = l->z,
                                      .tilt_ft = m->tilt_ft,
                                      .ground_ft = l->scene->ground_ft.values,
                                      .mats = m->mats,
                                      .length_ft = m->length_ft,
                                      .rest_ft = l->rest_ft,
                                      .rest_tilt_ft = l->rest_tilt_ft,
                                      .first = l->heaving.first,
                                      .last = l->heaving.last,
                                      .down_lb = l->brace_force_lb,
                                      .moment_lb_ft = l->brace_moment_lb_ft};
    mods_compute_vertical_forces(l->mods, &heave);
}

static double node_soil_force_lb(const struct planar_engine *l, int node)
{
    return kernel_local_soil_force_lb(&l->model, l->z, l->z + l->model.coordinate_count, node);
}

/* Returns the mean force of the soil on a node during the kick of its mats. It differs from the
 * present force only in a step that is divided into parts and in the step after it. */
static double mean_soil_force_lb(const struct planar_engine *l, int node)
{
    if (l->is_step_divided)
        return l->normal_lb[node];
    double now_lb = fmax(0.0, node_soil_force_lb(l, node));
    bool known = node >= l->normal_first && node <= l->normal_last;
    return known ? l->next_normal_lb[node] + l->next_normal_share * now_lb : now_lb;
}

/* Returns the Coulomb limit of a heaving mat, computed from the force of the soil in the kick of
 * its nodes, with dampers at the end of the step. Thus the friction of a foot that lands in a step
 * includes the impulse of its landing. */
static double soil_friction_limit_lb(const struct planar_engine *l, int n)
{
    const struct model *m = &l->model;
    if (l->is_step_divided || l->next_normal_share < 1.0)
        return m->friction_coefficient * (mean_soil_force_lb(l, n) + mean_soil_force_lb(l, n + 1));
    return m->friction_coefficient *
           (fmax(0.0, node_soil_force_lb(l, n)) + fmax(0.0, node_soil_force_lb(l, n + 1)));
}

/* Updates the speed of a mat under the gear, on which the elastic ground acts. Its Coulomb limit
 * includes its share of the gear's load. */
static void step_mat_under_gear(struct planar_engine *l, int n, double thrust_lb, double limit_lb,
                                double h_s)
{
    const struct model *m = &l->model;
    struct gear *gear = l->gear;
    double *v = &l->z[m->coordinate_count + 2 * n + 1];
    bool grounded = n < l->heaving.first || n > l->heaving.last || m->contact[n] ||
                    m->contact[n + 1];
    struct element_step step = element_make_step(&m->elements, (struct element_mat){*v, grounded},
                                                 h_s, l->mass_slug[n]);
    gear->mass_slug = l->mass_slug[n];
    if (!m->has_soil_normal && m->friction_law != SIM_FRICTION_NONE)
        limit_lb += m->friction_coefficient * l->scene->wheel_load_lb * gear->load_share[n + 1];
    *v = gear_solve_mat_speed_ft_s(gear, n + 1, step.speed_factor * *v, thrust_lb + step.push_lb,
                                   limit_lb, step.equivalent_s);
}

/* Sets the mat under the wheel in the model (from 0; -1: none). The thrust is applied by the
 * engine, not by the model. */
static void set_wheel_mat(struct model *m, int mat)
{
    m->span = (struct span){.mat = mat, .first_sharing_mat = -2};
}

/* Updates the speeds along the runway. `plain`: the scene has no cleats, elements or gear. */
KERNEL_INLINE unsigned kick_mats(struct planar_engine *l, const struct sim_touch *touch, int count,
                                 double h_s, bool plain)
{
    const struct model *m = &l->model;
    /* `u` is free for temporary use until outputs are written */
    double *v = l->z + m->coordinate_count, *thrust = l->u;
    const bool cleated = !plain && l->mods && l->mods->has_cleats,
               elements = !plain && m->elements.count > 0, geared = !plain && l->gear;
    unsigned stops = 0;
    if (geared) /* with a gear, waves are recorded at the lead axle */
        set_wheel_mat(&l->model, l->gear->lead_mat - 1);
    for (int n = l->sliding.first; n <= l->sliding.last; n++)
        thrust[n] = l->tension_lb[n + 1] - l->tension_lb[n];
    for (int i = 0; i < count; i++)
        thrust[touch[i].mat - 1] += touch[i].thrust_lb;
    for (int c = 0; l->mods && c < l->mods->brace_count; c++)
        /* forces on mats outside the part have no effect: the loop below skips them */
        thrust[l->mods->brace_mat[c] - 1] += l->mods->brace_force_lb[l->mods->brace_mat[c]];
    for (int n = l->sliding.first; n <= l->sliding.last; n++) {
        double limit = l->limit_lb[n], mass_slug = l->mass_slug[n];
        if (m->has_soil_normal && n >= l->heaving.first && n <= l->heaving.last)
            limit = soil_friction_limit_lb(l, n);
        for (int i = 0; i < count && !m->has_soil_normal && m->wheel_load_lb > 0.0; i++) {
            if (touch[i].mat - 1 == n)
                limit += m->friction_coefficient * m->wheel_load_lb * touch[i].load_share;
        }
        if (cleated)
            limit += mods_raised_cleat_hold_lb(l->mods, n + 1, l->z[2 * n], l->z[2 * n + 2]);
        if (m->friction_law == SIM_FRICTION_NONE)
            limit = 0.0;
        if (geared && l->gear->load_share[n + 1] > 0.0) {
            step_mat_under_gear(l, n, thrust[n], limit, h_s);
        } else if (elements) {
            struct element_mat mat = {v[2 * n + 1], n < l->heaving.first || n > l->heaving.last ||
                                                        m->contact[n] || m->contact[n + 1]};
            struct element_step step = element_make_step(&m->elements, mat, h_s, mass_slug);
            v[2 * n + 1] = friction_speed_ft_s(step.speed_factor * mat.v_ft_s,
                                               thrust[n] + step.push_lb, limit, step.equivalent_s,
                                               mass_slug, &stops);
        } else {
            v[2 * n + 1] = friction_speed_ft_s(v[2 * n + 1], thrust[n], limit, h_s, mass_slug,
                                               &stops);
        }
    }
    return stops;
}

/* Updates the speeds along the runway, and returns the number of mats that came to rest. Call after
 * kick_heaving_part, because friction depends on the reactions of the soil in the same step. A
 * plain runway has a separate loop, which is faster. */
static unsigned kick_sliding_part(struct planar_engine *l, const struct sim_touch *touch, int count,
                                  double h_s)
{
    bool plain = !(l->mods && l->mods->has_cleats) && l->model.elements.count == 0 && !l->gear;
    return plain ? kick_mats(l, touch, count, h_s, true) : kick_mats(l, touch, count, h_s, false);
}

/* Releases nodes on which the soil would pull at the end of the step, because soil cannot pull.
 * Puts nodes that it would push in contact. Returns true if a node has changed. */
static bool update_contacts(struct planar_engine *l, double h_s)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->coordinate_count;
    bool changed = false;
    for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
        double y_ft = l->z[2 * j];
        bool pushed = y_ft > 0.0 && l->kv_lb_ft[j] * y_ft +
                                            l->cv_lb_s_ft[j] * (v[2 * j] + h_s * l->accel[2 * j]) >
                                        0.0;
        changed = changed || pushed != m->contact[j];
        m->contact[j] = pushed;
    }
    return changed;
}

/* Updates the vertical speeds over h_s. Returns the largest change of speed due to the soil. */
static double kick_heaving_part(struct planar_engine *l, double h_s)
{
    const struct model *m = &l->model;
    double *v = l->z + m->coordinate_count;
    consistent_heave_rates(m, h_s, l->z, l->accel);
    for (int i = 0; i < MAX_CONTACT_ROUNDS && update_contacts(l, h_s); i++)
        consistent_heave_rates(m, h_s, l->z, l->accel);
    double jolt_ft_s = 0.0;
    for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
        double change_ft_s = h_s * l->accel[2 * j];
        v[2 * j] += change_ft_s;
        if (m->contact[j] && fabs(change_ft_s) > jolt_ft_s)
            jolt_ft_s = fabs(change_ft_s);
    }
    return jolt_ft_s;
}

/* ---- gear ---- */

/* Moves the wheel or gear from t0 to t1. The weight of a gear then acts on the heaving part. */
static int move_gear(struct planar_engine *l, struct sim_wheel *wheel, double t0_s, double t1_s,
                     struct sim_touch *touch)
{
    const struct model *m = &l->model;
    if (!l->gear)
        return sim_wheel_compute_action(wheel, t0_s, t1_s, touch);
    int count = gear_compute_action(l->gear, t0_s, t1_s, touch);
    for (int i = 0; i < l->gear->loaded_count && l->scene->wheel_load_lb > 0.0; i++) {
        int n = l->gear->loaded_mats[i] - 1;
        extend_part(&l->heaving, m, n - m->load_tail_mats, n + m->load_tail_mats);
    }
    return count;
}

/* Adds the weight of the gear to the forces on the nodes of the heaving part. */
static void load_heaving_part(struct planar_engine *l)
{
    const struct gear *gear = l->gear;
    if (l->mods && l->mods->acts_vertically) {
        brace_heaving_part(l);
    } else {
        for (int j = l->heaving.first; j <= l->heaving.last + 1; j++)
            l->brace_force_lb[j] = 0.0;
    }
    for (int i = 0; i < gear->loaded_count; i++) {
        int n = gear->loaded_mats[i] - 1;
        double half_lb = 0.5 * l->scene->wheel_load_lb * gear->load_share[n + 1];
        l->brace_force_lb[n] += half_lb;
        l->brace_force_lb[n + 1] += half_lb;
    }
}

/* ---- memory ---- */

static void set_tilt(struct planar_engine *l)
{
    struct model *m = &l->model;
    const double *ground = l->scene->ground_ft.values;
    for (int n = 0; n < m->mats; n++) {
        l->tilt_ft[n] = ground ? ground[n] - ground[n + 1] : 0.0;
        /* a node on softer soil settles more */
        l->rest_tilt_ft[n] = l->tilt_ft[n] + l->rest_ft[n + 1] - l->rest_ft[n];
        double s = l->rest_tilt_ft[n] / m->length_ft;
        l->rest_cos[n] = sqrt(1.0 - s * s);
    }
    for (int n = 0; n < m->mats; n++)
        m->max_tilt_ft = fmax(m->max_tilt_ft, fabs(l->rest_tilt_ft[n]));
    if (m->max_tilt_ft > 0.0) {
        m->tilt_ft = l->tilt_ft;
        m->rest_tilt_ft = l->rest_tilt_ft;
    }
}

/* Sets the properties of each node, joint and mat, from the lists or single values of the scene. */
static void set_properties(struct planar_engine *l)
{
    struct model *m = &l->model;
    const struct sim_scene *s = l->scene;
    for (int j = 0; j <= m->mats; j++) {
        l->kv_lb_ft[j] = sim_scene_local_value(s, SIM_VARIED_KV, m->kv_lb_ft, j + 1);
        l->cv_lb_s_ft[j] = sim_scene_local_value(s, SIM_VARIED_CV, m->cv_lb_s_ft, j + 1);
        l->kl_lb_ft[j] = sim_scene_local_value(s, SIM_VARIED_KL, m->kl_lb_ft, j + 1);
        l->kt_lb_ft_rad[j] = sim_scene_local_value(s, SIM_VARIED_KT, m->kt_lb_ft_rad, j + 1);
        l->rest_ft[j] = sim_scene_settlement_ft(s, j + 1);
    }
    for (int n = 0; n < m->mats; n++) {
        double weight_lb = sim_scene_weight_lb(s, n + 1);
        l->mass_slug[n] = weight_lb / s->g_ft_s2;
        l->mass_ratio[n] = l->mass_slug[n] / m->mass_slug;
        l->limit_lb[n] = s->friction * weight_lb;
    }
    m->node_kv_lb_ft = l->kv_lb_ft;
    m->node_cv_lb_s_ft = l->cv_lb_s_ft;
    m->joint_kt_lb_ft_rad = l->kt_lb_ft_rad;
    m->mass_ratio = l->mass_ratio;
}

/* Sets the arrays of a landing in one block of memory. The model must be made before. */
static void assign_arrays(struct planar_engine *l)
{
    struct model *m = &l->model;
    size_t length = 2 * (size_t)m->coordinate_count, joints = (size_t)m->mats + 2;
    double **per_joint[] = {&l->u,
                            &l->v,
                            &l->gap0_ft,
                            &l->grit_lb,
                            &l->grit_yield_ft,
                            &l->grit_extent_ft,
                            &l->tension_lb,
                            &l->height,
                            &l->max_compression_lb,
                            &l->max_tension_lb,
                            &l->max_rise_ft,
                            &l->tilt_ft,
                            &l->rest_cos,
                            &l->normal_lb,
                            &l->next_normal_lb,
                            &l->brace_force_lb,
                            &l->brace_moment_lb_ft,
                            &l->kl_lb_ft,
                            &l->kv_lb_ft,
                            &l->cv_lb_s_ft,
                            &l->rest_ft,
                            &l->limit_lb,
                            &l->kt_lb_ft_rad,
                            &l->mass_slug,
                            &l->rest_tilt_ft,
                            &l->mass_ratio};
    const size_t arrays = sizeof per_joint / sizeof per_joint[0];
    l->stored_value_count = 2 * length + arrays * joints;
    l->z = xcalloc(l->stored_value_count, sizeof *l->z);
    l->accel = l->z + length;
    for (size_t i = 0; i < arrays; i++)
        *per_joint[i] = l->z + 2 * length + i * joints;
    set_properties(l);
    set_tilt(l);
    bool braced = l->mods && l->mods->acts_vertically;
    if (braced || l->gear) {
        l->brace_heaving_part = l->gear ? load_heaving_part : brace_heaving_part;
        m->brace_force_lb = l->brace_force_lb;
        m->brace_moment_lb_ft = l->brace_moment_lb_ft;
    }
    l->slack_ft = m->slack_ft;
    m->given_tension_lb = l->tension_lb;
    m->slack_ft = 0.0; /* the engine applies the slack, so the model must not */
    bool gritty = false;
    for (int j = 0; j <= m->mats; j++) {
        l->gap0_ft[j] = sim_scene_joint_value(&l->scene->gap0_ft, j + 1);
        l->grit_lb[j] = sim_scene_joint_value(&l->scene->grit_lb, j + 1);
        l->grit_yield_ft[j] = l->grit_lb[j] / l->kl_lb_ft[j];
        gritty = gritty || l->grit_lb[j] > 0.0;
    }
    l->joint_law = joint_law(l->slack_ft, gritty);
}

enum mr_status planar_engine_make(struct planar_engine *l, const struct sim_scene *scene,
                                  struct sim_result *result, struct error *error)
{
    l->scene = scene;
    if (scene->friction > 0.0 &&
        (scene->friction_law == SIM_FRICTION_TANH || scene->friction_law == SIM_FRICTION_SIGN))
        return error_set(error, MR_USAGE,
                         "solver staggered has no friction law tanh or sign: %s; give friction "
                         "stick, or --solver event",
                         sim_scene_name(scene));
    if (model_make(&l->model, scene, true, error) != MR_OK)
        return error->status;
    if (result) /* describe the model before the engine changes it */
        model_describe(&l->model, result);
    l->mods = mods_make(scene);
    l->gear = gear_make(scene);
    assign_arrays(l);
    return MR_OK;
}

void planar_engine_free(struct planar_engine *l)
{
    mods_free(l->mods);
    gear_free(l->gear);
    model_free(&l->model);
    free(l->z);
}

/* ---- one run ---- */

#define FOLDED_MIN_DEG           85.0
#define DEG_PER_RAD              (180.0 / 3.14159265358979323846)
/* The wheel has left a wave if its lift is below this fraction of the lift at the overrun. A later
 * wave counts as a new one. */
#define OFF_WAVE_LIFT_RATIO      0.5
/* up to this sine, the angle equals the sine within rounding */
#define SMALL_TURN_SINE_MAX      0.01
#define STEPS_PER_CALLBACK       1024 /* number of steps between calls of may_continue */
#define STEPS_PER_SHAPE_UPDATE   4    /* number of steps between updates of lifts and angles */
/* Number of parts into which a step is divided if a node lands in it */
#define LANDING_STEP_PARTS       16
/* a node that lands with a smaller speed / sqrt(g L) does not lift its neighbours */
#define GENTLE_LANDING_SPEED_MAX 1e-4

/* Returns the index of the mat with the largest share of the wheel's load; -1: none. */
static int find_mat_under_wheel(const struct sim_touch *touch, int count)
{
    double most = 0.0;
    int mat = -1;
    for (int i = 0; i < count; i++) {
        if (touch[i].load_share > most) {
            most = touch[i].load_share;
            mat = touch[i].mat - 1;
        }
    }
    return mat;
}

/* Returns the largest lift and its node at the time `back_s` before the end of the present step. */
static double largest_lift_ft(const struct planar_engine *l, double back_s, int *node_from_1)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->coordinate_count;
    double most_ft = 0.0;
    *node_from_1 = 1;
    for (int j = l->heaving.first; j <= l->heaving.last + 1 && l->heaving.last >= l->heaving.first;
         j++) {
        double up_ft = v[2 * j] * back_s - l->z[2 * j];
        if (up_ft > most_ft && up_ft > SOIL_TOUCH_FT) {
            most_ft = up_ft;
            *node_from_1 = j + 1;
        }
    }
    return most_ft;
}

/* Records the outputs up to t_s, each at its own time. The speeds are of the step ending at t_s. */
static void record_outputs(struct planar_engine *l, struct march *march, double t_s)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->coordinate_count;
    while (march->record.next_record_s <= t_s) {
        double at_s = march->record.next_record_s, back_s = t_s - at_s;
        for (int n = 0; n < m->mats; n++) {
            l->v[n + 1] = v[2 * n + 1];
            l->u[n + 1] = l->z[2 * n + 1] - v[2 * n + 1] * back_s;
            l->height[n + 1] = v[2 * n] * back_s - l->z[2 * n];
        }
        march->record.height_ft = l->height;
        march->record.lift_ft = largest_lift_ft(l, back_s, &march->record.lift_node);
        march->max_lift_ft = fmax(march->max_lift_ft, march->record.lift_ft);
        sim_record_add(&march->record, at_s, l->u, l->v);
    }
}

/* Updates the extremes of the nodes and joints in the heaving part. */
static void record_extremes(struct planar_engine *l, struct march *march)
{
    const struct model *m = &l->model;
    const double *p = l->z;
    double left = 0.0;
    for (int j = l->heaving.first; j <= l->heaving.last + 1; j++) {
        double tilt = j <= l->heaving.last && m->tilt_ft ? m->tilt_ft[j] : 0.0;
        double right = j <= l->heaving.last ? (p[2 * j + 2] - p[2 * j] + tilt) / m->length_ft : 0.0;
        l->max_rise_ft[j] = -p[2 * j] > l->max_rise_ft[j] ? -p[2 * j] : l->max_rise_ft[j];
        if (fabs(right - left) > SMALL_TURN_SINE_MAX && fabs(right) < 1.0 && fabs(left) < 1.0) {
            double turn_deg = (elementary_asin(right) - elementary_asin(left)) * DEG_PER_RAD;
            if (turn_deg > march->crest_deg) {
                march->crest_deg = turn_deg;
                march->crest_joint = j + 1;
            }
            if (-turn_deg > march->sag_deg) {
                march->sag_deg = -turn_deg;
                march->sag_joint = j + 1;
            }
        }
        left = right;
    }
}

/* Records the highest node at the moment when the first node has risen by lift_ft. */
static void record_crest(const struct planar_engine *l, struct march *march, double lift_ft)
{
    int highest = l->heaving.first;
    for (int j = l->heaving.first + 1; j <= l->heaving.last + 1 && j <= l->model.mats; j++)
        highest = l->z[2 * j] < l->z[2 * highest] ? j : highest;
    if (l->heaving.last >= l->heaving.first && -l->z[2 * highest] >= lift_ft) {
        march->first_crest_node = highest + 1;
        march->first_crest_wheel_mat = l->model.span.mat + 1;
    }
}

/* Records an overrun: the wheel reaches a wave that is too high for the wheel to press it flat. */
static void record_encounter(const struct planar_engine *l, struct march *march, double lift_ft)
{
    int mat = l->model.span.mat;
    if (march->first_crest_node == 0)
        record_crest(l, march, lift_ft);
    if (mat < 0)
        return;
    double left_ft = -l->z[2 * mat], right_ft = -l->z[2 * mat + 2];
    int node = (left_ft > right_ft ? mat : mat + 1) + 1;
    bool meets = fmax(left_ft, right_ft) >= lift_ft;
    if (meets && !march->was_wheel_on_wave && march->wave_encounter_count < SIM_WAVE_ENCOUNTERS_MAX)
        march->wave_encounter_nodes[march->wave_encounter_count++] = node;
    march->was_wheel_on_wave = meets || (march->was_wheel_on_wave &&
                                         fmax(left_ft, right_ft) >= OFF_WAVE_LIFT_RATIO * lift_ft);
}

static bool update_march_status(struct planar_engine *l, struct march *march, double t_s)
{
    const struct model *m = &l->model;
    int mat = l->sliding.first + 1, node;
    double sum = 0.0;
    for (int n = l->sliding.first; n <= l->sliding.last; n++)
        sum += fabs(l->z[2 * n + 1]) + fabs(l->z[m->coordinate_count + 2 * n + 1]);
    if (l->heaving.last >= l->heaving.first) {
        double angle = model_largest_angle_deg(m, l->z, &mat);
        march->max_lift_ft = fmax(march->max_lift_ft, model_lift_ft(m, l->z, &node));
        record_extremes(l, march);
        if (angle > FOLDED_MIN_DEG)
            march->status = SIM_FOLDED;
        if (!isfinite(angle))
            march->status = SIM_UNSTABLE;
    }
    if (!(sum < 1e6 * m->mats * m->length_ft))
        march->status = SIM_UNSTABLE;
    march->mat = mat;
    march->t_s = t_s;
    return march->status == SIM_OK;
}

static void init_march_state(struct planar_engine *l, bool prunes)
{
    struct model *m = &l->model;
    model_start(m, l->z);
    for (int j = 0; j <= m->mats; j++)
        l->z[2 * j] += l->rest_ft[j] - m->rest_y_ft;
    for (int n = 0; n < m->mats && l->scene->varied[SIM_VARIED_V0].count > 0; n++)
        l->z[m->coordinate_count + 2 * n + 1] =
            sim_scene_joint_value(&l->scene->varied[SIM_VARIED_V0], n + 1);
    l->sliding = l->heaving = (struct moving_part){0, m->mats - 1, 0, 0};
    for (int j = 0; j <= m->mats; j++)
        l->grit_extent_ft[j] = joint_initial_grit_extent_ft(l->gap0_ft[j], l->slack_ft);
    memset(l->max_compression_lb, 0, 3 * ((size_t)m->mats + 2) * sizeof *l->max_compression_lb);
    if (l->mods)
        mods_reset(l->mods);
    if (!prunes)
        return;
    update_tensions(l);
    l->sliding.last = l->heaving.last = -1;
    for (int n = 0; n < m->mats; n++) {
        double push_lb = l->tension_lb[n + 1] - l->tension_lb[n];
        if (l->z[m->coordinate_count + 2 * n + 1] != 0.0 ||
            fabs(push_lb) > (m->friction_law == SIM_FRICTION_NONE ? 0.0 : l->limit_lb[n]))
            extend_part(&l->sliding, m, n - 1, n + 1);
        if (!is_mat_at_rest(l, n) ||
            (m->tilt_ft && (l->tension_lb[n] != 0.0 || l->tension_lb[n + 1] != 0.0)))
            extend_part(&l->heaving, m, n - m->load_tail_mats, n + m->load_tail_mats);
    }
}

/* True if a node will reach the ground in the step. Two nodes that land in the same step lift their
 * neighbours differently from two that land one after the other, so without this test every step
 * longer than the time between the two landings would give the same wrong result. */
static bool will_node_land(const struct planar_engine *l, double h_s)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->coordinate_count;
    double gentle_ft_s = GENTLE_LANDING_SPEED_MAX * sqrt(m->scene->g_ft_s2 * m->length_ft);
    for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
        if (!m->contact[j] && v[2 * j] > gentle_ft_s && l->z[2 * j] + h_s * v[2 * j] > 0.0)
            return true;
    }
    return false;
}

/* Steps the heights over h_s in several parts. Afterwards the speeds are those of half a part
 * before the end of the step. Friction uses the soil's mean force during the kick, which lasts from
 * half a step before the step's beginning to half a step after it. The soil's force after that
 * belongs to the next step. Returns the largest change of a node's speed. */
static double step_heights_in_parts(struct planar_engine *l, bool after_parts, double first_kick_s,
                                    double h_s)
{
    struct model *m = &l->model;
    double *p = l->z, *v = l->z + m->coordinate_count;
    double part_s = h_s / LANDING_STEP_PARTS, jolt_ft_s = 0.0, done_s = 0.5 * part_s - first_kick_s;
    /* fraction of the mean force that belongs to the time before this step */
    double early = fmax(0.0, 0.5 + done_s / h_s);
    for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
        bool known = after_parts && j >= l->normal_first && j <= l->normal_last;
        l->normal_lb[j] = known ? l->next_normal_lb[j]
                                : early * fmax(0.0, node_soil_force_lb(l, j));
        l->next_normal_lb[j] = 0.0;
    }
    for (int k = 0; k < LANDING_STEP_PARTS; k++) {
        double kick_s = k == 0 ? first_kick_s : part_s;
        if (k > 0)
            model_sample_shape_modes(m, l->z);
        if (k > 0 && l->brace_heaving_part)
            l->brace_heaving_part(l);
        jolt_ft_s = fmax(jolt_ft_s, kick_heaving_part(l, kick_s));
        double now_s = fmax(0.0, fmin(kick_s, 0.5 * h_s - done_s));
        for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
            double push_lb = fmax(0.0, node_soil_force_lb(l, j));
            l->normal_lb[j] += now_s / h_s * push_lb;
            l->next_normal_lb[j] += (kick_s - now_s) / h_s * push_lb;
            p[2 * j] += part_s * v[2 * j];
        }
        done_s += kick_s;
    }
    l->normal_first = m->first_mat;
    l->normal_last = m->last_mat + 1;
    return jolt_ft_s;
}

/* State of a march while it runs. */
struct march_run {
    struct planar_engine *engine;
    struct march *march;
    const struct sim_options *options;
    struct sim_wheel wheel;
    struct sim_touch touch[SIM_TOUCH_MAX];
    int touch_count;
    bool omits_mats, has_divided_steps, has_heaving_part;
    double last_height_step_s; /* length of the last step of the heights */
};

static void begin_march(struct march_run *way)
{
    struct planar_engine *l = way->engine;
    double h = way->march->h_s;
    way->omits_mats = !way->options->integrates_all_mats && element_allows_rest(&l->model.elements);
    way->has_divided_steps = !way->options->is_single_pass;
    way->last_height_step_s = h;
    l->last_step_s = 0.0; /* no mat has moved yet */
    l->next_normal_share = 1.0;
    l->is_step_divided = false;
    init_march_state(l, way->omits_mats);
    sim_wheel_start(&way->wheel, l->scene);
    if (l->gear) {
        gear_reset(l->gear, h);
        /* with a gear, the load is applied by its axles, not by the model */
        l->model.wheel_load_lb = 0.0;
    }
    record_outputs(l, way->march, 0.0);
}

/* Time at which the kick of step i begins, and time at which it ends. */
static double kick_start_time_s(const struct march *march, uint64_t i)
{
    return i == 0 ? 0.0 : ((double)i - 0.5) * march->h_s;
}

static double kick_end_time_s(const struct march *march, uint64_t i)
{
    return ((double)i + 0.5) * march->h_s;
}

/* Moves the wheel, and updates which mats are integrated. */
static void step_wheel(struct march_run *way, uint64_t i)
{
    struct planar_engine *l = way->engine;
    way->touch_count = move_gear(l, &way->wheel, kick_start_time_s(way->march, i),
                                 kick_end_time_s(way->march, i), way->touch);
    set_wheel_mat(&l->model, find_mat_under_wheel(way->touch, way->touch_count));
    if (way->omits_mats) {
        update_sliding_part(l, way->touch, way->touch_count);
        update_heaving_part(l);
        add_heaving_mats_to_sliding(l);
    }
    way->has_heaving_part = l->heaving.last >= l->heaving.first;
}

/* Computes the forces at the present positions and updates the vertical speeds. */
static void step_vertical(struct march_run *way, uint64_t i)
{
    struct planar_engine *l = way->engine;
    struct march *march = way->march;
    struct model *m = &l->model;
    double h = march->h_s, kick_s = kick_end_time_s(march, i) - kick_start_time_s(march, i);
    if (l->mods)
        brace_sliding_part(l, way->touch, way->touch_count, kick_s);
    update_tensions(l);
    if (way->has_heaving_part) {
        m->first_mat = l->heaving.first;
        m->last_mat = l->heaving.last;
        model_sample_shape_modes(m, l->z);
        if (l->brace_heaving_part)
            l->brace_heaving_part(l);
    }
    l->is_step_divided = way->has_heaving_part && way->has_divided_steps && will_node_land(l, h);
    if (l->is_step_divided) {
        double part_s = h / LANDING_STEP_PARTS;
        double first_s = 0.5 * ((i > 0 ? way->last_height_step_s : 0.0) + part_s);
        march->impact_ft_s = fmax(
            march->impact_ft_s, step_heights_in_parts(l, way->last_height_step_s < h, first_s, h));
        way->last_height_step_s = part_s;
        /* fraction of the next step's mean force that is due to the present force */
        l->next_normal_share = 0.5 * (part_s + h) / h;
    } else if (way->has_heaving_part) {
        /* after a divided step the speeds are those of only half a part before */
        double part_s = way->last_height_step_s < h ? 0.5 * (way->last_height_step_s + h) : kick_s;
        l->next_normal_share = way->last_height_step_s < h ? part_s / h : 1.0;
        march->impact_ft_s = fmax(march->impact_ft_s, kick_heaving_part(l, part_s));
        way->last_height_step_s = h;
    } else {
        way->last_height_step_s = h;
    }
}

/* Updates the speeds along the runway, then the positions. */
static void step_along_runway(struct march_run *way, uint64_t i)
{
    struct planar_engine *l = way->engine;
    struct march *march = way->march;
    struct model *m = &l->model;
    double h = march->h_s, *p = l->z, *v = l->z + m->coordinate_count;
    march->events += kick_sliding_part(l, way->touch, way->touch_count,
                                       kick_end_time_s(march, i) - kick_start_time_s(march, i));
    for (int n = l->sliding.first; n <= l->sliding.last; n++)
        p[2 * n + 1] += h * v[2 * n + 1];
    l->last_step_s = way->has_divided_steps ? h : 0.0;
    for (int j = m->first_mat; way->has_heaving_part && !l->is_step_divided && j <= m->last_mat + 1;
         j++)
        p[2 * j] += h * v[2 * j];
    int live = l->sliding.last - l->sliding.first + 1;
    march->active_mat_time_s += live * h;
    march->active_mats_max = live > march->active_mats_max ? live : march->active_mats_max;
    march->completed_step_count = i + 1;
}

/* Updates the outputs and extremes at the end t_s of step i. Returns false if the march ends with
 * this step. */
static bool update_extremes(struct march_run *way, uint64_t i, double t_s)
{
    struct march *march = way->march;
    bool due = i % STEPS_PER_SHAPE_UPDATE == 0 || i + 1 == march->step_count;
    if (due && !update_march_status(way->engine, march, t_s))
        return false;
    if (i % STEPS_PER_SHAPE_UPDATE == 0 && way->options->wave_encounter_height_ft > 0.0)
        record_encounter(way->engine, march, way->options->wave_encounter_height_ft);
    if (march->record.next_record_s <= t_s)
        record_outputs(way->engine, march, t_s);
    return true;
}

static void finish_march(struct march_run *way)
{
    struct planar_engine *l = way->engine;
    const double *v = l->z + l->model.coordinate_count;
    for (int n = l->sliding.first; n <= l->sliding.last; n++)
        way->march->speed_end_ft_s = fmax(way->march->speed_end_ft_s, fabs(v[2 * n + 1]));
    if (l->mods) {
        struct mods_view view = planar_engine_view(l);
        way->march->mods = mods_copy_end_state(l->mods, &view);
    }
}

void planar_engine_run(struct planar_engine *l, struct march *march,
                       const struct sim_options *options)
{
    struct march_run way = {.engine = l, .march = march, .options = options};
    double begin_s = monotonic_s();
    begin_march(&way);
    for (uint64_t i = 0; i < march->step_count; i++) {
        double t_s = (double)(i + 1) * march->h_s *
                     (i + 1 == march->step_count ? 1.0 + 1e-11 : 1.0);
        step_wheel(&way, i);
        step_vertical(&way, i);
        step_along_runway(&way, i);
        if (!update_extremes(&way, i, t_s))
            break;
        if (i % STEPS_PER_CALLBACK == 0 && way.options->may_continue &&
            !way.options->may_continue(way.options->may_continue_ctx, march->pass_number,
                                       (double)i / (double)march->step_count)) {
            march->status = SIM_INTERRUPTED;
            march->mat = way.engine->sliding.first + 1;
            march->t_s = t_s;
            break;
        }
    }
    finish_march(&way);
    march->ms = 1e3 * (monotonic_s() - begin_s);
}
