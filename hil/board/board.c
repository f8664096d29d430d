#include "hil/board/board.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unicorn/unicorn.h>

#include "hil/board/parts.h"
#include "hil/board/which.h"
#include "hil/core/context.h"
#include "hil/core/cpu.h"
#include "hil/core/cpu_registers.h"
#include "hil/core/elf.h"
#include "hil/core/event.h"
#include "hil/core/exception.h"
#include "hil/core/hclk.h"
#include "hil/core/nvic.h"
#include "hil/core/scb.h"
#include "hil/core/systick.h"
#include "hil/periph/board_type.h"
#include "hil/periph/cells.h"

/* RAM after a power cut: neither what was there nor zero. */
static void forget_ram(struct hil_board *board)
{
    uint64_t random = board->options.seed + board->core.state.counters.power_cuts;
    for (size_t i = 0; i < HIL_SRAM_SIZE + HIL_CCM_SIZE; i += 8) {
        uint64_t noise = hil_random(&random);
        memcpy(i < HIL_SRAM_SIZE ? board->core.memory->sram + i
                                 : board->core.memory->ccm + (i - HIL_SRAM_SIZE),
               &noise, 8);
    }
    hil_cpu_forget_code(&board->core);
}

/* Everything that a reset line reaches. Time, rig, script and counters go on; SRAM keeps its
 * contents. */
static void reset_chip(struct hil_board *board, uint32_t csr_flags)
{
    struct hil_core *core = &board->core;
    core->reset.asked = false;
    core->reset.flags = 0;
    hil_nvic_reset(&core->state.nvic);
    hil_scb_reset(&core->state.scb, board->options.type->idcode);
    hil_systick_reset(core);
    if (core->reset.power_lost) {
        core->reset.power_lost = false;
        board->state.mcu.rcc.csr = 0;
        forget_ram(board);
    }
    hil_mcu_reset(&board->mcu, csr_flags);
    hil_cpu_reset(core);
}

static void take_reset(struct hil_board *board)
{
    board->core.state.counters.resets++;
    hil_trace(&board->core, "reset, RCC_CSR flags 0x%08x", (unsigned)board->core.reset.flags);
    reset_chip(board, board->core.reset.flags);
}

void hil_board_reset(struct hil_board *board)
{
    if (board->core.state.cpu.walking)
        hil_cpu_leave_block(&board->core);
    hil_core_request_reset(&board->core, 0);
    take_reset(board);
}

