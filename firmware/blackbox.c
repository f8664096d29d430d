#include "firmware/blackbox.h"

#include <string.h>

#include "common/wire.h"
#include "firmware/health.h"

/* maximum steps of a memory job per call of blackbox_poll; a read takes two calls or more */
#define JOB_STEPS_PER_POLL       128u
#define VERIFY_TRIES_MAX         2u
#define ERASE_TRIES_MAX          2u
#define FAILURES_MAX             64u
#define ERASE_ASSUMED_MS         60u /* assumed duration of an erase until one has been measured */
#define READ_TRIES_MAX           4u
#define SCAN_TRIES_MAX           32u /* each page of a sector is read twice */
/* reserve of free pages in the ring: twice the data (58 bytes per ms) that arrives while 8 pages of
 * configuration are written, 4 ms each */
#define RING_RESERVE_PAGES       16u
/* reserve during an erase: RING_RESERVE_PAGES plus the data of 400 ms */
#define RING_RESERVE_ERASE_PAGES 112u
#define SECTOR_PAGES             NOR_PAGES_PER_SECTOR

/* States of a sector that belongs to no record. */
enum {
    SECTOR_BAD = 0xf9, /* programming or erasing failed */
    SECTOR_UNREAD = 0xfa,
    /* as dirty, but carries a mark that its record was freed; erased after all other dirty
     * sectors */
    SECTOR_DIRTY_MARKED = 0xfb,
    SECTOR_DIRTY = 0xfc,
    /* belongs to a record for which `records` has no room; must not be changed */
    SECTOR_UNLISTED_RECORD = 0xfd,
    /* Erased, or assumed to be erased because its first page was blank at start. If another page
     * is not blank, writing to that page fails. */
    SECTOR_ERASED = 0xff,
};
_Static_assert(BLACKBOX_RECORDS_MAX <= SECTOR_BAD,
               "an index of a record must differ from every sector state");

enum job {
    JOB_NONE,
    JOB_SCAN_FIRST_PAGE,
    JOB_SCAN_PAGE,
    JOB_SCAN_FIND_END,
    JOB_SCAN_START,
    JOB_PROGRAM,
    JOB_VERIFY,
    JOB_ERASE,
    JOB_CHECK_ERASED,
    JOB_FREE_READ,
    JOB_FREE_PROGRAM,
    JOB_FREE_VERIFY,
    JOB_READ,
};

static uint32_t get_address(unsigned sector, unsigned page)
{
    return sector * NOR_SECTOR_BYTES + page * NOR_PAGE_BYTES;
}

static bool is_sector_dirty(uint8_t state)
{
    return state == SECTOR_DIRTY || state == SECTOR_DIRTY_MARKED;
}

static void set_sector(struct blackbox *box, unsigned sector, uint8_t state)
{
    uint8_t before = box->sector_state[sector];
    box->ready_sectors = box->ready_sectors - (before == SECTOR_ERASED) + (state == SECTOR_ERASED);
    box->dirty_sectors = box->dirty_sectors - is_sector_dirty(before) + is_sector_dirty(state);
    box->bad_sectors = box->bad_sectors - (before == SECTOR_BAD) + (state == SECTOR_BAD);
    box->sector_state[sector] = state;
}

/* Returns the next sector in this state, searching from `from` on and around the end of the memory;
 * NOR_SECTORS: none. */
static unsigned find_sector(const struct blackbox *box, unsigned from, uint8_t state)
{
    for (unsigned n = 0; n < NOR_SECTORS; n++) {
        unsigned sector = (from + n) % NOR_SECTORS;
        if (box->sector_state[sector] == state)
            return sector;
    }
    return NOR_SECTORS;
}

static int find_unused_record_index(const struct blackbox *box)
{
    for (int i = 0; i < (int)BLACKBOX_RECORDS_MAX; i++) {
        if (!box->records[i].is_used)
            return i;
    }
    return -1;
}

static int find_record(const struct blackbox *box, uint16_t record)
{
    for (int i = 0; i < (int)BLACKBOX_RECORDS_MAX; i++) {
        if (box->records[i].is_used && box->records[i].record == record)
            return i;
    }
    return -1;
}

/* --- jobs of the memory: JOB_READ reads into `read_buffer`, all others into `buffer` --- */

static void begin_job(struct blackbox *box, enum job job, unsigned sector, unsigned page)
{
    box->job = job;
    box->job_sector = sector;
    box->job_page = page;
}

static void begin_read(struct blackbox *box, enum job job, unsigned sector, unsigned page)
{
    begin_job(box, job, sector, page);
    nor_begin_read(get_address(sector, page), box->buffer, NOR_PAGE_BYTES);
}

