#include "hil/board/board.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unicorn/unicorn.h>

#include "hil/debug/debug.h"
#include "hil/core/elf.h"
#include "hil/board/machine.h"
#include "hil/debug/profile.h"
#include "hil/debug/vcd.h"

#define CSR_POWER_ON 0x0e000000u /* POR, pin, brown-out */
#define CSR_PIN (1u << 26)       /* every reset shows on the pin too */
#define CSR_BROWN_OUT (1u << 25)
#define POWER_DOWN_V 1.68
#define OWN_MEMORY offsetof(struct hil_memory, nor) /* bytes of the chip's own memories */

struct hil_snapshot {
    struct hil_state state;
    struct hil_cpu_registers registers;
    struct hil_memory memory;
    struct hil_options options;
};

void hil_options_default(struct hil_options *options)
{
    *options = (struct hil_options){
        .seed = 1,
        .hse_hz = 8000000,
        .lsi_hz = 32000,
        .host_baud = 2000000,
        .can_bus = HIL_CAN_CONNECTED,
        .adc_noise = true,
        .temperature_c = 20.0,
        .uid = {0x00310042u, 0x5847500fu, 0x20343635u},
    };
}

void hil_board_stop(struct hil_board *board, enum mr_status status, const char *format, ...)
{
    va_list arguments;
    if (board->stopped)
        return;
    board->stopped = true;
    board->stop_status = status;
    va_start(arguments, format);
    vsnprintf(board->reason, sizeof board->reason, format, arguments);
    va_end(arguments);
    hil_trace(board, "stop: %s", board->reason);
    hil_cpu_attend(board);
}

void hil_trace_line(struct hil_board *board, const char *format, ...)
{
    va_list arguments;
    uint64_t t_ns = hil_board_now_ps(board) / HIL_NS_PS;
    fprintf(board->options.trace, "%4llu.%09llu ", (unsigned long long)(t_ns / 1000000000u),
            (unsigned long long)(t_ns % 1000000000u));
    va_start(arguments, format);
    vfprintf(board->options.trace, format, arguments);
    va_end(arguments);
    fputc('\n', board->options.trace);
}

void hil_board_request_reset(struct hil_board *board, uint32_t flags)
{
    board->reset_request = true;
    board->reset_flags |= flags | CSR_PIN;
    hil_cpu_attend(board);
}

void hil_board_cut_power(struct hil_board *board)
{
    board->state.counters.power_cuts++;
    hil_trace(board, "power cut");
    hil_flash_power_lost(board);
    hil_w25q_power_lost(board);
    hil_tmp112_power(board);
    board->power_lost = board->reset_request = true;
    board->reset_flags = CSR_POWER_ON;
    hil_cpu_attend(board);
}

void hil_board_power_off(struct hil_board *board, uint64_t duration_ps)
{
    hil_board_cut_power(board);
    board->hold_ps = hil_board_now_ps(board) + duration_ps;
}

/* Volts at which the chip goes into reset: DS8626, embedded reset and power control block, typical, falling. */
static double brown_out_volts(const struct hil_board *board)
{
    static const double level[4] = {2.83, 2.50, 2.19, POWER_DOWN_V}; /* OPTCR.BOR_LEV; 3: off */
    return level[board->state.flash.options >> 2 & 3u];
}

void hil_board_brown_out(struct hil_board *board, double volts, uint64_t duration_ps)
{
    /* RM0090 table 10: HCLK for each wait state, by supply. */
    double hz_by_wait_state = volts >= 2.7 ? 30e6 : volts >= 2.4 ? 24e6 : volts >= 2.1 ? 22e6 : 20e6;
    if (volts < POWER_DOWN_V) {
        hil_board_power_off(board, duration_ps);
    } else if (volts < brown_out_volts(board)) {
        hil_board_request_reset(board, CSR_BROWN_OUT);
        board->hold_ps = hil_board_now_ps(board) + duration_ps;
    } else if (volts < 1.8 || board->state.clock.hclk_hz > hz_by_wait_state * ((board->state.rcc.flash_acr & 7u) + 1u)) {
        hil_board_stop(board, MR_HALTED,
                       "supply of %.2f V: silicon could not run at HCLK %u Hz with %u wait states, and the option bytes "
                       "let it try (brown-out reset below %.2f V)",
                       volts, (unsigned)board->state.clock.hclk_hz, (unsigned)(board->state.rcc.flash_acr & 7u),
                       brown_out_volts(board));
    }
}

