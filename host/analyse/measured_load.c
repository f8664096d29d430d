#include "host/analyse/measured_load.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/catalogue.h"
#include "common/watch.h"
#include "common/wire.h"
#include "host/base/xmalloc.h"
#include "host/board/config_text.h"
#include "host/link/link.h"
#include "host/store/store.h"
#include "host/store/store_journal.h"

#define BLOCKS_PER_S 1000

/* ---- gates ---- */

/* Collects the first edge of each known switch, in order of time. */
static void collect_gates(struct measured_landing *measured, const struct store_edge *edges,
                          size_t edge_count, const struct store_switch *places, size_t place_count)
{
    measured->edge_count = edge_count;
    for (size_t p = 0; p < place_count; p++) {
        /* ignore rows that only a damaged campaign can have */
        if (places[p].step_codes == 0 || places[p].position < 1 || places[p].position > 64)
            continue;
        measured->fitted_switches |= 1ull << (places[p].position - 1);
        measured->switch_ft[places[p].position - 1] = places[p].station_ft;
        measured->switch_count++;
    }
    for (size_t e = 0; e < edge_count; e++) {
        for (size_t p = 0; p < place_count; p++) {
            uint64_t bit = 1ull << ((places[p].position - 1) & 63);
            if (places[p].position < 1 || places[p].position > 64 ||
                places[p].position != edges[e].position || measured->switches_with_edges & bit ||
                isnan(edges[e].board_us) || measured->gate_count == MR_GATES_MAX)
                continue;
            measured->switches_with_edges |= bit;
            measured->gate[measured->gate_count++] = (struct mr_gate){edges[e].board_us / 1e6,
                                                                      places[p].station_ft};
        }
    }
}

/* ---- times that belong to the landing: block records, messages and edges form groups separated
 * by pauses of half a minute. A landing lasts 22 s from its first edge
 * (common/onboard/landing.h), so a group that is small compared with the largest one does not
 * belong to it: one wrong time would make the record hours long. Data outside all groups is
 * counted and excluded; the campaign keeps it ---- */

#define GROUP_PAUSE_S        30
/* A group of times with fewer than 1/GROUP_SIZE_RATIO_MAX of the entries of the largest group is
 * excluded. A group with edges and at least GROUP_MIN_ENTRIES entries is kept, because a link may
 * have been down around it. */
#define GROUP_SIZE_RATIO_MAX 100u
#define GROUP_MIN_ENTRIES    100u

struct time_groups {
    struct time_group {
        int64_t from_s, to_s; /* first and last second of the group */
        size_t count, edges;
    } * group;
    size_t group_count;
};

static void time_groups_add(struct time_groups *groups, int64_t second, size_t count, size_t edges)
{
    struct time_group *last = groups->group_count ? &groups->group[groups->group_count - 1] : NULL;
    if (!last || second < last->from_s || second > last->to_s + 1) {
        xlist_grow(&groups->group, groups->group_count, sizeof *groups->group);
        last = &groups->group[groups->group_count++];
        *last = (struct time_group){second, second, 0, 0};
    }
    last->to_s = second > last->to_s ? second : last->to_s;
    last->count += count;
    last->edges += edges;
}

static int64_t get_edge_second(double board_s)
{
    return (int64_t)floor(fmax(-9e15, fmin(9e15, board_s)));
}

static int compare_groups(const void *a, const void *b)
{
    int64_t x = ((const struct time_group *)a)->from_s, y = ((const struct time_group *)b)->from_s;
    return (x > y) - (x < y);
}

