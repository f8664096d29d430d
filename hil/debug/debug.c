#include "hil/debug/debug.h"

#include <stdio.h>
#include <string.h>
#include <unicorn/unicorn.h>

#include "hil/board/board.h"
#include "hil/core/cpu.h"
#include "hil/core/bus.h"
#include "hil/core/core.h"
#include "hil/core/nvic.h"

#define XPSR_EXCEPTION             0x1ffu
/* DBGMCU_APB1_FZ (RM0090 38.16.4) */
#define FREEZE_TIM2                (1u << 0)
#define FREEZE_TIM4                (1u << 2)
#define FREEZE_IWDG                (1u << 12)
/* faults and SVCall belong to the instruction that causes them */
#define LAST_SYNCHRONOUS_EXCEPTION HIL_EXC_DEBUG_MONITOR

/* The attached debugger, or NULL. */
static struct hil_debug *get_debugger(const struct hil_board *board)
{
    return board->core.observers.debugger_context;
}

static unsigned count_active_exceptions(const struct hil_board *board)
{
    unsigned active = 0;
    for (unsigned w = 0; w < HIL_EXCEPTION_WORDS; w++)
        active += (unsigned)__builtin_popcount(board->core.state.nvic.active[w]);
    return active;
}

void hil_debug_detach(struct hil_board *board)
{
    struct hil_debug *d = get_debugger(board);
    for (unsigned i = 0; d && i < HIL_WATCHPOINTS_MAX; i++) {
        if (d->watchpoints[i].size)
            hil_debug_set_watchpoint(board, d->watchpoints[i].kind, d->watchpoints[i].address,
                                     d->watchpoints[i].size, false);
    }
    board->core.observers.debugger = NULL;
    board->core.observers.debugger_context = NULL;
}

void hil_debug_hold(struct hil_board *board, enum hil_hold_reason reason)
{
    struct hil_debug *d = get_debugger(board);
    d->hold_reason = reason;
    d->is_stepping = false;
}

bool hil_debug_is_holding(const struct hil_board *board)
{
    const struct hil_debug *d = get_debugger(board);
    return d && d->hold_reason != HIL_HOLD_NONE;
}

static void release_hold(struct hil_board *board)
{
    struct hil_debug *d = get_debugger(board);
    uint32_t pc = hil_cpu_register(&board->core, 15) & ~1u;
    if (d->hold_reason == HIL_HOLD_BKPT) /* continue past the firmware's own BKPT */
        hil_debug_write_register(board, HIL_REG_PC, pc += 2u);
    d->hold_reason = HIL_HOLD_NONE;
    d->is_watchpoint_hit = false;
    d->is_resuming = true;
    d->resume_pc = pc;
}

void hil_debug_run(struct hil_board *board)
{
    release_hold(board);
    get_debugger(board)->is_stepping = false;
}

void hil_debug_step(struct hil_board *board)
{
    struct hil_debug *d = get_debugger(board);
    release_hold(board);
    d->is_stepping = true;
    d->has_stepped = false;
    d->step_depth = count_active_exceptions(board);
}

void hil_debug_advance(struct hil_board *board, uint64_t until_ps)
{
    struct hil_core *core = &board->core;
    struct hil_clock *clock = &core->state.clock;
    struct hil_events *events = &core->state.events;
    const uint32_t stops = core->state.scb.apb1_fz;
    core->has_reached_target = false;
    hil_event_handle_due(core);
    uint64_t from_ps = hil_now_ps(core), until = hil_clock_cycle_at_ps(clock, until_ps);
    if (core->is_stopped || core->reset.is_requested || clock->is_stopped ||
        until <= clock->now_cycle)
        return;
    if (stops & FREEZE_TIM2)
        hil_tim_freeze_until(&board->mcu.tim, HIL_TIM2, until);
    if (stops & FREEZE_TIM4)
        hil_tim_freeze_until(&board->mcu.tim, HIL_TIM4, until);
    if ((stops & FREEZE_IWDG) && events->due_ps[HIL_EVENT_IWDG] != HIL_NEVER)
        hil_event_set_ps(core, HIL_EVENT_IWDG,
                         events->due_ps[HIL_EVENT_IWDG] + (until_ps - from_ps));
    hil_scb_hold_counters(core, until - clock->now_cycle);
    hil_event_set_ps(core, HIL_EVENT_RUN_END, until_ps);
    while (!core->has_reached_target && !core->is_stopped && !core->reset.is_requested) {
        if (events->next_cycle > clock->now_cycle)
            clock->now_cycle = events->next_cycle;
        hil_event_handle_due(core);
    }
    hil_event_set_ps(core, HIL_EVENT_RUN_END, HIL_NEVER);
    core->has_reached_target = false;
}

