#include "host/calibrate/jump.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/block.h"
#include "common/channels.h"
#include "common/gain.h"
#include "host/base/quantity.h"
#include "host/base/units.h"

/* ---- jump ---- */

static bool is_different_sensor(const struct mr_channel_config *old,
                                const struct mr_channel_config *new)
{
    return old->serial[0] && new->serial[0] &&
           memcmp(old->serial, new->serial, sizeof old->serial) != 0;
}

bool jump_find(const struct mr_channel_config *old, const struct mr_channel_config *new,
               char text[JUMP_TEXT_SIZE])
{
    bool transducer = new->kind == MR_KIND_DISPLACEMENT;
    if (!mr_channel_is_sensor(new) || old->kind != new->kind || old->number != new->number ||
        old->unit_per_code == 0.0f || new->unit_per_code == 0.0f)
        return false;
    /* not for another sensor, and not for the first calibration of a sensor */
    bool same = !is_different_sensor(old, new) && (old->calibrated_day || !new->calibrated_day);
    double was = (double)mr_channel_gain(old), is = (double)mr_channel_gain(new),
           ratio = fabs(is / was),
           most = same       ? JUMP_RATIO_SAME_SENSOR
                : transducer ? JUMP_RATIO_TRANSDUCER
                             : JUMP_RATIO_GAGE;
    snprintf(text, JUMP_TEXT_SIZE, "gain %.4g -> %.4g %s per code, a factor of %.3g", was, is,
             transducer ? "in" : "lb", ratio);
    return (same && is * was < 0.0) || !(ratio <= most && ratio >= 1.0 / most);
}

void jump_channel_name(unsigned index, char out[8])
{
    snprintf(out, 8, index < MR_TRANSDUCERS ? "d%u" : "t%u",
             (index < MR_TRANSDUCERS ? index : index - MR_TRANSDUCERS) % 100u + 1u);
}

bool jump_channel_find(const char *name, size_t length, unsigned *index)
{
    char known[8];
    for (*index = 0; *index < MR_TRANSDUCERS + MR_GAGES; ++*index) {
        jump_channel_name(*index, known);
        if (strlen(known) == length && memcmp(known, name, length) == 0)
            return true;
    }
    return false;
}

/* ---- mistake ---- */

/* Returns the distance of a gain from the middle of the possible range, as the logarithm of the
 * ratio; infinite outside the range. */
static double compute_gain_distance(const struct mr_gain_limits *limits, double gain)
{
    double least = (double)limits->min_gain, most = (double)limits->max_gain;
    return gain >= least && gain <= most ? fabs(log(gain / sqrt(least * most))) : HUGE_VAL;
}

void jump_write_mistake_hint(const struct mr_channel_config *channel, char *out, size_t size)
{
    const struct mr_gain_limits limits = mr_gain_limits(channel);
    const enum unit_kind kind = channel->kind == MR_KIND_DISPLACEMENT ? UNIT_DISPLACEMENT
                                                                      : UNIT_TENSION;
    double gain = fabs((double)mr_channel_gain(channel)), nearest = HUGE_VAL;
    const char *own = unit_get(kind, false)->text;
    const struct unit_word *unit;
    out[0] = '\0';
    if (compute_gain_distance(&limits, gain) < HUGE_VAL)
        return;
    for (size_t i = 0; (unit = unit_word_get(i)); i++) {
        if (unit->kind != kind)
            continue;
        double other = compute_gain_distance(&limits, quantity_convert(gain, unit->word, own));
        if (!(other < nearest))
            continue;
        nearest = other;
        snprintf(out, size, "; the unit of the values may have been %s", unit->word);
    }
    if (compute_gain_distance(&limits, 1.0 / gain) < nearest)
        snprintf(out, size, "; the columns may be swapped");
}