/* Removes the groups that do not belong to the landing; the order is kept. */
static void time_groups_select(struct time_groups *groups)
{
    size_t joined = 0, left = 0, most = 0;
    if (groups->group_count)
        qsort(groups->group, groups->group_count, sizeof *groups->group, compare_groups);
    for (size_t g = 0; g < groups->group_count; g++) {
        const struct time_group next = groups->group[g];
        struct time_group *last = joined ? &groups->group[joined - 1] : NULL;
        if (last && next.from_s - GROUP_PAUSE_S <= last->to_s) {
            last->to_s = next.to_s > last->to_s ? next.to_s : last->to_s;
            last->count += next.count;
            last->edges += next.edges;
        } else {
            groups->group[joined++] = next;
        }
        most = groups->group[joined - 1].count > most ? groups->group[joined - 1].count : most;
    }
    for (size_t g = 0; g < joined; g++) {
        const struct time_group group = groups->group[g];
        if (group.count && (group.count > most / GROUP_SIZE_RATIO_MAX || group.count == most ||
                            (group.edges && group.count >= GROUP_MIN_ENTRIES)))
            groups->group[left++] = group;
    }
    groups->group_count = left;
}

/* True if a group contains the time, or if there are no groups. */
static bool time_groups_contain(const struct time_groups *groups, int64_t second)
{
    for (size_t g = 0; g < groups->group_count; g++) {
        if (second >= groups->group[g].from_s && second <= groups->group[g].to_s)
            return true;
    }
    return groups->group_count == 0;
}

/* ---- block records and CAN messages ---- */

/* The data from which the samples of a landing are built. */
struct series_data {
    struct measured_landing *measured;
    struct time_groups groups;
    int64_t from_block; /* first block that is loaded */
    struct mr_block *block;
    uint8_t *source; /* enum measured_source, one per block */
    size_t block_count;
    struct message {
        const struct mr_series_pack *pack;
        int64_t newest; /* newest block in the message */
        uint8_t data[MR_MESSAGE_BYTES_MAX];
    } * message;
    size_t message_count;
    int64_t first_second,
        /* seconds of the first and the last data; last_second < first_second: no data */
        last_second;
};

static void count_excluded_record(struct measured_excluded *aside, size_t *count, int64_t block)
{
    if (aside->blocks + aside->messages + aside->edges == 0)
        aside->first_block = block;
    ++*count;
}

static void extend_time_span(struct series_data *record, int64_t first, int64_t last)
{
    bool any = record->last_second >= record->first_second;
    record->first_second = any && record->first_second < first ? record->first_second : first;
    record->last_second = any && record->last_second > last ? record->last_second : last;
}

static enum mr_status append_block(void *context, const uint8_t *bytes, size_t length, int link)
{
    struct series_data *record = context;
    struct measured_excluded *aside = &record->measured->excluded;
    struct mr_block block;
    enum mr_status status = mr_block_decode(&block, bytes, length);
    if (status != MR_OK)
        return status;
    if (!time_groups_contain(&record->groups, block.index / BLOCKS_PER_S)) {
        count_excluded_record(aside, &aside->blocks, block.index);
        return MR_OK;
    }
    if ((int64_t)block.index < record->from_block) {
        record->measured->skipped_blocks++;
        return MR_OK;
    }
    xlist_grow(&record->block, record->block_count, sizeof *record->block);
    xlist_grow(&record->source, record->block_count, sizeof *record->source);
    record->source[record->block_count] = link == STORE_LINK_BLACK_BOX ? MEASURED_BOX
                                                                       : MEASURED_SERIAL;
    record->block[record->block_count++] = block;
    extend_time_span(record, block.index, block.index);
    return MR_OK;
}

static void count_block(void *context, int64_t index)
{
    time_groups_add(context, index / BLOCKS_PER_S, 1, 0);
}

static const struct mr_series_pack *find_pack(const struct store_frame *frame)
{
    unsigned number = frame->id <= UINT16_MAX ? mr_series_pack_find((uint16_t)frame->id)
                                              : MR_SERIES_PACK_COUNT;
    bool whole = frame->length == MR_MESSAGE_BYTES_MAX && frame->board_us != STORE_NONE;
    return number < MR_SERIES_PACK_COUNT && whole ? mr_series_pack_at(number) : NULL;
}

static enum mr_status count_message(void *context, const struct store_frame *frame)
{
    if (find_pack(frame))
        time_groups_add(context, frame->board_us / 1000000, 1, 0);
    return MR_OK;
}

