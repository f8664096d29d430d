#include "hil/rig/codes.h"

#define CODE_MAX 4095u

struct range {
    uint16_t least, most;
};

static const struct range low_codes = {0, MR_CODE_LOW};
static const struct range middle_codes = {MR_CODE_LOW + 1u, MR_CODE_HIGH - 1u};
static const struct range high_codes = {MR_CODE_HIGH, CODE_MAX};

static struct range range_of(unsigned i, unsigned low, unsigned high)
{
    return i < low ? low_codes : i < low + high ? high_codes : middle_codes;
}

/* Can `count` codes, `low` and `high` of them saturated, add up to `sum`? */
static bool possible(unsigned sum, unsigned count, unsigned low, unsigned high)
{
    unsigned least = 0, most = 0;
    if (low + high > count)
        return false;
    for (unsigned i = 0; i < count; i++) {
        least += range_of(i, low, high).least;
        most += range_of(i, low, high).most;
    }
    return sum >= least && sum <= most;
}

/* Begins with the least of each and hands the rest out evenly; a code that is full leaves its share
 * to the next ones. */
static void spread(unsigned sum, unsigned count, unsigned low, unsigned high, uint16_t *codes)
{
    unsigned rest = sum;
    for (unsigned i = 0; i < count; i++) {
        codes[i] = range_of(i, low, high).least;
        rest -= codes[i];
    }
    while (rest) {
        for (unsigned i = 0; i < count && rest; i++) {
            unsigned share = (rest + (count - i) - 1u) / (count - i);
            unsigned room = (unsigned)(range_of(i, low, high).most - codes[i]);
            unsigned more = share < room ? share : room;
            codes[i] = (uint16_t)(codes[i] + more);
            rest -= more;
        }
    }
}

/* A transducer's counts are of both polarities together: any split will do. */
static bool spread_transducer(const struct mr_block *block, unsigned i, struct hil_codes *codes)
{
    const unsigned n = HIL_CODES_PER_POLARITY;
    for (unsigned low = 0; low <= block->low[i]; low++) {
        for (unsigned high = 0; high <= block->high[i]; high++) {
            if (!possible(block->plus[i], n, low, high) ||
                !possible(block->minus[i], n, block->low[i] - low, block->high[i] - high))
                continue;
            spread(block->plus[i], n, low, high, codes->transducer[0][i]);
            spread(block->minus[i], n, block->low[i] - low, block->high[i] - high,
                   codes->transducer[1][i]);
            return true;
        }
    }
    return false;
}

bool hil_codes_of(const struct mr_block *block, struct hil_codes *codes, unsigned *channel)
{
    *codes = (struct hil_codes){0};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        *channel = i;
        if (!(block->absent >> i & 1u) && !spread_transducer(block, i, codes))
            return false;
    }
    for (unsigned i = 0; i < MR_ADC1_CHANNELS; i++) {
        unsigned c = *channel = MR_TRANSDUCERS + i;
        if (block->absent >> c & 1u)
            continue;
        if (!possible(block->sum[i], MR_SCANS_PER_BLOCK, block->low[c], block->high[c]))
            return false;
        spread(block->sum[i], MR_SCANS_PER_BLOCK, block->low[c], block->high[c], codes->adc1[i]);
    }
    return true;
}