/* Frees a record: marks its sectors as dirty. */
static void discard_record(struct blackbox *box, unsigned place)
{
    struct blackbox_record *record = &box->records[place];
    for (unsigned s = 0; s < NOR_SECTORS; s++) {
        if (box->sector_state[s] == place)
            set_sector(box, s, s == record->last_sector ? SECTOR_DIRTY_MARKED : SECTOR_DIRTY);
    }
    record->is_used = false;
}

/* --- pages --- */

/* True if the ring drops its oldest page when it is full, because no landing is being written. */
static bool is_ring_running(const struct blackbox *box)
{
    return box->state == MR_BOX_READY || box->state == MR_BOX_SCANNING;
}

static void open_page(struct blackbox_writer *writer, uint8_t *page)
{
    memset(page, 0, MR_BOXPAGE_BYTES);
    page[MR_BOXPAGE_KIND_OFFSET] = MR_BOXPAGE_NOT_FREED | MR_BOXPAGE_STREAM;
    page[MR_BOXPAGE_FIRST_OFFSET] = MR_BOXPAGE_NO_FIRST;
    writer->page = page;
    writer->next_bit = 0;
    writer->pending_bits = 0;
}

static void open_ring_page(struct blackbox *box)
{
    if (is_ring_running(box) && box->pages_closed - box->pages_written == BLACKBOX_RING_PAGES)
        box->pages_written++;
    if (box->pages_closed % BLACKBOX_KEY_INTERVAL_PAGES == 0)
        box->is_key_due = true;
    box->has_key[box->pages_closed % BLACKBOX_RING_PAGES] = false;
    open_page(&box->stream_writer, box->ring[box->pages_closed % BLACKBOX_RING_PAGES]);
}

static void begin_ring(struct blackbox *box)
{
    box->pages_closed = 0;
    box->pages_written = 0;
    box->pack.has_key = false;
    open_ring_page(box);
    box->stream_writer.page[MR_BOXPAGE_FIRST_OFFSET] = 0;
}

/* True if the ring has room for one more block or message, which may continue in the page after the
 * open one. */
static bool has_ring_space(const struct blackbox *box)
{
    return is_ring_running(box) || box->pages_closed + 1 - box->pages_written < BLACKBOX_RING_PAGES;
}

static void close_page(struct blackbox *box, struct blackbox_writer *writer)
{
    if (writer == &box->stream_writer) {
        box->pages_closed++;
        open_ring_page(box);
    } else if (++box->config_pages_closed < BLACKBOX_CONFIG_PAGES) {
        open_page(writer, box->config_pages[box->config_pages_closed]);
    } else {
        box->is_configuring = false;
    }
}

_Static_assert(MR_BOXPAGE_PAYLOAD_BYTES % 4u == 0, "a page contains a whole number of words");

/* Appends `count` bits word by word; `bits` has complete words, padded with zeroes. */
static void append_bits(struct blackbox *box, struct blackbox_writer *writer, const uint8_t *bits,
                        size_t count)
{
    while (count) {
        unsigned n = count < 32 ? (unsigned)count : 32u, held = writer->next_bit % 32u;
        uint32_t word = mr_get_u32(&bits);
        count -= n;
        writer->pending_bits |= word << held;
        writer->next_bit += n;
        if (held + n < 32)
            continue;
        unsigned end = writer->next_bit / 32u;
        mr_put_u32(writer->page + MR_BOXPAGE_HEADER_BYTES + 4u * (end - 1), writer->pending_bits);
        if (end == MR_BOXPAGE_PAYLOAD_BYTES / 4u) {
            close_page(box, writer);
            writer->next_bit = held + n - 32;
        }
        /* two shifts: one shift by 32 would be undefined */
        writer->pending_bits = word >> 1 >> (31 - held);
    }
}

/* Ends the stream of a page: writes the end tag, then ones. */
static void end_stream(struct blackbox *box, struct blackbox_writer *writer)
{
    static const uint8_t end_tag[4] = {3};
    append_bits(box, writer, end_tag, MR_PACK_TAG_BITS);
    uint8_t ones[4];
    unsigned left = (32u - writer->next_bit % 32u) % 32u; /* number of free bits in the last word */
    mr_put_u32(ones, (1u << left) - 1u);
    append_bits(box, writer, ones, left);
    if (writer->next_bit) {
        memset(writer->page + MR_BOXPAGE_HEADER_BYTES + writer->next_bit / 8, 0xff,
               MR_BOXPAGE_PAYLOAD_BYTES - writer->next_bit / 8);
        close_page(box, writer);
    }
}

