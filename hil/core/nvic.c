#include "hil/core/nvic.h"

#include "hil/core/access.h"
#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/core/registers.h"

#define ISPR         0x200u
#define ICPR         0x280u
#define IABR         0x300u
#define IPR          0x400u
#define IPR_END      (IPR + (HIL_INTERRUPTS + 3u) / 4u * 4u)
#define THREAD_GROUP 256

static bool get(const uint32_t *set, unsigned i)
{
    return (set[i / 32u] >> (i % 32u) & 1u) != 0;
}
static void put(uint32_t *set, unsigned i, bool on)
{
    uint32_t bit = 1u << (i % 32u);
    set[i / 32u] = on ? set[i / 32u] | bit : set[i / 32u] & ~bit;
}

void hil_nvic_reset(struct hil_nvic *nvic)
{
    *nvic = (struct hil_nvic){.active_group = THREAD_GROUP, .best_group = THREAD_GROUP};
    nvic->priority[HIL_EXC_RESET] = -3;
    nvic->priority[HIL_EXC_NMI] = -2;
    nvic->priority[HIL_EXC_HARD_FAULT] = -1;
    /* The configurable faults are enabled by SHCSR; these have no enable bit. */
    put(nvic->enabled, HIL_EXC_NMI, true);
    put(nvic->enabled, HIL_EXC_HARD_FAULT, true);
    put(nvic->enabled, HIL_EXC_SVCALL, true);
    put(nvic->enabled, HIL_EXC_DEBUG_MONITOR, true);
    put(nvic->enabled, HIL_EXC_PENDSV, true);
    put(nvic->enabled, HIL_EXC_SYSTICK, true);
}

int hil_nvic_group(const struct hil_nvic *nvic, int priority)
{
    /* Bits PRIGROUP..0 of the priority byte are the subpriority. */
    return priority < 0 ? priority : priority & ~((2 << nvic->prigroup) - 1) & 0xff;
}

void hil_nvic_update(struct hil_core *core)
{
    struct hil_nvic *nvic = &core->state.nvic;
    int best_priority = THREAD_GROUP;
    int active_group = THREAD_GROUP;
    nvic->best = 0;
    nvic->best_group = THREAD_GROUP;
    for (unsigned w = 0; w < HIL_EXCEPTION_WORDS; w++) {
        for (uint32_t set = nvic->pending[w] & nvic->enabled[w]; set; set &= set - 1) {
            unsigned i = 32u * w + (unsigned)__builtin_ctz(set);
            if (nvic->priority[i] < best_priority) {
                best_priority = nvic->priority[i];
                nvic->best = (uint16_t)i;
            }
        }
        for (uint32_t set = nvic->active[w]; set; set &= set - 1) {
            unsigned i = 32u * w + (unsigned)__builtin_ctz(set);
            int group = hil_nvic_group(nvic, nvic->priority[i]);
            if (group < active_group)
                active_group = group;
        }
    }
    if (nvic->best)
        nvic->best_group = (int16_t)hil_nvic_group(nvic, best_priority);
    nvic->active_group = (int16_t)active_group;
    if (nvic->best && nvic->best_group < nvic->active_group)
        hil_core_attend(core);
}

static void nvic_pend(struct hil_core *core, unsigned exception)
{
    put(core->state.nvic.pending, exception, true);
    hil_nvic_update(core);
}

static void nvic_unpend(struct hil_core *core, unsigned exception)
{
    put(core->state.nvic.pending, exception, false);
    hil_nvic_update(core);
}

void hil_irq_line(struct hil_core *core, unsigned irq, bool level)
{
    hil_nvic_line(core, 16u + irq, level);
}

void hil_nvic_line(struct hil_core *core, unsigned exception, bool level)
{
    struct hil_nvic *nvic = &core->state.nvic;
    bool before = get(nvic->line, exception);
    if (level == before)
        return;
    put(nvic->line, exception, level);
    if (level)
        nvic_pend(core, exception);
}

void hil_nvic_activate(struct hil_core *core, unsigned exception)
{
    put(core->state.nvic.active, exception, true);
    put(core->state.nvic.pending, exception, false);
    hil_nvic_update(core);
}

