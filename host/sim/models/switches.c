/* The switches of a model: the end of a mode's validity, and the effect of a change. */
#include <math.h>

#include "host/sim/models/kernel.h"

#define HOLD_PART  1.25e-7 /* bounces slower than this times sqrt(g L) are ignored */
/* Mats; a joint keeps its mode up to this distance beyond its edge. The motion far from a wave
 * opens joints by 1e-30 ft, which must not switch them. */
#define SLACK_EDGE 1e-12

static struct kernel_mat mat_of(const struct model *m, const double *z, int n)
{
    if (n < m->first || n > m->last)
        return kernel_outside(m, n);
    if (m->tilt_ft)
        return kernel_tilted_mat(m, z, z + m->size, n, 1.0 / m->length_ft);
    return kernel_mat(z, z + m->size, n, 1.0 / m->length_ft);
}

static double tension_lb(const struct model *m, const double *z, int j)
{
    struct kernel_mat l = mat_of(m, z, j - 1), r = mat_of(m, z, j);
    return kernel_tension_lb(m, j, &l, &r, m->has_full_profile, m->slack_ft > 0.0);
}

double model_push_lb(const struct model *m, double t_s, const double *z, int mat)
{
    double rate,
        thrust = m->span.mat < 0 ? 0.0 : span_thrust_lb(&m->span, m->length_ft, t_s, mat, &rate);
    double push = tension_lb(m, z, mat + 1) - tension_lb(m, z, mat) + thrust;
    return m->elements.count == 0
             ? push
             : push + element_force_lb(&m->elements, model_element_mat(m, z, mat));
}

double model_limit_lb(const struct model *m, const double *z, int mat)
{
    const double *v = z + m->size;
    if (!m->has_soil_normal)
        return kernel_limit_lb(m, mat, 0.0, 0.0);
    return kernel_limit_lb(m, mat, kernel_soil_lb(m, z, v, mat), kernel_soil_lb(m, z, v, mat + 1));
}

/* True if a mat has no friction because it is in the air and its normal force is that of the soil.
 * Such a mat neither stops nor sticks. */
static inline bool is_afloat(const struct model *m, int mat)
{
    return m->has_soil_normal && !m->contact[mat] && !m->contact[mat + 1];
}

/* Positive where the soil acts on a node. In the consistent model the soil does not pull. */
static inline double contact_value(const struct model *m, const double *z, int node)
{
    return soil_contact_depth_ft(m->is_consistent, m->kv_at ? m->kv_at[node] : m->kv,
                                 m->cv_at ? m->cv_at[node] : m->cv, z[2 * node],
                                 z[m->size + 2 * node]);
}

static double joint_turn_rad(const struct model *m, const double *z, int j)
{
    struct kernel_mat l = mat_of(m, z, j - 1), r = mat_of(m, z, j);
    return kernel_turn_rad(&l, &r);
}

static bool has_torsion(const struct model *m, int j)
{
    if ((j == 0 && m->has_left_torsion) || (j == m->mats && m->has_right_torsion))
        return false;
    return m->kt > 0.0 || m->ct > 0.0;
}

/* Acceleration of a node at the edge of contact: `off` with the lift shears of a node in contact,
 * `on` with those of a raised node. The model is not changed; fields that must change are changed
 * in a copy. */
static void held_accel(const struct model *m, double t_s, const double *z, int node, double *off,
                       double *on)
{
    struct model copy = *m;
    double *accel = m->scratch;
    int mat = node > 0 ? node - 1 : 0; /* the mat whose rotation moves the node */
    signed char kept = m->lift[mat];
    copy.held_node = -1;
    report_rates(&copy, t_s, z, accel);
    *off = accel[2 * node];
    m->lift[mat] = m->held_lift[node > 0 ? 0 : 1];
    report_rates(&copy, t_s, z, accel);
    *on = accel[2 * node];
    m->lift[mat] = kept;
}

