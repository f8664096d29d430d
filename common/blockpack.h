/* Lossless packing of block records and messages into a stream of bits, the content of the black
 * box.
 *
 * Bits fill each byte from bit 0 up. A record begins with a tag of two bits:
 *     0  packed block: its 32 sums as differences from the previous block, each in an adaptive
 *        Golomb-Rice code
 *     1  plain block: 16 sums of 14 bits, 16 of 15 bits; used where packing saves nothing, so no
 *        block of 12-bit codes exceeds MR_PACK_PLAIN_BITS
 *     2  other; three more bits give the kind:
 *        0  message (id 11 bits, length 4 bits, bytes)
 *        1  key (index u32, tick u32)
 *        2  saturation (mask of 24 bits, a byte low << 4 | high per set bit)
 *        3  wide block (32 sums of 16 bits)
 *        4  padding to the next byte
 *        5  absent channels (mask of 24 bits), directly after a key
 *     3  end: this page contains nothing more
 * Packed, plain and wide blocks have the index of the previous block plus one and its tick plus
 * MR_TICKS_PER_BLOCK. A key holds index and tick of the next block and resets the prediction. A
 * saturation record applies until the next saturation record. The sums of absent channels are left
 * out of blocks of every kind.
 *
 * Golomb-Rice code: a difference d becomes z = 2 d, or -2 d - 1 when negative; q = z >> k is
 * written as q zeroes and a one, followed by the k low bits of z. Eight zeroes mean that z follows
 * in 16 bits. k = floor(log2(mean)), where mean is a running mean of z over 16 blocks. Source: Rice
 * and Plaunt, 1971; the code is common in lossless audio. Pure functions. */
#ifndef MATRIG_COMMON_BLOCKPACK_H
#define MATRIG_COMMON_BLOCKPACK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/status.h"

#define MR_PACK_SUMS       MR_BLOCK_SUMS
#define MR_PACK_PLAIN_BITS (2u + 16u * 14u + 16u * 15u)
#define MR_PACK_TAG_BITS   2u
/* Maximum number of bits written: a saturation record with every channel, and a packed block in
 * which each sum has 16 uncoded bits. Rounded up to whole words, because the output is written in
 * words. */
#define MR_PACK_BITS_MAX   (5u + 24u + 8u * MR_CHANNELS + 2u + 24u * MR_PACK_SUMS)
#define MR_PACK_BYTES_MAX  ((MR_PACK_BITS_MAX + 31u) / 32u * 4u)

/* State of the packer or unpacker between blocks. To begin, set it to zero or call
 * mr_pack_reset. */
struct mr_pack {
    bool has_key;   /* index and tick are known */
    uint32_t index; /* index of the next block */
    uint32_t tick;
    uint32_t absent_channels;
    /* sums of the previous block: only those that are present, without gaps */
    uint16_t previous_sum[MR_PACK_SUMS];
    uint32_t mean_x16[MR_PACK_SUMS]; /* running mean of z for each sum, times 16 */
    uint8_t low_count[MR_CHANNELS], high_count[MR_CHANNELS];
    /* the previous block was wide, so a difference from it may need more than 16 bits */
    bool is_wide;
};

void mr_pack_reset(struct mr_pack *pack);
/* True if the block can be packed without a key. */
bool mr_pack_can_omit_key(const struct mr_pack *pack, const struct mr_block *block);

/* The functions that fill `out` return the number of bits written; the remaining bits of the last
 * word are 0. */
size_t mr_pack_key_block(struct mr_pack *pack, const struct mr_block *block,
                         uint8_t out[MR_PACK_BYTES_MAX]);
/* Packs a block for which mr_pack_can_omit_key is true, after a saturation record if its saturation
 * has changed. */
size_t mr_pack_block(struct mr_pack *pack, const struct mr_block *block,
                     uint8_t out[MR_PACK_BYTES_MAX]);
/* Packs a message; `length` is at most 8. */
size_t mr_pack_message(uint16_t id, const uint8_t *payload, size_t length,
                       uint8_t out[MR_PACK_BYTES_MAX]);
/* Writes padding for a stream whose next bit is bit `at` of a byte; nothing if `at` is 0. */
size_t mr_pack_padding(unsigned at, uint8_t out[MR_PACK_BYTES_MAX]);

enum mr_record_kind { MR_RECORD_BLOCK, MR_RECORD_MESSAGE, MR_RECORD_OTHER, MR_RECORD_END };

struct mr_record {
    enum mr_record_kind kind;
    struct mr_block block;
    uint16_t id;
    uint8_t length;
    uint8_t payload[16];
};

/* Reads the record at bit `*at` of a stream of `bits` bits and sets *at to the bit after it.
 * MR_TRUNCATED: the stream ends inside the record, and *at is unchanged; MR_MALFORMED: not a
 * record, or a block before any key. */
enum mr_status mr_unpack_record(struct mr_pack *pack, const uint8_t *stream, size_t bits,
                                size_t *at, struct mr_record *record);

#endif
