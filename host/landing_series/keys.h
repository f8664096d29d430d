/* Keys: reading the keys of a study file's objects. An error names the file, the object
 * (`where`, "" at the top) and the key; after the first nothing more is read. An absent key leaves
 * its value as it was. */
#ifndef MATRIG_HOST_LANDING_SERIES_KEYS_H
#define MATRIG_HOST_LANDING_SERIES_KEYS_H

#include "host/landing_series/series.h"

struct keys {
    const char *path;
    struct error *error;
};

bool keys_failed(const struct keys *keys);
/* "wrong value: FILE: WHERE.KEY; give WANTED". */
void keys_wrong(const struct keys *keys, const char *where, const char *key, const char *wanted);

/* Every key must be one of `known` (a list that ends with NULL), or a comment. */
void keys_check(const struct keys *keys, const char *where, const json_t *object,
                const char *const *known);

void keys_number(const struct keys *keys, const char *where, const json_t *object, const char *key,
                 double low, double high, double *value);
void keys_range(const struct keys *keys, const char *where, const json_t *object, const char *key,
                double low, double high, struct series_range *value);
/* Index of a word among `choices` (short words; the list ends with NULL), or `now` when the key is
 * absent. */
unsigned keys_choice(const struct keys *keys, const char *where, const json_t *object,
                     const char *key, const char *const *choices, unsigned now);
void keys_text(const struct keys *keys, const char *where, const json_t *object, const char *key,
               char *to, size_t size);

#endif
