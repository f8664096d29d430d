/* Compiles LANES_FILE, which begins with lanes_kernel.h, for each kind of processor; LANES_CALL
 * calls the one for this. A vector operation is lowered for the processor that its own function is
 * compiled for, and that of a function clone, or of an inline function which two share, for the
 * oldest of them: hence a file for each. */
#if LANES_HAVE_AVX2
#pragma GCC push_options
#pragma GCC target("avx2")
#define LANES(name) name##_avx2
#define LANES_AVX2
#include LANES_FILE
#undef LANES
#undef LANES_AVX2
#pragma GCC pop_options
#pragma GCC push_options
#pragma GCC target("avx2,avx512f,avx512dq,avx512vl")
#define LANES(name) name##_avx512
#define LANES_AVX512
#define masks bit_masks
#if defined LANES_DOUBLE
#define lanes wide_lanes
#define words wide_words
#endif
#include LANES_FILE
#undef LANES
#undef LANES_AVX512
#undef lanes
#undef words
#undef masks
#pragma GCC pop_options
#define LANES_CALL(name, ...)                                                 \
    (__builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl") \
         ? name##_avx512(__VA_ARGS__)                                         \
     : __builtin_cpu_supports("avx2") ? name##_avx2(__VA_ARGS__)              \
                                      : name##_plain(__VA_ARGS__))
#else
#define LANES_CALL(name, ...) name##_plain(__VA_ARGS__)
#endif
#define LANES(name) name##_plain
#if defined LANES_DOUBLE
#define lanes narrow_lanes
#define words narrow_words
#define masks narrow_masks
#include LANES_FILE
#undef lanes
#undef words
#undef masks
#else
#include LANES_FILE
#endif
