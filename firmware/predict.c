#include "firmware/predict.h"

#include <string.h>

#include "common/block.h"
#include "common/wire.h"
#include "firmware/config.h"
#include "firmware/schedule.h"

#define NOTHING_TO_REPORT UINT32_MAX

/* Saves the runway state for reports, and computes its CRC. */
static void save_runway(struct predict *p)
{
    mr_predictor_save(&p->predictor, &p->state);
    p->crc = mr_runway_crc(&p->state);
    p->is_store_due = true;
}

void predict_start(struct predict *p)
{
    mr_risk_plan_clear(&p->plan);
    mr_risk_plan_clear(&p->staged_plan);
}

void predict_configure(struct predict *p, const float *slack_in)
{
    struct mr_predictor_config started;
    if (p->status == MR_OK && p->predictor.config.chain.mats)
        /* keeps the saved state while no predictor is configured */
        mr_predictor_save(&p->predictor, &p->state);
    p->next_report_message = p->next_risk_item = NOTHING_TO_REPORT;
    p->is_warning = false;
    p->lamp_limit = MR_NAN;
    p->status = MR_NOT_NOW;
    if (!config.predict[0].fitted)
        return;
    mr_config_get_predictor(&config, &started);
    p->status = mr_predictor_start(&p->predictor, &started);
    if (p->status != MR_OK)
        return;
    if (mr_predictor_load(&p->predictor, &p->state) != MR_OK) {
        p->source = MR_RUNWAY_UNKNOWN;
        mr_predictor_set_survey(&p->predictor, slack_in);
    }
    save_runway(p);
}

/* --- messages --- */

static void report_zone(const struct predict *p, struct telemetry *telemetry, uint32_t index)
{
    struct predict_report report;
    predict_fill_report(&p->predictor, &p->zone, p->is_warning, index, &report);
    TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, zone, ZONE, &report.zone);
    TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, zone_lead, ZONE_LEAD, &report.zone_lead);
    if (report.zone.mats)
        TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, zone_error, ZONE_ERROR, &report.zone_error);
    TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, zone_coming, ZONE_COMING, &report.zone_coming);
    TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, zone_press, ZONE_PRESS, &report.zone_press);
    TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, verdict, VERDICT, &report.verdict);
    predict_fill_risk_report(&p->risk_report, index, &report);
    TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, risk, RISK, &report.risk);
    TELEMETRY_SEND_MESSAGE(telemetry, TO_RECORD, risk_lead, RISK_LEAD, &report.risk_lead);
}

static uint32_t get_doubted_transducers(const struct mr_predictor *predictor)
{
    uint32_t doubts = 0;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        doubts |= (uint32_t)predictor->doubt[i] << (2u * i);
    return doubts;
}

static void report_trust(struct predict *p, struct telemetry *telemetry, uint32_t index)
{
    uint32_t blocks = index - p->trust_block, updates = p->predictor.updates - p->updates;
    TELEMETRY_SEND(telemetry, TO_RECORD, trust, TRUST, .doubts = (uint16_t)p->reported_doubts,
                   .resistance = p->predictor.resistance_scale,
                   .updates = blocks ? (float)updates / (float)blocks : 0.0f,
                   .block16 = (uint16_t)index);
    p->trust_block = index;
    p->updates = p->predictor.updates;
}

/* Computes the prediction, sets the lamp and sends the messages that are due. */
static void predict_and_report(struct predict *p, struct telemetry *telemetry,
                               const struct landing *landing, uint32_t index)
{
    struct mr_predictor_zone was = p->zone;
    mr_predictor_get_zone(&p->predictor, &p->zone);
    mr_risk_compute(&p->risk, &p->predictor, &p->zone, &p->risk_report);
    bool warning = mr_risk_is_lamp_on(p->lamp_limit, &p->zone, &p->risk_report) &&
                   landing_can_warn(landing, index);
    bool changed = warning != p->is_warning || p->zone.verdict != was.verdict ||
                   p->zone.level != was.level;
    uint32_t doubts = get_doubted_transducers(&p->predictor);
    p->is_warning = warning;
    board_set_warning(warning);
    if (changed || DUE(ZONES, index))
        report_zone(p, telemetry, index);
    if (doubts != p->reported_doubts || index - p->trust_block >= PREDICT_TRUST_BLOCKS) {
        p->reported_doubts = doubts;
        report_trust(p, telemetry, index);
    }
}

static void report_runway(const struct predict *p, struct telemetry *telemetry, unsigned sinks)
{
    TELEMETRY_SEND(telemetry, sinks, runway, RUNWAY, .mats = p->state.mats,
                   .landings = p->state.landing_count, .resistance = p->state.resistance_scale);
}

