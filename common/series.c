#include "common/series.h"

#include "common/wire.h"

static const struct mr_series all_series[MR_SERIES_COUNT] = {
#define SERIES(series, NAME, letter, unit, per_unit, readings, blocks, what, text) \
    {MR_KIND_##NAME, #letter[0], readings, blocks, per_unit},
#include "common/catalogue.def"
};

static const struct mr_series_pack packs[MR_SERIES_PACKS] = {
#define PACK(SERIES_NAME, name, NAME, id, first, count) {id, MR_SERIES_##SERIES_NAME, first, count},
#include "common/catalogue.def"
};

#define SERIES(series, NAME, letter, unit, per_unit, readings, blocks, what, text) \
    _Static_assert((readings) <= 16, "no room for a bit of each reading of " #series);
#include "common/catalogue.def"

const struct mr_series *mr_series_at(unsigned number)
{
    return &all_series[number];
}

const struct mr_series_pack *mr_series_pack_at(unsigned number)
{
    return &packs[number];
}

unsigned mr_series_pack_find(uint16_t id)
{
    unsigned number = 0;
    while (number < MR_SERIES_PACKS && packs[number].id != id)
        number++;
    return number;
}

static uint16_t missing_of(const float *readings, unsigned count)
{
    uint16_t mask = 0;
    for (unsigned i = 0; i < count; i++) {
        if (__builtin_isnan(readings[i]))
            mask = (uint16_t)(mask | 1u << i);
    }
    return mask;
}

size_t mr_series_pack_put(const struct mr_series_pack *pack, const float *readings, uint32_t index,
                          uint8_t out[MR_MESSAGE_MAX])
{
    const struct mr_series *series = &all_series[pack->series];
    uint8_t *p = out;
    for (unsigned i = 0; i < pack->count; i++)
        p = mr_put_real_i16(p, readings[pack->first - 1u + i], series->per_unit);
    if (pack->count < MR_PACK_READINGS)
        p = mr_put_u16(p, missing_of(readings, series->readings));
    p = mr_put_u16(p, (uint16_t)index);
    return (size_t)(p - out);
}

unsigned mr_series_pack_get(const struct mr_series_pack *pack, const uint8_t *payload,
                            float readings[MR_PACK_READINGS])
{
    for (unsigned i = 0; i < pack->count; i++)
        readings[i] = mr_get_real_i16(&payload, all_series[pack->series].per_unit);
    return pack->count;
}
