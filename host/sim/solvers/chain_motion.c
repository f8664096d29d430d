#include "host/sim/solvers/chain_motion.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/elementary.h"
#include "host/base/xmalloc.h"
#include "host/sim/elements/element.h"
#include "host/sim/elements/gear.h"
#include "host/sim/elements/law.h"

#define ARRAY_PADDING         8
#define ARRAY_ALIGNMENT       64
/* Largest product of step and fastest rate, divided by the order. With it the terms of the series
 * decrease. */
#define SERIES_STEP_MAX       0.4
#define TANH_SATURATION_SPEED 20.0 /* speed / veps above which tanh is 1 within rounding */
#define COULOMB_SPEED_MIN     25.0 /* speed / veps above which a mat slides by Coulomb's law */
/* Largest product of step and rate of tanh while the argument of tanh is near 0. */
#define TANH_STEP_MAX         0.3
#define EDGE_TOLERANCE        1e-12 /* in mats; README.md: a wheel at x = n L is on mat n + 1 */
#define ROUNDING_SHARE        (16.0 * DBL_EPSILON)
#define SLIDE_ON_GROUND       3 /* value of slide for a mat on elastic ground */

#if defined __x86_64__ && defined __GNUC__ && !defined __clang__
#define VECTORISE_LOOP _Pragma("GCC ivdep")
#else
#define VECTORISE_LOOP
#endif

/* ---- a step's series ---- */

LAW_INLINE void expand_tensions(const struct motion *m, int k, int first, int count)
{
    const double *u = m->u_terms[k] + first, *v = m->u_terms[k + 1] + first;
    const double *a = m->tension_a + first, *b = m->tension_b + first;
    double *pull = m->tension_terms[k] + first, factor = k + 1.0;
    VECTORISE_LOOP
    for (int j = 0; j < count; j++)
        pull[j] = a[j] * (u[j] - u[j - 1]) + b[j] * (factor * (v[j] - v[j - 1]));
    for (int j = 0; k == 0 && j < count; j++)
        pull[j] += a[j] * m->gap0_ft[first + j] + m->tension_c_lb[first + j];
}

/* Computes the series of y = tanh w, with w = speed / veps, from y' = (1 - y^2) w'. */
static void expand_tanh_friction(const struct motion *m, int k, int first, int last)
{
    double per = 1.0 / m->scene->veps_ft_s;
    for (int n = first; n <= last; n++) {
        double sum = 0.0;
        m->tanh_terms[k][n] = 0.0;
        if (m->slide_direction[n] != 2)
            continue;
        if (k == 0) {
            m->tanh_terms[0][n] = elementary_tanh(m->u_terms[1][n] * per);
            m->tanh_square_terms[0][n] = 1.0 - m->tanh_terms[0][n] * m->tanh_terms[0][n];
            continue;
        }
        for (int i = 0; i < k; i++) /* the coefficients of w are w_(i+1) = (i + 2) c_(i+2) / veps */
            sum += (i + 1) * (i + 2) * m->u_terms[i + 2][n] * per *
                   m->tanh_square_terms[k - 1 - i][n];
        m->tanh_terms[k][n] = sum / k;
        sum = 0.0;
        for (int i = 0; i <= k; i++)
            sum += m->tanh_terms[i][n] * m->tanh_terms[k - i][n];
        m->tanh_square_terms[k][n] = -sum;
    }
}

TARGET_CLONES void motion_expand_series(const struct motion *m, int first, int last, int order)
{
    int count = last - first + 1;
    /* Set the mats beyond the range to rest: their older coefficients may remain from an earlier
     * motion. */
    for (int k = 1; k <= order; k++)
        m->u_terms[k][first - 1] = m->u_terms[k][last + 1] = 0.0;
    for (int k = 0; k < order; k++) {
        expand_tensions(m, k, first, count + 1);
        if (k + 2 > order)
            break;
        const double *pull = m->tension_terms[k] + first, *v = m->u_terms[k + 1] + first;
        const double *per_slug = m->moving_inverse_mass + first,
                     *rub = m->friction_force_lb + first;
        const double *drag = m->drag_lb_s_ft + first;
        double *next = m->u_terms[k + 2] + first, factor = k + 1.0;
        double share = 1.0 / ((k + 1.0) * (k + 2.0));
        VECTORISE_LOOP
        for (int n = 0; n < count; n++)
            next[n] = pull[n + 1] - pull[n] - drag[n] * (factor * v[n]);
        for (int n = 0; k < 3 && n < count; n++)
            next[n] += m->thrust_terms[k][first + n] - (k == 0 ? rub[n] : 0.0);
        for (int i = 0; m->has_gear && k > 0 && i < m->load_count; i++) {
            const struct mat_load *part = &m->loads[i];
            m->u_terms[k + 2][part->mat] -=
                part->slope_lb_ft * m->u_terms[k][part->mat] +
                (k == 1 && part->mode == GROUND_YIELDING
                     ? part->force_sign * m->load_friction_lb * part->load_share[1]
                     : 0.0);
        }
        if (m->friction_law == SIM_FRICTION_TANH) {
            expand_tanh_friction(m, k, first, last);
            for (int n = 0; n < count; n++)
                next[n] -= m->limit_lb[first + n] * m->tanh_terms[k][first + n];
        }
        VECTORISE_LOOP
        for (int n = 0; n < count; n++)
            next[n] *= per_slug[n] * share;
    }
}

TARGET_CLONES double motion_largest_value(const double *values, int first, int last)
{
    double most = 0.0;
    for (int n = first; n <= last; n++)
        most = law_max(most, fabs(values[n]));
    return most;
}

/* Longest step for which the last two terms, which are omitted, are within the tolerance, relative
 * to the larger of the largest speed so far and the speed that the step adds. The terms must also
 * decrease. */
