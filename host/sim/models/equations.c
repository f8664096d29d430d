/* Equations of both planar models (PLANAR.md, "Models"): right-hand sides, mass matrices and
 * Jacobians. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "host/sim/models/kernel.h"

/* ---- tanh of many speeds ---- */

#define LOG2_E         1.44269504088896340736
#define LN2_HIGH       6.93147180369123816490e-01
#define LN2_LOW        1.90821492927058770002e-10
/* 1.5 * 2^52; adding it rounds a number to the nearest integer, in the lowest bits */
#define ROUNDING_SHIFT 6755399441055744.0
#define VECTOR_SIZE    4

typedef double vector4 __attribute__((vector_size(8 * VECTOR_SIZE)));
typedef int64_t vector4_bits __attribute__((vector_size(8 * VECTOR_SIZE)));

/* Computes tanh x = 1 - 2/(e^(2x) + 1) for x > 0. e^y = 2^k e^r with |r| <= ln 2 / 2. The Taylor
 * series of e^r is truncated where the remainder is below 1e-17. */
static inline __attribute__((always_inline)) vector4 vector4_tanh(vector4 x)
{
    const vector4_bits sign = (vector4_bits)(vector4){-0.0, -0.0, -0.0, -0.0};
    vector4 size = (vector4)((vector4_bits)x & ~sign);
    const vector4_bits small = size < 20.0, most = (vector4_bits)(vector4){20.0, 20.0, 20.0, 20.0};
    vector4 y = 2.0 * (vector4)((small & (vector4_bits)size) | (~small & most));
    vector4 k = y * LOG2_E + ROUNDING_SHIFT;
    vector4 whole = k - ROUNDING_SHIFT;
    vector4 r = (y - whole * LN2_HIGH) - whole * LN2_LOW;
    vector4 r2 = r * r, r4 = r2 * r2;
    vector4 low = (1.0 + r) + r2 * (1.0 / 2 + r * (1.0 / 6)) + r4 * (1.0 / 24 + r * (1.0 / 120));
    vector4 high = (1.0 / 720 + r * (1.0 / 5040)) + r2 * (1.0 / 40320 + r * (1.0 / 362880)) +
                   r4 * ((1.0 / 3628800 + r * (1.0 / 39916800)) +
                         r2 * (1.0 / 479001600 + r * (1.0 / 6227020800)));
    vector4 power = (vector4)(((vector4_bits)k + 1023) << 52);
    vector4 t = 1.0 - 2.0 / (power * (low + r4 * r2 * high) + 1.0);
    return (vector4)((vector4_bits)t | ((vector4_bits)x & sign));
}

TARGET_CLONES void vector_tanh(const double *restrict from, double scale, double *restrict to,
                               int count)
{
    int i = 0;
    for (; i + VECTOR_SIZE <= count; i += VECTOR_SIZE) {
        vector4 x = {from[2 * i], from[2 * i + 2], from[2 * i + 4], from[2 * i + 6]};
        x = vector4_tanh(scale * x);
        memcpy(to + i, &x, sizeof x);
    }
    for (; i < count; i++)
        to[i] = vector4_tanh((vector4){scale * from[2 * i]})[0];
}

/* ---- report model: from one end of the window to the other. Each mat's angular acceleration is
 * local; the acceleration of the node heights is a running sum ---- */

/* True if a flat mat stays flat: its joints transmit no moment, and the soil acts on both ends
 * alike. */
KERNEL_INLINE bool is_mat_staying_flat(const struct model *m, int n, const struct kernel_mat *mat)
{
    return mat->s == 0.0 && mat->w == 0.0 && !m->torsion[n] && !m->torsion[n + 1] &&
           m->lift_shear_sign[n] == 0 && m->contact[n] == m->contact[n + 1] &&
           n != m->held_node - 1 && n != m->held_node;
}

