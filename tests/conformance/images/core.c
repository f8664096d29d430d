/* Instructions of the ARMv7E-M core: results and flags (ARM A7.7). Flags are bits 31 to 27 of APSR:
 * N Z C V Q; 19 to 16: GE. */
#include "bench.h"

#define N 0x80000000u
#define Z 0x40000000u
#define C 0x20000000u
#define V 0x10000000u
#define Q 0x08000000u

static void both(const char *name, uint32_t result, uint32_t flags, uint32_t want_result,
                 uint32_t want_flags)
{
    put_text(name);
    expect("", result, want_result);
    put_text(name);
    expect(".flags", flags, want_flags);
}

/* `instruction rd, a, b` with the flags set before it. */
#define T2(name, instruction, a, b, before, want, want_flags)                                \
    do {                                                                                     \
        uint32_t r_, f_;                                                                     \
        __asm__ volatile("msr apsr_nzcvqg, %4\n\t" instruction " %0, %2, %3\n\tmrs %1, apsr" \
                         : "=&l"(r_), "=&r"(f_)                                              \
                         : "l"(a), "l"(b), "r"(before)                                       \
                         : "cc");                                                            \
        both(name, r_, f_, want, want_flags);                                                \
    } while (0)
/* `instruction rd, a` and what follows the operands */
#define T1(name, instruction, tail, a, before, want, want_flags)                                 \
    do {                                                                                         \
        uint32_t r_, f_;                                                                         \
        __asm__ volatile("msr apsr_nzcvqg, %3\n\t" instruction " %0, %2" tail "\n\tmrs %1, apsr" \
                         : "=&r"(r_), "=&r"(f_)                                                  \
                         : "r"(a), "r"(before)                                                   \
                         : "cc");                                                                \
        both(name, r_, f_, want, want_flags);                                                    \
    } while (0)
/* `instruction rd, a, b, c` */
#define T3(name, instruction, a, b, c, want, want_flags)                                         \
    do {                                                                                         \
        uint32_t r_, f_;                                                                         \
        __asm__ volatile("msr apsr_nzcvqg, %5\n\t" instruction " %0, %2, %3, %4\n\tmrs %1, apsr" \
                         : "=&r"(r_), "=&r"(f_)                                                  \
                         : "r"(a), "r"(b), "r"(c), "r"(0)                                        \
                         : "cc");                                                                \
        both(name, r_, f_, want, want_flags);                                                    \
    } while (0)
/* `instruction lo, hi, a, b` */
#define TL(name, instruction, a, b, low, high, want_low, want_high)                              \
    do {                                                                                         \
        uint32_t l_ = low, h_ = high;                                                            \
        __asm__ volatile(instruction " %0, %1, %2, %3" : "+&r"(l_), "+&r"(h_) : "r"(a), "r"(b)); \
        expect(name ".low", l_, want_low);                                                       \
        expect(name ".high", h_, want_high);                                                     \
    } while (0)

