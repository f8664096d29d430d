#include "host/compare/figures.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/units.h"
#include "host/base/xmalloc.h"

/* ---- two series, sample by sample ---- */

/* In a few thousand samples, noise does not exceed this number of standard deviations. */
#define NOISE_MAX_SIGMAS 5.0

double signal_compute_en_score(double measured, double measured_error, double simulated,
                               double simulated_error)
{
    double error = hypot(measured_error, simulated_error), difference = fabs(measured - simulated);
    if (isnan(difference) || isnan(error))
        return (double)NAN;
    if (error > 0.0)
        return difference / (2.0 * error);
    return difference > 0.0 ? (double)INFINITY : 0.0;
}

static bool has_both_values(const struct signal *s, size_t i)
{
    return !isnan(s->measured[i]) && !isnan(s->simulated[i]);
}

/* Computes the differences of the series. The mean over samples reduces the noise; the rest of a
 * sample's error counts as common to all samples. */
static void compute_differences(const struct signal *s, struct signal_figures *f)
{
    double sum = 0.0, squares = 0.0, chi = 0.0, common = 0.0;
    for (size_t i = 0; i < s->count; i++) {
        if (!has_both_values(s, i))
            continue;
        double d = s->measured[i] - s->simulated[i],
               u = hypot(s->measured_error[i], s->simulated_error[i]);
        sum += d;
        squares += d * d;
        if (d != 0.0)
            chi += d * d / (u * u);
        common += sqrt(fmax(u * u - s->noise_deviation * s->noise_deviation, 0.0));
        f->compared_sample_count++;
    }
    double n = (double)f->compared_sample_count;
    if (f->compared_sample_count == 0)
        return;
    f->bias = sum / n;
    f->bias_error = hypot(common / n, s->noise_deviation / sqrt(n));
    f->rms = sqrt(squares / n);
    f->rms_per_error = sqrt(chi / n);
}

/* Returns the mean of the samples around i that both series have, so that both are smoothed in the
 * same way. NaN: there are none. */
static double compute_moving_mean(const struct signal *s, const double *values, size_t i)
{
    size_t half = SIGNAL_MEAN_SAMPLES / 2, from = i > half ? i - half : 0,
           to = i + half < s->count ? i + half : s->count - 1;
    double sum = 0.0;
    size_t count = 0;
    for (size_t k = from; k <= to; k++) {
        if (!has_both_values(s, k))
            continue;
        sum += values[k];
        count++;
    }
    return count ? sum / (double)count : (double)NAN;
}

static double get_sample_time_s(const struct signal *s, double i)
{
    return s->t0_s + i * s->dt_s;
}

/* Finds the peak of the measured or the simulated series. `noise`: noise of a mean over the
 * window. */
static struct signal_moment find_peak(const struct signal *s, const double *values,
                                      const double *errors, double noise)
{
    struct signal_moment peak = {(double)NAN, (double)NAN, (double)NAN, (double)NAN};
    size_t at = 0, first = 0;
    for (size_t i = 0; i < s->count; i++) {
        double value = has_both_values(s, i) ? compute_moving_mean(s, values, i) : (double)NAN;
        if (isnan(value) || fabs(value) <= fabs(peak.value))
            continue;
        peak.value = value;
        at = i;
    }
    if (isnan(peak.value))
        return peak;
    double near = fmax(SIGNAL_PEAK_TOLERANCE * fabs(peak.value), NOISE_MAX_SIGMAS * noise);
    for (first = 0; !(fabs(peak.value - compute_moving_mean(s, values, first)) <= near);)
        first++; /* the loop ends at the peak at the latest */
    peak.error = errors[at];
    peak.t_s = get_sample_time_s(s, (double)first);
    peak.t_error_s = s->time_error_s[first];
    return peak;
}

