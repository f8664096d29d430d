#include "host/analyse/track.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/gates.h"
#include "host/base/statistics.h"
#include "host/base/xmalloc.h"

#define PARABOLA_TERMS 3u
#define MIN_HALF_POWER (-16)
#define MAX_HALF_POWER 6

/* The station and its derivatives by time. */
enum { TRACK_STATION, TRACK_SPEED, TRACK_ACCELERATION, TRACK_QUANTITY_COUNT };

/* Returns the covariance of the station at two times since the first gate, for q = 1: the integral
 * over u of (s - u)^2 (t - u)^2 / 4. */
static double compute_covariance(double a_s, double b_s)
{
    double s = fmin(a_s, b_s), d = fabs(a_s - b_s);
    return s <= 0.0 ? 0.0 : s * s * s * (s * s / 20.0 + d * s / 8.0 + d * d / 12.0);
}

/* The terms of the parabola and their derivatives by time. */
static double compute_parabola_term(int quantity, double t_s, size_t n)
{
    const double term[TRACK_QUANTITY_COUNT][PARABOLA_TERMS] = {
        {1.0, t_s, t_s * t_s}, {0.0, 1.0, 2.0 * t_s}, {0.0, 0.0, 2.0}};
    return term[quantity][n];
}

/* Fills the matrix of universal kriging: the covariances, with the terms of the parabola as
 * additional rows and columns. */
static size_t fill_kriging_matrix(const struct track *track, const struct track_model *model,
                                  double system[TRACK_MATRIX_SIZE][TRACK_MATRIX_SIZE])
{
    size_t n = track->gate_count;
    memset(system, 0, sizeof(double[TRACK_MATRIX_SIZE][TRACK_MATRIX_SIZE]));
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < n; k++)
            system[i][k] = model->intensity * compute_covariance(track->t_s[i], track->t_s[k]);
        system[i][i] += track->gate_error_ft * track->gate_error_ft +
                        model->ripple_deviation_ft * model->ripple_deviation_ft;
        for (size_t p = 0; p < PARABOLA_TERMS; p++)
            system[i][n + p] = system[n + p][i] = compute_parabola_term(TRACK_STATION,
                                                                        track->t_s[i], p);
    }
    return n + PARABOLA_TERMS;
}

static void swap_rows(double *a, double *b, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        double kept = a[i];
        a[i] = b[i];
        b[i] = kept;
    }
}

/* Inverts by Gauss-Jordan elimination with row pivots, and computes the logarithm of the absolute
 * determinant. Returns false if the matrix is singular. */
static bool invert_matrix(double a[TRACK_MATRIX_SIZE][TRACK_MATRIX_SIZE], size_t n,
                          double inverse[TRACK_MATRIX_SIZE][TRACK_MATRIX_SIZE],
                          double *log_determinant)
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

/* Returns minus twice the restricted log likelihood, up to a constant. S: covariances, X: terms of
 * the parabola, y: stations. The determinant of the whole matrix is |S| |X' S^-1 X|; the
 * generalised sum of squares is y' P y, where P is the upper left part of the inverse. */
static double compute_deviance(const struct track *track, struct track_model *model)
{
    double system[TRACK_MATRIX_SIZE][TRACK_MATRIX_SIZE], log_determinant, squares = 0.0;
    size_t size = fill_kriging_matrix(track, model, system);
    if (!invert_matrix(system, size, model->inverse, &log_determinant))
        return (double)INFINITY;
    for (size_t i = 0; i < track->gate_count; i++) {
        for (size_t k = 0; k < track->gate_count; k++)
            squares += track->station_ft[i] * model->inverse[i][k] * track->station_ft[k];
    }
    return log_determinant + squares;
}

/* Stores a model if it is among the most likely ones. `unlikely` has the deviance of each entry of
 * track->model. */
static void select_likeliest_models(struct track *track, const struct track_model *model,
                                    double unlikeliness_now, double unlikely[TRACK_MODELS_MAX])
{
    size_t place = track->model_count;
    if (place == TRACK_MODELS_MAX) {
        place = 0;
        for (size_t i = 1; i < TRACK_MODELS_MAX; i++)
            place = unlikely[i] > unlikely[place] ? i : place;
        if (unlikeliness_now >= unlikely[place])
            return;
    } else {
        track->model_count++;
    }
    track->model[place] = *model;
    unlikely[place] = unlikeliness_now;
}

