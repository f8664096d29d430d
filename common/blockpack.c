#include "common/blockpack.h"

#include <string.h>

#include "common/wire.h"

/* Writes bit fields into 32-bit words, lowest bit first. Words in memory are little-endian, so
 * bytes also fill from the lowest bit. */
struct mr_bit_writer {
    uint8_t *next;      /* address of the next complete word */
    uint32_t word;      /* bits of the incomplete word */
    unsigned word_bits; /* number of bits in `word`, always below 32 */
};

/* Writes at most 31 bits; higher bits of `value` must be 0. Stores at most one word. */
static inline void mr_bit_writer_put(struct mr_bit_writer *to, uint32_t value, unsigned bits)
{
    unsigned total = to->word_bits + bits;
    to->word |= value << to->word_bits;
    if (total >= 32) { /* a word is complete */
        to->next = mr_put_u32(to->next, to->word);
        to->word = value >> (32 - to->word_bits);
        total -= 32;
    }
    to->word_bits = total;
}

static inline void mr_bit_writer_put32(struct mr_bit_writer *to, uint32_t value)
{
    mr_bit_writer_put(to, value & 0xffffu, 16);
    mr_bit_writer_put(to, value >> 16, 16);
}

/* Writes the incomplete word, padded with zeroes. Returns the number of bits written since
 * `start`. */
static inline size_t mr_bit_writer_end(struct mr_bit_writer *to, const uint8_t *start)
{
    if (to->word_bits)
        mr_put_u32(to->next, to->word);
    return (size_t)(to->next - start) * 8u + to->word_bits;
}

enum { TAG_PACKED, TAG_PLAIN, TAG_EXTENDED, TAG_END };
enum {
    EXTENDED_MESSAGE,
    EXTENDED_KEY,
    EXTENDED_SATURATION,
    EXTENDED_WIDE_BLOCK,
    EXTENDED_PADDING,
    EXTENDED_ABSENT_CHANNELS
};
#define EXTENDED_TAG(kind) (TAG_EXTENDED | (uint32_t)(kind) << 2)
#define EXTENDED_TAG_BITS  5u
#define ESCAPE_ZEROES      8u /* number of zeroes that mark an uncoded 16-bit value */
/* initial mean of 8: typical difference of a sum of 8 codes with 2 LSB of noise */
#define INITIAL_MEAN_X16   128u

/* The sums that a block contains: first `four_code_count` sums of 4 codes each, then sums of 8. */
struct sums {
    const uint16_t *value;
    unsigned four_code_count, count;
    uint16_t gathered[MR_PACK_SUMS];
};

static unsigned get_plain_bit_count(const struct sums *sums, unsigned i)
{
    return i < sums->four_code_count ? 14u : 15u;
}

static void count_present_sums(struct sums *sums, uint32_t absent)
{
    sums->four_code_count =
        2u * (MR_TRANSDUCERS - (unsigned)__builtin_popcount(absent & MR_BITS_TRANSDUCERS));
    sums->count = MR_PACK_SUMS - (unsigned)__builtin_popcount(mr_block_absent_sums(absent));
}

static void gather_present_sums(struct sums *sums, const struct mr_block *block)
{
    sums->value = block->sums;
    sums->four_code_count = 2u * MR_TRANSDUCERS;
    sums->count = MR_PACK_SUMS;
    if (!block->absent_channels)
        return;
    count_present_sums(sums, block->absent_channels);
    uint32_t absent = mr_block_absent_sums(block->absent_channels);
    uint16_t *to = sums->gathered;
    sums->value = to;
    for (unsigned i = 0; i < MR_PACK_SUMS; i++) {
        if (!(absent >> i & 1u))
            *to++ = block->sums[i];
    }
    if (sums->count % 2)
        *to = 0; /* pad the list, because is_wide reads pairs */
}

static unsigned compute_rice_parameter(const struct mr_pack *pack, unsigned i)
{
    return 27u - (unsigned)__builtin_clz(pack->mean_x16[i] | 16u);
}

static void update_prediction(struct mr_pack *pack, unsigned i, uint32_t z, uint16_t value)
{
    pack->mean_x16[i] += z - (pack->mean_x16[i] >> 4);
    pack->previous_sum[i] = value;
}

