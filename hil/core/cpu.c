#include "hil/core/cpu.h"

#include <stdlib.h>
#include <string.h>
#include <unicorn/unicorn.h>

#include "hil/core/bus.h"
#include "hil/core/core.h"
#include "hil/core/nvic.h"
#include "hil/core/whatif.h"

/* The Makefile builds bootrom.bin from hil/rom before it compiles this file. */
__asm__(".section .rodata\n"
        ".balign 4096\n"
        ".global hil_bootrom_image\n"
        "hil_bootrom_image:\n"
        ".incbin \"bootrom.bin\"\n"
        ".previous\n");

/* --- the address space --- */

/* Maps memory that stores do not change directly. The protection must be set after mapping;
 * otherwise Unicorn would execute a store that the memory hook has already handled. */
static void map_read_only(struct hil_core *core, uint32_t base, uint32_t size, const uint8_t *bytes,
                          bool readable)
{
    uint32_t protection = readable ? UC_PROT_READ | UC_PROT_EXEC : UC_PROT_EXEC;
    uc_check(
        uc_mem_map_ptr(core->uc, base, size, protection | UC_PROT_WRITE, (void *)(uintptr_t)bytes),
        "mapping flash or ROM");
    uc_check(uc_mem_protect(core->uc, base, size, protection), "protecting flash or ROM");
}

/* Maps address 0 to flash or, if `rom`, to the boot ROM. */
static void map_address_zero(struct hil_core *core, bool rom, bool readable)
{
    core->engine.is_rom_at_zero = rom;
    if (rom)
        map_read_only(core, 0, HIL_ROM_SIZE, hil_bootrom_image, true);
    else
        map_read_only(core, 0, HIL_FLASH_SIZE, core->memory->flash, readable);
}

static void unmap_address_zero(struct hil_core *core)
{
    uc_check(uc_mem_unmap(core->uc, 0, core->engine.is_rom_at_zero ? HIL_ROM_SIZE : HIL_FLASH_SIZE),
             "unmapping address 0");
}

/* Makes reads of flash call the memory hook: during an erase, because reads must wait, and after it
 * while the data cache may hold old content. This needs a new mapping, because only that empties
 * Unicorn's address cache. It takes a millisecond, so it is not done for each programmed word. */
static void intercept_flash_reads(struct hil_core *core, bool guarded)
{
    if (core->engine.are_flash_reads_intercepted == guarded)
        return;
    core->engine.are_flash_reads_intercepted = guarded;
    unmap_address_zero(core);
    uc_check(uc_mem_unmap(core->uc, HIL_FLASH_BASE, HIL_FLASH_SIZE), "unmapping flash");
    map_address_zero(core, core->engine.is_rom_at_zero, !guarded);
    map_read_only(core, HIL_FLASH_BASE, HIL_FLASH_SIZE, core->memory->flash, !guarded);
}

/* Maps flash or ROM at address 0 to match the state of the boot pin. */
void hil_cpu_map_boot_memory(struct hil_core *core)
{
    if (core->engine.is_rom_at_zero == core->state.bank.is_boot_rom_mapped)
        return;
    unmap_address_zero(core);
    map_address_zero(core, core->state.bank.is_boot_rom_mapped,
                     !core->engine.are_flash_reads_intercepted);
}

static bool is_flash_address(const struct hil_core *core, uint32_t address)
{
    return address - HIL_FLASH_BASE < HIL_FLASH_SIZE ||
           (address < HIL_FLASH_SIZE && !core->engine.is_rom_at_zero);
}

static bool on_invalid_memory(uc_engine *uc, uc_mem_type type, uint64_t address, int size,
                              int64_t value, void *user)
{
    struct hil_core *core = user;
    (void)uc;
    if (type == UC_MEM_WRITE_PROT && is_flash_address(core, (uint32_t)address)) {
        /* the store itself changes nothing: the flash controller does */
        if (core->engine.split_store_bytes_left) {
            core->engine.split_store_bytes_left--;
            return true;
        }
        core->bank_calls.store(core->bank_calls.context, (uint32_t)address, (unsigned)size,
                               (uint64_t)value);
        if (address % (unsigned)size) /* Unicorn reports an unaligned store again byte by byte */
            core->engine.split_store_bytes_left = (unsigned)size;
        return true;
    }
    if (type == UC_MEM_READ_PROT && core->engine.are_flash_reads_intercepted &&
        is_flash_address(core, (uint32_t)address)) {
        core->bank_calls.load(core->bank_calls.context, (uint32_t)address);
        return true;
    }
    core->engine.bad_address = (uint32_t)address;
    core->engine.bad_size = (uint32_t)size;
    core->engine.bad_instruction = (struct hil_instruction){core->state.cpu.block_address, 0};
    (void)hil_translator_find_instruction(&core->engine.translator, (uint32_t)address,
                                          &core->engine.bad_instruction);
    if (type == UC_MEM_WRITE_UNMAPPED || type == UC_MEM_WRITE_PROT)
        core->engine.translator.is_instruction_abandoned =
            hil_translator_can_leave_code(&core->engine.translator);
    return false;
}

