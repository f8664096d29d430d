#include "hil/core/file_place.h"

#include <errno.h>
#include <limits.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum mr_status hil_file_refuse(const struct hil_file_context *at, enum mr_status status,
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
        /* control characters are not allowed; a path may contain UTF-8, text from the file only
         * ASCII */
        if ((*p > 0 && *p < ' ') || (p - at->error >= n && (*p < ' ' || *p > '~')))
            *p = '?';
    }
    return status;
}

/* Returns the path of the file with this name that is part of matrig's build or installation; NULL:
 * there is none. The caller frees it. */
static char *find_installed_file(const char *path)
{
    static const char *const places[] = {"..", "../share/matrig/runs", "../share/matrig"};
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    char program[PATH_MAX], place[2 * PATH_MAX + 80], *found = NULL;
    ssize_t length = readlink("/proc/self/exe", program, sizeof program);
    while (length > 0 && program[length - 1] != '/')
        length--;
    for (size_t i = path[0] == '/'; i < sizeof places / sizeof places[0] && !found; i++) {
        snprintf(place, sizeof place, "%.*s%s/%s", (int)length, program, places[i],
                 i == 0 ? path : name);
        found = *name ? realpath(place, NULL) : NULL;
    }
    return found;
}

/* Reports that the file does not exist. For a relative path the message names the current folder,
 * because it may be the wrong one. */
static enum mr_status refuse_missing(const struct hil_file_context *at, const char *advice)
{
    char folder[PATH_MAX] = "", *own = find_installed_file(at->path);
    bool relative = at->path[0] != '/' && getcwd(folder, sizeof folder);
    enum mr_status status = hil_file_refuse(
        at, MR_IO, "%s%s%s; %s%s", strerror(ENOENT), relative ? " in the folder " : "", folder,
        own ? "the file that was installed with matrig is " : advice, own ? own : "");
    free(own);
    return status;
}

enum mr_status hil_file_read(const struct hil_file_context *at, size_t max_bytes,
                             const char *advice, char **bytes, size_t *size)
{
    FILE *file = fopen(at->path, "rb");
    size_t room = 0;
    *bytes = NULL;
    *size = 0;
    if (!file && errno == ENOENT)
        return refuse_missing(at, advice);
    if (!file)
        return hil_file_refuse(at, MR_IO, "%s; %s", strerror(errno), advice);
    while (*size == room && room <= max_bytes) {
        room = room ? 2 * room : 1u << 20;
        *bytes = realloc(*bytes, room + 1);
        if (!*bytes)
            abort(); /* out of memory: abort, as everywhere in the emulated board */
        *size += fread(*bytes + *size, 1, room - *size, file);
    }
    bool failed = ferror(file) != 0;
    fclose(file);
    (*bytes)[*size] = '\0';
    if (failed)
        return hil_file_refuse(at, MR_IO, "cannot be read; %s", advice);
    return *size <= max_bytes
             ? MR_OK
             : hil_file_refuse(at, MR_TOO_LONG, "the file is larger than %zu bytes; %s", max_bytes,
                               advice);
}
