/* Insides of the model: its parts, which host/live/model.c puts together. */
#ifndef MATRIG_HOST_LIVE_MODEL_PARTS_H
#define MATRIG_HOST_LIVE_MODEL_PARTS_H

#include "host/live/model.h"

/* Declares `m`, the message got from its payload, or returns true: it is none. */
#define GET(name)                                      \
    struct mr_##name m;                                \
    if (mr_##name##_get(&m, payload, length) != MR_OK) \
    return true

/* Identity and configuration. True: it was one of these. */
bool live_model_take_configuration(struct live_model *model, uint16_t id, const uint8_t *payload, size_t length);

#endif