static enum mr_status append_message(void *context, const struct store_frame *frame)
{
    struct series_data *record = context;
    struct measured_excluded *aside = &record->measured->excluded;
    const struct mr_series_pack *pack = find_pack(frame);
    if (!pack)
        return MR_OK;
    int64_t newest = frame->board_us / 1000;
    if (!time_groups_contain(&record->groups, newest / BLOCKS_PER_S)) {
        count_excluded_record(aside, &aside->messages, newest);
        return MR_OK;
    }
    if (newest - mr_series_at(pack->series)->averaged_blocks + 1 < record->from_block)
        return MR_OK;
    xlist_grow(&record->message, record->message_count, sizeof *record->message);
    struct message *message = &record->message[record->message_count++];
    *message = (struct message){.pack = pack, .newest = newest};
    memcpy(message->data, frame->data, sizeof message->data);
    return MR_OK;
}

#define SAMPLES_MAX 3600000

static enum mr_status allocate_series(struct measured_landing *measured, int64_t first,
                                      int64_t last, struct error *error)
{
    if (last < first || last - first >= SAMPLES_MAX)
        return error_set(error, MR_MALFORMED,
                         "impossible block numbers: RUN %lld, blocks %lld to %lld; the database is "
                         "damaged, use a different copy of the campaign",
                         (long long)measured->landing.id, (long long)first, (long long)last);
    measured->first_block = first;
    measured->samples = (size_t)(last - first) + 1;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        struct measured_channel *channel = &measured->channel[c];
        channel->raw = xmalloc(measured->samples * sizeof *channel->raw);
        channel->validity = xmalloc(measured->samples);
        channel->source = xcalloc(measured->samples, 1);
        channel->stride = 1;
        memset(channel->validity, MEASURED_MISSING, measured->samples);
        for (size_t i = 0; i < measured->samples; i++)
            channel->raw[i] = MR_NAN;
    }
    return MR_OK;
}

static void begin_watch(struct mr_watch *watch, const struct measured_landing *measured,
                        uint32_t index)
{
    struct mr_channel_config config[MR_CHANNELS];
    for (unsigned c = 0; c < MR_CHANNELS; c++)
        config[c] = measured->channel[c].config;
    mr_watch_begin(watch, config, index);
}

/* After a gap of this length, the supervision of channels that were not stuck starts anew, because
 * a channel may have left its range and returned during the gap, which only the board could
 * observe. */
#define WATCH_GAP_BLOCKS 20
static void reset_after_gap(struct mr_watch *watch)
{
    for (unsigned c = 0; c < MR_WATCH_CHANNELS; c++) {
        if (!watch->channel[c].is_stuck)
            watch->channel[c].anchor_reading = MR_NAN;
    }
}

static void invalidate_stuck_samples(struct measured_channel *channel, size_t sample)
{
    channel->validity[sample] = MR_INVALID_STUCK;
    channel->raw[sample] = MR_NAN;
}

/* Checks the readings of a block as the board does. A stuck channel is invalid from the reading at
 * which it stopped moving, so this also invalidates earlier readings back to that one. */
static void decode_block(struct measured_landing *measured, struct mr_watch *watch,
                         const struct mr_block *block, enum measured_source source)
{
    size_t i = (size_t)((int64_t)block->index - measured->first_block);
    float ratio = mr_reference_ratio(&measured->channel[MR_REFERENCE].config, block);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        struct measured_channel *channel = &measured->channel[c];
        struct mr_reading reading = mr_channel_read(&channel->config, block, c, ratio);
        if (c < MR_WATCH_CHANNELS)
            mr_watch_check(watch, &channel->config, c, block->index, &reading);
        channel->raw[i] = reading.value;
        channel->validity[i] = reading.validity;
        channel->source[i] = (uint8_t)source;
        if (reading.validity != MR_INVALID_STUCK)
            continue;
        invalidate_stuck_samples(channel, i);
        for (size_t k = i; k-- > 0 &&
                           (int64_t)k + measured->first_block >= watch->channel[c].anchor_block &&
                           channel->validity[k] != MR_INVALID_STUCK;) {
            if (channel->validity[k] == MR_VALID)
                invalidate_stuck_samples(channel, k);
        }
    }
}

