/* Pages of the black box, as stored in the memory and sent over serial. Little-endian:
 *
 *     seq u32 | record u16 | kind u8 | first u8 | payload 244 bytes | CRC-32 u32
 *
 *     seq     counts all pages ever written; consecutive within a record
 *     record  number of the recording, from 1
 *     kind    0x80 | enum mr_boxpage_kind. The top bit is programmed to 0 when the record is
 *             freed; the CRC is computed with the bit set
 *     first   stream page: payload byte at which a reader may begin (a key, or the first
 *             message); 0xff: none
 *     CRC     of everything before it
 *
 * A record consists of a start page, stream pages and an end page, which is missing after a power
 * failure. The payloads of the stream pages form one continuous stream (common/blockpack.h), so a
 * record of the stream may cross a page boundary. After an end tag or a missing page, the stream
 * continues at the next `first`. */
#ifndef MATRIG_COMMON_BOXPAGE_H
#define MATRIG_COMMON_BOXPAGE_H

#include <stddef.h>
#include <stdint.h>

#include "common/blockpack.h"
#include "common/status.h"

#define MR_BOXPAGE_BYTES         256u
#define MR_BOXPAGE_HEADER_BYTES  8u
#define MR_BOXPAGE_PAYLOAD_BYTES 244u
#define MR_BOXPAGE_KIND_OFFSET   6u /* offsets */
#define MR_BOXPAGE_FIRST_OFFSET  7u
#define MR_BOXPAGE_NOT_FREED     0x80u
#define MR_BOXPAGE_NO_FIRST      0xffu

enum mr_boxpage_kind { MR_BOXPAGE_START = 1, MR_BOXPAGE_STREAM = 2, MR_BOXPAGE_END = 3 };

struct mr_boxpage_header {
    uint32_t seq;
    uint16_t record;
    uint8_t kind; /* enum mr_boxpage_kind */
    uint8_t first_record_byte;
    uint8_t is_freed; /* 1: the page's record has been freed */
};

/* Completes a page that already holds kind, first and payload: writes seq, record and CRC. */
void mr_boxpage_seal(uint8_t page[MR_BOXPAGE_BYTES], uint32_t seq, uint16_t record);
/* Checks a page. MR_TOO_FEW: it is erased (all ones); MR_CRC: it is neither erased nor valid. */
enum mr_status mr_boxpage_check(const uint8_t page[MR_BOXPAGE_BYTES],
                                struct mr_boxpage_header *header);

/* Payload of a start page. */
struct mr_boxpage_start_page {
    uint16_t layout; /* MR_LAYOUT */
    uint16_t landing;
    uint32_t armed_block, trigger_block;
    uint32_t uid[3], image_crc, config_crc;
    uint8_t firmware[3];
    uint8_t clock_source;
};
void mr_boxpage_put_start(uint8_t page[MR_BOXPAGE_BYTES],
                          const struct mr_boxpage_start_page *start);
void mr_boxpage_get_start(const uint8_t page[MR_BOXPAGE_BYTES],
                          struct mr_boxpage_start_page *start);

/* Payload of an end page. */
struct mr_boxpage_end {
    uint32_t first_block;   /* index of the first block in the stream */
    uint32_t stored_blocks; /* number of blocks stored */
    /* number of blocks since first_block that were not stored: no room, or lost earlier by the
     * board */
    uint32_t lost_blocks;
    uint32_t lost_messages; /* number of messages that were not stored */
};
void mr_boxpage_put_end(uint8_t page[MR_BOXPAGE_BYTES], const struct mr_boxpage_end *end);
void mr_boxpage_get_end(const uint8_t page[MR_BOXPAGE_BYTES], struct mr_boxpage_end *end);

/* ---- reading a record ---- */

/* Reads a record of the black box: returns the blocks and messages of its pages in order.
 *
 * `pages` holds `count` pages by their number in the record; `present[i]` is 0 if page i is
 * missing. After a missing page, the reader continues at the next byte at which it may begin; the
 * block indices show the gap. */

struct mr_box_reader {
    const uint8_t *pages;
    const uint8_t *present;
    size_t page_count;
    size_t page; /* page on which the next record of the stream begins */
    size_t bit;
    bool is_synchronised;
    struct mr_pack pack;
};

void mr_box_reader_begin(struct mr_box_reader *reader, const uint8_t *pages, const uint8_t *present,
                         size_t count);
/* Returns the next block or message in `record`. MR_TOO_FEW: there are no more. */
enum mr_status mr_box_reader_next(struct mr_box_reader *reader, struct mr_record *record);

#endif
