#include "host/board/identity.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "common/command.h"
#include "common/wire.h"

#define POLL_MS 50

static uint64_t now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000u + (uint64_t)now.tv_nsec / 1000000u;
}

void identity_begin(struct identity_talk *talk, struct link *link)
{
    *talk = (struct identity_talk){.link = link};
    mr_deframer_init(&talk->deframer);
}

static void take(struct identity_talk *talk, const struct mr_frame *frame)
{
    struct identity *identity = &talk->identity;
    struct mr_board_uid uid;
    struct mr_board_image image;
    switch (frame->type) {
    case MR_ID_HELLO:
        talk->hello |= mr_hello_get(&identity->hello, frame->payload, frame->length) == MR_OK;
        break;
    case MR_ID_BOARD_UID:
        if (mr_board_uid_get(&uid, frame->payload, frame->length) == MR_OK) {
            identity->uid[0] = uid.uid0;
            identity->uid[1] = uid.uid1;
        }
        break;
    case MR_ID_BOARD_IMAGE:
        if (talk->hello && mr_board_image_get(&image, frame->payload, frame->length) == MR_OK) {
            identity->uid[2] = image.uid2;
            identity->image_crc = image.image_crc;
            talk->image = true;
        }
        break;
    case MR_ID_IMAGE_COMMIT:
        (void)mr_image_commit_get(&identity->commit, frame->payload, frame->length);
        break;
    case MR_ID_IMAGE_HEADER: /* the last of them */
        identity->commit_known = talk->image && mr_image_header_get(&identity->header, frame->payload, frame->length) == MR_OK;
        break;
    case MR_ID_ACK:
        talk->acknowledged |= mr_ack_get(&talk->ack, frame->payload, frame->length) == MR_OK && talk->ack.tag == talk->seq;
        break;
    default:
        break;
    }
}

/* What comes within POLL_MS. MR_OK also when nothing does. */
static enum mr_status listen_once(struct identity_talk *talk, struct error *error)
{
    uint8_t bytes[4096];
    size_t length = 0;
    uint64_t host_us;
    enum mr_status status = link_receive_bytes(talk->link, bytes, sizeof bytes, &length, &host_us, error);
    if (status == MR_TOO_FEW && link_fd(talk->link) < 0)
        return error_set(error, MR_IO, "the device went away: %s; plug it in again", link_spec(talk->link));
    if (status == MR_TOO_FEW) {
        struct pollfd ready = {.fd = link_fd(talk->link), .events = POLLIN};
        (void)poll(&ready, 1, POLL_MS); /* interrupted or not: the caller has the time in view */
        return MR_OK;
    }
    if (status == MR_CLOSED)
        return error_set(error, MR_CLOSED, "the board closed the link: %s; is it still running?", link_spec(talk->link));
    for (size_t i = 0; status == MR_OK && i < length; i++) {
        struct mr_frame frame;
        if (mr_deframer_push(&talk->deframer, bytes[i], &frame) == MR_OK)
            take(talk, &frame);
    }
    return status;
}

enum mr_status identity_listen(struct identity_talk *talk, unsigned timeout_ms, struct error *error)
{
    uint64_t until_ms = now_ms() + timeout_ms;
    enum mr_status status = MR_OK;
    while (status == MR_OK && !talk->identity.commit_known && now_ms() < until_ms)
        status = listen_once(talk, error);
    if (status != MR_OK)
        return status;
    return talk->hello && talk->image ? MR_OK : MR_TIMEOUT;
}

enum mr_status identity_order(struct identity_talk *talk, uint8_t code, unsigned timeout_ms, enum mr_status *answer, struct error *error)
{
    uint8_t payload[MR_MESSAGE_MAX], frame[MR_FRAME_MAX];
    struct mr_command command = {.code = code, .tag = ++talk->seq};
    size_t length = mr_command_put(&command, payload);
    uint64_t until_ms = now_ms() + timeout_ms;
    talk->acknowledged = false;
    enum mr_status status =
        link_send_bytes(talk->link, frame, mr_frame_encode(talk->seq, MR_ID_COMMAND, payload, length, frame), error);
    while (status == MR_OK && !talk->acknowledged) {
        if (now_ms() > until_ms)
            return error_set(error, MR_TIMEOUT, "the board does not answer `%s`: %s; is it running and connected?", mr_command_name(code),
                             link_spec(talk->link));
        status = listen_once(talk, error);
    }
    *answer = (enum mr_status)talk->ack.status;
    return status;
}

bool identity_runs(const struct identity *identity, const struct mr_image *image, char *why, size_t size)
{
    char runs[MR_IMAGE_COMMIT_TEXT], file[MR_IMAGE_COMMIT_TEXT];
    if (!identity->commit_known || identity->commit.state != MR_IMAGE_GOOD) {
        snprintf(why, size, "the board's image: %s", identity->commit_known ? mr_image_state_text(identity->commit.state) : "no header");
        return false;
    }
    mr_image_commit_text(identity->commit.commit, identity->commit.commit_more, identity->commit.changed != 0, runs);
    mr_image_commit_text(image->commit, image->commit_more, image->changed, file);
    if (identity->image_crc != image->program_crc)
        snprintf(why, size, "program %08x, not %08x (commit %s, not %s)", (unsigned)identity->image_crc, (unsigned)image->program_crc, runs, file);
    else if (identity->header.header_crc != image->header_crc)
        snprintf(why, size, "the same program, another header or other vectors (commit %s, not %s)", runs, file);
    else
        return true;
    return false;
}
