/* The replay file: a recorded landing as the board saw it, as text (`matrig-replay 1`), read once.
 *
 *     matrig-replay 1
 *     uid <word 0> <word 1> <word 2>       identity of the board that recorded it, 8 hex digits
 *                                          each; may be left out
 *     crystal <1 or 0>                     0: the crystal did not start
 *     command <block> <code> <index> <tag> <argument>      taken by the board in that block; in
 *                                                          order
 *     edge <tick>                          capture of TIM2's channel 1; ticks since TIM2 began, not
 *                                          wrapped; rising
 *     frame <tick>                         film frame: PB3 rises; in order, a millisecond apart
 *     block <hex>                          a block record as it goes over the wire
 *                                          (common/block.h); consecutive
 *     end <crc32>                          of everything before this line, 8 hex digits
 *
 * Lines that begin with # say nothing. Blocks count from the moment the board's scans begin, as the
 * records say; before the first record its codes hold, after the last one its. */
#ifndef MATRIG_HIL_REPLAYFILE_H
#define MATRIG_HIL_REPLAYFILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/status.h"

struct hil_replay_command {
    uint32_t block;
    struct mr_command message;
};

struct hil_replay {
    bool has_uid;
    uint32_t uid[3];
    bool crystal;
    struct mr_block *blocks;
    size_t block_count; /* at least 1 */
    uint64_t *edge_tick;
    size_t edge_count;
    uint64_t *frame_tick;
    size_t frame_count;
    struct hil_replay_command *commands;
    size_t command_count;
    uint32_t origin_tick; /* TIM2 at the first trigger of block 0 */
};

/* Read a file. On failure nothing is kept and `error` (size bytes) says what is wrong, with file
 * and line. MR_IO: cannot be read; MR_MALFORMED, MR_TRUNCATED, MR_CRC, MR_VERSION: not a whole
 * replay file of version 1, or a record whose sums no codes can have. */
enum mr_status hil_replay_read(const char *path, struct hil_replay *replay, char *error,
                               size_t size);
void hil_replay_free(struct hil_replay *replay);

#endif
