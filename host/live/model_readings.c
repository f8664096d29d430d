/* The channels' readings: the newest of each, and the buckets of which curves are drawn. */
#include <math.h>
#include <string.h>

#include "host/live/model_parts.h"

#define MISSING             ((float)NAN)
#define RECORD_FRESH_BLOCKS 200 /* while records are this new, CAN says nothing that they do not */
#define SILENT_BLOCKS       500 /* a link so far behind the other brings nothing more */
#define TELLING_BLOCKS      10

void live_model_begin_readings(struct live_model *model)
{
    for (unsigned i = 0; i < LIVE_CHANNELS; i++)
        model->reading[i] =
            (struct live_reading){.value = MISSING, .block = -1, .least = MISSING, .most = MISSING};
    for (unsigned i = 0; i < LIVE_OPEN_BUCKETS; i++)
        model->open[i].bucket = -1;
    model->closed_to = -1;
    model->record_block = -1;
}

static void close_bucket(struct live_model *model, struct live_bucket *bucket)
{
    if (model->closed_count == LIVE_CLOSED_BUCKETS) {
        memmove(model->closed, model->closed + 1,
                (LIVE_CLOSED_BUCKETS - 1) * sizeof model->closed[0]);
        model->closed_count--;
        model->forgotten++;
    }
    model->closed[model->closed_count++] = *bucket;
    if (bucket->bucket > model->closed_to)
        model->closed_to = bucket->bucket;
    bucket->bucket = -1;
}

/* Closes the open buckets up to `last`, in order. */
static void close_to(struct live_model *model, int64_t last)
{
    for (;;) {
        struct live_bucket *oldest = NULL;
        for (unsigned i = 0; i < LIVE_OPEN_BUCKETS; i++) {
            struct live_bucket *bucket = &model->open[i];
            if (bucket->bucket >= 0 && bucket->bucket <= last &&
                (!oldest || bucket->bucket < oldest->bucket))
                oldest = bucket;
        }
        if (!oldest)
            return;
        close_bucket(model, oldest);
    }
}

/* The bucket of a block; NULL: it is closed already. */
static struct live_bucket *bucket_of(struct live_model *model, int64_t block)
{
    int64_t number = block / LIVE_BUCKET_BLOCKS;
    struct live_bucket *bucket = &model->open[number % LIVE_OPEN_BUCKETS];
    if (block < 0 || number <= model->closed_to) {
        model->late += block >= 0;
        return NULL;
    }
    close_to(model, number - LIVE_OPEN_BUCKETS);
    if (bucket->bucket != number) { /* what was there is LIVE_OPEN_BUCKETS older, so closed */
        bucket->bucket = number;
        for (unsigned i = 0; i < LIVE_CHANNELS; i++)
            bucket->least[i] = bucket->most[i] = MISSING;
    }
    return bucket;
}

static void take_reading(struct live_model *model, struct live_bucket *bucket, unsigned index,
                         float value, unsigned validity, int64_t block)
{
    struct live_reading *reading = &model->reading[index];
    if (block >= reading->block) {
        reading->block = block;
        reading->value = value;
        reading->validity = (uint8_t)validity;
    }
    reading->least = fminf(reading->least, value); /* NaN is no number to fminf */
    reading->most = fmaxf(reading->most, value);
    bucket->least[index] = fminf(bucket->least[index], value);
    bucket->most[index] = fmaxf(bucket->most[index], value);
}

void live_model_settle(struct live_model *model)
{
    int64_t can = model->link[LINK_CAN].newest, serial = model->link[LINK_SERIAL].newest,
            passed = live_model_block(model);
    int64_t behind = can < serial ? can : serial;
    if (behind >= 0 && passed - behind < SILENT_BLOCKS)
        passed = behind;
    /* A message is told some blocks after the readings it is about. */
    close_to(model, (passed - TELLING_BLOCKS) / LIVE_BUCKET_BLOCKS - 1);
}

unsigned live_model_take(struct live_model *model, struct live_bucket *out, unsigned most)
{
    unsigned count = model->closed_count < most ? model->closed_count : most;
    memcpy(out, model->closed, count * sizeof *out);
    model->closed_count -= count;
    memmove(model->closed, model->closed + count, model->closed_count * sizeof model->closed[0]);
    return count;
}

void live_model_end_readings(struct live_model *model)
{
    close_to(model, INT64_MAX);
}

void live_model_take_block(struct live_model *model, const struct mr_block *block)
{
    struct live_bucket *bucket = bucket_of(model, block->index);
    float ratio = mr_channels_ratio(&model->channel[MR_REFERENCE], block);
    model->records++;
    if ((int64_t)block->index > model->record_block)
        model->record_block = block->index;
    for (unsigned i = 0; i < LIVE_CHANNELS && bucket; i++) {
        if (!live_model_calibrated(model, i) || block->absent >> i & 1u)
            continue;
        struct mr_reading reading = mr_channel_read(&model->channel[i], block, i, ratio);
        take_reading(model, bucket, i, reading.value, reading.validity, block->index);
    }
}

void live_model_take_values(struct live_model *model, unsigned first, unsigned count,
                            const float *values, int64_t block)
{
    if (model->record_block >= 0 && block - model->record_block < RECORD_FRESH_BLOCKS)
        return;
    struct live_bucket *bucket = bucket_of(model, block);
    for (unsigned i = 0; i < count && bucket; i++) {
        bool fitted = !model->channel_known[first + i] ||
                      mr_channel_measures(&model->channel[first + i]);
        if (fitted)
            take_reading(model, bucket, first + i, values[i],
                         isnan(values[i]) ? MR_INVALID_SATURATED : MR_VALID, block);
    }
}
