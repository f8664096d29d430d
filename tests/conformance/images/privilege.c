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
    __asm__ volatile("msr basepri, %2\n\tmov r4, #1\n\tmsr control, r4\n\tisb\n\tcpsid i\n\tmsr basepri, r4\n\tmrs %0, primask\n\t"
                     "mov r4, #0\n\tmsr control, r4\n\tisb\n\tmrs %1, control\n\tsvc #0"
                     : "=&r"(primask), "=&r"(control) : "r"(0) : "r4", "memory");
    expect("unprivileged_control_stays", control & 3u, 1);
    expect("unprivileged_primask_reads_0", primask, 0);
    __asm__ volatile("mrs %0, control" : "=r"(control));
    expect("handler_gave_privilege_back", control & 3u, 0);
    __asm__ volatile("mrs %0, primask" : "=r"(primask));
    expect("unprivileged_cps_ignored", primask, 0);
    on(11, keeper);
}

int main(void)
{
    unprivileged();
    return 0;
}
