#include "common/braking.h"

#include <math.h>
#include <string.h>

#define N             MR_BRAKING_UNKNOWNS
#define ROUNDS        10
#define DELAY_LEAST_S (-0.5) /* nonsense, but the search may pass there */
#define DELAY_MOST_S  0.5

/* Station and its derivatives by the unknowns at a time. */
struct at {
    double station_ft;
    double speed_ft_s;
    double slope[N];
};

/* Distance lost to braking per unit of deceleration, its derivatives by time and by the delay. The
 * shape counts after the rise: within it nothing but a switch at the very touchdown would be
 * concerned. */
static void loss(double since_s, double delay_s, double shape, double *value, double *rate,
                 double *by_delay)
{
    double rise_s = 2.0 * delay_s;
    if (since_s < rise_s) { /* twice the integral of 3 u^2 - 2 u^3 */
        double u = since_s / rise_s;
        *value = rise_s * rise_s * u * u * u * u * (0.25 - 0.1 * u);
        *rate = rise_s * u * u * u * (1.0 - 0.5 * u);
        *by_delay = 2.0 * rise_s * u * u * u * u * (-0.5 + 0.3 * u);
    } else {
        *value = 0.5 * (since_s - delay_s) * (since_s - delay_s) + 0.5 * shape * delay_s * delay_s;
        *rate = since_s - delay_s;
        *by_delay = (1.0 + shape) * delay_s - since_s;
    }
}

static void motion_at(const struct mr_braking *fit, double t_s, struct at *at)
{
    double since_s = t_s - fit->touchdown_s;
    double lost = 0.0, rate = 0.0, by_delay = 0.0;
    if (since_s > 0.0)
        loss(since_s, fit->delay_s, fit->shape, &lost, &rate, &by_delay);
    at->station_ft = fit->touchdown_ft + fit->speed_ft_s * since_s - fit->deceleration_ft_s2 * lost;
    at->speed_ft_s = fit->speed_ft_s - fit->deceleration_ft_s2 * rate;
    at->slope[MR_BRAKING_TIME] = -at->speed_ft_s;
    at->slope[MR_BRAKING_SPEED] = since_s;
    at->slope[MR_BRAKING_DECELERATION] = -lost;
    at->slope[MR_BRAKING_DELAY] = -fit->deceleration_ft_s2 * by_delay;
    at->slope[MR_BRAKING_SHAPE] = since_s > 2.0 * fit->delay_s
                                    ? -0.5 * fit->deceleration_ft_s2 * fit->delay_s * fit->delay_s
                                    : 0.0;
}

static bool factor_normal(double matrix[N][N])
{
    for (unsigned i = 0; i < N; i++) {
        for (unsigned k = 0; k <= i; k++) {
            double sum = matrix[i][k];
            for (unsigned j = 0; j < k; j++)
                sum -= matrix[i][j] * matrix[k][j];
            if (i != k)
                matrix[i][k] = sum / matrix[k][k];
            else if (sum > 1e-13 * matrix[i][i])
                matrix[i][i] = sqrt(sum);
            else
                return false;
        }
    }
    return true;
}

static void solve_normal(double lower[N][N], double x[N])
{
    for (unsigned i = 0; i < N; i++) {
        for (unsigned k = 0; k < i; k++)
            x[i] -= lower[i][k] * x[k];
        x[i] /= lower[i][i];
    }
    for (unsigned i = N; i-- > 0;) {
        for (unsigned k = i + 1; k < N; k++)
            x[i] -= lower[k][i] * x[k];
        x[i] /= lower[i][i];
    }
}

static double variance_by(const struct mr_braking *fit, const double *gradient)
{
    double variance = 0.0;
    for (unsigned i = 0; i < N; i++) {
        for (unsigned k = 0; k < N; k++)
            variance += gradient[i] * fit->covariance[i][k] * gradient[k];
    }
    return variance > 0.0 ? variance : 0.0;
}

static double standard_error(const struct mr_braking *fit, const double *gradient)
{
    return sqrt(variance_by(fit, gradient));
}

static bool uses(const struct mr_braking *fit, size_t gate)
{
    return !(fit->left_out & 1u << gate);
}

/* A start good enough to converge from: the parabola through the gates (three of them at least), on
 * the track's line where there is one. */
