#include "common/gates.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#define TERM_COUNT (MR_GATES_ORDER_MAX + 1)

/* Quantile 0.975 of Student's t for 1 to 10 degrees of freedom. */
static const double student_t_975[] = {12.706, 4.303, 3.182, 2.776, 2.571,
                                       2.447,  2.365, 2.306, 2.262, 2.228};

double mr_gates_student_factor(unsigned freedom)
{
    unsigned known = sizeof student_t_975 / sizeof student_t_975[0];
    if (freedom == 0)
        return student_t_975[0] / 1.96;
    return freedom <= known ? student_t_975[freedom - 1] / 1.96 : 1.0 + 1.37 / (double)freedom;
}

/* Chebyshev polynomials T_0 to T_order of scaled time, two derivatives by time: 1, 1/s, 1/s^2. */
struct basis {
    double value[TERM_COUNT];
    double first_derivative[TERM_COUNT];
    double second_derivative[TERM_COUNT];
};

static double scale_time(const struct mr_gates_fit *fit, double t_s)
{
    return (t_s - fit->mid_time_s) / fit->half_span_s;
}

static void compute_values(const struct mr_gates_fit *fit, double tau, double value[TERM_COUNT])
{
    memset(value, 0, TERM_COUNT * sizeof value[0]);
    value[0] = 1.0;
    value[1] = tau;
    for (unsigned k = 2; k <= fit->degree; k++)
        value[k] = 2.0 * tau * value[k - 1] - value[k - 2];
}

static void compute_basis(const struct mr_gates_fit *fit, double t_s, struct basis *basis)
{
    double tau = scale_time(fit, t_s);
    double per_s = 1.0 / fit->half_span_s;
    memset(basis, 0, sizeof *basis);
    compute_values(fit, tau, basis->value);
    basis->first_derivative[1] = per_s;
    for (unsigned k = 2; k <= fit->degree; k++) {
        basis->first_derivative[k] = 2.0 * per_s * basis->value[k - 1] +
                                     2.0 * tau * basis->first_derivative[k - 1] -
                                     basis->first_derivative[k - 2];
        basis->second_derivative[k] = 4.0 * per_s * basis->first_derivative[k - 1] +
                                      2.0 * tau * basis->second_derivative[k - 1] -
                                      basis->second_derivative[k - 2];
    }
}

/* Returns the root of the sum of squares. hypot is not used: it differs between C libraries in the
 * last bit, and host and board must agree. */
static double add_in_quadrature(double a, double b)
{
    return sqrt(a * a + b * b);
}

static double fit_value(const struct mr_gates_fit *fit, const double *terms)
{
    double sum = 0.0;
    for (unsigned k = 0; k <= fit->degree; k++)
        sum += fit->coefficient[k] * terms[k];
    return sum;
}

/* Variance of a quantity, from its derivatives with respect to the n unknowns. */
static double get_variance(const double covariance[TERM_COUNT][TERM_COUNT], unsigned n,
                           const double *gradient)
{
    double variance = 0.0;
    for (unsigned i = 0; i < n; i++) {
        for (unsigned k = 0; k < n; k++)
            variance += gradient[i] * covariance[i][k] * gradient[k];
    }
    return variance > 0.0 ? variance : 0.0;
}

static double compute_standard_error(const struct mr_gates_fit *fit, const double *gradient)
{
    return sqrt(get_variance(fit->covariance, fit->degree + 1, gradient));
}

/* Cholesky factor in place (lower triangle). False: the matrix is not positive definite. */
static bool factor_cholesky(double matrix[TERM_COUNT][TERM_COUNT], unsigned n)
{
    for (unsigned i = 0; i < n; i++) {
        for (unsigned k = 0; k <= i; k++) {
            double sum = matrix[i][k];
            for (unsigned j = 0; j < k; j++)
                sum -= matrix[i][j] * matrix[k][j];
            if (i != k) {
                matrix[i][k] = sum / matrix[k][k];
            } else if (sum > 1e-13 * matrix[i][i]) {
                matrix[i][i] = sqrt(sum);
            } else {
                return false;
            }
        }
    }
    return true;
}

static void solve_factored(double lower[TERM_COUNT][TERM_COUNT], unsigned n, double x[TERM_COUNT])
{
    for (unsigned i = 0; i < n; i++) {
        for (unsigned k = 0; k < i; k++)
            x[i] -= lower[i][k] * x[k];
        x[i] /= lower[i][i];
    }
    for (unsigned i = n; i-- > 0;) {
        for (unsigned k = i + 1; k < n; k++)
            x[i] -= lower[k][i] * x[k];
        x[i] /= lower[i][i];
    }
}

/* Computes `scale` times the inverse of the matrix with the given Cholesky factor. */
static void invert_factored(double lower[TERM_COUNT][TERM_COUNT], unsigned n, double scale,
                            double inverse[TERM_COUNT][TERM_COUNT])
{
    for (unsigned column = 0; column < n; column++) {
        double unit[TERM_COUNT] = {0};
        unit[column] = scale;
        solve_factored(lower, n, unit);
        for (unsigned row = 0; row < n; row++)
            inverse[row][column] = unit[row];
    }
}