static void append_key(struct blackbox *box, const struct mr_block *block)
{
    uint8_t bits[MR_PACK_BYTES_MAX];
    append_bits(box, &box->stream_writer, bits,
                mr_pack_padding(box->stream_writer.next_bit % 8, bits));
    unsigned slot = box->pages_closed % BLACKBOX_RING_PAGES;
    if (box->stream_writer.page[MR_BOXPAGE_FIRST_OFFSET] == MR_BOXPAGE_NO_FIRST)
        box->stream_writer.page[MR_BOXPAGE_FIRST_OFFSET] =
            (uint8_t)(box->stream_writer.next_bit / 8);
    if (!box->has_key[slot]) {
        box->has_key[slot] = true;
        box->key_block[slot] = block->index;
        box->key_stored_count[slot] = box->stored_count;
    }
    if (box->is_first_block_pending) {
        box->is_first_block_pending = false;
        box->end.first_block = block->index;
        box->first_stored_count = box->stored_count;
    }
    append_bits(box, &box->stream_writer, bits, mr_pack_key_block(&box->pack, block, bits));
    box->is_key_due = false;
}

void blackbox_on_block(struct blackbox *box, const struct mr_block *block)
{
    uint8_t bits[MR_PACK_BYTES_MAX];
    if (!box->is_armed || (!is_ring_running(box) && box->state != MR_BOX_RECORDING))
        return;
    box->last_block = block->index;
    if (!has_ring_space(box)) {
        health_count_fault(MR_FAULT_BOX_LOST, 0);
        return;
    }
    if (box->is_key_due || !mr_pack_can_omit_key(&box->pack, block))
        append_key(box, block);
    append_bits(box, &box->stream_writer, bits, mr_pack_block(&box->pack, block, bits));
    box->stored_count++;
}

void blackbox_record_message(struct blackbox *box, uint16_t id, const uint8_t *payload,
                             size_t length)
{
    uint8_t bits[MR_PACK_BYTES_MAX];
    if (!box->is_armed || (!is_ring_running(box) && box->state != MR_BOX_RECORDING))
        return;
    if (!has_ring_space(box)) {
        box->end.lost_messages++;
        health_count_fault(MR_FAULT_BOX_LOST, 1);
        return;
    }
    append_bits(box, &box->stream_writer, bits, mr_pack_message(id, payload, length, bits));
}

void blackbox_arm(struct blackbox *box, const struct mr_boxpage_start_page *start)
{
    if (is_ring_running(box))
        begin_ring(box);
    box->is_armed = true;
    box->reading_index = -1;
    box->start = *start;
    box->config_pages_closed = 1;
    open_page(&box->config_writer, box->config_pages[1]);
    box->config_writer.page[MR_BOXPAGE_FIRST_OFFSET] = 0;
    box->is_configuring = true;
}

void blackbox_record_configuration(struct blackbox *box, uint16_t id, const uint8_t *payload,
                                   size_t length)
{
    uint8_t bits[MR_PACK_BYTES_MAX];
    if (!box->is_configuring)
        return;
    size_t count = mr_pack_message(id, payload, length, bits);
    unsigned left = (BLACKBOX_CONFIG_PAGES - box->config_pages_closed) * MR_BOXPAGE_PAYLOAD_BYTES *
                        8u -
                    box->config_writer.next_bit;
    if (count + MR_PACK_TAG_BITS + 32u <= left) {
        /* keep room for the end tag and for the last, incomplete word */
        append_bits(box, &box->config_writer, bits, count);
        return;
    }
    health_count_fault(MR_FAULT_BOX_LOST, 1);
    /* end the page properly; otherwise a reader would continue with bits of the stream */
    end_stream(box, &box->config_writer);
    box->is_configuring = false;
}

/* Skips the pages before the first key, which a reader could not decode. Skips further pages if the
 * ring would not have enough room for the blocks that arrive while the configuration is written and
 * an erase ends. */
static void skip_to_key(struct blackbox *box)
{
    uint32_t slack = box->is_waiting_for_erase || box->job == JOB_ERASE ||
                             box->job == JOB_CHECK_ERASED
                       ? RING_RESERVE_ERASE_PAGES
                       : RING_RESERVE_PAGES;
    if (box->pages_closed + slack - box->pages_written > BLACKBOX_RING_PAGES)
        box->pages_written = box->pages_closed + slack - BLACKBOX_RING_PAGES;
    while (box->pages_written != box->pages_closed &&
           box->ring[box->pages_written % BLACKBOX_RING_PAGES][MR_BOXPAGE_FIRST_OFFSET] ==
               MR_BOXPAGE_NO_FIRST)
        box->pages_written++;
    uint32_t keyed = box->pages_written;
    while (keyed != box->pages_closed && !box->has_key[keyed % BLACKBOX_RING_PAGES])
        keyed++;
    unsigned slot = keyed % BLACKBOX_RING_PAGES;
    box->is_first_block_pending = !box->has_key[slot];
    box->is_key_due |= box->is_first_block_pending;
    box->end = (struct mr_boxpage_end){.first_block = box->key_block[slot]};
    box->first_stored_count = box->key_stored_count[slot];
}

