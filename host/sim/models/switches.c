/* The switches of a model: the end of a mode's validity, and the effect of a change. */
#include <math.h>

#include "host/sim/models/kernel.h"

#define HELD_SPEED_LIMIT     1.25e-7 /* bounces slower than this, times sqrt(g L), are ignored */
/* In mats. A joint keeps its mode up to this distance past its limit. Far from a wave, joints open
 * by 1e-30 ft, which must not change their modes. */
#define SLACK_EDGE_TOLERANCE 1e-12

static struct kernel_mat mat_state(const struct model *m, const double *z, int n)
{
    if (n < m->first_mat || n > m->last_mat)
        return kernel_outside(m, n);
    if (m->tilt_ft)
        return kernel_tilted_mat(m, z, z + m->coordinate_count, n, 1.0 / m->length_ft);
    return kernel_mat(z, z + m->coordinate_count, n, 1.0 / m->length_ft);
}

static double joint_tension_lb(const struct model *m, const double *z, int j)
{
    struct kernel_mat l = mat_state(m, z, j - 1), r = mat_state(m, z, j);
    return kernel_tension_lb(m, j, &l, &r, m->has_full_profile, m->slack_ft > 0.0);
}

double model_driving_force_lb(const struct model *m, double t_s, const double *z, int mat)
{
    double rate,
        thrust = m->span.mat < 0 ? 0.0 : span_thrust_lb(&m->span, m->length_ft, t_s, mat, &rate);
    double push = joint_tension_lb(m, z, mat + 1) - joint_tension_lb(m, z, mat) + thrust;
    return m->elements.count == 0
             ? push
             : push + element_force_lb(&m->elements, model_element_mat(m, z, mat));
}

double model_friction_limit_lb(const struct model *m, const double *z, int mat)
{
    const double *v = z + m->coordinate_count;
    if (!m->has_soil_normal)
        return kernel_limit_lb(m, mat, 0.0, 0.0);
    return kernel_limit_lb(m, mat, kernel_soil_force_lb(m, z, v, mat),
                           kernel_soil_force_lb(m, z, v, mat + 1));
}

/* True if a mat has no friction because it is in the air and the normal force of its friction is
 * that of the soil. Such a mat neither stops nor sticks. */
static inline bool is_mat_airborne(const struct model *m, int mat)
{
    return m->has_soil_normal && !m->contact[mat] && !m->contact[mat + 1];
}

/* Positive where the soil acts on a node. In the consistent model the soil does not pull. */
static inline double contact_depth_ft(const struct model *m, const double *z, int node)
{
    return soil_contact_depth_ft(m->is_consistent,
                                 m->node_kv_lb_ft ? m->node_kv_lb_ft[node] : m->kv_lb_ft,
                                 m->node_cv_lb_s_ft ? m->node_cv_lb_s_ft[node] : m->cv_lb_s_ft,
                                 z[2 * node], z[m->coordinate_count + 2 * node]);
}

static double joint_angle_rad(const struct model *m, const double *z, int j)
{
    struct kernel_mat l = mat_state(m, z, j - 1), r = mat_state(m, z, j);
    return kernel_joint_angle_rad(&l, &r);
}

static bool has_joint_torsion(const struct model *m, int j)
{
    if ((j == 0 && m->has_left_torsion) || (j == m->mats && m->has_right_torsion))
        return false;
    return m->kt_lb_ft_rad > 0.0 || m->ct_lb_ft_s_rad > 0.0;
}

/* Acceleration of a node at the edge of contact: `off` with the lift shears of a node in contact,
 * `on` with those of a raised node. Works on a copy of the model. */
static void compute_held_node_accel(const struct model *m, double t_s, const double *z, int node,
                                    double *off, double *on)
{
    struct model copy = *m;
    double *accel = m->scratch;
    int mat = node > 0 ? node - 1 : 0; /* the mat whose rotation moves the node */
    signed char kept = m->lift_shear_sign[mat];
    copy.held_node = -1;
    report_rates(&copy, t_s, z, accel);
    *off = accel[2 * node];
    m->lift_shear_sign[mat] = m->held_lift_shear_signs[node > 0 ? 0 : 1];
    report_rates(&copy, t_s, z, accel);
    *on = accel[2 * node];
    m->lift_shear_sign[mat] = kept;
}