KERNEL_INLINE void report_rates_kernel(const struct model *m, double t_s, const double *z,
                                       double *accel, const struct kernel_parts parts)
{
    const double *p = z, *v = z + m->coordinate_count;
    const double inverse_length = 1.0 / m->length_ft, inverse_mass = 1.0 / m->mass_slug;
    const double inverse_inertia = 1.0 / m->inertia_slug_ft2, h = m->half_ft;
    const int first = m->first_mat, last = m->last_mat;
    struct kernel_thrust thrust = kernel_thrust(m, t_s);
    kernel_prepare(m, v, parts.friction_law);
    struct kernel_mat before = kernel_outside(m, first - 1);
    struct kernel_mat mat = kernel_mat(p, v, first, inverse_length);
    double tension_l = kernel_tension_lb(m, first, &before, &mat, parts.has_full_profile,
                                         parts.has_slack);
    double moment_l = m->torsion[first] ? kernel_moment(m, first, &before, &mat) : 0.0;
    double soil_l = kernel_soil_force_lb(m, p, v, first);
    /* up: fraction of the time for which the held node (model.h) is off the ground */
    double height = 0.0, up = 0.0;

    for (int n = first; n <= last; n++) {
        struct kernel_mat after = n < last ? kernel_mat(p, v, n + 1, inverse_length)
                                           : kernel_outside(m, n + 1);
        double tension_r = kernel_tension_lb(m, n + 1, &mat, &after, parts.has_full_profile,
                                             parts.has_slack);
        double moment_r = m->torsion[n + 1] ? kernel_moment(m, n + 1, &mat, &after) : 0.0;
        double push = tension_r - tension_l;
        if (n == thrust.mat_a)
            push += thrust.a_lb;
        if (n == thrust.mat_b)
            push += thrust.b_lb;
        accel[2 * n + 1] =
            kernel_sliding_force_lb(m, n, mat.v, push, 0.0, 0.0, parts.friction_law) * inverse_mass;

        /* without a moment, the soil forces at both ends are equal */
        if (is_mat_staying_flat(m, n, &mat)) {
            if (n == first)
                accel[2 * n] = height = (m->q1_lb - 2.0 * soil_l) * inverse_mass;
            accel[2 * n + 2] = height;
            mat = after;
            tension_l = tension_r;
            moment_l = moment_r;
            continue;
        }
        double soil_r = kernel_soil_force_lb(m, p, v, n + 1);
        double lift = m->lift_shear_sign[n];
        if (n == m->held_node)
            lift += up * (m->held_lift_shear_signs[1] - m->lift_shear_sign[n]);
        double turning = moment_r - moment_l +
                         h * mat.c * (soil_l - soil_r + lift * m->lift_shear_lb) -
                         h * mat.s * (tension_l + tension_r);
        /* second derivative of sin theta */
        double rise = mat.c * turning * inverse_inertia - mat.s * mat.w * mat.w;
        double middle = (m->q1_lb - soil_l - soil_r) *
                        inverse_mass; /* n = 0: acceleration of the middle of mat 1 */
        if (n == m->held_node - 1) {
            double level = n == 0 ? -middle / h : -height * inverse_length;
            double shear = h * mat.c * mat.c * m->lift_shear_lb *
                           (m->held_lift_shear_signs[0] - m->lift_shear_sign[n]) * inverse_inertia;
            up = shear != 0.0 ? (level - rise) / shear : 0.0;
            rise = level;
        }
        if (n == 0 && m->held_node == 0)
            rise = middle / h;
        if (n == first) {
            height = first == 0 ? middle - h * rise : (m->q1_lb - 2.0 * soil_l) * inverse_mass;
            accel[2 * n] = height;
        }
        height = n == m->held_node - 1 ? 0.0 : height + m->length_ft * rise;
        accel[2 * n + 2] = height;
        mat = after;
        tension_l = tension_r;
        moment_l = moment_r;
        soil_l = soil_r;
    }
}

void report_rates(const struct model *model, double t_s, const double *z,
                  double *accel){KERNEL_DISPATCH(report_rates_kernel, model, t_s, z, accel)}

/* ---- consistent model: forces on the nodes, then one tridiagonal solve ---- */

KERNEL_INLINE double joint_tension_lb(const struct model *m, int j, const struct kernel_mat *l,
                                      const struct kernel_mat *r, const struct kernel_parts parts)
{
    return parts.are_tensions_given
             ? m->given_tension_lb[j]
             : kernel_tension_lb(m, j, l, r, parts.has_full_profile, parts.has_slack);
}

KERNEL_INLINE struct kernel_mat moving_mat_state(const struct model *m, const double *p,
                                                 const double *v, int n, double inverse_length,
                                                 const struct kernel_parts parts)
{
    return parts.are_tensions_given && m->tilt_ft ? kernel_tilted_mat(m, p, v, n, inverse_length)
                                                  : kernel_mat(p, v, n, inverse_length);
}

/* Kinematics of a mat outside the window: it is on the ground and has the tilt of the ground. If
 * the tensions are given, only the angle is used. */
