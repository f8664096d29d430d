#include "hil/core/stamp.h"

#include "hil/core/core.h"
#include "hil/core/locate.h"

struct hil_moment hil_stamp_at(const struct hil_core *core, uint64_t cycle)
{
    return (struct hil_moment){.ps = hil_clock_ps(&core->state.clock, cycle)};
}

static struct hil_moment moment_of(const struct hil_core *core, const struct hil_stamped *stamped)
{
    return (struct hil_moment){
        .ps = hil_clock_ps(&core->state.clock, stamped->cycle + stamped->before),
        .pc = stamped->pc};
}

struct hil_moment hil_stamp(struct hil_core *core)
{
    struct hil_stamped *last = &core->engine.stamped;
    uint32_t block = core->state.cpu.block_address;
    uint64_t now = hil_now(core);
    struct hil_place place;
    const struct hil_access access = core->bus.access;
    if (last->block != block || last->cycle != now)
        *last = (struct hil_stamped){.block = block, .cycle = now};
    bool same = last->pc && last->address == access.address && last->write == access.write;
    if (same && last->issue == core->bus.issues) /* it is asked for a second time */
        return moment_of(core, last);
    /* one instruction makes several accesses at most to several addresses */
    bool other = last->pc && !same;
    if (!hil_cpu_access_place(core, core->bus.issued, access.write, last->pc - other, &place))
        return (struct hil_moment){0};
    *last = (struct hil_stamped){.block = block,
                                 .cycle = now,
                                 .address = access.address,
                                 .write = access.write,
                                 .pc = place.pc,
                                 .issue = core->bus.issues,
                                 .before = place.before};
    return moment_of(core, last);
}