static void report_store(const struct predict *p, struct telemetry *telemetry, unsigned sinks,
                         const uint8_t *copy)
{
    TELEMETRY_SEND(telemetry, sinks, runway_store, RUNWAY_STORE,
                   .state = p->status == MR_OK ? 0 : (uint8_t)-p->status, .source = p->source,
                   .copy_a = copy[0], .copy_b = copy[1], .crc = p->crc);
}

void predict_send_regular(struct predict *p, struct telemetry *telemetry, const uint8_t *copy,
                          uint32_t index)
{
    if (p->status == MR_NOT_NOW || !(p->is_store_due || DUE(RUNWAY_STORE, index)))
        return;
    p->is_store_due = false;
    report_store(p, telemetry, TO_LINKS, copy);
}

static void report_joints(const struct predict *p, struct telemetry *telemetry, unsigned sinks,
                          unsigned n)
{
    struct mr_runway_joints message = mr_runway_make_message(&p->state, n);
    TELEMETRY_SEND_MESSAGE(telemetry, sinks, runway_joints, RUNWAY_JOINTS, &message);
}

/* Reports the runway on the links: the summary now, the joints in the next blocks. */
static void begin_report(struct predict *p, struct telemetry *telemetry)
{
    report_runway(p, telemetry, TO_LINKS);
    p->next_report_message = 0;
}

/* Returns item n of the report: the items of chart and plan, then the limit of the lamp. */
static float get_risk_item(const struct predict *p, unsigned n)
{
    return n < MR_RISK_PLAN_ITEM_COUNT ? mr_risk_plan_get_item(&p->plan, n) : p->lamp_limit;
}

/* Reports an item. Missing values of a chart are reported only for its first two rows. Returns
 * false if nothing was sent. */
static bool report_risk_item(const struct predict *p, struct telemetry *telemetry, unsigned sinks,
                             unsigned n)
{
    float value = get_risk_item(p, n);
    if (n >= 2 && __builtin_isnan(value))
        return false;
    TELEMETRY_SEND(telemetry, sinks, risk_item, RISK_ITEM, .index = (uint8_t)n,
                   .items = MR_RISK_REPORT_ITEM_COUNT, .value = value);
    return true;
}

static void continue_risk_report(struct predict *p, struct telemetry *telemetry)
{
    /* do not begin a report before the previous one has ended */
    if (p->next_report_message != NOTHING_TO_REPORT)
        return;
    for (unsigned i = 0; i < PREDICT_JOINTS_PER_BLOCK && p->next_risk_item != NOTHING_TO_REPORT;) {
        i += report_risk_item(p, telemetry, TO_LINKS, p->next_risk_item++);
        /* the limit of the lamp is sent only with a landing */
        if (p->next_risk_item >=
            (p->predictor.is_armed ? MR_RISK_REPORT_ITEM_COUNT : MR_RISK_PLAN_ITEM_COUNT))
            p->next_risk_item = NOTHING_TO_REPORT;
    }
}

static void continue_report(struct predict *p, struct telemetry *telemetry)
{
    if (!telemetry_can_burst(telemetry))
        return;
    continue_risk_report(p, telemetry);
    for (unsigned i = 0;
         i < PREDICT_JOINTS_PER_BLOCK && p->next_report_message != NOTHING_TO_REPORT; i++) {
        report_joints(p, telemetry, TO_LINKS, p->next_report_message++);
        if (p->next_report_message >= mr_runway_message_count(&p->state))
            p->next_report_message = NOTHING_TO_REPORT;
    }
}

/* --- a landing --- */

void predict_arm(struct predict *p, struct telemetry *telemetry, const float *slack_in,
                 uint32_t index)
{
    if (p->status != MR_OK)
        return;
    /* Load the state that was just saved, with openings rounded to 0.01 mil as they are reported,
     * so that a replay starts from the same values. Loading cannot fail, because the state is of
     * this runway. */
    save_runway(p);
    (void)mr_predictor_load(&p->predictor, &p->state);
    mr_predictor_mark_surveyed(&p->predictor, slack_in);
    mr_predictor_arm(&p->predictor);
    p->zone = (struct mr_predictor_zone){.level = p->predictor.level};
    p->motion = (struct predict_motion){0};
    p->is_warning = false;
    p->reported_doubts = p->updates = 0;
    p->trust_block = index;
    p->has_backlog = false;
    p->backlog_command = 0;
    p->lamp_limit = mr_risk_lamp_limit(config.risk[0].lamp_cost_ratio);
    mr_risk_arm(&p->risk, p->has_plan ? &p->plan : NULL, &p->predictor,
                config.site[0].touchdown_ft);
    p->risk_report = (struct mr_risk_report){.risk = MR_NAN};
    begin_report(p, telemetry);
    p->next_risk_item = 0;
}

