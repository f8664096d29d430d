#include "host/board/dialogue.h"

#include <assert.h>
#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/canbase.h"
#include "common/command.h"
#include "host/board/keyfile.h"
#include "host/link/link.h"
#include "host/base/cli.h"
#include "host/base/monotonic_clock.h"

#define SERIAL_BYTES_PER_RECEIVE    16384u
#define CAN_FRAMES_PER_RECEIVE      64
/* the board sends the key state within this time after a hello */
#define KEY_STATE_AFTER_HELLO_S     0.2
/* longer than the 1 s that the board waits between two hellos or two nonces */
#define KEY_STATE_TIMEOUT_S         1.5
/* number of tries per command, because another program may use the nonce first */
#define PROOF_TRIES_MAX             3u
/* maximum number of extra receptions after a deadline, to read data that had already arrived */
#define RECEIVES_AFTER_DEADLINE_MAX 16

/* ---- identity ---- */

static void update_image_identity(struct identity *identity, const uint8_t *bytes, size_t length)
{
    struct mr_board_image image;
    if (!identity->hello_known || mr_board_image_get(&image, bytes, length) != MR_OK)
        return;
    identity->uid[2] = image.uid2;
    identity->image_crc = image.image_crc;
    identity->image_known = true;
}

void identity_receive(struct identity *identity, uint32_t id, const uint8_t *bytes, size_t length)
{
    struct mr_board_uid uid;
    struct mr_config_state state;
    switch (id) {
    case MR_ID_HELLO:
        identity->hello_known |= mr_hello_get(&identity->hello, bytes, length) == MR_OK;
        break;
    case MR_ID_BOARD_UID:
        if (mr_board_uid_get(&uid, bytes, length) == MR_OK) {
            identity->uid[0] = uid.uid0;
            identity->uid[1] = uid.uid1;
        }
        break;
    case MR_ID_BOARD_IMAGE: update_image_identity(identity, bytes, length); break;
    case MR_ID_IMAGE_COMMIT: (void)mr_image_commit_get(&identity->commit, bytes, length); break;
    case MR_ID_IMAGE_HEADER: /* this message is the last one of the identity */
        identity->commit_known |= identity->image_known &&
                                  mr_image_header_get(&identity->header, bytes, length) == MR_OK;
        break;
    case MR_ID_CONFIG_STATE:
        if (mr_config_state_get(&state, bytes, length) == MR_OK) {
            identity->board_type = state.board;
            identity->board_known = true;
        }
        break;
    case MR_ID_BUS_KEY:
        identity->key_known |= mr_bus_key_get(&identity->key, bytes, length) == MR_OK;
        break;
    case MR_ID_NONCE:
        identity->nonce_known |= length == MR_PROOF_BYTES;
        if (length == MR_PROOF_BYTES)
            memcpy(identity->nonce, bytes, MR_PROOF_BYTES);
        break;
    default: break;
    }
}

enum mr_status identity_check_layout(const struct identity *identity, const char *spec,
                                     struct error *error)
{
    if (identity->hello.layout == MR_LAYOUT)
        return MR_OK;
    return error_set(
        error, MR_VERSION,
        "the board uses layout %u, but this matrig uses layout %u: %s; use the matrig version "
        "that belongs to the board's firmware",
        identity->hello.layout, MR_LAYOUT, spec);
}

void identity_uid_text(const struct identity *identity, char out[IDENTITY_UID_SIZE])
{
    snprintf(out, IDENTITY_UID_SIZE, "%08X%08X%08X", (unsigned)identity->uid[0],
             (unsigned)identity->uid[1], (unsigned)identity->uid[2]);
}

bool identity_is_running(const struct identity *identity, const struct mr_image *image, char *why,
                         size_t size)
{
    char runs[MR_IMAGE_COMMIT_TEXT], file[MR_IMAGE_COMMIT_TEXT];
    if (!identity->commit_known || identity->commit.state != MR_IMAGE_INTACT) {
        snprintf(why, size, "the board's image: %s",
                 identity->commit_known ? mr_image_state_text(identity->commit.state)
                                        : "no header");
        return false;
    }
    mr_image_commit_text(identity->commit.commit, identity->commit.commit_more,
                         identity->commit.changed != 0, runs);
    mr_image_commit_text(image->commit, image->commit_more, image->is_modified, file);
    if (identity->image_crc != image->program_crc)
        snprintf(why, size, "program CRC %08x instead of %08x (commit %s instead of %s)",
                 (unsigned)identity->image_crc, (unsigned)image->program_crc, runs, file);
    else if (identity->header.header_crc != image->header_crc)
        snprintf(why, size,
                 "the program is that of the image, but the header or the interrupt vectors differ "
                 "(commit %s instead of %s)",
                 runs, file);
    else
        return true;
    return false;
}

