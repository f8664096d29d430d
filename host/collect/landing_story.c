#include "host/collect/landing_story.h"

#include <string.h>

#define AHEAD_BLOCKS 1000 /* the newest block that is known may be so old */

void landing_story_start(struct landing_story *story)
{
    *story = (struct landing_story){0};
}

static bool same(const struct mr_landing *a, const struct mr_landing *b)
{
    return a->state == b->state && a->landing == b->landing && a->block == b->block;
}

/* A change that the board makes, or several of which those before the last were lost. */
static bool follows(const struct mr_landing *from, const struct mr_landing *to)
{
    bool number = from->landing == to->landing;
    switch (to->state) {
    case MR_LANDING_IDLE:
        return number && from->state != MR_LANDING_IDLE && to->cause == MR_LANDING_BY_COMMAND;
    case MR_LANDING_ARMED:
        return (from->state == MR_LANDING_IDLE || from->state == MR_LANDING_DONE) &&
               to->cause == MR_LANDING_BY_COMMAND;
    case MR_LANDING_LANDING:
        return number && from->state == MR_LANDING_ARMED && to->cause == MR_LANDING_BY_EDGE;
    case MR_LANDING_SETTLING:
        return number && (from->state == MR_LANDING_ARMED || from->state == MR_LANDING_LANDING) &&
               (to->cause == MR_LANDING_BY_STOP || to->cause == MR_LANDING_BY_LIMIT);
    case MR_LANDING_DONE:
        return number && from->state >= MR_LANDING_ARMED && from->state <= MR_LANDING_SETTLING &&
               to->cause == MR_LANDING_BY_SETTLED;
    default: return false;
    }
}

enum landing_belief landing_story_believe(struct landing_story *story,
                                          const struct mr_landing *message)
{
    story->waits = false;
    if (story->known == 0 || !same(message, &story->said)) {
        memmove(story->before + 1, story->before, sizeof story->before - sizeof story->before[0]);
        story->before[0] = story->said;
        story->said = *message;
        story->known += story->known < LANDING_STORY_STATES;
    }
    return LANDING_GOES_ON;
}

/* How many changes ago that was the state; 0: it is not known to have been. */
static unsigned changes_since(const struct landing_story *story, const struct mr_landing *message)
{
    for (unsigned i = 1; i < story->known; i++) {
        if (same(message, &story->before[i - 1]))
            return i;
    }
    return 0;
}

static enum landing_belief take_back(struct landing_story *story, unsigned changes)
{
    story->waits = false;
    story->said = story->before[changes - 1];
    story->known = 1;
    return LANDING_TAKEN_BACK;
}

enum landing_belief landing_story_hear(struct landing_story *story,
                                       const struct mr_landing *message, int64_t block)
{
    bool impossible = message->state > MR_LANDING_DONE || message->cause > MR_LANDING_BY_LIMIT ||
                      (block >= 0 && (int64_t)message->block > block + AHEAD_BLOCKS);
    bool said_again = story->waits && same(message, &story->doubted);
    if (impossible)
        return LANDING_DOUBTED;
    unsigned changes = changes_since(story, message);
    if (changes == 1 || (changes > 1 && said_again))
        return take_back(story, changes);
    if (story->known == 0 || said_again || same(message, &story->said) ||
        (message->block >= story->said.block && follows(&story->said, message)))
        return landing_story_believe(story, message);
    story->waits = true;
    story->doubted = *message;
    return LANDING_DOUBTED;
}
