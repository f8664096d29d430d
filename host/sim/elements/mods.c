#include "host/sim/elements/mods.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/elementary.h"
#include "host/base/xmalloc.h"
#include "host/sim/scene/result.h"

/* Displacement of a mat. The ground, mats 0 and N+1, does not move. */
static double view_u_ft(const struct mods_view *view, int mats, int mat)
{
    return mat < 1 || mat > mats ? 0.0 : view->u_ft[mat * view->stride + view->offset];
}

static double view_v_ft_s(const struct mods_view *view, int mats, int mat)
{
    return mat < 1 || mat > mats ? 0.0 : view->v_ft_s[mat * view->stride + view->offset];
}

/* Tension of a segment, which cannot be negative: 0 if the segment is slack. */
static double clip_tension_lb(double unclipped_tension_lb)
{
    return unclipped_tension_lb > 0.0 ? unclipped_tension_lb : 0.0;
}

#define RAD_PER_DEG (3.14159265358979323846 / 180.0)

/* --- restraints --- */

/* Force of an elastic-plastic element with the given stretch. `*zero` is the stretch at which the
 * force is 0; it changes when the element yields. */
static double elastic_plastic_force(double stiffness, double cap, double stretch, double *zero)
{
    double load = stiffness * (stretch - *zero);
    if (!(fabs(load) > cap))
        return load;
    load = copysign(cap, load);
    *zero = stretch - load / stiffness;
    return load;
}

/* Properties of each kind of restraint. `can_pull_out`: a force beyond its grip pulls the restraint
 * out; its zero then follows x. `ends`: number of spring ends at the mat and its neighbours. */
static const struct restraint_kind {
    bool can_pull_out, is_tension_only;
    double spring_end_count;
} restraint_kinds[SIM_RESTRAINT_KIND_COUNT] = {
    [SIM_ANCHORS] = {true, false, 1.0},
    [SIM_TIE_DOWNS] = {true, true, 1.0},
    [SIM_ABSORBERS] = {false, false, 4.0},
};

static void reset_restraints(struct restraints *r, const struct sim_scene *scene)
{
    const struct sim_list *zero = &r->parameters->zero_ft;
    for (int i = 0; i < r->count; i++) {
        int at = mods_nth_place(r->parameters->first_place, r->parameters->spacing, i);
        double start_ft = r->kind == SIM_ABSORBERS ? sim_scene_joint_value(&scene->gap0_ft, at)
                                                   : 0.0;
        r->zero_ft[i] = zero->count > 0 ? sim_scene_joint_value(zero, i + 1) : start_ft;
        r->place[i] = at;
        r->load_lb[i] = 0.0;
        r->stretch_ft[i] = start_ft - r->zero_ft[i];
    }
}

/* Force of the i-th restraint at x, with rate x'. */
static double restraint_lb(struct restraints *r, int i, double x_ft, double rate_ft_s)
{
    const struct sim_restraint *s = r->parameters;
    const struct restraint_kind *kind = &restraint_kinds[r->kind];
    double spring_lb = s->k_lb_ft * (x_ft - r->zero_ft[i]);
    r->stretch_ft[i] = 0.0;
    if (kind->is_tension_only && !(spring_lb > 0.0))
        return 0.0;
    if (kind->can_pull_out)
        spring_lb = elastic_plastic_force(s->k_lb_ft, s->grip_lb, x_ft, &r->zero_ft[i]);
    double lb = spring_lb + s->c_lb_s_ft * rate_ft_s;
    lb = fmax(kind->is_tension_only ? 0.0 : -s->grip_lb, fmin(lb, s->grip_lb));
    r->load_lb[i] = fmax(r->load_lb[i], fabs(lb));
    r->stretch_ft[i] = x_ft - r->zero_ft[i];
    return lb;
}

static double restraints_energy_lb_ft(const struct restraints *r)
{
    const struct sim_restraint *s = r->parameters;
    double energy = 0.0;
    for (int i = 0; i < r->count; i++) {
        double stretch_ft = fabs(r->stretch_ft[i]),
               elastic_ft = fmin(stretch_ft, s->grip_lb / s->k_lb_ft);
        energy += s->k_lb_ft * elastic_ft * (stretch_ft - 0.5 * elastic_ft);
    }
    return energy;
}

/* Bands: MODIFICATIONS.md, "Bands". All bands of a group are identical; tensions are those of one
 * band. CONNECTION_SWEEPS_MAX is the largest number of passes over the connections of a group in
 * which slips are computed. */
#define CONNECTION_SWEEPS_MAX 200
#define SLIP_TOLERANCE        1e-12 /* largest slip / mat length that counts as no slip */

/* Lists the mats with rivets or anchors in ascending order. Each such mat has one brace: the sum of
 * their forces. */
static void find_braces(struct mods *m)
{
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        for (int c = 0; c < m->band[g].segment_count - 1; c++)
            m->brace_force_lb[m->band[g].connection_mat[c]] = 1.0;
    }
    const struct sim_restraint *anchors = &m->scene->mods.restraint[SIM_ANCHORS];
    for (int i = 0; i < mods_restraint_count(m->scene, SIM_ANCHORS); i++)
        m->brace_force_lb[mods_nth_place(anchors->first_place, anchors->spacing, i)] = 1.0;
    for (int mat = 1; mat <= m->mats; mat++) {
        if (m->brace_force_lb[mat] > 0.0)
            m->brace_mat[m->brace_count++] = mat;
    }
}

