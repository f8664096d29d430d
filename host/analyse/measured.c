#include "host/analyse/measured.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/emulated.h"
#include "host/analyse/track.h"
#include "host/base/xmalloc.h"

#define CLOCK_TOLERANCE  0.01 /* tolerance of the internal oscillator, used as a standard error */
/* middle of the 8 scans, which are 125 us apart, from the start of the block */
#define SAMPLE_MIDDLE_MS 0.4375

double measured_time_s(const struct measured_landing *measured, size_t sample)
{
    double ms = (double)(measured->first_block + (int64_t)sample) + SAMPLE_MIDDLE_MS;
    return ms / 1000.0 - (double)measured->t0_us / 1e6;
}

double measured_value(const struct measured_channel *channel, size_t sample)
{
    double raw = (double)channel->raw[sample];
    return channel->config.kind == MR_KIND_DISPLACEMENT ? raw - channel->baseline : raw;
}

double measured_moving_mean(const struct measured_landing *measured,
                            const struct measured_channel *channel, size_t sample, size_t half)
{
    size_t from = sample > half ? sample - half : 0;
    size_t to = sample + half < measured->samples ? sample + half : measured->samples - 1;
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = from; i <= to; i++) {
        double value = measured_value(channel, i);
        if (!isnan(value)) {
            sum += value;
            count++;
        }
    }
    return count ? sum / (double)count : (double)NAN;
}

int measured_channel_index(const struct measured_landing *measured, enum mr_channel_kind kind,
                           unsigned number)
{
    for (int i = 0; i < (int)MR_CHANNELS; i++) {
        if (measured->channel[i].config.kind == kind &&
            measured->channel[i].config.number == number)
            return i;
    }
    return -1;
}

/* ---- gear ---- */

/* Includes a relative error of the clock in the errors. It changes speeds by the same factor and
 * decelerations by twice as much. */
static void add_clock_error(struct mr_gates_summary *summary)
{
    struct mr_estimate *speed = &summary->touchdown_speed_ft_s;
    struct mr_estimate *deceleration = &summary->mean_deceleration_ft_s2;
    speed->error = hypot(speed->error, CLOCK_TOLERANCE * speed->value);
    deceleration->error = hypot(deceleration->error, 2.0 * CLOCK_TOLERANCE * deceleration->value);
}

static void shift_gates(struct measured_landing *measured, double by_s)
{
    for (size_t i = 0; i < measured->gate_count; i++)
        measured->gate[i].t_s -= by_s;
}

/* Returns true if no source has data for that time. */
static bool is_in_gap(const struct measured_landing *measured, double t_s)
{
    double block = floor(t_s * 1e3 + (double)measured->t0_us / 1e3);
    for (size_t i = 0; i < measured->stretch_count; i++) {
        const struct measured_source_stretch *stretch = &measured->stretch[i];
        if (block >= (double)stretch->from_block && block <= (double)stretch->to_block)
            return stretch->source == MEASURED_NO_SOURCE;
    }
    return false;
}

/* Returns the first switch whose edge may be missing because of a gap in the record; 0: none. Such
 * a switch is beyond the last switch with an edge, and according to the fit the gear passed it
 * during a gap. A gap distorts the fit, so switches up to 3 standard errors beyond the stop are
 * included. */
static unsigned find_switch_in_data_gap(const struct measured_landing *measured)
{
    const struct mr_estimate *stop = &measured->summary.stop_station_ft;
    double last_ft = measured->gate_count ? measured->gate[measured->gate_count - 1].station_ft
                                          : (double)INFINITY;
    for (unsigned p = 0; p < 64; p++) {
        if (!(measured->fitted_switches & ~measured->switches_with_edges & 1ull << p) ||
            measured->switch_ft[p] < last_ft ||
            measured->switch_ft[p] > stop->value + 3.0 * stop->error)
            continue;
        double due_s = measured->switch_ft[p] < stop->value
                         ? measured_arrival_time_s(measured, measured->switch_ft[p])
                         : measured->summary.stop_t_s.value;
        if (is_in_gap(measured, due_s))
            return p + 1;
    }
    return 0;
}

