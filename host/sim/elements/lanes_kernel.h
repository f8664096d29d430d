/* Selections between vectors, and the law of the chain (common/chain_law.h) on vectors, for the
 * processor for which this file is included (lanes_each.h). */
/* The compiler does not generate these instructions from plain C. */
#if defined LANES_AVX512
LANES_INLINE masks LANES(is_greater)(lanes a, lanes b)
{
    return LANES_MM_COMPARE(a, b, _CMP_GT_OQ);
}
LANES_INLINE masks LANES(is_at_least)(lanes a, lanes b)
{
    return LANES_MM_COMPARE(a, b, _CMP_GE_OQ);
}
LANES_INLINE masks LANES(is_equal)(lanes a, lanes b)
{
    return LANES_MM_COMPARE(a, b, _CMP_EQ_OQ);
}
LANES_INLINE bool LANES(is_set)(masks mask, int lane)
{
    return (mask >> lane) % 2 != 0;
}
LANES_INLINE bool LANES(any)(masks mask)
{
    return mask != 0;
}
LANES_INLINE lanes LANES(choose)(masks mask, lanes yes, lanes no)
{
    return LANES_MM(mask_blend)(mask, no, yes);
}
LANES_INLINE lanes LANES(choose_or_zero)(masks mask, lanes yes)
{
    return LANES_MM(maskz_mov)(mask, yes);
}
LANES_INLINE lanes LANES(min)(lanes a, lanes b)
{
    return LANES_MM(min)(a, b);
}
LANES_INLINE lanes LANES(max)(lanes a, lanes b)
{
    return LANES_MM(max)(a, b);
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
LANES_INLINE lanes LANES(min)(lanes a, lanes b)
{
    return LANES_BUILTIN(min)(a, b);
}
LANES_INLINE lanes LANES(max)(lanes a, lanes b)
{
    return LANES_BUILTIN(max)(a, b);
}
#else
LANES_INLINE lanes LANES(choose)(masks mask, lanes yes, lanes no)
{
    return (lanes)((mask & (words)yes) | (~mask & (words)no));
}
LANES_INLINE bool LANES(any)(masks mask)
{
    uint64_t part[sizeof mask / 8], all = 0;
    memcpy(part, &mask, sizeof part);
    for (size_t i = 0; i < sizeof mask / 8; i++)
        all |= part[i];
    return all != 0;
}
/* If both are equal, returns b, as the processor instruction does, so that zeros keep their
 * sign. */
LANES_INLINE lanes LANES(min)(lanes a, lanes b)
{
    return LANES(choose)(a < b, a, b);
}
LANES_INLINE lanes LANES(max)(lanes a, lanes b)
{
    return LANES(choose)(a > b, a, b);
}
#endif
#if !defined LANES_AVX512
LANES_INLINE masks LANES(is_greater)(lanes a, lanes b)
{
    return a > b;
}
LANES_INLINE masks LANES(is_at_least)(lanes a, lanes b)
{
    return a >= b;
}
LANES_INLINE masks LANES(is_equal)(lanes a, lanes b)
{
    return a == b;
}
LANES_INLINE bool LANES(is_set)(masks mask, int lane)
{
    return mask[lane] != 0;
}
LANES_INLINE lanes LANES(choose_or_zero)(masks mask, lanes yes)
{
    return (lanes)(mask & (words)yes);
}
#endif
#include "common/chain_law.h"
