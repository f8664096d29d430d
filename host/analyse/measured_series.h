/* The series of a measured landing: from block records where there are any, the rest from CAN
 * messages. Only measured.c, and the parts measured_import.c. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_SERIES_H
#define MATRIG_HOST_ANALYSE_MEASURED_SERIES_H

#include "host/analyse/measured.h"
#include "host/analyse/measured_moments.h"

/* Fills source, first_block, samples, the raw series and validities, and, with both links, the
 * check of one against the other. Needs landing and channel configuration. */
enum mr_status measured_load_series(struct store *store, struct measured *measured,
                                    struct error *error);

struct measured_span {
    int64_t first, last; /* blocks, both in it */
    bool any;
};
void measured_span_add(struct measured_span *span, int64_t first, int64_t last);
/* MR_MALFORMED: longer than an hour, so there is an impossible block number in it. */
enum mr_status measured_check_span(const struct measured *measured, int64_t first, int64_t last,
                                   struct error *error);
/* Room for the samples of every measuring channel, all lost so far. MR_FULL. */
enum mr_status measured_make_series(struct measured *measured, const struct measured_span *span,
                                    struct error *error);
/* With the landing's edges: which times belong to it; edges that do not are set aside. MR_FULL. */
enum mr_status measured_judge(struct measured *measured, struct moments *moments,
                              struct error *error);

#endif
