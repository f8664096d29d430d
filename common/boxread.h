/* Reads a record of the black box: pages in, blocks and messages out, in order.
 *
 * `pages` holds `count` pages by their number in the record; `present[i]` is 0 for one that is
 * missing. What stands between a page that is missing and the next place where a reader may begin
 * is left out: the blocks' indices show what is not there. */
#ifndef MATRIG_COMMON_BOXREAD_H
#define MATRIG_COMMON_BOXREAD_H

#include "common/blockpack.h"
#include "common/boxpage.h"

struct mr_boxread {
    const uint8_t *pages;
    const uint8_t *present;
    size_t count;
    size_t page; /* where the next record of the stream begins */
    size_t bit;
    bool in_step;
    struct mr_pack pack;
};

void mr_boxread_begin(struct mr_boxread *reader, const uint8_t *pages, const uint8_t *present,
                      size_t count);
/* MR_OK: a block or a message; MR_TOO_FEW: no more. */
enum mr_status mr_boxread_next(struct mr_boxread *reader, struct mr_record *record);

#endif
