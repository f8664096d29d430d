/* The black box stores every landing completely in NOR memory, independent of the links and across
 * power failures.
 *
 * Blocks and messages are packed (common/blockpack.h) into pages (common/boxpage.h) in a ring in
 * RAM. From arming until the first edge the ring is overwritten continuously. It holds the last 0.4
 * s if no block can be compressed, or 1.2 s of quiet blocks. From the first edge on, full pages are
 * written to the memory, after a start page and the configuration at the time of arming.
 *
 * Space: sectors are used in rotation, so that they wear uniformly; records that were not freed are
 * skipped. Freed sectors are erased and checked while idle. Nothing is erased while a landing is
 * recorded, so arming waits until BLACKBOX_RESERVE_SECTORS sectors are erased. An incompressible
 * block takes 466 bits; 10 s of such blocks and the configuration take 151 sectors. The 4064
 * sectors of the box hold 25 such landings plus the reserve for the 26th. The maximum of 22 s
 * (landing.h) takes 120 sectors with real blocks, or 329 with incompressible blocks; the last 2.8 s
 * of the latter would exceed the reserve and be reported as lost.
 *
 * Every page is read back after programming. A page that fails this check is written again into the
 * next sector, and the rest of its sector is left unused. A sector that cannot be erased is not
 * used until the next start. Nothing is appended to a sector that was written before the last
 * start, so pages damaged by a power failure are not touched again. At start the first pages of all
 * sectors are read, which takes 0.1 s for an erased memory and less than 1 s for a full one.
 *
 * Pure except for the calls of board.h. Not reentrant; call all functions from the main loop. */
#ifndef MATRIG_FIRMWARE_BLACKBOX_H
#define MATRIG_FIRMWARE_BLACKBOX_H

#include "common/blockpack.h"
#include "common/boxpage.h"
#include "common/catalogue.h"
#include "firmware/board.h"

/* size in pages (32 KiB): during the longest erase (0.4 s) 24 KiB arrive; programming a page takes
 * 3 ms at most */
#define BLACKBOX_RING_PAGES         128u
/* pages for start page and configuration: tables of 8 points for all 22 channels take 6.7 KB, a
 * runway of 512 mats takes 1.9 KB */
#define BLACKBOX_CONFIG_PAGES       40u
#define BLACKBOX_RECORDS_MAX        64u
#define BLACKBOX_RESERVE_SECTORS    288u /* sectors */
/* maximum number of pages between two keys, at which a reader can begin to decode */
#define BLACKBOX_KEY_INTERVAL_PAGES 16u
#define BLACKBOX_PART_BYTES         128u /* bytes of a page that one frame carries */

struct blackbox_record {
    bool is_used, is_complete; /* is_complete false: the power failed during recording */
    uint16_t record, landing;
    uint16_t first_sector, last_sector;
    uint32_t first_seq, next_seq;
    uint32_t first_block, stored_blocks, lost_blocks;
};

struct blackbox_writer {
    uint8_t *page;
    unsigned next_bit;     /* number of the next bit of the payload */
    uint32_t pending_bits; /* bits of the last, incomplete word, which is not in the page yet */
};

struct blackbox {
    /* MISSING: no memory, or not configured; landings are recorded without it. READY: idle or
     * armed. CLOSING: writing the last pages of a landing. FAILED: too many pages failed in a row,
     * or the memory stayed busy; the box is not used until the next start. */
    enum mr_box_condition state;
    bool is_stuck;    /* the state is FAILED because the memory stayed busy */
    bool is_disabled; /* the configuration has no black box */
    uint32_t now_ms;  /* index of the newest block */

    /* for each sector: index in `records` of its record, or its state (enum in blackbox.c) */
    uint8_t sector_state[NOR_SECTORS];
    unsigned ready_sectors, dirty_sectors,
        bad_sectors; /* number of sectors that are erased, to be erased, and unusable */
    struct blackbox_record records[BLACKBOX_RECORDS_MAX];
    uint16_t next_record;
    uint32_t next_seq;
    /* sector written last; not erased until a newer one is written, because the next start needs
     * the numbers in it */
    unsigned newest_sector;

    /* The record being assembled. */
    struct mr_pack pack;
    bool is_key_due;
    uint8_t ring[BLACKBOX_RING_PAGES][MR_BOXPAGE_BYTES];
    uint32_t pages_closed;  /* number of closed pages; the page with this number is open */
    uint32_t pages_written; /* number of pages written or dropped */
    uint8_t config_pages[BLACKBOX_CONFIG_PAGES][MR_BOXPAGE_BYTES];
    unsigned config_pages_closed, config_pages_written;
    bool is_configuring;
    struct blackbox_writer stream_writer, config_writer;
    struct mr_boxpage_start_page start;
    struct mr_boxpage_end end;
    bool is_armed;
    /* the first block of the record, which must begin with a key, has not been packed yet */
    bool is_first_block_pending;
    bool is_end_written;         /* the end page has been put into the ring */
    uint32_t stored_count;       /* number of blocks packed since start */
    uint32_t first_stored_count; /* number of blocks packed before the record's first block */
    uint32_t last_block;
    /* block index, and number of blocks packed since start, at the first key of each page */
    uint32_t key_block[BLACKBOX_RING_PAGES], key_stored_count[BLACKBOX_RING_PAGES];
    bool has_key[BLACKBOX_RING_PAGES];

