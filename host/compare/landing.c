#include "host/compare/landing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/link/link.h"

static size_t stations(const struct measured *measured, const struct measured_channel **channels,
                       double *station_ft)
{
    size_t count = 0;
    for (unsigned c = 0; c < MR_TRANSDUCERS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_DISPLACEMENT || !channel->raw)
            continue;
        channels[count] = channel;
        station_ft[count++] = (double)channel->config.station_ft;
    }
    return count;
}

/* A simulated series at a simulated time; at rest outside it. */
static double value_at(const struct compare_simulated *s, const double *values, size_t column,
                       double t_s)
{
    double k = fmin(fmax(t_s / s->dt_s, 0.0), (double)(s->rows - 1));
    size_t i = (size_t)k;
    double from = values[i * s->stations + column];
    if (i + 1 >= s->rows)
        return from;
    return from + (k - (double)i) * (values[(i + 1) * s->stations + column] - from);
}

/* The simulation on the measured time, sample by sample. */
static enum mr_status take_row(const struct compare_simulated *s,
                               const struct compare_alignment *alignment, size_t column,
                               const struct measured_channel *channel, size_t length,
                               struct store_simulation *row, struct error *error)
{
    *row = (struct store_simulation){.number = channel->config.number,
                                     .station_ft = (double)channel->config.station_ft,
                                     .rms_in = (double)NAN,
                                     .dt_s = s->dt_s};
    row->series_in = malloc(length * sizeof *row->series_in);
    row->spread_in = s->seeds > 1 ? malloc(length * sizeof *row->spread_in) : NULL;
    if (!row->series_in || (s->seeds > 1 && !row->spread_in))
        return error_set(error, MR_FULL, "no memory: series of transducer %u; close other programs",
                         channel->config.number);
    row->length = length;
    for (size_t k = 0; k < length; k++) {
        double t_s = compare_simulated_time(alignment, (double)k * s->dt_s);
        row->series_in[k] = (float)value_at(s, s->mean_in, column, t_s);
        if (row->spread_in)
            row->spread_in[k] = (float)value_at(s, s->spread_in, column, t_s);
    }
    return MR_OK;
}

static enum mr_status take_head(const struct compare_model *model,
                                const struct compare_simulated *s,
                                const struct compare_alignment *alignment, double end_s,
                                struct store_simulation_head *head, struct error *error)
{
    *head = (struct store_simulation_head){
        .run_ms = s->run_ms,
        .error_in = s->error_in,
        .seeds = (int64_t)s->seeds,
        .edges = (int64_t)alignment->edges,
        .offset_s = alignment->offset_s,
        .scatter_s = alignment->scatter_s,
        .segments_dt_s = COMPARE_SEGMENTS_S,
        .segment_rows = (size_t)floor(end_s / COMPARE_SEGMENTS_S) + 1,
    };
    snprintf(head->file, sizeof head->file, "%s", model->name);
    const size_t row_bytes = MR_SEGMENTS * sizeof *head->segments_in;
    head->segments_in = malloc(head->segment_rows * row_bytes);
    if (!head->segments_in)
        return error_set(error, MR_FULL, "no memory: %zu rows of segments; close other programs",
                         head->segment_rows);
    for (size_t i = 0; i < head->segment_rows; i++) {
        double k = compare_simulated_time(alignment, (double)i * COMPARE_SEGMENTS_S) /
                       COMPARE_SEGMENTS_S +
                   0.5;
        size_t from = (size_t)fmin(fmax(k, 0.0), (double)(s->segment_rows - 1));
        memcpy(head->segments_in + i * MR_SEGMENTS, s->remaining_in + from * MR_SEGMENTS,
               row_bytes);
    }
    return MR_OK;
}