double motion_longest_step_s(const struct motion *m, int first, int last, int order,
                             double tolerance)
{
    double h = (double)INFINITY, v = m->max_speed_ft_s,
           bent = 2.0 * motion_largest_value(m->u_terms[2], first, last);
    double twisted = 3.0 * motion_largest_value(m->u_terms[3], first, last);
    bool springs = m->ground_damping_lb_s_ft > 0.0 || m->has_gear;
    for (int n = first; m->friction_law == SIM_FRICTION_TANH && n <= last; n++) {
        /* the series of tanh converges only if the speed changes by less than veps */
        double veps = m->scene->veps_ft_s, a = fabs(2.0 * m->u_terms[2][n]),
               jerk = fabs(6.0 * m->u_terms[3][n]);
        if (m->slide_direction[n] == 2)
            h = law_min(h, law_min(TANH_STEP_MAX / (m->tanh_rate + a / veps),
                                   sqrt(TANH_STEP_MAX * veps / jerk)));
    }
    for (int j = first; !springs && j <= last + 1; j++)
        springs = m->tension_a[j] != 0.0 &&
                  (m->moving_inverse_mass[j] != 0.0 || m->moving_inverse_mass[j - 1] != 0.0);
    for (int k = order - 1; k <= order; k++) {
        double term = k * motion_largest_value(m->u_terms[k], first, last) / tolerance;
        if (term > 0.0)
            h = law_min(h, law_max(elementary_pow(v / term, 1.0 / (k - 1)),
                                   law_max(elementary_pow(bent / term, 1.0 / (k - 2)),
                                           elementary_pow(twisted / term, 1.0 / (k - 3)))));
    }
    return springs ? law_min(h, SERIES_STEP_MAX * order / m->max_rate) : h;
}

TARGET_CLONES void motion_evaluate(const struct motion *m, int first, int last, int order, double h,
                                   double *u, double *v)
{
    int count = last - first + 1;
    double *sum = m->sum + first, *slope = m->slope + first;
    memcpy(sum, m->u_terms[order] + first, (size_t)count * sizeof *sum);
    memset(slope, 0, (size_t)count * sizeof *slope);
    for (int k = order; k-- > 0;) {
        const double *c = m->u_terms[k] + first;
        VECTORISE_LOOP
        for (int n = 0; n < count; n++) {
            slope[n] = slope[n] * h + sum[n];
            sum[n] = sum[n] * h + c[n];
        }
    }
    memcpy(u + first, sum, (size_t)count * sizeof *sum);
    if (v)
        memcpy(v + first, slope, (size_t)count * sizeof *slope);
}

/* ---- switches ---- */

TARGET_CLONES static void set_change_bounds(const struct motion *m, int first, int last, int order,
                                            double h)
{
    double *rv = m->speed_change_max + first, *rg = m->opening_change_max + first,
           *rt = m->tension_change_max + first;
    int count = last - first + 1;
    double power = 1.0;
    memset(rv - 1, 0, ((size_t)count + 2) * sizeof *rv);
    memset(rg, 0, ((size_t)count + 1) * sizeof *rg);
    memset(rt, 0, ((size_t)count + 1) * sizeof *rt);
    for (int k = 1; k <= order; k++) {
        const double *u = m->u_terms[k] + first,
                     *pull = m->tension_terms[k < order ? k : 0] + first;
        double slope = k * power;
        power *= h;
        if (k >= 2) {
            VECTORISE_LOOP
            for (int n = 0; n < count; n++)
                rv[n] += fabs(u[n]) * slope;
        }
        VECTORISE_LOOP
        for (int j = 0; j <= count; j++)
            rg[j] += fabs(u[j] - u[j - 1]) * power;
        if (k < order) {
            VECTORISE_LOOP
            for (int j = 0; j <= count; j++)
                rt[j] += fabs(pull[j]) * power;
        }
    }
}

double motion_opening_ft(const struct motion *m, int j)
{
    return m->gap0_ft[j] + (m->u_terms[0][j] - m->u_terms[0][j - 1]);
}

static double opening_rounding_ft(const struct motion *m, int j)
{
    return ROUNDING_SHARE * (fabs(m->u_terms[0][j]) + fabs(m->u_terms[0][j - 1]) +
                             fabs(m->gap0_ft[j]) + m->slack_ft);
}

static double speed_rounding_ft_s(const struct motion *m)
{
    return ROUNDING_SHARE * m->max_speed_ft_s;
}

static double tension_rounding_lb(const struct motion *m, int j)
{
    if (m->joint_mode[j] == JOINT_ABSENT || m->joint_mode[j] == JOINT_OPEN ||
        m->joint_mode[j] == JOINT_GRIT_OPENING)
        return 0.0;
    return m->kl_lb_ft * opening_rounding_ft(m, j) + m->cl_lb_s_ft * speed_rounding_ft_s(m) +
           ROUNDING_SHARE * m->grit_lb[j];
}

static double tension_lb(const struct motion *m, int j)
{
    return m->tension_a[j] * motion_opening_ft(m, j) +
           m->tension_b[j] * (m->u_terms[1][j] - m->u_terms[1][j - 1]) + m->tension_c_lb[j];
}

static double push_lb(const struct motion *m, int n)
{
    return tension_lb(m, n + 1) - tension_lb(m, n) + m->thrust_terms[0][n];
}

static double push_rounding_lb(const struct motion *m, int n)
{
    return tension_rounding_lb(m, n) + tension_rounding_lb(m, n + 1) +
           ROUNDING_SHARE * (m->limit_lb[n] + fabs(m->thrust_terms[0][n]));
}

static void compute_opening_series(const struct motion *m, int j, int order, double *g)
{
    g[0] = motion_opening_ft(m, j);
    for (int k = 1; k <= order; k++)
        g[k] = m->u_terms[k][j] - m->u_terms[k][j - 1];
}

static void replace_if_earlier(struct event *event, double h, int mat, int joint, int which)
{
    if (h < event->h_s || (h == event->h_s && event->mat + event->joint == 0))
        *event = (struct event){h, mat, joint, which};
}

double motion_ground_limit_lb(const struct motion *m, const struct mat_load *part)
{
    return m->weight_friction_lb +
           m->load_friction_lb *
               (part->load_share[0] + part->load_share[1] * (m->t_s - m->last_break_s));
}

