/* The single-precision unit (ARM A2.5, A7.7): results and the exception flags of FPSCR, by IEEE 754
 * and ARM's choices. Flags: 1 invalid, 2 division by zero, 4 overflow, 8 underflow, 0x10 inexact,
 * 0x80 input denormal. */
#include "bench.h"

#define IOC        1u
#define DZC        2u
#define OFC        4u
#define UFC        8u
#define IXC        0x10u
#define IDC        0x80u
#define FZ         (1u << 24)
#define DN         (1u << 25)
#define AHP        (1u << 26)
#define TO_NEAREST (0u << 22)
#define UP         (1u << 22)
#define DOWN       (2u << 22)
#define TO_ZERO    (3u << 22)
#define FLAGS      0xf000009fu

#define INF    0x7f800000u
#define MINUS  0x80000000u
#define ONE    0x3f800000u
#define TWO    0x40000000u
#define MAX    0x7f7fffffu
#define TINY   0x00000001u /* least denormal */
#define NORMAL 0x00800000u /* least normal */
#define QUIET  0x7fc00000u /* ARM's default NaN */

static void both(const char *name, uint32_t result, uint32_t fpscr, uint32_t want,
                 uint32_t want_flags)
{
    put_text(name);
    expect("", result, want);
    put_text(name);
    expect(".flags", fpscr & FLAGS, want_flags);
}

#define OPERATE(instruction, a, b, c, mode, r, f)                                                  \
    __asm__ volatile("vmsr fpscr, %5\n\tvmov s0, %2\n\tvmov s1, %3\n\tvmov s2, %4\n\t" instruction \
                     "\n\tvmov %0, s2\n\tvmrs %1, fpscr"                                           \
                     : "=&r"(r), "=&r"(f)                                                          \
                     : "r"(a), "r"(b), "r"(c), "r"(mode)                                           \
                     : "s0", "s1", "s2")
#define FP3(name, instruction, a, b, c, mode, want, flags) \
    do {                                                   \
        uint32_t r_, f_;                                   \
        OPERATE(instruction, a, b, c, mode, r_, f_);       \
        both(name, r_, f_, want, flags);                   \
    } while (0)
#define FP2(name, instruction, a, b, mode, want, flags) \
    FP3(name, instruction " s2, s0, s1", a, b, 0, mode, want, flags)
#define FP1(name, instruction, a, mode, want, flags) \
    FP3(name, instruction, a, 0, 0, mode, want, flags)

static void addition(void)
{
    FP2("add_exact", "vadd.f32", ONE, ONE, 0, TWO, 0);
    FP2("add_overflow", "vadd.f32", MAX, MAX, 0, INF, OFC | IXC);
    FP2("add_overflow_to_zero", "vadd.f32", MAX, MAX, TO_ZERO, MAX, OFC | IXC);
    FP2("add_overflow_down", "vadd.f32", MAX, MAX, DOWN, MAX, OFC | IXC);
    FP2("add_overflow_up", "vadd.f32", MAX, MAX, UP, INF, OFC | IXC);
    /* 1 + 2^-24: a tie, to even */
    FP2("add_half_ulp_nearest", "vadd.f32", ONE, 0x33800000, 0, ONE, IXC);
    FP2("add_half_ulp_up", "vadd.f32", ONE, 0x33800000, UP, 0x3f800001, IXC);
    FP2("add_half_ulp_down", "vadd.f32", ONE, 0x33800000, DOWN, ONE, IXC);
    FP2("add_half_ulp_to_zero", "vadd.f32", ONE, 0x33800000, TO_ZERO, ONE, IXC);
    FP2("add_tie_to_even_above", "vadd.f32", 0x3f800001, 0x33800000, 0, 0x3f800002, IXC);
    FP2("add_negative_up", "vadd.f32", MINUS | ONE, 0xb3800000, UP, MINUS | ONE, IXC);
    FP2("add_negative_down", "vadd.f32", MINUS | ONE, 0xb3800000, DOWN, 0xbf800001, IXC);
    FP2("sub_to_plus_zero", "vsub.f32", ONE, ONE, 0, 0, 0);
    FP2("sub_to_minus_zero_down", "vsub.f32", ONE, ONE, DOWN, MINUS, 0);
    FP2("add_minus_zeros", "vadd.f32", MINUS, MINUS, 0, MINUS, 0);
    FP2("add_mixed_zeros", "vadd.f32", 0, MINUS, 0, 0, 0);
    FP2("sub_infinities", "vsub.f32", INF, INF, 0, QUIET, IOC);
    FP2("add_infinity", "vadd.f32", INF, ONE, 0, INF, 0);
    FP2("add_denormals", "vadd.f32", TINY, TINY, 0, 2, 0);
    FP2("add_denormals_flushed", "vadd.f32", TINY, TINY, FZ, 0, IDC);
}

