#include "host/board/configtalk.h"
#include "host/link/diagnose.h"

#include <string.h>

#include "common/command.h"
#include "common/wire.h"
#include "host/board/configtext.h"
#include "host/board/listen.h"

#define ANSWER_S 10.0  /* without any, the board is taken not to listen */
#define WINDOW_S 2.0   /* without the answer to a window of words, they are sent again */
#define WINDOW 16u     /* words; the board's queues hold more */
#define ROUNDS 6       /* of asking for what has not come, of sending what did not arrive */

static void take_word(struct configtalk *talk, const struct mr_config_image *word)
{
    talk->words_there = word->words;
    if (word->offset >= MR_CONFIG_WORDS)
        return;
    mr_put_u32(talk->image + 4u * word->offset, word->value);
    talk->present[word->offset] = 1;
}

static enum mr_status take_message(void *context, uint32_t id, const uint8_t *bytes, size_t length, struct error *error)
{
    struct configtalk *talk = context;
    struct mr_config_image word;
    struct mr_config_staged staged;
    struct mr_board_uid uid;
    struct mr_board_image board_image;
    switch (id) {
    case MR_ID_HELLO:
        if (listen_hello(talk->link, bytes, length, error) != MR_OK)
            return MR_VERSION;
        talk->hello = true;
        break;
    case MR_ID_BOARD_UID:
        if (mr_board_uid_get(&uid, bytes, length) == MR_OK) {
            talk->uid[0] = uid.uid0;
            talk->uid[1] = uid.uid1;
        }
        break;
    case MR_ID_BOARD_IMAGE:
        if (mr_board_image_get(&board_image, bytes, length) == MR_OK)
            talk->uid[2] = board_image.uid2;
        break;
    case MR_ID_ACK:
        talk->acknowledged |= listen_ack(bytes, length, talk->tag, &talk->ack);
        break;
    case MR_ID_CONFIG_STATE:
        talk->state_known |= mr_config_state_get(&talk->state, bytes, length) == MR_OK;
        break;
    case MR_ID_CONFIG_IMAGE:
        if (mr_config_image_get(&word, bytes, length) == MR_OK)
            take_word(talk, &word);
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
    default:
        break;
    }
    return MR_OK;
}

/* What comes within a tenth of a second. */
static enum mr_status listen(struct configtalk *talk, struct error *error)
{
    return listen_either(talk->link, talk->kind, &talk->deframer, take_message, talk, error);
}

static enum mr_status send(struct configtalk *talk, uint16_t id, const uint8_t *payload, size_t length, struct error *error)
{
    return listen_send(talk->link, talk->kind, &talk->seq, id, payload, length, error);
}

enum mr_status configtalk_begin(struct configtalk *talk, struct link *link, enum link_kind kind, struct error *error)
{
    double until_s = listen_now_s() + ANSWER_S;
    enum mr_status status = MR_OK;
    memset(talk, 0, sizeof *talk);
    talk->link = link;
    talk->kind = kind;
    talk->tag = (uint16_t)(link_now_us() / 1000u); /* not that of the words somebody else left staged */
    mr_deframer_init(&talk->deframer);
    while (status == MR_OK && !(talk->hello && talk->state_known)) {
        if (listen_now_s() > until_s)
            return link_no_board(link, error);
        status = listen(talk, error);
    }
    return status;
}

static enum mr_status order(struct configtalk *talk, uint8_t code, uint32_t argument, struct error *error)
{
    uint8_t payload[MR_MESSAGE_MAX];
    struct mr_command command = {.code = code, .argument = (int32_t)argument, .tag = talk->tag};
    double until_s = listen_now_s() + ANSWER_S;
    talk->acknowledged = talk->refused = false;
    enum mr_status status = send(talk, MR_ID_COMMAND, payload, mr_command_put(&command, payload), error);
    while (status == MR_OK && !talk->acknowledged) {
        if (listen_now_s() > until_s)
            return error_set(error, MR_TIMEOUT, "the board does not answer `%s`: %s; is it running and connected?",
                             mr_command_name(code), link_spec(talk->link));
        status = listen(talk, error);
    }
    return status;
}

static enum mr_status not_now(const struct configtalk *talk, struct error *error)
{
    return error_set(error, MR_NOT_NOW, "the configuration is locked, a landing is armed or going on: %s; disarm it, or wait until it is done",
                     link_spec(talk->link));
}

static unsigned first_absent(const struct configtalk *talk)
{
    unsigned word = 0;
    while (word < MR_CONFIG_WORDS && talk->present[word])
        word++;
    return word;
}