/* Invalidates CAN samples of a channel that the board reported stuck, from that report until the
 * next one about the channel. */
static enum mr_status apply_stuck_events(struct store *store, struct measured_landing *measured,
                                         struct error *error)
{
    struct store_fault *event = NULL;
    size_t count = 0;
    enum mr_status status = store_channel_events_get(store, measured->landing.id, &event, &count,
                                                     error);
    for (size_t e = 0; e < count && status == MR_OK; e++) {
        if (event[e].code != MR_INVALID_STUCK || event[e].detail < 0 ||
            event[e].detail >= (int64_t)MR_WATCH_CHANNELS)
            continue;
        int64_t until = measured->first_block + (int64_t)measured->samples;
        for (size_t later = count; later-- > e + 1;)
            until = event[later].detail == event[e].detail ? event[later].board_us / 1000 : until;
        for (int64_t block = event[e].board_us / 1000; block < until; block++) {
            int64_t i = block - measured->first_block;
            struct measured_channel *channel = &measured->channel[event[e].detail];
            if (i >= 0 && i < (int64_t)measured->samples && channel->source[i] == MEASURED_CAN)
                invalidate_stuck_samples(channel, (size_t)i);
        }
    }
    free(event);
    return status;
}

/* Fills one of the samples that a CAN message covers with its mean, unless a better source has
 * filled it. `end`: first sample after the message. */
static void fill_sample(struct measured_channel *channel, size_t i, float value, unsigned blocks,
                        size_t end)
{
    if (channel->source[i] == MEASURED_SERIAL || channel->source[i] == MEASURED_BOX)
        return;
    channel->source[i] = MEASURED_CAN;
    channel->stride = blocks;
    channel->phase = (blocks - end % blocks) % blocks;
    channel->raw[i] = value;
    channel->validity[i] = isnan(value) ? MEASURED_INVALID : MR_VALID;
}

static void fill_series_from_message(struct measured_landing *measured,
                                     const struct message *message)
{
    const struct mr_series *series = mr_series_at(message->pack->series);
    float values[MR_PACK_READINGS];
    int64_t newest = message->newest - measured->first_block;
    unsigned count = mr_series_pack_get(message->pack, message->data, values);
    for (unsigned k = 0; k < count; k++) {
        int c = measured_channel_index(measured, series->kind, message->pack->first_reading + k);
        for (unsigned age = 0; c >= 0 && age < series->averaged_blocks; age++) {
            int64_t i = newest - (int64_t)age;
            if (i >= 0 && i < (int64_t)measured->samples)
                fill_sample(&measured->channel[c], (size_t)i, values[k], series->averaged_blocks,
                            (size_t)(newest + 1));
        }
    }
}

static void decode_blocks(struct measured_landing *measured, const struct series_data *record)
{
    size_t from_box = 0;
    struct mr_watch watch = {0};
    for (size_t b = 0; b < record->block_count; b++) {
        const struct mr_block *block = &record->block[b];
        if (!watch.is_recording && (int64_t)block->index >= measured->landing.armed_block)
            begin_watch(&watch, measured, block->index);
        if (b > 0 && block->index - record->block[b - 1].index > WATCH_GAP_BLOCKS)
            reset_after_gap(&watch);
        decode_block(measured, &watch, block, (enum measured_source)record->source[b]);
        from_box += record->source[b] == MEASURED_BOX;
    }
    measured->source = 2 * from_box > record->block_count ? MEASURED_BOX : MEASURED_SERIAL;
}

/* Returns the first block to load. A board may be armed hours before the landing, and so many
 * blocks do not fit into memory. INT64_MIN: load all. */
