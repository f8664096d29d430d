/* Surveyed: the sums of the gaps of each segment before and after a landing. What was read at gage
 * points between two landings (`matrig survey`, with the error of its readings) holds; a segment
 * that was not read then is as the board had it when the landing was armed. */
#ifndef MATRIG_HOST_STUDY_FIT_SURVEYED_H
#define MATRIG_HOST_STUDY_FIT_SURVEYED_H

#include "host/store/store.h"

struct fit_surveyed {
    double sum_in[MR_SEGMENTS]; /* NaN: not surveyed */
    double error_in;            /* of a sum that was read at gage points; 0: none was */
    size_t segments, gages;     /* how many are known, and how many of them from gage points */
};

enum mr_status fit_surveyed_before(struct store *store, int64_t run, struct fit_surveyed *surveyed,
                                   struct error *error);
/* Until the next landing of the campaign is armed. The board's own is known from then on: `next` is
 * that landing, or STORE_NONE. */
enum mr_status fit_surveyed_after(struct store *store, int64_t run, int64_t next,
                                  struct fit_surveyed *surveyed, struct error *error);

#endif
