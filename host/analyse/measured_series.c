#include "host/analyse/measured_series.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/catalogue.h"
#include "common/watch.h"
#include "common/wire.h"
#include "host/analyse/measured.h"
#include "host/base/xmalloc.h"
#include "host/link/link.h"
#include "host/store/store_import.h"
#include "host/store/store_journal.h"

struct measured_span {
    int64_t first, last; /* blocks, both in it */
    bool any;
};

/* Block records of a landing, in order, as far as their times can belong to it. `from`, `moments`
 * and `aside` are given. */
struct measured_blocks {
    struct mr_block *block;
    uint8_t *source; /* enum measured_source */
    size_t count;
    size_t *row;  /* in the campaign, counted from 0 */
    size_t rows;  /* seen, */
    size_t known; /* and of how many of those that were kept the source is, */
    size_t named; /* rows seen for it */
    int64_t from; /* blocks before it are passed over */
    int64_t skipped;
    const struct moments *moments;
    struct measured_aside *aside;
};

#define BLOCKS_PER_S 1000
#define SHARE        100u /* less than a hundredth of the largest group is none of the landing, */
#define LEAST        100u /* but with edges in it so many are enough: the link was down before */
#define BOARD_S      4294968.0 /* a board counts blocks in 32 bits */

static void add(struct moments *moments, int64_t second, size_t count, size_t edges)
{
    struct moments_group *last = moments->groups ? &moments->group[moments->groups - 1] : NULL;
    if (last && second >= last->from_s && second <= last->to_s + 1) {
        last->to_s = second > last->to_s ? second : last->to_s;
        last->count += count;
        last->edges += edges;
        return;
    }
    if (list_grow(&moments->group, moments->groups, sizeof *moments->group))
        moments->group[moments->groups++] = (struct moments_group){second, second, count, edges};
    else
        moments->full = true;
}

void moments_add(struct moments *moments, int64_t block)
{
    add(moments, block / BLOCKS_PER_S, 1, 0);
}

static bool on_board(double board_s)
{
    return board_s >= 0.0 && board_s < BOARD_S;
}

void moments_add_edge(struct moments *moments, double board_s)
{
    if (on_board(board_s))
        add(moments, (int64_t)board_s, 0, 1);
}

static int by_time(const void *a, const void *b)
{
    int64_t x = ((const struct moments_group *)a)->from_s,
            y = ((const struct moments_group *)b)->from_s;
    return (x > y) - (x < y);
}

/* In order, those without a pause between them as one. */
static void join(struct moments *moments)
{
    size_t made = 0;
    if (moments->groups)
        qsort(moments->group, moments->groups, sizeof *moments->group, by_time);
    for (size_t g = 0; g < moments->groups; g++) {
        const struct moments_group next = moments->group[g];
        struct moments_group *last = made ? &moments->group[made - 1] : NULL;
        if (last && next.from_s - MOMENTS_PAUSE_S <= last->to_s) {
            last->to_s = next.to_s > last->to_s ? next.to_s : last->to_s;
            last->count += next.count;
            last->edges += next.edges;
        } else {
            moments->group[made++] = next;
        }
    }
    moments->groups = made;
}

enum mr_status moments_judge(struct moments *moments)
{
    size_t most = 0, left = 0;
    join(moments);
    for (size_t g = 0; g < moments->groups; g++)
        most = moments->group[g].count > most ? moments->group[g].count : most;
    for (size_t g = 0; g < moments->groups; g++) {
        const struct moments_group group = moments->group[g];
        if (group.count && (group.count > most / SHARE || group.count == most ||
                            (group.edges && group.count >= LEAST)))
            moments->group[left++] = group;
    }
    moments->groups = left;
    return moments->full ? MR_FULL : MR_OK;
}

static bool holds(const struct moments *moments, int64_t second)
{
    for (size_t g = 0; g < moments->groups; g++) {
        if (second >= moments->group[g].from_s && second <= moments->group[g].to_s)
            return true;
    }
    return moments->groups == 0;
}

bool moments_hold(const struct moments *moments, int64_t block)
{
    return holds(moments, block / BLOCKS_PER_S);
}

bool moments_hold_edge(const struct moments *moments, double board_s)
{
    return moments->groups == 0 || (on_board(board_s) && holds(moments, (int64_t)board_s));
}

