#include "host/board/config_client.h"

#include <string.h>

#include "common/command.h"
#include "common/wire.h"
#include "host/board/config_text.h"

/* ---- words ---- */

static void store_word(struct config_words *words, const struct mr_config_image *word)
{
    words->count = word->words;
    if (word->words != MR_CONFIG_WORDS || word->offset >= MR_CONFIG_WORDS)
        return;
    mr_put_u32(words->image + 4u * word->offset, word->value);
    words->is_present[word->offset] = 1;
    words->has_last_word |= word->offset == MR_CONFIG_WORDS - 1;
}

void config_words_receive(struct config_words *words, const uint8_t *bytes, size_t length)
{
    struct mr_config_image word;
    if (mr_config_image_get(&word, bytes, length) == MR_OK)
        store_word(words, &word);
}

unsigned config_words_find_missing(const struct config_words *words)
{
    unsigned word = 0;
    while (word < MR_CONFIG_WORDS && words->is_present[word])
        word++;
    return word;
}

enum mr_status config_words_decode(const struct config_words *words, struct mr_config *config,
                                   uint32_t *crc)
{
    const uint8_t *p = words->image + MR_CONFIG_IMAGE_BYTES - 4;
    *crc = mr_get_u32(&p);
    return mr_config_decode(words->image, MR_CONFIG_IMAGE_BYTES, config);
}

bool config_words_add(struct config_words *words, const struct mr_config_image *word,
                      struct mr_config *config)
{
    uint32_t crc;
    if (word->words == MR_CONFIG_WORDS && word->offset == 0)
        memset(words->is_present, 0, sizeof words->is_present);
    words->has_last_word = false;
    store_word(words, word);
    return words->has_last_word && config_words_find_missing(words) == MR_CONFIG_WORDS &&
           config_words_decode(words, config, &crc) == MR_OK;
}

/* ---- reading and changing ---- */

#define WINDOW_TIMEOUT_S 2.0 /* time after which an unanswered window of words is sent again */
/* words in a window (words sent without waiting for an answer); must fit into the board's queues */
#define WINDOW_WORDS     16u
#define ATTEMPTS_MAX     6 /* attempts to request missing words, or to send words again */

static enum mr_status handle_message(void *context, const struct dialogue_message *message,
                                     struct error *error)
{
    struct config_client *client = context;
    struct mr_config_staged staged;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    (void)error;
    switch (message->id) {
    case MR_ID_CONFIG_STATE:
        client->state_known |= mr_config_state_get(&client->state, bytes, length) == MR_OK;
        break;
    case MR_ID_CONFIG_IMAGE:
        config_words_receive(&client->words, bytes, length);
        client->received_count++;
        break;
    case MR_ID_CONFIG_REFUSED:
        client->was_refused |= mr_config_refused_get(&client->refusal, bytes, length) == MR_OK;
        break;
    case MR_ID_CONFIG_STAGED:
        if (mr_config_staged_get(&staged, bytes, length) == MR_OK && staged.tag == client->tag) {
            client->progress = staged;
            client->is_staged = true;
        }
        break;
    default: break;
    }
    return MR_OK;
}

enum mr_status config_client_begin(struct config_client *client, struct dialogue *dialogue,
                                   struct error *error)
{
    memset(client, 0, sizeof *client);
    client->dialogue = dialogue;
    dialogue_subscribe(dialogue, handle_message, client);
    return dialogue_wait_for_hello(dialogue, dialogue_is_flag_set, &client->state_known, error);
}

static enum mr_status send_command(struct config_client *client, uint8_t code, uint32_t argument,
                                   struct mr_ack *ack, struct error *error)
{
    const struct dialogue_command order = {
        .code = code, .argument = (int32_t)argument, .answer_timeout_s = DIALOGUE_ANSWER_TIMEOUT_S};
    client->was_refused = false;
    enum mr_status status = dialogue_send_command(client->dialogue, &order, ack, error);
    return status == MR_TIMEOUT ? dialogue_set_no_answer_error(client->dialogue, code, error)
                                : status;
}

static enum mr_status set_locked_error(const struct config_client *client, struct error *error)
{
    return error_set(error, MR_NOT_NOW,
                     "the configuration is locked because a landing is armed or in progress: %s; "
                     "disarm the board, or wait for the end of the landing",
                     dialogue_spec(client->dialogue));
}

