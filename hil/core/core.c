#include "hil/core/core.h"

#include <stdarg.h>
#include <string.h>

#define CSR_PIN (1u << 26) /* every reset shows on the pin too */

void hil_core_stop(struct hil_core *core, enum mr_status status, const char *format, ...)
{
    va_list arguments;
    if (core->stopped)
        return;
    core->stopped = true;
    core->stop_status = status;
    va_start(arguments, format);
    vsnprintf(core->reason, sizeof core->reason, format, arguments);
    va_end(arguments);
    hil_trace(core, "stop: %s", core->reason);
    hil_core_attend(core);
    core->engine.translator.abandoned = core->engine.left_inside =
        hil_translator_can_leave(&core->engine.translator);
    if (core->engine.left_inside)
        uc_emu_stop(core->uc);
}

void hil_core_trace_line(struct hil_core *core, const char *format, ...)
{
    va_list arguments;
    uint64_t t_ns = hil_now_ps(core) / HIL_NS_PS;
    fprintf(core->trace, "%4llu.%09llu ", (unsigned long long)(t_ns / 1000000000u),
            (unsigned long long)(t_ns % 1000000000u));
    va_start(arguments, format);
    vfprintf(core->trace, format, arguments);
    va_end(arguments);
    fputc('\n', core->trace);
}

void hil_core_request_reset(struct hil_core *core, uint32_t flags)
{
    core->reset.asked = true;
    core->reset.flags |= flags | CSR_PIN;
    hil_core_attend(core);
}

enum mr_status hil_memory_peek(const struct hil_core *core, uint32_t address, void *out, size_t n)
{
    const uint8_t *memory = n <= HIL_FLASH_SIZE ? hil_memory_at(core, address, (uint32_t)n, false)
                                                : NULL;
    if (!memory)
        return MR_UNKNOWN;
    memcpy(out, memory, n);
    return MR_OK;
}

uint32_t hil_cpu_register(const struct hil_core *core, unsigned number)
{
    int id = number < 13  ? UC_ARM_REG_R0 + (int)number
           : number == 13 ? UC_ARM_REG_SP
           : number == 14 ? UC_ARM_REG_LR
           : number == 15 ? UC_ARM_REG_PC
           : number == 16 ? UC_ARM_REG_XPSR
                          : UC_ARM_REG_PRIMASK;
    uint32_t value = 0;
    uc_reg_read(core->uc, id, &value);
    return value;
}

/* --- the clock --- */

__extension__ typedef unsigned __int128 wide;

static void set_hz(struct hil_clock *clock, uint32_t hclk_hz)
{
    uint64_t a = HIL_SECOND_PS, b = hclk_hz;
    while (b) { /* Euclid */
        uint64_t rest = a % b;
        a = b;
        b = rest;
    }
    clock->hclk_hz = clock->ratio_hz = hclk_hz;
    clock->ratio_ps = HIL_SECOND_PS / a;
    clock->ratio_cycles = hclk_hz / a;
}

void hil_clock_start(struct hil_clock *clock, uint32_t hclk_hz)
{
    *clock = (struct hil_clock){0};
    set_hz(clock, hclk_hz);
}

uint64_t hil_clock_ps(const struct hil_clock *clock, uint64_t cycle)
{
    if (cycle < clock->anchor_cycle) /* only ever a moment before: at the rate of now */
        return clock->anchor_ps -
               (uint64_t)((wide)(clock->anchor_cycle - cycle) * HIL_SECOND_PS / clock->hclk_hz);
    uint64_t cycles = cycle - clock->anchor_cycle, product;
    /* 64 bits are enough for days at any ordinary rate, and four times faster */
    if (clock->ratio_hz == clock->hclk_hz &&
        !__builtin_mul_overflow(cycles, clock->ratio_ps, &product))
        return clock->anchor_ps + product / clock->ratio_cycles;
    wide ps = (wide)(cycle - clock->anchor_cycle) * HIL_SECOND_PS / clock->hclk_hz;
    return clock->anchor_ps + (uint64_t)ps;
}

uint64_t hil_clock_cycle(const struct hil_clock *clock, uint64_t t_ps)
{
    if (t_ps == HIL_NEVER)
        return HIL_NEVER;
    if (t_ps <= clock->anchor_ps)
        return clock->anchor_cycle;
    uint64_t product;
    if (clock->ratio_hz == clock->hclk_hz &&
        !__builtin_mul_overflow(t_ps - clock->anchor_ps, clock->ratio_cycles, &product) &&
        !__builtin_add_overflow(product, clock->ratio_ps - 1u, &product))
        return clock->anchor_cycle + product / clock->ratio_ps;
    wide cycles = ((wide)(t_ps - clock->anchor_ps) * clock->hclk_hz + (HIL_SECOND_PS - 1)) /
                  HIL_SECOND_PS;
    return clock->anchor_cycle + (uint64_t)cycles;
}

void hil_clock_turn(struct hil_clock *clock, uint32_t hclk_hz)
{
    clock->anchor_ps = hil_clock_ps(clock, clock->now_cycle);
    clock->anchor_cycle = clock->now_cycle;
    set_hz(clock, hclk_hz);
}
