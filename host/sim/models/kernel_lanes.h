/* Kernel of four mats at a time: what the right-hand sides of both models share, of kernel.h, in
 * lanes. The same bits (tests/host/test_sim_lanes.c). What few mats have (a moment, a thrust, the
 * ground beyond the ends) is done by kernel.h, mat by mat. Private to this folder. */
#ifndef MATRIG_HOST_SIM_MODELS_KERNEL_LANES_H
#define MATRIG_HOST_SIM_MODELS_KERNEL_LANES_H

#include "host/sim/models/kernel.h"
#include "host/sim/models/lanes_math.h"

#define KERNEL_LANES_LEAST 5 /* mats: four joints between them */

/* The window's mats; entry k belongs to mat first + k, to its left node and to its left joint. */
struct kernel_lanes {
    int first, count;
    double *s, *c, *w, *u, *v;         /* struct kernel_mat */
    double *soil_lb;                   /* node; count + 1 */
    double *tension_lb, *moment_lb_ft; /* joint; count + 1 */
    double *slide_ft_s2;               /* u'' */
    double *more[MODEL_LANES_ROWS - 9];
};

KERNEL_INLINE struct kernel_lanes kernel_lanes(const struct model *m)
{
    struct kernel_lanes of = {.first = m->first, .count = m->last - m->first + 1};
    double **rows[] = {&of.s,           &of.c,       &of.w,          &of.u,
                       &of.v,           &of.soil_lb, &of.tension_lb, &of.moment_lb_ft,
                       &of.slide_ft_s2, &of.more[0], &of.more[1],    &of.more[2]};
    _Static_assert(sizeof rows / sizeof rows[0] == MODEL_LANES_ROWS, "a row of its own each");
    for (int i = 0; i < MODEL_LANES_ROWS; i++)
        *rows[i] = m->lanes + (size_t)i * ((size_t)m->mats + 2);
    return of;
}

/* kernel_mat and kernel_soil_lb. */
KERNEL_INLINE void kernel_lanes_shape(const struct kernel_lanes *to, const struct model *m,
                                      const double *p, const double *v)
{
    const lanes inverse_length = lanes_all(1.0 / m->length_ft), zero = lanes_all(0.0);
    const lanes kv = lanes_all(m->kv), cv = lanes_all(m->cv), one = lanes_all(1.0);
    const double *p0 = p + 2 * to->first, *v0 = v + 2 * to->first;
    const signed char *contact = m->contact + to->first;
    LANES_EACH(k, 0, to->count)
    {
        lanes p_low = lanes_load(p0 + 2 * k), p_high = lanes_load(p0 + 2 * k + 4);
        lanes v_low = lanes_load(v0 + 2 * k), v_high = lanes_load(v0 + 2 * k + 4);
        lanes y = lanes_even(p_low, p_high), rate = lanes_even(v_low, v_high);
        lanes y_right = lanes_odd(lanes_load(p0 + 2 * k + 1), lanes_load(p0 + 2 * k + 5));
        lanes rate_right = lanes_odd(lanes_load(v0 + 2 * k + 1), lanes_load(v0 + 2 * k + 5));
        lanes s = (y_right - y) * inverse_length + zero; /* 0 of a flat mat is no -0 */
        lanes c = lanes_root(one - s * s);
        lanes touches = kv * y + cv * rate;
        lanes_store(to->s + k, s);
        lanes_store(to->c + k, c);
        lanes_store(to->w + k, (rate_right - rate) * inverse_length / c);
        lanes_store(to->u + k, lanes_odd(p_low, p_high));
        lanes_store(to->v + k, lanes_odd(v_low, v_high));
        lanes_store(to->soil_lb + k,
                    lanes_pick(lanes_wide(lanes_modes(contact + k) != 0), touches, zero));
    }
    to->soil_lb[to->count] = kernel_soil_lb(m, p, v, to->first + to->count);
}

/* Mat k of the window, -1 and count: those beside it. */
KERNEL_INLINE struct kernel_mat kernel_lanes_mat(const struct kernel_lanes *of,
                                                 const struct model *m, int k)
{
    if (k < 0 || k >= of->count)
        return kernel_outside(m, of->first + k);
    return (struct kernel_mat){of->s[k], of->c[k], of->w[k], of->u[k], of->v[k]};
}

