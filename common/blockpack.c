#include "common/blockpack.h"

#include <string.h>

enum { TAG_PACKED, TAG_PLAIN, TAG_OTHER, TAG_END };
enum { OTHER_MESSAGE, OTHER_KEY, OTHER_SATURATION, OTHER_WIDE, OTHER_PADDING };
#define OTHER(kind) (TAG_OTHER | (uint32_t)(kind) << 2)
#define OTHER_BITS 5u
#define ESCAPE 8u        /* zeroes that say: 16 bits follow */
#define MEAN_START 128u  /* a mean of 8: the sum of 8 codes with 2 LSB of noise differs by that */

struct writer {
    uint8_t *bytes;
    uint32_t held; /* bits not yet in a whole byte */
    unsigned held_bits;
    size_t count;
};

/* At most 24 bits. */
static void put(struct writer *w, uint32_t value, unsigned bits)
{
    w->held |= value << w->held_bits;
    w->held_bits += bits;
    w->count += bits;
    while (w->held_bits >= 8) {
        *w->bytes++ = (uint8_t)w->held;
        w->held >>= 8;
        w->held_bits -= 8;
    }
}

static void put32(struct writer *w, uint32_t value)
{
    put(w, value & 0xffffu, 16);
    put(w, value >> 16, 16);
}

static size_t finish(struct writer *w)
{
    if (w->held_bits)
        *w->bytes = (uint8_t)w->held;
    return w->count;
}

static unsigned plain_bits(unsigned i)
{
    return i < 2 * MR_TRANSDUCERS ? 14u : 15u;
}

static void gather(const struct mr_block *block, uint16_t value[MR_PACK_SUMS])
{
    memcpy(value, block->plus, sizeof block->plus);
    memcpy(value + MR_TRANSDUCERS, block->minus, sizeof block->minus);
    memcpy(value + 2 * MR_TRANSDUCERS, block->sum, sizeof block->sum);
}

static unsigned parameter(const struct mr_pack *pack, unsigned i)
{
    uint32_t mean = pack->mean16[i] >> 4;
    return mean > 1 ? 31u - (unsigned)__builtin_clz(mean) : 0u;
}

static void remember(struct mr_pack *pack, unsigned i, uint32_t z, uint16_t value)
{
    pack->mean16[i] += z - (pack->mean16[i] >> 4);
    pack->value[i] = value;
}

void mr_pack_forget(struct mr_pack *pack)
{
    memset(pack, 0, sizeof *pack);
    for (unsigned i = 0; i < MR_PACK_SUMS; i++)
        pack->mean16[i] = MEAN_START;
}

bool mr_pack_follows(const struct mr_pack *pack, const struct mr_block *block)
{
    return pack->keyed && block->index == pack->index && block->tick == pack->tick;
}

size_t mr_pack_key(struct mr_pack *pack, const struct mr_block *block, uint8_t out[MR_PACK_BYTES_MAX])
{
    struct writer w = {.bytes = out};
    mr_pack_forget(pack);
    pack->keyed = true;
    pack->index = block->index;
    pack->tick = block->tick;
    put(&w, OTHER(OTHER_KEY), OTHER_BITS);
    put32(&w, block->index);
    put32(&w, block->tick);
    return finish(&w);
}

static void put_saturation(struct writer *w, struct mr_pack *pack, const struct mr_block *block)
{
    uint32_t mask = 0;
    if (memcmp(pack->low, block->low, sizeof pack->low) == 0 && memcmp(pack->high, block->high, sizeof pack->high) == 0)
        return;
    for (unsigned c = 0; c < MR_CHANNELS; c++)
        mask |= (block->low[c] || block->high[c] ? 1u : 0u) << c;
    put(w, OTHER(OTHER_SATURATION), OTHER_BITS);
    put(w, mask, 24);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        if (mask >> c & 1u)
            put(w, (uint32_t)(block->low[c] << 4 | block->high[c]), 8);
    }
    memcpy(pack->low, block->low, sizeof pack->low);
    memcpy(pack->high, block->high, sizeof pack->high);
}