/* Finds the next event of elastic ground. `which` 0: the speed of the mat reverses; 1: the force
 * reaches its limit or leaves it; 2: the load falls to 0. */
static void find_ground_event(const struct motion *m, const struct mat_load *part, int order,
                              struct event *event)
{
    double s[POLYNOMIAL_DEGREE_MAX + 1], v[POLYNOMIAL_DEGREE_MAX + 1],
        limit_lb = motion_ground_limit_lb(m, part);
    double limit_rate = m->load_friction_lb * part->load_share[1],
           noise_lb = ROUNDING_SHARE * limit_lb;
    int n = part->mat;
    if (part->mode == GROUND_FRICTIONLESS)
        return;
    v[order] = 0.0;
    for (int k = 0; k < order; k++)
        v[k] = part->force_sign * (k + 1) * m->u_terms[k + 1][n];
    if (part->mode == GROUND_YIELDING) {
        double rate = part->k_lb_ft / (limit_rate < 0.0 ? m->recovered_share : 1.0);
        for (int k = 0; k < order; k++)
            s[k] = rate * v[k];
        s[0] -= limit_rate;
        replace_if_earlier(
            event,
            polynomial_first_negative_s(s, order - 1, event->h_s, rate * speed_rounding_ft_s(m)), n,
            0, 1);
        return;
    }
    for (int which = 0; which < 3; which++) {
        if (which == 2 && part->mode == GROUND_LOADING)
            continue;
        s[0] = part->force_sign * part->ground_force_lb;
        for (int k = 1; k <= order; k++)
            s[k] = part->force_sign * part->slope_lb_ft * m->u_terms[k][n];
        for (int k = 0; which < 2 && k <= order; k++)
            s[k] = which == 0 ? (part->mode == GROUND_LOADING ? v[k] : -v[k]) : -s[k];
        if (which == 1) {
            s[0] += limit_lb;
            s[1] += limit_rate;
        }
        replace_if_earlier(
            event,
            polynomial_first_negative_s(s, order, event->h_s,
                                        which == 0 ? speed_rounding_ft_s(m) : noise_lb),
            n, 0, which);
    }
}

static void find_mat_event(const struct motion *m, int n, int order, struct event *event)
{
    double s[POLYNOMIAL_DEGREE_MAX + 1], way = m->slide_direction[n];
    if (m->slide_direction[n] == SLIDE_ON_GROUND)
        return; /* on elastic ground, find_ground_event handles the mat */
    if (m->slide_direction[n] == 2) {
        double far_ft_s = m->friction_law == SIM_FRICTION_TANH
                            ? COULOMB_SPEED_MIN * m->scene->veps_ft_s
                            : DBL_MAX;
        if (far_ft_s - fabs(m->u_terms[1][n]) >= m->speed_change_max[n])
            return;
        for (way = -1.0; way <= 1.0; way += 2.0) {
            for (int k = 0; k < order; k++)
                s[k] = -way * (k + 1) * m->u_terms[k + 1][n];
            s[0] += far_ft_s;
            replace_if_earlier(
                event,
                polynomial_first_negative_s(s, order - 1, event->h_s, speed_rounding_ft_s(m)), n, 0,
                0);
        }
        return;
    }
    if (m->slide_direction[n]) {
        double near_ft_s = m->friction_law == SIM_FRICTION_TANH
                             ? TANH_SATURATION_SPEED * m->scene->veps_ft_s
                             : 0.0;
        if (way * m->u_terms[1][n] - near_ft_s >= m->speed_change_max[n])
            return;
        for (int k = 0; k < order; k++)
            s[k] = way * (k + 1) * m->u_terms[k + 1][n];
        s[0] -= near_ft_s;
        replace_if_earlier(
            event, polynomial_first_negative_s(s, order - 1, event->h_s, speed_rounding_ft_s(m)), n,
            0, 0);
        return;
    }
    double h = event->h_s,
           x = m->tension_terms[0][n + 1] - m->tension_terms[0][n] + m->thrust_terms[0][n];
    double most = m->tension_change_max[n + 1] + m->tension_change_max[n] +
                  h * (fabs(m->thrust_terms[1][n]) + h * fabs(m->thrust_terms[2][n]));
    if (m->limit_lb[n] - fabs(x) > most || m->limit_lb[n] == (double)INFINITY)
        return;
    for (way = -1.0; way <= 1.0; way += 2.0) {
        for (int k = 0; k < order; k++)
            s[k] = -way * (m->tension_terms[k][n + 1] - m->tension_terms[k][n] +
                           (k < 3 ? m->thrust_terms[k][n] : 0.0));
        s[0] += m->limit_lb[n];
        replace_if_earlier(
            event, polynomial_first_negative_s(s, order - 1, event->h_s, push_rounding_lb(m, n)), n,
            0, 0);
    }
}

/* Computes the conditions that end the mode of a joint. Each condition `which` (0, 1, 2) is a
 * series; the mode ends when it falls below 0. Returns false if there is no such condition. */
