#include "host/analyse/summary_missing.h"

#include <stdio.h>
#include <string.h>

#define NUMBERS 120 /* of the channels of a kind, in words */

static bool lacks(const struct measured_channel *channel, enum mr_channel_kind kind)
{
    return channel->config.kind == kind && channel->missing_to > channel->missing_from;
}

static bool same(const struct measured_channel *a, const struct measured_channel *b)
{
    return a->missing_from == b->missing_from && a->missing_to == b->missing_to;
}

/* "1 to 8" or "2, 5 to 7" of the channels that lack what the one at `c` does. */
static void numbers_text(const struct measured *measured, unsigned c, char out[NUMBERS])
{
    const struct measured_channel *first = &measured->channel[c];
    size_t used = 0;
    out[0] = '\0';
    for (unsigned i = c, run = 0; i < MR_CHANNELS; i++) {
        const struct measured_channel *channel = &measured->channel[i];
        if (!lacks(channel, first->config.kind) || !same(channel, first)) {
            run = 0;
            continue;
        }
        bool last = i + 1 == MR_CHANNELS || !lacks(channel + 1, first->config.kind) ||
                    !same(channel + 1, first);
        if ((run == 0 || last) && used < NUMBERS)
            used += (size_t)snprintf(out + used, NUMBERS - used, "%s%u",
                                     run > 0    ? " to "
                                     : used > 0 ? ", "
                                                : "",
                                     channel->config.number);
        run++;
    }
}

static bool told_already(const struct measured *measured, unsigned c)
{
    const struct measured_channel *channel = &measured->channel[c];
    for (unsigned i = 0; i < c; i++) {
        if (lacks(&measured->channel[i], channel->config.kind) &&
            same(&measured->channel[i], channel))
            return true;
    }
    return false;
}

void summary_missing_answer(const struct measured *measured, enum mr_channel_kind kind,
                            struct answer *answer)
{
    char numbers[NUMBERS];
    if (measured_ends_early(measured))
        answer_sentence(answer, NULL,
                        "The record ends %.3f s after %s, while the gear %s: peaks and ends are "
                        "those until then.",
                        measured_time_s(measured, measured->samples - 1),
                        measured->t0_is_touchdown ? "touchdown" : "the first switch",
                        measured_moves_text(measured));
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (!lacks(channel, kind) || told_already(measured, c))
            continue;
        numbers_text(measured, c, numbers);
        answer_sentence(answer, NULL,
                        "Readings are missing from %.3f to %.3f s (%s%s %s): a peak that fell "
                        "among them is not seen, and no error here knows of it.",
                        measured_time_s(measured, channel->missing_from),
                        measured_time_s(measured, channel->missing_to),
                        kind == MR_KIND_TENSION ? "gage" : "transducer",
                        strpbrk(numbers, " ") ? "s" : "", numbers);
    }
}
