/* The configuration in force and its two copies in flash; changing it, word by word, over either
 * link.
 *
 *     host: config_word ...     into the staging area; config_staged tells how far it has come
 *     host: config-apply CRC    it is looked at (common/config.h), refused with a reason, or stored
 *                               and in force
 *     host: config-read WORD    the configuration in force, as config_image messages from that word
 *                               on, on the link that asked
 *
 * A change goes to the copy that is not in force: erased, then written from its second word on, the
 * first word last: only with that is it one. Whenever the power goes, the copy in force is whole,
 * and after the last word both are; at start the one of the higher revision wins. A change must be
 * of the revision after the one in force, so nobody overwrites what he has not read. What is built
 * in has the highest revision of whole copies that were refused.
 *
 * No copy, as in a new chip: what is built in (config.c) is in force, and config_state says so. A
 * copy that holds something but not a whole configuration is a fault, CONFIG. */
#ifndef MATRIG_FIRMWARE_CONFIGSTORE_H
#define MATRIG_FIRMWARE_CONFIGSTORE_H

#include "common/catalogue.h"
#include "firmware/config.h"
#include "firmware/board.h"
#include "firmware/telemetry.h"

#define CONFIGSTORE_STAGED_WORDS    16u /* told after so many */
/* read out: 1 s takes them all, and CAN has room for the rest */
#define CONFIGSTORE_WORDS_PER_BLOCK 3u

enum configstore_source { CONFIGSTORE_BUILT_IN, CONFIGSTORE_COPY_A, CONFIGSTORE_COPY_B };

struct configstore {
    enum configstore_source source; /* of what is in force */
    uint8_t copy[FLASH_COPIES];     /* minus the status of mr_config_examine; CONFIGSTORE_BLANK */
    uint32_t crc;                   /* of what is in force */

    uint8_t image[MR_CONFIG_IMAGE];                /* what is staged, or read out */
    uint8_t received[(MR_CONFIG_WORDS + 7u) / 8u]; /* bit per word of what is staged */
    bool staging;
    uint16_t tag;   /* of the words that are staged */
    unsigned words; /* of them */
    bool telling, tell_serial;
    unsigned tell_next;
};

#define CONFIGSTORE_BLANK 255u

/* At start, before anything reads `config`. */
void configstore_start(struct configstore *store);
/* A word of a new configuration; taken when `locked` is MR_CONFIG_OPEN. */
void configstore_word(struct configstore *store, struct telemetry *telemetry,
                      const uint8_t *payload, size_t length, enum mr_config_locked locked);
/* config-apply. MR_OK: `config` is another now, everything derived from it must be;
 * MR_TOO_FEW: words are missing; MR_MALFORMED, MR_VERSION, MR_CRC: no configuration,
 * another table's, damaged; MR_LIMIT: refused, config_refused says why; MR_IO: the flash failed.
 * All but MR_OK leave the old one in force. */
enum mr_status configstore_apply(struct configstore *store, struct telemetry *telemetry,
                                 uint32_t crc);
/* config-read. MR_OK; MR_USAGE: no such word. */
enum mr_status configstore_read(struct configstore *store, uint32_t word, bool by_serial);
/* Each block: what is to be told. A landing ends the telling. */
void configstore_block(struct configstore *store, struct telemetry *telemetry, bool locked);
/* For hello. */
struct mr_config_state configstore_state(const struct configstore *store);

#endif