static void arithmetic(void)
{
    T2("adds_overflow", "adds", 0x7fffffff, 1, 0, 0x80000000, N | V);
    T2("adds_carry", "adds", 0xffffffff, 1, 0, 0, Z | C);
    T2("adds_both", "adds", 0x80000000, 0x80000000, 0, 0, Z | C | V);
    T2("subs_borrow", "subs", 0, 1, 0, 0xffffffff, N);
    T2("subs_equal", "subs", 5, 5, 0, 0, Z | C);
    T2("subs_overflow", "subs", 0x80000000, 1, 0, 0x7fffffff, C | V);
    T2("adcs_with", "adcs.w", 1, 1, C, 3, 0);
    T2("adcs_wraps", "adcs.w", 0xffffffff, 0, C, 0, Z | C);
    T2("adcs_overflow", "adcs.w", 0x7fffffff, 0, C, 0x80000000, N | V);
    T2("sbcs_without", "sbcs.w", 5, 3, 0, 1, C);
    T2("sbcs_zero", "sbcs.w", 0, 0, 0, 0xffffffff, N);
    T2("sbcs_with", "sbcs.w", 0, 0, C, 0, Z | C);
    T1("rsbs_one", "rsbs", ", #0", 1, 0, 0xffffffff, N);
    T1("rsbs_zero", "rsbs", ", #0", 0, 0, 0, Z | C);
    T1("rsbs_least", "rsbs", ", #0", 0x80000000, 0, 0x80000000, N | V);
    T2("ands_keeps", "ands.w", 0xf0, 0x0f, C | V, 0, Z | C | V);
    T2("bics", "bics.w", 0xff, 0x0f, 0, 0xf0, 0);
    T2("orns", "orns", 0, 0x7fffffff, V, 0x80000000, N | V);
    T2("eors", "eors.w", 0xffffffff, 0xffffffff, 0, 0, Z);
    T1("mvns", "mvns.w", "", 0, 0, 0xffffffff, N);
    T1("movs_rotated_immediate", "movs.w", "\n\tmovs.w %0, #0x80000000", 1, 0, 0x80000000, N | C);
    T1("movs_plain_immediate", "movs.w", "\n\tmovs.w %0, #0xff", 1, C, 0xff, C);
    T2("sdiv_toward_zero", "sdiv", -7, 2, 0, -3, 0);
    T2("sdiv_negative_divisor", "sdiv", 7, -2, 0, -3, 0);
    T2("sdiv_overflow", "sdiv", 0x80000000, -1, 0, 0x80000000, 0);
    T2("sdiv_by_zero", "sdiv", 5, 0, 0, 0, 0);
    T2("udiv", "udiv", 0xffffffff, 2, 0, 0x7fffffff, 0);
    T2("udiv_small", "udiv", 1, 0xffffffff, 0, 0, 0);
    T2("udiv_by_zero", "udiv", 5, 0, 0, 0, 0);
}

static void shifts(void)
{
    T2("lsls_1", "lsls.w", 0x80000001, 1, 0, 2, C);
    T2("lsls_32", "lsls.w", 1, 32, 0, 0, Z | C);
    T2("lsls_33", "lsls.w", 1, 33, C, 0, Z);
    T2("lsls_0_keeps_carry", "lsls.w", 1, 0, C, 1, C);
    T2("lsls_low_byte_counts", "lsls.w", 1, 0x101, 0, 2, 0);
    T2("lsrs_32", "lsrs.w", 0x80000000, 32, 0, 0, Z | C);
    T2("lsrs_33", "lsrs.w", 0x80000000, 33, C, 0, Z);
    T2("asrs_40", "asrs.w", 0x80000000, 40, 0, 0xffffffff, N | C);
    T2("rors_4", "rors.w", 0x0000000f, 4, 0, 0xf0000000, N | C);
    T2("rors_32", "rors.w", 0x80000001, 32, 0, 0x80000001, N | C);
    T2("rors_0_keeps_carry", "rors.w", 7, 0, C, 7, C);
    T1("rrxs", "rrxs", "", 3, C, 0x80000001, N | C);
    T1("rrxs_clear", "rrxs", "", 2, 0, 1, 0);
    T1("asrs_immediate_32", "asrs.w", ", #32", 0x7fffffff, C, 0, Z);
    T1("lsrs_immediate_32", "lsrs.w", ", #32", 0x80000000, 0, 0, Z | C);
    T2("add_shifted_operand", "add.w %0, %2, %3, lsl #4 @", 1, 2, 0, 33, 0);
    T2("ands_shifter_carry", "ands.w %0, %2, %3, lsr #1 @", 0xff, 3, 0, 1, C);
}

static void fields(void)
{
    T1("clz_0", "clz", "", 0, 0, 32, 0);
    T1("clz_1", "clz", "", 1, 0, 31, 0);
    T1("clz_top", "clz", "", 0x80000000, 0, 0, 0);
    T1("rbit", "rbit", "", 0x12345678, 0, 0x1e6a2c48, 0);
    T1("rev", "rev.w", "", 0x12345678, 0, 0x78563412, 0);
    T1("rev16", "rev16.w", "", 0x12345678, 0, 0x34127856, 0);
    T1("revsh", "revsh.w", "", 0x00000080, 0, 0xffff8000, 0);
    T1("ubfx", "ubfx", ", #8, #8", 0x12345678, 0, 0x56, 0);
    T1("sbfx", "sbfx", ", #8, #8", 0x00008000, 0, 0xffffff80, 0);
    T1("sbfx_whole", "sbfx", ", #0, #32", 0x87654321, 0, 0x87654321, 0);
    T1("bfc", "mov", "\n\tbfc %0, #4, #8", 0xffffffff, 0, 0xfffff00f, 0);
    T1("bfi", "mov.w %0, #-1\n\tbfi", ", #8, #4", 0x5, 0, 0xfffff5ff, 0);
    T1("sxtb_rotated", "sxtb.w", ", ror #8", 0x0000ff00, 0, 0xffffffff, 0);
    T1("uxth_rotated", "uxth.w", ", ror #16", 0x12345678, 0, 0x1234, 0);
    T1("uxtb16", "uxtb16", "", 0x11223344, 0, 0x00220044, 0);
    T1("sxtb16", "sxtb16", "", 0x00ff0080, 0, 0xffffff80, 0);
    T2("sxtab16", "sxtab16", 0x00010001, 0x00ff0080, 0, 0x0000ff81, 0);
    T2("uxtah", "uxtah", 0x10, 0x1234ffff, 0, 0x1000f, 0);
    T2("pkhbt", "pkhbt", 0x11112222, 0x33334444, 0, 0x33332222, 0);
    T2("pkhtb", "pkhtb %0, %2, %3, asr #16 @", 0x11112222, 0x33334444, 0, 0x11113333, 0);
}

