#include "host/exchange/import.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/block.h"
#include "common/channels.h"
#include "host/analyse/measured_load.h"
#include "host/base/statistics.h"
#include "host/base/xmalloc.h"
#include "host/link/link.h"

#define BLOCK_US           1000.0
/* middle of the eight scans of a block, see host/analyse/measured_load.h */
#define BLOCK_CENTER_US    437.5
#define LANDING_BLOCKS_MAX 3600000
/* number of the last block: the board's block index has 32 bits */
#define BLOCK_INDEX_MAX    4294967295.0
/* an interval longer than the usual one by this factor means missing data */
#define GAP_STEPS_MIN      1.5
#define SWITCH_SPACING_FT  5.0 /* default spacing of the switches, that of the rig */
#define SWITCH_FIRST_FT    (-2.5)
#define RIG_SWITCH_COUNT   24u
#define SWITCHES_MAX       64u
#define SWITCH_ERROR_FT    0.001

struct landing_import {
    struct store *store;
    struct mapping *mapping;
    const struct import_request *request;
    struct measured_landing template; /* landing given with --like */
    struct store_edge *edge;          /* edges of the template landing */
    size_t edge_count;
    double base_us; /* board time at which the file's time is 0 */
    int64_t first_block;
    size_t block_count;
    int64_t run, session;
    struct found_edge {
        double board_us;
        unsigned position;
    } found_edges[SWITCHES_MAX]; /* edges found in the file */
    unsigned found_edge_count;
};

/* ---- time ---- */

/* Returns the median sample interval; NaN: fewer than two samples. */
static double compute_median_step_s(const struct series *series)
{
    if (series->count < 2)
        return (double)NAN;
    double *step = xmalloc((series->count - 1) * sizeof *step);
    for (size_t i = 0; i + 1 < series->count; i++)
        step[i] = series->time_s[i + 1] - series->time_s[i];
    sort_numbers(step, series->count - 1);
    double median = step[(series->count - 1) / 2];
    free(step);
    return median;
}

/* Returns the time of the first threshold crossing, interpolated between two samples; NaN: none. */
static double find_edge_time_s(const struct mapping_channel *channel)
{
    const struct series *s = &channel->series;
    for (size_t i = 1; i < s->count; i++) {
        double from = s->value[i - 1] - channel->threshold, to = s->value[i] - channel->threshold;
        bool passes = channel->is_falling_edge ? from >= 0.0 && to < 0.0 : from <= 0.0 && to > 0.0;
        if (passes)
            return s->time_s[i - 1] + (s->time_s[i] - s->time_s[i - 1]) * from / (from - to);
    }
    return (double)NAN;
}

static const struct mapping_channel *find_channel_with_role(const struct mapping *m,
                                                            enum mapping_role role)
{
    for (size_t c = 0; c < m->channel_count; c++) {
        if (m->channel[c].role == role)
            return &m->channel[c];
    }
    return NULL;
}

static bool has_readings(const struct mapping_channel *channel)
{
    return channel->role == MAPPING_DISPLACEMENT || channel->role == MAPPING_TENSION;
}

static enum mr_status compute_time_base(struct landing_import *w,
                                        const struct mapping_channel *channel, struct error *error)
{
    double edge_s = find_edge_time_s(channel);
    if (!w->request->template_run)
        return error_set(
            error, MR_USAGE,
            "the mapping uses align without the switches of a landing: %s; give --like RUN",
            w->request->path);
    if (isnan(edge_s))
        return error_set(error, MR_MALFORMED,
                         "cannot align: '%s' never crosses %g in %s; correct align in the mapping",
                         channel->column_name, channel->threshold, w->request->path);
    for (size_t e = 0; e < w->edge_count; e++) {
        if (w->edge[e].position != channel->number || isnan(w->edge[e].board_us))
            continue;
        w->base_us = w->edge[e].board_us - 1e6 * edge_s;
        return MR_OK;
    }
    return error_set(error, MR_USAGE,
                     "RUN %lld has no edge of switch %u: %s; align with a different switch",
                     (long long)w->request->template_run, channel->number, w->request->path);
}