enum mr_status mr_gates_fit(const struct mr_gate *gates, size_t count, unsigned order,
                            double position_error_ft, struct mr_gates_fit *fit)
{
    double matrix[TERM_COUNT][TERM_COUNT] = {{0}};
    double right[TERM_COUNT] = {0};
    unsigned terms = order + 1;

    if (order < 1 || order > MR_GATES_ORDER_MAX || count < terms)
        return MR_TOO_FEW;
    for (size_t i = 1; i < count; i++) {
        if (!(gates[i].t_s > gates[i - 1].t_s))
            return MR_MALFORMED;
    }
    memset(fit, 0, sizeof *fit);
    fit->degree = order;
    fit->count = (unsigned)count;
    fit->mid_time_s = 0.5 * (gates[0].t_s + gates[count - 1].t_s);
    fit->half_span_s = 0.5 * (gates[count - 1].t_s - gates[0].t_s);

    for (size_t g = 0; g < count; g++) {
        double value[TERM_COUNT];
        compute_values(fit, scale_time(fit, gates[g].t_s), value);
        for (unsigned i = 0; i < terms; i++) {
            right[i] += value[i] * gates[g].station_ft;
            for (unsigned k = 0; k <= i; k++)
                matrix[i][k] += value[i] * value[k];
        }
    }
    if (!factor_cholesky(matrix, terms))
        return MR_NUMERICS;
    solve_factored(matrix, terms, right);
    memcpy(fit->coefficient, right, sizeof right);

    double squares = 0.0;
    for (size_t g = 0; g < count; g++) {
        double value[TERM_COUNT];
        compute_values(fit, scale_time(fit, gates[g].t_s), value);
        double residual = gates[g].station_ft - fit_value(fit, value);
        squares += residual * residual;
    }
    fit->residual_ft = count > terms ? sqrt(squares / (double)(count - terms)) : 0.0;
    double deviation = position_error_ft;
    if (count > terms && squares > mr_chi_square_limit((unsigned)count - terms, MR_SIGMA_1_IN_100) *
                                       deviation * deviation)
        deviation = fit->residual_ft * mr_gates_student_factor((unsigned)count - terms);
    invert_factored(matrix, terms, deviation * deviation, fit->covariance);
    return MR_OK;
}

static double sum_of_squares(const struct mr_gates_fit *fit)
{
    return fit->residual_ft * fit->residual_ft * (double)(fit->count - fit->degree - 1);
}

enum mr_status mr_gates_fit_best(const struct mr_gate *gates, size_t count,
                                 double position_error_ft, struct mr_gates_fit *fit)
{
    enum mr_status status = mr_gates_fit(gates, count, count > 2 ? 2 : 1, position_error_ft, fit);
    if (status != MR_OK)
        return status;
    for (unsigned order = fit->degree + 1; order <= MR_GATES_ORDER_MAX && count >= order + 4;
         order++) {
        struct mr_gates_fit higher;
        if (mr_gates_fit(gates, count, order, position_error_ft, &higher) != MR_OK)
            break;
        double gain = (sum_of_squares(fit) - sum_of_squares(&higher)) /
                      (position_error_ft * position_error_ft);
        if (gain > mr_chi_square_limit(order - fit->degree, MR_SIGMA_1_IN_100))
            *fit = higher;
    }
    return MR_OK;
}

void mr_gates_motion_at_time(const struct mr_gates_fit *fit, double t_s,
                             struct mr_motion_estimate *motion)
{
    struct basis basis;
    compute_basis(fit, t_s, &basis);
    motion->t_s = t_s;
    motion->position_ft = (struct mr_estimate){fit_value(fit, basis.value),
                                               compute_standard_error(fit, basis.value)};
    motion->speed_ft_s = (struct mr_estimate){fit_value(fit, basis.first_derivative),
                                              compute_standard_error(fit, basis.first_derivative)};
    motion->deceleration_ft_s2 = (struct mr_estimate){(double)NAN, (double)NAN};
    if (fit->degree >= 2)
        motion->deceleration_ft_s2 =
            (struct mr_estimate){-fit_value(fit, basis.second_derivative),
                                 compute_standard_error(fit, basis.second_derivative)};
}

static bool is_parabola(const struct mr_gates_fit *fit, double position_error_ft)
{
    unsigned freedom = fit->count - 3;
    return freedom == 0 || sum_of_squares(fit) <= mr_chi_square_limit(freedom, MR_SIGMA_1_IN_100) *
                                                      position_error_ft * position_error_ft;
}

/* Fits all gates except gate `out`. True: they lie on a parabola, `out` does not. */
static bool fit_without_gate(const struct mr_gate *gates, size_t count, size_t out,
                             double position_error_ft, struct mr_gates_fit *fit)
{
    struct mr_gate rest[MR_GATES_END_MAX];
    struct mr_motion_estimate there;
    memcpy(rest, gates, out * sizeof gates[0]);
    memcpy(rest + out, gates + out + 1, (count - out - 1) * sizeof gates[0]);
    if (mr_gates_fit(rest, count - 1, 2, position_error_ft, fit) != MR_OK ||
        !is_parabola(fit, position_error_ft))
        return false;
    mr_gates_motion_at_time(fit, gates[out].t_s, &there);
    double off_ft = fabs(gates[out].station_ft - there.position_ft.value);
    return off_ft >
           MR_GATE_OUTLIER_SIGMA * add_in_quadrature(position_error_ft, there.position_ft.error);
}

/* One step of the outlier search: tries the next gate. Returns false when the search has ended; if
 * it found an outlier, `fit` is the fit of the other gates. */
static bool test_next_outlier(const struct mr_gate *gates, size_t count, double position_error_ft,
                              struct mr_gates_fit *fit, struct mr_gates_search *search)
{
    struct mr_gates_fit without;
    if (count > 5 && search->next < count) {
        if (fit_without_gate(gates, count, search->next, position_error_ft, &without) &&
            (!search->is_found || without.residual_ft < search->min_residual_ft)) {
            search->is_found = true;
            search->outlier = search->next;
            search->min_residual_ft = without.residual_ft;
        }
        search->next++;
        return true;
    }
    if (search->is_found)
        (void)fit_without_gate(gates, count, search->outlier, position_error_ft, fit);
    return false;
}

