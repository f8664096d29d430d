#include "host/analyse/measured_peak.h"

#include <math.h>
#include <stdlib.h>

#define SUM_BITS 61 /* of a running sum, without sign */

/* Samples to each side in the means of which a peak is looked for, and, inside it, is taken from: a
 * step at the edge of the first is none in the second. Two values of each half at least. */
static size_t search_reach(const struct measured_channel *channel)
{
    return channel->stride > MEASURED_WINDOW / 4 ? 2 * channel->stride : MEASURED_WINDOW / 2;
}
static size_t peak_reach(const struct measured_channel *channel)
{
    return search_reach(channel) - channel->stride;
}

double measured_peak_samples(const struct measured_channel *channel)
{
    return 2.0 * (double)peak_reach(channel) + 1.0;
}

/* Which of the two halves a sample's value belongs to: every second value is of the same. */
static size_t half_of(const struct measured_channel *channel, size_t sample)
{
    return (sample + channel->phase) / channel->stride % 2;
}

/* The samples from `from` up to and without `to` that lie within `reach` of `sample`. */
struct window {
    size_t from, to;
};

static struct window window_at(const struct measured *measured, size_t sample, size_t reach)
{
    return (struct window){sample > reach ? sample - reach : 0, sample + reach < measured->samples
                                                                    ? sample + reach + 1
                                                                    : measured->samples};
}

/* The mean around a sample of one half of the values. NaN: none is valid. */
static double half_mean(const struct measured *measured, const struct measured_channel *channel,
                        size_t sample, size_t reach, size_t half)
{
    struct window window = window_at(measured, sample, reach);
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = window.from; i < window.to; i++) {
        double value = half_of(channel, i) == half ? measured_value(channel, i) : (double)NAN;
        if (!isnan(value)) {
            sum += value;
            count++;
        }
    }
    return count ? sum / (double)count : (double)NAN;
}

/* ---- running sums: nearly every sample is seen not to be the peak at the cost of two differences
 * ---- */

/* Of each half, over all samples before. Whole multiples of `unit`, so that no difference of two
 * sums depends on what came before. */
struct running {
    int64_t sum;
    int64_t count;
};

struct sums {
    struct running *half[2]; /* samples + 1 of each */
    double unit;             /* NaN: a value is infinite, and nothing can be told by sums */
};

/* The finest unit in which all values together fit a sum. */
static double unit_for(const struct measured *measured, const struct measured_channel *channel)
{
    double most = 1e-30; /* all zero: any unit does */
    int value_bits, count_bits;
    for (size_t i = 0; i < measured->samples; i++)
        most = fmax(most, fabs(measured_value(channel, i)));
    if (isinf(most))
        return (double)NAN;
    (void)frexp(most, &value_bits);
    (void)frexp((double)measured->samples, &count_bits);
    return ldexp(1.0, value_bits + count_bits - SUM_BITS);
}

static struct sums sums_of(const struct measured *measured, const struct measured_channel *channel)
{
    struct sums sums = {.unit = unit_for(measured, channel)};
    struct running now[2] = {{0, 0}, {0, 0}};
    for (size_t half = 0; half < 2; half++) {
        sums.half[half] = calloc(measured->samples + 1, sizeof *sums.half[half]);
        if (!sums.half[half])
            abort();
    }
    if (isnan(sums.unit))
        return sums;
    double per_unit = 1.0 / sums.unit; /* powers of two */
    /* counted on: dividing is dear */
    size_t within = channel->phase % channel->stride, half = half_of(channel, 0);
    for (size_t i = 0; i < measured->samples; i++) {
        double value = measured_value(channel, i);
        if (!isnan(value)) {
            now[half].sum += llrint(value * per_unit);
            now[half].count++;
        }
        sums.half[0][i + 1] = now[0];
        sums.half[1][i + 1] = now[1];
        if (++within == channel->stride) {
            within = 0;
            half = 1 - half;
        }
    }
    return sums;
}

/* Of each sample from `from` on half_mean, to half a unit; NaN also where the other half has no
 * value to take a peak from. Without sums every sample has the same. */
static double *rough_means(const struct measured *measured, const struct measured_channel *channel,
                           const struct sums *sums, size_t from, size_t half)
{
    const struct running *mine = sums->half[half], *others = sums->half[1 - half];
    double *mean = calloc(measured->samples + 1, sizeof *mean);
    if (!mean)
        abort();
    for (size_t i = from; i < measured->samples && !isnan(sums->unit); i++) {
        struct window search = window_at(measured, i, search_reach(channel)),
                      peak = window_at(measured, i, peak_reach(channel));
        int64_t count = mine[search.to].count - mine[search.from].count;
        bool usable = count > 0 && others[peak.to].count > others[peak.from].count;
        mean[i] = usable ? sums->unit * (double)(mine[search.to].sum - mine[search.from].sum) /
                               (double)count
                         : (double)NAN;
    }
    return mean;
}

/* What a rough mean must come to on the side of `sign` for half_mean to be the largest. */
static double least_of_peaks(const double *rough, size_t from, size_t to, double sign, double unit)
{
    double most = -(double)INFINITY;
    for (size_t i = from; i < to; i++)
        most = sign * rough[i] > most ? sign * rough[i] : most;
    /* sums round, and so does adding up a mean */
    return isnan(unit) ? most : most - 4.0 * unit - 1e-12 * fabs(most);
}

/* The extreme on the side of `sign`: found in one half, whose rough means are given, taken from the
 * other. */
static double extreme(const struct measured *measured, const struct measured_channel *channel,
                      const double *rough, double unit, size_t from, double sign, size_t half)
{
    double most = (double)NAN, other = (double)NAN;
    double least = least_of_peaks(rough, from, measured->samples, sign, unit);
    for (size_t i = from; i < measured->samples; i++) {
        if (!(sign * rough[i] >= least))
            continue;
        double value = sign * half_mean(measured, channel, i, search_reach(channel), half);
        if (isnan(value) || value <= most)
            continue;
        double there = half_mean(measured, channel, i, peak_reach(channel), 1 - half);
        if (isnan(there))
            continue;
        most = value;
        other = there;
    }
    return other;
}

void measured_peaks(const struct measured *measured, const struct measured_channel *channel,
                    size_t from, double *high, double *low)
{
    *high = *low = (double)NAN;
    if (measured->samples == 0) /* nor has the channel a stride then */
        return;
    struct sums sums = sums_of(measured, channel);
    *high = *low = 0.0;
    for (size_t half = 0; half < 2; half++) {
        double *rough = rough_means(measured, channel, &sums, from, half);
        *high += extreme(measured, channel, rough, sums.unit, from, 1.0, half) / 2.0;
        *low += extreme(measured, channel, rough, sums.unit, from, -1.0, half) / 2.0;
        free(rough);
    }
    free(sums.half[0]);
    free(sums.half[1]);
}
