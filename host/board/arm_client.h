/* Arming a board for a landing, and disarming it, over CAN or serial. Another program may use the
 * same CAN bus; each program recognises the answer to its own command by the tag. */
#ifndef MATRIG_HOST_BOARD_ARM_CLIENT_H
#define MATRIG_HOST_BOARD_ARM_CLIENT_H

#include "host/board/dialogue.h"

#define ARM_CLIENT_LANDING_MAX      65535
/* Time limit for the answer to arm or disarm, also in matrig log and on the live page. */
#define ARM_CLIENT_ANSWER_TIMEOUT_S 3

struct arm_client {
    struct dialogue *dialogue;
    bool landing_known, box_state_known;
    bool landing_state_received; /* a landing state was received since the command was sent */
    /* landing state that the command requests, and landing state before the command */
    unsigned wanted_state, previous_state;
    struct mr_landing landing; /* newest state of the landing */
    /* state of the black box, reported if it is the reason why arming was refused */
    struct mr_box_state box_state;
};

/* Waits for the board's hello and its state, which it sends once a second. The caller owns the
 * dialogue; `client` subscribes to it. Statuses as dialogue_wait_for_hello. */
enum mr_status arm_client_begin(struct arm_client *client, struct dialogue *dialogue,
                                struct error *error);
/* Sends MR_COMMAND_ARM with a landing's number from 0 to 65535 (0: the board takes the next
 * number), or MR_COMMAND_DISARM with 0; takes 5 s at most. If the answer is lost, the state that
 * the board reports decides. MR_OK: done, client->landing is the landing. MR_TIMEOUT: neither an
 * answer nor the state was received. Any other status: the board refused, and `error` has the
 * reason. */
enum mr_status arm_client_send(struct arm_client *client, uint8_t code, int32_t number,
                               struct error *error);

/* Returns the reason why a board refuses `arm` or `disarm`, and what to do, as text. Static
 * storage. */
const char *arm_client_refusal_text(enum mr_status answer);
/* True if a landing in this state is in progress and being recorded. */
bool arm_client_is_recording(unsigned state);

#endif
