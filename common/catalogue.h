/* The message catalogue in C: a struct, a put function and a get function for each message of
 * catalogue.def, and tables that describe the messages.
 *
 * Real fields are floats in the unit of the field; they are NaN where the wire carries the code for
 * a missing value. A put function writes exactly the message's length (at most MR_MESSAGE_BYTES_MAX
 * bytes) and returns that length. A get function returns MR_OK, or MR_TRUNCATED or MR_TOO_LONG when
 * `length` differs from the message's length; it never reads beyond `length`. Pure functions, no
 * state. */
#ifndef MATRIG_COMMON_CATALOGUE_H
#define MATRIG_COMMON_CATALOGUE_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

/* Layout version of catalogue.def, the block record, the stored configuration and serial framing.
 * The version is the largest one in this union, whose size is that of its largest member. The
 * message `hello` contains it. */
union mr_layout_versions {
    uint8_t other_formats[3];
#define SINCE_LAYOUT(name, NAME, layout) uint8_t name[layout];
#include "common/catalogue.def"
};
#define MR_LAYOUT            ((unsigned)sizeof(union mr_layout_versions))
#define MR_MESSAGE_BYTES_MAX 8u

typedef uint8_t mr_u8;
typedef int8_t mr_i8;
typedef uint16_t mr_u16;
typedef int16_t mr_i16;
typedef uint32_t mr_u32;
typedef int32_t mr_i32;

/* Meaning of the numbers in the catalogue: for each list of values an enum (enum mr_landing_state)
 * and a function (mr_landing_state_text) that returns the text of a value. Texts are static; a
 * value beyond the table gives "unknown". */
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
#define REAL(name, type, field, counts_per_unit, unit, text) float field;
#define FLOAT(name, field, unit, text) float field;
#define END_MESSAGE(name, NAME) };
/* clang-format on */
#include "common/catalogue.def"

#define MR_BOX_PART_BYTES 134u

enum mr_message_id {
#define MESSAGE(name, NAME, id, direction, text) MR_ID_##NAME = (id),
#include "common/catalogue.def"
    MR_ID_BLOCK = 0x300, /* serial only: a block record (common/block.h), longer than a CAN frame */
    /* serial only: half a page of the black box (common/boxpage.h), record u16 | page u16 | half u8
     * | reserved u8 | 128 bytes */
    MR_ID_BOX_PART = 0x301,
};

/* Index of each message from 0, for arrays of counts. Block records and parts of black-box pages
 * have an index too. */
enum mr_message_index {
#define MESSAGE(name, NAME, id, direction, text) MR_INDEX_##NAME,
#include "common/catalogue.def"
    MR_INDEX_BLOCK,
    MR_INDEX_BOX_PART,
    MR_MESSAGE_COUNT
};

#define MESSAGE(name, NAME, id, direction, text)                                                \
    size_t mr_##name##_put(const struct mr_##name *message, uint8_t out[MR_MESSAGE_BYTES_MAX]); \
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

/* Meaning of one number of an ENUM. `text` is NULL after the last entry. */
struct mr_value {
    long number;
    const char *text; /* text for the number; "": no message contains this number */
};
enum mr_coding { MR_CODING_NONE, MR_CODING_ENUM, MR_CODING_FLAGS, MR_CODING_BIT_PAIRS };

struct mr_field_info {
    const char *name;
    const char *unit;
    const char *text;              /* text in the table; mr_field_text returns it in full */
    const struct mr_value *values; /* NULL: the numbers have no names */
    enum mr_coding coding;
    enum mr_wire_type type;
    uint8_t offset;        /* position of the first byte in the payload */
    uint8_t size;          /* bytes */
    float counts_per_unit; /* counts per unit; 0: the field is not a scaled real */
};

struct mr_message_info {
    const char *name;
    const char *text;
    uint16_t id;
    enum mr_direction direction;
    uint8_t length; /* length of the payload, bytes */
    uint8_t field_count;
    uint16_t period_ms; /* period, ms; 0: not periodic */
    const struct mr_field_info *fields;
};

/* Returns the table of all messages, in ascending order of identifier, and their number in
 * `*count`. Static storage. */