static void saturation(void)
{
    T1("ssat_above", "ssat %0, #8, %2 @", "", 200, 0, 127, Q);
    T1("ssat_below", "ssat %0, #8, %2 @", "", -200, 0, 0xffffff80, Q);
    T1("ssat_within", "ssat %0, #8, %2 @", "", 100, 0, 100, 0);
    T1("ssat_shifted", "ssat %0, #8, %2, lsl #4 @", "", 0x10, 0, 127, Q);
    T1("q_sticks", "ssat %0, #8, %2 @", "", 1, Q, 1, Q);
    T1("usat_below", "usat %0, #8, %2 @", "", -1, 0, 0, Q);
    T1("usat_above", "usat %0, #8, %2 @", "", 300, 0, 255, Q);
    T1("ssat16", "ssat16 %0, #4, %2 @", "", 0x0020fff0, 0, 0x0007fff8, Q);
    T1("usat16", "usat16 %0, #4, %2 @", "", 0x0020fff0, 0, 0x000f0000, Q);
    T2("qadd", "qadd", 0x7fffffff, 1, 0, 0x7fffffff, Q);
    T2("qsub", "qsub", 0x80000000, 1, 0, 0x80000000, Q);
    T2("qdadd", "qdadd", 1, 0x40000000, 0, 0x7fffffff, Q);
    T2("qdsub", "qdsub", 0, 0x40000000, 0, 0x80000001, Q);
    T2("qadd16_no_q", "qadd16", 0x7fff8000, 0x0001ffff, 0, 0x7fff8000, 0);
    T2("qadd8", "qadd8", 0x7f80017f, 0x01ff0101, 0, 0x7f80027f, 0);
    T2("uqsub8", "uqsub8", 0x10203040, 0x20102010, 0, 0x00101030, 0);
    T2("uqadd16", "uqadd16", 0xfff00010, 0x00200020, 0, 0xffff0030, 0);
}

static void simd(void)
{
    T2("sadd16_ge", "sadd16", 0x7fff8000, 0x00018000, 0, 0x80000000, 0x000c0000);
    T2("ssub16_ge", "ssub16", 0x00010001, 0x00020000, 0, 0xffff0001, 0x00030000);
    T2("uadd8_ge", "uadd8", 0xff010203, 0x01010101, 0, 0x00020304, 0x00080000);
    T2("usub8_ge", "usub8", 0x01020304, 0x02020202, 0, 0xff000102, 0x00070000);
    T2("uadd16_ge", "uadd16", 0xffff0001, 0x00010001, 0, 0x00000002, 0x000c0000);
    T2("sasx", "sasx", 0x00010002, 0x00030004, 0, 0x0005ffff, 0x000c0000);
    T2("usax", "usax", 0x00010002, 0x00030004, 0, 0xfffd0005, 0x00000000);
    T2("sel", "sel", 0x11223344, 0xaabbccdd, 0x000a0000, 0x11bb33dd, 0x000a0000);
    T2("uhadd8", "uhadd8", 0xffffffff, 0x01010101, 0, 0x80808080, 0);
    T2("shsub16", "shsub16", 0x00010001, 0x00030002, 0, 0xffffffff, 0);
    T2("usad8", "usad8", 0x01020304, 0x04030201, 0, 8, 0);
    T3("usada8", "usada8", 0x01010101, 0, 5, 9, 0);
}