enum mr_status mr_gates_latest_motion(const struct mr_gate *gates, size_t count,
                                      double position_error_ft, struct mr_motion_estimate *motion)
{
    struct mr_gates_fit fit;
    size_t used = count < MR_GATES_ONLINE_MAX ? count : MR_GATES_ONLINE_MAX;
    if (used < 2)
        return MR_TOO_FEW;
    enum mr_status status = mr_gates_fit(gates + (count - used), used, used > 2 ? 2 : 1,
                                         position_error_ft, &fit);
    struct mr_gates_search search = {0};
    if (status == MR_OK && used == MR_GATES_ONLINE_MAX && !is_parabola(&fit, position_error_ft)) {
        while (test_next_outlier(gates + (count - used), used, position_error_ft, &fit, &search)) {
        }
    }
    if (status == MR_OK)
        mr_gates_motion_at_time(&fit, gates[count - 1].t_s, motion);
    return status;
}

/* Bisects for the time when the position of the fit, or its speed if `speed` is true, crosses
 * `target`, rising if `sign` is 1, falling if it is -1. 60 halvings reach double precision. */
static bool find_crossing(const struct mr_gates_fit *fit, bool speed, double sign, double target,
                          double low_s, double high_s, double *t_s)
{
    for (int i = 0; i < 60; i++) {
        struct basis basis;
        double mid_s = 0.5 * (low_s + high_s);
        compute_basis(fit, mid_s, &basis);
        double excess = sign *
                        (fit_value(fit, speed ? basis.first_derivative : basis.value) - target);
        if (i == 0) {
            struct basis low, high;
            compute_basis(fit, low_s, &low);
            compute_basis(fit, high_s, &high);
            if (sign * (fit_value(fit, speed ? low.first_derivative : low.value) - target) > 0.0 ||
                sign * (fit_value(fit, speed ? high.first_derivative : high.value) - target) < 0.0)
                return false;
        }
        if (excess < 0.0)
            low_s = mid_s;
        else
            high_s = mid_s;
    }
    *t_s = 0.5 * (low_s + high_s);
    return true;
}

enum mr_status mr_gates_motion_at_station(const struct mr_gates_fit *fit, double station_ft,
                                          bool beyond_last, struct mr_motion_estimate *motion)
{
    double first_s = fit->mid_time_s - fit->half_span_s,
           last_s = fit->mid_time_s + fit->half_span_s;
    double margin_s = 3.0 * fit->half_span_s / (double)(fit->count - 1), t_s;
    struct basis basis;
    double gradient[TERM_COUNT];
    if (!find_crossing(fit, false, 1.0, station_ft, first_s - (beyond_last ? 0.0 : margin_s),
                       last_s + (beyond_last ? margin_s : 0.0), &t_s))
        return MR_NUMERICS;
    mr_gates_motion_at_time(fit, t_s, motion);
    /* Convert the uncertainty of the position at a time to that of the time at a station: dt/dc =
     * -T/v, so dv/dc = T' + a_dec T/v. */
    compute_basis(fit, t_s, &basis);
    double speed_ft_s = motion->speed_ft_s.value;
    for (unsigned k = 0; k <= fit->degree; k++)
        gradient[k] = basis.first_derivative[k] -
                      fit_value(fit, basis.second_derivative) * basis.value[k] / speed_ft_s;
    motion->speed_ft_s.error = compute_standard_error(fit, gradient);
    return MR_OK;
}

/* Extrapolates a fit beyond its last gate to time and station of rest. */
static bool extrapolate_stop(const struct mr_gates_fit *fit, struct mr_estimate *t_s,
                             struct mr_estimate *station_ft)
{
    struct mr_motion_estimate last, stop;
    double last_s = fit->mid_time_s + fit->half_span_s;
    double stop_s;

    mr_gates_motion_at_time(fit, last_s, &last);
    if (!(last.deceleration_ft_s2.value > 0.0) || !(last.speed_ft_s.value > 0.0))
        return false;
    double horizon_s = 4.0 * last.speed_ft_s.value / last.deceleration_ft_s2.value;
    if (!find_crossing(fit, true, -1.0, 0.0, last_s, last_s + horizon_s, &stop_s))
        return false;
    mr_gates_motion_at_time(fit, stop_s, &stop);
    if (!(stop.deceleration_ft_s2.value > 0.0))
        return false;
    *t_s = (struct mr_estimate){stop_s, stop.speed_ft_s.error / stop.deceleration_ft_s2.value};
    *station_ft = stop.position_ft;
    return true;
}

/* Steps of the braking fit, defined below. */
static enum mr_status begin_braking(const struct mr_gate *gates, size_t count, double touchdown_ft,
                                    uint32_t left_out, struct mr_braking *fit);
static enum mr_status begin_late_brake(const struct mr_gate *gates, size_t count, size_t on_track,
                                       struct mr_braking *fit);
static enum mr_status begin_without_worst_gate(const struct mr_gate *gates, size_t count,
                                               double position_error_ft, struct mr_braking *fit);
static bool iterate_fit(const struct mr_gate *gates, size_t count, double position_error_ft,
                        struct mr_braking *fit, enum mr_status *status);

static void mark_outliers(const struct mr_braking *fit, const struct mr_gate *gates, size_t count,
                          struct mr_gates_summary *summary)
{
    for (size_t g = 0; g < count; g++) {
        if (!(fit->excluded_mask & ~summary->outlier_mask & 1u << g))
            continue;
        summary->outlier_mask |= 1u << g;
        summary->lateness_s[g] = mr_gate_lateness_s(fit, &gates[g]);
    }
}

/* Finds the touchdown if constant braking fits no range of gates. */
static enum mr_status find_touchdown(const struct mr_gate *gates, size_t count, size_t on_track,
                                     double touchdown_ft, double position_error_ft,
                                     struct mr_gates_summary *summary)
{
    struct mr_gates_fit fit;
    struct mr_motion_estimate touchdown;
    enum mr_status status;

