#include "hil/core/cpu.h"

#include <stdlib.h>
#include <string.h>
#include <unicorn/unicorn.h>

#include "hil/debug/debug.h"
#include "hil/board/machine.h"
#include "hil/debug/profile.h"
#include "hil/debug/vcd.h"

/* Why Unicorn came back, told by its hooks. */
enum { CAME_BACK_UNALIGNED = -2, CAME_BACK_NOCP = -1, CAME_BACK_PLAIN, CAME_BACK_RETURN, CAME_BACK_SVC, CAME_BACK_BKPT, CAME_BACK_OTHER };

#define XPSR_T (1u << 24)
#define OPCODE_YIELD 0xbf10u
#define OPCODE_WFE 0xbf20u
#define OPCODE_WFI 0xbf30u
#define OPCODE_SEV 0xbf40u
#define MAX_FP_SEARCH 256u
#define MAX_BLOCK_BYTES 4096u /* translation does not cross a page */

static void must(uc_err err, const char *what)
{
    if (err == UC_ERR_OK)
        return;
    fprintf(stderr, "matrig-board: the CPU emulator failed: %s: %s\n", what, uc_strerror(err));
    abort();
}

/* Memory that stores do not change. Only a later change of its protection makes Unicorn discard a store that the
 * memory hook has taken; as mapped, it would carry it out. */
static void map_read_only(struct hil_board *board, uint32_t base, uint32_t size, const uint8_t *bytes, bool readable)
{
    uint32_t protection = readable ? UC_PROT_READ | UC_PROT_EXEC : UC_PROT_EXEC;
    must(uc_mem_map_ptr(board->uc, base, size, protection | UC_PROT_WRITE, (void *)(uintptr_t)bytes),
         "mapping flash or ROM");
    must(uc_mem_protect(board->uc, base, size, protection), "protecting flash or ROM");
}

/* What is at address 0: flash, or after BOOT0 the ROM. */
static void map_zero(struct hil_board *board, bool rom, bool readable)
{
    board->rom_at_zero = rom;
    if (rom)
        map_read_only(board, 0, HIL_ROM_SIZE, hil_bootrom_image, true);
    else
        map_read_only(board, 0, HIL_FLASH_SIZE, board->memory->flash, readable);
}

static void unmap_zero(struct hil_board *board)
{
    must(uc_mem_unmap(board->uc, 0, board->rom_at_zero ? HIL_ROM_SIZE : HIL_FLASH_SIZE), "unmapping address 0");
}

/* While an erase runs beside code in RAM, reads of flash must be caught, for they wait. Mapping anew is the one way
 * that empties the core's address cache; it takes too long (a millisecond) to do it for single words. */
static void guard_flash(struct hil_board *board, bool guarded)
{
    if (board->flash_guarded == guarded)
        return;
    board->flash_guarded = guarded;
    unmap_zero(board);
    must(uc_mem_unmap(board->uc, HIL_FLASH_BASE, HIL_FLASH_SIZE), "unmapping flash");
    map_zero(board, board->rom_at_zero, !guarded);
    map_read_only(board, HIL_FLASH_BASE, HIL_FLASH_SIZE, board->memory->flash, !guarded);
}

/* Make address 0 what the state says. */
static void follow_boot_pin(struct hil_board *board)
{
    if (board->rom_at_zero == board->state.flash.boot_rom)
        return;
    unmap_zero(board);
    map_zero(board, board->state.flash.boot_rom, !board->flash_guarded);
}

static uint16_t halfword(const uint8_t *p) { return (uint16_t)(p[0] | p[1] << 8); }

static bool is_wide(uint16_t first) { return first >= 0xe800u; }

static bool is_fp(uint16_t first, uint16_t second)
{
    unsigned coprocessor = second >> 8 & 0xfu;
    return (first & 0xec00u) == 0xec00u && (coprocessor == 10 || coprocessor == 11);
}

