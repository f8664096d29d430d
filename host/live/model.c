#include "host/live/model_parts.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "common/command.h"
#include "common/crash.h"
#include "common/risk.h"
#include "common/series.h"
#include "host/collect/collect.h"

#define MISSING        ((float)NAN)
#define RESTART_BLOCKS 1000 /* a block so much older than the newest: the board began again */

static void forget_landing(struct live_model *model)
{
    model->zone = (struct live_zone){.block = -1,
                                     .start_ft = (double)NAN,
                                     .end_ft = (double)NAN,
                                     .lead_s = (double)NAN,
                                     .wheel_ft = (double)NAN};
    model->warning = (struct live_warning){.first_block = -1, .zone = model->zone};
    model->verdict = (struct live_verdict){.block = -1};
    model->risk = (struct live_risk){.block = -1, .lamp_limit = MISSING, .release_block = -1};
    model->motion_block = -1;
    model->position_ft = model->speed_ft_s = model->deceleration_ft_s2 = MISSING;
    model->speed_error_ft_s = model->deceleration_error_ft_s2 = MISSING;
    model->touchdown_known = model->stop_known = false;
    model->opened = 0;
    model->edges = 0;
    for (unsigned i = 0; i < LIVE_CHANNELS; i++)
        model->reading[i].least = model->reading[i].most = MISSING;
}

void live_model_start(struct live_model *model, bool can, bool serial)
{
    memset(model, 0, sizeof *model);
    model->link[LINK_CAN].used = can;
    model->link[LINK_SERIAL].used = serial;
    model->link[LINK_CAN].newest = model->link[LINK_SERIAL].newest = -1;
    model->touchdown_ft = MISSING;
    for (unsigned i = 0; i < MR_QUANTITIES; i++)
        model->quantity[i] = (struct mr_quantity_value){.value = (double)NAN, .error = (double)NAN};
    forget_landing(model);
    live_model_begin_readings(model);
}

void live_model_notice(struct live_model *model, enum live_severity severity, int64_t host_us,
                       const char *format, ...)
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

/* From arm to done, or nobody said. */
static bool is_recording(const struct live_model *model)
{
    return !model->state_known ||
           (model->state >= MR_LANDING_ARMED && model->state <= MR_LANDING_SETTLING);
}

bool live_model_advised(const struct live_model *model)
{
    return model->verdict.block >= 0 && model->verdict.said.verdict == MR_PREDICTOR_ADVISORY &&
           is_recording(model);
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
        snprintf(out, 25, "%08X%08X%08X", (unsigned)model->uid[0], (unsigned)model->uid[1],
                 (unsigned)model->uid[2]);
}

static void restart(struct live_model *model, int64_t host_us)
{
    live_model_end_readings(model);
    live_model_begin_readings(model);
    forget_landing(model);
    model->restarts++;
    model->state_known = false;
    memset(model->fault_count, 0, sizeof model->fault_count);
    model->link[LINK_CAN].newest = model->link[LINK_SERIAL].newest = -1;
    live_model_notice(model, LIVE_ALARM, host_us, "the board started again");
}

static void hear(struct live_model *model, enum link_kind kind, int64_t host_us, int64_t block)
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

void live_model_record(struct live_model *model, const struct mr_block *block, int64_t host_us)
{
    hear(model, LINK_SERIAL, host_us, block->index);
    live_model_take_block(model, block);
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
    live_model_notice(model, armed ? LIVE_NOTE : LIVE_SAY, host_us, "%s, landing %u",
                      mr_landing_state_text(m->state), m->landing);
}

static void take_edge(struct live_model *model, const struct mr_edge *m)
{
    if (m->position >= 1 && m->position <= STORE_SWITCHES_MAX)
        model->opened |= (uint64_t)1 << (m->position - 1);
    if (m->count > model->edges)
        model->edges = m->count;
    model->changes++;
}

static void take_motion(struct live_model *model, const struct live_link *link,
                        const struct mr_motion_error *errors, int64_t block)
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
        live_model_notice(model, LIVE_ALARM, host_us,
                          "WARNING: %u closed mats ahead, stations %.1f to %.1f ft",
                          model->zone.mats, model->zone.start_ft, model->zone.end_ft);
    } else {
        live_model_notice(model, LIVE_NOTE, host_us, "the warning is over");
    }
}

