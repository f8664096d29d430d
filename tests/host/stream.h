/* A board made by hand for tests of the host: writes a candump log and serial bytes, message by
 * message, through common/.
 *
 * stream_landing plays one whole landing whose truth is closed form: touchdown at 3 ft with speed
 * v0, constant deceleration a, so x = 3 + v0 t - a t^2 / 2; transducer n moves by peak * n / 8 over
 * 0.2 s as the wheel passes; gage n pulls 100 + n pounds, falling by 10 ahead of the wheel. Two
 * links, no noise. */
#ifndef MATRIG_TESTS_HOST_STREAM_H
#define MATRIG_TESTS_HOST_STREAM_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/channels.h"
#include "common/framing.h"
#include "host/link/candump.h"

#define STREAM_IN_PER_CODE     0.0016f
#define STREAM_LB_PER_CODE     0.16f
#define STREAM_ZERO_CODE       62.0f
#define STREAM_SWITCH_ERROR_FT 0.001f

struct stream {
    FILE *can; /* NULL: not written */
    FILE *serial;
    uint16_t seq;
    uint32_t can_sent;
    uint32_t serial_sent;
    uint32_t block;
    uint64_t host_us;
    double armed_s; /* before touchdown; 0: one second */
    bool (*drop_can)(const struct stream *stream, uint16_t id); /* true: sent and lost on the way */
    bool (*drop_serial)(const struct stream *stream, uint16_t type);
    /* Instead of the files, when set: what is sent, as it is sent. */
    void (*take_can)(struct stream *stream, const struct link_frame *frame);
    void (*take_serial)(struct stream *stream, const uint8_t *frame, size_t size);
};

/* Truth of a landing. */
struct stream_truth {
    double v0_ft_s;
    double a_ft_s2;
    double peak_in;
    double touchdown_s; /* board time */
    bool warn;
};

static inline void stream_can(struct stream *stream, uint16_t id, const uint8_t *payload,
                              size_t length)
{
    char line[CANDUMP_LINE_SIZE];
    struct link_frame frame = {.id = id, .length = (uint8_t)length, .host_us = stream->host_us};
    memcpy(frame.data, payload, length);
    stream->can_sent++;
    if (stream->take_can)
        stream->take_can(stream, &frame);
    if (!stream->can || (stream->drop_can && stream->drop_can(stream, id)))
        return;
    candump_write_line(&frame, line);
    fputs(line, stream->can);
}

static inline void stream_serial(struct stream *stream, uint16_t type, const uint8_t *payload,
                                 size_t length)
{
    uint8_t frame[MR_FRAME_BYTES_MAX];
    size_t size = mr_frame_encode(stream->seq++, type, payload, length, frame);
    stream->serial_sent++;
    if (stream->take_serial)
        stream->take_serial(stream, frame, size);
    if (stream->serial && !(stream->drop_serial && stream->drop_serial(stream, type)))
        fwrite(frame, 1, size, stream->serial);
}