/* Count the instructions of a block and look for those that need watching. */
static struct hil_block_info inspect_block(struct hil_board *board, uint32_t address, uint32_t size)
{
    struct hil_block_info info = {.address = address, .size = (uint16_t)size};
    const uint8_t *code = hil_board_memory(board, address, size, false);
    unsigned count = 0;
    for (uint32_t i = 0; code && i + 2 <= size; count++) {
        uint16_t first = halfword(code + i);
        bool wide = is_wide(first);
        if (first == OPCODE_SEV)
            info.flags |= HIL_BLOCK_SEV;
        if (wide && i + 4 <= size && is_fp(first, halfword(code + i + 2)))
            info.flags |= HIL_BLOCK_FP;
        i += wide ? 4 : 2;
    }
    info.instructions = (uint8_t)(count ? count : 1);
    if (address - HIL_SRAM_BASE < HIL_SRAM_SIZE)
        hil_stores_meet_code(&board->stores);
    if (board->profile)
        info.profile_block = hil_profile_block(board, address, size);
    if (board->vcd && hil_vcd_marks(board->vcd, address))
        info.flags |= HIL_BLOCK_MARKED;
    if (board->pin_times && hil_pin_times_wants(board->pin_times, address, size))
        info.flags |= HIL_BLOCK_WALKED;
    return info;
}

static const struct hil_block_info *block_info(struct hil_board *board, uint32_t address, uint32_t size)
{
    struct hil_block_info *info = &board->blocks[address >> 1 & (HIL_BLOCK_CACHE - 1)];
    if (info->address != address || info->size != size)
        *info = inspect_block(board, address, size);
    return info;
}

static void count_block(struct hil_board *board)
{
    struct hil_state *state = &board->state;
    if (board->profile && state->cpu.block_instructions)
        hil_profile_count(board, board->profile_block, state->cpu.block_instructions);
    state->clock.now_cycle += state->cpu.block_instructions;
    state->counters.instructions += state->cpu.block_instructions;
    state->cpu.block_instructions = 0;
}

/* The slow path of the block hook: treat events, find out whether the core must stop here. */
static bool must_stop(struct hil_board *board, uint32_t address)
{
    board->limit_cycle = HIL_NEVER;
    hil_event_run(board);
    if (board->limit_cycle > board->state.events.next_cycle)
        board->limit_cycle = board->state.events.next_cycle;
    if (board->stopped || board->target_reached || board->reset_request || board->state.rcc.no_clock)
        return true;
    if (hil_flash_busy(board)) {
        if (hil_flash_stalls(board, address))
            return true;
        board->limit_cycle = 0;
    }
    guard_flash(board, hil_flash_erases(board));
    const struct hil_nvic *nvic = &board->state.nvic;
    if (nvic->best && nvic->best_group < nvic->active_group) {
        if (hil_exception_due(board))
            return true;
        board->limit_cycle = 0; /* masked: look again at every block until it is not */
    }
    return false;
}

static __attribute__((noinline)) void treat_block(uc_engine *uc, uint64_t address, uint32_t size,
                                                  struct hil_board *board)
{
    struct hil_state *state = &board->state;
    if (board->runs_to_fp)
        return;
    if (board->single) { /* no block of the run, but the instruction, and whatever follows it */
        if (board->single++ > 1)
            uc_emu_stop(uc);
        return;
    }
    count_block(board);
    if (board->debug && board->debug->watch_hit) {
        hil_debug_hold(board, HIL_HOLD_WATCHPOINT);
        uc_emu_stop(uc);
        return;
    }
    if (state->clock.now_cycle >= board->limit_cycle && must_stop(board, (uint32_t)address)) {
        uc_emu_stop(uc);
        return;
    }
    const struct hil_block_info *info = block_info(board, (uint32_t)address, size);
    if (info->flags) {
        if (info->flags & HIL_BLOCK_MARKED)
            hil_vcd_block(board, (uint32_t)address);
        if (info->flags & HIL_BLOCK_SEV)
            state->cpu.event = true;
        if ((info->flags & HIL_BLOCK_FP) && (state->scb.cpacr & 0xf00000u) != 0xf00000u) {
            board->came_back = CAME_BACK_NOCP;
            uc_emu_stop(uc);
            return;
        }
    }
    state->cpu.block_address = (uint32_t)address;
    state->cpu.block_size = size;
    state->cpu.block_instructions = info->instructions;
    board->profile_block = info->profile_block;
    if ((info->flags & HIL_BLOCK_WALKED) || (board->debug && hil_debug_wants(board, (uint32_t)address, size))) {
        state->cpu.walking = true;
        uc_emu_stop(uc);
    }
}

