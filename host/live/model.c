#include "host/live/model_parts.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "common/bands.h"
#include "common/command.h"
#include "common/crash.h"
#include "common/predictor.h"
#include "common/series.h"
#include "common/switches.h"
#include "host/collect/collect.h"

#define MISSING ((float)NAN)
#define RESTART_BLOCKS 1000     /* a block so much older than the newest: the board began again */
#define RECORD_FRESH_BLOCKS 200 /* while records are this new, CAN says nothing that they do not */
#define SILENT_BLOCKS 500       /* a link so far behind the other brings nothing more */
#define TELLING_BLOCKS 10

static void forget_readings(struct live_model *model)
{
    for (unsigned i = 0; i < LIVE_CHANNELS; i++)
        model->reading[i] = (struct live_reading){.value = MISSING, .block = -1, .least = MISSING, .most = MISSING};
}

static void forget_landing(struct live_model *model)
{
    model->zone = (struct live_zone){.block = -1, .start_ft = (double)NAN, .end_ft = (double)NAN, .lead_s = (double)NAN,
                                     .wheel_ft = (double)NAN};
    model->warning = (struct live_warning){.first_block = -1, .zone = model->zone};
    model->verdict = (struct live_verdict){.block = -1};
    model->motion_block = -1;
    model->position_ft = model->speed_ft_s = model->deceleration_ft_s2 = MISSING;
    model->speed_error_ft_s = model->deceleration_error_ft_s2 = MISSING;
    model->touchdown_known = model->stop_known = false;
    model->opened = 0;
    model->edges = 0;
    for (unsigned i = 0; i < LIVE_CHANNELS; i++)
        model->reading[i].least = model->reading[i].most = MISSING;
}

static void forget_buckets(struct live_model *model)
{
    for (unsigned i = 0; i < LIVE_OPEN_BUCKETS; i++)
        model->open[i].bucket = -1;
    model->closed_to = -1;
    model->record_block = -1;
}

void live_model_start(struct live_model *model, bool can, bool serial)
{
    memset(model, 0, sizeof *model);
    model->link[LINK_CAN].used = can;
    model->link[LINK_SERIAL].used = serial;
    model->link[LINK_CAN].newest = model->link[LINK_SERIAL].newest = -1;
    model->touchdown_ft = MISSING;
    forget_readings(model);
    forget_landing(model);
    forget_buckets(model);
}

void live_model_notice(struct live_model *model, enum live_severity severity, int64_t host_us, const char *format, ...)
{
    struct live_notice *notice = &model->notice[model->notices++ % LIVE_NOTICES];
    va_list arguments;
    notice->number = model->notices;
    notice->host_us = host_us;
    notice->severity = severity;
    va_start(arguments, format);
    vsnprintf(notice->text, sizeof notice->text, format, arguments);
    va_end(arguments);
    model->changes++;
}

int64_t live_model_block(const struct live_model *model)
{
    int64_t can = model->link[LINK_CAN].newest, serial = model->link[LINK_SERIAL].newest;
    return can > serial ? can : serial;
}

int64_t live_model_heard_us(const struct live_model *model)
{
    int64_t can = model->link[LINK_CAN].heard_us, serial = model->link[LINK_SERIAL].heard_us;
    return can > serial ? can : serial;
}

double live_model_gear_ft(const struct live_model *model)
{
    if (model->stop_known)
        return (double)model->stop.station_ft;
    if (!isnan(model->zone.wheel_ft) && model->zone.block >= model->motion_block)
        return model->zone.wheel_ft;
    return (double)model->position_ft;
}

bool live_model_recording(const struct live_model *model)
{
    return !model->state_known || (model->state >= MR_LANDING_ARMED && model->state <= MR_LANDING_SETTLING);
}

bool live_model_advised(const struct live_model *model)
{
    return model->verdict.block >= 0 && model->verdict.said.verdict == MR_PREDICTOR_ADVISORY && live_model_recording(model);
}

const char *live_model_reading_text(const struct live_model *model, unsigned index)
{
    const struct live_reading *r = &model->reading[index];
    if (!isnan(r->value))
        return "";
    if (model->records > 0 && !live_model_calibrated(model, index))
        return "calibration not told yet";
    return r->block >= 0 ? mr_validity_text(r->validity) : "";
}