static void nans(void)
{
    FP2("nan_quiet_payload", "vadd.f32", 0x7fc12345, ONE, 0, 0x7fc12345, 0);
    FP2("nan_quiet_second", "vadd.f32", ONE, 0xffc12345, 0, 0xffc12345, 0);
    FP2("nan_signalling", "vadd.f32", 0x7f812345, ONE, 0, 0x7fc12345, IOC);
    FP2("nan_first_of_two_quiet", "vmul.f32", 0x7fc00001, 0x7fc00002, 0, 0x7fc00001, 0);
    FP2("nan_signalling_goes_first", "vmul.f32", 0x7fc00001, 0x7f800002, 0, 0x7fc00002, IOC);
    FP2("nan_first_signalling", "vmul.f32", 0x7f800001, 0x7f800002, 0, 0x7fc00001, IOC);
    FP2("nan_default_mode", "vadd.f32", 0x7fc12345, ONE, DN, QUIET, 0);
    FP2("nan_default_mode_signalling", "vadd.f32", 0xff812345, ONE, DN, QUIET, IOC);
    FP1("neg_of_nan", "vneg.f32 s2, s0", 0x7f812345, 0, 0xff812345, 0);
    FP1("abs_of_nan", "vabs.f32 s2, s0", 0xff812345, 0, 0x7f812345, 0);
    FP1("mov_of_nan", "vmov.f32 s2, s0", 0x7f812345, 0, 0x7f812345, 0);
}

static void multiplication(void)
{
    FP2("mul_exact_denormal", "vmul.f32", NORMAL, 0x3f000000, 0, 0x00400000, 0);
    FP2("mul_exact_denormal_flushed", "vmul.f32", NORMAL, 0x3f000000, FZ, 0, UFC);
    FP2("mul_inexact_denormal", "vmul.f32", 0x00800001, 0x3f000000, 0, 0x00400000, UFC | IXC);
    FP2("mul_tiny_before_rounding", "vmul.f32", NORMAL, 0x3f7fffff, 0, NORMAL, UFC | IXC);
    FP2("mul_underflow_to_zero", "vmul.f32", TINY, 0x3e800000, 0, 0, UFC | IXC);
    FP2("mul_underflow_up", "vmul.f32", TINY, 0x3e800000, UP, TINY, UFC | IXC);
    FP2("mul_zero_infinity", "vmul.f32", 0, INF, 0, QUIET, IOC);
    FP2("mul_denormal_input_flushed", "vmul.f32", TINY, INF, FZ, QUIET, IOC | IDC);
    FP2("mul_signs", "vmul.f32", MINUS | ONE, 0, 0, MINUS, 0);
    FP2("nmul", "vnmul.f32", TWO, TWO, 0, 0xc0800000, 0);
    FP2("div_third", "vdiv.f32", ONE, 0x40400000, 0, 0x3eaaaaab, IXC);
    FP2("div_third_to_zero", "vdiv.f32", ONE, 0x40400000, TO_ZERO, 0x3eaaaaaa, IXC);
    FP2("div_by_zero", "vdiv.f32", ONE, 0, 0, INF, DZC);
    FP2("div_by_minus_zero", "vdiv.f32", ONE, MINUS, 0, MINUS | INF, DZC);
    FP2("div_zeros", "vdiv.f32", 0, 0, 0, QUIET, IOC);
    FP2("div_infinities", "vdiv.f32", INF, INF, 0, QUIET, IOC);
    FP2("div_infinity_by_zero", "vdiv.f32", INF, 0, 0, INF, 0);
    FP2("div_by_denormal_flushed", "vdiv.f32", ONE, TINY, FZ, INF, DZC | IDC);
    FP1("sqrt_2", "vsqrt.f32 s2, s0", TWO, 0, 0x3fb504f3, IXC);
    FP1("sqrt_4", "vsqrt.f32 s2, s0", 0x40800000, 0, TWO, 0);
    FP1("sqrt_minus_zero", "vsqrt.f32 s2, s0", MINUS, 0, MINUS, 0);
    FP1("sqrt_minus_one", "vsqrt.f32 s2, s0", MINUS | ONE, 0, QUIET, IOC);
    FP1("sqrt_infinity", "vsqrt.f32 s2, s0", INF, 0, INF, 0);
    FP1("sqrt_denormal", "vsqrt.f32 s2, s0", 2, 0, 0x1a800000, 0);           /* 2^-148: 2^-74 */
    FP1("sqrt_denormal_inexact", "vsqrt.f32 s2, s0", 4, 0, 0x1ab504f3, IXC); /* 2^-147: 2^-73.5 */
}