/* Hardly any block needs more than to be counted; this runs for every one. */
static void on_block(uc_engine *uc, uint64_t address, uint32_t size, void *user)
{
    struct hil_board *board = user;
    struct hil_state *state = &board->state;
    const struct hil_block_info *info = &board->blocks[address >> 1 & (HIL_BLOCK_CACHE - 1)];
    uint64_t now_cycle = state->clock.now_cycle + state->cpu.block_instructions;
    bool plain = info->flags == 0 || (info->flags == HIL_BLOCK_FP && (state->scb.cpacr & 0xf00000u) == 0xf00000u);
    if (!plain || now_cycle >= board->limit_cycle || info->address != address || info->size != size || board->debug
        || board->profile || board->single || board->runs_to_fp) {
        treat_block(uc, address, size, board);
        return;
    }
    state->clock.now_cycle = now_cycle;
    state->counters.instructions += state->cpu.block_instructions;
    state->cpu.block_address = (uint32_t)address;
    state->cpu.block_size = size;
    state->cpu.block_instructions = info->instructions;
}

static void on_transfer(uc_engine *uc, uint64_t at, uint32_t size, void *user)
{
    struct hil_board *board = user;
    uint32_t address;
    (void)size;
    if (!hil_cpu_transfer_address(board, (uint32_t)at, &address) || !(address & 3u))
        return;
    board->came_back = CAME_BACK_UNALIGNED;
    board->bad_address = (uint32_t)at;
    uc_emu_stop(uc);
}

static void on_interrupt(uc_engine *uc, uint32_t number, void *user)
{
    struct hil_board *board = user;
    board->came_back = number == 8 ? CAME_BACK_RETURN
                       : number == 2 ? CAME_BACK_SVC
                       : number == 7 ? CAME_BACK_BKPT
                                     : CAME_BACK_OTHER;
    board->came_back_number = number;
    uc_emu_stop(uc);
}

static bool is_flash(const struct hil_board *board, uint32_t address)
{
    return address - HIL_FLASH_BASE < HIL_FLASH_SIZE || (address < HIL_FLASH_SIZE && !board->rom_at_zero);
}

static bool on_invalid_memory(uc_engine *uc, uc_mem_type type, uint64_t address, int size, int64_t value,
                              void *user)
{
    struct hil_board *board = user;
    (void)uc;
    if (type == UC_MEM_WRITE_PROT && is_flash(board, (uint32_t)address)) { /* the memory itself does not change now */
        if (board->split_bytes) {
            board->split_bytes--;
            return true;
        }
        hil_flash_store(board, (uint32_t)address, (unsigned)size, (uint64_t)value);
        if (address % (unsigned)size) /* Unicorn comes again with each byte */
            board->split_bytes = (unsigned)size;
        return true;
    }
    if (type == UC_MEM_READ_PROT && board->flash_guarded && is_flash(board, (uint32_t)address)) {
        hil_flash_wait(board);
        return true;
    }
    board->bad_address = (uint32_t)address;
    board->bad_size = (uint32_t)size;
    board->bad_type = (int)type;
    return false;
}

static uint64_t on_mmio_read(uc_engine *uc, uint64_t offset, unsigned size, void *user)
{
    const struct hil_region *region = user;
    (void)uc;
    return hil_bus_read(region->board, region->base + (uint32_t)offset, size);
}

static void on_mmio_write(uc_engine *uc, uint64_t offset, unsigned size, uint64_t value, void *user)
{
    const struct hil_region *region = user;
    (void)uc;
    hil_bus_write(region->board, region->base + (uint32_t)offset, size, (uint32_t)value);
    if (region->board->vcd)
        hil_vcd_sample(region->board, hil_now(region->board));
}

