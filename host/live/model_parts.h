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

/* Readings: no channel has one yet, no bucket is open. All open buckets are closed. */
void live_model_begin_readings(struct live_model *model);
void live_model_end_readings(struct live_model *model);
/* Those of a record; of a CAN message: `count` channels, `first` on. */
void live_model_take_block(struct live_model *model, const struct mr_block *block);
void live_model_take_values(struct live_model *model, unsigned first, unsigned count,
                            const float *values, int64_t block);

#endif
