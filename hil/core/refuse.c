#include "hil/core/refuse.h"

#include "hil/core/core.h"
#include "hil/core/locate.h"

void hil_bus_stop(struct hil_core *core, const char *why, const char *what)
{
    struct hil_access current = core->bus.access;
    const struct hil_peripheral *p = hil_peripheral_at(&core->bus, current.address);
    unsigned pc = (unsigned)hil_cpu_access_pc(core, current.address, current.write);
    char place[32] = "";
    if (p)
        snprintf(place, sizeof place, " (%s + 0x%x)", p->name,
                 (unsigned)(current.address - p->base));
    hil_core_stop(core, MR_UNMODELLED, "%s %s of %u bytes at 0x%08x%s, PC 0x%08x%s%s", why,
                  current.write ? "write" : "read", current.size, (unsigned)current.address, place,
                  pc, what ? ": " : "", what ? what : "");
}

uint32_t hil_bus_refuse(struct hil_core *core, const char *what)
{
    hil_bus_stop(core, "unmodelled", what);
    return 0;
}

uint32_t hil_bus_no_register(struct hil_core *core)
{
    hil_bus_stop(core, "unmodelled", NULL);
    return 0;
}