/* --- scan of the memory at start: the next step follows when a job ends --- */

static void scan_next_sector(struct blackbox *box)
{
    box->tries = 0;
    box->scan_sector++;
}

static unsigned find_record_index(struct blackbox *box, uint16_t record)
{
    int place = find_record(box, record);
    if (place >= 0)
        return (unsigned)place;
    place = find_unused_record_index(box);
    if (place < 0)
        return BLACKBOX_RECORDS_MAX;
    box->records[place] =
        (struct blackbox_record){.is_used = true, .record = record, .first_seq = UINT32_MAX};
    return (unsigned)place;
}

static void register_page(struct blackbox *box, const struct mr_boxpage_header *header)
{
    unsigned place = find_record_index(box, header->record);
    if (place == BLACKBOX_RECORDS_MAX) {
        set_sector(box, box->job_sector, SECTOR_UNLISTED_RECORD);
        return;
    }
    struct blackbox_record *record = &box->records[place];
    set_sector(box, box->job_sector, (uint8_t)place);
    if (header->seq - box->job_page < record->first_seq) {
        record->first_seq = header->seq - box->job_page;
        record->first_sector = (uint16_t)box->job_sector;
    }
    if (header->seq >= record->next_seq) {
        record->next_seq = header->seq + 1;
        record->last_sector = (uint16_t)box->job_sector;
        box->is_freed[place] = header->is_freed && box->job_page == 0;
    }
}

static void check_scanned_page(struct blackbox *box)
{
    struct mr_boxpage_header header;
    if (mr_boxpage_check(box->buffer, &header) == MR_OK) {
        register_page(box, &header);
        scan_next_sector(box);
    } else if (++box->tries < SCAN_TRIES_MAX) {
        begin_read(box, JOB_SCAN_PAGE, box->job_sector, box->tries / 2);
    } else { /* the page is damaged, or not one of the black box */
        set_sector(box, box->job_sector, SECTOR_DIRTY);
        scan_next_sector(box);
    }
}

static void check_first_page(struct blackbox *box)
{
    bool blank = true;
    for (unsigned i = 0; i < MR_BOXPAGE_HEADER_BYTES; i++)
        blank = blank && box->buffer[i] == 0xff;
    if (!blank) {
        begin_read(box, JOB_SCAN_PAGE, box->job_sector, 0);
        return;
    }
    set_sector(box, box->job_sector, SECTOR_ERASED);
    scan_next_sector(box);
}

/* Searches the last sector of a record, page by page, for its last page. */
static void find_last_page(struct blackbox *box)
{
    struct blackbox_record *record = &box->records[box->scan_record_index];
    struct mr_boxpage_header header;
    enum mr_status status = mr_boxpage_check(box->buffer, &header);
    if (status == MR_OK && header.record == record->record) {
        record->next_seq = header.seq + 1;
        if (header.kind == MR_BOXPAGE_END) {
            struct mr_boxpage_end end;
            mr_boxpage_get_end(box->buffer, &end);
            record->is_complete = true;
            record->first_block = end.first_block;
            record->stored_blocks = end.stored_blocks;
            record->lost_blocks = end.lost_blocks;
        }
    } else if (status == MR_CRC && ++box->tries < READ_TRIES_MAX) {
        begin_read(box, JOB_SCAN_FIND_END, box->job_sector, box->job_page);
        return;
    }
    box->tries = 0;
    if (status == MR_OK && box->job_page + 1 < SECTOR_PAGES)
        begin_read(box, JOB_SCAN_FIND_END, box->job_sector, box->job_page + 1);
    else
        begin_read(box, JOB_SCAN_START, record->first_sector, 0);
}

static void read_start_page(struct blackbox *box)
{
    struct mr_boxpage_header header;
    enum mr_status status = mr_boxpage_check(box->buffer, &header);
    if (status == MR_CRC && ++box->tries < READ_TRIES_MAX) {
        begin_read(box, JOB_SCAN_START, box->job_sector, 0);
        return;
    }
    if (status == MR_OK && header.kind == MR_BOXPAGE_START) {
        struct mr_boxpage_start_page start;
        mr_boxpage_get_start(box->buffer, &start);
        box->records[box->scan_record_index].landing = start.landing;
    }
    box->tries = 0;
    box->scan_record_index++;
}