/* Searches a grid of models: q in steps of half a power of ten, ripple from 0 to a large multiple
 * of the gates' error. */
static void select_models(struct track *track)
{
    static const double ripples[] = {0.0, 0.7, 1.4, 2.8, 5.6, 11.2};
    double unlikely[TRACK_MODELS_MAX], least = (double)INFINITY, sum = 0.0;
    for (int half = MIN_HALF_POWER; half <= MAX_HALF_POWER; half++) {
        for (size_t i = 0; i < sizeof ripples / sizeof ripples[0]; i++) {
            struct track_model model = {.intensity = pow(10.0, 0.5 * half),
                                        .ripple_deviation_ft = ripples[i] * track->gate_error_ft};
            double now = compute_deviance(track, &model);
            if (!isinf(now))
                select_likeliest_models(track, &model, now, unlikely);
        }
    }
    for (size_t m = 0; m < track->model_count; m++)
        least = fmin(least, unlikely[m]);
    for (size_t m = 0; m < track->model_count; m++)
        sum += track->model[m].weight = exp(-0.5 * (unlikely[m] - least));
    for (size_t m = 0; m < track->model_count; m++) {
        struct track_model *model = &track->model[m];
        model->weight /= sum;
        for (size_t i = 0; i < track->gate_count + PARABOLA_TERMS; i++) {
            model->factor_ft[i] = 0.0;
            for (size_t k = 0; k < track->gate_count; k++)
                model->factor_ft[i] += model->inverse[i][k] * track->station_ft[k];
        }
    }
}

/* Returns the covariance, for q = 1, of the station at a gate and a quantity at a time: the
 * integral over u, up to the earlier of the two, of (s - u)^2 / 2 times (t - u)^2 / 2 or its
 * derivative by t. */
static double compute_gate_covariance(int quantity, double gate_s, double t_s)
{
    double left_s = fmax(0.0, gate_s - t_s),
           cubes = gate_s * gate_s * gate_s - left_s * left_s * left_s;
    if (quantity == TRACK_STATION)
        return compute_covariance(gate_s, t_s);
    if (quantity == TRACK_ACCELERATION)
        return cubes / 6.0;
    double fourths = pow(gate_s, 4.0) - pow(left_s, 4.0);
    return fourths / 8.0 + (t_s - gate_s) * cubes / 6.0;
}

static double compute_prior_variance(int quantity, double t_s)
{
    return quantity == TRACK_STATION ? compute_covariance(t_s, t_s)
         : quantity == TRACK_SPEED   ? t_s * t_s * t_s / 3.0
                                     : t_s;
}

/* Covariances of a quantity at a time with the gates, and the terms of the parabola. */
static void compute_gate_covariances(const struct track *track, const struct track_model *model,
                                     int quantity, double since_s, double side[TRACK_MATRIX_SIZE])
{
    for (size_t i = 0; i < track->gate_count; i++)
        side[i] = model->intensity * compute_gate_covariance(quantity, track->t_s[i], since_s);
    for (size_t p = 0; p < PARABOLA_TERMS; p++)
        side[track->gate_count + p] = compute_parabola_term(quantity, since_s, p);
}

static double predict_variance(const struct track *track, const struct track_model *model,
                               int quantity, double since_s, const double *side)
{
    const size_t size = track->gate_count + PARABOLA_TERMS;
    double variance = model->intensity * compute_prior_variance(quantity, since_s);
    for (size_t i = 0; i < size; i++) {
        for (size_t k = 0; k < size; k++)
            variance -= side[i] * model->inverse[i][k] * side[k];
    }
    /* The ripple is real motion, which exists between gates too, so its variance is added. For the
     * speed, the ripple is assumed to be the fastest one that the gates resolve. The gates do not
     * show a ripple smaller than their error, so the error of a speed is at least that of the mean
     * speed between two gates. */
    double ripple = 0.0,
           spacing_s = track->t_s[track->gate_count - 1] / (double)(track->gate_count - 1);
    if (quantity == TRACK_STATION)
        ripple = model->ripple_deviation_ft;
    else if (quantity == TRACK_SPEED)
        ripple = hypot(M_PI * model->ripple_deviation_ft, sqrt(2.0) * track->gate_error_ft) /
                 spacing_s;
    return fmax(variance, 0.0) + ripple * ripple;
}

/* Sums over the models, each with its weight. */
struct model_sums {
    double mean, square, variance;
};

