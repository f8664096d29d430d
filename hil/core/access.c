#include "hil/core/access.h"

#include "hil/core/core.h"
#include "hil/core/registers.h"

unsigned hil_instructions_between(const struct hil_core *core, uint32_t from, uint32_t to)
{
    const uint8_t *code = from < to ? hil_memory_at(core, from, to - from, false) : NULL;
    unsigned n = 0;
    for (uint32_t i = 0; code && i < to - from; n++)
        i += code[i + 1] >= 0xe8u ? 4 : 2; /* ARMv7-M A5.1 */
    return n;
}

uint32_t hil_access_pc(const struct hil_core *core)
{
    struct hil_place place;
    return hil_translator_place(&core->engine.translator, core->bus.access.address, &place)
             ? place.pc
             : hil_cpu_register(core, 15) & ~1u;
}

/* ARMv7-M A7.3 */
bool hil_condition_holds(uint32_t xpsr, unsigned condition)
{
    bool n = xpsr >> 31 & 1u, z = xpsr >> 30 & 1u, c = xpsr >> 29 & 1u, v = xpsr >> 28 & 1u;
    const bool holds[8] = {z, c, n, v, c && !z, n == v, n == v && !z, true};
    return condition >= 14 || holds[condition / 2] != (condition & 1u);
}

/* Encodings: ARMv7-M A5.2 and A5.3. Offsets are whole words: the base tells. */
bool hil_transfer_is_unaligned(const struct hil_core *core, uint32_t pc)
{
    const uint8_t *code = hil_memory_at(core, pc, 4, false);
    if (!code)
        return false;
    uint16_t first = (uint16_t)(code[0] | code[1] << 8),
             second = (uint16_t)(code[2] | code[3] << 8);
    if ((first & 0xf000u) == 0xc000u) /* STM, LDM */
        return (hil_cpu_register(core, first >> 8 & 7u) & 3u) != 0;
    bool fp = (second >> 8 & 0xeu) == 0xau;
    bool multiple = (first & 0xfe40u) == 0xe800u ||                /* LDM, STM */
                    ((first & 0xfe40u) == 0xe840u &&               /* double; word */
                     ((first & 0x0120u) || !(first & 0x0080u))) || /* exclusives */
                    (fp && (first & 0xfe00u) == 0xec00u && (first & 0x01e0u) != 0x0040u) ||
                    (fp && (first & 0xff20u) == 0xed00u);
    unsigned base = first & 15u;
    return multiple && base != 13 && base != 15 && (hil_cpu_register(core, base) & 3u);
}

/* --- when --- */

struct hil_moment hil_stamp_at(const struct hil_core *core, uint64_t cycle)
{
    return (struct hil_moment){.ps = hil_clock_ps(&core->state.clock, cycle)};
}

struct hil_moment hil_stamp(const struct hil_core *core)
{
    struct hil_place place;
    if (!hil_translator_place(&core->engine.translator, core->bus.access.address, &place) ||
        !hil_memory_at(core, place.pc, 2, false)) /* the boot ROM's: its length is not known */
        return (struct hil_moment){0};
    uint64_t cycle = hil_now(core) +
                     hil_instructions_between(core, core->state.cpu.block_address, place.pc);
    return (struct hil_moment){.ps = hil_clock_ps(&core->state.clock, cycle), .pc = place.pc};
}

/* --- refusals --- */

void hil_bus_stop(struct hil_core *core, const char *why, const char *what)
{
    struct hil_access current = core->bus.access;
    const struct hil_peripheral *p = hil_peripheral_at(&core->bus, current.address);
    unsigned pc = (unsigned)hil_access_pc(core);
    char place[32] = "";
    if (p)
        snprintf(place, sizeof place, " (%s + 0x%x)",
                 core->bus.registers_of[p - core->bus.peripheral]->peripheral,
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
