#include "hil/core/file_place.h"

#include <errno.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum mr_status hil_file_refuse(const struct hil_file_place *at, enum mr_status status,
                               const char *format, ...)
{
    va_list arguments;
    int n = at->line ? snprintf(at->error, at->error_size, "%s:%u: ", at->path, at->line)
                     : snprintf(at->error, at->error_size, "%s: ", at->path);
    va_start(arguments, format);
    if (n > 0 && (size_t)n < at->error_size)
        vsnprintf(at->error + n, at->error_size - (size_t)n, format, arguments);
    va_end(arguments);
    for (char *p = at->error; *p; p++) {
        /* a file name may contain any printable character, text of a file only ASCII */
        if ((*p > 0 && *p < ' ') || (p - at->error >= n && (*p < ' ' || *p > '~')))
            *p = '?';
    }
    return status;
}

enum mr_status hil_file_read(const struct hil_file_place *at, size_t most, const char *advice,
                             char **bytes, size_t *size)
{
    FILE *file = fopen(at->path, "rb");
    size_t room = 0;
    *bytes = NULL;
    *size = 0;
    if (!file)
        return hil_file_refuse(at, MR_IO, "%s; %s", strerror(errno), advice);
    while (*size == room && room <= most) {
        room = room ? 2 * room : 1u << 20;
        *bytes = realloc(*bytes, room + 1);
        if (!*bytes)
            abort(); /* without memory the board aborts too */
        *size += fread(*bytes + *size, 1, room - *size, file);
    }
    bool failed = ferror(file) != 0;
    fclose(file);
    (*bytes)[*size] = '\0';
    if (failed)
        return hil_file_refuse(at, MR_IO, "cannot be read; %s", advice);
    return *size <= most
             ? MR_OK
             : hil_file_refuse(at, MR_TOO_LONG, "larger than %zu bytes; %s", most, advice);
}