static enum mr_status compute_blocks(struct landing_import *w, struct error *error)
{
    const struct mapping *m = w->mapping;
    const struct mapping_channel *by = find_channel_with_role(m, MAPPING_ALIGN);
    double first_s = (double)INFINITY, last_s = -(double)INFINITY;
    for (size_t c = 0; c < m->channel_count; c++) {
        const struct series *s = &m->channel[c].series;
        if (!has_readings(&m->channel[c]) || s->count == 0)
            continue;
        first_s = fmin(first_s, s->time_s[0]);
        last_s = fmax(last_s, s->time_s[s->count - 1]);
    }
    if (!(first_s <= last_s))
        return error_set(error, MR_MALFORMED,
                         "no reading of d1 to d8 or t1 to t14: %s; correct channels in the mapping",
                         w->request->path);
    if ((last_s - first_s) * 1e6 / BLOCK_US >= LANDING_BLOCKS_MAX)
        return error_set(error, MR_MALFORMED,
                         "the record of %.0f s is longer than an hour: %s; check the unit of time "
                         "in the mapping",
                         last_s - first_s, w->request->path);
    w->base_us = w->request->template_run ? (double)w->template.t0_us
                                          : BLOCK_CENTER_US - 1e6 * first_s;
    if (by) {
        enum mr_status status = compute_time_base(w, by, error);
        if (status != MR_OK)
            return status;
    }
    w->base_us += 1e6 * m->time_shift_s;
    double from = floor((w->base_us + 1e6 * first_s) / BLOCK_US),
           to = floor((w->base_us + 1e6 * last_s) / BLOCK_US);
    if (!(to <= BLOCK_INDEX_MAX))
        return error_set(error, MR_USAGE,
                         "the record ends at board time %.3g s: %s; board time is at most %.0f s, "
                         "so correct unit, shift_s or align in the mapping",
                         1e-3 * to, w->request->path, 1e-3 * BLOCK_INDEX_MAX);
    if (to < 0.0)
        return error_set(error, MR_USAGE,
                         "the record ends %.3f s before the start of board time: %s; correct "
                         "shift_s or align in the mapping",
                         -1e-6 * (w->base_us + 1e6 * last_s), w->request->path);
    if (from < 0.0) {
        cli_note(w->request->cli, "readings before the start of board time are left out (%.3f s)",
                 -1e-3 * from);
        from = 0.0;
    }
    w->first_block = (int64_t)from;
    w->block_count = (size_t)(to - from) + 1;
    return MR_OK;
}

/* ---- samples to blocks ---- */

/* Sets each block to the mean of its samples. */
static void resample_by_mean(const struct series *s, double base_us, int64_t first, size_t blocks,
                             float *reading)
{
    for (size_t i = 0, k = 0; i < blocks; i++) {
        double end_us = ((double)first + (double)i + 1.0) * BLOCK_US, sum = 0.0;
        size_t count = 0;
        for (; k < s->count && base_us + 1e6 * s->time_s[k] < end_us; k++) {
            if (base_us + 1e6 * s->time_s[k] < end_us - BLOCK_US)
                continue;
            sum += s->value[k];
            count++;
        }
        reading[i] = count ? (float)(sum / (double)count) : (float)NAN;
    }
}

void import_resample(const struct series *s, double base_us, double sample_period_us, double gap_us,
                     int64_t first, size_t blocks, float *reading)
{
    /* smaller differences of times count as 0, because times in files have six decimals */
    static const double same_us = 0.6;
    if (sample_period_us < 0.75 * BLOCK_US) {
        resample_by_mean(s, base_us, first, blocks, reading);
        return;
    }
    for (size_t i = 0, k = 0; i < blocks; i++) {
        double at_us = ((double)first + (double)i) * BLOCK_US + BLOCK_CENTER_US;
        while (k + 1 < s->count && base_us + 1e6 * s->time_s[k + 1] <= at_us + same_us)
            k++;
        double before_us = base_us + 1e6 * s->time_s[k],
               after_us = k + 1 < s->count ? base_us + 1e6 * s->time_s[k + 1] : before_us;
        reading[i] = (float)NAN;
        if (fabs(at_us - before_us) <= same_us)
            reading[i] = (float)s->value[k];
        else if (before_us < at_us && at_us < after_us && after_us - before_us <= gap_us)
            reading[i] = (float)(s->value[k] + (s->value[k + 1] - s->value[k]) *
                                                   (at_us - before_us) / (after_us - before_us));
    }
}