void hil_board_power_event(struct hil_board *board, uint64_t at)
{
    (void)at;
    board->state.held_in_reset = false;
    hil_trace(board, "reset released");
}

/* RAM after a power cut: neither what was there nor zero. */
static void forget_ram(struct hil_board *board)
{
    uint64_t random = board->options.seed + board->state.counters.power_cuts;
    for (size_t i = 0; i < HIL_SRAM_SIZE + HIL_CCM_SIZE; i += 8) {
        uint64_t noise = hil_random(&random);
        memcpy(i < HIL_SRAM_SIZE ? board->memory->sram + i : board->memory->ccm + (i - HIL_SRAM_SIZE), &noise, 8);
    }
    hil_cpu_forget_code(board);
}

/* Everything that a reset line reaches. Time, rig, script and counters go on; SRAM keeps its contents. */
static void reset_chip(struct hil_board *board, uint32_t csr_flags)
{
    board->reset_request = false;
    board->reset_flags = 0;
    hil_nvic_reset(&board->state.nvic);
    hil_scb_reset(&board->state.scb);
    board->state.systick = (struct hil_systick){.zero_cycle = HIL_NEVER};
    hil_event_set_cycle(board, HIL_EVENT_SYSTICK, HIL_NEVER);
    if (board->power_lost) {
        board->power_lost = false;
        board->state.rcc.csr = 0;
        forget_ram(board);
    }
    hil_flash_reset(board);
    hil_rcc_reset(board, csr_flags);
    hil_adc_reset(board); /* before its DMA stops, or it would seem to overrun */
    for (unsigned unit = 0; unit < 2; unit++) {
        hil_dma_reset(board, unit);
        hil_tim_reset(board, unit);
    }
    hil_usart_reset(board);
    hil_spi_reset(board);
    hil_i2c_reset(board);
    hil_can_reset(board);
    hil_iwdg_reset(board);
    for (unsigned port = 0; port < HIL_GPIO_PORTS; port++)
        hil_gpio_reset_port(board, port);
    hil_cpu_reset(board);
}

static void take_reset(struct hil_board *board)
{
    board->state.counters.resets++;
    hil_trace(board, "reset, RCC_CSR flags 0x%08x", (unsigned)board->reset_flags);
    reset_chip(board, board->reset_flags);
}

void hil_debug_reset(struct hil_board *board)
{
    if (board->state.cpu.walking)
        hil_cpu_leave_block(board);
    hil_board_request_reset(board, 0);
    take_reset(board);
}

