/* The gear as a board knows it in the course of a landing: from the switch edges that it has named
 * so far (common/onboard/landing.c does the same, from blocks). Feet and seconds. */
#ifndef MATRIG_TESTS_SCORE_KNOWN_GEAR_H
#define MATRIG_TESTS_SCORE_KNOWN_GEAR_H

#include <stdbool.h>
#include <stddef.h>

#include "common/gates.h"
#include "common/predictor.h"

#define GEAR_EDGE_NAMED_S 0.005 /* so long after it, an edge has its name (common/switches.h) */

struct known_gear {
    size_t gates, beyond;             /* named so far; of them, beyond touchdown */
    struct mr_motion_estimate motion; /* at the last gate */
    bool known;
};

/* Takes the gates named by t_s; true: there was a new one. `gate`: all of the landing, in order,
 * always the same ones; `gear` all 0 before the first call, t_s never decreasing. */
bool gear_take(struct known_gear *gear, const struct mr_gate *gate, size_t gates,
               double touchdown_ft, double switch_error_ft, double t_s);
/* The predictor's input of t_s but for its displacements: carried on from the last gate, until it
 * stops. NaN: not known. */
void gear_tell(const struct known_gear *gear, double touchdown_ft, double t_s,
               struct mr_predictor_input *input);

#endif