static void end_scan(struct blackbox *box)
{
    for (unsigned i = 0; i < BLACKBOX_RECORDS_MAX; i++) {
        const struct blackbox_record *record = &box->records[i];
        if (record->is_used && record->next_seq > box->next_seq) {
            box->next_seq = record->next_seq;
            box->next_record = (uint16_t)(record->record + 1);
            box->newest_sector = record->last_sector;
        }
    }
    for (unsigned i = 0; i < BLACKBOX_RECORDS_MAX; i++) {
        if (box->records[i].is_used && box->is_freed[i])
            discard_record(box, i);
    }
    box->write_sector = (box->newest_sector + 1) % NOR_SECTORS;
    box->state = MR_BOX_READY;
}

static bool begin_scan(struct blackbox *box)
{
    if (box->scan_sector < NOR_SECTORS) {
        begin_job(box, JOB_SCAN_FIRST_PAGE, box->scan_sector, 0);
        nor_begin_read(get_address(box->scan_sector, 0), box->buffer, MR_BOXPAGE_HEADER_BYTES);
        return true;
    }
    while (box->scan_record_index < BLACKBOX_RECORDS_MAX &&
           !box->records[box->scan_record_index].is_used)
        box->scan_record_index++;
    if (box->scan_record_index < BLACKBOX_RECORDS_MAX) {
        begin_read(box, JOB_SCAN_FIND_END, box->records[box->scan_record_index].last_sector, 0);
        return true;
    }
    end_scan(box);
    return false;
}

/* --- reading a record --- */

static bool begin_read_out(struct blackbox *box)
{
    if (box->has_read_all)
        return false;
    begin_job(box, JOB_READ, box->read_sector, box->read_cursor);
    nor_begin_read(get_address(box->read_sector, box->read_cursor), box->read_buffer,
                   NOR_PAGE_BYTES);
    return true;
}

static void advance_read(struct blackbox *box)
{
    unsigned place = (unsigned)box->reading_index;
    box->read_tries = 0;
    if (++box->read_cursor < SECTOR_PAGES)
        return;
    box->read_cursor = 0;
    if (box->read_sector == box->records[place].last_sector)
        box->has_read_all = true;
    else
        box->read_sector = find_sector(box, box->read_sector + 1, (uint8_t)place);
}

static void read_page(struct blackbox *box)
{
    struct mr_boxpage_header header;
    if (box->reading_index < 0)
        return;
    const struct blackbox_record *record = &box->records[box->reading_index];
    enum mr_status status = mr_boxpage_check(box->read_buffer, &header);
    if (status == MR_OK && header.record == record->record &&
        header.seq - record->first_seq >= box->read_page) {
        box->read_page = header.seq - record->first_seq;
        box->is_page_ready = true;
        box->read_part = 0;
    } else if (status == MR_CRC && ++box->read_tries < READ_TRIES_MAX) {
        return;
    } else {
        if (status == MR_CRC)
            health_count_fault(MR_FAULT_NOR_FAILED, 3);
        advance_read(box);
    }
}

/* --- a landing begins and ends --- */

void blackbox_trigger(struct blackbox *box, uint32_t block)
{
    int place = find_unused_record_index(box);
    if (box->state != MR_BOX_READY || !box->is_armed || place < 0)
        return;
    if (box->is_configuring)
        end_stream(box, &box->config_writer);
    box->is_configuring = false;
    box->start.trigger_block = block;
    mr_boxpage_put_start(box->config_pages[0], &box->start);
    box->config_pages_written = 0;
    skip_to_key(box);
    box->record_index = (unsigned)place;
    box->records[place] = (struct blackbox_record){.is_used = true,
                                                   .record = box->next_record++,
                                                   .landing = box->start.landing,
                                                   .first_sector = NOR_SECTORS,
                                                   .first_seq = box->next_seq,
                                                   .next_seq = box->next_seq};
    box->write_page = SECTOR_PAGES;
    box->failures = 0;
    box->is_end_written = false;
    box->reading_index = -1;
    box->state = MR_BOX_RECORDING;
}

void blackbox_finish(struct blackbox *box)
{
    box->is_armed = false;
    box->is_configuring = false;
    if (box->state == MR_BOX_RECORDING)
        box->state = MR_BOX_CLOSING;
}

/* Writes the rest of the stream and the end page as soon as the ring has room for both. */
static void write_end_page(struct blackbox *box)
{
    if (box->state != MR_BOX_CLOSING || box->is_end_written ||
        box->pages_closed + 3 - box->pages_written >= BLACKBOX_RING_PAGES)
        return;
    end_stream(box, &box->stream_writer);
    box->end.stored_blocks = box->is_first_block_pending
                               ? 0
                               : box->stored_count - box->first_stored_count;
    box->end.lost_blocks = box->is_first_block_pending
                             ? 0
                             : box->last_block + 1 - box->end.first_block - box->end.stored_blocks;
    mr_boxpage_put_end(box->ring[box->pages_closed % BLACKBOX_RING_PAGES], &box->end);
    box->pages_closed++;
    box->is_end_written = true;
}