static struct signal_moment find_arrival(const struct signal *s, const double *values,
                                         const double *errors, double noise, double peak,
                                         bool measured)
{
    struct signal_moment arrival = {SIGNAL_ARRIVAL_FRACTION * peak, (double)NAN, (double)NAN,
                                    (double)NAN};
    double threshold = fabs(arrival.value), before = (double)NAN;
    if (!(threshold > NOISE_MAX_SIGMAS * noise) || threshold == 0.0)
        return arrival;
    for (size_t i = 0; i < s->count; i++) {
        double value = has_both_values(s, i)
                         ? compute_moving_mean(s, values, i) * (peak < 0.0 ? -1.0 : 1.0)
                         : (double)NAN;
        if (isnan(value))
            continue;
        if (value < threshold) {
            before = value;
            continue;
        }
        if (isnan(before)) /* without a value before it, the curve begins above the threshold */
            return arrival;
        size_t half = SIGNAL_MEAN_SAMPLES / 2, from = i > half ? i - half : 0,
               to = i + half < s->count ? i + half : s->count - 1;
        double slope =
            fabs(compute_moving_mean(s, values, to) - compute_moving_mean(s, values, from)) /
            ((double)(to - from) * s->dt_s);
        double u = errors[i];
        if (measured) /* replace the noise of a single measured sample by that of the mean */
            u = sqrt(fmax(u * u - s->noise_deviation * s->noise_deviation, 0.0) + noise * noise);
        arrival.t_s = get_sample_time_s(s, (double)i - (value - threshold) / (value - before));
        arrival.error = u;
        arrival.t_error_s = sqrt(u * u / (slope * slope) +
                                 (measured ? s->time_error_s[i] * s->time_error_s[i] : 0.0) +
                                 s->dt_s * s->dt_s / 12.0);
        return arrival;
    }
    return arrival;
}

void signal_compute_figures(const struct signal *s, struct signal_figures *f)
{
    const struct signal_moment unknown = {(double)NAN, (double)NAN, (double)NAN, (double)NAN};
    *f = (struct signal_figures){
        .bias = (double)NAN,
        .bias_error = (double)NAN,
        .rms = (double)NAN,
        .rms_per_error = (double)NAN,
        .peak_measured = unknown,
        .peak_simulated = unknown,
        .arrival_measured = unknown,
        .arrival_simulated = unknown,
    };
    double noise = s->noise_deviation / sqrt(SIGNAL_MEAN_SAMPLES);
    compute_differences(s, f);
    if (f->compared_sample_count == 0)
        return;
    f->peak_measured = find_peak(s, s->measured, s->measured_error, noise);
    f->peak_simulated = find_peak(s, s->simulated, s->simulated_error, noise);
    f->arrival_measured = find_arrival(s, s->measured, s->measured_error, noise,
                                       f->peak_measured.value, true);
    f->arrival_simulated = find_arrival(s, s->simulated, s->simulated_error, noise,
                                        f->peak_simulated.value, false);
}

/* ---- a landing ---- */

/* Error of a stop time that is stored without one: about the time between the last edges. */
#define UNKNOWN_STOP_TIME_ERROR_S 0.1

void compare_timing_init(const struct measured_landing *measured, struct compare_timing *clock)
{
    double unused;
    clock->stop_s = measured->summary.stop_t_s.value;
    clock->stop_error_s = measured->summary.stop_t_s.error;
    if (!(clock->stop_error_s >= 0.0))
        clock->stop_error_s = UNKNOWN_STOP_TIME_ERROR_S;
    for (size_t i = 0; i <= COMPARE_TIMING_POINTS; i++) {
        double t_s = clock->stop_s * (double)i / COMPARE_TIMING_POINTS,
               speed_ft_s = measured_speed_ft_s(measured, t_s, &unused);
        double error_ft = measured->track ? track_compute_station(measured->track, t_s).error
                                          : (double)NAN;
        if (isnan(error_ft))
            error_ft = measured->landing.switch_error_ft;
        clock->error_s[i] = speed_ft_s > 0.0 ? fmin(error_ft / speed_ft_s, clock->stop_error_s)
                                             : clock->stop_error_s;
    }
}

double compare_compute_time_error_s(const struct compare_timing *clock, double t_s)
{
    double k = t_s / clock->stop_s * COMPARE_TIMING_POINTS;
    if (!(k > 0.0))
        return clock->error_s[0];
    if (k >= COMPARE_TIMING_POINTS)
        return clock->stop_error_s;
    size_t i = (size_t)k;
    return clock->error_s[i] + (k - (double)i) * (clock->error_s[i + 1] - clock->error_s[i]);
}

#define ZONE_SEARCH_STEP_S 0.02
#define SETTLING_S         0.3 /* time from the stop until the mats are at rest */
#define MAT_FT             ((double)MR_MAT_LENGTH_FT)

