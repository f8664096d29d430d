/* A handler that keeps the frame of what it interrupted and then uses the FPU itself. */
#ifndef MATRIG_TESTS_CONFORMANCE_FPKEEPER_H
#define MATRIG_TESTS_CONFORMANCE_FPKEEPER_H

#include "frames.h"

static volatile uint32_t stacked_s0, stacked_s15, stacked_fpscr;

static __attribute__((used)) void keep_fp(uint32_t *at, uint32_t lr)
{
    keep(at, lr);
    /* a new context */
    __asm__ volatile("vmov s0, %0\n\tvmov s15, %0\n\tvmrs %1, fpscr" : "+r"(skip), "=r"(cfsr_seen));
    icsr_seen = FPCCR;
    stacked_s0 = at[8];
    stacked_s15 = at[23];
    stacked_fpscr = at[24];
}
KEEPING(fp_keeper, keep_fp)

static __attribute__((unused)) void enable_fpu(void)
{
    CPACR = 0xfu << 20;
    isb();
}

#endif