static enum mr_status simulate(struct compare_model *model, size_t index,
                               const struct zones_closure *survey, struct compare_landing *landing,
                               char **scene_json, struct error *error)
{
    const struct measured *measured = &landing->measured;
    const struct measured_channel *channels[MR_TRANSDUCERS];
    double station_ft[MR_TRANSDUCERS];
    struct compare_simulated simulated;
    struct compare_alignment alignment;
    size_t count = stations(measured, channels, station_ft);
    if (count == 0)
        return error_set(error, MR_TOO_FEW, "no displacements: RUN %lld; nothing to compare with",
                         (long long)measured->landing.id);
    compare_simulate(model, index, measured, survey, station_ft, count, &simulated, error);
    if (error->status == MR_OK)
        compare_align(measured, &simulated.scene, &alignment, error);
    /* As far as both go. */
    double end_s = measured_time_s(measured, measured->samples - 1);
    if (error->status == MR_OK)
        end_s = fmin(end_s, (double)(simulated.rows - 1) * simulated.dt_s -
                                alignment.simulated_s[alignment.edges - 1] +
                                alignment.measured_s[alignment.edges - 1]);
    if (error->status == MR_OK && !(end_s > 0.0))
        error_set(error, MR_TOO_FEW,
                  "nothing to compare: RUN %lld and the simulation have no time in common",
                  (long long)measured->landing.id);
    size_t length = error->status == MR_OK ? (size_t)floor(end_s / simulated.dt_s) + 1 : 0;
    for (size_t k = 0; k < count && error->status == MR_OK; k++)
        take_row(&simulated, &alignment, k, channels[k], length, &landing->row[landing->rows++],
                 error);
    if (error->status == MR_OK &&
        take_head(model, &simulated, &alignment, end_s, &landing->head, error) == MR_OK) {
        memcpy(landing->moved_in, simulated.moved_in, sizeof landing->moved_in);
        memcpy(landing->moved_spread_in, simulated.moved_spread_in,
               sizeof landing->moved_spread_in);
        *scene_json = compare_describe(model, &simulated);
        if (!*scene_json)
            error_set(error, MR_FULL, "no memory: scene of RUN %lld; close other programs",
                      (long long)measured->landing.id);
    }
    compare_simulated_free(&simulated);
    return error->status;
}

/* What queries of the campaign want, without the series. */
static void fill_rows(struct compare_landing *landing)
{
    for (size_t i = 0; i < landing->rows; i++) {
        struct store_simulation *row = &landing->row[i];
        for (size_t c = 0; c < landing->figures.channels; c++) {
            const struct compare_channel *channel = &landing->figures.channel[c];
            if (channel->number != row->number)
                continue;
            row->peak_measured_in = channel->f.peak_measured.value;
            row->peak_measured_error_in = channel->f.peak_measured.error;
            row->peak_simulated_in = channel->f.peak_simulated.value;
            row->peak_simulated_error_in = channel->f.peak_simulated.error;
            row->rms_in = channel->f.rms;
            row->end_measured_in = channel->end_measured.value;
            row->end_simulated_in = channel->end_simulated.value;
        }
    }
}

static enum mr_status find_figures(struct store *store, struct compare_landing *landing,
                                   const struct zones_closure *survey, struct error *error)
{
    struct store_zone *zones = NULL;
    struct store_prediction *predictions = NULL;
    struct compare_said said = {0};
    int64_t run = landing->measured.landing.id;
    if (store_zones(store, run, &zones, &said.zones, error) == MR_OK &&
        store_predictions(store, run, &predictions, &said.predictions, error) == MR_OK) {
        said.zone = zones;
        said.prediction = predictions;
        compare_figures(&landing->measured, survey, &said, &landing->head, landing->row,
                        landing->rows, &landing->figures, error);
    }
    free(zones);
    free(predictions);
    return error->status;
}

static enum mr_status keep(struct store *store, const struct compare_landing *landing,
                           const char *scene_json, struct error *error)
{
    enum mr_status status = store_begin(store, error);
    if (status == MR_OK)
        status = store_simulation_put(store, landing->measured.landing.id, scene_json,
                                      (int64_t)link_now_us(), &landing->head, landing->row,
                                      landing->rows, error);
    return status == MR_OK ? store_commit(store, error) : status;
}

enum mr_status compare_landing(struct store *store, int64_t run, struct compare_model *model,
                               size_t index, struct compare_landing *landing, struct error *error)
{
    struct zones_closure survey;
    char *scene_json = NULL;
    memset(landing, 0, sizeof *landing);
    if (measured_load(store, run, &landing->measured, error) == MR_OK &&
        zones_load_survey(store, run, &survey, error) == MR_OK &&
        simulate(model, index, &survey, landing, &scene_json, error) == MR_OK &&
        find_figures(store, landing, &survey, error) == MR_OK) {
        fill_rows(landing);
        keep(store, landing, scene_json, error);
    }
    free(scene_json);
    return error->status;
}

void compare_landing_free(struct compare_landing *landing)
{
    for (size_t i = 0; i < landing->rows; i++) {
        free(landing->row[i].series_in);
        free(landing->row[i].spread_in);
    }
    free(landing->head.segments_in);
    measured_free(&landing->measured);
    memset(landing, 0, sizeof *landing);
}
