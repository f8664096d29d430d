#include "host/base/list.h"

#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"

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
