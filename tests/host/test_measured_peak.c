/* Peaks against a second way of finding them: each mean of each half added up anew, over series
 * with holes, plateaus and messages. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/measured.h"
#include "tests/cmocka_all.h"

#define SAMPLES 3000

/* By the definition: `reach` samples to each side, every second value, of `stride` samples each, of
 * parity `half`. */
static double mean_of(const double *value, size_t count, size_t stride, size_t phase, size_t at,
                      size_t reach, size_t half)
{
    double sum = 0.0;
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        bool near = i + reach >= at && i <= at + reach;
        if (!near || (i + phase) / stride % 2 != half || isnan(value[i]))
            continue;
        sum += value[i];
        n++;
    }
    return n ? sum / (double)n : (double)NAN;
}

static double peak_of(const double *value, size_t count, size_t stride, size_t phase, size_t from,
                      double sign)
{
    size_t reach = stride > 2 ? 2 * stride : 5;
    double sum = 0.0;
    for (size_t half = 0; half < 2; half++) {
        double most = (double)NAN, other = (double)NAN;
        for (size_t i = from; i < count; i++) {
            double mean = sign * mean_of(value, count, stride, phase, i, reach, half);
            double there = mean_of(value, count, stride, phase, i, reach - stride, 1 - half);
            if (isnan(mean) || isnan(there) || mean <= most)
                continue;
            most = mean;
            other = there;
        }
        sum += other;
    }
    return sum / 2.0;
}

static double noise(void)
{
    return (double)rand() / RAND_MAX - 0.5;
}

/* One series as a channel has it; `kind` says what is in it. */
static void series(int kind, float *raw, size_t stride)
{
    float level = 0.0f;
    for (size_t i = 0; i < SAMPLES; i++) {
        double t = (double)i / SAMPLES;
        if (i % stride == 0)
            level = (float)(kind == 0
                                ? 900.0 + 3000.0 * exp(-pow((t - 0.4) / 0.05, 2.0)) + 20.0 * noise()
                            : kind == 1 ? 1e-3 * noise()
                            : kind == 2 ? 1e6 * noise()
                                        : 2.5);
        bool hole = kind == 0 && ((i > 1180 && i < 1187) || rand() % 50 == 0);
        raw[i] = hole ? NAN : level;
    }
}

TEST(found_as_by_the_definition)
{
    static float raw[SAMPLES];
    static double value[SAMPLES];
    const size_t strides[] = {1, 2, 4};
    srand(11);
    for (int kind = 0; kind < 4; kind++) {
        for (size_t s = 0; s < 3; s++) {
            struct measured_landing measured = {.samples = SAMPLES};
            struct measured_channel channel = {.config.kind = kind % 2 ? MR_KIND_DISPLACEMENT
                                                                       : MR_KIND_TENSION,
                                               .raw = raw,
                                               .baseline = 0.3,
                                               .stride = strides[s],
                                               .phase = s};
            double high, low;
            series(kind, raw, strides[s]);
            for (size_t i = 0; i < SAMPLES; i++)
                value[i] = (double)raw[i] - (kind % 2 ? 0.3 : 0.0);
            measured_find_peaks(&measured, &channel, 700, &high, &low);
            double size = kind == 0 ? 1e4 : kind == 2 ? 1e6 : 1.0;
            assert_near(high, peak_of(value, SAMPLES, strides[s], s, 700, 1.0), 1e-12 * size);
            assert_near(low, peak_of(value, SAMPLES, strides[s], s, 700, -1.0), 1e-12 * size);
        }
    }
}

TEST(nothing_valid_is_nan)
{
    static float raw[SAMPLES];
    struct measured_landing measured = {.samples = SAMPLES};
    struct measured_channel channel = {.config.kind = MR_KIND_TENSION, .raw = raw, .stride = 1};
    double high, low;
    for (size_t i = 0; i < SAMPLES; i++)
        raw[i] = NAN;
    measured_find_peaks(&measured, &channel, 0, &high, &low);
    assert_true(isnan(high) && isnan(low));
    for (size_t i = 0; i < SAMPLES; i += 2) /* of one half alone: none to take a peak from */
        raw[i] = 1.0f;
    measured_find_peaks(&measured, &channel, 0, &high, &low);
    assert_true(isnan(high) && isnan(low));
}

/* It is none. */
TEST(an_infinite_reading)
{
    static float raw[SAMPLES];
    struct measured_landing measured = {.samples = SAMPLES};
    struct measured_channel channel = {.config.kind = MR_KIND_TENSION, .raw = raw, .stride = 1};
    double high, low;
    raw[100] = raw[101] = INFINITY;
    raw[2000] = raw[2001] = raw[2002] = raw[2003] = -6.0f;
    measured_find_peaks(&measured, &channel, 0, &high, &low);
    assert_true(high == 0.0 && low < 0.0);
}
