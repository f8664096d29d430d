/* What a campaign keeps of a board between two checks of matrig ready. */
#ifndef MATRIG_HOST_READYKEPT_H
#define MATRIG_HOST_READYKEPT_H

#include "host/board/ready.h"
#include "host/store/store.h"

/* What this board was at its last landing, its last shunt calibration, and how its channels were
 * calibrated. */
enum mr_status readykept_look_back(struct store *store, struct ready_facts *f, struct error *error);
/* `kind`: "ready" or "walk"; `f` of a check, NULL of a walk. The row: {"checks": [...], "spans_lb":
 * [...], "calibration": [...]}. */
enum mr_status readykept_save(struct store *store, const struct identity *identity,
                              const char *kind, const struct ready_report *report,
                              const struct ready_facts *f, int64_t made_us, struct error *error);

#endif
