/* One landing of a campaign compared with a model, and the comparison kept in the campaign. */
#ifndef MATRIG_HOST_COMPARE_LANDING_H
#define MATRIG_HOST_COMPARE_LANDING_H

#include "host/compare/figures.h"
#include "host/compare/model.h"

struct compare_landing {
    struct compare_figures figures;
    struct measured measured;
    struct store_simulation_head head;
    struct store_simulation row[MR_TRANSDUCERS]; /* aligned with the measured */
    size_t rows;
    /* of the gage points by this landing, simulated */
    double moved_in[SURVEY_POINTS], moved_spread_in[SURVEY_POINTS];
};

/* RUN as landing `index` (from 0) of the model's series: simulated, aligned, compared and kept; it
 * replaces no earlier comparison. MR_TOO_FEW, MR_TRUNCATED: nothing to compare with (no motion, no
 * transducers, no edges), the model is as before. The caller frees, also after an error. */
enum mr_status compare_landing(struct store *store, int64_t run, struct compare_model *model,
                               size_t index, struct compare_landing *landing, struct error *error);
void compare_landing_free(struct compare_landing *landing);

#endif