double model_margin(const struct model *m, double t_s, const double *z, struct model_switch s)
{
    switch (s.kind) {
    case MODEL_CONTACT: return soil_margin_ft(m->contact[s.index], contact_depth_ft(m, z, s.index));
    case MODEL_TORSION:
        return hinge_margin_rad(m->torsion[s.index], joint_angle_rad(m, z, s.index), m->tad_rad);
    case MODEL_SLACK: {
        struct kernel_mat l = mat_state(m, z, s.index - 1), r = mat_state(m, z, s.index);
        return joint_margin_ft(m->joint_mode[s.index],
                               kernel_gap_ft(m, s.index, &l, &r, m->has_full_profile), m->slack_ft,
                               SLACK_EDGE_TOLERANCE * m->length_ft);
    }
    case MODEL_SLIDE: return m->slide_direction[s.index] * z[m->coordinate_count + 2 * s.index + 1];
    case MODEL_STICK:
        return friction_margin_lb(model_friction_limit_lb(m, z, s.index),
                                  model_driving_force_lb(m, t_s, z, s.index));
    case MODEL_APEX: return z[2 * s.index] - z[2 * m->apex_node];
    case MODEL_HOLD: {
        double off, on;
        compute_held_node_accel(m, t_s, z, s.index, &off, &on);
        return fmin(-off, on);
    }
    }
    return 0.0;
}

void model_switch_range(const struct model *m, struct model_switch s, int *low, int *high)
{
    int node = s.index;
    *low = 2 * (node - 2);
    *high = 2 * (node + 3) + 1;
    if (s.kind == MODEL_HOLD) {
        *low = 2 * m->first_mat;
        *high = 2 * m->last_mat + 3;
    }
    if (s.kind == MODEL_APEX) {
        *low = 2 * (m->apex_node < node ? m->apex_node : node);
        *high = 2 * (m->apex_node < node ? node : m->apex_node) + 1;
    }
    if (*low < 2 * m->first_mat)
        *low = 2 * m->first_mat;
    if (*high > 2 * m->last_mat + 3)
        *high = 2 * m->last_mat + 3;
}

struct found_switches {
    struct model_switch *switches;
    int capacity;
    int count;
};

static inline void add_violation(struct found_switches *found, enum model_switch_kind kind,
                                 int index)
{
    if (found->count < found->capacity)
        found->switches[found->count] = (struct model_switch){kind, index};
    found->count++;
}

int model_find_violations(const struct model *m, double t_s, const double *z,
                          struct model_switch *list, int room)
{
    struct found_switches found = {list, room, 0};
    const double *v = z + m->coordinate_count;
    int lowest = m->apex_node;
    bool watch_apex = m->lift_shear != SIM_SHEAR_NONE && m->lifted_nodes > 0;
    for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
        double value = contact_depth_ft(m, z, j);
        if (j != m->held_node && (m->contact[j] ? value < 0.0 : value > 0.0))
            add_violation(&found, MODEL_CONTACT, j);
        if (watch_apex && z[2 * j] < z[2 * lowest])
            lowest = j;
    }
    if (m->held_node >= 0 &&
        model_margin(m, t_s, z, (struct model_switch){MODEL_HOLD, m->held_node}) < 0.0)
        add_violation(&found, MODEL_HOLD, m->held_node);
    if (lowest != m->apex_node && watch_apex)
        add_violation(&found, MODEL_APEX, lowest);
    if (m->tad_rad > 0.0 && (m->kt_lb_ft_rad > 0.0 || m->ct_lb_ft_s_rad > 0.0)) {
        /* |asin a - asin b| is certainly below TAD if |a| + |b| is below sin TAD */
        double flat_ft = (m->tad_rad < 1.5 ? elementary_sin(m->tad_rad) : 0.99) * m->length_ft -
                         2.0 * m->max_tilt_ft;
        double left_ft = 0.0;
        for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
            double right_ft = j <= m->last_mat ? fabs(z[2 * j + 2] - z[2 * j]) : 0.0;
            if ((m->torsion[j] || left_ft + right_ft > flat_ft) && has_joint_torsion(m, j) &&
                model_margin(m, t_s, z, (struct model_switch){MODEL_TORSION, j}) < 0.0)
                add_violation(&found, MODEL_TORSION, j);
            left_ft = right_ft;
        }
    }
    if (m->slack_ft > 0.0) {
        for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
            if (model_margin(m, t_s, z, (struct model_switch){MODEL_SLACK, j}) < 0.0)
                add_violation(&found, MODEL_SLACK, j);
        }
    }
    if (m->friction_law == SIM_FRICTION_STICK) {
        int first = m->first_mat > 0 ? m->first_mat - 1 : 0,
            last = m->last_mat < m->mats - 1 ? m->last_mat + 1 : m->mats - 1;
        double tension_l = joint_tension_lb(m, z, first);
        for (int n = first; n <= last; n++) {
            double tension_r = joint_tension_lb(m, z, n + 1);
            if (m->slide_direction[n] != 0) {
                if (m->slide_direction[n] * v[2 * n + 1] < 0.0 && !is_mat_airborne(m, n))
                    add_violation(&found, MODEL_SLIDE, n);
            } else {
                double rate, push = tension_r - tension_l;
                if (m->span.mat >= 0)
                    push += span_thrust_lb(&m->span, m->length_ft, t_s, n, &rate);
                if (m->elements.count > 0)
                    push += element_force_lb(&m->elements, model_element_mat(m, z, n));
                if (fabs(push) > model_friction_limit_lb(m, z, n))
                    add_violation(&found, MODEL_STICK, n);
            }
            tension_l = tension_r;
        }
    }
    return found.count;
}