/* ---- links ---- */

void dialogue_begin(struct dialogue *dialogue, struct link *can, struct link *serial)
{
    *dialogue = (struct dialogue){.now_s = monotonic_s,
                                  .link = {[LINK_CAN] = can, [LINK_SERIAL] = serial}};
    dialogue->kind = serial ? LINK_SERIAL : LINK_CAN;
    /* start value that another program is unlikely to use as its tag */
    dialogue->tag = (uint16_t)(link_now_us() / 1000u);
    mr_deframer_init(&dialogue->deframer);
}

enum mr_status dialogue_open(struct dialogue *dialogue, const char *can, const char *serial,
                             struct error *error)
{
    struct link *link[LINK_KINDS] = {NULL, NULL};
    enum mr_status status = MR_OK;
    if (serial)
        status = link_open(serial, LINK_SERIAL, &link[LINK_SERIAL], error);
    if (status == MR_OK && can)
        status = link_open(can, LINK_CAN, &link[LINK_CAN], error);
    dialogue_begin(dialogue, link[LINK_CAN], link[LINK_SERIAL]);
    if (status != MR_OK)
        dialogue_close(dialogue);
    return status;
}

void dialogue_close(struct dialogue *dialogue)
{
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        link_close(dialogue->link[kind]);
        dialogue->link[kind] = NULL;
    }
}

static struct dialogue command_dialogue;

static void close_command_dialogue(void)
{
    dialogue_close(&command_dialogue);
}

struct dialogue *dialogue_open_for_command(const char *can, const char *serial)
{
    struct error error = {0};
    atexit(close_command_dialogue);
    /* On failure error_set ends the program, and close_command_dialogue (called at exit) closes a
     * link that is already open. */
    if (dialogue_open(&command_dialogue, can, serial, &error) != MR_OK)
        error_set(fatal, error.status, "%s", error.text);
    return &command_dialogue;
}

struct link *dialogue_link(const struct dialogue *dialogue)
{
    return dialogue->link[dialogue->kind];
}

const char *dialogue_spec(const struct dialogue *dialogue)
{
    return link_get_spec(dialogue_link(dialogue));
}

double dialogue_now_s(const struct dialogue *dialogue)
{
    return dialogue->now_s();
}

/* ---- messages ---- */

void dialogue_subscribe(struct dialogue *dialogue, dialogue_handler *handle, void *context)
{
    assert(dialogue->subscriber_count < DIALOGUE_SUBSCRIBERS_MAX);
    dialogue->subscriber[dialogue->subscriber_count].handle = handle;
    dialogue->subscriber[dialogue->subscriber_count++].context = context;
}

void dialogue_reset(struct dialogue *dialogue)
{
    dialogue->identity = (struct identity){.hello_known = false};
    mr_deframer_init(&dialogue->deframer);
}

/* Stores the first answer to the current command. Answers to other programs have other tags. */
static void handle_answer(struct dialogue *dialogue, const struct dialogue_message *message)
{
    struct mr_ack answer;
    if (!dialogue->is_awaiting_answer || dialogue->is_answered ||
        mr_ack_get(&answer, message->payload, message->length) != MR_OK ||
        answer.code != dialogue->answer.code || answer.tag != dialogue->answer.tag)
        return;
    dialogue->answer = answer;
    dialogue->is_answered = true;
}

static enum mr_status handle_message(struct dialogue *dialogue,
                                     const struct dialogue_message *message, struct error *error)
{
    enum mr_status status = MR_OK;
    if (message->kind == dialogue->kind) {
        identity_receive(&dialogue->identity, message->id, message->payload, message->length);
        if (message->id == MR_ID_HELLO && !dialogue->accepts_any_layout &&
            dialogue->identity.hello_known)
            status = identity_check_layout(&dialogue->identity, dialogue_spec(dialogue), error);
        if (message->id == MR_ID_ACK)
            handle_answer(dialogue, message);
    }
    for (unsigned i = 0; status == MR_OK && i < dialogue->subscriber_count; i++)
        status = dialogue->subscriber[i].handle(dialogue->subscriber[i].context, message, error);
    return status;
}

