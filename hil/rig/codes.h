/* Converter codes that have given sums and counts of saturation: what a block record leaves open is
 * chosen here. */
#ifndef MATRIG_HIL_CODES_H
#define MATRIG_HIL_CODES_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"

#define HIL_CODES_PER_POLARITY (MR_SCANS_PER_BLOCK / 2u)

/* The codes of one block: of the transducers by polarity of the excitation (0 forward), each in
 * order of the scans. */
struct hil_codes {
    uint16_t transducer[2][MR_TRANSDUCERS][HIL_CODES_PER_POLARITY];
    uint16_t adc1[MR_ADC1_CHANNELS][MR_SCANS_PER_BLOCK];
};

/* Codes whose sums and counts are the block's, zeroes of channels that are absent. False: there are
 * none; `*channel` (0 to MR_CHANNELS - 1) is the first for which it is so. */
bool hil_codes_of(const struct mr_block *block, struct hil_codes *codes, unsigned *channel);

#endif