void hil_cpu_create(struct hil_board *board)
{
    /* Address ranges that answer to loads and stores but are no memory (RM0090 2.3, ARMv7-M B3.1). */
    static const struct { uint32_t base, size; } ranges[HIL_REGIONS] = {
        {0x1fff7000u, 0x00009000u}, /* above the boot ROM: OTP, unique id, option bytes */
        {0x22000000u, 0x02000000u}, /* SRAM bit-band alias */
        {0x40000000u, 0x02000000u}, /* APB1, APB2, AHB1 */
        {0x42000000u, 0x02000000u}, /* their bit-band alias */
        {0x50000000u, 0x10000000u}, /* AHB2 */
        {0xa0000000u, 0x00001000u}, /* FSMC registers */
        {0xe0000000u, 0x00100000u}, /* private peripheral bus */
    };
    hil_stores_start(&board->stores);
    must(uc_open(UC_ARCH_ARM, UC_MODE_THUMB, &board->uc), "open");
    must(uc_ctl_set_cpu_model(board->uc, UC_CPU_ARM_CORTEX_M4), "choosing the Cortex-M4");
    map_zero(board, false, true);
    map_read_only(board, HIL_FLASH_BASE, HIL_FLASH_SIZE, board->memory->flash, true);
    map_read_only(board, HIL_ROM_BASE, HIL_ROM_SIZE, hil_bootrom_image, true);
    must(uc_mem_map_ptr(board->uc, HIL_SRAM_BASE, HIL_SRAM_SIZE, UC_PROT_ALL, board->memory->sram),
         "mapping SRAM");
    must(uc_mem_map_ptr(board->uc, HIL_CCM_BASE, HIL_CCM_SIZE, UC_PROT_READ | UC_PROT_WRITE,
                        board->memory->ccm),
         "mapping CCM");
    for (unsigned i = 0; i < HIL_REGIONS; i++) {
        board->regions[i] = (struct hil_region){board, ranges[i].base};
        must(uc_mmio_map(board->uc, ranges[i].base, ranges[i].size, on_mmio_read, &board->regions[i],
                         on_mmio_write,
                         &board->regions[i]),
             "mapping peripherals");
    }
    uc_hook hook;
    must(uc_hook_add(board->uc, &hook, UC_HOOK_BLOCK, (void *)(uintptr_t)on_block, board, 1, 0),
         "block hook");
    must(uc_hook_add(board->uc, &hook, UC_HOOK_INTR, (void *)(uintptr_t)on_interrupt, board, 1, 0),
         "interrupt hook");
    if (board->options.watch_alignment)
        must(uc_hook_add(board->uc, &hook, UC_HOOK_CODE, (void *)(uintptr_t)on_transfer, board, 1, 0),
             "instruction hook");
    must(uc_hook_add(board->uc, &hook, UC_HOOK_MEM_INVALID, (void *)(uintptr_t)on_invalid_memory, board, 1,
                     0),
         "memory hook");
}

void hil_cpu_destroy(struct hil_board *board)
{
    if (board->uc)
        uc_close(board->uc);
}

void hil_cpu_forget_code(struct hil_board *board)
{
    memset(board->blocks, 0, sizeof board->blocks);
    if (!board->rom_at_zero)
        uc_ctl_remove_cache(board->uc, 0x00000000u, HIL_FLASH_SIZE);
    uc_ctl_remove_cache(board->uc, HIL_FLASH_BASE, HIL_FLASH_BASE + HIL_FLASH_SIZE);
    uc_ctl_remove_cache(board->uc, HIL_SRAM_BASE, HIL_SRAM_BASE + HIL_SRAM_SIZE);
}

void hil_cpu_forget_range(struct hil_board *board, uint32_t address, uint32_t n)
{
    if (n >= HIL_BLOCK_CACHE) {
        hil_cpu_forget_code(board);
        return;
    }
    /* A block that holds a changed byte begins at most its own length before it; aliases of flash share a place. */
    for (uint32_t back = 0; back < n + MAX_BLOCK_BYTES; back += 2)
        board->blocks[(address + n - 1u - back) >> 1 & (HIL_BLOCK_CACHE - 1)].address = UINT32_MAX;
    uc_ctl_remove_cache(board->uc, address, address + n);
    if (is_flash(board, address) && !board->rom_at_zero) {
        uint32_t alias = address < HIL_FLASH_SIZE ? address + HIL_FLASH_BASE : address - HIL_FLASH_BASE;
        uc_ctl_remove_cache(board->uc, alias, alias + n);
    }
}

void hil_cpu_inspect_again(struct hil_board *board, uint32_t address)
{
    board->blocks[address >> 1 & (HIL_BLOCK_CACHE - 1)].size = 0;
}

void hil_cpu_attend(struct hil_board *board) { board->limit_cycle = 0; }

