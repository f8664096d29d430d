#include "hil/debug/vcd.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "hil/board/board.h"
#include "hil/core/nvic.h"

/* Signals of every trace: scope, name, bits, and the present value. */
/* clang-format off */
#define SIGNAL_TABLE(X)                                                                           \
    X(pins, PD12_excitation_plus, 1, hil_board_pin_level(board, 3, 12))                          \
    X(pins, PD13_excitation_minus, 1, hil_board_pin_level(board, 3, 13))                         \
    X(pins, PA15_switch_edge, 1, hil_board_pin_level(board, 0, 15))                              \
    X(pins, PE0_lamp_off, 1, hil_board_pin_level(board, 4, 0))                                   \
    X(converters, adc1_scan, 1, state->events.due_cycle[HIL_EVENT_ADC1] != HIL_NEVER)       \
    X(converters, adc3_scan, 1, state->events.due_cycle[HIL_EVENT_ADC3] != HIL_NEVER)       \
    X(links, can_frame, 1, board->state.mcu.can.phase == HIL_CAN_FRAME)                    \
    X(links, usart1_tx, 1, state->events.due_cycle[HIL_EVENT_USART_TX] != HIL_NEVER)        \
    X(links, usart1_rx, 1, state->events.due_cycle[HIL_EVENT_USART_RX] != HIL_NEVER)        \
    X(core, sleeping, 1, state->cpu.is_asleep)                                                \
    X(core, exception, 8, hil_cpu_register(&board->core, 16) & 0x1ffu)                          \
    X(core, resets, 16, (uint32_t)state->counters.resets & 0xffffu)                        \
    X(core, hclk_hz, 32, state->clock.hclk_hz)
/* clang-format on */
#define SIGNAL_INDEX(scope, name, bits, now) SIGNAL_##name,
enum { SIGNAL_TABLE(SIGNAL_INDEX) FIXED_SIGNAL_COUNT };

#define SIGNALS_MAX       (FIXED_SIGNAL_COUNT + HIL_EXCEPTIONS)
#define FILE_BUFFER_BYTES (1u << 20)

#define SIGNAL_DECLARATION(scope, name, bits, now) {#scope, #name, bits},
static const struct {
    const char *scope, *name;
    unsigned bits;
} fixed_signals[FIXED_SIGNAL_COUNT] = {SIGNAL_TABLE(SIGNAL_DECLARATION)};

struct hil_vcd {
    struct hil_board *board;
    FILE *file;
    char *path;
    uint64_t t_ns;
    bool is_header_written;
    unsigned signal_count;
    uint32_t value[SIGNALS_MAX];
    unsigned bits[SIGNALS_MAX];
    char identifier[SIGNALS_MAX][4];
    /* number of signals of single exceptions, from FIXED_SIGNAL_COUNT on */
    unsigned exception_count;
    uint8_t exception[HIL_EXCEPTIONS];
};

static void declare_signal(struct hil_vcd *vcd, const char *name, unsigned bits)
{
    unsigned n = vcd->signal_count++;
    vcd->bits[n] = bits;
    vcd->identifier[n][0] = (char)('!' + n % 94u);
    vcd->identifier[n][1] = n >= 94u ? (char)('!' + n / 94u) : '\0';
    fprintf(vcd->file, "$var %s %u %s %s $end\n", bits == 1 ? "wire" : "reg", bits,
            vcd->identifier[n], name);
}

/* Adds a signal for each exception with a handler of its own: its vector is not 0 and is not the
 * most common vector. */
static void declare_exceptions(struct hil_vcd *vcd, const struct hil_board *board,
                               const struct mr_symbols *symbols)
{
    uint32_t vector[HIL_EXCEPTIONS], shared = 0;
    unsigned most = 2;
    memcpy(vector, board->core.memory->flash, sizeof vector);
    for (unsigned i = 2; i < HIL_EXCEPTIONS; i++) {
        unsigned same = 0;
        for (unsigned k = 2; k < HIL_EXCEPTIONS; k++)
            same += vector[k] == vector[i];
        if (same > most) {
            most = same;
            shared = vector[i];
        }
    }
    fputs("$scope module exceptions $end\n", vcd->file);
    for (unsigned i = 2; i < HIL_EXCEPTIONS; i++) {
        char name[80];
        const struct mr_symbol *symbol = mr_symbols_by_address(symbols, vector[i] & ~1u);
        if (!vector[i] || vector[i] == 0xffffffffu || vector[i] == shared)
            continue;
        int n = i < 16 ? snprintf(name, sizeof name, "exception%u", i)
                       : snprintf(name, sizeof name, "irq%u", i - 16);
        if (symbol)
            snprintf(name + n, sizeof name - (size_t)n, "_%s", symbol->name);
        vcd->exception[vcd->exception_count++] = (uint8_t)i;
        declare_signal(vcd, name, 1);
    }
    fputs("$upscope $end\n", vcd->file);
}

static void write_header(struct hil_vcd *vcd, const struct hil_board *board,
                         const struct mr_symbols *symbols)
{
    fputs("$version matrig-board $end\n$timescale 1 ns $end\n$scope module board $end\n",
          vcd->file);
    for (unsigned i = 0; i < FIXED_SIGNAL_COUNT; i++) {
        if (!i || strcmp(fixed_signals[i].scope, fixed_signals[i - 1].scope) != 0)
            fprintf(vcd->file, "%s$scope module %s $end\n", i ? "$upscope $end\n" : "",
                    fixed_signals[i].scope);
        declare_signal(vcd, fixed_signals[i].name, fixed_signals[i].bits);
    }
    fputs("$upscope $end\n", vcd->file);
    declare_exceptions(vcd, board, symbols);
    fputs("$upscope $end\n$enddefinitions $end\n", vcd->file);
}

