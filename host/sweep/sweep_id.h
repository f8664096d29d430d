/* Ids of a study's cases: README.md, "The case's id". */
#ifndef MATRIG_HOST_SWEEP_SWEEP_ID_H
#define MATRIG_HOST_SWEEP_SWEEP_ID_H

#include "host/sweep/sweep_study.h"

/* Allocates ids and order, which sweep_study_free releases. MR_MALFORMED: two cases are the same,
 * or a key leads nowhere; MR_FULL. `path` begins the errors. */
enum mr_status sweep_study_make_ids(struct sweep_study *study, const char *path,
                                    struct error *error);

#endif