static void add_model(struct model_sums *sums, double weight, double value, double variance)
{
    sums->mean += weight * value;
    sums->square += weight * value * value;
    sums->variance += weight * variance;
}

/* Returns the standard error, from the variance within and between the models. */
static double compute_error(const struct model_sums *sums)
{
    return sqrt(sums->variance + fmax(sums->square - sums->mean * sums->mean, 0.0));
}

/* Predicts a quantity between the first and the last gate (without `with_error`: error 0). */
static struct mr_estimate predict_quantity(const struct track *track, int quantity, double t_s,
                                           bool with_error)
{
    const double since_s = t_s - track->first_gate.t_s,
                 reference = quantity == TRACK_STATION ? track->station_ft[0] : 0.0;
    struct model_sums sums = {0};
    double side[TRACK_MATRIX_SIZE];
    for (size_t m = 0; m < track->model_count; m++) {
        const struct track_model *model = &track->model[m];
        double value = -reference;
        compute_gate_covariances(track, model, quantity, since_s, side);
        for (size_t i = 0; i < track->gate_count + PARABOLA_TERMS; i++)
            value += model->factor_ft[i] * side[i];
        add_model(&sums, model->weight, value,
                  with_error ? predict_variance(track, model, quantity, since_s, side) : 0.0);
    }
    return (struct mr_estimate){reference + sums.mean, with_error ? compute_error(&sums) : 0.0};
}

static struct track_moment make_gate_moment(const struct track *track, double t_s)
{
    return (struct track_moment){t_s, predict_quantity(track, TRACK_STATION, t_s, true),
                                 predict_quantity(track, TRACK_SPEED, t_s, true)};
}

/* Returns the standard error due to the rise of the brake (common/gates.h: delay d, shape k), which
 * shifts the position by 0 to a d^2 (1 + k) / 2. */
static double compute_brake_error_ft(double deceleration_ft_s2)
{
    const double d = MR_BRAKE_DELAY_S, e = MR_BRAKE_DELAY_ERROR_S;
    return 0.5 * deceleration_ft_s2 * (1.0 + MR_BRAKE_SHAPE) *
           sqrt(4.0 * d * d * e * e + 2.0 * e * e * e * e);
}

static void set_end_moments(const struct measured_landing *measured, struct track *track)
{
    const struct mr_gates_summary *summary = &measured->summary;
    double error_ft = hypot(summary->touchdown_speed_ft_s.value * summary->touchdown_t_s.error,
                            compute_brake_error_ft(summary->mean_deceleration_ft_s2.value));
    track->start_s = fmin(measured->gate[0].t_s, 0.0);
    track->brake_error_ft_s = MR_BRAKE_DELAY_ERROR_S * summary->mean_deceleration_ft_s2.value;
    track->touchdown = (struct track_moment){
        0.0, {measured->landing.touchdown_ft, error_ft}, summary->touchdown_speed_ft_s};
    track->stop =
        (struct track_moment){summary->stop_t_s.value, summary->stop_station_ft, {0.0, 0.0}};
    if (!track->has_gates)
        return;
    track->first_gate = make_gate_moment(track, track->first_gate.t_s);
    track->last_gate = make_gate_moment(track, track->last_gate.t_s);
    /* just before the stop, from the time of the stop and from the braking at the last gate */
    struct mr_estimate braking_ft_s2 = track_compute_deceleration(track, track->last_gate.t_s);
    track->stopping_speed_error_ft_s =
        hypot(braking_ft_s2.value * summary->stop_t_s.error,
              braking_ft_s2.error * fmax(0.0, track->stop.t_s - track->last_gate.t_s));
    track->stop.t_s = fmax(track->stop.t_s, track->last_gate.t_s);
}

void track_make(const struct measured_landing *measured, struct track *track)
{
    const struct mr_gates_summary *summary = &measured->summary;
    memset(track, 0, sizeof *track);
    track->gate_error_ft = measured->landing.switch_error_ft;
    for (size_t g = 0; g < measured->gate_count; g++) {
        const struct mr_gate *gate = &measured->gate[g];
        if (gate->t_s <= 0.0 || summary->outlier_mask & 1u << g)
            continue;
        if (track->gate_count == 0)
            track->first_gate.t_s = gate->t_s;
        track->last_gate.t_s = gate->t_s;
        track->t_s[track->gate_count] = gate->t_s - track->first_gate.t_s;
        track->station_ft[track->gate_count++] = gate->station_ft;
    }
    if (track->gate_count >= PARABOLA_TERMS)
        select_models(track);
    track->has_gates = track->model_count > 0;
    set_end_moments(measured, track);
}

