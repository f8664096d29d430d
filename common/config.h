/* Configuration of the instrument: site, channels with their calibration, switches, bands,
 * predictor. config.def has the fields, units and limits.
 *
 * Stored form: MR_CONFIG_IMAGE_BYTES bytes, little-endian, identical in flash, on the links and in
 * the database:
 *
 *      0  "MRCF"
 *      4  format u16 (MR_CONFIG_FORMAT) | 0 u16
 *      8  length u32 of the whole stored form
 *     12  layout u32: CRC-32 of the names, types and counts of all fields (mr_config_layout_crc)
 *     16  revision u32, copied from the group site
 *     20  every field, in the order of the table; TEXT unchanged
 *      .  0 to 3 bytes of 0 that make the length a multiple of 4
 *     -4  CRC-32 of everything before it; this number identifies the configuration everywhere
 *
 * A configuration has exactly one stored form. Pure functions, no state. */
#ifndef MATRIG_COMMON_CONFIG_H
#define MATRIG_COMMON_CONFIG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/status.h"

#define MR_CONFIG_SWITCHES 24u
#define MR_CONFIG_BANDS    4u
#define MR_CONFIG_POINTS   8u

/* One struct per group: mr_site_config, mr_channel_config, mr_gate_config, mr_band_config ... */
/* clang-format off */
#define MR_CONFIG_u8 uint8_t
#define MR_CONFIG_u16 uint16_t
#define MR_CONFIG_u32 uint32_t
#define GROUP(name, count) struct mr_##name##_config {
#define INTEGER(group, type, field, least, most, unit, text) MR_CONFIG_##type field;
#define REAL(group, field, least, most, unit, text) float field;
#define REALS(group, field, count, least, most, unit, text) float field[count];
#define TEXT(group, field, size, text) char field[size];
#define END_GROUP(name) };
/* clang-format on */
#include "common/config.def"

struct mr_config {
#define GROUP(name, count) struct mr_##name##_config name[count];
#include "common/config.def"
};

/* Numbers of the groups (MR_GROUP_site) and of the fields of each group (MR_FIELD_site_name), from
 * 0. */
enum mr_config_group_number {
#define GROUP(name, count) MR_GROUP_##name,
#include "common/config.def"
    MR_CONFIG_GROUP_COUNT
};
/* clang-format off */
#define GROUP(name, count) enum mr_config_##name##_field {
#define INTEGER(group, type, field, least, most, unit, text) MR_FIELD_##group##_##field,
#define REAL(group, field, least, most, unit, text) MR_FIELD_##group##_##field,
#define REALS(group, field, count, least, most, unit, text) MR_FIELD_##group##_##field,
#define TEXT(group, field, size, text) MR_FIELD_##group##_##field,
#define END_GROUP(name) MR_FIELDS_##name };
/* clang-format on */
#include "common/config.def"

/* Total bytes of all fields in the table. */
enum {
    MR_CONFIG_FIELD_BYTES = 0
#define SIZE_u8  1u
#define SIZE_u16 2u
#define SIZE_u32 4u
#define GROUP(name, count) + (count) * (0u
#define INTEGER(group, type, field, least, most, unit, text) +SIZE_##type
#define REAL(group, field, least, most, unit, text)          +4u
#define REALS(group, field, count, least, most, unit, text)  +4u * (count)
#define TEXT(group, field, size, text)                       +(size)
#define END_GROUP(name) )
#include "common/config.def"
#undef SIZE_u8
#undef SIZE_u16
#undef SIZE_u32
};

#define MR_CONFIG_FORMAT       1u
#define MR_CONFIG_HEADER_BYTES 20u
#define MR_CONFIG_IMAGE_BYTES \
    ((MR_CONFIG_HEADER_BYTES + (unsigned)MR_CONFIG_FIELD_BYTES + 3u) / 4u * 4u + 4u)
#define MR_CONFIG_WORDS (MR_CONFIG_IMAGE_BYTES / 4u)

enum mr_config_type {
    MR_CONFIG_TYPE_u8,
    MR_CONFIG_TYPE_u16,
    MR_CONFIG_TYPE_u32,
    MR_CONFIG_TYPE_REAL,
    MR_CONFIG_TYPE_OPTIONAL,
    MR_CONFIG_TYPE_TEXT
};

struct mr_config_field {
    const char *name;
    uint8_t type;              /* enum mr_config_type */
    uint8_t count;             /* number of elements; for a text, number of bytes */
    uint16_t offset;           /* offset in the struct of its group */
    uint32_t int_min, int_max; /* limits of an integer */
    float real_min, real_max;  /* limits of a real */
};

struct mr_config_group {
    const char *name;
    uint8_t count; /* number of groups of this kind */
    uint8_t field_count;
    /* offset: of the first member in struct mr_config; size: of one member */
    uint16_t offset, size;
    const struct mr_config_field *fields;
};

/* All MR_CONFIG_GROUP_COUNT groups. Static storage. */
extern const struct mr_config_group mr_config_groups[];

