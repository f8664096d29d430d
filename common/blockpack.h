/* Lossless packing of block records and messages into a stream of bits: what the black box stores.
 *
 * Bits fill bytes from the lowest on. A record begins with a tag of two bits:
 *     0  packed block: its 32 sums as differences to the block before, each in an adaptive
 *        Golomb-Rice code
 *     1  plain block: 16 sums of 14 bits, 16 of 15 bits; chosen when packing does not pay, so no
 *        block of codes that a 12-bit converter can give exceeds MR_PACK_PLAIN_BITS
 *     2  other, with three more bits:
 *        0  message (id 11 bits, length 4 bits, bytes)
 *        1  key (index u32, tick u32)
 *        2  saturation (mask of 24 bits, a byte low << 4 | high per set bit)
 *        3  wide block (32 sums of 16 bits)
 *        4  padding to the next byte
 *        5  absent channels (mask of 24 bits), right behind a key
 *     3  end: nothing follows in this page
 * Tags 0, 1 and wide hold a block whose index is one more than the last and whose tick is
 * MR_TICKS_PER_BLOCK later; a key holds index and tick of the block that follows it, and resets the
 * prediction. Saturation holds until the next one. The sums of channels that are absent are left
 * out of blocks of every kind.
 *
 * Golomb-Rice: a difference d becomes z = 2 d, or -2 d - 1 when negative; q = z >> k as q zeroes
 * and a one, then the k low bits of z. Eight zeroes instead: z follows in 16 bits. k =
 * floor(log2(mean)), with mean a running mean of z over 16 blocks. Rice and Plaunt, 1971; the same
 * as in lossless audio. Pure functions. */
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
/* The longest that is tried: a packed block of nothing but escapes after a saturation of every
 * channel. In whole words, for it is written by words. */
#define MR_PACK_BITS_MAX   (5u + 24u + 8u * MR_CHANNELS + 2u + 24u * MR_PACK_SUMS)
#define MR_PACK_BYTES_MAX  ((MR_PACK_BITS_MAX + 31u) / 32u * 4u)

/* What both sides remember between blocks. Zero it, or mr_pack_forget, to begin. */
struct mr_pack {
    bool keyed;     /* index and tick are known */
    uint32_t index; /* of the block to come */
    uint32_t tick;
    uint32_t absent;
    /* sums of the previous block; only those present, one after the other */
    uint16_t value[MR_PACK_SUMS];
    uint32_t mean16[MR_PACK_SUMS]; /* 16 times the running mean */
    uint8_t low[MR_CHANNELS], high[MR_CHANNELS];
    bool wide; /* the block before was: a difference to it may have more than 16 bits */
};

void mr_pack_forget(struct mr_pack *pack);
/* The block can be packed without a key. */
bool mr_pack_follows(const struct mr_pack *pack, const struct mr_block *block);

/* Each returns the number of bits it put into `out`; bits beyond them in the last word are 0. */
size_t mr_pack_key(struct mr_pack *pack, const struct mr_block *block,
                   uint8_t out[MR_PACK_BYTES_MAX]);
/* A block that follows; its saturation first where that changed. */
size_t mr_pack_block(struct mr_pack *pack, const struct mr_block *block,
                     uint8_t out[MR_PACK_BYTES_MAX]);
/* `length` at most 8. */
size_t mr_pack_message(uint16_t id, const uint8_t *payload, size_t length,
                       uint8_t out[MR_PACK_BYTES_MAX]);
/* Padding for a stream that stands at bit `at` of a byte; none when at is 0. */
size_t mr_pack_padding(unsigned at, uint8_t out[MR_PACK_BYTES_MAX]);

enum mr_record_kind { MR_RECORD_BLOCK, MR_RECORD_MESSAGE, MR_RECORD_OTHER, MR_RECORD_END };

struct mr_record {
    enum mr_record_kind kind;
    struct mr_block block;
    uint16_t id;
    uint8_t length;
    uint8_t payload[16];
};

/* The record at bit `*at` of a stream of `bits` bits; moves *at behind it. MR_OK; MR_TRUNCATED: the
 * stream ends inside it, *at stays; MR_MALFORMED: no record, or a block before any key. */
enum mr_status mr_unpack(struct mr_pack *pack, const uint8_t *stream, size_t bits, size_t *at,
                         struct mr_record *record);

#endif
