/* Kernel: the common parts of the right-hand sides of both models: kinematics, and the laws of
 * elements/ in the present modes. The functions are inlined, so that the compiler removes the parts
 * that a scene does not need. PLANAR.md, "Common pieces". Private to this folder and
 * solvers/planar_engine.c. */
#ifndef MATRIG_HOST_SIM_MODELS_KERNEL_H
#define MATRIG_HOST_SIM_MODELS_KERNEL_H

#include <math.h>

#include "host/base/elementary.h"
#include "host/sim/elements/law.h"
#include "host/sim/models/model.h"

/* Computes to[i] = tanh(scale * from[2 i]) for i = 0..count-1, with an absolute error below
 * 4e-16. */
void vector_tanh(const double *from, double scale, double *to, int count);

#define KERNEL_INLINE static inline __attribute__((always_inline))

/* Selects the parts of a kernel. The values are compile-time constants wherever the kernel is
 * inlined. */
struct kernel_parts {
    bool has_full_profile;
    bool has_slack;
    /* the tensions of the joints are given, and the step treats damping of the soil implicitly */
    bool are_tensions_given;
    /* `are_tensions_given` is true, and modifications act on nodes and joints */
    bool has_braces;
    enum sim_friction friction_law;
    double step_s; /* length of the step if `are_tensions_given`; not a compile-time constant */
};

/* Angle of a mat and its rate. The ground, and a mat at rest outside the window, are flat. */
struct kernel_mat {
    double s, c; /* sine and cosine of theta */
    double w;    /* theta' */
    double u, v;
};

/* The thrust, which acts on at most two mats at a time. */
struct kernel_thrust {
    int mat_a, mat_b;
    double a_lb, b_lb;
};

KERNEL_INLINE struct kernel_thrust kernel_thrust(const struct model *m, double t_s)
{
    struct kernel_thrust thrust = {-2, -2, 0.0, 0.0};
    double rate;
    if (m->span.mat < 0)
        return thrust;
    thrust.mat_a = m->span.first_sharing_mat == -2 ? m->span.mat
                 : m->span.first_sharing_mat < 0   ? 0
                                                   : m->span.first_sharing_mat;
    thrust.a_lb = span_thrust_lb(&m->span, m->length_ft, t_s, thrust.mat_a, &rate);
    if (m->span.first_sharing_mat >= 0) {
        thrust.mat_b = m->span.first_sharing_mat + 1;
        thrust.b_lb = span_thrust_lb(&m->span, m->length_ft, t_s, thrust.mat_b, &rate);
    }
    return thrust;
}

KERNEL_INLINE struct kernel_mat kernel_mat(const double *p, const double *v, int n,
                                           double inverse_length)
{
    double dy = p[2 * n + 2] - p[2 * n];
    double dv = v[2 * n + 2] - v[2 * n];
    struct kernel_mat mat = {0.0, 1.0, dv * inverse_length, p[2 * n + 1], v[2 * n + 1]};
    if (dy != 0.0) {
        mat.s = dy * inverse_length;
        /* NaN for an angle above 90 degrees; the step is then refused */
        mat.c = sqrt(1.0 - mat.s * mat.s);
        mat.w /= mat.c;
    }
    return mat;
}

/* Kinematics of a mat on uneven ground, as kernel_mat. */
KERNEL_INLINE struct kernel_mat kernel_tilted_mat(const struct model *m, const double *p,
                                                  const double *v, int n, double inverse_length)
{
    double dy = p[2 * n + 2] - p[2 * n] + m->tilt_ft[n];
    struct kernel_mat mat = {dy * inverse_length, 1.0, (v[2 * n + 2] - v[2 * n]) * inverse_length,
                             p[2 * n + 1], v[2 * n + 1]};
    mat.c = sqrt(1.0 - mat.s * mat.s);
    mat.w /= mat.c;
    return mat;
}

/* Kinematics of the ground, and of a mat outside the window: flat and at rest. */
KERNEL_INLINE struct kernel_mat kernel_outside(const struct model *m, int n)
{
    return (struct kernel_mat){0.0, 1.0, 0.0, n < 0 || n >= m->mats ? 0.0 : m->rest_u_ft[n], 0.0};
}

KERNEL_INLINE double kernel_gap_ft(const struct model *m, int j, const struct kernel_mat *l,
                                   const struct kernel_mat *r, bool full)
{
    double g = r->u - l->u;
    if (full)
        g += m->length_ft - m->half_ft * (l->c + r->c);
    if (m->scene->gap0_ft.count > 0)
        g += sim_scene_joint_value(&m->scene->gap0_ft, j + 1);
    return g;
}

/* Tension in joint j, between mats l and r. */
KERNEL_INLINE double kernel_tension_lb(const struct model *m, int j, const struct kernel_mat *l,
                                       const struct kernel_mat *r, bool full, bool slack)
{
    if ((j == 0 && m->is_left_free) || (j == m->mats && m->is_right_free))
        return 0.0;
    double g = kernel_gap_ft(m, j, l, r, full);
    double rate = r->v - l->v;
    if (full)
        rate += m->half_ft * (l->w * l->s + r->w * r->s);
    const struct law_joint joint = {m->kl_lb_ft, m->cl_lb_s_ft, m->slack_ft};
    return joint_mode_force_lb(&joint, slack, slack ? m->joint_mode[j] : 0, g, rate);
}