static void fused(void)
{
    /* (1 + 2^-23)^2 - (1 + 2^-22) is 2^-46: fused keeps it, rounding in between loses it. */
    FP3("fma_keeps", "vfma.f32 s2, s0, s1", 0x3f800001, 0x3f800001, 0xbf800002, 0, 0x28800000, 0);
    FP3("mla_rounds_between", "vmla.f32 s2, s0, s1", 0x3f800001, 0x3f800001, 0xbf800002, 0, 0, IXC);
    FP3("fms", "vfms.f32 s2, s0, s1", TWO, TWO, ONE, 0, 0xc0400000, 0);
    FP3("fnma", "vfnma.f32 s2, s0, s1", TWO, TWO, ONE, 0, 0xc0a00000, 0);
    FP3("fnms", "vfnms.f32 s2, s0, s1", TWO, TWO, ONE, 0, 0x40400000, 0);
    FP3("mls", "vmls.f32 s2, s0, s1", TWO, TWO, ONE, 0, 0xc0400000, 0);
    FP3("nmla", "vnmla.f32 s2, s0, s1", TWO, TWO, ONE, 0, 0xc0a00000, 0);
    FP3("nmls", "vnmls.f32 s2, s0, s1", TWO, TWO, ONE, 0, 0x40400000, 0);
    /* ARM A2.5.6: FPMulAdd */
    FP3("fma_infinity_zero_nan", "vfma.f32 s2, s0, s1", INF, 0, 0x7fc12345, 0, QUIET, IOC);
    FP3("fma_nan_addend", "vfma.f32 s2, s0, s1", ONE, ONE, 0x7fc12345, 0, 0x7fc12345, 0);
    FP3("fma_addend_goes_first", "vfma.f32 s2, s0, s1", 0x7fc00001, 0x7fc00002, 0x7fc00003, 0,
        0x7fc00003, 0);
    FP3("fma_opposite_infinities", "vfma.f32 s2, s0, s1", INF, ONE, MINUS | INF, 0, QUIET, IOC);
    FP3("fma_minus_zero", "vfma.f32 s2, s0, s1", MINUS, ONE, MINUS, 0, MINUS, 0);
    FP3("fma_tiny", "vfma.f32 s2, s0, s1", TINY, 0x3f000000, NORMAL, 0, NORMAL, IXC);
}

#define COMPARE(name, instruction, a, b, want)              \
    do {                                                    \
        uint32_t r_, f_;                                    \
        OPERATE(instruction " s0, s1", a, b, 0, 0, r_, f_); \
        (void)r_;                                           \
        expect(name, f_ &FLAGS, want);                      \
    } while (0)