static enum mr_status guess(const struct mr_gate *gates, size_t count, struct mr_braking *fit)
{
    struct mr_gate used[MR_GATES_MAX];
    struct mr_gates_fit parabola;
    struct mr_motion_estimate there;
    size_t total = 0, on_track = 0;
    for (size_t g = 0; g < count; g++) {
        if (!uses(fit, g))
            continue;
        on_track += gates[g].station_ft < fit->touchdown_ft;
        used[total++] = gates[g];
    }
    if (total < 3 || on_track == total)
        return MR_TOO_FEW;
    size_t skip = total - on_track >= 3 ? on_track : 0;
    enum mr_status status = mr_gates_fit(used + skip, total - skip, 2, 1.0, &parabola);
    if (status != MR_OK)
        return status;
    const struct mr_gate *last = &used[total - 1];
    mr_gates_at(&parabola, parabola.mid_s, &there);
    fit->deceleration_ft_s2 = there.deceleration_ft_s2.value;
    if (on_track >= 2) {
        const struct mr_gate *first = &used[0], *second = &used[on_track - 1];
        fit->speed_ft_s = (second->station_ft - first->station_ft) / (second->t_s - first->t_s);
        fit->touchdown_s = first->t_s + (fit->touchdown_ft - first->station_ft) / fit->speed_ft_s;
    } else { /* back from the first gate beyond at that deceleration */
        mr_gates_at(&parabola, used[skip].t_s, &there);
        double back_ft = used[skip].station_ft - fit->touchdown_ft,
               speed_ft_s = there.speed_ft_s.value;
        double square = speed_ft_s * speed_ft_s + 2.0 * fit->deceleration_ft_s2 * back_ft;
        fit->speed_ft_s = square > 0.0 ? sqrt(square) : speed_ft_s;
        fit->touchdown_s = used[skip].t_s - 2.0 * back_ft / (fit->speed_ft_s + speed_ft_s);
    }
    fit->delay_s = MR_BRAKE_DELAY_S;
    fit->shape = MR_BRAKE_SHAPE;
    double since_s = last->t_s - fit->touchdown_s - fit->delay_s;
    if (on_track >= 2 && since_s > 0.0) {
        double lost_ft = fit->touchdown_ft + fit->speed_ft_s * (last->t_s - fit->touchdown_s) -
                         last->station_ft;
        fit->deceleration_ft_s2 = 2.0 * lost_ft / (since_s * since_s);
    }
    fit->freedom = (unsigned)total - 3;
    return fit->speed_ft_s > 0.0 && fit->deceleration_ft_s2 > 0.0 ? MR_OK : MR_NUMERICS;
}

/* An unknown that was measured beforehand. */
static void known_before(double value, double error, double now, unsigned unknown,
                         struct mr_braking *fit, double matrix[N][N], double right[N])
{
    double off = (value - now) / error;
    matrix[unknown][unknown] = 1.0 / (error * error);
    right[unknown] = off / error;
    fit->chi_square += off * off;
}

/* Normal equations about the present values, in units of the position error. */
static void equations(const struct mr_gate *gates, size_t count, double position_error_ft,
                      struct mr_braking *fit, double matrix[N][N], double right[N])
{
    double weight = 1.0 / position_error_ft;
    memset(matrix, 0, N * sizeof matrix[0]);
    memset(right, 0, N * sizeof right[0]);
    fit->chi_square = 0.0;
    known_before(MR_BRAKE_DELAY_S, MR_BRAKE_DELAY_ERROR_S, fit->delay_s, MR_BRAKING_DELAY, fit,
                 matrix, right);
    known_before(MR_BRAKE_SHAPE, MR_BRAKE_SHAPE_ERROR, fit->shape, MR_BRAKING_SHAPE, fit, matrix,
                 right);
    for (size_t g = 0; g < count; g++) {
        struct at at;
        if (!uses(fit, g))
            continue;
        motion_at(fit, gates[g].t_s, &at);
        double residual = (gates[g].station_ft - at.station_ft) * weight;
        fit->chi_square += residual * residual;
        for (unsigned i = 0; i < N; i++) {
            at.slope[i] *= weight;
            right[i] += at.slope[i] * residual;
            for (unsigned k = 0; k <= i; k++)
                matrix[i][k] += at.slope[i] * at.slope[k];
        }
    }
}

static double within(double value, double least, double most)
{
    return value < least ? least : value > most ? most : value;
}

enum mr_status mr_braking_fit(const struct mr_gate *gates, size_t count, double touchdown_ft,
                              double position_error_ft, uint32_t left_out, struct mr_braking *fit)
{
    double matrix[N][N], step[N];
    memset(fit, 0, sizeof *fit);
    fit->touchdown_ft = touchdown_ft;
    fit->left_out = left_out;
    enum mr_status status = guess(gates, count, fit);
    if (status != MR_OK)
        return status;
    for (unsigned round = 0;; round++) {
        equations(gates, count, position_error_ft, fit, matrix, step);
        /* as near as it gets: gates that contradict each other, and chi-square says so */
        if (round == ROUNDS)
            break;
        if (!factor_normal(matrix))
            return MR_NUMERICS;
        solve_normal(matrix, step);
        fit->touchdown_s += step[MR_BRAKING_TIME];
        fit->speed_ft_s += step[MR_BRAKING_SPEED];
        fit->deceleration_ft_s2 += step[MR_BRAKING_DECELERATION];
        fit->delay_s = within(fit->delay_s + step[MR_BRAKING_DELAY], DELAY_LEAST_S, DELAY_MOST_S);
        fit->shape = within(fit->shape + step[MR_BRAKING_SHAPE], 0.0, 1.0);
        if (!(fit->speed_ft_s > 0.0) || !(fit->deceleration_ft_s2 > 0.0))
            return MR_NUMERICS;
        /* A step that moves no result by a hundredth of the error it can have is the last. */
        if (fabs(step[MR_BRAKING_SPEED]) < 2e-6 * fit->speed_ft_s &&
            fabs(step[MR_BRAKING_DECELERATION]) < 1e-5 * fit->deceleration_ft_s2 &&
            fabs(step[MR_BRAKING_TIME]) * fit->speed_ft_s < 1e-2 * position_error_ft)
            break;
    }
    equations(gates, count, position_error_ft, fit, matrix, step);
    if (!factor_normal(matrix))
        return MR_NUMERICS;
    for (unsigned column = 0; column < N; column++) {
        double unit[N] = {0};
        unit[column] = 1.0;
        solve_normal(matrix, unit);
        for (unsigned row = 0; row < N; row++)
            fit->covariance[row][column] = unit[row];
    }
    return MR_OK;
}

