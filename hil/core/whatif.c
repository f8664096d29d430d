#include "hil/core/whatif.h"

#include <stdlib.h>
#include <string.h>
#include <unicorn/unicorn.h>

#include "hil/core/core.h"

#define STEPS_MAX        (2u * HIL_WHATIF_INSTRUCTIONS)
/* bytes below and above the stack pointer of the load that may differ */
#define STACK_LOW        0x1000u
#define STACK_TOP        0x200u
#define REMEMBERED_LOADS 256u /* number of remembered instructions */
#define REGISTERS        33u

/* An instruction, or a store to a peripheral with its address and value. Stores to memory are
 * compared after a run: Unicorn's store hook misses some on 64-bit ARM computers. */
struct step {
    uint32_t pc, address;
    uint64_t value;
};

struct hil_whatif {
    struct uc_struct *uc;
    struct hil_translator translator;
    const struct hil_core *core;
    uint8_t *sram, *ccm;             /* page-aligned copies */
    uint8_t *first_sram, *first_ccm; /* state after the first run */
    uint32_t read_value; /* result of the first read and of later reads of the same register */
    uint32_t read_offset;
    bool was_read;
    uint32_t stack;
    struct step *step; /* steps of the first run */
    unsigned step_count, at;
    bool is_comparing, is_different;
    uint32_t last_pc;
    struct {
        uint32_t pc, caller, unknown, times;
    } tested[REMEMBERED_LOADS];
};

static const int copied_registers[REGISTERS] = {
    UC_ARM_REG_R0,  UC_ARM_REG_R1,    UC_ARM_REG_R2,        UC_ARM_REG_R3,  UC_ARM_REG_R4,
    UC_ARM_REG_R5,  UC_ARM_REG_R6,    UC_ARM_REG_R7,        UC_ARM_REG_R8,  UC_ARM_REG_R9,
    UC_ARM_REG_R10, UC_ARM_REG_R11,   UC_ARM_REG_R12,       UC_ARM_REG_SP,  UC_ARM_REG_LR,
    UC_ARM_REG_D0,  UC_ARM_REG_D1,    UC_ARM_REG_D2,        UC_ARM_REG_D3,  UC_ARM_REG_D4,
    UC_ARM_REG_D5,  UC_ARM_REG_D6,    UC_ARM_REG_D7,        UC_ARM_REG_D8,  UC_ARM_REG_D9,
    UC_ARM_REG_D10, UC_ARM_REG_D11,   UC_ARM_REG_D12,       UC_ARM_REG_D13, UC_ARM_REG_D14,
    UC_ARM_REG_D15, UC_ARM_REG_FPSCR, UC_ARM_REG_APSR_NZCV,
};

static void record_step(struct hil_whatif *w, struct step step)
{
    if (!w->is_comparing) {
        if (w->step_count < STEPS_MAX)
            w->step[w->step_count++] = step;
    } else if (w->at < w->step_count && !w->is_different) {
        const struct step *other = &w->step[w->at++];
        w->is_different = other->pc != step.pc || other->address != step.address ||
                          other->value != step.value;
        if (w->is_different)
            uc_emu_stop(w->uc);
    }
    if (!w->is_different || step.address)
        w->last_pc = step.pc;
}

static void on_instruction(uc_engine *uc, uint64_t pc, uint32_t size, void *user)
{
    (void)uc;
    (void)size;
    record_step(user, (struct step){(uint32_t)pc, 0, 0});
}

static void on_exception(uc_engine *uc, uint32_t number, void *user)
{
    (void)number;
    (void)user;
    uc_emu_stop(uc);
}

static uint64_t on_read(uc_engine *uc, uint64_t offset, unsigned size, void *user)
{
    struct hil_whatif *w = user;
    uint32_t at = (uint32_t)offset;
    (void)uc;
    (void)size;
    if (!w->was_read) {
        w->was_read = true;
        w->read_offset = at & ~3u;
    }
    if ((at & ~3u) != w->read_offset)
        return 0;
    return w->read_value >> (8u * (at & 3u));
}