static void comparison(void)
{
    uint32_t apsr;
    COMPARE("compare_less", "vcmp.f32", ONE, TWO, 0x80000000);
    COMPARE("compare_equal", "vcmp.f32", ONE, ONE, 0x60000000);
    COMPARE("compare_greater", "vcmp.f32", TWO, ONE, 0x20000000);
    COMPARE("compare_zeros", "vcmp.f32", 0, MINUS, 0x60000000);
    COMPARE("compare_quiet", "vcmp.f32", QUIET, ONE, 0x30000000);
    COMPARE("compare_signalling", "vcmp.f32", 0x7f800001, ONE, 0x30000000 | IOC);
    COMPARE("compare_e_quiet", "vcmpe.f32", QUIET, ONE, 0x30000000 | IOC);
    __asm__ volatile("vmov s0, %1\n\tvcmp.f32 s0, #0.0\n\tvmrs apsr_nzcv, fpscr\n\tmrs %0, apsr"
                     : "=r"(apsr)
                     : "r"(MINUS | ONE)
                     : "s0", "cc");
    expect("compare_with_zero", apsr & 0xf0000000u, 0x80000000u);
}

static void conversion(void)
{
    FP1("to_s32_truncates", "vcvt.s32.f32 s2, s0", 0x3ff33333, 0, 1, IXC);
    FP1("to_s32_truncates_negative", "vcvt.s32.f32 s2, s0", 0xbff33333, 0, 0xffffffff, IXC);
    FP1("to_s32_saturates", "vcvt.s32.f32 s2, s0", 0x4f32d05e, 0, 0x7fffffff, IOC);
    FP1("to_s32_saturates_low", "vcvt.s32.f32 s2, s0", MINUS | INF, 0, 0x80000000, IOC);
    FP1("to_s32_nan", "vcvt.s32.f32 s2, s0", QUIET, 0, 0, IOC);
    FP1("to_u32_negative", "vcvt.u32.f32 s2, s0", MINUS | ONE, 0, 0, IOC);
    FP1("to_u32_minus_half", "vcvt.u32.f32 s2, s0", 0xbf000000, 0, 0, IXC);
    FP1("to_s32_rounded_even", "vcvtr.s32.f32 s2, s0", 0x40200000, 0, 2, IXC);
    FP1("to_s32_rounded_odd", "vcvtr.s32.f32 s2, s0", 0x3fc00000, 0, 2, IXC);
    FP1("to_s32_rounded_up", "vcvtr.s32.f32 s2, s0", 0x3f800001, UP, 2, IXC);
    FP1("from_u32", "vcvt.f32.u32 s2, s0", 0xffffffff, 0, 0x4f800000, IXC);
    FP1("from_u32_to_zero", "vcvt.f32.u32 s2, s0", 0xffffffff, TO_ZERO, 0x4f7fffff, IXC);
    FP1("from_s32_least", "vcvt.f32.s32 s2, s0", 0x80000000, 0, 0xcf000000, 0);
    FP3("to_fixed_16", "vmov.f32 s2, s0\n\tvcvt.s32.f32 s2, s2, #16", 0x3fc00000, 0, 0, 0,
        0x00018000, 0);
    FP3("from_fixed_16", "vmov.f32 s2, s0\n\tvcvt.f32.s32 s2, s2, #16", 0x00018000, 0, 0, 0,
        0x3fc00000, 0);
    FP3("to_fixed_saturates", "vmov.f32 s2, s0\n\tvcvt.u16.f32 s2, s2, #8", 0x43800000, 0, 0, 0,
        0x0000ffff, IOC);
    FP3("to_half", "vcvtb.f16.f32 s2, s0", ONE, 0, 0xffffffff, 0, 0xffff3c00, 0);
    FP3("to_half_top", "vcvtt.f16.f32 s2, s0", ONE, 0, 0xffffffff, 0, 0x3c00ffff, 0);
    FP3("to_half_overflow", "vcvtb.f16.f32 s2, s0", 0x47800000, 0, 0, 0, 0x7c00, OFC | IXC);
    FP3("to_half_alternative", "vcvtb.f16.f32 s2, s0", 0x47800000, 0, 0, AHP, 0x7c00, 0);
    FP3("to_half_alternative_infinity", "vcvtb.f16.f32 s2, s0", INF, 0, 0, AHP, 0x7fff, IOC);
    FP3("to_half_denormal", "vcvtb.f16.f32 s2, s0", 0x33800000, 0, 0, 0, 0x0001, 0);
    FP1("from_half_denormal", "vcvtb.f32.f16 s2, s0", 0x0001, 0, 0x33800000, 0);
    FP1("from_half_top", "vcvtt.f32.f16 s2, s0", 0xc0000000, 0, 0xc0000000, 0);
    FP1("from_half_signalling", "vcvtb.f32.f16 s2, s0", 0x7d00, 0, 0x7fe00000, IOC);
}