const struct mr_message_info *mr_catalogue_messages(size_t *count);
/* Returns the message with this identifier, or NULL. Static storage. */
const struct mr_message_info *mr_message_find(uint16_t id);
/* These functions convert between identifier and index. mr_message_index returns MR_MESSAGE_COUNT
 * if the catalogue has no such message. */
unsigned mr_message_index(uint16_t id);
uint16_t mr_message_id_at(unsigned index);
/* Returns the name of the message with this index. Static storage. */
const char *mr_message_name(unsigned index);
/* Writes the text of a field with its list of values, truncated to `size`. */
void mr_field_text(const struct mr_field_info *field, char *out, size_t size);
/* Returns the value of a field in its unit; NaN if it is missing. `payload` has the message's
 * length. */
double mr_field_value(const struct mr_field_info *field, const uint8_t *payload);

/* ---- message ---- */

/* A decoded message of the catalogue, independent of the wire format. These functions are pure. */

struct mr_message {
    const struct mr_message_info *info;
    unsigned index; /* enum mr_message_index: selects the member of `as` */
    /* low 16 bits of the block that the message belongs to; -1: no such field */
    int32_t block16;
    int64_t block;                         /* full block index; -1: no such field */
    uint8_t payload[MR_MESSAGE_BYTES_MAX]; /* as received, info->length bytes */
    union {
#define MESSAGE(name, NAME, id, direction, text) struct mr_##name name;
#include "common/catalogue.def"
    } as;
};

/* Decodes a message. MR_UNKNOWN: the catalogue has no such message; MR_TRUNCATED or MR_TOO_LONG:
 * wrong length. On failure the content of `message` is undefined. */
enum mr_status mr_message_decode(struct mr_message *message, uint16_t id, const uint8_t *payload,
                                 size_t length);

/* ---- series ---- */

/* Readings packed over several messages: displacements and tensions on CAN, as defined by the
 * SERIES and SERIES_PACK rows of common/catalogue_series.def.
 *
 * Each of these messages is called a pack. It contains up to three readings as i16 in
 * `counts_per_unit` counts per inch or pound. In the last pack of a series, one bit for each
 * reading of the series follows, which is set if the reading is missing. Every pack ends with the
 * low 16 bits of the measured block. Pure. */

#define MR_PACK_READINGS 3u

enum mr_series_number {
#define SERIES(series, NAME, letter, unit, counts_per_unit, readings, blocks, what, text) \
    MR_SERIES_##NAME,
#include "common/catalogue.def"
    MR_SERIES_COUNT
};

enum mr_series_pack_number {
#define SERIES_PACK(SERIES_NAME, name, NAME, id, first, count) MR_PACK_##NAME,
#include "common/catalogue.def"
    MR_SERIES_PACK_COUNT
};

struct mr_series {
    enum mr_channel_kind kind; /* kind of the channels; their numbers begin at 1 */
    char letter;               /* prefix of a channel's name: d1, t14 */
    uint8_t reading_count;     /* number of readings, at most 16 */
    /* number of blocks averaged in a reading, which is also the number of blocks between two
     * packs */
    uint8_t averaged_blocks;
    float counts_per_unit; /* counts per inch or pound */
};

struct mr_series_pack {
    uint16_t id;
    uint8_t series;        /* enum mr_series_number */
    uint8_t first_reading; /* number of the first reading in the pack, from 1 */
    uint8_t reading_count;
};

/* These functions return a row of the tables; `number` is below MR_SERIES_COUNT or
 * MR_SERIES_PACK_COUNT. Static storage. */
const struct mr_series *mr_series_at(unsigned number);
const struct mr_series_pack *mr_series_pack_at(unsigned number);
/* Returns the number of the pack with an identifier; MR_SERIES_PACK_COUNT: the message is not a
 * pack. */
unsigned mr_series_pack_find(uint16_t id);
/* Writes one pack. `readings` holds all readings of the series, NaN if missing; `index` is the
 * block measured. Returns the length. */
size_t mr_series_pack_put(const struct mr_series_pack *pack, const float *readings, uint32_t index,
                          uint8_t out[MR_MESSAGE_BYTES_MAX]);
/* Reads the readings of a pack and returns their number. `payload` has the message's length. */
unsigned mr_series_pack_get(const struct mr_series_pack *pack, const uint8_t *payload,
                            float readings[MR_PACK_READINGS]);

#endif
