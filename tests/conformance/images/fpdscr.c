/* FPDSCR: the modes that a new context begins with (PM0214 4.6.5). */
#include "fpkeeper.h"

int main(void)
{
    on(11, fp_keeper);
    enable_fpu();
    expect("fpdscr_reset", FPDSCR, 0);
    FPDSCR = 0x02c00000u;
    __asm__ volatile("vmov s0, %0\n\tvmsr fpscr, %1\n\tsvc #0" ::"r"(0), "r"(0) : "s0", "memory");
    expect("fp_modes_from_fpdscr", cfsr_seen & 0x07c00000u, 0x02c00000u);
    FPDSCR = 0;
    return 0;
}
