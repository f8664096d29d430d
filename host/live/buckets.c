#include "host/live/buckets.h"

#include <math.h>
#include <string.h>

#include "common/catalogue.h"

#define MISSING_VALUE            ((float)NAN)
/* A block this much older than the newest one means that the board has restarted. */
#define RESTART_MIN_BLOCKS       1000
/* Values from CAN are ignored while the newest block record is not older than this. */
#define RECORD_AGE_MAX_BLOCKS    200
/* a link that is this far behind the other one counts as stopped */
#define LINK_SILENCE_MIN_BLOCKS  500
#define SENDING_DELAY_MAX_BLOCKS 10 /* a message can be sent this many blocks after its readings */

static void reset_buckets(struct live_buckets *b)
{
    for (unsigned i = 0; i < LIVE_CHANNEL_COUNT; i++)
        b->reading[i] = (struct live_reading){
            .value = MISSING_VALUE, .block = -1, .min = MISSING_VALUE, .max = MISSING_VALUE};
    for (unsigned i = 0; i < LIVE_OPEN_BUCKETS_MAX; i++)
        b->open_bucket[i].number = -1;
    b->newest_block[LINK_CAN] = b->newest_block[LINK_SERIAL] = b->newest_closed_bucket =
        b->newest_record_block = -1;
}

void live_buckets_init(struct live_buckets *buckets)
{
    memset(buckets, 0, sizeof *buckets);
    reset_buckets(buckets);
}

static void close_bucket(struct live_buckets *b, struct live_bucket *bucket)
{
    if (b->closed_count == LIVE_CLOSED_BUCKETS_MAX) {
        memmove(b->closed_bucket, b->closed_bucket + 1,
                (LIVE_CLOSED_BUCKETS_MAX - 1) * sizeof b->closed_bucket[0]);
        b->closed_count--;
        b->late_reading_count++;
    }
    b->closed_bucket[b->closed_count++] = *bucket;
    if (bucket->number > b->newest_closed_bucket)
        b->newest_closed_bucket = bucket->number;
    bucket->number = -1;
}

/* Closes the open buckets up to `last`, in order. */
static void close_buckets_until(struct live_buckets *b, int64_t last)
{
    for (;;) {
        struct live_bucket *oldest = NULL;
        for (unsigned i = 0; i < LIVE_OPEN_BUCKETS_MAX; i++) {
            struct live_bucket *bucket = &b->open_bucket[i];
            if (bucket->number >= 0 && bucket->number <= last &&
                (!oldest || bucket->number < oldest->number))
                oldest = bucket;
        }
        if (!oldest)
            return;
        close_bucket(b, oldest);
    }
}

bool live_buckets_advance(struct live_buckets *b, enum link_kind link, int64_t block)
{
    bool again = block >= 0 && b->newest_block[link] - block >= RESTART_MIN_BLOCKS;
    if (again) {
        close_buckets_until(b, INT64_MAX);
        reset_buckets(b);
        b->restart_count++;
    }
    if (block > b->newest_block[link])
        b->newest_block[link] = block;
    return again;
}

/* Returns the bucket of a block; NULL: the bucket is already closed. */
static struct live_bucket *find_bucket(struct live_buckets *b, int64_t block)
{
    int64_t number = block / LIVE_BUCKET_BLOCKS;
    struct live_bucket *bucket = &b->open_bucket[number % LIVE_OPEN_BUCKETS_MAX];
    if (block < 0 || number <= b->newest_closed_bucket) {
        b->late_reading_count += block >= 0;
        return NULL;
    }
    close_buckets_until(b, number - LIVE_OPEN_BUCKETS_MAX);
    /* the old content is of a bucket LIVE_OPEN_BUCKETS_MAX earlier, which is already closed */
    if (bucket->number != number) {
        bucket->number = number;
        for (unsigned i = 0; i < LIVE_CHANNEL_COUNT; i++)
            bucket->min[i] = bucket->max[i] = MISSING_VALUE;
    }
    return bucket;
}

static void add_reading(struct live_buckets *b, struct live_bucket *bucket, unsigned index,
                        float value, unsigned validity, int64_t block)
{
    struct live_reading *reading = &b->reading[index];
    if (block >= reading->block) {
        reading->block = block;
        reading->value = value;
        reading->validity = (uint8_t)validity;
    }
    reading->min = fminf(reading->min, value); /* fminf and fmaxf ignore NaN */
    reading->max = fmaxf(reading->max, value);
    bucket->min[index] = fminf(bucket->min[index], value);
    bucket->max[index] = fmaxf(bucket->max[index], value);
}

static bool is_calibrated(const struct live_buckets *b, unsigned index)
{
    const struct mr_channel_config *known = &b->channel[index];
    unsigned points = known->points < MR_CONFIG_POINTS ? known->points : MR_CONFIG_POINTS;
    uint32_t needed = (1u << (MR_CALIBRATION_FIRST_POINT_ITEM + 2u * points)) - 1u;
    if (!b->channel_known[index] || known->kind == MR_KIND_NONE)
        return b->channel_known[index];
    return b->zero_known[index] &&
           (!mr_channel_is_sensor(known) || (b->calibration_known[index] & needed) == needed);
}

