/* The consistent model (PLANAR.md, "Consistent model"): forces on the nodes, then one tridiagonal
 * solve. */
#include "host/sim/models/kernel.h"

KERNEL_INLINE double tension(const struct model *m, int j, const struct kernel_mat *l,
                             const struct kernel_mat *r, const struct kernel_parts parts)
{
    return parts.given ? m->given_lb[j] : kernel_tension_lb(m, j, l, r, parts.full, parts.slack);
}

KERNEL_INLINE struct kernel_mat inside(const struct model *m, const double *p, const double *v,
                                       int n, double inverse_length,
                                       const struct kernel_parts parts)
{
    if (parts.parted)
        return kernel_parted_mat(m, p, v, n, inverse_length);
    return parts.given && m->tilt_ft ? kernel_tilted_mat(m, p, v, n, inverse_length)
                                     : kernel_mat(p, v, n, inverse_length);
}

/* A mat beyond the window lies on the ground, tilted as that is; where tensions are given nothing
 * else is looked at. */
KERNEL_INLINE struct kernel_mat outside(const struct model *m, int n, double inverse_length,
                                        const struct kernel_parts parts)
{
    struct kernel_mat mat = kernel_outside(m, n);
    if (parts.given && m->tilt_ft && n >= 0 && n < m->mats) {
        mat.s = m->tilt_ft[n] * inverse_length;
        mat.c = sqrt(1.0 - mat.s * mat.s);
    }
    return mat;
}

/* What the ground under the right end of mat n pushes with; its own end where that is apart. */
KERNEL_INLINE double right_soil_lb(const struct model *m, const double *p, const double *v, int n,
                                   bool apart)
{
    const struct parting *parting = m->parting;
    if (!apart)
        return kernel_soil_lb(m, p, v, n + 1);
    return parting->contact[n + 1]
             ? soil_lb(m->kv, m->cv, parting->y_ft[n + 1], parting->v_ft_s[n + 1])
             : 0.0;
}

KERNEL_INLINE void kernel(const struct model *m, double t_s, const double *z, double *accel,
                          const struct kernel_parts parts)
{
    const double *p = z, *v = z + m->size;
    const double length = m->length_ft, inverse_length = 1.0 / length,
                 inverse_mass = 1.0 / m->mass_slug;
    const double h = m->half_ft, quarter = 0.25 * m->mass_slug;
    const int first = m->first, last = m->last;
    struct kernel_thrust thrust = kernel_thrust(m, t_s);
    kernel_prepare(m, v, parts.law);
    struct kernel_mat before = outside(m, first - 1, inverse_length, parts);
    struct kernel_mat mat = inside(m, p, v, first, inverse_length, parts);
    double tension_l = tension(m, first, &before, &mat, parts);
    double moment_l = m->torsion[first] ? kernel_moment(m, first, &before, &mat) : 0.0;
    double soil_l = kernel_soil_lb(m, p, v, first);
    if (parts.braced)
        moment_l += m->brace_lb_ft[first];
    double *upper = m->mass_upper;      /* of the factored mass matrix, per mat */
    double force = 0.0, diagonal = 0.0; /* of the node at the left end, from the mats before it */
    double upper_before = 0.0, off_before = 0.0, solved_before = 0.0;

    for (int n = first; n <= last; n++) {
        struct kernel_mat after = n < last ? inside(m, p, v, n + 1, inverse_length, parts)
                                           : outside(m, n + 1, inverse_length, parts);
        double tension_r = tension(m, n + 1, &mat, &after, parts);
        double moment_r = m->torsion[n + 1] ? kernel_moment(m, n + 1, &mat, &after) : 0.0;
        bool apart = parts.parted && m->parting->apart[n + 1];
        double soil_r = right_soil_lb(m, p, v, n, apart);
        if (parts.braced) {
            moment_r += m->brace_lb_ft[n + 1];
            force += m->brace_lb[n];
        }
        double push = tension_r - tension_l;
        if (n == thrust.mat_a)
            push += thrust.a_lb;
        if (n == thrust.mat_b)
            push += thrust.b_lb;
        accel[2 * n + 1] = kernel_slide_lb(m, n, mat.v, push, soil_l, soil_r, parts.law) *
                           inverse_mass;

        double turning = moment_r - moment_l - h * mat.s * (tension_l + tension_r);
        double inverse_lc = inverse_length / mat.c;
        double g = turning * inverse_lc - m->inertia * mat.s * mat.w * mat.w * inverse_lc / mat.c;
        double a = m->inertia * inverse_lc * inverse_lc;
        double damp_l = parts.given && m->contact[n] ? parts.step_s * m->cv : 0.0;
        bool touches_r = apart ? m->parting->contact[n + 1] : m->contact[n + 1];
        double damp_r = parts.given && touches_r ? parts.step_s * m->cv : 0.0;
        double down = 0.5 * m->weight_lb + (n == m->span.mat ? 0.5 * m->wheel_load_lb : 0.0);

        /* eliminate the left node: nothing else will be added to it */
        double pivot = diagonal + quarter + a + damp_l - off_before * upper_before;
        double solved = (force - g + down - soil_l - off_before * solved_before) / pivot;
        off_before = quarter - a;
        upper_before = off_before / pivot;
        if (n == first && first > 0)
            solved = upper_before = 0.0; /* the window's outermost nodes are held */
        solved_before = solved;
        upper[n] = upper_before;
        accel[2 * n] = solved;
        diagonal = quarter + a + damp_r;
        force = g + down - soil_r;

        mat = after;
        tension_l = tension_r;
        moment_l = moment_r;
        soil_l = soil_r;
        if (apart) { /* nothing else holds that end: the next mat begins anew */
            double pivot_r = diagonal - off_before * upper_before;
            m->parting->accel[n + 1] =
                n < last
                    ? (force + m->parting->down_lb[n + 1] - off_before * solved_before) / pivot_r
                    : 0.0;
            force = diagonal = upper_before = off_before = solved_before = 0.0;
            soil_l = kernel_soil_lb(m, p, v, n + 1);
        }
    }
    bool apart = parts.parted && m->parting->apart[last + 1];
    if (parts.braced)
        force += m->brace_lb[last + 1];
    accel[2 * last + 2] =
        apart ? 0.0 : (force - off_before * solved_before) / (diagonal - off_before * upper_before);
    if (last < m->mats - 1)
        accel[2 * last + 2] = 0.0;
    for (int n = last; n >= first; n--)
        accel[2 * n] -= upper[n] * (parts.parted && m->parting->apart[n + 1]
                                        ? m->parting->accel[n + 1]
                                        : accel[2 * n + 2]);
}

void consistent_rates(const struct model *model, double t_s, const double *z, double *accel)
{
    KERNEL_DISPATCH(kernel, model, t_s, z, accel)
}

void consistent_heave(const struct model *m, double step_s, const double *z, double *accel)
{
    if (m->parting)
        kernel(m, 0.0, z, accel,
               (struct kernel_parts){false, false, true, true, true, SIM_NONE, step_s});
    else if (m->brace_lb)
        kernel(m, 0.0, z, accel,
               (struct kernel_parts){false, false, true, true, false, SIM_NONE, step_s});
    else
        kernel(m, 0.0, z, accel,
               (struct kernel_parts){false, false, true, false, false, SIM_NONE, step_s});
}
