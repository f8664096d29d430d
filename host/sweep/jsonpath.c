#include "host/sweep/jsonpath.h"

#include <stdlib.h>
#include <string.h>

/* The next part of a path, up to a dot; false at its end, or when the part is empty or too long. */
static bool next_part(const char **path, char part[JSONPATH_MAX])
{
    size_t length = strcspn(*path, ".");
    if (length == 0 || length >= JSONPATH_MAX)
        return false;
    memcpy(part, *path, length);
    part[length] = '\0';
    *path += length;
    if (**path == '.')
        (*path)++;
    return true;
}

static bool place_in(const json_t *list, const char *part, size_t *place)
{
    char *end;
    long number = strtol(part, &end, 10);
    long size = (long)json_array_size(list);
    if (*end != '\0' || end == part || number >= size || number < -size)
        return false;
    *place = (size_t)(number < 0 ? number + size : number);
    return true;
}

static json_t *child(const json_t *parent, const char *part)
{
    size_t place;
    if (json_is_object(parent))
        return json_object_get(parent, part);
    return json_is_array(parent) && place_in(parent, part, &place) ? json_array_get(parent, place)
                                                                   : NULL;
}

static bool put(json_t *parent, const char *part, json_t *value)
{
    size_t place;
    if (json_is_object(parent))
        return json_object_set_new(parent, part, value) == 0;
    if (json_is_array(parent) && place_in(parent, part, &place))
        return json_array_set_new(parent, place, value) == 0;
    json_decref(value);
    return false;
}

json_t *jsonpath_get(const json_t *root, const char *path)
{
    char part[JSONPATH_MAX];
    json_t *found = NULL;
    while (*path) {
        if (!next_part(&path, part))
            return NULL;
        found = child(root, part);
        if (!found)
            return NULL;
        root = found;
    }
    return found;
}

bool jsonpath_set(json_t *object, const char *path, json_t *value)
{
    char part[JSONPATH_MAX];
    json_t *at = object;
    while (next_part(&path, part)) {
        if (!*path)
            return put(at, part, json_deep_copy(value));
        json_t *inner = json_copy(child(at, part));
        if (!inner)
            return false;
        if (!put(at, part, inner))
            return false;
        at = inner; /* now owned by its parent */
    }
    return false;
}
