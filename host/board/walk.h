/* The walk test: a person walks along the rig, trips each switch, pushes each transducer's mat and
 * pulls at each gage, in order. The result is a table of checks: one for each that did not answer
 * or answered in another's place, or one for each kind that all answered in order. Two that are
 * swapped and two that were tripped in the other order look the same; the check asks for both.
 *
 * Pure. */
#ifndef MATRIG_HOST_BOARD_WALK_H
#define MATRIG_HOST_BOARD_WALK_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "host/board/ready.h"

#define WALK_ANSWERS  64u /* kept of each kind */
#define WALK_ITEMS    32u
#define WALK_CHANNELS 16u
/* half a second of readings: so long all must be still after a movement */
#define WALK_ROWS     25u
#define WALK_PUSH_IN  0.05f /* a movement by hand; a mat at rest stays within a hundredth */
#define WALK_PULL_LB  5.0f

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
/* All that are fitted answered. */
bool walk_is_over(const struct walk *walk);
void walk_judge(const struct walk *walk, struct ready_report *report);

#endif
