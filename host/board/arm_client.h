/* Arming a board for a landing, and disarming it, over CAN or serial. On CAN another program may
 * use the same interface: a program recognises its own answer by its tag. */
#ifndef MATRIG_HOST_BOARD_ARM_CLIENT_H
#define MATRIG_HOST_BOARD_ARM_CLIENT_H

#include "host/board/dialogue.h"

#define ARM_CLIENT_LANDING_MOST 65535
/* for the answer to either order, here, at the terminal of matrig log and on the live page */
#define ARM_CLIENT_ANSWER_S     3

struct arm_client {
    struct dialogue *dialogue;
    bool landing_known, wait_known;
    bool landing_told;         /* since the command */
    unsigned wanted, before;   /* states: that the command is to reach, that it found */
    struct mr_landing landing; /* newest */
    struct mr_box_state box;   /* reported when it is why arming was refused */
};

/* The dialogue is the caller's; `talk` subscribes to it. Waits for the board's hello and its state,
 * sent once a second. Statuses as dialogue_hello. */
enum mr_status arm_client_begin(struct arm_client *talk, struct dialogue *dialogue,
                                struct error *error);
/* MR_COMMAND_ARM with a landing's number from 0 to 65535 (0: the board counts on), or
 * MR_COMMAND_DISARM with 0; at most 5 s. When the answer is lost, the board's reported state
 * decides. MR_OK: done, talk->landing is the landing; MR_TIMEOUT: neither an answer nor the state
 * arrived; else the board refused, and `error` has the reason. */
enum mr_status arm_client_order(struct arm_client *talk, uint8_t code, int32_t number,
                                struct error *error);

/* Why a board refuses `arm` or `disarm`, and what to do, in words. Static storage. */
const char *arm_client_refusal(enum mr_status answer);
/* The landing that is in this state goes on, and is recorded. */
bool arm_client_recording(unsigned state);

#endif