void predict_store_in_box(struct predict *p, struct telemetry *telemetry, const uint8_t *copy)
{
    if (p->status != MR_OK || !telemetry_has_box(telemetry))
        return;
    report_store(p, telemetry, TO_CONFIGURATION, copy);
    p->is_store_due = true; /* also makes the state be reported on the links */
    report_runway(p, telemetry, TO_CONFIGURATION);
    for (unsigned n = 0; n < mr_runway_message_count(&p->state); n++)
        report_joints(p, telemetry, TO_CONFIGURATION, n);
    for (unsigned n = 0; n < MR_RISK_REPORT_ITEM_COUNT; n++)
        (void)report_risk_item(p, telemetry, TO_CONFIGURATION, n);
}

/* Handles a backlog (waiting blocks) at most once per interval: by the next interval the predictor
 * has caught up, or a new backlog is reported. */
static void handle_backlog(struct predict *p, struct telemetry *telemetry,
                           const struct predict_block *block)
{
    unsigned waiting = block->blocks_waiting >= PREDICT_BACKLOG_BLOCKS ? block->blocks_waiting
                                                                       : p->backlog_command;
    bool lately = p->has_backlog && block->index - p->backlog_block < MR_PREDICTOR_INTERVAL_BLOCKS;
    p->backlog_command = 0;
    if (!waiting || lately)
        return;
    p->has_backlog = true;
    p->backlog_block = block->index;
    mr_predictor_reduce_level(&p->predictor);
    TELEMETRY_SEND(telemetry, TO_RECORD, backlog, BACKLOG, .waiting = (uint16_t)waiting,
                   .block = block->index);
}

void predict_on_block(struct predict *p, struct telemetry *telemetry, const struct landing *landing,
                      const struct predict_block *block)
{
    struct mr_predictor_input input;
    continue_report(p, telemetry);
    if (p->status != MR_OK || !p->predictor.is_armed)
        return;
    handle_backlog(p, telemetry, block);
    predict_compute_input(&p->motion, landing, config.site[0].touchdown_ft, block, &input);
    mr_predictor_on_block(&p->predictor, &input);
    mr_risk_on_block(&p->risk, &p->predictor, &input);
    if (DUE(LAMP, block->index))
        predict_and_report(p, telemetry, landing, block->index);
}

static void record_change(struct predict *p, enum mr_runway_source source, uint32_t index)
{
    p->source = (uint8_t)source;
    p->is_dirty = true;
    p->changed_block = index;
    save_runway(p);
}

enum mr_status predict_load(struct predict *p, enum mr_runway_source source, const float *slack_in)
{
    if (p->is_runway_set)
        return MR_OK;
    enum mr_status status = mr_predictor_load(&p->predictor, &p->state);
    if (status != MR_OK)
        return status;
    /* apply a survey that arrived before the runway was loaded */
    mr_predictor_set_survey(&p->predictor, slack_in);
    p->source = (uint8_t)(p->is_dirty ? MR_RUNWAY_MEASURED : source);
    save_runway(p);
    return MR_OK;
}

const struct mr_predictor_state *predict_get_state(struct predict *p)
{
    save_runway(p);
    return &p->state;
}

void predict_mark_stored(struct predict *p, uint32_t crc)
{
    p->is_dirty = p->crc != crc; /* true if the runway has changed since it was stored */
    p->is_store_due = true;
}

static void discard_plan(struct predict *p)
{
    mr_risk_plan_clear(&p->plan);
    p->has_plan = false;
}

bool predict_end(struct predict *p, struct telemetry *telemetry, const struct landing *landing,
                 uint32_t index)
{
    uint32_t held = predict_find_frozen_zeros(&p->predictor, landing);
    bool moved = landing->state != MR_LANDING_ARMED || (held & (held - 1u)) != 0;
    bool folded = p->status == MR_OK && p->predictor.is_armed && moved;
    if (p->status != MR_OK || !p->predictor.is_armed)
        return false;
    if (p->is_warning) { /* end the warning with the landing, and report its end */
        p->zone = (struct mr_predictor_zone){.level = p->zone.level,
                                             .critical_lb = p->zone.critical_lb,
                                             .lead_s = MR_NAN,
                                             .distance_ft = MR_NAN,
                                             .future_wheel_ft = MR_NAN};
        p->is_warning = false;
        board_set_warning(false);
        p->risk_report = (struct mr_risk_report){.risk = MR_NAN,
                                                 .start_s = MR_NAN,
                                                 .failure_s = MR_NAN,
                                                 .failure_ft = MR_NAN,
                                                 .reason = MR_RISK_UNKNOWN};
        report_zone(p, telemetry, index);
    }
    if (folded) {
        p->is_runway_set = true;
        mr_predictor_end_landing(&p->predictor);
        record_change(p, MR_RUNWAY_MEASURED, index);
    }
    p->predictor.is_armed = false;
    if (moved) /* discard the plan, which was valid only for the landing that has ended */
        discard_plan(p);
    return folded;
}

