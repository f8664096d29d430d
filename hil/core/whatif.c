#include "hil/core/whatif.h"

#include <stdlib.h>
#include <string.h>
#include <unicorn/unicorn.h>

#include "hil/core/core.h"

#define TRACED_STEPS_MAX      (2u * HIL_WHATIF_INSTRUCTIONS_MAX)
/* range of bytes below and above the stack pointer that may differ between the runs */
#define STACK_BYTES_BELOW     0x1000u
#define STACK_BYTES_ABOVE     0x200u
#define REMEMBERED_LOADS_MAX  256u /* number of remembered instructions */
#define COPIED_REGISTER_COUNT 33u

/* An instruction, or a store to a peripheral with its address and value. Stores to memory are
 * compared after a run: Unicorn's store hook misses some on 64-bit ARM computers. */
struct traced_step {
    uint32_t pc, address;
    uint64_t value;
};

struct hil_whatif {
    struct uc_struct *uc;
    struct hil_translator translator;
    const struct hil_core *core;
    uint8_t *sram, *ccm;                                 /* page-aligned copies */
    uint8_t *sram_after_first_run, *ccm_after_first_run; /* memory at the end of the first run */
    uint32_t read_value; /* value of the first read, and of later reads of the same register */
    uint32_t read_offset;
    bool has_been_read;
    uint32_t stack_pointer;
    struct traced_step *first_run_steps; /* steps of the first run */
    unsigned step_count, step_index;
    bool is_comparing, is_different;
    uint32_t last_pc;
    struct {
        uint32_t pc, caller, unknown_bits, test_count;
    } tested[REMEMBERED_LOADS_MAX];
};

static const int copied_registers[COPIED_REGISTER_COUNT] = {
    UC_ARM_REG_R0,  UC_ARM_REG_R1,    UC_ARM_REG_R2,        UC_ARM_REG_R3,  UC_ARM_REG_R4,
    UC_ARM_REG_R5,  UC_ARM_REG_R6,    UC_ARM_REG_R7,        UC_ARM_REG_R8,  UC_ARM_REG_R9,
    UC_ARM_REG_R10, UC_ARM_REG_R11,   UC_ARM_REG_R12,       UC_ARM_REG_SP,  UC_ARM_REG_LR,
    UC_ARM_REG_D0,  UC_ARM_REG_D1,    UC_ARM_REG_D2,        UC_ARM_REG_D3,  UC_ARM_REG_D4,
    UC_ARM_REG_D5,  UC_ARM_REG_D6,    UC_ARM_REG_D7,        UC_ARM_REG_D8,  UC_ARM_REG_D9,
    UC_ARM_REG_D10, UC_ARM_REG_D11,   UC_ARM_REG_D12,       UC_ARM_REG_D13, UC_ARM_REG_D14,
    UC_ARM_REG_D15, UC_ARM_REG_FPSCR, UC_ARM_REG_APSR_NZCV,
};

static void record_step(struct hil_whatif *w, struct traced_step step)
{
    if (!w->is_comparing) {
        if (w->step_count < TRACED_STEPS_MAX)
            w->first_run_steps[w->step_count++] = step;
    } else if (w->step_index < w->step_count && !w->is_different) {
        const struct traced_step *other = &w->first_run_steps[w->step_index++];
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
    record_step(user, (struct traced_step){(uint32_t)pc, 0, 0});
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
    if (!w->has_been_read) {
        w->has_been_read = true;
        w->read_offset = at & ~3u;
    }
    if ((at & ~3u) != w->read_offset)
        return 0;
    return w->read_value >> (8u * (at & 3u));
}

static uint64_t on_core_register_read(uc_engine *uc, uint64_t offset, unsigned size, void *user)
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
    record_step(w, (struct traced_step){w->last_pc, 0x40000000u | (uint32_t)offset, value});
}

static struct hil_whatif *create_core_copy(struct hil_core *core)
{
    struct hil_whatif *w = calloc(1, sizeof *w);
    uc_hook hook;
    if (!w || !(w->first_run_steps = calloc(TRACED_STEPS_MAX, sizeof *w->first_run_steps)) ||
        !(w->sram = aligned_alloc(4096, HIL_SRAM_SIZE)) ||
        !(w->ccm = aligned_alloc(4096, HIL_CCM_SIZE)) ||
        !(w->sram_after_first_run = malloc(HIL_SRAM_SIZE)) ||
        !(w->ccm_after_first_run = malloc(HIL_CCM_SIZE)))
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
    uc_check(uc_mmio_map(w->uc, 0xe0000000u, 0x00100000u, on_core_register_read, w, on_write, w),
             "mapping memory of the core");
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
    free(w->sram_after_first_run);
    free(w->ccm_after_first_run);
    free(w->first_run_steps);
    free(w);
    core->engine.whatif = NULL;
}