/* ---- rows of the campaign ---- */

static enum mr_status put_gap(struct landing_import *w, const struct mapping_channel *channel,
                              const float *reading, struct error *error)
{
    struct store_gap gap = {
        .link = LINK_KINDS, .message = "readings", .cause = "file", .from_block = STORE_NONE};
    snprintf(gap.channels, sizeof gap.channels, "%c%u",
             channel->role == MAPPING_TENSION ? 't' : 'd', channel->number);
    for (size_t i = 0; i < w->block_count; i++) {
        if (!isnan(reading[i]))
            continue;
        gap.count++;
        gap.to_block = w->first_block + (int64_t)i;
        gap.from_block = gap.from_block == STORE_NONE ? gap.to_block : gap.from_block;
    }
    return gap.count ? store_gap_put(w->store, w->session, w->run, &gap, error) : MR_OK;
}

static int64_t find_channel_index(const struct landing_import *w,
                                  const struct mapping_channel *channel)
{
    enum mr_channel_kind kind = channel->role == MAPPING_TENSION ? MR_KIND_TENSION
                                                                 : MR_KIND_DISPLACEMENT;
    int there = w->request->template_run
                  ? measured_channel_index(&w->template, kind, channel->number)
                  : -1;
    return there >= 0 ? there
                      : (channel->role == MAPPING_TENSION ? (int64_t)MR_TRANSDUCERS : 0) +
                            (int64_t)channel->number - 1;
}

/* Stores kind and station of a channel. The mapping's error is stored as linearity error, because
 * neither baseline nor reference reduces that error. */
static enum mr_status put_configuration(struct landing_import *w,
                                        const struct mapping_channel *channel, int64_t index,
                                        struct error *error)
{
    struct mr_channel_config config = {.band = 1, .station_ft = (float)NAN};
    const struct mr_channel_config *like = w->request->template_run
                                             ? &w->template.channel[index].config
                                             : NULL;
    if (like && like->kind)
        config = (struct mr_channel_config){.band = like->band, .station_ft = like->station_ft};
    config.kind = channel->role == MAPPING_TENSION ? MR_KIND_TENSION : MR_KIND_DISPLACEMENT;
    config.number = (uint8_t)channel->number;
    if (!isnan(channel->station_ft))
        config.station_ft = (float)channel->station_ft;
    if (!isnan(channel->standard_error))
        config.linearity_error = (float)channel->standard_error;
    enum mr_status status = store_channel_put(w->store, w->run, index, &config, error);
    for (unsigned item = 0; item < MR_CALIBRATION_FIRST_POINT_ITEM && status == MR_OK; item++)
        status = store_calibration_put(
            w->store, w->run,
            &(struct store_calibration){index, item, (double)mr_channel_get_item(&config, item)},
            error);
    return status;
}

static enum mr_status put_channel(struct landing_import *w, const struct mapping_channel *channel,
                                  float *reading, struct error *error)
{
    double sample_period_us = 1e6 * compute_median_step_s(&channel->series);
    double gap_us = isnan(w->mapping->gap_min_s) ? GAP_STEPS_MIN * sample_period_us
                                                 : 1e6 * w->mapping->gap_min_s;
    int64_t index = find_channel_index(w, channel);
    for (size_t i = 0; i < w->block_count; i++)
        reading[i] = (float)NAN;
    if (channel->series.count)
        import_resample(&channel->series, w->base_us, sample_period_us, gap_us, w->first_block,
                        w->block_count, reading);
    int64_t stride = sample_period_us > 1.5 * BLOCK_US && sample_period_us < 1e6
                       ? llround(sample_period_us / BLOCK_US)
                       : 1;
    struct store_imported_channel row = {.index = index,
                                         .first_block = w->first_block,
                                         .stride = stride,
                                         .count = w->block_count,
                                         .reading = reading};
    return put_configuration(w, channel, index, error) ?:
           store_imported_channel_put(w->store, w->run, &row, error) ?:
           put_gap(w, channel, reading, error);
}

