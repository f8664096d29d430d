/* The chain's reference in one precision. Whoever includes this has defined `real`, RUN (what
 * chain_reference_run is called in it) and ROUNDING, its last place. Not included twice. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#include "host/sim/elements/element.h" /* places of keys in the scene */
#include "tests/stability/chain_reference.h"

#define MATS  (CHAIN_REFERENCE_MATS + 2)
#define TERMS (CHAIN_REFERENCE_ORDER + 1)

/* Margins by which a switch comes late, so that no rounding undoes it. */
#define LATE_FT     (5.0 * ROUNDING)
#define LATE_FT_S   (500.0 * ROUNDING)
#define LATE_SHARE  (500.0 * ROUNDING) /* of a limit */
#define EDGE        1e-12              /* a wheel at x = n L is on mat n + 1 */
#define HALVINGS    60
#define AT_ONCE_MAX 4000

enum joint_mode {
    LOOSE,   /* a free end */
    LINEAR,  /* slack 0 */
    PRESSED, /* closed; with grit: reach 0 */
    OPEN,
    HOOKED,
    /* with grit */
    FOLLOWS, /* opening, reach goes along */
    HELD,    /* below reach: spring and damper, between -grit and 0 */
    HELD_FULL,
    HELD_NONE,
    YIELDS /* transmits grit, reach is compacted */
};

enum mat_mode {
    STUCK,
    SLIDES,
    SMOOTH, /* tanh */
    BARE,   /* no friction */
    /* under the gear on elastic ground; side: sign of q */
    LOADS,
    UNLOADS,
    GIVES, /* |q| at its limit */
    RIDES  /* without friction: q = 0 */
};

struct state {
    const struct sim_scene *scene;
    struct chain_reference *run;
    int mats, order;
    real mass, kl, cl, slack, c, veps, base_limit;
    real tolerance_ft;
    bool gear;
    real gear_k, rho, zeta, axle_law;
    enum mat_mode plain; /* of a sliding mat, by friction law */
    real gap0[MATS], grit[MATS], reach[MATS];
    enum joint_mode joint[MATS];
    enum mat_mode mat[MATS];
    int side[MATS];
    real q[MATS];
    /* by the span: polynomials in time from its begin */
    real thrust[3][MATS], limit[2][MATS], touching[MATS];
    /* series of the step: u, tension, force without the ground's; tanh, its argument and slope */
    real u[TERMS][MATS], tension[TERMS][MATS], force[TERMS][MATS], smooth[TERMS][MATS],
        argument[TERMS][MATS], slope[TERMS][MATS];
    real limit_now[MATS], limit_rate[MATS];
    int first, last;  /* mats that can move or be moved */
    bool look_at_all; /* in the next step: forces or limits have changed somewhere */
    real largest_ft;
};

/* ---- the wheel ---- */

struct times {
    real *at;
    size_t count, room;
};

static void times_add(struct times *times, real t_s, real end_s)
{
    if (!(t_s > 0.0 && t_s < end_s))
        return;
    if (times->count == times->room) {
        times->room = 2 * times->room + 64;
        times->at = realloc(times->at, times->room * sizeof *times->at);
        if (!times->at)
            abort();
    }
    times->at[times->count++] = t_s;
}

