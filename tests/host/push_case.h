/* Push tests of a ground that is known: the law stepped from force to force, then read by gages. */
#ifndef MATRIG_TESTS_HOST_PUSH_CASE_H
#define MATRIG_TESTS_HOST_PUSH_CASE_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "host/push/fit.h"

struct push_truth {
    double k_lb_in, unloading; /* of all mats; INFINITY: rigid */
    double limit_lb;
    double force_error_lb, displacement_error_in;
    bool rounds; /* errors are the gages' divisions, else normal */
};

/* Uniform in (0, 1): a 64-bit xorshift*. */
static inline double push_random(uint64_t *seed)
{
    *seed ^= *seed >> 12;
    *seed ^= *seed << 25;
    *seed ^= *seed >> 27;
    return ((double)((*seed * 2685821657736338717ull) >> 11) + 0.5) / 9007199254740992.0;
}

static inline double push_normal(uint64_t *seed)
{
    double u = push_random(seed), v = push_random(seed);
    return sqrt(-2.0 * log(u)) * cos(2.0 * M_PI * v);
}

static inline double push_read(double value, double error, bool rounds, uint64_t *seed)
{
    return rounds ? error * floor(value / error + 0.5) : value + error * push_normal(seed);
}

/* One reading more at this true force; *displacement_in and *hold_lb are where the ground was left.
 * A mat at its limit is pulled on by slide_in. */
static inline void push_step(struct push_series *series, const struct push_truth *truth,
                             double force_lb, double slide_in, double *displacement_in,
                             double *hold_lb, uint64_t *seed)
{
    double to = fmin(force_lb, truth->limit_lb), change = to - *hold_lb;
    *displacement_in += (change < 0.0 ? truth->unloading : 1.0) * change / truth->k_lb_in;
    if (force_lb >= truth->limit_lb)
        *displacement_in += slide_in;
    *hold_lb = to;
    series->force_lb[series->count] = push_read(to, truth->force_error_lb, truth->rounds, seed);
    series->displacement_in[series->count++] =
        push_read(*displacement_in, truth->displacement_error_in, truth->rounds, seed);
}

/* From 0 up to most_lb in steps, and down again. */
static inline struct push_series push_test(const struct push_truth *truth, double load_lb,
                                           double step_lb, double most_lb, bool down,
                                           uint64_t *seed)
{
    struct push_series series = {.load_lb = load_lb};
    double displacement_in = 0.0, hold_lb = 0.0, force_lb = 0.0;
    for (; force_lb <= most_lb + 1e-9; force_lb += step_lb)
        push_step(&series, truth, force_lb, 0.01, &displacement_in, &hold_lb, seed);
    for (force_lb = most_lb - 2.0 * step_lb; down && force_lb > -1e-9; force_lb -= 2.0 * step_lb)
        push_step(&series, truth, force_lb, 0.0, &displacement_in, &hold_lb, seed);
    return series;
}

#endif
