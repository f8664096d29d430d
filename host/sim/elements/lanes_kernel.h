/* Choices between vectors, and the law of the chain (common/chain_law.h) in them, for the processor
 * that this is included for (lanes_each.h). */
/* One instruction each, which the compiler does not find in the plain form. */
#if defined LANES_AVX512
LANES_INLINE lanes LANES(choose)(masks mask, lanes yes, lanes no)
{
    return (lanes)((mask & (masks)yes) | (~mask & (masks)no));
}
LANES_INLINE bool LANES(any)(masks mask)
{
    return __builtin_ia32_cvtq2mask512((long long __attribute__((vector_size(64))))mask) != 0;
}
LANES_INLINE lanes LANES(lesser)(lanes a, lanes b)
{
    return __builtin_ia32_minpd512_mask(a, b, a, (unsigned char)-1, 4);
}
LANES_INLINE lanes LANES(greater)(lanes a, lanes b)
{
    return __builtin_ia32_maxpd512_mask(a, b, a, (unsigned char)-1, 4);
}
#elif defined LANES_AVX2
LANES_INLINE lanes LANES(choose)(masks mask, lanes yes, lanes no)
{
    return LANES_BUILTIN(blendv)(no, yes, (lanes)mask);
}
LANES_INLINE bool LANES(any)(masks mask)
{
    return LANES_BUILTIN(movmsk)((lanes)mask) != 0;
}
LANES_INLINE lanes LANES(lesser)(lanes a, lanes b)
{
    return LANES_BUILTIN(min)(a, b);
}
LANES_INLINE lanes LANES(greater)(lanes a, lanes b)
{
    return LANES_BUILTIN(max)(a, b);
}
#else
LANES_INLINE lanes LANES(choose)(masks mask, lanes yes, lanes no)
{
    return (lanes)((mask & (masks)yes) | (~mask & (masks)no));
}
LANES_INLINE bool LANES(any)(masks mask)
{
    uint64_t part[4];
    memcpy(part, &mask, sizeof part);
    return (part[0] | part[1] | part[2] | part[3]) != 0;
}
/* Of equal ones the second: so the instructions have it, and zeros keep their sign. */
LANES_INLINE lanes LANES(lesser)(lanes a, lanes b)
{
    return LANES(choose)(a < b, a, b);
}
LANES_INLINE lanes LANES(greater)(lanes a, lanes b)
{
    return LANES(choose)(a > b, a, b);
}
#endif
#include "common/chain_law.h"
