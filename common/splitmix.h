/* Pseudorandom numbers from a seed, identical on every machine: splitmix64 (Steele, Lea and Flood
 * 2014). */
#ifndef MATRIG_COMMON_SPLITMIX_H
#define MATRIG_COMMON_SPLITMIX_H

#include <stdint.h>

/* Returns the next number and advances the state. The initial state is the seed, any value. */
static inline uint64_t mr_splitmix64(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

/* Returns a number that is uniform in [0, 1). */
static inline double mr_splitmix64_uniform(uint64_t *state)
{
    return (double)(mr_splitmix64(state) >> 11) * 0x1p-53;
}

#endif
