/* The implicit step of the chain; see chain.h. */
#include "tests/runs/chain.h"

#include <math.h>
#include <string.h>

#define MASS_SLUG (SYN_STRIP_WEIGHT_LB / SYN_GRAVITY_FT_S2)
#define STICK_LB  (SYN_FRICTION * SYN_STRIP_WEIGHT_LB)

/* Moreau's theta scheme: springs and dampers act at the middle of the step (which keeps the energy
 * of a ringing joint to its own damper), stick and grit on the speed at its end (which brings a mat
 * to rest exactly). A little above one half, so that what rings faster than the step dies out. */
#define THETA 0.52

#define TOGETHER       30 /* iterations that move all points at once */
#define ITERATIONS_MAX 20000
/* a law so near its line is on it: above rounding on slopes of 2e8 lb s/ft */
#define ON_LINE_LB     5e-6

/* What one step is about: fixed while its equations are solved. */
struct step {
    const struct syn_chain *chain;
    double h_s;
    double w_old_ft_s[SYN_JOINTS + 1];
    double thrust_lb[SYN_MATS + 2];
};

static double clamp(double x, double low, double high)
{
    return x < low ? low : x > high ? high : x;
}

/* What springs and dampers give at the middle of the step when joint j opens at w at its end: at
 * the hooks (positive: tension) and at the faces (positive: compression). Both are taken as lines;
 * the joint's law says which one bears. */
static double hook_lb(const struct step *step, int j, double w_ft_s, double *slope_out)
{
    double w_mid = (1.0 - THETA) * step->w_old_ft_s[j] + THETA * w_ft_s;
    double c_mid = step->chain->gap_ft[j] + THETA * step->h_s * w_mid;

    *slope_out = THETA * (SYN_JOINT_KL_LB_FT * THETA * step->h_s + SYN_JOINT_CL_LB_S_FT);
    return SYN_JOINT_KL_LB_FT * (c_mid - SYN_SLACK_FT) + SYN_JOINT_CL_LB_S_FT * w_mid;
}

static double contact_lb(const struct step *step, int j, double w_ft_s, double *slope_out)
{
    return -(hook_lb(step, j, w_ft_s, slope_out) + SYN_JOINT_KL_LB_FT * SYN_SLACK_FT);
}

/* Force across joint j (tension positive) when it opens at w at the end of the step; slope_out gets
 * dT/dw, never negative. */
static double joint_force_lb(const struct step *step, int j, double w_ft_s, double *slope_out)
{
    const struct syn_chain *chain = step->chain;
    double stiff;
    double hook = hook_lb(step, j, w_ft_s, &stiff);
    double contact = contact_lb(step, j, w_ft_s, &stiff);
    double grit = chain->grit_lb[j] * clamp(-w_ft_s / SYN_CREEP_FT_S, 0.0, 1.0);
    double compression = 0.0;

    *slope_out = 0.0;
    if (contact > grit) {
        compression = contact;
        *slope_out = stiff;
    } else if (grit > 0.0) {
        compression = grit;
        if (w_ft_s >= -SYN_CREEP_FT_S)
            *slope_out = chain->grit_lb[j] / SYN_CREEP_FT_S;
    }
    if (hook > -compression) {
        *slope_out = stiff;
        return hook;
    }
    return -compression;
}

/* What the ground takes from a mat moving at v, upfield positive. */
static double ground_force_lb(double v_ft_s, double *slope_out)
{
    bool slides = fabs(v_ft_s) > SYN_CREEP_FT_S;

    *slope_out = slides ? 0.0 : STICK_LB / SYN_CREEP_FT_S;
    return STICK_LB * clamp(v_ft_s / SYN_CREEP_FT_S, -1.0, 1.0);
}

/* Largest residual of the mats' momentum equations at speeds v, lb. */
static double worst_residual_lb(const struct step *step, const double *v_ft_s)
{
    double inertia = MASS_SLUG / step->h_s;
    double unused;
    double left = joint_force_lb(step, 1, v_ft_s[1], &unused);
    double most = 0.0;

    for (int n = 1; n <= SYN_MATS; n++) {
        double right = joint_force_lb(step, n + 1, v_ft_s[n + 1] - v_ft_s[n], &unused);
        double residual = inertia * (v_ft_s[n] - step->chain->v_ft_s[n]) +
                          ground_force_lb(v_ft_s[n], &unused) - step->thrust_lb[n] + left - right;

        if (!(fabs(residual) <= most))
            most = fabs(residual); /* a NaN ends here too, and is never small */
        left = right;
    }
    return most;
}

/* Where each law is made linear: every joint and every mat has a point of its own. */
struct points {
    double w_ft_s[SYN_JOINTS + 1];
    double v_ft_s[SYN_MATS + 2];
};