/* One message on both links: STREAM_BOTH(stream, mark, MARK, .number = 1). */
#define STREAM_BOTH(stream, name, NAME, ...)                    \
    do {                                                        \
        uint8_t payload_[MR_MESSAGE_BYTES_MAX];                 \
        const struct mr_##name message_ = {__VA_ARGS__};        \
        size_t length_ = mr_##name##_put(&message_, payload_);  \
        stream_can(stream, MR_ID_##NAME, payload_, length_);    \
        stream_serial(stream, MR_ID_##NAME, payload_, length_); \
    } while (0)
#define STREAM_CAN(stream, name, NAME, ...)                    \
    do {                                                       \
        uint8_t payload_[MR_MESSAGE_BYTES_MAX];                \
        const struct mr_##name message_ = {__VA_ARGS__};       \
        size_t length_ = mr_##name##_put(&message_, payload_); \
        stream_can(stream, MR_ID_##NAME, payload_, length_);   \
    } while (0)

static inline void stream_hello(struct stream *stream, unsigned layout)
{
    STREAM_BOTH(stream, hello, HELLO, .layout = (uint16_t)layout, .major = 9, .minor = 8,
                .patch = 7);
    STREAM_BOTH(stream, board_uid, BOARD_UID, .uid0 = 0x11, .uid1 = 0x22);
    STREAM_BOTH(stream, board_image, BOARD_IMAGE, .uid2 = 0x33, .image_crc = 0xdeadbeef);
    STREAM_BOTH(stream, board_config, BOARD_CONFIG, .config_crc = 0x12345678,
                .channels = MR_CHANNELS, .switches = 24, .segments = 42, .warning_mats = 30);
    STREAM_BOTH(stream, image_commit, IMAGE_COMMIT, .commit = 0xc7a3136a, .commit_more = 0xb3a3,
                .changed = 1, .state = 1);
    STREAM_BOTH(stream, site, SITE, .touchdown_ft = 3.0f,
                .switch_error_ft = STREAM_SWITCH_ERROR_FT);
}

static inline struct mr_channel_config stream_channel(unsigned index)
{
    static const float gage_ft[7] = {15.0f, 30.0f, 45.0f, 55.0f, 65.0f, 75.0f, 85.0f};
    struct mr_channel_config config = {.station_ft = NAN, .unit_per_code = 1.0f};
    if (index < MR_TRANSDUCERS) {
        config = (struct mr_channel_config){.kind = MR_KIND_DISPLACEMENT,
                                            .number = (uint8_t)(index + 1),
                                            .station_ft = 40.0f + 10.0f * (float)index,
                                            .unit_per_code = STREAM_IN_PER_CODE,
                                            .zero_code = STREAM_ZERO_CODE};
    } else if (index < MR_TRANSDUCERS + MR_GAGES) {
        unsigned gage = index - MR_TRANSDUCERS;
        config = (struct mr_channel_config){.kind = MR_KIND_TENSION,
                                            .number = (uint8_t)(gage + 1),
                                            .band = (uint8_t)(1 + gage / 7),
                                            .station_ft = gage_ft[gage % 7],
                                            .unit_per_code = STREAM_LB_PER_CODE,
                                            .zero_code = STREAM_ZERO_CODE};
    } else {
        config.kind = (uint8_t)(index == MR_TRANSDUCERS + MR_ADC1_STAIRCASE ? MR_KIND_STAIRCASE
                                                                            : MR_KIND_REFERENCE);
    }
    return config;
}

static inline void stream_configuration(struct stream *stream)
{
    for (unsigned i = 0; i < MR_CHANNELS; i++) {
        struct mr_channel_config c = stream_channel(i);
        STREAM_BOTH(stream, channel, CHANNEL, .index = (uint8_t)i, .kind = c.kind,
                    .station_ft = c.station_ft, .unit_per_code = c.unit_per_code);
        STREAM_BOTH(stream, channel_zero, CHANNEL_ZERO, .index = (uint8_t)i, .number = c.number,
                    .band = c.band, .zero_code = c.zero_code);
    }
    for (unsigned p = 1; p <= 24; p++)
        STREAM_BOTH(stream, switch_place, SWITCH_PLACE, .position = (uint8_t)p,
                    .step_codes = (uint16_t)(64 + 8 * (7 * (p - 1) % 24)),
                    .station_ft = 2.5f + 5.0f * (float)(p - 1));
    for (unsigned s = 0; s < 42; s++)
        STREAM_BOTH(stream, slack, SLACK, .segment = (uint8_t)s, .joints = 10, .slack_in = 0.2f,
                    .start_ft = (float)s * 20.0f / 7.0f, .end_ft = (float)(s + 1) * 20.0f / 7.0f);
}

static inline void stream_state(struct stream *stream, unsigned state, unsigned cause,
                                unsigned number, uint32_t block)
{
    STREAM_BOTH(stream, landing, LANDING, .state = (uint8_t)state, .cause = (uint8_t)cause,
                .landing = (uint16_t)number, .block = block);
}

static inline uint32_t stream_tick(double board_s)
{
    return (uint32_t)(int64_t)llround(board_s * 84e6);
}

/* A block with given inches and pounds; the reference is exact, so the ratio is 3103 / 3103. */
static inline struct mr_block stream_block(uint32_t index, const double *inches,
                                           const double *pounds)
{
    struct mr_block block = {.index = index, .tick = stream_tick((double)index / 1000.0)};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        long half =
            lround(4.0 * (inches[i] / (double)STREAM_IN_PER_CODE + (double)STREAM_ZERO_CODE));
        block.forward_sum[i] = (uint16_t)(4 * 2048 + half);
        block.reversed_sum[i] = (uint16_t)(4 * 2048 - half);
    }
    for (unsigned i = 0; i < MR_GAGES; i++)
        block.sum[i] = (uint16_t)lround(
            8.0 * (pounds[i] / (double)STREAM_LB_PER_CODE + (double)STREAM_ZERO_CODE));
    block.sum[MR_ADC1_STAIRCASE] = 8 * 100;
    block.sum[MR_ADC1_REFERENCE] = 8 * 3103;
    return block;
}

static inline double stream_station_ft(const struct stream_truth *truth, double board_s)
{
    double t = board_s - truth->touchdown_s;
    double stop = truth->v0_ft_s / truth->a_ft_s2;
    if (t > stop)
        t = stop;
    return 3.0 + truth->v0_ft_s * t - 0.5 * truth->a_ft_s2 * t * t;
}

/* Board time at which the wheel is at a station; NAN: it never is. Before touchdown it comes at
 * v0. */
static inline double stream_time_s(const struct stream_truth *truth, double station_ft)
{
    double way = station_ft - 3.0;
    double v = truth->v0_ft_s, a = truth->a_ft_s2;
    if (way < 0.0)
        return truth->touchdown_s + way / v;
    return v * v < 2.0 * a * way ? (double)NAN
                                 : truth->touchdown_s + (v - sqrt(v * v - 2.0 * a * way)) / a;
}

static inline void stream_readings(const struct stream_truth *truth, double board_s, double *inches,
                                   double *pounds)
{
    double wheel_ft = board_s < truth->touchdown_s ? -1000.0 : stream_station_ft(truth, board_s);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        double ahead_ft = (double)stream_channel(i).station_ft - wheel_ft;
        double share = ahead_ft > 10.0 ? 0.0 : ahead_ft < 0.0 ? 1.0 : 1.0 - ahead_ft / 10.0;
        inches[i] = 0.01 + share * truth->peak_in * (double)(i + 1) / 8.0;
    }
    for (unsigned i = 0; i < MR_GAGES; i++) {
        double ahead_ft = (double)stream_channel(MR_TRANSDUCERS + i).station_ft - wheel_ft;
        pounds[i] = 101.0 + (double)i - (ahead_ft > 0.0 && ahead_ft < 10.0 ? 10.0 : 0.0);
    }
}

/* What the board sends of one block: record, decimated readings, and the regular messages. */
static inline void stream_millisecond(struct stream *stream, const struct stream_truth *truth,
                                      bool recording)
{
    double inches[MR_TRANSDUCERS], pounds[MR_GAGES];
    static struct mr_block history[4];
    uint8_t record[MR_BLOCK_BYTES_MAX];
    uint32_t index = stream->block;
    uint16_t block16 = (uint16_t)index;
    stream_readings(truth, (double)index / 1000.0, inches, pounds);
    history[index % 4] = stream_block(index, inches, pounds);
    if (recording)
        stream_serial(stream, MR_ID_BLOCK, record, mr_block_encode(&history[index % 4], record));
    if (recording && index % 2 == 0) {
        float d[MR_TRANSDUCERS];
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            struct mr_channel_config config = stream_channel(i);
            d[i] = 0.5f * (mr_channel_read(&config, &history[index % 4], i, 1.0f).value +
                           mr_channel_read(&config, &history[(index + 3) % 4], i, 1.0f).value);
        }
        STREAM_CAN(stream, displacement_1_3, DISPLACEMENT_1_3, d[0], d[1], d[2], block16);
        STREAM_CAN(stream, displacement_4_6, DISPLACEMENT_4_6, d[3], d[4], d[5], block16);
        STREAM_CAN(stream, displacement_7_8, DISPLACEMENT_7_8, d[6], d[7], 0, block16);
    }
    if (recording && index % 4 == 1) {
        float t[MR_GAGES] = {0};
        for (unsigned i = 0; i < MR_GAGES; i++) {
            struct mr_channel_config config = stream_channel(MR_TRANSDUCERS + i);
            for (unsigned age = 0; age < 4; age++)
                t[i] += 0.25f * mr_channel_read(&config, &history[(index + 4 - age) % 4],
                                                MR_TRANSDUCERS + i, 1.0f)
                                    .value;
        }
        STREAM_CAN(stream, tension_1_3, TENSION_1_3, t[0], t[1], t[2], block16);
        STREAM_CAN(stream, tension_4_6, TENSION_4_6, t[3], t[4], t[5], block16);
        STREAM_CAN(stream, tension_7_9, TENSION_7_9, t[6], t[7], t[8], block16);
        STREAM_CAN(stream, tension_10_12, TENSION_10_12, t[9], t[10], t[11], block16);
        STREAM_CAN(stream, tension_13_14, TENSION_13_14, t[12], t[13], 0, block16);
    }
    if (index % 100 == 3)
        STREAM_BOTH(stream, clock, CLOCK, .block = index,
                    .tick = stream_tick((double)index / 1000.0));
    if (index % 100 == 43)
        STREAM_BOTH(stream, can_health, CAN_HEALTH, .sent = stream->can_sent);
    if (index % 100 == 63)
        STREAM_BOTH(stream, serial_health, SERIAL_HEALTH, .sent = stream->serial_sent);
    stream->block++;
    stream->host_us += 1000;
}

