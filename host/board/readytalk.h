/* Asking a board, over serial, whether it is ready, while its CAN is listened to; and hearing it live during a walk. */
#ifndef MATRIG_HOST_READYTALK_H
#define MATRIG_HOST_READYTALK_H

#include "common/block.h"
#include "common/framing.h"
#include "host/board/ready.h"
#include "host/link/link.h"

#define READYTALK_BLOCKS 256u /* kept */

struct readytalk {
    struct link *link[LINK_KINDS]; /* the caller's; NULL: not used */
    struct ready_facts *facts;     /* filled */
    struct mr_deframer deframer;
    uint16_t seq, tag;
    uint64_t until_ms;             /* of all of it, monotonic */

    bool acknowledged;
    struct mr_ack ack;
    uint8_t image[MR_CONFIG_IMAGE]; /* the configuration, as its words come */
    uint8_t present[MR_CONFIG_WORDS];
    struct mr_block block[READYTALK_BLOCKS];
    unsigned blocks;
    bool shunts_begun, seq_known, can_begun, lost_known, can_dropped_known, serial_dropped_known, clock_known, fault_known[MR_FAULT_COUNT];
    uint16_t last_seq, blocks_lost, can_dropped, serial_dropped, first_fault[MR_FAULT_COUNT];
    uint32_t can_sent, first_clock, newest_clock;
    int64_t can_since;
    struct timemap map;

    /* Live; each may be NULL. */
    void *context;
    void (*edge)(void *context, const struct mr_edge *edge);
    void (*event)(void *context, const struct mr_switch_event *event);
    void (*reading)(void *context, const struct mr_block *block);
};

/* `facts` as the caller has filled them so far. Everything ends within `limit_s`. */
void readytalk_begin(struct readytalk *talk, struct link *serial, struct link *can, struct ready_facts *facts, double limit_s);
/* Waits for hello, makes a board that is done idle, reads its configuration. MR_OK also when the board does not answer: the facts say
 * so. MR_VERSION: another layout; else a link's error. */
enum mr_status readytalk_meet(struct readytalk *talk, struct error *error);
/* Everything else that the facts have: readings, shunts, self-test, black box, time. */
enum mr_status readytalk_ask(struct readytalk *talk, struct error *error);
/* Keeps the board live for `seconds` (firmware/live.h); MR_OK when it answered so, MR_NOT_NOW: not idle, MR_TIMEOUT. */
enum mr_status readytalk_live(struct readytalk *talk, int seconds, struct error *error);
/* What comes within a tenth of a second. */
enum mr_status readytalk_listen(struct readytalk *talk, struct error *error);

#endif
