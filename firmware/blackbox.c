#include "firmware/blackbox_parts.h"

#include <string.h>

#include "common/wire.h"
#include "firmware/health.h"

#define STEPS        128u /* of the memory in one poll; a read takes two polls or more */
#define VERIFY_TRIES 2u
#define ERASE_TRIES  2u
#define FAILURES_MAX 64u
/* a sector that looked erased at start is looked at page by page: all of them in 22 min */
#define LOOK_MS      20u
#define ERASE_MS     60u /* until one was timed */

uint32_t blackbox_address(unsigned sector, unsigned page)
{
    return sector * NOR_SECTOR + page * NOR_PAGE;
}

static bool is_ready(uint8_t state)
{
    return state == SECTOR_ERASED || state == SECTOR_BLANK;
}
static bool is_dirty(uint8_t state)
{
    return state == SECTOR_DIRTY || state == SECTOR_LAST;
}

void blackbox_set_sector(struct blackbox *box, unsigned sector, uint8_t state)
{
    uint8_t before = box->sector[sector];
    box->ready = box->ready - is_ready(before) + is_ready(state);
    box->dirty = box->dirty - is_dirty(before) + is_dirty(state);
    box->bad = box->bad - (before == SECTOR_BAD) + (state == SECTOR_BAD);
    box->sector[sector] = state;
}

/* The next sector from `from` on, around the memory, whose state lies in [low, high]; NOR_SECTORS:
 * none. */
unsigned blackbox_find_sector(const struct blackbox *box, unsigned from, uint8_t low, uint8_t high)
{
    for (unsigned n = 0; n < NOR_SECTORS; n++) {
        unsigned sector = (from + n) % NOR_SECTORS;
        if (box->sector[sector] >= low && box->sector[sector] <= high)
            return sector;
    }
    return NOR_SECTORS;
}

/* --- a landing begins and ends --- */

int blackbox_free_place(const struct blackbox *box)
{
    for (int i = 0; i < (int)BLACKBOX_RECORDS; i++) {
        if (!box->records[i].used)
            return i;
    }
    return -1;
}

int blackbox_find_record(const struct blackbox *box, uint16_t record)
{
    for (int i = 0; i < (int)BLACKBOX_RECORDS; i++) {
        if (box->records[i].used && box->records[i].record == record)
            return i;
    }
    return -1;
}

void blackbox_trigger(struct blackbox *box, uint32_t block)
{
    int place = blackbox_free_place(box);
    if (box->state != BLACKBOX_ROLLING || !box->armed || place < 0)
        return;
    if (box->configuring)
        blackbox_flush(box, &box->meta);
    box->configuring = false;
    box->start.trigger_block = block;
    mr_boxpage_put_start(box->config[0], &box->start);
    box->config_got = 0;
    blackbox_begin_at_key(box);
    box->place = (unsigned)place;
    box->records[place] = (struct blackbox_record){.used = true,
                                                   .record = box->next_record++,
                                                   .landing = box->start.landing,
                                                   .first_sector = NOR_SECTORS,
                                                   .first_seq = box->next_seq,
                                                   .next_seq = box->next_seq};
    box->head_page = PAGES;
    box->failures = 0;
    box->end_written = false;
    box->reading = -1;
    box->state = BLACKBOX_RECORDING;
}

void blackbox_finish(struct blackbox *box)
{
    box->armed = false;
    box->configuring = false;
    if (box->state == BLACKBOX_RECORDING)
        box->state = BLACKBOX_CLOSING;
}

/* The rest of the stream and the end page, as soon as the ring has room for both. */
static void write_end(struct blackbox *box)
{
    if (box->state != BLACKBOX_CLOSING || box->end_written ||
        box->put + 3 - box->got >= BLACKBOX_RING)
        return;
    blackbox_flush(box, &box->stream);
    box->end.blocks = box->first_open ? 0 : box->stored - box->first_stored;
    box->end.lost = box->first_open ? 0
                                    : box->last_block + 1 - box->end.first_block - box->end.blocks;
    mr_boxpage_put_end(box->ring[box->put % BLACKBOX_RING], &box->end);
    box->put++;
    box->end_written = true;
}

