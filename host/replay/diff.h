/* Two boards' answers to the same landing, message by message and field by field.
 *
 * What follows from blocks, edges and commands must agree: equal where the same image ran, within
 * tolerances where another did. Block indices and ticks are compared after the replay's shift.
 * Counts since reset (frames queued) are compared as counts since the first such message of the
 * landing. What does not follow from the record - processor load, error counters of the links, the
 * cause of the last reset, faults of links and clocks - is not compared. */
#ifndef MATRIG_HOST_REPLAY_DIFF_H
#define MATRIG_HOST_REPLAY_DIFF_H

#include "host/base/answer.h"
#include "host/replay/input.h"

#define DIFF_MESSAGES_MAX 128

enum diff_kind { DIFF_VALUE, DIFF_ONLY_RECORDED, DIFF_ONLY_REPLAYED };

struct difference {
    enum diff_kind kind;
    int link;
    const char *message;
    const char *field; /* "" for a whole message */
    int64_t block;     /* of the record */
    double recorded, replayed;
};

struct diff_row { /* one message on one link */
    const char *message;
    int link;
    int64_t pairs;
    int64_t fields; /* compared */
    int64_t differ;
    int64_t only_recorded, only_replayed;
    struct difference first; /* when anything differs */
};

struct diff {
    bool exact;
    struct diff_row row[DIFF_MESSAGES_MAX];
    size_t rows;
    /* messages that only one side has count as a difference each */
    int64_t messages, fields, differ;
    int64_t late_blocks;   /* so much apart is what is told in turn: a full bus; 0: nothing */
    int64_t before_record; /* rest on blocks before the first record */
    /* of blocks after the last record: CAN tells of them first, or the record breaks off */
    int64_t after_record;
    /* recorded messages that no record foretells (CIRCUMSTANCE of the catalogue) */
    int64_t circumstances;
    int64_t not_recorded; /* messages of the replay that a lossy log may have missed */
    bool found;
    struct difference first; /* in time */
};

struct diff_options {
    bool exact;             /* else within tolerances */
    int64_t shift_blocks;   /* block of the record minus block of the replay */
    bool lossy[LINK_KINDS]; /* frames of this link were lost when it was recorded */
};

void diff_answers(const struct answers *recorded, const struct answers *replayed,
                  const struct diff_options *options, struct diff *diff);

void diff_answer(const struct diff *diff, struct answer *answer);

#endif
