#include "hil/core/core.h"

#include <stdarg.h>
#include <string.h>

#define CSR_PINRSTF (1u << 26) /* PINRSTF, set by every reset */

void hil_core_stop(struct hil_core *core, enum mr_status status, const char *format, ...)
{
    va_list arguments;
    if (core->is_stopped)
        return;
    core->is_stopped = true;
    core->stop_status = status;
    va_start(arguments, format);
    vsnprintf(core->failure_reason, sizeof core->failure_reason, format, arguments);
    va_end(arguments);
    hil_trace(core, "stop: %s", core->failure_reason);
    hil_core_request_check(core);
    core->engine.translator.is_instruction_abandoned = core->engine.has_left_block =
        hil_translator_can_leave_code(&core->engine.translator);
    if (core->engine.has_left_block)
        uc_emu_stop(core->uc);
}

void hil_core_trace_line(struct hil_core *core, const char *format, ...)
{
    va_list arguments;
    uint64_t t_ns = hil_now_ps(core) / HIL_PS_PER_NS;
    fprintf(core->trace, "%4llu.%09llu ", (unsigned long long)(t_ns / 1000000000u),
            (unsigned long long)(t_ns % 1000000000u));
    va_start(arguments, format);
    vfprintf(core->trace, format, arguments);
    va_end(arguments);
    fputc('\n', core->trace);
}

void hil_core_request_reset(struct hil_core *core, uint32_t flags)
{
    core->reset.is_requested = true;
    core->reset.csr_flags |= flags | CSR_PINRSTF;
    hil_core_request_check(core);
}

enum mr_status hil_memory_peek(const struct hil_core *core, uint32_t address, void *out, size_t n)
{
    const uint8_t *memory = n <= HIL_FLASH_SIZE ? hil_memory_at(core, address, (uint32_t)n, false)
                                                : NULL;
    if (!memory)
        return MR_UNKNOWN;
    memcpy(out, memory, n);
    return MR_OK;
}

uint32_t hil_cpu_register(const struct hil_core *core, unsigned number)
{
    int id = number < 13  ? UC_ARM_REG_R0 + (int)number
           : number == 13 ? UC_ARM_REG_SP
           : number == 14 ? UC_ARM_REG_LR
           : number == 15 ? UC_ARM_REG_PC
           : number == 16 ? UC_ARM_REG_XPSR
                          : UC_ARM_REG_PRIMASK;
    uint32_t value = 0;
    uc_reg_read(core->uc, id, &value);
    return value;
}

/* --- the clock --- */

__extension__ typedef unsigned __int128 uint128;