static bool find_joint_mode_end(const struct motion *m, int j, int which, const double *g,
                                int order, double *s, double *noise)
{
    enum { LIMITS_OPENING, LIMITS_SPEED, LIMITS_FORCE } of = LIMITS_OPENING;
    double way = 1.0, at = 0.0;
    bool first = which == 0;
    switch (m->joint_mode[j]) {
    case JOINT_OPEN:
        way = first ? 1.0 : -1.0;
        at = first ? 0.0 : m->slack_ft;
        break;
    case JOINT_PRESSED: way = -1.0; break;
    case JOINT_HOOKED: at = m->slack_ft; break;
    case JOINT_GRIT_OPENING:
        of = first ? LIMITS_SPEED : LIMITS_OPENING;
        way = first ? 1.0 : -1.0;
        at = m->slack_ft;
        break;
    case JOINT_GRIT_HOLDS:
        of = first ? LIMITS_OPENING : LIMITS_FORCE;
        way = which == 2 ? 1.0 : -1.0;
        at = first ? m->grit_extent_ft[j] : which == 1 ? 0.0 : -m->grit_lb[j];
        break;
    case JOINT_GRIT_FORCELESS:
        of = first ? LIMITS_OPENING : LIMITS_FORCE;
        way = first ? -1.0 : 1.0;
        at = first ? m->grit_extent_ft[j] : 0.0;
        break;
    case JOINT_GRIT_AT_LIMIT:
        of = first ? LIMITS_OPENING : LIMITS_FORCE;
        way = first ? 1.0 : -1.0;
        at = first ? m->grit_extent_ft[j] - m->grit_lb[j] / m->kl_lb_ft : -m->grit_lb[j];
        break;
    case JOINT_GRIT_YIELDS:
        of = first ? LIMITS_OPENING : LIMITS_SPEED;
        way = first ? 1.0 : -1.0;
        at = first ? -m->grit_lb[j] / m->kl_lb_ft : 0.0;
        break;
    default: return false;
    }
    static const int ends_of[] = {
        [JOINT_OPEN] = 2,          [JOINT_PRESSED] = 1,     [JOINT_HOOKED] = 1,
        [JOINT_GRIT_OPENING] = 2,  [JOINT_GRIT_HOLDS] = 3,  [JOINT_GRIT_FORCELESS] = 2,
        [JOINT_GRIT_AT_LIMIT] = 2, [JOINT_GRIT_YIELDS] = 2,
    };
    if (which >= ends_of[m->joint_mode[j]])
        return false;
    switch (of) {
    case LIMITS_OPENING:
        for (int k = 0; k <= order; k++)
            s[k] = way * g[k];
        s[0] -= way * at;
        *noise = opening_rounding_ft(m, j);
        break;
    case LIMITS_SPEED:
        for (int k = 0; k < order; k++)
            s[k] = way * (k + 1) * g[k + 1];
        s[order] = 0.0;
        *noise = speed_rounding_ft_s(m);
        break;
    case LIMITS_FORCE:
        for (int k = 0; k < order; k++)
            s[k] = way * (m->kl_lb_ft * g[k] + m->cl_lb_s_ft * (k + 1) * g[k + 1]);
        s[0] -= way * (m->kl_lb_ft * m->grit_extent_ft[j] + at);
        s[order] = 0.0;
        *noise = tension_rounding_lb(m, j);
        break;
    }
    return true;
}

static void find_joint_event(const struct motion *m, int j, int order, struct event *event)
{
    double g[POLYNOMIAL_DEGREE_MAX + 1], s[POLYNOMIAL_DEGREE_MAX + 1], noise,
        g_ft = motion_opening_ft(m, j);
    double way = m->opening_change_max[j];
    switch (m->joint_mode
                /* skip the joint early if its mode cannot end in this step, as for most joints */
                [j]) {
    case JOINT_ABSENT:
    case JOINT_ELASTIC: return;
    case JOINT_OPEN:
        if (g_ft > way && m->slack_ft - g_ft > way)
            return;
        break;
    case JOINT_PRESSED:
        if (-g_ft > way)
            return;
        break;
    case JOINT_HOOKED:
        if (g_ft - m->slack_ft > way)
            return;
        break;
    case JOINT_GRIT_HOLDS: {
        double t = m->tension_terms[0][j];
        if (m->grit_extent_ft[j] - g_ft > way && -t > m->tension_change_max[j] &&
            t + m->grit_lb[j] > m->tension_change_max[j])
            return;
        break;
    }
    case JOINT_GRIT_OPENING:
    case JOINT_GRIT_YIELDS: {
        bool yields = m->joint_mode[j] == JOINT_GRIT_YIELDS;
        double v = m->u_terms[1][j] - m->u_terms[1][j - 1],
               change = m->speed_change_max[j] + m->speed_change_max[j - 1];
        double room = yields ? g_ft + m->grit_lb[j] / m->kl_lb_ft : m->slack_ft - g_ft;
        v = yields ? -v : v;
        if (room > way && v >= change && (v > 0.0 || change == 0.0))
            return;
        break;
    }
    default: break;
    }
    compute_opening_series(m, j, order, g);
    for (int which = 0; find_joint_mode_end(m, j, which, g, order, s, &noise); which++)
        replace_if_earlier(event, polynomial_first_negative_s(s, order, event->h_s, noise), 0, j,
                           which);
}

static void set_joint_mode(struct motion *m, int j, enum joint_mode mode)
{
    bool spring = mode == JOINT_ELASTIC || mode == JOINT_PRESSED || mode == JOINT_HOOKED ||
                  mode == JOINT_GRIT_HOLDS;
    m->joint_mode[j] = (unsigned char)mode;
    m->tension_a[j] = spring ? m->kl_lb_ft : 0.0;
    m->tension_b[j] = spring ? m->cl_lb_s_ft : 0.0;
    m->tension_c_lb[j] = mode == JOINT_HOOKED     ? -m->kl_lb_ft * m->slack_ft
                       : mode == JOINT_GRIT_HOLDS ? -m->kl_lb_ft * m->grit_extent_ft[j]
                       : mode == JOINT_GRIT_AT_LIMIT || mode == JOINT_GRIT_YIELDS ? -m->grit_lb[j]
                                                                                  : 0.0;
}