KERNEL_INLINE struct kernel_mat resting_mat_state(const struct model *m, int n,
                                                  double inverse_length,
                                                  const struct kernel_parts parts)
{
    struct kernel_mat mat = kernel_outside(m, n);
    if (parts.are_tensions_given && m->rest_tilt_ft && n >= 0 && n < m->mats) {
        mat.s = m->rest_tilt_ft[n] * inverse_length;
        mat.c = sqrt(1.0 - mat.s * mat.s);
    }
    return mat;
}

KERNEL_INLINE double joint_moment_lb_ft(const struct model *m, int j, const struct kernel_mat *l,
                                        const struct kernel_mat *r, const struct kernel_parts parts)
{
    if (!m->torsion[j])
        return 0.0;
    return kernel_moment_with_stiffness(
        m, j, l, r, parts.are_tensions_given ? m->joint_kt_lb_ft_rad[j] : m->kt_lb_ft_rad);
}

KERNEL_INLINE double get_node_soil_force_lb(const struct model *m, const double *p, const double *v,
                                            int node, const struct kernel_parts parts)
{
    return parts.are_tensions_given ? kernel_local_soil_force_lb(m, p, v, node)
                                    : kernel_soil_force_lb(m, p, v, node);
}

KERNEL_INLINE void consistent_kernel(const struct model *m, double t_s, const double *z,
                                     double *accel, const struct kernel_parts parts)
{
    const double *p = z, *v = z + m->coordinate_count;
    const double length = m->length_ft, inverse_length = 1.0 / length,
                 inverse_mass = 1.0 / m->mass_slug;
    const double h = m->half_ft;
    double quarter = 0.25 * m->mass_slug, inertia = m->inertia_slug_ft2, weight_lb = m->weight_lb;
    const int first = m->first_mat, last = m->last_mat;
    struct kernel_thrust thrust = kernel_thrust(m, t_s);
    kernel_prepare(m, v, parts.friction_law);
    struct kernel_mat before = resting_mat_state(m, first - 1, inverse_length, parts);
    struct kernel_mat mat = moving_mat_state(m, p, v, first, inverse_length, parts);
    double tension_l = joint_tension_lb(m, first, &before, &mat, parts);
    double moment_l = joint_moment_lb_ft(m, first, &before, &mat, parts);
    double soil_l = get_node_soil_force_lb(m, p, v, first, parts);
    if (parts.has_braces)
        moment_l += m->brace_moment_lb_ft[first];
    /* upper diagonal of the factored mass matrix; one value per mat */
    double *upper = m->mass_upper;
    /* force on the left node, and diagonal element of the matrix, from the mats to the left */
    double force = 0.0, diagonal = 0.0;
    double upper_before = 0.0, off_before = 0.0, solved_before = 0.0;

    for (int n = first; n <= last; n++) {
        struct kernel_mat after = n < last ? moving_mat_state(m, p, v, n + 1, inverse_length, parts)
                                           : resting_mat_state(m, n + 1, inverse_length, parts);
        double tension_r = joint_tension_lb(m, n + 1, &mat, &after, parts);
        double moment_r = joint_moment_lb_ft(m, n + 1, &mat, &after, parts);
        double soil_r = get_node_soil_force_lb(m, p, v, n + 1, parts);
        if (parts.has_braces) {
            moment_r += m->brace_moment_lb_ft[n + 1];
            force += m->brace_force_lb[n];
        }
        double push = tension_r - tension_l;
        if (n == thrust.mat_a)
            push += thrust.a_lb;
        if (n == thrust.mat_b)
            push += thrust.b_lb;
        accel[2 * n + 1] = kernel_sliding_force_lb(m, n, mat.v, push, soil_l, soil_r,
                                                   parts.friction_law) *
                           inverse_mass;

        if (parts.are_tensions_given) { /* inertia and weight are proportional to mass */
            quarter = 0.25 * m->mass_slug * m->mass_ratio[n];
            inertia = m->inertia_slug_ft2 * m->mass_ratio[n];
            weight_lb = m->weight_lb * m->mass_ratio[n];
        }
        double turning = moment_r - moment_l - h * mat.s * (tension_l + tension_r);
        double inverse_lc = inverse_length / mat.c;
        double g = turning * inverse_lc - inertia * mat.s * mat.w * mat.w * inverse_lc / mat.c;
        double a = inertia * inverse_lc * inverse_lc;
        double damp_l = parts.are_tensions_given && m->contact[n]
                          ? parts.step_s * m->node_cv_lb_s_ft[n]
                          : 0.0;
        double damp_r = parts.are_tensions_given && m->contact[n + 1]
                          ? parts.step_s * m->node_cv_lb_s_ft[n + 1]
                          : 0.0;
        double down = 0.5 * weight_lb + (n == m->span.mat ? 0.5 * m->wheel_load_lb : 0.0);

        /* Eliminates the left node, whose terms are now complete. */
        double pivot = diagonal + quarter + a + damp_l - off_before * upper_before;
        double solved = (force - g + down - soil_l - off_before * solved_before) / pivot;
        off_before = quarter - a;
        upper_before = off_before / pivot;
        if (n == first && first > 0)
            solved = upper_before = 0.0; /* the outermost nodes of the window are fixed */
        solved_before = solved;
        upper[n] = upper_before;
        accel[2 * n] = solved;
        diagonal = quarter + a + damp_r;
        force = g + down - soil_r;

        mat = after;
        tension_l = tension_r;
        moment_l = moment_r;
        soil_l = soil_r;
    }
    if (parts.has_braces)
        force += m->brace_force_lb[last + 1];
    accel[2 * last + 2] = (force - off_before * solved_before) /
                          (diagonal - off_before * upper_before);
    if (last < m->mats - 1)
        accel[2 * last + 2] = 0.0;
    for (int n = last; n >= first; n--)
        accel[2 * n] -= upper[n] * accel[2 * n + 2];
}

