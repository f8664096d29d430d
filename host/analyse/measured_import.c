#include "host/analyse/measured_import.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/measured_blocks.h"
#include "host/analyse/measured_series.h"
#include "host/store/store_import.h"

#define STRIDE_MAX 1000
#define BLOCK_MOST (INT64_MAX / 2)

/* A row of a damaged campaign may begin anywhere. */
static bool on_board(const struct store_imported *row)
{
    return row->index >= 0 && row->index < (int64_t)MR_CHANNELS && row->first_block >= 0 &&
           row->first_block < BLOCK_MOST;
}

/* The rows of a file begin together: how many begin within the pause that parts groups from where
 * this one does? */
static size_t beside(const struct store_imported *rows, size_t count, size_t r)
{
    size_t n = 0;
    for (size_t k = 0; k < count; k++)
        n += on_board(&rows[k]) &&
             llabs(rows[k].first_block - rows[r].first_block) <= 1000 * MOMENTS_PAUSE_S;
    return n;
}

/* Rows that begin elsewhere than most do are set aside: left are the others, in front. How many. */
static size_t rows_together(struct measured *measured, struct store_imported *rows, size_t count)
{
    size_t most = 0, left = 0;
    for (size_t r = 0; r < count; r++)
        most = on_board(&rows[r]) && beside(rows, count, r) > most ? beside(rows, count, r) : most;
    for (size_t r = 0; r < count; r++) {
        bool together = on_board(&rows[r]) && beside(rows, count, r) == most;
        for (size_t i = 0; !together && i < rows[r].count; i++) {
            if (!isnan(rows[r].reading[i]))
                measured_set_aside(&measured->aside, &measured->aside.readings,
                                   rows[r].first_block);
        }
        struct store_imported row = rows[r];
        rows[r] = rows[left];
        rows[left] = row;
        left += together;
    }
    return left;
}

/* From the first to the last block of all rows, missing readings too; but where times were set
 * aside, of what was left. */
static struct measured_span span_of_rows(const struct store_imported *rows, size_t count,
                                         const struct moments *moments)
{
    struct measured_span span = {0};
    for (size_t r = 0; r < count; r++)
        measured_span_add(&span, rows[r].first_block,
                          rows[r].first_block + (int64_t)rows[r].count - 1);
    for (size_t g = 0; g < moments->groups; g++) {
        const struct moments_group *group = &moments->group[g];
        if (g == 0 && span.first / 1000 < group->from_s - MOMENTS_PAUSE_S)
            span.first = 1000 * group->from_s;
        if (g + 1 == moments->groups && span.last / 1000 > group->to_s + MOMENTS_PAUSE_S)
            span.last = 1000 * group->to_s + 999;
    }
    return span;
}

static void fill_from_row(struct measured *measured, const struct store_imported *row,
                          const struct moments *moments)
{
    struct measured_channel *channel = &measured->channel[row->index];
    channel->stride = row->stride >= 1 && row->stride <= STRIDE_MAX ? (size_t)row->stride : 1;
    for (size_t i = 0; i < row->count; i++) {
        int64_t block = row->first_block + (int64_t)i, at = block - measured->first_block;
        bool missing = isnan(row->reading[i]), held = moments_hold(moments, block);
        if (!missing && !held)
            measured_set_aside(&measured->aside, &measured->aside.readings, block);
        if (at < 0 || at >= (int64_t)measured->samples)
            continue;
        channel->source[at] = MEASURED_IMPORT;
        if (missing || !held)
            continue;
        channel->raw[at] = row->reading[i];
        channel->validity[at] = MR_VALID;
    }
}

static enum mr_status fill_from_import(struct measured *measured, struct store_imported *rows,
                                       size_t all, struct error *error)
{
    struct moments moments = {0};
    size_t count = rows_together(measured, rows, all);
    for (size_t r = 0; r < count; r++) {
        for (size_t i = 0; i < rows[r].count; i++) {
            if (!isnan(rows[r].reading[i]))
                moments_add(&moments, rows[r].first_block + (int64_t)i);
        }
    }
    enum mr_status status = measured_judge(measured, &moments, error);
    struct measured_span span = span_of_rows(rows, count, &moments);
    if (status == MR_OK)
        status = span.any ? measured_check_span(measured, span.first, span.last, error)
                          : measured_check_span(measured, 0, -1, error);
    if (status == MR_OK)
        status = measured_make_series(measured, &span, error);
    for (size_t r = 0; r < count && status == MR_OK; r++)
        fill_from_row(measured, &rows[r], &moments);
    moments_free(&moments);
    measured->source = MEASURED_IMPORT;
    return status;
}

enum mr_status measured_load_import(struct store *store, struct measured *measured,
                                    struct error *error)
{
    struct store_imported *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_imported(store, measured->landing.id, &rows, &count, error);
    if (status == MR_OK && count)
        status = fill_from_import(measured, rows, count, error);
    store_imported_free(rows, count);
    return status;
}
