/* Restraining bands of a landing: the board's messages about the bands, the wheel position at each
 * message, and the shunt calibrations before and after the landing. */
#ifndef MATRIG_HOST_ANALYSE_BANDS_H
#define MATRIG_HOST_ANALYSE_BANDS_H

#include "host/base/answer.h"
#include "host/analyse/measured.h"
#include "host/store/store.h"

struct bands_shunt { /* Shunt calibrations of one gage, before and after the landing. */
    unsigned gage;
    double expected_lb, before_lb, after_lb; /* NaN: not calibrated at that time, or not valid */
    /* verdicts that the board sent; STORE_NONE: not calibrated */
    int64_t verdict_before, verdict_after;
};

struct bands_summary {
    struct store_band *band;
    size_t band_count;
    struct store_band_event *event;
    size_t event_count;
    struct bands_shunt shunt[MR_GAGES];
    size_t shunt_count;
};

/* Returns MR_OK even if the board sent no messages about bands. A shunt calibration belongs to the
 * landing until the board is armed again in the same session. */
enum mr_status bands_load(struct store *store, const struct measured_landing *measured,
                          struct bands_summary *bands, struct error *error);
void bands_free(struct bands_summary *bands);

/* Adds the tensions of the bands, and the faults that the board found in them. */
void bands_to_answer(const struct bands_summary *bands, const struct measured_landing *measured,
                     struct answer *answer);
/* Adds the results of the shunt calibrations. Text output has one summary line; with `each`, it
 * also has a line for every gage. */
void bands_add_shunts(const struct bands_summary *bands, bool each, struct answer *answer);
#endif
