/* The black box: every landing complete in NOR memory, whatever becomes of the links and of the
 * supply.
 *
 * Blocks and messages are packed (common/blockpack.h) into pages (common/boxpage.h) in a ring in
 * RAM. From arming until the first edge the ring rolls: it holds the time before, 0.4 s of blocks
 * that do not pack at all, 1.2 s of quiet ones. From the first edge on pages go to the memory as
 * they fill, behind a start page and the configuration as it was when armed.
 *
 * Space. Sectors are used in turn around the memory, so they wear evenly; a record that was not
 * freed is passed over. Freed ones are erased and looked at while idle. Arming waits until
 * BLACKBOX_RESERVE sectors are erased: nothing is erased while a landing is recorded. A block that
 * does not pack takes 466 bits, so 10 s of them and configuration take 151 sectors, and the box's
 * 4064 hold 25 of those and the reserve for the 26th. Twenty-two seconds (landing.h) of real blocks
 * take 120 sectors, of such that do not pack 329: the last 2.8 s of those would not fit beyond the
 * reserve, and would be reported as lost.
 *
 * Every page is read back after it was programmed; one that does not hold goes once more into the
 * next sector, and the rest of its own is left. A sector that does not erase is not used until the
 * next start. Nothing is ever appended to a sector written before a start, so pages torn by a power
 * cut are never touched again. At start the first pages of all sectors are read: 0.1 s of an erased
 * memory, below 1 s of a full one.
 *
 * Pure but for the calls of board.h. Not reentrant; everything is called from the main loop. */
#ifndef MATRIG_FIRMWARE_BLACKBOX_H
#define MATRIG_FIRMWARE_BLACKBOX_H

#include "common/blockpack.h"
#include "common/boxpage.h"
#include "common/catalogue.h"
#include "firmware/board.h"

/* pages, 32 KiB: the worst erase of 0.4 s takes 24 KiB, the worst page program 3 ms */
#define BLACKBOX_RING      128u
/* pages of start and configuration: tables of 8 points for all 22 channels take 6.7 KB, a runway of
 * 512 mats 1.9 KB */
#define BLACKBOX_CONFIG    40u
#define BLACKBOX_RECORDS   64u
#define BLACKBOX_RESERVE   288u /* sectors */
#define BLACKBOX_KEY_PAGES 16u  /* a reader that lost its way is back in so many pages */
#define BLACKBOX_PART      128u /* bytes of a page that travel in one frame */

struct blackbox_record {
    bool used, complete; /* not complete: the power went while it was recorded */
    uint16_t record, landing;
    uint16_t first_sector, last_sector;
    uint32_t first_seq, next_seq;
    uint32_t first_block, blocks, lost;
};

struct blackbox_writer {
    uint8_t *page;
    unsigned bit;  /* of the payload */
    uint32_t held; /* the bits of a word that is not whole yet: they are not in the page */
};

struct blackbox {
    /* MISSING: no memory, or not configured: landings are taken without it; READY: idle or armed;
     * CLOSING: a landing is over, its last pages are on their way; FAILED: page after page does not
     * hold: given up until the next start */
    enum mr_box_condition state;
    bool left_out;   /* by the configuration */
    uint32_t now_ms; /* block index */

    /* a record's place in `records`, or what else it is (enum in blackbox.c) */
    uint8_t sector[NOR_SECTORS];
    unsigned ready, dirty, bad; /* sectors erased, to be erased, not to be used */
    struct blackbox_record records[BLACKBOX_RECORDS];
    uint16_t next_record;
    uint32_t next_seq;
    unsigned newest_sector; /* written last: kept until another is, for the numbers in it */

    /* What is being put together. */
    struct mr_pack pack;
    bool key_due;
    uint8_t ring[BLACKBOX_RING][MR_BOXPAGE];
    uint32_t put, got; /* pages closed, pages written or dropped; page `put` is open */
    uint8_t config[BLACKBOX_CONFIG][MR_BOXPAGE];
    unsigned config_put, config_got;
    bool configuring;
    struct blackbox_writer stream, meta;
    struct mr_boxpage_start start;
    struct mr_boxpage_end end;
    bool armed;
    bool first_open;       /* no key yet: the record's first block is still to come */
    bool end_written;      /* the end page is in the ring */
    uint32_t stored;       /* blocks ever packed */
    uint32_t first_stored; /* of them, before the record's first */
    uint32_t last_block;
    uint32_t key_block[BLACKBOX_RING], key_stored[BLACKBOX_RING]; /* at the first key of a page */
    bool key_valid[BLACKBOX_RING];