/* Receives serial data. MR_TOO_FEW: none is waiting. */
static enum mr_status receive_serial(struct dialogue *dialogue, bool *received, struct error *error)
{
    uint8_t bytes[SERIAL_BYTES_PER_RECEIVE];
    size_t length;
    uint64_t host_us;
    enum mr_status status = link_receive_bytes(dialogue->link[LINK_SERIAL], bytes, sizeof bytes,
                                               &length, &host_us, error);
    *received |= status == MR_OK;
    for (size_t i = 0; status == MR_OK && i < length; i++) {
        struct mr_frame frame;
        if (mr_deframer_push(&dialogue->deframer, bytes[i], &frame) == MR_OK)
            status = handle_message(dialogue,
                                    &(struct dialogue_message){LINK_SERIAL, frame.type, frame.seq,
                                                               frame.payload, frame.length,
                                                               host_us},
                                    error);
    }
    return status;
}

static enum mr_status receive_can(struct dialogue *dialogue, bool *received, struct error *error)
{
    struct link_frame can;
    uint16_t base = link_base(dialogue->link[LINK_CAN]);
    enum mr_status status = MR_OK;
    for (int i = 0; status == MR_OK && i < CAN_FRAMES_PER_RECEIVE; i++) {
        status = link_receive_frame(dialogue->link[LINK_CAN], &can, error);
        *received |= status == MR_OK;
        if (status == MR_OK && !(can.id & (LINK_ID_ERROR | LINK_ID_REMOTE | LINK_ID_EXTENDED)))
            status = handle_message(
                dialogue,
                &(struct dialogue_message){LINK_CAN, mr_can_id_from_bus((uint16_t)can.id, base), 0,
                                           can.data, can.length, can.host_us},
                error);
    }
    return status;
}

void dialogue_set_base(struct dialogue *dialogue, uint16_t base)
{
    struct link *can = dialogue->link[LINK_CAN];
    if (can && base != link_base(can))
        link_set_base(can, base);
}

/* Receives all waiting data of both links. Sets `*received` if there was any. */
static enum mr_status receive_waiting(struct dialogue *dialogue, struct pollfd ready[LINK_KINDS],
                                      bool *received, struct error *error)
{
    *received = false;
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        struct link *link = dialogue->link[kind];
        struct error away = {0};
        ready[kind] = (struct pollfd){.fd = -1, .events = POLLIN};
        if (!link)
            continue;
        enum mr_status status = kind == LINK_CAN ? receive_can(dialogue, received, error)
                                                 : receive_serial(dialogue, received, error);
        if (status == MR_CLOSED)
            return error_set(error, MR_CLOSED,
                             "the board closed the link: %s; check that the board is running",
                             link_get_spec(link));
        if (status != MR_OK && status != MR_TOO_FEW)
            return status;
        status = link_service(link, &away);
        if (status != MR_OK && status != MR_TOO_FEW)
            return error_set(error, status, "%s", away.text);
        ready[kind].fd = link_fd(link);
    }
    return MR_OK;
}

static enum mr_status receive_within(struct dialogue *dialogue, double timeout_s, bool *received,
                                     struct error *error)
{
    struct pollfd ready[LINK_KINDS];
    int wait_ms = (int)ceil(1000.0 * fmin(fmax(timeout_s, 0.0), DIALOGUE_RECEIVE_MAX_S));
    enum mr_status status = receive_waiting(dialogue, ready, received, error);
    if (status == MR_OK && !*received && wait_ms > 0 && poll(ready, LINK_KINDS, wait_ms) < 0 &&
        errno != EINTR)
        return error_set(error, MR_IO, "cannot wait for the board (%s): %s; try again",
                         strerror(errno), dialogue_spec(dialogue));
    return status;
}

/* ---- waiting ---- */

enum mr_status dialogue_receive(struct dialogue *dialogue, double timeout_s, struct error *error)
{
    bool received;
    return receive_within(dialogue, timeout_s, &received, error);
}

enum mr_status dialogue_wait_while_receiving(struct dialogue *dialogue, dialogue_condition *done,
                                             const void *context, const size_t *progress,
                                             double within_s, struct error *error)
{
    double until_s = dialogue->now_s() + within_s;
    size_t before = progress ? *progress : 0;
    for (int late = 0; !done(context);) {
        bool received;
        double left_s = until_s - dialogue->now_s();
        enum mr_status status = receive_within(dialogue, left_s, &received, error);
        if (status != MR_OK)
            return status;
        if (progress && *progress != before) {
            before = *progress;
            until_s = dialogue->now_s() + within_s;
            late = 0;
        } else if (left_s <= 0.0 && (!received || ++late == RECEIVES_AFTER_DEADLINE_MAX)) {
            return done(context) ? MR_OK : MR_TIMEOUT;
        }
    }
    return MR_OK;
}