    if (on_track >= 2) {
        status = mr_gates_fit(gates, on_track, 1, position_error_ft, &fit);
    } else {
        size_t used = count - on_track < MR_GATES_END_MAX ? count - on_track : MR_GATES_END_MAX;
        status = mr_gates_fit_best(gates + on_track, used, position_error_ft, &fit);
    }
    if (status == MR_OK)
        status = mr_gates_motion_at_station(&fit, touchdown_ft, on_track >= 2, &touchdown);
    if (status != MR_OK)
        return status;
    summary->touchdown_speed_ft_s = touchdown.speed_ft_s;
    summary->touchdown_t_s = (struct mr_estimate){touchdown.t_s, touchdown.position_ft.error /
                                                                     touchdown.speed_ft_s.value};
    double braked_ft_s2 = touchdown.deceleration_ft_s2.value;
    if (on_track < 2 && braked_ft_s2 > 0.0) {
        /* the polynomial brakes from touchdown on, the gear only after the brake's delay */
        summary->touchdown_speed_ft_s.value -= braked_ft_s2 * MR_BRAKE_DELAY_S;
        summary->touchdown_speed_ft_s.error =
            add_in_quadrature(touchdown.speed_ft_s.error, braked_ft_s2 * MR_BRAKE_DELAY_ERROR_S);
    }
    return MR_OK;
}

/* Increases the errors by the residuals, because braking was not quite constant. */
static void widen_errors(const struct mr_braking *fit, struct mr_gates_summary *summary)
{
    double factor = sqrt(fit->chi_square / (double)fit->degrees_of_freedom) *
                    mr_gates_student_factor(fit->degrees_of_freedom);
    struct mr_estimate *const estimate[] = {&summary->touchdown_speed_ft_s, &summary->touchdown_t_s,
                                            &summary->stop_t_s, &summary->stop_station_ft,
                                            &summary->mean_deceleration_ft_s2};
    for (size_t i = 0; i < sizeof estimate / sizeof estimate[0]; i++)
        estimate[i]->error *= factor;
}

static void compute_mean_deceleration(struct mr_gates_summary *summary)
{
    double speed_ft_s = summary->touchdown_speed_ft_s.value;
    double duration_s = summary->stop_t_s.value - summary->touchdown_t_s.value;
    double time_error_s = add_in_quadrature(summary->stop_t_s.error, summary->touchdown_t_s.error);
    double relative = add_in_quadrature(summary->touchdown_speed_ft_s.error / speed_ft_s,
                                        time_error_s / duration_s);
    summary->mean_deceleration_ft_s2.value = speed_ft_s / duration_s;
    summary->mean_deceleration_ft_s2.error = summary->mean_deceleration_ft_s2.value * relative;
}

void mr_final_fit_start(struct mr_final_fit *work, const struct mr_gate *gates, size_t count,
                        double touchdown_ft, double position_error_ft)
{
    memset(work, 0, sizeof *work);
    work->gates = gates;
    work->gate_count = count;
    work->touchdown_ft = touchdown_ft;
    work->position_error_ft = position_error_ft;
    while (work->gates_on_track < count && gates[work->gates_on_track].station_ft < touchdown_ft)
        work->gates_on_track++;
    work->used = count - work->gates_on_track;
    work->summary.gate_count = (unsigned)count;
    work->summary.gates_before_touchdown = (unsigned)work->gates_on_track;
    if (count < 3 || work->used == 0)
        work->status = MR_TOO_FEW;
    for (size_t i = 1; i < count; i++) {
        if (!(gates[i].t_s > gates[i - 1].t_s))
            work->status = MR_MALFORMED;
    }
    if (work->status != MR_OK)
        work->stage = MR_FINAL_DONE;
}

static void finish_fit(struct mr_final_fit *work, enum mr_status status)
{
    work->status = status;
    work->stage = MR_FINAL_DONE;
}

/* One step of fitting constant braking to the gates on the track (before touchdown) and the next
 * `used` gates. MR_OK: it fits. MR_TOO_FEW: call again; later attempts assume a late brake or leave
 * out the worst gate. MR_LIMIT: braking is not constant. */
static enum mr_status fit_uniform_braking(struct mr_final_fit *work)
{
    const struct mr_gate *gates = work->gates;
    size_t count = work->gates_on_track + work->used;
    struct mr_braking *fit = &work->braking;
    enum mr_final_attempt attempt = work->attempt;
    bool late = attempt == MR_FINAL_LATE_BRAKE;
    enum mr_status status;
    if (!work->is_fit_in_progress) {
        status = late ? begin_late_brake(gates, count, work->gates_on_track, fit)
               : attempt == MR_FINAL_WITHOUT_WORST_GATE
                   ? begin_without_worst_gate(gates, count, work->position_error_ft, fit)
                   : begin_braking(gates, count, work->touchdown_ft, 0, fit);
        work->is_fit_in_progress = status == MR_OK;
        /* accept the fit of the first attempt */
        if (late && !work->is_fit_in_progress && mr_braking_is_accepted(fit))
            return MR_OK;
        if (late && !work->is_fit_in_progress)
            work->attempt = MR_FINAL_WITHOUT_WORST_GATE;
        return work->is_fit_in_progress || late ? MR_TOO_FEW : MR_LIMIT;
    }
    if (iterate_fit(gates, count, work->position_error_ft, fit, &status))
        return MR_TOO_FEW;
    work->is_fit_in_progress = false;
    if (status != MR_OK && !late)
        return MR_LIMIT;
    bool holds = status == MR_OK && mr_braking_is_accepted(fit);
    bool perhaps_late = attempt == MR_FINAL_PROMPT_BRAKE && work->gates_on_track >= 2 &&
                        (!holds || fit->delay_s > MR_BRAKE_DELAY_S + 2.0 * MR_BRAKE_DELAY_ERROR_S);
    if (holds && !perhaps_late)
        return MR_OK;
    work->attempt = perhaps_late ? MR_FINAL_LATE_BRAKE
                  : late         ? MR_FINAL_REFIT
                                 : MR_FINAL_WITHOUT_WORST_GATE;
    return MR_TOO_FEW;
}

