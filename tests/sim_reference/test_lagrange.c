/* The reference's accelerations against Lagrange's equation (the 1973 report checked its own so,
 * A-9, for four masses), with every derivative of the energies and openings taken numerically.
 * Nothing of model.c but the accelerations and the regime is used: energies, openings and heights
 * are written here once more.
 *
 * Report model: coordinates are q1, the centre heights of mats 2..4, u and theta; each mat has its
 * own pair of soil springs and dashpots. The rows of the centre heights 2..4 are dropped and the
 * heights put in from A-4 afterwards: that is what leave out of the vertical motion. */
#include <math.h>
#include <string.h>

#include "tests/cmocka_all.h"
#include "tests/sim_reference/model.h"

#define MATS 4
#define MOST (3 * MATS)

/* A free mat chain: centre height, displacement and angle of each mat. */
struct pose {
    double y[MATS], u[MATS], th[MATS];
};

static const struct ref_scene *scene;
static bool bracketed; /* whether the joints feel the rotation, b = 1 */

static double opening(const struct pose *p, int j, bool full)
{
    double h = scene->L / 2;
    double ul = j > 0 ? p->u[j - 1] : 0, ur = j < MATS ? p->u[j] : 0;
    double tl = j > 0 ? p->th[j - 1] : 0, tr = j < MATS ? p->th[j] : 0;
    return ur - ul + (full ? scene->L - h * cos(tl) - h * cos(tr) : 0);
}

static double turn(const struct pose *p, int j)
{
    return (j < MATS ? p->th[j] : 0) - (j > 0 ? p->th[j - 1] : 0);
}

static double end_height(const struct pose *p, int n, int right)
{
    return p->y[n] + (right ? 1 : -1) * scene->L / 2 * sin(p->th[n]);
}

/* Coordinates to pose. Report: q1, y2..y4, u, theta as they are. Consistent: node heights and u. */
static struct pose pose_of(const double *x, bool consistent)
{
    struct pose p;
    for (int n = 0; n < MATS; n++) {
        if (consistent) {
            p.y[n] = (x[n] + x[n + 1]) / 2;
            p.th[n] = asin((x[n + 1] - x[n]) / scene->L);
            p.u[n] = x[MATS + 1 + n];
        } else {
            p.y[n] = x[n];
            p.u[n] = x[MATS + n];
            p.th[n] = x[2 * MATS + n];
        }
    }
    return p;
}

/* d(value)/dx_i by a central difference of fourth order. */
typedef double (*function)(const struct pose *, int, int);
static double slope(function f, const double *x, bool consistent, int i, int a, int b)
{
    const double step = 1e-3;
    double moved[MOST], at[4];
    static const double where[4] = {-2, -1, 1, 2};
    for (int k = 0; k < 4; k++) {
        memcpy(moved, x, sizeof moved);
        moved[i] += where[k] * step;
        struct pose p = pose_of(moved, consistent);
        at[k] = f(&p, a, b);
    }
    return (at[0] - 8 * at[1] + 8 * at[2] - at[3]) / (12 * step);
}

static double f_opening(const struct pose *p, int j, int unused)
{
    (void)unused;
    return opening(p, j, true);
}
static double f_turn(const struct pose *p, int j, int unused)
{
    (void)unused;
    return turn(p, j);
}
static double f_height(const struct pose *p, int n, int right)
{
    return end_height(p, n, right);
}
static double f_centre(const struct pose *p, int n, int unused)
{
    (void)unused;
    return p->y[n];
}
static double f_angle(const struct pose *p, int n, int unused)
{
    (void)unused;
    return p->th[n];
}

/* Rate of f along the motion. */
static double rate(function f, const double *x, const double *v, int size, bool consistent, int a,
                   int b)
{
    double sum = 0;
    for (int i = 0; i < size; i++)
        sum += slope(f, x, consistent, i, a, b) * v[i];
    return sum;
}

/* Generalised force: - d(potential)/dx - d(dissipation)/dv of joints, hinges, soil; weight. The
 * joint's tension is that of the scene's profile, its direction that of the full opening. */
