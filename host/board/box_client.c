#include "host/board/box_client.h"

#include <string.h>

#include "common/command.h"
#include "common/wire.h"

#define ANSWER_S  DIALOGUE_ANSWER_S
#define ROUNDS    6 /* of asking for what has not come */
#define PAGE_BITS 15u

static void take_part(struct box_client *talk, const uint8_t *payload)
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

static enum mr_status take(void *context, const struct dialogue_message *message,
                           struct error *error)
{
    struct box_client *talk = context;
    struct mr_box_end end;
    struct mr_box_record record;
    const uint8_t *bytes = message->payload;
    size_t length = message->length;
    (void)error;
    switch (message->id) {
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
        else if (talk->count < BOX_CLIENT_RECORDS)
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
    default: break;
    }
    return MR_OK;
}

enum mr_status box_client_begin(struct box_client *talk, struct dialogue *dialogue,
                                struct error *error)
{
    memset(talk, 0, sizeof *talk);
    talk->dialogue = dialogue;
    talk->half_page = UINT32_MAX;
    dialogue_subscribe(dialogue, take, talk);
    return dialogue_hello(dialogue, NULL, NULL, error);
}

/* What the board asks to be asked again is asked again. */
static enum mr_status order(struct box_client *talk, uint8_t code, int32_t argument,
                            struct error *error)
{
    struct dialogue *dialogue = talk->dialogue;
    const struct dialogue_order order = {.code = code, .argument = argument, .answer_s = ANSWER_S};
    struct mr_ack ack;
    double until_s = dialogue_now_s(dialogue) + ANSWER_S;
    enum mr_status status = dialogue_order(dialogue, &order, &ack, error);
    while (status == MR_OK && ack.status == MR_WAIT && dialogue_now_s(dialogue) < until_s) {
        status = dialogue_turn(dialogue, DIALOGUE_TURN_S, error);
        if (status == MR_OK)
            status = dialogue_order(dialogue, &order, &ack, error);
    }
    if (status == MR_TIMEOUT)
        return dialogue_lost(dialogue, code, error);
    if (status != MR_OK || ack.status == MR_OK)
        return status;
    if (ack.status == MR_UNKNOWN)
        return error_set(error, MR_UNKNOWN,
                         "the black box has no such record: %s; see matrig board list",
                         dialogue_spec(dialogue));
    return dialogue_refused(dialogue, &ack,
                            "a landing is armed or going on, or there is no black box", error);
}

enum mr_status box_client_list(struct box_client *talk, struct error *error)
{
    talk->count = 0;
    talk->listed = false;
    enum mr_status status = order(talk, MR_COMMAND_BOX_LIST, 0, error);
    if (status == MR_OK)
        status = dialogue_until(talk->dialogue, dialogue_flag, &talk->listed, ANSWER_S, error);
    return status == MR_TIMEOUT
             ? error_set(error, MR_TIMEOUT, "the list of records did not end: %s; try again",
                         dialogue_spec(talk->dialogue))
             : status;
}

static size_t first_absent(const struct box_client *talk)
{
    size_t page = 0;
    while (page < talk->page_count && talk->present[page])
        page++;
    return page;
}

enum mr_status box_client_read(struct box_client *talk, const struct box_client_record *record,
                               uint8_t (*pages)[MR_BOXPAGE], uint8_t *present, struct error *error)
{
    enum mr_status status = MR_OK;
    talk->reading = record->record.record;
    talk->pages = pages;
    talk->present = present;
    talk->page_count = record->record.pages;
    for (int round = 0; status == MR_OK && round < ROUNDS && first_absent(talk) < talk->page_count;
         round++) {
        talk->ended = false;
        status = order(talk, MR_COMMAND_BOX_READ,
                       (int32_t)((uint32_t)talk->reading << PAGE_BITS | first_absent(talk)), error);
        if (status == MR_OK)
            status = dialogue_while_coming(talk->dialogue, dialogue_flag, &talk->ended,
                                           &talk->parts, ANSWER_S, error);
        /* what has not come is asked for again */
        if (status == MR_TIMEOUT && error->status == MR_OK)
            status = MR_OK;
    }
    talk->pages = NULL;
    return status;
}

enum mr_status box_client_free(struct box_client *talk, uint16_t record, struct error *error)
{
    return order(talk, MR_COMMAND_BOX_FREE, record, error);
}