/* Fits all gates. With fewer than four gates beyond touchdown there is only one fit, which is
 * accepted even if it is poor. */
static void fit_all_gates(struct mr_final_fit *work)
{
    struct mr_gates_summary *summary = &work->summary;
    enum mr_status status = fit_uniform_braking(work);
    if (status == MR_TOO_FEW)
        return;
    if (status == MR_OK) {
        summary->is_uniform = true;
        mark_outliers(&work->braking, work->gates, work->gate_count, summary);
        summary->gates_used_for_stop = work->braking.degrees_of_freedom + 3;
        finish_fit(work, mr_braking_summarise(&work->braking, summary));
    } else if (work->used < 4) {
        status = mr_braking_fit(work->gates, work->gate_count, work->touchdown_ft,
                                work->position_error_ft, 0, &work->braking);
        summary->gates_used_for_stop = (unsigned)work->gate_count;
        if (status == MR_OK)
            status = mr_braking_summarise(&work->braking, summary);
        if (status == MR_OK && !mr_braking_is_accepted(&work->braking))
            widen_errors(&work->braking, summary);
        finish_fit(work, status);
    } else {
        work->stage = MR_FINAL_TOUCHDOWN;
        work->attempt = MR_FINAL_PROMPT_BRAKE;
        if (work->used > MR_GATES_END_MAX)
            work->used = MR_GATES_END_MAX;
    }
}

static void fit_touchdown(struct mr_final_fit *work)
{
    enum mr_status status = fit_uniform_braking(work);
    if (status == MR_TOO_FEW)
        return;
    if (status == MR_LIMIT && work->used > 3) {
        work->attempt = MR_FINAL_PROMPT_BRAKE;
        work->used -= work->used > 5 ? 3 : 1;
        return;
    }
    if (status == MR_OK) {
        mark_outliers(&work->braking, work->gates, work->gates_on_track + work->used,
                      &work->summary);
        status = mr_braking_summarise(&work->braking, &work->summary);
    } else {
        status = find_touchdown(work->gates, work->gate_count, work->gates_on_track,
                                work->touchdown_ft, work->position_error_ft, &work->summary);
    }
    work->stage = MR_FINAL_LAST_GATES;
    if (status != MR_OK)
        finish_fit(work, status);
}

static const struct mr_gate *get_last_gates(const struct mr_final_fit *work)
{
    return work->gates + (work->gate_count - work->end_fit.used);
}

/* Fits a parabola to the last gates, and in each further attempt to fewer gates, until it fits. */
static void fit_last_gates(struct mr_final_fit *work, bool fewer)
{
    struct mr_gates_fit *fit = &work->end_fit.fit;
    for (;;) {
        enum mr_status status = mr_gates_fit(get_last_gates(work), work->end_fit.used, 2,
                                             work->position_error_ft, fit);
        if (status != MR_OK) {
            finish_fit(work, status);
            return;
        }
        bool holds = is_parabola(fit, work->position_error_ft);
        if (!holds && work->end_fit.used > 5 && !fewer) {
            work->stage = MR_FINAL_FIND_OUTLIER;
            return;
        }
        if (holds || work->end_fit.used <= 4)
            break;
        work->end_fit.used--;
    }
    work->stage = MR_FINAL_STOP;
}

static void fit_end_gates(struct mr_final_fit *work)
{
    size_t count = work->gate_count - work->gates_on_track;
    memset(&work->end_fit, 0, sizeof work->end_fit);
    work->end_fit.used = count < MR_GATES_END_MAX ? count : MR_GATES_END_MAX;
    fit_last_gates(work, false);
}

/* Looks for a single gate without which the last gates lie on a parabola. */
static void find_outlier_gate(struct mr_final_fit *work)
{
    const struct mr_gate *gates = get_last_gates(work);
    struct mr_gates_search *search = &work->end_fit.search;
    if (test_next_outlier(gates, work->end_fit.used, work->position_error_ft, &work->end_fit.fit,
                          search))
        return;
    if (!search->is_found) {
        work->end_fit.used--;
        fit_last_gates(work, true);
        return;
    }
    struct mr_motion_estimate there;
    const struct mr_gate *outlier = &gates[search->outlier];
    mr_gates_motion_at_time(&work->end_fit.fit, outlier->t_s, &there);
    work->summary.outlier_mask |= 1u << (outlier - work->gates);
    work->summary.lateness_s[outlier - work->gates] =
        (there.position_ft.value - outlier->station_ft) / there.speed_ft_s.value;
    work->end_fit.used--;
    work->stage = MR_FINAL_STOP;
}

static enum mr_status find_stop(const struct mr_final_fit *work, struct mr_gates_summary *summary)
{
    struct mr_gates_fit cubic;
    struct mr_estimate cubic_s, cubic_ft;
    size_t count = work->gate_count - work->gates_on_track;
    if (!extrapolate_stop(&work->end_fit.fit, &summary->stop_t_s, &summary->stop_station_ft))
        return MR_NUMERICS;
    summary->gates_used_for_stop = (unsigned)work->end_fit.used;
    /* If the braking changes before the last gate, it may change after it too. A cubic through the
     * last gates represents this; its difference from the parabola adds to the error. */
    if (work->end_fit.used < MR_GATES_END_MAX && count > MR_GATES_ONLINE_MAX &&
        mr_gates_fit(work->gates + (work->gate_count - MR_GATES_ONLINE_MAX), MR_GATES_ONLINE_MAX, 3,
                     work->position_error_ft, &cubic) == MR_OK &&
        extrapolate_stop(&cubic, &cubic_s, &cubic_ft)) {
        summary->stop_t_s.error = add_in_quadrature(summary->stop_t_s.error,
                                                    cubic_s.value - summary->stop_t_s.value);
        summary->stop_station_ft.error = add_in_quadrature(
            summary->stop_station_ft.error, cubic_ft.value - summary->stop_station_ft.value);
    }
    compute_mean_deceleration(summary);
    return MR_OK;
}