enum mr_status configtalk_get(struct configtalk *talk, struct mr_config *config, uint32_t *crc, struct error *error)
{
    enum mr_status status = MR_OK;
    memset(talk->present, 0, sizeof talk->present);
    talk->words_there = 0;
    for (int round = 0; status == MR_OK && round < ROUNDS && first_absent(talk) < MR_CONFIG_WORDS; round++) {
        unsigned from = first_absent(talk), last = from;
        talk->tag++;
        status = order(talk, MR_COMMAND_CONFIG_READ, from, error);
        if (status == MR_OK && talk->ack.status != MR_OK)
            return talk->ack.status == MR_NOT_NOW
                       ? not_now(talk, error)
                       : error_set(error, (enum mr_status)talk->ack.status, "the board does not tell its configuration: %s; %s",
                                   link_spec(talk->link), mr_status_text((enum mr_status)talk->ack.status));
        double until_s = listen_now_s() + WINDOW_S;
        while (status == MR_OK && !talk->present[MR_CONFIG_WORDS - 1] && listen_now_s() < until_s) {
            status = listen(talk, error);
            if (first_absent(talk) != last)
                until_s = listen_now_s() + WINDOW_S;
            last = first_absent(talk);
        }
        if (status == MR_OK && talk->words_there && talk->words_there != MR_CONFIG_WORDS)
            return error_set(error, MR_VERSION, "the board's configuration has %u words, this matrig's %u: %s; use the matrig of its firmware",
                             talk->words_there, MR_CONFIG_WORDS, link_spec(talk->link));
    }
    if (status == MR_OK && first_absent(talk) < MR_CONFIG_WORDS)
        return error_set(error, MR_TIMEOUT, "the configuration did not come whole, word %u of %u is lost: %s; try again",
                         first_absent(talk), MR_CONFIG_WORDS, link_spec(talk->link));
    if (status != MR_OK)
        return status;
    const uint8_t *p = talk->image + MR_CONFIG_IMAGE - 4;
    *crc = mr_get_u32(&p);
    status = mr_config_decode(talk->image, MR_CONFIG_IMAGE, config);
    if (status == MR_VERSION)
        return error_set(error, status, "the board's configuration has other fields than this matrig's: %s; use the matrig of its firmware",
                         link_spec(talk->link));
    return status == MR_OK ? MR_OK : error_set(error, status, "what the board told is no configuration (%s): %s; try again",
                                               mr_status_text(status), link_spec(talk->link));
}

/* A window of words from `from` on, to the end of the board's next answer. */
static enum mr_status send_window(struct configtalk *talk, const uint8_t *image, unsigned from, struct error *error)
{
    unsigned to = (from / WINDOW + 1) * WINDOW;
    enum mr_status status = MR_OK;
    talk->staged = false;
    for (unsigned i = from; status == MR_OK && i < to && i < MR_CONFIG_WORDS; i++) {
        uint8_t payload[MR_MESSAGE_MAX];
        const uint8_t *p = image + 4u * i;
        struct mr_config_word word = {.offset = (uint16_t)i, .tag = talk->tag, .value = mr_get_u32(&p)};
        status = send(talk, MR_ID_CONFIG_WORD, payload, mr_config_word_put(&word, payload), error);
    }
    double until_s = listen_now_s() + WINDOW_S;
    while (status == MR_OK && !talk->staged && listen_now_s() < until_s)
        status = listen(talk, error);
    return status;
}

static enum mr_status send_words(struct configtalk *talk, const uint8_t *image, struct error *error)
{
    unsigned from = 0, idle = 0;
    while (from < MR_CONFIG_WORDS) {
        enum mr_status status = send_window(talk, image, from, error);
        if (status != MR_OK)
            return status;
        if (talk->staged && talk->progress.locked)
            return not_now(talk, error);
        idle = talk->staged && talk->progress.missing > from ? 0 : idle + 1;
        if (idle == ROUNDS)
            return error_set(error, MR_TIMEOUT, "the board does not take word %u of the configuration: %s; is the link sound?", from,
                             link_spec(talk->link));
        if (talk->staged)
            from = talk->progress.missing;
    }
    return MR_OK;
}

static enum mr_status refused(const struct configtalk *talk, const struct mr_config *config, struct error *error)
{
    char text[500] = "it does not say why";
    const struct mr_config_refused *r = &talk->reason;
    struct mr_config_reason reason = {.group = r->group, .index = r->index, .field = r->field, .element = r->element,
                                      .rule = r->rule, .other = r->other};
    if (talk->refused)
        configtext_reason(config, &reason, text, sizeof text);
    return error_set(error, MR_LIMIT, "the board refuses the configuration: %s; %s", link_spec(talk->link), text);
}

enum mr_status configtalk_set(struct configtalk *talk, const struct mr_config *config, struct error *error)
{
    static uint8_t image[MR_CONFIG_IMAGE];
    uint32_t crc = mr_config_encode(config, image);
    talk->tag++;
    enum mr_status status = send_words(talk, image, error);
    if (status == MR_OK)
        status = order(talk, MR_COMMAND_CONFIG_APPLY, crc, error);
    if (status != MR_OK || talk->ack.status == MR_OK)
        return status;
    if (talk->ack.status == MR_NOT_NOW)
        return not_now(talk, error);
    if (talk->ack.status == MR_LIMIT)
        return refused(talk, config, error);
    if (talk->ack.status == MR_IO)
        return error_set(error, MR_IO, "the board's flash failed: %s; the old configuration is in force; try again, then change the board",
                         link_spec(talk->link));
    return error_set(error, (enum mr_status)talk->ack.status, "the board refuses the configuration: %s; %s", link_spec(talk->link),
                     mr_status_text((enum mr_status)talk->ack.status));
}
