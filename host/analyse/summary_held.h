/* What kept a landing's campaign from being written while it was logged. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_HELD_H
#define MATRIG_HOST_ANALYSE_SUMMARY_HELD_H

#include "host/base/answer.h"
#include "host/store/store_log.h"

/* for people nothing when nothing did */
void summary_held_answer(const struct store_held *held, struct answer *answer);

#endif
