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
