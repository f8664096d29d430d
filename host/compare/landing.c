#include "host/compare/landing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
#include "host/link/link.h"
#include "host/store/store_journal.h"
#include "host/survey/survey.h"

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
static void take_row(const struct compare_simulated *s, const struct compare_alignment *alignment,
                     size_t column, const struct measured_channel *channel, size_t length,
                     struct store_simulation *row)
{
    *row = (struct store_simulation){.number = channel->config.number,
                                     .station_ft = (double)channel->config.station_ft,
                                     .rms_in = (double)NAN,
                                     .dt_s = s->dt_s};
    row->series_in = xmalloc(length * sizeof *row->series_in);
    row->spread_in = s->seeds > 1 ? xmalloc(length * sizeof *row->spread_in) : NULL;
    row->length = length;
    for (size_t k = 0; k < length; k++) {
        double t_s = compare_simulated_time(alignment, (double)k * s->dt_s);
        row->series_in[k] = (float)value_at(s, s->mean_in, column, t_s);
        if (row->spread_in)
            row->spread_in[k] = (float)value_at(s, s->spread_in, column, t_s);
    }
}

static void take_head(const struct compare_model *model, const struct compare_simulated *s,
                      const struct compare_alignment *alignment, double end_s,
                      struct store_simulation_head *head)
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
    head->segments_in = xmalloc(head->segment_rows * row_bytes);
    for (size_t i = 0; i < head->segment_rows; i++) {
        double k = compare_simulated_time(alignment, (double)i * COMPARE_SEGMENTS_S) /
                       COMPARE_SEGMENTS_S +
                   0.5;
        size_t from = (size_t)fmin(fmax(k, 0.0), (double)(s->segment_rows - 1));
        memcpy(head->segments_in + i * MR_SEGMENTS, s->remaining_in + from * MR_SEGMENTS,
               row_bytes);
    }
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
        take_row(&simulated, &alignment, k, channels[k], length, &landing->row[landing->rows++]);
    if (error->status == MR_OK) {
        take_head(model, &simulated, &alignment, end_s, &landing->head);
        memcpy(landing->moved_in, simulated.moved_in, sizeof landing->moved_in);
        memcpy(landing->moved_spread_in, simulated.moved_spread_in,
               sizeof landing->moved_spread_in);
        *scene_json = compare_describe(model, &simulated);
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
                        landing->rows, &landing->figures);
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

/* What simulations moved the gage points by, landing by landing. */
struct moves {
    bool known;
    double in[SURVEY_POINTS], spread_in[SURVEY_POINTS];
};

/* The runs of the series; the caller frees. */
static enum mr_status select_runs(struct store *store, const char *name, int64_t **runs,
                                  size_t *count, struct error *error)
{
    struct store_landing *rows = NULL;
    size_t all = 0;
    *count = 0;
    *runs = NULL;
    if (store_landings(store, &rows, &all, error) != MR_OK)
        return error->status;
    *runs = xcalloc(all + 1, sizeof **runs);
    for (size_t i = 0; i < all && error->status == MR_OK; i++) {
        struct store_series series = {0};
        bool is_void = false;
        if (store_is_void(store, rows[i].id, &is_void, NULL, error) == MR_OK && name)
            store_series_of(store, &rows[i], &series, error);
        if (!is_void && (!name || strcmp(series.name, name) == 0))
            (*runs)[(*count)++] = rows[i].id;
    }
    free(rows);
    if (error->status == MR_OK && *count == 0 && name)
        error_set(error, MR_UNKNOWN,
                  "no landings in series '%s': %s; leave --series out for all, or matrig landing "
                  "%s --series NAME begins one",
                  name, store_path(store), store_path(store));
    else if (error->status == MR_OK && *count == 0)
        error_set(error, MR_TOO_FEW, "no landings to compare: %s; log one first",
                  store_path(store));
    return error->status;
}

