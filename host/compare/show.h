/* What a comparison answers (host/base/answer.h): for people within 100 columns, and as JSON. */
#ifndef MATRIG_HOST_COMPARE_SHOW_H
#define MATRIG_HOST_COMPARE_SHOW_H

#include "host/base/answer.h"
#include "host/compare/series.h"

void compare_answer(const struct compare_figures *figures, const struct compare_verdict *verdict,
                    struct answer *answer);
void compare_series_answer(const struct compare_series *set, struct answer *answer);
/* Parts of a landing's: the table of its transducers with what its words mean, and what each
 * moment's zones are. */
void compare_channels_answer(const struct compare_figures *figures, struct answer *answer);
void compare_zones_answer(const struct compare_zones *zones, struct answer *answer);

#endif