struct hil_board *hil_board_create(const struct hil_options *options)
{
    struct hil_board *board = calloc(1, sizeof *board);
    if (!board)
        abort();
    /* Zero and page-aligned; what is never touched of it costs nothing. */
    board->memories = mmap(NULL, sizeof *board->memories, PROT_READ | PROT_WRITE,
                           MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (board->memories == MAP_FAILED)
        abort();
    memset(board->memories->own.flash, 0xff, sizeof board->memories->own.flash);
    board->options = *options;
    if (options->board_drawn)
        hil_electronics_identity(options->board_seed, board->options.uid);
    board->options.log = NULL; /* an empty board has nothing to tell, nor core.trace */
    hil_board_wire(board);
    for (unsigned i = 0; i < 2; i++)
        board->state.mcu.adc[i].noise = options->seed * 0x2545f4914f6cdd1dull +
                                        i * 0x632be59bd9b4e019ull;
    hil_cpu_create(&board->core);
    if (!options->bare) { /* the one-shot holds PA15 low, the camera's buffer PB3 */
        hil_gpio_drive(&board->mcu.gpio, 0, 15, false, 0);
        hil_gpio_drive(&board->mcu.gpio, 1, 3, false, 0);
    }
    hil_tmp112_power(&board->tmp112);
    reset_chip(board, HIL_CSR_POWER_ON);
    board->core.trace = options->trace;
    board->options.log = options->log;
    return board;
}

void hil_board_destroy(struct hil_board *board)
{
    if (!board)
        return;
    const struct hil_onlookers *lookers = &board->core.onlookers;
    if (lookers->tracer)
        lookers->tracer->end(lookers->tracer_who);
    if (lookers->profiler)
        lookers->profiler->end(lookers->profiler_who);
    hil_cpu_destroy(&board->core);
    hil_symbols_free(&board->symbols);
    munmap(board->memories, sizeof *board->memories);
    free(board);
}

void hil_board_set_callbacks(struct hil_board *board, const struct hil_callbacks *callbacks)
{
    board->lines.callbacks = *callbacks;
}

enum mr_status hil_board_restart(struct hil_board *board)
{
    hil_cpu_forget_code(&board->core);
    board->core.stopped = false;
    board->core.reason[0] = '\0';
    reset_chip(board, HIL_CSR_POWER_ON);
    if (board->options.left_on)
        hil_rcc_leave_on(&board->mcu.rcc);
    return board->core.stopped ? board->core.stop_status : MR_OK;
}

enum mr_status hil_board_fits(struct hil_board *board, const char *path)
{
    const struct hil_board_type *type = board->options.type, *wanted = type;
    char why[160];
    enum mr_status status = hil_which_head(board->core.memory->flash, &wanted, why, sizeof why);
    if (status != MR_OK)
        snprintf(board->core.reason, sizeof board->core.reason, "%s: %s", path, why);
    if (status != MR_OK)
        return status;
    for (uint32_t i = type->flash_kib * 1024u; i < HIL_FLASH_SIZE; i++) {
        if (board->core.memory->flash[i] == 0xff)
            continue;
        snprintf(board->core.reason, sizeof board->core.reason,
                 "%s: more than the %u KiB of flash that this chip has; is it for another board?",
                 path, (unsigned)type->flash_kib);
        return MR_VERSION;
    }
    if (wanted->number == type->number)
        return MR_OK;
    snprintf(board->core.reason, sizeof board->core.reason,
             "%s is an image for the board %s, and this is %s; give the other image, or no --board",
             path, hil_board_type_name(wanted), hil_board_type_name(type));
    return MR_VERSION;
}

/* The name of the function at an address: the image's symbols are read when the first is asked
 * for. */
static const char *function_at(void *who, uint32_t pc)
{
    struct hil_board *board = who;
    char error[256];
    if (!board->symbols.file && board->elf[0])
        (void)hil_symbols_read(&board->symbols, board->elf, error, sizeof error);
    const struct mr_symbol *symbol = mr_symbols_at(&board->symbols, pc);
    return symbol ? symbol->name : NULL;
}

void hil_board_name_functions(struct hil_board *board, const char *elf)
{
    hil_symbols_free(&board->symbols);
    snprintf(board->elf, sizeof board->elf, "%s", elf);
    board->mcu.rules.function = function_at;
    board->mcu.rules.who = board;
}

enum mr_status hil_board_load_elf(struct hil_board *board, const char *path)
{
    enum mr_status status = hil_elf_load(path, board->core.memory, board->core.reason,
                                         sizeof board->core.reason);
    if (status == MR_OK)
        status = hil_board_fits(board, path);
    if (status != MR_OK)
        return status;
    hil_board_name_functions(board, path);
    return hil_board_restart(board);
}

void hil_board_attach_rig(struct hil_board *board, const struct hil_run *run)
{
    board->rig.run = run;
    hil_rig_start(&board->rig);
    hil_script_start(&board->script);
}

void hil_board_attach_replay(struct hil_board *board, const struct hil_replay *replay)
{
    board->state.replay = (struct hil_replay_state){0};
    hil_replay_connect(&board->replay, replay);
    if (replay->has_uid)
        memcpy(board->options.uid, replay->uid, sizeof board->options.uid);
    if (!replay->crystal)
        board->options.hse_hz = 0;
}

/* Jump to the next event, counting the cycles passed over. */
static void pass_time(struct hil_core *core, uint64_t *counter)
{
    struct hil_core_state *state = &core->state;
    uint64_t next = state->events.next_cycle; /* never later than the end of the run */
    if (next > state->clock.now_cycle) {
        *counter += next - state->clock.now_cycle;
        state->clock.now_cycle = next;
    }
}

/* Does the core wait for flash: with its next instruction, or with the vector of an exception that
 * is due? */
static bool waits_for_flash(struct hil_core *core)
{
    uint32_t pc = 0;
    if (!core->state.bank.busy)
        return false;
    uc_reg_read(core->uc, UC_ARM_REG_PC, &pc);
    return hil_memory_stalls(core, pc) ||
           (hil_exception_due(core) && hil_memory_stalls(core, core->state.scb.vtor));
}

enum mr_status hil_board_run_until(struct hil_board *board, uint64_t t_ps)
{
    struct hil_core *core = &board->core;
    struct hil_core_state *state = &core->state;
    const struct hil_onlookers *lookers = &core->onlookers;
    if (core->stopped)
        return core->stop_status;
    core->target_reached = false;
    hil_event_set_ps(core, HIL_EVENT_TARGET, t_ps);
    for (;;) {
        if (lookers->debugger && lookers->debugger->holds(lookers->debugger_who))
            break;
        if (state->cpu.walking) { /* inside a block: nothing is due before its end */
            hil_cpu_run(core);
            continue;
        }
        hil_event_run(core);
        if (core->stopped || core->target_reached)
            break;
        if (core->reset.asked) {
            take_reset(board);
            hil_supply_hold(&board->supply);
            continue;
        }
        if (board->state.supply.held_in_reset) {
            pass_time(core, &state->counters.asleep_cycles);
            continue;
        }
        if (state->clock.stopped) {
            hil_hclk_stand_still(core);
            continue;
        }
        if (state->cpu.asleep) {
            if (hil_exception_wakes(core)) {
                state->cpu.asleep = false;
            } else {
                if (lookers->tracer)
                    lookers->tracer->sample(lookers->tracer_who, hil_now(core));
                pass_time(core, &state->counters.asleep_cycles);
                continue;
            }
            if (lookers->tracer)
                lookers->tracer->sample(lookers->tracer_who, hil_now(core));
        }
        if (waits_for_flash(core)) {
            pass_time(core, &state->counters.flash_stall_cycles);
            continue;
        }
        unsigned exception = hil_exception_due(core);
        if (exception) {
            uint32_t pc = 0;
            uc_reg_read(core->uc, UC_ARM_REG_PC, &pc);
            hil_exception_enter(core, exception, pc);
            continue;
        }
        const struct hil_nvic *nvic = &state->nvic;
        bool masked = nvic->best && nvic->best_group < nvic->active_group;
        core->limit_cycle = masked || state->bank.busy ? 0 : state->events.next_cycle;
        hil_cpu_run(core);
    }
    hil_event_set_ps(core, HIL_EVENT_TARGET, HIL_NEVER);
    hil_rig_count_excitation(&board->rig, hil_now(core));
    return core->stopped ? core->stop_status : MR_OK;
}

const char *hil_board_reason(const struct hil_board *board)
{
    return board->core.reason;
}

uint64_t hil_board_now_ps(const struct hil_board *board)
{
    return hil_now_ps(&board->core);
}

uint64_t hil_board_now_cycles(const struct hil_board *board)
{
    return board->core.state.clock.now_cycle;
}
uint32_t hil_board_hclk_hz(const struct hil_board *board)
{
    return board->core.state.clock.hclk_hz;
}

const struct hil_counters *hil_board_counters(const struct hil_board *board)
{
    return &board->core.state.counters;
}

bool hil_board_pin(const struct hil_board *board, unsigned port, unsigned pin)
{
    return port < HIL_GPIO_PORTS && pin < 16 && hil_gpio_level(&board->mcu.gpio, port, pin);
}

enum mr_status hil_board_can_inject(struct hil_board *board, const struct hil_can_frame *frame)
{
    return hil_can_inject(&board->mcu.can, frame);
}

enum mr_status hil_board_serial_inject(struct hil_board *board, const uint8_t *bytes, size_t n)
{
    return hil_usart_inject(&board->mcu.usart, bytes, n);
}

size_t hil_board_serial_room(const struct hil_board *board)
{
    return hil_usart_room(&board->mcu.usart);
}
void hil_board_set_host_baud(struct hil_board *board, uint32_t baud)
{
    board->options.host_baud = baud;
}

enum mr_status hil_board_add_faults(struct hil_board *board, const struct hil_fault_script *script)
{
    return hil_faults_add_all(&board->faults, script);
}

void hil_board_print_rules(const struct hil_board *board, FILE *out)
{
    hil_rules_print(&board->mcu.rules, out);
}

unsigned hil_board_rules_counted(const struct hil_board *board, uint64_t *times)
{
    return hil_rules_counted(&board->mcu.rules, times);
}

void hil_board_tell_faults_left(const struct hil_board *board)
{
    hil_faults_tell_rest(&board->faults);
}

enum mr_status hil_board_peek(const struct hil_board *board, uint32_t address, void *out, size_t n)
{
    return hil_memory_peek(&board->core, address, out, n);
}

enum mr_status hil_board_poke(struct hil_board *board, uint32_t address, const void *bytes,
                              size_t n)
{
    return hil_cpu_poke(&board->core, address, bytes, n);
}

uint32_t hil_board_register(const struct hil_board *board, unsigned number)
{
    return hil_cpu_register(&board->core, number);
}