static void multiplication(void)
{
    T2("mul", "mul", 0x10001, 0x10001, 0, 0x00020001, 0);
    T3("mla", "mla", 3, 4, 5, 17, 0);
    T3("mls", "mls", 3, 4, 10, 0xfffffffe, 0);
    TL("umull", "umull", 0xffffffff, 0xffffffff, 0, 0, 1, 0xfffffffe);
    TL("smull_minus_one", "smull", 0xffffffff, 0xffffffff, 0, 0, 1, 0);
    TL("smull_least", "smull", 0x80000000, 0x80000000, 0, 0, 0, 0x40000000);
    TL("umlal", "umlal", 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0, 0xfffffffe);
    TL("smlal", "smlal", 0xffffffff, 1, 0, 0, 0xffffffff, 0xffffffff);
    TL("umaal", "umaal", 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff);
    TL("smlalbb", "smlalbb", 0x8000, 0x8000, 0, 0, 0x40000000, 0);
    TL("smlaltb", "smlaltb", 0x8000ffff, 1, 0, 0, 0xffff8000, 0xffffffff);
    TL("smlald", "smlald", 0x00020003, 0x00040005, 0, 0, 23, 0);
    TL("smlsldx", "smlsldx", 0x00020003, 0x00040005, 0, 0, 2, 0); /* 3 * 4 - 2 * 5 */
    T2("smmul", "smmul", 0x60000000, 4, 0, 1, 0);
    T2("smmulr", "smmulr", 0x60000000, 4, 0, 2, 0);
    T3("smmla", "smmla", 0x40000000, 4, 10, 11, 0);
    T3("smmls", "smmls", 0x40000000, 4, 10, 9, 0);
    T2("smuad", "smuad", 0x7fff7fff, 0x7fff7fff, 0, 0x7ffe0002, 0);
    T2("smuad_overflow", "smuad", 0x80008000, 0x80008000, 0, 0x80000000, Q);
    T2("smusd", "smusd", 0x00020003, 0x00040005, 0, 7, 0);
    T3("smlad_overflow", "smlad", 1, 1, 0x7fffffff, 0x80000000, Q);
    T2("smulbt", "smulbt", 0x00007fff, 0x80000000, 0, 0xc0008000, 0);
    T2("smulwb", "smulwb", 0x00010000, 0x0000ffff, 0, 0xffffffff, 0);
    T3("smlabb_overflow", "smlabb", 0x7fff, 0x7fff, 0x7fffffff, 0xbfff0000, Q);
    T3("smlawb", "smlawb", 0x00020000, 3, 1, 7, 0);
}

/* For each condition, the 16 combinations of N Z C V for which it passes (ARM table A7-1); bit
 * index: NZCV as a number. */
#define CONDITION(name, condition, inverse, want)                                       \
    do {                                                                                \
        uint32_t passes_ = 0;                                                           \
        for (uint32_t nzcv = 0; nzcv < 16; nzcv++) {                                    \
            uint32_t yes_;                                                              \
            __asm__ volatile("msr apsr_nzcvq, %1\n\tite " condition "\n\tmov" condition \
                             " %0, #1\n\tmov" inverse " %0, #0"                         \
                             : "=&r"(yes_)                                              \
                             : "r"(nzcv << 28)                                          \
                             : "cc");                                                   \
            passes_ |= yes_ << nzcv;                                                    \
        }                                                                               \
        expect("condition_" name, passes_, want);                                       \
    } while (0)