/* Returns the first of several switches without an edge between the last switch with one and the
 * stop; 0: none. Either a cable is broken, or the gear stopped before it reached them. A single
 * such switch does not count, because the switch itself may be faulty. */
static unsigned find_unopened_switch(const struct measured_landing *measured)
{
    const struct mr_estimate *stop = &measured->summary.stop_station_ft;
    unsigned first = 0, silent = 0;
    for (unsigned p = 0; p < 64; p++)
        if (measured->fitted_switches & ~measured->switches_with_edges & 1ull << p &&
            measured->switch_ft[p] > measured->gate[measured->gate_count - 1].station_ft &&
            measured->switch_ft[p] < stop->value - 3.0 * stop->error)
            first = silent++ ? first : p + 1;
    return silent > 1 ? first : 0;
}

/* Returns true if, in the last state that was received, the gear has not arrived yet or is
 * moving. */
static bool is_moving_at_end(const struct measured_landing *measured)
{
    return measured->landing.state == MR_LANDING_ARMED ||
           measured->landing.state == MR_LANDING_LANDING;
}

/* Returns true if the record ends before the gear's stop is certain. Unless the board reported the
 * stop, the record must extend to two standard errors after the computed stop. */
static bool record_ends_before_stop(const struct measured_landing *measured)
{
    const struct mr_estimate *stop_t_s = &measured->summary.stop_t_s;
    double surely_s = stop_t_s->value + (is_moving_at_end(measured) ? 2.0 * stop_t_s->error : 0.0);
    return measured->samples == 0 || measured_time_s(measured, measured->samples - 1) < surely_s;
}

void measured_fit_gear_motion(struct measured_landing *measured)
{
    struct store_landing *landing = &measured->landing;
    int64_t armed_us = landing->armed_block == STORE_NONE ? 1000 * measured->first_block
                                                          : 1000 * landing->armed_block;
    measured->t0_us = armed_us;
    free(measured->track);
    measured->track = NULL;
    if (measured->gate_count > 0)
        measured->t0_us = (int64_t)llround(measured->gate[0].t_s * 1e6);
    shift_gates(measured, (double)measured->t0_us / 1e6);
    measured->fit_status = MR_TOO_FEW;
    if (measured->is_start_missing || isnan(landing->touchdown_ft) ||
        isnan(landing->switch_error_ft))
        return;
    measured->fit_status = mr_gates_summarise(measured->gate, measured->gate_count,
                                              landing->touchdown_ft, landing->switch_error_ft,
                                              &measured->summary);
    if (measured->fit_status != MR_OK)
        return;
    /* repeat the fit with touchdown, rounded to a microsecond, as origin */
    int64_t shift_us = (int64_t)llround(measured->summary.touchdown_t_s.value * 1e6);
    measured->t0_us += shift_us;
    measured->is_t0_touchdown = true;
    shift_gates(measured, (double)shift_us / 1e6);
    mr_gates_summarise(measured->gate, measured->gate_count, landing->touchdown_ft,
                       landing->switch_error_ft, &measured->summary);
    measured->track = xmalloc(sizeof *measured->track);
    track_make(measured, measured->track);
    if (landing->clock_source > 0)
        add_clock_error(&measured->summary);
    /* If the computed stop is after the end of the record, it is only extrapolated and does not
     * count as measured. The same applies if the last edges are missing: the fitted gear then rolls
     * too far. */
    measured->switch_in_data_gap = measured->has_board_result ? 0
                                                              : find_switch_in_data_gap(measured);
    measured->unopened_switch = record_ends_before_stop(measured) ? 0
                                                                  : find_unopened_switch(measured);
    if (measured->missing_edges > 0 || measured->switch_in_data_gap > 0 ||
        measured->unopened_switch > 0 || record_ends_before_stop(measured))
        measured->fit_status = MR_TRUNCATED;
}

