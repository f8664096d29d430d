/* Memory for commands that run once: an allocation that fails ends the process with one line and
 * exit code 3, as in git. What records a landing (collect, store, link, log, live) does not use
 * these: it keeps its data and reports a status. */
#ifndef MATRIG_HOST_BASE_XMALLOC_H
#define MATRIG_HOST_BASE_XMALLOC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* As malloc, calloc, realloc, strdup, open_memstream and asprintf of the C library, but never NULL;
 * xmemdup copies bytes as strdup does a text.
 * The caller frees what they return. A size of 0 gives a pointer that can be freed. */
void *xmalloc(size_t bytes) __attribute__((malloc, returns_nonnull));
void *xcalloc(size_t count, size_t bytes) __attribute__((malloc, returns_nonnull));
void *xrealloc(void *old, size_t bytes) __attribute__((returns_nonnull));
char *xstrdup(const char *text) __attribute__((malloc, returns_nonnull));
void *xmemdup(const void *from, size_t bytes) __attribute__((malloc, returns_nonnull));
FILE *xopen_memstream(char **text, size_t *length) __attribute__((returns_nonnull));
void *xaligned_alloc(size_t alignment, size_t bytes) __attribute__((malloc, returns_nonnull));
char *xasprintf(const char *format, ...)
    __attribute__((format(printf, 1, 2), malloc, returns_nonnull));

/* What else cannot be had for want of memory ends the process alike. */
_Noreturn void xmalloc_failed(size_t bytes);

/* Lists that grow one by one. */

/* Room for one more behind the `count` elements of `size` bytes of a list; `list` is the address of
 * its pointer, NULL at first. The room doubles at powers of two, so its size need not be stored.
 * False: no memory, and the list stays as it is. */
bool list_grow(void *list, size_t count, size_t size);
/* The same for commands that run once: no memory ends the process (host/base/xmalloc.h). */
void xlist_grow(void *list, size_t count, size_t size);

#endif