static void close_record(struct blackbox *box, bool complete)
{
    struct blackbox_record *record = &box->records[box->place];
    record->complete = complete;
    record->first_block = box->end.first_block;
    record->blocks = box->end.blocks;
    record->lost = box->end.lost;
    if (record->first_sector == NOR_SECTORS)
        record->used = false; /* not a single page found its place */
    box->state = BLACKBOX_ROLLING;
    blackbox_begin_ring(box);
}

/* --- writing --- */

static uint8_t *next_page(struct blackbox *box)
{
    if (box->config_got < box->config_put)
        return box->config[box->config_got];
    return box->got != box->put ? box->ring[box->got % BLACKBOX_RING] : NULL;
}

void blackbox_begin_job(struct blackbox *box, enum job job, unsigned sector, unsigned page)
{
    box->job = job;
    box->job_sector = sector;
    box->job_page = page;
}

void blackbox_begin_read(struct blackbox *box, enum job job, unsigned sector, unsigned page)
{
    blackbox_begin_job(box, job, sector, page);
    nor_begin_read(blackbox_address(sector, page), box->buffer, NOR_PAGE);
}

static bool begin_program(struct blackbox *box)
{
    struct blackbox_record *record = &box->records[box->place];
    uint8_t *page = next_page(box);
    if (!page) {
        if (box->end_written)
            close_record(box, true);
        return false;
    }
    if (box->head_page == PAGES) {
        unsigned sector = blackbox_find_sector(box, box->head, SECTOR_BLANK, SECTOR_ERASED);
        if (sector == NOR_SECTORS) {
            /* full: what is in the ring stays there and what comes is lost */
            if (box->state == BLACKBOX_CLOSING)
                close_record(box, false);
            return false;
        }
        box->head = sector;
        box->head_page = 0;
    }
    mr_boxpage_seal(page, record->next_seq, record->record);
    blackbox_begin_job(box, JOB_PROGRAM, box->head, box->head_page);
    nor_begin_program(blackbox_address(box->head, box->head_page), page);
    return true;
}

static void page_holds(struct blackbox *box)
{
    struct blackbox_record *record = &box->records[box->place];
    if (box->head_page == 0) {
        blackbox_set_sector(box, box->head, (uint8_t)box->place);
        if (record->first_sector == NOR_SECTORS)
            record->first_sector = (uint16_t)box->head;
        record->last_sector = (uint16_t)box->head;
        box->newest_sector = box->head;
    }
    box->failures = 0;
    box->next_seq = ++record->next_seq;
    if (box->config_got < box->config_put)
        box->config_got++;
    else
        box->got++;
    if (++box->head_page == PAGES)
        box->head = (box->head + 1) % NOR_SECTORS;
}

/* The page goes into the next sector. */
static void page_fails(struct blackbox *box)
{
    health_count(MR_FAULT_NOR_FAILED, 1);
    if (box->head_page == 0)
        blackbox_set_sector(box, box->head, SECTOR_BAD);
    box->head = (box->head + 1) % NOR_SECTORS;
    box->head_page = PAGES;
    if (++box->failures == FAILURES_MAX) {
        box->state = BLACKBOX_FAILED;
        box->armed = false;
    }
}

static void verify(struct blackbox *box)
{
    const uint8_t *page = next_page(box);
    if (memcmp(page, box->buffer, NOR_PAGE) == 0)
        page_holds(box);
    else if (++box->tries < VERIFY_TRIES)
        blackbox_begin_read(box, JOB_VERIFY, box->job_sector, box->job_page);
    else
        page_fails(box);
}

/* --- erasing --- */

static void erase_fails(struct blackbox *box)
{
    health_count(MR_FAULT_NOR_FAILED, 2);
    blackbox_set_sector(box, box->job_sector, SECTOR_BAD);
}

static void begin_erase(struct blackbox *box, unsigned sector)
{
    blackbox_begin_job(box, JOB_ERASE, sector, 0);
    box->erase_begun_ms = box->now_ms;
    nor_begin_erase(blackbox_address(sector, 0));
}

