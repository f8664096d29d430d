/* The configuration that a board tells word by word, into the database. */
#include <stdlib.h>
#include <string.h>

#include "common/wire.h"
#include "host/board/config_text.h"
#include "host/collect/collect_state.h"

static bool is_whole(const struct side *side)
{
    for (unsigned i = 0; i < MR_CONFIG_WORDS; i++) {
        if (!side->config_present[i])
            return false;
    }
    return true;
}

enum mr_status collect_config_word(struct collector *collector, struct side *side,
                                   const struct mr_config_image *word, struct error *error)
{
    struct mr_config config;
    if (word->words != MR_CONFIG_WORDS || word->offset >= MR_CONFIG_WORDS)
        return MR_OK; /* of another table */
    if (word->offset == 0)
        memset(side->config_present, 0, sizeof side->config_present);
    mr_put_u32(side->config_image + 4u * word->offset, word->value);
    side->config_present[word->offset] = 1;
    if (word->offset != MR_CONFIG_WORDS - 1 || !is_whole(side) ||
        mr_config_decode(side->config_image, MR_CONFIG_IMAGE, &config) != MR_OK)
        return MR_OK;
    char *text = config_text_write(&config);
    /* the last word is the CRC */
    enum mr_status status = store_configuration_put(collector->store, word->value, text, error);
    free(text);
    if (status == MR_OK) {
        collector->config_kept = true;
        collector->config_kept_crc = word->value;
    }
    return status;
}

bool collector_lacks_configuration(const struct collector *collector)
{
    bool known = collector->hello && collector->identity.config_crc != STORE_NONE;
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        if (collector->side[kind].current)
            return false; /* the board does not tell it from arm to done */
    }
    return known && !(collector->config_kept &&
                      collector->config_kept_crc == (uint32_t)collector->identity.config_crc);
}
