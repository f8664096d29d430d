/* What a live view shows: the newest of everything a board says, and its readings decimated.
 *
 * Messages and block records go in, whoever received them: the collector of a running log, or the
 * database that another log writes. Readings come out as buckets of LIVE_BUCKET_BLOCKS: the least
 * and the most that each channel read in it, so no peak is lost however few of them are drawn.
 * Block records (serial, each ms) are taken when they come; else what CAN says.
 *
 * Pure: no clock, no threads, bounded memory. Times of the host are Unix microseconds, of the board
 * blocks (ms) since its scans began. Displacements are readings, as the board sends them. Absent
 * values are NaN, absent blocks -1. */
#ifndef MATRIG_HOST_LIVE_MODEL_H
#define MATRIG_HOST_LIVE_MODEL_H

#include <stdbool.h>

#include "common/catalogue.h"
#include "common/channels.h"
#include "common/closure.h"
#include "common/fault.h"
#include "common/quantity.h"
#include "host/collect/collect.h"

/* transducers, then gages, in the board's order */
#define LIVE_CHANNELS       (MR_TRANSDUCERS + MR_GAGES)
#define LIVE_BUCKET_BLOCKS  20 /* 50 buckets a second */
/* links are not in step: so many may still be filled */
#define LIVE_OPEN_BUCKETS   32
#define LIVE_CLOSED_BUCKETS 256 /* not taken yet; the oldest is forgotten */
#define LIVE_NOTICES        40
#define LIVE_NOTICE_TEXT    120
#define LIVE_BANDS          4

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

enum live_severity { LIVE_SAY, LIVE_NOTE, LIVE_ALARM };

struct live_notice {
    uint64_t number; /* from 1 */
    int64_t host_us;
    enum live_severity severity;
    char text[LIVE_NOTICE_TEXT];
};

struct live_link {
    bool used;
    struct store_link_counts counts;
    int64_t heard_us;    /* host time of the newest message; 0: none */
    int64_t newest;      /* block of it */
    struct mr_zone zone; /* that its second half is to follow */
    struct mr_motion motion;
    struct mr_zone_coming coming; /* that a verdict is to follow */
    struct mr_zone_press press;
    struct mr_risk risk; /* that its lead is to follow */
};

struct live_zone {
    int64_t block; /* -1: none told */
    unsigned mats;
    double start_ft, end_ft, lead_s, wheel_ft;
    bool warning;
    unsigned inferred_percent;
};

struct live_warning {
    bool on;
    /* host time at which the message that began the newest one was received; 0: none since
     * arming */
    int64_t since_us;
    int64_t first_block;   /* that decided the first since arming, on the board; -1: none */
    int64_t received_us;   /* of the newest message that says so */
    struct live_zone zone; /* longest of it */
};

/* What the predictor makes of it. An advisory is less than a warning: the lamp stays dark. */
struct live_verdict {
    int64_t block; /* of the newest one; -1: none told */
    struct mr_verdict said;
    bool coming_known, press_known; /* they belong to it */
    struct mr_zone_coming coming;
    struct mr_zone_press press;
    /* host time of the message that began the newest advisory; 0: none since arming */
    int64_t since_us;
    uint8_t since_reason; /* of it */
    uint8_t told;         /* bit n: an advisory for reason n is among the notices */
};

/* Newest statement of the risk, and the brake release. */
struct live_risk {
    int64_t block;    /* -1: none told */
    float lamp_limit; /* NaN: none, or not told */
    struct mr_risk said;
    struct mr_risk_lead lead;
    int64_t release_block; /* -1: none told */
    struct mr_release release;
};

struct live_model {
    struct live_link link[LINK_KINDS];
    uint64_t restarts; /* seen: board time began again */
    uint64_t changes;  /* counts what a viewer must see at once */

    bool hello;
    struct mr_hello board;
    uint32_t uid[3], image_crc, config_crc;
    char commit[MR_IMAGE_COMMIT_TEXT];
    unsigned warning_mats;
    unsigned state, landing;
    bool state_known;
    int64_t state_block;

