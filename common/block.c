#include "common/block.h"

#include <stdbool.h>
#include <string.h>

#include "common/wire.h"

/* A code in both halves of a word. Two codes are processed at a time; the sum of 8 codes of 12 bits
 * has 15 bits, so no half overflows into the other. */
#define IN_BOTH_HALVES(code) ((uint32_t)(code)*0x00010001u)
#define CODE_RANGE           4096u

/* Returns the codes of two neighbouring channels in one scan, as the halves of a word. */
static inline uint32_t get_pair(const uint16_t *code)
{
    uint32_t pair;
    __builtin_memcpy(&pair, code, sizeof pair);
    return pair;
}

static inline void put_pair(uint16_t *sums, uint32_t pair)
{
    __builtin_memcpy(sums, &pair, sizeof pair);
}

/* Returns a word with the bit CODE_RANGE set in each half with a saturated code. A half that
 * borrows from the other one is itself saturated, so the result is zero exactly if no code is
 * saturated. */
static inline uint32_t get_saturation_bits(uint32_t pair)
{
    return (pair - IN_BOTH_HALVES(MR_CODE_LOW + 1u)) |
           (pair + IN_BOTH_HALVES(CODE_RANGE - MR_CODE_HIGH));
}

static inline bool has_saturation(uint32_t extreme)
{
    return (extreme & IN_BOTH_HALVES(CODE_RANGE)) != 0;
}

static void count_saturation(struct mr_block *block, unsigned channel, const uint16_t *code,
                             unsigned stride)
{
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++, code += stride) {
        if (*code <= MR_CODE_LOW)
            block->low_count[channel]++;
        else if (*code >= MR_CODE_HIGH)
            block->high_count[channel]++;
    }
}

static inline void count_pair_saturation(struct mr_block *block, unsigned channel,
                                         const uint16_t *code, unsigned stride)
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
    block->absent_channels = 0;
    __builtin_memset(block->low_count, 0, sizeof block->low_count);
    __builtin_memset(block->high_count, 0, sizeof block->high_count);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i += 2) {
        uint32_t plus = 0, minus = 0, extreme = 0;
#pragma GCC unroll 4
        for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan += 2) {
            uint32_t forward = get_pair(&transducers[scan][i]),
                     reversed = get_pair(&transducers[scan + 1][i]);
            plus += forward;
            minus += reversed;
            extreme |= get_saturation_bits(forward) | get_saturation_bits(reversed);
        }
        put_pair(&block->forward_sum[i], plus);
        put_pair(&block->reversed_sum[i], minus);
        if (has_saturation(extreme))
            count_pair_saturation(block, i, &transducers[0][i], MR_TRANSDUCERS);
    }
    for (unsigned i = 0; i < MR_ADC1_CHANNELS; i += 2) {
        uint32_t sum = 0, extreme = 0;
#pragma GCC unroll 8
        for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++) {
            uint32_t pair = get_pair(&adc1[scan][i]);
            sum += pair;
            extreme |= get_saturation_bits(pair);
        }
        put_pair(&block->sum[i], sum);
        if (has_saturation(extreme))
            count_pair_saturation(block, MR_TRANSDUCERS + i, &adc1[0][i], MR_ADC1_CHANNELS);
    }
}

void mr_scan_select_channels(struct mr_scan *scan, uint32_t absent)
{
    unsigned count = 0;
    *scan = (struct mr_scan){.absent_channels = absent & MR_BITS_OPTIONAL};
    for (unsigned channel = 0; channel < MR_CHANNELS; channel++) {
        if (scan->absent_channels >> channel & 1u)
            continue;
        scan->channel[count++] = (uint8_t)channel;
        if (channel < MR_TRANSDUCERS)
            scan->transducer_count++;
    }
    scan->adc1_count = (uint8_t)(count - scan->transducer_count);
}

/* Sums even and odd scans of a converter, a pair of columns at a time, and counts saturated
 * codes. */
static void sum_columns(struct mr_block *block, const uint8_t *channel, unsigned count,
                        const uint16_t *code, uint16_t even[MR_ADC1_CHANNELS],
                        uint16_t odd[MR_ADC1_CHANNELS])
{
    unsigned i = 0;
    for (; i + 1 < count; i += 2) {
        uint32_t sum_even = 0, sum_odd = 0, extreme = 0;
        const uint16_t *at = code + i;
        for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan += 2, at += 2 * count) {
            uint32_t first = get_pair(at), second = get_pair(at + count);
            sum_even += first;
            sum_odd += second;
            extreme |= get_saturation_bits(first) | get_saturation_bits(second);
        }
        put_pair(even + i, sum_even);
        put_pair(odd + i, sum_odd);
        if (has_saturation(extreme)) {
            count_saturation(block, channel[i], code + i, count);
            count_saturation(block, channel[i + 1], code + i + 1, count);
        }
    }
    if (i == count)
        return;
    even[i] = odd[i] = 0; /* the last column alone, if the number of columns is odd */
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan += 2) {
        even[i] = (uint16_t)(even[i] + code[scan * count + i]);
        odd[i] = (uint16_t)(odd[i] + code[(scan + 1) * count + i]);
    }
    count_saturation(block, channel[i], code + i, count);
}