    /* What the memory is doing. */
    unsigned job, job_sector, job_page, tries;
    uint8_t buffer[MR_BOXPAGE];
    unsigned place;     /* of the record being written */
    unsigned head;      /* sector being written, or where to look for the next */
    unsigned head_page; /* NOR_PAGES_PER_SECTOR: none open */
    unsigned failures;  /* pages in a row that did not hold */
    uint32_t erase_begun_ms, erase_ms;
    bool waits;  /* for an erase of the runway (app.c) */
    int freeing; /* place of a record; -1 */
    unsigned scan_sector, scan_place;
    bool freed[BLACKBOX_RECORDS];

    /* What is being read out. */
    int reading; /* place of a record; -1 */
    uint32_t read_page;
    unsigned read_sector, read_cursor, read_tries;
    bool read_ready, read_over; /* `read_buffer` holds page read_page; there is none behind it */
    unsigned read_part;
    uint8_t read_buffer[MR_BOXPAGE];
};

void blackbox_start(struct blackbox *box);
/* None is configured: nothing is put together, and the memory is left alone. */
void blackbox_leave_out(struct blackbox *box);
/* Go on with what the memory is doing, as far as it goes without waiting. `now_ms`: the newest
 * block. */
void blackbox_poll(struct blackbox *box, uint32_t now_ms);

/* It has no use for the memory now. */
bool blackbox_idle(const struct blackbox *box);

/* MR_OK: a landing may be armed (or there is no memory: it is armed without); MR_WAIT: after
 * blackbox_wait_s; MR_FULL: when records were freed. */
enum mr_status blackbox_ready(const struct blackbox *box);
/* Seconds until blackbox_ready, as far as known; NaN: not by waiting. */
float blackbox_wait_s(const struct blackbox *box);

/* Armed: what is known of the landing, then its configuration message by message. */
void blackbox_arm(struct blackbox *box, const struct mr_boxpage_start *start);
void blackbox_configure(struct blackbox *box, uint16_t id, const uint8_t *payload, size_t length);
/* Each block, in order, recording or not. A loss shows as a jump of the index. */
void blackbox_block(struct blackbox *box, const struct mr_block *block);
/* A message worth keeping. */
void blackbox_note(struct blackbox *box, uint16_t id, const uint8_t *payload, size_t length);
/* The first edge: from here on it is written. */
void blackbox_trigger(struct blackbox *box, uint32_t block);
/* The landing is over, or was broken off. Nothing happens when none was triggered. */
void blackbox_finish(struct blackbox *box);

/* Whether records can be listed, read and freed. MR_WAIT: soon, it is looking through its memory,
 * closing a record or freeing one; MR_NOT_NOW: a landing is armed or going on, or there is no
 * memory. */
enum mr_status blackbox_at_rest(const struct blackbox *box);
/* MR_OK; MR_UNKNOWN: no such record; MR_WAIT, MR_NOT_NOW: see above. */
enum mr_status blackbox_free(struct blackbox *box, uint16_t record);
/* Read a record out from page `page` on. Status as above. */
enum mr_status blackbox_read(struct blackbox *box, uint16_t record, uint32_t page);
enum blackbox_part { BLACKBOX_NO_PART, BLACKBOX_A_PART, BLACKBOX_LAST_READ };
/* The next half page, when it is there. BLACKBOX_LAST_READ: the record is over, `*page` is the
 * number of its pages. */
enum blackbox_part blackbox_take_part(struct blackbox *box, uint16_t *record, uint16_t *page,
                                      uint8_t *part, const uint8_t **bytes);
/* Record in place i, NULL when there is none. */
const struct blackbox_record *blackbox_record(const struct blackbox *box, unsigned i);

#endif