static void look(struct blackbox *box)
{
    bool was_dirty = is_dirty(box->sector[box->job_sector]);
    if (mr_is_blank(box->buffer, NOR_PAGE)) {
        if (box->job_page + 1 == PAGES)
            blackbox_set_sector(box, box->job_sector, SECTOR_ERASED);
        else if (was_dirty) /* just erased: to the end; else a page now and then */
            blackbox_begin_read(box, JOB_LOOK, box->job_sector, box->job_page + 1);
        box->look_page = was_dirty ? 0 : (box->job_page + 1) % PAGES;
        return;
    }
    box->look_page = 0;
    if (!was_dirty)
        blackbox_set_sector(box, box->job_sector, SECTOR_DIRTY);
    else if (box->state != BLACKBOX_ROLLING || box->armed)
        return; /* it stays dirty until there is time again */
    else if (++box->tries < ERASE_TRIES)
        begin_erase(box, box->job_sector);
    else
        erase_fails(box);
}

static bool begin_idle_work(struct blackbox *box)
{
    unsigned sector = NOR_SECTORS;
    if (box->dirty) {
        sector = blackbox_find_sector(box, box->head, SECTOR_DIRTY, SECTOR_DIRTY);
        if (sector == NOR_SECTORS)
            sector = blackbox_find_sector(box, (box->newest_sector + 1) % NOR_SECTORS, SECTOR_LAST,
                                          SECTOR_LAST);
        if (sector == box->newest_sector)
            sector = NOR_SECTORS;
    }
    if (sector != NOR_SECTORS) {
        box->tries = 0;
        begin_erase(box, sector);
        return true;
    }
    if (box->now_ms - box->looked_ms < LOOK_MS)
        return false;
    box->looked_ms = box->now_ms;
    if (box->all_looked)
        return false;
    sector = blackbox_find_sector(box, box->look_sector, SECTOR_BLANK, SECTOR_BLANK);
    box->all_looked = sector == NOR_SECTORS; /* only the scan at start finds such */
    if (box->all_looked)
        return false;
    box->look_sector = sector;
    blackbox_begin_read(box, JOB_LOOK, sector, box->look_page);
    return true;
}

/* --- freeing --- */

void blackbox_drop_record(struct blackbox *box, unsigned place)
{
    struct blackbox_record *record = &box->records[place];
    for (unsigned s = 0; s < NOR_SECTORS; s++) {
        if (box->sector[s] == place)
            blackbox_set_sector(box, s, s == record->last_sector ? SECTOR_LAST : SECTOR_DIRTY);
    }
    record->used = false;
}

static void program_mark(struct blackbox *box)
{
    uint8_t kind = box->buffer[MR_BOXPAGE_KIND] & (uint8_t)~MR_BOXPAGE_LIVE;
    memset(box->buffer, 0xff, NOR_PAGE);
    box->buffer[MR_BOXPAGE_KIND] = kind;
    blackbox_begin_job(box, JOB_MARK, box->job_sector, 0);
    nor_begin_program(blackbox_address(box->job_sector, 0), box->buffer);
}

static void check_mark(struct blackbox *box)
{
    if (!(box->buffer[MR_BOXPAGE_KIND] & MR_BOXPAGE_LIVE))
        blackbox_drop_record(box, (unsigned)box->freeing);
    else
        health_count(MR_FAULT_NOR_FAILED, 4); /* it stays */
    box->freeing = -1;
}

/* --- all together --- */

static bool begin_job(struct blackbox *box)
{
    switch (box->state) {
    case BLACKBOX_SCANNING: return blackbox_begin_scan(box);
    case BLACKBOX_RECORDING:
    case BLACKBOX_CLOSING: return begin_program(box);
    case BLACKBOX_ROLLING:
        if (box->armed)
            return false;
        if (box->freeing >= 0) {
            blackbox_begin_read(box, JOB_MARK_READ, box->records[box->freeing].last_sector, 0);
            return true;
        }
        if (box->reading >= 0)
            return !box->read_ready && blackbox_begin_read_out(box);
        return begin_idle_work(box);
    default: return false;
    }
}

static void finish_job(struct blackbox *box, bool done)
{
    enum job job = box->job;
    box->job = JOB_NONE;
    switch (job) {
    case JOB_SCAN_HEAD: blackbox_scan_head(box); break;
    case JOB_SCAN_PAGE: blackbox_scan_page(box); break;
    case JOB_SCAN_WALK: blackbox_scan_walk(box); break;
    case JOB_SCAN_START: blackbox_scan_start(box); break;
    case JOB_PROGRAM:
        box->tries = 0;
        if (done)
            blackbox_begin_read(box, JOB_VERIFY, box->job_sector, box->job_page);
        else
            page_fails(box);
        break;
    case JOB_VERIFY: verify(box); break;
    case JOB_ERASE:
        if (done) {
            box->erase_ms = (3 * box->erase_ms + (box->now_ms - box->erase_begun_ms) + 2) / 4;
            blackbox_begin_read(box, JOB_LOOK, box->job_sector, 0);
        } else {
            erase_fails(box);
        }
        break;
    case JOB_LOOK: look(box); break;
    case JOB_MARK_READ: program_mark(box); break;
    case JOB_MARK: blackbox_begin_read(box, JOB_MARK_CHECK, box->job_sector, 0); break;
    case JOB_MARK_CHECK: check_mark(box); break;
    case JOB_READ: blackbox_read_page(box); break;
    case JOB_NONE: break;
    }
}