KERNEL_INLINE double kernel_joint_angle_rad(const struct kernel_mat *l, const struct kernel_mat *r)
{
    return (r->s != 0.0 ? elementary_asin(r->s) : 0.0) -
           (l->s != 0.0 ? elementary_asin(l->s) : 0.0);
}

/* Moment in joint j, which must be engaged. */
KERNEL_INLINE double kernel_moment_with_stiffness(const struct model *m, int j,
                                                  const struct kernel_mat *l,
                                                  const struct kernel_mat *r, double kt)
{
    double wound = hinge_effective_angle_rad(m->has_torsion_jump, m->torsion[j],
                                             kernel_joint_angle_rad(l, r), m->tad_rad);
    return hinge_moment_lb_ft(kt, m->ct_lb_ft_s_rad, wound, r->w - l->w);
}

KERNEL_INLINE double kernel_moment(const struct model *m, int j, const struct kernel_mat *l,
                                   const struct kernel_mat *r)
{
    return kernel_moment_with_stiffness(m, j, l, r, m->kt_lb_ft_rad);
}

KERNEL_INLINE double kernel_soil_force_lb(const struct model *m, const double *p, const double *v,
                                          int node)
{
    return m->contact[node] ? soil_force_lb(m->kv_lb_ft, m->cv_lb_s_ft, p[2 * node], v[2 * node])
                            : 0.0;
}

/* Force of the soil at a node with its own soil properties, as kernel_soil_force_lb. */
KERNEL_INLINE double kernel_local_soil_force_lb(const struct model *m, const double *p,
                                                const double *v, int node)
{
    return m->contact[node] ? soil_force_lb(m->node_kv_lb_ft[node], m->node_cv_lb_s_ft[node],
                                            p[2 * node], v[2 * node])
                            : 0.0;
}

KERNEL_INLINE double kernel_limit_lb(const struct model *m, int n, double soil_l, double soil_r)
{
    if (m->has_soil_normal)
        return m->friction_coefficient * (soil_l + soil_r);
    return m->weight_friction_lb +
           (n == m->span.mat ? m->friction_coefficient * m->wheel_load_lb : 0.0);
}

/* Prepares the values that kernel_sliding_force_lb needs for the law tanh. */
KERNEL_INLINE void kernel_prepare(const struct model *m, const double *v, enum sim_friction law)
{
    if (law == SIM_FRICTION_TANH)
        vector_tanh(v + 2 * m->first_mat + 1, 1.0 / m->veps_ft_s, m->friction_tanh + m->first_mat,
                    m->last_mat - m->first_mat + 1);
}

/* Force m u'' on a mat: the push x minus friction. */
KERNEL_INLINE double kernel_sliding_force_lb(const struct model *m, int n, double v, double x,
                                             double soil_l, double soil_r, enum sim_friction law)
{
    if (law == SIM_FRICTION_STICK && m->slide_direction[n] == 0)
        return 0.0;
    if (law == SIM_FRICTION_NONE)
        return x;
    return x - friction_force_lb(law, kernel_limit_lb(m, n, soil_l, soil_r), v,
                                 law == SIM_FRICTION_STICK ? m->slide_direction[n] : 0,
                                 law == SIM_FRICTION_TANH ? m->friction_tanh[n] : 0.0);
}

/* Calls `kernel` with compile-time constants that describe this scene. */
/* clang-format off */
#define KERNEL_LAWS(kernel, full, slack, law, ...)                                       \
    switch (law) {                                                                       \
    case SIM_FRICTION_STICK: kernel(__VA_ARGS__, (struct kernel_parts){full, slack, false, false, \
        SIM_FRICTION_STICK, 0.0}); break;                                                        \
    case SIM_FRICTION_TANH: kernel(__VA_ARGS__, (struct kernel_parts){full, slack, false, false,  \
        SIM_FRICTION_TANH, 0.0}); break;                                                         \
    case SIM_FRICTION_SIGN: kernel(__VA_ARGS__, (struct kernel_parts){full, slack, false, false,  \
        SIM_FRICTION_SIGN, 0.0}); break;                                                         \
    case SIM_FRICTION_NONE: kernel(__VA_ARGS__, (struct kernel_parts){full, slack, false, false,  \
        SIM_FRICTION_NONE, 0.0}); break;                                                         \
    }
#define KERNEL_DISPATCH(kernel, m, ...)                                \
    if ((m)->has_full_profile) {                                                   \
        if ((m)->slack_ft > 0.0) {                                     \
            KERNEL_LAWS(kernel, true, true, (m)->friction_law, m, __VA_ARGS__)  \
        } else {                                                       \
            KERNEL_LAWS(kernel, true, false, (m)->friction_law, m, __VA_ARGS__) \
        }                                                              \
    } else if ((m)->slack_ft > 0.0) {                                  \
        KERNEL_LAWS(kernel, false, true, (m)->friction_law, m, __VA_ARGS__)     \
    } else {                                                           \
        KERNEL_LAWS(kernel, false, false, (m)->friction_law, m, __VA_ARGS__)    \
    }
/* clang-format on */

/* Computes the change of the rates of the nodes over a step of step_s, divided by step_s. The joint
 * tensions are model->given_tension_lb, and the dampers of the soil act with the rates at the end
 * of the step. Entries for the mats are not valid. */
void consistent_heave_rates(const struct model *model, double step_s, const double *z,
                            double *accel);

#endif
