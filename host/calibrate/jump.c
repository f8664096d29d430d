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

static bool is_another(const struct mr_channel_config *old, const struct mr_channel_config *new)
{
    return old->serial[0] && new->serial[0] &&
           memcmp(old->serial, new->serial, sizeof old->serial) != 0;
}

bool jump_find(const struct mr_channel_config *old, const struct mr_channel_config *new,
               struct jump *jump)
{
    bool transducer = new->kind == MR_KIND_DISPLACEMENT;
    *jump = (struct jump){.shift = (double)NAN};
    if (!mr_channel_measures(new) || old->kind != new->kind || old->number != new->number ||
        old->unit_per_code == 0.0f || new->unit_per_code == 0.0f)
        return false;
    jump->another = is_another(old, new);
    /* else it is its first calibration */
    bool same = !jump->another && (old->calibrated_day || !new->calibrated_day);
    jump->old_gain = (double)mr_channel_gain(old);
    jump->gain_now = (double)mr_channel_gain(new);
    jump->ratio = fabs(jump->gain_now / jump->old_gain);
    jump->turned = jump->gain_now * jump->old_gain < 0.0;
    jump->most = same ? JUMP_GAIN_SAME : transducer ? JUMP_GAIN_TRANSDUCER : JUMP_GAIN_GAGE;
    jump->gain = (same && jump->turned) ||
                 !(jump->ratio <= jump->most && jump->ratio >= 1.0 / jump->most);
    jump->shift_most = transducer ? JUMP_ZERO_IN : JUMP_ZERO_LB;
    /* by the gain that was: what a reading of today was then, less what it is */
    if (same && !isnan(old->zero_code))
        jump->shift = ((double)new->zero_code - (double)old->zero_code) * jump->old_gain;
    jump->zero = fabs(jump->shift) > jump->shift_most;
    return jump->gain || jump->zero;
}

void jump_text(const struct jump *jump, const struct mr_channel_config *channel, char *out,
               size_t size)
{
    const char *unit = channel->kind == MR_KIND_DISPLACEMENT ? "in" : "lb";
    int used = 0;
    out[0] = '\0';
    if (jump->gain)
        used = snprintf(out, size, "gain %.4g -> %.4g %s per code, %.3g times", jump->old_gain,
                        jump->gain_now, unit, jump->ratio);
    if (jump->zero && used >= 0 && (size_t)used < size)
        snprintf(out + used, size - (size_t)used, "%szero moved by %+.3g %s", used ? ", " : "",
                 jump->shift, unit);
}

void jump_channel(unsigned index, char out[8])
{
    snprintf(out, 8, index < MR_TRANSDUCERS ? "d%u" : "t%u",
             (index < MR_TRANSDUCERS ? index : index - MR_TRANSDUCERS) % 100u + 1u);
}

bool jump_channel_read(const char *name, size_t length, unsigned *index)
{
    char known[8];
    for (*index = 0; *index < MR_TRANSDUCERS + MR_GAGES; ++*index) {
        jump_channel(*index, known);
        if (strlen(known) == length && memcmp(known, name, length) == 0)
            return true;
    }
    return false;
}

/* ---- mistake ---- */

/* How far a gain is from the middle of what is possible, as a ratio's logarithm; infinite when it
 * is not possible. */
static double distance(const struct mr_gain_limits *limits, double gain)
{
    double least = (double)limits->least, most = (double)limits->most;
    return gain >= least && gain <= most ? fabs(log(gain / sqrt(least * most))) : HUGE_VAL;
}

void mistake_text(const struct mr_channel_config *channel, char *out, size_t size)
{
    const struct mr_gain_limits limits = mr_gain_limits(channel);
    const enum unit_kind kind = channel->kind == MR_KIND_DISPLACEMENT ? UNIT_DISPLACEMENT
                                                                      : UNIT_TENSION;
    double gain = fabs((double)mr_channel_gain(channel)), nearest = HUGE_VAL;
    const char *own = unit_of(kind, false)->text;
    const struct unit_word *unit;
    out[0] = '\0';
    if (distance(&limits, gain) < HUGE_VAL)
        return;
    for (size_t i = 0; (unit = unit_words(i)); i++) {
        if (unit->kind != kind)
            continue;
        double other = distance(&limits, quantity_convert(gain, unit->word, own));
        if (!(other < nearest))
            continue;
        nearest = other;
        snprintf(out, size, "; were the values %s?", unit->word);
    }
    if (distance(&limits, 1.0 / gain) < nearest)
        snprintf(out, size, "; are the columns swapped?");
}
