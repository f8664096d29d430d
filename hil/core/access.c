/* Which instruction of a basic block makes a given access.
 *
 * Unicorn reports the block, not the instruction. The registers, however, are those at the
 * instruction, so the one whose effective address is the reported one is it. Encodings: ARMv7-M
 * A5.2 and A5.3. */
#include "hil/core/access.h"

#include "hil/core/core.h"
#include "hil/core/registers.h"

struct access {
    uint32_t low;  /* first byte touched */
    uint32_t high; /* last */
    bool write;
    bool any; /* the instruction accesses memory at all */
};

static uint32_t reg(const struct hil_core *core, unsigned n)
{
    return hil_cpu_register(core, n);
}

static struct access one(uint32_t address, uint32_t bytes, bool write)
{
    return (struct access){address, address + bytes - 1u, write, true};
}

static struct access decode16(const struct hil_core *core, uint32_t pc, uint16_t op)
{
    const struct access none = {0};
    unsigned rn = op >> 3 & 7u;
    if ((op & 0xf800u) == 0x4800u) /* LDR literal */
        return one(((pc + 4u) & ~3u) + 4u * (op & 0xffu), 4, false);
    if ((op & 0xf000u) == 0x5000u) { /* register offset */
        static const uint8_t bytes[8] = {4, 2, 1, 1, 4, 2, 1, 2};
        unsigned kind = op >> 9 & 7u;
        return one(reg(core, rn) + reg(core, op >> 6 & 7u), bytes[kind], kind < 3);
    }
    if ((op & 0xe000u) == 0x6000u) { /* word or byte, immediate */
        uint32_t bytes = (op & 0x1000u) ? 1 : 4;
        return one(reg(core, rn) + bytes * (op >> 6 & 31u), bytes, !(op & 0x0800u));
    }
    if ((op & 0xf000u) == 0x8000u) /* halfword, immediate */
        return one(reg(core, rn) + 2u * (op >> 6 & 31u), 2, !(op & 0x0800u));
    if ((op & 0xf000u) == 0x9000u) /* SP relative */
        return one(reg(core, 13) + 4u * (op & 0xffu), 4, !(op & 0x0800u));
    if ((op & 0xfe00u) == 0xb400u) { /* PUSH */
        uint32_t bytes = 4u * (uint32_t)__builtin_popcount(op & 0x1ffu);
        return one(reg(core, 13) - bytes, bytes ? bytes : 4, true);
    }
    if ((op & 0xfe00u) == 0xbc00u) /* POP */
        return one(reg(core, 13), 4u * (uint32_t)__builtin_popcount(op & 0x1ffu) + 4u, false);
    if ((op & 0xf000u) == 0xc000u) /* STM, LDM */
        return one(reg(core, op >> 8 & 7u), 4u * (uint32_t)__builtin_popcount(op & 0xffu) + 4u,
                   !(op & 0x0800u));
    return none;
}

static struct access decode32(const struct hil_core *core, uint32_t pc, uint16_t a, uint16_t b)
{
    const struct access none = {0};
    unsigned rn = a & 15u;
    bool load = (a & 0x10u) != 0;
    uint32_t base = rn == 15 ? (pc + 4u) & ~3u : reg(core, rn);
    if ((a & 0xfe00u) == 0xf800u) { /* single */
        uint32_t bytes = 1u << (a >> 5 & 3u);
        if (bytes > 4)
            return none;
        if (rn == 15)
            return one((a & 0x80u) ? base + (b & 0xfffu) : base - (b & 0xfffu), bytes, !load);
        if (a & 0x80u)
            return one(base + (b & 0xfffu), bytes, !load);
        if (b & 0x0800u) {
            uint32_t offset = b & 0xffu;
            if (!(b & 0x0400u))
                offset = 0;
            return one((b & 0x0200u) ? base + offset : base - offset, bytes, !load);
        }
        return one(base + (reg(core, b & 15u) << (b >> 4 & 3u)), bytes, !load);
    }
    if ((a & 0xfe40u) == 0xe840u) { /* double, exclusive */
        uint32_t offset = 4u * (b & 0xffu);
        /* byte, halfword exclusives and table branch: no offset */
        if ((a & 0x0120u) == 0 && (a & 0x0080u))
            return one(base, 4, !load);
        if (!(a & 0x0100u) && (a & 0x0020u))
            offset = 0; /* post-indexed */
        return one((a & 0x0080u) || !(a & 0x0100u) ? base + offset : base - offset, 8, !load);
    }
    if ((a & 0xfe40u) == 0xe800u) { /* LDM, STM */
        uint32_t bytes = 4u * (uint32_t)__builtin_popcount(b);
        return one((a & 0x0100u) ? base - bytes : base, bytes ? bytes : 4, !load);
    }
    if ((a & 0xff20u) == 0xed00u) /* VLDR, VSTR */
        return one((a & 0x0080u) ? base + 4u * (b & 0xffu) : base - 4u * (b & 0xffu), 8, !load);
    if ((a & 0xfe00u) == 0xec00u) { /* VLDM, VSTM, VPUSH, VPOP */
        uint32_t bytes = 4u * (b & 0xffu);
        return one((a & 0x0100u) ? base - bytes : base, bytes ? bytes : 4, !load);
    }
    return none;
}

