#include "host/analyse/track.h"

#include <math.h>
#include <string.h>

#define PARABOLA 3u
#define BRAKE_ERROR_FT 0.01 /* at touchdown: the brake takes 0.05 s to rise, and the parabola does not know */
#define LEAST_LOG10_Q (-8.0)
#define MOST_LOG10_Q 3.0
#define SEARCH_STEPS 40
#define GOLDEN 0.6180339887498949

/* Covariance of station at two times for q = 1, both since touchdown: the integral over u of (s - u)^2 (t - u)^2 / 4. */
static double wander(double a_s, double b_s)
{
    double s = fmin(a_s, b_s), d = fabs(a_s - b_s);
    return s <= 0.0 ? 0.0 : s * s * s * (s * s / 20.0 + d * s / 8.0 + d * d / 12.0);
}

static double power(double t_s, size_t n)
{
    return n == 0 ? 1.0 : n == 1 ? t_s : t_s * t_s;
}

/* The system of universal kriging: covariances, bordered by the parabola. */
static size_t set_system(const struct track *track, double q, double system[TRACK_SIZE][TRACK_SIZE])
{
    size_t n = track->points;
    memset(system, 0, sizeof(double[TRACK_SIZE][TRACK_SIZE]));
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < n; k++)
            system[i][k] = q * wander(track->t_s[i], track->t_s[k]);
        system[i][i] += track->error_ft[i] * track->error_ft[i];
        for (size_t p = 0; p < PARABOLA; p++)
            system[i][n + p] = system[n + p][i] = power(track->t_s[i], p);
    }
    return n + PARABOLA;
}

static void swap_rows(double *a, double *b, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        double kept = a[i];
        a[i] = b[i];
        b[i] = kept;
    }
}

/* Gauss-Jordan with row pivots; false: singular. Also the logarithm of the determinant's size. */
static bool invert(double a[TRACK_SIZE][TRACK_SIZE], size_t n, double inverse[TRACK_SIZE][TRACK_SIZE], double *log_determinant)
{
    *log_determinant = 0.0;
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < n; k++)
            inverse[i][k] = i == k;
    }
    for (size_t c = 0; c < n; c++) {
        size_t pivot = c;
        for (size_t r = c + 1; r < n; r++)
            pivot = fabs(a[r][c]) > fabs(a[pivot][c]) ? r : pivot;
        if (!(fabs(a[pivot][c]) > 0.0))
            return false;
        if (pivot != c) {
            swap_rows(a[c], a[pivot], n);
            swap_rows(inverse[c], inverse[pivot], n);
        }
        double scale = a[c][c];
        *log_determinant += log(fabs(scale));
        for (size_t k = 0; k < n; k++) {
            a[c][k] /= scale;
            inverse[c][k] /= scale;
        }
        for (size_t r = 0; r < n; r++) {
            double factor = a[r][c];
            for (size_t k = 0; r != c && k < n; k++) {
                a[r][k] -= factor * a[c][k];
                inverse[r][k] -= factor * inverse[c][k];
            }
        }
    }
    return true;
}

/* Minus twice the restricted log likelihood, but for a constant: the bordered determinant is |S| |X' S^-1 X|, and y' P y is the
 * generalised sum of squares, P the upper left part of the inverse. */
static double unlikeliness(const struct track *track, double q)
{
    double system[TRACK_SIZE][TRACK_SIZE], inverse[TRACK_SIZE][TRACK_SIZE], log_determinant, squares = 0.0;
    size_t size = set_system(track, q, system);
    if (!invert(system, size, inverse, &log_determinant))
        return INFINITY;
    for (size_t i = 0; i < track->points; i++) {
        for (size_t k = 0; k < track->points; k++)
            squares += track->station_ft[i] * inverse[i][k] * track->station_ft[k];
    }
    return log_determinant + squares;
}

