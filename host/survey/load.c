#include "host/survey/load.h"
#include "host/link/diagnose.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <string.h>
#include <time.h>

#include "common/command.h"
#include "common/framing.h"
#include "host/board/listen.h"

#define HELLO_S 10.0
#define ANSWER_S 2.0 /* then it is sent again */
#define TRIES 3
#define DIGITS_IN 1e-4 /* of the command and of the message */

struct talk {
    struct link *link;
    enum link_kind kind;
    struct mr_deframer deframer;
    uint16_t seq, tag;
    bool hello, acknowledged;
    struct mr_ack ack;
    bool told[SURVEY_SPANS];
    unsigned tolds;
    double slack_in[SURVEY_SPANS];
};

static double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static enum mr_status take(struct talk *talk, uint32_t id, const uint8_t *bytes, size_t length, struct error *error)
{
    struct mr_ack ack;
    struct mr_slack slack;
    if (id == MR_ID_HELLO) {
        if (listen_hello(talk->link, bytes, length, error) != MR_OK)
            return MR_VERSION;
        talk->hello = true;
    } else if (id == MR_ID_ACK && mr_ack_get(&ack, bytes, length) == MR_OK && ack.tag == talk->tag) {
        talk->ack = ack;
        talk->acknowledged = true;
    } else if (id == MR_ID_SLACK && mr_slack_get(&slack, bytes, length) == MR_OK && slack.segment < SURVEY_SPANS) {
        talk->tolds += !talk->told[slack.segment];
        talk->told[slack.segment] = true;
        talk->slack_in[slack.segment] = (double)slack.slack_in;
    }
    return MR_OK;
}

static enum mr_status take_frame(void *context, const struct mr_frame *frame, struct error *error)
{
    return take(context, frame->type, frame->payload, frame->length, error);
}

/* What comes within a tenth of a second. */
static enum mr_status listen(struct talk *talk, struct error *error)
{
    struct link_frame can;
    if (talk->kind == LINK_SERIAL)
        return listen_tenth(talk->link, &talk->deframer, take_frame, talk, error);
    enum mr_status status = link_receive_frame(talk->link, &can, error);
    if (status == MR_OK)
        return take(talk, can.id, can.data, can.length, error);
    if (status == MR_CLOSED)
        return error_set(error, MR_CLOSED, "the board closed the link: %s; is it still running?", link_spec(talk->link));
    if (status != MR_TOO_FEW)
        return status;
    struct pollfd ready = {.fd = link_fd(talk->link), .events = POLLIN};
    if (poll(&ready, 1, 100) < 0 && errno != EINTR)
        return error_set(error, MR_IO, "cannot wait (%s): %s; try again", strerror(errno), link_spec(talk->link));
    return MR_OK;
}

static enum mr_status send(struct talk *talk, const struct mr_command *command, struct error *error)
{
    struct link_frame can = {.id = MR_ID_COMMAND};
    uint8_t bytes[MR_FRAME_MAX];
    can.length = (uint8_t)mr_command_put(command, can.data);
    return talk->kind == LINK_CAN
               ? link_send_frame(talk->link, &can, error)
               : link_send_bytes(talk->link, bytes, mr_frame_encode(talk->seq++, MR_ID_COMMAND, can.data, can.length, bytes), error);
}

static enum mr_status order(struct talk *talk, struct mr_command command, struct error *error)
{
    enum mr_status status = MR_OK;
    command.tag = ++talk->tag;
    talk->acknowledged = false;
    for (int tries = 0; tries < TRIES && !talk->acknowledged && status == MR_OK; tries++) {
        double until_s = now_s() + ANSWER_S;
        status = send(talk, &command, error);
        while (status == MR_OK && !talk->acknowledged && now_s() < until_s)
            status = listen(talk, error);
    }
    if (status != MR_OK)
        return status;
    if (!talk->acknowledged)
        return error_set(error, MR_TIMEOUT, "the board does not answer `%s`: %s; is it running and connected?",
                         mr_command_name(command.code), link_spec(talk->link));
    if (talk->ack.status == MR_NOT_NOW)
        return error_set(error, MR_NOT_NOW, "the board takes no survey now, a landing is armed or going on: %s; disarm it, or wait",
                         link_spec(talk->link));
    return talk->ack.status == MR_OK
               ? MR_OK
               : error_set(error, (enum mr_status)talk->ack.status, "the board refuses segment %u of the survey (%s): %s; look at its readings",
                           command.index, mr_status_text((enum mr_status)talk->ack.status), link_spec(talk->link));
}

static enum mr_status read_back(struct talk *talk, struct error *error)
{
    enum mr_status status = MR_OK;
    memset(talk->told, 0, sizeof talk->told);
    talk->tolds = 0;
    for (int tries = 0; tries < TRIES && talk->tolds < SURVEY_SPANS && status == MR_OK; tries++) {
        status = order(talk, (struct mr_command){.code = MR_COMMAND_STATE}, error);
        double until_s = now_s() + ANSWER_S;
        while (status == MR_OK && talk->tolds < SURVEY_SPANS && now_s() < until_s)
            status = listen(talk, error);
    }
    if (status == MR_OK && talk->tolds < SURVEY_SPANS)
        status = error_set(error, MR_TIMEOUT, "the board told %u of %u segments of what it holds now: %s; load it again", talk->tolds,
                           SURVEY_SPANS, link_spec(talk->link));
    return status;
}

static void compare(const struct talk *talk, const struct survey_slack *slack, struct survey_loaded *loaded)
{
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        double wanted_in = slack->segment[k].value_in;
        loaded->board_in[k] = talk->slack_in[k];
        if (isnan(wanted_in))
            loaded->older += isnan(talk->slack_in[k]) ? 0u : 1u;
        else
            loaded->different += fabs(talk->slack_in[k] - wanted_in) <= 0.51 * DIGITS_IN ? 0u : 1u;
    }
}

enum mr_status survey_load(struct link *link, enum link_kind kind, const struct survey_slack *slack, struct survey_loaded *loaded,
                           struct error *error)
{
    struct talk talk = {.link = link, .kind = kind, .tag = (uint16_t)(link_now_us() / 1000u)};
    double until_s = now_s() + HELLO_S;
    enum mr_status status = MR_OK;
    memset(loaded, 0, sizeof *loaded);
    mr_deframer_init(&talk.deframer);
    while (status == MR_OK && !talk.hello) {
        if (now_s() > until_s)
            return link_no_board(link, error);
        status = listen(&talk, error);
    }
    for (unsigned k = 0; k < SURVEY_SPANS && status == MR_OK; k++) {
        double slack_in = slack->segment[k].value_in;
        if (isnan(slack_in))
            continue;
        status = order(&talk, (struct mr_command){.code = MR_COMMAND_SURVEY, .index = (uint8_t)k, .argument = (int32_t)lround(slack_in / DIGITS_IN)},
                       error);
        loaded->sent += status == MR_OK;
    }
    if (status == MR_OK)
        status = read_back(&talk, error);
    if (status == MR_OK)
        compare(&talk, slack, loaded);
    return status;
}