bool measured_ends_while_moving(const struct measured_landing *measured)
{
    if (measured->samples == 0)
        return false;
    if (measured->fit_status == MR_TOO_FEW) /* the record ends too soon to fit a stop */
        return measured->gate_count > 0 && !measured->is_start_missing &&
               is_moving_at_end(measured);
    return measured->fit_status == MR_TRUNCATED && record_ends_before_stop(measured);
}

const char *measured_motion_at_end_text(const struct measured_landing *measured)
{
    bool past = measured->fit_status == MR_TRUNCATED && measured->samples > 0 &&
                measured_time_s(measured, measured->samples - 1) >=
                    measured->summary.stop_t_s.value;
    return past ? "may still move" : "moves";
}

void measured_format_unknown_stop(const struct measured_landing *measured,
                                  char out[MEASURED_REASON_SIZE])
{
    if (measured->missing_edges > 0)
        snprintf(out, MEASURED_REASON_SIZE,
                 "%zu of the %zu switch edges that the board reported are missing in the record",
                 measured->missing_edges, measured->gate_count + measured->missing_edges);
    else if (measured->switch_in_data_gap > 0)
        snprintf(out, MEASURED_REASON_SIZE,
                 "data is missing at the time when the gear passed switch %u",
                 measured->switch_in_data_gap);
    else if (measured->unopened_switch > 0)
        snprintf(out, MEASURED_REASON_SIZE,
                 "switch %u and later ones did not open, though the gear passed them",
                 measured->unopened_switch);
    else
        snprintf(out, MEASURED_REASON_SIZE, "the record ends while the gear %s",
                 measured_motion_at_end_text(measured));
}

double measured_block_time_s(const struct measured_landing *measured, int64_t block)
{
    return (1000.0 * (double)block - (double)measured->t0_us) / 1e6;
}

static bool is_motion_known(const struct measured_landing *measured, double t_s)
{
    return measured->fit_status == MR_OK && measured->track && t_s >= 0.0;
}

double measured_station_ft(const struct measured_landing *measured, double t_s)
{
    return is_motion_known(measured, t_s) ? track_station_ft(measured->track, t_s) : (double)NAN;
}

double measured_speed_ft_s(const struct measured_landing *measured, double t_s, double *error_ft_s)
{
    struct mr_estimate speed_ft_s = is_motion_known(measured, t_s)
                                      ? track_compute_speed(measured->track, t_s)
                                      : (struct mr_estimate){(double)NAN, (double)NAN};
    *error_ft_s = measured->landing.clock_source > 0
                    ? hypot(speed_ft_s.error, CLOCK_TOLERANCE * speed_ft_s.value)
                    : speed_ft_s.error;
    return speed_ft_s.value;
}

double measured_arrival_time_s(const struct measured_landing *measured, double station_ft)
{
    const struct mr_gates_summary *summary = &measured->summary;
    if (measured->fit_status != MR_OK || summary->stop_station_ft.value < station_ft)
        return (double)NAN;
    double low_s = 0.0;
    double high_s = summary->stop_t_s.value;
    for (int i = 0; i < 60; i++) { /* 60 bisections give the full accuracy of a double */
        double middle_s = 0.5 * (low_s + high_s);
        if (measured_station_ft(measured, middle_s) < station_ft)
            low_s = middle_s;
        else
            high_s = middle_s;
    }
    return high_s;
}

/* ---- channels ---- */

/* Returns the sample of the first edge of a known switch, or `samples` if there is none. */
static size_t find_first_edge_sample(const struct measured_landing *measured)
{
    if (measured->gate_count == 0)
        return measured->samples;
    double us = measured->gate[0].t_s * 1e6 + (double)measured->t0_us;
    double sample = floor(us / 1000.0) - (double)measured->first_block;
    if (!(sample > 0.0))
        return 0;
    return sample < (double)measured->samples ? (size_t)sample : measured->samples;
}

