#include <stdio.h>

#include "common/gain.h"
#include "host/board/configplace.h"
#include "host/board/configtext.h"
#include "host/calibrate/mistake.h"

static void name_element(struct configplace at, unsigned element, char out[CONFIGPLACE_NAME + 40])
{
    char name[CONFIGPLACE_NAME];
    configplace_name(at, name);
    if (configplace_field(at)->count > 1 && configplace_field(at)->type != MR_CONFIG_TYPE_TEXT)
        snprintf(out, CONFIGPLACE_NAME + 40, "value %u of %s", element + 1, name);
    else
        snprintf(out, CONFIGPLACE_NAME + 40, "%s", name);
}

static const char *rule_text(unsigned rule)
{
    switch (rule) {
/* clang-format off */
#define RULE_CASE(NAME, number, text) case number: return text;
        /* clang-format on */
        MR_CONFIG_RULE_TABLE(RULE_CASE)
#undef RULE_CASE
    default: return "unknown rule";
    }
}

static bool is_known(const struct mr_config_reason *r)
{
    return r->group < MR_CONFIG_GROUPS && r->index < mr_config_groups[r->group].count &&
           r->field < mr_config_groups[r->group].field_count;
}

/* The other place that a reason speaks of, and its value. */
static bool find_other(const struct mr_config_reason *r, struct configplace *other)
{
    *other = (struct configplace){r->group, r->index, r->field};
    if (r->rule == MR_RULE_NOT_ABOVE)
        other->field = r->other;
    else if (r->rule == MR_RULE_ALIKE || r->rule == MR_RULE_TAKEN)
        other->index = r->other;
    else if (r->rule == MR_RULE_NOT_RISING && configplace_field(*other)->count == 1)
        other->index = r->other;
    else
        return false;
    return other->index < mr_config_groups[other->group].count &&
           other->field < mr_config_groups[other->group].field_count;
}

static const char *const right_kinds = "channel[1] to [8] are displacement (1), [9] to [22] "
                                       "tension (2), [23] the staircase (3; 0 where no "
                                       "switch is fitted), [24] the reference (4); 0: not fitted";

/* Why a gain is impossible, in figures, and what mistake it looks like. */
static void write_gain_advice(const struct mr_channel_config *channel, unsigned rule, char *out,
                              size_t size)
{
    const char *unit = channel->kind == MR_KIND_DISPLACEMENT ? "in" : "lb";
    const struct mr_gain_limits limits = mr_gain_limits(channel);
    char mistake[80];
    mistake_text(channel, mistake, sizeof mistake);
    if (rule == MR_RULE_NARROW)
        snprintf(out, size, "low to high, %g to %g %s, are %.0f codes, at least %.0f are wanted%s",
                 (double)channel->low, (double)channel->high, unit,
                 (double)mr_channel_range_codes(channel), (double)MR_RANGE_LEAST_CODES, mistake);
    else if (rule == MR_RULE_UNREACHED)
        snprintf(
            out, size,
            "%.0f %% of low to high, %g to %g %s, are on the converter, at least %.0f are wanted%s",
            100.0 * (double)mr_channel_reached(channel), (double)channel->low,
            (double)channel->high, unit, 100.0 * (double)MR_RANGE_REACHED, mistake);
    else
        snprintf(out, size, "a %s gives %.3g to %.3g %s per code%s",
                 channel->kind == MR_KIND_DISPLACEMENT ? "transducer" : "gage",
                 (double)limits.least, (double)limits.most, unit, mistake);
}

static void write_advice(const struct mr_config *config, const struct mr_config_reason *r,
                         char *out, size_t size)
{
    struct configplace at = {r->group, r->index, r->field};
    char limits[200];
    configplace_limits(configplace_field(at), limits, sizeof limits);
    switch (r->rule) {
    case MR_RULE_TOO_SMALL:
        if (r->group == MR_GROUP_gate && r->field == MR_FIELD_gate_step_codes) {
            snprintf(out, size, "a step is at least %u codes, or 0: not fitted",
                     MR_CONFIG_STEP_CODES);
            break;
        }
        snprintf(out, size, "it is %s", limits);
        break;
    case MR_RULE_TOO_LARGE:
    case MR_RULE_NOT_A_NUMBER:
    case MR_RULE_NOT_TEXT: snprintf(out, size, "it is %s", limits); break;
    case MR_RULE_ALIKE:
        snprintf(out, size, "steps must be %u codes or more apart", MR_CONFIG_STEP_APART_CODES);
        break;
    case MR_RULE_PLACE: snprintf(out, size, "%s", right_kinds); break;
    case MR_RULE_SUM:
        snprintf(out, size, "zero_code of channel[23] and all steps together are at most 4095");
        break;
    case MR_RULE_NO_BAND:
        snprintf(out, size, "give that band a pretension_lb, or the gage another band or 0");
        break;
    case MR_RULE_UNSTABLE:
        snprintf(out, size,
                 "a shorter step_ms, or look at the units of predict.mat_weight_lb and "
                 "predict.joint_stiffness_lb_ft");
        break;
    case MR_RULE_COARSE:
    case MR_RULE_FINE:
    case MR_RULE_NARROW:
    case MR_RULE_UNREACHED:
        write_gain_advice(&config->channel[r->index], r->rule, out, size);
        break;
    case MR_RULE_REVISION:
        snprintf(out, size, "read the configuration again and change that one");
        break;
    default: snprintf(out, size, "mend it"); break;
    }
}

void configtext_reason(const struct mr_config *config, const struct mr_config_reason *r, char *out,
                       size_t size)
{
    struct configplace at = {r->group, r->index, r->field}, other;
    char name[CONFIGPLACE_NAME + 40], value[CONFIGPLACE_VALUE], advice[300];
    if (!is_known(r)) {
        snprintf(out, size, "group %u, index %u, field %u: %s; of another version", r->group,
                 r->index, r->field, rule_text(r->rule));
        return;
    }
    name_element(at, r->element, name);
    configplace_value(configplace_field(at), configplace_bytes(config, at), value);
    write_advice(config, r, advice, sizeof advice);
    if (find_other(r, &other)) {
        char other_name[CONFIGPLACE_NAME], other_value[CONFIGPLACE_VALUE];
        configplace_name(other, other_name);
        configplace_value(configplace_field(other), configplace_bytes(config, other), other_value);
        snprintf(out, size, "%s is %s, %s is %s: %s; %s", name, value, other_name, other_value,
                 r->rule == MR_RULE_TAKEN   ? "numbers of one kind must differ"
                 : r->rule == MR_RULE_ALIKE ? "they cannot be told apart"
                                            : "it must be more",
                 advice);
    } else {
        snprintf(out, size, "%s is %s: %s; %s", name, value, rule_text(r->rule), advice);
    }
}
