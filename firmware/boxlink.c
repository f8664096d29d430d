#include "firmware/boxlink.h"

#include <string.h>

#include "common/command.h"
#include "common/version.h"
#include "common/wire.h"
#include "firmware/schedule.h"
#include "firmware/configround.h"

#define PAGE_BITS 15u /* bits of the argument of the command box-read that hold the page */

enum mr_status boxlink_execute(struct boxlink *link, struct blackbox *box,
                               struct telemetry *telemetry, const struct mr_command *command)
{
    uint32_t argument = (uint32_t)command->argument;
    enum mr_status status = blackbox_check_access(box);
    if (command->argument < 0)
        return MR_USAGE;
    switch (command->code) {
    case MR_COMMAND_BOX_LIST:
        boxlink_report_state(box, telemetry);
        if (status != MR_WAIT)
            *link = (struct boxlink){.is_listing = true};
        return status == MR_WAIT ? MR_WAIT : MR_OK;
    case MR_COMMAND_BOX_READ:
        return blackbox_read(box, (uint16_t)(argument >> PAGE_BITS),
                             argument & ((1u << PAGE_BITS) - 1u));
    case MR_COMMAND_BOX_FREE:
        return argument > UINT16_MAX ? MR_USAGE : blackbox_free(box, (uint16_t)argument);
    default: return MR_UNKNOWN;
    }
}

void boxlink_arm(struct blackbox *box, struct telemetry *telemetry, const struct landing *landing,
                 const float *slack_in)
{
    const struct board_identity *identity = &telemetry->identity;
    struct mr_boxpage_start_page start = {
        .layout = MR_LAYOUT,
        .landing = landing->number,
        .armed_block = landing->changed_block,
        .image_crc = identity->image_crc,
        .config_crc = telemetry->config_crc,
        .firmware = {FIRMWARE_MAJOR, FIRMWARE_MINOR, FIRMWARE_PATCH},
        .clock_source = identity->clock_source,
    };
    if (box->is_disabled)
        return;
    memcpy(start.uid, identity->uid, sizeof start.uid);
    blackbox_arm(box, &start);
    configround_store(telemetry, landing, slack_in);
}

void boxlink_report_state(const struct blackbox *box, struct telemetry *telemetry)
{
    unsigned records = 0;
    for (unsigned i = 0; i < BLACKBOX_RECORDS_MAX; i++)
        records += blackbox_record_at(box, i) != NULL;
    TELEMETRY_SEND(telemetry, TO_LINKS, box_state, BOX_STATE, .state = (uint8_t)box->state,
                   .records = (uint8_t)records, .ready = (uint16_t)box->ready_sectors,
                   .wait_s = blackbox_wait_s(box), .reserve = BLACKBOX_RESERVE_SECTORS);
    TELEMETRY_SEND(telemetry, TO_LINKS, box_space, BOX_SPACE, .sectors = NOR_SECTORS,
                   .dirty = (uint16_t)box->dirty_sectors, .bad = (uint16_t)box->bad_sectors,
                   .wear = (float)box->next_seq / (float)(NOR_SECTORS * NOR_PAGES_PER_SECTOR));
}

static uint16_t clamp_u16(uint32_t value)
{
    return value > UINT16_MAX ? UINT16_MAX : (uint16_t)value;
}

/* Sends one record of the list per block. */
static void send_list(struct boxlink *link, const struct blackbox *box, struct telemetry *telemetry)
{
    const struct blackbox_record *record = NULL;
    while (link->next_record < BLACKBOX_RECORDS_MAX && !record)
        record = blackbox_record_at(box, link->next_record++);
    struct mr_box_record message = {0};
    struct mr_box_span span = {0};
    if (record) {
        message = (struct mr_box_record){.record = record->record,
                                         .landing = record->landing,
                                         .pages = clamp_u16(record->next_seq - record->first_seq),
                                         .complete = record->is_complete};
        span = (struct mr_box_span){.first_block = record->first_block,
                                    .blocks = clamp_u16(record->stored_blocks),
                                    .lost = clamp_u16(record->lost_blocks)};
    }
    TELEMETRY_SEND_MESSAGE(telemetry, TO_LINKS, box_record, BOX_RECORD, &message);
    if (message.record) /* 0 marks the end of the list */
        TELEMETRY_SEND_MESSAGE(telemetry, TO_LINKS, box_span, BOX_SPAN, &span);
    link->is_listing = record != NULL;
}

/* Sends half a page per block: 146 kB/s of the 200 kB/s that serial carries. */
static void send_page(struct blackbox *box, struct telemetry *telemetry)
{
    uint8_t payload[MR_BOX_PART_BYTES];
    uint16_t record, page;
    uint8_t part = 0;
    const uint8_t *bytes = NULL;
    enum blackbox_part what = blackbox_get_part(box, &record, &page, &part, &bytes);
    if (what == BLACKBOX_PART_END) {
        TELEMETRY_SEND(telemetry, TO_LINKS, box_end, BOX_END, .record = record, .pages = page);
    } else if (what == BLACKBOX_PART_READY) {
        uint8_t *p = mr_put_u8(mr_put_u8(mr_put_u16(mr_put_u16(payload, record), page), part), 0);
        memcpy(p, bytes, BLACKBOX_PART_BYTES);
        telemetry_send(telemetry, TO_SERIAL, MR_ID_BOX_PART, payload, sizeof payload);
    }
}

void boxlink_on_block(struct boxlink *link, struct blackbox *box, struct telemetry *telemetry,
                      const struct landing *landing, const struct mr_block *block, bool was_armed)
{
    blackbox_on_block(box, block);
    if (was_armed && landing->state == MR_LANDING_LANDING)
        blackbox_trigger(box, block->index);
    if (!landing_is_recording(landing) && box->is_armed)
        blackbox_finish(box);
    if (!box->is_disabled && DUE(BOX, block->index))
        boxlink_report_state(box, telemetry);
    if (link->is_listing)
        send_list(link, box, telemetry);
    send_page(box, telemetry);
}