void hil_cpu_save(const struct hil_board *board, struct hil_cpu_registers *registers)
{
    *registers = (struct hil_cpu_registers){0};
    for (int i = 0; i < 13; i++)
        uc_reg_read(board->uc, UC_ARM_REG_R0 + i, &registers->r[i]);
    for (int i = 0; i < 16; i++)
        uc_reg_read(board->uc, UC_ARM_REG_D0 + i, &registers->d[i]);
    uc_reg_read(board->uc, UC_ARM_REG_MSP, &registers->msp);
    uc_reg_read(board->uc, UC_ARM_REG_PSP, &registers->psp);
    uc_reg_read(board->uc, UC_ARM_REG_LR, &registers->lr);
    uc_reg_read(board->uc, UC_ARM_REG_PC, &registers->pc);
    uc_reg_read(board->uc, UC_ARM_REG_XPSR, &registers->xpsr);
    uc_reg_read(board->uc, UC_ARM_REG_CONTROL, &registers->control);
    uc_reg_read(board->uc, UC_ARM_REG_PRIMASK, &registers->primask);
    uc_reg_read(board->uc, UC_ARM_REG_BASEPRI, &registers->basepri);
    uc_reg_read(board->uc, UC_ARM_REG_FAULTMASK, &registers->faultmask);
    uc_reg_read(board->uc, UC_ARM_REG_FPSCR, &registers->fpscr);
}

void hil_cpu_load(struct hil_board *board, const struct hil_cpu_registers *registers)
{
    uint32_t thread = XPSR_T;
    uint32_t none = 0;
    uint32_t pc = registers->pc | 1u;
    follow_boot_pin(board);
    /* From any state to privileged thread mode on MSP, then everything, then the mode. */
    uc_reg_write(board->uc, UC_ARM_REG_XPSR_NZCVQG, &thread);
    uc_reg_write(board->uc, UC_ARM_REG_CONTROL, &none);
    for (int i = 0; i < 13; i++)
        uc_reg_write(board->uc, UC_ARM_REG_R0 + i, &registers->r[i]);
    for (int i = 0; i < 16; i++)
        uc_reg_write(board->uc, UC_ARM_REG_D0 + i, &registers->d[i]);
    uc_reg_write(board->uc, UC_ARM_REG_FPSCR, &registers->fpscr);
    uc_reg_write(board->uc, UC_ARM_REG_PRIMASK, &registers->primask);
    uc_reg_write(board->uc, UC_ARM_REG_BASEPRI, &registers->basepri);
    uc_reg_write(board->uc, UC_ARM_REG_FAULTMASK, &registers->faultmask);
    uint32_t control = registers->control & ~1u;
    uc_reg_write(board->uc, UC_ARM_REG_CONTROL, &control);
    uc_reg_write(board->uc, UC_ARM_REG_XPSR_NZCVQG, &registers->xpsr);
    uc_reg_write(board->uc, UC_ARM_REG_MSP, &registers->msp);
    uc_reg_write(board->uc, UC_ARM_REG_PSP, &registers->psp);
    uc_reg_write(board->uc, UC_ARM_REG_LR, &registers->lr);
    uc_reg_write(board->uc, UC_ARM_REG_PC, &pc);
    if (registers->control & 1u)
        uc_reg_write(board->uc, UC_ARM_REG_CONTROL, &registers->control);
    uint32_t apsr = 0;
    uc_reg_read(board->uc, UC_ARM_REG_APSR_NZCV, &apsr);
    uc_reg_write(board->uc, UC_ARM_REG_APSR_NZCV, &apsr);
}

void hil_cpu_reset(struct hil_board *board)
{
    struct hil_cpu_registers registers = {.lr = 0xffffffffu, .xpsr = XPSR_T};
    /* What BOOT0 chose is aliased at 0. */
    const uint8_t *table = board->state.flash.boot_rom ? hil_bootrom_image : board->memory->flash;
    follow_boot_pin(board);
    memcpy(&registers.msp, table, 4);
    memcpy(&registers.pc, table + 4, 4);
    registers.msp &= ~3u;
    hil_cpu_load(board, &registers);
    board->state.cpu = (struct hil_cpu){0};
    hil_exception_seen(board, 0);
    if (!(registers.pc & 1u) || registers.pc == 0xffffffffu)
        hil_board_stop(board, MR_HALTED, "no firmware: the reset vector is 0x%08x", (unsigned)registers.pc);
}

