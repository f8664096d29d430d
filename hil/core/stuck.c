#include "hil/core/stuck.h"

#include <unicorn/unicorn.h>

#include "hil/core/core.h"
#include "hil/core/cpu.h"

static void hold(struct hil_core *core, unsigned i)
{
    uint8_t *cell = hil_memory_at(core, core->state.stuck.bit[i].address, 1, true);
    if (!cell)
        return;
    uint8_t mask = core->state.stuck.bit[i].mask;
    *cell = (uint8_t)(core->state.stuck.bit[i].level ? *cell | mask : *cell & ~mask);
}

static void on_load(struct uc_struct *uc, int type, uint64_t address, int size, int64_t value,
                    void *context)
{
    struct hil_core *core = context;
    (void)uc;
    (void)type;
    (void)value;
    for (unsigned i = 0; i < core->state.stuck.count; i++) {
        uint32_t at = core->state.stuck.bit[i].address;
        if (at >= address && at < address + (uint64_t)size)
            hold(core, i);
    }
}

void hil_stuck_look(struct hil_core *core)
{
    uc_hook hook;
    if (!core->state.stuck.count || core->engine.looks_at_loads)
        return;
    core->engine.looks_at_loads = uc_hook_add(core->uc, &hook, UC_HOOK_MEM_READ,
                                              (void *)(uintptr_t)on_load, core, HIL_CCM_BASE,
                                              HIL_SRAM_BASE + HIL_SRAM_SIZE - 1u) == UC_ERR_OK;
    hil_cpu_forget_code(core); /* translated code does not look */
}

bool hil_stuck_add(struct hil_core *core, uint32_t address, unsigned bit, bool level)
{
    struct hil_stuck *stuck = &core->state.stuck;
    if (stuck->count == HIL_STUCK_MAX)
        return false;
    stuck->bit[stuck->count].address = address + bit / 8u;
    stuck->bit[stuck->count].mask = (uint8_t)(1u << bit % 8u);
    stuck->bit[stuck->count].level = level;
    hold(core, stuck->count++);
    hil_stuck_look(core);
    return true;
}
