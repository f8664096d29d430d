/* Thread mode without privilege (ARM B1.3.1): what it writes into the mask registers is ignored. */
#include "frames.h"

static __attribute__((used)) void promote(uint32_t *at, uint32_t lr)
{
    keep(at, lr);
    __asm__ volatile("mrs r0, control\n\tbic r0, #1\n\tmsr control, r0\n\tisb" ::: "r0");
}
KEEPING(promoter, promote)

static void unprivileged(void)
{
    uint32_t primask, control;
    on(11, promoter);
    forget();
    __asm__ volatile("msr basepri, %2\n\tmov r4, #1\n\tmsr control, r4\n\tisb\n\tcpsid i\n\tmsr "
                     "basepri, r4\n\tmrs %0, primask\n\t"
                     "mov r4, #0\n\tmsr control, r4\n\tisb\n\tmrs %1, control\n\tsvc #0"
                     : "=&r"(primask), "=&r"(control)
                     : "r"(0)
                     : "r4", "memory");
    expect("unprivileged_control_stays", control & 3u, 1);
    expect("unprivileged_primask_reads_0", primask, 0);
    __asm__ volatile("mrs %0, control" : "=r"(control));
    expect("handler_gave_privilege_back", control & 3u, 0);
    __asm__ volatile("mrs %0, primask" : "=r"(primask));
    expect("unprivileged_cps_ignored", primask, 0);
    on(11, keeper);
}

/* The System Control Space is for privileged code (PM0214 4.1): a read without privilege is a bus
 * fault. */
static void control_space(void)
{
    keep_faults();
    on(11, promoter);
    SHCSR = 1u << 17;
    isb();
    forget();
    skip = 4;
    __asm__ volatile(
        "mov r4, #1\n\tmsr control, r4\n\tisb\n\tldr.w r4, [%0]\n\tisb" ::"r"(0xe000ed00u)
        : "r4", "memory");
    expect("control_space_exception", ipsr_seen, 5);
    expect("control_space_cfsr", cfsr_seen, 0x00008200u);
    skip = 0;
    __asm__ volatile("svc #0" ::: "memory");
    SHCSR = 0;
}

int main(void)
{
    unprivileged();
    control_space();
    return 0;
}
