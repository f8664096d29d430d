/* The block record holds one millisecond of acquisition as integers. It is the basis of replay.
 *
 * TIM4 triggers both converters at 8 kHz, so a block is 8 scans. Converter 3 scans the 8
 * transducers while the excitation reverses from scan to scan, so each transducer has one sum per
 * polarity (4 codes each); converter 1 scans 16 channels (14 gages, staircase, reference; 8 codes
 * each). All output of the board depends only on these records, the edges and the commands, so a
 * replay with any codes that have the same sums and counts is identical bit for bit. The record of
 * a landing begins four blocks before the block in which it was armed, because the first means
 * reach back that far.
 *
 * A channel that is not fitted is neither converted nor stored: its sums and counts are 0 in the
 * struct and left out on the wire. Staircase and reference are always present.
 *
 * On the wire and on disk (little-endian; 78 bytes with all channels fitted and none saturated, at
 * most 102; 18 bytes with switches only):
 *     index u32 | tick u32 | absent u24 | forward_sum[8] u16 | reversed_sum[8] u16 | sum[16] u16 |
 *     mask u24 | one byte per set bit of mask
 * Bit c of `absent`: channel c is not fitted and its sums are left out. Bit c of `mask`: channel c
 * has saturated codes. The bytes after the mask follow in order of its bits; each is low count << 4
 * | high count. Channels 0..7 are the transducers, 8..23 the channels of converter 1 in scan order.
 * Layout version: MR_LAYOUT. */
#ifndef MATRIG_COMMON_BLOCK_H
#define MATRIG_COMMON_BLOCK_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

#define MR_SCANS_PER_BLOCK  8u
#define MR_TRANSDUCERS      8u
#define MR_GAGES            14u
#define MR_ADC1_CHANNELS    16u
#define MR_ADC1_STAIRCASE   14u /* index of the staircase in the scan of converter 1 */
#define MR_ADC1_REFERENCE   15u
#define MR_REFERENCE        (MR_TRANSDUCERS + MR_ADC1_REFERENCE) /* channel */
#define MR_CHANNELS         (MR_TRANSDUCERS + MR_ADC1_CHANNELS)
#define MR_BLOCK_SUMS       (2u * MR_TRANSDUCERS + MR_ADC1_CHANNELS)
#define MR_BLOCK_BYTES_MIN  (8u + 3u + 2u * 2u + 3u)
#define MR_BLOCK_BYTES_MAX  (8u + 3u + 2u * MR_BLOCK_SUMS + 3u + MR_CHANNELS)
/* Bits of the channels that may be absent. */
#define MR_BITS_TRANSDUCERS ((1u << MR_TRANSDUCERS) - 1u)
#define MR_BITS_GAGES       (((1u << MR_GAGES) - 1u) << MR_TRANSDUCERS)
#define MR_BITS_OPTIONAL    (MR_BITS_TRANSDUCERS | MR_BITS_GAGES)

#define MR_TICKS_PER_BLOCK 84000u /* ticks of TIM2 at 84 MHz */
#define MR_CODE_LOW        8u     /* codes up to this one count as saturated at the low end */
#define MR_CODE_HIGH       4087u  /* codes from this one on count as saturated at the high end */

struct mr_block {
    uint32_t index; /* number of blocks since the scans began; a jump means that blocks were lost */
    uint32_t tick;  /* value of TIM2 at the first trigger of the block, 1/84 us */
    union {
        struct {
            uint16_t forward_sum[MR_TRANSDUCERS];  /* sum of 4 codes with forward excitation */
            uint16_t reversed_sum[MR_TRANSDUCERS]; /* sum of 4 codes with reversed excitation */
            uint16_t sum[MR_ADC1_CHANNELS];        /* sums of 8 codes */
        };
        uint16_t sums[MR_BLOCK_SUMS]; /* all sums as one array */
    };
    uint32_t absent_channels;       /* bit c: channel c is not fitted */
    uint8_t low_count[MR_CHANNELS]; /* number of saturated codes, 0..8 */
    uint8_t high_count[MR_CHANNELS];
};

