#include "host/live/json.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/crash.h"
#include "host/base/cli.h"
#include "host/base/units.h"

#define DISPLACEMENT_PER_IN 10000.0
#define TENSION_PER_LB      100.0

static json_t *number(double value)
{
    return cli_json_number(value, 7);
}

/* Text from outside; what is no UTF-8 in it becomes question marks. NULL: null. */
static json_t *outside(const char *text)
{
    json_t *string = text ? json_string(text) : json_null();
    if (string)
        return string;
    char plain[300];
    size_t i = 0;
    for (; text[i] && i + 1 < sizeof plain; i++)
        plain[i] = (unsigned char)text[i] < 0x80 ? text[i] : '?';
    plain[i] = '\0';
    return json_string(plain);
}

static json_t *units_json(bool si)
{
    static const char *const names[UNIT_KINDS] = {"station", "displacement", "speed",
                                                  "deceleration", "tension"};
    json_t *units = json_object();
    for (int kind = 0; kind < UNIT_KINDS; kind++) {
        const struct unit *unit = unit_of((enum unit_kind)kind, si);
        json_object_set_new(units, names[kind],
                            json_pack("{sssf}", "text", unit->text, "factor", unit->factor));
    }
    return units;
}

static json_t *channels_json(const struct live_model *model)
{
    json_t *channels = json_array();
    for (unsigned i = 0; i < LIVE_CHANNELS; i++) {
        const struct mr_channel_config *config = &model->channel[i];
        unsigned number_ = model->zero_known[i] && config->number ? config->number
                         : i < MR_TRANSDUCERS                     ? i + 1
                                                                  : i - MR_TRANSDUCERS + 1;
        bool known = model->channel_known[i];
        char name[16];
        snprintf(name, sizeof name, "%s%u", i < MR_TRANSDUCERS ? "D" : "T", number_);
        json_array_append_new(channels,
                              json_pack("{sssbsosi}", "name", name, "fitted",
                                        !known || config->kind != MR_KIND_NONE, "station_ft",
                                        number(known ? (double)config->station_ft : (double)NAN),
                                        "band", model->zero_known[i] ? config->band : 0));
    }
    return channels;
}

static json_t *runway_json(const struct live_model *model)
{
    json_t *switches = json_array(), *segments = json_array();
    for (unsigned i = 0; i < STORE_SWITCHES_MAX; i++) {
        if (model->switch_known[i])
            json_array_append_new(switches, json_pack("{siso}", "position", i + 1, "station_ft",
                                                      number((double)model->switch_ft[i])));
    }
    for (unsigned i = 0; i < MR_SEGMENTS; i++) {
        const struct mr_slack *s = &model->segment[i];
        if (model->segment_known[i])
            json_array_append_new(segments,
                                  json_pack("{sososiso}", "start_ft", number((double)s->start_ft),
                                            "end_ft", number((double)s->end_ft), "joints",
                                            s->joints, "slack_in", number((double)s->slack_in)));
    }
    return json_pack("{sososo}", "switches", switches, "segments", segments, "touchdown_ft",
                     number((double)model->touchdown_ft));
}

/* What the page calls the quantities among a state's health. */
static json_t *quantities_json(void)
{
    json_t *quantities = json_array();
    for (unsigned i = 0; i < MR_QUANTITIES; i++) {
        const struct mr_quantity_info *q = mr_quantity_at(i);
        json_array_append_new(quantities, json_pack("{sssssssssi}", "key", q->key, "error_key",
                                                    q->error_key, "words", q->words, "unit",
                                                    q->unit, "decimals", q->decimals));
    }
    return quantities;
}

static json_t *board_json(const struct live_model *model)
{
    char uid[25], firmware[16] = "", crc[2][12] = {"", ""};
    live_model_uid(model, uid);
    if (model->board.layout) {
        snprintf(firmware, sizeof firmware, "%u.%u.%u", model->board.major, model->board.minor,
                 model->board.patch);
        snprintf(crc[0], sizeof crc[0], "%08x", (unsigned)model->image_crc);
        snprintf(crc[1], sizeof crc[1], "%08x", (unsigned)model->config_crc);
    }
    return json_pack("{sssssssssssbsi}", "uid", uid, "firmware", firmware, "image_crc", crc[0],
                     "config_crc", crc[1], "commit", model->commit, "other_layout",
                     model->board.layout != 0 && !model->hello, "clock_source",
                     model->board.clock_source);
}