/* Returns true if the record begins at arming, when the mat is at rest. */
static bool record_begins_at_arming(const struct measured_landing *measured)
{
    int64_t armed = measured->landing.armed_block;
    return armed != STORE_NONE && measured->first_block - armed <= MEASURED_BASELINE_BLOCKS / 5;
}

/* Finds the samples of the baseline. These are the samples before the first edge. If the board had
 * counted earlier edges, or if there is no edge, the mat may have moved before; then the samples
 * after arming are used instead. An imported record without an edge has no arming, so its first
 * samples are used. Returns false if there are no such samples. */
static bool find_rest_samples(const struct measured_landing *measured, size_t edge, size_t *from,
                              size_t *to)
{
    size_t begin = edge > MEASURED_BASELINE_BLOCKS ? edge - MEASURED_BASELINE_BLOCKS : 0;
    bool first = measured->is_start_missing || measured->gate_count == 0;
    *from = first ? 0 : begin;
    *to = !first                                       ? edge
        : measured->samples < MEASURED_BASELINE_BLOCKS ? measured->samples
                                                       : MEASURED_BASELINE_BLOCKS;
    return !measured->is_start_missing || record_begins_at_arming(measured);
}

/* Computes the noise of one value, which is the mean of `stride` samples. Uses samples at full
 * rate, or CAN samples (which are means) if there are more of them. */
static void compute_noise(struct measured_channel *channel, size_t from, size_t to)
{
    double squares[2] = {0.0, 0.0};
    size_t count[2] = {0, 0};
    for (size_t i = from; i < to; i++) {
        bool can = channel->source[i] == MEASURED_CAN;
        double off = (double)channel->raw[i] - channel->baseline;
        if (channel->validity[i] != MR_VALID)
            continue;
        squares[can] += off * off;
        count[can]++;
    }
    channel->noise = (double)NAN;
    if (count[0] >= count[1] && count[0] > 1)
        channel->noise = sqrt(squares[0] / (double)(count[0] - 1) / (double)channel->stride);
    else if (count[1] > 1)
        channel->noise = sqrt(squares[1] / (double)(count[1] - 1));
}

static void compute_baseline(struct measured_channel *channel, size_t from, size_t to)
{
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = from; i < to; i++) {
        if (channel->validity[i] != MR_VALID)
            continue;
        sum += (double)channel->raw[i];
        count++;
    }
    channel->baseline = count ? sum / (double)count : (double)NAN;
    channel->rest_samples = count;
    compute_noise(channel, from, to);
}

static void compute_extremes(const struct measured_landing *measured,
                             struct measured_channel *channel, size_t from)
{
    measured_find_peaks(measured, channel, from, &channel->high, &channel->low);
    channel->end = (double)NAN;
    if (measured->samples > MEASURED_FINAL_MEAN_BLOCKS)
        channel->end = measured_moving_mean(measured, channel,
                                            measured->samples - 1 - MEASURED_FINAL_MEAN_BLOCKS / 2,
                                            MEASURED_FINAL_MEAN_BLOCKS / 2);
    /* The end value may itself be the extreme. It then has the larger error of a peak (matrig
     * uncertainty prints its budget). */
    if (channel->end > channel->high)
        channel->high = channel->end;
    if (channel->end < channel->low)
        channel->low = channel->end;
    double samples = measured_peak_sample_count(channel);
    channel->high_error = measured_standard_error(measured, channel, channel->high, samples);
    channel->low_error = measured_standard_error(measured, channel, channel->low, samples);
    channel->end_error = measured_standard_error(measured, channel, channel->end,
                                                 MEASURED_FINAL_MEAN_BLOCKS);
    bool up = fabs(channel->high) >= fabs(channel->low);
    channel->peak = up ? channel->high : channel->low;
    channel->peak_error = up ? channel->high_error : channel->low_error;
}

