#include "host/link/timemap.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "host/base/statistics.h"

#define TIME_STAMP_ERROR_US       0.5 /* half the resolution of the host's time stamps */
#define STRIP_WIDTH_MIN_US        1e-3
/* 2000-01-01; an earlier time stamp is not a time of day */
#define EARLIEST_DATE_US          946684800000000
#define UNCERTAINTY_MAX_US        50000.0
#define BISECTION_COUNT           60
/* A larger rate difference means that the board's time is emulated, not that the clock was set. */
#define EMULATED_RATE_MIN_PPM     20000.0
/* A change of the clock is assumed if it explains the delays with a spread smaller by this factor.
 * Without a change, the factor was at most 2.8 in 50,000 sessions of 18 pairs or more, with any
 * delays. */
#define CLOCK_JUMP_RATIO_MIN      3.0
#define CLOCK_JUMP_PAIRS_MIN      6u  /* smallest number of pairs before and after the change */
#define CLOCK_JUMP_CANDIDATES_MAX 60u /* largest number of moments that are tried */

struct point {
    double x_s;  /* board time, s */
    double y_us; /* host time minus board time, both since the first pair */
};

void timemap_add(struct timemap *map, double board_us, int64_t host_us)
{
    if (map->pair_count &&
        board_us <= map->pair[(map->pair_count - 1) % TIMEMAP_PAIRS_MAX].board_us)
        return;
    map->pair[map->pair_count++ % TIMEMAP_PAIRS_MAX] = (struct timemap_pair){board_us, host_us};
}

static size_t copy_points(const struct timemap *map, struct timemap_fit *fit, struct point *point)
{
    size_t n = map->pair_count < TIMEMAP_PAIRS_MAX ? map->pair_count : TIMEMAP_PAIRS_MAX;
    double sum_s = 0.0;
    for (size_t i = 0; i < n; i++) {
        const struct timemap_pair *pair = &map->pair[(map->pair_count - n + i) % TIMEMAP_PAIRS_MAX];
        if (i == 0) {
            fit->board_origin_us = fit->from_us = pair->board_us;
            fit->host_origin_us = pair->host_us;
        }
        fit->to_us = pair->board_us;
        point[i].x_s = (pair->board_us - fit->board_origin_us) / 1e6;
        point[i].y_us = (double)(pair->host_us - fit->host_origin_us) -
                        (pair->board_us - fit->board_origin_us);
        sum_s += point[i].x_s;
    }
    fit->pair_count = n;
    fit->mean_time_s = n ? sum_s / (double)n : 0.0;
    return n;
}

/* True if c is on or above the line from a to b. */
static bool is_point_above_line(struct point a, struct point b, struct point c)
{
    return (b.x_s - a.x_s) * (c.y_us - a.y_us) >= (b.y_us - a.y_us) * (c.x_s - a.x_s);
}

/* Computes the lower convex hull of points that are sorted by time. */
static size_t compute_lower_hull(const struct point *point, size_t n, struct point *hull)
{
    size_t count = 0;
    for (size_t i = 0; i < n; i++) {
        while (count >= 2 && !is_point_above_line(hull[count - 2], hull[count - 1], point[i]))
            count--;
        hull[count++] = point[i];
    }
    return count;
}

/* Finds the line below all points that has the smallest mean distance to them. It contains the
 * hull's edge at the mean time. */
static void find_lower_tangent(const struct point *hull, size_t count, double mean_s,
                               double *at_mean_us, double *slope_ppm)
{
    size_t i = 1;
    while (i + 1 < count && hull[i].x_s < mean_s)
        i++;
    *slope_ppm = (hull[i].y_us - hull[i - 1].y_us) / (hull[i].x_s - hull[i - 1].x_s);
    *at_mean_us = hull[i].y_us + *slope_ppm * (mean_s - hull[i].x_s);
}

/* Finds the range of slopes of the lines through the point (mean_s, c_us) that stay below the
 * hull. */
static void find_slope_range(const struct point *hull, size_t count, double mean_s, double c_us,
                             double *low_ppm, double *high_ppm)
{
    *low_ppm = -(double)INFINITY;
    *high_ppm = (double)INFINITY;
    for (size_t i = 0; i < count; i++) {
        double x_s = hull[i].x_s - mean_s;
        if (x_s > 0.0)
            *high_ppm = fmin(*high_ppm, (hull[i].y_us - c_us) / x_s);
        else if (x_s < 0.0)
            *low_ppm = fmax(*low_ppm, (hull[i].y_us - c_us) / x_s);
    }
    /* on the hull itself the two slopes are equal except for rounding */
    *high_ppm = fmax(*high_ppm, *low_ppm);
}

