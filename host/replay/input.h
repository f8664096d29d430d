/* A recorded landing: what the board said of it, messages and block records, and what it is given
 * to say the same again. */
#ifndef MATRIG_HOST_REPLAY_INPUT_H
#define MATRIG_HOST_REPLAY_INPUT_H

#include <stdbool.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "host/link/link.h"
#include "host/store/store.h"

/* Its messages per link and its block records, read from a campaign. */
struct answer {
    const struct mr_message_info *info;
    int64_t block; /* its own, or the newest the link had brought when it came; -1: not known */
    uint8_t data[MR_MESSAGE_MAX];
};

struct answers {
    struct store_landing landing;
    struct answer *message[LINK_KINDS]; /* in order of reception */
    size_t messages[LINK_KINDS];
    struct mr_block *block; /* ascending by index */
    size_t blocks;
    unsigned board; /* which it was: common/boards.def */
    bool board_told;
};

/* MR_MALFORMED: a record that is none; MR_VERSION: a board of another layout. answers_free releases
 * what it holds. */
enum mr_status answers_load(struct store *store, int64_t run, struct answers *answers,
                            struct error *error);
void answers_free(struct answers *answers);

/* What a board took in during a recorded landing, put together from what it said: its block
 * records, the edges and film frames it reported, and the commands it acknowledged. Written as a
 * replay file for the emulated board (`matrig-replay 1`: a line for each command, edge, film frame
 * and block; hil/rig/replay.h draws it).
 *
 * Not recorded, and so made up: the survey is given again before arming, segment by segment, and
 * zeros that were measured (channel_zero of the landing says which, and what they were), and the
 * predictor's runway as it was when armed; blocks before the first record repeat it. A record that
 * begins late after the board's start is moved back by whole seconds, in which everything that the
 * board does by the clock repeats. */
struct replay_input {
    int64_t shift_blocks; /* the board's block n of the replay is block n + shift of the record */
    int64_t first_block;  /* of the record */
    int64_t last_block;
    int64_t armed_block;
    size_t edges;
    size_t frames;   /* of the film */
    size_t commands; /* given again in the block that took them */
    size_t surveyed; /* segments given before arming */
    bool runway;     /* the predictor's, of the time of arming, is given */
    size_t zeros;    /* measured zeros given before arming */
    bool crystal;
};

/* Writes the file. MR_TOO_FEW: no block records, or the landing was joined late; MR_TRUNCATED: the
 * record has holes, named with their times; MR_NOT_NOW: a board without a time base. */
enum mr_status replay_input_write(struct store *store, const struct answers *recorded,
                                  const char *path, struct replay_input *input,
                                  struct error *error);

#endif