static void pool(struct compare_series *set, const struct compare_figures *figures)
{
    set->run_ms += figures->run_ms;
    set->error_in = fmax(set->error_in, figures->error_in);
    for (size_t c = 0; c < figures->channels; c++) {
        const struct compare_channel *channel = &figures->channel[c];
        double n = (double)channel->f.compared;
        if (!channel->compared || channel->f.compared == 0)
            continue;
        set->channel[channel->number - 1].number = channel->number;
        set->channel[channel->number - 1].station_ft = channel->station_ft;
        set->channel[channel->number - 1].landings++;
        set->channel[channel->number - 1].samples += n;
        set->channel[channel->number - 1].bias_in += n * channel->f.bias;
        set->channel[channel->number - 1].rms_in += n * channel->f.rms * channel->f.rms;
    }
}

/* From sums to means. */
static void finish(struct compare_series *set)
{
    double samples = 0.0, sum = 0.0, squares = 0.0;
    for (size_t c = 0; c < MR_TRANSDUCERS; c++) {
        double n = set->channel[c].samples;
        samples += n;
        sum += set->channel[c].bias_in;
        squares += set->channel[c].rms_in;
        set->channel[c].bias_in /= n;
        set->channel[c].rms_in = sqrt(set->channel[c].rms_in / n);
    }
    set->pooled.bias_in = sum / samples;
    set->pooled.rms_in = sqrt(squares / samples);
    set->pooled.within = (double)NAN;
}

/* ---- surveys ---- */

/* Mean over the lines of what has moved. */
static void take_measured(const struct survey_change *change, struct compare_moved *moved)
{
    for (size_t p = 0; p < SURVEY_POINTS; p++) {
        double sum = 0.0, variance = 0.0, n = 0.0;
        for (size_t line = 0; line < SURVEY_LINES; line++) {
            const struct survey_estimate *e = &change->moved[line][p];
            if (isnan(e->value_in))
                continue;
            sum += e->value_in;
            variance += e->error_in * e->error_in;
            n += 1.0;
        }
        moved->point[p].measured_in = n > 0.0 ? sum / n : (double)NAN;
        moved->point[p].error_in = n > 0.0 ? sqrt(variance) / n : (double)NAN;
    }
}

/* `all`: landings of the campaign between the surveys, void ones and those of other series too:
 * each has moved the mat. */
static void take_simulated(const struct compare_series *set, const struct moves *moves,
                           int64_t after, int64_t until, size_t all, struct compare_moved *moved)
{
    moved->simulated = true;
    for (size_t i = 0; i < set->count; i++) {
        if (set->landing[i].run <= after || set->landing[i].run > until)
            continue;
        moved->landings++;
        moved->simulated = moved->simulated && moves[i].known;
        for (size_t p = 0; p < SURVEY_POINTS; p++) {
            moved->point[p].simulated_in += moves[i].in[p];
            moved->point[p].spread_in = hypot(moved->point[p].spread_in, moves[i].spread_in[p]);
        }
    }
    moved->simulated = moved->simulated && moved->landings == all && all > 0;
    double sum = 0.0, squares = 0.0, chi = 0.0;
    for (size_t p = 0; p < SURVEY_POINTS && moved->simulated; p++) {
        double d = moved->point[p].measured_in - moved->point[p].simulated_in;
        double u = hypot(moved->point[p].error_in, hypot(moved->point[p].spread_in, set->error_in));
        if (isnan(d))
            continue;
        sum += d;
        squares += d * d;
        chi += d * d / (u * u);
        moved->points++;
    }
    double n = (double)moved->points;
    moved->bias_in = moved->points ? sum / n : (double)NAN;
    moved->rms_in = moved->points ? sqrt(squares / n) : (double)NAN;
    moved->chi = moved->points ? sqrt(chi / n) : (double)NAN;
}

static size_t landings_between(const struct store_landing *rows, size_t count, int64_t after,
                               int64_t until)
{
    size_t found = 0;
    for (size_t i = 0; i < count; i++)
        found += rows[i].id > after && rows[i].id <= until;
    return found;
}

