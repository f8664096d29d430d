/* Lanes: the numbers of a vector, which are processed together. A vector of floats has 32 bytes. If
 * LANES_DOUBLE is defined, lanes are doubles, and a vector has 64 bytes with AVX-512, 32 with AVX2,
 * otherwise 16. Wider vectors would be slow, because the compiler splits vectors wider than the
 * processor's into single numbers. With AVX-512 a mask has one bit per lane. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_LANES_H
#define MATRIG_HOST_SIM_ELEMENTS_LANES_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#if defined LANES_DOUBLE
typedef double lane_real;
typedef int64_t lane_bits;
#define LANES_BUILTIN(name)                __builtin_ia32_##name##pd256
#define LANES_MM(name)                     _mm512_##name##_pd
#define LANES_MM_COMPARE                   _mm512_cmp_pd_mask
#define LAW_NEEDS_REMAINDER(stops, pushes) LANES(any)(stops)
#else
typedef float lane_real;
typedef int32_t lane_bits;
#define LANES_BUILTIN(name)                __builtin_ia32_##name##ps256
#define LANES_MM(name)                     _mm256_##name##_ps
#define LANES_MM_COMPARE                   _mm256_cmp_ps_mask
/* This form of the law does not need the value `left`. */
#define LAW_NEEDS_REMAINDER(stops, pushes) LANES(any)((stops) & (pushes))
#endif
#define LANES_COUNT (sizeof(lanes) / sizeof(lane_real))
typedef lane_real lanes __attribute__((vector_size(32)));
typedef lane_bits words __attribute__((vector_size(32)));
typedef words masks; /* result of a comparison: -1 or 0 in each lane */
typedef lane_real narrow_lanes __attribute__((vector_size(16)));
typedef lane_bits narrow_words __attribute__((vector_size(16)));
typedef narrow_words narrow_masks;
typedef lane_real wide_lanes __attribute__((vector_size(64)));
typedef lane_bits wide_words __attribute__((vector_size(64)));
typedef uint8_t bit_masks; /* with AVX-512, a comparison gives one bit per lane */
#define LANES_INLINE static inline __attribute__((always_inline))
#if defined __x86_64__ && !defined __clang__
#include <immintrin.h>
#define LANES_HAVE_AVX2 1
#define LANES_CPU_HAS_AVX512 \
    (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
#else
#define LANES_HAVE_AVX2 0
#endif

#define LAW_VECTOR
#define LAW_REAL                    lanes
#define LAW_MASK                    masks
#define LAW_VALUE(x)                ((lanes){0} + (lane_real)(x))
#define LAW_IS_GREATER(a, b)        LANES(is_greater)(a, b)
#define LAW_IS_AT_LEAST(a, b)       LANES(is_at_least)(a, b)
#define LAW_IS_EQUAL(a, b)          LANES(is_equal)(a, b)
#define LAW_IF(mask, yes, no)       LANES(choose)(mask, yes, no)
#define LAW_IF_ELSE_ZERO(mask, yes) LANES(choose_or_zero)(mask, yes)
#define LAW_SELECT(mask, yes, no)   LANES(pick)(mask, yes, no)
#define LAW_AND(a, b)               ((a) & (b))
#define LAW_OR(a, b)                ((a) | (b))
#define LAW_NOT(mask)               ((masks) ~(mask))
#define LAW_IS_SCALAR_TRUE(mask)    false
#define LAW_MIN(a, b)               LANES(min)(a, b)
#define LAW_MAX(a, b)               LANES(max)(a, b)
#define LAW_SIGN                    ((words)(-LAW_VALUE(0)))
#define LAW_ABS(x)                  ((lanes)(~LAW_SIGN & (words)(x)))
/* Returns `size` with the sign of `sign`; `size` must not be negative. */
#define LAW_COPYSIGN(size, sign)    ((lanes)((LAW_SIGN & (words)(sign)) | (words)(size)))
#define LAW(name)                   LANES(name)

#endif