static void conditions(void)
{
    uint32_t r, s;
    CONDITION("eq", "eq", "ne", 0xf0f0);
    CONDITION("ne", "ne", "eq", 0x0f0f);
    CONDITION("cs", "cs", "cc", 0xcccc);
    CONDITION("cc", "cc", "cs", 0x3333);
    CONDITION("mi", "mi", "pl", 0xff00);
    CONDITION("pl", "pl", "mi", 0x00ff);
    CONDITION("vs", "vs", "vc", 0xaaaa);
    CONDITION("vc", "vc", "vs", 0x5555);
    CONDITION("hi", "hi", "ls", 0x0c0c);
    CONDITION("ls", "ls", "hi", 0xf3f3);
    CONDITION("ge", "ge", "lt", 0xaa55);
    CONDITION("lt", "lt", "ge", 0x55aa);
    CONDITION("gt", "gt", "le", 0x0a05);
    CONDITION("le", "le", "gt", 0xf5fa);
    /* A 16-bit ADD inside an IT block leaves the flags alone (ARM A7.7.4), so all four of ITTTE see
     * Z. */
    __asm__ volatile("movs %0, #0\n\tmovs %1, #0\n\tittte eq\n\taddeq %0, %0, #1\n\taddeq %0, %0, "
                     "#2\n\taddeq %0, %0, #4\n\tmovne %1, #9"
                     : "=&l"(r), "=&l"(s)::"cc");
    expect("it_three_then", r, 7);
    expect("it_else_not_taken", s, 0);
    /* A compare inside changes what the next instruction of the block sees. */
    __asm__ volatile("movs %0, #0\n\titte eq\n\taddeq %0, %0, #1\n\tcmpeq %0, #5\n\tmovne %0, #3"
                     : "=&l"(r)::"cc");
    expect("it_compare_inside", r, 3);
    __asm__ volatile("movs %0, #0\n\tcbz %0, 1f\n\tmovs %0, #1\n1:\tadd %0, %0, #4"
                     : "=&l"(r)::"cc");
    expect("cbz", r, 4);
}

static uint32_t cells[16] __attribute__((aligned(16)));

static void memory(void)
{
    uint32_t r, s, t;
    volatile uint32_t *words = cells;
    uint32_t *at = cells;
    words[0] = 0x33221100;
    words[1] = 0x77665544;
    words[2] = 0xbbaa9988;
    __asm__ volatile("ldr %0, [%1, #1]" : "=r"(r) : "r"(at) : "memory");
    expect("ldr_unaligned_1", r, 0x44332211);
    __asm__ volatile("ldr %0, [%1, #3]" : "=r"(r) : "r"(at) : "memory");
    expect("ldr_unaligned_3", r, 0x66554433);
    __asm__ volatile("ldrsh %0, [%1, #7]" : "=r"(r) : "r"(at) : "memory");
    expect("ldrsh_unaligned", r, 0xffff8877);
    __asm__ volatile("str %0, [%1, #2]" ::"r"(0xdeadbeef), "r"(at) : "memory");
    expect("str_unaligned_low", words[0], 0xbeef1100);
    expect("str_unaligned_high", words[1], 0x7766dead);
    __asm__ volatile("ldrd %0, %1, [%2, #4]" : "=r"(r), "=r"(s) : "r"(at) : "memory");
    expect("ldrd_low", r, 0x7766dead);
    expect("ldrd_high", s, 0xbbaa9988);
    __asm__ volatile("ldr %0, [%1], #4" : "=r"(r), "+r"(at)::"memory");
    expect("post_index_value", r, 0xbeef1100);
    expect("post_index_base", (uint32_t)(at - cells), 1);
    __asm__ volatile("ldrsb %0, [%1, #-3]!" : "=r"(r), "+r"(at)::"memory");
    expect("pre_index_value", r, 0x00000011);
    expect("pre_index_base", (uint32_t)((uintptr_t)at - (uintptr_t)cells), 1);
    at = cells;
    __asm__ volatile("mov r4, #4\n\tmov r5, #5\n\tmov r6, #6\n\tstmia %0!, {r4-r6}\n\tldmdb %0!, "
                     "{r4, r6}\n\tmov %1, r4\n\tmov %2, r6"
                     : "+r"(at), "=&r"(r), "=&r"(s)::"r4", "r5", "r6", "memory");
    expect("ldmdb_first", r, 5);
    expect("ldmdb_second", s, 6);
    expect("ldmdb_base", (uint32_t)(at - cells), 1);
    __asm__ volatile("mov r4, #11\n\tmov r5, #22\n\tpush {r4, r5}\n\tldr %0, [sp]\n\tldr %1, [sp, "
                     "#4]\n\tadd sp, #8"
                     : "=&r"(r), "=&r"(s)::"r4", "r5", "memory");
    expect("push_lowest_first", r, 11);
    expect("push_then", s, 22);
    /* A table branch: the halfword at index 1 leads to the second place. */
    __asm__ volatile("mov %0, #1\n\ttbb [pc, %0]\n1:\t.byte (2f-1b)/2, (3f-1b)/2\n2:\tmov %0, "
                     "#20\n\tb 4f\n3:\tmov %0, #30\n4:"
                     : "=&r"(t));
    expect("tbb", t, 30);
    /* Exclusives (ARM A3.4): a store without a reservation fails, with one it works once. */
    words[0] = 5;
    __asm__ volatile("clrex\n\tstrex %0, %1, [%2]" : "=&r"(r) : "r"(6), "r"(cells) : "memory");
    expect("strex_without", r, 1);
    expect("strex_without_memory", words[0], 5);
    __asm__ volatile("ldrex %0, [%3]\n\tadd %0, #1\n\tstrex %1, %0, [%3]\n\tstrex %2, %0, [%3]"
                     : "=&r"(r), "=&r"(s), "=&r"(t)
                     : "r"(cells)
                     : "memory");
    expect("ldrex", r, 6);
    expect("strex", s, 0);
    expect("strex_again", t, 1);
    expect("strex_memory", words[0], 6);
    __asm__ volatile("ldrex %0, [%2]\n\tclrex\n\tstrex %1, %0, [%2]"
                     : "=&r"(r), "=&r"(s)
                     : "r"(cells)
                     : "memory");
    expect("strex_after_clrex", s, 1);
    __asm__ volatile("ldrexb %0, [%2]\n\tstrexb %1, %0, [%2]"
                     : "=&r"(r), "=&r"(s)
                     : "r"(cells)
                     : "memory");
    expect("strexb", s, 0);
}

