#include "common/block.h"

#include <string.h>

#include "common/wire.h"

static void count_saturation(struct mr_block *block, unsigned channel, uint16_t code)
{
    if (code <= MR_CODE_LOW)
        block->low[channel]++;
    else if (code >= MR_CODE_HIGH)
        block->high[channel]++;
}

void mr_block_from_scans(struct mr_block *block, uint32_t index, uint32_t tick,
                         uint16_t transducers[MR_SCANS_PER_BLOCK][MR_TRANSDUCERS],
                         uint16_t adc1[MR_SCANS_PER_BLOCK][MR_ADC1_CHANNELS])
{
    memset(block, 0, sizeof *block);
    block->index = index;
    block->tick = tick;
    for (unsigned scan = 0; scan < MR_SCANS_PER_BLOCK; scan++) {
        uint16_t *polarity = scan % 2 == 0 ? block->plus : block->minus;
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            uint16_t code = transducers[scan][i];
            polarity[i] = (uint16_t)(polarity[i] + code);
            count_saturation(block, i, code);
        }
        for (unsigned i = 0; i < MR_ADC1_CHANNELS; i++) {
            uint16_t code = adc1[scan][i];
            block->sum[i] = (uint16_t)(block->sum[i] + code);
            count_saturation(block, MR_TRANSDUCERS + i, code);
        }
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
