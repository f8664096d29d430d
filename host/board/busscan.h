/* Who is on a CAN bus, by what was heard on it: boards and their bases (common/canbase.h), what
 * belongs to no board, which of them get into each other's way, and where one more board could go.
 *
 *     busscan_frame(scan, &frame);              each that came, the identifier as on the bus
 *     busscan_find(scan, &found);
 *     busscan_conflicts(&found, 0x190, list, most);
 *
 * A board says hello once a second, then board_uid, board_image, board_config and config_state: it
 * is found after 1.5 s at the latest. Its messages are those of this matrig's catalogue, whatever
 * its layout. Pure. */
#ifndef MATRIG_HOST_BUSSCAN_H
#define MATRIG_HOST_BUSSCAN_H

#include <stdbool.h>
#include <stddef.h>

#include "common/canbase.h"
#include "host/board/identity.h"
#include "host/link/link.h"

#define BUSSCAN_LEAST_S 1.5 /* to hear each board's hello whole */
#define BUSSCAN_BOARDS  16u
#define BUSSCAN_UIDS    8u /* at one base: more are not told apart */
#define BUSSCAN_VOTES   4u
#define BUSSCAN_REMOTE  9u /* the lengths 0 to 8, then this */

/* hello, board_uid and board_image of one base, until none comes for a while. Boards that speak at
 * the same time have one of each in it for each board. */
struct busscan_round {
    uint64_t last_us;
    unsigned hellos, uids, images;
    uint32_t uid[BUSSCAN_UIDS][3];
};

/* The first board_uid and board_image behind a hello, and how often they were these. */
struct busscan_vote {
    uint32_t uid[3];
    unsigned votes;
};

/* What was heard as a board of this base would say it. */
struct busscan_place {
    unsigned uids; /* different ones, of whole rounds */
    uint32_t uid[BUSSCAN_UIDS][3];
    unsigned said; /* different board_uid of any round, BUSSCAN_UIDS at most */
    uint32_t said_uid[BUSSCAN_UIDS][2];
    unsigned twins; /* hellos that followed another at once: one board says its board_uid first */
    struct mr_hello hello; /* the newest */
    struct busscan_round round;
    /* without whole rounds, as another board's messages have these identifiers too */
    struct busscan_vote vote[BUSSCAN_VOTES];
    uint64_t hello_us;
    unsigned followed; /* what came since: 0 nothing is awaited, 1 hello, 2 board_uid */
    uint32_t following[3];
};

/* 360 KB. All zero before the first frame. */
struct busscan {
    uint64_t first_us, last_us;
    uint64_t frames; /* data and remote frames of 11-bit identifiers */
    uint64_t extended, remote, errors;
    uint32_t heard[MR_CAN_ID_MOST + 1][BUSSCAN_REMOTE + 1]; /* by length */
    struct busscan_place place[MR_CAN_BASE_MOST + 1];
};

void busscan_frame(struct busscan *scan, const struct link_frame *frame);
/* From the first frame to the last. */
double busscan_heard_s(const struct busscan *scan);

struct busscan_board {
    uint16_t base;
    struct mr_hello hello;
    unsigned uids; /* 2: two boards have this base */
    struct identity who[BUSSCAN_UIDS];
    bool more;       /* have it than are told apart in `who` */
    uint64_t frames; /* of its messages, those to it too */
    bool leaving;    /* set by who gives it another base: it is in nobody's way */
};

struct busscan_found {
    const struct busscan *scan;
    unsigned count; /* ascending by base */
    struct busscan_board board[BUSSCAN_BOARDS];
    uint32_t stray[MR_CAN_ID_MOST + 1]; /* frames that are of no board: their length, too */
};
void busscan_find(const struct busscan *scan, struct busscan_found *found);
/* Whether several boards have the base of this one. */
bool busscan_is_shared(const struct busscan_board *board);
/* The board with this uid, when it is alone at this base, leaves it. */
void busscan_leave(struct busscan_found *found, uint16_t base, const struct identity *who);

/* An identifier that a message of a board would have, and somebody else has. */
struct busscan_conflict {
    uint16_t id;                       /* on the bus */
    uint16_t message;                  /* of the board, by the catalogue */
    const struct busscan_board *board; /* whose it is; NULL: it was heard, of no board */
    uint16_t other;                    /* then: which message of that board */
    uint32_t frames;                   /* heard with it, of no board */
};

/* Those of a board that would come with this base: at most `most` of them, ascending. How many
 * there are. */
size_t busscan_conflicts(const struct busscan_found *found, uint16_t base,
                         struct busscan_conflict *list, size_t most);
/* Those of a board that was found, but for what boards of one base share. */
size_t busscan_conflicts_of(const struct busscan_found *found, const struct busscan_board *board,
                            struct busscan_conflict *list, size_t most);
/* "0x370 clock (8 frames of no board), ...", cut after some. */
void busscan_conflicts_text(const struct busscan_conflict *list, size_t count, size_t there,
                            char *out, size_t size);
/* Bases without a conflict, at most `most`: multiples of 0x10 first, then others. How many. */
size_t busscan_free(const struct busscan_found *found, uint16_t *bases, size_t most);
/* "0x190, 0x1a0, 0x1b0", or "none". */
void busscan_free_text(const struct busscan_found *found, char *out, size_t size);

#endif