enum mr_status hil_debug_set_breakpoint(struct hil_board *board, uint32_t address, bool set)
{
    struct hil_debug *d = get_debugger(board);
    unsigned i = 0;
    address &= ~1u;
    while (i < d->breakpoint_count && d->breakpoint[i] != address)
        i++;
    if (set && i == d->breakpoint_count) {
        if (i == HIL_BREAKPOINTS_MAX)
            return MR_FULL;
        d->breakpoint[d->breakpoint_count++] = address;
    } else if (!set && i < d->breakpoint_count) {
        d->breakpoint[i] = d->breakpoint[--d->breakpoint_count];
    }
    return MR_OK;
}

static void on_watched_access(uc_engine *uc, uc_mem_type type, uint64_t address, int size,
                              int64_t value, void *user)
{
    struct hil_board *board = user;
    struct hil_debug *d = get_debugger(board);
    bool write = type == UC_MEM_WRITE;
    (void)uc;
    (void)value;
    if (!d || d->is_watchpoint_hit)
        return;
    for (unsigned i = 0; i < HIL_WATCHPOINTS_MAX; i++) {
        const struct hil_watchpoint *w = &d->watchpoints[i];
        bool kind = w->kind == HIL_WATCH_ACCESS || (w->kind == HIL_WATCH_WRITE) == write;
        if (w->size && kind && address < (uint64_t)w->address + w->size &&
            address + (uint64_t)size > w->address) {
            hil_cpu_step_to_access(&board->core);
            d->is_watchpoint_hit = true;
            d->hit_kind = w->kind;
            d->hit_address = (uint32_t)address > w->address ? (uint32_t)address : w->address;
            struct hil_instruction place = {.pc = board->core.state.cpu.block_address};
            (void)hil_translator_find_instruction(&board->core.engine.translator, (uint32_t)address,
                                                  &place);
            d->hit_pc = place.pc;
            return;
        }
    }
}

static struct hil_watchpoint *find_watchpoint(struct hil_debug *d, enum hil_watch_kind kind,
                                              uint32_t address, uint32_t size)
{
    for (unsigned i = 0; i < HIL_WATCHPOINTS_MAX; i++) {
        if (d->watchpoints[i].size == size &&
            (!size || (d->watchpoints[i].kind == kind && d->watchpoints[i].address == address)))
            return &d->watchpoints[i];
    }
    return NULL;
}

enum mr_status hil_debug_set_watchpoint(struct hil_board *board, enum hil_watch_kind kind,
                                        uint32_t address, uint32_t size, bool set)
{
    struct hil_watchpoint *there = find_watchpoint(get_debugger(board), kind, address, size);
    struct hil_watchpoint *place = find_watchpoint(get_debugger(board), kind, 0, 0);
    if (!size || (set && !there && !place))
        return MR_FULL;
    if (set == (there != NULL))
        return MR_OK;
    if (set) {
        *place = (struct hil_watchpoint){.kind = kind, .address = address, .size = size};
        /* An access may begin before the watched range and extend into it; the callback checks this
         * exactly. */
        int types = kind == HIL_WATCH_WRITE ? UC_HOOK_MEM_WRITE
                  : kind == HIL_WATCH_READ  ? UC_HOOK_MEM_READ
                                            : UC_HOOK_MEM_READ | UC_HOOK_MEM_WRITE;
        uint64_t low = address < 8 ? 0 : address - 8u;
        if (uc_hook_add(board->core.uc, &place->unicorn_hook, types,
                        (void *)(uintptr_t)on_watched_access, board, low,
                        (uint64_t)address + size - 1u) != UC_ERR_OK) {
            place->size = 0;
            return MR_FULL;
        }
    } else {
        uc_hook_del(board->core.uc, there->unicorn_hook);
        there->size = 0;
    }
    /* discard translated code, because the check becomes part of the translation */
    hil_cpu_discard_code(&board->core);
    return MR_OK;
}

