#include "host/analyse/params.h"

#include <math.h>

/* Product of powers: relative errors add in squares, each times its power. */
static struct estimate product(double constant, const struct estimate *factors,
                               const double *powers, size_t count)
{
    double value = constant, relative2 = 0.0;
    for (size_t i = 0; i < count; i++) {
        double relative = powers[i] * factors[i].error / factors[i].value;
        value *= pow(factors[i].value, powers[i]);
        relative2 += relative * relative;
    }
    return (struct estimate){value, fabs(value) * sqrt(relative2)};
}

struct estimate params_inertia(struct estimate weight_lb, struct estimate spacing_ft,
                               struct estimate cord_ft, struct estimate period_s)
{
    /* Turned by a, each end swings out by a d/2 and its cord leans by a d/(2 l): restoring moment W
     * d^2 a/(4 l). */
    const struct estimate factors[] = {weight_lb, spacing_ft, cord_ft, period_s};
    const double powers[] = {1, 2, -1, 2};
    return product(1.0 / (16.0 * M_PI * M_PI), factors, powers, 4);
}

struct estimate params_joint_stiffness(struct estimate slope_lb_in_in, struct estimate joint_in)
{
    const struct estimate factors[] = {slope_lb_in_in, joint_in};
    const double powers[] = {1, 1};
    return product(12.0, factors, powers, 2);
}

struct estimate params_hinge_stiffness(struct estimate strip_ft_lb_rad, struct estimate wider)
{
    const struct estimate factors[] = {strip_ft_lb_rad, wider};
    const double powers[] = {1, 1};
    return product(1.0, factors, powers, 2);
}

struct estimate params_friction(struct estimate pull_lb, struct estimate weight_lb)
{
    const struct estimate factors[] = {pull_lb, weight_lb};
    const double powers[] = {1, -1};
    return product(1.0, factors, powers, 2);
}

struct estimate params_soil(struct estimate load_lb, struct estimate deflection_ft, double mats)
{
    const struct estimate factors[] = {load_lb, deflection_ft};
    const double powers[] = {1, -1};
    return product(1.0 / (2.0 * mats), factors, powers, 2);
}

struct estimate params_mean(const double *readings, size_t count, double each)
{
    double mean = 0.0, scatter2 = 0.0;
    for (size_t i = 0; i < count; i++)
        mean += readings[i] / (double)count;
    for (size_t i = 0; i < count; i++)
        scatter2 += (readings[i] - mean) * (readings[i] - mean);
    if (count > 1)
        scatter2 /= (double)(count - 1) * (double)count;
    return (struct estimate){mean, sqrt(scatter2 + each * each)};
}

/* Readings that lie partly within a free travel: where they divide, and the spring beyond.
 * params.h. */
#define LEAST_BEYOND 3
/* chance that scatter about 0 looks as much like a spring as the readings do */
#define NO_SPRING    0.01
#define SAME         1e-9 /* of the squares: two divisions fit alike */

/* The straight line through the readings with x above a limit. */
struct line {
    size_t count;
    double x, y;    /* their middle */
    double xx;      /* squares of x about that */
    double slope;   /* 0 where all x are the same */
    double free;    /* where the line meets 0 */
    double least_x; /* of those readings; INFINITY when there are none */
};

static struct line line_above(const double *x, const double *y, size_t count, double limit)
{
    struct line l = {.least_x = (double)INFINITY};
    double xy = 0.0;
    for (size_t i = 0; i < count; i++) {
        if (!(x[i] > limit))
            continue;
        l.count++;
        l.x += x[i];
        l.y += y[i];
        l.least_x = fmin(l.least_x, x[i]);
    }
    l.x /= (double)l.count;
    l.y /= (double)l.count;
    for (size_t i = 0; i < count; i++) { /* about their middle: no digits are lost */
        if (!(x[i] > limit))
            continue;
        l.xx += (x[i] - l.x) * (x[i] - l.x);
        xy += (x[i] - l.x) * (y[i] - l.y);
    }
    l.slope = l.xx > 0.0 ? xy / l.xx : 0.0;
    l.free = l.x - l.y / l.slope;
    return l;
}

/* What is left of all y: above the limit about the line through (x0, y0), elsewhere about 0. */
static double squares_about(const double *x, const double *y, size_t count, double limit, double x0,
                            double y0, double slope)
{
    double left = 0.0;
    for (size_t i = 0; i < count; i++) {
        double off = x[i] > limit ? y[i] - y0 - slope * (x[i] - x0) : y[i];
        left += off * off;
    }
    return left;
}

