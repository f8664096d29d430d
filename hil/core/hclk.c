#include "hil/core/hclk.h"

#include "hil/core/core.h"
#include "hil/core/event.h"

void hil_hclk_change(struct hil_core *core, uint32_t hclk_hz)
{
    struct hil_clock *clock = &core->state.clock;
    if (hclk_hz == clock->hclk_hz)
        return;
    hil_clock_turn(clock, hclk_hz);
    hil_event_rebase(core);
    hil_trace(core, "HCLK %u Hz", (unsigned)hclk_hz);
}

void hil_hclk_stand_still(struct hil_core *core)
{
    struct hil_clock *clock = &core->state.clock;
    struct hil_events *events = &core->state.events;
    uint64_t next_ps = HIL_NEVER; /* the end of the run is always there */
    for (unsigned i = 0; i < HIL_EVENT_COUNT; i++) {
        if (events->at_ps[i] < next_ps)
            next_ps = events->at_ps[i];
    }
    uint64_t now_ps = hil_clock_ps(clock, clock->now_cycle);
    clock->anchor_ps = next_ps > now_ps ? next_ps : now_ps;
    clock->anchor_cycle = clock->now_cycle;
    hil_event_rebase(core);
}