/* Next point for a law that is steep between low and high: where the last solution was, but never
 * from one side of the steep part to the other without a stop inside. Plain Newton jumps to and fro
 * across it for ever; with the stop, a mat that would reverse is tried at rest first, and a joint
 * that would turn from closing to opening is tried held. */
static double next_point(double from, double to, double low, double high)
{
    if ((from <= low && to >= high) || (from >= high && to <= low))
        return 0.5 * (low + high);
    return to;
}

/* Where joint j's law is steep: the part of the grit's ramp that neither hook nor contact covers;
 * low > high: nowhere. */
static void steep_part(const struct step *step, int j, double *low_ft_s, double *high_ft_s)
{
    double slope;
    double per_speed = step->chain->grit_lb[j] / SYN_CREEP_FT_S;
    double hook = hook_lb(step, j, 0.0, &slope);
    double contact = contact_lb(step, j, 0.0, &slope);

    *low_ft_s = fmax(-SYN_CREEP_FT_S, hook / (per_speed - slope));
    *high_ft_s = fmin(0.0, -contact / (per_speed - slope));
    if (per_speed < 10.0 * slope || *high_ft_s - *low_ft_s < 1e-6 * SYN_CREEP_FT_S)
        *low_ft_s = 1.0; /* no grit to speak of */
}

/* Solve the equations made linear at the points: (tridiagonal) v = right-hand side. Positive
 * definite: no pivoting. */
static void solve_linear(const struct step *step, const struct points *points, double *v_ft_s)
{
    double inertia = MASS_SLUG / step->h_s;
    double pivot[SYN_MATS + 2];
    double left_slope;
    double left = joint_force_lb(step, 1, points->w_ft_s[1], &left_slope);
    double slopes[SYN_JOINTS + 1];

    left -= left_slope * points->w_ft_s[1];
    for (int n = 1; n <= SYN_MATS; n++) {
        double right_slope;
        double stick_slope;
        double right = joint_force_lb(step, n + 1, points->w_ft_s[n + 1], &right_slope);
        double ground = ground_force_lb(points->v_ft_s[n], &stick_slope);

        right -= right_slope * points->w_ft_s[n + 1];
        ground -= stick_slope * points->v_ft_s[n];
        slopes[n] = left_slope;
        pivot[n] = inertia + stick_slope + left_slope + right_slope;
        v_ft_s[n] = inertia * step->chain->v_ft_s[n] - ground + step->thrust_lb[n] - left + right;
        if (n > 1) {
            double factor = slopes[n] / pivot[n - 1];

            pivot[n] -= factor * slopes[n];
            v_ft_s[n] += factor * v_ft_s[n - 1];
        }
        left = right;
        left_slope = right_slope;
    }
    v_ft_s[SYN_MATS] /= pivot[SYN_MATS];
    for (int n = SYN_MATS - 1; n >= 1; n--)
        v_ft_s[n] = (v_ft_s[n] + slopes[n + 1] * v_ft_s[n + 1]) / pivot[n];
}

/* Move the points to the solution v of the linear equations: all of them, or, with `first_only`,
 * only the first along the runway whose law is not on its line there. The former is fast and
 * usually enough; the latter, Murty's least-index rule for such systems, is slow and cannot go
 * round in circles. */
static void move_points(const struct step *step, const double *v_ft_s, bool first_only,
                        struct points *points)
{
    double slope;

    for (int n = 1; n <= SYN_JOINTS; n++) {
        double w = v_ft_s[n] - v_ft_s[n - 1];
        double w_line = joint_force_lb(step, n, points->w_ft_s[n], &slope) +
                        slope * (w - points->w_ft_s[n]);

        if (!first_only || fabs(joint_force_lb(step, n, w, &slope) - w_line) > ON_LINE_LB) {
            double low, high;

            steep_part(step, n, &low, &high);
            points->w_ft_s[n] = low > high ? w : next_point(points->w_ft_s[n], w, low, high);
            if (first_only)
                return;
        }
        if (n <= SYN_MATS) {
            double v_line = ground_force_lb(points->v_ft_s[n], &slope) +
                            slope * (v_ft_s[n] - points->v_ft_s[n]);

            if (!first_only || fabs(ground_force_lb(v_ft_s[n], &slope) - v_line) > ON_LINE_LB) {
                points->v_ft_s[n] = next_point(points->v_ft_s[n], v_ft_s[n], -SYN_CREEP_FT_S,
                                               SYN_CREEP_FT_S);
                if (first_only)
                    return;
            }
        }
    }
}

