/* What the images about exceptions share: handlers that keep the frame of what they interrupted,
 * and faults on purpose. */
#ifndef MATRIG_TESTS_CONFORMANCE_FRAMES_H
#define MATRIG_TESTS_CONFORMANCE_FRAMES_H

#include "bench.h"

#define NAKED          __attribute__((naked))
#define UNDEFINED_WIDE ".short 0xf7f0, 0xa000" /* ARM A7.7.194 */

static volatile uint32_t sequence;   /* a digit for each thing that happened, in order */
static volatile uint32_t exc_return; /* LR in the handler */
static volatile uint32_t frame_at;   /* address of the frame */
static volatile uint32_t frame[8];   /* r0-r3, r12, lr, pc, xpsr */
static volatile uint32_t ipsr_seen, control_seen, icsr_seen, cfsr_seen, hfsr_seen, fpccr_seen;
static volatile uint32_t skip;   /* added to the stacked PC */
static volatile uint32_t repair; /* set the T bit, return to the stacked LR */

static __attribute__((unused)) void note(uint32_t digit)
{
    sequence = sequence << 4 | digit;
}

/* Calls keep(frame, lr) with the frame of whatever was interrupted. */
#define KEEPING(name, keep)                                                                  \
    static NAKED void name(void)                                                             \
    {                                                                                        \
        __asm__ volatile("mov r1, lr\n\ttst lr, #4\n\tite eq\n\tmrseq r0, msp\n\tmrsne r0, " \
                         "psp\n\tpush {r4, lr}\n\t"                                          \
                         "bl " #keep "\n\tpop {r4, pc}");                                    \
    }

static __attribute__((used)) void keep(uint32_t *at, uint32_t lr)
{
    __asm__ volatile("mrs %0, ipsr" : "=r"(ipsr_seen));
    __asm__ volatile("mrs %0, control" : "=r"(control_seen));
    exc_return = lr;
    frame_at = (uint32_t)(uintptr_t)at;
    for (unsigned i = 0; i < 8; i++)
        frame[i] = at[i];
    icsr_seen = ICSR;
    cfsr_seen = CFSR;
    hfsr_seen = HFSR;
    fpccr_seen = FPCCR;
    CFSR = 0xffffffffu;
    HFSR = 0xffffffffu;
    at[6] += skip;
    if (repair) {
        at[6] = at[5] & ~1u;
        at[7] |= 1u << 24;
    }
    note(ipsr_seen & 15u);
}
KEEPING(keeper, keep)

static __attribute__((unused)) void isb(void)
{
    __asm__ volatile("dsb\n\tisb" ::: "memory");
}

static __attribute__((unused)) void forget(void)
{
    sequence = exc_return = frame_at = cfsr_seen = hfsr_seen = ipsr_seen = 0;
    skip = repair = 0;
}

/* `code` faults; `setup` goes before it, with %1 for `operand`. */
#define FAULT(name, setup, operand, code, skips, want_exception, want_cfsr, want_hfsr) \
    do {                                                                               \
        uint32_t pc_;                                                                  \
        forget();                                                                      \
        skip = skips;                                                                  \
        __asm__ volatile(setup "\n\tadr %0, 1f\n\tb 1f\n\t.balign 4\n1:\t" code        \
                         : "=&r"(pc_)                                                  \
                         : "r"(operand)                                                \
                         : "r4", "r5", "lr", "memory", "cc");                          \
        expect(name "_exception", ipsr_seen, want_exception);                          \
        expect(name "_cfsr", cfsr_seen, want_cfsr);                                    \
        expect(name "_hfsr", hfsr_seen, want_hfsr);                                    \
        expect(name "_pc", frame[6] - pc_, 0);                                         \
    } while (0)

/* The four configurable exceptions that can be faults, and HardFault, go to the keeper. */
static __attribute__((unused)) void keep_faults(void)
{
    for (unsigned n = 3; n < 7; n++)
        on(n, keeper);
}

#endif
