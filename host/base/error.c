#include "host/base/error.h"

#include <ctype.h>
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
    if (error->end_program)
        error->end_program(error);
    return status;
}

void error_kind_text(enum mr_status status, char out[static ERROR_KIND_SIZE])
{
    static const struct {
        enum mr_status status;
        const char *name;
    } kinds[] = {
#define STATUS_NAME_ROW(name, value, exit_code, text) {name, #name},
        MR_STATUS_TABLE(STATUS_NAME_ROW)
#undef STATUS_NAME_ROW
    };
    const char *name = "MR_UNKNOWN";
    size_t length = 0;
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (kinds[i].status == status)
            name = kinds[i].name;
    }
    for (const char *c = name + 3; *c && length + 1 < ERROR_KIND_SIZE; c++)
        out[length++] = *c == '_' ? '-' : (char)tolower((unsigned char)*c);
    out[length] = '\0';
}
