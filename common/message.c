#include "common/message.h"

#include <stdbool.h>
#include <string.h>

#include "common/wire.h"

/* `block16` or `block`, in which it happened, is the last field where there is one. */
static void take_block(struct mr_message *message, const struct mr_message_info *info,
                       const uint8_t *payload)
{
    const struct mr_field_info *last = &info->fields[info->field_count - 1];
    const uint8_t *p = payload + last->offset;
    bool low = strcmp(last->name, "block16") == 0, all = strcmp(last->name, "block") == 0;
    message->block16 = low ? mr_get_u16(&p) : -1;
    message->block = all ? (int64_t)mr_get_u32(&p) : -1;
}

enum mr_status mr_message_read(struct mr_message *message, uint16_t id, const uint8_t *payload,
                               size_t length)
{
    unsigned place = mr_message_place(id);
    const struct mr_message_info *info = mr_message_find(id);
    if (!info)
        return MR_UNKNOWN;
    if (length != info->length)
        return length < info->length ? MR_TRUNCATED : MR_TOO_LONG;
    memset(message, 0, sizeof *message);
    message->info = info;
    message->place = place;
    take_block(message, info, payload);
    memcpy(message->payload, payload, length);
    switch (place) {
/* clang-format off */
#define MESSAGE(name, NAME, id, direction, text) \
    case MR_PLACE_##NAME: return mr_##name##_get(&message->as.name, payload, length);
/* clang-format on */
#include "common/catalogue.def"
    default: return MR_UNKNOWN;
    }
}
