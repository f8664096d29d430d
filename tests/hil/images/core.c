/* Exceptions: priorities, preemption, tail-chaining, floating-point context, stacks, masks. */
#include "tests/hil/images/image.h"

static volatile uint32_t place;

static void note(uint32_t what)
{
    results[8 + place++] = what;
}

void irq6(void) /* lowest: pends a higher and an equal one, is preempted by the higher */
{
    note(0x61);
    pend_irq(8);
    pend_irq(7);
    __asm__ volatile("dsb\n isb");
    note(0x62);
}
void irq7(void)
{
    note(0x71);
}
void irq8(void) /* highest; spoils every register that a handler may */
{
    note(0x81);
    __asm__ volatile(
        "vmov.f32 s0, #1.0\n vmov.f32 s1, #2.0\n vmov.f32 s15, #3.0\n vadd.f32 s0, s1, s15\n"
        "vmov.f32 s7, #5.0\n" ::
            : "s0", "s1", "s7", "s15");
}
void svc(void)
{
    note(0xa0);
}
void pendsv(void)
{
    note(0xb0);
}
void systick(void)
{
    results[3]++;
}

/* Numbers kept in S registers across preemption; the sum shows any loss. */
static float spin(unsigned n)
{
    register float a __asm__("s0") = 1.5f;
    register float b __asm__("s1") = 0.25f;
    register float c __asm__("s7") = 7.0f;
    register float d __asm__("s15") = 0.125f;
    while (n--) {
        __asm__ volatile("vadd.f32 %0, %0, %1\n vadd.f32 %2, %2, %3"
                         : "+t"(a), "+t"(b), "+t"(c), "+t"(d));
        if (n == 50)
            pend_irq(8);
    }
    return a + c;
}

int main(void)
{
    uint32_t basepri = 0x50, zero = 0, sp_before, sp_after;
    union {
        float f;
        uint32_t u;
    } sum;
    REG(0xe000ed0cu) = 0x05fa0300; /* four bits of group priority */
    enable_fpu();
    for (unsigned n = 6; n <= 8; n++)
        enable_irq(n);
    irq_priority(6, 0xf0);
    irq_priority(7, 0xf0);
    irq_priority(8, 0x40);
    *(volatile uint8_t *)0xe000ed22u = 0xe0; /* PendSV above 6 and 7 */
    __asm__ volatile("mov %0, sp" : "=r"(sp_before));
    pend_irq(6);
    __asm__ volatile("dsb\n isb");
    note(0x01);
    /* BASEPRI holds 6 and 7 back, not 8 */
    __asm__ volatile("msr basepri, %0" ::"r"(basepri));
    pend_irq(7);
    pend_irq(8);
    __asm__ volatile("dsb\n isb");
    note(0x02);
    __asm__ volatile("msr basepri, %0\n isb" ::"r"(zero));
    note(0x03);
    /* PRIMASK holds everything back; WFI goes on all the same */
    __asm__ volatile("cpsid i");
    pend_irq(7);
    __asm__ volatile("wfi");
    note(0x04);
    __asm__ volatile("cpsie i\n isb");
    __asm__ volatile("svc 1");
    REG(0xe000ed04u) = 1u << 28;
    __asm__ volatile("dsb\n isb");
    __asm__ volatile("mov %0, sp" : "=r"(sp_after));
    results[1] = sp_before - sp_after;
    sum.f = spin(100);
    results[2] = sum.u;
    /* Process stack, through an exception and back */
    __asm__ volatile("msr psp, %1\n mov r2, #2\n msr control, r2\n isb\n svc 2\n mrs %0, control\n"
                     "mov r2, #0\n msr control, r2\n isb"
                     : "=&r"(zero)
                     : "r"(0x20010000u)
                     : "r0", "r1", "r2", "r3", "r12", "memory");
    results[4] = zero & 2u;
    results[7] = place;
    /* SysTick every 1000 cycles for 10 periods */
    REG(0xe000e014u) = 999;
    REG(0xe000e018u) = 0;
    REG(0xe000e010u) = 7;
    while (results[3] < 10)
        __asm__ volatile("wfi");
    REG(0xe000e010u) = 0;
    results[0] = 1;
    return 0;
}