enum mr_status dialogue_wait_until(struct dialogue *dialogue, dialogue_condition *done,
                                   const void *context, double within_s, struct error *error)
{
    return dialogue_wait_while_receiving(dialogue, done, context, NULL, within_s, error);
}

bool dialogue_is_flag_set(const void *flag)
{
    return *(const bool *)flag;
}

struct hello_wait {
    const struct dialogue *dialogue;
    dialogue_condition *done;
    const void *context;
};

static bool is_hello_wait_over(const void *context)
{
    const struct hello_wait *hello_wait = context;
    return hello_wait->dialogue->identity.hello_known &&
           (!hello_wait->done || hello_wait->done(hello_wait->context));
}

enum mr_status dialogue_wait_for_hello(struct dialogue *dialogue, dialogue_condition *done,
                                       const void *context, struct error *error)
{
    const struct hello_wait hello_wait = {dialogue, done, context};
    enum mr_status status = dialogue_wait_until(dialogue, is_hello_wait_over, &hello_wait,
                                                DIALOGUE_HELLO_TIMEOUT_S, error);
    return status == MR_TIMEOUT ? dialogue_set_no_hello_error(dialogue, error) : status;
}

enum mr_status dialogue_wait_for_identity(struct dialogue *dialogue, double within_s,
                                          struct error *error)
{
    const struct identity *identity = &dialogue->identity;
    enum mr_status status = dialogue_wait_until(dialogue, dialogue_is_flag_set,
                                                &identity->commit_known, within_s, error);
    return status == MR_TIMEOUT && identity->image_known ? MR_OK : status;
}

/* ---- commands ---- */

bool dialogue_is_repeatable_command(unsigned code)
{
    switch (code) {
    case MR_COMMAND_STATE:
    case MR_COMMAND_SURVEY:
    case MR_COMMAND_CONFIG_READ:
    case MR_COMMAND_LIVE:
    case MR_COMMAND_BOX_LIST:
    case MR_COMMAND_BOX_READ:
    case MR_COMMAND_RUNWAY_FORGET:
    case MR_COMMAND_RUNWAY_READ:
    case MR_COMMAND_RUNWAY_JOINTS:
    case MR_COMMAND_RUNWAY_WORD: return true;
    default:
        /* not repeatable: a second copy would be refused, end something twice, or make a second
         * mark or picture */
        return false;
    }
}

uint16_t dialogue_tag(const struct dialogue *dialogue)
{
    return dialogue->tag;
}

uint16_t dialogue_next_tag(struct dialogue *dialogue)
{
    return ++dialogue->tag;
}

enum mr_status dialogue_send(struct dialogue *dialogue, uint16_t id, const uint8_t *payload,
                             size_t length, struct error *error)
{
    struct link *link = dialogue_link(dialogue);
    return link_send_message(link, link_base(link), dialogue->seq++, id, payload, length, error);
}

/* Sends the proof (authentication code) that must precede a command if the board requires it.
 * `within_s`: time limit for receiving the state of the board's key. */
static enum mr_status send_proof(struct dialogue *dialogue, const uint8_t *command, double within_s,
                                 bool *proven, struct error *error)
{
    struct identity *identity = &dialogue->identity;
    char uid[IDENTITY_UID_SIZE];
    uint8_t proof[MR_PROOF_BYTES];
    *proven = false;
    if (mr_command_privilege(command[0]) != MR_PRIVILEGE_OPERATOR)
        return MR_OK;
    enum mr_status status = dialogue_wait_until(dialogue, dialogue_is_flag_set,
                                                &identity->key_known, within_s, error);
    if (status != MR_OK || identity->key.state != MR_KEY_SET || !identity->image_known)
        /* on a timeout, continue: the board's answer to the command shows what is missing */
        return status == MR_TIMEOUT ? MR_OK : status;
    status = dialogue_wait_until(dialogue, dialogue_is_flag_set, &identity->nonce_known,
                                 KEY_STATE_TIMEOUT_S, error);
    identity_uid_text(identity, uid);
    if (status == MR_OK)
        status = keyfile_compute_proof(uid, identity->uid, identity->nonce, command, proof, error);
    if (status != MR_OK)
        return status;
    *proven = true;
    return dialogue_send(dialogue, MR_ID_PROOF, proof, sizeof proof, error);
}