/* Returns the direction of the lift shear of mat n. `left`, `right`: that end is raised. */
static signed char lift_shear_sign(const struct model *m, int n, bool left, bool right)
{
    /* the mat after the next one; its left end is the node after the highest one */
    int ridge = m->apex_node + 1;
    if (m->lift_shear == SIM_SHEAR_FOLLOWING)
        return n == ridge && left;
    if (right && (!left || n == ridge))
        return 1;
    return m->lift_shear == SIM_SHEAR_BOTH && left && !right ? -1 : 0;
}

static void update_held_lift_shears(struct model *m)
{
    int n = m->held_node;
    if (n < 0)
        return;
    m->held_lift_shear_signs[0] = n > 0 ? lift_shear_sign(m, n - 1, !m->contact[n - 1], true) : 0;
    m->held_lift_shear_signs[1] = n <= m->last_mat ? lift_shear_sign(m, n, true, !m->contact[n + 1])
                                                   : 0;
}

static void update_lift_shears(struct model *m, const double *z)
{
    m->lifted_nodes = 0;
    for (int j = m->first_mat; j <= m->last_mat + 1; j++)
        m->lifted_nodes += !m->contact[j];
    if (m->lift_shear == SIM_SHEAR_NONE)
        return;
    for (int n = m->first_mat; n <= m->last_mat; n++)
        m->lift_shear_sign[n] = 0;
    if (m->lifted_nodes == 0) {
        m->apex_node = m->first_mat;
        return;
    }
    if (m->contact[m->apex_node] || m->apex_node < m->first_mat || m->apex_node > m->last_mat + 1) {
        for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
            if (z[2 * j] < z[2 * m->apex_node] || m->apex_node < m->first_mat ||
                m->apex_node > m->last_mat + 1)
                m->apex_node = j;
        }
    }
    for (int n = m->first_mat; n <= m->last_mat; n++)
        m->lift_shear_sign[n] = lift_shear_sign(m, n, !m->contact[n], !m->contact[n + 1]);
}

static void update_shape_modes(struct model *m, const double *z)
{
    update_lift_shears(m, z);
    update_held_lift_shears(m);
}

static void update_slide_directions(struct model *m, double t_s, const double *z)
{
    if (m->friction_law != SIM_FRICTION_STICK)
        return;
    for (int n = m->first_mat; n <= m->last_mat; n++) {
        double v = z[m->coordinate_count + 2 * n + 1];
        if (v != 0.0)
            m->slide_direction[n] = v > 0.0 ? 1 : -1;
        else {
            double push = model_driving_force_lb(m, t_s, z, n);
            bool rests = fabs(push) <= model_friction_limit_lb(m, z, n) && !is_mat_airborne(m, n);
            m->slide_direction[n] = rests ? 0 : push > 0.0 ? 1 : -1;
        }
    }
}

void model_update_modes(struct model *m, double t_s, const double *z)
{
    update_shape_modes(m, z);
    update_slide_directions(m, t_s, z);
}

/* Holds a node at the edge of contact if it has almost stopped and forces drive it back to the edge
 * from both sides. */
