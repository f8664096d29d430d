/* The slow log: a row a minute through the night - mat temperature, where the mat lies, what the
 * bands hold - in the last sectors of the black box's memory.
 *
 * A row (common/slowrow.h) is made at each full minute of the block index while no landing is going
 * on, of the means of its last four seconds, and told when it is kept (or at once when there is no
 * memory, or none is configured). Rows fill the pages of a ring of SLOWLOG_SECTORS sectors, four to
 * a page; SLOWLOG_AHEAD of them ahead of the newest row are kept erased, so that rows go on for
 * four hours of standing armed, when nothing is erased. So 25 to 26 sectors of 64 rows are held:
 * 26.7 hours at least.
 *
 * The black box comes first: norshare.h lets the log begin an operation only when the box has none,
 * and an erase only when no landing is armed or going on. A row is read back after it was
 * programmed and goes once more into the next place when it does not hold. What the power tears has
 * no valid CRC and is passed over; rows before it are not touched. Looking through the sectors at
 * start takes some 0.6 s; rows made meanwhile wait.
 *
 * Pure but for the calls of nor.h. */
#ifndef MATRIG_FIRMWARE_SLOWLOG_H
#define MATRIG_FIRMWARE_SLOWLOG_H

#include <stdbool.h>

#include "common/slowrow.h"
#include "firmware/nor.h"

#define SLOWLOG_AHEAD           4u
/* rows that wait for the memory: four minutes of erasing for the box */
#define SLOWLOG_WAITING         4u
#define SLOWLOG_MEAN_BLOCKS     4096u
#define SLOWLOG_ROWS_PER_PAGE   (NOR_PAGE / MR_SLOWROW)
#define SLOWLOG_ROWS_PER_SECTOR (NOR_SECTOR / MR_SLOWROW)

/* What a block adds. */
struct slowlog_block {
    uint32_t index;
    const float *displacement_in; /* MR_TRANSDUCERS; NaN: missing */
    const float *tension_lb;      /* MR_GAGES */
    float temperature_c;
    uint8_t state; /* as in the message slow_state */
    bool quiet;    /* no landing is going on */
};

struct slowlog {
    /* the row in the making */
    bool begun;
    uint32_t due;
    unsigned blocks;
    float sum[MR_TRANSDUCERS + MR_GAGES];
    uint16_t count[MR_TRANSDUCERS + MR_GAGES];

    struct mr_slowrow waiting[SLOWLOG_WAITING];
    unsigned put, got;
    struct mr_slowrow news; /* kept, to be told */
    bool has_news;

    /* the memory */
    bool missing, scanned;
    /* by the configuration, with the black box: the memory is left alone */
    bool left_out;
    unsigned job, page, tries; /* page: within the ring */
    uint8_t buffer[NOR_PAGE];
    uint32_t next_seq;
    uint8_t boot;
    /* bit per sector of the ring: erased and looked at; does not erase */
    uint32_t blank, bad;
    bool ahead_erased; /* nothing to erase until the next row or sector */
    uint8_t rows_in[SLOWLOG_SECTORS];
    unsigned place;      /* of the next row: sector * SLOWLOG_ROWS_PER_SECTOR + row */
    uint32_t newest_seq; /* while scanning */
    unsigned newest_place;

    /* being read out */
    bool reading, page_read;
    uint32_t wanted;
    unsigned read_pages; /* of the ring, done */
    unsigned read_page, read_row;

    struct mr_slowrow telling;
    unsigned part; /* of it, to be told; MR_SLOWROW_PARTS: none */
    bool end_due;
};

void slowlog_start(struct slowlog *log);
void slowlog_block(struct slowlog *log, const struct slowlog_block *block);
/* Readings of before are of another zero, or another configuration: no mean goes over both. */
void slowlog_forget(struct slowlog *log);

/* The memory. An operation that was begun: go on with it; true: it still holds the memory. */
bool slowlog_busy(struct slowlog *log);
/* Begin the next one, if any. */
void slowlog_begin(struct slowlog *log, bool may_erase);
bool slowlog_erasing(const struct slowlog *log);

/* Tell all rows from number `seq` on. MR_OK; MR_WAIT: it is still being looked through; MR_NOT_NOW:
 * no memory, or none is configured. */
enum mr_status slowlog_read(struct slowlog *log, uint32_t seq);
void slowlog_read_stop(struct slowlog *log);
/* The next message to be said. Its length; 0: none. */
size_t slowlog_take_part(struct slowlog *log, uint16_t *id, uint8_t payload[MR_MESSAGE_MAX]);
unsigned slowlog_rows(const struct slowlog *log);

#endif