static uint64_t on_read_of_core(uc_engine *uc, uint64_t offset, unsigned size, void *user)
{
    (void)uc;
    (void)offset;
    (void)size;
    (void)user;
    return 0;
}

static void on_write(uc_engine *uc, uint64_t offset, unsigned size, uint64_t value, void *user)
{
    struct hil_whatif *w = user;
    (void)uc;
    (void)size;
    record_step(w, (struct step){w->last_pc, 0x40000000u | (uint32_t)offset, value});
}

static struct hil_whatif *create_copy(struct hil_core *core)
{
    struct hil_whatif *w = calloc(1, sizeof *w);
    uc_hook hook;
    if (!w || !(w->step = calloc(STEPS_MAX, sizeof *w->step)) ||
        !(w->sram = aligned_alloc(4096, HIL_SRAM_SIZE)) ||
        !(w->ccm = aligned_alloc(4096, HIL_CCM_SIZE)) || !(w->first_sram = malloc(HIL_SRAM_SIZE)) ||
        !(w->first_ccm = malloc(HIL_CCM_SIZE)))
        abort();
    w->core = core;
    hil_translator_start(&w->translator);
    uc_check(uc_open(UC_ARCH_ARM, UC_MODE_THUMB, &w->uc), "open");
    uc_check(uc_ctl_set_cpu_model(w->uc, UC_CPU_ARM_CORTEX_M4), "choosing the Cortex-M4");
    static const uint32_t flash[2] = {0, HIL_FLASH_BASE};
    for (unsigned i = 0; i < 2; i++)
        uc_check(uc_mem_map_ptr(w->uc, flash[i], HIL_FLASH_SIZE, UC_PROT_READ | UC_PROT_EXEC,
                                core->memory->flash),
                 "mapping flash");
    uc_check(uc_mem_map_ptr(w->uc, HIL_SRAM_BASE, HIL_SRAM_SIZE, UC_PROT_ALL, w->sram),
             "mapping SRAM");
    uc_check(
        uc_mem_map_ptr(w->uc, HIL_CCM_BASE, HIL_CCM_SIZE, UC_PROT_READ | UC_PROT_WRITE, w->ccm),
        "mapping CCM");
    uc_check(uc_mmio_map(w->uc, 0x40000000u, 0x20000000u, on_read, w, on_write, w),
             "mapping peripherals");
    uc_check(uc_mmio_map(w->uc, 0xe0000000u, 0x00100000u, on_read_of_core, w, on_write, w),
             "mapping the core's own");
    uc_check(uc_hook_add(w->uc, &hook, UC_HOOK_CODE, (void *)(uintptr_t)on_instruction, w, 1, 0),
             "instruction hook");
    uc_check(uc_hook_add(w->uc, &hook, UC_HOOK_INTR, (void *)(uintptr_t)on_exception, w, 1, 0),
             "exception hook");
    return w;
}

void hil_whatif_destroy(struct hil_core *core)
{
    struct hil_whatif *w = core->engine.whatif;
    if (!w)
        return;
    uc_close(w->uc);
    free(w->sram);
    free(w->ccm);
    free(w->first_sram);
    free(w->first_ccm);
    free(w->step);
    free(w);
    core->engine.whatif = NULL;
}

void hil_whatif_reset(struct hil_core *core)
{
    if (core->engine.whatif)
        memset(core->engine.whatif->tested, 0, sizeof core->engine.whatif->tested);
}