static uint64_t on_mmio_read(uc_engine *uc, uint64_t offset, unsigned size, void *user)
{
    const struct hil_region *region = user;
    (void)uc;
    return hil_bus_read(region->core, region->base + (uint32_t)offset, size);
}

static void on_mmio_write(uc_engine *uc, uint64_t offset, unsigned size, uint64_t value, void *user)
{
    const struct hil_region *region = user;
    (void)uc;
    hil_bus_write(region->core, region->base + (uint32_t)offset, size, (uint32_t)value);
    const struct hil_observers *observers = &region->core->observers;
    if (observers->tracer)
        observers->tracer->sample_signals(observers->tracer_context, hil_now_cycle(region->core));
}

/* Maps the whole address space; aborts if Unicorn cannot. */
static void map_memories(struct hil_core *core)
{
    /* Address ranges without memory in which loads and stores go to the bus (RM0090 2.3, ARMv7-M
     * B3.1). The space between the option bytes and SRAM is not listed: an access there is a bus
     * fault, for example after a stack overflow. */
    static const struct {
        uint32_t base, size;
    } ranges[HIL_REGION_COUNT] = {
        {0x1fff7000u, 0x00006000u}, /* above the boot ROM: OTP, unique id, option bytes */
        {0x22000000u, 0x02000000u}, /* SRAM bit-band alias: refused */
        {0x40000000u, 0x02000000u}, /* APB1, APB2, AHB1 */
        {0x42000000u, 0x02000000u}, /* bit-band alias of the peripherals: refused */
        {0x50000000u, 0x10000000u}, /* AHB2 */
        {0xa0000000u, 0x00001000u}, /* FSMC registers */
        {0xe0000000u, 0x00100000u}, /* private peripheral bus */
    };
    map_address_zero(core, false, true);
    map_read_only(core, HIL_FLASH_BASE, HIL_FLASH_SIZE, core->memory->flash, true);
    map_read_only(core, HIL_ROM_BASE, HIL_ROM_SIZE, hil_bootrom_image, true);
    uc_check(
        uc_mem_map_ptr(core->uc, HIL_SRAM_BASE, HIL_SRAM_SIZE, UC_PROT_ALL, core->memory->sram),
        "mapping SRAM");
    if (!core->has_no_ccm)
        uc_check(uc_mem_map_ptr(core->uc, HIL_CCM_BASE, HIL_CCM_SIZE, UC_PROT_READ | UC_PROT_WRITE,
                                core->memory->ccm),
                 "mapping CCM");
    for (unsigned i = 0; i < HIL_REGION_COUNT; i++) {
        core->engine.regions[i] = (struct hil_region){core, ranges[i].base};
        uc_check(uc_mmio_map(core->uc, ranges[i].base, ranges[i].size, on_mmio_read,
                             &core->engine.regions[i], on_mmio_write, &core->engine.regions[i]),
                 "mapping peripherals");
    }
    uc_hook hook;
    uc_check(uc_hook_add(core->uc, &hook, UC_HOOK_MEM_INVALID, (void *)(uintptr_t)on_invalid_memory,
                         core, 1, 0),
             "memory hook");
}

/* --- blocks --- */

/* Why Unicorn returned, set by its hooks. */
enum {
    RETURNED_WITHOUT_REASON,
    RETURNED_EXC_RETURN,
    RETURNED_SVC,
    RETURNED_BKPT,
    RETURNED_NO_CODE,
    RETURNED_UNALIGNED,
    RETURNED_OTHER
};

#define REGISTER_XPSR   16u
#define XPSR_T          (1u << 24)
#define CCR_DIV_0_TRP   (1u << 4)
#define OPCODE_YIELD    0xbf10u
#define OPCODE_WFE      0xbf20u
#define OPCODE_WFI      0xbf30u
#define OPCODE_SEV      0xbf40u
#define MAX_BLOCK_BYTES 4096u /* Unicorn's blocks do not extend beyond a page */