static int64_t find_first_block(const struct measured_landing *measured,
                                const struct time_groups *groups)
{
    const struct time_group *last = groups->group_count ? &groups->group[groups->group_count - 1]
                                                        : NULL;
    if (!last || measured->landing.armed_block == STORE_NONE ||
        BLOCKS_PER_S * (last->to_s - groups->group[0].from_s) <= 2 * MEASURED_BEFORE_EDGE_BLOCKS)
        return INT64_MIN;
    int64_t until = measured->gate_count ? (int64_t)floor(measured->gate[0].t_s * 1000.0)
                                         : BLOCKS_PER_S * (last->to_s + 1);
    return until - MEASURED_BEFORE_EDGE_BLOCKS;
}

static void select_groups(struct measured_landing *measured, struct time_groups *groups)
{
    size_t kept = 0;
    for (size_t g = 0; g < measured->gate_count; g++)
        time_groups_add(groups, get_edge_second(measured->gate[g].t_s), 0, 1);
    time_groups_select(groups);
    for (size_t g = 0; g < measured->gate_count; g++) {
        if (time_groups_contain(groups, get_edge_second(measured->gate[g].t_s)))
            measured->gate[kept++] = measured->gate[g];
        else
            count_excluded_record(&measured->excluded, &measured->excluded.edges,
                                  get_edge_second(1000.0 * measured->gate[g].t_s));
    }
    measured->gate_count = kept;
}

static enum mr_status load_board_series(struct store *store, struct series_data *record,
                                        struct error *error)
{
    struct measured_landing *measured = record->measured;
    int64_t run = measured->landing.id;
    enum mr_status status = store_block_indexes_for_each(store, run, count_block, &record->groups,
                                                         error);
    bool messages = record->groups.group_count == 0 || !measured->recalibrated_channels;
    if (status == MR_OK && messages)
        status = store_frames_for_each(store, run, LINK_CAN, count_message, &record->groups, error);
    if (status != MR_OK)
        return status;
    select_groups(measured, &record->groups);
    record->from_block = find_first_block(measured, &record->groups);
    if (store_blocks_for_each(store, run, append_block, record, error) != MR_OK)
        return error_set(
            error, MR_MALFORMED,
            "damaged block record: RUN %lld of %s; use a different copy of the campaign",
            (long long)run, store_path(store));
    if (messages)
        status = store_frames_for_each(store, run, LINK_CAN, append_message, record, error);
    /* messages extend the record only before its first or after its last block record */
    int64_t first = record->first_second, last = record->last_second;
    for (size_t i = 0; i < record->message_count; i++) {
        const struct message *message = &record->message[i];
        int64_t oldest = message->newest - mr_series_at(message->pack->series)->averaged_blocks + 1;
        if (!record->block_count || message->newest < first || oldest > last)
            extend_time_span(record, oldest, message->newest);
    }
    if (status != MR_OK || record->last_second < record->first_second)
        return status;
    status = allocate_series(measured, record->first_second, record->last_second, error);
    if (status != MR_OK)
        return status;
    measured->source = MEASURED_CAN;
    if (record->block_count)
        decode_blocks(measured, record);
    for (size_t i = 0; i < record->message_count; i++)
        fill_series_from_message(measured, &record->message[i]);
    return messages ? apply_stuck_events(store, measured, error) : MR_OK;
}

#define STRIDE_MAX      1000
#define BLOCK_INDEX_MAX (INT64_MAX / 2)