bool mr_final_fit_step(struct mr_final_fit *work)
{
    switch (work->stage) {
    case MR_FINAL_ALL_GATES: fit_all_gates(work); break;
    case MR_FINAL_TOUCHDOWN: fit_touchdown(work); break;
    case MR_FINAL_LAST_GATES: fit_end_gates(work); break;
    case MR_FINAL_FIND_OUTLIER: find_outlier_gate(work); break;
    case MR_FINAL_STOP: finish_fit(work, find_stop(work, &work->summary)); break;
    case MR_FINAL_DONE: break;
    }
    return work->stage != MR_FINAL_DONE;
}

enum mr_status mr_gates_summarise(const struct mr_gate *gates, size_t count, double touchdown_ft,
                                  double position_error_ft, struct mr_gates_summary *summary)
{
    struct mr_final_fit work;
    mr_final_fit_start(&work, gates, count, touchdown_ft, position_error_ft);
    while (mr_final_fit_step(&work)) {
    }
    *summary = work.summary;
    return work.status;
}

/* ---- braking ---- */

#define UNKNOWNS MR_BRAKING_UNKNOWN_COUNT
_Static_assert((int)UNKNOWNS == (int)TERM_COUNT, "both fits share factor, solve and invert");
#define ITERATIONS_MAX 10
/* smallest delay in the iteration, which may pass through negative values */
#define DELAY_MIN_S    (-0.5)
#define DELAY_MAX_S    0.5
#define ONSET_MAX_S    1.0 /* latest onset of a late brake */
#define LATE_GATES     4u  /* number of last gates needed to estimate the onset */
/* largest error of the preliminary motion for which a late brake is fitted */
#define LATE_MISFIT_FT 0.25

/* Station and speed at a time, and the derivatives of the station with respect to the unknowns. */
struct motion {
    double station_ft;
    double speed_ft_s;
    double gradient[UNKNOWNS];
};

/* Distance lost to braking per unit of deceleration, and its derivatives with respect to time and
 * delay. The shape is ignored during the rise of the deceleration, where it would matter only for a
 * switch close to touchdown. */