static enum mr_status put_channels(struct landing_import *w, struct error *error)
{
    unsigned unknown = 0;
    for (size_t c = 0; c < w->mapping->channel_count; c++) {
        const struct mapping_channel *channel = &w->mapping->channel[c];
        if (has_readings(channel) && channel->series.count == 0)
            cli_note(w->request->cli, "no reading of %c%u in %s",
                     channel->role == MAPPING_TENSION ? 't' : 'd', channel->number,
                     w->request->path);
    }
    float *reading = xmalloc(w->block_count * sizeof *reading);
    enum mr_status status = MR_OK;
    for (size_t c = 0; c < w->mapping->channel_count && status == MR_OK; c++) {
        if (has_readings(&w->mapping->channel[c]) && w->mapping->channel[c].series.count)
            status = put_channel(w, &w->mapping->channel[c], reading, error);
        unknown += has_readings(&w->mapping->channel[c]) &&
                   isnan(w->mapping->channel[c].standard_error);
    }
    if (unknown)
        cli_note(w->request->cli,
                 "the mapping states no error for %u channels, so their standard errors include "
                 "only noise; add error to the mapping",
                 unknown);
    free(reading);
    return status;
}

/* Stores a switch and, if known, the time it opened. */
static enum mr_status put_switch(struct landing_import *w, unsigned position, double station_ft,
                                 double edge_s, struct error *error)
{
    struct store_switch place = {position, 1, station_ft};
    if (isnan(station_ft))
        place.station_ft = SWITCH_FIRST_FT + SWITCH_SPACING_FT * (position - 1);
    double edge_us = w->base_us + 1e6 * edge_s;
    if (!isnan(edge_s) && !(edge_us >= 0.0 && edge_us < BLOCK_INDEX_MAX * BLOCK_US))
        cli_note(w->request->cli,
                 "the edge of switch %u is left out, because its time is outside board time",
                 position);
    else if (!isnan(edge_s) && w->found_edge_count < SWITCHES_MAX)
        w->found_edges[w->found_edge_count++] = (struct found_edge){edge_us, position};
    return store_switch_put(w->store, w->run, &place, error);
}

static int compare_times(const void *a, const void *b)
{
    double x = ((const struct found_edge *)a)->board_us,
           y = ((const struct found_edge *)b)->board_us;
    return (x > y) - (x < y);
}

static enum mr_status put_edges(struct landing_import *w, struct error *error)
{
    enum mr_status status = MR_OK;
    qsort(w->found_edges, w->found_edge_count, sizeof w->found_edges[0], compare_times);
    for (unsigned i = 0; i < w->found_edge_count && status == MR_OK; i++) {
        const struct found_edge *found = &w->found_edges[i];
        struct store_edge edge = {.count = i + 1,
                                  .position = found->position,
                                  .step_codes = (double)NAN,
                                  .board_us = found->board_us,
                                  .tick = (int64_t)llround(found->board_us * MR_TICKS_PER_US) &
                                          0xffffffff};
        status = store_edge_put(w->store, w->run, &edge, error);
    }
    return status;
}

/* Computes the times of switch edges from the gear's position and the stations of the rig's
 * switches. */
static enum mr_status make_gear_edges(struct landing_import *w, struct mapping_channel gear,
                                      struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned p = 1; p <= RIG_SWITCH_COUNT && status == MR_OK; p++) {
        gear.threshold = SWITCH_FIRST_FT + SWITCH_SPACING_FT * (p - 1);
        status = put_switch(w, p, (double)NAN, find_edge_time_s(&gear), error);
    }
    return status ?: put_edges(w, error);
}

