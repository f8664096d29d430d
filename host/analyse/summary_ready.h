/* What `matrig ready` had found before a landing: the newest check and the newest walk of its
 * board, within 12 h before arming. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_READY_H
#define MATRIG_HOST_ANALYSE_SUMMARY_READY_H

#include "host/base/answer.h"
#include "host/store/store.h"

#define SUMMARY_READY_KINDS 2

struct summary_ready {
    bool known;
    bool go;
    double before_min; /* minutes before arming */
    char no_go[400];   /* "switch 12: did not answer; ..." */
};

/* One for each kind: ready, walk. */
enum mr_status summary_ready_load(struct store *store, const struct store_landing *landing,
                                  struct summary_ready ready[SUMMARY_READY_KINDS],
                                  struct error *error);
/* "go, 14 min before", with what was not when it was no-go; for programs "readiness", in which null
 * was not done. */
void summary_ready_answer(const struct summary_ready ready[SUMMARY_READY_KINDS],
                          struct answer *answer);

#endif