struct compare_zone compare_find_closed_zone(const float *slack_in, const float *remaining_in,
                                             double wheel_ft)
{
    /* a zone in which the wheel is begins at the wheel */
    const double error_ft = ZONES_ERROR_MATS * MAT_FT, at_wheel_ft = 0.1;
    struct mr_closure_zone run;
    zones_find_longest_zone(slack_in, remaining_in, wheel_ft, (double)INFINITY, &run);
    return (struct compare_zone){
        .is_known = true,
        .mats = (double)run.mats,
        .start_ft = (double)run.start_ft,
        .end_ft = (double)run.end_ft,
        .start_error_ft = (double)run.start_ft - wheel_ft < at_wheel_ft ? 0.0 : error_ft,
        .end_error_ft = error_ft};
}

struct compare_overlap compare_compute_overlap(const struct compare_zone *a,
                                               const struct compare_zone *b)
{
    struct compare_overlap overlap = {.is_known = a->is_known && b->is_known,
                                      .start_difference_ft = (double)NAN,
                                      .end_difference_ft = (double)NAN};
    if (!overlap.is_known)
        return overlap;
    if (a->mats > 0.0 && b->mats > 0.0) {
        overlap.common_mats =
            fmax(0.0, (fmin(a->end_ft, b->end_ft) - fmax(a->start_ft, b->start_ft)) / MAT_FT);
        overlap.start_difference_ft = a->start_ft - b->start_ft;
        overlap.end_difference_ft = a->end_ft - b->end_ft;
    }
    double of_a = a->mats > 0.0 ? (a->end_ft - a->start_ft) / MAT_FT : 0.0,
           of_b = b->mats > 0.0 ? (b->end_ft - b->start_ft) / MAT_FT : 0.0;
    overlap.all_mats = of_a + of_b - overlap.common_mats;
    overlap.share = overlap.all_mats > 0.0 ? overlap.common_mats / overlap.all_mats : 1.0;
    return overlap;
}

/* Returns the newest zone and prediction of the board at a time. */
static struct compare_zone find_board_zone(const struct measured_landing *measured,
                                           const struct compare_board_reports *reports, double t_s)
{
    struct compare_zone zone = {.is_known = false};
    const struct store_zone *row = NULL;
    for (size_t i = 0; i < reports->zone_count && zones_time_s(measured, &reports->zone[i]) <= t_s;
         i++)
        row = &reports->zone[i];
    if (!row)
        return zone;
    zone = (struct compare_zone){true,        (double)row->mats, row->start_ft,
                                 row->end_ft, (double)NAN,       (double)NAN};
    const struct store_prediction *prediction =
        zones_find_prediction(reports->prediction, reports->prediction_count, row->block);
    if (prediction) {
        zone.start_error_ft = prediction->start_error_ft;
        zone.end_error_ft = prediction->end_error_ft;
    }
    return zone;
}

/* Returns false where blocks were lost: survey openings alone, without movements, do not give the
 * zone at that time. */
static bool has_movement_data(const struct measured_landing *measured, size_t sample)
{
    unsigned readings = 0;
    for (unsigned c = 0; c < MR_TRANSDUCERS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        readings +=
            channel->config.kind == MR_KIND_DISPLACEMENT &&
            !isnan(measured_moving_mean(measured, channel, sample, MEASURED_MEAN_BLOCKS / 2));
    }
    return readings >= 2;
}

static struct compare_zone find_measured_zone(const struct measured_landing *measured,
                                              const struct zones_slack *survey, double t_s)
{
    float remaining_in[MR_SEGMENTS];
    double sample = (t_s - measured_time_s(measured, 0)) * 1000.0;
    if (survey->surveyed_segment_count == 0 ||
        !(sample >= 0.0 && sample < (double)measured->samples) ||
        !has_movement_data(measured, (size_t)sample))
        return (struct compare_zone){.is_known = false};
    zones_compute_remaining_slack(measured, survey, (size_t)sample, remaining_in);
    double wheel_ft = measured_station_ft(measured, measured_time_s(measured, (size_t)sample));
    return compare_find_closed_zone(survey->slack_in, remaining_in, wheel_ft);
}

static struct compare_zone find_simulated_zone(const struct compare_segment_openings *segments,
                                               double t_s, double wheel_ft)
{
    double row = floor(t_s / segments->dt_s + 0.5);
    if (segments->row_count == 0 || !(row >= 0.0))
        return (struct compare_zone){.is_known = false};
    size_t at = row < (double)segments->row_count ? (size_t)row : segments->row_count - 1;
    return compare_find_closed_zone(segments->remaining_in,
                                    segments->remaining_in + at * MR_SEGMENTS, wheel_ft);
}