/* Returns the number of pairs nearest to the line that are assumed to have uniform density. */
static size_t count_strip_pairs(size_t n)
{
    return 4 + (size_t)sqrt((double)n);
}

/* Computes the posterior of the line (timemap.h) on a grid of offsets c = T - D / u, u from 0 to 1.
 * D: height of the strip that holds m pairs; T: its top. The weight of an offset is proportional to
 * u^(m-2) times the range of slopes, which is the width between the tangents. */
static void integrate_posterior(struct timemap_fit *fit, const struct point *hull, size_t count,
                                double touch_us, double strip_us, double m)
{
    double sum = 0.0;
    for (size_t j = 0; j < TIMEMAP_GRID_POINTS; j++) {
        double u = pow(((double)j + 0.5) / TIMEMAP_GRID_POINTS, 1.0 / (m - 2.0));
        fit->offset_us[j] = touch_us + strip_us - strip_us / u;
        find_slope_range(hull, count, fit->mean_time_s, fit->offset_us[j], &fit->low_ppm[j],
                         &fit->high_ppm[j]);
        fit->weight[j] = u * (fit->high_ppm[j] - fit->low_ppm[j]);
        sum += fit->weight[j];
    }
    for (size_t j = 0; j < TIMEMAP_GRID_POINTS; j++)
        fit->weight[j] = sum > 0.0 ? fit->weight[j] / sum : 1.0 / TIMEMAP_GRID_POINTS;
}

/* Posterior of one quantity: a weighted sum of uniform distributions. */
struct residual_mixture {
    double low[TIMEMAP_GRID_POINTS], high[TIMEMAP_GRID_POINTS];
    const double *weight;
};

static double compute_probability_below(const struct residual_mixture *mixture, double value)
{
    double sum = 0.0;
    for (size_t j = 0; j < TIMEMAP_GRID_POINTS; j++) {
        double low = mixture->low[j], high = mixture->high[j];
        if (value >= high)
            sum += mixture->weight[j];
        else if (value > low)
            sum += mixture->weight[j] * (value - low) / (high - low);
    }
    return sum;
}

static double compute_quantile(const struct residual_mixture *mixture, double low, double high,
                               double p)
{
    for (int i = 0; i < BISECTION_COUNT && high - low > 1e-5; i++) {
        double middle = 0.5 * (low + high);
        if (compute_probability_below(mixture, middle) < p)
            low = middle;
        else
            high = middle;
    }
    return 0.5 * (low + high);
}

/* Computes the 95 % interval of the quantity k c + b t, with c and b of timemap.h. */
static struct timemap_value compute_interval(const struct timemap_fit *fit, double k, double t_s)
{
    struct residual_mixture mixture = {.weight = fit->weight};
    double least = (double)INFINITY, most = -(double)INFINITY;
    for (size_t j = 0; j < TIMEMAP_GRID_POINTS; j++) {
        double a = k * fit->offset_us[j] + fit->low_ppm[j] * t_s,
               b = k * fit->offset_us[j] + fit->high_ppm[j] * t_s;
        mixture.low[j] = a < b ? a : b;
        mixture.high[j] = a < b ? b : a;
        least = fmin(least, mixture.low[j]);
        most = fmax(most, mixture.high[j]);
    }
    double low = compute_quantile(&mixture, least, most, 0.025),
           high = compute_quantile(&mixture, low, most, 0.975);
    return (struct timemap_value){0.5 * (low + high), 0.5 * (high - low)};
}

struct timemap_value timemap_to_host_us(const struct timemap_fit *fit, double board_us)
{
    double since_us = board_us - fit->board_origin_us;
    struct timemap_value offset = compute_interval(fit, 1.0, since_us / 1e6 - fit->mean_time_s);
    return (struct timemap_value){(double)fit->host_origin_us + since_us + offset.value +
                                      TIME_STAMP_ERROR_US,
                                  hypot(offset.half_width, TIME_STAMP_ERROR_US)};
}

static bool is_rate_error_above(const struct timemap_fit *fit, double most_ppm)
{
    return fabs(fit->rate_ppm.value) - fit->rate_ppm.half_width > most_ppm;
}

static enum timemap_refusal check_fit(const struct timemap_fit *fit, double tolerance_ppm, bool set)
{
    if (fit->host_origin_us < EARLIEST_DATE_US)
        return TIMEMAP_UNDATED;
    if (set && !is_rate_error_above(fit, EMULATED_RATE_MIN_PPM))
        return TIMEMAP_UNCERTAIN;
    if (is_rate_error_above(fit, tolerance_ppm))
        return TIMEMAP_WRONG_RATE;
    if (fit->spread_us > UNCERTAINTY_MAX_US ||
        timemap_to_host_us(fit, fit->to_us).half_width > UNCERTAINTY_MAX_US)
        return TIMEMAP_UNCERTAIN;
    return TIMEMAP_OK;
}