static void find_longest_missing_stretch(const struct measured_landing *measured,
                                         struct measured_channel *channel, size_t from)
{
    size_t begin = from, longest = MEASURED_MEAN_BLOCKS;
    channel->missing_start = channel->missing_end = 0;
    if (channel->valid_samples == 0) /* without a valid sample there are no results */
        return;
    for (size_t i = from; i <= measured->samples; i++) {
        if (i < measured->samples && channel->validity[i] != MR_VALID)
            continue;
        if (i - begin > longest) {
            longest = i - begin;
            channel->missing_start = begin;
            channel->missing_end = i;
        }
        begin = i + 1;
    }
}

void measured_compute_results(struct measured_landing *measured)
{
    size_t edge = find_first_edge_sample(measured), from, to;
    measured->has_no_baseline = !find_rest_samples(measured, edge, &from, &to);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_DISPLACEMENT && channel->config.kind != MR_KIND_TENSION)
            continue;
        for (size_t i = 0; i < measured->samples; i++)
            channel->valid_samples += channel->validity[i] == MR_VALID;
        compute_baseline(channel, from, to);
        if (measured->has_no_baseline) /* without a baseline, the noise is known but not the zero */
            channel->baseline = (double)NAN;
        compute_extremes(measured, channel, edge < measured->samples ? edge : 0);
        find_longest_missing_stretch(measured, channel, edge < measured->samples ? edge : 0);
    }
}

/* Returns the source of a block: that of its block record; without one, CAN if any channel has a
 * CAN sample. */
static enum measured_source find_block_source(const struct measured_landing *measured,
                                              size_t sample)
{
    enum measured_source source = MEASURED_NO_SOURCE;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        enum measured_source of_channel = (enum measured_source)measured->channel[c].source[sample];
        if (of_channel != MEASURED_NO_SOURCE)
            source = of_channel;
    }
    return source;
}

void measured_find_source_stretches(struct measured_landing *measured)
{
    for (size_t i = 0; i < measured->samples; i++) {
        enum measured_source source = find_block_source(measured, i);
        int64_t block = measured->first_block + (int64_t)i;
        measured->blocks_by_source[source]++;
        if (measured->stretch_count &&
            measured->stretch[measured->stretch_count - 1].source == source) {
            measured->stretch[measured->stretch_count - 1].to_block = block;
            continue;
        }
        xlist_grow(&measured->stretch, measured->stretch_count, sizeof *measured->stretch);
        measured->stretch[measured->stretch_count++] =
            (struct measured_source_stretch){source, block, block};
    }
}

void measured_format_missing_start(const struct measured_landing *measured,
                                   char out[MEASURED_MISSING_START_SIZE])
{
    out[0] = '\0';
    const char *lost = measured->has_no_baseline ? "speeds and movements are not known"
                                                 : "speeds are not known";
    if (measured->is_start_missing && measured->first_edge > 0)
        snprintf(out, MEASURED_MISSING_START_SIZE,
                 "incomplete: the switch edges before edge %lld were not received; %s",
                 (long long)measured->first_edge, lost);
    else if (measured->is_start_missing)
        snprintf(out, MEASURED_MISSING_START_SIZE,
                 "incomplete: none of the %zu switch edges was received; %s",
                 measured->missing_edges, lost);
}

const char *measured_origin_text(const struct measured_landing *measured)
{
    return measured->is_t0_touchdown ? "touchdown"
         : measured->gate_count == 0
             ? (measured->landing.armed_block == STORE_NONE ? "the start of the record" : "arming")
         : measured->is_start_missing ? "the first switch edge received"
                                      : "the first switch edge";
}

