#include "hil/core/event.h"

#include "hil/core/core.h"

static void target_event(void *device, uint64_t at)
{
    struct hil_core *core = device;
    (void)at;
    core->target_reached = true;
}

void hil_event_wire(struct hil_core *core, enum hil_event_slot slot,
                    void (*handler)(void *device, uint64_t at), void *device)
{
    core->handler[slot] = (struct hil_event_wire){handler, device};
}

static void init(struct hil_events *events)
{
    for (unsigned i = 0; i < HIL_EVENT_SLOTS; i++) {
        events->at_cycle[i] = HIL_NEVER;
        events->at_ps[i] = HIL_NEVER;
    }
    events->next_cycle = HIL_NEVER;
}

void hil_event_create(struct hil_core *core)
{
    init(&core->state.events);
    hil_event_wire(core, HIL_EVENT_TARGET, target_event, core);
}

/* Least of the times with their slots below them, so that of those at the same time the first slot
 * wins; in chains that do not wait for one another. */
#define SLOT_BITS 5u
_Static_assert(HIL_EVENT_SLOTS <= 1u << SLOT_BITS, "slots in their bits");

static void find_next(struct hil_core *core)
{
    struct hil_events *events = &core->state.events;
    uint64_t least[HIL_EVENT_CHAINS] = {HIL_NEVER, HIL_NEVER, HIL_NEVER, HIL_NEVER};
#pragma GCC unroll 28
    for (unsigned i = 0; i < HIL_EVENT_SLOTS; i++) {
        /* cycles of a hundred years take 59 bits */
        uint64_t key = events->at_cycle[i] << SLOT_BITS | i;
        least[i % HIL_EVENT_CHAINS] = key < least[i % HIL_EVENT_CHAINS]
                                        ? key
                                        : least[i % HIL_EVENT_CHAINS];
    }
    least[0] = least[1] < least[0] ? least[1] : least[0];
    least[2] = least[3] < least[2] ? least[3] : least[2];
    unsigned slot = (unsigned)((least[2] < least[0] ? least[2] : least[0]) &
                               ((1u << SLOT_BITS) - 1u));
    uint64_t next = events->at_cycle[slot];
    events->next_cycle = next;
    events->next_slot = slot;
    if (next < core->limit_cycle)
        core->limit_cycle = next;
}

static void set(struct hil_core *core, enum hil_event_slot slot, uint64_t cycle, uint64_t t_ps)
{
    struct hil_events *events = &core->state.events;
    uint64_t before = events->at_cycle[slot];
    events->at_cycle[slot] = cycle;
    events->at_ps[slot] = t_ps;
    if (before == events->next_cycle && cycle > before) { /* it may have been the earliest */
        find_next(core);
    } else if (cycle < events->next_cycle ||
               (cycle == events->next_cycle && slot < events->next_slot)) {
        events->next_cycle = cycle;
        events->next_slot = slot;
    }
    if (events->next_cycle < core->limit_cycle)
        core->limit_cycle = events->next_cycle;
}

void hil_event_set_cycle(struct hil_core *core, enum hil_event_slot slot, uint64_t cycle)
{
    set(core, slot, cycle, HIL_NEVER);
}

void hil_event_set_ps(struct hil_core *core, enum hil_event_slot slot, uint64_t t_ps)
{
    set(core, slot, hil_clock_cycle(&core->state.clock, t_ps), t_ps);
}

/* Convert the slots that are in picoseconds again, after a change of HCLK. */
static void rebase(struct hil_core *core)
{
    struct hil_events *events = &core->state.events;
    for (unsigned i = 0; i < HIL_EVENT_SLOTS; i++) {
        if (events->at_ps[i] != HIL_NEVER)
            events->at_cycle[i] = hil_clock_cycle(&core->state.clock, events->at_ps[i]);
    }
    find_next(core);
}

void hil_event_run(struct hil_core *core)
{
    struct hil_events *events = &core->state.events;
    const struct hil_onlookers *lookers = &core->onlookers;
    while (events->next_cycle <= core->state.clock.now_cycle && !core->target_reached) {
        unsigned slot = events->next_slot;
        uint64_t at = events->at_cycle[slot];
        events->at_cycle[slot] = HIL_NEVER;
        events->at_ps[slot] = HIL_NEVER;
        events->next_cycle = HIL_NEVER; /* until the handler has set what it sets */
        core->handler[slot].handler(core->handler[slot].device, at);
        /* where a run is cut changes nothing, and shows nowhere */
        if (lookers->tracer && slot != HIL_EVENT_TARGET)
            lookers->tracer->sample(lookers->tracer_who, at);
        find_next(core);
    }
}

/* --- changes of HCLK --- */

void hil_hclk_change(struct hil_core *core, uint32_t hclk_hz)
{
    struct hil_clock *clock = &core->state.clock;
    if (hclk_hz == clock->hclk_hz)
        return;
    hil_clock_turn(clock, hclk_hz);
    rebase(core);
    hil_trace(core, "HCLK %u Hz", (unsigned)hclk_hz);
}

void hil_hclk_stand_still(struct hil_core *core)
{
    struct hil_clock *clock = &core->state.clock;
    struct hil_events *events = &core->state.events;
    uint64_t next_ps = HIL_NEVER; /* the end of the run is always there */
    for (unsigned i = 0; i < HIL_EVENT_SLOTS; i++) {
        if (events->at_ps[i] < next_ps)
            next_ps = events->at_ps[i];
    }
    uint64_t now_ps = hil_clock_ps(clock, clock->now_cycle);
    clock->anchor_ps = next_ps > now_ps ? next_ps : now_ps;
    clock->anchor_cycle = clock->now_cycle;
    rebase(core);
}