double model_margin(const struct model *m, double t_s, const double *z, struct model_switch s)
{
    switch (s.kind) {
    case MODEL_CONTACT: return soil_margin_ft(m->contact[s.index], contact_value(m, z, s.index));
    case MODEL_TORSION:
        return hinge_margin_rad(m->torsion[s.index], joint_turn_rad(m, z, s.index), m->tad_rad);
    case MODEL_SLACK: {
        struct kernel_mat l = mat_of(m, z, s.index - 1), r = mat_of(m, z, s.index);
        return joint_margin_ft(m->joint[s.index],
                               kernel_gap_ft(m, s.index, &l, &r, m->has_full_profile), m->slack_ft,
                               SLACK_EDGE * m->length_ft);
    }
    case MODEL_SLIDE: return m->slide[s.index] * z[m->size + 2 * s.index + 1];
    case MODEL_STICK:
        return friction_margin_lb(model_limit_lb(m, z, s.index), model_push_lb(m, t_s, z, s.index));
    case MODEL_APEX: return z[2 * s.index] - z[2 * m->apex];
    case MODEL_HOLD: {
        double off, on;
        held_accel(m, t_s, z, s.index, &off, &on);
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
        *low = 2 * m->first;
        *high = 2 * m->last + 3;
    }
    if (s.kind == MODEL_APEX) {
        *low = 2 * (m->apex < node ? m->apex : node);
        *high = 2 * (m->apex < node ? node : m->apex) + 1;
    }
    if (*low < 2 * m->first)
        *low = 2 * m->first;
    if (*high > 2 * m->last + 3)
        *high = 2 * m->last + 3;
}

struct found {
    struct model_switch *list;
    int room;
    int count;
};

static inline void add_violation(struct found *found, enum model_switch_kind kind, int index)
{
    if (found->count < found->room)
        found->list[found->count] = (struct model_switch){kind, index};
    found->count++;
}

int model_find_violations(const struct model *m, double t_s, const double *z,
                          struct model_switch *list, int room)
{
    struct found found = {list, room, 0};
    const double *v = z + m->size;
    int lowest = m->apex;
    bool watch_apex = m->shear != SIM_SHEAR_NONE && m->lifted_nodes > 0;
    for (int j = m->first; j <= m->last + 1; j++) {
        double value = contact_value(m, z, j);
        if (j != m->held_node && (m->contact[j] ? value < 0.0 : value > 0.0))
            add_violation(&found, MODEL_CONTACT, j);
        if (watch_apex && z[2 * j] < z[2 * lowest])
            lowest = j;
    }
    if (m->held_node >= 0 &&
        model_margin(m, t_s, z, (struct model_switch){MODEL_HOLD, m->held_node}) < 0.0)
        add_violation(&found, MODEL_HOLD, m->held_node);
    if (lowest != m->apex && watch_apex)
        add_violation(&found, MODEL_APEX, lowest);
    if (m->tad_rad > 0.0 && (m->kt > 0.0 || m->ct > 0.0)) {
        /* |asin a - asin b| is certainly below TAD while |a| + |b| is below sin TAD */
        double flat_ft = (m->tad_rad < 1.5 ? elementary_sin(m->tad_rad) : 0.99) * m->length_ft -
                         2.0 * m->max_tilt_ft;
        double left_ft = 0.0;
        for (int j = m->first; j <= m->last + 1; j++) {
            double right_ft = j <= m->last ? fabs(z[2 * j + 2] - z[2 * j]) : 0.0;
            if ((m->torsion[j] || left_ft + right_ft > flat_ft) && has_torsion(m, j) &&
                model_margin(m, t_s, z, (struct model_switch){MODEL_TORSION, j}) < 0.0)
                add_violation(&found, MODEL_TORSION, j);
            left_ft = right_ft;
        }
    }
    if (m->slack_ft > 0.0) {
        for (int j = m->first; j <= m->last + 1; j++) {
            if (model_margin(m, t_s, z, (struct model_switch){MODEL_SLACK, j}) < 0.0)
                add_violation(&found, MODEL_SLACK, j);
        }
    }
    if (m->law == SIM_FRICTION_STICK) {
        int first = m->first > 0 ? m->first - 1 : 0,
            last = m->last < m->mats - 1 ? m->last + 1 : m->mats - 1;
        double tension_l = tension_lb(m, z, first);
        for (int n = first; n <= last; n++) {
            double tension_r = tension_lb(m, z, n + 1);
            if (m->slide[n] != 0) {
                if (m->slide[n] * v[2 * n + 1] < 0.0 && !is_afloat(m, n))
                    add_violation(&found, MODEL_SLIDE, n);
            } else {
                double rate, push = tension_r - tension_l;
                if (m->span.mat >= 0)
                    push += span_thrust_lb(&m->span, m->length_ft, t_s, n, &rate);
                if (m->elements.count > 0)
                    push += element_force_lb(&m->elements, model_element_mat(m, z, n));
                if (fabs(push) > model_limit_lb(m, z, n))
                    add_violation(&found, MODEL_STICK, n);
            }
            tension_l = tension_r;
        }
    }
    return found.count;
}

/* Lift shear of mat n. `left`, `right`: the left or right end is raised. */
static signed char lift_mode(const struct model *m, int n, bool left, bool right)
{
    /* second mat behind the apex node: its left end is the next node */
    int ridge = m->apex + 1;
    if (m->shear == SIM_SHEAR_FOLLOWING)
        return n == ridge && left;
    if (right && (!left || n == ridge))
        return 1;
    return m->shear == SIM_SHEAR_BOTH && left && !right ? -1 : 0;
}

static void settle_held(struct model *m)
{
    int n = m->held_node;
    if (n < 0)
        return;
    m->held_lift[0] = n > 0 ? lift_mode(m, n - 1, !m->contact[n - 1], true) : 0;
    m->held_lift[1] = n <= m->last ? lift_mode(m, n, true, !m->contact[n + 1]) : 0;
}

static void update_lift_modes(struct model *m, const double *z)
{
    m->lifted_nodes = 0;
    for (int j = m->first; j <= m->last + 1; j++)
        m->lifted_nodes += !m->contact[j];
    if (m->shear == SIM_SHEAR_NONE)
        return;
    for (int n = m->first; n <= m->last; n++)
        m->lift[n] = 0;
    if (m->lifted_nodes == 0) {
        m->apex = m->first;
        return;
    }
    if (m->contact[m->apex] || m->apex < m->first || m->apex > m->last + 1) {
        for (int j = m->first; j <= m->last + 1; j++) {
            if (z[2 * j] < z[2 * m->apex] || m->apex < m->first || m->apex > m->last + 1)
                m->apex = j;
        }
    }
    for (int n = m->first; n <= m->last; n++)
        m->lift[n] = lift_mode(m, n, !m->contact[n], !m->contact[n + 1]);
}

static void settle_shape(struct model *m, const double *z)
{
    update_lift_modes(m, z);
    settle_held(m);
}

static void settle_slide(struct model *m, double t_s, const double *z)
{
    if (m->law != SIM_FRICTION_STICK)
        return;
    for (int n = m->first; n <= m->last; n++) {
        double v = z[m->size + 2 * n + 1];
        if (v != 0.0)
            m->slide[n] = v > 0.0 ? 1 : -1;
        else {
            double push = model_push_lb(m, t_s, z, n);
            bool rests = fabs(push) <= model_limit_lb(m, z, n) && !is_afloat(m, n);
            m->slide[n] = rests ? 0 : push > 0.0 ? 1 : -1;
        }
    }
}

void model_settle(struct model *m, double t_s, const double *z)
{
    settle_shape(m, z);
    settle_slide(m, t_s, z);
}

/* Holds a node at the edge of contact if it has almost stopped and forces drive it back to the edge
 * from both sides. */
static void try_hold(struct model *m, double t_s, double *z, int node)
{
    double off, on, speed = z[m->size + 2 * node], edge_ft = z[2 * node];
    if (fabs(speed) > HOLD_PART * sqrt(m->scene->g_ft_s2 * m->length_ft))
        return;
    signed char kept = m->contact[node];
    m->contact[node] = 1;
    m->held_node = node;
    update_lift_modes(m, z);
    settle_held(m);
    held_accel(m, t_s, z, node, &off, &on);
    m->held_node = -1;
    if (off < 0.0 && on > 0.0) {
        m->held_node = node;
        /* the following nodes move by the same height, so that their mats keep their angles */
        for (int j = node; j <= m->last + 1; j++) {
            z[m->size + 2 * j] -= speed;
            if (fabs(z[2 * j] - edge_ft) > 1e-3 * SOIL_TOUCH_FT)
                continue;
            /* well within contact, so that rounding does not lift flat mats */
            z[2 * j] = -0.5 * SOIL_TOUCH_FT;
            if (fabs(z[m->size + 2 * j]) < fabs(speed))
                z[m->size + 2 * j] = 0.0;
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
        if (m->held_node < 0 && m->shear != SIM_SHEAR_NONE &&
            (m->first == 0 || s.index >= m->first + 2))
            try_hold(m, t_s, z, s.index);
        break;
    case MODEL_HOLD: {
        double off, on;
        held_accel(m, t_s, z, s.index, &off, &on);
        m->held_node = -1;
        m->contact[s.index] = (signed char)(on < 0.0 ? 0 : 1);
        if (on < 0.0) /* below the edge, contact would push the node up at first */
            z[2 * s.index] = -SOIL_TOUCH_FT;
        break;
    }
    case MODEL_TORSION:
        m->torsion[s.index] = m->torsion[s.index]                 ? 0
                            : joint_turn_rad(m, z, s.index) > 0.0 ? 1
                                                                  : -1;
        break;
    case MODEL_SLACK: {
        struct kernel_mat l = mat_of(m, z, s.index - 1), r = mat_of(m, z, s.index);
        double gap = kernel_gap_ft(m, s.index, &l, &r, m->has_full_profile);
        if (m->joint[s.index] != 0)
            m->joint[s.index] = 0;
        else
            m->joint[s.index] = gap > 0.5 * m->slack_ft ? 1 : -1;
        break;
    }
    case MODEL_SLIDE: z[m->size + 2 * s.index + 1] = 0.0; break;
    case MODEL_STICK: m->slide[s.index] = model_push_lb(m, t_s, z, s.index) > 0.0 ? 1 : -1; break;
    case MODEL_APEX: m->apex = s.index; break;
    }
}

/* Updates the direction of sliding of mats in the air, which reverse without a stop. Otherwise such
 * a mat would count as stopped when it lands. */
static void update_afloat_slides(struct model *m, const double *z)
{
    for (int n = m->first; m->law == SIM_FRICTION_STICK && n <= m->last; n++) {
        double v = z[m->size + 2 * n + 1];
        if (v != 0.0 && is_afloat(m, n))
            m->slide[n] = v > 0.0 ? 1 : -1;
    }
}

void model_sample_shape(struct model *m, const double *z)
{
    bool switches = m->tad_rad > 0.0;
    double flat_ft = (m->tad_rad < 1.5 ? elementary_sin(m->tad_rad) : 0.99) * m->length_ft;
    double left_ft = 0.0;
    m->apex = m->first;
    m->held_node = -1;
    for (int j = m->first; j <= m->last + 1; j++) {
        m->contact[j] = m->is_consistent ? contact_value(m, z, j) > 0.0
                                         : z[2 * j] >= -SOIL_TOUCH_FT;
        if (z[2 * j] < z[2 * m->apex])
            m->apex = j;
        double right_ft = j <= m->last ? fabs(z[2 * j + 2] - z[2 * j]) : 0.0;
        m->torsion[j] = !switches;
        if (switches && left_ft + right_ft > flat_ft) {
            double turn = joint_turn_rad(m, z, j);
            m->torsion[j] = hinge_side(turn, m->tad_rad);
        }
        if (!has_torsion(m, j))
            m->torsion[j] = 0;
        left_ft = right_ft;
        if (m->slack_ft > 0.0) {
            struct kernel_mat l = mat_of(m, z, j - 1), r = mat_of(m, z, j);
            double gap = kernel_gap_ft(m, j, &l, &r, m->has_full_profile);
            m->joint[j] = joint_mode(gap, m->slack_ft);
        }
    }
    settle_shape(m, z);
    update_afloat_slides(m, z);
}

void model_sample(struct model *m, double t_s, const double *z)
{
    model_sample_shape(m, z);
    settle_slide(m, t_s, z);
}

/* Largest distance of a quantity from the range of its values at both ends of a step: twice the
 * excess of the cubic through values and slopes. (A slope that differs from the mean by 1 raises
 * the cubic by 4/27 of the step.) */
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
static inline bool can_pass(const struct step_ends *s, double from, double to, double rate_from,
                            double rate_to, double limit)
{
    return (from > to ? from : to) + max_deviation(s->h_s, from, to, rate_from, rate_to) > limit;
}

static bool can_contact_change(const struct model *m, const struct step_ends *s, int node)
{
    int y = 2 * node, v = m->size + y;
    double sign = m->contact[node] ? -1.0 : 1.0,
           edge = m->is_consistent ? 0.0 : sign * -SOIL_TOUCH_FT;
    bool height = can_pass(s, sign * s->z0[y], sign * s->z1[y], sign * s->r0[y], sign * s->r1[y],
                           edge);
    if (!m->is_consistent || (m->contact[node] ? height : !height))
        return height;
    double c = m->cv / m->kv; /* the soil pushes while height and force are both positive */
    return can_pass(s, sign * (s->z0[y] + c * s->z0[v]), sign * (s->z1[y] + c * s->z1[v]),
                    sign * (s->r0[y] + c * s->r0[v]), sign * (s->r1[y] + c * s->r1[v]), 0.0);
}

static bool can_apex_change(const struct model *m, const struct step_ends *s, int node)
{
    int y = 2 * node, a = 2 * m->apex;
    return node != m->apex && can_pass(s, s->z0[a] - s->z0[y], s->z1[a] - s->z1[y],
                                       s->r0[a] - s->r0[y], s->r1[a] - s->r1[y], 0.0);
}

static bool can_torsion_change(const struct model *m, const struct step_ends *s, int joint,
                               double flat_ft)
{
    double tilt_ft = 0.0;
    for (int n = joint - 1; n <= joint; n++) {
        if (n < m->first || n > m->last)
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
        struct kernel_mat l = mat_of(m, z, joint - 1), r = mat_of(m, z, joint);
        turn[end] = kernel_turn_rad(&l, &r);
        rate[end] = r.w - l.w;
    }
    double side = m->torsion[joint];
    if (m->torsion[joint])
        return can_pass(s, -side * turn[0], -side * turn[1], -side * rate[0], -side * rate[1],
                        -m->tad_rad);
    return can_pass(s, turn[0], turn[1], rate[0], rate[1], m->tad_rad) ||
           can_pass(s, -turn[0], -turn[1], -rate[0], -rate[1], m->tad_rad);
}

static bool can_slack_change(const struct model *m, const struct step_ends *s, int joint)
{
    double gap[2], rate[2];
    for (int end = 0; end < 2; end++) {
        const double *z = end ? s->z1 : s->z0;
        struct kernel_mat l = mat_of(m, z, joint - 1), r = mat_of(m, z, joint);
        gap[end] = kernel_gap_ft(m, joint, &l, &r, m->has_full_profile);
        rate[end] = r.v - l.v + (m->has_full_profile ? m->half_ft * (l.w * l.s + r.w * r.s) : 0.0);
    }
    bool opens = can_pass(s, gap[0], gap[1], rate[0], rate[1],
                          m->joint[joint] < 0 ? 0.0 : m->slack_ft);
    bool closes = can_pass(s, -gap[0], -gap[1], -rate[0], -rate[1],
                           m->joint[joint] > 0 ? -m->slack_ft : 0.0);
    return m->joint[joint] < 0 ? opens : m->joint[joint] > 0 ? closes : opens || closes;
}

/* Rate of change of a joint's tension, without the effect of tilting. */
static double tension_rate(const struct model *m, const double *z, const double *rate, int joint)
{
    int l = m->size + 2 * joint - 1, r = m->size + 2 * joint + 1;
    bool left = joint > m->first, right = joint <= m->last;
    if ((joint == 0 && m->is_left_free) || (joint == m->mats && m->is_right_free) ||
        (m->slack_ft > 0.0 && m->joint[joint] == 0))
        return 0.0;
    return m->kl * ((right ? z[r] : 0.0) - (left ? z[l] : 0.0)) +
           m->cl * ((right ? rate[r] : 0.0) - (left ? rate[l] : 0.0));
}

static bool can_slip_change(const struct model *m, const struct step_ends *s, int mat)
{
    int v = m->size + 2 * mat + 1;
    double side = m->slide[mat];
    if (m->slide[mat])
        return can_pass(s, -side * s->z0[v], -side * s->z1[v], -side * s->r0[v], -side * s->r1[v],
                        0.0);
    if (m->has_soil_normal)
        return true; /* the limit of friction is not constant either */
    double from = model_push_lb(m, s->t0_s, s->z0, mat), to = model_push_lb(m, s->t1_s, s->z1, mat);
    double rate_from = tension_rate(m, s->z0, s->r0, mat + 1) - tension_rate(m, s->z0, s->r0, mat);
    double rate_to = tension_rate(m, s->z1, s->r1, mat + 1) - tension_rate(m, s->z1, s->r1, mat);
    double limit = model_limit_lb(m, s->z0, mat);
    return can_pass(s, from, to, rate_from, rate_to, limit) ||
           can_pass(s, -from, -to, -rate_from, -rate_to, limit);
}

bool model_can_switch(const struct model *m, double t0_s, const double *z0, const double *rate0,
                      double t1_s, const double *z1, const double *rate1)
{
    const struct step_ends s = {z0, z1, rate0, rate1, t0_s, t1_s, t1_s - t0_s};
    bool apexes = m->shear != SIM_SHEAR_NONE && m->lifted_nodes > 0;
    bool torsions = m->tad_rad > 0.0 && (m->kt > 0.0 || m->ct > 0.0);
    double flat_ft = (m->tad_rad < 1.5 ? elementary_sin(m->tad_rad) : 0.99) * m->length_ft;
    if (m->held_node >= 0)
        return true;
    for (int j = m->first; j <= m->last + 1; j++) {
        if (can_contact_change(m, &s, j) || (apexes && can_apex_change(m, &s, j)) ||
            (torsions && has_torsion(m, j) && can_torsion_change(m, &s, j, flat_ft)) ||
            (m->slack_ft > 0.0 && can_slack_change(m, &s, j)))
            return true;
    }
    int first = m->first > 0 ? m->first - 1 : 0,
        last = m->last < m->mats - 1 ? m->last + 1 : m->mats - 1;
    for (int n = first; m->law == SIM_FRICTION_STICK && n <= last; n++) {
        if (can_slip_change(m, &s, n))
            return true;
    }
    return false;
}
