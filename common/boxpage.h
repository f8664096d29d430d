/* Pages of the black box, as they stand in the memory and travel over serial. Little-endian:
 *
 *     seq u32 | record u16 | kind u8 | first u8 | payload 244 bytes | CRC-32 u32
 *
 *     seq     counts the pages ever written; consecutive within a record
 *     record  the recording it belongs to, counts on from 1
 *     kind    0x80 | enum mr_boxpage_kind. The uppermost bit is programmed to 0 when the record is
 *             freed; the CRC is that of the page with the bit set
 *     first   stream: byte of the payload at which a reader may begin (a key, or the first
 *             message); 0xff: none
 *     CRC     of everything before it
 *
 * A record is a start page, stream pages (common/blockpack.h; their payloads follow each other
 * without a gap, so records of the stream may cross from page to page) and an end page, which is
 * missing when the power went. After an end tag, or a page that is missing, the stream goes on at
 * the next `first`. */
#ifndef MATRIG_COMMON_BOXPAGE_H
#define MATRIG_COMMON_BOXPAGE_H

#include <stddef.h>
#include <stdint.h>

#include "common/blockpack.h"
#include "common/status.h"

#define MR_BOXPAGE          256u
#define MR_BOXPAGE_HEADER   8u
#define MR_BOXPAGE_PAYLOAD  244u
#define MR_BOXPAGE_KIND     6u /* offsets */
#define MR_BOXPAGE_FIRST    7u
#define MR_BOXPAGE_LIVE     0x80u
#define MR_BOXPAGE_NO_FIRST 0xffu

enum mr_boxpage_kind { MR_BOXPAGE_START = 1, MR_BOXPAGE_STREAM = 2, MR_BOXPAGE_END = 3 };

struct mr_boxpage_header {
    uint32_t seq;
    uint16_t record;
    uint8_t kind; /* enum mr_boxpage_kind */
    uint8_t first;
    uint8_t freed; /* 1: the bit was programmed to 0 */
};

/* Write seq, record and CRC into a page whose kind, first and payload stand. */
void mr_boxpage_seal(uint8_t page[MR_BOXPAGE], uint32_t seq, uint16_t record);
/* MR_OK; MR_TOO_FEW: erased, all ones; MR_CRC: neither erased nor a whole page. */
enum mr_status mr_boxpage_check(const uint8_t page[MR_BOXPAGE], struct mr_boxpage_header *header);

/* Payload of a start page. */
struct mr_boxpage_start {
    uint16_t layout; /* MR_LAYOUT */
    uint16_t landing;
    uint32_t armed_block, trigger_block;
    uint32_t uid[3], image_crc, config_crc;
    uint8_t firmware[3];
    uint8_t clock_source;
};
void mr_boxpage_put_start(uint8_t page[MR_BOXPAGE], const struct mr_boxpage_start *start);
void mr_boxpage_get_start(const uint8_t page[MR_BOXPAGE], struct mr_boxpage_start *start);

/* Payload of an end page. */
struct mr_boxpage_end {
    uint32_t first_block; /* of the stream */
    uint32_t blocks;      /* stored */
    /* blocks since the first that found no room, or that the board had lost before */
    uint32_t lost;
    uint32_t notes_lost; /* messages likewise */
};
void mr_boxpage_put_end(uint8_t page[MR_BOXPAGE], const struct mr_boxpage_end *end);
void mr_boxpage_get_end(const uint8_t page[MR_BOXPAGE], struct mr_boxpage_end *end);

/* ---- boxread ---- */

/* Reads a record of the black box: pages in, blocks and messages out, in order.
 *
 * `pages` holds `count` pages by their number in the record; `present[i]` is 0 for one that is
 * missing. What stands between a page that is missing and the next place where a reader may begin
 * is left out: the blocks' indices show what is not there. */

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