json_t *live_json_configuration(const struct live_model *model, const struct live_source *source)
{
    json_t *from = json_pack("{sosososbss?}", "db", outside(source->db), "can",
                             outside(source->can), "serial", outside(source->serial), "commands",
                             source->commands, "no_commands", source->no_commands);
    return json_pack(
        "{sosososososososfsi}", "units", units_json(source->si), "source", from, "board",
        board_json(model), "channels", channels_json(model), "runway", runway_json(model), "limits",
        json_pack("{si}", "warning_mats", model->warning_mats), "quantities", quantities_json(),
        "bucket_s", LIVE_BUCKET_BLOCKS / 1000.0, "transducers", (int)MR_TRANSDUCERS);
}

static json_t *zone_json(const struct live_zone *zone)
{
    return json_pack("{sisosososbsi}", "mats", zone->block < 0 ? 0 : zone->mats, "start_ft",
                     number(zone->start_ft), "end_ft", number(zone->end_ft), "lead_s",
                     number(zone->lead_s), "warning", zone->warning, "inferred_percent",
                     zone->inferred_percent);
}

static json_t *warning_json(const struct live_warning *warning)
{
    return json_pack("{sbsIsIsoso}", "on", warning->on, "since_us", (json_int_t)warning->since_us,
                     "received_us", (json_int_t)warning->received_us, "first_decided_block",
                     warning->first_block < 0 ? json_null()
                                              : json_integer((json_int_t)warning->first_block),
                     "zone", zone_json(&warning->zone));
}

static json_t *verdict_json(const struct live_model *model)
{
    const struct live_verdict *v = &model->verdict;
    bool zone = v->said.reason != MR_PREDICTOR_COMPRESSION && v->coming_known,
         press = v->said.reason == MR_PREDICTOR_COMPRESSION && v->press_known;
    if (v->block < 0)
        return json_null();
    return json_pack("{sssssbsIsssssosososo}", "says", mr_predictor_verdict_text(v->said.verdict),
                     "reason", mr_predictor_reason_text(v->said.reason), "advisory",
                     live_model_advised(model), "since_us", (json_int_t)v->since_us, "since_reason",
                     mr_predictor_reason_text(v->since_reason), "model",
                     mr_predictor_level_text(v->said.level), "coming_mats",
                     number(zone ? (double)v->coming.mats : (double)NAN), "coming_wheel_ft",
                     number(zone ? (double)v->coming.wheel_ft : (double)NAN), "compression_lb",
                     number(press ? (double)v->press.compression_lb : (double)NAN), "critical_lb",
                     number(press ? (double)v->press.critical_lb : (double)NAN));
}

static json_t *risk_json(const struct live_model *model)
{
    const struct live_risk *r = &model->risk;
    if (r->block < 0)
        return json_null();
    return json_pack(
        "{sososssbsbsosososs}", "risk", number((double)r->said.risk), "lamp_limit",
        number((double)r->lamp_limit), "reason", mr_risk_reason_text(r->said.reason), "of_plan",
        (r->said.basis & MR_RISK_OF_PLAN) != 0, "of_chart", (r->said.basis & MR_RISK_OF_CHART) != 0,
        "start_s", number((double)r->lead.start_s), "failure_s", number((double)r->lead.failure_s),
        "failure_ft", number((double)r->lead.failure_ft), "release",
        r->release_block < 0 ? "" : mr_release_state_text(r->release.state));
}

