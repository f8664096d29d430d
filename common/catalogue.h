/* The message catalogue in C: a struct, a put and a get for each message of catalogue.def, and
 * tables that describe them.
 *
 * Real fields are floats in the field's unit, NaN where the wire says missing. A put writes exactly
 * the message's length (at most MR_MESSAGE_MAX bytes) and returns it. A get returns MR_OK, or
 * MR_TRUNCATED / MR_TOO_LONG when `length` is not the message's own; it never reads beyond
 * `length`. Pure functions, no state. */
#ifndef MATRIG_COMMON_CATALOGUE_H
#define MATRIG_COMMON_CATALOGUE_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

/* Layout version of catalogue.def, of the block record, the stored configuration and serial
 * framing: that of what changed last, so the size of the largest of these. Travels in `hello`. */
union mr_layouts {
    uint8_t all_others[3];
#define SINCE(name, NAME, layout) uint8_t name[layout];
#include "common/catalogue.def"
};
#define MR_LAYOUT      ((unsigned)sizeof(union mr_layouts))
#define MR_MESSAGE_MAX 8u

typedef uint8_t mr_u8;
typedef int8_t mr_i8;
typedef uint16_t mr_u16;
typedef int16_t mr_i16;
typedef uint32_t mr_u32;
typedef int32_t mr_i32;

/* What the numbers of the catalogue mean: enum mr_landing_state and its like, and
 * mr_landing_state_text(): the text of a value, static, "unknown" beyond the table. */
/* clang-format off */
#define ENUM(values) enum mr_##values {
#define VALUE(values, NAME, number, word) NAME = (number),
#define END_ENUM(values) };
/* clang-format on */
#include "common/catalogue.def"

#define ENUM(values) const char *mr_##values##_text(unsigned value);
#include "common/catalogue.def"

/* clang-format off */
#define MESSAGE(name, NAME, id, direction, text) struct mr_##name {
#define INTEGER(name, type, field, unit, text) mr_##type field;
#define REAL(name, type, field, per_unit, unit, text) float field;
#define FLOAT(name, field, unit, text) float field;
#define END(name, NAME) };
/* clang-format on */
#include "common/catalogue.def"

#define MR_BOX_PART_BYTES 134u

enum mr_message_id {
#define MESSAGE(name, NAME, id, direction, text) MR_ID_##NAME = (id),
#include "common/catalogue.def"
    MR_ID_BLOCK = 0x300, /* serial only: a block record (common/block.h), longer than a CAN frame */
    /* serial only: half a page of the black box (common/boxpage.h): record u16 | page u16 | half u8
     * | reserved u8 | 128 bytes */
    MR_ID_BOX_PART = 0x301,
};

/* Each message, block records and black-box parts included, has a place from 0 on, for tables of
 * counts. */
enum mr_message_place {
#define MESSAGE(name, NAME, id, direction, text) MR_PLACE_##NAME,
#include "common/catalogue.def"
    MR_PLACE_BLOCK,
    MR_PLACE_BOX_PART,
    MR_PLACES
};

#define MESSAGE(name, NAME, id, direction, text)                                          \
    size_t mr_##name##_put(const struct mr_##name *message, uint8_t out[MR_MESSAGE_MAX]); \
    enum mr_status mr_##name##_get(struct mr_##name *message, const uint8_t *bytes, size_t length);
#include "common/catalogue.def"

enum mr_direction { MR_DIRECTION_BOTH, MR_DIRECTION_CAN, MR_DIRECTION_HOST };
enum mr_wire_type {
    MR_WIRE_u8,
    MR_WIRE_i8,
    MR_WIRE_u16,
    MR_WIRE_i16,
    MR_WIRE_u32,
    MR_WIRE_i32,
    MR_WIRE_f32
};

/* What a number of ENUM means. `word` NULL: behind the last one. */
struct mr_value {
    long number;
    const char *word; /* "": no message carries it */
};
enum mr_coding { MR_CODING_NONE, MR_CODING_CODE, MR_CODING_BITS, MR_CODING_PAIRS };

struct mr_field_info {
    const char *name;
    const char *unit;
    const char *text;              /* as it stands in the table: mr_field_text has it in full */
    const struct mr_value *values; /* NULL: none have names */
    enum mr_coding coding;
    enum mr_wire_type type;
    uint8_t offset; /* first byte in the payload */
    uint8_t size;   /* bytes */
    float per_unit; /* counts to one unit; 0: not a scaled real */
};

struct mr_message_info {
    const char *name;
    const char *text;
    uint16_t id;
    enum mr_direction direction;
    uint8_t length; /* bytes of payload */
    uint8_t field_count;
    uint16_t every_ms; /* 0: it does not come by the clock */
    const struct mr_field_info *fields;
};

/* The whole table, ascending by identifier; `*count` messages. Static storage. */
const struct mr_message_info *mr_catalogue(size_t *count);
/* The message with this identifier, or NULL. */
const struct mr_message_info *mr_message_find(uint16_t id);
/* Place of an identifier, below MR_PLACES; MR_PLACES: there is no such message. And back. */
unsigned mr_message_place(uint16_t id);
uint16_t mr_message_at(unsigned place);
/* Name of the message at a place. Static storage. */
const char *mr_message_text(unsigned place);
/* Text of a field, its list of values written out; cut off at `size`. */
void mr_field_text(const struct mr_field_info *field, char *out, size_t size);
/* Value of a field of a payload that has the message's length, in the field's unit; NaN when
 * missing. */
double mr_field_value(const struct mr_field_info *field, const uint8_t *payload);

#endif
