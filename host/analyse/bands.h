/* Bands of a landing: the board's messages about them, where the wheel was then, and the shunt
 * calibrations around it. */
#ifndef MATRIG_HOST_ANALYSE_BANDS_H
#define MATRIG_HOST_ANALYSE_BANDS_H

#include "host/base/answer.h"
#include "host/analyse/measured.h"
#include "host/store/store.h"

struct bands_shunt { /* one gage, before and after the landing */
    unsigned gage;
    double expected_lb, before_lb, after_lb; /* NaN: not calibrated then, or not valid */
    int64_t before_verdict, after_verdict;   /* as in the message; STORE_NONE: not calibrated */
};

struct bands_summary {
    struct store_band *band;
    size_t bands;
    struct store_band_event *event;
    size_t events;
    struct bands_shunt shunt[MR_GAGES];
    size_t shunts;
};

/* MR_OK also without messages from the board. Calibrations count until the board is armed again in
 * the same session. */
enum mr_status bands_load(struct store *store, const struct measured *measured,
                          struct bands_summary *bands, struct error *error);
void bands_free(struct bands_summary *bands);

/* Tensions of the bands, and what the board found wrong with them. */
void bands_answer(const struct bands_summary *bands, const struct measured *measured,
                  struct answer *answer);
/* What shunt calibrations found: people read one line and, with `each`, every gage. */
void bands_shunts_answer(const struct bands_summary *bands, bool each, struct answer *answer);
#endif