static uint16_t read_halfword(const uint8_t *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

static bool is_32_bit_opcode(uint16_t first)
{
    return first >= 0xe800u;
}

static bool is_fp_opcode(uint16_t first, uint16_t second)
{
    unsigned coprocessor = second >> 8 & 0xfu;
    return (first & 0xec00u) == 0xec00u && (coprocessor == 10 || coprocessor == 11);
}

static bool is_fpu_disabled(const struct hil_core *core)
{
    return (core->state.scb.cpacr & 0xf00000u) != 0xf00000u;
}

/* UDIV, SDIV. ARMv7-M A5.3.17 */
static bool is_division_opcode(uint16_t first)
{
    return (first & 0xffd0u) == 0xfb90u;
}

/* True if a block with these flags must run instruction by instruction, because it may cause faults
 * that Unicorn does not emulate. */
static bool can_block_fault(const struct hil_core *core, unsigned flags)
{
    return ((flags & HIL_BLOCK_HAS_FP) && is_fpu_disabled(core)) ||
           ((flags & HIL_BLOCK_HAS_DIVISION) && (core->state.scb.ccr & CCR_DIV_0_TRP));
}

/* Counts the instructions of a block and finds those that need special handling. */
static struct hil_block_info inspect_block(struct hil_core *core, uint32_t address, uint32_t size)
{
    struct hil_block_info info = {.address = address, .size = (uint16_t)size};
    const uint8_t *code = hil_memory_at(core, address, size, false);
    unsigned count = 0;
    for (uint32_t i = 0; code && i + 2 <= size; count++) {
        uint16_t first = read_halfword(code + i);
        bool wide = is_32_bit_opcode(first);
        if (first == OPCODE_SEV)
            info.flags |= HIL_BLOCK_HAS_SEV;
        if (wide && i + 4 <= size && is_fp_opcode(first, read_halfword(code + i + 2)))
            info.flags |= HIL_BLOCK_HAS_FP;
        if (is_division_opcode(first))
            info.flags |= HIL_BLOCK_HAS_DIVISION;
        i += wide ? 4 : 2;
    }
    info.instruction_count = (uint8_t)(count ? count : 1);
    if (address - HIL_SRAM_BASE < HIL_SRAM_SIZE)
        hil_translator_check_ram_stores(&core->engine.translator);
    return info;
}

static const struct hil_block_info *get_block_info(struct hil_core *core, uint32_t address,
                                                   uint32_t size)
{
    struct hil_block_info *info = &core->engine.blocks[address >> 1 & (HIL_BLOCK_CACHE_SIZE - 1)];
    if (info->address != address || info->size != size)
        *info = inspect_block(core, address, size);
    return info;
}

/* Returns the time from now_cycle to the end of the block, in 1/HIL_PARTS_PER_CYCLE cycles. */
static uint64_t get_block_end_parts(const struct hil_core *core)
{
    const struct hil_cpu *cpu = &core->state.cpu;
    return (uint64_t)cpu->block_instruction_count * core->instruction_cycle_parts +
           cpu->uncounted_cycle_parts;
}

static void count_block(struct hil_core *core)
{
    struct hil_core_state *state = &core->state;
    uint64_t parts = get_block_end_parts(core);
    if (core->observers.profiler && state->cpu.block_instruction_count)
        core->observers.profiler->count_instructions(
            core->observers.profiler_context, state->cpu.block_address, state->cpu.block_size,
            state->cpu.block_instruction_count);
    state->clock.now_cycle += parts / HIL_PARTS_PER_CYCLE;
    state->cpu.uncounted_cycle_parts = parts % HIL_PARTS_PER_CYCLE;
    state->counters.instructions += state->cpu.block_instruction_count;
    state->cpu.block_instruction_count = 0;
}

/* Slow path of the block hook: handles events and decides whether the core must stop here. */
static bool is_stop_due(struct hil_core *core, uint32_t address)
{
    core->next_check_cycle = HIL_NEVER;
    hil_event_handle_due(core);
    if (core->next_check_cycle > core->state.events.next_cycle)
        core->next_check_cycle = core->state.events.next_cycle;
    if (core->is_stopped || core->has_reached_target || core->reset.is_requested ||
        core->state.clock.is_stopped)
        return true;
    if (core->state.bank.is_busy) {
        if (hil_memory_is_stalled(core, address))
            return true;
        core->next_check_cycle = 0;
    }
    intercept_flash_reads(core, core->state.bank.is_erasing || core->state.bank.stale_sectors);
    const struct hil_nvic *nvic = &core->state.nvic;
    if (nvic->next_exception && nvic->next_group_priority < nvic->active_group_priority) {
        if (hil_exception_next(core))
            return true;
        /* the exception is masked: check again at each block */
        core->next_check_cycle = 0;
    }
    return false;
}

static __attribute__((noinline)) void handle_block(uc_engine *uc, uint64_t address, uint32_t size,
                                                   struct hil_core *core)
{
    const struct hil_observers *observers = &core->observers;
    struct hil_core_state *state = &core->state;
    if (core->engine.single_step_state) {
        /* the first call is for the single instruction itself, so stop at the second */
        if (core->engine.single_step_state++ > 1)
            uc_emu_stop(uc);
        return;
    }
    count_block(core);
    if (observers->debugger &&
        observers->debugger->has_hit_watchpoint(observers->debugger_context)) {
        uc_emu_stop(uc);
        return;
    }
    if (state->clock.now_cycle >= core->next_check_cycle && is_stop_due(core, (uint32_t)address)) {
        uc_emu_stop(uc);
        return;
    }
    const struct hil_block_info *info = get_block_info(core, (uint32_t)address, size);
    if (info->flags & HIL_BLOCK_HAS_SEV)
        state->cpu.is_event_register_set = true;
    state->cpu.block_address = (uint32_t)address;
    state->cpu.block_size = size;
    state->cpu.block_instruction_count = info->instruction_count;
    if (can_block_fault(core, info->flags) ||
        (observers->debugger && observers->debugger->must_step_block(observers->debugger_context,
                                                                     (uint32_t)address, size))) {
        state->cpu.is_stepping = true;
        uc_emu_stop(uc);
    }
}

/* Called at the start of every block. Nearly all blocks only have to be counted. */
static void on_block(uc_engine *uc, uint64_t address, uint32_t size, void *user)
{
    struct hil_core *core = user;
    struct hil_core_state *state = &core->state;
    const struct hil_block_info *info =
        &core->engine.blocks[address >> 1 & (HIL_BLOCK_CACHE_SIZE - 1)];
    uint64_t parts = get_block_end_parts(core);
    uint64_t now_cycle = state->clock.now_cycle + parts / HIL_PARTS_PER_CYCLE;
    bool plain = info->flags == 0 ||
                 (!(info->flags & HIL_BLOCK_HAS_SEV) && !can_block_fault(core, info->flags));
    if (!plain || now_cycle >= core->next_check_cycle || info->address != address ||
        info->size != size || core->observers.debugger || core->observers.profiler ||
        core->engine.single_step_state) {
        handle_block(uc, address, size, core);
        return;
    }
    state->clock.now_cycle = now_cycle;
    state->cpu.uncounted_cycle_parts = parts % HIL_PARTS_PER_CYCLE;
    state->counters.instructions += state->cpu.block_instruction_count;
    state->cpu.block_address = (uint32_t)address;
    state->cpu.block_size = size;
    state->cpu.block_instruction_count = info->instruction_count;
}

/* Stops at a transfer that may fault; the rest of the block is then executed instruction by
 * instruction. */
static void on_checked_transfer(uc_engine *uc, uint64_t at, uint32_t size, void *user)
{
    struct hil_core *core = user;
    (void)size;
    if (core->engine.single_step_state || !hil_is_transfer_unaligned(core, (uint32_t)at))
        return;
    core->state.cpu.is_stepping = true;
    uc_emu_stop(uc);
}

static void on_interrupt(uc_engine *uc, uint32_t number, void *user)
{
    struct hil_core *core = user;
    core->engine.return_reason = number == 8 ? RETURNED_EXC_RETURN
                               : number == 2 ? RETURNED_SVC
                               : number == 7 ? RETURNED_BKPT
                               : number == 3 ? RETURNED_NO_CODE
                               : number == 4 ? RETURNED_UNALIGNED
                                             : RETURNED_OTHER;
    core->engine.return_interrupt = number;
    uc_emu_stop(uc);
}

void hil_cpu_create(struct hil_core *core)
{
    hil_translator_start(&core->engine.translator);
    uc_check(uc_open(UC_ARCH_ARM, UC_MODE_THUMB, &core->uc), "open");
    uc_check(uc_ctl_set_cpu_model(core->uc, UC_CPU_ARM_CORTEX_M4), "choosing the Cortex-M4");
    map_memories(core);
    /* select the translator first: during the first translation it obtains its reference to
     * Unicorn's processor */
    struct hil_translator *before = hil_translator_select(&core->engine.translator);
    uc_ctl_remove_cache(core->uc, HIL_FLASH_BASE, HIL_FLASH_BASE + 2u);
    hil_translator_select(before);
    uc_hook hook;
    uc_check(uc_hook_add(core->uc, &hook, UC_HOOK_BLOCK, (void *)(uintptr_t)on_block, core, 1, 0),
             "block hook");
    uc_check(
        uc_hook_add(core->uc, &hook, UC_HOOK_INTR, (void *)(uintptr_t)on_interrupt, core, 1, 0),
        "interrupt hook");
    if (core->is_alignment_checked)
        uc_check(uc_hook_add(core->uc, &hook, UC_HOOK_CODE, (void *)(uintptr_t)on_checked_transfer,
                             core, 1, 0),
                 "instruction hook");
}

void hil_cpu_destroy(struct hil_core *core)
{
    hil_whatif_destroy(core);
    if (core->uc)
        uc_close(core->uc);
}

void hil_cpu_discard_code(struct hil_core *core)
{
    memset(core->engine.blocks, 0, sizeof core->engine.blocks);
    /* discard this, because it holds translations and results of the old code */
    hil_whatif_destroy(core);
    if (!core->engine.is_rom_at_zero)
        uc_ctl_remove_cache(core->uc, 0x00000000u, HIL_FLASH_SIZE);
    uc_ctl_remove_cache(core->uc, HIL_FLASH_BASE, HIL_FLASH_BASE + HIL_FLASH_SIZE);
    uc_ctl_remove_cache(core->uc, HIL_SRAM_BASE, HIL_SRAM_BASE + HIL_SRAM_SIZE);
}

void hil_cpu_discard_range(struct hil_core *core, uint32_t address, uint32_t n)
{
    if (n >= HIL_BLOCK_CACHE_SIZE) {
        hil_cpu_discard_code(core);
        return;
    }
    /* A block that contains a changed byte begins at most MAX_BLOCK_BYTES before it. Flash at 0 and
     * at 0x08000000 share their cache entries. */
    for (uint32_t back = 0; back < n + MAX_BLOCK_BYTES; back += 2)
        core->engine.blocks[(address + n - 1u - back) >> 1 & (HIL_BLOCK_CACHE_SIZE - 1)].address =
            UINT32_MAX;
    hil_whatif_destroy(core);
    uc_ctl_remove_cache(core->uc, address, address + n);
    if (is_flash_address(core, address) && !core->engine.is_rom_at_zero) {
        uint32_t alias = address < HIL_FLASH_SIZE ? address + HIL_FLASH_BASE
                                                  : address - HIL_FLASH_BASE;
        uc_ctl_remove_cache(core->uc, alias, alias + n);
    }
}

/* ITSTATE is bits 26:25 and 15:10 (ARMv7-M B1.4.2). */
static uint32_t extract_itstate(uint32_t xpsr)
{
    return (xpsr >> 25 & 3u) | (xpsr >> 8 & 0xfcu);
}

/* Sets ITSTATE to its value before the faulting instruction, because the exception frame must
 * contain that value. */
static void set_itstate(struct hil_core *core, uint32_t itstate)
{
    uint32_t xpsr = hil_cpu_register(core, REGISTER_XPSR);
    xpsr = (xpsr & ~0x0600fc00u) | (itstate & 3u) << 25 | (itstate & 0xfcu) << 8;
    uc_reg_write(core->uc, UC_ARM_REG_XPSR_NZCVQG, &xpsr);
}

static uint32_t read_pc(const struct hil_core *core)
{
    uint32_t pc = 0;
    uc_reg_read(core->uc, UC_ARM_REG_PC, &pc);
    return pc;
}

/* Raises a fault of the instruction at `pc`. The instructions before it in the block must have been
 * counted. */
static void raise_fault(struct hil_core *core, uint32_t cfsr, uint32_t pc, uint32_t address)
{
    struct hil_cpu *cpu = &core->state.cpu;
    cpu->block_instruction_count = hil_count_instructions(core, cpu->block_address, pc);
    count_block(core);
    hil_exception_fault(core, cfsr, pc, address);
}

/* Handles an instruction that Unicorn does not execute: an undefined instruction, or WFE or YIELD;
 * for the latter, PC is already after it. */
static void handle_invalid_instruction(struct hil_core *core)
{
    uint32_t pc = read_pc(core) & ~1u;
    const uint8_t *before = hil_memory_at(core, pc - 2, 2, false);
    bool past = pc == core->state.cpu.block_address + core->state.cpu.block_size;
    uint16_t opcode = before && past ? read_halfword(before) : 0;
    if (opcode == OPCODE_WFE || opcode == OPCODE_YIELD) {
        count_block(core);
        core->state.cpu.is_asleep |= opcode == OPCODE_WFE && !core->state.cpu.is_event_register_set;
        core->state.cpu.is_event_register_set &= opcode != OPCODE_WFE;
        return;
    }
    const uint8_t *code = hil_memory_at(core, pc, 4, false);
    uint16_t first = code ? read_halfword(code) : 0;
    /* an instruction for an absent coprocessor; erased flash (0xffff) decodes as one (ARMv7-M
     * A5.3.18) */
    bool coprocessor = (first & 0xec00u) == 0xec00u && code &&
                       !is_fp_opcode(first, read_halfword(code + 2));
    bool thumb = (hil_cpu_register(core, REGISTER_XPSR) & XPSR_T) != 0;
    raise_fault(core,
                !thumb        ? HIL_CFSR_INVSTATE
                : coprocessor ? HIL_CFSR_NOCP
                              : HIL_CFSR_UNDEFINSTR,
                pc, 0);
}

static void handle_bad_memory(struct hil_core *core, uc_err err)
{
    uint32_t address = core->engine.bad_address;
    const struct hil_instruction place = core->engine.bad_instruction;
    if (err == UC_ERR_FETCH_UNMAPPED || err == UC_ERR_FETCH_PROT) {
        count_block(core);
        hil_exception_fault(core, HIL_CFSR_IBUSERR, read_pc(core) & ~1u, address);
        return;
    }
    if (err == UC_ERR_WRITE_PROT) {
        count_block(core);
        hil_core_stop(core, MR_UNMODELLED,
                      "unmodelled write of %u bytes to system memory at 0x%08x, PC 0x%08x",
                      (unsigned)core->engine.bad_size, (unsigned)address, (unsigned)place.pc);
        return;
    }
    set_itstate(core, place.itstate);
    raise_fault(core, HIL_CFSR_PRECISERR | HIL_CFSR_BFARVALID, place.pc, address);
}

static uc_err run_unicorn(struct hil_core *core, uint32_t pc, uint32_t until)
{
    struct hil_translator *before = hil_translator_select(&core->engine.translator);
    uc_err err = uc_emu_start(core->uc, pc | 1u, until, 0, 0);
    hil_translator_select(before);
    return err;
}

/* Handles Unicorn's return at the end of a block or inside it. `slept`: if there is no other reason
 * for the return, the core has executed WFI. */
static void handle_unicorn_return(struct hil_core *core, uc_err err, bool slept)
{
    switch (err) {
    case UC_ERR_OK: break;
    case UC_ERR_INSN_INVALID: handle_invalid_instruction(core); return;
    case UC_ERR_READ_UNMAPPED:
    case UC_ERR_WRITE_UNMAPPED:
    case UC_ERR_FETCH_UNMAPPED:
    case UC_ERR_WRITE_PROT:
    case UC_ERR_READ_PROT:
    case UC_ERR_FETCH_PROT: handle_bad_memory(core, err); return;
    default:
        hil_core_stop(core, MR_HALTED, "the CPU emulator failed at PC 0x%08x: %s",
                      (unsigned)read_pc(core), uc_strerror(err));
        return;
    }
    if (core->engine.return_reason == RETURNED_UNALIGNED) {
        raise_fault(core, HIL_CFSR_UNALIGNED, read_pc(core) & ~1u, 0);
        return;
    }
    if (core->engine.has_left_block) {
        core->engine.has_left_block = false;
        hil_cpu_leave_block(core);
        return;
    }
    count_block(core);
    switch (core->engine.return_reason) {
    case RETURNED_EXC_RETURN: hil_exception_return(core, read_pc(core) | 1u); break;
    case RETURNED_SVC: hil_exception_svc(core, read_pc(core)); break;
    case RETURNED_NO_CODE: /* code cannot be executed at this address (ARMv7-M B3.1) */
        hil_exception_fault(core, HIL_CFSR_IACCVIOL, read_pc(core) & ~1u, 0);
        break;
    case RETURNED_BKPT:
        if (core->observers.debugger)
            core->observers.debugger->handle_bkpt(core->observers.debugger_context);
        else
            hil_exception_bkpt(core, read_pc(core) & ~1u);
        break;
    case RETURNED_OTHER:
        hil_core_stop(core, MR_HALTED, "processor exception %u at PC 0x%08x",
                      (unsigned)core->engine.return_interrupt, (unsigned)read_pc(core));
        break;
    default: core->state.cpu.is_asleep |= slept; break;
    }
}

static uint32_t get_instruction_bytes(const struct hil_core *core, uint32_t pc, uint16_t *opcode)
{
    const uint8_t *code = hil_memory_at(core, pc, 2, false);
    *opcode = code ? read_halfword(code) : 0;
    return *opcode >= 0xe800u ? 4 : 2;
}

static void discard_block(struct hil_core *core)
{
    uint32_t start = core->state.cpu.block_address;
    uc_check(uc_ctl_remove_cache(core->uc, (uint64_t)start,
                                 (uint64_t)start + core->state.cpu.block_size),
             "forgetting a block");
}

/* Returns the CFSR bits if the instruction at `pc` causes a fault that Unicorn does not emulate; 0:
 * no fault. */
static uint32_t find_unemulated_fault(const struct hil_core *core, uint32_t pc)
{
    uint32_t xpsr = hil_cpu_register(core, REGISTER_XPSR);
    const uint8_t *code = hil_memory_at(core, pc, 4, false);
    uint32_t itstate = extract_itstate(xpsr);
    if (!code || (itstate && !hil_is_condition_met(xpsr, itstate >> 4)))
        return 0;
    if (is_fpu_disabled(core) && is_fp_opcode(read_halfword(code), read_halfword(code + 2)))
        return HIL_CFSR_NOCP;
    if (is_division_opcode(read_halfword(code)) && (core->state.scb.ccr & CCR_DIV_0_TRP) &&
        !hil_cpu_register(core, read_halfword(code + 2) & 15u))
        return HIL_CFSR_DIVBYZERO;
    return core->is_alignment_checked && hil_is_transfer_unaligned(core, pc) ? HIL_CFSR_UNALIGNED
                                                                             : 0;
}

/* Runs the block instruction by instruction, from the present one to its end or to a hold by the
 * debugger. The blocks translated for single instructions are discarded afterwards, because normal
 * execution would use them. */
static void run_by_instruction(struct hil_core *core)
{
    struct hil_cpu *cpu = &core->state.cpu;
    const struct hil_observers *observers = &core->observers;
    discard_block(core);
    for (;;) {
        uint16_t opcode;
        uint32_t pc = read_pc(core) & ~1u;
        uint32_t next = pc + get_instruction_bytes(core, pc, &opcode);
        bool last = next >= cpu->block_address + cpu->block_size;
        if (observers->debugger &&
            observers->debugger->must_stop_before(observers->debugger_context, pc)) {
            discard_block(core);
            return;
        }
        uint32_t cfsr = find_unemulated_fault(core, pc);
        if (cfsr) {
            cpu->is_stepping = false;
            discard_block(core);
            raise_fault(core, cfsr, pc, 0);
            return;
        }
        core->engine.single_step_state = 1;
        core->engine.return_reason = RETURNED_WITHOUT_REASON;
        uc_err err = run_unicorn(core, pc, last ? 0 : next);
        core->engine.single_step_state = 0;
        if (err != UC_ERR_OK || core->engine.return_reason != RETURNED_WITHOUT_REASON ||
            core->engine.has_left_block || last) {
            cpu->is_stepping = false;
            discard_block(core);
            handle_unicorn_return(core, err, opcode == OPCODE_WFI);
            return;
        }
    }
}

void hil_cpu_step_to_access(struct hil_core *core)
{
    if (core->engine.single_step_state || !hil_translator_can_leave_code(&core->engine.translator))
        return;
    core->state.cpu.is_stepping = true;
    uc_emu_stop(core->uc);
    hil_translator_leave_code(&core->engine.translator);
}

void hil_cpu_leave_block(struct hil_core *core)
{
    struct hil_cpu *cpu = &core->state.cpu;
    cpu->block_instruction_count = hil_count_instructions(core, cpu->block_address,
                                                          read_pc(core) & ~1u);
    count_block(core);
    cpu->is_stepping = false;
}

void hil_cpu_run(struct hil_core *core)
{
    intercept_flash_reads(core, core->state.bank.is_erasing || core->state.bank.stale_sectors);
    if (core->state.cpu.is_stepping) {
        run_by_instruction(core);
        return;
    }
    core->engine.return_reason = RETURNED_WITHOUT_REASON;
    uc_err err = run_unicorn(core, read_pc(core), 0);
    if (core->state.cpu.is_stepping)
        return; /* the caller continues at the start of the block */
    /* If Unicorn returned inside a block without a request, the core has executed WFI. */
    handle_unicorn_return(core, err, core->state.cpu.block_instruction_count != 0);
}

enum mr_status hil_cpu_poke(struct hil_core *core, uint32_t address, const void *bytes, size_t n)
{
    uint8_t *memory = n <= HIL_FLASH_SIZE ? hil_memory_at(core, address, (uint32_t)n, false) : NULL;
    if (!memory)
        return MR_UNKNOWN;
    memcpy(memory, bytes, n);
    hil_cpu_discard_range(core, address, (uint32_t)n);
    return MR_OK;
}

/* --- all registers --- */

void hil_cpu_load_registers(struct hil_core *core, const struct hil_cpu_registers *registers)
{
    uint32_t thread = XPSR_T;
    uint32_t none = 0;
    uint32_t pc = registers->pc | 1u;
    hil_whatif_reset(core);
    hil_cpu_map_boot_memory(core);
    /* First switch to privileged thread mode on MSP, in which all registers can be set. Set the
     * mode last. */
    uc_reg_write(core->uc, UC_ARM_REG_XPSR_NZCVQG, &thread);
    uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &none);
    for (int i = 0; i < 13; i++)
        uc_reg_write(core->uc, UC_ARM_REG_R0 + i, &registers->r[i]);
    for (int i = 0; i < 16; i++)
        uc_reg_write(core->uc, UC_ARM_REG_D0 + i, &registers->d[i]);
    uc_reg_write(core->uc, UC_ARM_REG_FPSCR, &registers->fpscr);
    uc_reg_write(core->uc, UC_ARM_REG_PRIMASK, &registers->primask);
    uc_reg_write(core->uc, UC_ARM_REG_BASEPRI, &registers->basepri);
    uc_reg_write(core->uc, UC_ARM_REG_FAULTMASK, &registers->faultmask);
    uint32_t control = registers->control & ~1u;
    uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &control);
    uc_reg_write(core->uc, UC_ARM_REG_XPSR_NZCVQG, &registers->xpsr);
    uc_reg_write(core->uc, UC_ARM_REG_MSP, &registers->msp);
    uc_reg_write(core->uc, UC_ARM_REG_PSP, &registers->psp);
    uc_reg_write(core->uc, UC_ARM_REG_LR, &registers->lr);
    uc_reg_write(core->uc, UC_ARM_REG_PC, &pc);
    if (registers->control & 1u)
        uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &registers->control);
    uint32_t apsr = 0;
    uc_reg_read(core->uc, UC_ARM_REG_APSR_NZCV, &apsr);
    uc_reg_write(core->uc, UC_ARM_REG_APSR_NZCV, &apsr);
}

