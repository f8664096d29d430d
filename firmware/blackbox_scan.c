#include "firmware/blackbox_parts.h"

#define SCAN_TRIES 32u /* each page of a sector twice */

static void scan_next(struct blackbox *box)
{
    box->tries = 0;
    box->scan_sector++;
}

static unsigned place_of(struct blackbox *box, uint16_t record)
{
    for (unsigned i = 0; i < BLACKBOX_RECORDS; i++) {
        if (box->records[i].used && box->records[i].record == record)
            return i;
    }
    int place = blackbox_free_place(box);
    if (place < 0)
        return BLACKBOX_RECORDS;
    box->records[place] =
        (struct blackbox_record){.used = true, .record = record, .first_seq = UINT32_MAX};
    return (unsigned)place;
}

static void found_page(struct blackbox *box, const struct mr_boxpage_header *header)
{
    unsigned place = place_of(box, header->record);
    if (place == BLACKBOX_RECORDS) {
        blackbox_set_sector(box, box->job_sector, SECTOR_FOREIGN);
        return;
    }
    struct blackbox_record *record = &box->records[place];
    blackbox_set_sector(box, box->job_sector, (uint8_t)place);
    if (header->seq - box->job_page < record->first_seq) {
        record->first_seq = header->seq - box->job_page;
        record->first_sector = (uint16_t)box->job_sector;
    }
    if (header->seq >= record->next_seq) {
        record->next_seq = header->seq + 1;
        record->last_sector = (uint16_t)box->job_sector;
        box->freed[place] = header->freed && box->job_page == 0;
    }
}

void blackbox_scan_page(struct blackbox *box)
{
    struct mr_boxpage_header header;
    if (mr_boxpage_check(box->buffer, &header) == MR_OK) {
        found_page(box, &header);
        scan_next(box);
    } else if (++box->tries < SCAN_TRIES) {
        blackbox_begin_read(box, JOB_SCAN_PAGE, box->job_sector, box->tries / 2);
    } else { /* torn, or never ours */
        blackbox_set_sector(box, box->job_sector, SECTOR_DIRTY);
        scan_next(box);
    }
}

void blackbox_scan_head(struct blackbox *box)
{
    bool blank = true;
    for (unsigned i = 0; i < MR_BOXPAGE_HEADER; i++)
        blank = blank && box->buffer[i] == 0xff;
    if (!blank) {
        blackbox_begin_read(box, JOB_SCAN_PAGE, box->job_sector, 0);
        return;
    }
    blackbox_set_sector(box, box->job_sector, SECTOR_BLANK);
    scan_next(box);
}

/* How far the record came in its last sector. */
void blackbox_scan_walk(struct blackbox *box)
{
    struct blackbox_record *record = &box->records[box->scan_place];
    struct mr_boxpage_header header;
    enum mr_status status = mr_boxpage_check(box->buffer, &header);
    if (status == MR_OK && header.record == record->record) {
        record->next_seq = header.seq + 1;
        if (header.kind == MR_BOXPAGE_END) {
            struct mr_boxpage_end end;
            mr_boxpage_get_end(box->buffer, &end);
            record->complete = true;
            record->first_block = end.first_block;
            record->blocks = end.blocks;
            record->lost = end.lost;
        }
    } else if (status == MR_CRC && ++box->tries < READ_TRIES) {
        blackbox_begin_read(box, JOB_SCAN_WALK, box->job_sector, box->job_page);
        return;
    }
    box->tries = 0;
    if (status == MR_OK && box->job_page + 1 < PAGES)
        blackbox_begin_read(box, JOB_SCAN_WALK, box->job_sector, box->job_page + 1);
    else
        blackbox_begin_read(box, JOB_SCAN_START, record->first_sector, 0);
}

void blackbox_scan_start(struct blackbox *box)
{
    struct mr_boxpage_header header;
    enum mr_status status = mr_boxpage_check(box->buffer, &header);
    if (status == MR_CRC && ++box->tries < READ_TRIES) {
        blackbox_begin_read(box, JOB_SCAN_START, box->job_sector, 0);
        return;
    }
    if (status == MR_OK && header.kind == MR_BOXPAGE_START) {
        struct mr_boxpage_start start;
        mr_boxpage_get_start(box->buffer, &start);
        box->records[box->scan_place].landing = start.landing;
    }
    box->tries = 0;
    box->scan_place++;
}

static void scan_ends(struct blackbox *box)
{
    for (unsigned i = 0; i < BLACKBOX_RECORDS; i++) {
        const struct blackbox_record *record = &box->records[i];
        if (record->used && record->next_seq > box->next_seq) {
            box->next_seq = record->next_seq;
            box->next_record = (uint16_t)(record->record + 1);
            box->newest_sector = record->last_sector;
        }
    }
    for (unsigned i = 0; i < BLACKBOX_RECORDS; i++) {
        if (box->records[i].used && box->freed[i])
            blackbox_drop_record(box, i);
    }
    box->head = (box->newest_sector + 1) % NOR_SECTORS;
    box->look_sector = box->head;
    box->state = BLACKBOX_ROLLING;
}

bool blackbox_begin_scan(struct blackbox *box)
{
    if (box->scan_sector < NOR_SECTORS) {
        blackbox_begin_job(box, JOB_SCAN_HEAD, box->scan_sector, 0);
        nor_begin_read(blackbox_address(box->scan_sector, 0), box->buffer, MR_BOXPAGE_HEADER);
        return true;
    }
    while (box->scan_place < BLACKBOX_RECORDS && !box->records[box->scan_place].used)
        box->scan_place++;
    if (box->scan_place < BLACKBOX_RECORDS) {
        blackbox_begin_read(box, JOB_SCAN_WALK, box->records[box->scan_place].last_sector, 0);
        return true;
    }
    scan_ends(box);
    return false;
}