static enum mr_status compare_surveys(struct store *store, const struct moves *moves,
                                      struct compare_series *set, struct error *error)
{
    struct store_gage_survey *rows = NULL;
    struct survey *survey = NULL;
    struct survey_found found;
    struct store_landing *landings = NULL;
    size_t count = 0, points = 0, landing_count = 0;
    double squares = 0.0;
    if (store_gage_surveys(store, &rows, &count, error) != MR_OK ||
        store_landings(store, &landings, &landing_count, error) != MR_OK) {
        free(rows);
        return error->status;
    }
    set->moved = xcalloc(count + 1, sizeof *set->moved);
    survey = xmalloc(sizeof *survey);
    for (size_t i = 1; i < count && error->status == MR_OK; i++) {
        if (survey_get(store, rows[i].id, survey, error) != MR_OK ||
            survey_find(store, survey, &found, error) != MR_OK)
            break;
        size_t before = i;
        while (before > 0 && rows[before - 1].id != found.previous)
            before--;
        if (before == 0 || rows[i].after_run == STORE_NONE)
            continue;
        const struct store_gage_survey *previous = &rows[before - 1];
        struct compare_moved *moved = &set->moved[set->moves];
        moved->from_survey = previous->id;
        moved->to_survey = rows[i].id;
        take_measured(&found.since_previous, moved);
        int64_t after = previous->after_run == STORE_NONE ? 0 : previous->after_run,
                until = rows[i].after_run;
        take_simulated(set, moves, after, until,
                       landings_between(landings, landing_count, after, until), moved);
        if (moved->landings == 0) /* none of this series between them */
            memset(moved, 0, sizeof *moved);
        else
            set->moves++;
        if (moved->points > 0) {
            squares += (double)moved->points * moved->rms_in * moved->rms_in;
            points += moved->points;
        }
    }
    set->pooled.moved_in = points ? sqrt(squares / (double)points) : (double)NAN;
    free(landings);
    free(rows);
    free(survey);
    return error->status;
}

/* ---- the series ---- */

static enum mr_status run_landing(struct store *store, struct compare_model *model,
                                  struct compare_series *set, size_t index, struct moves *moves,
                                  struct error *error)
{
    struct compare_landing landing;
    struct compare_series_landing *out = &set->landing[index];
    struct error why = {0};
    enum mr_status status = compare_landing(store, out->run, model, index, &landing, &why);
    if (status == MR_OK) {
        out->compared = true;
        set->compared++;
        out->figures = landing.figures;
        pool(set, &out->figures);
        moves->known = true;
        memcpy(moves->in, landing.moved_in, sizeof moves->in);
        memcpy(moves->spread_in, landing.moved_spread_in, sizeof moves->spread_in);
    } else if (status == MR_TOO_FEW || status == MR_TRUNCATED || status == MR_NUMERICS) {
        snprintf(out->why, sizeof out->why, "%s", why.text);
    } else {
        error_set(error, status, "%s", why.text);
    }
    compare_landing_free(&landing);
    return error->status;
}

enum mr_status compare_series_run(struct store *store, const char *name,
                                  struct compare_model *model,
                                  void (*progress)(void *ctx, size_t done, size_t of), void *ctx,
                                  struct compare_series *set, struct error *error)
{
    int64_t *runs = NULL;
    struct moves *moves = NULL;
    memset(set, 0, sizeof *set);
    snprintf(set->against, sizeof set->against, "%s", model->name);
    snprintf(set->name, sizeof set->name, "%s", name ? name : "");
    if (select_runs(store, name, &runs, &set->count, error) == MR_OK) {
        set->landing = xcalloc(set->count, sizeof *set->landing);
        moves = xcalloc(set->count, sizeof *moves);
    }
    for (size_t i = 0; i < set->count && error->status == MR_OK; i++) {
        set->landing[i].run = runs[i];
        run_landing(store, model, set, i, &moves[i], error);
        if (progress)
            progress(ctx, i + 1, set->count);
    }
    if (error->status == MR_OK && set->compared == 0)
        error_set(error, MR_TOO_FEW, "no landing could be compared: %s: %s", store_path(store),
                  set->landing[0].why);
    if (error->status == MR_OK) {
        finish(set);
        compare_surveys(store, moves, set, error);
    }
    free(runs);
    free(moves);
    return error->status;
}

void compare_series_free(struct compare_series *set)
{
    free(set->landing);
    free(set->moved);
    memset(set, 0, sizeof *set);
}
