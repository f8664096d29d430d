#include "firmware/slowlog.h"

#include <string.h>

#include "common/wire.h"
#include "firmware/health.h"
#include "firmware/schedule.h"

enum job { JOB_NONE, JOB_SCAN, JOB_CHECK, JOB_PROGRAM, JOB_VERIFY, JOB_ERASE, JOB_LOOK, JOB_READ };

#define PAGES       NOR_PAGES_PER_SECTOR
#define RING_PAGES  (SLOWLOG_SECTORS * PAGES)
#define READ_TRIES  4u
#define PLACE_TRIES 8u /* for a row that does not hold */
#define ERASE_TRIES 2u
#define COUNT_LEAST 2u /* readings that make a mean */
#define NEWS_FAILED 5u /* detail of MR_FAULT_NOR_FAILED */
_Static_assert(SLOWLOG_SECTORS <= 32, "a bit each");
_Static_assert(SLOWLOG_AHEAD + 2 <= SLOWLOG_SECTORS, "there must be room for rows");

static uint32_t address_of(unsigned page)
{
    return NOR_SECTORS * NOR_SECTOR + page * NOR_PAGE;
}

static unsigned sector_of(unsigned place)
{
    return place / SLOWLOG_ROWS_PER_SECTOR;
}
static unsigned page_of(unsigned place)
{
    return place / SLOWLOG_ROWS_PER_PAGE;
}

static uint8_t *row_at(struct slowlog *log, unsigned place)
{
    return log->buffer + MR_SLOWROW * (place % SLOWLOG_ROWS_PER_PAGE);
}

/* --- the row --- */

void slowlog_start(struct slowlog *log)
{
    memset(log, 0, sizeof *log);
    log->boot = 1;
    log->next_seq = 1;
    log->part = MR_SLOWROW_PARTS;
    log->blank = UINT32_MAX >> (32u - SLOWLOG_SECTORS);
    log->missing = nor_poll() == NOR_MISSING;
}

void slowlog_forget(struct slowlog *log)
{
    log->blocks = 0;
    memset(log->sum, 0, sizeof log->sum);
    memset(log->count, 0, sizeof log->count);
}

static void add(struct slowlog *log, unsigned first, const float *values, unsigned count)
{
    for (unsigned i = 0; i < count; i++) {
        if (__builtin_isnan(values[i]))
            continue;
        log->sum[first + i] += values[i];
        log->count[first + i]++;
    }
}

/* Half of the blocks at least, or it is missing. */
static float mean(const struct slowlog *log, unsigned i)
{
    unsigned least = log->blocks / 2 > COUNT_LEAST ? log->blocks / 2 : COUNT_LEAST;
    return log->count[i] >= least ? log->sum[i] / (float)log->count[i] : MR_NAN;
}

static void make_row(struct slowlog *log, const struct slowlog_block *block)
{
    struct mr_slowrow row = {.block = block->index,
                             .faults = health_faults(),
                             .temperature_c = block->temperature_c,
                             .state = block->state};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        row.displacement_in[i] = mean(log, i);
    for (unsigned i = 0; i < MR_GAGES; i++)
        row.tension_lb[i] = mean(log, MR_TRANSDUCERS + i);
    if (log->missing || log->left_out) {
        /* told at once; one that comes while another is told is not */
        log->news = row;
        log->has_news = true;
        return;
    }
    if (log->put - log->got == SLOWLOG_WAITING) {
        health_count(MR_FAULT_NOR_FAILED, NEWS_FAILED);
        log->got++;
        log->next_seq++; /* its number shows that it is missing */
    }
    log->waiting[log->put++ % SLOWLOG_WAITING] = row;
}

static bool is_since(uint32_t index, uint32_t when)
{
    return (int32_t)(index - when) >= 0;
}

/* The first block after this one in which a row is due. */
static uint32_t next_row(uint32_t index)
{
    return index + 1u + BLOCKS_UNTIL(SLOW_ROW, index + 1u);
}

void slowlog_block(struct slowlog *log, const struct slowlog_block *block)
{
    if (!log->begun)
        log->due = next_row(block->index);
    log->begun = true;
    if (!is_since(block->index, log->due - SLOWLOG_MEAN_BLOCKS))
        return;
    if (!block->quiet) { /* as soon as the landing is over */
        slowlog_forget(log);
        log->due = block->index + SLOWLOG_MEAN_BLOCKS;
        return;
    }
    log->blocks++;
    add(log, 0, block->displacement_in, MR_TRANSDUCERS);
    add(log, MR_TRANSDUCERS, block->tension_lb, MR_GAGES);
    if (!is_since(block->index, log->due))
        return;
    make_row(log, block);
    slowlog_forget(log);
    log->due = next_row(block->index);
}

/* --- the memory --- */

static void begin(struct slowlog *log, enum job job, unsigned page)
{
    log->job = job;
    log->page = page;
    if (job != JOB_PROGRAM && job != JOB_ERASE)
        nor_begin_read(address_of(page), log->buffer, NOR_PAGE);
}

static void set_bit(uint32_t *bits, unsigned sector, bool on)
{
    *bits = on ? *bits | 1u << sector : *bits & ~(1u << sector);
}