/* ---- everything against everything ---- */

static const uint32_t values[] = {
    0,          MINUS,       TINY,       MINUS | TINY, 0x007fffff, NORMAL,      MINUS | NORMAL,
    0x00800001, 0x33800000,  0x3effffff, 0x3f7fffff,   ONE,        MINUS | ONE, 0x3f800001,
    0x3fc00000, 0x40490fdb,  0x4b000001, 0x5f000000,   0x7e800000, MAX,         MINUS | MAX,
    INF,        MINUS | INF, QUIET,      0xffc54321,   0x7f812345,
};
#define OPTION_VALUES (sizeof values / sizeof values[0])

/* Fowler, Noll and Vo's hash (FNV-1a), by words. */
static uint32_t mixed(uint32_t hash, uint32_t word)
{
    return (hash ^ word) * 16777619u;
}

#define SWEEP(name, instruction)                                                            \
    for (uint32_t mode = 0; mode < 16; mode++) {                                            \
        uint32_t hash = 2166136261u;                                                        \
        for (unsigned i = 0; i < OPTION_VALUES; i++) {                                      \
            for (unsigned k = 0; k < OPTION_VALUES; k++) {                                  \
                uint32_t r, f;                                                              \
                OPERATE(instruction, values[i], values[k], values[(i + k) % OPTION_VALUES], \
                        mode << 22, r, f);                                                  \
                hash = mixed(mixed(hash, r), f);                                            \
            }                                                                               \
        }                                                                                   \
        put_text("sweep_" name "_mode");                                                    \
        put_char((char)(mode < 10 ? '0' + mode : 'a' + mode - 10));                         \
        tell("", hash);                                                                     \
    }

static void sweeps(void)
{
    SWEEP("add", "vadd.f32 s2, s0, s1")
    SWEEP("sub", "vsub.f32 s2, s0, s1")
    SWEEP("mul", "vmul.f32 s2, s0, s1")
    SWEEP("div", "vdiv.f32 s2, s0, s1")
    SWEEP("sqrt", "vsqrt.f32 s2, s0")
    SWEEP("mla", "vmla.f32 s2, s0, s1")
    SWEEP("fma", "vfma.f32 s2, s0, s1")
    SWEEP("fnms", "vfnms.f32 s2, s0, s1")
    SWEEP("compare", "vcmp.f32 s0, s1")
    SWEEP("compare_e", "vcmpe.f32 s0, s1")
    SWEEP("to_s32", "vcvt.s32.f32 s2, s0")
    SWEEP("to_u32_rounded", "vcvtr.u32.f32 s2, s0")
    SWEEP("from_s32", "vcvt.f32.s32 s2, s0")
    SWEEP("to_half", "vcvtb.f16.f32 s2, s0")
    SWEEP("from_half", "vcvtt.f32.f16 s2, s0")
}

int main(void)
{
    uint32_t r;
    CPACR = 0xfu << 20;
    __asm__ volatile("dsb\n\tisb");
    __asm__ volatile("vmsr fpscr, %1\n\tvmrs %0, fpscr" : "=r"(r) : "r"(0xffffffffu));
    expect("fpscr_writable_bits", r, 0xf7c0009fu); /* ARM B1.4.7 */
    __asm__ volatile("vmsr fpscr, %1\n\tvmrs %0, fpscr" : "=r"(r) : "r"(0));
    expect("fpscr_cleared", r, 0);
    /* PM0214: single precision, with divide and square root */
    expect("mvfr0", WORD(0xe000ef40u), 0x10110021u);
    expect("mvfr1", WORD(0xe000ef44u), 0x11000011u);
    addition();
    nans();
    multiplication();
    fused();
    comparison();
    conversion();
    sweeps();
    return 0;
}
