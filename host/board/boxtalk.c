#include "host/board/boxtalk.h"
#include "host/link/diagnose.h"

#include <string.h>

#include "common/command.h"
#include "common/wire.h"
#include "host/board/listen.h"

#define ANSWER_S 10.0  /* without any, the board is taken not to listen */
#define ROUNDS 6       /* of asking for what has not come */
#define PAGE_BITS 15u

static void take_part(struct boxtalk *talk, const uint8_t *payload)
{
    const uint8_t *p = payload;
    uint16_t record = mr_get_u16(&p);
    uint16_t page = mr_get_u16(&p);
    uint8_t part = mr_get_u8(&p);
    struct mr_boxpage_header header;
    uint8_t whole[MR_BOXPAGE];
    if (!talk->pages || record != talk->reading || page >= talk->page_count)
        return;
    talk->parts++;
    if (part == 0) {
        memcpy(talk->half, p + 1, sizeof talk->half);
        talk->half_page = page;
    } else if (part == 1 && talk->half_page == page) {
        memcpy(whole, talk->half, sizeof talk->half);
        memcpy(whole + sizeof talk->half, p + 1, sizeof talk->half);
        if (mr_boxpage_check(whole, &header) == MR_OK && header.record == record) {
            memcpy(talk->pages[page], whole, sizeof whole);
            talk->present[page] = 1;
        }
    }
}

/* Messages of the slow log, and whose and when it is. */
static void take_slow(struct boxtalk *talk, uint16_t id, const uint8_t *bytes, size_t length)
{
    struct mr_board_uid uid;
    struct mr_board_image image;
    if (id == MR_ID_BOARD_UID && mr_board_uid_get(&uid, bytes, length) == MR_OK) {
        talk->uid[0] = uid.uid0;
        talk->uid[1] = uid.uid1;
    } else if (id == MR_ID_BOARD_IMAGE && mr_board_image_get(&image, bytes, length) == MR_OK) {
        talk->uid[2] = image.uid2;
        talk->uid_known = true;
    } else if (id == MR_ID_CLOCK && mr_clock_get(&talk->clock, bytes, length) == MR_OK) {
        talk->clock_us = link_now_us();
        talk->clock_known = true;
    } else if (id == MR_ID_SLOW_END && mr_slow_end_get(&talk->slow_end, bytes, length) == MR_OK) {
        talk->slow_ended = true;
    } else if (mr_slowrow_take(&talk->slow, id, bytes, length) == MR_OK) {
        talk->slow_rows++;
        if (talk->slow_row)
            talk->slow_row(talk->slow_context, &talk->slow.row);
    }
}

static enum mr_status take_frame(void *context, const struct mr_frame *frame, struct error *error)
{
    struct boxtalk *talk = context;
    struct mr_box_end end;
    struct mr_box_record record;
    const uint8_t *bytes = frame->payload;
    size_t length = frame->length;
    switch (frame->type) {
    case MR_ID_HELLO:
        if (listen_hello(talk->link, bytes, length, error) != MR_OK)
            return MR_VERSION;
        talk->hello = true;
        break;
    case MR_ID_ACK:
        talk->acknowledged |= listen_ack(bytes, length, talk->tag, &talk->ack);
        break;
    case MR_ID_BOX_STATE:
        talk->state_known |= mr_box_state_get(&talk->state, bytes, length) == MR_OK;
        break;
    case MR_ID_BOX_SPACE:
        talk->space_known |= mr_box_space_get(&talk->space, bytes, length) == MR_OK;
        break;
    case MR_ID_BOX_RECORD:
        if (mr_box_record_get(&record, bytes, length) != MR_OK)
            break;
        if (!record.record)
            talk->listed = true;
        else if (talk->count < BOXTALK_RECORDS)
            talk->records[talk->count++].record = record;
        break;
    case MR_ID_BOX_SPAN:
        if (talk->count)
            (void)mr_box_span_get(&talk->records[talk->count - 1].span, bytes, length);
        break;
    case MR_ID_BOX_PART:
        if (length == MR_BOX_PART_BYTES)
            take_part(talk, bytes);
        break;
    case MR_ID_BOX_END:
        talk->ended |= mr_box_end_get(&end, bytes, length) == MR_OK && end.record == talk->reading;
        break;
    default:
        take_slow(talk, frame->type, bytes, length);
        break;
    }
    return MR_OK;
}

/* What comes within a tenth of a second. */
static enum mr_status listen(struct boxtalk *talk, struct error *error)
{
    return listen_tenth(talk->link, &talk->deframer, take_frame, talk, error);
}

enum mr_status boxtalk_begin(struct boxtalk *talk, struct link *link, struct error *error)
{
    double until_s = listen_now_s() + ANSWER_S;
    enum mr_status status = MR_OK;
    memset(talk, 0, sizeof *talk);
    talk->link = link;
    talk->half_page = UINT32_MAX;
    mr_deframer_init(&talk->deframer);
    while (status == MR_OK && !talk->hello) {
        if (listen_now_s() > until_s)
            return link_no_board(link, error);
        status = listen(talk, error);
    }
    return status;
}