struct zone_input {
    const struct measured_landing *measured;
    const struct zones_slack *survey;
    const struct compare_segment_openings *segments;
    const struct compare_board_reports *reports;
};

static void set_zone_moment(const struct zone_input *in, const char *what, double t_s,
                            struct compare_zone_moment *moment)
{
    moment->description = what;
    moment->t_s = t_s;
    moment->wheel_ft = measured_station_ft(in->measured, t_s);
    moment->zone[COMPARE_MEASURED] = find_measured_zone(in->measured, in->survey, t_s);
    moment->zone[COMPARE_BOARD] = find_board_zone(in->measured, in->reports, t_s);
    moment->zone[COMPARE_SIMULATED] = find_simulated_zone(in->segments, t_s, moment->wheel_ft);
    moment->board_overlap = compare_compute_overlap(&moment->zone[COMPARE_MEASURED],
                                                    &moment->zone[COMPARE_BOARD]);
    moment->simulated_overlap = compare_compute_overlap(&moment->zone[COMPARE_MEASURED],
                                                        &moment->zone[COMPARE_SIMULATED]);
}

/* Returns the time at which the zone is longest while the gear moves. Uses the measured zone, or
 * else the board's, or else the simulated zone. */
static double find_longest_zone_s(const struct zone_input *in, double stop_s,
                                  enum compare_zone_source *source)
{
    double most[COMPARE_SOURCE_COUNT] = {0.0}, at_s[COMPARE_SOURCE_COUNT] = {0.0};
    for (double t_s = 0.0; t_s < stop_s; t_s += ZONE_SEARCH_STEP_S) {
        struct compare_zone_moment moment;
        set_zone_moment(in, "", t_s, &moment);
        for (int k = 0; k < COMPARE_SOURCE_COUNT; k++) {
            if (!moment.zone[k].is_known || moment.zone[k].mats <= most[k])
                continue;
            most[k] = moment.zone[k].mats;
            at_s[k] = t_s;
        }
    }
    for (int k = 0; k < COMPARE_SOURCE_COUNT; k++) {
        *source = (enum compare_zone_source)k;
        if (most[k] > 0.0)
            return at_s[k];
    }
    return (double)NAN;
}

void compare_find_zones(const struct measured_landing *measured, const struct zones_slack *survey,
                        const struct compare_board_reports *reports,
                        const struct compare_segment_openings *segments,
                        struct compare_zones *zones)
{
    static const char *const longest[] = {"longest measured", "longest said", "longest simulated"};
    const struct zone_input in = {measured, survey, segments, reports};
    double stop_s = measured->summary.stop_t_s.value,
           end_s = measured_time_s(measured, measured->samples - 1);
    enum compare_zone_source source;
    double t_s = find_longest_zone_s(&in, stop_s, &source);
    zones->count = 0;
    if (!isnan(t_s))
        set_zone_moment(&in, longest[source], t_s, &zones->moment[zones->count++]);
    set_zone_moment(&in, "at rest", fmin(stop_s + SETTLING_S, end_s),
                    &zones->moment[zones->count++]);
}

const struct compare_zone_moment *compare_find_moment(const struct compare_zones *zones, bool rest)
{
    for (size_t i = 0; i < zones->count; i++) {
        if ((strcmp(zones->moment[i].description, "at rest") == 0) == rest)
            return &zones->moment[i];
    }
    return NULL;
}

/* Returns the movement or spread of a row at a time: linear between samples, constant after the
 * last sample, NaN before the first. */
static double interpolate_simulation(const struct store_simulation *row, const float *values,
                                     double t_s)
{
    double k = (t_s - row->t0_s) / row->dt_s;
    if (!values || row->length == 0 || !(k >= 0.0))
        return (double)NAN;
    size_t i = (size_t)fmin(k, (double)row->length);
    if (i + 1 >= row->length)
        return (double)values[row->length - 1];
    return (double)values[i] + (k - (double)i) * (double)(values[i + 1] - values[i]);
}

