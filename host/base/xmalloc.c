#include "host/base/xmalloc.h"

#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "common/status.h"

_Noreturn void xmalloc_exit_out_of_memory(size_t bytes)
{
    fprintf(stderr, "matrig: out of memory: cannot allocate %zu bytes; close other programs\n",
            bytes);
    exit(mr_status_exit_code(MR_FULL));
}

static void *check_allocated(void *memory, size_t bytes)
{
    if (!memory)
        xmalloc_exit_out_of_memory(bytes);
    return memory;
}

void *xmalloc(size_t bytes)
{
    return check_allocated(malloc(bytes ? bytes : 1), bytes);
}

void *xcalloc(size_t count, size_t bytes)
{
    return check_allocated(calloc(count ? count : 1, bytes ? bytes : 1), count * bytes);
}

void *xrealloc(void *old, size_t bytes)
{
    return check_allocated(realloc(old, bytes ? bytes : 1), bytes);
}

void *xaligned_alloc(size_t alignment, size_t bytes)
{
    return check_allocated(aligned_alloc(alignment, bytes), bytes);
}

void *xmemdup(const void *from, size_t bytes)
{
    return memcpy(xmalloc(bytes), from, bytes);
}

char *xstrdup(const char *text)
{
    return check_allocated(strdup(text), strlen(text) + 1);
}

FILE *xopen_memstream(char **text, size_t *length)
{
    return check_allocated(open_memstream(text, length), BUFSIZ);
}

char *xasprintf(const char *format, ...)
{
    va_list arguments;
    char *text = NULL;
    va_start(arguments, format);
    if (vasprintf(&text, format, arguments) < 0)
        text = NULL;
    va_end(arguments);
    return check_allocated(text, BUFSIZ);
}

bool list_grow(void *list, size_t count, size_t size)
{
    void *elements;
    if (count & (count - 1))
        return true;
    memcpy(&elements, list, sizeof elements);
    elements = realloc(elements, (count ? 2 * count : 1) * size);
    if (elements)
        memcpy(list, &elements, sizeof elements);
    return elements != NULL;
}

void xlist_grow(void *list, size_t count, size_t size)
{
    void *elements;
    if (count & (count - 1))
        return;
    memcpy(&elements, list, sizeof elements);
    elements = xrealloc(elements, (count ? 2 * count : 1) * size);
    memcpy(list, &elements, sizeof elements);
}
