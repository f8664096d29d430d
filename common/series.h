/* Readings packed over several messages: displacements and tensions on CAN, as the SERIES and PACK
 * rows of common/catalogue_series.def have them.
 *
 * A pack is one of the messages. It carries up to three readings as i16, `per_unit` counts to an
 * inch or pound; then, the last pack of a series alone, a bit for each reading of the series that
 * is missing; then the low 16 bits of the block measured. Pure. */
#ifndef MATRIG_COMMON_SERIES_H
#define MATRIG_COMMON_SERIES_H

#include "common/catalogue.h"

#define MR_PACK_READINGS 3u

enum mr_series_number {
#define SERIES(series, NAME, letter, unit, per_unit, readings, blocks, what, text) MR_SERIES_##NAME,
#include "common/catalogue.def"
    MR_SERIES_COUNT
};

enum mr_series_pack_number {
#define PACK(SERIES_NAME, name, NAME, id, first, count) MR_PACK_##NAME,
#include "common/catalogue.def"
    MR_SERIES_PACKS
};

struct mr_series {
    enum mr_channel_kind kind; /* of its channels, which are numbered from 1 */
    char letter;               /* d1, t14 */
    uint8_t readings;          /* at most 16 */
    uint8_t blocks;            /* each is the mean of as many, and comes every so many */
    float per_unit;            /* counts to an inch or pound */
};

struct mr_series_pack {
    uint16_t id;
    uint8_t series; /* enum mr_series_number */
    uint8_t first;  /* reading, from 1 */
    uint8_t count;
};

/* `number` below MR_SERIES_COUNT or MR_SERIES_PACKS. Static storage. */
const struct mr_series *mr_series_at(unsigned number);
const struct mr_series_pack *mr_series_pack_at(unsigned number);
/* Number of the pack with an identifier; MR_SERIES_PACKS: the message is none. */
unsigned mr_series_pack_find(uint16_t id);
/* Writes a pack of all readings of its series, NaN what is missing; `index`: the block measured.
 * Returns its length. */
size_t mr_series_pack_put(const struct mr_series_pack *pack, const float *readings, uint32_t index,
                          uint8_t out[MR_MESSAGE_MAX]);
/* Readings of a pack's payload, which has the message's length; returns how many. */
unsigned mr_series_pack_get(const struct mr_series_pack *pack, const uint8_t *payload,
                            float readings[MR_PACK_READINGS]);

#endif
