#include "common/config.h"

#include <string.h>

#include "common/block.h"
#include "common/channels.h"
#include "common/crc32.h"
#include "common/gain.h"
#include "common/predictor.h"
#include "common/staircase.h"
#include "common/wire.h"

#define MAGIC             0x4643524du /* "MRCF" */
#define MISSING_REAL_BITS 0x7fc00000u
#define CODE_MAX          4095u
#define G_FT_S2           32.174f
#define IN_PER_FT         12.0f
#define MS_PER_S          1000.0f

_Static_assert(MR_CONFIG_STEP_MIN_CODES >= 2u * (unsigned)MR_STAIRCASE_TOLERANCE_CODES,
               "the smallest step is larger than the tolerance");

/* clang-format off */
#define GROUP(name, count) static const struct mr_config_field name##_fields[] = {
#define INTEGER(group, type, field, least, most, unit, text)                                     \
    {#field, MR_CONFIG_TYPE_##type, 1, offsetof(struct mr_##group##_config, field), least, most, \
     0.0f, 0.0f},
#define REAL(group, field, least, most, unit, text)                                     \
    {#field, MR_CONFIG_TYPE_REAL, 1, offsetof(struct mr_##group##_config, field), 0, 0, \
     (float)(least), (float)(most)},
#define OPTIONAL(group, field, least, most, unit, text)                                     \
    {#field, MR_CONFIG_TYPE_OPTIONAL, 1, offsetof(struct mr_##group##_config, field), 0, 0, \
     (float)(least), (float)(most)},
#define REALS(group, field, count, least, most, unit, text)                                 \
    {#field, MR_CONFIG_TYPE_REAL, count, offsetof(struct mr_##group##_config, field), 0, 0, \
     (float)(least), (float)(most)},
#define TEXT(group, field, size, text)                                                           \
    {#field, MR_CONFIG_TYPE_TEXT, size, offsetof(struct mr_##group##_config, field), 0, 0, 0.0f, \
     0.0f},
#define END_GROUP(name) };
/* clang-format on */
#include "common/config.def"

