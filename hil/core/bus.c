#include "hil/core/bus.h"

#include <stdlib.h>

#include "hil/core/core.h"
#include "hil/core/nvic.h"

void hil_bus_attach(struct hil_core *core, const struct hil_peripheral *peripheral)
{
    struct hil_bus *bus = &core->bus;
    if (bus->peripheral_count == HIL_PERIPHERALS_MAX || !hil_registers_by_base(peripheral->base))
        abort();
    bus->page_peripheral[(peripheral->base - 0x40000000u) >> 10] = (uint8_t)bus->peripheral_count;
    bus->peripheral_registers[bus->peripheral_count] = hil_registers_by_base(peripheral->base);
    bus->peripheral[bus->peripheral_count++] = *peripheral;
}

static bool is_access_allowed(struct hil_core *core, const struct hil_register *r, bool write,
                              uint32_t value)
{
    if (!r) {
        hil_bus_refuse_register(core);
        return false;
    }
    const char *objection = write ? hil_register_refusal(r, value) : NULL;
    if (!objection)
        return true;
    hil_bus_refuse(core, objection);
    return false;
}

/* True if the table of registers permits the access. */
static bool is_access_modelled(struct hil_core *core, const struct hil_peripheral *p,
                               uint32_t offset, bool write, uint32_t value)
{
    const struct hil_register **r =
        &core->bus.register_at[p - core->bus.peripheral][offset / 4u % HIL_REGISTER_WORDS];
    if (!*r)
        *r = hil_register_at(core->bus.peripheral_registers[p - core->bus.peripheral], offset);
    return is_access_allowed(core, *r, write, value);
}

static bool is_core_access_modelled(struct hil_core *core, uint32_t offset, bool write,
                                    uint32_t value)
{
    return is_access_allowed(core, hil_register_at(hil_registers_by_base(0xe000e000u), offset),
                             write, value);
}

static uint32_t get_addressed_bytes(uint32_t value, uint32_t address, unsigned size)
{
    value >>= 8u * (address & 3u);
    return size == 1 ? value & 0xffu : size == 2 ? value & 0xffffu : value;
}

static bool is_clock_on(struct hil_core *core, const struct hil_peripheral *p)
{
    const struct hil_new_clocks *fresh = &core->bus.new_clocks;
    if (fresh->clock_enables && fresh->clock_enables == p->clock_enables &&
        (fresh->clock_mask & p->clock_mask))
        fresh->on_first_access(fresh->context);
    if (!p->clock_enables || (*p->clock_enables & p->clock_mask))
        return true;
    hil_bus_stop(core, "clock of the peripheral is off:", NULL);
    return false;
}

uint32_t hil_bus_read_mask(const struct hil_core *core)
{
    const struct hil_access *access = &core->bus.access;
    return get_addressed_bytes(UINT32_MAX, 0, access->size) << (8u * (access->address & 3u));
}

uint32_t hil_bus_read(struct hil_core *core, uint32_t address, unsigned size)
{
    core->bus.access = (struct hil_access){address, size, false};
    if (address - 0x40000000u < 0x00080000u) {
        const struct hil_peripheral *p = hil_peripheral_at(&core->bus, address);
        if (!p)
            return hil_bus_refuse_register(core);
        if (!is_clock_on(core, p) ||
            !is_access_modelled(core, p, (address - p->base) & ~3u, false, 0))
            return 0;
        return get_addressed_bytes(p->read(p->device, p->unit, (address - p->base) & ~3u), address,
                                   size);
    }
    if ((address & ~0xfffu) == 0xe000e000u &&
        !is_core_access_modelled(core, address & 0xffcu, false, 0))
        return 0;
    if (address - 0xe0000000u < 0x00100000u)
        return hil_scb_read(core, address, size);
    if (address - 0x1fff0000u < 0x00010000u)
        return core->bus.system_memory.read
                 ? get_addressed_bytes(
                       core->bus.system_memory.read(core->bus.system_memory.device, address),
                       address, size)
                 : hil_bus_refuse_register(core);
    return hil_bus_refuse_register(core);
}

void hil_bus_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value)
{
    core->bus.access = (struct hil_access){address, size, true};
    if (address - 0x40000000u < 0x00080000u) {
        const struct hil_peripheral *p = hil_peripheral_at(&core->bus, address);
        if (!p) {
            hil_bus_refuse_register(core);
            return;
        }
        if (!is_clock_on(core, p))
            return;
        uint32_t offset = address - p->base;
        if (size == 4 && !(offset & 3u)) {
            if (!is_access_modelled(core, p, offset, true, value))
                return;
            p->write(p->device, p->unit, offset, value);
            return;
        }
        if (!p->allows_narrow_writes) {
            hil_bus_refuse(core, "a write that is not a word is not modelled for this register");
            return;
        }
        uint32_t mask = (size == 1 ? 0xffu : 0xffffu) << (8u * (offset & 3u));
        uint32_t shifted = value << (8u * (offset & 3u)) & mask;
        uint32_t rest =
            (p->unchanged_bits ? p->unchanged_bits(p->device, p->unit, offset & ~3u) : 0) & ~mask;
        if (!is_access_modelled(core, p, offset & ~3u, true, rest | shifted))
            return;
        p->write(p->device, p->unit, offset & ~3u, rest | shifted);
        return;
    }
    if ((address & ~0xfffu) == 0xe000e000u && size == 4 && !(address & 3u) &&
        !is_core_access_modelled(core, address & 0xffcu, true, value))
        return;
    if (address - 0xe0000000u < 0x00100000u) {
        hil_scb_write(core, address, size, value);
        return;
    }
    hil_bus_refuse_register(core);
}
