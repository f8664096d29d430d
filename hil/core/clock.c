#include "hil/core/clock.h"

#include "hil/core/time.h"

__extension__ typedef unsigned __int128 wide;

static void set_hz(struct hil_clock *clock, uint32_t hclk_hz)
{
    uint64_t a = HIL_SECOND_PS, b = hclk_hz;
    while (b) { /* Euclid */
        uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    clock->hclk_hz = clock->ratio_hz = hclk_hz;
    clock->ratio_ps = HIL_SECOND_PS / a;
    clock->ratio_cycles = hclk_hz / a;
}

void hil_clock_start(struct hil_clock *clock, uint32_t hclk_hz)
{
    *clock = (struct hil_clock){0};
    set_hz(clock, hclk_hz);
}

uint64_t hil_clock_ps(const struct hil_clock *clock, uint64_t cycle)
{
    if (cycle < clock->anchor_cycle) /* only ever a moment before: at the rate of now */
        return clock->anchor_ps -
               (uint64_t)((wide)(clock->anchor_cycle - cycle) * HIL_SECOND_PS / clock->hclk_hz);
    uint64_t cycles = cycle - clock->anchor_cycle, product;
    /* 64 bits are enough for days at any ordinary rate, and four times faster */
    if (clock->ratio_hz == clock->hclk_hz &&
        !__builtin_mul_overflow(cycles, clock->ratio_ps, &product))
        return clock->anchor_ps + product / clock->ratio_cycles;
    wide ps = (wide)(cycle - clock->anchor_cycle) * HIL_SECOND_PS / clock->hclk_hz;
    return clock->anchor_ps + (uint64_t)ps;
}

uint64_t hil_clock_cycle(const struct hil_clock *clock, uint64_t t_ps)
{
    if (t_ps == HIL_NEVER)
        return HIL_NEVER;
    if (t_ps <= clock->anchor_ps)
        return clock->anchor_cycle;
    uint64_t product;
    if (clock->ratio_hz == clock->hclk_hz &&
        !__builtin_mul_overflow(t_ps - clock->anchor_ps, clock->ratio_cycles, &product) &&
        !__builtin_add_overflow(product, clock->ratio_ps - 1u, &product))
        return clock->anchor_cycle + product / clock->ratio_ps;
    wide cycles = ((wide)(t_ps - clock->anchor_ps) * clock->hclk_hz + (HIL_SECOND_PS - 1)) /
                  HIL_SECOND_PS;
    return clock->anchor_cycle + (uint64_t)cycles;
}

void hil_clock_turn(struct hil_clock *clock, uint32_t hclk_hz)
{
    clock->anchor_ps = hil_clock_ps(clock, clock->now_cycle);
    clock->anchor_cycle = clock->now_cycle;
    set_hz(clock, hclk_hz);
}