static void close_record(struct blackbox *box, bool complete)
{
    struct blackbox_record *record = &box->records[box->record_index];
    record->is_complete = complete;
    record->first_block = box->end.first_block;
    record->stored_blocks = box->end.stored_blocks;
    record->lost_blocks = box->end.lost_blocks;
    if (record->first_sector == NOR_SECTORS)
        record->is_used = false; /* no page was written, so there is no record */
    box->state = MR_BOX_READY;
    begin_ring(box);
}

/* --- writing --- */

static uint8_t *begin_next_page(struct blackbox *box)
{
    if (box->config_pages_written < box->config_pages_closed)
        return box->config_pages[box->config_pages_written];
    return box->pages_written != box->pages_closed
             ? box->ring[box->pages_written % BLACKBOX_RING_PAGES]
             : NULL;
}

static bool begin_program(struct blackbox *box)
{
    struct blackbox_record *record = &box->records[box->record_index];
    uint8_t *page = begin_next_page(box);
    if (!page) {
        if (box->is_end_written)
            close_record(box, true);
        return false;
    }
    if (box->write_page == SECTOR_PAGES) {
        unsigned sector = find_sector(box, box->write_sector, SECTOR_ERASED);
        if (sector == NOR_SECTORS) {
            /* the memory is full: the ring keeps its pages, and new data is lost */
            if (box->state == MR_BOX_CLOSING)
                close_record(box, false);
            return false;
        }
        box->write_sector = sector;
        box->write_page = 0;
    }
    mr_boxpage_seal(page, record->next_seq, record->record);
    begin_job(box, JOB_PROGRAM, box->write_sector, box->write_page);
    nor_begin_program(get_address(box->write_sector, box->write_page), page);
    return true;
}

static void confirm_page(struct blackbox *box)
{
    struct blackbox_record *record = &box->records[box->record_index];
    if (box->write_page == 0) {
        set_sector(box, box->write_sector, (uint8_t)box->record_index);
        if (record->first_sector == NOR_SECTORS)
            record->first_sector = (uint16_t)box->write_sector;
        record->last_sector = (uint16_t)box->write_sector;
        box->newest_sector = box->write_sector;
    }
    box->failures = 0;
    box->next_seq = ++record->next_seq;
    if (box->config_pages_written < box->config_pages_closed)
        box->config_pages_written++;
    else
        box->pages_written++;
    if (++box->write_page == SECTOR_PAGES)
        box->write_sector = (box->write_sector + 1) % NOR_SECTORS;
}

/* Continues in the next sector after a page has failed. */
static void handle_failed_page(struct blackbox *box)
{
    health_count_fault(MR_FAULT_NOR_FAILED, 1);
    if (box->write_page == 0)
        set_sector(box, box->write_sector, SECTOR_BAD);
    box->write_sector = (box->write_sector + 1) % NOR_SECTORS;
    box->write_page = SECTOR_PAGES;
    if (++box->failures == FAILURES_MAX) {
        box->state = MR_BOX_FAILED;
        box->is_armed = false;
    }
}

static void verify_page(struct blackbox *box)
{
    const uint8_t *page = begin_next_page(box);
    if (memcmp(page, box->buffer, NOR_PAGE_BYTES) == 0)
        confirm_page(box);
    else if (++box->tries < VERIFY_TRIES_MAX)
        begin_read(box, JOB_VERIFY, box->job_sector, box->job_page);
    else
        handle_failed_page(box);
}

/* --- erasing --- */

static void mark_sector_bad(struct blackbox *box)
{
    health_count_fault(MR_FAULT_NOR_FAILED, 2);
    set_sector(box, box->job_sector, SECTOR_BAD);
}

static void begin_erase(struct blackbox *box, unsigned sector)
{
    begin_job(box, JOB_ERASE, sector, 0);
    box->erase_start_ms = box->now_ms;
    nor_begin_erase(get_address(sector, 0));
}

/* Checks an erased sector page by page. */
static void check_erased_page(struct blackbox *box)
{
    if (mr_is_blank(box->buffer, NOR_PAGE_BYTES)) {
        if (box->job_page + 1 == SECTOR_PAGES)
            set_sector(box, box->job_sector, SECTOR_ERASED);
        else
            begin_read(box, JOB_CHECK_ERASED, box->job_sector, box->job_page + 1);
    } else if (box->state != MR_BOX_READY || box->is_armed) {
        return; /* leave the sector dirty for a later erase */
    } else if (++box->tries < ERASE_TRIES_MAX) {
        begin_erase(box, box->job_sector);
    } else {
        mark_sector_bad(box);
    }
}