    bool channel_known[MR_CHANNELS], zero_known[MR_CHANNELS];
    struct mr_channel_config channel[MR_CHANNELS];
    uint32_t calibration_told[MR_CHANNELS]; /* bit n: item n */
    bool switch_known[STORE_SWITCHES_MAX];
    float switch_ft[STORE_SWITCHES_MAX];
    uint64_t opened; /* bit p-1: switch p, since arming */
    unsigned edges;
    bool segment_known[MR_SEGMENTS];
    struct mr_slack segment[MR_SEGMENTS];
    float touchdown_ft;
    uint64_t configured; /* counts changes of what is above but state, opened, edges */

    struct live_zone zone;
    struct live_warning warning;
    struct live_verdict verdict;
    struct live_risk risk;
    int64_t motion_block;
    float position_ft, speed_ft_s, deceleration_ft_s2;
    float speed_error_ft_s, deceleration_error_ft_s2;
    bool touchdown_known, stop_known;
    struct mr_touchdown touchdown;
    struct mr_stop stop;

    struct mr_band_state band[LIVE_BANDS];
    struct mr_health health;
    bool health_known, alarm_known, box_known;
    struct mr_can_alarm alarm;
    struct mr_box_state box;
    struct mr_upkeep upkeep;
    struct mr_quantity_value quantity[MR_QUANTITIES];
    uint16_t fault_count[MR_FAULT_COUNT];

    struct live_reading reading[LIVE_CHANNELS];
    int64_t record_block;   /* of the newest block record; -1 */
    uint64_t records, late; /* taken; came for a bucket that was closed */
    struct live_bucket open[LIVE_OPEN_BUCKETS];
    int64_t closed_to; /* buckets up to it are closed */
    struct live_bucket closed[LIVE_CLOSED_BUCKETS];
    unsigned closed_count;
    uint64_t forgotten; /* buckets that nobody took in time */

    struct live_notice notice[LIVE_NOTICES];
    uint64_t notices; /* ever made; the newest is notice[(notices - 1) % LIVE_NOTICES] */

    int64_t strangers; /* frames that are not the board's, on its identifiers */

    struct mr_ack ack; /* newest */
    uint64_t acks;
};

void live_model_start(struct live_model *model, bool can, bool serial);

/* A message of the board, as the collector tells it. */
void live_model_message(struct live_model *model, const struct collector_event *event);
void live_model_record(struct live_model *model, const struct mr_block *record, int64_t host_us);
/* Frames by now that are not the board's. */
void live_model_strangers(struct live_model *model, int64_t count, int64_t host_us);
void live_model_counts(struct live_model *model, enum link_kind kind,
                       const struct store_link_counts *counts, int64_t host_us);

/* Closes the buckets that both links have passed, or the one that is heard when the other is
 * silent. Call it before each take. */
void live_model_settle(struct live_model *model);
/* Moves up to `most` closed buckets out, the oldest first; returns how many. */
unsigned live_model_take(struct live_model *model, struct live_bucket *out, unsigned most);

void live_model_notice(struct live_model *model, enum live_severity severity, int64_t host_us,
                       const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Newest block heard of on either link; -1: none. Host time of the newest message; 0: none. */
int64_t live_model_block(const struct live_model *model);
int64_t live_model_heard_us(const struct live_model *model);
/* Where the gear is by the newest statement, ft; NaN: not known, or no landing goes on. */
double live_model_gear_ft(const struct live_model *model);
/* The predictor advises, and does not warn. */
bool live_model_advised(const struct live_model *model);
/* All that turns the channel's codes into its value has been told. No record is read before: a zero
 * or a table that is not known would make a number that looks right. False of any of those that are
 * fitted: lacks. */
bool live_model_calibrated(const struct live_model *model, unsigned index);
bool live_model_lacks_calibration(const struct live_model *model);
/* Why a reading is NaN, in words; empty: it is not, or nothing has come. Static storage. */
const char *live_model_reading_text(const struct live_model *model, unsigned index);
/* "003100425847500F20343635"; empty: not known yet. */
void live_model_uid(const struct live_model *model, char out[25]);

#endif
