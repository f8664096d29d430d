#include "host/replay/diff_field.h"

#include <string.h>

#include "common/fault.h"

static const struct {
    const char *field; /* "message.field"; "*.field": of every message */
    enum field_rule rule;
} rules[] = {
    {"sync_at.tick", FIELD_CIRCUMSTANCE}, /* the bus was busy otherwise */
    {"sync_at.sent", FIELD_CIRCUMSTANCE},
    {"camera.tick", FIELD_CIRCUMSTANCE}, /* the processor was */
    {"*.block16", FIELD_BLOCK16},
    {"*.at_block16", FIELD_BLOCK16},
    {"*.block", FIELD_BLOCK},
    {"*.tick", FIELD_TICK},
    {"can_health.sent", FIELD_QUEUED},
    {"serial_health.sent", FIELD_QUEUED},
    {"health.faults", FIELD_FAULTS},
    {"hello.major", FIELD_IMAGE},
    {"hello.minor", FIELD_IMAGE},
    {"hello.patch", FIELD_IMAGE},
    {"board_image.image_crc", FIELD_IMAGE},
    {"image_commit.commit", FIELD_CIRCUMSTANCE}, /* one program may be built from many commits */
    {"image_commit.commit_more", FIELD_CIRCUMSTANCE},
    {"image_commit.changed", FIELD_CIRCUMSTANCE},
    {"image_commit.state", FIELD_CIRCUMSTANCE},
    {"image_header.program_crc", FIELD_IMAGE},
    {"image_header.header_crc", FIELD_CIRCUMSTANCE},
    {"hello.reset_cause", FIELD_CIRCUMSTANCE},
    {"health.load_permille", FIELD_CIRCUMSTANCE},
    {"can_health.dropped", FIELD_CIRCUMSTANCE},
    {"can_health.tec", FIELD_CIRCUMSTANCE},
    {"can_health.rec", FIELD_CIRCUMSTANCE},
    {"serial_health.dropped", FIELD_CIRCUMSTANCE},
    {"serial_health.bad", FIELD_CIRCUMSTANCE},
    {"channel_quality.error_codes", FIELD_CIRCUMSTANCE}, /* it grows with the hours since power on */
    {"runway_store.source", FIELD_CIRCUMSTANCE}, /* the host gives it to the one that replays */
    {"runway_store.copy_a", FIELD_CIRCUMSTANCE},
    {"runway_store.copy_b", FIELD_CIRCUMSTANCE},
    {"temperature.temperature_c", FIELD_CIRCUMSTANCE},
    {"temperature.error_c", FIELD_CIRCUMSTANCE},
    {"box_state.state", FIELD_CIRCUMSTANCE},
    {"box_state.records", FIELD_CIRCUMSTANCE},
    {"box_state.ready", FIELD_CIRCUMSTANCE},
    {"box_state.wait_s", FIELD_CIRCUMSTANCE},
    {"box_state.reserve", FIELD_CIRCUMSTANCE},
    {"box_space.sectors", FIELD_CIRCUMSTANCE},
    {"box_space.dirty", FIELD_CIRCUMSTANCE},
    {"box_space.bad", FIELD_CIRCUMSTANCE},
    {"box_space.wear", FIELD_CIRCUMSTANCE},
    {"box_record.record", FIELD_CIRCUMSTANCE},
    {"box_record.landing", FIELD_CIRCUMSTANCE},
    {"box_record.pages", FIELD_CIRCUMSTANCE},
    {"box_record.complete", FIELD_CIRCUMSTANCE},
    {"box_span.first_block", FIELD_CIRCUMSTANCE},
    {"box_span.blocks", FIELD_CIRCUMSTANCE},
    {"box_span.lost", FIELD_CIRCUMSTANCE},
};

/* An image that computes a little otherwise: ten times the resolution of the message, or what the estimate's own error
 * allows. Counts, states, names of switches and ticks must be equal whatever the image. */
static const struct {
    const char *unit;
    double tolerance;
} tolerances[] = {
    {"in", 0.002}, {"lb", 0.2}, {"ft", 0.05}, {"ft/s", 0.02}, {"ft/s2", 0.1}, {"s", 0.05}, {"codes", 1.0}, {"ms", 5.0}, {"%", 5.0},
};

/* Messages that say what the links, the clock or the chip did: they come and go with the circumstances. */
static const char *const circumstances[] = {"message_count", "config_refused", "config_image", "config_state", "config_staged",
                                            "crash", "upkeep", "self_test", "can_alarm", "restarts", "can_drops"};

bool field_circumstance(const struct mr_message_info *info)
{
    for (size_t i = 0; i < sizeof circumstances / sizeof circumstances[0]; i++) {
        if (strcmp(circumstances[i], info->name) == 0)
            return true;
    }
    return false;
}

enum field_rule field_rule(const struct mr_message_info *info, const struct mr_field_info *field)
{
    size_t length = strlen(info->name);
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++) {
        const char *rule = rules[i].field;
        bool of_message = strncmp(rule, "*.", 2) == 0 ||
                          (strncmp(rule, info->name, length) == 0 && rule[length] == '.');
        if (of_message && strcmp(strchr(rule, '.') + 1, field->name) == 0)
            return rules[i].rule;
    }
    return FIELD_PLAIN;
}

uint32_t field_record_faults(void)
{
    return 1u << MR_FAULT_REFERENCE | 1u << MR_FAULT_NO_FIT;
}

double field_tolerance(const char *unit)
{
    for (size_t i = 0; i < sizeof tolerances / sizeof tolerances[0]; i++) {
        if (strcmp(tolerances[i].unit, unit) == 0)
            return tolerances[i].tolerance;
    }
    return 0.0;
}

const char *field_tolerances_text(void)
{
    return "0.002 in, 0.2 lb, 0.05 ft, 0.02 ft/s, 0.1 ft/s2, 0.05 s, 1 code, 5 ms, 5 %; counts, states, switches and ticks equal";
}