static bool begin_idle_work(struct blackbox *box)
{
    unsigned sector = NOR_SECTORS;
    if (box->dirty_sectors) {
        sector = find_sector(box, box->write_sector, SECTOR_DIRTY);
        if (sector == NOR_SECTORS)
            sector = find_sector(box, (box->newest_sector + 1) % NOR_SECTORS, SECTOR_DIRTY_MARKED);
    }
    if (sector == NOR_SECTORS || sector == box->newest_sector)
        return false;
    box->tries = 0;
    begin_erase(box, sector);
    return true;
}

/* --- freeing --- */

static void program_mark(struct blackbox *box)
{
    uint8_t kind = box->buffer[MR_BOXPAGE_KIND_OFFSET] & (uint8_t)~MR_BOXPAGE_NOT_FREED;
    memset(box->buffer, 0xff, NOR_PAGE_BYTES);
    box->buffer[MR_BOXPAGE_KIND_OFFSET] = kind;
    begin_job(box, JOB_FREE_PROGRAM, box->job_sector, 0);
    nor_begin_program(get_address(box->job_sector, 0), box->buffer);
}

static void check_mark(struct blackbox *box)
{
    if (!(box->buffer[MR_BOXPAGE_KIND_OFFSET] & MR_BOXPAGE_NOT_FREED))
        discard_record(box, (unsigned)box->freeing_index);
    else
        health_count_fault(MR_FAULT_NOR_FAILED, 4); /* the record could not be freed */
    box->freeing_index = -1;
}

/* --- poll --- */

static bool begin_next_job(struct blackbox *box)
{
    switch (box->state) {
    case MR_BOX_SCANNING: return begin_scan(box);
    case MR_BOX_RECORDING:
    case MR_BOX_CLOSING: return begin_program(box);
    case MR_BOX_READY:
        if (box->is_armed)
            return false;
        if (box->freeing_index >= 0) {
            begin_read(box, JOB_FREE_READ, box->records[box->freeing_index].last_sector, 0);
            return true;
        }
        if (box->reading_index >= 0)
            return !box->is_page_ready && begin_read_out(box);
        return begin_idle_work(box);
    default: return false;
    }
}

static void finish_job(struct blackbox *box, bool done)
{
    enum job job = box->job;
    box->job = JOB_NONE;
    switch (job) {
    case JOB_SCAN_FIRST_PAGE: check_first_page(box); break;
    case JOB_SCAN_PAGE: check_scanned_page(box); break;
    case JOB_SCAN_FIND_END: find_last_page(box); break;
    case JOB_SCAN_START: read_start_page(box); break;
    case JOB_PROGRAM:
        box->tries = 0;
        if (done)
            begin_read(box, JOB_VERIFY, box->job_sector, box->job_page);
        else
            handle_failed_page(box);
        break;
    case JOB_VERIFY: verify_page(box); break;
    case JOB_ERASE:
        if (done) {
            box->erase_ms = (3 * box->erase_ms + (box->now_ms - box->erase_start_ms) + 2) / 4;
            begin_read(box, JOB_CHECK_ERASED, box->job_sector, 0);
        } else {
            mark_sector_bad(box);
        }
        break;
    case JOB_CHECK_ERASED: check_erased_page(box); break;
    case JOB_FREE_READ: program_mark(box); break;
    case JOB_FREE_PROGRAM: begin_read(box, JOB_FREE_VERIFY, box->job_sector, 0); break;
    case JOB_FREE_VERIFY: check_mark(box); break;
    case JOB_READ: read_page(box); break;
    case JOB_NONE: break;
    }
}

void blackbox_start(struct blackbox *box)
{
    memset(box, 0, sizeof *box);
    memset(box->sector_state, SECTOR_UNREAD, sizeof box->sector_state);
    box->next_record = 1;
    box->newest_sector = NOR_SECTORS - 1;
    box->erase_ms = ERASE_ASSUMED_MS;
    box->freeing_index = -1;
    box->reading_index = -1;
    box->state = MR_BOX_SCANNING;
    begin_ring(box);
    if (nor_poll() == NOR_MISSING) {
        health_count_fault(MR_FAULT_NOR_MISSING, 0);
        box->state = MR_BOX_MISSING;
    }
}

bool blackbox_has_memory(const struct blackbox *box)
{
    return box->state != MR_BOX_MISSING && !box->is_stuck;
}

void blackbox_disable(struct blackbox *box)
{
    memset(box, 0, sizeof *box);
    box->is_disabled = true;
    box->freeing_index = -1;
    box->reading_index = -1;
}