void consistent_rates(const struct model *model, double t_s, const double *z, double *accel)
{
    KERNEL_DISPATCH(consistent_kernel, model, t_s, z, accel)
}

void consistent_heave_rates(const struct model *m, double step_s, const double *z, double *accel)
{
    if (m->brace_force_lb)
        consistent_kernel(
            m, 0.0, z, accel,
            (struct kernel_parts){false, false, true, true, SIM_FRICTION_NONE, step_s});
    else
        consistent_kernel(
            m, 0.0, z, accel,
            (struct kernel_parts){false, false, true, false, SIM_FRICTION_NONE, step_s});
}

/* ---- mass matrix and Jacobians in the present modes; rows and columns in the order of p (model.h)
 * ---- */

/* A quantity of joint j, and its derivatives with respect to Y_{j-1}, u_{j-1}, Y_j, u_j, Y_{j+1}
 * and to their rates. */
struct joint_slope {
    double value;
    double p[5], v[5];
};

/* Derivatives of quantities of a mat with respect to its height difference dY. That of sin theta is
 * 1/L. */
struct mat_slope {
    double angle_by_y; /* d theta/d dY, and d theta'/d dY' */
    double rate_by_y;  /* d theta'/d dY */
};

static struct mat_slope compute_mat_slope(const struct model *m, const struct kernel_mat *mat)
{
    double turn = 1.0 / (m->length_ft * mat->c);
    return (struct mat_slope){turn, mat->w * mat->s / (mat->c * mat->c * m->length_ft)};
}

static void add_difference(double *at, int left, int right, double slope)
{
    at[right] += slope;
    at[left] -= slope;
}

static struct joint_slope tension_slope(const struct model *m, int j, const struct kernel_mat *l,
                                        const struct kernel_mat *r)
{
    struct joint_slope t = {
        .value = kernel_tension_lb(m, j, l, r, m->has_full_profile, m->slack_ft > 0.0)};
    if ((j == 0 && m->is_left_free) || (j == m->mats && m->is_right_free) ||
        !joint_can_transmit_force(m->slack_ft > 0.0, m->joint_mode[j]))
        return t;
    add_difference(t.p, 1, 3, m->kl_lb_ft);
    add_difference(t.v, 1, 3, m->cl_lb_s_ft);
    if (m->has_full_profile) {
        const struct kernel_mat *mats[2] = {l, r};
        for (int k = 0; k < 2; k++) {
            const struct kernel_mat *mat = mats[k];
            struct mat_slope slope = compute_mat_slope(m, mat);
            double gap = m->half_ft * mat->s / mat->c / m->length_ft;
            double rate_p = m->half_ft * (slope.rate_by_y * mat->s + mat->w / m->length_ft);
            add_difference(t.p, 2 * k, 2 * k + 2, m->kl_lb_ft * gap + m->cl_lb_s_ft * rate_p);
            add_difference(t.v, 2 * k, 2 * k + 2,
                           m->cl_lb_s_ft * m->half_ft * mat->s * slope.angle_by_y);
        }
    }
    return t;
}