/* Returns the station of the main bogie's lead wheel at the moment when switch `i` (from 0) opens.
 * All stations of the gear are those of this wheel. */
static inline float mr_config_gate_ft(const struct mr_config *config, unsigned i)
{
    return config->gate[i].station_ft - config->site[0].wheel_ahead_ft;
}

uint32_t mr_config_layout_crc(void);
/* Writes the stored form, MR_CONFIG_IMAGE_BYTES bytes. Returns its CRC-32, which is also in the
 * last four bytes. */
uint32_t mr_config_encode(const struct mr_config *config, uint8_t *image);
/* Checks that `image` is a complete configuration of this table. MR_MALFORMED: not a configuration;
 * MR_TRUNCATED: longer than `length`; MR_CRC; MR_VERSION: intact, but of a different format or
 * table. The values are not checked; use mr_config_check for them. */
enum mr_status mr_config_check_image(const uint8_t *image, size_t length);
/* Calls mr_config_check_image and, if it returns MR_OK, reads the configuration; else `config` is
 * unchanged. */
enum mr_status mr_config_decode(const uint8_t *image, size_t length, struct mr_config *config);
/* Swaps the field values of a complete image and of `config`; a second call restores both. The
 * revision and CRC of the image are not updated. */
void mr_config_swap_image(uint8_t *image, struct mr_config *config);

/* Rules that a configuration must meet. The brackets give the meaning of `other`. */
/* clang-format off */
#define MR_CONFIG_RULE_TABLE(X)                                                                    \
    X(TOO_SMALL,     1, "below its minimum")                                                       \
    X(TOO_LARGE,     2, "above its maximum")                                                       \
    X(NOT_A_NUMBER,  3, "not a number")                                                            \
    X(NOT_TEXT,      4, "must be printable ASCII, padded with zero bytes")                         \
    X(NOT_ABOVE,     5, "must be greater than another field [other: its number in the group]")     \
    X(NOT_RISING,    6, "must be greater than the preceding value [other: its index, from 0]")     \
    X(SUM_TOO_LARGE, 7, "zero code plus the steps up to this one exceeds the converter's range")   \
    X(STEPS_TOO_CLOSE, 8, "too close to the step of another switch [other: that switch, from 0]")  \
    X(MUST_NOT_BE_ZERO, 9, "must not be 0 for a fitted part")                                      \
    X(NUMBER_IN_USE, 10, "another channel of this kind has this number [other: its index, from 0]")\
    X(WRONG_INPUT,  11, "this input cannot measure that kind")                                     \
    X(NO_BAND,      12, "the band is not fitted: its pretension is 0")                             \
    X(ONE_POINT,    13, "must be 0, or 2 or more points")                                          \
    X(NO_STATION,   14, "must have a station")                                                     \
    X(REVISION,     15, "must be the active revision plus 1: another change was made meanwhile")   \
    X(UNSTABLE,     16, "beyond the stability limit for this mat weight and joint stiffness")      \
    X(CODE_TOO_COARSE, 17, "the value per code is larger than that of any sensor of the rig")      \
    X(CODE_TOO_FINE, 18, "the value per code is smaller than that of any sensor of the rig")       \
    X(RANGE_TOO_NARROW, 19, "the range low to high covers too few codes")                          \
    X(RANGE_UNREACHABLE, 20, "most of the range low to high is outside the converter's range")     \
    X(NO_INPUT,     21, "this board has no such input")
/* clang-format on */

enum mr_config_rule {
    MR_RULE_NONE = 0,
#define MR_CONFIG_RULE_ENUM(NAME, number, text) MR_RULE_##NAME = (number),
    MR_CONFIG_RULE_TABLE(MR_CONFIG_RULE_ENUM) MR_RULE_COUNT
};
#undef MR_CONFIG_RULE_ENUM

struct mr_config_violation {
    uint8_t group, index, field, element; /* place of the violation; numbers from 0 */
    uint8_t rule, other;
};

/* Minimum distances of staircase steps, codes. A step must be at least twice the tolerance for
 * identifying it, because smaller changes are ignored. Two steps must differ by the second number:
 * an edge is assigned to the switch with the nearest step, and measured steps (matrig ready --walk)
 * repeat to 2 codes. Steps that are set by design values should be 8 apart. */
#define MR_CONFIG_STEP_MIN_CODES          8u
#define MR_CONFIG_STEP_DISTANCE_MIN_CODES 6u

/* Checks a configuration. MR_LIMIT: `reason` has the first violation. The limits of all fields are
 * checked first, then the relations between fields. */
enum mr_status mr_config_check(const struct mr_config *config, struct mr_config_violation *reason);

/* Start parameters of the predictor (common/predictor.h), from the groups site and predict and the
 * stations of the transducers. */
struct mr_predictor_config;
void mr_config_get_predictor(const struct mr_config *config, struct mr_predictor_config *predictor);

#endif