void live_model_uid(const struct live_model *model, char out[25])
{
    out[0] = '\0';
    if (model->uid[0] || model->uid[1] || model->uid[2])
        snprintf(out, 25, "%08X%08X%08X", (unsigned)model->uid[0], (unsigned)model->uid[1], (unsigned)model->uid[2]);
}

/* ---- readings ---- */

static void close_bucket(struct live_model *model, struct live_bucket *bucket)
{
    if (model->closed_count == LIVE_CLOSED_BUCKETS) {
        memmove(model->closed, model->closed + 1, (LIVE_CLOSED_BUCKETS - 1) * sizeof model->closed[0]);
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
            if (bucket->bucket >= 0 && bucket->bucket <= last && (!oldest || bucket->bucket < oldest->bucket))
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

static void take_reading(struct live_model *model, struct live_bucket *bucket, unsigned index, float value, unsigned validity,
                         int64_t block)
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
    int64_t can = model->link[LINK_CAN].newest, serial = model->link[LINK_SERIAL].newest, passed = live_model_block(model);
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

static void restart(struct live_model *model, int64_t host_us)
{
    close_to(model, INT64_MAX);
    forget_buckets(model);
    forget_readings(model);
    forget_landing(model);
    model->restarts++;
    model->state_known = false;
    memset(model->fault_count, 0, sizeof model->fault_count);
    model->link[LINK_CAN].newest = model->link[LINK_SERIAL].newest = -1;
    live_model_notice(model, LIVE_ALARM, host_us, "the board started again");
}

static void heard(struct live_model *model, enum link_kind kind, int64_t host_us, int64_t block)
{
    struct live_link *link = &model->link[kind];
    link->used = true;
    if (host_us > link->heard_us)
        link->heard_us = host_us;
    if (block >= 0 && link->newest - block >= RESTART_BLOCKS)
        restart(model, host_us);
    if (block > link->newest)
        link->newest = block;
}

void live_model_record(struct live_model *model, const uint8_t *record, size_t length, int64_t host_us)
{
    struct mr_block block;
    if (mr_block_get(&block, record, length) != MR_OK)
        return;
    heard(model, LINK_SERIAL, host_us, block.index);
    struct live_bucket *bucket = bucket_of(model, block.index);
    float ratio = mr_channels_ratio(&block);
    model->records++;
    if ((int64_t)block.index > model->record_block)
        model->record_block = block.index;
    for (unsigned i = 0; i < LIVE_CHANNELS && bucket; i++) {
        if (!live_model_calibrated(model, i) || block.absent >> i & 1u)
            continue;
        struct mr_reading reading = mr_channel_read(&model->channel[i], &block, i, ratio);
        take_reading(model, bucket, i, reading.value, reading.validity, block.index);
    }
}

/* Values of a CAN message, `first` on. */
static void take_values(struct live_model *model, unsigned first, unsigned count, const float *values, int64_t block)
{
    if (model->record_block >= 0 && block - model->record_block < RECORD_FRESH_BLOCKS)
        return;
    struct live_bucket *bucket = bucket_of(model, block);
    for (unsigned i = 0; i < count && bucket; i++) {
        bool fitted = !model->channel_known[first + i] || mr_channel_measures(&model->channel[first + i]);
        if (fitted)
            take_reading(model, bucket, first + i, values[i], isnan(values[i]) ? MR_INVALID_SATURATED : MR_VALID, block);
    }
}

/* ---- what happens ---- */

static void take_state(struct live_model *model, const struct mr_landing *m, int64_t host_us)
{
    bool newer = !model->state_known || (int64_t)m->block >= model->state_block;
    if (!newer || (model->state_known && m->state == model->state && m->landing == model->landing))
        return;
    bool armed = m->state == MR_LANDING_ARMED;
    if (armed)
        forget_landing(model);
    model->state_known = true;
    model->state = m->state;
    model->landing = m->landing;
    model->state_block = m->block;
    live_model_notice(model, armed ? LIVE_NOTE : LIVE_SAY, host_us, "%s, landing %u", mr_landing_state_text(m->state), m->landing);
}

static void take_edge(struct live_model *model, const struct mr_edge *m)
{
    if (m->position >= 1 && m->position <= STORE_SWITCHES_MAX)
        model->opened |= (uint64_t)1 << (m->position - 1);
    if (m->count > model->edges)
        model->edges = m->count;
    model->changes++;
}

static void take_motion(struct live_model *model, const struct live_link *link, const struct mr_motion_error *errors, int64_t block)
{
    const struct mr_motion *m = &link->motion;
    if (block < model->motion_block)
        return;
    model->motion_block = block;
    model->position_ft = m->position_ft;
    model->speed_ft_s = m->speed_ft_s;
    model->deceleration_ft_s2 = m->deceleration_ft_s2;
    model->speed_error_ft_s = errors ? errors->speed_ft_s : MISSING;
    model->deceleration_error_ft_s2 = errors ? errors->deceleration_ft_s2 : MISSING;
}

static void take_warning(struct live_model *model, int64_t host_us)
{
    struct live_warning *warning = &model->warning;
    bool on = model->zone.warning;
    bool begins = on && !warning->on;
    if (on) {
        warning->received_us = host_us;
        if (begins || model->zone.mats >= warning->zone.mats)
            warning->zone = model->zone;
    }
    if (on == warning->on)
        return;
    warning->on = on;
    if (begins) {
        warning->since_us = host_us;
        warning->first_block = warning->first_block < 0 ? model->zone.block : warning->first_block;
        live_model_notice(model, LIVE_ALARM, host_us, "WARNING: %u closed mats ahead, stations %.1f to %.1f ft", model->zone.mats,
                          model->zone.start_ft, model->zone.end_ft);
    } else {
        live_model_notice(model, LIVE_NOTE, host_us, "the warning is over");
    }
}

/* Zone and its second half have the same block; the newer of the two links' statements counts. */
static void take_zone(struct live_model *model, const struct live_link *link, const struct mr_zone_lead *m, int64_t host_us,
                      int64_t block)
{
    if (m->block16 != link->zone.block16 || block < model->zone.block)
        return;
    model->zone = (struct live_zone){.block = block, .mats = link->zone.mats, .start_ft = (double)link->zone.start_ft,
                                     .end_ft = (double)link->zone.end_ft, .lead_s = (double)m->lead_s,
                                     .wheel_ft = (double)m->wheel_ft, .warning = m->warning != 0,
                                     .inferred_percent = m->inferred_percent};
    take_warning(model, host_us);
}

/* What a verdict goes with has its block, and is sent before it. */
static void take_verdict(struct live_model *model, const struct mr_verdict *m, int64_t host_us, int64_t block)
{
    struct live_verdict *verdict = &model->verdict;
    bool advised = live_model_advised(model);
    if (block < verdict->block)
        return;
    verdict->block = block;
    verdict->said = *m;
    if (live_model_advised(model) && !advised) {
        verdict->since_us = host_us;
        verdict->since_reason = m->reason;
    }
    if (advised != live_model_advised(model))
        model->changes++;
    if (!live_model_advised(model) || verdict->told >> (m->reason & 7u) & 1u)
        return;
    verdict->told |= (uint8_t)(1u << (m->reason & 7u)); /* once in a landing: it may come and go 20 times a second */
    live_model_notice(model, LIVE_NOTE, host_us, "advisory: %s", mr_predictor_reason_text(m->reason));
}

static void take_fault(struct live_model *model, const struct mr_fault *m, int64_t host_us)
{
    if (m->code >= MR_FAULT_COUNT || m->count <= model->fault_count[m->code])
        return;
    model->fault_count[m->code] = m->count;
    live_model_notice(model, LIVE_ALARM, host_us, "fault: %s (%u, %u times)", mr_fault_text(m->code), m->detail, m->count);
}

static void channel_name(const struct live_model *model, unsigned index, char *out, size_t size)
{
    unsigned number = index < MR_CHANNELS && model->zero_known[index] ? model->channel[index].number : 0;
    if (index < MR_TRANSDUCERS)
        snprintf(out, size, "transducer %u", number ? number : index + 1);
    else if (index < LIVE_CHANNELS)
        snprintf(out, size, "gage %u", number ? number : index - MR_TRANSDUCERS + 1);
    else
        snprintf(out, size, "channel %u", index);
}

static void take_channel_event(struct live_model *model, const struct mr_channel_event *m, int64_t host_us)
{
    char name[40], text[LIVE_NOTICE_TEXT];
    channel_name(model, m->index, name, sizeof name);
    snprintf(text, sizeof text, "%s: %s", name, m->validity ? mr_validity_text(m->validity) : "valid again");
    const struct live_notice *last = model->notices ? &model->notice[(model->notices - 1) % LIVE_NOTICES] : NULL;
    if (!last || strcmp(last->text, text) != 0) /* the other link says it too */
        live_model_notice(model, m->validity ? LIVE_ALARM : LIVE_SAY, host_us, "%s", text);
}

static void take_alarm(struct live_model *model, const struct mr_can_alarm *m, int64_t host_us)
{
    bool changed = model->alarm_known ? m->state != model->alarm.state : m->state != 0;
    if (model->alarm_known && m->outages < model->alarm.outages)
        return; /* had waited in the controller */
    model->alarm_known = true;
    model->alarm = *m;
    if (changed)
        live_model_notice(model, m->state ? LIVE_ALARM : LIVE_SAY, host_us, "the board says of CAN: %s", mr_can_state_text(m->state));
}

static void take_ack(struct live_model *model, const struct mr_ack *m, int64_t host_us)
{
    bool again = model->acks && model->ack.tag == m->tag && model->ack.code == m->code && model->ack.block == m->block;
    model->ack = *m;
    model->acks++;
    model->changes++;
    if (!again && (m->code == MR_COMMAND_ARM || m->code == MR_COMMAND_DISARM) && m->status != MR_OK)
        live_model_notice(model, LIVE_ALARM, host_us, "%s refused: %s", mr_command_name(m->code), mr_status_text(m->status));
}

/* Readings on CAN. True: it was one of these. */
static bool reading_message(struct live_model *model, uint16_t id, const uint8_t *payload, int64_t block)
{
    unsigned number = mr_series_pack_find(id);
    if (number >= MR_SERIES_PACKS)
        return false;
    const struct mr_series_pack *pack = mr_series_pack_at(number);
    float values[MR_PACK_READINGS];
    unsigned count = mr_series_pack_get(pack, payload, values);
    unsigned first = mr_series_at(pack->series)->kind == MR_KIND_TENSION ? MR_TRANSDUCERS : 0;
    take_values(model, first + pack->first - 1, count, values, block);
    return true;
}

/* Health. True: it was one of these. */
static bool health_message(struct live_model *model, uint16_t id, const uint8_t *payload, size_t length, int64_t host_us)
{
    switch (id) {
    case MR_ID_HEALTH: { GET(health); model->health = m; model->health_known = true; return true; }
    case MR_ID_FAULT: { GET(fault); take_fault(model, &m, host_us); return true; }
    case MR_ID_CHANNEL_EVENT: { GET(channel_event); take_channel_event(model, &m, host_us); return true; }
    case MR_ID_CAN_ALARM: { GET(can_alarm); take_alarm(model, &m, host_us); return true; }
    case MR_ID_BOX_STATE: { GET(box_state); model->box = m; model->box_known = true; return true; }
    case MR_ID_UPKEEP: { GET(upkeep); model->upkeep = m; model->upkeep_known = true; return true; }
    case MR_ID_TEMPERATURE: { GET(temperature); model->temperature = m; model->temperature_known = true; return true; }
    default: return false;
    }
}

/* What a landing brings. */
static bool landing_message(struct live_model *model, struct live_link *link, uint16_t id, const uint8_t *payload, size_t length,
                            int64_t host_us, int64_t block)
{
    switch (id) {
    case MR_ID_LANDING: { GET(landing); take_state(model, &m, host_us); return true; }
    case MR_ID_EDGE: { GET(edge); take_edge(model, &m); return true; }
    case MR_ID_MOTION: { GET(motion); link->motion = m; take_motion(model, link, NULL, block); return true; }
    case MR_ID_MOTION_ERROR: {
        GET(motion_error);
        if (m.block16 == link->motion.block16)
            take_motion(model, link, &m, block);
        return true;
    }
    case MR_ID_ZONE: { GET(zone); link->zone = m; return true; }
    case MR_ID_ZONE_LEAD: { GET(zone_lead); take_zone(model, link, &m, host_us, block); return true; }
    case MR_ID_ZONE_COMING: { GET(zone_coming); link->coming = m; return true; }
    case MR_ID_ZONE_PRESS: { GET(zone_press); link->press = m; return true; }
    case MR_ID_VERDICT: {
        GET(verdict);
        if (block >= model->verdict.block) {
            model->verdict.coming_known = link->coming.block16 == m.block16;
            model->verdict.coming = link->coming;
            model->verdict.press_known = link->press.block16 == m.block16;
            model->verdict.press = link->press;
        }
        take_verdict(model, &m, host_us, block);
        return true;
    }
    case MR_ID_TOUCHDOWN: { GET(touchdown); model->touchdown = m; model->touchdown_known = true; return true; }
    case MR_ID_STOP: { GET(stop); model->stop = m; model->stop_known = true; return true; }
    case MR_ID_BAND_STATE: {
        GET(band_state);
        if (m.band >= 1 && m.band <= LIVE_BANDS)
            model->band[m.band - 1] = m;
        return true;
    }
    case MR_ID_ACK: { GET(ack); take_ack(model, &m, host_us); return true; }
    default: return false;
    }
}

/* What is told once, as a line; of two links the first that says it. */
static bool notice_message(struct live_model *model, enum link_kind kind, uint16_t id, const uint8_t *payload, size_t length,
                           int64_t host_us)
{
    if (kind == LINK_CAN && model->link[LINK_SERIAL].heard_us + 1000000 > host_us)
        return true;
    switch (id) {
    case MR_ID_BAND_EVENT: {
        GET(band_event);
        live_model_notice(model, LIVE_ALARM, host_us, "band %u, gage %u: %s", m.band, m.gage, mr_band_reason_text(m.reason));
        return true;
    }
    case MR_ID_SWITCH_EVENT: {
        GET(switch_event);
        live_model_notice(model, LIVE_NOTE, host_us, "switch %u: %s", m.position, mr_switch_reason_text(m.reason));
        return true;
    }
    case MR_ID_PUSHBACK: {
        GET(pushback);
        live_model_notice(model, LIVE_NOTE, host_us, "the model is pushed past switch %u", m.position);
        return true;
    }
    case MR_ID_MARK: { GET(mark); live_model_notice(model, LIVE_NOTE, host_us, "mark %u", m.number); return true; }
    default: return false;
    }
}

void live_model_message(struct live_model *model, enum link_kind kind, uint16_t id, const uint8_t *payload, size_t length,
                        int64_t host_us, int64_t block)
{
    struct live_link *link = &model->link[kind];
    heard(model, kind, host_us, block);
    if (id != MR_ID_HELLO && model->board.layout != 0 && !model->hello)
        return; /* of another layout: it means something else */
    (void)(live_model_take_configuration(model, id, payload, length) || reading_message(model, id, payload, block) ||
           landing_message(model, link, id, payload, length, host_us, block) || health_message(model, id, payload, length, host_us) ||
           notice_message(model, kind, id, payload, length, host_us));
}

void live_model_counts(struct live_model *model, enum link_kind kind, const struct store_link_counts *counts, int64_t host_us)
{
    struct store_link_counts *known = &model->link[kind].counts;
    const char *name = kind == LINK_CAN ? "CAN" : "serial";
    int64_t lost = counts->lost - known->lost, dropped = counts->dropped - known->dropped;
    if (lost > 0)
        live_model_notice(model, LIVE_ALARM, host_us, "%s: %lld frames lost on the way", name, (long long)lost);
    if (dropped > 0)
        live_model_notice(model, LIVE_ALARM, host_us, "%s: the board could not send %lld frames", name, (long long)dropped);
    *known = *counts;
}

void live_model_strangers(struct live_model *model, int64_t count, int64_t host_us)
{
    if (count > model->strangers)
        live_model_notice(model, LIVE_ALARM, host_us, "CAN: %lld %s not the board's; what rests on CAN is doubtful", (long long)count,
                          count == 1 ? "frame is" : "frames are");
    model->strangers = count;
}