/* Squares that the law leaves when it begins between `limit` and the readings above. */
static double squares_left(const double *x, const double *y, size_t count, double limit)
{
    struct line l = line_above(x, y, count, limit);
    bool within = l.slope > 0.0 && l.free >= limit && l.free <= l.least_x;
    /* no reading contradicts */
    bool below = isinf(limit) && !(l.slope > 0.0 && l.free > l.least_x);
    if (l.count > 0 && (within || below))
        return squares_about(x, y, count, limit, l.x, l.y, l.slope);
    if (isinf(limit))
        return (double)INFINITY;
    double dd = 0.0, dy = 0.0; /* else it begins at the limit */
    for (size_t i = 0; i < count; i++) {
        dd += x[i] > limit ? (x[i] - limit) * (x[i] - limit) : 0.0;
        dy += x[i] > limit ? (x[i] - limit) * y[i] : 0.0;
    }
    return squares_about(x, y, count, limit, limit, 0.0, dd > 0.0 ? fmax(0.0, dy / dd) : 0.0);
}

/* Student's t that chance exceeds once in 200, by degrees of freedom. */
static double student(size_t freedom)
{
    static const double t[] = {63.66, 9.925, 5.841, 4.604, 4.032,
                               3.707, 3.499, 3.355, 3.250, 3.169};
    size_t entries = sizeof t / sizeof t[0];
    return freedom <= entries ? t[freedom - 1] : freedom < 20 ? 3.169 : 2.845;
}

/* The spring of the readings beyond, and its errors from the larger of two scatters: about their
 * line, and of all readings. */
static void read_spring(const double *x, const double *y, size_t count, double limit,
                        double squares, struct params_travel *travel)
{
    struct line l = line_above(x, y, count, limit);
    double n = (double)l.count, about_line = 0.0;
    for (size_t i = 0; i < count; i++) {
        double off = x[i] > limit ? y[i] - l.y - l.slope * (x[i] - l.x) : 0.0;
        about_line += off * off / (n - 2.0);
    }
    double variance = fmax(about_line, squares / ((double)count - 2.0));
    double k_error = sqrt(variance / l.xx), lever = l.x - l.free;
    travel->scatter = sqrt(variance);
    travel->k = (struct estimate){l.slope, k_error};
    /* free = x - y/k with x and y in the middle; the errors of y and k are independent */
    travel->free = (struct estimate){
        l.free, sqrt(variance / n + lever * lever * k_error * k_error) / fabs(l.slope)};
    travel->known = l.slope > student(l.count - 2) * k_error;
}

enum mr_status params_travel(const double *x, const double *y, size_t count,
                             struct params_travel *travel, struct error *error)
{
    struct line_fit all;
    if (line_fit(x, y, count, &all, error) != MR_OK)
        return error->status;
    double limit = -(double)INFINITY, best = squares_left(x, y, count, limit), nothing = 0.0;
    for (size_t i = 0; i < count; i++)
        nothing += y[i] * y[i];
    for (size_t i = 0; i < count; i++) {
        double left = squares_left(x, y, count, x[i]);
        double alike_within = SAME * (left + SAME * nothing);
        bool better = left + alike_within < best, alike = !better && left - alike_within <= best;
        if (better || (alike && x[i] < limit)) {
            /* of those that fit alike the one with most readings beyond */
            limit = x[i];
            best = left;
        }
    }
    struct line l = line_above(x, y, count, limit);
    *travel = (struct params_travel){.beyond = l.count,
                                     .scatter = sqrt(best / (double)(count - 2))};
    /* the law has two parameters more than `always 0`: F with 2 and n - 2 degrees of freedom, whose
     * tail is a power */
    double chance = nothing > 0.0 ? pow(fmin(1.0, best / nothing), 0.5 * (double)(count - 2)) : 1.0;
    bool falls = all.slope.value < 0.0 && -all.slope.value > student(count - 2) * all.slope.error;
    if (chance > NO_SPRING)
        travel->beyond = 0;
    else if (!falls && l.count >= LEAST_BEYOND && l.xx > 0.0)
        read_spring(x, y, count, limit, best, travel);
    return MR_OK;
}