static void set_clock_hz(struct hil_clock *clock, uint32_t hclk_hz)
{
    uint64_t a = HIL_PS_PER_S, b = hclk_hz;
    while (b) { /* greatest common divisor */
        uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    clock->hclk_hz = clock->ratio_hclk_hz = hclk_hz;
    clock->ratio_ps = HIL_PS_PER_S / a;
    clock->ratio_cycles = hclk_hz / a;
}

void hil_clock_start(struct hil_clock *clock, uint32_t hclk_hz)
{
    *clock = (struct hil_clock){0};
    set_clock_hz(clock, hclk_hz);
}

uint64_t hil_clock_ps_at_cycle(const struct hil_clock *clock, uint64_t cycle)
{
    /* just before a change of HCLK, the new frequency already applies to the last cycles */
    if (cycle < clock->anchor_cycle)
        return clock->anchor_ps -
               (uint64_t)((uint128)(clock->anchor_cycle - cycle) * HIL_PS_PER_S / clock->hclk_hz);
    uint64_t cycles = cycle - clock->anchor_cycle, product;
    /* A product of 64 bits does not overflow for days at common clock rates, and is four times
     * faster than `uint128`. */
    if (clock->ratio_hclk_hz == clock->hclk_hz &&
        !__builtin_mul_overflow(cycles, clock->ratio_ps, &product))
        return clock->anchor_ps + product / clock->ratio_cycles;
    uint128 ps = (uint128)(cycle - clock->anchor_cycle) * HIL_PS_PER_S / clock->hclk_hz;
    return clock->anchor_ps + (uint64_t)ps;
}

uint64_t hil_clock_cycle_at_ps(const struct hil_clock *clock, uint64_t t_ps)
{
    if (t_ps == HIL_NEVER)
        return HIL_NEVER;
    if (t_ps <= clock->anchor_ps)
        return clock->anchor_cycle;
    uint64_t product;
    if (clock->ratio_hclk_hz == clock->hclk_hz &&
        !__builtin_mul_overflow(t_ps - clock->anchor_ps, clock->ratio_cycles, &product) &&
        !__builtin_add_overflow(product, clock->ratio_ps - 1u, &product))
        return clock->anchor_cycle + product / clock->ratio_ps;
    uint128 cycles = ((uint128)(t_ps - clock->anchor_ps) * clock->hclk_hz + (HIL_PS_PER_S - 1)) /
                     HIL_PS_PER_S;
    return clock->anchor_cycle + (uint64_t)cycles;
}

void hil_clock_set_hclk(struct hil_clock *clock, uint32_t hclk_hz)
{
    clock->anchor_ps = hil_clock_ps_at_cycle(clock, clock->now_cycle);
    clock->anchor_cycle = clock->now_cycle;
    set_clock_hz(clock, hclk_hz);
}

/* ---- events ---- */

static void stop_at_target(void *device, uint64_t at)
{
    struct hil_core *core = device;
    (void)at;
    core->has_reached_target = true;
}

void hil_event_connect(struct hil_core *core, enum hil_event_slot slot,
                       void (*handler)(void *device, uint64_t at), void *device)
{
    core->event_handler[slot] = (struct hil_event_handler){handler, device};
}

void hil_core_create(struct hil_core *core)
{
    struct hil_events *events = &core->state.events;
    for (unsigned i = 0; i < HIL_EVENT_SLOTS; i++)
        events->due_cycle[i] = events->due_ps[i] = HIL_NEVER;
    events->next_cycle = HIL_NEVER;
    hil_event_connect(core, HIL_EVENT_RUN_END, stop_at_target, core);
    memset(core->bus.page_peripheral, HIL_NO_PERIPHERAL, sizeof core->bus.page_peripheral);
}

/* Finds the earliest event. The search key has the cycle in its upper bits and the slot in its
 * lower bits, so of two events at the same cycle the lower slot is first. The search uses several
 * independent minima, which is faster than one. */
#define EVENT_SLOT_BITS 5u
_Static_assert(HIL_EVENT_SLOTS <= 1u << EVENT_SLOT_BITS,
               "the slot numbers fit into their bit field");

static void find_next_event(struct hil_core *core)
{
    struct hil_events *events = &core->state.events;
    uint64_t least[HIL_EVENT_SEARCH_CHAINS] = {HIL_NEVER, HIL_NEVER, HIL_NEVER, HIL_NEVER};
#pragma GCC unroll 28
    for (unsigned i = 0; i < HIL_EVENT_SLOTS; i++) {
        /* 59 bits are enough for the cycles of a hundred years */
        uint64_t key = events->due_cycle[i] << EVENT_SLOT_BITS | i;
        least[i % HIL_EVENT_SEARCH_CHAINS] = key < least[i % HIL_EVENT_SEARCH_CHAINS]
                                               ? key
                                               : least[i % HIL_EVENT_SEARCH_CHAINS];
    }
    least[0] = least[1] < least[0] ? least[1] : least[0];
    least[2] = least[3] < least[2] ? least[3] : least[2];
    unsigned slot = (unsigned)((least[2] < least[0] ? least[2] : least[0]) &
                               ((1u << EVENT_SLOT_BITS) - 1u));
    uint64_t next = events->due_cycle[slot];
    events->next_cycle = next;
    events->next_slot = slot;
    if (next < core->next_check_cycle)
        core->next_check_cycle = next;
}

static void set_event_time(struct hil_core *core, enum hil_event_slot slot, uint64_t cycle,
                           uint64_t t_ps)
{
    struct hil_events *events = &core->state.events;
    uint64_t before = events->due_cycle[slot];
    events->due_cycle[slot] = cycle;
    events->due_ps[slot] = t_ps;
    /* search again, because the moved event may have been the earliest */
    if (before == events->next_cycle && cycle > before) {
        find_next_event(core);
    } else if (cycle < events->next_cycle ||
               (cycle == events->next_cycle && slot < events->next_slot)) {
        events->next_cycle = cycle;
        events->next_slot = slot;
    }
    if (events->next_cycle < core->next_check_cycle)
        core->next_check_cycle = events->next_cycle;
}

void hil_event_set_cycle(struct hil_core *core, enum hil_event_slot slot, uint64_t cycle)
{
    set_event_time(core, slot, cycle, HIL_NEVER);
}

void hil_event_set_ps(struct hil_core *core, enum hil_event_slot slot, uint64_t t_ps)
{
    set_event_time(core, slot, hil_clock_cycle_at_ps(&core->state.clock, t_ps), t_ps);
}

/* Recalculates the slots set in picoseconds after a change of HCLK. */
static void reschedule_physical_times(struct hil_core *core)
{
    struct hil_events *events = &core->state.events;
    for (unsigned i = 0; i < HIL_EVENT_SLOTS; i++) {
        if (events->due_ps[i] != HIL_NEVER)
            events->due_cycle[i] = hil_clock_cycle_at_ps(&core->state.clock, events->due_ps[i]);
    }
    find_next_event(core);
}

void hil_event_handle_due(struct hil_core *core)
{
    struct hil_events *events = &core->state.events;
    const struct hil_observers *observers = &core->observers;
    while (events->next_cycle <= core->state.clock.now_cycle && !core->has_reached_target) {
        unsigned slot = events->next_slot;
        uint64_t at = events->due_cycle[slot];
        events->due_cycle[slot] = HIL_NEVER;
        events->due_ps[slot] = HIL_NEVER;
        events->next_cycle = HIL_NEVER; /* no event is due until the handler has set new ones */
        core->event_handler[slot].handler(core->event_handler[slot].device, at);
        /* not in a trace: the end of a part of a run must leave no mark there */
        if (observers->tracer && slot != HIL_EVENT_RUN_END)
            observers->tracer->sample_signals(observers->tracer_context, at);
        find_next_event(core);
    }
}

/* --- changes of HCLK --- */

void hil_core_set_hclk(struct hil_core *core, uint32_t hclk_hz)
{
    struct hil_clock *clock = &core->state.clock;
    if (hclk_hz == clock->hclk_hz)
        return;
    hil_clock_set_hclk(clock, hclk_hz);
    reschedule_physical_times(core);
    hil_trace(core, "HCLK %u Hz", (unsigned)hclk_hz);
}

void hil_core_skip_to_event(struct hil_core *core)
{
    struct hil_clock *clock = &core->state.clock;
    struct hil_events *events = &core->state.events;
    /* always finds a time, because the end of the run is in the queue */
    uint64_t next_ps = HIL_NEVER;
    for (unsigned i = 0; i < HIL_EVENT_SLOTS; i++) {
        if (events->due_ps[i] < next_ps)
            next_ps = events->due_ps[i];
    }
    uint64_t now_ps = hil_clock_ps_at_cycle(clock, clock->now_cycle);
    clock->anchor_ps = next_ps > now_ps ? next_ps : now_ps;
    clock->anchor_cycle = clock->now_cycle;
    reschedule_physical_times(core);
}

/* ---- registers ---- */

/* clang-format off */
#define REGISTER_ROW(loose, access, offset, count, stride, name, reset, plain, action, status, \
    partly, refused, what)                                                                     \
    {offset, count, stride, access, loose, #name, reset, plain, action, status, partly,        \
     refused, what},