static void write_value(const struct hil_vcd *vcd, unsigned signal)
{
    char digits[36];
    uint32_t value = vcd->value[signal];
    if (vcd->bits[signal] == 1) {
        fprintf(vcd->file, "%c%s\n", value ? '1' : '0', vcd->identifier[signal]);
        return;
    }
    unsigned n = 0;
    for (uint32_t rest = value; rest > 1; rest >>= 1)
        n++;
    digits[n + 1] = '\0';
    for (unsigned i = 0; i <= n; i++)
        digits[n - i] = (char)('0' + (value >> i & 1u));
    fprintf(vcd->file, "b%s %s\n", digits, vcd->identifier[signal]);
}

static void change_value(struct hil_vcd *vcd, unsigned signal, uint32_t value, uint64_t t_ns)
{
    if (vcd->value[signal] == value && vcd->is_header_written)
        return;
    vcd->value[signal] = value;
    if (!vcd->is_header_written)
        return;
    /* time must not go back in the file: some events are handled a few instructions late */
    if (t_ns > vcd->t_ns) {
        vcd->t_ns = t_ns;
        fprintf(vcd->file, "#%llu\n", (unsigned long long)t_ns);
    }
    write_value(vcd, signal);
}

static void read_fixed_values(const struct hil_board *board, uint32_t value[FIXED_SIGNAL_COUNT])
{
    const struct hil_core_state *state = &board->core.state;
#define SIGNAL_VALUE(scope, name, bits, now) value[SIGNAL_##name] = now;
    SIGNAL_TABLE(SIGNAL_VALUE)
}

static void write_changes(void *context, uint64_t at)
{
    struct hil_vcd *vcd = context;
    const struct hil_board *board = vcd->board;
    uint32_t value[FIXED_SIGNAL_COUNT];
    uint64_t t_ns = hil_clock_ps_at_cycle(&board->core.state.clock, at) / HIL_PS_PER_NS;
    read_fixed_values(board, value);
    for (unsigned i = 0; i < FIXED_SIGNAL_COUNT; i++)
        change_value(vcd, i, value[i], t_ns);
    for (unsigned i = 0; i < vcd->exception_count; i++)
        change_value(vcd, FIXED_SIGNAL_COUNT + i,
                     hil_nvic_is_active(&board->core.state.nvic, vcd->exception[i]), t_ns);
}

static void on_exception(void *context)
{
    const struct hil_vcd *vcd = context;
    write_changes(context, hil_now_cycle(&vcd->board->core));
}

static void write_initial_values(struct hil_vcd *vcd)
{
    const struct hil_board *board = vcd->board;
    write_changes(vcd,
                  /* the initial values are set without being written */
                  hil_now_cycle(&board->core));
    vcd->is_header_written = true;
    vcd->t_ns = hil_board_now_ps(board) / HIL_PS_PER_NS;
    fprintf(vcd->file, "#%llu\n$dumpvars\n", (unsigned long long)vcd->t_ns);
    for (unsigned i = 0; i < vcd->signal_count; i++)
        write_value(vcd, i);
    fputs("$end\n", vcd->file);
}

static const struct hil_tracer_calls tracer_calls = {
    .sample_signals = write_changes,
    .on_exception_change = on_exception,
};

enum mr_status hil_vcd_open(struct hil_board *board, const char *path,
                            const struct mr_symbols *symbols, char *error, size_t size)
{
    struct hil_vcd *vcd = hil_allocate(sizeof *vcd);
    vcd->file = fopen(path, "w");
    vcd->path = strdup(path);
    if (!vcd->file || !vcd->path) {
        snprintf(error, size, "--vcd: cannot write %s: %s; give a different file", path,
                 strerror(errno));
        free(vcd->path);
        free(vcd);
        return MR_IO;
    }
    setvbuf(vcd->file, NULL, _IOFBF, FILE_BUFFER_BYTES);
    write_header(vcd, board, symbols);
    vcd->board = board;
    board->core.observers.tracer_context = vcd;
    board->core.observers.tracer = &tracer_calls;
    write_initial_values(vcd);
    return MR_OK;
}

enum mr_status hil_vcd_close(struct hil_board *board, char *error, size_t size)
{
    struct hil_vcd *vcd = board->core.observers.tracer_context;
    if (!vcd)
        return MR_OK;
    if (vcd->is_header_written)
        fprintf(vcd->file, "#%llu\n",
                (unsigned long long)(hil_board_now_ps(board) / HIL_PS_PER_NS));
    bool failed = ferror(vcd->file) != 0;
    failed |= fclose(vcd->file) != 0;
    if (failed)
        snprintf(error, size,
                 "--vcd: cannot write all of %s: %s; free disk space or give a different file",
                 vcd->path, strerror(errno));
    free(vcd->path);
    free(vcd);
    board->core.observers.tracer = NULL;
    board->core.observers.tracer_context = NULL;
    return failed ? MR_IO : MR_OK;
}