static uint32_t read_pc(const struct hil_board *board)
{
    uint32_t pc = 0;
    uc_reg_read(board->uc, UC_ARM_REG_PC, &pc);
    return pc;
}

/* Unicorn stopped at an instruction it does not execute: WFE and YIELD (PC already past) or an undefined
 * one. */
static void treat_invalid(struct hil_board *board)
{
    uint32_t pc = read_pc(board) & ~1u;
    const uint8_t *before = hil_board_memory(board, pc - 2, 2, false);
    bool past = pc == board->state.cpu.block_address + board->state.cpu.block_size;
    uint16_t opcode = before && past ? halfword(before) : 0;
    count_block(board);
    if (opcode == OPCODE_WFE) {
        if (board->state.cpu.event)
            board->state.cpu.event = false;
        else
            board->state.cpu.asleep = true;
    } else if (opcode != OPCODE_YIELD) {
        const uint8_t *code = hil_board_memory(board, pc, 4, false);
        uint16_t first = code ? halfword(code) : 0;
        /* A coprocessor that is not there; erased flash (0xffff) reads as such (ARMv7-M A5.3.18). */
        bool coprocessor = (first & 0xec00u) == 0xec00u && code && !is_fp(first, halfword(code + 2));
        hil_exception_fault(board, coprocessor ? HIL_CFSR_NOCP : HIL_CFSR_UNDEFINSTR, pc, 0);
    }
}

static void treat_bad_memory(struct hil_board *board, uc_err err)
{
    uint32_t address = board->bad_address;
    count_block(board);
    if (err == UC_ERR_FETCH_UNMAPPED || err == UC_ERR_FETCH_PROT) {
        hil_exception_fault(board, HIL_CFSR_IBUSERR, read_pc(board) & ~1u, address);
        return;
    }
    bool write = err == UC_ERR_WRITE_UNMAPPED || err == UC_ERR_WRITE_PROT;
    uint32_t pc = hil_cpu_access_pc(board, address, write);
    if (err == UC_ERR_WRITE_PROT) {
        hil_board_stop(board, MR_UNMODELLED, "unmodelled write of %u bytes to system memory at 0x%08x, PC 0x%08x",
                       (unsigned)board->bad_size, (unsigned)address, (unsigned)pc);
        return;
    }
    hil_exception_fault(board, HIL_CFSR_PRECISERR | HIL_CFSR_BFARVALID, pc, address);
}

static uc_err start(struct hil_board *board, uint32_t pc, uint32_t until)
{
    hil_stores_run(&board->stores);
    uc_err err = uc_emu_start(board->uc, pc | 1u, until, 0, 0);
    hil_stores_run(NULL);
    return err;
}

/* A block with floating point while the unit is off: run it up to there, then fault. */
static void treat_fp_off(struct hil_board *board)
{
    uint32_t from = read_pc(board) & ~1u, at = from;
    const uint8_t *code = hil_board_memory(board, from, MAX_FP_SEARCH, false);
    uint32_t left = code ? MAX_FP_SEARCH : 0;
    for (; left >= 4 && !is_fp(halfword(code), halfword(code + 2));) {
        uint32_t bytes = is_wide(halfword(code)) ? 4 : 2;
        at += bytes;
        code += bytes;
        left -= bytes;
        board->state.clock.now_cycle++;
        board->state.counters.instructions++;
    }
    if (at != from) {
        uc_ctl_remove_cache(board->uc, from, at + 4u);
        board->runs_to_fp = true;
        uc_err err = start(board, from, at);
        board->runs_to_fp = false;
        if (err != UC_ERR_OK || (read_pc(board) & ~1u) != at) {
            hil_board_stop(board, MR_HALTED, "floating point near PC 0x%08x while CPACR keeps the unit off",
                           (unsigned)at);
            return;
        }
    }
    hil_exception_fault(board, HIL_CFSR_NOCP, at, 0);
}