#define REG(access, offset, count, stride, name, ...) \
    REGISTER_ROW(false, access, offset, count, stride, name, __VA_ARGS__)
#define LOOSE(access, offset, count, stride, name, ...) \
    REGISTER_ROW(true, access, offset, count, stride, name, __VA_ARGS__)
#define SET(name, peripheral, base) {peripheral, base, (const struct hil_register[]){
#define END(set)                    {.name = NULL}}},
static const struct hil_register_set register_sets[] = {
#include "hil/core/registers.def"
};
/* clang-format on */
#define REGISTER_SET_COUNT (sizeof register_sets / sizeof register_sets[0])

const struct hil_register_set *hil_registers_all(size_t *count)
{
    *count = REGISTER_SET_COUNT;
    return register_sets;
}

const struct hil_register_set *hil_registers_by_base(uint32_t base)
{
    for (size_t i = 0; i < REGISTER_SET_COUNT; i++) {
        if (register_sets[i].base == base)
            return &register_sets[i];
    }
    return NULL;
}

const struct hil_register *hil_register_at(const struct hil_register_set *set, uint32_t offset)
{
    for (const struct hil_register *r = set->registers; r->name; r++) {
        uint32_t from = offset - r->offset;
        if (offset >= r->offset && from % r->stride == 0 && from / r->stride < r->count)
            return r;
    }
    return NULL;
}

const char *hil_register_refusal(const struct hil_register *r, uint32_t value)
{
    uint32_t changed = value ^ r->reset;
    if (r->access == 'r')
        return "the register is read-only: the chip ignores the write";
    if (changed & r->unmodelled_bits)
        return r->explanation;
    if (!r->allows_reserved &&
        (changed & ~(r->plain_bits | r->action_bits | r->status | r->conditional_bits)))
        return "a reserved bit does not keep its reset value";
    return NULL;
}

