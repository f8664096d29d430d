#include "host/replay/diff_field.h"

#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "common/fault.h"
#include "host/base/units.h"

struct rule {
    uint16_t id; /* 0: of every message */
    const char *field;
    enum field_rule rule;
};

/* The rows of the catalogue; what is not there is compared by the name that times have everywhere,
 * or as it stands. */
static const struct rule rules[] = {
#define REPLAY(name, NAME, field, rule) {MR_ID_##NAME, #field, FIELD_##rule},
#include "common/catalogue.def"
    {0, "block16", FIELD_BLOCK16},
    {0, "at_block16", FIELD_BLOCK16},
    {0, "block", FIELD_BLOCK},
    {0, "tick", FIELD_TICK},
};

/* A row of a field that is not there would say nothing. */
#define REPLAY(name, NAME, field, rule) \
    _Static_assert(offsetof(struct mr_##name, field) < sizeof(struct mr_##name), #field);
#include "common/catalogue.def"

/* An image that computes a little otherwise: ten times the resolution of the message, or what the
 * estimate's own error allows. Counts, states, names of switches and ticks must be equal whatever
 * the image. */
static const struct {
    const char *unit;
    double tolerance;
} tolerances[] = {
    {"in", 0.002}, {"lb", 0.2},    {"ft", 0.05}, {"ft/s", 0.02}, {"ft/s2", 0.1},
    {"s", 0.05},   {"codes", 1.0}, {"ms", 5.0},  {"%", 5.0},
};

bool field_circumstance(const struct mr_message_info *info)
{
    switch (info->id) {
/* clang-format off */
#define CIRCUMSTANCE(name, NAME) case MR_ID_##NAME: return true;
/* clang-format on */
#include "common/catalogue.def"
    default: return false;
    }
}

bool field_in_turn(const struct mr_message_info *info)
{
    switch (info->id) {
/* clang-format off */
#define IN_TURN(name, NAME) case MR_ID_##NAME: return true;
/* clang-format on */
#include "common/catalogue.def"
    default: return false;
    }
}

enum field_rule field_rule(const struct mr_message_info *info, const struct mr_field_info *field)
{
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++) {
        if ((rules[i].id == 0 || rules[i].id == info->id) &&
            strcmp(rules[i].field, field->name) == 0)
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

void field_tolerances_text(bool si, char out[FIELD_TOLERANCES_TEXT])
{
    size_t used = 0;
    for (size_t i = 0; i < sizeof tolerances / sizeof tolerances[0]; i++) {
        double value = tolerances[i].tolerance;
        const char *unit = tolerances[i].unit;
        for (int kind = 0; si && kind < UNIT_KINDS; kind++) {
            const struct unit *shown = unit_of((enum unit_kind)kind, true);
            if (strcmp(unit_given((enum unit_kind)kind)->text, tolerances[i].unit) != 0)
                continue;
            value *= shown->factor;
            unit = shown->text;
        }
        used += (size_t)snprintf(out + used, FIELD_TOLERANCES_TEXT - used, "%.2g %s, ", value,
                                 unit);
    }
    snprintf(out + used - 2, FIELD_TOLERANCES_TEXT + 2 - used,
             "; counts, states, switches and ticks equal");
}