void blackbox_start(struct blackbox *box)
{
    memset(box, 0, sizeof *box);
    memset(box->sector, SECTOR_UNREAD, sizeof box->sector);
    box->next_record = 1;
    box->newest_sector = NOR_SECTORS - 1;
    box->erase_ms = ERASE_MS;
    box->freeing = -1;
    box->reading = -1;
    box->state = BLACKBOX_SCANNING;
    blackbox_begin_ring(box);
    if (nor_poll() == NOR_MISSING) {
        health_count(MR_FAULT_NOR_MISSING, 0);
        box->state = BLACKBOX_MISSING;
    }
}

void blackbox_leave_out(struct blackbox *box)
{
    memset(box, 0, sizeof *box);
    box->left_out = true;
    box->freeing = -1;
    box->reading = -1;
}

void blackbox_poll(struct blackbox *box, uint32_t now_ms)
{
    box->now_ms = now_ms;
    if (box->state == BLACKBOX_MISSING)
        return;
    write_end(box);
    for (unsigned n = 0; n < STEPS; n++) {
        enum nor_status status = nor_poll();
        if (status == NOR_BUSY)
            return;
        if (status == NOR_MISSING) {
            health_count(MR_FAULT_NOR_MISSING, 1);
            box->state = BLACKBOX_MISSING;
            return;
        }
        finish_job(box, status == NOR_IDLE);
        if (box->job == JOB_NONE && !begin_job(box))
            return;
    }
}

bool blackbox_idle(const struct blackbox *box)
{
    return box->job == JOB_NONE &&
           (box->state == BLACKBOX_ROLLING || box->state == BLACKBOX_FAILED);
}

enum mr_status blackbox_ready(const struct blackbox *box)
{
    if (box->state == BLACKBOX_MISSING || box->state == BLACKBOX_FAILED)
        return MR_OK;
    if (box->state != BLACKBOX_ROLLING || box->freeing >= 0)
        return MR_WAIT;
    if (blackbox_free_place(box) < 0 || box->ready + box->dirty < BLACKBOX_RESERVE)
        return MR_FULL;
    return box->ready < BLACKBOX_RESERVE ? MR_WAIT : MR_OK;
}

float blackbox_wait_s(const struct blackbox *box)
{
    switch (blackbox_ready(box)) {
    case MR_OK: return 0.0f;
    case MR_WAIT:
        if (box->state == BLACKBOX_SCANNING || box->freeing >= 0)
            return 1.0f;
        if (box->state != BLACKBOX_ROLLING)
            return 0.005f * (float)(box->put - box->got + 1);
        return 0.001f * (float)((BLACKBOX_RESERVE - box->ready) * (box->erase_ms + 1));
    default: return MR_NAN;
    }
}

enum mr_status blackbox_at_rest(const struct blackbox *box)
{
    if (box->state == BLACKBOX_SCANNING || box->state == BLACKBOX_CLOSING || box->freeing >= 0)
        return MR_WAIT;
    return box->state == BLACKBOX_ROLLING && !box->armed ? MR_OK : MR_NOT_NOW;
}

enum mr_status blackbox_free(struct blackbox *box, uint16_t record)
{
    int place = blackbox_find_record(box, record);
    enum mr_status status = blackbox_at_rest(box);
    if (status != MR_OK)
        return status;
    if (place < 0)
        return MR_UNKNOWN;
    if (box->reading == place)
        box->reading = -1;
    box->freeing = place;
    return MR_OK;
}

const struct blackbox_record *blackbox_record(const struct blackbox *box, unsigned i)
{
    return i < BLACKBOX_RECORDS && box->records[i].used ? &box->records[i] : NULL;
}
