/* FPCCR: no note of contexts, no lazy storing (PM0214 4.6.2). */
#include "fpkeeper.h"

int main(void)
{
    on(11, keeper);
    enable_fpu();
    FPCCR = 0x40000000u; /* ASPEN off: no context is noted */
    isb();
    forget();
    __asm__ volatile("vmov s0, %0\n\tsvc #0" ::"r"(0) : "s0", "memory");
    expect("aspen_off_exc_return", exc_return, 0xfffffff9u);
    FPCCR = 0x80000000u; /* LSPEN off: everything is stored at once */
    isb();
    forget();
    on(11, fp_keeper);
    __asm__ volatile("vmov s0, %0\n\tsvc #0" ::"r"(0x12345678) : "s0", "memory");
    expect("eager_exc_return", exc_return, 0xffffffe9u);
    expect("eager_lspact", fpccr_seen & 1u, 0);
    expect("eager_stacked_s0", stacked_s0, 0x12345678u);
    FPCCR = 0xc0000000u;
    return 0;
}