static void init_bands(struct mods *m, double *at)
{
    size_t segments = m->state->segment_count, connections = m->state->connection_count,
           segment = 0, connection = 0;
    double *k = at, *stretch = k + segments;
    m->band_lb = stretch + segments;
    int *mat = (int *)(m->band_lb + segments);
    m->brace_mat = mat + connections;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        int count = mods_connection_count(m->scene, g);
        if (count == 0)
            continue;
        m->band[g] = (struct mods_bands){
            .scene_bands = &m->scene->mods.band[g],
            .segment_count = count + 1,
            .connection_mat = mat + connection,
            .k_lb_ft = k + segment,
            .stretch_ft = stretch + segment,
            .tension_lb = m->band_lb + segment,
            .min_lb = m->state->band_min_lb + segment,
            .max_lb = m->state->band_max_lb + segment,
            .slip_ft = m->state->band_slip_ft + connection,
            .load_lb = m->state->band_load_lb + connection,
            .is_pulled_out = m->state->band_pulled_out + connection,
            .is_riveted = m->state->band_mat + connection,
        };
        for (int c = 0; c < count; c++)
            m->band[g].connection_mat[c] = mods_nth_place(m->band[g].scene_bands->first_mat,
                                                          m->band[g].scene_bands->spacing, c);
        segment += (size_t)count + 1;
        connection += (size_t)count;
    }
    find_braces(m);
}

static double unclipped_tension_lb(const struct mods *m, const struct mods_bands *b,
                                   const struct mods_view *view, int segment)
{
    int right = segment < b->segment_count - 1 ? b->connection_mat[segment] : m->mats + 1;
    int left = segment > 0 ? b->connection_mat[segment - 1] : 0;
    double longer_ft = view_u_ft(view, m->mats, right) - view_u_ft(view, m->mats, left);
    return b->k_lb_ft[segment] * (b->stretch_ft[segment] + longer_ft);
}

static double grip_lb(const struct mods_bands *b, int connection)
{
    return b->is_pulled_out[connection] != 0.0 ? 0.0 : b->scene_bands->grip_lb;
}

/* Returns the length of band, ft, that slides from segment `from` to segment `to` until their
 * tensions differ by the grip. A slack segment first loses its slack without tension. */
static double sliding_length_ft(const struct mods_bands *b, int from, int to, double grip)
{
    double t_from = b->tension_lb[from], t_to = b->tension_lb[to];
    double k_from = b->k_lb_ft[from], k_to = b->k_lb_ft[to];
    /* sliding length if the segment `to` remains slack */
    double to_limit_ft = (t_from - grip) / k_from;
    return t_to + k_to * to_limit_ft <= 0.0 ? to_limit_ft
                                            : (t_from - t_to - grip) / (k_from + k_to);
}

/* Slides the band through one connection until the connection holds. Returns the slip. */
static double slide_connection(struct mods_bands *b, int c)
{
    double grip = grip_lb(b, c);
    double difference = clip_tension_lb(b->tension_lb[c + 1]) - clip_tension_lb(b->tension_lb[c]);
    if (!(fabs(difference) > grip))
        return 0.0;
    int from = difference > 0.0 ? c + 1 : c, to = difference > 0.0 ? c : c + 1;
    double s = sliding_length_ft(b, from, to, grip);
    b->stretch_ft[from] -= s;
    b->stretch_ft[to] += s;
    b->tension_lb[from] -= b->k_lb_ft[from] * s;
    b->tension_lb[to] += b->k_lb_ft[to] * s;
    b->slip_ft[c] += s;
    return s;
}

/* Slides the bands of a group. Slip at one connection changes the tension at the next, so passes
 * over all connections alternate in direction until nothing slips. */
static void slide_connections(const struct mods *m, struct mods_bands *b)
{
    for (int sweep = 0; sweep < CONNECTION_SWEEPS_MAX; sweep++) {
        double most_ft = 0.0;
        for (int i = 0; i < b->segment_count - 1; i++)
            most_ft = fmax(most_ft, slide_connection(b, sweep % 2 ? b->segment_count - 2 - i : i));
        if (!(most_ft > SLIP_TOLERANCE * m->scene->length_ft))
            return;
    }
}

/* Loads the rivets near the wheel: it tilts a riveted mat by band_tilt against the band on both
 * sides, which pulls the rivets perpendicular to the mat. A rivet whose hole is worn by slip has
 * less strength. */
static void update_rivet_loads(struct mods_bands *b, const struct sim_touch *touch, int count)
{
    const struct sim_bands *s = b->scene_bands;
    int first = b->connection_mat[0];
    for (int i = 0; i < count; i++) {
        int c = (touch[i].mat - first) / s->spacing;
        if (touch[i].mat < first || (touch[i].mat - first) % s->spacing != 0 ||
            c >= b->segment_count - 1)
            continue;
        double across_lb = s->mat_tilt_rad * (clip_tension_lb(b->tension_lb[c]) +
                                              clip_tension_lb(b->tension_lb[c + 1]));
        double worn = b->slip_ft[c] / s->hole_wear_ft;
        if (across_lb > s->rivet_pull_lb * (worn < 1.0 ? 1.0 - worn : 0.0))
            b->is_pulled_out[c] = 1.0;
    }
}

/* Updates the smallest and largest tensions, and adds the forces of the group to its mats. */
static void update_extremes(struct mods *m, const struct mods_bands *b)
{
    for (int i = 0; i < b->segment_count; i++) {
        b->min_lb[i] = b->tension_lb[i] < b->min_lb[i] ? b->tension_lb[i] : b->min_lb[i];
        b->max_lb[i] = b->tension_lb[i] > b->max_lb[i] ? b->tension_lb[i] : b->max_lb[i];
    }
    for (int c = 0; c < b->segment_count - 1; c++) {
        double carried_lb = clip_tension_lb(b->tension_lb[c + 1]) -
                            clip_tension_lb(b->tension_lb[c]);
        if (fabs(carried_lb) > b->load_lb[c])
            b->load_lb[c] = fabs(carried_lb);
        m->brace_force_lb[b->connection_mat[c]] += b->scene_bands->count * carried_lb;
    }
}

