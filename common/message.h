/* A message of the catalogue, read once: who gets it need not know how it stood on the wire.
 * Pure. */
#ifndef MATRIG_COMMON_MESSAGE_H
#define MATRIG_COMMON_MESSAGE_H

#include "common/catalogue.h"

struct mr_message {
    const struct mr_message_info *info;
    unsigned place; /* enum mr_message_place: which member of `as` it is */
    /* low 16 bits of the block that it belongs to; -1: it has no such field */
    int32_t block16;
    int64_t block;                   /* all of it; -1: it has no such field */
    uint8_t payload[MR_MESSAGE_MAX]; /* as it came, info->length bytes */
    union {
#define MESSAGE(name, NAME, id, direction, text) struct mr_##name name;
#include "common/catalogue.def"
    } as;
};

/* MR_OK; MR_UNKNOWN: the catalogue has no such message; MR_TRUNCATED, MR_TOO_LONG: its length is
 * another one. Then `message` says nothing. */
enum mr_status mr_message_read(struct mr_message *message, uint16_t id, const uint8_t *payload,
                               size_t length);

#endif
