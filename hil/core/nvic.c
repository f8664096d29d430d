#include "hil/core/nvic.h"

#include "hil/core/core.h"

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

void hil_nvic_pend(struct hil_core *core, unsigned exception)
{
    put(core->state.nvic.pending, exception, true);
    hil_nvic_update(core);
}

void hil_nvic_unpend(struct hil_core *core, unsigned exception)
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
        hil_nvic_pend(core, exception);
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

uint32_t hil_nvic_priorities(const struct hil_nvic *nvic, unsigned exception, unsigned count)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < count && exception + i < HIL_EXCEPTIONS; i++)
        value |= (uint32_t)(nvic->priority[exception + i] & 0xff) << (8u * i);
    return value;
}

void hil_nvic_set_priorities(struct hil_core *core, unsigned exception, unsigned count,
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

bool hil_nvic_read(struct hil_core *core, uint32_t offset, unsigned size, uint32_t *value)
{
    if (offset >= IPR)
        *value = hil_nvic_priorities(&core->state.nvic, 16u + offset - IPR, size);
    else
        *value = window(set_at(&core->state.nvic, offset), (offset & 0x7fu) / 4u);
    return offset >= IPR ? offset + size <= IPR_END : size == 4 && offset % 4u == 0;
}

bool hil_nvic_write(struct hil_core *core, uint32_t offset, unsigned size, uint32_t value)
{
    struct hil_nvic *nvic = &core->state.nvic;
    if (offset >= IPR && offset + size <= IPR_END) {
        hil_nvic_set_priorities(core, 16u + offset - IPR, size, value);
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
