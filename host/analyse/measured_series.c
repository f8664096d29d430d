#include "host/analyse/measured_series.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/series.h"
#include "common/watch.h"
#include "common/wire.h"
#include "host/analyse/measured_blocks.h"
#include "host/analyse/measured_import.h"
#include "host/analyse/measured_source.h"
#include "host/link/link.h"
#include "host/store/store_recalibrate.h"

void measured_span_add(struct measured_span *span, int64_t first, int64_t last)
{
    span->first = span->any && span->first < first ? span->first : first;
    span->last = span->any && span->last > last ? span->last : last;
    span->any = true;
}

enum mr_status measured_make_series(struct measured *measured, const struct measured_span *span,
                                    struct error *error)
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

enum mr_status measured_check_span(const struct measured *measured, int64_t first, int64_t last,
                                   struct error *error)
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

enum mr_status measured_judge(struct measured *measured, struct moments *moments,
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