static int by_value(const void *a, const void *b)
{
    const real *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* Where the aircraft is and how it pushes at a time inside a span. */
struct aircraft {
    bool there;
    real x_ft, speed_ft_s, force_lb, force_rate;
};

static struct aircraft aircraft_at(const struct sim_scene *scene, real t_s)
{
    struct aircraft a = {.there = true};
    size_t count = scene->path_count;
    if (count == 0) {
        a.x_ft = scene->start_ft + scene->vac_ft_s * t_s;
        a.speed_ft_s = scene->vac_ft_s;
        a.force_lb = scene->force_lb;
    } else {
        const struct sim_path_row *row = scene->path;
        size_t i = 0;
        a.there = t_s >= row[0].t_s;
        while (i + 1 < count && row[i + 1].t_s <= t_s)
            i++;
        a.x_ft = row[i].x_ft;
        if (i + 1 < count && a.there) {
            real long_s = row[i + 1].t_s - row[i].t_s;
            a.speed_ft_s = (row[i + 1].x_ft - row[i].x_ft) / long_s;
            a.force_rate = (row[i + 1].force_lb - row[i].force_lb) / long_s;
            a.x_ft += a.speed_ft_s * (t_s - row[i].t_s);
            a.force_lb = row[i].force_lb + a.force_rate * (t_s - row[i].t_s);
        }
    }
    if (t_s >= scene->force_stop_s)
        a.force_lb = a.force_rate = 0.0;
    return a;
}

static size_t line_count(const struct state *s)
{
    return s->gear && s->scene->gear.line_setbacks_ft.count > 0
             ? s->scene->gear.line_setbacks_ft.count
             : 1;
}

static real line_behind_ft(const struct state *s, size_t i)
{
    return s->gear && s->scene->gear.line_setbacks_ft.count > 0
             ? s->scene->gear.line_setbacks_ft.values[i]
             : 0.0;
}

static real line_axles(const struct state *s, size_t i)
{
    return s->gear && s->scene->gear.axle_counts.count > 0 ? s->scene->gear.axle_counts.values[i]
                                                           : 1.0;
}

static real foot_ft(const struct state *s)
{
    return s->gear ? s->scene->gear.axle_length_ft : 0.0;
}

/* Times within t0..t1 (one speed) at which a point `ahead` of the lead axle crosses k L + shift. */
static void add_hops(struct times *times, const struct state *s, real t0_s, real t1_s, real x0_ft,
                     real speed_ft_s, real ahead_ft, real end_s)
{
    for (int k = 0; speed_ft_s != 0.0 && k <= s->mats; k++) {
        real t_s = t0_s + (k * s->scene->length_ft - ahead_ft - x0_ft) / speed_ft_s;
        if (t_s > t0_s && t_s < t1_s)
            times_add(times, t_s, end_s);
    }
}

static struct times breaks_of(const struct state *s, real end_s)
{
    const struct sim_scene *scene = s->scene;
    struct times times = {0};
    size_t rows = scene->path_count > 0 ? scene->path_count : 2;
    times_add(&times, scene->force_stop_s, end_s);
    for (size_t r = 0; r + 1 < rows; r++) {
        real t0_s = 0.0, t1_s = end_s;
        if (scene->path_count > 0) {
            t0_s = scene->path[r].t_s;
            t1_s = scene->path[r + 1].t_s;
            times_add(&times, t0_s, end_s);
            times_add(&times, t1_s, end_s);
        }
        if (!(t1_s > t0_s))
            continue;
        real speed_ft_s = scene->vac_ft_s, x0_ft = scene->start_ft;
        if (scene->path_count > 0) {
            x0_ft = scene->path[r].x_ft;
            speed_ft_s = (scene->path[r + 1].x_ft - x0_ft) / (t1_s - t0_s);
        }
        for (size_t i = 0; i < line_count(s); i++) {
            real ahead_ft = -line_behind_ft(s, i), half_ft = 0.5 * foot_ft(s);
            add_hops(&times, s, t0_s, t1_s, x0_ft, speed_ft_s, ahead_ft, end_s);
            if (scene->thrust == SIM_THRUST_LINEAR)
                add_hops(&times, s, t0_s, t1_s, x0_ft, speed_ft_s,
                         ahead_ft + 0.5 * scene->length_ft, end_s);
            if (half_ft > 0.0) {
                add_hops(&times, s, t0_s, t1_s, x0_ft, speed_ft_s, ahead_ft + half_ft, end_s);
                add_hops(&times, s, t0_s, t1_s, x0_ft, speed_ft_s, ahead_ft - half_ft, end_s);
            }
        }
    }
    qsort(times.at, times.count, sizeof *times.at, by_value);
    return times;
}

/* part[0] + part[1] t of the force goes to this mat. */
static void add_thrust(struct state *s, int n, const real part[2], const struct aircraft *a,
                       real axles)
{
    if (n < 1 || n > s->mats)
        return;
    s->thrust[0][n] += axles * part[0] * a->force_lb;
    s->thrust[1][n] += axles * (part[0] * a->force_rate + part[1] * a->force_lb);
    s->thrust[2][n] += axles * part[1] * a->force_rate;
}

static void add_load(struct state *s, int n, const real part[2], real axles)
{
    if (n < 1 || n > s->mats)
        return;
    real hold_lb = s->scene->friction * s->scene->wheel_load_lb * axles;
    s->limit[0][n] += hold_lb * part[0];
    s->limit[1][n] += hold_lb * part[1];
    s->touching[n] += axles;
}

static real gear_stiffness(const struct state *s, real touching)
{
    return touching > 0.0 ? s->gear_k * pow(touching, s->axle_law) : 0.0;
}

/* The wheel's parts in a span. */
static void press(struct state *s, real t0_s, real t1_s)
{
    const struct sim_scene *scene = s->scene;
    real length_ft = scene->length_ft, half_s = 0.5 * (t1_s - t0_s);
    struct aircraft a = aircraft_at(scene, t0_s + half_s);
    memset(s->thrust, 0, sizeof s->thrust);
    memset(s->limit, 0, sizeof s->limit);
    memset(s->touching, 0, sizeof s->touching);
    for (int n = 1; n <= s->mats; n++)
        s->limit[0][n] = s->base_limit;
    if (!a.there)
        return;
    a.force_lb -= a.force_rate * half_s; /* from the span's begin on */
    for (size_t i = 0; i < line_count(s); i++) {
        real axles = line_axles(s, i), middle_ft = a.x_ft - line_behind_ft(s, i);
        real begin_ft = middle_ft - a.speed_ft_s * half_s;
        int under = (int)floor(middle_ft / length_ft + EDGE) + 1;
        if (under < 1 || under > s->mats)
            continue;
        if (foot_ft(s) > 0.0) {
            real foot = foot_ft(s);
            for (int n = 1; n <= s->mats; n++) {
                real left_ft = (n - 1) * length_ft, right_ft = n * length_ft;
                bool back = middle_ft - 0.5 * foot >= left_ft, /* its end is on this mat */
                    front = middle_ft + 0.5 * foot <= right_ft;
                if (middle_ft + 0.5 * foot <= left_ft || middle_ft - 0.5 * foot >= right_ft)
                    continue;
                real part[2] = {((front ? begin_ft + 0.5 * foot : right_ft) -
                                 (back ? begin_ft - 0.5 * foot : left_ft)) /
                                    foot,
                                (front - back) * a.speed_ft_s / foot};
                add_thrust(s, n, part, &a, axles);
                add_load(s, n, part, axles);
            }
            continue;
        }
        static const real all[2] = {1.0, 0.0};
        add_load(s, under, all, axles);
        if (scene->thrust == SIM_THRUST_JUMP) {
            add_thrust(s, under, all, &a, axles);
            continue;
        }
        real w = middle_ft / length_ft - 0.5, cell = floor(w);
        real right[2] = {begin_ft / length_ft - 0.5 - cell, a.speed_ft_s / length_ft};
        real left[2] = {1.0 - right[0], -right[1]};
        if (cell < 0.0) {
            add_thrust(s, 1, all, &a, axles);
        } else {
            add_thrust(s, (int)cell + 1, left, &a, axles);
            add_thrust(s, (int)cell + 2, right, &a, axles);
        }
    }
}

/* Mats that an axle reaches, and those that the last one leaves. */
static void change_ground(struct state *s, const real *touched)
{
    for (int n = 1; s->gear && n <= s->mats; n++) {
        real v = s->u[1][n];
        if (s->touching[n] < touched[n])
            s->q[n] *= gear_stiffness(s, s->touching[n]) / gear_stiffness(s, touched[n]);
        if (s->touching[n] > 0.0) {
            real limit = s->limit[0][n];
            if (s->plain == BARE) {
                s->mat[n] = RIDES;
                continue;
            }
            s->q[n] = fmax(-limit, fmin(limit, s->q[n]));
            s->side[n] = s->q[n] > 0.0 ? 1 : s->q[n] < 0.0 ? -1 : v < 0.0 ? -1 : 1;
            s->mat[n] = v * s->side[n] < 0.0 ? UNLOADS : LOADS;
        } else if (touched[n] > 0.0) {
            s->q[n] = 0.0;
            s->mat[n] = s->plain;
            if (s->plain == SLIDES && fabs(v) <= LATE_FT_S) {
                s->u[1][n] = 0.0;
                s->mat[n] = STUCK;
            } else {
                s->side[n] = v < 0.0 ? -1 : 1;
            }
        }
    }
}

/* ---- the series of a step ---- */

static real opening(const struct state *s, int j, int k)
{
    return s->u[k][j] - s->u[k][j - 1] + (k == 0 ? s->gap0[j] : 0.0);
}

/* Term k of the spring and damper of a joint that pulls nothing at `rest`. */
static real spring(const struct state *s, int j, int k, real rest_ft)
{
    real g = opening(s, j, k) - (k == 0 ? rest_ft : 0.0);
    return s->kl * g + s->cl * (k + 1) * opening(s, j, k + 1);
}

static real tension_term(const struct state *s, int j, int k)
{
    switch (s->joint[j]) {
    case LINEAR:
    case PRESSED: return spring(s, j, k, 0.0);
    case HOOKED: return spring(s, j, k, s->slack);
    case HELD: return spring(s, j, k, s->reach[j]);
    case HELD_FULL:
    case YIELDS: return k == 0 ? -s->grit[j] : 0.0;
    case LOOSE:
    case OPEN:
    case FOLLOWS:
    case HELD_NONE: break;
    }
    return 0.0;
}

/* q' = rate u' */
static real ground_rate(const struct state *s, int n)
{
    real k = gear_stiffness(s, s->touching[n]);
    return s->mat[n] == LOADS ? k : s->mat[n] == UNLOADS ? k / s->rho : 0.0;
}

/* Term k of w = tanh(y): w' = z y' with z = 1 - w^2. */
static real smooth_term(struct state *s, int n, int k)
{
    real sum = 0.0, z = 0.0;
    s->argument[k][n] = (k + 1) * s->u[k + 1][n] / s->veps;
    for (int i = 0; i < k; i++)
        sum += s->slope[i][n] * (k - i) * s->argument[k - i][n];
    s->smooth[k][n] = k == 0 ? tanh(s->argument[0][n]) : sum / k;
    for (int i = 0; i <= k; i++)
        z -= s->smooth[i][n] * s->smooth[k - i][n];
    s->slope[k][n] = k == 0 ? pow(cosh(s->argument[0][n]), -2.0) : z;
    return s->smooth[k][n];
}

/* Term k of what the ground holds a mat with. */
static real hold_term(struct state *s, int n, int k)
{
    real damping = s->c;
    real held = 0.0;
    switch (s->mat[n]) {
    case STUCK:
    case BARE: break;
    case SLIDES: held = k == 0 ? s->side[n] * s->limit_now[n] : 0.0; break;
    case SMOOTH: held = s->limit_now[n] * smooth_term(s, n, k); break;
    case LOADS:
    case UNLOADS: held = k == 0 ? s->q[n] : ground_rate(s, n) * s->u[k][n]; break;
    case GIVES:
        held = s->side[n] * (k == 0 ? s->limit_now[n] : k == 1 ? s->limit_rate[n] : 0.0);
        break;
    case RIDES: break;
    }
    if (s->mat[n] >= LOADS)
        damping += 2.0 * s->zeta * sqrt(gear_stiffness(s, s->touching[n]) * s->mass);
    return held + damping * (k + 1) * s->u[k + 1][n];
}

static void find_moving(struct state *s)
{
    s->first = s->mats + 1;
    s->last = 0;
    for (int n = 1; n <= s->mats; n++) {
        bool idle = s->mat[n] == STUCK && s->thrust[0][n] == 0.0 && s->thrust[1][n] == 0.0 &&
                    s->thrust[2][n] == 0.0;
        if (idle && !s->look_at_all)
            continue;
        s->first = n < s->first ? n : s->first;
        s->last = n;
    }
    s->first = s->first > 1 ? s->first - 1 : 1;
    s->last = s->last < s->mats ? s->last + 1 : s->mats;
    s->look_at_all = false;
}

/* Series from `at_s` of the span on; u[0] and u[1] are the state. */
static void expand(struct state *s, real at_s)
{
    for (int k = 1; k <= s->order; k++) /* those beside them rest */
        s->u[k][s->first - 1] = s->u[k][s->last + 1] = 0.0;
    for (int n = s->first; n <= s->last; n++) {
        s->limit_now[n] = s->limit[0][n] + s->limit[1][n] * at_s;
        s->limit_rate[n] = s->limit[1][n];
    }
    for (int k = 0; k + 2 <= s->order; k++) {
        for (int j = s->first; j <= s->last + 1; j++)
            s->tension[k][j] = tension_term(s, j, k);
        for (int n = s->first; n <= s->last; n++) {
            real x = s->tension[k][n + 1] - s->tension[k][n];
            if (k == 0)
                x += s->thrust[0][n] + at_s * (s->thrust[1][n] + at_s * s->thrust[2][n]);
            else if (k == 1)
                x += s->thrust[1][n] + 2.0 * at_s * s->thrust[2][n];
            else if (k == 2)
                x += s->thrust[2][n];
            s->force[k][n] = x;
            s->u[k + 2][n] = s->mat[n] == STUCK
                               ? 0.0
                               : (x - hold_term(s, n, k)) / (s->mass * (k + 1) * (k + 2));
        }
    }
}

/* How far the series is good. */
static real reach_s(const struct state *s, real most_s)
{
    real h = most_s;
    for (int k = s->order - 1; k <= s->order; k++) {
        real largest = 0.0;
        for (int n = s->first; n <= s->last; n++)
            largest = fmax(largest, fabs(s->u[k][n]));
        if (largest > 0.0)
            h = fmin(h, pow(s->tolerance_ft / largest, 1.0 / k));
    }
    /* the series of a tanh that has come to 1 says nothing of where it turns */
    for (int n = s->first; n <= s->last; n++) {
        real change;
        do {
            real power = 1.0;
            change = 0.0;
            for (int k = 1; s->mat[n] == SMOOTH && k + 2 <= s->order; k++)
                change += fabs(s->argument[k][n]) * (power *= h);
        } while (change > 0.5 * fmax(1.0, fabs(s->argument[0][n]) - 20.0) && (h *= 0.7) > 0.0);
    }
    return h;
}

/* ---- where a polynomial falls below 0 ---- */

/* First t of 0..1 at which the polynomial with these Bernstein coefficients is below 0; 2: none. */
static real first_below(const real *b, int degree, int depth)
{
    real left[TERMS], right[TERMS];
    bool below = false;
    for (int i = 0; i <= degree; i++)
        below = below || b[i] < 0.0;
    if (!below)
        return 2.0;
    if (b[0] < 0.0)
        return 0.0;
    if (depth == 0)
        return b[degree] < 0.0 ? 1.0 : 2.0;
    memcpy(right, b, sizeof(real) * (size_t)(degree + 1));
    for (int r = 0; r <= degree; r++) { /* de Casteljau at the middle */
        left[r] = right[0];
        for (int i = 0; i < degree - r; i++)
            right[i] = 0.5 * (right[i] + right[i + 1]);
    }
    real t = first_below(left, degree, depth - 1);
    if (t <= 1.0)
        return 0.5 * t;
    t = first_below(right, degree, depth - 1);
    return t <= 1.0 ? 0.5 + 0.5 * t : 2.0;
}

/* The same for p (terms in time) within 0..h_s; INFINITY: nowhere. */
static real falls_below(const real *p, int degree, real h_s)
{
    static real share[TERMS][TERMS][TERMS]; /* C(i,k)/C(degree,k) */
    real least = p[0], scaled[TERMS], power = h_s, b[TERMS];
    for (int k = 1; k <= degree; k++, power *= h_s)
        least -= fabs(p[k]) * power;
    if (least >= 0.0)
        return (real)INFINITY;
    if (p[0] < 0.0)
        return 0.0;
    while (degree > 1 && p[degree] == 0.0)
        degree--;
    if (share[degree][0][0] == 0.0)
        for (int i = 0; i <= degree; i++) {
            real quotient = 1.0;
            for (int k = 0; k <= i; k++) {
                share[degree][i][k] = quotient;
                quotient *= (real)(i - k) / (real)(degree - k);
            }
        }
    power = 1.0;
    for (int k = 0; k <= degree; k++, power *= h_s)
        scaled[k] = p[k] * power;
    for (int i = 0; i <= degree; i++) {
        b[i] = 0.0;
        for (int k = 0; k <= i; k++)
            b[i] += share[degree][i][k] * scaled[k];
    }
    real t = first_below(b, degree, HALVINGS);
    return t <= 1.0 ? t * h_s : (real)INFINITY;
}

/* ---- switches ---- */

struct event {
    real at_s;
    bool joint;
    int index, to;
};

struct search {
    const struct state *s;
    real h_s;
    struct event first;
};

static void consider(struct search *search, const real *p, int degree, real late, bool joint,
                     int index, int to)
{
    real margin[TERMS];
    memcpy(margin, p, sizeof(real) * (size_t)(degree + 1));
    margin[0] += late;
    real at_s = falls_below(margin, degree, search->h_s);
    if (at_s < search->first.at_s || (at_s <= search->h_s && search->first.at_s > search->h_s)) {
        search->first = (struct event){at_s, joint, index, to};
        search->h_s = at_s;
    }
}

/* p = sign (q - at) */
static void signed_copy(real *p, const real *q, int degree, real sign, real at)
{
    for (int k = 0; k <= degree; k++)
        p[k] = sign * (q[k] - (k == 0 ? at : 0.0));
}

static void search_joint(struct search *search, int j)
{
    const struct state *s = search->s;
    real g[TERMS], rate[TERMS], raw[TERMS], p[TERMS];
    int degree = s->order;
    real late = LATE_FT * fmax(1.0, s->largest_ft);
    enum joint_mode mode = s->joint[j];
    bool grit = s->grit[j] > 0.0;
    if (mode == LOOSE || mode == LINEAR)
        return;
    for (int k = 0; k <= degree; k++)
        g[k] = opening(s, j, k);
    for (int k = 0; k < degree; k++)
        rate[k] = (k + 1) * g[k + 1];
    switch (mode) {
    case LOOSE:
    case LINEAR: return;
    case PRESSED:
        signed_copy(p, g, degree, -1.0, 0.0);
        consider(search, p, degree, late, true, j, grit ? FOLLOWS : OPEN);
        return;
    case OPEN:
        consider(search, g, degree, late, true, j, PRESSED);
        signed_copy(p, g, degree, -1.0, s->slack);
        consider(search, p, degree, late, true, j, HOOKED);
        return;
    case HOOKED:
        signed_copy(p, g, degree, 1.0, s->slack);
        consider(search, p, degree, late, true, j, grit ? HELD : OPEN);
        return;
    case FOLLOWS:
        consider(search, rate, degree - 1, LATE_FT_S, true, j, HELD);
        signed_copy(p, g, degree, -1.0, s->slack);
        consider(search, p, degree, late, true, j, HOOKED);
        return;
    case YIELDS:
        signed_copy(p, rate, degree - 1, -1.0, 0.0);
        consider(search, p, degree - 1, LATE_FT_S, true, j, HELD);
        signed_copy(p, g, degree, 1.0, -s->grit[j] / s->kl);
        consider(search, p, degree, late, true, j, PRESSED);
        return;
    case HELD:
    case HELD_FULL:
    case HELD_NONE: break;
    }
    signed_copy(p, g, degree, -1.0, s->reach[j]);
    consider(search, p, degree, late, true, j, FOLLOWS);
    signed_copy(p, g, degree, 1.0, s->reach[j] - s->grit[j] / s->kl);
    consider(search, p, degree, late, true, j, YIELDS);
    if (s->cl <= 0.0)
        return;
    for (int k = 0; k < degree; k++)
        raw[k] = spring(s, j, k, s->reach[j]);
    real late_lb = s->kl * late + LATE_SHARE * s->grit[j];
    signed_copy(p, raw, degree - 1, mode == HELD_NONE ? 1.0 : -1.0, 0.0);
    if (mode != HELD_FULL)
        consider(search, p, degree - 1, late_lb, true, j, mode == HELD ? HELD_NONE : HELD);
    signed_copy(p, raw, degree - 1, mode == HELD_FULL ? -1.0 : 1.0, -s->grit[j]);
    if (mode != HELD_NONE)
        consider(search, p, degree - 1, late_lb, true, j, mode == HELD ? HELD_FULL : HELD);
}

/* Targets of a mat's event. */
enum { TO_STUCK, TO_SLIDE_UP, TO_SLIDE_DOWN, TO_LOADS, TO_OTHER_WAY, TO_UNLOADS, TO_GIVES };

static void search_mat(struct search *search, int n)
{
    const struct state *s = search->s;
    real p[TERMS], speed[TERMS];
    int degree = s->order - 1, side = s->side[n];
    real late_lb = LATE_SHARE * s->limit_now[n] + s->kl * LATE_FT * s->largest_ft;
    enum mat_mode mode = s->mat[n];
    if (mode == SMOOTH || mode == BARE || mode == RIDES)
        return;
    if (mode == STUCK) {
        for (int way = 1; way >= -1; way -= 2) {
            for (int k = 0; k < degree; k++)
                p[k] = -way * s->force[k][n];
            p[0] += s->limit_now[n];
            consider(search, p, degree - 1, late_lb, false, n,
                     way > 0 ? TO_SLIDE_UP : TO_SLIDE_DOWN);
        }
        return;
    }
    for (int k = 0; k <= degree; k++)
        speed[k] = side * (k + 1) * s->u[k + 1][n];
    if (mode == SLIDES) {
        consider(search, speed, degree, LATE_FT_S, false, n, TO_STUCK);
        return;
    }
    real stiff = gear_stiffness(s, s->touching[n]), limit_rate = s->limit_rate[n];
    if (mode == GIVES) {
        real rate = limit_rate >= 0.0 ? stiff : stiff / s->rho;
        for (int k = 0; k <= degree; k++)
            p[k] = rate * speed[k] - (k == 0 ? limit_rate : 0.0);
        consider(search, p, degree, rate * LATE_FT_S, false, n,
                 limit_rate > 0.0 ? TO_LOADS : TO_UNLOADS);
        return;
    }
    signed_copy(p, speed, degree, mode == LOADS ? 1.0 : -1.0, 0.0);
    consider(search, p, degree, LATE_FT_S, false, n, mode == LOADS ? TO_UNLOADS : TO_LOADS);
    p[0] = side * s->q[n];
    for (int k = 1; k <= degree; k++)
        p[k] = side * ground_rate(s, n) * s->u[k][n];
    if (mode == UNLOADS)
        consider(search, p, degree, LATE_SHARE * s->limit_now[n], false, n, TO_OTHER_WAY);
    signed_copy(p, p, degree, -1.0, s->limit_now[n]);
    p[1] += limit_rate;
    consider(search, p, degree, LATE_SHARE * s->limit_now[n], false, n, TO_GIVES);
}

static struct event first_event(const struct state *s, real h_s)
{
    struct search search = {s, h_s, {.at_s = (real)INFINITY}};
    for (int j = s->first; j <= s->last + 1; j++)
        search_joint(&search, j);
    for (int n = s->first; n <= s->last; n++)
        search_mat(&search, n);
    return search.first;
}

static void switch_joint(struct state *s, int j, enum joint_mode to)
{
    real g = opening(s, j, 0);
    if (to == HELD && s->joint[j] == HOOKED)
        s->reach[j] = s->slack;
    if (to == HELD && s->joint[j] == FOLLOWS)
        s->reach[j] = fmin(g, s->slack);
    if (to == HELD && s->joint[j] == YIELDS)
        s->reach[j] = g + s->grit[j] / s->kl;
    if (to == PRESSED)
        s->reach[j] = 0.0;
    s->joint[j] = to;
}

static void switch_mat(struct state *s, int n, int to, real limit)
{
    switch (to) {
    case TO_STUCK:
        s->mat[n] = STUCK;
        s->u[1][n] = 0.0;
        s->look_at_all = true;
        break;
    case TO_SLIDE_UP:
    case TO_SLIDE_DOWN:
        s->mat[n] = SLIDES;
        s->side[n] = to == TO_SLIDE_UP ? 1 : -1;
        break;
    case TO_OTHER_WAY:
        s->mat[n] = LOADS;
        s->side[n] = -s->side[n];
        break;
    case TO_LOADS: s->mat[n] = LOADS; break;
    case TO_UNLOADS: s->mat[n] = UNLOADS; break;
    case TO_GIVES:
        s->mat[n] = GIVES;
        s->q[n] = s->side[n] * limit;
        break;
    }
}

/* ---- the run ---- */

static bool understood(const struct sim_scene *scene)
{
    return scene->model == SIM_MODEL_CHAIN && scene->mats <= CHAIN_REFERENCE_MATS &&
           !mods_are_present(scene) && scene->friction_law != SIM_FRICTION_SIGN;
}

static void begin(struct state *s)
{
    const struct sim_scene *scene = s->scene;
    bool rubs = scene->friction > 0.0 && scene->friction_law != SIM_FRICTION_NONE;
    s->mats = scene->mats;
    s->mass = scene->weight_lb / scene->g_ft_s2;
    s->kl = scene->kl_lb_ft;
    s->cl = scene->cl_lb_s_ft;
    s->slack = scene->slack_ft;
    s->veps = scene->veps_ft_s;
    s->base_limit = scene->friction * scene->weight_lb;
    s->c = scene->element_values[ELEMENT_ground_damping];
    s->gear_k = scene->element_values[ELEMENT_gear_ground];
    s->gear = s->gear_k > 0.0;
    s->rho = scene->gear.recovered_share;
    s->zeta = scene->gear.damping;
    s->axle_law = scene->gear.axle_exponent;
    s->plain = !rubs ? BARE : scene->friction_law == SIM_FRICTION_TANH ? SMOOTH : SLIDES;
    for (int j = 1; j <= s->mats + 1; j++) {
        real g = s->gap0[j] = sim_scene_joint_value(&scene->gap0_ft, j);
        bool grit = s->slack > 0.0 && sim_scene_joint_value(&scene->grit_lb, j) > 0.0;
        s->grit[j] = grit ? sim_scene_joint_value(&scene->grit_lb, j) : 0.0;
        s->reach[j] = fmin(fmax(g, 0.0), s->slack);
        s->joint[j] = s->slack <= 0.0 ? LINEAR
                    : g < 0.0         ? PRESSED
                    : g > s->slack    ? HOOKED
                    : grit            ? FOLLOWS
                                      : OPEN;
    }
    if (scene->left_end == SIM_END_FREE)
        s->joint[1] = LOOSE;
    if (scene->right_end == SIM_END_FREE)
        s->joint[s->mats + 1] = LOOSE;
    real x_ft = scene->path_count > 0 ? scene->path[0].x_ft : scene->start_ft;
    real under = floor(x_ft / scene->length_ft + EDGE) + 1.0;
    int thrown = scene->v0_mat > 0 ? scene->v0_mat : (int)fmax(1.0, fmin(s->mats, under));
    for (int n = 1; n <= s->mats; n++)
        s->mat[n] = s->plain == SLIDES ? STUCK : s->plain;
    s->u[1][thrown] = scene->v0_ft_s;
    s->side[thrown] = scene->v0_ft_s < 0.0 ? -1 : 1;
    if (s->plain == SLIDES && scene->v0_ft_s != 0.0)
        s->mat[thrown] = SLIDES;
}

static void series_at(const struct state *s, int n, real t_s, real *u_ft, real *v_ft_s)
{
    real u = s->u[s->order][n], v = 0.0;
    for (int k = s->order - 1; k >= 0; k--) {
        v = v * t_s + u;
        u = u * t_s + s->u[k][n];
    }
    *u_ft = u;
    *v_ft_s = v;
}

/* The times asked for within a step that begins at `begin_s`. */
static void show(const struct state *s, real begin_s, real long_s, bool last, size_t *next,
                 double *u_ft)
{
    const struct sim_list *times = &s->scene->t_out_s;
    for (; *next < times->count; (*next)++) {
        real into_s = times->values[*next] - begin_s, u, v;
        if (into_s > long_s && !last)
            return;
        double *row = u_ft + *next * ((size_t)s->mats + 1);
        for (int n = 1; n <= s->mats; n++) {
            u = s->u[0][n];
            if (n >= s->first && n <= s->last)
                series_at(s, n, fmax(0.0, fmin(into_s, long_s)), &u, &v);
            row[n] = (double)u;
        }
    }
}

static void advance(struct state *s, real h_s)
{
    for (int n = s->first; n <= s->last; n++) {
        real u, v;
        series_at(s, n, h_s, &u, &v);
        if (s->mat[n] == LOADS || s->mat[n] == UNLOADS)
            s->q[n] += ground_rate(s, n) * (u - s->u[0][n]);
        s->u[0][n] = u;
        s->u[1][n] = v;
        s->largest_ft = fmax(s->largest_ft, fabs(u));
    }
}

#define PEAK_POINTS 8

/* Largest of sign times a tension within the step: of even points, then of the parabola through the
 * largest and its neighbours. */
static real peak(const struct state *s, int j, real h_s, real sign)
{
    real at[PEAK_POINTS + 1];
    int top = 0;
    for (int i = 0; i <= PEAK_POINTS; i++) {
        at[i] = 0.0;
        for (int k = s->order - 2; k >= 0; k--)
            at[i] = at[i] * (h_s * i / PEAK_POINTS) + sign * s->tension[k][j];
        top = at[i] > at[top] ? i : top;
    }
    if (top == 0 || top == PEAK_POINTS)
        return at[top];
    real slope = 0.5 * (at[top + 1] - at[top - 1]);
    real bend = at[top + 1] - 2.0 * at[top] + at[top - 1];
    return bend < 0.0 ? at[top] - 0.5 * slope * slope / bend : at[top];
}

static void note_peaks(const struct state *s, real h_s)
{
    for (int j = s->first; s->run->push_lb && j <= s->last + 1; j++) {
        double *push = &s->run->push_lb[j], *pull = &s->run->pull_lb[j];
        real most = 0.0, power = 1.0; /* beyond T(0) */
        for (int k = 1; k + 2 <= s->order; k++)
            most += fabs(s->tension[k][j]) * (power *= h_s);
        if (most - s->tension[0][j] > *push)
            *push = fmax(*push, (double)peak(s, j, h_s, -1.0));
        if (most + s->tension[0][j] > *pull)
            *pull = fmax(*pull, (double)peak(s, j, h_s, 1.0));
    }
}

static bool span(struct state *s, real t0_s, real t1_s, real end_s, size_t *next, double *u_ft)
{
    real at_s = 0.0, long_s = t1_s - t0_s;
    int at_once = 0;
    while (at_s < long_s) {
        find_moving(s);
        expand(s, at_s);
        real h_s = reach_s(s, long_s - at_s);
        struct event event = first_event(s, h_s);
        bool switches = event.at_s <= h_s;
        if (switches)
            h_s = event.at_s;
        bool arrives = !switches && at_s + h_s >= long_s * (1.0 - 5.0 * ROUNDING);
        show(s, t0_s + at_s, h_s, arrives && t1_s >= end_s, next, u_ft);
        note_peaks(s, h_s);
        advance(s, h_s);
        at_s = arrives ? long_s : at_s + h_s;
        for (int n = s->first; n <= s->last; n++)
            if (s->mat[n] == GIVES)
                s->q[n] = s->side[n] * (s->limit[0][n] + s->limit[1][n] * at_s);
        if (switches && event.joint)
            switch_joint(s, event.index, (enum joint_mode)event.to);
        else if (switches)
            switch_mat(s, event.index, event.to,
                       s->limit[0][event.index] + s->limit[1][event.index] * at_s);
        s->run->switches += switches;
        at_once = switches && h_s <= 0.5 * ROUNDING * end_s ? at_once + 1 : 0;
        s->run->t_s = (double)(t0_s + at_s);
        if (++s->run->steps > s->run->most_steps || at_once > AT_ONCE_MAX ||
            !isfinite(s->largest_ft))
            return false;
    }
    return true;
}

bool RUN(struct chain_reference *run, const struct sim_scene *scene, double *u_ft)
{
    if (!understood(scene) || run->order > CHAIN_REFERENCE_ORDER)
        return false;
    struct state *s = calloc(1, sizeof *s);
    real touched[MATS] = {0}, end_s = sim_scene_end_s(scene), t_s = 0.0;
    size_t next = 0;
    bool good = true;
    if (!s)
        return false;
    s->scene = scene;
    s->run = run;
    s->order = run->order;
    s->tolerance_ft = run->tolerance_ft;
    run->steps = run->switches = 0;
    for (int j = 1; run->push_lb && j <= scene->mats + 1; j++)
        run->push_lb[j] = run->pull_lb[j] = 0.0;
    begin(s);
    struct times breaks = breaks_of(s, end_s);
    for (size_t i = 0; good && i <= breaks.count; i++) {
        real to_s = i < breaks.count ? breaks.at[i] : end_s;
        if (!(to_s > t_s))
            continue;
        press(s, t_s, to_s);
        s->look_at_all = true;
        change_ground(s, touched);
        memcpy(touched, s->touching, sizeof touched);
        good = span(s, t_s, to_s, end_s, &next, u_ft);
        t_s = to_s;
    }
    free(breaks.at);
    free(s);
    return good;
}