/* Sets the bands of a group to their state at the start of the scene. A segment ends in the middle
 * of the mats to which it is riveted. The outer segments end at the anchor springs, at the ends of
 * the runway. */
static void reset_band_group(const struct mods *m, struct mods_bands *b)
{
    const struct sim_scene *scene = m->scene;
    const struct sim_bands *s = b->scene_bands;
    double ea_lb = s->area_ft2 * s->e_lb_ft2;
    for (int c = 0; c < b->segment_count - 1; c++) {
        b->slip_ft[c] = s->slipped_ft.count ? sim_scene_joint_value(&s->slipped_ft, c + 1) : 0.0;
        b->is_pulled_out[c] = 0.0;
        b->load_lb[c] = 0.0;
        b->is_riveted[c] = b->connection_mat[c];
        for (size_t i = 0; i < s->pulled.count; i++)
            b->is_pulled_out[c] = s->pulled.values[i] == b->connection_mat[c] ? 1.0
                                                                              : b->is_pulled_out[c];
    }
    for (int i = 0; i < b->segment_count; i++) {
        double from_ft = i > 0 ? (b->connection_mat[i - 1] - 0.5) * scene->length_ft : 0.0;
        double to_ft = i < b->segment_count - 1 ? (b->connection_mat[i] - 0.5) * scene->length_ft
                                                : m->mats * scene->length_ft;
        double give_ft_lb = (to_ft - from_ft) / ea_lb;
        if (i == 0 || i == b->segment_count - 1)
            give_ft_lb += 1.0 / s->k_lb_ft;
        b->k_lb_ft[i] = 1.0 / give_ft_lb;
        b->stretch_ft[i] = sim_scene_joint_value(&s->initial_tension_lb, i + 1) * give_ft_lb -
                           s->thermal_expansion_per_degf * s->temperature_rise_degf *
                               (to_ft - from_ft);
        b->tension_lb[i] = b->k_lb_ft[i] * b->stretch_ft[i];
        b->min_lb[i] = (double)INFINITY;
        b->max_lb[i] = -(double)INFINITY;
    }
}

/* Updates the bands from the positions of the mats. If `view` is NULL, resets them to the start of
 * the scene. */
void mods_apply_bands(struct mods *m, const struct mods_view *view, const struct sim_touch *touch,
                      int count)
{
    for (int i = 0; i < m->brace_count; i++)
        m->brace_force_lb[m->brace_mat[i]] = 0.0;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        struct mods_bands *b = &m->band[g];
        if (b->segment_count == 0)
            continue;
        if (!view)
            reset_band_group(m, b);
        for (int i = 0; view && i < b->segment_count; i++)
            b->tension_lb[i] = unclipped_tension_lb(m, b, view, i);
        if (view && b->scene_bands->rivet_pull_lb < HUGE_VAL)
            update_rivet_loads(b, touch, count);
        slide_connections(m, b);
        update_extremes(m, b);
    }
    struct restraints *anchors = &m->restraint[SIM_ANCHORS];
    for (int i = 0; i < anchors->count; i++) {
        int mat = (int)anchors->place[i];
        double u_ft = view ? view_u_ft(view, m->mats, mat) : 0.0,
               v_ft_s = view ? view_v_ft_s(view, m->mats, mat) : 0.0;
        m->brace_force_lb[mat] -= restraint_lb(anchors, i, u_ft, v_ft_s);
    }
}

static double mods_band_energy_lb_ft(const struct mods *m, const struct mods_view *view)
{
    double energy = 0.0;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        const struct mods_bands *b = &m->band[g];
        double of_one = 0.0;
        for (int i = 0; i < b->segment_count; i++) {
            double t_lb = clip_tension_lb(unclipped_tension_lb(m, b, view, i));
            of_one += 0.5 * t_lb * t_lb / b->k_lb_ft[i];
        }
        energy += b->segment_count > 0 ? b->scene_bands->count * of_one : 0.0;
    }
    return energy;
}

/* --- state --- */

static void assign_state_arrays(struct mods_state *s)
{
    double *at = s->values;
    double **per_segment[] = {&s->band_lb, &s->band_min_lb, &s->band_max_lb};
    double **per_connection[] = {&s->band_slip_ft, &s->band_load_lb, &s->band_pulled_out,
                                 &s->band_mat};
    double **per_cleat[] = {&s->cleat_remaining_share, &s->cleat_mat};
    double **per_restraint[] = {&s->restraint_zero_ft, &s->restraint_load_lb, &s->restraint_places};
    double **per_joint[] = {&s->stiffener_gap_ft, &s->torn};
    for (size_t i = 0; i < 3; i++, at += s->segment_count)
        *per_segment[i] = at;
    for (size_t i = 0; i < 4; i++, at += s->connection_count)
        *per_connection[i] = at;
    for (size_t i = 0; i < 2; i++, at += s->cleat_count)
        *per_cleat[i] = at;
    for (size_t i = 0; i < 3; i++, at += s->restraint_count)
        *per_restraint[i] = at;
    for (size_t i = 0; i < 2; i++, at += s->joint_count + 1)
        *per_joint[i] = at;
    s->value_count = (size_t)(at - s->values);
}

