#include "host/base/error.h"

#include <stdarg.h>
#include <stdio.h>

enum mr_status error_set(struct error *error, enum mr_status status, const char *format, ...)
{
    if (error->status != MR_OK)
        return status;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->text, sizeof error->text, format, arguments);
    va_end(arguments);
    for (char *p = error->text; *p; p++) {
        if ((unsigned char)*p < 0x20 || *p == 0x7f)
            *p = '?';
    }
    error->status = status;
    return status;
}