void compare_fill_curves(const struct measured_landing *measured,
                         const struct compare_timing *clock, const struct measured_channel *channel,
                         const struct store_simulation *row, double solver_error_in,
                         struct compare_curves *s)
{
    double end_s = row->t0_s + (double)(row->length - 1) * row->dt_s;
    size_t n = measured->samples;
    double **arrays[] = {&s->t_s,
                         &s->measured_in,
                         &s->measured_error_in,
                         &s->simulated_in,
                         &s->simulated_error_in,
                         &s->time_error_s,
                         &s->alignment_error_in};
    s->storage = xcalloc(7 * n, sizeof *s->storage);
    for (size_t i = 0; i < 7; i++)
        *arrays[i] = s->storage + i * n;
    for (size_t i = 0; i < measured->samples; i++) {
        double t_s = measured_time_s(measured, i);
        s->t_s[i] = t_s;
        bool outside = t_s < 0.0 || t_s > end_s;
        s->measured_in[i] = outside ? (double)NAN : measured_value(channel, i);
        s->simulated_in[i] = outside ? (double)NAN
                                     : interpolate_simulation(row, row->series_in, t_s);
        s->time_error_s[i] = compare_compute_time_error_s(clock, t_s);
        double before_in = interpolate_simulation(row, row->series_in,
                                                  fmax(t_s - s->time_error_s[i], row->t0_s));
        s->alignment_error_in[i] =
            0.5 *
            fabs(interpolate_simulation(row, row->series_in, t_s + s->time_error_s[i]) - before_in);
        s->measured_error_in[i] =
            hypot(measured_standard_error(measured, channel, s->measured_in[i], 1.0),
                  s->alignment_error_in[i]);
        double spread_in = interpolate_simulation(row, row->spread_in, t_s);
        s->simulated_error_in[i] = hypot(solver_error_in, isnan(spread_in) ? 0.0 : spread_in);
    }
}

/* Compares the means over the last 0.2 s of the time that measurement and simulation have in
 * common. */
static void compare_final_means(const struct measured_landing *measured,
                                const struct measured_channel *channel,
                                const struct compare_curves *s, struct compare_channel *out)
{
    double sum_m = 0.0, sum_s = 0.0, alignment = 0.0, simulated_error = 0.0;
    size_t count = 0;
    for (size_t i = measured->samples; i-- > 0 && count < MEASURED_FINAL_MEAN_BLOCKS;) {
        if (isnan(s->measured_in[i]) || isnan(s->simulated_in[i]))
            continue;
        sum_m += s->measured_in[i];
        sum_s += s->simulated_in[i];
        alignment += s->alignment_error_in[i];
        simulated_error += s->simulated_error_in[i];
        count++;
    }
    double n = (double)count;
    out->end_measured.value = sum_m / n;
    out->end_measured.error = hypot(measured_standard_error(measured, channel, sum_m / n, n),
                                    alignment / n);
    out->end_simulated.value = sum_s / n;
    out->end_simulated.error = simulated_error / n;
    out->end_en_score = signal_compute_en_score(out->end_measured.value, out->end_measured.error,
                                                out->end_simulated.value, out->end_simulated.error);
}

static void compute_channel_figures(const struct measured_landing *measured,
                                    const struct measured_channel *channel,
                                    const struct compare_curves *s, struct compare_channel *out)
{
    const struct signal signal = {
        .count = measured->samples,
        .t0_s = measured_time_s(measured, 0),
        .dt_s = 0.001,
        .measured = s->measured_in,
        .simulated = s->simulated_in,
        .measured_error = s->measured_error_in,
        .simulated_error = s->simulated_error_in,
        .time_error_s = s->time_error_s,
        .noise_deviation = isnan(channel->noise) ? 0.0 : channel->noise,
    };
    struct signal_figures *f = &out->figures;
    signal_compute_figures(&signal, f);
    /* channel->peak excludes the noise that raises a maximum (measured.h) */
    f->peak_measured.value = channel->peak;
    f->peak_measured.error = channel->peak_error;
    compare_final_means(measured, channel, s, out);
    out->bias_en_score = signal_compute_en_score(f->bias, f->bias_error, 0.0, 0.0);
    out->peak_en_score = signal_compute_en_score(f->peak_measured.value, f->peak_measured.error,
                                                 f->peak_simulated.value, f->peak_simulated.error);
    const struct signal_moment *m = &f->arrival_measured, *a = &f->arrival_simulated;
    out->arrival_en_score = signal_compute_en_score(m->t_s, m->t_error_s, a->t_s, a->t_error_s);
}