static json_t *gear_json(const struct live_model *model)
{
    json_t *final = json_null();
    if (model->touchdown_known || model->stop_known)
        final = json_pack(
            "{sososososo}", "touchdown_ft_s",
            number(model->touchdown_known ? (double)model->touchdown.speed_ft_s : (double)NAN),
            "touchdown_error_ft_s",
            number(model->touchdown_known ? (double)model->touchdown.speed_error_ft_s
                                          : (double)NAN),
            "deceleration_ft_s2",
            number(model->touchdown_known ? (double)model->touchdown.deceleration_ft_s2
                                          : (double)NAN),
            "stop_ft", number(model->stop_known ? (double)model->stop.station_ft : (double)NAN),
            "after_s",
            number(model->stop_known ? (double)model->stop.after_touchdown_s : (double)NAN));
    return json_pack("{sosososososiso}", "station_ft", number(live_model_gear_ft(model)),
                     "speed_ft_s", number((double)model->speed_ft_s), "speed_error_ft_s",
                     number((double)model->speed_error_ft_s), "deceleration_ft_s2",
                     number((double)model->deceleration_ft_s2), "deceleration_error_ft_s2",
                     number((double)model->deceleration_error_ft_s2), "edges", model->edges,
                     "final", final);
}

static json_t *opened_json(const struct live_model *model)
{
    json_t *opened = json_array();
    for (unsigned i = 0; i < STORE_SWITCHES_MAX; i++) {
        if (model->opened >> i & 1u)
            json_array_append_new(opened, json_integer(i + 1));
    }
    return opened;
}

static json_t *readings_json(const struct live_model *model)
{
    json_t *readings = json_array();
    for (unsigned i = 0; i < LIVE_CHANNELS; i++) {
        const struct live_reading *r = &model->reading[i];
        const char *why = live_model_reading_text(model, i);
        json_array_append_new(readings,
                              json_pack("[ooos]", number((double)r->value),
                                        number((double)r->least), number((double)r->most), why));
    }
    return readings;
}

static json_t *links_json(const struct live_model *model)
{
    json_t *links = json_array();
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct live_link *link = &model->link[kind];
        json_array_append_new(
            links,
            json_pack("{sssbsIsIsIsIsIsI}", "name", kind == LINK_CAN ? "CAN" : "serial", "used",
                      link->used, "received", (json_int_t)link->counts.received, "lost",
                      (json_int_t)link->counts.lost, "dropped", (json_int_t)link->counts.dropped,
                      "bad", (json_int_t)link->counts.bad, "foreign",
                      (json_int_t)link->counts.foreign, "heard_us", (json_int_t)link->heard_us));
    }
    return links;
}

static json_t *health_json(const struct live_model *model)
{
    json_t *health = json_object(), *faults = json_array();
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        if (model->health_known && model->health.faults >> i & 1u)
            json_array_append_new(faults, json_pack("{sisssi}", "code", i, "text", mr_fault_text(i),
                                                    "count", model->fault_count[i]));
    }
    json_object_set_new(health, "faults", faults);
    json_object_set_new(health, "known", json_boolean(model->health_known));
    json_object_set_new(health, "blocks_lost", json_integer(model->health.blocks_lost));
    json_object_set_new(health, "restarts", json_integer((json_int_t)model->restarts));
    json_object_set_new(
        health, "can",
        json_string(model->alarm_known ? mr_can_state_text(model->alarm.state) : ""));
    json_object_set_new(health, "can_good",
                        json_boolean(!model->alarm_known || model->alarm.state == MR_CAN_GOOD));
    json_object_set_new(health, "black_box",
                        json_string(model->box_known && model->box.state <= MR_BOX_FAILED
                                        ? mr_box_condition_text(model->box.state)
                                        : ""));
    json_object_set_new(health, "black_box_good",
                        json_boolean(!model->box_known || (model->box.state >= MR_BOX_READY &&
                                                           model->box.state <= MR_BOX_CLOSING)));
    json_object_set_new(health, "black_box_wait_s",
                        number(model->box_known ? (double)model->box.wait_s : (double)NAN));
    json_object_set_new(health, "black_box_records", json_integer(model->box.records));
    for (unsigned i = 0; i < MR_QUANTITIES; i++) {
        json_object_set_new(health, mr_quantity_at(i)->key, number(model->quantity[i].value));
        json_object_set_new(health, mr_quantity_at(i)->error_key, number(model->quantity[i].error));
    }
    json_object_set_new(health, "stack_used", json_integer(model->upkeep.stack_used));
    json_object_set_new(health, "stack_size", json_integer(model->upkeep.stack_size));
    return health;
}