void mr_pack_reset(struct mr_pack *pack)
{
    memset(pack, 0, sizeof *pack);
    for (unsigned i = 0; i < MR_PACK_SUMS; i++)
        pack->mean_x16[i] = INITIAL_MEAN_X16;
}

bool mr_pack_can_omit_key(const struct mr_pack *pack, const struct mr_block *block)
{
    return pack->has_key && block->index == pack->index && block->tick == pack->tick &&
           block->absent_channels == pack->absent_channels;
}

size_t mr_pack_key_block(struct mr_pack *pack, const struct mr_block *block,
                         uint8_t out[MR_PACK_BYTES_MAX])
{
    struct mr_bit_writer w = {.next = out};
    mr_pack_reset(pack);
    pack->has_key = true;
    pack->index = block->index;
    pack->tick = block->tick;
    pack->absent_channels = block->absent_channels;
    mr_bit_writer_put(&w, EXTENDED_TAG(EXTENDED_KEY), EXTENDED_TAG_BITS);
    mr_bit_writer_put32(&w, block->index);
    mr_bit_writer_put32(&w, block->tick);
    if (block->absent_channels) {
        mr_bit_writer_put(&w, EXTENDED_TAG(EXTENDED_ABSENT_CHANNELS), EXTENDED_TAG_BITS);
        mr_bit_writer_put(&w, block->absent_channels, 24);
    }
    return mr_bit_writer_end(&w, out);
}

static bool has_same_counts(const uint8_t *a, const uint8_t *b)
{
    uint32_t differ = 0;
    for (unsigned i = 0; i < MR_CHANNELS; i += 4)
        differ |= mr_get_u32(&a) ^ mr_get_u32(&b);
    return differ == 0;
}

static void put_saturation(struct mr_bit_writer *w, struct mr_pack *pack,
                           const struct mr_block *block)
{
    uint32_t mask = 0;
    if (has_same_counts(pack->low_count, block->low_count) &&
        has_same_counts(pack->high_count, block->high_count))
        return;
    for (unsigned c = 0; c < MR_CHANNELS; c++)
        mask |= (block->low_count[c] || block->high_count[c] ? 1u : 0u) << c;
    mr_bit_writer_put(w, EXTENDED_TAG(EXTENDED_SATURATION), EXTENDED_TAG_BITS);
    mr_bit_writer_put(w, mask, 24);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        if (mask >> c & 1u)
            mr_bit_writer_put(w, (uint32_t)(block->low_count[c] << 4 | block->high_count[c]), 8);
    }
    memcpy(pack->low_count, block->low_count, sizeof pack->low_count);
    memcpy(pack->high_count, block->high_count, sizeof pack->high_count);
}

/* Writes all sums as differences from the previous block. Returns the number of bits. */
static size_t put_packed(struct mr_bit_writer *to, struct mr_pack *pack, const uint16_t *value,
                         unsigned count)
{
    struct mr_bit_writer w = *to; /* a local copy, which the compiler keeps in registers */
    mr_bit_writer_put(&w, TAG_PACKED, MR_PACK_TAG_BITS);
#pragma GCC unroll 4
    for (unsigned i = 0; i < count; i++) {
        int32_t d = (int32_t)value[i] - (int32_t)pack->previous_sum[i];
        uint32_t z = (uint32_t)d << 1 ^ (uint32_t)(d >> 31);
        unsigned k = compute_rice_parameter(pack, i);
        uint32_t q = z >> k;
        update_prediction(pack, i, z, value[i]);
        uint32_t code = ((z - (q << k)) * 2u + 1u) << q;
        unsigned length = q + 1u + k;
        if (__builtin_expect(q >= ESCAPE_ZEROES, 0)) {
            /* If z needs 17 bits, this form is not used: the block is written again in the wide
             * form. */
            code = z << ESCAPE_ZEROES;
            length = ESCAPE_ZEROES + 16u;
        }
        mr_bit_writer_put(&w, code, length);
    }
    size_t bits = (size_t)(w.next - to->next) * 8u + w.word_bits - to->word_bits;
    *to = w;
    return bits;
}