/* Zone and its second half have the same block; the newer of the two links' statements counts. */
static void take_zone(struct live_model *model, const struct live_link *link,
                      const struct mr_zone_lead *m, int64_t host_us, int64_t block)
{
    if (m->block16 != link->zone.block16 || block < model->zone.block)
        return;
    model->zone = (struct live_zone){.block = block,
                                     .mats = link->zone.mats,
                                     .start_ft = (double)link->zone.start_ft,
                                     .end_ft = (double)link->zone.end_ft,
                                     .lead_s = (double)m->lead_s,
                                     .wheel_ft = (double)m->wheel_ft,
                                     .warning = m->warning != 0,
                                     .inferred_percent = m->inferred_percent};
    take_warning(model, host_us);
}

/* What a verdict goes with has its block, and is sent before it. */
static void take_verdict(struct live_model *model, const struct mr_verdict *m, int64_t host_us,
                         int64_t block)
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
    /* once in a landing: it may come and go 20 times a second */
    verdict->told |= (uint8_t)(1u << (m->reason & 7u));
    live_model_notice(model, LIVE_NOTE, host_us, "advisory: %s",
                      mr_predictor_reason_text(m->reason));
}

static void take_risk(struct live_model *model, const struct live_link *link,
                      const struct mr_risk_lead *m, int64_t block)
{
    if (m->block16 != link->risk.block16 || block < model->risk.block)
        return;
    model->risk.block = block;
    model->risk.said = link->risk;
    model->risk.lead = *m;
}

/* Each change once, whichever link says it first. */
static void take_release(struct live_model *model, const struct mr_release *m, int64_t host_us)
{
    struct live_risk *risk = &model->risk;
    bool known = risk->release_block >= (int64_t)m->block && risk->release.state == m->state;
    risk->release_block = (int64_t)m->block;
    risk->release = *m;
    if (known)
        return;
    model->changes++;
    live_model_notice(model, m->state == MR_RELEASE_ASKED ? LIVE_ALARM : LIVE_NOTE, host_us,
                      "brake release: %s (%s)", mr_release_state_text(m->state),
                      mr_release_reason_text(m->reason));
}

static void take_fault(struct live_model *model, const struct mr_fault *m, int64_t host_us)
{
    if (m->code >= MR_FAULT_COUNT || m->count <= model->fault_count[m->code])
        return;
    model->fault_count[m->code] = m->count;
    live_model_notice(model, LIVE_ALARM, host_us, "fault: %s (%u, %u times)",
                      mr_fault_text(m->code), m->detail, m->count);
}

static void channel_name(const struct live_model *model, unsigned index, char *out, size_t size)
{
    unsigned number = index < MR_CHANNELS && model->zero_known[index] ? model->channel[index].number
                                                                      : 0;
    if (index < MR_TRANSDUCERS)
        snprintf(out, size, "transducer %u", number ? number : index + 1);
    else if (index < LIVE_CHANNELS)
        snprintf(out, size, "gage %u", number ? number : index - MR_TRANSDUCERS + 1);
    else
        snprintf(out, size, "channel %u", index);
}

static void take_channel_event(struct live_model *model, const struct mr_channel_event *m,
                               int64_t host_us)
{
    char name[40], text[LIVE_NOTICE_TEXT];
    channel_name(model, m->index, name, sizeof name);
    snprintf(text, sizeof text, "%s: %s", name,
             m->validity ? mr_validity_text(m->validity) : "valid again");
    const struct live_notice *last = model->notices
                                       ? &model->notice[(model->notices - 1) % LIVE_NOTICES]
                                       : NULL;
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
        live_model_notice(model, m->state ? LIVE_ALARM : LIVE_SAY, host_us,
                          "the board says of CAN: %s", mr_can_state_text(m->state));
}

static void take_ack(struct live_model *model, const struct mr_ack *m, int64_t host_us)
{
    bool again = model->acks && model->ack.tag == m->tag && model->ack.code == m->code &&
                 model->ack.block == m->block;
    model->ack = *m;
    model->acks++;
    model->changes++;
    if (!again && (m->code == MR_COMMAND_ARM || m->code == MR_COMMAND_DISARM) && m->status != MR_OK)
        live_model_notice(model, LIVE_ALARM, host_us, "%s refused: %s", mr_command_name(m->code),
                          mr_status_text(m->status));
}

/* Readings on CAN. */
static void reading_message(struct live_model *model, const struct live_heard *heard)
{
    const struct mr_series_pack *pack =
        mr_series_pack_at(mr_series_pack_find(heard->message->info->id));
    float values[MR_PACK_READINGS];
    unsigned count = mr_series_pack_get(pack, heard->message->payload, values);
    unsigned first = mr_series_at(pack->series)->kind == MR_KIND_TENSION ? MR_TRANSDUCERS : 0;
    live_model_take_values(model, first + pack->first - 1, count, values, heard->block);
}