void moments_free(struct moments *moments)
{
    free(moments->group);
    *moments = (struct moments){0};
}

static void measured_set_aside(struct measured_aside *aside, size_t *count, int64_t block)
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

static enum mr_status measured_blocks_load(struct store *store, int64_t run,
                                           struct measured_blocks *list, struct error *error)
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

static void measured_blocks_free(struct measured_blocks *list)
{
    free(list->block);
    free(list->source);
    free(list->row);
}

static void measured_span_add(struct measured_span *span, int64_t first, int64_t last)
{
    span->first = span->any && span->first < first ? span->first : first;
    span->last = span->any && span->last > last ? span->last : last;
    span->any = true;
}

static enum mr_status measured_make_series(struct measured *measured,
                                           const struct measured_span *span, struct error *error)
{
    size_t samples = (size_t)(span->last - span->first) + 1;
    measured->first_block = span->first;
    measured->samples = samples;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        struct measured_channel *channel = &measured->channel[c];
        channel->raw = malloc(samples * sizeof *channel->raw);
        channel->validity = malloc(samples);
        channel->source = calloc(samples, 1);
        channel->stride = 1;
        if (!channel->raw || !channel->validity || !channel->source)
            return error_set(error, MR_FULL,
                             "no memory: RUN %lld with %zu samples; close other programs",
                             (long long)measured->landing.id, samples);
        memset(channel->validity, MEASURED_LOST, samples);
        for (size_t i = 0; i < samples; i++)
            channel->raw[i] = MR_NAN;
    }
    return MR_OK;
}

#define SAMPLES_MAX 3600000

static enum mr_status measured_check_span(const struct measured *measured, int64_t first,
                                          int64_t last, struct error *error)
{
    if (last >= first && last - first < SAMPLES_MAX)
        return MR_OK;
    return error_set(
        error, MR_MALFORMED,
        "impossible block numbers: RUN %lld, blocks %lld to %lld; the database is damaged",
        (long long)measured->landing.id, (long long)first, (long long)last);
}

static void begin_watch(struct mr_watch *watch, const struct measured *measured, uint32_t index)
{
    struct mr_channel_config config[MR_CHANNELS];
    for (unsigned c = 0; c < MR_CHANNELS; c++)
        config[c] = measured->channel[c].config;
    mr_watch_begin(watch, config, index);
}

/* The board saw what came in a hole; here a channel may have left its band there and come back,
 * while its neighbours moved. What was not stuck before is judged anew. */
#define WATCH_HOLE_BLOCKS 20
static void pass_hole(struct mr_watch *watch)
{
    for (unsigned c = 0; c < MR_WATCHED; c++) {
        if (!watch->channel[c].stuck)
            watch->channel[c].anchor = MR_NAN;
    }
}

/* As the board does it. A channel that turns out to be stuck has been so since its anchor: those
 * readings lose their validity here and, when they have been held against the board's messages,
 * their value (blank_stuck). */
static void read_block(struct measured *measured, struct mr_watch *watch,
                       const struct mr_block *block, enum measured_source source)
{
    size_t i = (size_t)((int64_t)block->index - measured->first_block);
    float ratio = mr_channels_ratio(&measured->channel[MR_REFERENCE].config, block);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        struct measured_channel *channel = &measured->channel[c];
        struct mr_reading reading = mr_channel_read(&channel->config, block, c, ratio);
        if (c < MR_WATCHED)
            mr_watch_reading(watch, &channel->config, c, block->index, &reading);
        channel->raw[i] = reading.value;
        channel->validity[i] = reading.validity;
        channel->source[i] = (uint8_t)source;
        if (reading.validity != MR_INVALID_STUCK)
            continue;
        for (size_t k = i; k-- > 0 &&
                           (int64_t)k + measured->first_block >= watch->channel[c].anchor_block &&
                           channel->validity[k] != MR_INVALID_STUCK;) {
            if (channel->validity[k] == MR_VALID)
                channel->validity[k] = MR_INVALID_STUCK;
        }
    }
}

static void blank_stuck(struct measured *measured)
{
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        for (size_t i = 0; i < measured->samples; i++) {
            if (measured->channel[c].validity[i] == MR_INVALID_STUCK)
                measured->channel[c].raw[i] = MR_NAN;
        }
    }
}