static double force(const double *x, const double *v, int size, bool consistent, int i)
{
    struct pose p = pose_of(x, consistent);
    double sum = 0;
    for (int j = 0; j <= MATS; j++) {
        bool joined = (j > 0 || scene->left_fixed) && (j < MATS || scene->right_fixed);
        bool hinged = (j > 0 || scene->left_torsion_fixed) &&
                      (j < MATS || scene->right_torsion_fixed);
        double low_rate = (j < MATS ? v[(consistent ? MATS + 1 : MATS) + j] : 0) -
                          (j > 0 ? v[(consistent ? MATS + 1 : MATS) + j - 1] : 0);
        double full_rate = rate(f_opening, x, v, size, consistent, j, 0);
        double tension = scene->KL * opening(&p, j, bracketed) +
                         scene->CL * (bracketed ? full_rate : low_rate);
        if (joined)
            sum -= tension * slope(f_opening, x, consistent, i, j, 0);
        double d = turn(&p, j), beyond = fabs(d) - scene->TAD;
        if (hinged && beyond > 0)
            sum -= (scene->KT * copysign(beyond, d) +
                    scene->CT * rate(f_turn, x, v, size, consistent, j, 0)) *
                   slope(f_turn, x, consistent, i, j, 0);
    }
    for (int n = 0; n < MATS; n++) {
        for (int right = 0; right <= 1; right++) {
            double y = end_height(&p, n, right);
            double reaction = scene->KV * y +
                              scene->CV * rate(f_height, x, v, size, consistent, n, right);
            bool presses = y > 0 && (!consistent || reaction > 0);
            if (presses)
                sum -= reaction * slope(f_height, x, consistent, i, n, right);
        }
        if (consistent)
            sum += scene->W * slope(f_centre, x, consistent, i, n, 0);
    }
    return sum;
}

static double kinetic(const double *x, const double *v, int size, bool consistent)
{
    double sum = 0;
    for (int n = 0; n < MATS; n++) {
        double y = rate(f_centre, x, v, size, consistent, n, 0),
               w = rate(f_angle, x, v, size, consistent, n, 0);
        double u = v[(consistent ? MATS + 1 : MATS) + n];
        sum += 0.5 * scene->W / scene->g * (y * y + u * u) + 0.5 * scene->I * w * w;
    }
    return sum;
}

/* dT/dx_i and dT/dv_i, numerically. */
static double kinetic_slope(const double *x, const double *v, int size, bool consistent, int i,
                            bool of_rate)
{
    const double step = of_rate ? 1e-2 : 2e-3;
    static const double where[4] = {-2, -1, 1, 2}, weight[4] = {1, -8, 8, -1};
    double sum = 0;
    for (int k = 0; k < 4; k++) {
        double a[MOST], b[MOST];
        memcpy(a, x, sizeof a);
        memcpy(b, v, sizeof b);
        (of_rate ? b : a)[i] += where[k] * step;
        sum += weight[k] * kinetic(a, b, size, consistent);
    }
    return sum / (12 * step);
}

/* d/dt (dT/dv_i) - dT/dx_i - force_i along x(t) = x + v t + a t^2/2: zero when a is right. */
static double residual(const double *x, const double *v, const double *a, int size, bool consistent,
                       int i)
{
    const double step = 1e-4;
    static const double where[4] = {-2, -1, 1, 2}, weight[4] = {1, -8, 8, -1};
    double momentum_rate = 0;
    for (int k = 0; k < 4; k++) {
        double t = where[k] * step, moved[MOST] = {0}, speed[MOST] = {0};
        for (int c = 0; c < size; c++) {
            moved[c] = x[c] + v[c] * t + a[c] * t * t / 2;
            speed[c] = v[c] + a[c] * t;
        }
        momentum_rate += weight[k] * kinetic_slope(moved, speed, size, consistent, i, true);
    }
    momentum_rate /= 12 * step;
    return momentum_rate - kinetic_slope(x, v, size, consistent, i, false) -
           force(x, v, size, consistent, i);
}

