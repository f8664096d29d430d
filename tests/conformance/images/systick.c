/* SysTick (PM0214 4.5): registers, counting, the flag that reading clears, the interrupt. No times
 * are measured: waits are bounded and only what happened counts. */
#include "bench.h"

#define CTRL      WORD(0xe000e010u)
#define LOAD      WORD(0xe000e014u)
#define VALUE     WORD(0xe000e018u)
#define CALIB     WORD(0xe000e01cu)
#define ENABLE    1u
#define TICKINT   2u
#define CLKSOURCE 4u
#define COUNTFLAG 0x10000u
#define PATIENCE  5000000u

static volatile uint32_t ticks;

static void tick(void)
{
    ticks++;
}

static uint32_t wait_for_flag(void)
{
    for (uint32_t n = 0; n < PATIENCE; n++) {
        if (CTRL & COUNTFLAG)
            return 1;
    }
    return 0;
}

static uint32_t wait_for_ticks(uint32_t count)
{
    for (uint32_t n = 0; n < PATIENCE && ticks < count; n++)
        ;
    return ticks >= count;
}

int main(void)
{
    uint32_t before, after = 0;
    on(15, tick);
    expect("ctrl_reset", CTRL & ~CLKSOURCE, 0);
    LOAD = 0xffffffffu;
    expect("load_24_bits", LOAD, 0x00ffffffu);
    VALUE = 0x1234;
    expect("value_write_clears", VALUE, 0);
    CTRL = CLKSOURCE;
    expect("ctrl_reads_back", CTRL, CLKSOURCE);
    LOAD = 199999;
    VALUE = 0;
    CTRL = CLKSOURCE | ENABLE;
    expect("counts_to_0", wait_for_flag(), 1);
    expect("flag_cleared_by_reading", CTRL & COUNTFLAG, 0);
    expect("reloads", wait_for_flag(), 1);
    expect("value_within_load", VALUE <= 199999, 1);
    before = VALUE;
    for (uint32_t n = 0; n < PATIENCE; n++) {
        after = VALUE;
        if (after != before)
            break;
    }
    expect("counts", before != after, 1);
    expect("no_interrupt_without_tickint", ticks, 0);
    wait_for_flag();
    wait_for_flag();
    VALUE = 0; /* clears the flag too (PM0214 4.5.3) */
    expect("write_clears_flag", CTRL & COUNTFLAG, 0);
    CTRL = 0;
    LOAD = 0x00ffffff;
    VALUE = 0;
    CTRL = CLKSOURCE | TICKINT | ENABLE;
    expect("no_interrupt_at_start", ticks, 0);
    CTRL = 0;
    LOAD = 15999;
    VALUE = 0;
    CTRL = CLKSOURCE | TICKINT | ENABLE;
    expect("interrupts", wait_for_ticks(3), 1);
    __asm__ volatile("cpsid i");
    for (uint32_t n = 0; n < PATIENCE && !(ICSR & 1u << 26); n++)
        ;
    expect("pends_while_masked", ICSR >> 26 & 1u, 1);
    CTRL = 0;
    before = ticks;
    __asm__ volatile("cpsie i\n\tisb");
    expect("runs_once_when_unmasked", ticks - before, 1);
    expect("stopped_ctrl", CTRL & 7u, 0);
    before = VALUE;
    for (volatile uint32_t i = 0; i < 200; i++)
        ;
    expect("stopped_value_stays", VALUE - before, 0);
    ICSR = 1u << 25; /* PENDSTCLR */
    return 0;
}