const char *measured_quality_text(const struct measured_landing *measured)
{
    static const char *const marks[3][2] = {
        {"", ", incomplete"},
        {", UNCALIBRATED", ", incomplete, UNCALIBRATED"},
        {", calibration unknown", ", incomplete, calibration unknown"}};
    return marks[!measured->has_calibration_dates ? 2 : measured->is_uncalibrated]
                [measured->is_start_missing];
}

bool measured_is_emulated(const struct store_landing *landing)
{
    const char *uid = landing->board_uid;
    return strlen(uid) == 24 && strncmp(uid + 8, MR_EMULATED_LOT_TEXT, 6) == 0;
}

void measured_free(struct measured_landing *measured)
{
    free(measured->track);
    free(measured->stretch);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        free(measured->channel[c].raw);
        free(measured->channel[c].validity);
        free(measured->channel[c].source);
    }
}

size_t measured_list_channels(const struct measured_landing *measured,
                              const struct measured_channel **channels)
{
    static const enum mr_channel_kind kinds[] = {MR_KIND_DISPLACEMENT, MR_KIND_TENSION};
    size_t count = 0;
    for (size_t k = 0; k < 2; k++) {
        for (unsigned number = 1; number <= MR_CHANNELS; number++) {
            int c = measured_channel_index(measured, kinds[k], number);
            if (c >= 0)
                channels[count++] = &measured->channel[c];
        }
    }
    return count;
}

#define BLOCKS_PER_HOUR 3600000.0

struct mr_error_conditions measured_error_conditions(const struct measured_landing *measured,
                                                     const struct measured_channel *channel,
                                                     double value, double samples)
{
    bool movement = channel->config.kind == MR_KIND_DISPLACEMENT;
    double stride = (double)channel->stride;
    return (struct mr_error_conditions){
        .value = (float)value,
        .noise = (float)channel->noise,
        .averaged_blocks = (float)fmax(samples / stride, 1.0),
        .baseline_blocks = movement ? (float)fmax((double)channel->rest_samples / stride, 1.0)
                                    : 0.0f,
        /* Hours since power-on, for an absolute reading: zero_error depends on the age of the zero.
         * A movement has no hours, because its baseline does not drift during a landing. */
        .hours = movement ? 0.0f : (float)((double)measured->first_block / BLOCKS_PER_HOUR),
        .reference_error = measured->channel[MR_TRANSDUCERS + MR_ADC1_REFERENCE].config.gain_error,
    };
}

double measured_standard_error(const struct measured_landing *measured,
                               const struct measured_channel *channel, double value, double samples)
{
    struct mr_error_conditions c = measured_error_conditions(measured, channel, value, samples);
    return (double)mr_reading_error(&channel->config, &c);
}

#define SUM_BITS 61 /* number of bits in a running sum, without the sign bit */

/* Returns the half width of the mean in which a peak is located. The value of the peak is a
 * narrower mean (get_peak_half_width), which excludes a step at the edge of the wider one. It
 * contains at least two values from each half of the readings (measured.h). */
static size_t get_search_half_width(const struct measured_channel *channel)
{
    return channel->stride > MEASURED_MEAN_BLOCKS / 4 ? 2 * channel->stride
                                                      : MEASURED_MEAN_BLOCKS / 2;
}
static size_t get_peak_half_width(const struct measured_channel *channel)
{
    return get_search_half_width(channel) - channel->stride;
}

double measured_peak_sample_count(const struct measured_channel *channel)
{
    return 2.0 * (double)get_peak_half_width(channel) + 1.0;
}

/* Sums over all earlier samples, for each half of the values. Successive values belong to the two
 * halves alternately. The sums are integers in `unit`, so the difference of two sums is exact. */
struct half_sums {
    struct running_sum {
        int64_t sum, count;
    } * half[2]; /* arrays with samples + 1 entries */
    double unit;
};