static struct mods_state *make_state(const struct sim_scene *scene)
{
    size_t connections = 0, segments = 0, cleats = (size_t)mods_cleat_count(scene),
           joints = (size_t)scene->mats + 1, restraints = 0;
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; k++)
        restraints += (size_t)mods_restraint_count(scene, k);
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        size_t of_group = (size_t)mods_connection_count(scene, g);
        connections += of_group;
        segments += of_group > 0 ? of_group + 1 : 0;
    }
    size_t count = 3 * segments + 4 * connections + 2 * cleats + 3 * restraints + 2 * (joints + 1);
    struct mods_state *s = xcalloc(1, sizeof *s + count * sizeof s->values[0]);
    s->segment_count = segments;
    s->connection_count = connections;
    s->cleat_count = cleats;
    s->joint_count = joints;
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; k++)
        s->restraint_counts[k] = (size_t)mods_restraint_count(scene, k);
    s->restraint_count = restraints;
    assign_state_arrays(s);
    return s;
}

struct mods_state *mods_copy_end_state(struct mods *m, const struct mods_view *view)
{
    const struct mods_state *from = m->state;
    size_t size = sizeof *from + from->value_count * sizeof from->values[0];
    if (m->has_bands)
        mods_apply_bands(m, view, NULL, 0);
    for (size_t i = 0; i < from->segment_count; i++)
        from->band_lb[i] = m->band_lb[i];
    for (int j = 1; m->has_stiffeners && j <= m->mats + 1; j++)
        from->stiffener_gap_ft[j] = m->spring_gap_ft[j];
    struct mods_state *copy = xmalloc(size);
    memcpy(copy, from, size);
    assign_state_arrays(copy);
    return copy;
}

double mods_difference_lb(const struct mods_state *a, const struct mods_state *b)
{
    double most = 0.0;
    /* the first three arrays: tension, smallest tension, largest tension */
    for (size_t i = 0; i < 3 * a->segment_count; i++)
        most = fmax(most, fabs(a->values[i] - b->values[i]));
    return most;
}

/* --- making --- */

static void assign_arrays(struct mods *m)
{
    size_t joints = (size_t)m->mats + 2;
    double *at = m->storage;
    double **per_joint[] = {&m->spring_lb_ft,        &m->spring_gap_ft,
                            &m->spring_cap_lb,       &m->bending_stiffness_lb_ft_rad,
                            &m->bending_yield_lb_ft, &m->bending_zero_rad,
                            &m->hull_points,         &m->cleat_rise_ft,
                            &m->brace_force_lb,      &m->saved_thrust_lb};
    for (size_t i = 0; i < 10; i++, at += joints)
        *per_joint[i] = at;
    m->restraint_stretch_ft = at;
    at += m->state->restraint_count;
    if (m->has_bands)
        init_bands(m, at);
    size_t before = 0;
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; k++) {
        const struct sim_restraint *made = &m->scene->mods.restraint[k];
        double ends = m->state->restraint_counts[k] > 0 ? restraint_kinds[k].spring_end_count : 0.0;
        m->restraint[k] = (struct restraints){
            .kind = k,
            .parameters = made,
            .row_k_lb_ft = ends * made->k_lb_ft,
            .row_c_lb_s_ft = ends * made->c_lb_s_ft,
            .count = (int)m->state->restraint_counts[k],
            .zero_ft = m->state->restraint_zero_ft + before,
            .load_lb = m->state->restraint_load_lb + before,
            .place = m->state->restraint_places + before,
            .stretch_ft = m->restraint_stretch_ft + before,
        };
        before += m->state->restraint_counts[k];
    }
}

struct mods *mods_make(const struct sim_scene *scene)
{
    const struct sim_mods *s = &scene->mods;
    bool anchored = mods_restraint_count(scene, SIM_ANCHORS) > 0;
    bool sprung = scene->left_end == SIM_END_SPRING || scene->right_end == SIM_END_SPRING;
    if (!mods_are_present(scene))
        return NULL;
    struct mods *m = xmalloc(sizeof *m);
    *m = (struct mods){
        .scene = scene,
        .has_bands = s->band[0].count > 0.0 || s->band[1].count > 0.0 || anchored,
        .has_cleats = mods_cleat_count(scene) > 0 && s->cleat_hold_lb > 0.0,
        .has_stiffeners = s->stiffener_span_mats > 1,
        .has_diagonal_lay = s->lay_deg > 0.0 && (s->lay_slide_lb > 0.0 || s->lay_mu > 0.0),
        .can_tear = s->tear_lb < HUGE_VAL || s->torn.count > 0,
        .mats = scene->mats,
        .cleat_count = mods_cleat_count(scene),
        .state = make_state(scene),
    };
    m->has_joint_springs = m->has_stiffeners || m->has_diagonal_lay || m->can_tear || sprung ||
                           m->state->restraint_counts[SIM_ABSORBERS] > 0;
    m->acts_vertically = m->has_bands || m->has_stiffeners ||
                         m->state->restraint_counts[SIM_TIE_DOWNS] > 0;
    size_t bands = 3 * m->state->segment_count + 2 * m->state->connection_count +
                   2 * m->state->restraint_count;
    m->storage = xcalloc(bands + 10 * ((size_t)m->mats + 2), sizeof(double));
    assign_arrays(m);
    mods_reset(m);
    return m;
}

void mods_free(struct mods *m)
{
    if (!m)
        return;
    free(m->state);
    free(m->storage);
    free(m);
}

/* Number of stiffener lines that cross a joint. Line k = 0, 1, ... connects the mats first + k
 * period to first + k period + span - 1. The lines are staggered evenly across the strip. */
static int count_stiffener_lines(const struct sim_mods *s, int joint)
{
    int period = s->stiffener_span_mats - 1 +
                 (s->stiffener_free_joints > 0 ? s->stiffener_free_joints : 1),
        lines = 0;
    for (int line = 0; line < s->stiffener_line_count; line++) {
        /* position of the mat at the left of the joint, counted from the start of its stiffener */
        int at = joint - 1 - (s->stiffener_first_mat + line * period / s->stiffener_line_count);
        lines += at >= 0 && at % period < s->stiffener_span_mats - 1;
    }
    return lines;
}