void hil_nvic_deactivate(struct hil_core *core, unsigned exception)
{
    struct hil_nvic *nvic = &core->state.nvic;
    put(nvic->active, exception, false);
    if (get(nvic->line, exception))
        put(nvic->pending, exception, true);
    hil_nvic_update(core);
}

bool hil_nvic_is_active(const struct hil_nvic *nvic, unsigned exception)
{
    return get(nvic->active, exception);
}

/* One 32-interrupt register, seen as part of the exception set (offset by the 16 system
 * exceptions). */
static uint32_t window(const uint32_t *set, unsigned n)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < 32u && 32u * n + i < HIL_INTERRUPTS; i++)
        value |= (uint32_t)get(set, 16u + 32u * n + i) << i;
    return value;
}

static void window_put(uint32_t *set, unsigned n, uint32_t bits, bool on)
{
    for (unsigned i = 0; i < 32u && 32u * n + i < HIL_INTERRUPTS; i++) {
        if (bits >> i & 1u)
            put(set, 16u + 32u * n + i, on);
    }
}

/* Priorities of `count` exceptions, 1 to 4, from this one on: a byte each, as the registers of
 * priorities have them. */
static uint32_t priorities(const struct hil_nvic *nvic, unsigned exception, unsigned count)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < count && exception + i < HIL_EXCEPTIONS; i++)
        value |= (uint32_t)(nvic->priority[exception + i] & 0xff) << (8u * i);
    return value;
}

static void set_priorities(struct hil_core *core, unsigned exception, unsigned count,
                           uint32_t value)
{
    for (unsigned i = 0; i < count && exception + i < HIL_EXCEPTIONS; i++)
        core->state.nvic.priority[exception + i] = (int16_t)(value >> (8u * i) & 0xf0u);
    hil_nvic_update(core);
}

/* What ISER, ICER, ISPR, ICPR and IABR show. */
static uint32_t *set_at(struct hil_nvic *nvic, uint32_t offset)
{
    return offset < ISPR ? nvic->enabled : offset < IABR ? nvic->pending : nvic->active;
}

/* Registers 0x100..0x4FF of the system control space (ISER, ICER, ISPR, ICPR, IABR, IPR). False: no
 * such register. */
static bool nvic_read(struct hil_core *core, uint32_t offset, unsigned size, uint32_t *value)
{
    if (offset >= IPR)
        *value = priorities(&core->state.nvic, 16u + offset - IPR, size);
    else
        *value = window(set_at(&core->state.nvic, offset), (offset & 0x7fu) / 4u);
    return offset >= IPR ? offset + size <= IPR_END : size == 4 && offset % 4u == 0;
}

static bool nvic_write(struct hil_core *core, uint32_t offset, unsigned size, uint32_t value)
{
    struct hil_nvic *nvic = &core->state.nvic;
    if (offset >= IPR && offset + size <= IPR_END) {
        set_priorities(core, 16u + offset - IPR, size, value);
        return true;
    }
    if (size != 4 || offset % 4u)
        return false;
    unsigned n = (offset & 0x7fu) / 4u;
    window_put(set_at(nvic, offset), n, value, !(offset & 0x80u));
    /* A line that is still high pends again at once. */
    for (unsigned i = 0; offset >= ICPR && i < 32u && 32u * n + i < HIL_INTERRUPTS; i++) {
        unsigned exception = 16u + 32u * n + i;
        if ((value >> i & 1u) && get(nvic->line, exception) && !get(nvic->active, exception))
            put(nvic->pending, exception, true);
    }
    hil_nvic_update(core);
    return true;
}

/* --- SysTick --- */

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
        nvic_pend(core, HIL_EXC_SYSTICK);
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

static uint32_t systick_read(struct hil_core *core, uint32_t offset)
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

static void systick_write(struct hil_core *core, uint32_t offset, uint32_t value)
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

/* --- system control block --- */

#define SYSTEM        0xe000e000u
#define ICTR          0x004u
#define SCB           0xd00u
#define ICSR          0xd04u
#define AIRCR         0xd0cu
#define SHPR          0xd18u
#define SHCSR         0xd24u
#define CFSR          0xd28u
#define HFSR          0xd2cu
#define STIR          0xf00u
#define FPCCR         0xf34u
#define DWT_CTRL      0xe0001000u
#define DWT_CYCCNT    0xe0001004u
#define DWT_LAR       0xe0001fb0u
#define DBGMCU        0xe0042000u
#define DEMCR_TRCENA  (1u << 24)
#define DWT_CYCCNTENA 1u
#define AIRCR_KEY     0x05fau
#define CSR_SOFTWARE  (1u << 28) /* RCC_CSR.SFTRSTF */