static struct joint_slope moment_slope(const struct model *m, int j, const struct kernel_mat *l,
                                       const struct kernel_mat *r)
{
    struct joint_slope t = {0};
    if (!m->torsion[j])
        return t;
    t.value = kernel_moment(m, j, l, r);
    struct mat_slope left = compute_mat_slope(m, l), right = compute_mat_slope(m, r);
    add_difference(t.p, 0, 2,
                   -m->kt_lb_ft_rad * left.angle_by_y - m->ct_lb_ft_s_rad * left.rate_by_y);
    add_difference(t.p, 2, 4,
                   m->kt_lb_ft_rad * right.angle_by_y + m->ct_lb_ft_s_rad * right.rate_by_y);
    add_difference(t.v, 0, 2, -m->ct_lb_ft_s_rad * left.angle_by_y);
    add_difference(t.v, 2, 4, m->ct_lb_ft_s_rad * right.angle_by_y);
    return t;
}

struct jacobian_rows {
    const struct model *m;
    double *mass, *dr_dp, *dr_dv;
};

static void add_band_element(const struct jacobian_rows *r, double *band, int row, int column,
                             double value)
{
    if (value != 0.0 && column >= 2 * r->m->first_mat && column <= 2 * r->m->last_mat + 2)
        band[row * MODEL_ROW_LENGTH + column - row + MODEL_HALF_BANDWIDTH] += value;
}

/* Adds a gradient with respect to Y_{n-1}..Y_{n+2}, multiplied by `scale`, to a row of the matrix
 * (7 values from column 2n-2). */
static void add_mat_gradient(const struct jacobian_rows *r, int row, int n, double scale,
                             const double *p, const double *v)
{
    for (int k = 0; k < 7; k++) {
        add_band_element(r, r->dr_dp, row, 2 * n - 2 + k, scale * p[k]);
        add_band_element(r, r->dr_dv, row, 2 * n - 2 + k, scale * v[k]);
    }
}

static void add_soil_gradient(const struct jacobian_rows *r, int row, int node, double scale)
{
    if (!r->m->contact[node])
        return;
    add_band_element(r, r->dr_dp, row, 2 * node, scale * r->m->kv_lb_ft);
    add_band_element(r, r->dr_dv, row, 2 * node, scale * r->m->cv_lb_s_ft);
}

static void displacement_row(const struct jacobian_rows *r, double t_s, const double *z, int n,
                             const struct kernel_mat *mat, const struct joint_slope *left,
                             const struct joint_slope *right, double *drift)
{
    const struct model *m = r->m;
    int row = 2 * n + 1;
    double rate;
    if (m->friction_law == SIM_FRICTION_STICK && m->slide_direction[n] == 0) {
        add_band_element(r, r->mass, row, row, 1.0);
        return;
    }
    add_band_element(r, r->mass, row, row, m->mass_slug);
    for (int k = 0; k < 5; k++) {
        add_band_element(r, r->dr_dp, row, 2 * n - 2 + k, -left->p[k]);
        add_band_element(r, r->dr_dv, row, 2 * n - 2 + k, -left->v[k]);
        add_band_element(r, r->dr_dp, row, 2 * n + k, right->p[k]);
        add_band_element(r, r->dr_dv, row, 2 * n + k, right->v[k]);
    }
    double smooth = m->friction_law == SIM_FRICTION_TANH ? elementary_tanh(mat->v / m->veps_ft_s)
                                                         : 0.0;
    double share = friction_share(m->friction_law, mat->v, m->slide_direction[n], smooth);
    if (m->friction_law == SIM_FRICTION_TANH)
        add_band_element(r, r->dr_dv, row, row,
                         friction_slope_lb_s_ft(m->friction_law, model_friction_limit_lb(m, z, n),
                                                share, m->veps_ft_s));
    if (m->elements.count > 0)
        add_band_element(r, r->dr_dv, row, row,
                         element_slope_lb_s_ft(&m->elements, model_element_mat(m, z, n)));
    if (m->has_soil_normal) {
        add_soil_gradient(r, row, n, -share * m->friction_coefficient);
        add_soil_gradient(r, row, n + 1, -share * m->friction_coefficient);
    }
    if (m->span.mat >= 0) {
        span_thrust_lb(&m->span, m->length_ft, t_s, n, &rate);
        drift[row] = rate;
    }
}