/* Requests all words from the first missing one on. */
static enum mr_status request_words(struct config_client *client, struct error *error)
{
    struct mr_ack ack;
    client->words.has_last_word = false;
    enum mr_status status = send_command(client, MR_COMMAND_CONFIG_READ,
                                         config_words_find_missing(&client->words), &ack, error);
    if (status == MR_OK && ack.status != MR_OK)
        return ack.status == MR_NOT_NOW
                 ? set_locked_error(client, error)
                 : error_set(error, (enum mr_status)ack.status,
                             "the board did not send its configuration: %s; %s",
                             dialogue_spec(client->dialogue),
                             mr_status_text((enum mr_status)ack.status));
    if (status == MR_OK)
        status = dialogue_wait_while_receiving(client->dialogue, dialogue_is_flag_set,
                                               &client->words.has_last_word,
                                               &client->received_count, WINDOW_TIMEOUT_S, error);
    /* MR_TIMEOUT is no failure here: the caller requests missing words again */
    if (status == MR_TIMEOUT && error->status == MR_OK)
        status = MR_OK;
    if (status == MR_OK && client->words.count && client->words.count != MR_CONFIG_WORDS)
        return error_set(error, MR_VERSION,
                         "the configuration of the board has %u words, but this matrig expects %u: "
                         "%s; use the matrig version that belongs to the board's firmware",
                         client->words.count, MR_CONFIG_WORDS, dialogue_spec(client->dialogue));
    return status;
}

enum mr_status config_client_get(struct config_client *client, struct mr_config *config,
                                 uint32_t *crc, struct error *error)
{
    enum mr_status status = MR_OK;
    client->words = (struct config_words){.count = 0};
    for (int round = 0; status == MR_OK && round < ATTEMPTS_MAX &&
                        config_words_find_missing(&client->words) < MR_CONFIG_WORDS;
         round++)
        status = request_words(client, error);
    if (status == MR_OK && config_words_find_missing(&client->words) < MR_CONFIG_WORDS)
        return error_set(
            error, MR_TIMEOUT,
            "the configuration is incomplete, because word %u of %u was lost: %s; try again",
            config_words_find_missing(&client->words), MR_CONFIG_WORDS,
            dialogue_spec(client->dialogue));
    if (status != MR_OK)
        return status;
    status = config_words_decode(&client->words, config, crc);
    if (status == MR_VERSION)
        return error_set(error, status,
                         "the configuration of the board has other fields than this matrig "
                         "expects: %s; use the matrig version that belongs to the board's firmware",
                         dialogue_spec(client->dialogue));
    return status == MR_OK
             ? MR_OK
             : error_set(error, status, "the board sent no valid configuration (%s): %s; try again",
                         mr_status_text(status), dialogue_spec(client->dialogue));
}

enum mr_status config_client_begin_and_get(struct config_client *client, struct dialogue *dialogue,
                                           struct mr_config *config, uint32_t *crc,
                                           struct error *error)
{
    enum mr_status status = config_client_begin(client, dialogue, error);
    /* a finished landing is already stored, so disarming loses no data */
    if (status == MR_OK && dialogue->identity.hello.state == MR_LANDING_DONE)
        status = dialogue_execute(
            dialogue,
            &(struct dialogue_command){.code = MR_COMMAND_DISARM,
                                       .answer_timeout_s = DIALOGUE_ANSWER_TIMEOUT_S},
            NULL, error);
    return status ?: config_client_get(client, config, crc, error);
}

enum mr_status config_client_set_live_duration(struct dialogue *dialogue, int seconds,
                                               struct error *error)
{
    return dialogue_execute(
        dialogue,
        &(struct dialogue_command){.code = MR_COMMAND_LIVE,
                                   .argument = seconds,
                                   .answer_timeout_s = DIALOGUE_ANSWER_TIMEOUT_S},
        "the board must be idle", error);
}

