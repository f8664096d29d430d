/* Bits put one after the other into words of 32, from the lowest on; words in memory are
 * little-endian, so the bits fill bytes from the lowest on. Pure. */
#ifndef MATRIG_COMMON_BITS_H
#define MATRIG_COMMON_BITS_H

#include <stddef.h>
#include <stdint.h>

#include "common/wire.h"

struct mr_bits {
    uint8_t *next;      /* where the next whole word goes */
    uint32_t held;      /* bits that do not make a word yet */
    unsigned held_bits; /* below 32 */
};

/* `bits` at most 31; `value` has none beyond them. Writes at most one word. */
static inline void mr_bits_put(struct mr_bits *to, uint32_t value, unsigned bits)
{
    unsigned total = to->held_bits + bits;
    to->held |= value << to->held_bits;
    if (total >= 32) { /* so some were held */
        to->next = mr_put_u32(to->next, to->held);
        to->held = value >> (32 - to->held_bits);
        total -= 32;
    }
    to->held_bits = total;
}

static inline void mr_bits_put32(struct mr_bits *to, uint32_t value)
{
    mr_bits_put(to, value & 0xffffu, 16);
    mr_bits_put(to, value >> 16, 16);
}

/* Writes the word that is held, padded with zeroes, and returns the bits put since `start`. */
static inline size_t mr_bits_end(struct mr_bits *to, const uint8_t *start)
{
    if (to->held_bits)
        mr_put_u32(to->next, to->held);
    return (size_t)(to->next - start) * 8u + to->held_bits;
}

#endif
