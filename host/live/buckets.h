/* Decimated readings for a live view: buckets of LIVE_BUCKET_BLOCKS with the minimum and maximum of
 * each channel, so that peaks remain visible in a coarse drawing. Block records (serial, each ms)
 * are used if they arrive, otherwise the readings sent on CAN.
 *
 * Pure functions: no clock, no threads, bounded memory. Displacements are readings as the board
 * sends them. Missing values are NaN, missing blocks -1. A block is 1 ms, counted from the start of
 * the board's scans. */
#ifndef MATRIG_HOST_LIVE_BUCKETS_H
#define MATRIG_HOST_LIVE_BUCKETS_H

#include <stdbool.h>

#include "common/channels.h"
#include "common/catalogue.h"
#include "host/link/link.h"

/* number of channels: transducers, then gages, in the board's order */
#define LIVE_CHANNEL_COUNT      (MR_TRANSDUCERS + MR_GAGES)
#define LIVE_BUCKET_BLOCKS      20 /* blocks per bucket: 50 buckets a second */
/* number of open buckets, which can still be filled because the links are not synchronous */
#define LIVE_OPEN_BUCKETS_MAX   32
/* number of closed buckets that are not read yet; if full, the oldest is discarded */
#define LIVE_CLOSED_BUCKETS_MAX 256

struct live_bucket {
    int64_t number; /* number of the bucket: block / LIVE_BUCKET_BLOCKS; -1: free */
    float min[LIVE_CHANNEL_COUNT], max[LIVE_CHANNEL_COUNT];
};

struct live_reading {
    float value; /* newest value; NaN: not valid */
    int64_t block;
    uint8_t validity; /* enum mr_validity; for readings from CAN only valid or saturated */
    float min, max;   /* minimum and maximum since arming, or since the view began */
};

struct live_buckets {
    int64_t newest_block[LINK_KINDS]; /* newest block on each link */
    uint64_t restart_count;           /* number of detected restarts of the board */

    bool channel_known[MR_CHANNELS], zero_known[MR_CHANNELS];
    struct mr_channel_config channel[MR_CHANNELS];
    uint32_t calibration_known[MR_CHANNELS]; /* bit n: calibration item n of the channel is known */

    struct live_reading reading[LIVE_CHANNEL_COUNT];
    int64_t newest_record_block; /* block of the newest block record */
    /* number of records used; number of readings that were lost because their bucket was closed or
     * was not read in time */
    uint64_t record_count, late_reading_count;
    struct live_bucket open_bucket[LIVE_OPEN_BUCKETS_MAX];
    int64_t newest_closed_bucket; /* number of the last closed bucket */
    struct live_bucket closed_bucket[LIVE_CLOSED_BUCKETS_MAX];
    unsigned closed_count;
};

void live_buckets_init(struct live_buckets *buckets);

/* Reports the newest block of a link. If the board has restarted, closes all open buckets and
 * returns true. */
bool live_buckets_advance(struct live_buckets *buckets, enum link_kind link, int64_t block);
/* Applies readings from CAN and messages with calibration or zeros; ignores other messages. */
void live_buckets_add_message(struct live_buckets *buckets, const struct mr_message *message,
                              int64_t block);
void live_buckets_add_record(struct live_buckets *buckets, const struct mr_block *record);
/* Resets the minimum and maximum of each channel. */
void live_buckets_reset_extremes(struct live_buckets *buckets);

/* Closes the buckets that are complete: both links have passed them, or one link has passed them
 * and the other one is silent. Call it before each live_buckets_pop. */
void live_buckets_close_complete(struct live_buckets *buckets);
/* Moves up to `most` closed buckets to `out`, oldest first. Returns their number. */
unsigned live_buckets_pop(struct live_buckets *buckets, struct live_bucket *out, unsigned most);

/* Returns the newest block on either link. */
int64_t live_buckets_newest_block(const struct live_buckets *buckets);
/* Returns the reason why a channel has no value; "": it has a value, or no reading has arrived.
 * Static storage. */
const char *live_buckets_missing_reason(const struct live_buckets *buckets, unsigned index);

#endif