/* Angle of a joint between two mats that lie on uneven ground. */
static double initial_joint_angle_rad(const struct sim_scene *scene, int joint)
{
    const double *ground_ft = scene->ground_ft.values;
    if (!ground_ft || joint < 2 || joint > scene->mats)
        return 0.0;
    double left = (ground_ft[joint - 2] - ground_ft[joint - 1]) / scene->length_ft;
    double right = (ground_ft[joint - 1] - ground_ft[joint]) / scene->length_ft;
    return elementary_asin(right) - elementary_asin(left);
}

static void reset_joints(struct mods *m)
{
    const struct sim_mods *s = &m->scene->mods;
    double tangent = elementary_tan(s->lay_deg * RAD_PER_DEG);
    for (int j = 1; j <= m->mats + 1; j++) {
        /* the mats at the ends have no stiffeners to the ground */
        bool inner = j > 1 && j <= m->mats;
        m->spring_gap_ft[j] = sim_scene_joint_value(&m->scene->gap0_ft, j);
        if (m->has_stiffeners && inner) {
            int lines = count_stiffener_lines(s, j);
            m->spring_lb_ft[j] = lines * s->stiffener_k_lb_ft;
            m->spring_cap_lb[j] = lines > 0 ? lines * s->stiffener_grip_lb : 0.0;
            m->bending_stiffness_lb_ft_rad[j] = lines * s->stiffener_kt_lb_ft_rad;
            m->bending_yield_lb_ft[j] = lines > 0 ? lines * s->stiffener_yield_lb_ft : 0.0;
            if (s->stiffener_gap0_ft.count > 0)
                m->spring_gap_ft[j] = sim_scene_joint_value(&s->stiffener_gap0_ft, j);
        } else if (m->has_diagonal_lay && inner) {
            m->spring_lb_ft[j] = m->scene->kl_lb_ft * tangent * tangent;
            m->spring_cap_lb[j] = s->lay_slide_lb * elementary_sin(s->lay_deg * RAD_PER_DEG);
        } else if (!inner &&
                   (j == 1 ? m->scene->left_end : m->scene->right_end) == SIM_END_SPRING) {
            m->spring_lb_ft[j] = m->scene->end_k_lb_ft[j > 1];
            m->spring_cap_lb[j] = (double)INFINITY;
        }
        m->bending_zero_rad[j] = initial_joint_angle_rad(m->scene, j);
        m->state->torn[j] = 0.0;
    }
    for (size_t i = 0; i < s->torn.count; i++)
        m->state->torn[(int)s->torn.values[i]] = 1.0;
}

void mods_reset(struct mods *m)
{
    const struct sim_mods *s = &m->scene->mods;
    for (int i = 0; i < m->cleat_count; i++) {
        m->state->cleat_remaining_share[i] =
            s->cleat_remaining_share.count ? sim_scene_joint_value(&s->cleat_remaining_share, i + 1)
                                           : 1.0;
        m->state->cleat_mat[i] = mods_nth_place(s->cleat_first, s->cleat_every, i);
        m->cleat_rise_ft[i] = 0.0;
    }
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; k++)
        reset_restraints(&m->restraint[k], m->scene);
    if (m->has_joint_springs)
        reset_joints(m);
    if (m->has_bands)
        mods_apply_bands(m, NULL, NULL, 0);
}

/* --- cleats --- */

static int find_cleat_of_mat(const struct mods *m, int mat)
{
    if (!m->has_cleats)
        return -1;
    int first = (int)m->state->cleat_mat[0], every = m->scene->mods.cleat_every;
    return mat >= first && (mat - first) % every == 0 ? (mat - first) / every : -1;
}

double mods_cleat_hold_lb(const struct mods *m, int mat)
{
    int cleat = find_cleat_of_mat(m, mat);
    return cleat < 0 ? 0.0 : m->scene->mods.cleat_hold_lb * m->state->cleat_remaining_share[cleat];
}

/* Reduces the hold of cleats on moving mats: the soil behind a cleat yields, and the cleat
 * bends. */
void mods_wear_cleats(struct mods *m, const struct mods_view *view, double h_s, int first, int last)
{
    const struct sim_mods *s = &m->scene->mods;
    int begin = (int)m->state->cleat_mat[0], every = s->cleat_every;
    int from = first > begin ? (first - begin + every - 1) / every : 0;
    for (int i = from; i < m->cleat_count && begin + i * every <= last; i++) {
        double moved_ft = fabs(view_v_ft_s(view, m->mats, begin + i * every)) * h_s;
        if (moved_ft > 0.0)
            m->state->cleat_remaining_share[i] *= elementary_exp(-moved_ft / s->cleat_travel_ft);
    }
}

/* --- joints --- */

static double joint_opening_ft(const struct mods *m, const struct mods_view *view, int j)
{
    return sim_scene_joint_value(&m->scene->gap0_ft, j) + view_u_ft(view, m->mats, j) -
           view_u_ft(view, m->mats, j - 1);
}

static void update_absorber_loads(struct mods *m, const struct mods_view *view, int first, int last)
{
    struct restraints *r = &m->restraint[SIM_ABSORBERS];
    for (int i = 0; i < r->count; i++) {
        int j = (int)r->place[i];
        double rate_ft_s = view_v_ft_s(view, m->mats, j) - view_v_ft_s(view, m->mats, j - 1);
        if (j >= first && j <= last)
            view->tension_lb[j - view->joint_offset] +=
                restraint_lb(r, i, joint_opening_ft(m, view, j), rate_ft_s);
    }
}

