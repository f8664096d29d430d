#include "host/collect/witness.h"

#include <stdlib.h>
#include <string.h>

void witness_start(struct witness *witness)
{
    memset(witness, 0, sizeof *witness);
    witness_restart(witness);
}

/* The used part of a ring: from `first` to the ring's end, and what is left from its beginning. */
static void copy_ring(void *to, const void *from, size_t first, size_t count, size_t ring,
                      size_t size)
{
    size_t tail = first + count > ring ? ring - first : count;
    memcpy((uint8_t *)to + first * size, (const uint8_t *)from + first * size, tail * size);
    memcpy(to, from, (count - tail) * size);
}

void witness_copy(struct witness *to, const struct witness *from)
{
    copy_ring(to->waiting, from->waiting, from->first, from->count, WITNESS_WAITING,
              sizeof from->waiting[0]);
    for (unsigned place = 0; place < MR_PLACES; place++)
        copy_ring(to->said[place], from->said[place], from->said_first[place],
                  from->said_count[place], WITNESS_SAID, sizeof from->said[0][0]);
    to->first = from->first;
    to->count = from->count;
    memcpy(to->said_first, from->said_first, sizeof to->said_first);
    memcpy(to->said_count, from->said_count, sizeof to->said_count);
    memcpy(to->forgotten_block, from->forgotten_block, sizeof to->forgotten_block);
    to->newest_block = from->newest_block;
    to->lost_from_block = from->lost_from_block;
    to->lost_block = from->lost_block;
}

void witness_restart(struct witness *witness)
{
    witness->newest_block = -1;
    witness->lost_from_block = witness->lost_block = -1;
    memset(witness->said_count, 0, sizeof witness->said_count);
    for (unsigned place = 0; place < MR_PLACES; place++)
        witness->forgotten_block[place] = -1;
    /* of the boot before, or of this one: nobody knows */
    for (size_t i = 0; i < witness->count; i++)
        witness->waiting[(witness->first + i) % WITNESS_WAITING].block = -1;
}

bool witness_covers(const struct mr_message *message)
{
    switch (message->place) {
    case MR_PLACE_CLOCK:         /* time must be known at once; timebase.h doubts it */
    case MR_PLACE_CAN_HEALTH:    /* counts what came before it; account.h doubts it */
    case MR_PLACE_MESSAGE_COUNT: /* of one link */
    case MR_PLACE_CAN_ALARM:     /* not at the same time on both */
    case MR_PLACE_CONFIG_IMAGE: /* on the link that asked */ return false;
    default: return message->info->direction == MR_DIRECTION_BOTH;
    }
}

void witness_block(struct witness *witness, int64_t block)
{
    if (block > witness->newest_block)
        witness->newest_block = block;
}

void witness_lost(struct witness *witness, int64_t from_block, int64_t block)
{
    /* One stretch that covers all lately lost: none of it is forgotten before nothing of it can be
     * asked for. */
    if (witness->lost_block < 0 || from_block > witness->lost_block + WITNESS_KEPT_BLOCKS)
        witness->lost_from_block = from_block;
    if (block > witness->lost_block)
        witness->lost_block = block;
}

static struct witness_said *said(struct witness *witness, unsigned place, unsigned i)
{
    return &witness->said[place][(witness->said_first[place] + i) % WITNESS_SAID];
}

static void forget(struct witness *witness, unsigned place, unsigned count)
{
    witness->said_first[place] = (witness->said_first[place] + count) % WITNESS_SAID;
    witness->said_count[place] -= count;
}

void witness_serial(struct witness *witness, const struct mr_message *message, int64_t block)
{
    unsigned place = message->place;
    witness_block(witness, block);
    while (witness->said_count[place] > 0 &&
           (witness->said_count[place] == WITNESS_SAID ||
            said(witness, place, 0)->block + WITNESS_KEPT_BLOCKS < witness->newest_block)) {
        witness->forgotten_block[place] = said(witness, place, 0)->block;
        forget(witness, place, 1);
    }
    struct witness_said *newest = said(witness, place, witness->said_count[place]++);
    newest->block = witness->newest_block;
    memcpy(newest->payload, message->payload, sizeof newest->payload);
}

bool witness_can(struct witness *witness, const struct witness_message *message)
{
    if (witness->count == WITNESS_WAITING)
        return false;
    witness->waiting[(witness->first + witness->count++) % WITNESS_WAITING] = *message;
    return true;
}

/* Serial has said the same lately, and CAN has not brought it since. What it said before that will
 * not come over CAN any more. */
static bool was_said(struct witness *witness, const struct witness_message *message)
{
    unsigned place = message->message.place;
    for (unsigned i = 0; i < witness->said_count[place]; i++) {
        const struct witness_said *twin = said(witness, place, i);
        int64_t apart = message->block < 0 || twin->block < 0 ? 0
                                                              : llabs(message->block - twin->block);
        bool lately = apart < WITNESS_APART_BLOCKS;
        if (lately &&
            memcmp(twin->payload, message->message.payload, message->message.info->length) == 0) {
            forget(witness, place, i + 1);
            return true;
        }
    }
    return false;
}

static bool lost_near(const struct witness *witness, int64_t block)
{
    return witness->lost_block >= 0 && block + WITNESS_LATE_BLOCKS >= witness->lost_from_block &&
           block - WITNESS_LATE_BLOCKS <= witness->lost_block;
}

/* CAN may be so far behind that what serial said at its time is no longer remembered. */
static bool remembers(const struct witness *witness, const struct witness_message *message)
{
    int64_t forgotten_block = witness->forgotten_block[message->message.place];
    return forgotten_block < 0 || message->block - WITNESS_LATE_BLOCKS > forgotten_block;
}

enum witness_verdict witness_take(struct witness *witness, int64_t can_block, bool over,
                                  struct witness_message *message)
{
    enum witness_verdict verdict = WITNESS_WAIT;
    if (witness->count == 0)
        return WITNESS_WAIT;
    const struct witness_message *oldest = &witness->waiting[witness->first];
    int64_t newest = witness->newest_block;
    bool passed = newest >= 0 &&
                  newest >= oldest->block + (over ? WITNESS_OVER_BLOCKS : WITNESS_LATE_BLOCKS);
    if (was_said(witness, oldest))
        verdict = WITNESS_SAME;
    else if (passed && oldest->block >= 0)
        verdict = lost_near(witness, oldest->block) || !remembers(witness, oldest)
                    ? WITNESS_UNHEARD
                    : WITNESS_STRANGER;
    else if (passed || over || witness->count == WITNESS_WAITING ||
             can_block > newest + WITNESS_SILENT_BLOCKS)
        verdict = WITNESS_UNHEARD;
    if (verdict == WITNESS_WAIT)
        return verdict;
    *message = *oldest;
    witness->first = (witness->first + 1) % WITNESS_WAITING;
    witness->count--;
    return verdict;
}