/* Interpolates station and speed with the cubic that has both at both ends, and the errors
 * linearly. */
static struct track_moment interpolate_cubic(const struct track_moment *from,
                                             const struct track_moment *to, double t_s)
{
    double span_s = to->t_s - from->t_s, x = (t_s - from->t_s) / span_s;
    double rise = to->station_ft.value - from->station_ft.value;
    double v0 = from->speed_ft_s.value * span_s, v1 = to->speed_ft_s.value * span_s;
    double square = 3.0 * rise - 2.0 * v0 - v1, cube = v0 + v1 - 2.0 * rise;
    return (struct track_moment){
        t_s,
        {from->station_ft.value + v0 * x + square * x * x + cube * x * x * x,
         from->station_ft.error + (to->station_ft.error - from->station_ft.error) * x},
        {(v0 + 2.0 * square * x + 3.0 * cube * x * x) / span_s,
         from->speed_ft_s.error + (to->speed_ft_s.error - from->speed_ft_s.error) * x}};
}

/* Station and speed at a time that is not between the first and the last gate. */
static struct track_moment extrapolate_moment(const struct track *track, double t_s)
{
    const struct track_moment *touchdown = &track->touchdown, *stop = &track->stop;
    const struct mr_estimate unknown = {(double)NAN, (double)NAN};
    if (t_s < track->start_s)
        return (struct track_moment){t_s, unknown, unknown};
    if (t_s < 0.0)
        return (struct track_moment){
            t_s,
            {touchdown->station_ft.value + touchdown->speed_ft_s.value * t_s,
             hypot(touchdown->station_ft.error, touchdown->speed_ft_s.error * t_s)},
            touchdown->speed_ft_s};
    if (t_s >= stop->t_s)
        return *stop;
    if (!track->has_gates) {
        struct track_moment coarse = interpolate_cubic(touchdown, stop, t_s);
        coarse.station_ft.error = coarse.speed_ft_s.error = (double)NAN;
        return coarse;
    }
    if (t_s < track->first_gate.t_s) {
        /* it is not known when the deceleration rises */
        struct track_moment rising = interpolate_cubic(touchdown, &track->first_gate, t_s);
        rising.speed_ft_s.error = hypot(rising.speed_ft_s.error, track->brake_error_ft_s);
        return rising;
    }
    struct track_moment stopping = *stop;
    stopping.speed_ft_s.error = track->stopping_speed_error_ft_s;
    return interpolate_cubic(&track->last_gate, &stopping, t_s);
}

static bool is_between_gates(const struct track *track, double t_s)
{
    return track->has_gates && t_s >= track->first_gate.t_s && t_s <= track->last_gate.t_s &&
           t_s < track->stop.t_s;
}

double track_station_ft(const struct track *track, double t_s)
{
    return is_between_gates(track, t_s) ? predict_quantity(track, TRACK_STATION, t_s, false).value
                                        : extrapolate_moment(track, t_s).station_ft.value;
}

struct mr_estimate track_compute_station(const struct track *track, double t_s)
{
    if (!track->has_gates)
        return (struct mr_estimate){(double)NAN, (double)NAN};
    return is_between_gates(track, t_s) ? predict_quantity(track, TRACK_STATION, t_s, true)
                                        : extrapolate_moment(track, t_s).station_ft;
}

struct mr_estimate track_compute_speed(const struct track *track, double t_s)
{
    return is_between_gates(track, t_s) ? predict_quantity(track, TRACK_SPEED, t_s, true)
                                        : extrapolate_moment(track, t_s).speed_ft_s;
}

struct mr_estimate track_compute_deceleration(const struct track *track, double t_s)
{
    if (!track->has_gates || t_s < track->first_gate.t_s || t_s > track->last_gate.t_s)
        return (struct mr_estimate){(double)NAN, (double)NAN};
    struct mr_estimate a = predict_quantity(track, TRACK_ACCELERATION, t_s, true);
    return (struct mr_estimate){-a.value, a.error};
}