double mr_chi_square(unsigned freedom, double deviations)
{
    double k = (double)freedom, part = 2.0 / (9.0 * k);
    double root = 1.0 - part + deviations * sqrt(part);
    return freedom ? k * root * root * root : 0.0;
}

bool mr_braking_holds(const struct mr_braking *fit)
{
    return fit->freedom == 0 || fit->chi_square <= mr_chi_square(fit->freedom, MR_ONE_IN_1000);
}

/* The gate that chi-square would lose most without (exact where the model is linear), and by how
 * much. */
static double find_worst(const struct mr_braking *fit, const struct mr_gate *gates, size_t count,
                         double position_error_ft, size_t *worst)
{
    double most = 0.0;
    for (size_t g = 0; g < count; g++) {
        struct at at;
        if (!uses(fit, g))
            continue;
        motion_at(fit, gates[g].t_s, &at);
        double residual = (gates[g].station_ft - at.station_ft) / position_error_ft;
        double own = 1.0 - variance_by(fit, at.slope) / (position_error_ft * position_error_ft);
        if (own > 1e-6 && residual * residual / own > most) {
            most = residual * residual / own;
            *worst = g;
        }
    }
    return most;
}

enum mr_status mr_braking_leave_out(const struct mr_gate *gates, size_t count,
                                    double position_error_ft, struct mr_braking *fit)
{
    size_t worst = 0, out = 0;
    for (size_t g = 0; g < count; g++)
        out += !uses(fit, g);
    if (out > count / 5 || fit->freedom < 2 ||
        find_worst(fit, gates, count, position_error_ft, &worst) < MR_GATE_ALIEN * MR_GATE_ALIEN)
        return MR_LIMIT;
    double touchdown_ft = fit->touchdown_ft;
    return mr_braking_fit(gates, count, touchdown_ft, position_error_ft,
                          fit->left_out | 1u << worst, fit);
}

double mr_braking_late_s(const struct mr_braking *fit, const struct mr_gate *gate)
{
    struct at at;
    motion_at(fit, gate->t_s, &at);
    return at.speed_ft_s > 0.0 ? (at.station_ft - gate->station_ft) / at.speed_ft_s : 0.0;
}

enum mr_status mr_braking_summarise(const struct mr_braking *fit, struct mr_gates_summary *summary)
{
    double v = fit->speed_ft_s, a = fit->deceleration_ft_s2, d = fit->delay_s;
    double after_s = d + v / a; /* from touchdown to rest */
    if (after_s < 2.0 * d)
        return MR_NUMERICS;
    double k = fit->shape;
    const double of_speed[N] = {[MR_BRAKING_SPEED] = 1.0};
    const double of_touchdown[N] = {[MR_BRAKING_TIME] = 1.0};
    const double of_stop[N] = {1.0, 1.0 / a, -v / (a * a), 1.0, 0.0};
    const double of_station[N] = {0.0, after_s, -0.5 * v * v / (a * a) - 0.5 * k * d * d,
                                  v - k * a * d, -0.5 * a * d * d};
    const double of_mean[N] = {0.0, 1.0 / after_s - v / (a * after_s * after_s),
                               v * v / (a * a * after_s * after_s), -v / (after_s * after_s), 0.0};
    summary->touchdown_speed_ft_s = (struct mr_estimate){v, standard_error(fit, of_speed)};
    summary->touchdown_t_s = (struct mr_estimate){fit->touchdown_s,
                                                  standard_error(fit, of_touchdown)};
    summary->stop_t_s = (struct mr_estimate){fit->touchdown_s + after_s,
                                             standard_error(fit, of_stop)};
    summary->stop_station_ft =
        (struct mr_estimate){fit->touchdown_ft + v * d + 0.5 * v * v / a - 0.5 * k * a * d * d,
                             standard_error(fit, of_station)};
    summary->mean_deceleration_ft_s2 = (struct mr_estimate){v / after_s,
                                                            standard_error(fit, of_mean)};
    return MR_OK;
}
