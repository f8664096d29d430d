/* Block records of a landing, in order, as far as their times can belong to it. Only
 * measured_series.c. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_BLOCKS_H
#define MATRIG_HOST_ANALYSE_MEASURED_BLOCKS_H

#include "host/analyse/measured.h"
#include "host/analyse/measured_moments.h"

struct measured_blocks {
    struct mr_block *block;
    uint8_t *source; /* enum measured_source */
    size_t count;
    size_t *row;  /* in the campaign, counted from 0 */
    size_t rows;  /* seen, */
    size_t known; /* and of how many of those that were kept the source is, */
    size_t named; /* rows seen for it */
    int64_t from; /* blocks before it are passed over */
    int64_t skipped;
    const struct moments *moments;
    struct measured_aside *aside;
};

/* One more of `*count`, of this block. */
void measured_set_aside(struct measured_aside *aside, size_t *count, int64_t block);

/* `from`, `moments` and `aside` are given. MR_FULL; MR_MALFORMED: a record that is none. Release
 * with measured_blocks_free. */
enum mr_status measured_blocks_load(struct store *store, int64_t run, struct measured_blocks *list,
                                    struct error *error);
void measured_blocks_free(struct measured_blocks *list);

#endif
