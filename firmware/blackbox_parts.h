/* What the parts of the black box share: blackbox.c (the memory's work, one job at a time),
 * blackbox_stream.c (pages put together), blackbox_scan.c (what is there at start), blackbox_read.c
 * (reading out). Nobody else includes it. */
#ifndef MATRIG_FIRMWARE_BLACKBOX_PARTS_H
#define MATRIG_FIRMWARE_BLACKBOX_PARTS_H

#include "firmware/blackbox.h"

/* A sector that belongs to no record. */
enum {
    SECTOR_BAD = 0xf9, /* does not program or erase */
    SECTOR_UNREAD = 0xfa,
    /* dirty, and carries the mark that its record was freed: erased after the others */
    SECTOR_LAST = 0xfb,
    SECTOR_DIRTY = 0xfc,
    SECTOR_FOREIGN = 0xfd, /* holds pages of more records than there are places: left alone */
    SECTOR_BLANK = 0xfe,   /* looked erased at start */
    SECTOR_ERASED = 0xff,  /* erased and looked at */
};
_Static_assert(BLACKBOX_RECORDS <= SECTOR_BAD, "a place must not look like a state");

enum job {
    JOB_NONE,
    JOB_SCAN_HEAD,
    JOB_SCAN_PAGE,
    JOB_SCAN_WALK,
    JOB_SCAN_START,
    JOB_PROGRAM,
    JOB_VERIFY,
    JOB_ERASE,
    JOB_LOOK,
    JOB_MARK_READ,
    JOB_MARK,
    JOB_MARK_CHECK,
    JOB_READ,
};

#define PAGES      NOR_PAGES_PER_SECTOR
#define READ_TRIES 4u

/* The memory's work. `buffer` takes what a job reads, `read_buffer` what JOB_READ does. */
uint32_t blackbox_address(unsigned sector, unsigned page);
void blackbox_begin_job(struct blackbox *box, enum job job, unsigned sector, unsigned page);
void blackbox_begin_read(struct blackbox *box, enum job job, unsigned sector, unsigned page);
void blackbox_set_sector(struct blackbox *box, unsigned sector, uint8_t state);
/* The next sector from `from` on, around the memory, whose state lies in [low, high]; NOR_SECTORS:
 * none. */
unsigned blackbox_find_sector(const struct blackbox *box, unsigned from, uint8_t low, uint8_t high);
/* A place for a record, and the place of one; -1: none. */
int blackbox_free_place(const struct blackbox *box);
int blackbox_find_record(const struct blackbox *box, uint16_t record);
/* Its sectors are to be erased. */
void blackbox_drop_record(struct blackbox *box, unsigned place);

/* Pages put together: an empty ring; the ring from its first key on; the end tag, and ones to the
 * end of the page. */
void blackbox_begin_ring(struct blackbox *box);
void blackbox_begin_at_key(struct blackbox *box);
void blackbox_flush(struct blackbox *box, struct blackbox_writer *writer);
/* The ring forgets its oldest page when it is full: nothing is written. */
static inline bool blackbox_is_rolling(const struct blackbox *box)
{
    return box->state == BLACKBOX_ROLLING || box->state == BLACKBOX_SCANNING;
}

/* Steps of looking through the memory at start, each when its job is done. False: it is over. */
bool blackbox_begin_scan(struct blackbox *box);
void blackbox_scan_head(struct blackbox *box);
void blackbox_scan_page(struct blackbox *box);
void blackbox_scan_walk(struct blackbox *box);
void blackbox_scan_start(struct blackbox *box);

/* Reading out: the next page of the record, and what came of it. */
bool blackbox_begin_read_out(struct blackbox *box);
void blackbox_read_page(struct blackbox *box);

#endif
