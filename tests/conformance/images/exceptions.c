/* Exceptions (ARM B1.5): entry, frame, return, priorities, pending, masks. */
#include "frames.h"

static uint32_t process_stack[64] __attribute__((aligned(8)));

/* ---- entry and return ---- */

static void supervisor_call(void)
{
    uint32_t sp, r0, r12, after_flags;
    on(11, keeper);
    forget();
    __asm__ volatile("mov %0, sp\n\tmov r0, #10\n\tmov r1, #11\n\tmov r2, #12\n\tmov r3, "
                     "#13\n\tmov r12, #112\n\tmov lr, #99\n\t"
                     "msr apsr_nzcvq, %4\n\tsvc #7\n\tmrs %3, apsr\n\tmov %1, r0\n\tmov %2, r12"
                     : "=&r"(sp), "=&r"(r0), "=&r"(r12), "=&r"(after_flags)
                     : "r"(0xa8000000u)
                     : "r0", "r1", "r2", "r3", "r12", "lr", "memory", "cc");
    expect("svc_ipsr", ipsr_seen, 11);
    expect("svc_exc_return", exc_return, 0xfffffff9u);
    expect("svc_vectactive", icsr_seen & 0x1ffu, 11);
    expect("svc_retobase", icsr_seen >> 11 & 1u, 1);
    expect("svc_frame_r0", frame[0], 10);
    expect("svc_frame_r1", frame[1], 11);
    expect("svc_frame_r2", frame[2], 12);
    expect("svc_frame_r3", frame[3], 13);
    expect("svc_frame_r12", frame[4], 112);
    expect("svc_frame_lr", frame[5], 99);
    /* the stacked PC is that of the next instruction */
    expect("svc_instruction_before_pc", HALF(frame[6] - 2), 0xdf07u);
    expect("svc_frame_flags_and_t", frame[7] & 0xff000000u, 0xa9000000u);
    expect("svc_frame_exception", frame[7] & 0x1ffu, 0);
    expect("svc_frame_aligned", frame_at & 7u, 0);
    expect("svc_frame_bit9", frame[7] >> 9 & 1u, (sp >> 2) & 1u);
    expect("svc_frame_size", sp - frame_at - (sp & 4u), 0x20);
    expect("svc_returns_r0", r0, 10);
    expect("svc_returns_r12", r12, 112);
    expect("svc_returns_flags", after_flags, 0xa8000000u);
}

/* With SP at 4 mod 8 the frame begins on 8 and bit 9 of the stacked xPSR says so (ARM B1.5.7). */
static void alignment(void)
{
    uint32_t before, after;
    forget();
    __asm__ volatile("mov r4, sp\n\tbic r5, r4, #7\n\tsub r5, #4\n\tmov sp, r5\n\tsvc #0\n\tmov "
                     "%1, sp\n\tmov sp, r4\n\tmov %0, r5"
                     : "=&r"(before), "=&r"(after)::"r4", "r5", "memory");
    expect("unaligned_sp_bit9", frame[7] >> 9 & 1u, 1);
    expect("unaligned_sp_frame", before - frame_at, 0x24);
    expect("unaligned_sp_restored", after - before, 0);
}

static void process_stack_used(void)
{
    uint32_t control, psp;
    uint32_t top = (uint32_t)(uintptr_t)&process_stack[60];
    forget();
    __asm__ volatile("msr psp, %2\n\tmov r4, #2\n\tmsr control, r4\n\tisb\n\tsvc #1\n\tmrs %0, "
                     "control\n\tmrs %1, psp\n\tmov r4, #0\n\t"
                     "msr control, r4\n\tisb"
                     : "=&r"(control), "=&r"(psp)
                     : "r"(top)
                     : "r4", "memory");
    expect("psp_exc_return", exc_return, 0xfffffffdu);
    expect("psp_frame", top - frame_at, 0x20);
    expect("psp_control_in_handler", control_seen & 3u, 0);
    expect("psp_control_after", control & 3u, 2);
    expect("psp_after", psp - top, 0);
}

/* What a handler writes into the frame is what comes back. */
static __attribute__((used)) void change(uint32_t *at, uint32_t lr)
{
    (void)lr;
    at[0] = 0x1234;
    at[6] += 2; /* over one 16-bit instruction */
    at[7] = (at[7] & 0x07ffffffu) | 0x58000000u;
}
KEEPING(changer, change)

