#include "hil/core/systick.h"

#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/core/nvic.h"

#define ENABLE    1u
#define TICKINT   2u
#define CLKSOURCE 4u /* 1: HCLK, 0: HCLK / 8 */
#define COUNTFLAG (1u << 16)

static uint32_t divider(const struct hil_systick *s)
{
    return (s->ctrl & CLKSOURCE) ? 1 : 8;
}

static uint32_t current(const struct hil_core *core)
{
    const struct hil_systick *s = &core->state.systick;
    if (!(s->ctrl & ENABLE) || s->zero_cycle == HIL_NEVER)
        return s->value;
    uint64_t now = hil_now(core);
    uint64_t left = s->zero_cycle > now ? (s->zero_cycle - now + divider(s) - 1) / divider(s) : 0;
    return (uint32_t)left;
}

/* The counter is at `value` now and runs: when is it 0? From 0 it reloads first. */
static void schedule(struct hil_core *core, uint32_t value)
{
    struct hil_systick *s = &core->state.systick;
    uint64_t ticks = value ? value : s->load ? (uint64_t)s->load + 1u : 0;
    s->zero_cycle = ticks ? hil_now(core) + ticks * divider(s) : HIL_NEVER;
    s->value = value;
    hil_event_set_cycle(core, HIL_EVENT_SYSTICK, s->zero_cycle);
}

static void on_zero(void *device, uint64_t at)
{
    struct hil_core *core = device;
    struct hil_systick *s = &core->state.systick;
    s->ctrl |= COUNTFLAG;
    if (s->ctrl & TICKINT)
        hil_nvic_pend(core, HIL_EXC_SYSTICK);
    s->value = 0;
    s->zero_cycle = s->load ? at + ((uint64_t)s->load + 1u) * divider(s) : HIL_NEVER;
    hil_event_set_cycle(core, HIL_EVENT_SYSTICK, s->zero_cycle);
}

void hil_systick_create(struct hil_core *core)
{
    hil_event_wire(core, HIL_EVENT_SYSTICK, on_zero, core);
}

void hil_systick_reset(struct hil_core *core)
{
    core->state.systick = (struct hil_systick){.zero_cycle = HIL_NEVER};
    hil_event_set_cycle(core, HIL_EVENT_SYSTICK, HIL_NEVER);
}

uint32_t hil_systick_read(struct hil_core *core, uint32_t offset)
{
    struct hil_systick *s = &core->state.systick;
    uint32_t value;
    switch (offset) {
    case 0x10:
        value = s->ctrl;
        s->ctrl &= ~COUNTFLAG;
        return value;
    case 0x14: return s->load;
    case 0x18: return current(core);
    default: /* CALIB: 18750, skewed */ return 0x4000493e;
    }
}

void hil_systick_write(struct hil_core *core, uint32_t offset, uint32_t value)
{
    struct hil_systick *s = &core->state.systick;
    uint32_t count = current(core);
    switch (offset) {
    case 0x10:
        s->ctrl = (s->ctrl & COUNTFLAG) | (value & (ENABLE | TICKINT | CLKSOURCE));
        s->value = count;
        if (s->ctrl & ENABLE)
            schedule(core, count);
        else
            hil_event_set_cycle(core, HIL_EVENT_SYSTICK, HIL_NEVER);
        break;
    case 0x14: s->load = value & 0xffffffu; break;
    case 0x18: /* any write clears counter and flag, without an interrupt */
        s->ctrl &= ~COUNTFLAG;
        s->value = 0;
        if (s->ctrl & ENABLE)
            schedule(core, 0);
        break;
    default: /* CALIB is read-only */ break;
    }
}