/* Samples from CAN: what the board said of a channel that stuck, up to what it said of it next. */
static enum mr_status take_stuck_from_events(struct store *store, struct measured *measured,
                                             struct error *error)
{
    struct store_fault *event = NULL;
    size_t count = 0;
    enum mr_status status = store_channel_events(store, measured->landing.id, &event, &count,
                                                 error);
    for (size_t e = 0; e < count && status == MR_OK; e++) {
        if (event[e].code != MR_INVALID_STUCK || event[e].detail < 0 ||
            event[e].detail >= (int64_t)MR_WATCHED)
            continue;
        int64_t until = measured->first_block + (int64_t)measured->samples;
        for (size_t later = count; later-- > e + 1;)
            until = event[later].detail == event[e].detail ? event[later].board_us / 1000 : until;
        for (int64_t block = event[e].board_us / 1000; block < until; block++) {
            int64_t i = block - measured->first_block;
            struct measured_channel *channel = &measured->channel[event[e].detail];
            if (i >= 0 && i < (int64_t)measured->samples && channel->source[i] == MEASURED_CAN)
                channel->validity[i] = MR_INVALID_STUCK;
        }
    }
    free(event);
    return status;
}

/* ---- CAN messages of decimated channels ---- */

static const struct mr_series_pack *find_pack(const struct store_frame *frame)
{
    unsigned number = frame->id <= UINT16_MAX ? mr_series_pack_find((uint16_t)frame->id)
                                              : MR_SERIES_PACKS;
    bool whole = frame->length == MR_MESSAGE_MAX && frame->board_us != STORE_NONE;
    return number < MR_SERIES_PACKS && whole ? mr_series_pack_at(number) : NULL;
}

struct spans {
    struct measured_span blocks, all;
    int64_t from;
    const struct moments *moments;
    struct measured_aside *aside;
};

/* Times of the messages that measure. */
static enum mr_status add_moment(void *context, const struct store_frame *frame)
{
    if (find_pack(frame))
        moments_add(context, frame->board_us / 1000);
    return MR_OK;
}

/* What a message is the mean of is added where it lies before or behind all block records. */
static enum mr_status find_span(void *context, const struct store_frame *frame)
{
    struct spans *spans = context;
    const struct mr_series_pack *pack = find_pack(frame);
    if (!pack)
        return MR_OK;
    int64_t last = frame->board_us / 1000, first = last - mr_series_at(pack->series)->blocks + 1;
    if (!moments_hold(spans->moments, last)) {
        measured_set_aside(spans->aside, &spans->aside->messages, last);
        return MR_OK;
    }
    if (first < spans->from)
        return MR_OK;
    if (!spans->blocks.any || last < spans->blocks.first || first > spans->blocks.last)
        measured_span_add(&spans->all, first, last);
    return MR_OK;
}

/* One of the samples that a message is the mean of, if nothing better has it. `end`: sample after
 * the message's last. */
static void fill_sample(struct measured_channel *channel, size_t i, float value, unsigned blocks,
                        size_t end)
{
    if (channel->source[i] == MEASURED_SERIAL || channel->source[i] == MEASURED_BOX)
        return;
    channel->source[i] = MEASURED_CAN;
    channel->stride = blocks;
    channel->phase = (blocks - end % blocks) % blocks;
    channel->raw[i] = value;
    channel->validity[i] = isnan(value) ? MEASURED_NOT_VALID : MR_VALID;
}

static enum mr_status fill_from_message(void *context, const struct store_frame *frame)
{
    struct measured *measured = context;
    const struct mr_series_pack *pack = find_pack(frame);
    if (!pack)
        return MR_OK;
    const struct mr_series *series = mr_series_at(pack->series);
    float values[MR_PACK_READINGS];
    int64_t newest = frame->board_us / 1000 - measured->first_block;
    for (unsigned k = 0, count = mr_series_pack_get(pack, frame->data, values); k < count; k++) {
        int c = measured_find(measured, series->kind, pack->first + k);
        for (unsigned age = 0; c >= 0 && age < series->blocks; age++) {
            int64_t i = newest - (int64_t)age;
            if (i >= 0 && i < (int64_t)measured->samples)
                fill_sample(&measured->channel[c], (size_t)i, values[k], series->blocks,
                            (size_t)(newest + 1));
        }
    }
    return MR_OK;
}