static double most_likely_q(const struct track *track)
{
    double low = LEAST_LOG10_Q, high = MOST_LOG10_Q;
    double a = high - GOLDEN * (high - low), b = low + GOLDEN * (high - low);
    double at_a = unlikeliness(track, pow(10.0, a)), at_b = unlikeliness(track, pow(10.0, b));
    for (int i = 0; i < SEARCH_STEPS; i++) {
        if (at_a < at_b) {
            high = b;
            b = a;
            at_b = at_a;
            a = high - GOLDEN * (high - low);
            at_a = unlikeliness(track, pow(10.0, a));
        } else {
            low = a;
            a = b;
            at_a = at_b;
            b = low + GOLDEN * (high - low);
            at_b = unlikeliness(track, pow(10.0, b));
        }
    }
    return pow(10.0, 0.5 * (low + high));
}

static void add_point(struct track *track, double t_s, double station_ft, double error_ft)
{
    track->t_s[track->points] = t_s;
    track->station_ft[track->points] = station_ft;
    track->error_ft[track->points++] = error_ft;
}

void track_make(const struct measured *measured, struct track *track)
{
    const struct mr_gates_summary *summary = &measured->summary;
    const struct store_landing *landing = &measured->landing;
    double system[TRACK_SIZE][TRACK_SIZE], log_determinant;
    memset(track, 0, sizeof *track);
    if (measured->fit_status != MR_OK || !measured->t0_is_touchdown)
        return;
    double touchdown_error_ft = summary->touchdown_speed_ft_s.value * summary->touchdown_t_s.error;
    track->touchdown_ft = landing->touchdown_ft;
    track->touchdown_s = summary->touchdown_t_s;
    track->speed_ft_s = summary->touchdown_speed_ft_s;
    track->begin_s = fmin(measured->gate[0].t_s, 0.0);
    track->stop_s = summary->stop_t_s.value;
    add_point(track, 0.0, landing->touchdown_ft, hypot(touchdown_error_ft, BRAKE_ERROR_FT));
    for (size_t g = 0; g < measured->gates; g++) {
        const struct mr_gate *gate = &measured->gate[g];
        if (gate->t_s > 0.0 && gate->t_s < track->stop_s && !(summary->alien & 1u << g))
            add_point(track, gate->t_s, gate->station_ft, landing->switch_error_ft);
    }
    if (track->points < 4)
        return;
    add_point(track, track->stop_s, summary->stop_station_ft.value, summary->stop_station_ft.error);
    track->q = most_likely_q(track);
    size_t size = set_system(track, track->q, system);
    track->known = invert(system, size, track->inverse, &log_determinant);
}

/* Right side of the kriging system for one time. */
static void set_side(const struct track *track, double t_s, double side[TRACK_SIZE])
{
    for (size_t i = 0; i < track->points; i++)
        side[i] = track->q * wander(track->t_s[i], t_s);
    for (size_t p = 0; p < PARABOLA; p++)
        side[track->points + p] = power(t_s, p);
}

struct mr_estimate track_at(const struct track *track, double t_s)
{
    const struct mr_estimate unknown = {(double)NAN, (double)NAN};
    double side[TRACK_SIZE], station_ft = 0.0, variance = 0.0;
    if (!track->known || t_s < track->begin_s)
        return unknown;
    if (t_s < 0.0)
        return (struct mr_estimate){track->touchdown_ft + track->speed_ft_s.value * t_s,
                                    hypot(track->speed_ft_s.error * t_s, track->error_ft[0])};
    t_s = fmin(t_s, track->stop_s);
    set_side(track, t_s, side);
    for (size_t i = 0; i < track->points + PARABOLA; i++) {
        double weight = 0.0;
        for (size_t k = 0; k < track->points + PARABOLA; k++)
            weight += track->inverse[i][k] * side[k];
        variance -= weight * side[i];
        if (i < track->points)
            station_ft += weight * track->station_ft[i];
    }
    variance += track->q * wander(t_s, t_s);
    return (struct mr_estimate){station_ft, sqrt(fmax(variance, 0.0))};
}