/* Builds samples from the first to the last block of all imported rows. */
static enum mr_status load_imported_series(struct store *store, struct series_data *record,
                                           struct error *error)
{
    struct measured_landing *measured = record->measured;
    struct store_imported_channel *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_imported_channels_get(store, measured->landing.id, &rows, &count,
                                                        error);
    for (size_t r = 0; r < count; r++) {
        if (rows[r].index < 0 || rows[r].index >= (int64_t)MR_CHANNELS || rows[r].first_block < 0 ||
            rows[r].first_block >= BLOCK_INDEX_MAX)
            rows[r].count = 0; /* ignore such a row, which only a damaged campaign can have */
        else
            extend_time_span(record, rows[r].first_block,
                             rows[r].first_block + (int64_t)rows[r].count - 1);
    }
    if (status == MR_OK && count) {
        status = allocate_series(measured, record->first_second, record->last_second, error);
        measured->source = MEASURED_IMPORT;
    }
    for (size_t r = 0; r < count && status == MR_OK; r++) {
        const struct store_imported_channel *row = &rows[r];
        struct measured_channel *channel = &measured->channel[row->count ? row->index : 0];
        if (row->count)
            channel->stride = row->stride >= 1 && row->stride <= STRIDE_MAX ? (size_t)row->stride
                                                                            : 1;
        for (size_t i = 0; i < row->count; i++) {
            size_t at = (size_t)(row->first_block - measured->first_block) + i;
            channel->source[at] = MEASURED_IMPORT;
            channel->raw[at] = row->reading[i];
            if (!isnan(row->reading[i]))
                channel->validity[at] = MR_VALID;
        }
    }
    store_imported_channels_free(rows, count);
    return status;
}

/* Sets source, first_block, samples, raw samples and validities. The landing and the channel
 * configuration must be loaded. */
static enum mr_status load_series(struct store *store, struct measured_landing *measured,
                                  struct error *error)
{
    struct series_data record = {.measured = measured, .last_second = -1};
    enum mr_status status = load_board_series(store, &record, error);
    if (status == MR_OK && record.last_second < record.first_second)
        status = load_imported_series(store, &record, error);
    if (status == MR_OK && measured->source != MEASURED_NO_SOURCE)
        measured_find_source_stretches(measured);
    free(record.groups.group);
    free(record.block);
    free(record.source);
    free(record.message);
    return status;
}

/* ---- a landing ---- */

static enum mr_status load_gates(struct store *store, int64_t run,
                                 struct measured_landing *measured, struct error *error)
{
    struct store_edge *edges = NULL;
    struct store_switch *places = NULL;
    size_t edge_count, place_count;
    enum mr_status status = store_edges_get(store, run, &edges, &edge_count, error)
                              ?: store_switches_get(store, run, &places, &place_count, error);
    if (status == MR_OK)
        collect_gates(measured, edges, edge_count, places, place_count);
    for (size_t i = 0; status == MR_OK && i < edge_count; i++) {
        if (edges[i].count > 0 &&
            (measured->first_edge == 0 || edges[i].count < measured->first_edge))
            measured->first_edge = edges[i].count;
    }
    measured->is_start_missing = measured->first_edge > 1;
    free(edges);
    free(places);
    return status;
}

static enum mr_status count_missing_edges(struct store *store, int64_t run,
                                          struct measured_landing *measured, struct error *error)
{
    struct store_result result;
    bool found;
    enum mr_status status = store_result_get(store, run, &result, &found, error);
    measured->has_board_result = status == MR_OK && found && result.switches != STORE_NONE;
    if (measured->has_board_result && result.switches > (int64_t)measured->gate_count)
        measured->missing_edges = (size_t)result.switches - measured->gate_count;
    measured->is_start_missing |= measured->edge_count == 0 && measured->missing_edges > 0;
    return status;
}

static enum mr_status load_configuration(struct store *store, int64_t run,
                                         struct measured_landing *measured, struct error *error)
{
    struct mr_channel_config channels[MR_CHANNELS];
    size_t found;
    enum mr_status status = store_channels_get(store, run, channels, &found, error);
    for (unsigned c = 0; c < MR_CHANNELS; c++)
        measured->channel[c].config = channels[c];
    return status;
}

/* Finds channels without calibration date. The dates count as unknown if another version wrote the
 * configuration. */
