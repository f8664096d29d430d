/* What forecasts are judged by: a logistic rule and its fit, paired leads with whole series drawn
 * again, Brier's score and its parts. */
#ifndef MATRIG_TESTS_SCORE_STATS_H
#define MATRIG_TESTS_SCORE_STATS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STATS_INPUTS 12
#define STATS_BINS   5

/* Weights of a logistic rule by Newton's steps, drawn to 0 by a ridge; `input`: `inputs` of each of
 * `count`, at most STATS_INPUTS. */
void stats_fit(const float *input, const bool *event, size_t count, size_t inputs, double ridge,
               double *weight);
double stats_rule(const double *weight, const float *input, size_t inputs);

/* Brier's score, and Murphy's parts by fifths (J. Appl. Meteorol. 12 (1973) 595): reliability less
 * resolution and with uncertainty is the score, but for what differs within a fifth. */
struct stats_held {
    double brier, reliability, resolution, uncertainty;
    double said[STATS_BINS], seen[STATS_BINS]; /* means; NaN: nothing in it */
    unsigned count[STATS_BINS], events[STATS_BINS];
};
void stats_held(const float *said, const bool *event, size_t count, struct stats_held *held);

/* Area of `own` less that of `other` on the same landings, and its 95 % interval: series are drawn
 * with replacement, always the same way. */
struct stats_lead {
    double area, other, low, high;
};
struct stats_lead stats_lead(const float *own, const float *other, const bool *event,
                             const uint16_t *series, size_t count);

#endif