/* Returns the most frequent reason for invalid readings. */
static const char *find_most_frequent_reason(const struct measured_landing *measured,
                                             const struct measured_channel *channel)
{
    size_t counts[256] = {0}, most = 0;
    for (size_t i = 0; i < measured->samples; i++)
        counts[channel->validity[i]]++;
    for (size_t v = 1; v < 256; v++)
        most = counts[v] > counts[most ? most : 1] || !most ? v : most;
    return most == MEASURED_MISSING ? "it was not received"
         : most == MEASURED_INVALID ? "not valid"
                                    : mr_validity_text((unsigned)most);
}

static bool is_channel_usable(const struct measured_landing *measured,
                              const struct measured_channel *channel,
                              const struct store_simulation *row, struct compare_channel *out)
{
    size_t of = 0, valid = 0;
    double end_s = row ? row->t0_s + (double)row->length * row->dt_s : 0.0;
    for (size_t i = 0; i < measured->samples && channel->raw; i++) {
        double t_s = measured_time_s(measured, i);
        of += t_s >= 0.0 && t_s <= end_s;
        valid += t_s >= 0.0 && t_s <= end_s && !isnan(measured_value(channel, i));
    }
    out->valid_share = of ? (double)valid / (double)of : 0.0;
    if (!row || row->length == 0)
        snprintf(out->reason_or_remark, sizeof out->reason_or_remark,
                 "not simulated; compare the landing again");
    else if (!channel->raw || of == 0)
        snprintf(out->reason_or_remark, sizeof out->reason_or_remark, "no readings were received");
    else if (isnan(channel->baseline))
        snprintf(out->reason_or_remark, sizeof out->reason_or_remark,
                 "no reading at rest before the landing: %s",
                 find_most_frequent_reason(measured, channel));
    else if (out->valid_share < COMPARE_MIN_VALID_SHARE)
        snprintf(out->reason_or_remark, sizeof out->reason_or_remark,
                 "only %.0f %% of the readings are valid, but at least half must be valid: %s",
                 100.0 * out->valid_share, find_most_frequent_reason(measured, channel));
    else
        return true;
    return false;
}

static void add_channel(const struct measured_landing *measured, const struct compare_timing *clock,
                        const struct measured_channel *channel, const struct store_simulation *row,
                        double solver_error_in, struct compare_channel *out)
{
    const double nan = (double)NAN;
    struct compare_curves series;
    *out = (struct compare_channel){.number = channel->config.number,
                                    .station_ft = (double)channel->config.station_ft,
                                    .bias_en_score = nan,
                                    .peak_en_score = nan,
                                    .end_en_score = nan,
                                    .arrival_en_score = nan,
                                    .end_measured = {nan, nan, nan, nan},
                                    .end_simulated = {nan, nan, nan, nan}};
    const struct signal empty = {.count = 0};
    signal_compute_figures(&empty, &out->figures); /* without samples, all figures become unknown */
    out->is_compared = is_channel_usable(measured, channel, row, out);
    if (!out->is_compared)
        return;
    compare_fill_curves(measured, clock, channel, row, solver_error_in, &series);
    compute_channel_figures(measured, channel, &series, out);
    free(series.storage);
}

void compare_compute_figures(const struct measured_landing *measured,
                             const struct zones_slack *survey,
                             const struct compare_board_reports *reports,
                             const struct store_simulation_summary *head,
                             const struct store_simulation *rows, size_t count,
                             struct compare_figures *figures)
{
    memset(figures, 0, sizeof *figures);
    figures->run = measured->landing.id;
    measured_format_missing_start(measured, figures->missing_start_text);
    figures->marks = measured_quality_text(measured);
    snprintf(figures->model_file, sizeof figures->model_file, "%s", head->file);
    figures->simulation_ms = head->run_ms;
    figures->solver_error_in = head->error_in;
    figures->seed_count = head->seeds;
    figures->surveyed_segment_count = survey->surveyed_segment_count;
    compare_timing_init(measured, &figures->timing);
    for (unsigned number = 1; number <= MR_TRANSDUCERS; number++) {
        int c = measured_channel_index(measured, MR_KIND_DISPLACEMENT, number);
        const struct store_simulation *row = NULL;
        for (size_t i = 0; i < count; i++)
            row = rows[i].number == (int64_t)number ? &rows[i] : row;
        if (c < 0)
            continue;
        double solver_error_in = !isnan(head->error_in) ? head->error_in
                               : row                    ? row->peak_simulated_error_in
                                                        : 0.0;
        add_channel(measured, &figures->timing, &measured->channel[c], row, solver_error_in,
                    &figures->channel[figures->channel_count++]);
    }
    const struct compare_segment_openings segments = {head->segments_in, head->segment_rows,
                                                      head->segments_dt_s};
    compare_find_zones(measured, survey, reports, &segments, &figures->zones);
}