size_t mr_pack_block(struct mr_pack *pack, const struct mr_block *block, uint8_t out[MR_PACK_BYTES_MAX])
{
    struct writer w = {.bytes = out};
    uint16_t value[MR_PACK_SUMS];
    uint32_t z[MR_PACK_SUMS];
    unsigned bits = MR_PACK_TAG_BITS;
    bool wide = false;

    put_saturation(&w, pack, block);
    gather(block, value);
    for (unsigned i = 0; i < MR_PACK_SUMS; i++) {
        int32_t d = (int32_t)value[i] - (int32_t)pack->value[i];
        unsigned k = parameter(pack, i);
        z[i] = (uint32_t)d << 1 ^ (uint32_t)(d >> 31);
        /* z has 17 bits only where a sum has 16, and such a block is sent wide */
        bits += z[i] >> k < ESCAPE ? (z[i] >> k) + 1 + k : ESCAPE + 16;
        wide |= value[i] >> plain_bits(i) != 0;
    }
    if (wide) {
        put(&w, OTHER(OTHER_WIDE), OTHER_BITS);
        for (unsigned i = 0; i < MR_PACK_SUMS; i++)
            put(&w, value[i], 16);
    } else if (bits >= MR_PACK_PLAIN_BITS) {
        put(&w, TAG_PLAIN, MR_PACK_TAG_BITS);
        for (unsigned i = 0; i < MR_PACK_SUMS; i++)
            put(&w, value[i], plain_bits(i));
    } else {
        put(&w, TAG_PACKED, MR_PACK_TAG_BITS);
        for (unsigned i = 0; i < MR_PACK_SUMS; i++) {
            unsigned k = parameter(pack, i);
            uint32_t q = z[i] >> k;
            if (q < ESCAPE) {
                put(&w, 1u << q, (unsigned)q + 1);
                put(&w, z[i] & ((1u << k) - 1), k);
            } else {
                put(&w, 0, ESCAPE);
                put(&w, z[i], 16);
            }
        }
    }
    for (unsigned i = 0; i < MR_PACK_SUMS; i++)
        remember(pack, i, z[i], value[i]);
    pack->index++;
    pack->tick += MR_TICKS_PER_BLOCK;
    return finish(&w);
}

size_t mr_pack_message(uint16_t id, const uint8_t *payload, size_t length, uint8_t out[MR_PACK_BYTES_MAX])
{
    struct writer w = {.bytes = out};
    put(&w, OTHER(OTHER_MESSAGE), OTHER_BITS);
    put(&w, id & 0x7ffu, 11);
    put(&w, (uint32_t)length & 15u, 4);
    for (size_t i = 0; i < length; i++)
        put(&w, payload[i], 8);
    return finish(&w);
}

size_t mr_pack_padding(unsigned at, uint8_t out[MR_PACK_BYTES_MAX])
{
    struct writer w = {.bytes = out};
    if (at % 8u == 0)
        return 0;
    unsigned after = (at + OTHER_BITS) % 8u;
    put(&w, OTHER(OTHER_PADDING), OTHER_BITS);
    put(&w, 0, after ? 8u - after : 0u);
    return finish(&w);
}

struct reader {
    const uint8_t *stream;
    size_t bits, at;
    bool short_of; /* asked for more than there is */
};

static uint32_t get(struct reader *r, unsigned bits)
{
    uint32_t value = 0;
    if (bits > r->bits - r->at) {
        r->short_of = true;
        r->at = r->bits;
        return 0;
    }
    for (unsigned i = 0; i < bits; i++, r->at++)
        value |= (uint32_t)(r->stream[r->at / 8] >> r->at % 8 & 1u) << i;
    return value;
}

static uint32_t get_rice(struct reader *r, unsigned k)
{
    uint32_t q = 0;
    while (q < ESCAPE && !r->short_of && get(r, 1) == 0)
        q++;
    return q < ESCAPE ? q << k | get(r, k) : get(r, 16);
}