static void special_registers(void)
{
    uint32_t r;
    __asm__ volatile("msr primask, %1\n\tmrs %0, primask\n\tcpsie i" : "=r"(r) : "r"(0xffffffff));
    expect("primask_one_bit", r, 1);
    __asm__ volatile("msr basepri, %1\n\tmrs %0, basepri" : "=r"(r) : "r"(0xff));
    expect("basepri_upper_four_bits", r, 0xf0); /* PM0214 2.1.3: bits 7:4 */
    __asm__ volatile("msr basepri, %1\n\tmsr basepri_max, %2\n\tmrs %0, basepri"
                     : "=r"(r)
                     : "r"(0x80), "r"(0x40));
    expect("basepri_max_raises", r, 0x40);
    __asm__ volatile("msr basepri_max, %1\n\tmrs %0, basepri" : "=r"(r) : "r"(0xc0));
    expect("basepri_max_never_lowers", r, 0x40);
    __asm__ volatile("msr basepri_max, %1\n\tmrs %0, basepri" : "=r"(r) : "r"(0));
    expect("basepri_max_not_by_zero", r, 0x40);
    __asm__ volatile("msr basepri, %1\n\tmrs %0, basepri" : "=r"(r) : "r"(0));
    expect("basepri_off", r, 0);
    __asm__ volatile("msr faultmask, %1\n\tmrs %0, faultmask\n\tcpsie f" : "=r"(r) : "r"(1));
    expect("faultmask", r, 1);
    __asm__ volatile("mrs %0, ipsr" : "=r"(r));
    expect("ipsr_thread", r, 0);
    __asm__ volatile("mrs %0, xpsr" : "=r"(r));
    expect("epsr_reads_as_0", r & 0x07000000u, 0); /* ARM B5.2.2 */
    __asm__ volatile("mrs %0, control" : "=r"(r));
    expect("control", r & 3u, 0);
    __asm__ volatile("msr psp, %1\n\tmrs %0, psp" : "=r"(r) : "r"(0x20001007));
    expect("psp_word_aligned", r, 0x20001004); /* ARM B1.4.1: bits 1:0 are 0 */
    expect("cpuid_part", WORD(0xe000ed00u) & 0xff0ffff0u, 0x410fc240u & 0xff0ffff0u);
    expect("cpuid", WORD(0xe000ed00u), 0x410fc241u); /* PM0214 4.4.2 */
    expect("aircr_reads", AIRCR, 0xfa050000u);
    expect("ccr_reset", CCR, 0x200u);
    expect("shcsr_reset", SHCSR, 0);
    expect("cpacr_reset", CPACR, 0);
    expect("mpu_type", WORD(0xe000ed90u), 0x00000800u); /* PM0214 4.2.5: 8 regions */
}

int main(void)
{
    arithmetic();
    shifts();
    fields();
    saturation();
    simd();
    multiplication();
    conditions();
    memory();
    special_registers();
    return 0;
}