void hil_cpu_reset(struct hil_core *core)
{
    struct hil_cpu_registers registers = {.lr = 0xffffffffu, .xpsr = XPSR_T};
    /* BOOT0 selects the memory at address 0. */
    const uint8_t *table = core->state.bank.is_boot_rom_mapped ? hil_bootrom_image
                                                               : core->memory->flash;
    hil_cpu_map_boot_memory(core);
    memcpy(&registers.msp, table, 4);
    memcpy(&registers.pc, table + 4, 4);
    registers.msp &= ~3u;
    hil_cpu_load_registers(core, &registers);
    core->state.cpu = (struct hil_cpu){0};
    hil_exception_trace(core);
    if (!(registers.pc & 1u) || registers.pc == 0xffffffffu)
        hil_core_stop(core, MR_HALTED, "no firmware: the reset vector is 0x%08x",
                      (unsigned)registers.pc);
}

/* --- stuck bits of RAM --- */

static void set_stuck_bit(struct hil_core *core, unsigned i)
{
    uint8_t *cell = hil_memory_at(core, core->state.stuck_bits.bit[i].address, 1, true);
    if (!cell)
        return;
    uint8_t mask = core->state.stuck_bits.bit[i].mask;
    *cell = (uint8_t)(core->state.stuck_bits.bit[i].level ? *cell | mask : *cell & ~mask);
}