/* Moment of both joints on mat n, and its gradient with respect to Y_{n-1}..Y_{n+2}. */
static double turning_moment(const struct model *m, const struct kernel_mat *mat,
                             const struct joint_slope *tl, const struct joint_slope *tr,
                             const struct joint_slope *ml, const struct joint_slope *mr, double *p,
                             double *v)
{
    double hs = m->half_ft * mat->s;
    memset(p, 0, 7 * sizeof *p);
    memset(v, 0, 7 * sizeof *v);
    for (int k = 0; k < 5; k++) {
        p[k] += -ml->p[k] - hs * tl->p[k];
        v[k] += -ml->v[k] - hs * tl->v[k];
        p[k + 2] += mr->p[k] - hs * tr->p[k];
        v[k + 2] += mr->v[k] - hs * tr->v[k];
    }
    add_difference(p, 2, 4, -m->half_ft * (tl->value + tr->value) / m->length_ft);
    return mr->value - ml->value - hs * (tl->value + tr->value);
}

static void report_rows(const struct jacobian_rows *r, const double *z, int n,
                        const struct kernel_mat *mat, double turning, double *p, double *v)
{
    const struct model *m = r->m;
    const double *zp = z, *zv = z + m->coordinate_count;
    double h = m->half_ft, length = m->length_ft;
    double lean = -mat->s / mat->c / length; /* derivative of cos theta with respect to dY */
    double soil = kernel_soil_force_lb(m, zp, zv, n) - kernel_soil_force_lb(m, zp, zv, n + 1) +
                  m->lift_shear_sign[n] * m->lift_shear_lb;
    struct mat_slope slope = compute_mat_slope(m, mat);
    add_difference(p, 2, 4, h * lean * soil);
    turning += h * mat->c * soil;
    for (int end = 0; end < 2; end++) {
        if (m->contact[n + end]) {
            double sign = end == 0 ? 1.0 : -1.0;
            p[2 + 2 * end] += sign * h * mat->c * m->kv_lb_ft;
            v[2 + 2 * end] += sign * h * mat->c * m->cv_lb_s_ft;
        }
    }
    for (int k = 0; k < 7; k++) {
        p[k] *= mat->c / m->inertia_slug_ft2;
        v[k] *= mat->c / m->inertia_slug_ft2;
    }
    add_difference(p, 2, 4,
                   lean * turning / m->inertia_slug_ft2 - mat->w * mat->w / length -
                       2.0 * mat->s * mat->w * slope.rate_by_y);
    add_difference(v, 2, 4, -2.0 * mat->s * mat->w * slope.angle_by_y);

    int row = 2 * n + 2;
    add_band_element(r, r->mass, row, row, 1.0);
    if (n == 0 && m->held_node >= 0 && m->held_node <= 1) {
        /* In this row, the acceleration of the held node is 0, so the other end of mat 1
         * accelerates twice as fast as its middle. */
        int other = m->held_node == 0 ? row : row - 2;
        add_band_element(r, r->mass, 0, 0, 1.0);
        add_soil_gradient(r, other, 0, -2.0 / m->mass_slug);
        add_soil_gradient(r, other, 1, -2.0 / m->mass_slug);
        return;
    }
    if (n == m->held_node - 1)
        return; /* the acceleration of the held node is 0 */
    add_band_element(r, r->mass, row, row - 2, -1.0);
    add_mat_gradient(r, row, n, length, p, v);
    if (n == m->first_mat) {
        row = 2 * n;
        add_band_element(r, r->mass, row, row, 1.0);
        add_soil_gradient(r, row, n, -(n == 0 ? 1.0 : 2.0) / m->mass_slug);
        if (n == 0) {
            add_soil_gradient(r, row, 1, -1.0 / m->mass_slug);
            add_mat_gradient(r, row, 0, -h, p, v);
        }
    }
}