/* The core came back from the end of a block or from inside it. `slept`: by WFI, if nothing else. */
static void treat_return(struct hil_board *board, uc_err err, bool slept)
{
    switch (err) {
    case UC_ERR_OK:
        break;
    case UC_ERR_INSN_INVALID:
        treat_invalid(board);
        return;
    case UC_ERR_READ_UNMAPPED:
    case UC_ERR_WRITE_UNMAPPED:
    case UC_ERR_FETCH_UNMAPPED:
    case UC_ERR_WRITE_PROT:
    case UC_ERR_READ_PROT:
    case UC_ERR_FETCH_PROT:
        treat_bad_memory(board, err);
        return;
    default:
        hil_board_stop(board, MR_HALTED, "the CPU emulator failed at PC 0x%08x: %s", (unsigned)read_pc(board),
                       uc_strerror(err));
        return;
    }
    count_block(board);
    switch (board->came_back) {
    case CAME_BACK_RETURN:
        hil_exception_return(board, read_pc(board) | 1u);
        break;
    case CAME_BACK_NOCP:
        treat_fp_off(board);
        break;
    case CAME_BACK_UNALIGNED:
        hil_exception_fault(board, HIL_CFSR_UNALIGNED, board->bad_address, 0);
        break;
    case CAME_BACK_SVC:
        hil_exception_svc(board, read_pc(board));
        break;
    case CAME_BACK_BKPT:
        if (board->debug)
            hil_debug_hold(board, HIL_HOLD_BKPT);
        else
            hil_exception_bkpt(board, read_pc(board) & ~1u);
        break;
    case CAME_BACK_OTHER:
        hil_board_stop(board, MR_HALTED, "processor exception %u at PC 0x%08x",
                       (unsigned)board->came_back_number,
                       (unsigned)read_pc(board));
        break;
    default:
        board->state.cpu.asleep |= slept;
        break;
    }
}

static uint32_t instruction_bytes(const struct hil_board *board, uint32_t pc, uint16_t *opcode)
{
    const uint8_t *code = hil_board_memory(board, pc, 2, false);
    *opcode = code ? halfword(code) : 0;
    return *opcode >= 0xe800u ? 4 : 2;
}

static void forget_block(struct hil_board *board)
{
    uint32_t start = board->state.cpu.block_address;
    must(uc_ctl_remove_cache(board->uc, (uint64_t)start, (uint64_t)start + board->state.cpu.block_size),
         "forgetting a block");
}

/* Run the block instruction by instruction, from where it stands, to its end or to where the debugger wants
 * to hold. The pieces translated for that must not stay: they would be blocks of the run. */
static void walk(struct hil_board *board)
{
    struct hil_cpu *cpu = &board->state.cpu;
    forget_block(board);
    for (;;) {
        uint16_t opcode;
        uint32_t pc = read_pc(board) & ~1u;
        uint32_t next = pc + instruction_bytes(board, pc, &opcode);
        bool last = next >= cpu->block_address + cpu->block_size;
        if (hil_debug_stops_before(board, pc)) {
            forget_block(board);
            return;
        }
        if (board->pin_times)
            board->pin_times->pc = pc;
        board->single = 1;
        board->came_back = CAME_BACK_PLAIN;
        uc_err err = start(board, pc, last ? 0 : next);
        board->single = 0;
        if (err != UC_ERR_OK || board->came_back != CAME_BACK_PLAIN || last) {
            cpu->walking = false;
            forget_block(board);
            treat_return(board, err, opcode == OPCODE_WFI);
            return;
        }
    }
}

void hil_cpu_leave_block(struct hil_board *board)
{
    struct hil_cpu *cpu = &board->state.cpu;
    uint32_t pc = read_pc(board) & ~1u;
    unsigned done = 0;
    uint16_t opcode;
    for (uint32_t at = cpu->block_address; at < pc; at += instruction_bytes(board, at, &opcode))
        done++;
    cpu->block_instructions = done;
    count_block(board);
    cpu->walking = false;
}

void hil_cpu_run(struct hil_board *board)
{
    guard_flash(board, hil_flash_erases(board));
    if (board->state.cpu.walking) {
        walk(board);
        return;
    }
    board->came_back = CAME_BACK_PLAIN;
    uc_err err = start(board, read_pc(board), 0);
    if (board->state.cpu.walking)
        return; /* at the block's start */
    /* Nobody asked it to stop and it is at no block's start: WFI. */
    treat_return(board, err, board->state.cpu.block_instructions != 0);
}