static bool has_breakpoint_in(const struct hil_debug *d, uint32_t address, uint32_t size)
{
    for (unsigned i = 0; i < d->breakpoint_count; i++) {
        if (d->breakpoint[i] - address < size)
            return true;
    }
    return false;
}

/* True if the running code is part of the step. Handlers of interrupts that occur during a step are
 * not. */
static bool is_code_part_of_step(const struct hil_board *board)
{
    const struct hil_debug *d = get_debugger(board);
    return count_active_exceptions(board) <= d->step_depth ||
           (hil_cpu_register(&board->core, 16) & XPSR_EXCEPTION) <= LAST_SYNCHRONOUS_EXCEPTION;
}

static bool must_step_block(const void *context, uint32_t address, uint32_t size)
{
    const struct hil_debug *d = context;
    return has_breakpoint_in(d, address, size) ||
           (d->is_stepping && is_code_part_of_step(d->board));
}

static bool is_step_done(struct hil_board *board)
{
    struct hil_debug *d = get_debugger(board);
    if (!d->is_stepping || !is_code_part_of_step(board))
        return false;
    if (!d->has_stepped) {
        d->has_stepped = true;
        return false;
    }
    return true;
}

static bool must_stop_before(void *context, uint32_t pc)
{
    struct hil_debug *d = context;
    struct hil_board *board = d->board;
    bool goes_on = d->is_resuming && d->resume_pc == pc;
    d->is_resuming = false;
    if (d->is_watchpoint_hit && !goes_on)
        hil_debug_hold(board, HIL_HOLD_WATCHPOINT);
    else if (!goes_on && has_breakpoint_in(d, pc, 1))
        hil_debug_hold(board, HIL_HOLD_BREAKPOINT);
    else if (is_step_done(board))
        hil_debug_hold(board, HIL_HOLD_STEP);
    return d->hold_reason != HIL_HOLD_NONE;
}

static bool is_holding(const void *context)
{
    const struct hil_debug *d = context;
    return d->hold_reason != HIL_HOLD_NONE;
}

static bool has_hit_watchpoint(void *context)
{
    const struct hil_debug *d = context;
    if (d->is_watchpoint_hit)
        hil_debug_hold(d->board, HIL_HOLD_WATCHPOINT);
    return d->is_watchpoint_hit;
}

static void handle_bkpt(void *context)
{
    const struct hil_debug *d = context;
    hil_debug_hold(d->board, HIL_HOLD_BKPT);
}

static const struct hil_debugger_calls debugger_calls = {
    .is_holding = is_holding,
    .has_hit_watchpoint = has_hit_watchpoint,
    .handle_bkpt = handle_bkpt,
    .must_step_block = must_step_block,
    .must_stop_before = must_stop_before,
};

void hil_debug_attach(struct hil_board *board, struct hil_debug *debug)
{
    *debug = (struct hil_debug){.board = board, .hold_reason = HIL_HOLD_REQUESTED};
    board->core.observers.debugger_context = debug;
    board->core.observers.debugger = &debugger_calls;
}

