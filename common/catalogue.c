#include "common/catalogue.h"

#include <stdbool.h>
#include <string.h>

#include "common/wire.h"

/* put functions: write the fields in the order of the table */
/* clang-format off */
#define MESSAGE(name, NAME, id, direction, text)                                         \
    size_t mr_##name##_put(const struct mr_##name *message, uint8_t out[MR_MESSAGE_BYTES_MAX]) \
    {                                                                                    \
        uint8_t *p = out;
#define INTEGER(name, type, field, unit, text) p = mr_put_##type(p, message->field);
#define REAL(name, type, field, counts_per_unit, unit, text) \
    p = mr_put_real_##type(p, message->field, counts_per_unit);
#define FLOAT(name, field, unit, text) p = mr_put_f32(p, message->field);
#define END_MESSAGE(name, NAME)   \
        return (size_t)(p - out); \
    }
#include "common/catalogue.def"

/* Wire layout of a message as a struct of byte arrays. Only its size and offsets are used, so it
 * needs no packing. */
#define SIZE_u8 1
#define SIZE_i8 1
#define SIZE_u16 2
#define SIZE_i16 2
#define SIZE_u32 4
#define SIZE_i32 4
#define MESSAGE(name, NAME, id, direction, text) struct name##_wire {
#define INTEGER(name, type, field, unit, text) uint8_t field[SIZE_##type];
#define REAL(name, type, field, counts_per_unit, unit, text) uint8_t field[SIZE_##type];
#define FLOAT(name, field, unit, text) uint8_t field[4];
#define END_MESSAGE(name, NAME)                                        \
    };                                                                 \
    _Static_assert(sizeof(struct name##_wire) <= MR_MESSAGE_BYTES_MAX, \
        "message " #name " is longer than a CAN frame");
#include "common/catalogue.def"

#define MESSAGE(name, NAME, id, direction, text)                                                   \
    enum mr_status mr_##name##_get(struct mr_##name *message, const uint8_t *bytes, size_t length) \
    {                                                                                              \
        const uint8_t *p = bytes;                                                                  \
        if (length != sizeof(struct name##_wire))                                                  \
            return length < sizeof(struct name##_wire) ? MR_TRUNCATED : MR_TOO_LONG;
#define INTEGER(name, type, field, unit, text) message->field = mr_get_##type(&p);
#define REAL(name, type, field, counts_per_unit, unit, text) \
    message->field = mr_get_real_##type(&p, counts_per_unit);
#define FLOAT(name, field, unit, text) message->field = mr_get_f32(&p);
#define END_MESSAGE(name, NAME) \
        return MR_OK;           \
    }
#include "common/catalogue.def"

#define ENUM(values) static const struct mr_value values##_values[] = {
#define VALUE(values, NAME, number, word) {number, word},
#define UNSENT_VALUE(values, NAME, number, text) {number, ""},
#define END_ENUM(values) {0, NULL}};
#include "common/catalogue.def"

#define ENUM(values)                               \
    const char *mr_##values##_text(unsigned value) \
    {                                              \
        switch (value) {
#define VALUE(values, NAME, number, word) case number: return word;
#define DESCRIBED_VALUE(values, NAME, number, word, text) case number: return text;
#define END_ENUM(values)           \
        default: return "unknown"; \
        }                          \
    }
#include "common/catalogue.def"

#define MESSAGE(name, NAME, id, direction, text) \
    static const struct mr_field_info name##_fields[] = {
#define FIELD_OF_VALUES(name, type, field, values, coding, text)                            \
    {#field, "", text, values, coding, MR_WIRE_##type, offsetof(struct name##_wire, field), \
     SIZE_##type, 0.0f},
#define ENUMERATED(name, type, field, values, text) \
    FIELD_OF_VALUES(name, type, field, values##_values, MR_CODING_ENUM, text)
#define FLAGS(name, type, field, values, text) \
    FIELD_OF_VALUES(name, type, field, values##_values, MR_CODING_FLAGS, text)
#define BIT_PAIRS(name, type, field, values, text) \
    FIELD_OF_VALUES(name, type, field, values##_values, MR_CODING_BIT_PAIRS, text)
#define INTEGER(name, type, field, unit, text)                                              \
    {#field, unit, text, NULL, MR_CODING_NONE, MR_WIRE_##type, offsetof(struct name##_wire, \
     field), SIZE_##type, 0.0f},
#define REAL(name, type, field, counts_per_unit, unit, text)                                       \
    {#field, unit, text, NULL, MR_CODING_NONE, MR_WIRE_##type, offsetof(struct name##_wire, \
     field), SIZE_##type, counts_per_unit},
#define FLOAT(name, field, unit, text)                                                           \
    {#field, unit, text, NULL, MR_CODING_NONE, MR_WIRE_f32, offsetof(struct name##_wire, field), \
     4, 0.0f},
#define END_MESSAGE(name, NAME) };
/* clang-format on */
#include "common/catalogue.def"

static const struct mr_message_info messages[] = {
/* clang-format off */
#define MESSAGE(this, NAME, number, way, words)                                                 \
    [MR_INDEX_##NAME] = {.name = #this, .text = words, .id = number,                            \
                         .direction = MR_DIRECTION_##way, .length = sizeof(struct this##_wire), \
                         .field_count = sizeof this##_fields / sizeof this##_fields[0],         \
                             .fields = this##_fields,
#define PERIOD_MS(name, NAME, ms) .period_ms = ms,
#define END_MESSAGE(name, NAME) },
/* clang-format on */
#include "common/catalogue.def"
};

const struct mr_message_info *mr_catalogue_messages(size_t *count)
{
    *count = sizeof messages / sizeof messages[0];
    return messages;
}

const struct mr_message_info *mr_message_find(uint16_t id)
{
    unsigned place = mr_message_index(id);
    return place < sizeof messages / sizeof messages[0] ? &messages[place] : NULL;
}

unsigned mr_message_index(uint16_t id)
{
    switch (id) {
/* clang-format off */
#define MESSAGE(name, NAME, id, direction, text) case id: return MR_INDEX_##NAME;
/* clang-format on */
#include "common/catalogue.def"
    case MR_ID_BLOCK: return MR_INDEX_BLOCK;
    case MR_ID_BOX_PART: return MR_INDEX_BOX_PART;
    default: return MR_MESSAGE_COUNT;
    }
}

/* Uses a list of identifiers of its own. With the table above, the texts would be linked into the
 * image of the board. */
uint16_t mr_message_id_at(unsigned index)
{
    static const uint16_t ids[] = {
#define MESSAGE(name, NAME, id, direction, text) id,
#include "common/catalogue.def"
        MR_ID_BLOCK,
        MR_ID_BOX_PART,
    };
    return index < MR_MESSAGE_COUNT ? ids[index] : 0;
}

const char *mr_message_name(unsigned index)
{
    if (index < sizeof messages / sizeof messages[0])
        return messages[index].name;
    return index == MR_INDEX_BLOCK ? "block" : "box_part";
}

static void append(char **out, const char *end, const char *text)
{
    while (*text && *out < end)
        *(*out)++ = *text++;
}

static void append_number(char **out, const char *end, long number)
{
    char digits[3 * sizeof number + 1], *at = digits + sizeof digits;
    *--at = '\0';
    do {
        *--at = (char)('0' + number % 10);
        number /= 10;
    } while (number > 0);
    append(out, end, at);
}

/* Writes the list of values, "0 idle, 1 armed, 2 landing"; for a bit field, the numbers of the
 * bits. */
static void append_values(char **out, const char *end, const struct mr_field_info *field)
{
    bool first = true;
    for (const struct mr_value *value = field->values; value->text; value++) {
        long number = value->number;
        if (!value->text[0])
            continue;
        for (number = field->coding == MR_CODING_FLAGS ? 0 : number;
             field->coding == MR_CODING_FLAGS && value->number >> number > 1;)
            number++;
        append(out, end, first ? "" : ", ");
        append_number(out, end, number);
        append(out, end, " ");
        append(out, end, value->text);
        first = false;
    }
}

void mr_field_text(const struct mr_field_info *field, char *out, size_t size)
{
    const char *end = out + size - 1;
    for (const char *text = field->text; *text; text++) {
        if (*text == '*' && field->values)
            append_values(&out, end, field);
        else
            append(&out, end, (const char[]){*text, '\0'});
    }
    *out = '\0';
}

double mr_field_value(const struct mr_field_info *field, const uint8_t *payload)
{
    const uint8_t *p = payload + field->offset;
    if (field->counts_per_unit > 0.0f) {
        return (double)(field->type == MR_WIRE_u16 ? mr_get_real_u16(&p, field->counts_per_unit)
                                                   : mr_get_real_i16(&p, field->counts_per_unit));
    }
    switch (field->type) {
    case MR_WIRE_u8: return mr_get_u8(&p);
    case MR_WIRE_i8: return mr_get_i8(&p);
    case MR_WIRE_u16: return mr_get_u16(&p);
    case MR_WIRE_i16: return mr_get_i16(&p);
    case MR_WIRE_u32: return mr_get_u32(&p);
    case MR_WIRE_i32: return mr_get_i32(&p);
    case MR_WIRE_f32: break;
    }
    return (double)mr_get_f32(&p);
}

/* ---- message ---- */

/* Reads the block of a message from its last field, if that is `block16` or `block`. */
static void read_block_index(struct mr_message *message, const struct mr_message_info *info,
                             const uint8_t *payload)
{
    const struct mr_field_info *last = &info->fields[info->field_count - 1];
    const uint8_t *p = payload + last->offset;
    bool low = strcmp(last->name, "block16") == 0, all = strcmp(last->name, "block") == 0;
    message->block16 = low ? mr_get_u16(&p) : -1;
    message->block = all ? (int64_t)mr_get_u32(&p) : -1;
}

enum mr_status mr_message_decode(struct mr_message *message, uint16_t id, const uint8_t *payload,
                                 size_t length)
{
    unsigned place = mr_message_index(id);
    const struct mr_message_info *info = mr_message_find(id);
    if (!info)
        return MR_UNKNOWN;
    if (length != info->length)
        return length < info->length ? MR_TRUNCATED : MR_TOO_LONG;
    memset(message, 0, sizeof *message);
    message->info = info;
    message->index = place;
    read_block_index(message, info, payload);
    memcpy(message->payload, payload, length);
    switch (place) {
/* clang-format off */
#define MESSAGE(name, NAME, id, direction, text) \
    case MR_INDEX_##NAME: return mr_##name##_get(&message->as.name, payload, length);
/* clang-format on */
#include "common/catalogue.def"
    default: return MR_UNKNOWN;
    }
}

/* ---- series ---- */

static const struct mr_series all_series[MR_SERIES_COUNT] = {
#define SERIES(series, NAME, letter, unit, counts_per_unit, readings, blocks, what, text) \
    {MR_KIND_##NAME, #letter[0], readings, blocks, counts_per_unit},
#include "common/catalogue.def"
};

static const struct mr_series_pack series_packs[MR_SERIES_PACK_COUNT] = {
#define SERIES_PACK(SERIES_NAME, name, NAME, id, first, count) \
    {id, MR_SERIES_##SERIES_NAME, first, count},
#include "common/catalogue.def"
};

#define SERIES(series, NAME, letter, unit, counts_per_unit, readings, blocks, what, text) \
    _Static_assert((readings) <= 16, "the mask has too few bits for the readings of " #series);
#include "common/catalogue.def"

const struct mr_series *mr_series_at(unsigned number)
{
    return &all_series[number];
}

const struct mr_series_pack *mr_series_pack_at(unsigned number)
{
    return &series_packs[number];
}

unsigned mr_series_pack_find(uint16_t id)
{
    unsigned number = 0;
    while (number < MR_SERIES_PACK_COUNT && series_packs[number].id != id)
        number++;
    return number;
}

static uint16_t get_missing_bits(const float *readings, unsigned count)
{
    uint16_t mask = 0;
    for (unsigned i = 0; i < count; i++) {
        if (__builtin_isnan(readings[i]))
            mask = (uint16_t)(mask | 1u << i);
    }
    return mask;
}

size_t mr_series_pack_put(const struct mr_series_pack *pack, const float *readings, uint32_t index,
                          uint8_t out[MR_MESSAGE_BYTES_MAX])
{
    const struct mr_series *series = &all_series[pack->series];
    uint8_t *p = out;
    for (unsigned i = 0; i < pack->reading_count; i++)
        p = mr_put_real_i16(p, readings[pack->first_reading - 1u + i], series->counts_per_unit);
    if (pack->reading_count < MR_PACK_READINGS)
        p = mr_put_u16(p, get_missing_bits(readings, series->reading_count));
    p = mr_put_u16(p, (uint16_t)index);
    return (size_t)(p - out);
}

unsigned mr_series_pack_get(const struct mr_series_pack *pack, const uint8_t *payload,
                            float readings[MR_PACK_READINGS])
{
    for (unsigned i = 0; i < pack->reading_count; i++)
        readings[i] = mr_get_real_i16(&payload, all_series[pack->series].counts_per_unit);
    return pack->reading_count;
}
