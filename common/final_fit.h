/* The final fit of a landing in steps: mr_gates_summarise for a board that must not leave its
 * blocks waiting.
 *
 * Each step fits once, at most some 200,000 operations of software double precision or 8 ms on the
 * board, and the same bits come out as from mr_gates_summarise, which is these steps in a row. The
 * work is the caller's; it points to the gates, which must not change meanwhile. */
#ifndef MATRIG_COMMON_FINAL_FIT_H
#define MATRIG_COMMON_FINAL_FIT_H

#include <stdbool.h>
#include <stddef.h>

#include "common/braking.h"
#include "common/gates.h"

enum mr_final_stage { MR_FINAL_WHOLE, MR_FINAL_START, MR_FINAL_REST, MR_FINAL_OVER };

struct mr_final_fit {
    const struct mr_gate *gates;
    size_t count;
    size_t on_track;
    double touchdown_ft;
    double position_error_ft;
    enum mr_final_stage stage;
    bool fitted; /* the present part once; what follows leaves gates out */
    size_t used; /* gates beyond touchdown of the present part */
    struct mr_braking braking;
    struct mr_gates_summary summary;
    enum mr_status status; /* when over: as mr_gates_summarise */
};

void mr_final_fit_start(struct mr_final_fit *work, const struct mr_gate *gates, size_t count,
                        double touchdown_ft, double position_error_ft);
/* False: it is over, `status` and `summary` say how. */
bool mr_final_fit_step(struct mr_final_fit *work);

#endif