static void frame_changed(void)
{
    uint32_t r0, flags;
    on(11, changer);
    __asm__ volatile("mov r0, #1\n\tsvc #0\n\tmovs r0, #2\n\tmrs %1, apsr\n\tmov %0, r0"
                     : "=&r"(r0), "=&r"(flags)::"r0", "cc", "memory");
    expect("changed_r0_and_pc", r0, 0x1234);
    expect("changed_flags", flags, 0x58000000u);
    on(11, keeper);
}

/* A reservation does not survive an exception (ARM A3.4.4). */
static void reservation(void)
{
    static uint32_t cell;
    uint32_t failed;
    __asm__ volatile("ldrex r4, [%1]\n\tsvc #0\n\tstrex %0, r4, [%1]"
                     : "=&r"(failed)
                     : "r"(&cell)
                     : "r4", "memory");
    expect("strex_after_exception", failed, 1);
}

/* ---- pending and priorities ---- */

static void svc_pends(void)
{
    note(1);
    ICSR = 1u << 28; /* PENDSVSET */
    isb();
    icsr_seen = ICSR;
    note(2);
}
static void pendsv_notes(void)
{
    __asm__ volatile("mov %0, lr" : "=r"(exc_return));
    note(3);
}

static void pend_service(void)
{
    on(11, svc_pends);
    on(14, pendsv_notes);
    forget();
    SHPR(11) = 0x80;
    SHPR(14) = 0xf0;
    __asm__ volatile("svc #0" ::: "memory");
    expect("pendsv_waits_for_svc", sequence, 0x123);
    expect("pendsv_pending", icsr_seen >> 28 & 1u, 1);
    expect("pendsv_vectpending", icsr_seen >> 12 & 0x1ffu, 14);
    forget();
    SHPR(14) = 0x40;
    __asm__ volatile("svc #0" ::: "memory");
    expect("pendsv_preempts_svc", sequence, 0x132);
    expect("pendsv_nested_exc_return", exc_return, 0xfffffff1u);
    forget();
    SHPR(14) = 0x80; /* equal: no preemption */
    __asm__ volatile("svc #0" ::: "memory");
    expect("pendsv_equal_waits", sequence, 0x123);
    SHPR(14) = 0xf0;
    forget();
    __asm__ volatile("cpsid i");
    ICSR = 1u << 28;
    isb();
    ICSR = 1u << 27; /* PENDSVCLR */
    __asm__ volatile("cpsie i\n\tisb");
    expect("pendsv_cleared", sequence, 0);
    SHPR(11) = 0;
    on(11, keeper);
}

static void irq_a(void)
{
    note(0xa);
    ISPR(8) = BIT(8);
    isb();
    note(0xb);
}
static void irq_b(void)
{
    note(0xc);
    icsr_seen = ICSR;
    cfsr_seen = IABR(7);
    __asm__ volatile("mov %0, lr" : "=r"(exc_return));
}
static void irq_note(void)
{
    uint32_t n;
    __asm__ volatile("mrs %0, ipsr" : "=r"(n));
    note(n - 16u);
}

