/* A landing at a glance: what a list of a campaign's landings says of each, in the numbers of its
 * summary. The series are read only where the rest leaves a doubt, so that a list of thousands is
 * there at once. */
#ifndef MATRIG_HOST_ANALYSE_PREVIEW_H
#define MATRIG_HOST_ANALYSE_PREVIEW_H

#include "host/analyse/summary.h"
#include "host/store/store_journal.h"

struct preview {
    struct measured measured; /* as measured_load_gear has it */
    struct zones zones;
    struct summary_link link[LINK_KINDS]; /* lost, dropped, silent */
    struct store_series series;           /* id 0: none */
    bool is_void, imported;
    uint16_t can_base;           /* of its board */
    struct store_change *change; /* what people said */
    size_t changes;
    size_t seen; /* waves and breaks, without those that were withdrawn */
    struct store_edge *edge;
    size_t edges;
};

/* The caller releases it with preview_free, also after an error. */
enum mr_status preview_load(struct store *store, int64_t run, struct preview *glance,
                            struct error *error);
void preview_free(struct preview *glance);

/* A row of the list. `same`: the earlier RUN that is the same landing, 0: none. `bases`: people see
 * where on CAN its board was. */
void preview_answer(const struct preview *glance, int64_t same, bool bases, struct answer *answer);

#endif