static json_t *bands_json(const struct live_model *model)
{
    json_t *bands = json_array();
    for (unsigned i = 0; i < LIVE_BANDS; i++) {
        const struct mr_band_state *band = &model->band[i];
        if (band->band)
            json_array_append_new(bands, json_pack("{sisososo}", "band", band->band, "least_lb",
                                                   number((double)band->least_lb), "mean_lb",
                                                   number((double)band->mean_lb), "most_lb",
                                                   number((double)band->most_lb)));
    }
    return bands;
}

static json_t *notices_json(const struct live_model *model)
{
    static const char *const severity[] = {"say", "note", "alarm"};
    json_t *notices = json_array();
    uint64_t first = model->notices > LIVE_NOTICES ? model->notices - LIVE_NOTICES : 0;
    for (uint64_t i = first; i < model->notices; i++) {
        const struct live_notice *n = &model->notice[i % LIVE_NOTICES];
        json_array_append_new(notices, json_pack("{sIsIssss}", "n", (json_int_t)n->number, "us",
                                                 (json_int_t)n->host_us, "severity",
                                                 severity[n->severity], "text", n->text));
    }
    return notices;
}

json_t *live_json_state(const struct live_model *model, int64_t now_us)
{
    json_t *state = json_object();
    json_object_set_new(state, "now_us", json_integer(now_us));
    json_object_set_new(state, "heard_us", json_integer(live_model_heard_us(model)));
    json_object_set_new(state, "block", json_integer(live_model_block(model)));
    json_object_set_new(state, "hello", json_boolean(model->hello));
    json_object_set_new(
        state, "state",
        json_string(model->state_known ? mr_landing_state_text(model->state) : "unknown"));
    json_object_set_new(state, "landing", json_integer(model->landing));
    json_object_set_new(
        state, "source",
        json_string(model->record_block >= 0 && live_model_block(model) - model->record_block < 500
                        ? "serial, each ms"
                        : "CAN"));
    json_object_set_new(state, "late", json_integer((json_int_t)(model->late + model->forgotten)));
    json_object_set_new(state, "warning", warning_json(&model->warning));
    json_object_set_new(state, "verdict", verdict_json(model));
    json_object_set_new(state, "risk", risk_json(model));
    json_object_set_new(state, "zone", zone_json(&model->zone));
    json_object_set_new(state, "gear", gear_json(model));
    json_object_set_new(state, "opened", opened_json(model));
    json_object_set_new(state, "readings", readings_json(model));
    json_object_set_new(state, "bands", bands_json(model));
    json_object_set_new(state, "links", links_json(model));
    json_object_set_new(state, "health", health_json(model));
    json_object_set_new(state, "notices", notices_json(model));
    return state;
}

static void put_values(FILE *out, const float values[LIVE_CHANNELS])
{
    for (unsigned i = 0; i < LIVE_CHANNELS; i++) {
        if (isfinite(values[i]))
            fprintf(out, ",%ld",
                    lround((double)values[i] *
                           (i < MR_TRANSDUCERS ? DISPLACEMENT_PER_IN : TENSION_PER_LB)));
        else
            fputs(",null", out);
    }
}

char *live_json_buckets(uint32_t run, uint64_t restarts, const struct live_bucket *buckets,
                        unsigned count)
{
    char *text = NULL;
    size_t length;
    FILE *out = open_memstream(&text, &length);
    if (!out)
        return NULL;
    fprintf(out, "{\"epoch\":\"%08x-%llu\",\"b\":[", (unsigned)run, (unsigned long long)restarts);
    for (unsigned i = 0; i < count; i++) {
        fprintf(out, "%s[%lld", i ? "," : "", (long long)buckets[i].bucket);
        put_values(out, buckets[i].least);
        put_values(out, buckets[i].most);
        fputc(']', out);
    }
    fputs("]}", out);
    return fclose(out) == 0 ? text : (free(text), NULL);
}
