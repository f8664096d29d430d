/* Packing: bits worked out by hand, every kind of block there and back, the bound. */
#include <string.h>

#include "common/blockpack.h"
#include "tests/cmocka_all.h"

static uint32_t random_state;

static uint32_t draw(uint32_t below)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (uint32_t)((uint64_t)random_state * below >> 32);
}

TEST(a_key_and_a_still_block_by_hand)
{
    struct mr_pack pack;
    struct mr_block block = {.index = 1, .tick = 0x80000002u};
    uint8_t bits[MR_PACK_BYTES_MAX];
    /* tag 2, kind 1: 0b00110; then 1 in 32 bits, 0x80000002 in 32: 69 bits from the lowest on */
    const uint8_t key[] = {0x26, 0, 0, 0, 0x40, 0, 0, 0, 0x10};
    assert_int_equal(mr_pack_key_block(&pack, &block, bits), 69);
    assert_memory_equal(bits, key, sizeof key);
    /* tag 0; the mean begins at 8, so k = 3: zero is a one and three zeroes, 32 times: 130 bits */
    assert_int_equal(mr_pack_block(&pack, &block, bits), 130);
    assert_int_equal(bits[0], 0x44);
    assert_int_equal(bits[15], 0x44);
    assert_int_equal(bits[16], 0x00);
    /* message 0x090 of two bytes: tag 2, kind 0, id, length: 0b00010, 0x090 << 5, 2 << 16 */
    assert_int_equal(mr_pack_message(0x090, (const uint8_t[]){0xa5, 0x5a}, 2, bits), 36);
    const uint8_t message[] = {0x02, 0x12, 0x52, 0xaa, 0x05};
    assert_memory_equal(bits, message, sizeof message);
    for (unsigned at = 0; at < 8; at++) /* padding ends at a byte */
        assert_int_equal((at + mr_pack_padding(at, bits)) % 8, 0);
}

/* Behind the key, tag 2, kind 5 (0b10110) and the mask; then two sums that do not move, four bits
 * each as above. */
TEST(what_is_absent_costs_no_bits)
{
    struct mr_pack pack;
    struct mr_block block = {.index = 1, .tick = 2, .absent_channels = 0x3fffff};
    uint8_t bits[MR_PACK_BYTES_MAX];
    assert_int_equal(mr_pack_key_block(&pack, &block, bits), 69 + 29);
    assert_int_equal(bits[8] >> 5 | (bits[9] & 3u) << 3, 2 | 5 << 2);
    assert_int_equal((bits[9] >> 2 | bits[10] << 6 | bits[11] << 14 | bits[12] << 22) & 0xffffff,
                     0x3fffff);
    assert_true(mr_pack_can_omit_key(&pack, &block));
    assert_int_equal(mr_pack_block(&pack, &block, bits), 2 + 2 * 4);
    block.index = 2;
    block.tick += MR_TICKS_PER_BLOCK;
    assert_true(mr_pack_can_omit_key(&pack, &block));
    block.absent_channels = 0x3ffffe; /* another set of channels needs a key */
    assert_false(mr_pack_can_omit_key(&pack, &block));
    /* and so does a mask: kind 5 where there is no key, or without a staircase */
    struct mr_record record;
    struct mr_pack unpack = {0};
    size_t at = 0;
    assert_int_equal(
        mr_unpack_record(&unpack, (const uint8_t[]){2u | 5u << 2, 0, 0, 0}, 32, &at, &record),
        MR_MALFORMED);
    unpack.has_key = true;
    at = 0;
    assert_int_equal(
        mr_unpack_record(&unpack, (const uint8_t[]){2u | 5u << 2, 0, 0, 0x10}, 32, &at, &record),
        MR_MALFORMED);
    at = 0;
    assert_int_equal(
        mr_unpack_record(&unpack, (const uint8_t[]){2u | 5u << 2, 0, 0, 0x04}, 32, &at, &record),
        MR_OK);
}

enum look { STILL, QUIET, WHITE, WIDE, ONE_WIDE, SATURATED, STEPS, LOOKS };

static void make(struct mr_block *block, const struct mr_block *before, enum look look)
{
    *block = (struct mr_block){.index = before->index + 1,
                               .tick = before->tick + MR_TICKS_PER_BLOCK};
    for (unsigned i = 0; i < 32; i++) {
        uint16_t *value = i < 8  ? &block->forward_sum[i]
                        : i < 16 ? &block->reversed_sum[i - 8]
                                 : &block->sum[i - 16];
        uint32_t codes = i < 16 ? 4 : 8;
        *value = (uint16_t)(codes * 2000 + i);
        if (look == QUIET || look == ONE_WIDE)
            *value = (uint16_t)(*value + draw(20));
        if (look == WHITE || look == SATURATED)
            *value = (uint16_t)draw(codes * 4095 + 1);
        if (look == WIDE || (look == ONE_WIDE && i == 31 && draw(2)))
            *value = (uint16_t)draw(65536);
        if (look == STEPS)
            *value = (uint16_t)(draw(2) * codes * 4095);
    }
    for (unsigned c = 0; c < MR_CHANNELS && look == SATURATED; c++) {
        block->low_count[c] = (uint8_t)(draw(3) ? 0 : draw(5));
        block->high_count[c] = (uint8_t)draw(5);
    }
}

