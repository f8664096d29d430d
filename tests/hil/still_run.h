/* A rig at rest. */
#ifndef MATRIG_TESTS_HIL_STILL_RUN_H
#define MATRIG_TESTS_HIL_STILL_RUN_H

#include <stdlib.h>

#include "hil/rig/runfile.h"
#include "tests/cmocka_all.h"

/* A run in which nothing moves and no switch opens, with zero displacement and tension. */
static inline void still_run(struct hil_run *run, double duration_s)
{
    *run = (struct hil_run){.duration_s = duration_s, .sample_rate_hz = 1.0, .sample_count = 1};
    run->samples = calloc(1, sizeof *run->samples);
    assert_non_null(run->samples);
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        run->switch_open_ps[i] = HIL_RUN_NEVER;
}

#endif
