/* The configuration of a board, over CAN or serial: its words, reading it, changing it. */
#ifndef MATRIG_HOST_BOARD_CONFIG_CLIENT_H
#define MATRIG_HOST_BOARD_CONFIG_CLIENT_H

#include <stdbool.h>

#include "common/catalogue.h"
#include "common/config.h"
#include "host/board/dialogue.h"

/* A configuration as a board sends it: its words, one message `config_image` each, in any order,
 * some of them lost. */
struct configwords {
    uint8_t image[MR_CONFIG_IMAGE];
    uint8_t present[MR_CONFIG_WORDS];
    unsigned there; /* words of the board's configuration; 0: none received */
    bool ended;     /* the last word, which ends the sequence, was received; the caller clears it */
};

/* All zero: none. Takes a message; a word of another table is not kept. */
void configwords_take(struct configwords *words, const uint8_t *bytes, size_t length);
/* Takes a word that the board sends by itself, all of them in order. True: it was the last one, and
 * `*config` is the whole configuration. */
bool configwords_follow(struct configwords *words, const struct mr_config_image *word,
                        struct mr_config *config);
/* The first one to be requested; MR_CONFIG_WORDS: all received. */
unsigned configwords_absent(const struct configwords *words);
/* When all are received: the configuration, and the CRC at its end. Statuses as
 * mr_config_decode. */
enum mr_status configwords_decode(const struct configwords *words, struct mr_config *config,
                                  uint32_t *crc);

/* Talking to a board about its configuration, over CAN or serial: reading it, changing it. */
struct config_client {
    struct dialogue *dialogue;
    bool refused, state_known, staged;
    uint16_t tag; /* of the words being sent */
    struct mr_config_refused reason;
    struct mr_config_state state;     /* as last sent after a hello */
    struct mr_config_staged progress; /* of the words being sent */
    struct configwords words;         /* being read */
    size_t told;                      /* received, each time */
};

/* The dialogue is the caller's; `talk` subscribes to it. Waits for the board's hello and the
 * identity of its configuration. Statuses as dialogue_hello. */
enum mr_status config_client_begin(struct config_client *talk, struct dialogue *dialogue,
                                   struct error *error);
/* The configuration in force and its CRC. MR_NOT_NOW: a landing is armed or going on; MR_VERSION:
 * of another table. */
enum mr_status config_client_get(struct config_client *talk, struct mr_config *config,
                                 uint32_t *crc, struct error *error);
/* Begins, makes a board that is done with a landing idle, and gets its configuration. */
enum mr_status config_client_meet(struct config_client *talk, struct dialogue *dialogue,
                                  struct mr_config *config, uint32_t *crc, struct error *error);
/* Keeps an idle board sending its edges and block records for `seconds`; 0: no longer. */
enum mr_status config_client_live(struct dialogue *dialogue, int seconds, struct error *error);
/* Sends it; MR_OK: it is in force, and in flash. On CAN the dialogue continues at its base.
 * MR_LIMIT: refused, `error` has the reason; MR_NOT_NOW. */
enum mr_status config_client_set(struct config_client *talk, const struct mr_config *config,
                                 struct error *error);

#endif