static void hold_node_at_contact(struct model *m, double t_s, double *z, int node)
{
    double off, on, speed = z[m->coordinate_count + 2 * node], edge_ft = z[2 * node];
    if (fabs(speed) > HELD_SPEED_LIMIT * sqrt(m->scene->g_ft_s2 * m->length_ft))
        return;
    signed char kept = m->contact[node];
    m->contact[node] = 1;
    m->held_node = node;
    update_lift_shears(m, z);
    update_held_lift_shears(m);
    compute_held_node_accel(m, t_s, z, node, &off, &on);
    m->held_node = -1;
    if (off < 0.0 && on > 0.0) {
        m->held_node = node;
        /* move the following nodes by the same height, so that their mats keep their angles */
        for (int j = node; j <= m->last_mat + 1; j++) {
            z[m->coordinate_count + 2 * j] -= speed;
            if (fabs(z[2 * j] - edge_ft) > 1e-3 * SOIL_TOUCH_FT)
                continue;
            /* clearly in contact, so that rounding does not lift flat mats */
            z[2 * j] = -0.5 * SOIL_TOUCH_FT;
            if (fabs(z[m->coordinate_count + 2 * j]) < fabs(speed))
                z[m->coordinate_count + 2 * j] = 0.0;
            m->contact[j] = 1;
        }
        return;
    }
    m->contact[node] = kept;
}

void model_apply_switch(struct model *m, double t_s, double *z, struct model_switch s)
{
    switch (s.kind) {
    case MODEL_CONTACT:
        m->contact[s.index] = !m->contact[s.index];
        if (m->held_node < 0 && m->lift_shear != SIM_SHEAR_NONE &&
            (m->first_mat == 0 || s.index >= m->first_mat + 2))
            hold_node_at_contact(m, t_s, z, s.index);
        break;
    case MODEL_HOLD: {
        double off, on;
        compute_held_node_accel(m, t_s, z, s.index, &off, &on);
        m->held_node = -1;
        m->contact[s.index] = (signed char)(on < 0.0 ? 0 : 1);
        if (on < 0.0) /* at the edge, contact would push the node up */
            z[2 * s.index] = -SOIL_TOUCH_FT;
        break;
    }
    case MODEL_TORSION:
        m->torsion[s.index] = m->torsion[s.index]                  ? 0
                            : joint_angle_rad(m, z, s.index) > 0.0 ? 1
                                                                   : -1;
        break;
    case MODEL_SLACK: {
        struct kernel_mat l = mat_state(m, z, s.index - 1), r = mat_state(m, z, s.index);
        double gap = kernel_gap_ft(m, s.index, &l, &r, m->has_full_profile);
        if (m->joint_mode[s.index] != 0)
            m->joint_mode[s.index] = 0;
        else
            m->joint_mode[s.index] = gap > 0.5 * m->slack_ft ? 1 : -1;
        break;
    }
    case MODEL_SLIDE: z[m->coordinate_count + 2 * s.index + 1] = 0.0; break;
    case MODEL_STICK:
        m->slide_direction[s.index] = model_driving_force_lb(m, t_s, z, s.index) > 0.0 ? 1 : -1;
        break;
    case MODEL_APEX: m->apex_node = s.index; break;
    }
}

/* Updates the direction of sliding of mats in the air, which can reverse without a stop. With an
 * old direction, such a mat would count as stopped when it lands. */
static void update_airborne_slide_directions(struct model *m, const double *z)
{
    for (int n = m->first_mat; m->friction_law == SIM_FRICTION_STICK && n <= m->last_mat; n++) {
        double v = z[m->coordinate_count + 2 * n + 1];
        if (v != 0.0 && is_mat_airborne(m, n))
            m->slide_direction[n] = v > 0.0 ? 1 : -1;
    }
}

void model_sample_shape_modes(struct model *m, const double *z)
{
    bool switches = m->tad_rad > 0.0;
    double flat_ft = (m->tad_rad < 1.5 ? elementary_sin(m->tad_rad) : 0.99) * m->length_ft;
    double left_ft = 0.0;
    m->apex_node = m->first_mat;
    m->held_node = -1;
    for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
        m->contact[j] = m->is_consistent ? contact_depth_ft(m, z, j) > 0.0
                                         : z[2 * j] >= -SOIL_TOUCH_FT;
        if (z[2 * j] < z[2 * m->apex_node])
            m->apex_node = j;
        double right_ft = j <= m->last_mat ? fabs(z[2 * j + 2] - z[2 * j]) : 0.0;
        m->torsion[j] = !switches;
        if (switches && left_ft + right_ft > flat_ft) {
            double turn = joint_angle_rad(m, z, j);
            m->torsion[j] = hinge_mode(turn, m->tad_rad);
        }
        if (!has_joint_torsion(m, j))
            m->torsion[j] = 0;
        left_ft = right_ft;
        if (m->slack_ft > 0.0) {
            struct kernel_mat l = mat_state(m, z, j - 1), r = mat_state(m, z, j);
            double gap = kernel_gap_ft(m, j, &l, &r, m->has_full_profile);
            m->joint_mode[j] = joint_mode(gap, m->slack_ft);
        }
    }
    update_shape_modes(m, z);
    update_airborne_slide_directions(m, z);
}

