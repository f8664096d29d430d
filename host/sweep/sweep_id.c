#include "host/sweep/sweep_id.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/sweep/canonical.h"

/* What all cases share, beside the base. Outputs count as a set; the name of study or scene,
 * timeouts and labels do not. */
static uint64_t shared_hash(const struct sweep_study *study)
{
    json_t *outputs = json_object();
    for (size_t i = 0; i < json_array_size(sweep_study_outputs(study)); i++)
        json_object_set_new(
            outputs, json_string_value(json_array_get(sweep_study_outputs(study), i)), json_true());
    uint64_t hash = canonical_hash(FNV_BASIS, outputs);
    hash = canonical_hash(hash, json_object_get(study->root, "find"));
    hash = canonical_hash(hash, json_object_get(study->root, "solver"));
    hash = canonical_hash(hash, json_object_get(study->root, "rtol"));
    json_decref(outputs);
    const char *kind = sweep_kind_names[study->kind];
    return fnv1a(hash, kind, strlen(kind));
}

struct hashed_key {
    const char *name;
    const json_t *value; /* of the base; NULL: not in it */
    uint64_t hash;
};

static int by_key(const void *a, const void *b)
{
    return strcmp(((const struct hashed_key *)a)->name, ((const struct hashed_key *)b)->name);
}

/* Every key that a case can have, sorted, with the hash of the base's value: values that a case
 * shares with the base are not hashed again. */
static struct hashed_key *hash_keys(const json_t *input, const json_t *base, size_t *count)
{
    struct hashed_key *keys = calloc(json_object_size(input) + 1, sizeof *keys);
    const char *name;
    json_t *value;
    *count = 0;
    json_object_foreach((json_t *)(uintptr_t)input, name, value)
    {
        if (!keys || name[0] == '_' || strcmp(name, "name") == 0)
            continue;
        const json_t *own = json_object_get(base, name);
        keys[(*count)++] = (struct hashed_key){name, own, own ? canonical_hash(FNV_BASIS, own) : 0};
    }
    if (keys)
        qsort(keys, *count, sizeof *keys, by_key);
    return keys;
}

static uint64_t case_hash(uint64_t hash, const struct hashed_key *keys, size_t count,
                          const json_t *input)
{
    for (size_t i = 0; i < count; i++) {
        const json_t *value = json_object_get(input, keys[i].name);
        uint64_t own = value && value == keys[i].value ? keys[i].hash
                                                       : canonical_hash(FNV_BASIS, value);
        hash = fnv1a(hash, keys[i].name, strlen(keys[i].name) + 1);
        hash = fnv1a(hash, &own, sizeof own);
    }
    return hash;
}

static int by_id(const void *a, const void *b)
{
    const struct sweep_place *p = a, *q = b;
    return p->id != q->id ? (p->id < q->id ? -1 : 1) : p->index < q->index ? -1 : 1;
}

static enum mr_status check_distinct(const struct sweep_study *study, const char *path,
                                     struct error *error)
{
    for (size_t i = 1; i < study->cases; i++) {
        if (study->order[i].id != study->order[i - 1].id)
            continue;
        json_t *values = sweep_study_values(study, study->order[i].index);
        char *text = json_dumps(values, JSON_COMPACT);
        error_set(error, MR_MALFORMED,
                  "the same case twice: %s: %.300s (cases %zu and %zu); take one of them out", path,
                  text ? text : "", study->order[i - 1].index, study->order[i].index);
        free(text);
        json_decref(values);
        return error->status;
    }
    return MR_OK;
}

/* What the base has where the search puts its values does not count. */
static void drop_searched(const struct sweep_study *study, json_t *input)
{
    const char *key;
    json_t *factor;
    if (!study->find.key.set)
        json_object_del(input, study->find.key.name);
    json_object_foreach(study->find.key.set, key, factor) json_object_del(input, key);
}

enum mr_status sweep_study_make_ids(struct sweep_study *study, const char *path,
                                    struct error *error)
{
    uint64_t shared = shared_hash(study);
    struct hashed_key *keys = NULL;
    size_t count = 0;
    study->ids = calloc(study->cases, sizeof *study->ids);
    study->order = calloc(study->cases, sizeof *study->order);
    if (!study->ids || !study->order)
        return error_set(error, MR_FULL, "out of memory: %s: %zu cases; split the study", path,
                         study->cases);
    json_t *first = NULL; /* owns the names in keys */
    for (size_t i = 0; i < study->cases; i++) {
        json_t *input = sweep_study_input(study, i);
        if (!input) {
            error_set(error, MR_MALFORMED,
                      "no such place: %s: a dotted key leads nowhere in the base; correct it",
                      path);
            break;
        }
        if (study->find.wanted)
            drop_searched(study, input);
        if (i == 0) {
            first = json_incref(input);
            keys = hash_keys(input, study->base, &count);
        }
        study->ids[i] = case_hash(shared, keys, count, input);
        study->order[i] = (struct sweep_place){study->ids[i], i};
        json_decref(input);
    }
    free(keys);
    json_decref(first);
    if (error->status != MR_OK)
        return error->status;
    qsort(study->order, study->cases, sizeof *study->order, by_id);
    return check_distinct(study, path, error);
}

void sweep_id_text(uint64_t id, char text[SWEEP_ID_SIZE])
{
    snprintf(text, SWEEP_ID_SIZE, "%016" PRIx64, id);
}

bool sweep_id_parse(const char *text, uint64_t *id)
{
    if (!text || strlen(text) != SWEEP_ID_SIZE - 1 ||
        strspn(text, "0123456789abcdef") != SWEEP_ID_SIZE - 1)
        return false;
    *id = strtoull(text, NULL, 16);
    return true;
}

bool sweep_study_find(const struct sweep_study *study, uint64_t id, size_t *index)
{
    size_t low = 0, high = study->cases;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (study->order[middle].id < id)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == study->cases || study->order[low].id != id)
        return false;
    *index = study->order[low].index;
    return true;
}