struct mr_estimate track_compute_residual_ft(const struct track *track, size_t gate)
{
    struct model_sums sums = {0};
    for (size_t m = 0; m < track->model_count; m++) {
        /* predict_quantity the gate from the other gates, using the inverse of the matrix of all
         * gates (Dubrule 1983) */
        const struct track_model *model = &track->model[m];
        const double own = model->inverse[gate][gate];
        add_model(&sums, model->weight, model->factor_ft[gate] / own, 1.0 / own);
    }
    return (struct mr_estimate){sums.mean, compute_error(&sums)};
}

/* ---- the film ---- */

/* largest gap in periods, because damaged data may contain any time */
#define GAP_PERIODS_MAX       1e9
/* number of steps on each side that are included in the median; up to half of them may be gaps */
#define MEDIAN_STEPS_PER_SIDE 7u

/* Returns the median of the steps from `from` to `to`. Of two middle steps it takes the shorter
 * one, because the longer one may be a gap of several periods. */
static double find_median_step(const double *t_us, size_t from, size_t to)
{
    double step_us[2 * MEDIAN_STEPS_PER_SIDE + 1];
    size_t count = 0;
    for (size_t i = from; i < to; i++)
        step_us[count++] = t_us[i + 1] - t_us[i];
    sort_numbers(step_us, count);
    return step_us[(count - 1) / 2];
}

void film_compute_frame_numbers(const double *t_us, size_t count, int64_t *number)
{
    if (count)
        number[0] = 1;
    for (size_t i = 1; i < count; i++) {
        size_t from = i - 1 > MEDIAN_STEPS_PER_SIDE ? i - 1 - MEDIAN_STEPS_PER_SIDE : 0;
        size_t to = i + MEDIAN_STEPS_PER_SIDE < count - 1 ? i + MEDIAN_STEPS_PER_SIDE : count - 1;
        int64_t periods = llround(
            fmin((t_us[i] - t_us[i - 1]) / find_median_step(t_us, from, to), GAP_PERIODS_MAX));
        number[i] = number[i - 1] + (periods > 1 ? periods : 1);
    }
}

static void set_frame_numbers(struct film *film)
{
    double *t_us = xcalloc(film->frame_count, sizeof *t_us);
    int64_t *number = xcalloc(film->frame_count, sizeof *number);
    for (size_t i = 0; i < film->frame_count; i++)
        t_us[i] = film->frame[i].board_us;
    film_compute_frame_numbers(t_us, film->frame_count, number);
    for (size_t i = 0; i < film->frame_count; i++)
        film->frame[i].number = number[i];
    free(t_us);
    free(number);
}

/* Adds a frame, in order of pulses. Skips a pulse whose time is unknown or not later than the
 * previous one. */
static void add_frame(struct film *film, const struct measured_landing *measured,
                      const struct store_film_frame *row)
{
    const struct film_frame *last = film->frame_count ? &film->frame[film->frame_count - 1] : NULL;
    if (isnan(row->board_us) || (last && row->board_us <= last->board_us))
        return;
    double t_s = (row->board_us - (double)measured->t0_us) / 1e6;
    struct film_frame *frame = &film->frame[film->frame_count++];
    *frame = (struct film_frame){.board_pulse_count = row->number,
                                 .board_us = row->board_us,
                                 .t_s = t_s,
                                 .station_ft = {(double)NAN, (double)NAN}};
    if (measured->fit_status == MR_OK && measured->track)
        frame->station_ft = track_compute_station(measured->track, t_s);
    frame->speed_ft_s.value = measured_speed_ft_s(measured, t_s, &frame->speed_ft_s.error);
}

enum mr_status film_load(struct store *store, const struct measured_landing *measured,
                         struct film *film, struct error *error)
{
    struct store_film_frame *row = NULL;
    size_t count = 0;
    *film = (struct film){.rate_hz = (double)NAN};
    enum mr_status status = store_film_frames_get(store, measured->landing.id, &row, &count, error);
    if (status != MR_OK || count == 0)
        return status;
    film->frame = xcalloc(count, sizeof *film->frame);
    for (size_t i = 0; i < count; i++)
        add_frame(film, measured, &row[i]);
    free(row);
    set_frame_numbers(film);
    if (film->frame_count > 1) {
        const struct film_frame *last = &film->frame[film->frame_count - 1];
        film->rate_hz = (double)(last->number - 1) /
                        ((last->board_us - film->frame[0].board_us) / 1e6);
        film->missing_frame_count = last->number - (int64_t)film->frame_count;
    }
    return MR_OK;
}

void film_free(struct film *film)
{
    free(film->frame);
}
