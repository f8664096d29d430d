#include "hil/rig/fault_log.h"

#include <stdarg.h>

#include "hil/core/core.h"
#include "hil/core/time.h"

void hil_fault_tell(struct hil_core *core, FILE *log, unsigned file_line, const char *format, ...)
{
    char text[160];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    core->state.counters.faults_injected++;
    hil_trace(core, "fault: %s", text);
    if (!log)
        return;
    uint64_t t_ns = hil_now_ps(core) / HIL_NS_PS;
    fprintf(log, "fault at %llu.%09llu s: %s", (unsigned long long)(t_ns / 1000000000u),
            (unsigned long long)(t_ns % 1000000000u), text);
    if (file_line)
        fprintf(log, " (line %u)", file_line);
    fputc('\n', log);
}