static void switch_joint(struct motion *m, int j, int which)
{
    bool dirty = m->grit_lb[j] > 0.0;
    double g_ft = motion_opening_ft(m, j);
    switch (m->joint_mode[j]) {
    case JOINT_OPEN: set_joint_mode(m, j, which == 0 ? JOINT_PRESSED : JOINT_HOOKED); break;
    case JOINT_PRESSED: set_joint_mode(m, j, dirty ? JOINT_GRIT_OPENING : JOINT_OPEN); break;
    case JOINT_HOOKED:
        m->grit_extent_ft[j] = m->slack_ft;
        set_joint_mode(m, j, dirty ? JOINT_GRIT_HOLDS : JOINT_OPEN);
        break;
    case JOINT_GRIT_OPENING:
        if (which == 0)
            m->grit_extent_ft[j] = g_ft;
        set_joint_mode(m, j,
                       which == 1   ? JOINT_HOOKED
                       : g_ft > 0.0 ? JOINT_GRIT_HOLDS
                                    : JOINT_PRESSED);
        break;
    case JOINT_GRIT_HOLDS:
        set_joint_mode(m, j,
                       which == 0            ? JOINT_GRIT_OPENING
                       : which == 1          ? JOINT_GRIT_FORCELESS
                       : m->cl_lb_s_ft > 0.0 ? JOINT_GRIT_AT_LIMIT
                                             : JOINT_GRIT_YIELDS);
        break;
    case JOINT_GRIT_FORCELESS:
        set_joint_mode(m, j, which == 0 ? JOINT_GRIT_OPENING : JOINT_GRIT_HOLDS);
        break;
    case JOINT_GRIT_AT_LIMIT:
        set_joint_mode(m, j, which == 0 ? JOINT_GRIT_YIELDS : JOINT_GRIT_HOLDS);
        break;
    case JOINT_GRIT_YIELDS:
        m->grit_extent_ft[j] = which == 0 ? 0.0 : g_ft + m->grit_lb[j] / m->kl_lb_ft;
        set_joint_mode(m, j, which == 0 ? JOINT_PRESSED : JOINT_GRIT_HOLDS);
        break;
    default: break;
    }
}

static void set_slide(struct motion *m, int n, int way)
{
    m->slide_direction[n] = (signed char)way;
    m->drag_lb_s_ft[n] = m->ground_damping_lb_s_ft;
    m->moving_inverse_mass[n] = way ? m->inverse_mass : 0.0;
    m->friction_force_lb[n] = way == 1 || way == -1 ? way * m->limit_lb[n] : 0.0;
    if (way && n < m->moving_low)
        m->moving_low = n;
    if (way && n > m->moving_high)
        m->moving_high = n;
}

static void shrink_moving_range(struct motion *m)
{
    while (m->moving_low <= m->moving_high && m->slide_direction[m->moving_low] == 0)
        m->moving_low++;
    while (m->moving_low <= m->moving_high && m->slide_direction[m->moving_high] == 0)
        m->moving_high--;
    if (m->moving_low > m->moving_high) {
        m->moving_low = m->mats + 1;
        m->moving_high = 0;
    }
}

static void set_ground_mode(struct motion *m, struct mat_load *part, enum ground_mode mode)
{
    double limit_lb = motion_ground_limit_lb(m, part);
    part->mode = mode;
    part->slope_lb_ft = mode == GROUND_LOADING   ? part->k_lb_ft
                      : mode == GROUND_UNLOADING ? part->k_lb_ft / m->recovered_share
                                                 : 0.0;
    if (mode == GROUND_YIELDING)
        part->ground_force_lb = part->force_sign * limit_lb;
    set_slide(m, part->mat, SLIDE_ON_GROUND);
    m->drag_lb_s_ft[part->mat] += 2.0 * m->scene->gear.damping *
                                  sqrt(part->k_lb_ft / m->inverse_mass);
    m->friction_force_lb[part->mat] = part->ground_force_lb;
}

static void switch_ground(struct motion *m, struct mat_load *part, int which)
{
    if (part->mode == GROUND_YIELDING)
        set_ground_mode(m, part, part->load_share[1] > 0.0 ? GROUND_LOADING : GROUND_UNLOADING);
    else if (which == 0)
        set_ground_mode(m, part, part->mode == GROUND_LOADING ? GROUND_UNLOADING : GROUND_LOADING);
    else if (which == 1)
        set_ground_mode(m, part, GROUND_YIELDING);
    else {
        part->force_sign = -part->force_sign;
        set_ground_mode(m, part, GROUND_LOADING);
    }
}

static void switch_mat(struct motion *m, int n, int which)
{
    for (int i = 0; m->slide_direction[n] == SLIDE_ON_GROUND && i < m->load_count; i++) {
        if (m->loads[i].mat == n) {
            switch_ground(m, &m->loads[i], which);
            return;
        }
    }
    bool rests = m->slide_direction[n] == 0;
    if (m->friction_law == SIM_FRICTION_TANH) {
        set_slide(m, n, m->slide_direction[n] != 2 ? 2 : m->u_terms[1][n] > 0.0 ? 1 : -1);
        return;
    }
    m->u_terms[1][n] = 0.0;
    double x = push_lb(m, n);
    bool held = !rests && fabs(x) <= m->limit_lb[n] + push_rounding_lb(m, n);
    set_slide(m, n, held ? 0 : x > 0.0 ? 1 : -1);
    shrink_moving_range(m);
}

/* ---- the wheel ---- */

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static size_t axle_line_count(const struct motion *m)
{
    return m->has_gear && m->scene->gear.line_setbacks_ft.count > 0
             ? m->scene->gear.line_setbacks_ft.count
             : 1;
}

static double line_setback_ft(const struct motion *m, size_t line)
{
    const struct sim_list *lines = &m->scene->gear.line_setbacks_ft;
    return m->has_gear && lines->count > 0 ? lines->values[line] : 0.0;
}

static double line_axles(const struct motion *m, size_t line)
{
    const struct sim_list *axles = &m->scene->gear.axle_counts;
    return m->has_gear && axles->count > 0 ? axles->values[line] : 1.0;
}

static void add_break_time(struct motion *m, double t_s)
{
    if (!(t_s > 0.0 && t_s < sim_scene_end_s(m->scene)))
        return;
    xlist_grow(&m->break_times_s, m->break_count, sizeof *m->break_times_s);
    m->break_times_s[m->break_count++] = t_s;
}

/* Adds break times: when a point `ahead_ft` ahead of the path's position crosses from one mat to
 * the next. */