void hil_scb_reset(struct hil_scb *scb, uint32_t idcode)
{
    *scb = (struct hil_scb){.dwt_ctrl = 0x40000000, .idcode = idcode};
    hil_registers_reset(SYSTEM, SCB, scb->word, sizeof scb->word / 4u);
}

static uint32_t icsr(const struct hil_core *core)
{
    const struct hil_nvic *nvic = &core->state.nvic;
    uint32_t value = hil_cpu_register(core, 16) & 0x1ffu; /* VECTACTIVE */
    unsigned active = 0;
    bool isr_pending = false;
    for (unsigned w = 0; w < HIL_EXCEPTION_WORDS; w++) {
        active += (unsigned)__builtin_popcount(nvic->active[w]);
        isr_pending |= (w ? nvic->pending[w] : nvic->pending[w] & 0xffff0000u) != 0;
    }
    if (active <= 1)
        value |= 1u << 11; /* RETTOBASE */
    value |= (uint32_t)nvic->best << 12;
    value |= (uint32_t)isr_pending << 22;
    value |= (nvic->pending[0] >> HIL_EXC_SYSTICK & 1u) << 26;
    value |= (nvic->pending[0] >> HIL_EXC_PENDSV & 1u) << 28;
    return value | (nvic->pending[0] >> HIL_EXC_NMI & 1u) << 31;
}

static void icsr_write(struct hil_core *core, uint32_t value)
{
    if (value >> 31 & 1u)
        nvic_pend(core, HIL_EXC_NMI);
    if (value >> 28 & 1u)
        nvic_pend(core, HIL_EXC_PENDSV);
    else if (value >> 27 & 1u)
        nvic_unpend(core, HIL_EXC_PENDSV);
    if (value >> 26 & 1u)
        nvic_pend(core, HIL_EXC_SYSTICK);
    else if (value >> 25 & 1u)
        nvic_unpend(core, HIL_EXC_SYSTICK);
}

static uint32_t shcsr(const struct hil_nvic *nvic)
{
    uint32_t active = nvic->active[0], pending = nvic->pending[0], enabled = nvic->enabled[0];
    return (active >> 4 & 1u) | (active >> 5 & 1u) << 1 | (active >> 6 & 1u) << 3 |
           (active >> 11 & 1u) << 7 | (active >> 14 & 1u) << 10 | (active >> 15 & 1u) << 11 |
           (pending >> 6 & 1u) << 12 | (pending >> 4 & 1u) << 13 | (pending >> 5 & 1u) << 14 |
           (pending >> 11 & 1u) << 15 | (enabled >> 4 & 7u) << 16;
}

static void aircr_write(struct hil_core *core, uint32_t value)
{
    if (value >> 16 != AIRCR_KEY)
        return;
    core->state.nvic.prigroup = (uint8_t)(value >> 8 & 7u);
    hil_nvic_update(core);
    if (value & 4u)
        hil_core_request_reset(core, CSR_SOFTWARE);
}

static uint32_t cyccnt(const struct hil_core *core)
{
    const struct hil_scb *scb = &core->state.scb;
    return scb->dwt_offset + ((scb->dwt_ctrl & DWT_CYCCNTENA) ? (uint32_t)hil_now(core) : 0);
}

static uint32_t scs_read(struct hil_core *core, uint32_t offset, unsigned size)
{
    struct hil_scb *scb = &core->state.scb;
    uint32_t value = 0;
    if (offset >= 0x10u && offset < 0x20u && size == 4)
        return systick_read(core, offset);
    if (offset >= 0x100u && offset < 0x500u)
        return nvic_read(core, offset, size, &value) ? value : hil_bus_no_register(core);
    if (offset >= SHPR && offset + size <= SHCSR)
        /* of exceptions 4 to 15 */
        return priorities(&core->state.nvic, 4u + offset - SHPR, size);
    if (offset >= CFSR && offset < HFSR) /* CFSR and its byte parts */
        return scb->cfsr >> (8u * (offset & 3u)) &
               (size == 4 ? 0xffffffffu : (1u << (8u * size)) - 1u);
    if (size != 4 || offset % 4u)
        return hil_bus_no_register(core);
    switch (offset) {
    case ICTR: /* interrupt lines in groups of 32, minus one */ return 2;
    case ICSR: return icsr(core);
    case AIRCR: /* reads with the key's complement */
        return 0xfa050000u | (uint32_t)core->state.nvic.prigroup << 8;
    case SHCSR: return shcsr(&core->state.nvic);
    default: return scb->word[(offset - SCB) / 4u];
    }
}

