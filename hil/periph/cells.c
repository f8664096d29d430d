#include "hil/periph/cells.h"

uint64_t hil_cell_time_ps(enum hil_cell_times times, uint32_t typical_us, uint32_t maximum_us,
                          uint64_t *random)
{
    /* drawn in any case: other draws stay the same */
    double u = (double)(hil_random(random) >> 11) * 0x1p-53;
    if (times != HIL_TIMES_SPREAD)
        return (times == HIL_TIMES_TYPICAL ? typical_us : maximum_us) * 1000000ull;
    u *= u;
    u *= u;
    u *= u;
    return (uint64_t)((typical_us + (maximum_us - typical_us) * u) * 1e6);
}

/* 64 independent bits, each 1 with probability permille / 1000: from the lowest of ten binary
 * digits of the probability upwards, a digit 1 is an OR with a random word, a digit 0 an AND. */
static uint64_t biased_bits(unsigned permille, uint64_t *random)
{
    unsigned p = permille * 1024u / 1000u;
    uint64_t bits = 0;
    for (unsigned digit = 0; digit < 10; digit++) {
        uint64_t word = hil_random(random);
        bits = (p >> digit & 1u) ? bits | word : bits & word;
    }
    return bits;
}

void hil_cells_tear(uint8_t *cells, const uint8_t *wanted, size_t n, unsigned permille,
                    uint64_t *random)
{
    uint64_t changes = 0;
    for (size_t i = 0; i < n; i++) {
        if (i % 8u == 0)
            changes = permille >= 1000 ? UINT64_MAX : biased_bits(permille, random);
        uint8_t mask = (uint8_t)(changes >> (8u * (i % 8u)));
        cells[i] = (uint8_t)((cells[i] & ~mask) | ((wanted ? wanted[i] : 0xffu) & mask));
    }
}
