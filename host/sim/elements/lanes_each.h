/* Includes LANES_FILE once for each kind of processor; LANES_CALL calls the version for the
 * processor on which the program runs. LANES_FILE begins with lanes_kernel.h. Separate inclusions
 * are necessary because the compiler translates vector operations for the target of the enclosing
 * function; in a function clone, or an inline function shared by two targets, it would use the
 * oldest target. */
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
#define LANES_CALL(name, ...)                                      \
    (LANES_CPU_HAS_AVX512             ? name##_avx512(__VA_ARGS__) \
     : __builtin_cpu_supports("avx2") ? name##_avx2(__VA_ARGS__)   \
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
