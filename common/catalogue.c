#include "common/catalogue.h"

#include "common/wire.h"

/* put: field by field, in the order of the table. */
#define MESSAGE(name, NAME, id, direction, text)                                       \
    size_t mr_##name##_put(const struct mr_##name *message, uint8_t out[MR_MESSAGE_MAX]) \
    {                                                                                  \
        uint8_t *p = out;
#define INTEGER(name, type, field, unit, text) p = mr_put_##type(p, message->field);
#define REAL(name, type, field, per_unit, unit, text) p = mr_put_real_##type(p, message->field, per_unit);
#define FLOAT(name, field, unit, text) p = mr_put_f32(p, message->field);
#define END(name, NAME)         \
        return (size_t)(p - out); \
    }
#include "common/catalogue.def"
#undef MESSAGE
#undef INTEGER
#undef REAL
#undef FLOAT
#undef END

/* Wire image of a message: only its size and offsets are used, so a struct of byte arrays needs no packing. */
#define SIZE_u8 1
#define SIZE_i8 1
#define SIZE_u16 2
#define SIZE_i16 2
#define SIZE_u32 4
#define SIZE_i32 4
#define MESSAGE(name, NAME, id, direction, text) struct name##_wire {
#define INTEGER(name, type, field, unit, text) uint8_t field[SIZE_##type];
#define REAL(name, type, field, per_unit, unit, text) uint8_t field[SIZE_##type];
#define FLOAT(name, field, unit, text) uint8_t field[4];
#define END(name, NAME)                                                                       \
    };                                                                                        \
    _Static_assert(sizeof(struct name##_wire) <= MR_MESSAGE_MAX, "message " #name " is longer than a CAN frame");
#include "common/catalogue.def"
#undef MESSAGE
#undef INTEGER
#undef REAL
#undef FLOAT
#undef END

#define MESSAGE(name, NAME, id, direction, text)                                                    \
    enum mr_status mr_##name##_get(struct mr_##name *message, const uint8_t *bytes, size_t length)  \
    {                                                                                               \
        const uint8_t *p = bytes;                                                                   \
        if (length != sizeof(struct name##_wire))                                                   \
            return length < sizeof(struct name##_wire) ? MR_TRUNCATED : MR_TOO_LONG;
#define INTEGER(name, type, field, unit, text) message->field = mr_get_##type(&p);
#define REAL(name, type, field, per_unit, unit, text) message->field = mr_get_real_##type(&p, per_unit);
#define FLOAT(name, field, unit, text) message->field = mr_get_f32(&p);
#define END(name, NAME) \
        return MR_OK;   \
    }
#include "common/catalogue.def"
#undef MESSAGE
#undef INTEGER
#undef REAL
#undef FLOAT
#undef END

#define MESSAGE(name, NAME, id, direction, text) static const struct mr_field_info name##_fields[] = {
#define INTEGER(name, type, field, unit, text) \
    {#field, unit, text, MR_WIRE_##type, offsetof(struct name##_wire, field), SIZE_##type, 0.0f},
#define REAL(name, type, field, per_unit, unit, text) \
    {#field, unit, text, MR_WIRE_##type, offsetof(struct name##_wire, field), SIZE_##type, per_unit},
#define FLOAT(name, field, unit, text) \
    {#field, unit, text, MR_WIRE_f32, offsetof(struct name##_wire, field), 4, 0.0f},
#define END(name, NAME) };
#include "common/catalogue.def"
#undef MESSAGE
#undef INTEGER
#undef REAL
#undef FLOAT
#undef END

static const struct mr_message_info messages[] = {
#define MESSAGE(name, NAME, id, direction, text)                                                 \
    {#name, text, id, MR_DIRECTION_##direction, sizeof(struct name##_wire),                      \
     sizeof name##_fields / sizeof name##_fields[0], name##_fields},
#define INTEGER(name, type, field, unit, text)
#define REAL(name, type, field, per_unit, unit, text)
#define FLOAT(name, field, unit, text)
#define END(name, NAME)
#include "common/catalogue.def"
#undef MESSAGE
#undef INTEGER
#undef REAL
#undef FLOAT
#undef END
};

const struct mr_message_info *mr_catalogue(size_t *count)
{
    *count = sizeof messages / sizeof messages[0];
    return messages;
}

const struct mr_message_info *mr_message_find(uint16_t id)
{
    for (size_t i = 0; i < sizeof messages / sizeof messages[0]; i++) {
        if (messages[i].id == id)
            return &messages[i];
    }
    return NULL;
}

unsigned mr_message_place(uint16_t id)
{
    switch (id) {
#define MESSAGE(name, NAME, id, direction, text) case id: return MR_PLACE_##NAME;
#define INTEGER(name, type, field, unit, text)
#define REAL(name, type, field, per_unit, unit, text)
#define FLOAT(name, field, unit, text)
#define END(name, NAME)
#include "common/catalogue.def"
#undef MESSAGE
#undef INTEGER
#undef REAL
#undef FLOAT
#undef END
    case MR_ID_BLOCK: return MR_PLACE_BLOCK;
    case MR_ID_BOX_PART: return MR_PLACE_BOX_PART;
    default: return MR_PLACES;
    }
}

uint16_t mr_message_at(unsigned place)
{
    if (place < sizeof messages / sizeof messages[0])
        return messages[place].id;
    return place == MR_PLACE_BLOCK ? MR_ID_BLOCK : MR_ID_BOX_PART;
}

const char *mr_message_text(unsigned place)
{
    if (place < sizeof messages / sizeof messages[0])
        return messages[place].name;
    return place == MR_PLACE_BLOCK ? "block" : "box_part";
}

double mr_field_value(const struct mr_field_info *field, const uint8_t *payload)
{
    const uint8_t *p = payload + field->offset;
    if (field->per_unit > 0.0f) {
        return (double)(field->type == MR_WIRE_u16 ? mr_get_real_u16(&p, field->per_unit)
                                                   : mr_get_real_i16(&p, field->per_unit));
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
