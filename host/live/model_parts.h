/* Insides of the model: its parts, which host/live/model.c puts together. */
#ifndef MATRIG_HOST_LIVE_MODEL_PARTS_H
#define MATRIG_HOST_LIVE_MODEL_PARTS_H

#include "host/live/model.h"

/* A message that is the board's, with what the links tell of it. */
struct live_heard {
    const struct mr_message *message;
    struct live_link *link;
    int64_t host_us;
    int64_t block; /* its time; -1: not known */
};

/* Identity and configuration. */
void live_model_take_configuration(struct live_model *model, const struct live_heard *heard);

#endif