static void get_block(struct reader *r, struct mr_pack *pack, unsigned tag, struct mr_block *block)
{
    uint16_t value[MR_PACK_SUMS];
    for (unsigned i = 0; i < MR_PACK_SUMS; i++) {
        uint32_t z;
        if (tag == TAG_PACKED) {
            z = get_rice(r, parameter(pack, i));
            int32_t d = (int32_t)(z >> 1) ^ -(int32_t)(z & 1u);
            value[i] = (uint16_t)((int32_t)pack->value[i] + d);
        } else {
            value[i] = (uint16_t)get(r, tag == TAG_PLAIN ? plain_bits(i) : 16u);
            int32_t d = (int32_t)value[i] - (int32_t)pack->value[i];
            z = (uint32_t)d << 1 ^ (uint32_t)(d >> 31);
        }
        remember(pack, i, z, value[i]);
    }
    *block = (struct mr_block){.index = pack->index++, .tick = pack->tick};
    pack->tick += MR_TICKS_PER_BLOCK;
    memcpy(block->plus, value, sizeof block->plus);
    memcpy(block->minus, value + MR_TRANSDUCERS, sizeof block->minus);
    memcpy(block->sum, value + 2 * MR_TRANSDUCERS, sizeof block->sum);
    memcpy(block->low, pack->low, sizeof block->low);
    memcpy(block->high, pack->high, sizeof block->high);
}

static void get_saturation(struct reader *r, struct mr_pack *pack)
{
    uint32_t mask = get(r, 24);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        uint32_t counts = mask >> c & 1u ? get(r, 8) : 0;
        pack->low[c] = (uint8_t)(counts >> 4);
        pack->high[c] = (uint8_t)(counts & 15u);
    }
}

static enum mr_status get_other(struct reader *r, struct mr_pack *pack, struct mr_record *record)
{
    record->kind = MR_RECORD_OTHER;
    switch (get(r, OTHER_BITS - MR_PACK_TAG_BITS)) {
    case OTHER_MESSAGE:
        record->kind = MR_RECORD_MESSAGE;
        record->id = (uint16_t)get(r, 11);
        record->length = (uint8_t)get(r, 4);
        for (unsigned i = 0; i < record->length; i++)
            record->payload[i] = (uint8_t)get(r, 8);
        return MR_OK;
    case OTHER_KEY:
        mr_pack_forget(pack);
        pack->keyed = true;
        pack->index = get(r, 16);
        pack->index |= get(r, 16) << 16;
        pack->tick = get(r, 16);
        pack->tick |= get(r, 16) << 16;
        return MR_OK;
    case OTHER_SATURATION:
        get_saturation(r, pack);
        return MR_OK;
    case OTHER_WIDE:
        record->kind = MR_RECORD_BLOCK;
        if (!pack->keyed)
            return MR_MALFORMED;
        get_block(r, pack, TAG_OTHER, &record->block);
        return MR_OK;
    case OTHER_PADDING:
        r->at = (r->at + 7) / 8 * 8;
        return MR_OK;
    default:
        return MR_MALFORMED;
    }
}

enum mr_status mr_unpack(struct mr_pack *pack, const uint8_t *stream, size_t bits, size_t *at, struct mr_record *record)
{
    struct reader r = {.stream = stream, .bits = bits, .at = *at};
    struct mr_pack before = *pack;
    enum mr_status status = MR_OK;
    unsigned tag = get(&r, MR_PACK_TAG_BITS);
    if (r.short_of)
        return MR_TRUNCATED;
    if (tag == TAG_OTHER) {
        status = get_other(&r, pack, record);
    } else if (tag == TAG_END) {
        record->kind = MR_RECORD_END;
    } else if (!pack->keyed) {
        status = MR_MALFORMED;
    } else {
        record->kind = MR_RECORD_BLOCK;
        get_block(&r, pack, tag, &record->block);
    }
    if (r.short_of) {
        *pack = before;
        return MR_TRUNCATED;
    }
    *at = r.at;
    return status;
}
