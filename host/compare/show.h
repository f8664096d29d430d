/* The answer of a comparison (host/base/answer.h): text of at most 100 columns, and JSON. */
#ifndef MATRIG_HOST_COMPARE_SHOW_H
#define MATRIG_HOST_COMPARE_SHOW_H

#include <stdio.h>

#include "host/base/answer.h"
#include "host/compare/landing.h"

void compare_to_answer(const struct compare_figures *figures, const struct compare_verdict *verdict,
                       struct answer *answer);
/* Adds the main results as text. */
void compare_add_summary(const struct compare_figures *figures,
                         const struct compare_verdict *verdict, struct answer *answer);
void compare_series_to_answer(const struct compare_series *set, struct answer *answer);
/* Checks the results against limits and stores the verdict of a landing, or of a series and its
 * landings. */
void compare_check(const struct compare_figures *figures, const struct compare_limits *limits,
                   struct compare_verdict *verdict);
void compare_series_check(struct compare_series *set, const struct compare_limits *limits);
/* Parts of a landing's answer: the table of its transducers with an explanation of its columns, and
 * the zones at each moment. */
void compare_add_channels(const struct compare_figures *figures, struct answer *answer);
void compare_add_zones(const struct compare_zones *zones, struct answer *answer);

/* Writes CSV with one row per millisecond: t_s, then for each transducer the measured value, its
 * error, the simulated value, its error, and the error of the alignment. The head has the units. */
void compare_write_csv(FILE *out, const struct compare_landing *landing, bool si);

#endif
