#include "tests/hil/pin_times.h"

#include <string.h>

#include "hil/board/board.h"
#include "hil/board/parts.h"
#include "hil/core/cpu.h"

#define NS_PS 1000.0

/* Longest rise or fall by OSPEEDR, at 2.7 V or more and 50, 50, 40, 30 pF: STM32F407 data sheet,
 * I/O AC characteristics. */
static const double slew_ns_of_speed[4] = {100.0, 10.0, 6.0, 4.0};

static double slew_ns(const struct hil_board *board, unsigned port, unsigned pin)
{
    return slew_ns_of_speed[board->state.mcu.gpio.port[port].ospeedr >> (2u * pin) & 3u];
}

static bool wants(const void *who, uint32_t address, uint32_t size)
{
    const struct hil_pin_times *times = who;
    for (unsigned i = 0; i < times->blocks; i++) {
        if (times->block[i].address == address && times->block[i].size == size)
            return true;
    }
    return false;
}

static void learn_block(struct hil_pin_times *times)
{
    struct hil_board *board = times->board;
    const struct hil_cpu *cpu = &board->core.state.cpu;
    if (times->blocks == HIL_PIN_BLOCKS || wants(times, cpu->block_address, cpu->block_size))
        return;
    times->block[times->blocks].address = cpu->block_address;
    times->block[times->blocks++].size = cpu->block_size;
    hil_cpu_inspect_again(&board->core, cpu->block_address);
}

/* Instructions of the block that is walked through, before the one that runs. */
static unsigned instructions_before(const struct hil_pin_times *times)
{
    const struct hil_board *board = times->board;
    uint32_t start = board->core.state.cpu.block_address, size = board->core.state.cpu.block_size;
    const uint8_t *code = board->core.state.cpu.walking
                            ? hil_memory_at(&board->core, start, size, false)
                            : NULL;
    unsigned n = 0;
    for (uint32_t i = 0; code && i < size && start + i < times->pc; n++)
        i += code[i + 1] >= 0xe8u ? 4 : 2; /* ARMv7-M A5.1 */
    return n;
}

static void begin_pulse(struct hil_pin_times *times, unsigned n, uint64_t now_ps)
{
    struct hil_pin_time *time = &times->of[n];
    time->lasts = true;
    time->begin_ps = now_ps;
    time->begin_slew_ns = slew_ns(times->board, times->rules[n].port, times->rules[n].pin);
    time->pulse_pc = times->pc;
}

static void end_pulse(const struct hil_pin_times *times, struct hil_pin_time *time, double least_ns,
                      uint64_t now_ps)
{
    double lasted_ns = (double)(now_ps - time->begin_ps) / NS_PS - time->begin_slew_ns;
    time->too_short += lasted_ns < least_ns;
    if (time->pulses++ && lasted_ns >= time->shortest_ns)
        return;
    time->shortest_ns = lasted_ns;
    time->slew_ns = time->begin_slew_ns;
    time->begin_pc = time->pulse_pc;
    time->end_pc = times->pc;
}

static void follow_pin(struct hil_pin_times *times, unsigned n, uint64_t now_ps)
{
    const struct hil_board *board = times->board;
    const struct hil_pin_rule *rule = &times->rules[n];
    struct hil_pin_time *time = &times->of[n];
    bool located = board->core.state.cpu.walking,
         high = hil_board_pin(board, rule->port, rule->pin);
    if (high == times->was_high[n])
        return;
    times->was_high[n] = high;
    times->unlocated += !located;
    if (time->lasts && located) /* else its beginning or its end is not known */
        end_pulse(times, time, rule->least_ns, now_ps);
    time->lasts = false;
    if (located && high == rule->level)
        begin_pulse(times, n, now_ps);
}

static void stored(void *who, unsigned port)
{
    struct hil_pin_times *times = who;
    const struct hil_core *core = &times->board->core;
    uint64_t now_ps = 0;
    for (unsigned i = 0; i < times->count; i++) {
        if (times->rules[i].port != port)
            continue;
        if (!now_ps) {
            learn_block(times);
            now_ps = hil_clock_ps(&core->state.clock, hil_now(core) + instructions_before(times));
        }
        follow_pin(times, i, now_ps);
    }
}

static void see_instruction(void *who, uint32_t pc)
{
    struct hil_pin_times *times = who;
    times->pc = pc;
}

static const struct hil_store_watch_calls calls = {.wants = wants, .at = see_instruction};

void hil_pin_times_watch(struct hil_board *board, struct hil_pin_times *times,
                         const struct hil_pin_rule *rules, unsigned count)
{
    times->rules = rules;
    times->count = count < HIL_PIN_RULES ? count : HIL_PIN_RULES;
    times->unlocated = 0;
    memset(times->of, 0, sizeof times->of);
    for (unsigned i = 0; i < times->count; i++)
        times->was_high[i] = hil_board_pin(board, rules[i].port, rules[i].pin);
    times->board = board;
    board->core.onlookers.store_watch_who = times;
    board->core.onlookers.store_watch = &calls;
    board->mcu.gpio.stored = stored;
    board->mcu.gpio.stored_who = times;
    for (unsigned i = 0; i < times->blocks; i++)
        hil_cpu_inspect_again(&board->core, times->block[i].address);
}
