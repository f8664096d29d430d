/* What was found in a bundle (host/base/answer.h). */
#ifndef MATRIG_HOST_BUNDLE_SHOW_H
#define MATRIG_HOST_BUNDLE_SHOW_H

#include "host/base/answer.h"
#include "host/bundle/bundle.h"

/* The verdict, every file, and those tables that are not whole (`saved` NULL: nothing was to be
 * saved). */
void bundle_answer(const struct bundle_check *check, const bool saved[BUNDLE_FILES],
                   struct answer *answer);

#endif
