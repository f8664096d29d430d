/* Comparison of two boards' messages about the same landing, message by message and field by field.
 *
 * Everything that follows from blocks, edges and commands must agree: exactly if the same image
 * ran, within tolerances if a different image ran. Block indices and ticks are compared after the
 * replay's shift. Counts since reset (queued frames) are compared as counts since the first such
 * message of the landing. Data that does not follow from the record is not compared: processor
 * load, error counters of the links, the cause of the last reset, faults of links and clocks. */
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
    const char *field; /* name of the field; "": the whole message */
    int64_t block;     /* block, counted as in the record */
    double recorded, replayed;
};

struct diff_row { /* comparison of one message on one link */
    const char *message;
    int link;
    int64_t pair_count;
    int64_t compared_fields; /* number of compared fields */
    int64_t differing_fields;
    int64_t only_recorded_count, only_replayed_count;
    struct difference first_difference; /* first difference, if there is one */
};

struct diff {
    bool is_exact;
    struct diff_row row[DIFF_MESSAGES_MAX];
    size_t row_count;
    /* totals; a message that only one side has counts as one difference */
    int64_t compared_messages, compared_fields, differing_fields;
    /* largest time difference, in blocks, of messages that are sent in rotation and that a full bus
     * delayed; 0: no delay */
    int64_t bus_delay_blocks;
    /* number of messages that depend on blocks before the first record */
    int64_t messages_before_record;
    /* number of messages about blocks after the last record: CAN delivers them earlier, or the
     * record ends early */
    int64_t messages_after_record;
    /* number of recorded messages that are never determined by a record (NOT_COMPARED in the
     * catalogue) */
    int64_t excluded_messages;
    /* number of messages of the replay that may be missing in the record due to losses */
    int64_t unrecorded_messages;
    bool has_difference;
    struct difference first_difference; /* earliest difference */
};

struct diff_options {
    /* values must be equal; false: they may differ within tolerances */
    bool is_exact;
    int64_t shift_blocks;        /* block of the record minus block of the replay */
    bool has_losses[LINK_KINDS]; /* frames of this link were lost when it was recorded */
};

void diff_messages(const struct board_messages *recorded, const struct board_messages *replayed,
                   const struct diff_options *options, struct diff *diff);

void diff_to_answer(const struct diff *diff, struct answer *answer);

#endif