void blackbox_poll(struct blackbox *box, uint32_t now_ms)
{
    box->now_ms = now_ms;
    if (!blackbox_has_memory(box))
        return;
    write_end_page(box);
    for (unsigned n = 0; n < JOB_STEPS_PER_POLL; n++) {
        enum nor_status status = nor_poll();
        if (status == NOR_BUSY)
            return;
        if (status == NOR_MISSING) {
            health_count_fault(MR_FAULT_NOR_MISSING, 1);
            box->state = MR_BOX_MISSING;
            return;
        }
        if (status == NOR_STUCK) {
            health_count_fault(MR_FAULT_NOR_FAILED, 5);
            box->is_stuck = true;
            box->state = MR_BOX_FAILED;
            return;
        }
        finish_job(box, status == NOR_IDLE);
        if (box->job == JOB_NONE && !begin_next_job(box))
            return;
    }
}

bool blackbox_is_idle(const struct blackbox *box)
{
    return box->job == JOB_NONE && (box->state == MR_BOX_READY || box->state == MR_BOX_FAILED);
}

enum mr_status blackbox_check_ready(const struct blackbox *box)
{
    if (box->state == MR_BOX_MISSING || box->state == MR_BOX_FAILED)
        return MR_OK;
    if (box->state != MR_BOX_READY || box->freeing_index >= 0)
        return MR_WAIT;
    if (find_unused_record_index(box) < 0 ||
        box->ready_sectors + box->dirty_sectors < BLACKBOX_RESERVE_SECTORS)
        return MR_FULL;
    return box->ready_sectors < BLACKBOX_RESERVE_SECTORS ? MR_WAIT : MR_OK;
}

float blackbox_wait_s(const struct blackbox *box)
{
    switch (blackbox_check_ready(box)) {
    case MR_OK: return 0.0f;
    case MR_WAIT:
        if (box->state == MR_BOX_SCANNING || box->freeing_index >= 0)
            return 1.0f;
        if (box->state != MR_BOX_READY)
            return 0.005f * (float)(box->pages_closed - box->pages_written + 1);
        return 0.001f *
               (float)((BLACKBOX_RESERVE_SECTORS - box->ready_sectors) * (box->erase_ms + 1));
    default: return MR_NAN;
    }
}

enum mr_status blackbox_check_access(const struct blackbox *box)
{
    if (box->state == MR_BOX_SCANNING || box->state == MR_BOX_CLOSING || box->freeing_index >= 0)
        return MR_WAIT;
    return box->state == MR_BOX_READY && !box->is_armed ? MR_OK : MR_NOT_NOW;
}

enum mr_status blackbox_free(struct blackbox *box, uint16_t record)
{
    int place = find_record(box, record);
    enum mr_status status = blackbox_check_access(box);
    if (status != MR_OK)
        return status;
    if (place < 0)
        return MR_UNKNOWN;
    if (box->reading_index == place)
        box->reading_index = -1;
    box->freeing_index = place;
    return MR_OK;
}

const struct blackbox_record *blackbox_record_at(const struct blackbox *box, unsigned i)
{
    return i < BLACKBOX_RECORDS_MAX && box->records[i].is_used ? &box->records[i] : NULL;
}

enum mr_status blackbox_read(struct blackbox *box, uint16_t record, uint32_t page)
{
    int place = find_record(box, record);
    enum mr_status status = blackbox_check_access(box);
    if (status != MR_OK)
        return status;
    if (place < 0)
        return MR_UNKNOWN;
    /* Page n of a record is in sector n / SECTOR_PAGES of the record or in a later one, because a
     * sector has at most SECTOR_PAGES of its pages. */
    box->read_sector = box->records[place].first_sector;
    for (uint32_t n = 0;
         n < page / SECTOR_PAGES && box->read_sector != box->records[place].last_sector; n++)
        box->read_sector = find_sector(box, box->read_sector + 1, (uint8_t)place);
    box->reading_index = place;
    box->read_page = page;
    box->read_cursor = 0;
    box->read_tries = 0;
    box->is_page_ready = false;
    box->has_read_all = false;
    return MR_OK;
}

enum blackbox_part blackbox_get_part(struct blackbox *box, uint16_t *record, uint16_t *page,
                                     uint8_t *part, const uint8_t **bytes)
{
    if (box->reading_index < 0)
        return BLACKBOX_PART_NONE;
    const struct blackbox_record *of = &box->records[box->reading_index];
    *record = of->record;
    if (box->has_read_all && !box->is_page_ready) {
        *page = (uint16_t)(of->next_seq - of->first_seq);
        box->reading_index = -1;
        return BLACKBOX_PART_END;
    }
    if (!box->is_page_ready)
        return BLACKBOX_PART_NONE;
    *page = (uint16_t)box->read_page;
    *part = (uint8_t)box->read_part;
    *bytes = box->read_buffer + BLACKBOX_PART_BYTES * box->read_part;
    if (++box->read_part == NOR_PAGE_BYTES / BLACKBOX_PART_BYTES) {
        box->is_page_ready = false;
        box->read_page++;
        advance_read(box);
    }
    return BLACKBOX_PART_READY;
}