static enum mr_status load_calibration_state(struct store *store, int64_t run,
                                             struct measured_landing *measured, struct error *error)
{
    struct mr_config *config = xmalloc(sizeof *config);
    char *text = NULL;
    struct error ignored = {0};
    int64_t crc = measured->landing.config_crc;
    enum mr_status status =
        store_recalibrated_channels_get(store, run, &measured->recalibrated_channels, error);
    if (status == MR_OK && crc != STORE_NONE)
        status = store_configuration_get(store, (uint32_t)crc, &text, error);
    measured->has_calibration_dates = text && config_text_read(text, "", config, &ignored) == MR_OK;
    if (measured->has_calibration_dates) {
        measured->site = config->site[0];
        measured->is_uncalibrated = (config_text_undated_channels(config) &
                                     ~measured->recalibrated_channels) != 0;
    }
    free(text);
    free(config);
    return status;
}

static enum mr_status load_gates_and_calibration(struct store *store, int64_t run,
                                                 struct measured_landing *measured,
                                                 struct error *error)
{
    memset(measured, 0, sizeof *measured);
    return store_landing_get(store, run, &measured->landing, error) ?:
           load_calibration_state(store, run, measured, error) ?:
           load_gates(store, run, measured, error) ?:
           count_missing_edges(store, run, measured, error);
}

static enum mr_status load_configuration_and_series(struct store *store, int64_t run,
                                                    struct measured_landing *measured,
                                                    struct error *error)
{
    enum mr_status status = load_configuration(store, run, measured, error)
                              ?: load_series(store, measured, error);
    if (status != MR_OK)
        return status;
    measured_fit_gear_motion(measured);
    measured_compute_results(measured);
    return MR_OK;
}

enum mr_status measured_load(struct store *store, int64_t run, struct measured_landing *measured,
                             struct error *error)
{
    return load_gates_and_calibration(store, run, measured, error)
             ?: load_configuration_and_series(store, run, measured, error);
}

/* an edge counts as covered if there is a block record within this many blocks (one second) */
#define NEAR_EDGE_BLOCKS 1000

/* Fits the motion of the gear without loading samples. Sets `*enough` if this is sufficient: the
 * board received all edges, reported the end of the landing, and has block records near each edge
 * and after the stop. */
static enum mr_status fit_without_series(struct store *store, struct measured_landing *measured,
                                         bool *enough, struct error *error)
{
    const struct store_landing *landing = &measured->landing;
    int64_t first = -1, near = 0;
    *enough = measured->has_board_result && measured->missing_edges == 0 &&
              measured->gate_count > 0 && !measured->is_start_missing &&
              (landing->state == MR_LANDING_DONE || landing->state == MR_LANDING_IDLE);
    enum mr_status status = *enough ? store_first_block_get(store, landing->id, &first, error)
                                    : MR_OK;
    for (size_t g = 0; g < measured->gate_count && *enough && status == MR_OK; g++) {
        int64_t block = (int64_t)fmax(-9e15, fmin(9e15, measured->gate[g].t_s * 1e3));
        status = store_find_block_within(store, landing->id, block, block + NEAR_EDGE_BLOCKS, &near,
                                         error);
        *enough = near >= 0;
    }
    if (!*enough || status != MR_OK)
        return status;
    measured->source = MEASURED_SERIAL;
    measured->first_block = first;
    /* no end of the record, so that the stop is computed without regard to it */
    measured->samples = SIZE_MAX / 4;
    measured_fit_gear_motion(measured);
    *enough = measured->fit_status == MR_OK;
    int64_t stop = (int64_t)(measured->summary.stop_t_s.value * 1e3) + measured->t0_us / 1000 + 1;
    if (*enough)
        status = store_find_block_within(store, landing->id, stop, stop + NEAR_EDGE_BLOCKS, &near,
                                         error);
    *enough &= near >= 0;
    measured->samples = (size_t)(near - first) + 1;
    return status;
}

enum mr_status measured_load_gear(struct store *store, int64_t run,
                                  struct measured_landing *measured, struct error *error)
{
    bool enough = false;
    enum mr_status status = load_gates_and_calibration(store, run, measured, error)
                              ?: fit_without_series(store, measured, &enough, error);
    if (status != MR_OK || enough)
        return status;
    measured_free(measured);
    return measured_load(store, run, measured, error);
}
