/* What a board knows of the runway, and its chart of the risk. */
#ifndef MATRIG_HOST_BOARD_RUNWAY_CLIENT_H
#define MATRIG_HOST_BOARD_RUNWAY_CLIENT_H

#include "common/risk.h"
#include "common/runway.h"
#include "host/board/dialogue.h"

/* Talking to a board about what its predictor knows of the runway: reading it, giving it one,
 * making it forget. */
struct runway_client {
    struct dialogue *dialogue;
    bool said_hello, stored_known, looked, whole;
    struct mr_runway_store stored;   /* its origin */
    struct mr_predictor_state state; /* the runway, once read */
    unsigned parts;
};

/* The dialogue is the caller's; `talk` subscribes to it. Waits until the board has sent a hello and
 * read its memory. Statuses as dialogue_hello. */
enum mr_status runway_client_begin(struct runway_client *talk, struct dialogue *dialogue,
                                   struct error *error);
/* Fills state and stored; complete, and with the CRC that the board reports. MR_CRC: it arrived
 * damaged each time. */
enum mr_status runway_client_read(struct runway_client *talk, struct error *error);
/* MR_OK: the board has accepted and stored it. MR_LIMIT: the board has another number of mats;
 * MR_MALFORMED: it is refused; MR_NOT_NOW. */
enum mr_status runway_client_give(struct runway_client *talk,
                                  const struct mr_predictor_state *state, struct error *error);
/* MR_OK: the runway is now an unmeasured one, and stored so. MR_NOT_NOW. */
enum mr_status runway_client_forget(struct runway_client *talk, struct error *error);

/* Giving a board chart and plan for the landing to come (common/risk.h). */
/* After the board's hello. MR_NOT_NOW: it is armed, or has no predictor; MR_VERSION: its runway has
 * had another number of landings. */
enum mr_status runway_client_chart(struct dialogue *dialogue, const struct mr_risk_plan *plan,
                                   struct error *error);

#endif
