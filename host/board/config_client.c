#include "host/board/config_client.h"

#include <string.h>

#include "common/command.h"
#include "common/wire.h"
#include "host/board/config_text.h"

/* ---- words ---- */

static void put_word(struct configwords *words, const struct mr_config_image *word)
{
    words->there = word->words;
    if (word->words != MR_CONFIG_WORDS || word->offset >= MR_CONFIG_WORDS)
        return;
    mr_put_u32(words->image + 4u * word->offset, word->value);
    words->present[word->offset] = 1;
    words->ended |= word->offset == MR_CONFIG_WORDS - 1;
}

void configwords_take(struct configwords *words, const uint8_t *bytes, size_t length)
{
    struct mr_config_image word;
    if (mr_config_image_get(&word, bytes, length) == MR_OK)
        put_word(words, &word);
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

bool configwords_follow(struct configwords *words, const struct mr_config_image *word,
                        struct mr_config *config)
{
    uint32_t crc;
    if (word->words == MR_CONFIG_WORDS && word->offset == 0)
        memset(words->present, 0, sizeof words->present);
    words->ended = false;
    put_word(words, word);
    return words->ended && configwords_absent(words) == MR_CONFIG_WORDS &&
           configwords_decode(words, config, &crc) == MR_OK;
}

/* ---- reading and changing ---- */

#define WINDOW_S 2.0 /* time after which a window of words is sent again */
#define WINDOW   16u /* words; fits into the board's queues */
#define ROUNDS   6   /* attempts to request absent words, or to send words again */

static enum mr_status take(void *context, const struct dialogue_message *message,
                           struct error *error)
{
    struct config_client *talk = context;
    struct mr_config_staged staged;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    (void)error;
    switch (message->id) {
    case MR_ID_CONFIG_STATE:
        talk->state_known |= mr_config_state_get(&talk->state, bytes, length) == MR_OK;
        break;
    case MR_ID_CONFIG_IMAGE:
        configwords_take(&talk->words, bytes, length);
        talk->told++;
        break;
    case MR_ID_CONFIG_REFUSED:
        talk->refused |= mr_config_refused_get(&talk->reason, bytes, length) == MR_OK;
        break;
    case MR_ID_CONFIG_STAGED:
        if (mr_config_staged_get(&staged, bytes, length) == MR_OK && staged.tag == talk->tag) {
            talk->progress = staged;
            talk->staged = true;
        }
        break;
    default: break;
    }
    return MR_OK;
}

enum mr_status config_client_begin(struct config_client *talk, struct dialogue *dialogue,
                                   struct error *error)
{
    memset(talk, 0, sizeof *talk);
    talk->dialogue = dialogue;
    dialogue_subscribe(dialogue, take, talk);
    return dialogue_hello(dialogue, dialogue_flag, &talk->state_known, error);
}

static enum mr_status order(struct config_client *talk, uint8_t code, uint32_t argument,
                            struct mr_ack *ack, struct error *error)
{
    const struct dialogue_command order = {
        .code = code, .argument = (int32_t)argument, .answer_s = DIALOGUE_ANSWER_S};
    talk->refused = false;
    enum mr_status status = dialogue_send_command(talk->dialogue, &order, ack, error);
    return status == MR_TIMEOUT ? dialogue_lost(talk->dialogue, code, error) : status;
}

static enum mr_status not_now(const struct config_client *talk, struct error *error)
{
    return error_set(error, MR_NOT_NOW,
                     "the configuration is locked because a landing is armed or in progress: %s; "
                     "disarm the board, or wait for the end of the landing",
                     dialogue_spec(talk->dialogue));
}

/* One request for all words from the first absent one on. */
static enum mr_status ask_for_words(struct config_client *talk, struct error *error)
{
    struct mr_ack ack;
    talk->words.ended = false;
    enum mr_status status = order(talk, MR_COMMAND_CONFIG_READ, configwords_absent(&talk->words),
                                  &ack, error);
    if (status == MR_OK && ack.status != MR_OK)
        return ack.status == MR_NOT_NOW
                 ? not_now(talk, error)
                 : error_set(error, (enum mr_status)ack.status,
                             "the board did not send its configuration: %s; %s",
                             dialogue_spec(talk->dialogue),
                             mr_status_text((enum mr_status)ack.status));
    if (status == MR_OK)
        status = dialogue_while_coming(talk->dialogue, dialogue_flag, &talk->words.ended,
                                       &talk->told, WINDOW_S, error);
    if (status == MR_TIMEOUT && error->status == MR_OK) /* the caller requests absent words again */
        status = MR_OK;
    if (status == MR_OK && talk->words.there && talk->words.there != MR_CONFIG_WORDS)
        return error_set(error, MR_VERSION,
                         "the configuration of the board has %u words, that of this matrig %u: %s; "
                         "use the matrig version of the board's firmware",
                         talk->words.there, MR_CONFIG_WORDS, dialogue_spec(talk->dialogue));
    return status;
}

enum mr_status config_client_get(struct config_client *talk, struct mr_config *config,
                                 uint32_t *crc, struct error *error)
{
    enum mr_status status = MR_OK;
    talk->words = (struct configwords){.there = 0};
    for (int round = 0;
         status == MR_OK && round < ROUNDS && configwords_absent(&talk->words) < MR_CONFIG_WORDS;
         round++)
        status = ask_for_words(talk, error);
    if (status == MR_OK && configwords_absent(&talk->words) < MR_CONFIG_WORDS)
        return error_set(error, MR_TIMEOUT,
                         "the configuration is incomplete, word %u of %u was lost: %s; try again",
                         configwords_absent(&talk->words), MR_CONFIG_WORDS,
                         dialogue_spec(talk->dialogue));
    if (status != MR_OK)
        return status;
    status = configwords_decode(&talk->words, config, crc);
    if (status == MR_VERSION)
        return error_set(error, status,
                         "the configuration of the board has different fields than that of this "
                         "matrig: %s; use the matrig version of the board's firmware",
                         dialogue_spec(talk->dialogue));
    return status == MR_OK
             ? MR_OK
             : error_set(error, status, "the board sent no valid configuration (%s): %s; try again",
                         mr_status_text(status), dialogue_spec(talk->dialogue));
}

enum mr_status config_client_identify(struct config_client *talk, struct dialogue *dialogue,
                                      struct mr_config *config, uint32_t *crc, struct error *error)
{
    enum mr_status status = config_client_begin(talk, dialogue, error);
    /* a finished landing is stored already, so disarming is safe */
    if (status == MR_OK && dialogue->identity.hello.state == MR_LANDING_DONE)
        status = dialogue_execute(
            dialogue,
            &(struct dialogue_command){.code = MR_COMMAND_DISARM, .answer_s = DIALOGUE_ANSWER_S},
            NULL, error);
    return status ?: config_client_get(talk, config, crc, error);
}

enum mr_status config_client_live(struct dialogue *dialogue, int seconds, struct error *error)
{
    return dialogue_execute(dialogue,
                            &(struct dialogue_command){.code = MR_COMMAND_LIVE,
                                                       .argument = seconds,
                                                       .answer_s = DIALOGUE_ANSWER_S},
                            "the board must be idle", error);
}

/* Sends a window of words from `from` on, and waits for the board's next message about it. */
static enum mr_status send_window(struct config_client *talk, const uint8_t *image, unsigned from,
                                  struct error *error)
{
    unsigned to = (from / WINDOW + 1) * WINDOW;
    enum mr_status status = MR_OK;
    talk->staged = false;
    for (unsigned i = from; status == MR_OK && i < to && i < MR_CONFIG_WORDS; i++) {
        uint8_t payload[MR_MESSAGE_MAX];
        const uint8_t *p = image + 4u * i;
        struct mr_config_word word = {
            .offset = (uint16_t)i, .tag = talk->tag, .value = mr_get_u32(&p)};
        status = dialogue_send(talk->dialogue, MR_ID_CONFIG_WORD, payload,
                               mr_config_word_put(&word, payload), error);
    }
    if (status == MR_OK)
        status = dialogue_until(talk->dialogue, dialogue_flag, &talk->staged, WINDOW_S, error);
    /* the caller sends them again */
    return status == MR_TIMEOUT && error->status == MR_OK ? MR_OK : status;
}

static enum mr_status send_words(struct config_client *talk, const uint8_t *image,
                                 struct error *error)
{
    unsigned from = 0, idle = 0;
    while (from < MR_CONFIG_WORDS) {
        enum mr_status status = send_window(talk, image, from, error);
        if (status != MR_OK)
            return status;
        if (talk->staged && talk->progress.locked == MR_CONFIG_BY_CAN)
            return dialogue_refused(
                talk->dialogue,
                &(struct mr_ack){.code = MR_COMMAND_CONFIG_APPLY, .status = MR_CABLE}, NULL, error);
        if (talk->staged && talk->progress.locked)
            return not_now(talk, error);
        idle = talk->staged && talk->progress.missing > from ? 0 : idle + 1;
        if (idle == ROUNDS)
            return error_set(error, MR_TIMEOUT,
                             "the board did not accept word %u of the configuration: %s; check the "
                             "cable and try again",
                             from, dialogue_spec(talk->dialogue));
        if (talk->staged)
            from = talk->progress.missing;
    }
    return MR_OK;
}

static enum mr_status refused(const struct config_client *talk, const struct mr_config *config,
                              struct error *error)
{
    char text[500] = "the board gives no reason";
    const struct mr_config_refused *r = &talk->reason;
    struct mr_config_reason reason = {.group = r->group,
                                      .index = r->index,
                                      .field = r->field,
                                      .element = r->element,
                                      .rule = r->rule,
                                      .other = r->other};
    if (talk->refused)
        config_text_reason(config, &reason, text, sizeof text);
    return error_set(error, MR_LIMIT, "the board refused the configuration: %s; %s",
                     dialogue_spec(talk->dialogue), text);
}

enum mr_status config_client_set(struct config_client *talk, const struct mr_config *config,
                                 struct error *error)
{
    static uint8_t image[MR_CONFIG_IMAGE];
    struct mr_ack ack;
    uint32_t crc = mr_config_encode(config, image);
    /* a new tag, because another program may have left words staged */
    talk->tag = dialogue_next_tag(talk->dialogue);
    enum mr_status status = send_words(talk, image, error)
                              ?: order(talk, MR_COMMAND_CONFIG_APPLY, crc, &ack, error);
    if (status == MR_OK && ack.status == MR_OK) /* the answer is the last message at the old base */
        dialogue_move(talk->dialogue, config->site[0].can_base);
    if (status != MR_OK || ack.status == MR_OK)
        return status;
    if (ack.status == MR_NOT_NOW)
        return not_now(talk, error);
    if (ack.status == MR_LIMIT)
        return refused(talk, config, error);
    if (ack.status == MR_IO)
        return error_set(error, MR_IO,
                         "writing the flash of the board failed: %s; the old configuration is "
                         "still active; try again, and if it fails again, replace the board",
                         dialogue_spec(talk->dialogue));
    return error_set(error, (enum mr_status)ack.status,
                     "the board refused the configuration: %s; %s", dialogue_spec(talk->dialogue),
                     mr_status_text((enum mr_status)ack.status));
}