static void interrupts(void)
{
    uint32_t pending;
    for (unsigned n = 5; n < 11; n++)
        on(IRQ(n), irq_note);
    on(IRQ(7), irq_a);
    on(IRQ(8), irq_b);
    ISER(7) = BIT(7) | BIT(8);
    IPR(7) = 0x80;
    IPR(8) = 0x40;
    forget();
    ISPR(7) = BIT(7);
    isb();
    expect("nested_order", sequence, 0xacb);
    expect("nested_exc_return", exc_return, 0xfffffff1u);
    expect("nested_vectactive", icsr_seen & 0x1ffu, IRQ(8));
    expect("nested_retobase", icsr_seen >> 11 & 1u, 0);
    expect("nested_active_bits", cfsr_seen, BIT(7) | BIT(8));
    expect("active_after", IABR(7), 0);
    forget();
    IPR(8) = 0x80; /* equal */
    ISPR(7) = BIT(7);
    isb();
    expect("equal_order", sequence, 0xabc);
    expect("tail_chained_exc_return", exc_return, 0xfffffff9u);
    forget();
    AIRCR = 0x05fa0000u | 6u << 8; /* PRIGROUP 6: bit 7 alone preempts (PM0214 4.4.5) */
    isb();
    IPR(7) = 0x70;
    IPR(8) = 0x40; /* same group, more urgent subpriority: waits */
    ISPR(7) = BIT(7);
    isb();
    expect("subpriority_does_not_preempt", sequence, 0xabc);
    AIRCR = 0x05fa0000u;
    isb();
    on(IRQ(7), irq_note);
    on(IRQ(8), irq_note);
    ISER(5) = BIT(5) | BIT(6) | BIT(9) | BIT(10);
    forget();
    IPR(5) = 0x90, IPR(6) = 0x30, IPR(7) = 0x30, IPR(8) = 0x90, IPR(9) = 0x20, IPR(10) = 0x10;
    __asm__ volatile("cpsid i");
    ISPR(5) = BIT(5) | BIT(6) | BIT(7) | BIT(8) | BIT(9) | BIT(10);
    isb();
    pending = ISPR(5);
    expect("pending_bits", pending, 0x7e0);
    expect("masked_nothing_runs", sequence, 0);
    expect("isrpending", ICSR >> 22 & 1u, 1);
    expect("vectpending_most_urgent", ICSR >> 12 & 0x1ffu, IRQ(10));
    ICPR(8) = BIT(8);
    __asm__ volatile("cpsie i\n\tisb");
    expect("order_by_priority_then_number", sequence, 0xa9675);
    forget();
    ICER(5) = BIT(5);
    ISPR(5) = BIT(5);
    isb();
    expect("disabled_stays_pending", ISPR(5) & BIT(5), BIT(5));
    expect("disabled_does_not_run", sequence, 0);
    ICPR(5) = BIT(5);
    ISER(5) = BIT(5);
    isb();
    expect("cleared_does_not_run", sequence, 0);
    STIR = 6;
    isb();
    expect("stir", sequence, 6);
    expect("enable_reads_back", ISER(5), 0x7e0);
    expect("disable_reads_back", ICER(5), 0x7e0);
    IPR(5) = 0xff;
    expect("ipr_upper_four_bits", IPR(5), 0xf0); /* PM0214 4.3.7 */
    SHPR(15) = 0xff;
    expect("shpr_upper_four_bits", SHPR(15), 0xf0);
}

static void masks(void)
{
    IPR(6) = 0x60;
    IPR(9) = 0x50;
    forget();
    __asm__ volatile("msr basepri, %0\n\tisb" ::"r"(0x60));
    ISPR(6) = BIT(6);
    isb();
    expect("basepri_masks_equal", sequence, 0);
    ISPR(9) = BIT(9);
    isb();
    expect("basepri_passes_more_urgent", sequence, 9);
    __asm__ volatile("msr basepri, %0\n\tisb" ::"r"(0x70));
    expect("basepri_lowered", sequence, 0x96);
    __asm__ volatile("msr basepri, %0\n\tisb" ::"r"(0));
    forget();
    __asm__ volatile("cpsid f");
    ISPR(6) = BIT(6);
    isb();
    expect("faultmask_masks", sequence, 0);
    __asm__ volatile("cpsie f\n\tisb");
    expect("faultmask_released", sequence, 6);
    /* WFI wakes on what PRIMASK holds back; the interrupt runs when PRIMASK is cleared (ARM
     * B1.5.19). */
    forget();
    __asm__ volatile("cpsid i");
    ISPR(6) = BIT(6);
    __asm__ volatile("dsb\n\twfi");
    expect("wfi_wakes_masked", sequence, 0);
    __asm__ volatile("cpsie i\n\tisb");
    expect("then_runs", sequence, 6);
    on(2, keeper);
    forget();
    __asm__ volatile("cpsid i");
    ICSR = 1u << 31; /* NMIPENDSET */
    isb();
    __asm__ volatile("cpsie i");
    expect("nmi_passes_primask", sequence, 2);
    expect("nmi_exc_return", exc_return, 0xfffffff9u);
    on(15, keeper);
    forget();
    SHPR(15) = 0;
    ICSR = 1u << 26; /* PENDSTSET */
    isb();
    expect("pendst", sequence, 15);
}

int main(void)
{
    supervisor_call();
    alignment();
    process_stack_used();
    frame_changed();
    reservation();
    pend_service();
    interrupts();
    masks();
    return 0;
}