void model_sample_modes(struct model *m, double t_s, const double *z)
{
    model_sample_shape_modes(m, z);
    update_slide_directions(m, t_s, z);
}

/* Returns the largest distance by which a quantity can leave the range between its values at the
 * ends of a step: twice the excess of the cubic through values and slopes. (A slope that differs
 * from the mean by 1 raises the cubic by 4/27 of the step.) */
static inline double max_deviation(double h, double from, double to, double rate_from,
                                   double rate_to)
{
    double change = to - from;
    return 8.0 / 27.0 * (fabs(rate_from * h - change) + fabs(rate_to * h - change));
}

struct step_ends {
    const double *z0, *z1, *r0, *r1; /* states at both ends of the step, and their rates */
    double t0_s, t1_s, h_s;
};

/* Returns true if a quantity can pass from below `limit` to above it. */
static inline bool can_exceed_limit(const struct step_ends *s, double from, double to,
                                    double rate_from, double rate_to, double limit)
{
    return (from > to ? from : to) + max_deviation(s->h_s, from, to, rate_from, rate_to) > limit;
}

static bool can_contact_change(const struct model *m, const struct step_ends *s, int node)
{
    int y = 2 * node, v = m->coordinate_count + y;
    double sign = m->contact[node] ? -1.0 : 1.0,
           edge = m->is_consistent ? 0.0 : sign * -SOIL_TOUCH_FT;
    bool height = can_exceed_limit(s, sign * s->z0[y], sign * s->z1[y], sign * s->r0[y],
                                   sign * s->r1[y], edge);
    if (!m->is_consistent || (m->contact[node] ? height : !height))
        return height;
    /* the soil pushes while height and force are both positive */
    double c = m->cv_lb_s_ft / m->kv_lb_ft;
    return can_exceed_limit(s, sign * (s->z0[y] + c * s->z0[v]), sign * (s->z1[y] + c * s->z1[v]),
                            sign * (s->r0[y] + c * s->r0[v]), sign * (s->r1[y] + c * s->r1[v]),
                            0.0);
}

static bool can_apex_change(const struct model *m, const struct step_ends *s, int node)
{
    int y = 2 * node, a = 2 * m->apex_node;
    return node != m->apex_node && can_exceed_limit(s, s->z0[a] - s->z0[y], s->z1[a] - s->z1[y],
                                                    s->r0[a] - s->r0[y], s->r1[a] - s->r1[y], 0.0);
}

static bool can_torsion_change(const struct model *m, const struct step_ends *s, int joint,
                               double flat_ft)
{
    double tilt_ft = 0.0;
    for (int n = joint - 1; n <= joint; n++) {
        if (n < m->first_mat || n > m->last_mat)
            continue;
        double from = s->z0[2 * n + 2] - s->z0[2 * n], to = s->z1[2 * n + 2] - s->z1[2 * n];
        tilt_ft += fmax(fabs(from), fabs(to)) + max_deviation(s->h_s, from, to,
                                                              s->r0[2 * n + 2] - s->r0[2 * n],
                                                              s->r1[2 * n + 2] - s->r1[2 * n]);
    }
    if (!m->torsion[joint] && tilt_ft < flat_ft)
        return false;
    double turn[2], rate[2];
    for (int end = 0; end < 2; end++) {
        const double *z = end ? s->z1 : s->z0;
        struct kernel_mat l = mat_state(m, z, joint - 1), r = mat_state(m, z, joint);
        turn[end] = kernel_joint_angle_rad(&l, &r);
        rate[end] = r.w - l.w;
    }
    double side = m->torsion[joint];
    if (m->torsion[joint])
        return can_exceed_limit(s, -side * turn[0], -side * turn[1], -side * rate[0],
                                -side * rate[1], -m->tad_rad);
    return can_exceed_limit(s, turn[0], turn[1], rate[0], rate[1], m->tad_rad) ||
           can_exceed_limit(s, -turn[0], -turn[1], -rate[0], -rate[1], m->tad_rad);
}

