/* Memory for commands that run once: a failed allocation ends the process with one line and exit
 * code 3, as in git. Code that records a landing (collect, store, link, log, live) does not use
 * these functions: on failure it keeps its data and returns a status. */
#ifndef MATRIG_HOST_BASE_XMALLOC_H
#define MATRIG_HOST_BASE_XMALLOC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* As malloc, calloc, realloc, strdup, open_memstream and asprintf of the C library, but never
 * return NULL. xmemdup copies bytes. The caller frees the result. A size of 0 gives a pointer that
 * can be freed. */
void *xmalloc(size_t bytes) __attribute__((malloc, returns_nonnull));
void *xcalloc(size_t count, size_t bytes) __attribute__((malloc, returns_nonnull));
void *xrealloc(void *old, size_t bytes) __attribute__((returns_nonnull));
char *xstrdup(const char *text) __attribute__((malloc, returns_nonnull));
void *xmemdup(const void *from, size_t bytes) __attribute__((malloc, returns_nonnull));
FILE *xopen_memstream(char **text, size_t *length) __attribute__((returns_nonnull));
void *xaligned_alloc(size_t alignment, size_t bytes) __attribute__((malloc, returns_nonnull));
char *xasprintf(const char *format, ...)
    __attribute__((format(printf, 1, 2), malloc, returns_nonnull));

/* Ends the process as xmalloc does, after a failed allocation of another function. */
_Noreturn void xmalloc_exit_out_of_memory(size_t bytes);

/* Makes room for one more element in a list of `count` elements of `size` bytes. `list` is the
 * address of the list's pointer, which is NULL at first. The capacity doubles at powers of two, so
 * it need not be stored. Returns false if there is no memory; the list is then unchanged. */
bool list_grow(void *list, size_t count, size_t size);
/* As list_grow, for commands that run once: lack of memory ends the process. */
void xlist_grow(void *list, size_t count, size_t size);

#endif
