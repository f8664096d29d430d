#include "firmware/blackbox_parts.h"

#include "firmware/health.h"

bool blackbox_begin_read_out(struct blackbox *box)
{
    if (box->read_over)
        return false;
    blackbox_begin_job(box, JOB_READ, box->read_sector, box->read_cursor);
    nor_begin_read(blackbox_address(box->read_sector, box->read_cursor), box->read_buffer,
                   NOR_PAGE);
    return true;
}

static void next_read(struct blackbox *box)
{
    unsigned place = (unsigned)box->reading;
    box->read_tries = 0;
    if (++box->read_cursor < PAGES)
        return;
    box->read_cursor = 0;
    if (box->read_sector == box->records[place].last_sector)
        box->read_over = true;
    else
        box->read_sector = blackbox_find_sector(box, box->read_sector + 1, (uint8_t)place,
                                                (uint8_t)place);
}

void blackbox_read_page(struct blackbox *box)
{
    struct mr_boxpage_header header;
    if (box->reading < 0)
        return;
    const struct blackbox_record *record = &box->records[box->reading];
    enum mr_status status = mr_boxpage_check(box->read_buffer, &header);
    if (status == MR_OK && header.record == record->record &&
        header.seq - record->first_seq >= box->read_page) {
        box->read_page = header.seq - record->first_seq;
        box->read_ready = true;
        box->read_part = 0;
    } else if (status == MR_CRC && ++box->read_tries < READ_TRIES) {
        return;
    } else {
        if (status == MR_CRC)
            health_count(MR_FAULT_NOR_FAILED, 3);
        next_read(box);
    }
}

enum mr_status blackbox_read(struct blackbox *box, uint16_t record, uint32_t page)
{
    int place = blackbox_find_record(box, record);
    enum mr_status status = blackbox_at_rest(box);
    if (status != MR_OK)
        return status;
    if (place < 0)
        return MR_UNKNOWN;
    /* Every sector holds at most PAGES of them, so page n is in the record's sector n / PAGES or
     * behind it. */
    box->read_sector = box->records[place].first_sector;
    for (uint32_t n = 0; n < page / PAGES && box->read_sector != box->records[place].last_sector;
         n++)
        box->read_sector = blackbox_find_sector(box, box->read_sector + 1, (uint8_t)place,
                                                (uint8_t)place);
    box->reading = place;
    box->read_page = page;
    box->read_cursor = 0;
    box->read_tries = 0;
    box->read_ready = false;
    box->read_over = false;
    return MR_OK;
}

enum blackbox_part blackbox_take_part(struct blackbox *box, uint16_t *record, uint16_t *page,
                                      uint8_t *part, const uint8_t **bytes)
{
    if (box->reading < 0)
        return BLACKBOX_NO_PART;
    const struct blackbox_record *of = &box->records[box->reading];
    *record = of->record;
    if (box->read_over && !box->read_ready) {
        *page = (uint16_t)(of->next_seq - of->first_seq);
        box->reading = -1;
        return BLACKBOX_LAST_READ;
    }
    if (!box->read_ready)
        return BLACKBOX_NO_PART;
    *page = (uint16_t)box->read_page;
    *part = (uint8_t)box->read_part;
    *bytes = box->read_buffer + BLACKBOX_PART * box->read_part;
    if (++box->read_part == NOR_PAGE / BLACKBOX_PART) {
        box->read_ready = false;
        box->read_page++;
        next_read(box);
    }
    return BLACKBOX_A_PART;
}
