/* What a board said of one landing: its messages per link and its block records, read from a
 * campaign database. */
#ifndef MATRIG_HOST_REPLAY_ANSWERS_H
#define MATRIG_HOST_REPLAY_ANSWERS_H

#include "common/block.h"
#include "common/catalogue.h"
#include "host/link/link.h"
#include "host/store/store.h"

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
/* Only which board it was, as far as the record tells, whatever is damaged in it; nothing is to be
 * released. */
void answers_load_board(struct store *store, int64_t run, struct answers *answers);
void answers_free(struct answers *answers);

#endif
