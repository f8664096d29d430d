/* The frame of the FPU: room made at entry, registers stored when a handler uses the FPU (ARM
 * B1.5.7, B1.5.8). */
#include "fpkeeper.h"

static void floating_frame(void)
{
    uint32_t sp, s0, s15, fpscr, control;
    on(11, keeper);
    keep_faults();
    expect("fpccr_reset", FPCCR, 0xc0000000u);
    expect("fpdscr_reset", FPDSCR, 0);
    CPACR = 0xfu << 20;
    isb();
    expect("cpacr", CPACR, 0x00f00000u);
    __asm__ volatile("mrs %0, control" : "=r"(control));
    expect("fpca_before", control >> 2 & 1u, 0);
    forget();
    __asm__ volatile("mov %0, sp\n\tvmov s0, %5\n\tvmov s15, %6\n\tvmsr fpscr, %7\n\tsvc "
                     "#0\n\tvmov %1, s0\n\tvmov %2, s15\n\tvmrs %3, fpscr\n\t"
                     "mrs %4, control"
                     : "=&r"(sp), "=&r"(s0), "=&r"(s15), "=&r"(fpscr), "=&r"(control)
                     : "r"(0x3f800000), "r"(0x40490fdb), "r"(0xa3c00010u)
                     : "s0", "s15", "memory");
    expect("fp_exc_return", exc_return, 0xffffffe9u);
    expect("fp_frame_size", (sp & ~7u) - frame_at, 0x68);
    expect("fp_fpca_in_handler", control_seen >> 2 & 1u, 0);
    expect("fp_lspact_in_handler", fpccr_seen & 1u, 1); /* lazy: only room is made */
    expect("fp_fpcar", FPCAR - frame_at, 0x20);
    expect("fp_fpca_after", control >> 2 & 1u, 1);
    expect("fp_s0_after", s0, 0x3f800000u);
    expect("fp_s15_after", s15, 0x40490fdbu);
    expect("fp_fpscr_after", fpscr, 0xa3c00010u);
    expect("fp_lspact_after", FPCCR & 1u, 0);
    /* A handler that uses the FPU starts a context of its own, with FPDSCR's modes, and the old one
     * comes back. */
    on(11, fp_keeper);
    forget();
    __asm__ volatile("vmov s0, %4\n\tvmov s15, %5\n\tvmsr fpscr, %6\n\tsvc #0\n\tvmov %0, "
                     "s0\n\tvmov %1, s15\n\tvmrs %2, fpscr\n\tmrs %3, control"
                     : "=&r"(s0), "=&r"(s15), "=&r"(fpscr), "=&r"(control)
                     : "r"(0x3f800000), "r"(0x40490fdb), "r"(0x03c00000u)
                     : "s0", "s15", "memory");
    expect("fp_used_s0_after", s0, 0x3f800000u);
    expect("fp_used_s15_after", s15, 0x40490fdbu);
    expect("fp_used_fpscr_after", fpscr, 0x03c00000u);
    expect("fp_modes_in_handler", cfsr_seen & 0x07c00000u, 0);
    expect("fp_lspact_after_use", icsr_seen & 1u, 0);
    expect("fp_stacked_s0", stacked_s0, 0x3f800000u);
    expect("fp_stacked_s15", stacked_s15, 0x40490fdbu);
    expect("fp_stacked_fpscr", stacked_fpscr, 0x03c00000u);
    on(11, keeper);
    /* Without a context there is no such frame. */
    forget();
    __asm__ volatile(
        "mrs r4, control\n\tbic r4, #4\n\tmsr control, r4\n\tisb\n\tmov %0, sp\n\tsvc #0"
        : "=&r"(sp)::"r4", "memory");
    expect("fpca_cleared_exc_return", exc_return, 0xfffffff9u);
    expect("fpca_cleared_frame", (sp & ~7u) - frame_at, 0x20);
}

int main(void)
{
    floating_frame();
    return 0;
}