/* Runs a copy of the core from the load on; the load reads `value`. */
static void run_copy(struct hil_whatif *w, uint32_t pc, uint32_t value)
{
    const struct hil_core *core = w->core;
    memcpy(w->sram, core->memory->sram, HIL_SRAM_SIZE);
    memcpy(w->ccm, core->memory->ccm, HIL_CCM_SIZE);
    for (unsigned i = 0; i < REGISTERS; i++) {
        uint64_t content = 0;
        uc_reg_read(core->uc, copied_registers[i], &content);
        uc_reg_write(w->uc, copied_registers[i], &content);
        if (copied_registers[i] == UC_ARM_REG_SP)
            w->stack = (uint32_t)content;
    }
    w->read_value = value;
    w->was_read = w->is_different = false;
    w->at = 0;
    struct hil_translator *outer = hil_translator_select(&w->translator);
    (void)uc_emu_start(w->uc, pc | 1u, 0, 0, HIL_WHATIF_INSTRUCTIONS);
    hil_translator_select(outer);
    w->is_different |= w->is_comparing &&
                       w->at < w->step_count; /* the run ended earlier than the first one */
}

/* Makes the run with which the others are compared. */
static void run_first(struct hil_whatif *w, uint32_t pc, uint32_t value)
{
    w->is_comparing = false;
    w->step_count = 0;
    run_copy(w, pc, value);
    memcpy(w->first_sram, w->sram, HIL_SRAM_SIZE);
    memcpy(w->first_ccm, w->ccm, HIL_CCM_SIZE);
}

/* True if the memory at `base` differs between the runs, apart from the stack around the stack
 * pointer. */
static bool is_memory_different(const struct hil_whatif *w, const uint8_t *memory,
                                const uint8_t *first, uint32_t base, uint32_t size)
{
    if (!memcmp(memory, first, size))
        return false;
    for (uint32_t i = 0; i < size; i++)
        if (memory[i] != first[i] && base + i - (w->stack - STACK_LOW) >= STACK_LOW + STACK_TOP)
            return true;
    return false;
}

static bool is_run_different(struct hil_whatif *w, uint32_t pc, uint32_t value)
{
    w->is_comparing = true;
    run_copy(w, pc, value);
    if (w->is_different)
        return true;
    w->last_pc = pc;
    return is_memory_different(w, w->sram, w->first_sram, HIL_SRAM_BASE, HIL_SRAM_SIZE) ||
           is_memory_different(w, w->ccm, w->first_ccm, HIL_CCM_BASE, HIL_CCM_SIZE);
}

/* True if this load was tried often enough. */
static bool is_tested_enough(struct hil_whatif *w, uint32_t pc, uint32_t unknown)
{
    unsigned i = 0;
    uint32_t caller = 0; /* LR need not be a return address: it only distinguishes callers */
    uc_reg_read(w->core->uc, UC_ARM_REG_LR, &caller);
    while (
        i < REMEMBERED_LOADS && w->tested[i].times &&
        (w->tested[i].pc != pc || w->tested[i].caller != caller || w->tested[i].unknown != unknown))
        i++;
    if (i == REMEMBERED_LOADS)
        return false;
    w->tested[i].pc = pc;
    w->tested[i].caller = caller;
    w->tested[i].unknown = unknown;
    return w->tested[i].times++ >= HIL_WHATIF_TIMES;
}

bool hil_whatif_has_effect(struct hil_core *core, uint32_t pc, uint32_t value, uint32_t unknown,
                           struct hil_difference *difference)
{
    static const uint32_t pattern[] = {0xffffffffu, 0x55555555u, 0xaaaaaaaau};
    struct hil_whatif *w = core->engine.whatif;
    bool matters = false;
    if (!w)
        w = core->engine.whatif = create_copy(core);
    if (is_tested_enough(w, pc, unknown))
        return false;
    run_first(w, pc, value & ~unknown);
    for (unsigned i = 0; i < 3 && !matters; i++)
        matters = is_run_different(w, pc, (value & ~unknown) | (pattern[i] & unknown));
    *difference = (struct hil_difference){(unsigned)__builtin_ctz(unknown), w->last_pc};
    for (unsigned bit = 0; matters && bit < 32; bit++) {
        if ((unknown >> bit & 1u) && is_run_different(w, pc, (value & ~unknown) | 1u << bit)) {
            *difference = (struct hil_difference){bit, w->last_pc};
            break;
        }
    }
    return matters;
}