    /* Operation of the memory in progress. */
    unsigned job, job_sector, job_page, tries;
    uint8_t buffer[MR_BOXPAGE_BYTES];
    unsigned record_index; /* index in `records` of the record being written */
    /* sector being written, or sector from which the search for the next one starts */
    unsigned write_sector;
    unsigned write_page; /* page being written; NOR_PAGES_PER_SECTOR: no sector is open */
    unsigned failures;   /* number of consecutive pages that failed the read-back */
    uint32_t erase_start_ms, erase_ms;
    bool is_waiting_for_erase; /* waiting for an erase by the runway store (app.c) */
    int freeing_index;         /* index of the record being freed; -1: none */
    unsigned scan_sector, scan_record_index;
    bool is_freed[BLACKBOX_RECORDS_MAX];

    /* Record being read out. */
    int reading_index; /* index of the record; -1: none */
    uint32_t read_page;
    unsigned read_sector, read_cursor, read_tries;
    /* is_page_ready: `read_buffer` has page read_page; has_read_all: the record has no further
     * pages */
    bool is_page_ready, has_read_all;
    unsigned read_part;
    uint8_t read_buffer[MR_BOXPAGE_BYTES];
};

void blackbox_start(struct blackbox *box);
/* True if there is a memory that executes commands. */
bool blackbox_has_memory(const struct blackbox *box);
/* Call if the configuration has no black box: nothing is recorded, and the memory is not
 * accessed. */
void blackbox_disable(struct blackbox *box);
/* Continues the operation of the memory, without waiting. `now_ms`: index of the newest block. */
void blackbox_poll(struct blackbox *box, uint32_t now_ms);

/* True if the black box does not need the memory now. */
bool blackbox_is_idle(const struct blackbox *box);

/* MR_OK: a landing may be armed (it is recorded without the box if there is no memory); MR_WAIT:
 * call again after blackbox_wait_s; MR_FULL: records must be freed first. */
enum mr_status blackbox_check_ready(const struct blackbox *box);
/* Expected seconds until blackbox_check_ready returns MR_OK; NaN: waiting does not help. */
float blackbox_wait_s(const struct blackbox *box);

/* Call at arming with the facts of the landing; then record its configuration, one call per
 * message. */
void blackbox_arm(struct blackbox *box, const struct mr_boxpage_start_page *start);
void blackbox_record_configuration(struct blackbox *box, uint16_t id, const uint8_t *payload,
                                   size_t length);
/* Call for each block, in order, also while nothing is recorded. A jump of the index means lost
 * blocks. */
void blackbox_on_block(struct blackbox *box, const struct mr_block *block);
/* Records a message. */
void blackbox_record_message(struct blackbox *box, uint16_t id, const uint8_t *payload,
                             size_t length);
/* Call at the first edge: writing to the memory starts here. */
void blackbox_trigger(struct blackbox *box, uint32_t block);
/* Call when the landing has ended or was aborted. Has no effect if blackbox_trigger was not called
 * for it. */
void blackbox_finish(struct blackbox *box);

/* MR_OK: records can be listed, read and freed. MR_WAIT: the box is scanning its memory, closing a
 * record or freeing one; try again soon. MR_NOT_NOW: a landing is armed or in progress, or there is
 * no memory. */
enum mr_status blackbox_check_access(const struct blackbox *box);
/* Frees a record. MR_UNKNOWN: no such record; MR_WAIT, MR_NOT_NOW: as blackbox_check_access. */
enum mr_status blackbox_free(struct blackbox *box, uint16_t record);
/* Starts reading out a record at page `page`. Status as blackbox_free. */
enum mr_status blackbox_read(struct blackbox *box, uint16_t record, uint32_t page);
enum blackbox_part { BLACKBOX_PART_NONE, BLACKBOX_PART_READY, BLACKBOX_PART_END };
/* Returns the next half page if it is ready. BLACKBOX_PART_END: end of the record; `*page` is its
 * number of pages. */
enum blackbox_part blackbox_get_part(struct blackbox *box, uint16_t *record, uint16_t *page,
                                     uint8_t *part, const uint8_t **bytes);
/* Record with index i in `records`, or NULL. */
const struct blackbox_record *blackbox_record_at(const struct blackbox *box, unsigned i);

#endif