static bool has_bit(uint32_t bits, unsigned sector)
{
    return bits >> sector & 1u;
}

_Static_assert(MR_SLOWROW % 4 == 0 && NOR_PAGE % 4 == 0, "whole words");
static unsigned next_sector(const struct slowlog *log, unsigned sector)
{
    for (unsigned n = 1; n < SLOWLOG_SECTORS; n++) {
        unsigned next = (sector + n) % SLOWLOG_SECTORS;
        if (!has_bit(log->bad, next))
            return next;
    }
    return sector;
}

static void next_place(struct slowlog *log)
{
    log->ahead_erased = false;
    log->place++;
    if (log->place % SLOWLOG_ROWS_PER_SECTOR == 0)
        log->place = SLOWLOG_ROWS_PER_SECTOR * next_sector(log, sector_of(log->place - 1));
}

static void scan_ends(struct slowlog *log)
{
    log->scanned = true;
    if (log->newest_seq) {
        log->next_seq += log->newest_seq;
        log->place = log->newest_place;
        next_place(log);
    }
}

/* A page whose rows are not all whole is read again: a mistake in reading is not taken for a row
 * that the power tore. */
static void scan_page(struct slowlog *log)
{
    unsigned sector = log->page / PAGES;
    struct mr_slowrow row;
    unsigned rows = mr_is_blank(log->buffer, NOR_PAGE) ? 0 : SLOWLOG_ROWS_PER_PAGE, whole = 0,
             torn = 0;
    for (unsigned i = 0; i < rows; i++) {
        enum mr_status status = mr_slowrow_get(&row, log->buffer + MR_SLOWROW * i);
        whole += status == MR_OK;
        torn += status == MR_CRC;
    }
    if (torn && ++log->tries < READ_TRIES) {
        begin(log, JOB_SCAN, log->page);
        return;
    }
    log->tries = 0;
    if (whole + torn)
        set_bit(&log->blank, sector, false);
    log->rows_in[sector] = (uint8_t)(log->rows_in[sector] + whole);
    for (unsigned i = 0; i < rows; i++) {
        if (mr_slowrow_get(&row, log->buffer + MR_SLOWROW * i) == MR_OK &&
            row.seq > log->newest_seq) {
            log->newest_seq = row.seq;
            log->newest_place = log->page * SLOWLOG_ROWS_PER_PAGE + i;
            log->boot = (uint8_t)(row.boot + 1);
        }
    }
    if (++log->page == RING_PAGES)
        scan_ends(log);
}

static void row_ends(struct slowlog *log, bool kept)
{
    const struct mr_slowrow *row = &log->waiting[log->got % SLOWLOG_WAITING];
    if (kept) {
        log->news = *row;
        log->has_news = true;
        log->rows_in[sector_of(log->place)]++;
    } else {
        health_count(MR_FAULT_NOR_FAILED, NEWS_FAILED);
    }
    log->next_seq++;
    log->got++;
    log->tries = 0;
}

/* The place was blank when it was looked at: the row alone, ones leave the rest of the page as it
 * is. */
static void program_row(struct slowlog *log)
{
    struct mr_slowrow *row = &log->waiting[log->got % SLOWLOG_WAITING];
    if (!mr_is_blank(row_at(log, log->place), MR_SLOWROW)) { /* torn when the power went */
        next_place(log);
        return;
    }
    row->seq = log->next_seq;
    row->boot = log->boot;
    memset(log->buffer, 0xff, NOR_PAGE);
    mr_slowrow_put(row, row_at(log, log->place));
    set_bit(&log->blank, sector_of(log->place), false);
    begin(log, JOB_PROGRAM, page_of(log->place));
    nor_begin_program(address_of(log->page), log->buffer);
}

static void verify_row(struct slowlog *log)
{
    uint8_t wanted[MR_SLOWROW];
    mr_slowrow_put(&log->waiting[log->got % SLOWLOG_WAITING], wanted);
    bool holds = memcmp(wanted, row_at(log, log->place), MR_SLOWROW) == 0;
    if (holds || ++log->tries == PLACE_TRIES)
        row_ends(log, holds);
    next_place(log);
}

static void look(struct slowlog *log, bool done)
{
    unsigned sector = log->page / PAGES;
    if (done && mr_is_blank(log->buffer, NOR_PAGE)) {
        if ((log->page + 1) % PAGES) {
            begin(log, JOB_LOOK, log->page + 1);
            return;
        }
        set_bit(&log->blank, sector, true);
    } else if (++log->tries < ERASE_TRIES) {
        return; /* it is not blank: erased again */
    } else {
        health_count(MR_FAULT_NOR_FAILED, NEWS_FAILED);
        set_bit(&log->bad, sector, true);
        if (sector == sector_of(log->place))
            log->place = SLOWLOG_ROWS_PER_SECTOR * next_sector(log, sector);
    }
    log->tries = 0;
}

