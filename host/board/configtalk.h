/* Talking to a board about its configuration, over CAN or serial: reading it, changing it. */
#ifndef MATRIG_HOST_CONFIGTALK_H
#define MATRIG_HOST_CONFIGTALK_H

#include "common/catalogue.h"
#include "common/config.h"
#include "common/framing.h"
#include "host/link/link.h"

struct configtalk {
    struct link *link;
    enum link_kind kind;
    struct mr_deframer deframer;
    uint16_t seq, tag;
    bool hello, acknowledged, refused, state_known, staged;
    uint32_t uid[3];                  /* the board's, as hello's round last told it */
    struct mr_ack ack;
    struct mr_config_refused reason;
    struct mr_config_state state;     /* as hello's round last told it */
    struct mr_config_staged progress; /* of the words being sent */
    uint8_t image[MR_CONFIG_IMAGE];   /* being read */
    uint8_t present[MR_CONFIG_WORDS];
    unsigned words_there;             /* words the board says it has; 0: none came */
};

/* The link is the caller's. Waits until the board says hello, which it does once a second. MR_TIMEOUT; MR_VERSION: a board of another
 * layout. */
enum mr_status configtalk_begin(struct configtalk *talk, struct link *link, enum link_kind kind, struct error *error);
/* The configuration in force and its CRC. MR_NOT_NOW: a landing is armed or going on; MR_VERSION: of another table. */
enum mr_status configtalk_get(struct configtalk *talk, struct mr_config *config, uint32_t *crc, struct error *error);
/* Sends it; it is in force, and in flash, when this says MR_OK. MR_LIMIT: refused, `error` says why; MR_NOT_NOW. */
enum mr_status configtalk_set(struct configtalk *talk, const struct mr_config *config, struct error *error);

#endif