const struct mr_config_group mr_config_groups[] = {
#define GROUP(name, count)              \
    {#name,                             \
     count,                             \
     MR_FIELDS_##name,                  \
     offsetof(struct mr_config, name),  \
     sizeof(struct mr_##name##_config), \
     name##_fields},
#include "common/config.def"
};

_Static_assert(sizeof mr_config_groups / sizeof mr_config_groups[0] == MR_CONFIG_GROUP_COUNT,
               "the table has a row for each group");

/* Extends a CRC by a name, without its terminating zero. */
static uint32_t add_name_to_crc(uint32_t crc, const char *name)
{
    for (; *name; name++)
        crc = mr_crc32(crc, (const uint8_t *)name, 1);
    return crc;
}

uint32_t mr_config_layout_crc(void)
{
    uint32_t crc = 0;
    for (unsigned g = 0; g < MR_CONFIG_GROUP_COUNT; g++) {
        const struct mr_config_group *group = &mr_config_groups[g];
        crc = add_name_to_crc(crc, group->name);
        crc = mr_crc32(crc, &group->count, 1);
        for (unsigned f = 0; f < group->field_count; f++) {
            const struct mr_config_field *field = &group->fields[f];
            crc = add_name_to_crc(crc, field->name);
            crc = mr_crc32(crc, (const uint8_t[]){field->type, field->count}, 2);
        }
    }
    return crc;
}

static unsigned get_element_size(const struct mr_config_field *field)
{
    switch (field->type) {
    case MR_CONFIG_TYPE_u8:
    case MR_CONFIG_TYPE_TEXT: return 1;
    case MR_CONFIG_TYPE_u16: return 2;
    default: return 4;
    }
}

/* Returns the bits of an element; a real in its IEEE 754 form. */
static uint32_t get_element(const uint8_t *at, unsigned size)
{
    uint16_t half;
    uint32_t word;
    if (size == 1)
        return *at;
    if (size == 2) {
        memcpy(&half, at, sizeof half);
        return half;
    }
    memcpy(&word, at, sizeof word);
    return word;
}

static void set_element(uint8_t *at, unsigned size, uint32_t bits)
{
    uint16_t half = (uint16_t)bits;
    if (size == 1)
        *at = (uint8_t)bits;
    else if (size == 2)
        memcpy(at, &half, sizeof half);
    else
        memcpy(at, &bits, sizeof bits);
}

static uint8_t *put_bits(uint8_t *p, unsigned size, uint32_t bits)
{
    return size == 1 ? mr_put_u8(p, (uint8_t)bits)
         : size == 2 ? mr_put_u16(p, (uint16_t)bits)
                     : mr_put_u32(p, bits);
}

static uint32_t get_bits(const uint8_t **p, unsigned size)
{
    return size == 1 ? mr_get_u8(p) : size == 2 ? mr_get_u16(p) : mr_get_u32(p);
}

static uint8_t *get_group_address(struct mr_config *config, const struct mr_config_group *group,
                                  unsigned index)
{
    return (uint8_t *)config + group->offset + index * group->size;
}

/* Visits all elements in table order: `to_image` copies from `config` to `fields`, `to_config` from
 * `fields` to `config`; both together exchange the values. */
static void copy_elements(uint8_t *fields, struct mr_config *config, bool to_image, bool to_config)
{
    uint8_t *p = fields;
    for (unsigned g = 0; g < MR_CONFIG_GROUP_COUNT; g++) {
        const struct mr_config_group *group = &mr_config_groups[g];
        for (unsigned n = 0; n < group->count * group->field_count; n++) {
            const struct mr_config_field *field = &group->fields[n % group->field_count];
            uint8_t *at = get_group_address(config, group, n / group->field_count) + field->offset;
            unsigned size = get_element_size(field);
            for (unsigned e = 0; e < field->count; e++, at += size, p += size) {
                const uint8_t *stored = p;
                uint32_t old = get_element(at, size);
                if (to_config)
                    set_element(at, size, get_bits(&stored, size));
                if (to_image)
                    put_bits(p, size, old);
            }
        }
    }
}

uint32_t mr_config_encode(const struct mr_config *config, uint8_t *image)
{
    uint8_t *p = mr_put_u32(image, MAGIC);
    memset(image, 0, MR_CONFIG_IMAGE_BYTES);
    p = mr_put_u32(image, MAGIC);
    p = mr_put_u16(mr_put_u16(p, MR_CONFIG_FORMAT), 0);
    p = mr_put_u32(p, MR_CONFIG_IMAGE_BYTES);
    p = mr_put_u32(p, mr_config_layout_crc());
    p = mr_put_u32(p, config->site[0].revision);
    /* the cast is safe, because copy_elements only reads the configuration here */
    copy_elements(p, (struct mr_config *)(uintptr_t)config, true, false);
    uint32_t crc = mr_crc32(0, image, MR_CONFIG_IMAGE_BYTES - 4);
    mr_put_u32(image + MR_CONFIG_IMAGE_BYTES - 4, crc);
    return crc;
}

enum mr_status mr_config_check_image(const uint8_t *image, size_t length)
{
    const uint8_t *p = image;
    if (length < MR_CONFIG_HEADER_BYTES + 4)
        return MR_TRUNCATED;
    if (mr_get_u32(&p) != MAGIC)
        return MR_MALFORMED;
    uint16_t format = mr_get_u16(&p);
    uint16_t reserved = mr_get_u16(&p);
    uint32_t own_length = mr_get_u32(&p);
    uint32_t layout = mr_get_u32(&p);
    if (own_length < MR_CONFIG_HEADER_BYTES + 4)
        return MR_MALFORMED;
    if (own_length > length)
        return MR_TRUNCATED;
    p = image + own_length - 4;
    if (mr_get_u32(&p) != mr_crc32(0, image, own_length - 4))
        return MR_CRC;
    if (format != MR_CONFIG_FORMAT || reserved || own_length != MR_CONFIG_IMAGE_BYTES ||
        layout != mr_config_layout_crc())
        return MR_VERSION;
    return MR_OK;
}

enum mr_status mr_config_decode(const uint8_t *image, size_t length, struct mr_config *config)
{
    enum mr_status status = mr_config_check_image(image, length);
    if (status == MR_OK)
        /* the cast is safe, because copy_elements only reads the image here */
        copy_elements((uint8_t *)(uintptr_t)image + MR_CONFIG_HEADER_BYTES, config, false, true);
    return status;
}

void mr_config_swap_image(uint8_t *image, struct mr_config *config)
{
    copy_elements(image + MR_CONFIG_HEADER_BYTES, config, true, true);
}

static enum mr_config_rule check_real(const struct mr_config_field *field, const uint8_t *at)
{
    uint32_t bits = get_element(at, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    /* use one bit pattern for a missing value, so that equal configurations have equal images */
    if (__builtin_isnan(value))
        return field->type == MR_CONFIG_TYPE_OPTIONAL && bits == MISSING_REAL_BITS
                 ? MR_RULE_NONE
                 : MR_RULE_NOT_A_NUMBER;
    return value < field->real_min ? MR_RULE_TOO_SMALL
         : value > field->real_max ? MR_RULE_TOO_LARGE
                                   : MR_RULE_NONE;
}

static enum mr_config_rule check_text(const struct mr_config_field *field, const uint8_t *at)
{
    bool ended = false;
    for (unsigned i = 0; i < field->count; i++) {
        bool printable = at[i] >= ' ' && at[i] <= '~';
        if (at[i] ? ended || !printable : false)
            return MR_RULE_NOT_TEXT;
        ended = ended || !at[i];
    }
    return MR_RULE_NONE;
}

static enum mr_config_rule check_element(const struct mr_config_field *field, const uint8_t *at)
{
    if (field->type == MR_CONFIG_TYPE_REAL || field->type == MR_CONFIG_TYPE_OPTIONAL)
        return check_real(field, at);
    uint32_t value = get_element(at, get_element_size(field));
    return value < field->int_min ? MR_RULE_TOO_SMALL
         : value > field->int_max ? MR_RULE_TOO_LARGE
                                  : MR_RULE_NONE;
}

static enum mr_config_rule check_field(const struct mr_config_field *field, const uint8_t *at,
                                       uint8_t *element)
{
    enum mr_config_rule rule = MR_RULE_NONE;
    *element = 0;
    if (field->type == MR_CONFIG_TYPE_TEXT)
        return check_text(field, at);
    for (unsigned e = 0; e < field->count && rule == MR_RULE_NONE; e++) {
        *element = (uint8_t)e;
        rule = check_element(field, at + e * get_element_size(field));
    }
    return rule;
}

static bool check_limits(const struct mr_config *config, struct mr_config_violation *reason)
{
    for (unsigned g = 0; g < MR_CONFIG_GROUP_COUNT; g++) {
        const struct mr_config_group *group = &mr_config_groups[g];
        for (unsigned n = 0; n < group->count * group->field_count; n++) {
            unsigned f = n % group->field_count, index = n / group->field_count;
            const uint8_t *at = (const uint8_t *)config + group->offset + index * group->size +
                                group->fields[f].offset;
            *reason = (struct mr_config_violation){
                .group = (uint8_t)g, .index = (uint8_t)index, .field = (uint8_t)f};
            reason->rule = (uint8_t)check_field(&group->fields[f], at, &reason->element);
            if (reason->rule)
                return false;
        }
    }
    return true;
}

/* Sets the reason why a field is refused: SET_REASON(reason, channel, i, kind,
 * MR_RULE_WRONG_INPUT). More members may follow: .element, .other. */
#define SET_REASON(reason, name, n, which, ...)                                   \
    (*(reason) = (struct mr_config_violation){.group = MR_GROUP_##name,           \
                                              .index = (uint8_t)(n),              \
                                              .field = MR_FIELD_##name##_##which, \
                                              .rule = (uint8_t)__VA_ARGS__},      \
     false)

static bool has_switch(const struct mr_config *config)
{
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++) {
        if (config->gate[i].step_codes)
            return true;
    }
    return false;
}

/* The wiring of the converter inputs is fixed: transducers at ADC3; gages, staircase and reference
 * at ADC1. */
static bool check_channel_input(const struct mr_config *config, unsigned i,
                                struct mr_config_violation *reason)
{
    unsigned kind = config->channel[i].kind;
    bool right = i < MR_TRANSDUCERS ? kind == MR_KIND_DISPLACEMENT || kind == MR_KIND_NONE
               : i < MR_TRANSDUCERS + MR_ADC1_STAIRCASE
                   ? kind == MR_KIND_TENSION || kind == MR_KIND_NONE
               : i == MR_TRANSDUCERS + MR_ADC1_STAIRCASE
                   ? kind == MR_KIND_STAIRCASE || (kind == MR_KIND_NONE && !has_switch(config))
                   : kind == MR_KIND_REFERENCE;
    return right || SET_REASON(reason, channel, i, kind, MR_RULE_WRONG_INPUT);
}

static bool check_number(const struct mr_config *config, unsigned i,
                         struct mr_config_violation *reason)
{
    const struct mr_channel_config *channel = &config->channel[i];
    if (channel->kind != MR_KIND_DISPLACEMENT && channel->kind != MR_KIND_TENSION)
        return true;
    if (channel->number == 0)
        return SET_REASON(reason, channel, i, number, MR_RULE_MUST_NOT_BE_ZERO);
    for (unsigned k = 0; k < i; k++) {
        if (config->channel[k].kind == channel->kind &&
            config->channel[k].number == channel->number)
            return SET_REASON(reason, channel, i, number, MR_RULE_NUMBER_IN_USE,
                              .other = (uint8_t)k);
    }
    return true;
}

/* Checks that the stations of the transducers rise with the channel numbers, because
 * common/closure.c uses neighbouring channels as the ends of an interval. */
static bool check_station(const struct mr_config *config, unsigned i,
                          struct mr_config_violation *reason)
{
    const struct mr_channel_config *channel = &config->channel[i];
    if (channel->kind != MR_KIND_DISPLACEMENT)
        return true;
    if (__builtin_isnan(channel->station_ft))
        return SET_REASON(reason, channel, i, station_ft, MR_RULE_NO_STATION);
    for (unsigned k = 0; k < i; k++) {
        if (config->channel[k].kind == MR_KIND_DISPLACEMENT &&
            !(channel->station_ft > config->channel[k].station_ft))
            return SET_REASON(reason, channel, i, station_ft, MR_RULE_NOT_RISING,
                              .other = (uint8_t)k);
    }
    return true;
}

static bool check_points(const struct mr_channel_config *channel, unsigned i,
                         struct mr_config_violation *reason)
{
    if (channel->points == 1)
        return SET_REASON(reason, channel, i, points, MR_RULE_ONE_POINT);
    for (unsigned k = 1; k < channel->points; k++) {
        if (!(channel->point_reading[k] > channel->point_reading[k - 1]))
            return SET_REASON(reason, channel, i, point_reading, MR_RULE_NOT_RISING,
                              .element = (uint8_t)k, .other = (uint8_t)(k - 1));
        if (!(channel->point_value[k] > channel->point_value[k - 1]))
            return SET_REASON(reason, channel, i, point_value, MR_RULE_NOT_RISING,
                              .element = (uint8_t)k, .other = (uint8_t)(k - 1));
    }
    return true;
}

/* Checks that the gain is physically possible with the sensors and electronics of this rig. */
static bool check_gain(const struct mr_channel_config *channel, unsigned i,
                       struct mr_config_violation *reason)
{
    enum mr_config_rule rule = mr_channel_is_sensor(channel) ? mr_gain_check(channel)
                                                             : MR_RULE_NONE;
    return rule == MR_RULE_NONE || SET_REASON(reason, channel, i, unit_per_code, rule);
}

static bool check_channel(const struct mr_config *config, unsigned i,
                          struct mr_config_violation *reason)
{
    const struct mr_channel_config *channel = &config->channel[i];
    if (!check_channel_input(config, i, reason))
        return false;
    if (channel->kind == MR_KIND_NONE)
        return true;
    if (channel->unit_per_code == 0.0f)
        return SET_REASON(reason, channel, i, unit_per_code, MR_RULE_MUST_NOT_BE_ZERO);
    bool ranged = channel->low != 0.0f || channel->high != 0.0f;
    if (ranged && !(channel->high > channel->low))
        return SET_REASON(reason, channel, i, high, MR_RULE_NOT_ABOVE,
                          .other = MR_FIELD_channel_low);
    if (channel->expires_day && channel->expires_day <= channel->calibrated_day)
        return SET_REASON(reason, channel, i, expires_day, MR_RULE_NOT_ABOVE,
                          .other = MR_FIELD_channel_calibrated_day);
    if (channel->expires_day && !channel->calibrated_day)
        return SET_REASON(reason, channel, i, calibrated_day, MR_RULE_MUST_NOT_BE_ZERO);
    if (channel->band && !(config->band[channel->band - 1].pretension_lb > 0.0f))
        return SET_REASON(reason, channel, i, band, MR_RULE_NO_BAND);
    return check_number(config, i, reason) && check_station(config, i, reason) &&
           check_points(channel, i, reason) && check_gain(channel, i, reason);
}

static bool check_gate(const struct mr_config *config, unsigned i,
                       struct mr_config_violation *reason)
{
    const struct mr_gate_config *gate = &config->gate[i];
    if (!gate->step_codes)
        return true;
    if (gate->step_codes < MR_CONFIG_STEP_MIN_CODES)
        return SET_REASON(reason, gate, i, step_codes, MR_RULE_TOO_SMALL);
    float sum_codes = config->channel[MR_TRANSDUCERS + MR_ADC1_STAIRCASE].zero_code +
                      (float)gate->step_codes;
    for (unsigned k = 0; k < i; k++) {
        const struct mr_gate_config *before = &config->gate[k];
        unsigned apart = before->step_codes > gate->step_codes
                           ? before->step_codes - gate->step_codes
                           : gate->step_codes - before->step_codes;
        sum_codes += (float)before->step_codes;
        if (before->step_codes && !(gate->station_ft > before->station_ft))
            return SET_REASON(reason, gate, i, station_ft, MR_RULE_NOT_RISING, .other = (uint8_t)k);
        if (before->step_codes && apart < MR_CONFIG_STEP_DISTANCE_MIN_CODES)
            return SET_REASON(reason, gate, i, step_codes, MR_RULE_STEPS_TOO_CLOSE,
                              .other = (uint8_t)k);
    }
    return sum_codes <= (float)CODE_MAX ||
           SET_REASON(reason, gate, i, step_codes, MR_RULE_SUM_TOO_LARGE);
}

void mr_config_get_predictor(const struct mr_config *config, struct mr_predictor_config *predictor)
{
    const struct mr_predict_config *p = &config->predict[0];
    *predictor = (struct mr_predictor_config){
        .chain = {.mats = config->site[0].mats,
                  .mat_length_ft = config->site[0].mat_length_ft,
                  .mass_slug = p->mat_weight_lb / G_FT_S2,
                  .friction_lb = p->friction * p->mat_weight_lb,
                  .kl_lb_ft = p->joint_stiffness_lb_ft,
                  .cl_lb_s_ft = p->joint_damping_lb_s_ft,
                  .slack_ft = p->slack_in / IN_PER_FT,
                  .step_s = p->step_ms / MS_PER_S},
        .grit_lb = p->grit_lb,
        .thrust_lb_per_g = p->thrust_lb_per_g,
        .deceleration_ft_s2 = p->deceleration_ft_s2,
        .bump_ft = p->bump_in / IN_PER_FT,
        .mat_weight_lb = p->mat_weight_lb,
        .updates_per_block = p->updates_per_block,
        .level = (enum mr_predictor_level)p->level,
    };
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        predictor->station_ft[i] = config->channel[i].kind == MR_KIND_DISPLACEMENT
                                     ? config->channel[i].station_ft
                                     : MR_NAN;
}

static bool check_band(const struct mr_config *config, unsigned i,
                       struct mr_config_violation *reason)
{
    const struct mr_band_config *band = &config->band[i];
    bool right = band->yield_lb == 0.0f || band->yield_lb > band->pretension_lb;
    return right || SET_REASON(reason, band, i, yield_lb, MR_RULE_NOT_ABOVE,
                               .other = MR_FIELD_band_pretension_lb);
}

/* Checks the values of a predictor that is to run; otherwise they may have any value within the
 * limits. */
static bool check_predictor(const struct mr_config *config, struct mr_config_violation *reason)
{
    struct mr_predictor_config predictor;
    if (!config->predict[0].fitted)
        return true;
    mr_config_get_predictor(config, &predictor);
    return predictor.chain.step_s <=
               MR_CHAIN_STEP_MARGIN * mr_chain_step_limit_s(&predictor.chain) ||
           SET_REASON(reason, predict, 0, step_ms, MR_RULE_UNSTABLE);
}

enum mr_status mr_config_check(const struct mr_config *config, struct mr_config_violation *reason)
{
    if (!check_limits(config, reason))
        return MR_LIMIT;
    for (unsigned i = 0; i < MR_CHANNELS; i++) {
        if (!check_channel(config, i, reason))
            return MR_LIMIT;
    }
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++) {
        if (!check_gate(config, i, reason))
            return MR_LIMIT;
    }
    for (unsigned i = 0; i < MR_CONFIG_BANDS; i++) {
        if (!check_band(config, i, reason))
            return MR_LIMIT;
    }
    if (!check_predictor(config, reason))
        return MR_LIMIT;
    if (config->site[0].wheel_pulses && !(config->site[0].wheel_radius_ft > 0.0f)) {
        (void)SET_REASON(reason, site, 0, wheel_radius_ft, MR_RULE_MUST_NOT_BE_ZERO);
        return MR_LIMIT;
    }
    *reason = (struct mr_config_violation){0};
    return MR_OK;
}
