/* Configuration of a board over CAN or serial: its words, and how to read and change it. */
#ifndef MATRIG_HOST_BOARD_CONFIG_CLIENT_H
#define MATRIG_HOST_BOARD_CONFIG_CLIENT_H

#include <stdbool.h>

#include "common/catalogue.h"
#include "common/config.h"
#include "host/board/dialogue.h"

/* A configuration as a board sends it: one message `config_image` per word, in any order. Some
 * words may be lost. */
struct config_words {
    uint8_t image[MR_CONFIG_IMAGE_BYTES];
    uint8_t is_present[MR_CONFIG_WORDS];
    unsigned count; /* number of words in the board's configuration; 0: none received */
    /* the last word of the sequence was received; the caller resets this flag */
    bool has_last_word;
};

/* Adds the word of a message. A word of a configuration with another layout is ignored. A zeroed
 * struct contains no words. */
void config_words_receive(struct config_words *words, const uint8_t *bytes, size_t length);
/* Adds a word that the board sends unasked. Returns true if it was the last word of the sequence
 * and `*config` now has the whole configuration. */
bool config_words_add(struct config_words *words, const struct mr_config_image *word,
                      struct mr_config *config);
/* Returns the index of the first missing word, to be requested next; MR_CONFIG_WORDS: all words
 * were received. */
unsigned config_words_find_missing(const struct config_words *words);
/* Decodes a complete set of words: the configuration, and the CRC at its end. Statuses as
 * mr_config_decode. */
enum mr_status config_words_decode(const struct config_words *words, struct mr_config *config,
                                   uint32_t *crc);

/* A client for the configuration of a board, over CAN or serial: reads and changes it. */
struct config_client {
    struct dialogue *dialogue;
    bool was_refused, state_known, is_staged;
    uint16_t tag; /* tag of the words being sent */
    struct mr_config_refused refusal;
    struct mr_config_state state;     /* newest state, sent by the board after its hello */
    struct mr_config_staged progress; /* progress of the words being sent */
    struct config_words words;        /* words received while reading a configuration */
    size_t received_count;            /* number of received words, repetitions included */
};

/* Waits for the board's hello and the identity of its configuration. The caller owns the dialogue;
 * `client` subscribes to it. Statuses as dialogue_wait_for_hello. */
enum mr_status config_client_begin(struct config_client *client, struct dialogue *dialogue,
                                   struct error *error);
/* Reads the active configuration and its CRC. MR_NOT_NOW: a landing is armed or in progress.
 * MR_VERSION: the configuration has another layout. */
enum mr_status config_client_get(struct config_client *client, struct mr_config *config,
                                 uint32_t *crc, struct error *error);
/* Calls config_client_begin, sets a board that has finished a landing to idle, and reads its
 * configuration. */
enum mr_status config_client_begin_and_get(struct config_client *client, struct dialogue *dialogue,
                                           struct mr_config *config, uint32_t *crc,
                                           struct error *error);
/* Makes an idle board send edges and block records for `seconds`; 0: stops them. */
enum mr_status config_client_set_live_duration(struct dialogue *dialogue, int seconds,
                                               struct error *error);
/* Sends a configuration. MR_OK: it is active and stored in flash; on CAN the dialogue continues at
 * the new base. MR_LIMIT: refused, and `error` has the reason. MR_NOT_NOW: a landing is armed or in
 * progress. */
enum mr_status config_client_set(struct config_client *client, const struct mr_config *config,
                                 struct error *error);

#endif