void hil_whatif_reset(struct hil_core *core)
{
    if (core->engine.whatif)
        memset(core->engine.whatif->tested, 0, sizeof core->engine.whatif->tested);
}

/* Runs a copy of the core, beginning at the load, which reads `value`. */
static void run_copy(struct hil_whatif *w, uint32_t pc, uint32_t value)
{
    const struct hil_core *core = w->core;
    memcpy(w->sram, core->memory->sram, HIL_SRAM_SIZE);
    memcpy(w->ccm, core->memory->ccm, HIL_CCM_SIZE);
    for (unsigned i = 0; i < COPIED_REGISTER_COUNT; i++) {
        uint64_t content = 0;
        uc_reg_read(core->uc, copied_registers[i], &content);
        uc_reg_write(w->uc, copied_registers[i], &content);
        if (copied_registers[i] == UC_ARM_REG_SP)
            w->stack_pointer = (uint32_t)content;
    }
    w->read_value = value;
    w->has_been_read = w->is_different = false;
    w->step_index = 0;
    struct hil_translator *outer = hil_translator_select(&w->translator);
    (void)uc_emu_start(w->uc, pc | 1u, 0, 0, HIL_WHATIF_INSTRUCTIONS_MAX);
    hil_translator_select(outer);
    w->is_different |= w->is_comparing &&
                       /* also a difference: the run ended earlier than the first one */
                       w->step_index < w->step_count;
}

/* Makes the run with which the others are compared. */
static void run_reference(struct hil_whatif *w, uint32_t pc, uint32_t value)
{
    w->is_comparing = false;
    w->step_count = 0;
    run_copy(w, pc, value);
    memcpy(w->sram_after_first_run, w->sram, HIL_SRAM_SIZE);
    memcpy(w->ccm_after_first_run, w->ccm, HIL_CCM_SIZE);
}

/* True if the memory at `base` differs between the runs, apart from the stack around the stack
 * pointer. */
static bool is_memory_different(const struct hil_whatif *w, const uint8_t *memory,
                                const uint8_t *first, uint32_t base, uint32_t size)
{
    if (!memcmp(memory, first, size))
        return false;
    for (uint32_t i = 0; i < size; i++)
        if (memory[i] != first[i] && base + i - (w->stack_pointer - STACK_BYTES_BELOW) >=
                                         STACK_BYTES_BELOW + STACK_BYTES_ABOVE)
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
    return is_memory_different(w, w->sram, w->sram_after_first_run, HIL_SRAM_BASE, HIL_SRAM_SIZE) ||
           is_memory_different(w, w->ccm, w->ccm_after_first_run, HIL_CCM_BASE, HIL_CCM_SIZE);
}

/* True if this load was tested often enough. */
static bool is_tested_enough(struct hil_whatif *w, uint32_t pc, uint32_t unknown)
{
    unsigned i = 0;
    uint32_t caller = 0; /* LR may be no return address; here it only distinguishes callers */
    uc_reg_read(w->core->uc, UC_ARM_REG_LR, &caller);
    while (i < REMEMBERED_LOADS_MAX && w->tested[i].test_count &&
           (w->tested[i].pc != pc || w->tested[i].caller != caller ||
            w->tested[i].unknown_bits != unknown))
        i++;
    if (i == REMEMBERED_LOADS_MAX)
        return false;
    w->tested[i].pc = pc;
    w->tested[i].caller = caller;
    w->tested[i].unknown_bits = unknown;
    return w->tested[i].test_count++ >= HIL_WHATIF_TESTS_PER_LOAD;
}

bool hil_whatif_has_effect(struct hil_core *core, uint32_t pc, uint32_t value, uint32_t unknown,
                           struct hil_whatif_difference *difference)
{
    static const uint32_t pattern[] = {0xffffffffu, 0x55555555u, 0xaaaaaaaau};
    struct hil_whatif *w = core->engine.whatif;
    bool matters = false;
    if (!w)
        w = core->engine.whatif = create_core_copy(core);
    if (is_tested_enough(w, pc, unknown))
        return false;
    run_reference(w, pc, value & ~unknown);
    for (unsigned i = 0; i < 3 && !matters; i++)
        matters = is_run_different(w, pc, (value & ~unknown) | (pattern[i] & unknown));
    *difference = (struct hil_whatif_difference){(unsigned)__builtin_ctz(unknown), w->last_pc};
    for (unsigned bit = 0; matters && bit < 32; bit++) {
        if ((unknown >> bit & 1u) && is_run_different(w, pc, (value & ~unknown) | 1u << bit)) {
            *difference = (struct hil_whatif_difference){bit, w->last_pc};
            break;
        }
    }
    return matters;
}