static void on_checked_load(struct uc_struct *uc, int type, uint64_t address, int size,
                            int64_t value, void *context)
{
    struct hil_core *core = context;
    (void)uc;
    (void)type;
    (void)value;
    for (unsigned i = 0; i < core->state.stuck_bits.count; i++) {
        uint32_t at = core->state.stuck_bits.bit[i].address;
        if (at >= address && at < address + (uint64_t)size)
            set_stuck_bit(core, i);
    }
}

void hil_stuck_bits_enable(struct hil_core *core)
{
    uc_hook hook;
    if (!core->state.stuck_bits.count || core->engine.is_checking_loads)
        return;
    core->engine.is_checking_loads =
        uc_hook_add(core->uc, &hook, UC_HOOK_MEM_READ, (void *)(uintptr_t)on_checked_load, core,
                    HIL_CCM_BASE, HIL_SRAM_BASE + HIL_SRAM_SIZE - 1u) == UC_ERR_OK;
    hil_cpu_discard_code(core); /* discard code that was translated without the load hook */
}

bool hil_stuck_bit_add(struct hil_core *core, uint32_t address, unsigned bit, bool level)
{
    struct hil_stuck_bits *stuck = &core->state.stuck_bits;
    if (stuck->count == HIL_STUCK_BITS_MAX)
        return false;
    stuck->bit[stuck->count].address = address + bit / 8u;
    stuck->bit[stuck->count].mask = (uint8_t)(1u << bit % 8u);
    stuck->bit[stuck->count].level = level;
    set_stuck_bit(core, stuck->count++);
    hil_stuck_bits_enable(core);
    return true;
}