static enum mr_status check_against_message(void *context, const struct store_frame *frame)
{
    struct measured *measured = context;
    const struct mr_series_pack *pack = find_pack(frame);
    if (!pack)
        return MR_OK;
    const struct mr_series *series = mr_series_at(pack->series);
    float values[MR_PACK_READINGS];
    int64_t newest = frame->board_us / 1000 - measured->first_block;
    for (unsigned k = 0, count = mr_series_pack_get(pack, frame->data, values); k < count; k++) {
        float can = values[k];
        int c = measured_find(measured, series->kind, pack->first + k);
        if (c < 0 || newest - series->blocks + 1 < 0 || newest >= (int64_t)measured->samples)
            continue;
        float sum = 0.0f;
        bool all = true;
        for (unsigned age = 0; age < series->blocks; age++) {
            size_t i = (size_t)newest - age;
            sum += measured->channel[c].raw[i];
            all = all && measured->channel[c].validity[i] != MEASURED_LOST;
        }
        if (!all)
            continue;
        float mean = sum / (float)series->blocks;
        double digits = fabs((double)(can - mean) * (double)series->per_unit);
        measured->check.compared++;
        if (isnan(can) != isnan(mean) || digits > 1.0)
            measured->check.different++;
        if (digits > measured->check.worst_digits)
            measured->check.worst_digits = digits;
    }
    return MR_OK;
}

/* `span`: of the blocks and of what CAN adds to them. */
static enum mr_status series_from_blocks(struct measured *measured,
                                         const struct measured_blocks *list,
                                         const struct measured_span *span, struct error *error)
{
    size_t from_box = 0;
    struct mr_watch watch = {0};
    enum mr_status status = measured_make_series(measured, span, error);
    for (size_t b = 0; b < list->count && status == MR_OK; b++) {
        const struct mr_block *block = &list->block[b];
        if (!watch.recording && (int64_t)block->index >= measured->landing.armed_block)
            begin_watch(&watch, measured, block->index);
        if (b > 0 && block->index - list->block[b - 1].index > WATCH_HOLE_BLOCKS)
            pass_hole(&watch);
        read_block(measured, &watch, block, (enum measured_source)list->source[b]);
        from_box += list->source[b] == MEASURED_BOX;
    }
    measured->source = 2 * from_box > list->count ? MEASURED_BOX : MEASURED_SERIAL;
    return status;
}

/* A board may be armed for hours before the gear comes: that is not held in memory. INT64_MIN: all
 * of it. */
static int64_t find_from(const struct measured *measured, const struct moments *moments)
{
    int64_t blocks = moments->groups ? 1000 * (moments->group[moments->groups - 1].to_s -
                                               moments->group[0].from_s)
                                     : 0;
    if (blocks <= 2 * MEASURED_BEFORE_BLOCKS || measured->landing.armed_block == STORE_NONE)
        return INT64_MIN;
    int64_t until = measured->gates ? (int64_t)floor(measured->gate[0].t_s * 1000.0)
                                    : 1000 * (moments->group[moments->groups - 1].to_s + 1);
    return until - MEASURED_BEFORE_BLOCKS;
}

/* Where both are, the messages are held against the block records first: then they fill what these
 * lack. */
static enum mr_status take_messages(struct store *store, struct measured *measured, bool check,
                                    bool fill, struct error *error)
{
    int64_t run = measured->landing.id;
    enum mr_status status = MR_OK;
    if (check)
        status = store_frames_each(store, run, LINK_CAN, check_against_message, measured, error);
    if (status == MR_OK && fill)
        status = store_frames_each(store, run, LINK_CAN, fill_from_message, measured, error);
    if (status == MR_OK && fill)
        status = take_stuck_from_events(store, measured, error);
    return status;
}

/* ---- which times are the landing's ---- */

static void add_row(void *context, int64_t index, int link)
{
    (void)link;
    moments_add(context, index);
}