static int get_unicorn_register(unsigned number)
{
    static const int special[] = {UC_ARM_REG_SP,      UC_ARM_REG_LR,      UC_ARM_REG_PC,
                                  UC_ARM_REG_XPSR,    UC_ARM_REG_MSP,     UC_ARM_REG_PSP,
                                  UC_ARM_REG_PRIMASK, UC_ARM_REG_BASEPRI, UC_ARM_REG_FAULTMASK,
                                  UC_ARM_REG_CONTROL};
    if (number < 13)
        return UC_ARM_REG_R0 + (int)number;
    if (number < HIL_REG_D0)
        return special[number - 13u];
    return number < HIL_REG_FPSCR ? UC_ARM_REG_D0 + (int)(number - HIL_REG_D0) : UC_ARM_REG_FPSCR;
}

uint64_t hil_debug_read_register(const struct hil_board *board, unsigned number)
{
    uint64_t value = 0;
    uc_reg_read(board->core.uc, get_unicorn_register(number), &value);
    return number == HIL_REG_PC ? value & ~1ull : value;
}

void hil_debug_write_register(struct hil_board *board, unsigned number, uint64_t value)
{
    struct hil_cpu *cpu = &board->core.state.cpu;
    if (number == HIL_REG_PC) {
        if (cpu->is_stepping)
            hil_cpu_leave_block(&board->core);
        cpu->is_asleep = false;
        value |= 1u;
    }
    if (number == HIL_REG_XPSR) {
        /* Write only the flags: the debugger must not change mode and T bit, and writing the whole
         * register would switch the stack. */
        uint32_t flags = (uint32_t)value;
        uc_reg_write(board->core.uc, UC_ARM_REG_APSR_NZCVQG, &flags);
        return;
    }
    uc_reg_write(board->core.uc, get_unicorn_register(number), &value);
}

/* State that must be restored after the debugger has read a peripheral register. */
struct saved_state {
    struct hil_core core;
    struct hil_state state;
    struct hil_callbacks callbacks;
};

static bool is_bus_address(uint32_t address)
{
    return (address >= 0x40000000u && address < 0x60000000u) ||
           (address >= 0xe0000000u && address < 0xe0100000u) || address - 0x1fff0000u < 0x10000u;
}

static unsigned get_access_size(uint32_t address, size_t n)
{
    return !(address & 3u) && n >= 4 ? 4 : !(address & 1u) && n >= 2 ? 2 : 1;
}

static enum mr_status access_bus(struct hil_board *board, uint32_t address, uint8_t *bytes,
                                 size_t n, bool write)
{
    /* static because it is large; there is one debugger at a time */
    static struct saved_state before;
    struct hil_core *core = &board->core;
    if (!n || !is_bus_address(address) || !is_bus_address(address + (uint32_t)n - 1u))
        return MR_UNKNOWN;
    before = (struct saved_state){*core, board->state, board->lines.callbacks};
    if (!write) {
        board->lines.callbacks = (struct hil_callbacks){0};
        core->trace = NULL;
        core->observers.tracer = NULL;
        core->is_stopped = false;
    }
    for (size_t i = 0; i < n && !core->is_stopped;) {
        uint32_t value = 0;
        unsigned size = get_access_size(address + (uint32_t)i, n - i);
        memcpy(&value, bytes + i, size);
        if (write)
            hil_bus_write(core, address + (uint32_t)i, size, value);
        else
            value = hil_bus_read(core, address + (uint32_t)i, size);
        memcpy(bytes + i, &value, size);
        i += size;
    }
    bool failed = core->is_stopped && !(write && before.core.is_stopped);
    if (failed || !write) {
        *core = before.core;
        board->state = before.state;
        board->lines.callbacks = before.callbacks;
    }
    return failed ? MR_UNKNOWN : MR_OK;
}

enum mr_status hil_debug_read(struct hil_board *board, uint32_t address, uint8_t *out, size_t n)
{
    return hil_board_peek(board, address, out, n) == MR_OK
             ? MR_OK
             : access_bus(board, address, out, n, false);
}

enum mr_status hil_debug_write(struct hil_board *board, uint32_t address, uint8_t *bytes, size_t n)
{
    return hil_board_poke(board, address, bytes, n) == MR_OK
             ? MR_OK
             : access_bus(board, address, bytes, n, true);
}
