#include "firmware/configstore.h"

#include <string.h>

#include "common/wire.h"
#include "firmware/board.h"
#include "firmware/health.h"
#include "firmware/channels.h"

#define BOTH_COPIES 3u /* detail of the fault: both copies */

static uint32_t get_word(const uint8_t *image, unsigned word)
{
    const uint8_t *p = image + 4u * word;
    return mr_get_u32(&p);
}

static uint32_t get_copy_revision(unsigned copy)
{
    return get_word(flash_get_copy(copy), 4);
}

/* Checks a copy. An intact copy may still be refused, because another firmware version with other
 * rules may have written it. */
static uint8_t check_copy(unsigned copy)
{
    const uint8_t *bytes = flash_get_copy(copy);
    return mr_is_blank(bytes, MR_CONFIG_IMAGE_BYTES)
             ? CONFIGSTORE_BLANK
             : (uint8_t)-mr_config_check_image(bytes, FLASH_COPY_BYTES);
}

/* Checks that `config` is valid and fits no channel for which the board has no input. */
static enum mr_status check_config(struct mr_config_violation *reason)
{
    enum mr_status status = mr_config_check(&config, reason);
    for (unsigned c = 0; status == MR_OK && c < MR_CHANNELS; c++) {
        if (config.channel[c].kind == MR_KIND_NONE || board_input_mask() >> c & 1u)
            continue;
        *reason = (struct mr_config_violation){.group = MR_GROUP_channel,
                                               .index = (uint8_t)c,
                                               .field = MR_FIELD_channel_kind,
                                               .rule = MR_RULE_NO_INPUT};
        status = MR_LIMIT;
    }
    return status;
}

/* Applies a copy. Returns false, with nothing changed, if it is invalid. */
static bool use_copy(struct configstore *store, unsigned copy)
{
    struct mr_config_violation reason;
    memcpy(store->image, flash_get_copy(copy), MR_CONFIG_IMAGE_BYTES);
    mr_config_swap_image(store->image, &config);
    if (check_config(&reason) != MR_OK) {
        mr_config_swap_image(store->image, &config);
        store->copy_state[copy] = (uint8_t)-MR_LIMIT;
        return false;
    }
    store->source = copy ? CONFIGSTORE_COPY_B : CONFIGSTORE_COPY_A;
    store->crc = get_word(flash_get_copy(copy), MR_CONFIG_WORDS - 1);
    return true;
}

/* Returns the highest revision of intact copies that were refused. The next change must have a
 * higher revision; otherwise another firmware version, which accepts such a copy, would take the
 * copy for the newer configuration. */
static uint32_t find_refused_revision(const struct configstore *store)
{
    uint32_t highest = 0;
    for (unsigned copy = 0; copy < FLASH_COPIES; copy++) {
        bool whole = store->copy_state[copy] == (uint8_t)-MR_LIMIT ||
                     store->copy_state[copy] == (uint8_t)-MR_VERSION;
        if (whole && get_copy_revision(copy) > highest)
            highest = get_copy_revision(copy);
    }
    return highest;
}

static bool is_damaged(uint8_t copy)
{
    return copy != (uint8_t)MR_OK && copy != CONFIGSTORE_BLANK;
}

void configstore_start(struct configstore *store)
{
    memset(store, 0, sizeof *store);
    config_adapt_to_board(board_input_mask(), board_supply_mv());
    for (unsigned copy = 0; copy < FLASH_COPIES; copy++)
        store->copy_state[copy] = check_copy(copy);
    bool both = store->copy_state[0] == MR_OK && store->copy_state[1] == MR_OK;
    unsigned first = both ? get_copy_revision(1) > get_copy_revision(0)
                          : store->copy_state[0] != MR_OK;
    for (unsigned i = 0; i < FLASH_COPIES && store->source == CONFIGSTORE_BUILT_IN; i++) {
        if (store->copy_state[(first + i) % FLASH_COPIES] == MR_OK)
            use_copy(store, (first + i) % FLASH_COPIES);
    }
    if (store->source == CONFIGSTORE_BUILT_IN) {
        config.site[0].revision = find_refused_revision(store);
        store->crc = mr_config_encode(&config, store->image);
    }
    unsigned damaged = (is_damaged(store->copy_state[0]) ? 1u : 0u) |
                       (is_damaged(store->copy_state[1]) ? 2u : 0u);
    if (damaged)
        health_count_fault(
            MR_FAULT_CONFIG,
            (uint8_t)(store->source == CONFIGSTORE_BUILT_IN ? BOTH_COPIES : damaged));
}

struct mr_config_state configstore_get_state(const struct configstore *store)
{
    return (struct mr_config_state){.revision = config.site[0].revision,
                                    .source = (uint8_t)store->source,
                                    .copy_a = store->copy_state[0],
                                    .copy_b = store->copy_state[1]};
}

static bool is_received(const struct configstore *store, unsigned word)
{
    return store->received_words[word / 8u] >> (word % 8u) & 1u;
}

static void report_staged(const struct configstore *store, struct telemetry *telemetry,
                          uint16_t tag, enum mr_config_locked locked)
{
    struct mr_config_staged staged = {
        .tag = tag, .words = (uint16_t)store->staged_word_count, .locked = (uint8_t)locked};
    while (staged.missing < MR_CONFIG_WORDS && is_received(store, staged.missing))
        staged.missing++;
    TELEMETRY_SEND_MESSAGE(telemetry, TO_LINKS, config_staged, CONFIG_STAGED, &staged);
}