/* Sends a window of words from `from` on, and waits for the board's next message about it. */
static enum mr_status send_window(struct config_client *client, const uint8_t *image, unsigned from,
                                  struct error *error)
{
    unsigned to = (from / WINDOW_WORDS + 1) * WINDOW_WORDS;
    enum mr_status status = MR_OK;
    client->is_staged = false;
    for (unsigned i = from; status == MR_OK && i < to && i < MR_CONFIG_WORDS; i++) {
        uint8_t payload[MR_MESSAGE_BYTES_MAX];
        const uint8_t *p = image + 4u * i;
        struct mr_config_word word = {
            .offset = (uint16_t)i, .tag = client->tag, .value = mr_get_u32(&p)};
        status = dialogue_send(client->dialogue, MR_ID_CONFIG_WORD, payload,
                               mr_config_word_put(&word, payload), error);
    }
    if (status == MR_OK)
        status = dialogue_wait_until(client->dialogue, dialogue_is_flag_set, &client->is_staged,
                                     WINDOW_TIMEOUT_S, error);
    /* MR_TIMEOUT is no failure here: the caller sends the words again */
    return status == MR_TIMEOUT && error->status == MR_OK ? MR_OK : status;
}

static enum mr_status send_words(struct config_client *client, const uint8_t *image,
                                 struct error *error)
{
    unsigned from = 0, idle = 0;
    while (from < MR_CONFIG_WORDS) {
        enum mr_status status = send_window(client, image, from, error);
        if (status != MR_OK)
            return status;
        if (client->is_staged && client->progress.locked == MR_CONFIG_LOCKED_CAN)
            return dialogue_set_refusal_error(
                client->dialogue,
                &(struct mr_ack){.code = MR_COMMAND_CONFIG_APPLY, .status = MR_CABLE}, NULL, error);
        if (client->is_staged && client->progress.locked)
            return set_locked_error(client, error);
        idle = client->is_staged && client->progress.missing > from ? 0 : idle + 1;
        if (idle == ATTEMPTS_MAX)
            return error_set(error, MR_TIMEOUT,
                             "the board did not accept word %u of the configuration: %s; check the "
                             "cable and try again",
                             from, dialogue_spec(client->dialogue));
        if (client->is_staged)
            from = client->progress.missing;
    }
    return MR_OK;
}

static enum mr_status set_refusal_error(const struct config_client *client,
                                        const struct mr_config *config, struct error *error)
{
    char text[500] = "the board gave no reason";
    const struct mr_config_refused *r = &client->refusal;
    struct mr_config_violation reason = {.group = r->group,
                                         .index = r->index,
                                         .field = r->field,
                                         .element = r->element,
                                         .rule = r->rule,
                                         .other = r->other};
    if (client->was_refused)
        config_text_reason(config, &reason, text, sizeof text);
    return error_set(error, MR_LIMIT, "the board refused the configuration: %s; %s",
                     dialogue_spec(client->dialogue), text);
}

enum mr_status config_client_set(struct config_client *client, const struct mr_config *config,
                                 struct error *error)
{
    static uint8_t image[MR_CONFIG_IMAGE_BYTES];
    struct mr_ack ack;
    uint32_t crc = mr_config_encode(config, image);
    /* Use a new tag: words of another program with the old tag may still be staged on the board. */
    client->tag = dialogue_next_tag(client->dialogue);
    enum mr_status status = send_words(client, image, error)
                              ?: send_command(client, MR_COMMAND_CONFIG_APPLY, crc, &ack, error);
    /* the board sends this answer from the old CAN base and then uses the new one */
    if (status == MR_OK && ack.status == MR_OK)
        dialogue_set_base(client->dialogue, config->site[0].can_base);
    if (status != MR_OK || ack.status == MR_OK)
        return status;
    if (ack.status == MR_NOT_NOW)
        return set_locked_error(client, error);
    if (ack.status == MR_LIMIT)
        return set_refusal_error(client, config, error);
    if (ack.status == MR_IO)
        return error_set(error, MR_IO,
                         "the board could not write its flash, so the old configuration is still "
                         "active: %s; try again, and replace the board if this fails again",
                         dialogue_spec(client->dialogue));
    return error_set(error, (enum mr_status)ack.status,
                     "the board refused the configuration: %s; %s", dialogue_spec(client->dialogue),
                     mr_status_text((enum mr_status)ack.status));
}