void live_buckets_add_record(struct live_buckets *b, const struct mr_block *record)
{
    struct live_bucket *bucket = find_bucket(b, record->index);
    float ratio = mr_reference_ratio(&b->channel[MR_REFERENCE], record);
    b->record_count++;
    if ((int64_t)record->index > b->newest_record_block)
        b->newest_record_block = record->index;
    for (unsigned i = 0; i < LIVE_CHANNEL_COUNT && bucket; i++) {
        if (!is_calibrated(b, i) || record->absent_channels >> i & 1u)
            continue;
        struct mr_reading reading = mr_channel_read(&b->channel[i], record, i, ratio);
        add_reading(b, bucket, i, reading.value, reading.validity, record->index);
    }
}

static void add_reading_pack(struct live_buckets *b, const struct mr_message *message,
                             int64_t block)
{
    const struct mr_series_pack *pack = mr_series_pack_at(mr_series_pack_find(message->info->id));
    if (b->newest_record_block >= 0 && block - b->newest_record_block < RECORD_AGE_MAX_BLOCKS)
        return;
    struct live_bucket *bucket = find_bucket(b, block);
    float values[MR_PACK_READINGS];
    unsigned count = mr_series_pack_get(pack, message->payload, values);
    unsigned first = mr_series_at(pack->series)->kind == MR_KIND_TENSION ? MR_TRANSDUCERS : 0;
    first += pack->first_reading - 1u;
    for (unsigned i = 0; i < count && bucket; i++) {
        bool fitted = !b->channel_known[first + i] || mr_channel_is_sensor(&b->channel[first + i]);
        if (fitted)
            add_reading(b, bucket, first + i, values[i],
                        isnan(values[i]) ? MR_INVALID_SATURATED : MR_VALID, block);
    }
}

static void set_channel(struct live_buckets *b, const struct mr_channel *m)
{
    if (m->index >= MR_CHANNELS)
        return;
    b->channel_known[m->index] = true;
    b->channel[m->index].kind = m->kind;
    b->channel[m->index].station_ft = m->station_ft;
    b->channel[m->index].unit_per_code = m->unit_per_code;
}

static void set_zero(struct live_buckets *b, const struct mr_channel_zero *m)
{
    if (m->index >= MR_CHANNELS)
        return;
    b->zero_known[m->index] = true;
    b->channel[m->index].number = m->number;
    b->channel[m->index].band = m->band;
    b->channel[m->index].zero_code = m->zero_code;
}

void live_buckets_add_message(struct live_buckets *b, const struct mr_message *message,
                              int64_t block)
{
    const struct mr_calibration *item = &message->as.calibration;
    switch (message->index) {
    case MR_INDEX_CHANNEL: set_channel(b, &message->as.channel); break;
    case MR_INDEX_CHANNEL_ZERO: set_zero(b, &message->as.channel_zero); break;
    case MR_INDEX_CALIBRATION:
        if (item->index < MR_CHANNELS && item->item < MR_CALIBRATION_ITEM_COUNT) {
            mr_channel_set_item(&b->channel[item->index], item->item, item->value);
            b->calibration_known[item->index] |= 1u << item->item;
        }
        break;
#define SERIES_PACK(SERIES_NAME, name, NAME, id, first, count) case MR_INDEX_##NAME:
#include "common/catalogue.def"
        add_reading_pack(b, message, block);
        break;
    default: break;
    }
}

void live_buckets_reset_extremes(struct live_buckets *b)
{
    for (unsigned i = 0; i < LIVE_CHANNEL_COUNT; i++)
        b->reading[i].min = b->reading[i].max = MISSING_VALUE;
}

int64_t live_buckets_newest_block(const struct live_buckets *b)
{
    int64_t can = b->newest_block[LINK_CAN], serial = b->newest_block[LINK_SERIAL];
    return can > serial ? can : serial;
}

void live_buckets_close_complete(struct live_buckets *b)
{
    int64_t can = b->newest_block[LINK_CAN], serial = b->newest_block[LINK_SERIAL];
    int64_t passed = live_buckets_newest_block(b), behind = can < serial ? can : serial;
    if (behind >= 0 && passed - behind < LINK_SILENCE_MIN_BLOCKS)
        passed = behind;
    close_buckets_until(b, (passed - SENDING_DELAY_MAX_BLOCKS) / LIVE_BUCKET_BLOCKS - 1);
}

unsigned live_buckets_pop(struct live_buckets *b, struct live_bucket *out, unsigned most)
{
    unsigned count = b->closed_count < most ? b->closed_count : most;
    memcpy(out, b->closed_bucket, count * sizeof *out);
    b->closed_count -= count;
    memmove(b->closed_bucket, b->closed_bucket + count,
            b->closed_count * sizeof b->closed_bucket[0]);
    return count;
}

const char *live_buckets_missing_reason(const struct live_buckets *b, unsigned index)
{
    const struct live_reading *r = &b->reading[index];
    if (!isnan(r->value))
        return "";
    if (b->record_count > 0 && !is_calibrated(b, index))
        return "calibration not received yet";
    return r->block >= 0 ? mr_validity_text(r->validity) : "";
}