void mods_add_joint_forces(struct mods *m, const struct mods_view *view, int first, int last)
{
    const struct sim_mods *s = &m->scene->mods;
    double tangent = m->has_diagonal_lay ? elementary_tan(s->lay_deg * RAD_PER_DEG) : 0.0;
    for (int j = first < 1 ? 1 : first; j <= last && j <= m->mats + 1; j++) {
        double *tension_lb = &view->tension_lb[j - view->joint_offset];
        double own_lb = *tension_lb;
        if (m->can_tear && own_lb > s->tear_lb)
            m->state->torn[j] = 1.0;
        if (m->can_tear && m->state->torn[j] != 0.0 && own_lb > 0.0)
            *tension_lb = own_lb = 0.0;
        if (m->spring_lb_ft[j] > 0.0) {
            double cap_lb = m->spring_cap_lb[j] + s->lay_mu * tangent * fabs(own_lb);
            *tension_lb += elastic_plastic_force(
                m->spring_lb_ft[j], cap_lb, joint_opening_ft(m, view, j), &m->spring_gap_ft[j]);
        }
    }
    update_absorber_loads(m, view, first, last);
}

bool mods_is_torn(const struct mods *m, int joint)
{
    return m->can_tear && m->state->torn[joint] != 0.0;
}

/* Bending moment of the stiffeners at a joint that is turned by angle_rad. */
static double mods_moment_lb_ft(struct mods *m, int joint, double angle_rad)
{
    if (!(m->bending_stiffness_lb_ft_rad[joint] > 0.0))
        return 0.0;
    return elastic_plastic_force(m->bending_stiffness_lb_ft_rad[joint],
                                 m->bending_yield_lb_ft[joint], angle_rad,
                                 &m->bending_zero_rad[joint]);
}

/* --- all modifications --- */

double mods_energy_lb_ft(const struct mods *m, const struct mods_view *view)
{
    double energy = m->has_bands ? mods_band_energy_lb_ft(m, view) : 0.0;
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; k++)
        energy += restraints_energy_lb_ft(&m->restraint[k]);
    for (int j = 1; m->has_joint_springs && j <= m->mats + 1; j++) {
        double g_ft = joint_opening_ft(m, view, j) - m->spring_gap_ft[j];
        energy += 0.5 * m->spring_lb_ft[j] * g_ft * g_ft;
    }
    return energy;
}

double mods_stiffness_lb_ft(const struct mods *m)
{
    double spring = 0.0, bands = 0.0;
    for (int j = 1; m->has_joint_springs && j <= m->mats + 1; j++)
        spring = fmax(spring, m->spring_lb_ft[j]);
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        const struct mods_bands *b = &m->band[g];
        double most = 0.0;
        for (int i = 0; i < b->segment_count - 1; i++)
            most = fmax(most, b->k_lb_ft[i] + b->k_lb_ft[i + 1]);
        bands += most > 0.0 ? 2.0 * b->scene_bands->count * most : 0.0;
    }
    return 4.0 * spring + bands + m->restraint[SIM_ANCHORS].row_k_lb_ft +
           m->restraint[SIM_ABSORBERS].row_k_lb_ft;
}

double mods_damping_lb_s_ft(const struct mods *m)
{
    return m->restraint[SIM_ANCHORS].row_c_lb_s_ft + m->restraint[SIM_ABSORBERS].row_c_lb_s_ft;
}

void mods_describe(const struct mods *m, struct sim_result *result)
{
    const struct sim_mods *s = &m->scene->mods;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        const struct mods_bands *b = &m->band[g];
        if (b->segment_count > 0)
            sim_result_add_note(
                result, "%g bands, each riveted to %d mats; stiffness between rivets: %.4g lb/ft",
                b->scene_bands->count, b->segment_count - 1, b->k_lb_ft[b->segment_count / 2]);
    }
    if (m->has_cleats)
        sim_result_add_note(
            result,
            "%d cleats, each with a holding force of %g lb when new (friction of a mat: %g lb)",
            m->cleat_count, s->cleat_hold_lb, m->scene->friction * m->scene->weight_lb);
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; k++) {
        const struct restraints *r = &m->restraint[k];
        if (r->count > 0)
            sim_result_add_note(result, "%ss: %d, %g lb/ft each%s", mods_restraint_name(r->kind),
                                r->count, r->parameters->k_lb_ft,
                                k == SIM_TIE_DOWNS && m->scene->model == SIM_MODEL_CHAIN
                                    ? "; no effect in model chain, in which mats do not rise"
                                    : "");
    }
    if (m->has_stiffeners)
        sim_result_add_note(result, "%d line(s) of stiffeners over %d mats each; model %s",
                            s->stiffener_line_count, s->stiffener_span_mats,
                            m->scene->model == SIM_MODEL_CHAIN
                                ? "chain: the stiffeners stretch, but do not bend"
                                : "consistent");
    if (m->has_diagonal_lay)
        sim_result_add_note(result,
                            "the joints at %g degrees slide at %g lb + %g times the joint load",
                            s->lay_deg, s->lay_slide_lb, s->lay_mu);
}

/* Vertical forces of the modifications on mats that rise: bands over a wave, bent stiffeners,
 * cleats that leave the ground (MODIFICATIONS.md). */

/* In the functions below, mats and nodes count from 0, as in the planar model, and Y points down. A
 * mat outside the heaving part (the mats that move vertically) is on the ground. */