static void finish_job(struct slowlog *log, bool done)
{
    enum job job = (enum job)log->job;
    log->job = JOB_NONE;
    switch (job) {
    case JOB_SCAN: scan_page(log); break;
    case JOB_CHECK: program_row(log); break;
    case JOB_PROGRAM: begin(log, JOB_VERIFY, log->page); break;
    case JOB_VERIFY: verify_row(log); break;
    case JOB_ERASE:
        if (done)
            begin(log, JOB_LOOK, log->page);
        else
            look(log, false);
        break;
    case JOB_LOOK: look(log, true); break;
    case JOB_READ: log->page_read = true; break;
    case JOB_NONE: break;
    }
}

bool slowlog_busy(struct slowlog *log)
{
    if (log->job == JOB_NONE)
        return false;
    enum nor_status status = nor_poll();
    if (status == NOR_MISSING) {
        log->missing = true;
        log->job = JOB_NONE;
        log->reading = false;
    } else if (status != NOR_BUSY) {
        finish_job(log, status == NOR_IDLE);
    }
    return log->job != JOB_NONE;
}

bool slowlog_erasing(const struct slowlog *log)
{
    return log->job == JOB_ERASE;
}

/* A row begins a sector only when that is erased. */
static bool has_room(const struct slowlog *log)
{
    return log->place % SLOWLOG_ROWS_PER_SECTOR || has_bit(log->blank, sector_of(log->place));
}

/* The sector of the next row when that would be its first, and those ahead of it. SLOWLOG_SECTORS:
 * all are erased. */
static unsigned sector_to_erase(const struct slowlog *log)
{
    unsigned sector = sector_of(log->place);
    if (!has_room(log))
        return sector;
    for (unsigned n = 0; n < SLOWLOG_AHEAD; n++) {
        sector = next_sector(log, sector);
        if (!has_bit(log->blank, sector))
            return sector;
    }
    return SLOWLOG_SECTORS;
}

static void begin_erase(struct slowlog *log, unsigned sector)
{
    log->rows_in[sector] = 0;
    begin(log, JOB_ERASE, sector * PAGES);
    nor_begin_erase(address_of(log->page));
}

static void begin_read_page(struct slowlog *log)
{
    log->read_row = 0;
    log->read_page = (log->read_page + 1) % RING_PAGES;
    if (log->read_pages++ == RING_PAGES) {
        log->reading = false;
        log->end_due = true;
        return;
    }
    begin(log, JOB_READ, log->read_page);
}

void slowlog_begin(struct slowlog *log, bool may_erase)
{
    if (log->missing || log->page_read) /* the buffer holds rows to be told */
        return;
    if (!log->scanned) {
        begin(log, JOB_SCAN, log->page);
        return;
    }
    unsigned sector = may_erase && !log->ahead_erased ? sector_to_erase(log) : SLOWLOG_SECTORS;
    log->ahead_erased |= may_erase && sector == SLOWLOG_SECTORS;
    if (log->put != log->got && !log->has_news && has_room(log))
        begin(log, JOB_CHECK, page_of(log->place));
    else if (sector != SLOWLOG_SECTORS)
        begin_erase(log, sector);
    else if (log->reading)
        begin_read_page(log);
}

/* --- reading out, and telling --- */

enum mr_status slowlog_read(struct slowlog *log, uint32_t seq)
{
    if (log->missing || log->left_out)
        return MR_NOT_NOW;
    if (!log->scanned)
        return MR_WAIT;
    log->reading = true;
    log->page_read = false;
    log->wanted = seq;
    log->read_pages = 0;
    log->read_page = (sector_of(log->place) + 1) * PAGES - 1; /* the next is the oldest */
    return MR_OK;
}

void slowlog_read_stop(struct slowlog *log)
{
    log->reading = false;
    log->page_read = false;
}

unsigned slowlog_rows(const struct slowlog *log)
{
    unsigned rows = 0;
    for (unsigned i = 0; i < SLOWLOG_SECTORS; i++)
        rows += log->rows_in[i];
    return rows;
}

/* The next wanted row of the page that was read. */
static bool take_read(struct slowlog *log)
{
    while (log->page_read && log->read_row < SLOWLOG_ROWS_PER_PAGE) {
        const uint8_t *bytes = log->buffer + MR_SLOWROW * log->read_row++;
        if (mr_slowrow_get(&log->telling, bytes) == MR_OK && log->telling.seq >= log->wanted) {
            log->part = 0;
            return true;
        }
    }
    log->page_read = false;
    return false;
}

size_t slowlog_take_part(struct slowlog *log, uint16_t *id, uint8_t payload[MR_MESSAGE_MAX])
{
    if (log->part == MR_SLOWROW_PARTS) {
        if (log->has_news) {
            log->telling = log->news;
            log->has_news = false;
            log->part = 0;
        } else if (!take_read(log)) {
            if (!log->end_due)
                return 0;
            log->end_due = false;
            *id = MR_ID_SLOW_END;
            return mr_slow_end_put(&(struct mr_slow_end){.next_seq = log->next_seq,
                                                         .rows = (uint16_t)slowlog_rows(log),
                                                         .boot = log->boot},
                                   payload);
        }
    }
    return mr_slowrow_part(&log->telling, log->part++, id, payload);
}
