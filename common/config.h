/* Configuration of the instrument: site, channels with their calibration, switches, bands. Fields, units and limits: config.def. */
#ifndef MATRIG_COMMON_CONFIG_H
#define MATRIG_COMMON_CONFIG_H

#include <stdint.h>

#define MR_CONFIG_SWITCHES 24u
#define MR_CONFIG_BANDS 4u
#define MR_CONFIG_POINTS 8u

enum mr_config_wheel { MR_WHEEL_MAIN = 0, MR_WHEEL_NOSE = 1, MR_WHEEL_OTHER = 2 };

/* struct mr_site_config, mr_channel_config, mr_gate_config, mr_band_config. */
#define MR_CONFIG_u8 uint8_t
#define MR_CONFIG_u16 uint16_t
#define MR_CONFIG_u32 uint32_t
#define GROUP(name, count) struct mr_##name##_config {
#define INTEGER(group, type, field, least, most, unit, text) MR_CONFIG_##type field;
#define REAL(group, field, least, most, unit, text) float field;
#define REALS(group, field, count, least, most, unit, text) float field[count];
#define TEXT(group, field, size, text) char field[size];
#define END(name) };
#include "common/config.def"
#undef GROUP
#undef INTEGER
#undef REAL
#undef REALS
#undef TEXT
#undef END

struct mr_config {
#define GROUP(name, count) struct mr_##name##_config name[count];
#define INTEGER(group, type, field, least, most, unit, text)
#define REAL(group, field, least, most, unit, text)
#define REALS(group, field, count, least, most, unit, text)
#define TEXT(group, field, size, text)
#define END(name)
#include "common/config.def"
#undef GROUP
#undef INTEGER
#undef REAL
#undef REALS
#undef TEXT
#undef END
};

#endif