static double mat_height_slope(const struct mods_heaving_part *h, int n)
{
    if (n < 0 || n >= h->mats)
        return 0.0;
    if (n < h->first || n > h->last)
        return h->rest_tilt_ft[n] / h->length_ft;
    double tilt_ft = h->tilt_ft ? h->tilt_ft[n] : 0.0;
    return (h->z[2 * n + 2] - h->z[2 * n] + tilt_ft) / h->length_ft;
}

static double group_tension_lb(const struct mods_bands *b, int segment)
{
    return b->scene_bands->count * clip_tension_lb(b->tension_lb[segment]);
}

/* Finds the segment that spans node j, which is between mats j and j + 1 (mats counted from 1). */
static int find_segment_over_joint(const struct mods_bands *b, int j)
{
    int first = b->connection_mat[0], every = b->scene_bands->spacing;
    int before = j < first ? 0 : (j - first) / every + 1; /* number of rivets in mats 1 to j */
    return before < b->segment_count ? before : b->segment_count - 1;
}

/* Adds the forces of a band that follows the mats. At a crest it presses down with T times the
 * change of angle: 2 T h/L for a wave of two mats. */
static void add_crest_forces(const struct mods_bands *b, const struct mods_heaving_part *h)
{
    for (int j = h->first + 1; j <= h->last; j++) {
        double kink = mat_height_slope(h, j) - mat_height_slope(h, j - 1);
        if (kink > 0.0)
            h->down_lb[j] += group_tension_lb(b, find_segment_over_joint(b, j)) * kink;
    }
}

static double node_height_ft(const struct mods_heaving_part *h, int node)
{
    double ground_ft = h->ground_ft ? h->ground_ft[node] : 0.0;
    if (node >= h->first && node <= h->last + 1)
        return ground_ft - h->z[2 * node];
    return ground_ft - h->rest_ft[node];
}

/* Height of the band at a node, or at the middle of a riveted mat. `at`: position in mats from the
 * left end. */
static double height_at_ft(const struct mods_heaving_part *h, double at)
{
    int node = (int)floor(at);
    double left_ft = node_height_ft(h, node);
    return at > node ? 0.5 * (left_ft + node_height_ft(h, node + 1)) : left_ft;
}

static void add_node_force(const struct mods_heaving_part *h, double at, double down_lb)
{
    int node = (int)floor(at);
    bool middle = at > node;
    for (int j = node; j <= node + middle; j++) {
        if (j >= h->first && j <= h->last + 1)
            h->down_lb[j] += middle ? 0.5 * down_lb : down_lb;
    }
}

static double height_slope_between(const struct mods_heaving_part *h, double from, double to)
{
    return (height_at_ft(h, to) - height_at_ft(h, from)) / ((to - from) * h->length_ft);
}

/* Adds the forces of a band that is free between its rivets. The band takes the shortest path over
 * the nodes between the rivets. */
static void add_band_node_forces(const struct mods *m, const struct mods_bands *b,
                                 const struct mods_heaving_part *h, int segment)
{
    double t_lb = group_tension_lb(b, segment), *line = m->hull_points;
    double from = segment > 0 ? b->connection_mat[segment - 1] - 0.5 : 0.0;
    double to = segment < b->segment_count - 1 ? b->connection_mat[segment] - 0.5 : m->mats;
    int count = 1;
    if (!(t_lb > 0.0) || to <= h->first || from >= h->last + 1 || !(to > from))
        return;
    line[0] = from;
    for (int j = (int)floor(from) + 1; j < to + 1.0; j++) {
        double at = j < to ? j : to;
        while (count > 1 && height_slope_between(h, line[count - 2], line[count - 1]) <=
                                height_slope_between(h, line[count - 1], at))
            count--;
        line[count++] = at;
        if (at == to)
            break;
    }
    for (int i = 0; i + 1 < count; i++) {
        double pulled_lb = t_lb * height_slope_between(h, line[i], line[i + 1]);
        add_node_force(h, line[i], -pulled_lb);
        add_node_force(h, line[i + 1], pulled_lb);
    }
}

/* Adds the forces of tie-downs, which act on the middles of their mats. Their speeds are computed
 * from the rates of the node heights. */
static void add_tie_down_forces(struct restraints *r, const struct mods_heaving_part *h)
{
    const double *v = h->z + 2 * h->mats + 1;
    for (int i = 0; i < r->count; i++) {
        int n = (int)r->place[i] - 1;
        if (n < h->first || n > h->last)
            continue;
        double rise_ft = 0.5 * (h->rest_ft[n] + h->rest_ft[n + 1] - h->z[2 * n] - h->z[2 * n + 2]);
        double half_lb = 0.5 * restraint_lb(r, i, rise_ft, -0.5 * (v[2 * n] + v[2 * n + 2]));
        h->down_lb[n] += half_lb;
        h->down_lb[n + 1] += half_lb;
    }
}

void mods_compute_vertical_forces(struct mods *m, const struct mods_heaving_part *h)
{
    for (int j = h->first; j <= h->last + 1; j++) {
        h->down_lb[j] = 0.0;
        h->moment_lb_ft[j] = m->has_stiffeners
                               ? mods_moment_lb_ft(m, j + 1,
                                                   elementary_asin(mat_height_slope(h, j)) -
                                                       elementary_asin(mat_height_slope(h, j - 1)))
                               : 0.0;
    }
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        const struct mods_bands *b = &m->band[g];
        if (b->segment_count > 0 && b->scene_bands->acts_on == SIM_BAND_OVER_JOINTS)
            add_crest_forces(b, h);
        for (int i = 0; i < b->segment_count && b->scene_bands->acts_on == SIM_BAND_OVER_RIVETS;
             i++)
            add_band_node_forces(m, b, h, i);
    }
    add_tie_down_forces(&m->restraint[SIM_TIE_DOWNS], h);
}