struct hil_board *hil_board_create(const struct hil_options *options)
{
    struct hil_board *board = calloc(1, sizeof *board);
    if (!board)
        abort();
    /* Zero and page-aligned; what is never touched of it costs nothing. */
    board->memory = mmap(NULL, sizeof *board->memory, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (board->memory == MAP_FAILED)
        abort();
    memset(board->memory->flash, 0xff, sizeof board->memory->flash);
    board->options = *options;
    board->options.trace = board->options.log = NULL; /* an empty board has nothing to tell */
    hil_event_init(&board->state.events);
    hil_clock_start(&board->state.clock, 16000000);
    board->state.rig.pulse_end_ps = HIL_NEVER;
    for (unsigned i = 0; i < 2; i++)
        board->state.adc[i].noise = options->seed * 0x2545f4914f6cdd1dull + i * 0x632be59bd9b4e019ull;
    hil_flash_create(board);
    hil_w25q_create(board);
    hil_faults_init(board);
    hil_bus_init(board);
    hil_cpu_create(board);
    hil_gpio_drive(board, 0, 15, false, 0); /* the one-shot holds PA15 low */
    hil_gpio_drive(board, 1, 12, true, 0);  /* pull-up at the NOR's chip select */
    hil_gpio_drive(board, 1, 6, true, 0);   /* and at the thermometer's lines */
    hil_tmp112_power(board);
    reset_chip(board, CSR_POWER_ON);
    board->options.trace = options->trace;
    board->options.log = options->log;
    return board;
}

void hil_board_destroy(struct hil_board *board)
{
    if (!board)
        return;
    hil_vcd_close(board, NULL, 0);
    hil_profile_end(board);
    hil_cpu_destroy(board);
    munmap(board->memory, sizeof *board->memory);
    free(board);
}

void hil_board_set_callbacks(struct hil_board *board, const struct hil_callbacks *callbacks)
{
    board->callbacks = *callbacks;
}

void hil_board_set_pin_callbacks(struct hil_board *board, const struct hil_callbacks *callbacks)
{
    board->pin_callbacks = *callbacks;
}

enum mr_status hil_board_restart(struct hil_board *board)
{
    hil_cpu_forget_code(board);
    board->stopped = false;
    board->reason[0] = '\0';
    reset_chip(board, CSR_POWER_ON);
    return board->stopped ? board->stop_status : MR_OK;
}

enum mr_status hil_board_load_elf(struct hil_board *board, const char *path)
{
    enum mr_status status = hil_elf_load(path, board->memory, board->reason, sizeof board->reason);
    if (status != MR_OK)
        return status;
    return hil_board_restart(board);
}

void hil_board_attach_rig(struct hil_board *board, const struct hil_run *run)
{
    board->run = run;
    hil_rig_start(board);
    hil_script_start(board);
}

/* Jump to the next event, counting the cycles passed over. */
static void pass_time(struct hil_board *board, uint64_t *counter)
{
    struct hil_state *state = &board->state;
    uint64_t next = state->events.next_cycle; /* never later than the end of the run */
    if (next > state->clock.now_cycle) {
        *counter += next - state->clock.now_cycle;
        state->clock.now_cycle = next;
    }
}

/* Does the core wait for flash: with its next instruction, or with the vector of an exception that is due? */
static bool waits_for_flash(struct hil_board *board)
{
    uint32_t pc = 0;
    if (!hil_flash_busy(board))
        return false;
    uc_reg_read(board->uc, UC_ARM_REG_PC, &pc);
    return hil_flash_stalls(board, pc)
           || (hil_exception_due(board) && hil_flash_stalls(board, board->state.scb.vtor));
}

enum mr_status hil_board_run_until(struct hil_board *board, uint64_t t_ps)
{
    struct hil_state *state = &board->state;
    if (board->stopped)
        return board->stop_status;
    board->target_reached = false;
    hil_event_set_ps(board, HIL_EVENT_TARGET, t_ps);
    for (;;) {
        if (hil_debug_holds(board))
            break;
        if (state->cpu.walking) { /* inside a block: nothing is due before its end */
            hil_cpu_run(board);
            continue;
        }
        hil_event_run(board);
        if (board->stopped || board->target_reached)
            break;
        if (board->reset_request) {
            take_reset(board);
            state->held_in_reset = board->hold_ps > hil_board_now_ps(board);
            if (state->held_in_reset)
                hil_event_set_ps(board, HIL_EVENT_POWER, board->hold_ps);
            board->hold_ps = 0;
            continue;
        }
        if (state->held_in_reset) {
            pass_time(board, &state->counters.asleep_cycles);
            continue;
        }
        if (state->rcc.no_clock) {
            hil_clock_stand_still(board);
            continue;
        }
        if (state->cpu.asleep) {
            if (hil_exception_wakes(board)) {
                state->cpu.asleep = false;
            } else {
                if (board->vcd)
                    hil_vcd_sample(board, hil_now(board));
                pass_time(board, &state->counters.asleep_cycles);
                continue;
            }
            if (board->vcd)
                hil_vcd_sample(board, hil_now(board));
        }
        if (waits_for_flash(board)) {
            pass_time(board, &state->counters.flash_stall_cycles);
            continue;
        }
        unsigned exception = hil_exception_due(board);
        if (exception) {
            uint32_t pc = 0;
            uc_reg_read(board->uc, UC_ARM_REG_PC, &pc);
            hil_exception_enter(board, exception, pc);
            continue;
        }
        const struct hil_nvic *nvic = &state->nvic;
        bool masked = nvic->best && nvic->best_group < nvic->active_group;
        board->limit_cycle = masked || hil_flash_busy(board) ? 0 : state->events.next_cycle;
        hil_cpu_run(board);
    }
    hil_event_set_ps(board, HIL_EVENT_TARGET, HIL_NEVER);
    hil_rig_count_excitation(board, hil_now(board));
    return board->stopped ? board->stop_status : MR_OK;
}

const char *hil_board_reason(const struct hil_board *board) { return board->reason; }

uint64_t hil_board_now_ps(const struct hil_board *board)
{
    return hil_clock_ps(&board->state.clock, board->state.clock.now_cycle);
}

uint64_t hil_board_now_cycles(const struct hil_board *board) { return board->state.clock.now_cycle; }
uint32_t hil_board_hclk_hz(const struct hil_board *board) { return board->state.clock.hclk_hz; }

const struct hil_counters *hil_board_counters(const struct hil_board *board)
{
    return &board->state.counters;
}

bool hil_board_pin(const struct hil_board *board, unsigned port, unsigned pin)
{
    return port < HIL_GPIO_PORTS && pin < 16 && hil_gpio_level(board, port, pin);
}

void hil_board_drive_pin(struct hil_board *board, unsigned port, unsigned pin, bool level)
{
    if (port < HIL_GPIO_PORTS && pin < 16)
        hil_gpio_drive(board, port, pin, level, hil_now(board));
}

enum mr_status hil_board_peek(const struct hil_board *board, uint32_t address, void *out, size_t n)
{
    const uint8_t *memory = n <= HIL_FLASH_SIZE ? hil_board_memory(board, address, (uint32_t)n, false) : NULL;
    if (!memory)
        return MR_UNKNOWN;
    memcpy(out, memory, n);
    return MR_OK;
}

enum mr_status hil_board_poke(struct hil_board *board, uint32_t address, const void *bytes, size_t n)
{
    uint8_t *memory = n <= HIL_FLASH_SIZE ? hil_board_memory(board, address, (uint32_t)n, false) : NULL;
    if (!memory)
        return MR_UNKNOWN;
    memcpy(memory, bytes, n);
    hil_cpu_forget_range(board, address, (uint32_t)n);
    return MR_OK;
}

uint32_t hil_board_register(const struct hil_board *board, unsigned number)
{
    int id = number < 13 ? UC_ARM_REG_R0 + (int)number
             : number == 13 ? UC_ARM_REG_SP
             : number == 14 ? UC_ARM_REG_LR
             : number == 15 ? UC_ARM_REG_PC
             : number == 16 ? UC_ARM_REG_XPSR
                            : UC_ARM_REG_PRIMASK;
    uint32_t value = 0;
    uc_reg_read(board->uc, id, &value);
    return value;
}

struct hil_snapshot *hil_board_snapshot(const struct hil_board *board)
{
    struct hil_snapshot *snapshot = malloc(sizeof *snapshot);
    if (!snapshot)
        abort();
    snapshot->state = board->state;
    snapshot->options = board->options;
    snapshot->options.trace = snapshot->options.log = NULL;
    memcpy(&snapshot->memory, board->memory, OWN_MEMORY);
    hil_w25q_copy(&snapshot->memory, NULL, board->memory, board->state.w25q.used);
    hil_cpu_save(board, &snapshot->registers);
    return snapshot;
}

void hil_board_restore(struct hil_board *board, const struct hil_snapshot *snapshot)
{
    FILE *trace = board->options.trace, *log = board->options.log;
    board->options = snapshot->options;
    board->options.trace = trace;
    board->options.log = log;
    hil_w25q_copy(board->memory, board->state.w25q.used, &snapshot->memory, snapshot->state.w25q.used);
    board->state = snapshot->state;
    memcpy(board->memory, &snapshot->memory, OWN_MEMORY);
    hil_cpu_forget_code(board);
    hil_cpu_load(board, &snapshot->registers);
    hil_stuck_look(board);
    board->stopped = board->reset_request = board->power_lost = false;
    board->reset_flags = 0;
    board->hold_ps = 0;
    board->reason[0] = '\0';
}

struct hil_board *hil_board_fork(const struct hil_board *board)
{
    struct hil_options options = board->options;
    options.trace = options.log = NULL;
    struct hil_board *copy = hil_board_create(&options);
    struct hil_snapshot *snapshot = hil_board_snapshot(board);
    copy->run = board->run;
    copy->replay = board->replay;
    hil_board_restore(copy, snapshot);
    free(snapshot);
    return copy;
}