static void leave_out(struct mr_block *block, uint32_t absent)
{
    block->absent_channels = absent;
    for (unsigned c = 0; c < 22; c++) {
        if (!(absent >> c & 1u))
            continue;
        if (c < 8)
            block->forward_sum[c] = block->reversed_sum[c] = 0;
        else
            block->sum[c - 8] = 0;
        block->low_count[c] = block->high_count[c] = 0;
    }
}

TEST(every_block_comes_back)
{
    static uint8_t stream[4000 * MR_PACK_BYTES_MAX];
    static struct mr_block sent[4000];
    struct mr_pack pack, unpack = {0};
    struct mr_block before = {0};
    size_t at = 0;
    uint32_t absent = 0;
    memset(stream, 0, sizeof stream);
    mr_pack_reset(&pack);
    random_state = 1;
    for (unsigned n = 0; n < COUNT_OF(sent); n++) {
        uint8_t bits[2][MR_PACK_BYTES_MAX];
        size_t count[2] = {0, 0};
        make(&sent[n], &before, n % 64 < 40 ? (enum look)(n / 64 % LOOKS) : QUIET);
        if (draw(100) == 0)
            sent[n].index += draw(50);
        if (draw(200) == 0)
            absent = draw(2) ? draw(1u << 22) : 0;
        leave_out(&sent[n], absent);
        if (!mr_pack_can_omit_key(&pack, &sent[n]))
            count[0] = mr_pack_key_block(&pack, &sent[n], bits[0]);
        count[1] = mr_pack_block(&pack, &sent[n], bits[1]);
        assert_true(count[1] <= MR_PACK_BYTES_MAX * 8u);
        for (unsigned part = 0; part < 2; part++) {
            for (size_t i = 0; i < count[part]; i++, at++)
                stream[at / 8] |= (uint8_t)((bits[part][i / 8] >> i % 8 & 1u) << at % 8);
        }
        before = sent[n];
    }
    size_t read = 0;
    for (unsigned n = 0; n < COUNT_OF(sent);) {
        struct mr_record record;
        assert_int_equal(mr_unpack_record(&unpack, stream, at, &read, &record), MR_OK);
        if (record.kind == MR_RECORD_BLOCK)
            assert_memory_equal(&record.block, &sent[n++], sizeof sent[0]);
    }
    assert_int_equal(read, at);
}

TEST(no_codes_exceed_the_bound)
{
    struct mr_pack pack;
    struct mr_block block = {0}, before = {0};
    uint8_t bits[MR_PACK_BYTES_MAX];
    size_t white = 0, quiet = 0;
    random_state = 2;
    mr_pack_key_block(&pack, &block, bits);
    for (unsigned n = 0; n < 20000; n++) {
        enum look look = n < 5000  ? QUIET
                       : n < 10000 ? WHITE
                       : n < 15000 ? STEPS
                                   : (enum look)(draw(2) ? WHITE : STILL);
        make(&block, &before, look);
        pack.index = block.index;
        pack.tick = block.tick;
        size_t count = mr_pack_block(&pack, &block, bits);
        assert_true(count <= MR_PACK_PLAIN_BITS);
        quiet += n < 5000 ? count : 0;
        white += n >= 5000 && n < 10000 ? count : 0;
        before = block;
    }
    /* 1000 blocks a second: at most 60 kB/s whatever comes, and a third of it where the noise is
     * that of the converters */
    assert_true(MR_PACK_PLAIN_BITS * 1000u / 8u <= 60000u);
    assert_true(white / 5000 > 460);
    assert_in_range(quiet / 5000, 100, 200);
}

TEST(what_is_cut_off_or_none_is_refused)
{
    struct mr_pack pack, unpack = {0};
    struct mr_block block = {.index = 7, .tick = 9};
    struct mr_record record;
    uint8_t key[MR_PACK_BYTES_MAX], bits[MR_PACK_BYTES_MAX];
    size_t at = 0;
    size_t key_bits = mr_pack_key_block(&pack, &block, key);
    size_t count = mr_pack_block(&pack, &block, bits);
    assert_int_equal(mr_unpack_record(&unpack, bits, count, &at, &record),
                     MR_MALFORMED); /* no key */
    for (size_t cut = 0; cut < key_bits; cut++) {
        at = 0;
        assert_int_equal(mr_unpack_record(&unpack, key, cut, &at, &record), MR_TRUNCATED);
        assert_int_equal(at, 0);
    }
    assert_int_equal(mr_unpack_record(&unpack, key, key_bits, &at, &record), MR_OK);
    for (size_t cut = 0; cut < count; cut++) {
        at = 0;
        assert_int_equal(mr_unpack_record(&unpack, bits, cut, &at, &record), MR_TRUNCATED);
    }
    at = 0; /* nothing of the attempts has stayed */
    assert_int_equal(mr_unpack_record(&unpack, bits, count, &at, &record), MR_OK);
    assert_int_equal(record.block.index, 7);
    at = 0;
    assert_int_equal(mr_unpack_record(&unpack, (const uint8_t[]){2u | 7u << 2}, 8, &at, &record),
                     MR_MALFORMED);
    at = 0;
    assert_int_equal(mr_unpack_record(&unpack, (const uint8_t[]){0xff}, 8, &at, &record), MR_OK);
    assert_int_equal(record.kind, MR_RECORD_END);
}
