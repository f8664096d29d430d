#include "host/analyse/params.h"

#include <math.h>

#include "common/gates.h"

#define ROUNDING_TOLERANCE 1e-9

/* Returns a product of powers. Its relative error is the root of the sum of squares of power times
 * relative error. */
static struct estimate multiply_powers(double constant, const struct estimate *factors,
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

struct estimate params_compute_inertia(struct estimate weight_lb, struct estimate spacing_ft,
                                       struct estimate cord_ft, struct estimate period_s)
{
    /* A mat turned by the angle a moves each end by a d/2 and tilts its cord by a d/(2 l), which
     * gives the restoring moment W d^2 a/(4 l). */
    const struct estimate factors[] = {weight_lb, spacing_ft, cord_ft, period_s};
    const double powers[] = {1, 2, -1, 2};
    return multiply_powers(1.0 / (16.0 * M_PI * M_PI), factors, powers, 4);
}

struct estimate params_compute_joint_stiffness(struct estimate slope_lb_in_in,
                                               struct estimate joint_in)
{
    const struct estimate factors[] = {slope_lb_in_in, joint_in};
    const double powers[] = {1, 1};
    return multiply_powers(12.0, factors, powers, 2);
}

struct estimate params_compute_hinge_stiffness(struct estimate strip_ft_lb_rad,
                                               struct estimate width_ratio)
{
    const struct estimate factors[] = {strip_ft_lb_rad, width_ratio};
    const double powers[] = {1, 1};
    return multiply_powers(1.0, factors, powers, 2);
}

struct estimate params_compute_mat_area(struct estimate length_ft, struct estimate width_ft)
{
    const struct estimate factors[] = {length_ft, width_ft};
    const double powers[] = {1, 1};
    return multiply_powers(1.0, factors, powers, 2);
}

struct estimate params_compute_friction(struct estimate pull_lb, struct estimate weight_lb)
{
    const struct estimate factors[] = {pull_lb, weight_lb};
    const double powers[] = {1, -1};
    return multiply_powers(1.0, factors, powers, 2);
}

struct estimate params_compute_soil_stiffness(struct estimate load_lb,
                                              struct estimate deflection_ft, double mats)
{
    const struct estimate factors[] = {load_lb, deflection_ft};
    const double powers[] = {1, -1};
    return multiply_powers(1.0 / (2.0 * mats), factors, powers, 2);
}

enum mr_status params_compute_plate_soil_stiffness(const double *load_lb,
                                                   const double *settlement_ft, size_t count,
                                                   struct estimate plate_ft,
                                                   struct estimate mat_ft2,
                                                   struct estimate *kv_lb_ft, struct error *error)
{
    struct line_fit line;
    const double powers[] = {1, -2, 1};
    if (line_fit(settlement_ft, load_lb, count, &line, error) != MR_OK)
        return error->status;
    line.slope.error *= mr_gates_student_factor((unsigned)count - 2u);
    const struct estimate factors[] = {line.slope, plate_ft, mat_ft2};
    *kv_lb_ft = multiply_powers(0.5 / (M_PI / 4.0), factors, powers, 3);
    return MR_OK;
}

struct estimate params_compute_mean(const double *readings, size_t count, double each)
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

/* Returns Student's t for a two-sided probability of 1 %, by degrees of freedom. */
static double compute_student_t(size_t freedom)
{
    static const double t[] = {63.66, 9.925, 5.841, 4.604, 4.032,
                               3.707, 3.499, 3.355, 3.250, 3.169};
    size_t entries = sizeof t / sizeof t[0];
    return freedom <= entries ? t[freedom - 1] : freedom < 20 ? 3.169 : 2.845;
}

enum mr_status params_fit_spring(const double *x, const double *y, size_t count,
                                 struct params_spring_fit *spring, struct error *error)
{
    struct line_fit line;
    if (line_fit(x, y, count, &line, error) != MR_OK)
        return error->status;
    double slope = line.slope.value, free = -line.intercept.value / slope,
           variance = line.intercept.error * line.intercept.error + 2.0 * free * line.covariance +
                      free * free * line.slope.error * line.slope.error;
    *spring = (struct params_spring_fit){
        .is_known = slope > compute_student_t(count - 2) * line.slope.error,
        .scatter = line.scatter,
        .stiffness = line.slope,
        .free_travel = {free, sqrt(fmax(variance, 0.0)) / fabs(slope)},
    };
    for (size_t i = 0; i < count && slope > 0.0; i++)
        spring->free_travel_readings += x[i] < free - ROUNDING_TOLERANCE * fabs(free);
    return MR_OK;
}
