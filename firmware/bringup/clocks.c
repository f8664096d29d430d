/* Clocks against each other. The crystal is compared with the internal oscillator at start
 * (clock.c), the internal low-speed one by the watchdog (falls.c). Here: the core's cycles, SysTick
 * and the timers, which must be whole multiples; where the timers stand to each other; where in the
 * scan the converters are. RM0090 18.3.15 (TIM4 starts TIM2), 13.8 (DMA). */
#include "common/boardtime.h"
#include "firmware/bringup/bringup.h"
#include "firmware/bringup/say.h"
#include "firmware/f407/drivers.h"

#define INTERNAL_KHZ 16000u
#define CRYSTAL_KHZ  8000u
#define SPAN_US      5000u /* shorter than SysTick's 10 ms */
#define SCAN_TICKS   10500u
#define WAIT_US      1000u
#define BLOCK_US     100000u /* for one to come */
#define ADC1_STREAM  4u

static void say_crystal(void)
{
    uint32_t khz = clock_crystal_khz();
    if (!khz) {
        say_none("crystal", "kHz");
        say_none("internal", "kHz");
        return;
    }
    /* each by the other, as if that were right */
    say_number("crystal", (int32_t)khz, "kHz");
    say_number("internal", (int32_t)(INTERNAL_KHZ * CRYSTAL_KHZ / khz), "kHz");
}

static uint32_t systick_since(uint32_t value)
{
    uint32_t now = SYST_CVR;
    return value >= now ? value - now : value + SYST_RVR + 1u - now;
}

static void say_rates(void)
{
    uint32_t mask = irq_mask();
    uint32_t tick = TIM2->CNT, systick = SYST_CVR, begun = pace_begin();
    pace_wait(SPAN_US);
    uint32_t ticks = TIM2->CNT - tick, systicks = systick_since(systick),
             cycles = pace_cycles(begun);
    irq_restore(mask);
    if (ticks == 0) {
        say_none("cycles_per_tick", "ratio");
        say_none("systick_per_tick", "ratio");
        return;
    }
    say_milli("cycles_per_tick", (int32_t)((uint64_t)cycles * 1000u / ticks), "ratio");
    say_milli("systick_per_tick", (int32_t)((uint64_t)systicks * 1000u / ticks), "ratio");
}

/* One that has just come: what has waited is left out. */
static bool take_newest_block(struct mr_block *block)
{
    uint32_t begun = pace_begin();
    while (board_block_take(block)) {
    }
    while (!board_block_take(block)) {
        if (pace_passed(begun, BLOCK_US))
            return false;
    }
    return true;
}

/* TIM2 minus TIM4 within a scan: TIM2 is read between two looks at TIM4. It wraps after 51 s, and
 * that is no whole number of scans: its ticks since the start are told by a block. */
static void say_timers(void)
{
    struct mr_block block;
    bool come = take_newest_block(&block);
    uint32_t mask = irq_mask();
    uint32_t before = TIM4->CNT, between = TIM2->CNT, after = TIM4->CNT;
    irq_restore(mask);
    if (!come || between == 0) {
        say_none("timer_offset", "ticks");
        return;
    }
    uint32_t width = (after + SCAN_TICKS - before) % SCAN_TICKS;
    uint32_t middle = (before + width / 2u) % SCAN_TICKS;
    uint64_t ticks = (uint64_t)mr_boardtime_ticks(0, block.index, between);
    int32_t offset = (int32_t)((ticks + SCAN_TICKS - middle) % SCAN_TICKS);
    say_number("timer_offset",
               offset > (int32_t)SCAN_TICKS / 2 ? offset - (int32_t)SCAN_TICKS : offset, "ticks");
}

/* TIM4's count when the stream of converter 1 has moved on. */
static bool wait_for_conversion(uint32_t *tick)
{
    uint32_t begun = pace_begin(), left = DMA2->stream[ADC1_STREAM].NDTR;
    while (DMA2->stream[ADC1_STREAM].NDTR == left) {
        if (pace_passed(begun, WAIT_US))
            return false;
    }
    *tick = TIM4->CNT;
    return true;
}

static void say_conversions(void)
{
    uint32_t first = SCAN_TICKS, last = 0, tick;
    uint32_t mask = irq_mask();
    bool come = true;
    for (unsigned n = 0; come && n < 32; n++) {
        come = wait_for_conversion(&tick);
        if (n == 0)
            continue; /* may have been late */
        first = come && tick < first ? tick : first;
        last = come && tick > last ? tick : last;
    }
    irq_restore(mask);
    if (!come) {
        say_none("conversion_first", "ticks");
        say_none("conversion_last", "ticks");
        return;
    }
    say_number("conversion_first", (int32_t)first, "ticks");
    say_number("conversion_last", (int32_t)last, "ticks");
}

void bringup_clocks(void)
{
    say_crystal();
    say_rates();
    say_timers();
    say_conversions();
}