static void health_message(struct live_model *model, const struct live_heard *heard)
{
    const struct mr_message *m = heard->message;
    switch (m->place) {
    case MR_PLACE_HEALTH:
        model->health = m->as.health;
        model->health_known = true;
        break;
    case MR_PLACE_FAULT: take_fault(model, &m->as.fault, heard->host_us); break;
    case MR_PLACE_CHANNEL_EVENT:
        take_channel_event(model, &m->as.channel_event, heard->host_us);
        break;
    case MR_PLACE_CAN_ALARM: take_alarm(model, &m->as.can_alarm, heard->host_us); break;
    case MR_PLACE_BOX_STATE:
        model->box = m->as.box_state;
        model->box_known = true;
        break;
    case MR_PLACE_UPKEEP: model->upkeep = m->as.upkeep; break;
    default: break;
    }
}

/* What a landing brings: its state, its gear and its bands. */
static void landing_message(struct live_model *model, const struct live_heard *heard)
{
    const struct mr_message *m = heard->message;
    struct live_link *link = heard->link;
    switch (m->place) {
    case MR_PLACE_LANDING: take_state(model, &m->as.landing, heard->host_us); break;
    case MR_PLACE_EDGE: take_edge(model, &m->as.edge); break;
    case MR_PLACE_MOTION:
        link->motion = m->as.motion;
        take_motion(model, link, NULL, heard->block);
        break;
    case MR_PLACE_MOTION_ERROR:
        if (m->block16 == link->motion.block16)
            take_motion(model, link, &m->as.motion_error, heard->block);
        break;
    case MR_PLACE_TOUCHDOWN:
        model->touchdown = m->as.touchdown;
        model->touchdown_known = true;
        break;
    case MR_PLACE_STOP:
        model->stop = m->as.stop;
        model->stop_known = true;
        break;
    case MR_PLACE_BAND_STATE:
        if (m->as.band_state.band >= 1 && m->as.band_state.band <= LIVE_BANDS)
            model->band[m->as.band_state.band - 1] = m->as.band_state;
        break;
    case MR_PLACE_ACK: take_ack(model, &m->as.ack, heard->host_us); break;
    default: break;
    }
}

/* What the predictor says. */
static void predictor_message(struct live_model *model, const struct live_heard *heard)
{
    const struct mr_message *m = heard->message;
    struct live_link *link = heard->link;
    switch (m->place) {
    case MR_PLACE_ZONE: link->zone = m->as.zone; break;
    case MR_PLACE_ZONE_LEAD:
        take_zone(model, link, &m->as.zone_lead, heard->host_us, heard->block);
        break;
    case MR_PLACE_ZONE_COMING: link->coming = m->as.zone_coming; break;
    case MR_PLACE_ZONE_PRESS: link->press = m->as.zone_press; break;
    case MR_PLACE_RISK: link->risk = m->as.risk; break;
    case MR_PLACE_RISK_ITEM:
        if (m->as.risk_item.index == MR_RISK_ITEMS) /* the first of the limits */
            model->risk.lamp_limit = m->as.risk_item.value;
        break;
    case MR_PLACE_RISK_LEAD: take_risk(model, link, &m->as.risk_lead, heard->block); break;
    case MR_PLACE_RELEASE: take_release(model, &m->as.release, heard->host_us); break;
    case MR_PLACE_VERDICT:
        if (heard->block >= model->verdict.block) {
            model->verdict.coming_known = link->coming.block16 == m->block16;
            model->verdict.coming = link->coming;
            model->verdict.press_known = link->press.block16 == m->block16;
            model->verdict.press = link->press;
        }
        take_verdict(model, &m->as.verdict, heard->host_us, heard->block);
        break;
    default: break;
    }
}

/* What is told once, as a line; of two links the first that says it. */
static void notice_message(struct live_model *model, const struct live_heard *heard)
{
    if (heard->link == &model->link[LINK_CAN] &&
        model->link[LINK_SERIAL].heard_us + 1000000 > heard->host_us)
        return;
    switch (heard->message->place) {
/* clang-format off */
#define NOTICE(name, NAME, severity, ...)                                       \
    case MR_PLACE_##NAME: {                                                     \
        const struct mr_##name *m = &heard->message->as.name;                   \
        live_model_notice(model, LIVE_##severity, heard->host_us, __VA_ARGS__); \
        break;                                                                  \
    }
/* clang-format on */
#include "common/catalogue.def"
    default: break;
    }
}

