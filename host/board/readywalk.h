/* The walk test: somebody walks along the rig, trips each switch, pushes each transducer's mat and
 * pulls at each gage, in order. What answered, in which order, is held against what is fitted:
 * missing ones, those that answered twice, and those that answered in another's place. That two are
 * swapped and that they were tripped in the other order cannot be told apart; both are said.
 *
 * Pure. */
#ifndef MATRIG_HOST_READYWALK_H
#define MATRIG_HOST_READYWALK_H

#include <stdbool.h>
#include <stdint.h>

#include "host/board/ready.h"

#define WALK_ITEMS    32u
#define WALK_CHANNELS 16u
/* half a second of readings: so long all must be still after a movement */
#define WALK_ROWS     25u
#define WALK_PUSH_IN  0.05f /* a movement by hand; a mat at rest stays within a hundredth */
#define WALK_PULL_LB  5.0f

/* One kind of thing, numbered from 1 along the rig. */
struct walk_order {
    uint32_t fitted; /* bit n-1 */
    /* left out by the two that answered after it: no longer waited for */
    uint32_t passed;
    uint8_t order[WALK_ITEMS]; /* in which they answered, each once */
    unsigned count;
    uint8_t again[WALK_ITEMS]; /* how often n answered more, at n-1 */
};

enum walk_answer { WALK_NEXT, WALK_ANOTHER, WALK_AGAIN, WALK_NOT_FITTED };

/* The one to come, 0: all have answered. */
unsigned walk_next(const struct walk_order *order);
/* `n` answered. */
enum walk_answer walk_take(struct walk_order *order, unsigned n);
bool walk_over(const struct walk_order *order);
/* What a walk says: one check for each that is missing, twice, or in another's place, or one that
 * all is well. `what`: "switch", `verb`: "tripped". */
void walk_judge(const struct walk_order *order, const char *what, const char *verb,
                struct ready_report *report);

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

#endif
