/* A record of the black box into the campaign database: what is missing there of its landing. */
#ifndef MATRIG_HOST_BOXFILL_H
#define MATRIG_HOST_BOXFILL_H

#include "common/boxpage.h"
#include "host/store/store.h"

/* bit in `links` of a row that the black box brought; 1 and 2 are CAN and serial */
#define BOXFILL_LINK 4

struct boxfill {
    int64_t run;
    bool made;      /* no landing of the database matched: a new one */
    int64_t blocks; /* in the record */
    int64_t filled_blocks, filled_edges;
    /* between its first and last, lost by the board or with pages that could not be read */
    int64_t absent_blocks;
};

/* `run` 0: the landing of the same board, number and arming; made when there is none. Blocks and
 * edges that are there stay. Blocks that are added belong to a session of its own, ended by "black
 * box", and an event `blackbox` (code record, detail blocks filled, value absent) tells of it.
 * Configuration, calibration, results, bands, quality and events are taken as a log takes them.
 * MR_MALFORMED: the record's start page is missing or of another layout. */
enum mr_status boxfill(struct store *store, const char *link, int64_t run,
                       const uint8_t (*pages)[MR_BOXPAGE], const uint8_t *present, size_t count,
                       struct boxfill *result, struct error *error);

#endif