void hil_registers_reset(uint32_t base, uint32_t offset, uint32_t *word, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct hil_register *r = hil_register_at(hil_registers_by_base(base),
                                                       offset + 4u * (uint32_t)i);
        word[i] = r ? r->reset : 0;
    }
}

/* ---- the access in progress ---- */

unsigned hil_count_instructions(const struct hil_core *core, uint32_t from, uint32_t to)
{
    const uint8_t *code = from < to ? hil_memory_at(core, from, to - from, false) : NULL;
    unsigned n = 0;
    for (uint32_t i = 0; code && i < to - from; n++)
        i += code[i + 1] >= 0xe8u ? 4 : 2; /* an instruction of 4 bytes: ARMv7-M A5.1 */
    return n;
}

uint32_t hil_access_pc(const struct hil_core *core)
{
    struct hil_instruction place;
    return hil_translator_find_instruction(&core->engine.translator, core->bus.access.address,
                                           &place)
             ? place.pc
             : hil_cpu_register(core, 15) & ~1u;
}

/* Condition codes: ARMv7-M A7.3. */
bool hil_is_condition_met(uint32_t xpsr, unsigned condition)
{
    bool n = xpsr >> 31 & 1u, z = xpsr >> 30 & 1u, c = xpsr >> 29 & 1u, v = xpsr >> 28 & 1u;
    const bool holds[8] = {z, c, n, v, c && !z, n == v, n == v && !z, true};
    return condition >= 14 || holds[condition / 2] != (condition & 1u);
}

/* True if the transfer at `pc` is unaligned. Encodings: ARMv7-M A5.2 and A5.3. Offsets are whole
 * words, so only the base matters. */
bool hil_is_transfer_unaligned(const struct hil_core *core, uint32_t pc)
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
                    ((first & 0xfe40u) == 0xe840u &&               /* LDRD, STRD; exclusives */
                     ((first & 0x0120u) || !(first & 0x0080u))) || /* offset in words */
                    (fp && (first & 0xfe00u) == 0xec00u && (first & 0x01e0u) != 0x0040u) ||
                    (fp && (first & 0xff20u) == 0xed00u);
    unsigned base = first & 15u;
    return multiple && base != 13 && base != 15 && (hil_cpu_register(core, base) & 3u);
}

/* --- time of an access --- */

struct hil_timestamp hil_timestamp_at_cycle(const struct hil_core *core, uint64_t cycle)
{
    return (struct hil_timestamp){.ps = hil_clock_ps_at_cycle(&core->state.clock, cycle)};
}

struct hil_timestamp hil_access_timestamp(const struct hil_core *core)
{
    struct hil_instruction place;
    if (!hil_translator_find_instruction(&core->engine.translator, core->bus.access.address,
                                         &place) ||
        /* the boot ROM made the access: its instructions are not decoded */
        !hil_memory_at(core, place.pc, 2, false))
        return (struct hil_timestamp){0};
    uint64_t parts = (uint64_t)hil_count_instructions(core, core->state.cpu.block_address,
                                                      place.pc) *
                     core->instruction_cycle_parts;
    uint64_t cycle = hil_now_cycle(core) + parts / HIL_PARTS_PER_CYCLE;
    return (struct hil_timestamp){.ps = hil_clock_ps_at_cycle(&core->state.clock, cycle),
                                  .pc = place.pc};
}

/* --- refusals --- */

void hil_bus_stop(struct hil_core *core, const char *reason, const char *detail)
{
    struct hil_access current = core->bus.access;
    const struct hil_peripheral *p = hil_peripheral_at(&core->bus, current.address);
    unsigned pc = (unsigned)hil_access_pc(core);
    char place[32] = "";
    if (p)
        snprintf(place, sizeof place, " (%s + 0x%x)",
                 core->bus.peripheral_registers[p - core->bus.peripheral]->peripheral,
                 (unsigned)(current.address - p->base));
    hil_core_stop(core, MR_UNMODELLED, "%s %s of %u bytes at 0x%08x%s, PC 0x%08x%s%s", reason,
                  current.is_write ? "write" : "read", current.size, (unsigned)current.address,
                  place, pc, detail ? ": " : "", detail ? detail : "");
}

uint32_t hil_bus_refuse(struct hil_core *core, const char *what)
{
    hil_bus_stop(core, "unmodelled", what);
    return 0;
}

uint32_t hil_bus_refuse_register(struct hil_core *core)
{
    hil_bus_stop(core, "unmodelled", NULL);
    return 0;
}
