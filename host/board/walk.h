/* The walk test: somebody walks along the rig, trips each switch, pushes each transducer's mat and
 * pulls at each gage, in order. The result is a table of checks: one for each that did not answer
 * or answered in another's place, or one for each kind that all answered in order. Two that are
 * swapped and two that were tripped in the other order look the same; the check asks for both.
 *
 * Learning the steps of the staircase: the step at the n-th edge is that of the n-th switch that is
 * fitted, whatever name the configured steps give that edge. A step is learned to half a code
 * (common/staircase.h) and rounded to whole codes. Resistors and the converter's curve are in it:
 * in a landing the switches open in the same order, at the same levels.
 *
 * Pure. */
#ifndef MATRIG_HOST_BOARD_WALK_H
#define MATRIG_HOST_BOARD_WALK_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "host/board/ready.h"

#define WALK_ANSWERS          64u /* kept of each kind */
#define WALK_ITEMS            32u
#define WALK_CHANNELS         16u
/* half a second of readings: so long all must be still after a movement */
#define WALK_ROWS             25u
#define WALK_PUSH_IN          0.05f /* a movement by hand; a mat at rest stays within a hundredth */
#define WALK_PULL_LB          5.0f
/* A step this far from the configured one is another switch's, or of a wrong resistor: 5 % of the
 * largest built in and the converter's worst are 12 + 3 codes. */
#define WALK_STEP_FAR_CODES   16.0
/* Where every step is within so much of the configured one, and those are 8 apart as they are
 * built, the configured steps name each with 1.5 codes to spare: it is the converter's curve that
 * moves them. What is learned has in it the curve at the levels of this order; when a switch stays
 * closed the levels are others, and of two learned steps that are close one may be taken for the
 * other. 2.5 was chosen afterwards, on drawn boards (docs/measured/electronics.md). */
#define WALK_STEP_CURVE_CODES 2.5
#define WALK_STEP_BUILT_CODES 8u

enum walk_kind { WALK_SWITCH, WALK_TRANSDUCER, WALK_GAGE, WALK_KINDS };
extern const char *const walk_names[WALK_KINDS];

/* Movements by hand of channels at rest: the one that moved most is the one that was meant. */
struct walk_motion {
    unsigned channels;
    float limit; /* in or lb: less is no movement */
    float row[WALK_ROWS][WALK_CHANNELS];
    unsigned rows;
    float rest[WALK_CHANNELS], peak[WALK_CHANNELS];
    bool at_rest, moving;
};
void walk_motion_start(struct walk_motion *motion, unsigned channels, float limit);
/* The next reading of all, one each 20 ms; NaN: not valid. Returns the channel, from 1, whose
 * movement is over; 0: none. */
unsigned walk_motion_take(struct walk_motion *motion, const float *value);

struct walk_answer {
    unsigned number; /* as it was named, from 1; 0: an edge of no switch */
    uint8_t edge;    /* as the board counts them */
    double codes;    /* its step */
};
struct walk {
    const struct mr_config *config;
    struct walk_answer answer[WALK_KINDS][WALK_ANSWERS];
    unsigned count[WALK_KINDS], strange;
    struct walk_motion transducers, gages;
    bool gage_disturbed; /* a transducer was pushed while a gage moved: that is the push */
};
void walk_start(struct walk *walk, const struct mr_config *config);
/* True: something answered, the newest of `kind`. */
bool walk_take_edge(struct walk *walk, const struct mr_edge *edge);
void walk_take_event(struct walk *walk, const struct mr_switch_event *event);
bool walk_take_reading(struct walk *walk, const struct mr_block *block, enum walk_kind *kind);
/* All that are fitted answered; with `learns`: as many edges as switches. */
bool walk_is_over(const struct walk *walk, bool learns);
void walk_judge(const struct walk *walk, struct ready_report *report);
/* Learns the steps: `*learned` is the configuration with them, or as it is where those name the
 * switches better; a check says which. False: the check says what is wrong. */
bool walk_learn(const struct walk *walk, struct mr_config *learned, struct ready_report *report);

#endif
