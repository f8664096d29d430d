#include "host/calibrate/mistake.h"

#include <math.h>
#include <stdio.h>

#include "common/gain.h"
#include "host/base/quantity.h"
#include "host/base/units.h"

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