void mr_block_from_fitted_scans(struct mr_block *block, const struct mr_scan *scan, uint32_t index,
                                uint32_t tick, const uint16_t *transducers, const uint16_t *others)
{
    uint16_t even[MR_ADC1_CHANNELS], odd[MR_ADC1_CHANNELS];
    const uint8_t *channel = scan->channel;
    *block =
        (struct mr_block){.index = index, .tick = tick, .absent_channels = scan->absent_channels};
    sum_columns(block, channel, scan->transducer_count, transducers, even, odd);
    for (unsigned i = 0; i < scan->transducer_count; i++) {
        block->forward_sum[channel[i]] = even[i];
        block->reversed_sum[channel[i]] = odd[i];
    }
    channel += scan->transducer_count;
    sum_columns(block, channel, scan->adc1_count, others, even, odd);
    for (unsigned i = 0; i < scan->adc1_count; i++)
        block->sum[channel[i] - MR_TRANSDUCERS] = (uint16_t)(even[i] + odd[i]);
}

static uint8_t *put_u24(uint8_t *p, uint32_t value)
{
    return mr_put_u8(mr_put_u16(p, (uint16_t)value), (uint8_t)(value >> 16));
}

static uint32_t get_u24(const uint8_t **p)
{
    uint32_t low = mr_get_u16(p);
    return low | (uint32_t)mr_get_u8(p) << 16;
}

size_t mr_block_encode(const struct mr_block *block, uint8_t out[MR_BLOCK_BYTES_MAX])
{
    uint8_t *p = put_u24(mr_put_u32(mr_put_u32(out, block->index), block->tick),
                         block->absent_channels);
    uint32_t absent = mr_block_absent_sums(block->absent_channels);
    for (unsigned i = 0; i < MR_BLOCK_SUMS; i++) {
        if (!(absent >> i & 1u))
            p = mr_put_u16(p, block->sums[i]);
    }

    uint8_t *mask_at = p;
    uint32_t mask = 0;
    p += 3;
    for (unsigned channel = 0; channel < MR_CHANNELS; channel++) {
        if (block->low_count[channel] | block->high_count[channel]) {
            mask |= 1u << channel;
            p = mr_put_u8(p,
                          (uint8_t)(block->low_count[channel] << 4 | block->high_count[channel]));
        }
    }
    put_u24(mask_at, mask);
    return (size_t)(p - out);
}

enum mr_status mr_block_decode(struct mr_block *block, const uint8_t *bytes, size_t length)
{
    const uint8_t *p = bytes;
    if (length < MR_BLOCK_BYTES_MIN)
        return MR_TRUNCATED;
    memset(block, 0, sizeof *block);
    block->index = mr_get_u32(&p);
    block->tick = mr_get_u32(&p);
    block->absent_channels = get_u24(&p);
    if (block->absent_channels & ~MR_BITS_OPTIONAL)
        return MR_MALFORMED;
    uint32_t absent = mr_block_absent_sums(block->absent_channels);
    size_t expected = 8u + 3u + 2u * (MR_BLOCK_SUMS - (size_t)__builtin_popcount(absent)) + 3u;
    if (length < expected)
        return MR_TRUNCATED;
    for (unsigned i = 0; i < MR_BLOCK_SUMS; i++) {
        if (!(absent >> i & 1u))
            block->sums[i] = mr_get_u16(&p);
    }

    uint32_t mask = get_u24(&p);
    if (mask & block->absent_channels)
        return MR_MALFORMED;
    expected += (size_t)__builtin_popcount(mask);
    if (length != expected)
        return length < expected ? MR_TRUNCATED : MR_TOO_LONG;
    for (unsigned channel = 0; channel < MR_CHANNELS; channel++) {
        if (!(mask & 1u << channel))
            continue;
        uint8_t counts = mr_get_u8(&p);
        block->low_count[channel] = counts >> 4;
        block->high_count[channel] = counts & 15u;
        if (counts == 0 ||
            block->low_count[channel] + block->high_count[channel] > (int)MR_SCANS_PER_BLOCK)
            return MR_MALFORMED;
    }
    return MR_OK;
}