/* True if the clock was set between pair k - 1 and pair k + gap. The pairs before and after the
 * change get separate lines, both with the rate of the longer part. A change is found if four
 * fifths of all pairs are at most `most_us` above their line. */
static bool is_clock_jump_at(const struct point *point, size_t n, size_t k, size_t gap,
                             double most_us)
{
    struct point hull[TIMEMAP_PAIRS_MAX];
    double at_us, slope_ppm, sum_s = 0.0;
    size_t from = k < n - k ? k + gap : 0, to = k < n - k ? n : k, within = 0;
    for (size_t i = from; i < to; i++)
        sum_s += point[i].x_s;
    size_t count = compute_lower_hull(point + from, to - from, hull);
    find_lower_tangent(hull, count, sum_s / (double)(to - from), &at_us, &slope_ppm);
    for (size_t part = 0; part < 2; part++) {
        size_t begin = part ? k + gap : 0, end = part ? n : k;
        double least_us = (double)INFINITY;
        for (size_t i = begin; i < end; i++)
            least_us = fmin(least_us, point[i].y_us - slope_ppm * point[i].x_s);
        for (size_t i = begin; i < end; i++)
            within += point[i].y_us - slope_ppm * point[i].x_s - least_us < most_us;
    }
    return within > (n - gap) * 4 / 5;
}

/* True if this computer's clock was set during the session: assuming such a change makes the delays
 * much smaller. */
static bool has_clock_jump(double late_us, const struct point *point, size_t n)
{
    double most_us = (late_us - 2.0 * TIME_STAMP_ERROR_US) / CLOCK_JUMP_RATIO_MIN;
    size_t gap = n / CLOCK_JUMP_CANDIDATES_MAX;
    for (size_t k = CLOCK_JUMP_PAIRS_MIN;
         n >= TIMEMAP_PAIRS_MIN + CLOCK_JUMP_PAIRS_MIN && k + gap + CLOCK_JUMP_PAIRS_MIN <= n;
         k += gap ? gap : 1) {
        if (is_clock_jump_at(point, n, k, gap, most_us))
            return true;
    }
    return false;
}

void timemap_fit(const struct timemap *map, double tolerance_ppm, struct timemap_fit *fit)
{
    struct point point[TIMEMAP_PAIRS_MAX], hull[TIMEMAP_PAIRS_MAX];
    double over_us[TIMEMAP_PAIRS_MAX], touch_us, slope_ppm;
    memset(fit, 0, sizeof *fit);
    size_t n = copy_points(map, fit, point);
    fit->refusal = TIMEMAP_TOO_FEW_PAIRS;
    if (n < TIMEMAP_PAIRS_MIN)
        return;
    size_t count = compute_lower_hull(point, n, hull);
    find_lower_tangent(hull, count, fit->mean_time_s, &touch_us, &slope_ppm);
    for (size_t i = 0; i < n; i++)
        over_us[i] = point[i].y_us - touch_us - slope_ppm * (point[i].x_s - fit->mean_time_s);
    sort_numbers(over_us, n);
    fit->spread_us = over_us[n / 2];
    size_t m = count_strip_pairs(n);
    double strip_us = over_us[m - 1] * (1.0 - (double)m / (4.0 * (double)n));
    integrate_posterior(fit, hull, count, touch_us, fmax(strip_us, STRIP_WIDTH_MIN_US), (double)m);
    /* time that this computer's clock gains per second of the board's clock, us */
    struct timemap_value slower = compute_interval(fit, 0.0, 1.0);
    fit->rate_ppm = (struct timemap_value){1e6 / (1.0 + slower.value / 1e6) - 1e6,
                                           slower.half_width};
    fit->refusal = check_fit(fit, tolerance_ppm, has_clock_jump(over_us[n * 4 / 5], point, n));
}

const char *timemap_refusal_text(unsigned refusal)
{
    switch (refusal) {
    case TIMEMAP_OK: return "good";
    case TIMEMAP_TOO_FEW_PAIRS: return "too few clock messages; log for at least 15 s";
    case TIMEMAP_UNDATED: return "the record contains no times of day";
    case TIMEMAP_WRONG_RATE:
        return "board time and the clock of this computer differ in rate: the board was emulated "
               "at full speed or read from a file, or the clock of this computer was changed";
    case TIMEMAP_UNCERTAIN:
        return "the delays of the link vary too much, or the clock of this computer was changed";
    default: return "unknown";
    }
}
