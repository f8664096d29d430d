/* Memory for commands that run once: an allocation that fails ends the process with one line and
 * exit code 3, as in git. What records a landing (collect, store, link, log, live) does not use
 * these: it keeps its data and reports a status. */
#ifndef MATRIG_HOST_BASE_XMALLOC_H
#define MATRIG_HOST_BASE_XMALLOC_H

#include <stdio.h>

/* As malloc, calloc, realloc, strdup, open_memstream and asprintf of the C library, but never NULL.
 * The caller frees what they return. A size of 0 gives a pointer that can be freed. */
void *xmalloc(size_t bytes) __attribute__((malloc, returns_nonnull));
void *xcalloc(size_t count, size_t bytes) __attribute__((malloc, returns_nonnull));
void *xrealloc(void *old, size_t bytes) __attribute__((returns_nonnull));
char *xstrdup(const char *text) __attribute__((malloc, returns_nonnull));
FILE *xopen_memstream(char **text, size_t *length) __attribute__((returns_nonnull));
char *xasprintf(const char *format, ...)
    __attribute__((format(printf, 1, 2), malloc, returns_nonnull));

#endif
