/* Serial as the witness of what CAN says. On serial every frame has a number and a CRC-32; on CAN
 * anybody may speak, by the board's own identifiers. A message that the board sends on both links
 * is obeyed from CAN only once serial has said the same, byte for byte. One that serial has not
 * said a second after its time is a stranger's, unless serial lost frames meanwhile, or CAN is so
 * far behind that what serial said then is forgotten: then CAN is what is left.
 *
 * Messages of CAN wait in their order, and serial's are remembered until their twin comes. Pure;
 * times are blocks of the board. */
#ifndef MATRIG_HOST_COLLECT_WITNESS_H
#define MATRIG_HOST_COLLECT_WITNESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/message.h"

/* messages of CAN; in a landing there are about 500 of them a second */
#define WITNESS_WAITING       8192u
#define WITNESS_SAID          256u /* of each kind; all joints of the runway are 120 in a row */
#define WITNESS_LATE_BLOCKS   1000 /* serial says within this what it says at all */
/* serial so far behind is silent; logs that are read from files are in step within less */
#define WITNESS_SILENT_BLOCKS 5000
#define WITNESS_APART_BLOCKS  2000 /* twins are not further apart than this */
#define WITNESS_OVER_BLOCKS   50   /* when serial has ended, it had so long to say what it had to */
#define WITNESS_KEPT_BLOCKS   10000 /* after so long nobody waits for a twin on CAN any more */

struct witness_message {
    struct mr_message message;
    uint64_t host_us; /* when it came, */
    int64_t block;    /* and the newest block on its link then; -1: none */
    int64_t mark;     /* the caller's own, kept, */
    bool shown;       /* likewise */
};

/* What serial said, and the newest block then. */
struct witness_said {
    uint8_t payload[MR_MESSAGE_MAX];
    int64_t block;
};

struct witness {
    struct witness_message waiting[WITNESS_WAITING]; /* a ring: `count` of them from `first` on */
    size_t first, count;
    struct witness_said said[MR_PLACES][WITNESS_SAID]; /* rings, the oldest first */
    unsigned said_first[MR_PLACES], said_count[MR_PLACES];
    /* of the newest that was forgotten for want of room or for its age; -1: none */
    int64_t forgotten_block[MR_PLACES];
    int64_t newest_block; /* of serial; -1: none */
    /* between which serial last lost frames, whoever lost them; lost_block -1: never */
    int64_t lost_from_block, lost_block;
};

enum witness_verdict {
    WITNESS_WAIT,     /* nothing is known yet, or nothing waits */
    WITNESS_SAME,     /* serial has said it */
    WITNESS_UNHEARD,  /* serial cannot tell: it lost frames, is silent, or spoke too long ago */
    WITNESS_STRANGER, /* serial was there and did not say it */
};

void witness_start(struct witness *witness);
/* `to` waits for and remembers the same; it may have been anything. */
void witness_copy(struct witness *to, const struct witness *from);
/* The board sends it on both links, with the same bytes. Counts and states of one link, and answers
 * to who asked on it, are not. */
bool witness_covers(const struct mr_message *message);
/* Serial says something; `block`: its newest, the message's own included. */
void witness_serial(struct witness *witness, const struct mr_message *message, int64_t block);
/* Serial's time goes on; it lost frames after `from_block`. */
void witness_block(struct witness *witness, int64_t block);
void witness_lost(struct witness *witness, int64_t from_block, int64_t block);
/* The board began again: times of serial before it say nothing. */
void witness_restart(struct witness *witness);
/* A message of CAN waits. False: there is no room, so the oldest must be taken first. */
bool witness_can(struct witness *witness, const struct witness_message *message);
/* The oldest that waits, when it can be told what it is; then it waits no longer. `can_block`:
 * newest block of CAN. `over`: nothing more comes over serial. */
enum witness_verdict witness_take(struct witness *witness, int64_t can_block, bool over,
                                  struct witness_message *message);

#endif