static enum mr_status order_once(struct boxtalk *talk, uint8_t code, int32_t argument, struct error *error)
{
    uint8_t payload[MR_MESSAGE_MAX], frame[MR_FRAME_MAX];
    struct mr_command command = {.code = code, .argument = argument, .tag = ++talk->tag};
    size_t length = mr_command_put(&command, payload);
    double until_s = listen_now_s() + ANSWER_S;
    talk->acknowledged = false;
    enum mr_status status =
        link_send_bytes(talk->link, frame, mr_frame_encode(talk->seq++, MR_ID_COMMAND, payload, length, frame), error);
    while (status == MR_OK && !talk->acknowledged) {
        if (listen_now_s() > until_s)
            return error_set(error, MR_TIMEOUT, "the board does not answer `%s`: %s; is it running and connected?",
                             mr_command_name(code), link_spec(talk->link));
        status = listen(talk, error);
    }
    return status;
}

/* What the board asks to be asked again is asked again. */
static enum mr_status order(struct boxtalk *talk, uint8_t code, int32_t argument, struct error *error)
{
    double until_s = listen_now_s() + ANSWER_S;
    enum mr_status status = order_once(talk, code, argument, error);
    while (status == MR_OK && talk->ack.status == MR_WAIT && listen_now_s() < until_s) {
        status = listen(talk, error);
        if (status == MR_OK)
            status = order_once(talk, code, argument, error);
    }
    if (status != MR_OK || talk->ack.status == MR_OK)
        return status;
    if (talk->ack.status == MR_NOT_NOW)
        return error_set(error, MR_NOT_NOW, "the board refuses `%s` now: %s; a landing is armed or going on, or there is no black box",
                         mr_command_name(code), link_spec(talk->link));
    if (talk->ack.status == MR_UNKNOWN)
        return error_set(error, MR_UNKNOWN, "the black box has no such record: %s; see matrig board list", link_spec(talk->link));
    return error_set(error, (enum mr_status)talk->ack.status, "the board refuses `%s`: %s; %s", mr_command_name(code),
                     link_spec(talk->link), mr_status_text((enum mr_status)talk->ack.status));
}

enum mr_status boxtalk_list(struct boxtalk *talk, struct error *error)
{
    double until_s = listen_now_s() + ANSWER_S;
    talk->count = 0;
    talk->listed = false;
    enum mr_status status = order(talk, MR_COMMAND_BOX_LIST, 0, error);
    while (status == MR_OK && !talk->listed) {
        if (listen_now_s() > until_s)
            return error_set(error, MR_TIMEOUT, "the list of records did not end: %s; try again", link_spec(talk->link));
        status = listen(talk, error);
    }
    return status;
}

static size_t first_absent(const struct boxtalk *talk)
{
    size_t page = 0;
    while (page < talk->page_count && talk->present[page])
        page++;
    return page;
}

enum mr_status boxtalk_read(struct boxtalk *talk, const struct boxtalk_record *record, uint8_t (*pages)[MR_BOXPAGE],
                            uint8_t *present, struct error *error)
{
    enum mr_status status = MR_OK;
    talk->reading = record->record.record;
    talk->pages = pages;
    talk->present = present;
    talk->page_count = record->record.pages;
    for (int round = 0; status == MR_OK && round < ROUNDS && first_absent(talk) < talk->page_count; round++) {
        talk->ended = false;
        status = order(talk, MR_COMMAND_BOX_READ, (int32_t)((uint32_t)talk->reading << PAGE_BITS | first_absent(talk)), error);
        double until_s = listen_now_s() + ANSWER_S;
        for (size_t parts = talk->parts; status == MR_OK && !talk->ended && listen_now_s() < until_s; parts = talk->parts) {
            status = listen(talk, error);
            if (talk->parts != parts)
                until_s = listen_now_s() + ANSWER_S;
        }
    }
    talk->pages = NULL;
    return status;
}

enum mr_status boxtalk_slow(struct boxtalk *talk, uint32_t first, void (*row)(void *context, const struct mr_slowrow *row),
                            void *context, struct error *error)
{
    talk->slow_row = row;
    talk->slow_context = context;
    talk->slow_ended = false;
    enum mr_status status = order(talk, MR_COMMAND_SLOW_READ, (int32_t)first, error);
    double until_s = listen_now_s() + ANSWER_S;
    size_t rows = talk->slow_rows;
    while (status == MR_OK && !(talk->slow_ended && talk->uid_known && talk->clock_known)) {
        if (listen_now_s() > until_s)
            status = error_set(error, MR_TIMEOUT, "the slow log did not end: %s; try again, it goes on from where it was",
                               link_spec(talk->link));
        else
            status = listen(talk, error);
        if (talk->slow_rows != rows)
            until_s = listen_now_s() + ANSWER_S;
        rows = talk->slow_rows;
    }
    talk->slow_row = NULL;
    return status;
}

enum mr_status boxtalk_free(struct boxtalk *talk, uint16_t record, struct error *error)
{
    return order(talk, MR_COMMAND_BOX_FREE, record, error);
}