static bool solve(const struct step *step, double *v_ft_s, struct syn_chain *count)
{
    struct points points;

    memcpy(points.v_ft_s, v_ft_s, sizeof points.v_ft_s);
    for (int j = 1; j <= SYN_JOINTS; j++)
        points.w_ft_s[j] = v_ft_s[j] - v_ft_s[j - 1];
    for (int i = 0; i < ITERATIONS_MAX; i++) {
        solve_linear(step, &points, v_ft_s);
        count->iterations++;
        if (i == TOGETHER)
            count->hard_steps++;
        if (worst_residual_lb(step, v_ft_s) <= SYN_RESIDUAL_LB)
            return true;
        move_points(step, v_ft_s, i >= TOGETHER, &points);
    }
    return false;
}

static void share_thrust(const struct syn_thrust *thrust, double *thrust_lb)
{
    double left_ft = thrust->centre_ft - 0.5 * thrust->length_ft;
    double right_ft = left_ft + thrust->length_ft;

    memset(thrust_lb, 0, (SYN_MATS + 2) * sizeof *thrust_lb);
    if (!(thrust->force_lb > 0.0))
        return;
    for (int n = (int)floor(left_ft / SYN_MAT_FT) + 1; (n - 1) * SYN_MAT_FT < right_ft; n++) {
        double from = fmax(left_ft, (n - 1) * SYN_MAT_FT);
        double to = fmin(right_ft, n * SYN_MAT_FT);

        if (n >= 1 && n <= SYN_MATS && to > from)
            thrust_lb[n] = thrust->force_lb * (to - from) / thrust->length_ft;
    }
}

bool syn_chain_step(struct syn_chain *chain, const struct syn_thrust *thrust, double step_s)
{
    struct step step;
    double v[SYN_MATS + 2];
    double unused;

    step.chain = chain;
    step.h_s = step_s;
    share_thrust(thrust, step.thrust_lb);
    for (int j = 1; j <= SYN_JOINTS; j++)
        step.w_old_ft_s[j] = chain->v_ft_s[j] - chain->v_ft_s[j - 1];
    memcpy(v, chain->v_ft_s, sizeof v);
    if (!solve(&step, v, chain))
        return false;
    for (int n = 1; n <= SYN_MATS; n++) {
        chain->friction_impulse_lb_s += step_s * ground_force_lb(v[n], &unused);
        chain->thrust_impulse_lb_s += step_s * step.thrust_lb[n];
    }
    chain->end_impulse_lb_s += step_s * (joint_force_lb(&step, 1, v[1], &unused) -
                                         joint_force_lb(&step, SYN_JOINTS, -v[SYN_MATS], &unused));
    for (int j = 1; j <= SYN_JOINTS; j++)
        chain->gap_ft[j] += step_s *
                            ((1.0 - THETA) * step.w_old_ft_s[j] + THETA * (v[j] - v[j - 1]));
    memcpy(chain->v_ft_s, v, sizeof v);
    chain->steps++;
    return true;
}

void syn_chain_mark(struct syn_chain *chain)
{
    memcpy(chain->gap_start_ft, chain->gap_ft, sizeof chain->gap_ft);
    memset(chain->v_ft_s, 0, sizeof chain->v_ft_s);
    chain->friction_impulse_lb_s = 0.0;
    chain->end_impulse_lb_s = 0.0;
    chain->thrust_impulse_lb_s = 0.0;
    chain->steps = 0;
    chain->hard_steps = 0;
    chain->iterations = 0;
}

void syn_chain_displacement(const struct syn_chain *chain, double *u_ft)
{
    u_ft[0] = 0.0;
    for (int j = 1; j <= SYN_MATS; j++)
        u_ft[j] = u_ft[j - 1] + (chain->gap_ft[j] - chain->gap_start_ft[j]);
    u_ft[SYN_MATS + 1] = 0.0;
}

double syn_chain_fastest(const struct syn_chain *chain)
{
    double most = 0.0;

    for (int n = 1; n <= SYN_MATS; n++)
        most = fmax(most, fabs(chain->v_ft_s[n]));
    return most;
}

int syn_chain_mat_at(double station_ft)
{
    int mat = (int)floor(station_ft / SYN_MAT_FT + 1e-9) + 1;

    return mat < 1 ? 1 : mat > SYN_MATS ? SYN_MATS : mat;
}

void syn_chain_zone(const struct syn_chain *chain, double closed_ft, double from_ft,
                    struct syn_zone *zone)
{
    memset(zone, 0, sizeof *zone);
    for (int first = 1; first <= SYN_JOINTS; first++) {
        int last_open = first - 10;

        if (chain->gap_ft[first] > closed_ft || (first - 1) * SYN_MAT_FT < from_ft)
            continue;
        zone->closed_joints++;
        for (int j = first + 1; j <= SYN_JOINTS; j++) {
            if (chain->gap_ft[j] > closed_ft) {
                if (j - last_open < 10)
                    break;
                last_open = j;
            } else if (j - first > zone->mats) {
                zone->mats = j - first;
                zone->start_ft = (first - 1) * SYN_MAT_FT;
                zone->end_ft = (j - 1) * SYN_MAT_FT;
            }
        }
    }
}