/* kernel_tension_lb. */
KERNEL_INLINE void kernel_lanes_tension(const struct kernel_lanes *to, const struct model *m,
                                        bool full, bool slack)
{
    const lanes kl = lanes_all(m->kl), cl = lanes_all(m->cl), zero = lanes_all(0.0);
    const lanes length = lanes_all(m->length_ft), half = lanes_all(m->half_ft);
    const lanes slack_ft = lanes_all(m->slack_ft);
    LANES_EACH(k, 1, to->count)
    {
        lanes gap = lanes_load(to->u + k) - lanes_load(to->u + k - 1);
        lanes rate = lanes_load(to->v + k) - lanes_load(to->v + k - 1);
        if (full) {
            gap += length - half * (lanes_load(to->c + k - 1) + lanes_load(to->c + k));
            rate += half * (lanes_load(to->w + k - 1) * lanes_load(to->s + k - 1) +
                            lanes_load(to->w + k) * lanes_load(to->s + k));
        }
        lanes_int mode = {0};
        if (slack) {
            mode = lanes_modes(m->joint + to->first + k);
            gap = lanes_pick(lanes_wide(mode > 0), gap - slack_ft, gap);
        }
        lanes tension = kl * gap + cl * rate;
        if (slack)
            tension = lanes_pick(lanes_wide(mode == 0), zero, tension);
        lanes_store(to->tension_lb + k, tension);
    }
    for (int k = 0; k <= to->count; k += to->count) {
        struct kernel_mat l = kernel_lanes_mat(to, m, k - 1), r = kernel_lanes_mat(to, m, k);
        to->tension_lb[k] = kernel_tension_lb(m, to->first + k, &l, &r, full, slack);
    }
}

/* kernel_moment where a joint is engaged. Few are, or all. */
static inline void kernel_lanes_moment(const struct kernel_lanes *to, const struct model *m)
{
    const signed char *torsion = m->torsion + to->first;
    memset(to->moment_lb_ft, 0, ((size_t)to->count + 1) * sizeof *to->moment_lb_ft);
    for (int from = 0; from <= to->count; from += 8) {
        uint64_t any; /* beyond the joints other modes follow */
        memcpy(&any, torsion + from, sizeof any);
        for (int k = from; any != 0 && k < from + 8 && k <= to->count; k++) {
            if (!torsion[k])
                continue;
            struct kernel_mat l = kernel_lanes_mat(to, m, k - 1), r = kernel_lanes_mat(to, m, k);
            to->moment_lb_ft[k] = kernel_moment(m, to->first + k, &l, &r);
        }
    }
}

/* kernel_slide_lb, over the mass. */
KERNEL_INLINE void kernel_lanes_slide(const struct kernel_lanes *to, const struct model *m,
                                      double t_s, enum sim_friction law)
{
    const lanes inverse_mass = lanes_all(1.0 / m->mass_slug), zero = lanes_all(0.0);
    const lanes by_weight = lanes_all(m->weight_limit_lb), friction = lanes_all(m->friction);
    LANES_EACH(k, 0, to->count)
    {
        lanes force = lanes_load(to->tension_lb + k + 1) - lanes_load(to->tension_lb + k);
        lanes limit = m->soil_normal
                        ? friction * (lanes_load(to->soil_lb + k) + lanes_load(to->soil_lb + k + 1))
                        : by_weight;
        if (law == SIM_STICK) {
            lanes_int slide = lanes_modes(m->slide + to->first + k);
            force = lanes_pick(lanes_wide(slide == 0), zero, force - lanes_number(slide) * limit);
        } else if (law == SIM_TANH) {
            force = force - limit * lanes_load(m->tanh + to->first + k);
        } else if (law == SIM_SIGN) {
            lanes v = lanes_load(to->v + k);
            force = force - lanes_pick(v == zero, zero, lanes_copysign(limit, v));
        }
        lanes_store(to->slide_ft_s2 + k, force * inverse_mass);
    }
    /* those under the aircraft */
    struct kernel_thrust thrust = kernel_thrust(m, t_s);
    const int mats[] = {m->span.mat, thrust.mat_a, thrust.mat_b};
    for (int i = 0; i < 3; i++) {
        int n = mats[i], k = n - to->first;
        if (k < 0 || k >= to->count)
            continue;
        double push = to->tension_lb[k + 1] - to->tension_lb[k];
        if (n == thrust.mat_a)
            push += thrust.a_lb;
        if (n == thrust.mat_b)
            push += thrust.b_lb;
        to->slide_ft_s2[k] = kernel_slide_lb(m, n, to->v[k], push, to->soil_lb[k],
                                             to->soil_lb[k + 1], law) *
                             (1.0 / m->mass_slug);
    }
}

/* What mats and joints of both models do. */
KERNEL_INLINE void kernel_lanes_common(const struct kernel_lanes *to, const struct model *m,
                                       double t_s, const double *z, const struct kernel_parts parts)
{
    kernel_prepare(m, z + m->size, parts.law);
    kernel_lanes_shape(to, m, z, z + m->size);
    kernel_lanes_tension(to, m, parts.full, parts.slack);
    kernel_lanes_moment(to, m);
    kernel_lanes_slide(to, m, t_s, parts.law);
}

/* Whether lanes do what the model needs now. */
static inline bool kernel_lanes_take(const struct model *m)
{
    return m->last - m->first + 1 >= KERNEL_LANES_LEAST && m->held < 0 &&
           m->scene->gap0_ft.count == 0;
}

#endif
