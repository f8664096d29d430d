/* TIM2 (32 bits) and TIM4 (16 bits), RM0090 18.4: registers, counting, prescaler, update event and
 * interrupt. No times are measured: waits are bounded and only what happened counts. */
#include "bench.h"

#define TIM2      0x40000000u
#define TIM4      0x40000800u
#define CR1       0x00u
#define CR2       0x04u
#define DIER      0x0cu
#define SR        0x10u
#define EGR       0x14u
#define CCMR1     0x18u
#define CCER      0x20u
#define CNT       0x24u
#define PSC       0x28u
#define ARR       0x2cu
#define CCR1      0x34u
#define PATIENCE  300000u
#define R(offset) WORD(timer + (offset))

static uint32_t timer;
static volatile uint32_t updates;

static void update(void)
{
    updates++;
    R(SR) = ~1u;
    __asm__ volatile("dsb");
}

static void say(const char *name, const char *what, uint32_t value, uint32_t manual)
{
    put_text(name);
    expect(what, value, manual);
}

static uint32_t wait_for(uint32_t flag)
{
    for (uint32_t n = 0; n < PATIENCE; n++) {
        if (R(SR) & flag)
            return 1;
    }
    return 0;
}

static void check(const char *name, uint32_t base, uint32_t most, unsigned irq)
{
    uint32_t before, after;
    timer = base;
    on(IRQ(irq), update);
    say(name, "_cr1_reset", R(CR1), 0);
    say(name, "_dier_reset", R(DIER), 0);
    say(name, "_sr_reset", R(SR), 0);
    say(name, "_psc_reset", R(PSC), 0);
    say(name, "_cnt_reset", R(CNT), 0);
    say(name, "_arr_reset", R(ARR), most);
    R(PSC) = 15;
    say(name, "_psc_reads_back", R(PSC), 15);
    R(ARR) = 0x12345678u;
    say(name, "_arr_width", R(ARR), 0x12345678u & most);
    for (uint32_t i = 0; i < 4; i++)
        R(CCR1 + 4 * i) = 0x87654321u + i;
    say(name, "_ccr1_width", R(CCR1), 0x87654321u & most);
    say(name, "_ccr4_width", R(CCR1 + 12), 0x87654324u & most);
    R(EGR) = 1; /* UG */
    say(name, "_ug_sets_uif", R(SR) & 1u, 1);
    say(name, "_egr_reads_0", R(EGR), 0);
    R(SR) = 0xffffffffu;
    say(name, "_sr_writing_1_keeps", R(SR) & 1u, 1);
    R(SR) = ~1u;
    say(name, "_sr_writing_0_clears", R(SR) & 1u, 0);
    R(CR1) = 2; /* UDIS */
    R(EGR) = 1;
    say(name, "_udis_no_uif", R(SR) & 1u, 0);
    R(CR1) = 4; /* URS: only overflow sets the flag */
    R(EGR) = 1;
    say(name, "_urs_no_uif", R(SR) & 1u, 0);
    R(CR1) = 0;
    R(PSC) = 0;
    R(ARR) = 999;
    R(EGR) = 1;
    R(SR) = 0;
    R(CNT) = 500;
    say(name, "_cnt_reads_back", R(CNT), 500);
    R(CNT) = 0;
    R(CR1) = 1; /* CEN */
    say(name, "_overflow_sets_uif", wait_for(1), 1);
    say(name, "_cnt_within_arr", R(CNT) <= 999, 1);
    R(SR) = 0;
    say(name, "_overflows_again", wait_for(1), 1);
    R(CR1) = 0;
    before = R(CNT);
    for (volatile uint32_t i = 0; i < 200; i++)
        ;
    after = R(CNT);
    say(name, "_stopped_stays", after - before, 0);
    R(SR) = 0;
    updates = 0;
    R(DIER) = 1;    /* UIE */
    R(CR1) = 4 | 1; /* URS, CEN */
    R(EGR) = 1;     /* begin at 0, without a flag */
    for (uint32_t n = 0; n < PATIENCE && !(ISPR(irq) & BIT(irq)); n++)
        ;
    say(name, "_pends_in_nvic", ISPR(irq) >> (irq % 32u) & 1u, 1);
    say(name, "_disabled_in_nvic", updates, 0);
    ISER(irq) = BIT(irq);
    for (uint32_t n = 0; n < PATIENCE && updates < 3; n++)
        ;
    say(name, "_interrupts", updates >= 3, 1);
    ICER(irq) = BIT(irq);
    R(CR1) = 8 | 1; /* OPM: stops at the next update */
    R(SR) = 0;
    R(DIER) = 0;
    wait_for(1);
    say(name, "_one_pulse_stops", R(CR1) & 1u, 0);
    R(SR) = 0;
    R(CCR1) = 200;
    R(CNT) = 0;
    R(CR1) = 1;
    say(name, "_compare_sets_cc1if", wait_for(2), 1);
    R(CR1) = 0;
}

int main(void)
{
    RCC_APB1ENR = 1u << 0 | 1u << 2;
    (void)RCC_APB1ENR;
    check("tim2", TIM2, 0xffffffffu, 28);
    check("tim4", TIM4, 0xffffu, 30);
    return 0;
}