struct compare_channel_means compare_compute_means(const struct compare_figures *figures)
{
    struct compare_channel_means mean = {0};
    double sum = 0.0, squares = 0.0;
    for (size_t i = 0; i < figures->channel_count; i++) {
        const struct compare_channel *c = &figures->channel[i];
        if (!c->is_compared)
            continue;
        double n = (double)c->figures.compared_sample_count;
        mean.channel_count++;
        mean.sample_count += n;
        sum += n * c->figures.bias;
        squares += n * c->figures.rms * c->figures.rms;
        mean.worst_rms_in = fmax(mean.worst_rms_in, c->figures.rms);
        mean.worst_peak_en_score = fmax(mean.worst_peak_en_score, c->peak_en_score);
    }
    mean.bias_in = mean.sample_count > 0.0 ? sum / mean.sample_count : (double)NAN;
    mean.rms_in = mean.sample_count > 0.0 ? sqrt(squares / mean.sample_count) : (double)NAN;
    if (mean.channel_count == 0)
        mean.worst_rms_in = mean.worst_peak_en_score = (double)NAN;
    return mean;
}

/* ---- agreement ---- */

void compare_compute_agreement(const struct compare_figures *figures, struct compare_agreement *a)
{
    *a = (struct compare_agreement){.run = figures->run,
                                    .model_file = figures->model_file[0] ? figures->model_file
                                                                         : "the simulation",
                                    .en_score = (double)NAN};
    for (size_t i = 0; i < figures->channel_count; i++) {
        const struct compare_channel *c = &figures->channel[i];
        const struct {
            const char *value;
            bool is_time;
            double measured, simulated, en;
        } values[] = {
            {"peak", false, c->figures.peak_measured.value, c->figures.peak_simulated.value,
             c->peak_en_score},
            {"end", false, c->end_measured.value, c->end_simulated.value, c->end_en_score},
            {"arrival", true, c->figures.arrival_measured.t_s, c->figures.arrival_simulated.t_s,
             c->arrival_en_score}};
        for (size_t k = 0; k < 3 && c->is_compared; k++) {
            if (isnan(values[k].en))
                continue;
            a->judged_value_count++;
            a->differing_value_count += values[k].en > 1.0;
            if (a->channel && values[k].en <= a->en_score)
                continue;
            a->channel = c;
            a->value_name = values[k].value;
            a->is_time = values[k].is_time;
            a->measured = values[k].measured;
            a->simulated = values[k].simulated;
            a->en_score = values[k].en;
        }
    }
}

void compare_write_agreement(const struct compare_agreement *a, bool si,
                             char out[COMPARE_AGREEMENT_SIZE])
{
    const struct unit *station = unit_get(UNIT_STATION, si);
    const enum unit_kind kind = a->is_time ? UNIT_TIME : UNIT_DISPLACEMENT;
    char measured[UNIT_TEXT_SIZE], simulated[UNIT_TEXT_SIZE];
    if (!a->channel) {
        snprintf(out, COMPARE_AGREEMENT_SIZE,
                 "RUN %" PRId64 " has no peak, end or arrival that can be compared with %s", a->run,
                 a->model_file);
        return;
    }
    snprintf(out, COMPARE_AGREEMENT_SIZE,
             "RUN %" PRId64 " %s %s: %zu of %zu peaks, ends and arrivals differ by more than "
             "twice their errors; largest: the %s at transducer %" PRId64 ", %.1f %s, measured %s, "
             "simulated %s, En %.3g",
             a->run, a->differing_value_count ? "differs from" : "agrees with", a->model_file,
             a->differing_value_count, a->judged_value_count, a->value_name, a->channel->number,
             a->channel->station_ft * station->factor, station->text,
             unit_value_text(kind, si, a->measured, 4, measured),
             unit_value_text(kind, si, a->simulated, 4, simulated), a->en_score);
}
