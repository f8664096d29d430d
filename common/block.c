#include "common/block.h"

#include <stdbool.h>
#include <string.h>

#include "common/wire.h"

/* Two codes at a time, one in each half of a word: 8 codes of 12 bits add up to 15 bits, so nothing carries over. */
#define BOTH(code) ((uint32_t)(code) * 0x00010001u)
#define CODES 4096u

/* The codes of two neighbouring channels in one scan. */
static inline uint32_t pair_at(const uint16_t *code)
{
    uint32_t pair;
    __builtin_memcpy(&pair, code, sizeof pair);
    return pair;
}

static inline void put_pair(uint16_t *sums, uint32_t pair)
{
    __builtin_memcpy(sums, &pair, sizeof pair);
}

/* The bit of value CODES is set in a half whose code is saturated. A half that borrows from its neighbour is saturated itself: a word
 * has such a bit when, and only when, one of its codes is. */
static inline uint32_t extremes(uint32_t pair)
{
    return (pair - BOTH(MR_CODE_LOW + 1u)) | (pair + BOTH(CODES - MR_CODE_HIGH));
}

static inline bool any_saturated(uint32_t extreme)
{
    return (extreme & BOTH(CODES)) != 0;
}

static void count_saturation(struct mr_block *block, unsigned channel, const uint16_t *code, unsigned stride)
{
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++, code += stride) {
        if (*code <= MR_CODE_LOW)
            block->low[channel]++;
        else if (*code >= MR_CODE_HIGH)
            block->high[channel]++;
    }
}

static inline void count_pair(struct mr_block *block, unsigned channel, const uint16_t *code, unsigned stride)
{
    count_saturation(block, channel, code, stride);
    count_saturation(block, channel + 1, code + 1, stride);
}

void mr_block_from_scans(struct mr_block *block, uint32_t index, uint32_t tick,
                         uint16_t transducers[MR_SCANS_PER_BLOCK][MR_TRANSDUCERS],
                         uint16_t adc1[MR_SCANS_PER_BLOCK][MR_ADC1_CHANNELS])
{
    block->index = index;
    block->tick = tick;
    __builtin_memset(block->low, 0, sizeof block->low);
    __builtin_memset(block->high, 0, sizeof block->high);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i += 2) {
        uint32_t plus = 0, minus = 0, extreme = 0;
#pragma GCC unroll 4
        for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan += 2) {
            uint32_t forward = pair_at(&transducers[scan][i]), reversed = pair_at(&transducers[scan + 1][i]);
            plus += forward;
            minus += reversed;
            extreme |= extremes(forward) | extremes(reversed);
        }
        put_pair(&block->plus[i], plus);
        put_pair(&block->minus[i], minus);
        if (any_saturated(extreme))
            count_pair(block, i, &transducers[0][i], MR_TRANSDUCERS);
    }
    for (unsigned i = 0; i < MR_ADC1_CHANNELS; i += 2) {
        uint32_t sum = 0, extreme = 0;
#pragma GCC unroll 8
        for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++) {
            uint32_t pair = pair_at(&adc1[scan][i]);
            sum += pair;
            extreme |= extremes(pair);
        }
        put_pair(&block->sum[i], sum);
        if (any_saturated(extreme))
            count_pair(block, MR_TRANSDUCERS + i, &adc1[0][i], MR_ADC1_CHANNELS);
    }
}

size_t mr_block_put(const struct mr_block *block, uint8_t out[MR_BLOCK_BYTES_MAX])
{
    uint8_t *p = mr_put_u32(mr_put_u32(out, block->index), block->tick);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        p = mr_put_u16(p, block->plus[i]);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        p = mr_put_u16(p, block->minus[i]);
    for (unsigned i = 0; i < MR_ADC1_CHANNELS; i++)
        p = mr_put_u16(p, block->sum[i]);

    uint8_t *mask_at = p;
    uint32_t mask = 0;
    p += 3;
    for (unsigned channel = 0; channel < MR_CHANNELS; channel++) {
        if (block->low[channel] | block->high[channel]) {
            mask |= 1u << channel;
            p = mr_put_u8(p, (uint8_t)(block->low[channel] << 4 | block->high[channel]));
        }
    }
    mr_put_u8(mr_put_u16(mask_at, (uint16_t)mask), (uint8_t)(mask >> 16));
    return (size_t)(p - out);
}

enum mr_status mr_block_get(struct mr_block *block, const uint8_t *bytes, size_t length)
{
    const uint8_t *p = bytes;
    if (length < MR_BLOCK_BYTES_MIN)
        return MR_TRUNCATED;
    memset(block, 0, sizeof *block);
    block->index = mr_get_u32(&p);
    block->tick = mr_get_u32(&p);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        block->plus[i] = mr_get_u16(&p);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        block->minus[i] = mr_get_u16(&p);
    for (unsigned i = 0; i < MR_ADC1_CHANNELS; i++)
        block->sum[i] = mr_get_u16(&p);

    uint32_t mask = mr_get_u16(&p);
    mask |= (uint32_t)mr_get_u8(&p) << 16;
    size_t expected = MR_BLOCK_BYTES_MIN + (size_t)__builtin_popcount(mask);
    if (length != expected)
        return length < expected ? MR_TRUNCATED : MR_TOO_LONG;
    for (unsigned channel = 0; channel < MR_CHANNELS; channel++) {
        if (!(mask & 1u << channel))
            continue;
        uint8_t counts = mr_get_u8(&p);
        block->low[channel] = counts >> 4;
        block->high[channel] = counts & 15u;
        if (counts == 0 || block->low[channel] + block->high[channel] > (int)MR_SCANS_PER_BLOCK)
            return MR_MALFORMED;
    }
    return MR_OK;
}