/* Numbers in [-1, 1] that are the same everywhere. */
static double scatter(unsigned *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (double)(*seed >> 8) / (double)(1u << 23) - 1;
}

static struct ref_scene small_scene(enum ref_model model, bool full)
{
    struct ref_scene s;
    ref_defaults(&s);
    s.model = model;
    s.mats = MATS;
    s.full = full;
    s.friction = REF_NO_FRICTION;
    s.F = s.V = 0;
    s.shear = REF_NONE;
    s.left_fixed = s.left_torsion_fixed = s.right_torsion_fixed = true;
    s.KL = 4e4; /* soft enough for numerical derivatives of forces to be good to 1e-8 */
    s.KV = 3e3;
    s.CV = 60;
    s.KT = 500;
    s.CT = 10;
    s.TAD = 0.05;
    return s;
}

static void report_model_obeys_lagrange(bool full)
{
    struct ref_scene s = small_scene(REF_REPORT, full);
    const struct ref_wheel wheel = {MATS, MATS, false};
    unsigned seed = 1;
    int checked_contact = 0, checked_lifted = 0;
    for (int state = 0; state < 12; state++) {
        double q[2 * MATS + 1], v[2 * MATS + 1], a[2 * MATS + 1], y[MATS + 1], y_rate[MATS + 1];
        struct ref_regime now;
        for (int i = 0; i < 2 * MATS + 1; i++) {
            q[i] = 0.2 * scatter(&seed);
            v[i] = 2 * scatter(&seed);
        }
        ref_regime_of(&s, &wheel, 0, q, v, &now);
        ref_accelerations(&s, &now, &wheel, 0, q, v, a);
        ref_heights(&s, q, v, y, y_rate);
        double x[MOST] = {0}, speed[MOST] = {0}, accel[MOST] = {0};
        for (int n = 0; n < MATS; n++) {
            x[n] = (y[n] + y[n + 1]) / 2; /* A-4 put in */
            speed[n] = (y_rate[n] + y_rate[n + 1]) / 2;
            x[MATS + n] = q[1 + n];
            speed[MATS + n] = v[1 + n];
            accel[MATS + n] = a[1 + n];
            x[2 * MATS + n] = q[1 + MATS + n];
            speed[2 * MATS + n] = v[1 + MATS + n];
            accel[2 * MATS + n] = a[1 + MATS + n];
        }
        accel[0] = a[0];
        scene = &s;
        bracketed = full;
        for (int i = 0; i < MOST; i++) {
            if (i > 0 && i < MATS)
                continue; /* the dropped rows */
            double off = residual(x, speed, accel, MOST, false, i);
            assert_near(off / 1000, 0, 1e-7); /* forces here are of the order of 1000 lb */
        }
        for (int j = 0; j <= MATS; j++)
            *(now.contact[j] ? &checked_contact : &checked_lifted) += 1;
    }
    assert_true(checked_contact > 10 && checked_lifted > 10);
}

TEST(the_report_model_with_brackets_is_lagranges)
{
    report_model_obeys_lagrange(true);
}

TEST(the_low_profile_is_lagranges_with_forces_that_ignore_rotation)
{
    report_model_obeys_lagrange(false);
}

TEST(the_consistent_model_is_lagranges)
{
    const int size = 2 * MATS + 1;
    struct ref_scene s = small_scene(REF_CONSISTENT, true);
    const struct ref_wheel wheel = {MATS, MATS, false};
    unsigned seed = 7;
    for (int k = 0; k < 12; k++) {
        double x[MOST] = {0}, v[MOST] = {0}, a[MOST] = {0};
        struct ref_regime now;
        for (int i = 0; i < size; i++) {
            x[i] = 0.2 * scatter(&seed);
            v[i] = 2 * scatter(&seed);
        }
        ref_regime_of(&s, &wheel, 0, x, v, &now);
        ref_accelerations(&s, &now, &wheel, 0, x, v, a);
        scene = &s;
        bracketed = true;
        for (int i = 0; i < size; i++) {
            double off = residual(x, v, a, size, true, i);
            assert_near(off / 1000, 0, 1e-7);
        }
    }
}