static enum mr_status make_switch_edges(struct landing_import *w, struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t c = 0; c < w->mapping->channel_count && status == MR_OK; c++) {
        const struct mapping_channel *channel = &w->mapping->channel[c];
        if (channel->role == MAPPING_SWITCH)
            status = put_switch(w, channel->number, channel->station_ft, find_edge_time_s(channel),
                                error);
    }
    return status ?: put_edges(w, error);
}

static enum mr_status copy_template(struct landing_import *w, struct error *error)
{
    struct store_switch *place = NULL;
    struct store_segment *segment = NULL;
    size_t places = 0, segments = 0;
    enum mr_status status =
        store_switches_get(w->store, w->request->template_run, &place, &places, error)
            ?: store_segments_get(w->store, w->request->template_run, &segment, &segments, error);
    for (size_t i = 0; i < places && status == MR_OK; i++)
        status = store_switch_put(w->store, w->run, &place[i], error);
    for (size_t i = 0; i < segments && status == MR_OK; i++)
        status = store_segment_put(w->store, w->run, &segment[i], error);
    for (size_t i = 0; i < w->edge_count && status == MR_OK; i++)
        status = store_edge_put(w->store, w->run, &w->edge[i], error);
    free(place);
    free(segment);
    return status;
}

static enum mr_status put_gear(struct landing_import *w, struct error *error)
{
    const struct mapping_channel *gear = find_channel_with_role(w->mapping, MAPPING_GEAR);
    if (w->request->template_run)
        return copy_template(w, error);
    if (find_channel_with_role(w->mapping, MAPPING_SWITCH))
        return make_switch_edges(w, error);
    return gear ? make_gear_edges(w, *gear, error) : MR_OK;
}

static enum mr_status put_landing(struct landing_import *w, struct error *error)
{
    const struct mapping *m = w->mapping;
    char spec[500];
    snprintf(spec, sizeof spec, "import:%s", w->request->path);
    struct store_session session = {.started_us = (int64_t)link_now_us()};
    enum mr_status status = store_session_add(w->store, &session, error);
    struct store_landing landing = {
        .session = session.id,
        .armed_block = w->first_block,
        .armed_us = session.started_us,
        .state = MR_LANDING_DONE,
        .image_crc = STORE_NONE,
        .config_crc = STORE_NONE,
        .clock_source = STORE_NONE,
        .touchdown_ft = m->touchdown_ft,
        .switch_error_ft = isnan(m->switch_error_ft) ? SWITCH_ERROR_FT : m->switch_error_ft};
    if (w->request->template_run) {
        landing.board_landing = w->template.landing.board_landing;
        landing.touchdown_ft = w->template.landing.touchdown_ft;
        landing.switch_error_ft = w->template.landing.switch_error_ft;
        landing.clock_source = w->template.landing.clock_source;
    }
    if (status == MR_OK)
        status = store_landing_add(w->store, &landing, error);
    w->session = session.id;
    w->run = landing.id;
    return status;
}

enum mr_status import_landing(struct store *store, struct mapping *mapping,
                              const struct import_request *request, struct import_result *result,
                              struct error *error)
{
    struct landing_import w = {.store = store, .mapping = mapping, .request = request};
    if ((!request->template_run ||
         (measured_load(store, request->template_run, &w.template, error) == MR_OK &&
          store_edges_get(store, request->template_run, &w.edge, &w.edge_count, error) == MR_OK)) &&
        compute_blocks(&w, error) == MR_OK && put_landing(&w, error) == MR_OK &&
        put_channels(&w, error) == MR_OK && put_gear(&w, error) == MR_OK &&
        store_session_end(store, w.session, (int64_t)link_now_us(), "end", error) == MR_OK) {
        result->session = w.session;
        result->runs[result->run_count++] = w.run;
    }
    free(w.edge);
    if (request->template_run)
        measured_free(&w.template);
    return error->status;
}