void configstore_put_word(struct configstore *store, struct telemetry *telemetry,
                          const uint8_t *payload, size_t length, enum mr_config_locked locked)
{
    struct mr_config_word word;
    if (mr_config_word_get(&word, payload, length) != MR_OK || word.offset >= MR_CONFIG_WORDS)
        return;
    if (!locked && (!store->is_staging || word.tag != store->tag)) {
        memset(store->received_words, 0, sizeof store->received_words);
        store->staged_word_count = 0;
        store->tag = word.tag;
        store->is_staging = true;
        store->is_reading = false;
    }
    if (!locked) {
        if (!is_received(store, word.offset))
            store->staged_word_count++;
        mr_put_u32(store->image + 4u * word.offset, word.value);
        store->received_words[word.offset / 8u] =
            (uint8_t)(store->received_words[word.offset / 8u] | 1u << (word.offset % 8u));
    }
    if (word.offset % CONFIGSTORE_STAGED_WORDS == CONFIGSTORE_STAGED_WORDS - 1 ||
        word.offset == MR_CONFIG_WORDS - 1)
        report_staged(store, telemetry, word.tag, locked);
}

/* Checks the staged image: MR_OK, or MR_LIMIT with the reason. `config` and the image are unchanged
 * afterwards. */
static enum mr_status check_staged(struct configstore *store, struct mr_config_violation *reason)
{
    uint32_t revision = config.site[0].revision;
    mr_config_swap_image(store->image, &config);
    enum mr_status status = check_config(reason);
    if (status == MR_OK && config.site[0].revision != revision + 1u) {
        *reason = (struct mr_config_violation){
            .group = MR_GROUP_site, .field = MR_FIELD_site_revision, .rule = MR_RULE_REVISION};
        status = MR_LIMIT;
    }
    mr_config_swap_image(store->image, &config);
    return status;
}

/* Writes the copy that is not in use. Its first word is written last, so that an interrupted copy
 * is not valid. */
static bool write_copy(const struct configstore *store, unsigned copy)
{
    flash_begin();
    bool written = flash_erase(copy);
    for (unsigned i = 1; written && i <= MR_CONFIG_WORDS; i++) {
        unsigned word = i % MR_CONFIG_WORDS;
        written = flash_program(copy, 4u * word, get_word(store->image, word));
    }
    flash_end();
    return written && memcmp(flash_get_copy(copy), store->image, MR_CONFIG_IMAGE_BYTES) == 0;
}

enum mr_status configstore_apply(struct configstore *store, struct telemetry *telemetry,
                                 uint32_t crc)
{
    struct mr_config_violation r;
    unsigned copy = store->source == CONFIGSTORE_COPY_A ? 1 : 0;
    if (!store->is_staging || store->staged_word_count != MR_CONFIG_WORDS)
        return MR_TOO_FEW;
    enum mr_status status = mr_config_check_image(store->image, MR_CONFIG_IMAGE_BYTES);
    if (status == MR_OK && get_word(store->image, MR_CONFIG_WORDS - 1) != crc)
        status = MR_CRC;
    if (status != MR_OK)
        return status;
    if (check_staged(store, &r) != MR_OK) {
        struct mr_config_refused refused = {.group = r.group,
                                            .index = r.index,
                                            .field = r.field,
                                            .element = r.element,
                                            .rule = r.rule,
                                            .other = r.other};
        TELEMETRY_SEND_MESSAGE(telemetry, TO_LINKS, config_refused, CONFIG_REFUSED, &refused);
        return MR_LIMIT;
    }
    bool written = write_copy(store, copy);
    store->copy_state[copy] = check_copy(copy);
    if (!written) {
        health_count_fault(MR_FAULT_CONFIG, (uint8_t)(copy + 1));
        return MR_IO;
    }
    store->is_staging = false;
    use_copy(store, copy);
    return MR_OK;
}

enum mr_status configstore_read(struct configstore *store, uint32_t word, bool by_serial)
{
    if (word >= MR_CONFIG_WORDS)
        return MR_USAGE;
    zero_swap(); /* store the configured zeros, not the ones measured since */
    mr_config_encode(&config, store->image);
    zero_swap();
    store->is_staging = false;
    store->is_reading = true;
    store->is_read_by_serial = by_serial;
    store->next_read_word = word;
    return MR_OK;
}

void configstore_on_block(struct configstore *store, struct telemetry *telemetry, bool locked)
{
    store->is_reading = store->is_reading && !locked;
    for (unsigned i = 0;
         store->is_reading && i < CONFIGSTORE_WORDS_PER_BLOCK && telemetry_can_burst(telemetry);
         i++) {
        TELEMETRY_SEND(telemetry, store->is_read_by_serial ? TO_SERIAL : TO_CAN, config_image,
                       CONFIG_IMAGE, .offset = (uint16_t)store->next_read_word,
                       .words = MR_CONFIG_WORDS,
                       .value = get_word(store->image, store->next_read_word));
        store->is_reading = ++store->next_read_word < MR_CONFIG_WORDS;
    }
}
