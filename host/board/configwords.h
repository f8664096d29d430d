/* A configuration as a board tells it: its words, one message `config_image` each, in any order,
 * some of them lost. */
#ifndef MATRIG_HOST_BOARD_CONFIGWORDS_H
#define MATRIG_HOST_BOARD_CONFIGWORDS_H

#include <stdbool.h>

#include "common/catalogue.h"
#include "common/config.h"

struct configwords {
    uint8_t image[MR_CONFIG_IMAGE];
    uint8_t present[MR_CONFIG_WORDS];
    unsigned there; /* words the board says it has; 0: none came */
    bool ended;     /* the last came, with which the board ends: cleared by who asks */
};

/* All zero: none. Takes a message; a word of another table is not kept. */
void configwords_take(struct configwords *words, const uint8_t *bytes, size_t length);
/* The first that is to be asked for; MR_CONFIG_WORDS: all came. */
unsigned configwords_absent(const struct configwords *words);
/* When all came: the configuration, and the CRC that it ends with. Statuses as mr_config_decode. */
enum mr_status configwords_decode(const struct configwords *words, struct mr_config *config,
                                  uint32_t *crc);

#endif