/* Which part takes a message; the others are not shown. */
static void (*const parts[MR_PLACES])(struct live_model *model, const struct live_heard *heard) = {
#define PACK(SERIES_NAME, name, NAME, id, first, count) [MR_PLACE_##NAME] = reading_message,
#define NOTICE(name, NAME, severity, ...)               [MR_PLACE_##NAME] = notice_message,
#include "common/catalogue.def"
    [MR_PLACE_HELLO] = live_model_take_configuration,
    [MR_PLACE_BOARD_UID] = live_model_take_configuration,
    [MR_PLACE_BOARD_IMAGE] = live_model_take_configuration,
    [MR_PLACE_IMAGE_COMMIT] = live_model_take_configuration,
    [MR_PLACE_BOARD_CONFIG] = live_model_take_configuration,
    [MR_PLACE_SITE] = live_model_take_configuration,
    [MR_PLACE_CHANNEL] = live_model_take_configuration,
    [MR_PLACE_CHANNEL_ZERO] = live_model_take_configuration,
    [MR_PLACE_CALIBRATION] = live_model_take_configuration,
    [MR_PLACE_SWITCH_PLACE] = live_model_take_configuration,
    [MR_PLACE_SLACK] = live_model_take_configuration,
    [MR_PLACE_LANDING] = landing_message,
    [MR_PLACE_EDGE] = landing_message,
    [MR_PLACE_MOTION] = landing_message,
    [MR_PLACE_MOTION_ERROR] = landing_message,
    [MR_PLACE_TOUCHDOWN] = landing_message,
    [MR_PLACE_STOP] = landing_message,
    [MR_PLACE_BAND_STATE] = landing_message,
    [MR_PLACE_ACK] = landing_message,
    [MR_PLACE_ZONE] = predictor_message,
    [MR_PLACE_ZONE_LEAD] = predictor_message,
    [MR_PLACE_RISK] = predictor_message,
    [MR_PLACE_RISK_ITEM] = predictor_message,
    [MR_PLACE_RISK_LEAD] = predictor_message,
    [MR_PLACE_RELEASE] = predictor_message,
    [MR_PLACE_ZONE_COMING] = predictor_message,
    [MR_PLACE_ZONE_PRESS] = predictor_message,
    [MR_PLACE_VERDICT] = predictor_message,
    [MR_PLACE_HEALTH] = health_message,
    [MR_PLACE_FAULT] = health_message,
    [MR_PLACE_CHANNEL_EVENT] = health_message,
    [MR_PLACE_CAN_ALARM] = health_message,
    [MR_PLACE_BOX_STATE] = health_message,
    [MR_PLACE_UPKEEP] = health_message,
};

void live_model_message(struct live_model *model, const struct collector_event *event)
{
    const struct mr_message *m = event->message;
    const struct live_heard heard = {
        .message = m,
        .link = &model->link[event->link],
        .host_us = (int64_t)event->host_us,
        .block = event->board_us == STORE_NONE ? -1 : event->board_us / 1000};
    hear(model, event->link, heard.host_us, heard.block);
    if (m->place != MR_PLACE_HELLO && model->board.layout != 0 && !model->hello)
        return; /* of another layout: it means something else */
    mr_quantity_take(model->quantity, m);
    if (parts[m->place])
        parts[m->place](model, &heard);
}

void live_model_counts(struct live_model *model, enum link_kind kind,
                       const struct store_link_counts *counts, int64_t host_us)
{
    struct store_link_counts *known = &model->link[kind].counts;
    const char *name = kind == LINK_CAN ? "CAN" : "serial";
    int64_t lost = counts->lost - known->lost, dropped = counts->dropped - known->dropped;
    if (lost > 0)
        live_model_notice(model, LIVE_ALARM, host_us, "%s: %lld frames lost on the way", name,
                          (long long)lost);
    if (dropped > 0)
        live_model_notice(model, LIVE_ALARM, host_us, "%s: the board could not send %lld frames",
                          name, (long long)dropped);
    *known = *counts;
}

void live_model_strangers(struct live_model *model, int64_t count, int64_t host_us)
{
    if (count > model->strangers)
        live_model_notice(model, LIVE_ALARM, host_us,
                          "CAN: %lld %s not the board's; what rests on CAN is doubtful",
                          (long long)count, count == 1 ? "frame is" : "frames are");
    model->strangers = count;
}