/* True if a sum exceeds the range of 12-bit codes; compares two sums at a time. */
static bool is_wide(const struct sums *sums)
{
    uint32_t of_four = 0, of_eight = 0, pair;
    for (unsigned i = 0; i < sums->four_code_count; i += 2) {
        __builtin_memcpy(&pair, sums->value + i, sizeof pair);
        of_four |= pair;
    }
    for (unsigned i = sums->four_code_count; i < sums->count; i += 2) {
        __builtin_memcpy(&pair, sums->value + i, sizeof pair);
        of_eight |= pair;
    }
    return ((of_four & 0xc000c000u) | (of_eight & 0x80008000u)) != 0;
}

size_t mr_pack_block(struct mr_pack *pack, const struct mr_block *block,
                     uint8_t out[MR_PACK_BYTES_MAX])
{
    struct mr_bit_writer w = {.next = out};
    put_saturation(&w, pack, block);

    /* Nearly every block can be packed: write the packed form first, and write another form over it
     * if it does not fit. */
    struct mr_bit_writer before = w;
    struct sums sums;
    gather_present_sums(&sums, block);
    size_t packed = put_packed(&w, pack, sums.value, sums.count);
    bool wide_now = is_wide(&sums), wide = wide_now || pack->is_wide;
    pack->is_wide = wide_now;
    if (wide || packed >= MR_PACK_TAG_BITS + 15u * sums.count - sums.four_code_count) {
        w = before;
        if (wide)
            mr_bit_writer_put(&w, EXTENDED_TAG(EXTENDED_WIDE_BLOCK), EXTENDED_TAG_BITS);
        else
            mr_bit_writer_put(&w, TAG_PLAIN, MR_PACK_TAG_BITS);
        for (unsigned i = 0; i < sums.count; i++)
            mr_bit_writer_put(&w, sums.value[i], wide ? 16u : get_plain_bit_count(&sums, i));
    }
    pack->index++;
    pack->tick += MR_TICKS_PER_BLOCK;
    return mr_bit_writer_end(&w, out);
}

size_t mr_pack_message(uint16_t id, const uint8_t *payload, size_t length,
                       uint8_t out[MR_PACK_BYTES_MAX])
{
    struct mr_bit_writer w = {.next = out};
    mr_bit_writer_put(&w, EXTENDED_TAG(EXTENDED_MESSAGE), EXTENDED_TAG_BITS);
    mr_bit_writer_put(&w, id & 0x7ffu, 11);
    mr_bit_writer_put(&w, (uint32_t)length & 15u, 4);
    for (size_t i = 0; i < length; i++)
        mr_bit_writer_put(&w, payload[i], 8);
    return mr_bit_writer_end(&w, out);
}

size_t mr_pack_padding(unsigned at, uint8_t out[MR_PACK_BYTES_MAX])
{
    struct mr_bit_writer w = {.next = out};
    if (at % 8u == 0)
        return 0;
    unsigned after = (at + EXTENDED_TAG_BITS) % 8u;
    mr_bit_writer_put(&w, EXTENDED_TAG(EXTENDED_PADDING), EXTENDED_TAG_BITS);
    mr_bit_writer_put(&w, 0, after ? 8u - after : 0u);
    return mr_bit_writer_end(&w, out);
}

struct bit_reader {
    const uint8_t *stream;
    size_t bits, at;
    bool is_truncated; /* more bits were read than the stream has */
};

static uint32_t get_bits(struct bit_reader *r, unsigned bits)
{
    uint32_t value = 0;
    if (bits > r->bits - r->at) {
        r->is_truncated = true;
        r->at = r->bits;
        return 0;
    }
    for (unsigned i = 0; i < bits; i++, r->at++)
        value |= (uint32_t)(r->stream[r->at / 8] >> r->at % 8 & 1u) << i;
    return value;
}

static uint32_t get_rice(struct bit_reader *r, unsigned k)
{
    uint32_t q = 0;
    while (q < ESCAPE_ZEROES && !r->is_truncated && get_bits(r, 1) == 0)
        q++;
    return q < ESCAPE_ZEROES ? q << k | get_bits(r, k) : get_bits(r, 16);
}

