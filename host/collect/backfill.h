/* Adds a record of the black box to the campaign database: the parts of its landing that are
 * missing there. */
#ifndef MATRIG_HOST_BOXFILL_H
#define MATRIG_HOST_BOXFILL_H

#include "common/boxpage.h"
#include "host/store/store.h"

/* Bit in `links` of a row that came from the black box; 1 and 2 are CAN and serial. */
#define BACKFILL_LINK_BIT 4

struct backfill {
    int64_t run;
    bool is_new_landing; /* no landing in the database matched, so a new one was added */
    int64_t block_count; /* number of blocks in the record */
    int64_t filled_blocks, filled_edges;
    /* number of blocks missing between the first and the last one: lost by the board, or on pages
     * that could not be read */
    int64_t missing_blocks;
};

/* Adds a record. `run` 0: the landing with the same board, number and arming time, or a new landing
 * if there is none. Blocks and edges that the database has are not changed. Added blocks belong to
 * a separate session, ended by "black box". An event `blackbox` records the transfer (code: record,
 * detail: blocks filled, value: blocks absent). Configuration, calibration, results, bands, quality
 * and events are stored as a log stores them. MR_MALFORMED: the start page of the record is missing
 * or has another layout. */
enum mr_status backfill_store_record(struct store *store, const char *link, int64_t run,
                                     const uint8_t (*pages)[MR_BOXPAGE_BYTES],
                                     const uint8_t *present, size_t count, struct backfill *result,
                                     struct error *error);

#endif
