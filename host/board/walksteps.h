/* Learning the steps of the staircase: somebody trips each switch once, upfield first, and what the
 * staircase does at the n-th edge is the step of the n-th switch that is fitted, whatever name
 * the configured steps give that edge.
 *
 * A step is learned to half a code (common/staircase.h) and rounded to whole codes, as the
 * configuration has them. Resistors and the converter's curve are in it: in a landing the switches
 * open in the same order, at the same levels.
 *
 * Pure. */
#ifndef MATRIG_HOST_WALKSTEPS_H
#define MATRIG_HOST_WALKSTEPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/config.h"

/* A step this far from the configured one is another switch's, or of a wrong resistor: 5 % of the
 * largest built in and the converter's worst are 12 + 3 codes. */
#define WALK_STEP_FAR_CODES   16.0
#define WALK_STEPS_KEPT       64u
/* Where every step is within so much of the configured one, and those are 8 apart as they are
 * built, the configured steps name each with 1.5 codes to spare: it is the converter's curve that
 * moves them. What is learned has in it the curve at the levels of this order; when a switch stays
 * closed the levels are others, and of two learned steps that are close one may be taken for the
 * other. 2.5 was chosen afterwards, on drawn boards (docs/measured/electronics.md). */
#define WALK_STEP_CURVE_CODES 2.5
#define WALK_STEP_BUILT_CODES 8u

struct walk_steps {
    unsigned count;
    uint8_t number[WALK_STEPS_KEPT]; /* of the edge, as the board counts them */
    double codes[WALK_STEPS_KEPT];
};

struct walk_steps_found {
    unsigned count;
    double furthest_codes;     /* from the step configured */
    unsigned near, near_other; /* the two that are nearest to each other; 0: fewer than two */
    double apart_codes;
    bool configured_stay; /* learned, two would be too close; as configured, each is named */
};

/* An edge; returns the switch that it is taken for, 0: it has no step, or all have answered. */
unsigned walk_steps_take(struct walk_steps *steps, const struct mr_config *config, uint8_t number,
                         double step_codes);
/* The edge of this number was a contact's bounce. */
void walk_steps_bounced(struct walk_steps *steps, uint8_t number);
/* As many as are fitted. */
bool walk_steps_over(const struct walk_steps *steps, const struct mr_config *config);
/* `config` with the steps as they are, or as it is where those are better (configured_stay). False:
 * `why` (size bytes) names what is wrong: some did not answer, one is far from what is configured,
 * two come closer than MR_CONFIG_STEP_APART_CODES, or the configuration is not sound with them. */
bool walk_steps_learn(const struct walk_steps *steps, const struct mr_config *config,
                      struct mr_config *learned, struct walk_steps_found *found, char *why,
                      size_t size);

#endif