void predict_set_survey(struct predict *p, const float *slack_in, uint32_t index)
{
    if (p->status != MR_OK)
        return;
    mr_predictor_set_survey(&p->predictor, slack_in);
    record_change(p, MR_RUNWAY_MEASURED, index);
}

/* --- commands --- */

static enum mr_status activate_runway(struct predict *p, uint32_t crc, uint32_t index)
{
    p->staged_state.mats = p->predictor.config.chain.mats;
    if (mr_runway_crc(&p->staged_state) != crc)
        return MR_CRC;
    enum mr_status status = mr_predictor_load(&p->predictor, &p->staged_state);
    p->is_runway_set |= status == MR_OK;
    if (status == MR_OK)
        record_change(p, MR_RUNWAY_HOST, index);
    return status;
}

static void discard_runway(struct predict *p, uint32_t index)
{
    struct mr_predictor_config started = p->predictor.config;
    p->status = mr_predictor_start(&p->predictor, &started);
    p->is_runway_set = true;
    record_change(p, MR_RUNWAY_UNKNOWN, index);
}

/* Activates the received chart and plan for the next landing. */
static enum mr_status activate_chart(struct predict *p, uint32_t crc)
{
    bool right = mr_risk_plan_crc(&p->staged_plan) == crc;
    enum mr_status status = right ? mr_risk_plan_check(&p->staged_plan) : MR_CRC;
    /* refuse a chart that was made for another state of the runway */
    if (status == MR_OK && !__builtin_isnan(p->staged_plan.chart_deceleration_ft_s2[0]) &&
        p->staged_plan.landing_count != (float)p->predictor.landing_count)
        status = MR_VERSION;
    if (status == MR_OK) {
        p->plan = p->staged_plan;
        p->has_plan = true;
        p->next_risk_item = 0;
    }
    mr_risk_plan_clear(&p->staged_plan);
    return status;
}

static enum mr_status execute_chart(struct predict *p, const struct mr_command *command)
{
    float value;
    switch (command->code) {
    case MR_COMMAND_CHART_WORD:
        memcpy(&value, &command->argument, sizeof value);
        return mr_risk_plan_set_item(&p->staged_plan, command->index, value) ? MR_OK : MR_USAGE;
    /* discard chart and plan, and any received words of an incomplete chart */
    case MR_COMMAND_CHART_FORGET:
        mr_risk_plan_clear(&p->staged_plan);
        discard_plan(p);
        p->next_risk_item = 0;
        return MR_OK;
    default: return activate_chart(p, (uint32_t)command->argument);
    }
}

enum mr_status predict_set_backlog(struct predict *p, int32_t waiting)
{
    if (p->status != MR_OK)
        return MR_NOT_NOW;
    if (waiting < 1 || waiting > (int32_t)UINT16_MAX)
        return MR_USAGE;
    p->backlog_command = (uint16_t)waiting;
    return MR_OK;
}

enum mr_status predict_execute_command(struct predict *p, struct telemetry *telemetry,
                                       const struct mr_command *command, uint32_t index,
                                       bool *is_survey_discarded)
{
    if (p->status != MR_OK)
        return MR_NOT_NOW;
    switch (command->code) {
    case MR_COMMAND_CHART_WORD:
    case MR_COMMAND_CHART_TAKE:
    case MR_COMMAND_CHART_FORGET: return execute_chart(p, command);
    case MR_COMMAND_RUNWAY_FORGET:
        discard_runway(p, index);
        *is_survey_discarded = true;
        return p->status;
    case MR_COMMAND_RUNWAY_READ:
        save_runway(p);
        begin_report(p, telemetry);
        return MR_OK;
    case MR_COMMAND_RUNWAY_JOINTS:
        mr_runway_apply_joints(&p->staged_state, command->index, command->argument);
        return MR_OK;
    case MR_COMMAND_RUNWAY_WORD:
        return mr_runway_apply_word(&p->staged_state, command->index, command->argument) ? MR_OK
                                                                                         : MR_USAGE;
    default: return activate_runway(p, (uint32_t)command->argument, index);
    }
}