static void consistent_rows(const struct jacobian_rows *r, const double *accel, int n,
                            const struct kernel_mat *mat, double turning, double *p, double *v)
{
    const struct model *m = r->m;
    double length = m->length_ft, quarter = 0.25 * m->mass_slug, c2 = mat->c * mat->c;
    double a = m->inertia_slug_ft2 / (length * length * c2);
    double a_y = 2.0 * a * mat->s / c2 / length;
    struct mat_slope slope = compute_mat_slope(m, mat);
    double spin = m->inertia_slug_ft2 * mat->s * mat->w / (length * c2);
    for (int k = 0; k < 7; k++) {
        p[k] *= slope.angle_by_y;
        v[k] *= slope.angle_by_y;
    }
    /* derivative of 1/(L cos theta) with respect to dY: angle_by_y s/(c^2 L); the derivative of s
     * w^2/c^2 has three terms */
    add_difference(p, 2, 4,
                   turning * slope.angle_by_y * mat->s / c2 / length -
                       2.0 * spin * slope.rate_by_y -
                       m->inertia_slug_ft2 * mat->w * mat->w / (length * c2) *
                           (1.0 + 2.0 * mat->s * mat->s / c2) / length);
    add_difference(v, 2, 4, -2.0 * spin * slope.angle_by_y);
    add_mat_gradient(r, 2 * n, n, -1.0, p, v);
    add_mat_gradient(r, 2 * n + 2, n, 1.0, p, v);
    add_band_element(r, r->mass, 2 * n, 2 * n, quarter + a);
    add_band_element(r, r->mass, 2 * n, 2 * n + 2, quarter - a);
    add_band_element(r, r->mass, 2 * n + 2, 2 * n + 2, quarter + a);
    add_band_element(r, r->mass, 2 * n + 2, 2 * n, quarter - a);
    /* derivative of the mass matrix, times accel */
    double change = a_y * (accel[2 * n + 2] - accel[2 * n]);
    add_band_element(r, r->dr_dp, 2 * n, 2 * n + 2, change);
    add_band_element(r, r->dr_dp, 2 * n, 2 * n, -change);
    add_band_element(r, r->dr_dp, 2 * n + 2, 2 * n + 2, -change);
    add_band_element(r, r->dr_dp, 2 * n + 2, 2 * n, change);
    add_soil_gradient(r, 2 * n, n, -1.0);
    add_soil_gradient(r, 2 * n + 2, n + 1, -1.0);
}

/* Sets the row of an outermost node of the window, which does not move in the consistent model. */
static void set_fixed_node_row(const struct jacobian_rows *r, int row)
{
    size_t from = (size_t)row * MODEL_ROW_LENGTH;
    memset(r->mass + from, 0, MODEL_ROW_LENGTH * sizeof *r->mass);
    memset(r->dr_dp + from, 0, MODEL_ROW_LENGTH * sizeof *r->dr_dp);
    memset(r->dr_dv + from, 0, MODEL_ROW_LENGTH * sizeof *r->dr_dv);
    r->mass[from + MODEL_HALF_BANDWIDTH] = 1.0;
}

void model_linearise(struct model *m, double t_s, const double *z, const double *accel,
                     double *mass, double *dr_dp, double *dr_dv, double *drift)
{
    const double *zp = z, *zv = z + m->coordinate_count;
    const struct jacobian_rows rows = {m, mass, dr_dp, dr_dv};
    size_t low = 2 * (size_t)m->first_mat, count = 2 * (size_t)(m->last_mat - m->first_mat) + 3;
    memset(mass + low * MODEL_ROW_LENGTH, 0, count * MODEL_ROW_LENGTH * sizeof *mass);
    memset(dr_dp + low * MODEL_ROW_LENGTH, 0, count * MODEL_ROW_LENGTH * sizeof *dr_dp);
    memset(dr_dv + low * MODEL_ROW_LENGTH, 0, count * MODEL_ROW_LENGTH * sizeof *dr_dv);
    memset(drift + low, 0, count * sizeof *drift);
    struct kernel_mat before = kernel_outside(m, m->first_mat - 1);
    struct kernel_mat mat = kernel_mat(zp, zv, m->first_mat, 1.0 / m->length_ft);
    struct joint_slope tension_l = tension_slope(m, m->first_mat, &before, &mat);
    struct joint_slope moment_l = moment_slope(m, m->first_mat, &before, &mat);
    for (int n = m->first_mat; n <= m->last_mat; n++) {
        struct kernel_mat after = n < m->last_mat ? kernel_mat(zp, zv, n + 1, 1.0 / m->length_ft)
                                                  : kernel_outside(m, n + 1);
        struct joint_slope tension_r = tension_slope(m, n + 1, &mat, &after);
        struct joint_slope moment_r = moment_slope(m, n + 1, &mat, &after);
        double p[7], v[7];
        displacement_row(&rows, t_s, z, n, &mat, &tension_l, &tension_r, drift);
        double turning = turning_moment(m, &mat, &tension_l, &tension_r, &moment_l, &moment_r, p,
                                        v);
        if (m->is_consistent)
            consistent_rows(&rows, accel, n, &mat, turning, p, v);
        else
            report_rows(&rows, z, n, &mat, turning, p, v);
        mat = after;
        tension_l = tension_r;
        moment_l = moment_r;
    }
    if (m->is_consistent && m->first_mat > 0)
        set_fixed_node_row(&rows, 2 * m->first_mat);
    if (m->is_consistent && m->last_mat < m->mats - 1)
        set_fixed_node_row(&rows, 2 * m->last_mat + 2);
}