/* Sends the command with its proof and waits for the answer in `dialogue`. */
static enum mr_status send_with_proof(struct dialogue *dialogue, const uint8_t *payload,
                                      size_t length, double answer_timeout_s, struct error *error)
{
    uint8_t nonce[MR_PROOF_BYTES];
    bool proven = false, again = true;
    enum mr_status status = MR_OK;
    for (unsigned i = 0; i < PROOF_TRIES_MAX && status == MR_OK && again; i++) {
        double within_s = i                              ? KEY_STATE_TIMEOUT_S
                        : dialogue->identity.hello_known ? KEY_STATE_AFTER_HELLO_S
                                                         : 0.0;
        dialogue->is_answered = false;
        status = send_proof(dialogue, payload, within_s, &proven, error);
        memcpy(nonce, dialogue->identity.nonce, sizeof nonce);
        if (status == MR_OK)
            status = dialogue_send(dialogue, MR_ID_COMMAND, payload, length, error)
                       ?: dialogue_wait_until(dialogue, dialogue_is_flag_set,
                                              &dialogue->is_answered, answer_timeout_s, error);
        again = dialogue->answer.status == MR_PROOF &&
                (!proven || memcmp(nonce, dialogue->identity.nonce, sizeof nonce) != 0);
    }
    if (status == MR_OK && proven && dialogue->answer.status == MR_PROOF) {
        char uid[IDENTITY_UID_SIZE], path[KEYFILE_PATH_SIZE];
        identity_uid_text(&dialogue->identity, uid);
        keyfile_path(uid, path);
        status = error_set(error, MR_PROOF,
                           "the board refused `%s`: %s; replace this file, which does not contain "
                           "the key of the board: %s",
                           mr_command_name(payload[0]), dialogue_spec(dialogue), path);
    } else if (status == MR_OK && dialogue->answer.status == MR_PROOF &&
               dialogue->identity.key.state == MR_KEY_DAMAGED) {
        status = error_set(error, MR_PROOF,
                           "the board refused `%s`, because its key is damaged: %s; set a new key "
                           "with matrig board key new, or remove the key with key clear",
                           mr_command_name(payload[0]), dialogue_spec(dialogue));
    }
    return status;
}

enum mr_status dialogue_send_command(struct dialogue *dialogue,
                                     const struct dialogue_command *request, struct mr_ack *answer,
                                     struct error *error)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    const struct mr_command command = {.code = request->code,
                                       .index = request->index,
                                       .argument = request->argument,
                                       .tag = dialogue_next_tag(dialogue)};
    size_t length = mr_command_put(&command, payload);
    unsigned tries = dialogue_is_repeatable_command(request->code) && request->tries_max > 1
                       ? request->tries_max
                       : 1;
    enum mr_status status = MR_TIMEOUT;
    dialogue->answer = (struct mr_ack){.code = command.code, .tag = command.tag};
    dialogue->is_awaiting_answer = true;
    for (unsigned i = 0; i < tries && status == MR_TIMEOUT; i++)
        status = send_with_proof(dialogue, payload, length, request->answer_timeout_s, error);
    dialogue->is_awaiting_answer = false;
    if (status == MR_TIMEOUT && error->status == MR_OK && request->was_executed &&
        request->was_executed(request->context))
        /* The command was executed and only the answer was lost: return the expected answer, with
         * status 0. */
        status = MR_OK;
    *answer = dialogue->answer;
    return status;
}

enum mr_status dialogue_set_no_hello_error(const struct dialogue *dialogue, struct error *error)
{
    return link_set_no_board_error(dialogue_link(dialogue), error);
}

enum mr_status dialogue_set_no_answer_error(const struct dialogue *dialogue, unsigned code,
                                            struct error *error)
{
    return error_set(
        error, MR_TIMEOUT,
        "the board did not answer `%s`: %s; check that the board is running and connected",
        mr_command_name(code), dialogue_spec(dialogue));
}

enum mr_status dialogue_set_refusal_error(const struct dialogue *dialogue,
                                          const struct mr_ack *answer, const char *not_now,
                                          struct error *error)
{
    enum mr_status why = (enum mr_status)answer->status;
    bool now = why == MR_NOT_NOW && not_now;
    return error_set(error, why, "the board refused `%s`%s: %s; %s", mr_command_name(answer->code),
                     now ? " now" : "", dialogue_spec(dialogue),
                     now ? not_now : mr_status_text(why));
}

enum mr_status dialogue_execute(struct dialogue *dialogue, const struct dialogue_command *request,
                                const char *not_now, struct error *error)
{
    struct mr_ack answer;
    enum mr_status status = dialogue_send_command(dialogue, request, &answer, error);
    if (status == MR_TIMEOUT)
        return dialogue_set_no_answer_error(dialogue, request->code, error);
    return status != MR_OK || answer.status == MR_OK
             ? status
             : dialogue_set_refusal_error(dialogue, &answer, not_now, error);
}