static void add_mat_crossings(struct motion *m, const struct sim_path_row *row, double ahead_ft)
{
    double length_ft = m->scene->length_ft, x0_ft = row[0].x_ft + ahead_ft;
    double x1_ft = row[1].x_ft + ahead_ft, stopping_distance_ft = x1_ft - x0_ft;
    double low = ceil(fmin(x0_ft, x1_ft) / length_ft), high = floor(fmax(x0_ft, x1_ft) / length_ft);
    for (double i = fmax(low, 0.0); i <= fmin(high, m->mats); i++)
        add_break_time(m, row[0].t_s + (row[1].t_s - row[0].t_s) *
                                           ((i * length_ft - x0_ft) / stopping_distance_ft));
}

static void make_break_times(struct motion *m)
{
    const struct sim_scene *scene = m->scene;
    double half_ft = m->has_gear ? 0.5 * scene->gear.axle_length_ft : 0.0;
    for (size_t i = 0; i < m->wheel.row_count; i++) {
        const struct sim_path_row *row = m->wheel.rows + i;
        add_break_time(m, row->t_s);
        if (i + 1 == m->wheel.row_count || row[1].x_ft == row->x_ft || !(row[1].t_s > row->t_s))
            continue;
        for (size_t line = 0; line < axle_line_count(m); line++) {
            double ahead_ft = -line_setback_ft(m, line);
            add_mat_crossings(m, row, ahead_ft);
            if (scene->thrust == SIM_THRUST_LINEAR)
                add_mat_crossings(m, row, ahead_ft + 0.5 * scene->length_ft);
            if (half_ft > 0.0) {
                add_mat_crossings(m, row, ahead_ft - half_ft);
                add_mat_crossings(m, row, ahead_ft + half_ft);
            }
        }
    }
    add_break_time(m, scene->force_stop_s);
    qsort(m->break_times_s, m->break_count, sizeof *m->break_times_s, compare_doubles);
    xlist_grow(&m->break_times_s, m->break_count, sizeof *m->break_times_s);
    m->break_times_s[m->break_count++] = sim_scene_end_s(scene);
}

static struct mat_load *get_or_add_load(struct motion *m, int mat)
{
    int i = 0;
    while (i < m->load_count && m->loads[i].mat != mat)
        i++;
    if (i == m->load_count)
        m->loads[m->load_count++] = (struct mat_load){.mat = mat};
    return &m->loads[i];
}

/* Adds the load of `axles` axles on a mat: the fraction `share` of the thrust and load of each.
 * `rate` is the rate of change of `share`. */
static void add_axle_load(struct motion *m, int mat, double share, double rate, double axles,
                          const double force[2], bool thrust, bool load)
{
    if (mat < 1 || mat > m->mats || m->load_count == SIM_TOUCH_MAX)
        return;
    struct mat_load *part = get_or_add_load(m, mat);
    if (thrust) {
        part->thrust_lb[0] += axles * share * force[0];
        part->thrust_lb[1] += axles * (share * force[1] + rate * force[0]);
        part->thrust_lb[2] += axles * rate * force[1];
    }
    if (load) {
        part->load_share[0] += axles * share;
        part->load_share[1] += axles * rate;
        part->axle_count += axles;
    }
}

/* Adds the loads of one axle line. The line is at x_ft in the middle of the interval, half_s after
 * its start. */
static void add_axles(struct motion *m, double x_ft, double speed_ft_s, double half_s, double axles,
                      const double force[2])
{
    const struct sim_scene *scene = m->scene;
    double length_ft = scene->length_ft, foot_ft = m->has_gear ? scene->gear.axle_length_ft : 0.0;
    double at_ft = x_ft - speed_ft_s * half_s, mat = floor(x_ft / length_ft + EDGE_TOLERANCE) + 1.0;
    bool jump = scene->thrust == SIM_THRUST_JUMP;
    if (!(mat >= 1.0 && mat <= m->mats))
        return;
    if (foot_ft > 0.0) {
        double back_ft = -0.5 * foot_ft, front_ft = 0.5 * foot_ft;
        int first = (int)fmax(1.0, floor((x_ft + back_ft) / length_ft) + 1.0);
        for (int n = first; n <= m->mats && (n - 1) * length_ft < x_ft + front_ft; n++) {
            bool begins = x_ft + back_ft > (n - 1) * length_ft,
                 ends = x_ft + front_ft < n * length_ft;
            double from_ft = begins ? at_ft + back_ft : (n - 1) * length_ft;
            double to_ft = ends ? at_ft + front_ft : n * length_ft;
            add_axle_load(m, n, (to_ft - from_ft) / foot_ft,
                          ((ends - begins) * speed_ft_s) / foot_ft, axles, force, true, true);
        }
        return;
    }
    add_axle_load(m, (int)mat, 1.0, 0.0, axles, force, jump, true);
    if (jump)
        return;
    double w = x_ft / length_ft - 0.5, i = floor(w), rate = speed_ft_s / length_ft;
    double right = at_ft / length_ft - 0.5 - i;
    if (i < 0.0) {
        add_axle_load(m, 1, 1.0, 0.0, axles, force, true, false);
    } else {
        add_axle_load(m, (int)i + 1, 1.0 - right, -rate, axles, force, true, false);
        add_axle_load(m, (int)i + 2, right, rate, axles, force, true, false);
    }
}

static void mark_mat_changed(struct motion *m, int n)
{
    m->changed_low = n < m->changed_low ? n : m->changed_low;
    m->changed_high = n > m->changed_high ? n : m->changed_high;
}

/* Continues or restarts the elastic ground under a loaded mat. `before`: its state so far; NULL:
 * newly loaded. */
static void restart_ground(struct motion *m, struct mat_load *part, const struct mat_load *before)
{
    double v = m->u_terms[1][part->mat];
    part->k_lb_ft = gear_stiffness_lb_ft(m->scene, part->axle_count);
    part->ground_force_lb = before ? before->ground_force_lb : 0.0;
    if (before && part->axle_count < before->axle_count)
        part->ground_force_lb *= part->k_lb_ft / before->k_lb_ft;
    if (m->friction_law == SIM_FRICTION_NONE) {
        part->ground_force_lb = 0.0;
        set_ground_mode(m, part, GROUND_FRICTIONLESS);
        return;
    }
    double limit_lb = motion_ground_limit_lb(m, part);
    part->ground_force_lb = fmax(-limit_lb, fmin(limit_lb, part->ground_force_lb));
    part->force_sign = part->ground_force_lb > 0.0            ? 1
                     : part->ground_force_lb < 0.0 || v < 0.0 ? -1
                                                              : 1;
    set_ground_mode(m, part, v * part->force_sign < 0.0 ? GROUND_UNLOADING : GROUND_LOADING);
}

