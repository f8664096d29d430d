/* Asking a board, over serial, whether it is ready, while its CAN is listened to; and hearing it
 * live during a walk. */
#ifndef MATRIG_HOST_BOARD_READY_CLIENT_H
#define MATRIG_HOST_BOARD_READY_CLIENT_H

#include "common/block.h"
#include "host/board/config_client.h"
#include "host/board/dialogue.h"
#include "host/board/ready.h"
#include "host/store/store.h"

#define READY_CLIENT_BLOCKS 256u /* kept */

struct ready_client {
    struct dialogue *dialogue;
    struct ready_facts *facts; /* filled */
    /* of all of it, by the dialogue's clock; INFINITY: until the caller ends it */
    double until_s;

    bool acknowledged; /* the newest order, */
    struct mr_ack ack; /* so */
    struct configwords words;
    struct mr_block block[READY_CLIENT_BLOCKS];
    unsigned blocks;
    bool seq_known, can_begun, lost_known, can_dropped_known, serial_dropped_known, clock_known,
        fault_known[MR_FAULT_COUNT];
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

/* The dialogue is the caller's; `talk` subscribes to it. `facts` as the caller has filled them so
 * far. Everything ends within `limit_s`. */
void ready_client_begin(struct ready_client *talk, struct dialogue *dialogue,
                        struct ready_facts *facts, double limit_s);
/* Waits for hello, makes a board that is done idle, reads its configuration. MR_OK also when the
 * board does not answer: the facts say so. Else as host/board/dialogue.h has it. */
enum mr_status ready_client_meet(struct ready_client *talk, struct error *error);
/* Everything else that the facts have: readings, shunts, self-test, black box, time. */
enum mr_status ready_client_ask(struct ready_client *talk, struct error *error);
/* Keeps the board live for `seconds` (firmware/landinglink.h); MR_OK when it answered so,
 * MR_NOT_NOW: not idle, MR_TIMEOUT. */
enum mr_status ready_client_live(struct ready_client *talk, int seconds, struct error *error);

/* What this board was at its last landing and its last shunt calibration. */
enum mr_status ready_client_look_back(struct store *store, struct ready_facts *f,
                                      struct error *error);
/* `kind`: "ready" or "walk"; `f` of a check, NULL of a walk. The row: {"checks": [...], "spans_lb":
 * [...]}. */
enum mr_status ready_client_save(struct store *store, const struct identity *identity,
                                 const char *kind, const struct ready_report *report,
                                 const struct ready_facts *f, int64_t made_us, struct error *error);

#endif