static struct half_sums make_half_sums(const struct measured_landing *measured,
                                       const struct measured_channel *channel)
{
    struct half_sums sums = {.unit = 1.0};
    double most = 1e-30; /* start value, because any unit will do if all samples are 0 */
    int value_bits, count_bits;
    for (size_t i = 0; i < measured->samples; i++) {
        double value = fabs(measured_value(channel, i));
        most = isfinite(value) ? fmax(most, value) : most;
    }
    (void)frexp(most, &value_bits);
    (void)frexp((double)measured->samples, &count_bits);
    sums.unit = ldexp(1.0, value_bits + count_bits - SUM_BITS);
    double counts_per_unit = 1.0 / sums.unit; /* exact, because unit is a power of two */
    for (size_t half = 0; half < 2; half++)
        sums.half[half] = xcalloc(measured->samples + 1, sizeof *sums.half[half]);
    /* counters, which replace slow divisions */
    size_t within = channel->phase % channel->stride, half = channel->phase / channel->stride % 2;
    for (size_t i = 0; i < measured->samples; i++) {
        double value = measured_value(channel, i);
        sums.half[0][i + 1] = sums.half[0][i];
        sums.half[1][i + 1] = sums.half[1][i];
        if (isfinite(value)) {
            sums.half[half][i + 1].sum += llrint(value * counts_per_unit);
            sums.half[half][i + 1].count++;
        }
        if (++within == channel->stride) {
            within = 0;
            half = 1 - half;
        }
    }
    return sums;
}

/* Returns the mean of one half of the values within `reach` samples of `sample`, or NaN if there is
 * no valid value. */
static double compute_half_mean(const struct half_sums *sums, size_t half, size_t sample,
                                size_t reach, size_t samples)
{
    const struct running_sum
        *from = &sums->half[half][sample > reach ? sample - reach : 0],
        *to = &sums->half[half][sample + reach < samples ? sample + reach + 1 : samples];
    return to->count > from->count
             ? sums->unit * (double)(to->sum - from->sum) / (double)(to->count - from->count)
             : (double)NAN;
}

void measured_find_peaks(const struct measured_landing *measured,
                         const struct measured_channel *channel, size_t from, double *high,
                         double *low)
{
    *high = *low = (double)NAN;
    if (measured->samples == 0) /* without samples, the stride is not known either */
        return;
    const size_t search = get_search_half_width(channel), peak = get_peak_half_width(channel);
    struct half_sums sums = make_half_sums(measured, channel);
    *high = *low = 0.0;
    for (size_t half = 0; half < 2; half++) {
        double most = (double)NAN, least = (double)NAN, at_most = (double)NAN,
               at_least = (double)NAN;
        for (size_t i = from; i < measured->samples; i++) {
            double value = compute_half_mean(&sums, half, i, search, measured->samples);
            if (isnan(value) || (value <= most && value >= least))
                continue;
            double other_mean = compute_half_mean(&sums, 1 - half, i, peak, measured->samples);
            if (isnan(other_mean))
                continue;
            if (!(value <= most)) {
                most = value;
                at_most = other_mean;
            }
            if (!(value >= least)) {
                least = value;
                at_least = other_mean;
            }
        }
        *high += at_most / 2.0;
        *low += at_least / 2.0;
    }
    free(sums.half[0]);
    free(sums.half[1]);
}

static const struct {
    const char *name;
    char letter;
    const char *text_if_only, *text_if_filled;
} sources[MEASURED_SOURCE_COUNT] = {
    [MEASURED_NO_SOURCE] = {"none", '-', "no readings were received", "from no source"},
    [MEASURED_SERIAL] = {"serial", 'S', "serial block records, 1 kHz", "from serial"},
    [MEASURED_CAN] = {"can", 'C', "CAN messages, displacements at 500 Hz and tensions at 250 Hz",
                      "from CAN (displacements at 500 Hz, tensions at 250 Hz)"},
    [MEASURED_BOX] = {"blackbox", 'B', "black box records, 1 kHz", "from the black box"},
    [MEASURED_IMPORT] = {"import", 'I', "a file of a different instrument",
                         "from a file of a different instrument"},
};