static void remove_wheel_forces(struct motion *m, int n)
{
    double v = m->u_terms[1][n];
    bool slides = m->friction_law == SIM_FRICTION_STICK ||
                  (m->friction_law == SIM_FRICTION_TANH &&
                   fabs(v) > COULOMB_SPEED_MIN * m->scene->veps_ft_s);
    m->limit_lb[n] = m->weight_friction_lb;
    int left = slides ? (v > 0.0) - (v < 0.0) : 2;
    set_slide(m, n, m->slide_direction[n] == SLIDE_ON_GROUND ? left : m->slide_direction[n]);
}

/* Sets the forces of the wheel from the present time to the next break. */
void motion_set_wheel_action(struct motion *m)
{
    const struct sim_path_row *rows = m->wheel.rows, *last = rows + m->wheel.row_count - 1;
    double until_s = m->break_times_s[m->next_break], half_s = 0.5 * (until_s - m->t_s);
    double middle_s = m->t_s + half_s, force[2] = {0.0, 0.0}, x_ft = last->x_ft, speed_ft_s = 0.0;
    struct mat_load before[SIM_TOUCH_MAX];
    int count = m->load_count;
    bool there = middle_s >= rows->t_s;
    memcpy(before, m->loads, sizeof before);
    m->load_count = 0;
    m->last_break_s = m->t_s;
    for (const struct sim_path_row *row = rows; row < last; row++) {
        double long_s = row[1].t_s - row->t_s;
        if (!(middle_s >= row->t_s && middle_s < row[1].t_s))
            continue;
        speed_ft_s = (row[1].x_ft - row->x_ft) / long_s;
        x_ft = row->x_ft + speed_ft_s * (middle_s - row->t_s);
        force[1] = middle_s < m->scene->force_stop_s ? (row[1].force_lb - row->force_lb) / long_s
                                                     : 0.0;
        force[0] = middle_s < m->scene->force_stop_s
                     ? row->force_lb +
                           (row[1].force_lb - row->force_lb) * ((m->t_s - row->t_s) / long_s)
                     : 0.0;
    }
    for (size_t i = 0; there && i < axle_line_count(m); i++)
        add_axles(m, x_ft - line_setback_ft(m, i), speed_ft_s, half_s, line_axles(m, i), force);
    for (int i = 0; i < count; i++) {
        int n = before[i].mat;
        mark_mat_changed(m, n);
        m->thrust_terms[0][n] = m->thrust_terms[1][n] = m->thrust_terms[2][n] = 0.0;
        remove_wheel_forces(m, n);
    }
    for (int i = 0; i < m->load_count; i++) {
        struct mat_load *part = &m->loads[i];
        const struct mat_load *was = NULL;
        for (int k = 0; k < count; k++)
            was = before[k].mat == part->mat && before[k].axle_count > 0.0 ? &before[k] : was;
        mark_mat_changed(m, part->mat);
        m->limit_lb[part->mat] = m->weight_friction_lb + m->load_friction_lb * part->load_share[0];
        if (m->has_gear && part->axle_count > 0.0)
            restart_ground(m, part, was);
        else
            set_slide(m, part->mat, m->slide_direction[part->mat]);
    }
    shrink_moving_range(m);
}

/* Sets the thrust of the wheel from the present time on. */
void motion_set_wheel_thrust(struct motion *m)
{
    double dt = m->t_s - m->last_break_s;
    for (int i = 0; i < m->load_count; i++) {
        const struct mat_load *part = &m->loads[i];
        const double *f = part->thrust_lb;
        m->thrust_terms[0][part->mat] = f[0] + dt * (f[1] + dt * f[2]);
        m->thrust_terms[1][part->mat] = f[1] + 2.0 * dt * f[2];
        m->thrust_terms[2][part->mat] = f[2];
        mark_mat_changed(m, part->mat);
    }
}

/* ---- interface ---- */

struct event motion_first_event(struct motion *m, int first, int last, int order, double wide_s)
{
    struct event event = {wide_s, 0, 0, 0};
    set_change_bounds(m, first, last, order, wide_s);
    for (int i = 0; m->has_gear && i < m->load_count; i++) {
        if (m->loads[i].axle_count > 0.0)
            find_ground_event(m, &m->loads[i], order, &event);
    }
    for (int n = first; n <= last; n++)
        find_mat_event(m, n, order, &event);
    for (int j = first; j <= last + 1; j++)
        find_joint_event(m, j, order, &event);
    return event;
}

void motion_apply_switch(struct motion *m, const struct event *event)
{
    if (event->mat)
        switch_mat(m, event->mat, event->condition);
    else if (event->joint)
        switch_joint(m, event->joint, event->condition);
}

