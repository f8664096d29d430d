/* Random numbers of the advice: a seed and a stream make the same ones everywhere. splitmix64
 * (Steele, Lea and Flood 2014). */
#ifndef MATRIG_HOST_ADVISE_CHANCE_H
#define MATRIG_HOST_ADVISE_CHANCE_H

#include <math.h>
#include <stdint.h>

struct chance {
    uint64_t state;
};

static inline uint64_t chance_next(struct chance *chance)
{
    uint64_t z = chance->state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

/* Streams of a seed have nothing in common. */
static inline struct chance chance_from(uint64_t seed, uint64_t stream)
{
    struct chance chance = {seed};
    chance.state = chance_next(&chance) ^ (stream + 1u) * 0xd1342543de82ef95u;
    (void)chance_next(&chance);
    return chance;
}

/* In [0, 1). */
static inline double chance_uniform(struct chance *chance)
{
    return (double)(chance_next(chance) >> 11) * 0x1p-53;
}

/* Standard normal (Box and Muller). */
static inline double chance_normal(struct chance *chance)
{
    double u = 1.0 - chance_uniform(chance);
    return sqrt(-2.0 * log(u)) * cos(6.283185307179586 * chance_uniform(chance));
}

#endif