const char *measured_source_name(enum measured_source source)
{
    return sources[source].name;
}

char measured_source_letter(enum measured_source source)
{
    return sources[source].letter;
}

/* Describes the records that were excluded because of their time. Returns false if there are
 * none. */
static bool format_excluded(const struct measured_landing *measured, char *out, size_t size)
{
    const struct measured_excluded *aside = &measured->excluded;
    const struct {
        size_t count;
        const char *singular, *plural;
    } kinds[] = {{aside->blocks, "block record", "block records"},
                 {aside->messages, "CAN message", "CAN messages"},
                 {aside->edges, "switch edge", "switch edges"}};
    size_t used = 0;
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
        if (kinds[k].count && used < size)
            used += (size_t)snprintf(out + used, size - used, "%s%zu %s", used ? ", " : "",
                                     kinds[k].count,
                                     kinds[k].count == 1 ? kinds[k].singular : kinds[k].plural);
    }
    if (used && used < size)
        snprintf(out + used, size - used,
                 " left out: their times are far from the landing (first: board time %.3f s)",
                 (double)aside->first_block / 1000.0);
    return used != 0;
}

void measured_format_source(const struct measured_landing *measured, char out[MEASURED_SOURCE_SIZE])
{
    static const enum measured_source source_order[] = {MEASURED_SERIAL, MEASURED_BOX, MEASURED_CAN,
                                                        MEASURED_IMPORT, MEASURED_NO_SOURCE};
    size_t used = (size_t)snprintf(out, MEASURED_SOURCE_SIZE, "%s",
                                   sources[measured->source].text_if_only);
    const char *separator = ";";
    for (unsigned k = 0; k < MEASURED_SOURCE_COUNT && used < MEASURED_SOURCE_SIZE; k++) {
        size_t stretches = 0;
        if (source_order[k] == measured->source || !measured->blocks_by_source[source_order[k]])
            continue;
        for (size_t i = 0; i < measured->stretch_count; i++)
            stretches += measured->stretch[i].source == source_order[k];
        used += (size_t)snprintf(out + used, MEASURED_SOURCE_SIZE - used,
                                 "%s %lld of %zu ms %s, %zu %s", separator,
                                 (long long)measured->blocks_by_source[source_order[k]],
                                 measured->samples, sources[source_order[k]].text_if_filled,
                                 stretches, stretches == 1 ? "stretch" : "stretches");
        separator = ",";
    }
    if (measured->skipped_blocks && used < MEASURED_SOURCE_SIZE)
        used += (size_t)snprintf(
            out + used, MEASURED_SOURCE_SIZE - used,
            "; %lld ms of earlier readings are stored in the campaign but not shown",
            (long long)measured->skipped_blocks);
    if (used < MEASURED_SOURCE_SIZE &&
        format_excluded(measured, out + used + 2, MEASURED_SOURCE_SIZE - used - 2))
        memcpy(out + used, "; ", 2);
}

void measured_print_excluded(const struct measured_landing *measured, const struct cli *cli)
{
    char text[MEASURED_SOURCE_SIZE];
    if (format_excluded(measured, text, sizeof text))
        cli_note(cli, "RUN %lld: %s", (long long)measured->landing.id, text);
}

json_t *measured_excluded_json(const struct measured_landing *measured)
{
    const struct measured_excluded *aside = &measured->excluded;
    if (aside->blocks + aside->messages + aside->edges == 0)
        return json_null();
    return json_pack("{sIsIsIsI}", "blocks", (json_int_t)aside->blocks, "messages",
                     (json_int_t)aside->messages, "edges", (json_int_t)aside->edges, "first_block",
                     (json_int_t)aside->first_block);
}
