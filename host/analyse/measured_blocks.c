#include "host/analyse/measured_blocks.h"

#include <stdlib.h>

#include "host/base/xmalloc.h"

void measured_set_aside(struct measured_aside *aside, size_t *count, int64_t block)
{
    if (aside->blocks + aside->messages + aside->edges + aside->readings == 0)
        aside->block = block;
    ++*count;
}

static enum mr_status keep_block(void *context, const uint8_t *record, size_t length)
{
    struct measured_blocks *list = context;
    struct mr_block block;
    enum mr_status status = mr_block_get(&block, record, length);
    size_t row = list->rows++;
    if (status != MR_OK)
        return status;
    if (!moments_hold(list->moments, block.index)) {
        measured_set_aside(list->aside, &list->aside->blocks, block.index);
        return MR_OK;
    }
    if ((int64_t)block.index < list->from) {
        list->skipped++;
        return MR_OK;
    }
    if (!list_grow(&list->block, list->count, sizeof *list->block) ||
        !list_grow(&list->source, list->count, sizeof *list->source) ||
        !list_grow(&list->row, list->count, sizeof *list->row))
        return MR_FULL;
    list->row[list->count] = row;
    list->block[list->count++] = block;
    return MR_OK;
}

static void keep_source(void *context, int64_t index, int link)
{
    struct measured_blocks *list = context;
    (void)index;
    if (list->known < list->count && list->row[list->known] == list->named++)
        list->source[list->known++] = link == STORE_LINK_BOX ? MEASURED_BOX : MEASURED_SERIAL;
}

enum mr_status measured_blocks_load(struct store *store, int64_t run, struct measured_blocks *list,
                                    struct error *error)
{
    enum mr_status status = store_blocks_each(store, run, keep_block, list, error);
    if (status == MR_FULL)
        return error_set(error, status, "no memory: RUN %lld; close other programs",
                         (long long)run);
    if (status != MR_OK)
        return error_set(error, MR_MALFORMED,
                         "damaged block record: RUN %lld of %s; the database is damaged",
                         (long long)run, store_path(store));
    return store_block_links_each(store, run, keep_source, list, error);
}

void measured_blocks_free(struct measured_blocks *list)
{
    free(list->block);
    free(list->source);
    free(list->row);
}