static bool can_slack_change(const struct model *m, const struct step_ends *s, int joint)
{
    double gap[2], rate[2];
    for (int end = 0; end < 2; end++) {
        const double *z = end ? s->z1 : s->z0;
        struct kernel_mat l = mat_state(m, z, joint - 1), r = mat_state(m, z, joint);
        gap[end] = kernel_gap_ft(m, joint, &l, &r, m->has_full_profile);
        rate[end] = r.v - l.v + (m->has_full_profile ? m->half_ft * (l.w * l.s + r.w * r.s) : 0.0);
    }
    bool opens = can_exceed_limit(s, gap[0], gap[1], rate[0], rate[1],
                                  m->joint_mode[joint] < 0 ? 0.0 : m->slack_ft);
    bool closes = can_exceed_limit(s, -gap[0], -gap[1], -rate[0], -rate[1],
                                   m->joint_mode[joint] > 0 ? -m->slack_ft : 0.0);
    return m->joint_mode[joint] < 0 ? opens : m->joint_mode[joint] > 0 ? closes : opens || closes;
}

/* Rate of change of a joint's tension, without the effect of tilting. */
static double joint_tension_rate(const struct model *m, const double *z, const double *rate,
                                 int joint)
{
    int l = m->coordinate_count + 2 * joint - 1, r = m->coordinate_count + 2 * joint + 1;
    bool left = joint > m->first_mat, right = joint <= m->last_mat;
    if ((joint == 0 && m->is_left_free) || (joint == m->mats && m->is_right_free) ||
        (m->slack_ft > 0.0 && m->joint_mode[joint] == 0))
        return 0.0;
    return m->kl_lb_ft * ((right ? z[r] : 0.0) - (left ? z[l] : 0.0)) +
           m->cl_lb_s_ft * ((right ? rate[r] : 0.0) - (left ? rate[l] : 0.0));
}

static bool can_slip_change(const struct model *m, const struct step_ends *s, int mat)
{
    int v = m->coordinate_count + 2 * mat + 1;
    double side = m->slide_direction[mat];
    if (m->slide_direction[mat])
        return can_exceed_limit(s, -side * s->z0[v], -side * s->z1[v], -side * s->r0[v],
                                -side * s->r1[v], 0.0);
    if (m->has_soil_normal)
        return true; /* the limit of friction may vary too */
    double from = model_driving_force_lb(m, s->t0_s, s->z0, mat),
           to = model_driving_force_lb(m, s->t1_s, s->z1, mat);
    double rate_from = joint_tension_rate(m, s->z0, s->r0, mat + 1) -
                       joint_tension_rate(m, s->z0, s->r0, mat);
    double rate_to = joint_tension_rate(m, s->z1, s->r1, mat + 1) -
                     joint_tension_rate(m, s->z1, s->r1, mat);
    double limit = model_friction_limit_lb(m, s->z0, mat);
    return can_exceed_limit(s, from, to, rate_from, rate_to, limit) ||
           can_exceed_limit(s, -from, -to, -rate_from, -rate_to, limit);
}

bool model_can_switch(const struct model *m, double t0_s, const double *z0, const double *rate0,
                      double t1_s, const double *z1, const double *rate1)
{
    const struct step_ends s = {z0, z1, rate0, rate1, t0_s, t1_s, t1_s - t0_s};
    bool apexes = m->lift_shear != SIM_SHEAR_NONE && m->lifted_nodes > 0;
    bool torsions = m->tad_rad > 0.0 && (m->kt_lb_ft_rad > 0.0 || m->ct_lb_ft_s_rad > 0.0);
    double flat_ft = (m->tad_rad < 1.5 ? elementary_sin(m->tad_rad) : 0.99) * m->length_ft;
    if (m->held_node >= 0)
        return true;
    for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
        if (can_contact_change(m, &s, j) || (apexes && can_apex_change(m, &s, j)) ||
            (torsions && has_joint_torsion(m, j) && can_torsion_change(m, &s, j, flat_ft)) ||
            (m->slack_ft > 0.0 && can_slack_change(m, &s, j)))
            return true;
    }
    int first = m->first_mat > 0 ? m->first_mat - 1 : 0,
        last = m->last_mat < m->mats - 1 ? m->last_mat + 1 : m->mats - 1;
    for (int n = first; m->friction_law == SIM_FRICTION_STICK && n <= last; n++) {
        if (can_slip_change(m, &s, n))
            return true;
    }
    return false;
}