static void get_block(struct bit_reader *r, struct mr_pack *pack, unsigned tag,
                      struct mr_block *block)
{
    uint32_t absent = mr_block_absent_sums(pack->absent_channels);
    struct sums sums;
    count_present_sums(&sums, pack->absent_channels);
    *block = (struct mr_block){
        .index = pack->index++, .tick = pack->tick, .absent_channels = pack->absent_channels};
    pack->tick += MR_TICKS_PER_BLOCK;
    for (unsigned i = 0, place = 0; i < sums.count; i++, place++) {
        while (absent >> place & 1u)
            place++;
        uint16_t *value = &block->sums[place];
        uint32_t z;
        if (tag == TAG_PACKED) {
            z = get_rice(r, compute_rice_parameter(pack, i));
            int32_t d = (int32_t)(z >> 1) ^ -(int32_t)(z & 1u);
            *value = (uint16_t)((int32_t)pack->previous_sum[i] + d);
        } else {
            *value = (uint16_t)get_bits(r, tag == TAG_PLAIN ? get_plain_bit_count(&sums, i) : 16u);
            int32_t d = (int32_t)*value - (int32_t)pack->previous_sum[i];
            z = (uint32_t)d << 1 ^ (uint32_t)(d >> 31);
        }
        update_prediction(pack, i, z, *value);
    }
    memcpy(block->low_count, pack->low_count, sizeof block->low_count);
    memcpy(block->high_count, pack->high_count, sizeof block->high_count);
}

static void get_saturation(struct bit_reader *r, struct mr_pack *pack)
{
    uint32_t mask = get_bits(r, 24);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        uint32_t counts = mask >> c & 1u ? get_bits(r, 8) : 0;
        pack->low_count[c] = (uint8_t)(counts >> 4);
        pack->high_count[c] = (uint8_t)(counts & 15u);
    }
}

static enum mr_status get_extended_record(struct bit_reader *r, struct mr_pack *pack,
                                          struct mr_record *record)
{
    record->kind = MR_RECORD_OTHER;
    switch (get_bits(r, EXTENDED_TAG_BITS - MR_PACK_TAG_BITS)) {
    case EXTENDED_MESSAGE:
        record->kind = MR_RECORD_MESSAGE;
        record->id = (uint16_t)get_bits(r, 11);
        record->length = (uint8_t)get_bits(r, 4);
        for (unsigned i = 0; i < record->length; i++)
            record->payload[i] = (uint8_t)get_bits(r, 8);
        return MR_OK;
    case EXTENDED_KEY:
        mr_pack_reset(pack);
        pack->has_key = true;
        pack->index = get_bits(r, 16);
        pack->index |= get_bits(r, 16) << 16;
        pack->tick = get_bits(r, 16);
        pack->tick |= get_bits(r, 16) << 16;
        return MR_OK;
    case EXTENDED_SATURATION: get_saturation(r, pack); return MR_OK;
    case EXTENDED_WIDE_BLOCK:
        record->kind = MR_RECORD_BLOCK;
        if (!pack->has_key)
            return MR_MALFORMED;
        get_block(r, pack, TAG_EXTENDED, &record->block);
        return MR_OK;
    case EXTENDED_ABSENT_CHANNELS:
        pack->absent_channels = get_bits(r, 24);
        return pack->has_key && !(pack->absent_channels & ~MR_BITS_OPTIONAL) ? MR_OK : MR_MALFORMED;
    case EXTENDED_PADDING: r->at = (r->at + 7) / 8 * 8; return MR_OK;
    default: return MR_MALFORMED;
    }
}

enum mr_status mr_unpack_record(struct mr_pack *pack, const uint8_t *stream, size_t bits,
                                size_t *at, struct mr_record *record)
{
    struct bit_reader r = {.stream = stream, .bits = bits, .at = *at};
    struct mr_pack before = *pack;
    enum mr_status status = MR_OK;
    unsigned tag = get_bits(&r, MR_PACK_TAG_BITS);
    if (r.is_truncated)
        return MR_TRUNCATED;
    if (tag == TAG_EXTENDED) {
        status = get_extended_record(&r, pack, record);
    } else if (tag == TAG_END) {
        record->kind = MR_RECORD_END;
    } else if (!pack->has_key) {
        status = MR_MALFORMED;
    } else {
        record->kind = MR_RECORD_BLOCK;
        get_block(&r, pack, tag, &record->block);
    }
    if (r.is_truncated) {
        *pack = before;
        return MR_TRUNCATED;
    }
    *at = r.at;
    return status;
}
