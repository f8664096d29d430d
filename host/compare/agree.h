/* Whether measured and simulated agree, in a sentence: which value differs most, by how much,
 * where, and what errors say so.
 *
 * Values are the peak, the end and the arrival of each transducer that was compared. Two agree
 * while En, their difference over twice their common standard error (signal.h), is at most 1. */
#ifndef MATRIG_HOST_COMPARE_AGREE_H
#define MATRIG_HOST_COMPARE_AGREE_H

#include "host/compare/figures.h"

#define COMPARE_SENTENCE 600

enum compare_value { COMPARE_PEAK, COMPARE_END, COMPARE_ARRIVAL, COMPARE_VALUES };

struct compare_agreement {
    int64_t run;
    const char *against;   /* what was simulated: a file */
    size_t judged, differ; /* values whose En is known; of them beyond 1 */
    size_t unknown;        /* of channels that were compared */
    size_t left_out;       /* fitted channels that were not compared */
    /* The value with the largest En; channel NULL: none is known. Inches, for COMPARE_ARRIVAL
     * seconds. */
    const struct compare_channel *channel; /* of the figures */
    enum compare_value value;
    double measured, measured_error, simulated, simulated_error;
    double difference; /* measured - simulated */
    double error;      /* common standard error of the difference */
    double en;
    double measured_t_s, simulated_t_s; /* when; NaN for COMPARE_END */
};

/* Points into `figures`. */
void compare_agreement(const struct compare_figures *figures, struct compare_agreement *agreement);
/* "peak", "end", "arrival". Static storage. */
const char *compare_value_text(enum compare_value value);
/* One sentence, without an end of line. */
void compare_sentence(const struct compare_agreement *agreement, bool si,
                      char out[COMPARE_SENTENCE]);
/* Of several: how many differ, and the sentence of the one that does so most. */
void compare_sentence_of(const struct compare_figures *const *figures, size_t count, bool si,
                         char out[COMPARE_SENTENCE]);

#endif
