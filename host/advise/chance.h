/* Random numbers of the advice: a seed and a stream make the same ones everywhere. */
#ifndef MATRIG_HOST_ADVISE_CHANCE_H
#define MATRIG_HOST_ADVISE_CHANCE_H

#include <math.h>
#include <stdint.h>

#include "common/splitmix.h"

struct chance {
    uint64_t state;
};

/* Streams of a seed have nothing in common. */
static inline struct chance chance_from(uint64_t seed, uint64_t stream)
{
    struct chance chance = {seed};
    chance.state = mr_splitmix64(&chance.state) ^ (stream + 1u) * 0xd1342543de82ef95u;
    (void)mr_splitmix64(&chance.state);
    return chance;
}

/* In [0, 1). */
static inline double chance_uniform(struct chance *chance)
{
    return mr_splitmix64_uniform(&chance->state);
}

/* Standard normal (Box and Muller). */
static inline double chance_normal(struct chance *chance)
{
    double u = 1.0 - chance_uniform(chance);
    return sqrt(-2.0 * log(u)) * cos(6.283185307179586 * chance_uniform(chance));
}

#endif
