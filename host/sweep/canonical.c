#include "host/sweep/canonical.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

uint64_t fnv1a(uint64_t hash, const void *bytes, size_t size)
{
    const unsigned char *byte = bytes;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ byte[i]) * 0x100000001b3u;
    return hash;
}

static uint64_t text_hash(uint64_t hash, const char *text)
{
    return fnv1a(hash, text, strlen(text) + 1); /* with its end: "ab","c" is not "a","bc" */
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static uint64_t object_hash(uint64_t hash, const json_t *object)
{
    size_t count = 0;
    const char **names = calloc(json_object_size(object) + 1, sizeof *names);
    const char *name;
    json_t *value;
    if (!names)
        abort(); /* a wrong id would be worse than no sweep */
    json_object_foreach((json_t *)(uintptr_t)object, name, value)
    {
        if (name[0] != '_')
            names[count++] = name;
    }
    qsort(names, count, sizeof *names, by_name);
    hash = fnv1a(hash, "{", 1);
    for (size_t i = 0; i < count; i++)
        hash = canonical_hash(text_hash(hash, names[i]), json_object_get(object, names[i]));
    free(names);
    return fnv1a(hash, "}", 1);
}

uint64_t canonical_hash(uint64_t hash, const json_t *value)
{
    char number[40];
    switch (value ? json_typeof(value) : JSON_NULL) {
    case JSON_OBJECT: return object_hash(hash, value);
    case JSON_ARRAY:
        hash = fnv1a(hash, "[", 1);
        for (size_t i = 0; i < json_array_size(value); i++)
            hash = canonical_hash(hash, json_array_get(value, i));
        return fnv1a(hash, "]", 1);
    case JSON_STRING: return text_hash(fnv1a(hash, "\"", 1), json_string_value(value));
    case JSON_INTEGER:
    case JSON_REAL:
        /* + 0: no minus before 0 */
        snprintf(number, sizeof number, "%.17g", json_number_value(value) + 0.0);
        return text_hash(fnv1a(hash, "#", 1), number);
    case JSON_TRUE: return fnv1a(hash, "t", 1);
    case JSON_FALSE: return fnv1a(hash, "f", 1);
    case JSON_NULL: break;
    }
    return fnv1a(hash, "n", 1);
}
