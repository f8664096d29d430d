#include "host/board/configwords.h"

#include "common/wire.h"

void configwords_take(struct configwords *words, const uint8_t *bytes, size_t length)
{
    struct mr_config_image word;
    if (mr_config_image_get(&word, bytes, length) != MR_OK)
        return;
    words->there = word.words;
    if (word.words != MR_CONFIG_WORDS || word.offset >= MR_CONFIG_WORDS)
        return;
    mr_put_u32(words->image + 4u * word.offset, word.value);
    words->present[word.offset] = 1;
    words->ended |= word.offset == MR_CONFIG_WORDS - 1;
}

unsigned configwords_absent(const struct configwords *words)
{
    unsigned word = 0;
    while (word < MR_CONFIG_WORDS && words->present[word])
        word++;
    return word;
}

enum mr_status configwords_decode(const struct configwords *words, struct mr_config *config,
                                  uint32_t *crc)
{
    const uint8_t *p = words->image + MR_CONFIG_IMAGE - 4;
    *crc = mr_get_u32(&p);
    return mr_config_decode(words->image, MR_CONFIG_IMAGE, config);
}
