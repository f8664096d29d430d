/* Lists that grow one by one. */
#ifndef MATRIG_HOST_BASE_LIST_H
#define MATRIG_HOST_BASE_LIST_H

#include <stdbool.h>
#include <stddef.h>

/* Room for one more behind the `count` elements of `size` bytes of a list; `list` is the address of
 * its pointer, NULL at first. The room doubles at powers of two, so that nobody needs to remember
 * how large it is. False: no memory, and the list stays as it is. */
bool list_grow(void *list, size_t count, size_t size);
/* The same for commands that run once: no memory ends the process (host/base/xmalloc.h). */
void xlist_grow(void *list, size_t count, size_t size);

#endif
