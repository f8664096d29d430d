/* Channels: from block records to inches and pounds, each with its validity.
 *
 *     displacement = ((plus - minus) / 8 - zero_code) * unit_per_code * ratio      plus, minus: sums of 4 codes
 *     tension      = (sum / 8 - zero_code) * unit_per_code * ratio                 sum: of 8 codes
 *     ratio        = MR_REFERENCE_CODE / (reference sum / 8)
 *
 * The transducers are excited with alternating polarity, so half the difference of the two polarities is the synchronous
 * demodulation: offsets of amplifier and converter cancel. The reference channel takes the converter's scale out of both.
 * A reading that is not valid has value NaN. Single precision, no library calls: host and board agree bit for bit. */
#ifndef MATRIG_COMMON_CHANNELS_H
#define MATRIG_COMMON_CHANNELS_H

#include <stdint.h>

#include "common/block.h"
#include "common/config.h"

#define MR_REFERENCE_CODE 3103.0f   /* 2.500 V of 3.300 V, 4096 codes */
#define MR_REFERENCE_SPAN 0.02f     /* relative; beyond it nothing measured against it is valid */
#define MR_COMMON_MODE_LOW 1638.0f  /* mean of both polarities, codes: a driven transducer sits at mid-scale, 2048; */
#define MR_COMMON_MODE_HIGH 2458.0f /* beyond these (a fifth off) it is open or shorted */

enum mr_channel_kind {
    MR_KIND_NONE = 0,
    MR_KIND_DISPLACEMENT = 1,
    MR_KIND_TENSION = 2,
    MR_KIND_STAIRCASE = 3,
    MR_KIND_REFERENCE = 4,
};

enum mr_validity {
    MR_VALID = 0,
    MR_INVALID_NOT_FITTED = 1,
    MR_INVALID_SATURATED = 2, /* at least one code of the block at an end of the converter */
    MR_INVALID_OPEN = 3,      /* common mode out of range: broken or shorted lead */
    MR_INVALID_REFERENCE = 4, /* the reference channel is out of range */
};

struct mr_reading {
    float value; /* in or lb; NaN unless valid */
    uint8_t validity;
};

/* Scale correction of a block, MR_REFERENCE_CODE over its reference; NaN when the reference is out of range. */
float mr_channels_ratio(const struct mr_block *block);

/* Reading of channel 0..MR_CHANNELS-1 of a block; `ratio` from mr_channels_ratio of the same block. Staircase and
 * reference read as mean codes, without ratio. */
struct mr_reading mr_channel_read(const struct mr_channel_config *config, const struct mr_block *block,
                                  unsigned channel, float ratio);

/* Short text of a validity. Static storage. */
const char *mr_validity_text(unsigned validity);

#endif