void motion_make(struct motion *m, const struct sim_scene *scene)
{
    size_t length = ((size_t)scene->mats + 2 + ARRAY_PADDING - 1) / ARRAY_PADDING * ARRAY_PADDING +
                    2 * ARRAY_PADDING;
    bool tanh_law = scene->friction_law == SIM_FRICTION_TANH && scene->friction > 0.0;
    size_t arrays = (POLYNOMIAL_DEGREE_MAX + 1) + POLYNOMIAL_DEGREE_MAX + 21 +
                    (tanh_law ? 2 * POLYNOMIAL_DEGREE_MAX : 0);
    *m = (struct motion){.scene = scene,
                         .mats = scene->mats,
                         .inverse_mass = scene->g_ft_s2 / scene->weight_lb,
                         .kl_lb_ft = scene->kl_lb_ft,
                         .cl_lb_s_ft = scene->cl_lb_s_ft,
                         .slack_ft = scene->slack_ft,
                         .ground_damping_lb_s_ft = scene->element_values[ELEMENT_ground_damping],
                         .weight_friction_lb = scene->friction * scene->weight_lb,
                         .load_friction_lb = scene->friction * scene->wheel_load_lb,
                         .friction_law = !(scene->friction > 0.0) ||
                                                 scene->friction_law == SIM_FRICTION_NONE
                                           ? SIM_FRICTION_NONE
                                       : tanh_law ? SIM_FRICTION_TANH
                                                  : SIM_FRICTION_STICK,
                         .has_gear = scene->element_values[ELEMENT_gear_ground] > 0.0,
                         .recovered_share = scene->gear.recovered_share,
                         .array_length = length};
    double w = 4.0 * m->kl_lb_ft * m->inverse_mass, d = 4.0 * m->cl_lb_s_ft * m->inverse_mass;
    double axles = 0.0;
    for (size_t i = 0; i < axle_line_count(m); i++)
        axles += line_axles(m, i);
    double ground = m->has_gear ? gear_stiffness_lb_ft(scene, axles) * m->inverse_mass : 0.0;
    m->max_rate = d + sqrt(w + ground / law_min(1.0, m->recovered_share)) +
                  m->ground_damping_lb_s_ft * m->inverse_mass +
                  2.0 * scene->gear.damping * sqrt(ground);
    m->tanh_rate = (m->weight_friction_lb + m->load_friction_lb) * m->inverse_mass /
                   scene->veps_ft_s;
    sim_wheel_start(&m->wheel, scene);
    make_break_times(m);
    m->storage = xaligned_alloc(ARRAY_ALIGNMENT, arrays * length * sizeof(double) + 2 * length);
    double *next = (double *)m->storage + ARRAY_PADDING;
    double **const places[] = {&m->thrust_terms[0],
                               &m->thrust_terms[1],
                               &m->thrust_terms[2],
                               &m->moving_inverse_mass,
                               &m->limit_lb,
                               &m->friction_force_lb,
                               &m->drag_lb_s_ft,
                               &m->speed_change_max,
                               &m->tension_a,
                               &m->tension_b,
                               &m->tension_c_lb,
                               &m->gap0_ft,
                               &m->grit_lb,
                               &m->grit_extent_ft,
                               &m->max_compression_lb,
                               &m->max_tension_lb,
                               &m->opening_change_max,
                               &m->tension_change_max,
                               &m->sampled_u_ft,
                               &m->sum,
                               &m->slope};
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++, next += length)
        *places[i] = next;
    for (int k = 0; k <= POLYNOMIAL_DEGREE_MAX; k++, next += length)
        m->u_terms[k] = next;
    for (int k = 0; k < POLYNOMIAL_DEGREE_MAX; k++, next += length)
        m->tension_terms[k] = next;
    for (int k = 0; tanh_law && k < POLYNOMIAL_DEGREE_MAX; k++, next += 2 * length) {
        m->tanh_terms[k] = next;
        m->tanh_square_terms[k] = next + length;
    }
    m->slide_direction = (signed char *)((double *)m->storage + arrays * length) + ARRAY_PADDING;
    m->joint_mode = (unsigned char *)m->slide_direction + length;
}

void motion_free(struct motion *m)
{
    free(m->break_times_s);
    free(m->storage);
}

void motion_start(struct motion *m)
{
    const struct sim_scene *scene = m->scene;
    size_t doubles =
        (size_t)((double *)(void *)(m->slide_direction - ARRAY_PADDING) - (double *)m->storage);
    memset(m->storage, 0, doubles * sizeof(double) + 2 * m->array_length);
    m->next_break = 0;
    m->load_count = 0;
    m->t_s = m->max_speed_ft_s = 0.0;
    m->moving_low = m->mats + 1;
    m->moving_high = 0;
    m->changed_low = m->mats + 1;
    m->changed_high = 0;
    for (int j = 0; j < m->mats + 2; j++)
        set_joint_mode(m, j, JOINT_ABSENT);
    for (int j = 1; j <= m->mats + 1; j++) {
        double g_ft = m->gap0_ft[j] = sim_scene_joint_value(&scene->gap0_ft, j);
        bool end = (j == 1 && scene->left_end == SIM_END_FREE) ||
                   (j == m->mats + 1 && scene->right_end == SIM_END_FREE);
        m->grit_lb[j] = m->slack_ft > 0.0 ? sim_scene_joint_value(&scene->grit_lb, j) : 0.0;
        m->grit_extent_ft[j] = joint_initial_grit_extent_ft(g_ft, m->slack_ft);
        set_joint_mode(m, j,
                       end                   ? JOINT_ABSENT
                       : m->slack_ft <= 0.0  ? JOINT_ELASTIC
                       : g_ft < 0.0          ? JOINT_PRESSED
                       : g_ft > m->slack_ft  ? JOINT_HOOKED
                       : m->grit_lb[j] > 0.0 ? JOINT_GRIT_OPENING
                                             : JOINT_OPEN);
    }
    for (int n = 1; n <= m->mats; n++) {
        m->limit_lb[n] = m->weight_friction_lb;
        set_slide(m, n, m->friction_law == SIM_FRICTION_STICK ? 0 : 2);
    }
    m->limit_lb[0] = m->limit_lb[m->mats + 1] = (double)INFINITY;
    int thrown = scene->v0_mat > 0 ? scene->v0_mat : sim_wheel_first_mat(&m->wheel);
    m->u_terms[1][thrown] = scene->v0_ft_s;
    if (m->friction_law != SIM_FRICTION_NONE && scene->v0_ft_s != 0.0 &&
        (m->friction_law == SIM_FRICTION_STICK ||
         fabs(scene->v0_ft_s) > COULOMB_SPEED_MIN * scene->veps_ft_s))
        set_slide(m, thrown, scene->v0_ft_s > 0.0 ? 1 : -1);
    m->max_speed_ft_s = fabs(scene->v0_ft_s);
    motion_set_wheel_action(m);
}
