/* The runway state of a board's predictor, and its risk chart. */
#ifndef MATRIG_HOST_BOARD_RUNWAY_CLIENT_H
#define MATRIG_HOST_BOARD_RUNWAY_CLIENT_H

#include "common/risk.h"
#include "common/runway.h"
#include "host/board/dialogue.h"

/* A client for the predictor's runway state: reads, replaces or resets it. */
struct runway_client {
    struct dialogue *dialogue;
    bool hello_received, stored_known, is_memory_read, is_complete;
    struct mr_runway_store stored;   /* origin of the runway state that the board has stored */
    struct mr_predictor_state state; /* the runway state, after runway_client_read */
    unsigned received_part_count;
};

/* Waits until the board has sent a hello and has read its stored runway. The caller owns the
 * dialogue; `client` subscribes to it. Statuses as dialogue_wait_for_hello. */
enum mr_status runway_client_begin(struct runway_client *client, struct dialogue *dialogue,
                                   struct error *error);
/* Reads the complete state, checks it against the CRC that the board reports, and fills state and
 * stored. MR_CRC: the received state was damaged in every try. */
enum mr_status runway_client_read(struct runway_client *client, struct error *error);
/* Sends a runway state. MR_OK: the board has accepted and stored it. MR_LIMIT: the board has a
 * different number of mats. MR_MALFORMED: the board refused it. MR_NOT_NOW: the board is armed or
 * in a landing. */
enum mr_status runway_client_load(struct runway_client *client,
                                  const struct mr_predictor_state *state, struct error *error);
/* Resets the runway state to that of an unmeasured runway. MR_OK: the board has stored it.
 * MR_NOT_NOW: the board is armed or in a landing. */
enum mr_status runway_client_discard(struct runway_client *client, struct error *error);

/* Sends the risk chart and the plan of the next landing (common/risk.h). Call it after the board's
 * hello. MR_NOT_NOW: the board is armed or has no predictor. MR_VERSION: the board's runway history
 * has a different number of landings. */
enum mr_status runway_client_send_chart(struct dialogue *dialogue, const struct mr_risk_plan *plan,
                                        struct error *error);

#endif