/* ---- banded matrices ---- */

void banded_combine(int size, double x, const double *mass, double y, const double *dr_dp, double z,
                    const double *dr_dv, double *a)
{
    for (int i = 0; i < size; i++) {
        double *row = a + (size_t)i * BANDED_ROW_LENGTH;
        size_t from = (size_t)i * MODEL_ROW_LENGTH;
        for (size_t k = 0; k < MODEL_ROW_LENGTH; k++)
            row[k] = x * mass[from + k] + y * dr_dp[from + k] + z * dr_dv[from + k];
        for (size_t k = MODEL_ROW_LENGTH; k < BANDED_ROW_LENGTH; k++)
            row[k] = 0.0;
    }
}

bool banded_factor(int size, double *a, int *pivot)
{
    for (int i = 0; i < size; i++) {
        int below = i + MODEL_HALF_BANDWIDTH < size ? MODEL_HALF_BANDWIDTH : size - 1 - i;
        /* row[0] is the diagonal element */
        double *row = a + (size_t)i * BANDED_ROW_LENGTH + MODEL_HALF_BANDWIDTH;
        int best = 0;
        double most = fabs(row[0]);
        for (int r = 1; r <= below; r++) {
            double value =
                fabs(a[(size_t)(i + r) * BANDED_ROW_LENGTH + MODEL_HALF_BANDWIDTH - (size_t)r]);
            if (value > most) {
                most = value;
                best = r;
            }
        }
        if (!(most > 0.0) || !isfinite(most))
            return false;
        pivot[i] = best;
        if (best > 0) {
            double *other = a + (size_t)(i + best) * BANDED_ROW_LENGTH + MODEL_HALF_BANDWIDTH -
                            best;
            for (int k = 0; k <= 2 * MODEL_HALF_BANDWIDTH; k++) {
                double kept = row[k];
                row[k] = other[k];
                other[k] = kept;
            }
        }
        double inverse = 1.0 / row[0];
        for (int r = 1; r <= below; r++) {
            double *under = a + (size_t)(i + r) * BANDED_ROW_LENGTH + MODEL_HALF_BANDWIDTH - r;
            if (under[0] == 0.0)
                continue;
            double factor = under[0] * inverse;
            under[0] = factor;
            for (int k = 1; k <= 2 * MODEL_HALF_BANDWIDTH; k++)
                under[k] -= factor * row[k];
        }
    }
    return true;
}

void banded_solve(int size, const double *a, const int *pivot, double *x)
{
    for (int i = 0; i < size; i++) {
        int below = i + MODEL_HALF_BANDWIDTH < size ? MODEL_HALF_BANDWIDTH : size - 1 - i;
        if (pivot[i] > 0) {
            double kept = x[i];
            x[i] = x[i + pivot[i]];
            x[i + pivot[i]] = kept;
        }
        for (int r = 1; r <= below; r++)
            x[i + r] -= a[(size_t)(i + r) * BANDED_ROW_LENGTH + MODEL_HALF_BANDWIDTH - (size_t)r] *
                        x[i];
    }
    for (int i = size - 1; i >= 0; i--) {
        const double *row = a + (size_t)i * BANDED_ROW_LENGTH + MODEL_HALF_BANDWIDTH;
        int right = i + 2 * MODEL_HALF_BANDWIDTH < size ? 2 * MODEL_HALF_BANDWIDTH : size - 1 - i;
        double sum = x[i];
        for (int k = 1; k <= right; k++)
            sum -= row[k] * x[i + k];
        x[i] = sum / row[0];
    }
}

void banded_multiply(int size, const double *rows, const double *x, double *y)
{
    for (int i = 0; i < size; i++) {
        int low = i < MODEL_HALF_BANDWIDTH ? MODEL_HALF_BANDWIDTH - i : 0;
        int high = i + MODEL_HALF_BANDWIDTH < size ? 2 * MODEL_HALF_BANDWIDTH
                                                   : MODEL_HALF_BANDWIDTH + size - 1 - i;
        double sum = 0.0;
        for (int k = low; k <= high; k++)
            sum += rows[(size_t)i * MODEL_ROW_LENGTH + (size_t)k] * x[i + k - MODEL_HALF_BANDWIDTH];
        y[i] = sum;
    }
}
