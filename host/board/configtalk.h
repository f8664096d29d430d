/* Talking to a board about its configuration, over CAN or serial: reading it, changing it. */
#ifndef MATRIG_HOST_CONFIGTALK_H
#define MATRIG_HOST_CONFIGTALK_H

#include "host/board/configwords.h"
#include "host/board/dialogue.h"

struct configtalk {
    struct dialogue *dialogue;
    bool refused, state_known, staged;
    uint16_t tag; /* of the words being sent */
    struct mr_config_refused reason;
    struct mr_config_state state;     /* as hello's round last told it */
    struct mr_config_staged progress; /* of the words being sent */
    struct configwords words;         /* being read */
    size_t told;                      /* that came, each time */
};

/* The dialogue is the caller's; `talk` subscribes to it. Waits until the board has said hello and
 * what configuration it has. Statuses as dialogue_hello. */
enum mr_status configtalk_begin(struct configtalk *talk, struct dialogue *dialogue,
                                struct error *error);
/* The configuration in force and its CRC. MR_NOT_NOW: a landing is armed or going on; MR_VERSION:
 * of another table. */
enum mr_status configtalk_get(struct configtalk *talk, struct mr_config *config, uint32_t *crc,
                              struct error *error);
/* Sends it; it is in force, and in flash, when this says MR_OK. On CAN the dialogue goes on at its
 * base. MR_LIMIT: refused, `error` says why; MR_NOT_NOW. */
enum mr_status configtalk_set(struct configtalk *talk, const struct mr_config *config,
                              struct error *error);

#endif
