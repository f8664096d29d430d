#include "tests/score/stats.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/statistics.h"
#include "tests/score/score.h"

#define ROUNDS 30u
#define DRAWS  1000u

/* Solves a x = b (symmetric, positive) in place by Cholesky's way; b becomes x. */
static void solve(double a[STATS_INPUTS][STATS_INPUTS], double *b, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j <= i; j++) {
            double sum = a[i][j];
            for (size_t k = 0; k < j; k++)
                sum -= a[i][k] * a[j][k];
            a[i][j] = i == j ? sqrt(fmax(sum, 1e-12)) : sum / a[j][j];
        }
        for (size_t k = 0; k < i; k++)
            b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++)
            b[i] -= a[k][i] * b[k];
        b[i] /= a[i][i];
    }
}

double stats_rule(const double *weight, const float *input, size_t inputs)
{
    double sum = 0.0;
    for (size_t k = 0; k < inputs; k++)
        sum += weight[k] * (double)input[k];
    return 1.0 / (1.0 + exp(-sum));
}

void stats_fit(const float *input, const bool *event, size_t count, size_t inputs, double ridge,
               double *weight)
{
    memset(weight, 0, inputs * sizeof *weight);
    for (unsigned round = 0; round < ROUNDS; round++) {
        double a[STATS_INPUTS][STATS_INPUTS] = {{0}}, b[STATS_INPUTS] = {0};
        for (size_t i = 0; i < count; i++) {
            const float *x = input + i * inputs;
            double p = stats_rule(weight, x, inputs), off = event[i] - p;
            for (size_t k = 0; k < inputs; k++) {
                b[k] += off * (double)x[k];
                for (size_t j = 0; j < inputs; j++)
                    a[k][j] += p * (1.0 - p) * (double)x[k] * (double)x[j];
            }
        }
        for (size_t k = 0; k < inputs; k++) {
            a[k][k] += ridge;
            b[k] -= ridge * weight[k];
        }
        solve(a, b, inputs);
        for (size_t k = 0; k < inputs; k++)
            weight[k] += b[k];
    }
}

void stats_held(const float *said, const bool *event, size_t count, struct stats_held *held)
{
    double events = 0.0, n = (double)count;
    *held = (struct stats_held){0};
    for (size_t i = 0; i < count; i++) {
        double p = (double)said[i], off = p - event[i];
        unsigned bin = (unsigned)fmin(STATS_BINS * p, STATS_BINS - 1.0);
        held->brier += off * off / n;
        held->said[bin] += p;
        held->count[bin]++;
        held->events[bin] += event[i];
        events += event[i];
    }
    for (unsigned b = 0; b < STATS_BINS; b++) {
        double in = held->count[b], rate = events / n;
        held->said[b] /= in;
        held->seen[b] = held->events[b] / in;
        if (!held->count[b])
            continue;
        held->reliability += in / n * pow(held->said[b] - held->seen[b], 2.0);
        held->resolution += in / n * pow(held->seen[b] - rate, 2.0);
    }
    held->uncertainty = events / n * (1.0 - events / n);
}

/* Landings as often as their series was drawn. */
static size_t draw_again(const float *rank, const bool *event, const uint16_t *series, size_t count,
                         const unsigned *times, float *to, bool *to_event)
{
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        for (unsigned t = 0; t < times[series[i]]; t++) {
            to[n] = rank[i];
            to_event[n++] = event[i];
        }
    }
    return n;
}

struct stats_lead stats_lead(const float *own, const float *other, const bool *event,
                             const uint16_t *series, size_t count)
{
    static unsigned times[UINT16_MAX + 1u];
    static uint16_t all[UINT16_MAX + 1u];
    static double lead[DRAWS];
    struct stats_lead result = {score_auc(own, event, count), score_auc(other, event, count),
                                (double)NAN, (double)NAN};
    uint64_t state = 0xb0075000u;
    size_t several = 0, draws = 0;
    for (size_t i = 0; i < count; i++) {
        if (!i || series[i] != series[i - 1])
            all[several++] = series[i];
    }
    float *rank = calloc(SCORE_LANDINGS * several + 1, sizeof *rank);
    bool *drawn = calloc(SCORE_LANDINGS * several + 1, sizeof *drawn);
    for (unsigned d = 0; rank && drawn && several && d < DRAWS; d++) {
        memset(times, 0, sizeof times);
        for (size_t s = 0; s < several; s++)
            times[all[(size_t)(score_uniform(&state) * (double)several)]]++;
        size_t n = draw_again(own, event, series, count, times, rank, drawn);
        double area = score_auc(rank, drawn, n);
        n = draw_again(other, event, series, count, times, rank, drawn);
        area -= score_auc(rank, drawn, n);
        if (!isnan(area))
            lead[draws++] = area;
    }
    free(rank);
    free(drawn);
    sort_numbers(lead, draws);
    if (draws) {
        result.low = lead[draws / 40];
        result.high = lead[draws - draws / 40 - 1];
    }
    return result;
}