/* Armed 1 s (or armed_s) before touchdown, recorded until 1 s after the stop, done. */
static inline void stream_landing(struct stream *stream, struct stream_truth *truth,
                                  unsigned number)
{
    unsigned next = 1, count = 0;
    truth->touchdown_s = (double)stream->block / 1000.0 +
                         (stream->armed_s > 0.0 ? stream->armed_s : 1.0);
    double stop_s = truth->touchdown_s + truth->v0_ft_s / truth->a_ft_s2;
    stream_state(stream, 1, 1, number, stream->block);
    stream_hello(stream, MR_LAYOUT);
    stream_configuration(stream);
    while ((double)stream->block / 1000.0 < stop_s + 1.0) {
        double now_s = (double)stream->block / 1000.0;
        double station_ft = 2.5 + 5.0 * (double)(next - 1);
        double edge_s = next <= 24 ? stream_time_s(truth, station_ft) : (double)NAN;
        stream_millisecond(stream, truth, true);
        if (edge_s < now_s) {
            if (++count == 1)
                stream_state(stream, 2, 2, number, stream->block);
            STREAM_BOTH(stream, edge, EDGE, .tick = stream_tick(edge_s), .position = (uint8_t)next,
                        .count = (uint8_t)count,
                        .step_codes = (float)(64 + 8 * (7 * (next - 1) % 24)));
            STREAM_BOTH(stream, motion, MOTION, .position_ft = (float)station_ft,
                        .speed_ft_s = 20.0f, .deceleration_ft_s2 = 5.0f,
                        .block16 = (uint16_t)(stream->block - 1));
            STREAM_BOTH(stream, motion_error, MOTION_ERROR, .position_ft = 0.001f,
                        .speed_ft_s = 0.01f, .deceleration_ft_s2 = 0.1f,
                        .block16 = (uint16_t)(stream->block - 1));
            next++;
        }
        if (stream->block % 50 == 0) {
            bool warning = truth->warn && now_s > truth->touchdown_s + 1.0 &&
                           now_s < truth->touchdown_s + 2.0;
            STREAM_BOTH(stream, zone, ZONE, .mats = (uint16_t)(warning ? 35 : 5), .start_ft = 60.0f,
                        .end_ft = 70.0f, .block16 = (uint16_t)(stream->block - 1));
            STREAM_BOTH(stream, zone_lead, ZONE_LEAD, .lead_s = 0.75f, .wheel_ft = 30.0f,
                        .warning = warning, .inferred_percent = 20,
                        .block16 = (uint16_t)(stream->block - 1));
        }
    }
    STREAM_BOTH(stream, touchdown, TOUCHDOWN, .speed_ft_s = (float)truth->v0_ft_s,
                .speed_error_ft_s = 0.01f, .deceleration_ft_s2 = (float)truth->a_ft_s2,
                .deceleration_error_ft_s2 = 0.01f);
    STREAM_BOTH(stream, stop, STOP, .station_ft = (float)stream_station_ft(truth, 1e9),
                .station_error_ft = 0.01f,
                .after_touchdown_s = (float)(truth->v0_ft_s / truth->a_ft_s2),
                .switches = (uint8_t)(next - 1), .used = 8);
    stream_state(stream, 3, 3, number, stream->block);
    stream_state(stream, 4, 4, number, stream->block);
}

/* Idle for a while. */
static inline void stream_idle(struct stream *stream, unsigned blocks)
{
    struct stream_truth still = {.v0_ft_s = 1.0, .a_ft_s2 = 1.0, .touchdown_s = 1e9};
    for (unsigned i = 0; i < blocks; i++)
        stream_millisecond(stream, &still, false);
}

#endif
