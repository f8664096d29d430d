/* What the board says of a landing's state, one message after the other, on a link on which anybody
 * may speak: does a message go on from those before? The board says each change at once and the
 * state once a second, so a change that cannot follow, because messages were lost or because it is
 * not the board's, is doubted until it is said again. Pure. */
#ifndef MATRIG_HOST_COLLECT_LANDING_STORY_H
#define MATRIG_HOST_COLLECT_LANDING_STORY_H

#include <stdbool.h>
#include <stdint.h>

#include "common/catalogue.h"

#define LANDING_STORY_STATES 8u
struct landing_story {
    unsigned known;                                     /* how many of these: */
    struct mr_landing said;                             /* the newest state believed, */
    struct mr_landing before[LANDING_STORY_STATES - 1]; /* and those before it, the newest first */
    bool waits;
    struct mr_landing doubted; /* until it is said again */
};

enum landing_belief {
    LANDING_GOES_ON, /* believed */
    /* believed: it is a state before the last changes again, so those were not the board's. The
     * last one is taken back at once, several when the state is said twice */
    LANDING_TAKEN_BACK,
    LANDING_DOUBTED,
};

/* The board began again, or nothing is known yet. */
void landing_story_start(struct landing_story *story);
/* `block`: the newest of the link; -1: not known. */
enum landing_belief landing_story_hear(struct landing_story *story,
                                       const struct mr_landing *message, int64_t block);
/* The same for a message that the board is known to have sent. */
enum landing_belief landing_story_believe(struct landing_story *story,
                                          const struct mr_landing *message);

#endif
