/* The active configuration and its two copies in flash. It can be changed word by word over both
 * links.
 *
 *     host: config_word ...     into the staging area; config_staged reports the progress
 *     host: config-apply CRC    it is checked (common/config.h), and refused with a reason or
 *                               stored and made active
 *     host: config-read WORD    the active configuration is sent as config_image messages, from
 *                               that word on, on the link of the command
 *
 * A change is written to the inactive copy: the copy is erased and then written from its second
 * word on. Its first word, which makes the copy valid, is written last. The active copy is
 * therefore intact after a power failure at any time. At start, the copy with the higher revision
 * is used. A change must have the revision after the active one, so that a host cannot overwrite a
 * configuration that it has not read. The built-in configuration has the highest revision of the
 * refused intact copies.
 *
 * Without a copy, as on a new chip, the built-in configuration (config.c) is active, and
 * config_state reports this. A copy that is neither blank nor a complete configuration is the fault
 * CONFIG. */
#ifndef MATRIG_FIRMWARE_CONFIGSTORE_H
#define MATRIG_FIRMWARE_CONFIGSTORE_H

#include "common/catalogue.h"
#include "firmware/config.h"
#include "firmware/board.h"
#include "firmware/telemetry.h"

#define CONFIGSTORE_STAGED_WORDS    16u /* number of words between two progress reports */
/* number of words read out per block: all are sent within 1 s, which leaves room for other CAN
 * messages */
#define CONFIGSTORE_WORDS_PER_BLOCK 3u

enum configstore_source { CONFIGSTORE_BUILT_IN, CONFIGSTORE_COPY_A, CONFIGSTORE_COPY_B };

struct configstore {
    enum configstore_source source; /* source of the active configuration */
    /* state of each copy: negative status of mr_config_check_image, or CONFIGSTORE_BLANK */
    uint8_t copy_state[FLASH_COPIES];
    uint32_t crc; /* CRC of the active configuration */

    uint8_t image[MR_CONFIG_IMAGE_BYTES]; /* configuration being staged or read out */
    uint8_t received_words[(MR_CONFIG_WORDS + 7u) / 8u]; /* one bit per staged word */
    bool is_staging;
    uint16_t tag;               /* tag of the message that began the staged words */
    unsigned staged_word_count; /* number of staged words */
    bool is_reading, is_read_by_serial;
    unsigned next_read_word;
};

#define CONFIGSTORE_BLANK 255u

/* Call at start, before anything reads `config`. */
void configstore_start(struct configstore *store);
/* Processes a word of a new configuration. The word is accepted only if `locked` is
 * MR_CONFIG_UNLOCKED. */
void configstore_put_word(struct configstore *store, struct telemetry *telemetry,
                          const uint8_t *payload, size_t length, enum mr_config_locked locked);
/* Executes config-apply. MR_OK: `config` has changed, and everything derived from it must be
 * updated; MR_TOO_FEW: words are missing; MR_MALFORMED: not a configuration; MR_VERSION: a
 * configuration of a different layout; MR_CRC: damaged; MR_LIMIT: refused, with the reason in
 * config_refused; MR_IO: the flash failed. On failure the old configuration stays active. */
enum mr_status configstore_apply(struct configstore *store, struct telemetry *telemetry,
                                 uint32_t crc);
/* Executes config-read. MR_OK; MR_USAGE: no such word. */
enum mr_status configstore_read(struct configstore *store, uint32_t word, bool by_serial);
/* Call in each block: sends the next words being read out. A landing ends the read-out. */
void configstore_on_block(struct configstore *store, struct telemetry *telemetry, bool locked);
/* State for the message hello. */
struct mr_config_state configstore_get_state(const struct configstore *store);

#endif