static void compute_distance_loss(double since_s, double delay_s, double shape, double *value,
                                  double *rate, double *by_delay)
{
    double rise_s = 2.0 * delay_s;
    if (since_s < rise_s) { /* during the rise: twice the integral of 3 u^2 - 2 u^3 */
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

static void compute_motion(const struct mr_braking *fit, double t_s, struct motion *motion)
{
    double since_s = t_s - fit->touchdown_s, braked_s = since_s - fit->onset_s;
    double lost = 0.0, rate = 0.0, by_delay = 0.0;
    if (braked_s > 0.0)
        compute_distance_loss(braked_s, fit->delay_s, fit->shape, &lost, &rate, &by_delay);
    motion->station_ft = fit->touchdown_ft + fit->speed_ft_s * since_s -
                         fit->deceleration_ft_s2 * lost;
    motion->speed_ft_s = fit->speed_ft_s - fit->deceleration_ft_s2 * rate;
    motion->gradient[MR_BRAKING_TIME] = -motion->speed_ft_s;
    motion->gradient[MR_BRAKING_SPEED] = since_s;
    motion->gradient[MR_BRAKING_DECELERATION] = -lost;
    motion->gradient[MR_BRAKING_DELAY] = fit->deceleration_ft_s2 *
                                         (fit->is_brake_late ? rate : -by_delay);
    motion->gradient[MR_BRAKING_SHAPE] =
        braked_s > 2.0 * fit->delay_s ? -0.5 * fit->deceleration_ft_s2 * fit->delay_s * fit->delay_s
                                      : 0.0;
}

static double get_braking_error(const struct mr_braking *fit, const double *gradient)
{
    return sqrt(get_variance(fit->covariance, UNKNOWNS, gradient));
}

static bool is_gate_used(const struct mr_braking *fit, size_t gate)
{
    return !(fit->excluded_mask & 1u << gate);
}

/* Sets start values from which the fit converges: a parabola through at least three gates; speed
 * and touchdown from the gates on the track if there are two. */
static enum mr_status set_start_values(const struct mr_gate *gates, size_t count,
                                       struct mr_braking *fit)
{
    struct mr_gate used[MR_GATES_MAX];
    struct mr_gates_fit parabola;
    struct mr_motion_estimate there;
    size_t total = 0, on_track = 0;
    for (size_t g = 0; g < count; g++) {
        if (!is_gate_used(fit, g))
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
    mr_gates_motion_at_time(&parabola, parabola.mid_time_s, &there);
    fit->deceleration_ft_s2 = there.deceleration_ft_s2.value;
    if (on_track >= 2) {
        const struct mr_gate *first = &used[0], *second = &used[on_track - 1];
        fit->speed_ft_s = (second->station_ft - first->station_ft) / (second->t_s - first->t_s);
        fit->touchdown_s = first->t_s + (fit->touchdown_ft - first->station_ft) / fit->speed_ft_s;
    } else { /* extrapolate back from the first gate after touchdown */
        mr_gates_motion_at_time(&parabola, used[skip].t_s, &there);
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
    fit->degrees_of_freedom = (unsigned)total - 3;
    return fit->speed_ft_s > 0.0 && fit->deceleration_ft_s2 > 0.0 ? MR_OK : MR_NUMERICS;
}

/* Adds the prior value of an unknown to the equations, as if it were measured. */
static void add_prior(double value, double error, double now, unsigned unknown,
                      struct mr_braking *fit, double matrix[UNKNOWNS][UNKNOWNS],
                      double right[UNKNOWNS])
{
    double off = (value - now) / error;
    matrix[unknown][unknown] = 1.0 / (error * error);
    right[unknown] = off / error;
    fit->chi_square += off * off;
}

/* Normal equations at the present values, in units of the position error. */
static void set_equations(const struct mr_gate *gates, size_t count, double position_error_ft,
                          struct mr_braking *fit, double matrix[UNKNOWNS][UNKNOWNS],
                          double right[UNKNOWNS])
{
    double weight = 1.0 / position_error_ft;
    memset(matrix, 0, UNKNOWNS * sizeof matrix[0]);
    memset(right, 0, UNKNOWNS * sizeof right[0]);
    fit->chi_square = 0.0;
    if (!fit->is_brake_late)
        add_prior(MR_BRAKE_DELAY_S, MR_BRAKE_DELAY_ERROR_S, fit->delay_s, MR_BRAKING_DELAY, fit,
                  matrix, right);
    add_prior(MR_BRAKE_SHAPE, MR_BRAKE_SHAPE_ERROR, fit->shape, MR_BRAKING_SHAPE, fit, matrix,
              right);
    for (size_t g = 0; g < count; g++) {
        struct motion motion;
        if (!is_gate_used(fit, g))
            continue;
        compute_motion(fit, gates[g].t_s, &motion);
        double residual = (gates[g].station_ft - motion.station_ft) * weight;
        fit->chi_square += residual * residual;
        for (unsigned i = 0; i < UNKNOWNS; i++) {
            motion.gradient[i] *= weight;
            right[i] += motion.gradient[i] * residual;
            for (unsigned k = 0; k <= i; k++)
                matrix[i][k] += motion.gradient[i] * motion.gradient[k];
        }
    }
}

static double clamp(double value, double least, double most)
{
    return value < least ? least : value > most ? most : value;
}

static enum mr_status begin_braking(const struct mr_gate *gates, size_t count, double touchdown_ft,
                                    uint32_t left_out, struct mr_braking *fit)
{
    memset(fit, 0, sizeof *fit);
    fit->touchdown_ft = touchdown_ft;
    fit->excluded_mask = left_out;
    return set_start_values(gates, count, fit);
}

/* Sets the start values for a late brake: the speed of the gates on the track, and the time at
 * which a parabola through the last gates has this speed. MR_LIMIT: at that time the gear was
 * elsewhere; `fit` is unchanged. */
static enum mr_status begin_late_brake(const struct mr_gate *gates, size_t count, size_t on_track,
                                       struct mr_braking *fit)
{
    size_t last = count - on_track < MR_GATES_END_MAX ? count - on_track : MR_GATES_END_MAX;
    struct mr_gates_fit parabola;
    struct mr_motion_estimate end, onset;
    struct mr_braking late;
    if (last < LATE_GATES || mr_gates_fit(gates + count - last, last, 2, 1.0, &parabola) != MR_OK ||
        begin_braking(gates, count, fit->touchdown_ft, 0, &late) != MR_OK)
        return MR_LIMIT;
    mr_gates_motion_at_time(&parabola, gates[count - 1].t_s, &end);
    late.deceleration_ft_s2 = end.deceleration_ft_s2.value;
    double onset_s = gates[count - 1].t_s -
                     (late.speed_ft_s - end.speed_ft_s.value) / late.deceleration_ft_s2;
    mr_gates_motion_at_time(&parabola, onset_s, &onset);
    double rolled_ft = late.speed_ft_s * (onset_s - late.touchdown_s);
    late.is_brake_late = true;
    late.degrees_of_freedom--;
    late.onset_s = onset_s - late.touchdown_s - late.delay_s;
    if (!(late.deceleration_ft_s2 > 0.0) || !(late.onset_s > 0.0) || late.onset_s > ONSET_MAX_S ||
        fabs(onset.position_ft.value - late.touchdown_ft - rolled_ft) > LATE_MISFIT_FT)
        return MR_LIMIT;
    *fit = late;
    return MR_OK;
}

/* Computes one iteration, or the covariance after the last one. False: the fit has ended. */
static bool iterate_fit(const struct mr_gate *gates, size_t count, double position_error_ft,
                        struct mr_braking *fit, enum mr_status *status)
{
    double matrix[UNKNOWNS][UNKNOWNS], step[UNKNOWNS];
    set_equations(gates, count, position_error_ft, fit, matrix, step);
    *status = factor_cholesky(matrix, UNKNOWNS) ? MR_OK : MR_NUMERICS;
    if (*status != MR_OK)
        return false;
    /* without convergence the fit ends after ITERATIONS_MAX; chi-square then shows the misfit */
    if (fit->is_converged || fit->iterations == ITERATIONS_MAX) {
        invert_factored(matrix, UNKNOWNS, 1.0, fit->covariance);
        return false;
    }
    fit->iterations++;
    solve_factored(matrix, UNKNOWNS, step);
    fit->touchdown_s += step[MR_BRAKING_TIME];
    fit->speed_ft_s += step[MR_BRAKING_SPEED];
    fit->deceleration_ft_s2 += step[MR_BRAKING_DECELERATION];
    double *delay_s = fit->is_brake_late ? &fit->onset_s : &fit->delay_s;
    *delay_s = clamp(*delay_s + step[MR_BRAKING_DELAY], fit->is_brake_late ? 0.0 : DELAY_MIN_S,
                     fit->is_brake_late ? ONSET_MAX_S : DELAY_MAX_S);
    fit->shape = clamp(fit->shape + step[MR_BRAKING_SHAPE], 0.0, 1.0);
    if (!(fit->speed_ft_s > 0.0) || !(fit->deceleration_ft_s2 > 0.0))
        *status = MR_NUMERICS;
    /* Converged if no result moved by more than a hundredth of its smallest possible error. */
    fit->is_converged = fabs(step[MR_BRAKING_SPEED]) < 2e-6 * fit->speed_ft_s &&
                        fabs(step[MR_BRAKING_DECELERATION]) < 1e-5 * fit->deceleration_ft_s2 &&
                        fabs(step[MR_BRAKING_TIME]) * fit->speed_ft_s < 1e-2 * position_error_ft;
    return *status == MR_OK;
}

enum mr_status mr_braking_fit(const struct mr_gate *gates, size_t count, double touchdown_ft,
                              double position_error_ft, uint32_t left_out, struct mr_braking *fit)
{
    enum mr_status status = begin_braking(gates, count, touchdown_ft, left_out, fit);
    while (status == MR_OK && iterate_fit(gates, count, position_error_ft, fit, &status)) {
    }
    return status;
}

double mr_chi_square_limit(unsigned freedom, double deviations)
{
    double k = (double)freedom, part = 2.0 / (9.0 * k);
    double root = 1.0 - part + deviations * sqrt(part);
    return freedom ? k * root * root * root : 0.0;
}

bool mr_braking_is_accepted(const struct mr_braking *fit)
{
    return fit->degrees_of_freedom == 0 ||
           fit->chi_square <= mr_chi_square_limit(fit->degrees_of_freedom, MR_SIGMA_1_IN_1000);
}

/* Finds the gate whose removal lowers chi-square most (exact for a linear model). */
static double find_worst_gate(const struct mr_braking *fit, const struct mr_gate *gates,
                              size_t count, double position_error_ft, size_t *worst)
{
    double most = 0.0;
    for (size_t g = 0; g < count; g++) {
        struct motion motion;
        if (!is_gate_used(fit, g))
            continue;
        compute_motion(fit, gates[g].t_s, &motion);
        double residual = (gates[g].station_ft - motion.station_ft) / position_error_ft;
        double own = 1.0 - get_variance(fit->covariance, UNKNOWNS, motion.gradient) /
                               (position_error_ft * position_error_ft);
        if (own > 1e-6 && residual * residual / own > most) {
            most = residual * residual / own;
            *worst = g;
        }
    }
    return most;
}

static enum mr_status begin_without_worst_gate(const struct mr_gate *gates, size_t count,
                                               double position_error_ft, struct mr_braking *fit)
{
    size_t worst = 0, out = 0;
    for (size_t g = 0; g < count; g++)
        out += !is_gate_used(fit, g);
    if (out > count / 5 || fit->degrees_of_freedom < 2 ||
        find_worst_gate(fit, gates, count, position_error_ft, &worst) <
            MR_GATE_OUTLIER_SIGMA * MR_GATE_OUTLIER_SIGMA)
        return MR_LIMIT;
    return begin_braking(gates, count, fit->touchdown_ft, fit->excluded_mask | 1u << worst, fit);
}

enum mr_status mr_braking_drop_worst_gate(const struct mr_gate *gates, size_t count,
                                          double position_error_ft, struct mr_braking *fit)
{
    enum mr_status status = begin_without_worst_gate(gates, count, position_error_ft, fit);
    while (status == MR_OK && iterate_fit(gates, count, position_error_ft, fit, &status)) {
    }
    return status;
}

double mr_gate_lateness_s(const struct mr_braking *fit, const struct mr_gate *gate)
{
    struct motion motion;
    compute_motion(fit, gate->t_s, &motion);
    return motion.speed_ft_s > 0.0 ? (motion.station_ft - gate->station_ft) / motion.speed_ft_s
                                   : 0.0;
}

enum mr_status mr_braking_summarise(const struct mr_braking *fit, struct mr_gates_summary *summary)
{
    double v = fit->speed_ft_s, a = fit->deceleration_ft_s2, d = fit->delay_s;
    double onset_s = fit->onset_s, after_s = onset_s + d + v / a; /* time from touchdown to rest */
    if (v / a < d)
        return MR_NUMERICS;
    double k = fit->shape;
    const double of_speed[UNKNOWNS] = {[MR_BRAKING_SPEED] = 1.0};
    const double of_touchdown[UNKNOWNS] = {[MR_BRAKING_TIME] = 1.0};
    const double of_stop[UNKNOWNS] = {1.0, 1.0 / a, -v / (a * a), 1.0, 0.0};
    const double of_station[UNKNOWNS] = {0.0, after_s, -0.5 * v * v / (a * a) - 0.5 * k * d * d,
                                         fit->is_brake_late ? v : v - k * a * d, -0.5 * a * d * d};
    const double of_mean[UNKNOWNS] = {0.0, 1.0 / after_s - v / (a * after_s * after_s),
                                      v * v / (a * a * after_s * after_s), -v / (after_s * after_s),
                                      0.0};
    summary->touchdown_speed_ft_s = (struct mr_estimate){v, get_braking_error(fit, of_speed)};
    summary->touchdown_t_s = (struct mr_estimate){fit->touchdown_s,
                                                  get_braking_error(fit, of_touchdown)};
    summary->stop_t_s = (struct mr_estimate){fit->touchdown_s + after_s,
                                             get_braking_error(fit, of_stop)};
    summary->stop_station_ft = (struct mr_estimate){fit->touchdown_ft + v * (onset_s + d) +
                                                        0.5 * v * v / a - 0.5 * k * a * d * d,
                                                    get_braking_error(fit, of_station)};
    summary->mean_deceleration_ft_s2 = (struct mr_estimate){v / after_s,
                                                            get_braking_error(fit, of_mean)};
    return MR_OK;
}