#define XPSR 16u

/* ARMv7-M A7.3 */
static bool condition_holds(const struct hil_core *core, unsigned condition)
{
    uint32_t xpsr = hil_cpu_register(core, XPSR);
    bool n = xpsr >> 31 & 1u, z = xpsr >> 30 & 1u, c = xpsr >> 29 & 1u, v = xpsr >> 28 & 1u;
    const bool holds[8] = {z, c, n, v, c && !z, n == v, n == v && !z, true};
    return condition >= 14 || holds[condition / 2] != (condition & 1u);
}

/* The conditions of an IT instruction are used up one by one. ARMv7-M A7.3.3 */
static unsigned next_it(unsigned it)
{
    return (it & 7u) ? (it & 0xe0u) | (it << 1 & 0x1fu) : 0;
}

static bool accesses(const struct hil_core *core, uint32_t pc, const uint8_t *code, bool wide,
                     uint32_t address, bool write)
{
    uint16_t first = (uint16_t)(code[0] | code[1] << 8);
    struct access access = wide ? decode32(core, pc, first, (uint16_t)(code[2] | code[3] << 8))
                                : decode16(core, pc, first);
    return access.any && access.write == write && address >= access.low && address <= access.high;
}

bool hil_cpu_access_place(const struct hil_core *core, uint32_t address, bool write, uint32_t after,
                          struct hil_place *place)
{
    uint32_t start = core->state.cpu.block_address, size = core->state.cpu.block_size;
    const uint8_t *code = hil_memory_at(core, start, size, false);
    unsigned n = 0, it = 0;
    for (uint32_t i = 0; code && i + 2 <= size; n++) {
        uint16_t first = (uint16_t)(code[i] | code[i + 1] << 8);
        bool wide = first >= 0xe800u && i + 4 <= size;
        if ((first & 0xff00u) == 0xbf00u && (first & 15u)) {
            it = first & 0xffu;
            i += 2;
            continue;
        }
        if (start + i > after && accesses(core, start + i, code + i, wide, address, write) &&
            (!it || condition_holds(core, it >> 4))) {
            *place = (struct hil_place){start + i, n};
            return true;
        }
        it = next_it(it);
        i += wide ? 4 : 2;
    }
    return false;
}

uint32_t hil_cpu_access_pc(const struct hil_core *core, uint32_t address, bool write)
{
    struct hil_place place = {.pc = core->state.cpu.block_address};
    (void)hil_cpu_access_place(core, address, write, 0, &place);
    return place.pc;
}

bool hil_cpu_transfer_address(const struct hil_core *core, uint32_t pc, uint32_t *address)
{
    const uint8_t *code = hil_memory_at(core, pc, 4, false);
    if (!code)
        return false;
    uint16_t first = (uint16_t)(code[0] | code[1] << 8),
             second = (uint16_t)(code[2] | code[3] << 8);
    bool fp = (second >> 8 & 0xeu) == 0xau;
    bool multiple = (first & 0xfe40u) == 0xe800u ||                /* LDM, STM */
                    ((first & 0xfe40u) == 0xe840u &&               /* double; word */
                     ((first & 0x0120u) || !(first & 0x0080u))) || /* exclusives */
                    (fp && (first & 0xfe00u) == 0xec00u && (first & 0x01e0u) != 0x0040u) ||
                    (fp && (first & 0xff20u) == 0xed00u);
    unsigned base = first & 15u;
    struct access access = {0};
    if ((first & 0xf000u) == 0xc000u) /* STM, LDM */
        access = decode16(core, pc, first);
    else if (multiple && base != 13 && base != 15)
        access = decode32(core, pc, first, second);
    *address = access.low;
    return access.any;
}

/* --- when --- */

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
    if (!hil_cpu_access_place(core, access.address, access.write, last->pc - other, &place))
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

/* --- refusals --- */

void hil_bus_stop(struct hil_core *core, const char *why, const char *what)
{
    struct hil_access current = core->bus.access;
    const struct hil_peripheral *p = hil_peripheral_at(&core->bus, current.address);
    unsigned pc = (unsigned)hil_cpu_access_pc(core, current.address, current.write);
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
