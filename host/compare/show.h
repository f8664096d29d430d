/* What a comparison answers (host/base/answer.h): for people within 100 columns, and as JSON. */
#ifndef MATRIG_HOST_COMPARE_SHOW_H
#define MATRIG_HOST_COMPARE_SHOW_H

#include <stdio.h>

#include "host/base/answer.h"
#include "host/compare/landing.h"

void compare_answer(const struct compare_figures *figures, const struct compare_verdict *verdict,
                    struct answer *answer);
/* What matters of it, for people. */
void compare_brief_answer(const struct compare_figures *figures,
                          const struct compare_verdict *verdict, struct answer *answer);
void compare_series_answer(const struct compare_series *set, struct answer *answer);
/* The result against limits, into the verdict of a landing, or of a series and its landings. */
void compare_judge(const struct compare_figures *figures, const struct compare_limits *limits,
                   struct compare_verdict *verdict);
void compare_series_judge(struct compare_series *set, const struct compare_limits *limits);
/* Parts of a landing's: the table of its transducers with what its words mean, and what each
 * moment's zones are. */
void compare_channels_answer(const struct compare_figures *figures, struct answer *answer);
void compare_zones_answer(const struct compare_zones *zones, struct answer *answer);

/* CSV, a row a millisecond: t_s, then of each transducer measured, its error, simulated, its error,
 * alignment's part; units in the head. */
void compare_csv(FILE *out, const struct compare_landing *landing, bool si);

#endif