double mods_rate_squared(const struct mods *m, double mass_slug, double inertia)
{
    double length_ft = m->scene->length_ft, turn = 0.0, pull_lb = 0.0;
    double lightest = fmin(mass_slug, 4.0 * inertia / (length_ft * length_ft));
    for (int j = 1; m->has_stiffeners && j <= m->mats + 1; j++)
        turn = fmax(turn, m->bending_stiffness_lb_ft_rad[j]);
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        double most_lb = 0.0;
        for (int i = 0; i < m->band[g].segment_count; i++)
            most_lb = fmax(most_lb, group_tension_lb(&m->band[g], i));
        pull_lb += most_lb;
    }
    double damping = 2.0 * mods_damping_lb_s_ft(m) / mass_slug +
                     2.0 * m->restraint[SIM_TIE_DOWNS].row_c_lb_s_ft / lightest;
    return mods_stiffness_lb_ft(m) / mass_slug + 4.0 * turn / inertia +
           2.0 * pull_lb * 4.0 / (length_ft * lightest) + damping * damping +
           m->restraint[SIM_TIE_DOWNS].row_k_lb_ft / lightest;
}

/* Returns the share of a cleat's hold that remains after the wheel presses the cleat back into the
 * soil. `out` is the share of its depth that was out of the soil. The tip of the cleat stays in
 * place, so the cleat bends at its root by an angle with cos(angle) = 1 - out. A part of this
 * bending springs back. */
static double remaining_hold_share(const struct sim_mods *s, double out)
{
    if (!(s->cleat_exponent > 0.0))
        return 1.0 - out;
    double bent = elementary_acos(1.0 - out) - s->cleat_spring_deg * RAD_PER_DEG;
    return bent > 0.0 ? elementary_pow(elementary_cos(bent), s->cleat_exponent) : 1.0;
}

double mods_raised_cleat_hold_lb(struct mods *m, int mat, double left_y_ft, double right_y_ft)
{
    int cleat = find_cleat_of_mat(m, mat);
    if (cleat < 0)
        return 0.0;
    const struct sim_mods *s = &m->scene->mods;
    double raised_ft = -0.5 * (left_y_ft + right_y_ft);
    raised_ft = raised_ft > 0.0 ? fmin(raised_ft, s->cleat_depth_ft) : 0.0;
    double in = 1.0 - raised_ft / s->cleat_depth_ft;
    m->cleat_rise_ft[cleat] = fmax(m->cleat_rise_ft[cleat], raised_ft);
    double whole_lb = s->cleat_hold_lb * m->state->cleat_remaining_share[cleat];
    return s->cleat_exponent > 0.0 ? whole_lb * elementary_pow(in, s->cleat_exponent)
                                   : whole_lb * in * in;
}

/* Presses raised cleats under the wheel back into the soil. The part of a cleat that was out of the
 * soil bends. */
void mods_bend_raised_cleats(struct mods *m, const struct sim_touch *touch, int count)
{
    for (int i = 0; i < count; i++) {
        int cleat = find_cleat_of_mat(m, touch[i].mat);
        if (cleat < 0 || !(m->cleat_rise_ft[cleat] > 0.0))
            continue;
        const struct sim_mods *s = &m->scene->mods;
        m->state->cleat_remaining_share[cleat] *=
            remaining_hold_share(s, m->cleat_rise_ft[cleat] / s->cleat_depth_ft);
        m->cleat_rise_ft[cleat] = 0.0;
    }
}

/* Copies the numbers whose flag is set to the list. */
static void set_list_of_flagged_numbers(struct sim_list *list, const double *flags,
                                        const double *numbers, size_t count)
{
    double *found = xcalloc(count + 1, sizeof *found);
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        if (flags[i] != 0.0)
            found[n++] = numbers ? numbers[i] : (double)i;
    }
    sim_scene_set_list(list, found, n);
    free(found);
}

void mods_carry_over(struct sim_scene *scene, const struct sim_result *result)
{
    const struct mods_state *s = result->mods;
    struct sim_mods *m = &scene->mods;
    size_t segment = 0, connection = 0;
    if (!s)
        return;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        struct sim_bands *b = &m->band[g];
        size_t count = (size_t)mods_connection_count(scene, g);
        if (count == 0)
            continue;
        sim_scene_set_list(&b->initial_tension_lb, s->band_lb + segment, count + 1);
        sim_scene_set_list(&b->slipped_ft, s->band_slip_ft + connection, count);
        set_list_of_flagged_numbers(&b->pulled, s->band_pulled_out + connection,
                                    s->band_mat + connection, count);
        b->temperature_rise_degf = 0.0;
        segment += count + 1;
        connection += count;
    }
    if (m->cleat_every > 0)
        sim_scene_set_list(&m->cleat_remaining_share, s->cleat_remaining_share, s->cleat_count);
    if (m->stiffener_span_mats > 1)
        sim_scene_set_list(&m->stiffener_gap0_ft, s->stiffener_gap_ft + 1, (size_t)scene->mats + 1);
    for (int k = 0, i = 0; k < SIM_RESTRAINT_KIND_COUNT; k++) {
        struct sim_list *zero = &m->restraint[k].zero_ft;
        size_t count = s->restraint_counts[k];
        if (count > 0)
            sim_scene_set_list(zero, s->restraint_zero_ft + i, count);
        /* movements of the next landing are measured from the present positions of the mats */
        for (size_t c = 0; c < count && k == SIM_ANCHORS; c++)
            zero->values[c] -= result->u_ft[(int)s->restraint_places[c]];
        i += (int)count;
    }
    if (m->tear_lb < HUGE_VAL)
        set_list_of_flagged_numbers(&m->torn, s->torn, NULL, s->joint_count + 1);
}
