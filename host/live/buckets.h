/* Readings of a live view, decimated: buckets of LIVE_BUCKET_BLOCKS with the least and the most of
 * each channel, so that no peak is lost however few of them are drawn. Block records (serial, each
 * ms) count when they come, else the readings on CAN.
 *
 * Pure: no clock, no threads, bounded memory. Displacements are readings, as the board sends them.
 * Absent values are NaN, absent blocks -1. A block is a ms since the board's scans began. */
#ifndef MATRIG_HOST_LIVE_BUCKETS_H
#define MATRIG_HOST_LIVE_BUCKETS_H

#include <stdbool.h>

#include "common/channels.h"
#include "common/catalogue.h"
#include "host/link/link.h"

/* transducers, then gages, in the board's order */
#define LIVE_CHANNELS       (MR_TRANSDUCERS + MR_GAGES)
#define LIVE_BUCKET_BLOCKS  20 /* 50 buckets a second */
/* links are not in step: so many may still be filled */
#define LIVE_OPEN_BUCKETS   32
#define LIVE_CLOSED_BUCKETS 256 /* not taken yet; the oldest is forgotten */

struct live_bucket {
    int64_t bucket; /* block / LIVE_BUCKET_BLOCKS; -1: free */
    float least[LIVE_CHANNELS], most[LIVE_CHANNELS];
};

struct live_reading {
    float value; /* newest; NaN: not valid */
    int64_t block;
    uint8_t validity;  /* enum mr_validity; of CAN alone valid or saturated */
    float least, most; /* since arming, or since the view began */
};

struct live_buckets {
    int64_t newest[LINK_KINDS]; /* block heard of on each link */
    uint64_t restarts;          /* seen: board time began again */

    bool channel_known[MR_CHANNELS], zero_known[MR_CHANNELS];
    struct mr_channel_config channel[MR_CHANNELS];
    uint32_t calibration_known[MR_CHANNELS]; /* bit n: item n */

    struct live_reading reading[LIVE_CHANNELS];
    int64_t record_block;   /* of the newest block record */
    uint64_t records, late; /* taken; for a bucket that was closed, or not taken in time */
    struct live_bucket open[LIVE_OPEN_BUCKETS];
    int64_t closed_to; /* buckets up to it are closed */
    struct live_bucket closed[LIVE_CLOSED_BUCKETS];
    unsigned closed_count;
};

void live_buckets_start(struct live_buckets *buckets);

/* A link has heard of this block. True: the board began again; open buckets were closed. */
bool live_buckets_hear(struct live_buckets *buckets, enum link_kind link, int64_t block);
/* Readings on CAN, and what turns codes into readings; other messages change nothing. */
void live_buckets_message(struct live_buckets *buckets, const struct mr_message *message,
                          int64_t block);
void live_buckets_record(struct live_buckets *buckets, const struct mr_block *record);
/* Least and most of each channel begin again. */
void live_buckets_arm(struct live_buckets *buckets);

/* Closes the buckets that both links have passed, or the one that is heard when the other is
 * silent. Call it before each take. */
void live_buckets_settle(struct live_buckets *buckets);
/* Moves up to `most` closed buckets out, the oldest first; returns how many. */
unsigned live_buckets_take(struct live_buckets *buckets, struct live_bucket *out, unsigned most);

/* Newest block heard of on either link. */
int64_t live_buckets_block(const struct live_buckets *buckets);
/* Zero and calibration of the channel have come. No record is read before. */
/* Why a channel has no value; "": it has one, or nothing was read. Static storage. */
const char *live_buckets_why(const struct live_buckets *buckets, unsigned index);

#endif