static enum mr_status measured_judge(struct measured *measured, struct moments *moments,
                                     struct error *error)
{
    size_t kept = 0;
    for (size_t g = 0; g < measured->gates; g++)
        moments_add_edge(moments, measured->gate[g].t_s);
    if (moments_judge(moments) != MR_OK)
        return error_set(error, MR_FULL, "no memory: RUN %lld; close other programs",
                         (long long)measured->landing.id);
    for (size_t g = 0; g < measured->gates; g++) {
        if (moments_hold_edge(moments, measured->gate[g].t_s))
            measured->gate[kept++] = measured->gate[g];
        else
            measured_set_aside(&measured->aside, &measured->aside.edges,
                               (int64_t)fmax(-9e15, fmin(9e15, measured->gate[g].t_s * 1000.0)));
    }
    measured->gates = kept;
    return MR_OK;
}

static enum mr_status find_moments(struct store *store, struct measured *measured,
                                   bool recalibrated, struct moments *moments, struct error *error)
{
    int64_t run = measured->landing.id;
    enum mr_status status = store_block_links_each(store, run, add_row, moments, error);
    if (status == MR_OK && (moments->groups == 0 || !recalibrated))
        status = store_frames_each(store, run, LINK_CAN, add_moment, moments, error);
    return status == MR_OK ? measured_judge(measured, moments, error) : status;
}

/* ---- all of it ---- */

static enum mr_status series_from_board(struct store *store, struct measured *measured,
                                        struct measured_blocks *list, bool recalibrated,
                                        struct spans *spans, struct error *error)
{
    bool fill = list->count == 0 || !recalibrated;
    const struct measured_span *span = &spans->all;
    enum mr_status status = MR_OK;
    for (size_t b = 0; b < list->count; b++)
        measured_span_add(&spans->blocks, list->block[b].index, list->block[b].index);
    spans->all = spans->blocks;
    if (fill)
        status = store_frames_each(store, measured->landing.id, LINK_CAN, find_span, spans, error);
    if (status != MR_OK || !span->any)
        return status;
    status = measured_check_span(measured, span->first, span->last, error);
    if (status == MR_OK && list->count)
        status = series_from_blocks(measured, list, span, error);
    else if (status == MR_OK)
        status = measured_make_series(measured, span, error);
    if (status == MR_OK)
        status = take_messages(store, measured, list->count && !recalibrated, fill, error);
    if (status == MR_OK && !list->count)
        measured->source = MEASURED_CAN;
    return status;
}

#define STRIDE_MAX 1000
#define BLOCK_MOST (INT64_MAX / 2)

/* A row of a damaged campaign may begin anywhere. */
static bool row_on_board(const struct store_imported *row)
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
        n += row_on_board(&rows[k]) &&
             llabs(rows[k].first_block - rows[r].first_block) <= 1000 * MOMENTS_PAUSE_S;
    return n;
}

/* Rows that begin elsewhere than most do are set aside: left are the others, in front. How many. */
static size_t rows_together(struct measured *measured, struct store_imported *rows, size_t count)
{
    size_t most = 0, left = 0;
    for (size_t r = 0; r < count; r++)
        most = row_on_board(&rows[r]) && beside(rows, count, r) > most ? beside(rows, count, r)
                                                                       : most;
    for (size_t r = 0; r < count; r++) {
        bool together = row_on_board(&rows[r]) && beside(rows, count, r) == most;
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

static enum mr_status measured_load_import(struct store *store, struct measured *measured,
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

enum mr_status measured_load_series(struct store *store, struct measured *measured,
                                    struct error *error)
{
    struct moments moments = {0};
    struct measured_blocks list = {.moments = &moments, .aside = &measured->aside};
    struct spans spans = {.moments = &moments, .aside = &measured->aside};
    bool recalibrated = false;
    enum mr_status status = store_is_recalibrated(store, measured->landing.id, &recalibrated,
                                                  error);
    if (status == MR_OK)
        status = find_moments(store, measured, recalibrated, &moments, error);
    if (status == MR_OK) {
        list.from = spans.from = find_from(measured, &moments);
        status = measured_blocks_load(store, measured->landing.id, &list, error);
    }
    measured->skipped_blocks = list.skipped;
    if (status == MR_OK)
        status = series_from_board(store, measured, &list, recalibrated, &spans, error);
    if (status == MR_OK && !spans.all.any)
        status = measured_load_import(store, measured, error);
    if (status == MR_OK && measured->source != MEASURED_NOTHING) {
        blank_stuck(measured);
        status = measured_find_stretches(measured, error);
    }
    moments_free(&moments);
    measured_blocks_free(&list);
    return status;
}