/* Bit i is set when sums[i] belongs to an absent channel. */
static inline uint32_t mr_block_absent_sums(uint32_t absent)
{
    uint32_t transducers = absent & MR_BITS_TRANSDUCERS;
    return transducers | transducers << MR_TRANSDUCERS |
           absent >> MR_TRANSDUCERS << 2 * MR_TRANSDUCERS;
}

/* The channels that the converters scan: those that are fitted, in order, first the transducers
 * (converter 3), then the others (converter 1). */
struct mr_scan {
    uint32_t absent_channels;
    uint8_t transducer_count, adc1_count; /* conversions per scan of ADC3 and of ADC1 */
    uint8_t channel[MR_CHANNELS];
};
/* Sets the scan to all channels except those in the bit mask `absent`. Only bits of
 * MR_BITS_OPTIONAL count. */
void mr_scan_select_channels(struct mr_scan *scan, uint32_t absent);

/* Sums 8 scans of all channels. `transducers` and `adc1` hold the 12-bit results of the converters
 * in scan order. Even scans of the block were taken with the excitation forward. */
void mr_block_from_scans(struct mr_block *block, uint32_t index, uint32_t tick,
                         uint16_t transducers[MR_SCANS_PER_BLOCK][MR_TRANSDUCERS],
                         uint16_t adc1[MR_SCANS_PER_BLOCK][MR_ADC1_CHANNELS]);

/* As mr_block_from_scans, for the channels in `scan` only: the rows have scan->transducer_count and
 * scan->adc1_count codes. */
void mr_block_from_fitted_scans(struct mr_block *block, const struct mr_scan *scan, uint32_t index,
                                uint32_t tick, const uint16_t *transducers, const uint16_t *others);

/* Writes the wire form of a block. Returns its length, MR_BLOCK_BYTES_MIN to MR_BLOCK_BYTES_MAX. */
size_t mr_block_encode(const struct mr_block *block, uint8_t out[MR_BLOCK_BYTES_MAX]);

/* Reads the wire form of a block. MR_TRUNCATED or MR_TOO_LONG: `length` does not match the masks;
 * MR_MALFORMED: impossible masks or counts. */
enum mr_status mr_block_decode(struct mr_block *block, const uint8_t *bytes, size_t length);

/* ---- time ---- */

/* Board time in 64 bits: all times in the board's messages are ticks of TIM2 (84 MHz), the only
 * clock of the board, since the scans began.
 *
 * Block b begins with its first trigger, at 84000 b ticks, which is 1000 b microseconds. Times of
 * edges, film frames, camera pulses and sync frames are sent as captured by TIM2, modulo 2^32
 * ticks, which wrap every 51.1 s. The block index sent with a capture determines the number of
 * wraps: block indices count milliseconds for 49 days, and the origin (the tick at which block 0
 * began) is the same for all blocks. Captures are therefore unambiguous even after a gap of blocks
 * of any length, if the block sent with the capture is less than 25.5 s from it. Exact integers;
 * pure functions. */

#define MR_TICKS_PER_US 84

/* Returns the value of TIM2, modulo 2^32, at the beginning of block 0, computed from the index and
 * the first tick of any block. */
static inline uint32_t mr_boardtime_origin_tick(uint32_t block, uint32_t tick)
{
    return tick - block * MR_TICKS_PER_BLOCK;
}
/* Returns the value of TIM2, modulo 2^32, at the beginning of a block; `origin` is from
 * mr_boardtime_origin_tick. */
static inline uint32_t mr_boardtime_block_tick(uint32_t origin, uint32_t block)
{
    return origin + block * MR_TICKS_PER_BLOCK;
}
/* Returns the number of ticks from the beginning of the scans to a capture that is less than 25.5 s
 * from the beginning of `block`. Negative: the capture was before the scans began. */
static inline int64_t mr_boardtime_unwrap(uint32_t origin, uint32_t block, uint32_t tick)
{
    int32_t since = (int32_t)(tick - mr_boardtime_block_tick(origin, block));
    return (int64_t)block * (int64_t)MR_TICKS_PER_BLOCK + since;
}

#endif