static void system_write(struct hil_core *core, uint32_t offset, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    switch (offset) {
    case ICSR: icsr_write(core, value); break;
    case AIRCR: aircr_write(core, value); break;
    case SHCSR:
        core->state.nvic.enabled[0] = (core->state.nvic.enabled[0] & ~0x70u) | (value >> 16 & 7u)
                                                                                   << 4;
        hil_nvic_update(core);
        break;
    case CFSR:
    case HFSR: /* flags are cleared by writing 1 */ scb->word[(offset - SCB) / 4u] &= ~value; break;
    case STIR:
        if ((value & 0x1ffu) < HIL_INTERRUPTS)
            nvic_pend(core, 16u + (value & 0x1ffu));
        break;
    case FPCCR: scb->fpccr = value & 0xc0000000u; break;
    default: /* CCR.DIV_0_TRP is kept, but a division by zero gives 0 either way */
        scb->word[(offset - SCB) / 4u] = value;
        break;
    }
}

static void scs_write(struct hil_core *core, uint32_t offset, unsigned size, uint32_t value)
{
    bool known = true;
    if (offset >= 0x10u && offset < 0x20u && size == 4)
        systick_write(core, offset, value);
    else if (offset >= 0x100u && offset < 0x500u)
        known = nvic_write(core, offset, size, value);
    else if (offset >= SHPR && offset + size <= SHCSR)
        set_priorities(core, 4u + offset - SHPR, size, value);
    else if (size == 4 && offset % 4u == 0)
        system_write(core, offset, value);
    else
        known = false;
    if (!known)
        hil_bus_no_register(core);
}

uint32_t hil_scb_read(struct hil_core *core, uint32_t address, unsigned size)
{
    struct hil_scb *scb = &core->state.scb;
    if ((address & ~0xfffu) == SYSTEM)
        return scs_read(core, address & 0xfffu, size);
    if (size == 4 && address == DWT_CTRL)
        return scb->dwt_ctrl;
    if (size == 4 && address == DWT_CYCCNT)
        return cyccnt(core);
    if (size == 4 && address % 4u == 0 && address - DBGMCU < sizeof scb->dbgmcu)
        return scb->dbgmcu[(address - DBGMCU) / 4u];
    return hil_bus_no_register(core);
}

static void dwt_write(struct hil_core *core, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    if (!(scb->demcr & DEMCR_TRCENA))
        return; /* as silicon: the unit is off */
    /* all but CYCCNTENA, and SYNCTAP/CYCTAP, which only matter to trace */
    if (value & 0x3ffffffeu & ~0x1e00u)
        hil_bus_refuse(core, "DWT functions other than the cycle counter");
    uint32_t count = cyccnt(core);
    scb->dwt_ctrl = 0x40000000u | (value & DWT_CYCCNTENA);
    scb->dwt_offset = (value & DWT_CYCCNTENA) ? count - (uint32_t)hil_now(core) : count;
}

void hil_scb_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    if ((address & ~0xfffu) == SYSTEM)
        scs_write(core, address & 0xfffu, size, value);
    else if (size == 4 && address == DWT_CTRL)
        dwt_write(core, value);
    else if (size == 4 && address == DWT_CYCCNT)
        scb->dwt_offset = (scb->dwt_ctrl & DWT_CYCCNTENA) ? value - (uint32_t)hil_now(core) : value;
    else if (size == 4 && address % 4u == 0 && address > DBGMCU &&
             address - DBGMCU < sizeof scb->dbgmcu)
        scb->dbgmcu[(address - DBGMCU) / 4u] = address == DBGMCU + 4u ? value & 0xffu : value;
    /* the lock is not implemented on the STM32F4: writes are ignored */
    else if (size != 4 || address != DWT_LAR)
        hil_bus_no_register(core);
}
