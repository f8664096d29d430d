/* The report's model (PLANAR.md, "Report model"), evaluated from one end of the window to the
 * other: each mat's angular acceleration is local, node heights accelerate as its running sum. */
#include "host/sim/models/kernel.h"

/* A flat mat with nothing in its joints, both feet in the same mode. */
KERNEL_INLINE bool flat_stays(const struct model *m, int n, const struct kernel_mat *mat)
{
    return mat->s == 0.0 && mat->w == 0.0 && !m->torsion[n] && !m->torsion[n + 1] &&
           m->lift[n] == 0 && m->contact[n] == m->contact[n + 1] && n != m->held - 1 &&
           n != m->held;
}

KERNEL_INLINE void kernel(const struct model *m, double t_s, const double *z, double *accel,
                          const struct kernel_parts parts)
{
    const double *p = z, *v = z + m->size;
    const double inverse_length = 1.0 / m->length_ft, inverse_mass = 1.0 / m->mass_slug;
    const double inverse_inertia = 1.0 / m->inertia, h = m->half_ft;
    const int first = m->first, last = m->last;
    struct kernel_thrust thrust = kernel_thrust(m, t_s);
    kernel_prepare(m, v, parts.law);
    struct kernel_mat before = kernel_outside(m, first - 1);
    struct kernel_mat mat = kernel_mat(p, v, first, inverse_length);
    double tension_l = kernel_tension_lb(m, first, &before, &mat, parts.full, parts.slack);
    double moment_l = m->torsion[first] ? kernel_moment(m, first, &before, &mat) : 0.0;
    double soil_l = kernel_soil_lb(m, p, v, first);
    double height = 0.0, up = 0.0; /* up: share of the time that the held node is up */

    for (int n = first; n <= last; n++) {
        struct kernel_mat after = n < last ? kernel_mat(p, v, n + 1, inverse_length)
                                           : kernel_outside(m, n + 1);
        double tension_r = kernel_tension_lb(m, n + 1, &mat, &after, parts.full, parts.slack);
        double moment_r = m->torsion[n + 1] ? kernel_moment(m, n + 1, &mat, &after) : 0.0;
        double push = tension_r - tension_l;
        if (n == thrust.mat_a)
            push += thrust.a_lb;
        if (n == thrust.mat_b)
            push += thrust.b_lb;
        accel[2 * n + 1] = kernel_slide_lb(m, n, mat.v, push, 0.0, 0.0, parts.law) * inverse_mass;

        if (flat_stays(m, n, &mat)) { /* nothing turns it: soil_l is soil_r */
            if (n == first)
                accel[2 * n] = height = (m->q1_lb - 2.0 * soil_l) * inverse_mass;
            accel[2 * n + 2] = height;
            mat = after;
            tension_l = tension_r;
            moment_l = moment_r;
            continue;
        }
        double soil_r = kernel_soil_lb(m, p, v, n + 1);
        double lift = m->lift[n];
        if (n == m->held)
            lift += up * (m->held_lift[1] - m->lift[n]);
        double turning = moment_r - moment_l + h * mat.c * (soil_l - soil_r + lift * m->shear_lb) -
                         h * mat.s * (tension_l + tension_r);
        double rise = mat.c * turning * inverse_inertia - mat.s * mat.w * mat.w; /* (sin theta)'' */
        double middle = (m->q1_lb - soil_l - soil_r) * inverse_mass;             /* of mat 1 */
        if (n == m->held - 1) {
            double level = n == 0 ? -middle / h : -height * inverse_length;
            double shear = h * mat.c * mat.c * m->shear_lb * (m->held_lift[0] - m->lift[n]) *
                           inverse_inertia;
            up = shear != 0.0 ? (level - rise) / shear : 0.0;
            rise = level;
        }
        if (n == 0 && m->held == 0)
            rise = middle / h;
        if (n == first) {
            height = first == 0 ? middle - h * rise : (m->q1_lb - 2.0 * soil_l) * inverse_mass;
            accel[2 * n] = height;
        }
        height = n == m->held - 1 ? 0.0 : height + m->length_ft * rise;
        accel[2 * n + 2] = height;
        mat = after;
        tension_l = tension_r;
        moment_l = moment_r;
        soil_l = soil_r;
    }
}

void report_rates(const struct model *model, double t_s, const double *z, double *accel)
{
    KERNEL_DISPATCH(kernel, model, t_s, z, accel)
}
