#include "host/analyse/measured_load.h"
#include "host/study/fit/campaign.h"
#include "host/base/xmalloc.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/zones.h"
#include "host/compare/landing.h"
#include "host/survey/survey.h"

/* ---- surveyed ---- */

enum mr_status fit_surveyed(struct store *store, int64_t run, bool after, int64_t board,
                            struct fit_surveyed *surveyed, struct error *error)
{
    static struct survey_found found;
    struct zones_closure told = {.surveyed = 0};
    struct store_landing *rows = NULL;
    size_t count = 0;
    bool there = false;
    double squares = 0.0;
    int64_t from_us = INT64_MIN, to_us = INT64_MAX;
    *surveyed = (struct fit_surveyed){0};
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        told.slack_in[s] = NAN;
    if (store_landings(store, &rows, &count, error) != MR_OK)
        return error->status;
    for (size_t i = 0; i < count; i++) {
        if (rows[i].id < run + after)
            from_us = rows[i].armed_us > from_us ? rows[i].armed_us : from_us;
        else
            to_us = rows[i].armed_us < to_us ? rows[i].armed_us : to_us;
    }
    free(rows);
    if ((board != STORE_NONE && zones_load_survey(store, board, &told, error) != MR_OK) ||
        survey_find_between(store, from_us, to_us, &found, &there, error) != MR_OK)
        return error->status;
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        const struct survey_estimate *read = &found.slack.segment[s];
        bool gage = there && !isnan(read->value_in);
        surveyed->sum_in[s] = gage ? read->value_in : (double)told.slack_in[s];
        surveyed->segments += isnan(surveyed->sum_in[s]) ? 0 : 1;
        surveyed->gages += gage;
        squares += gage ? read->error_in * read->error_in : 0.0;
    }
    if (surveyed->gages > 0)
        surveyed->error_in = sqrt(squares / (double)surveyed->gages);
    return MR_OK;
}

/* ---- campaign ---- */

#define SURVEY_SPREAD 0.03 /* of all sums of a survey alike: the gauge, and what counts as closed */
#define MANY_SAMPLES  1e9

/* Relative error of a movement: what its samples do not average out, of an inch. */
static double gain_error(const struct measured *measured, const struct measured_channel *channel,
                         double baseline_in)
{
    double error_in = measured_error(measured, channel, 1.0, MANY_SAMPLES);
    return isnan(error_in) ? 0.0 : sqrt(fmax(error_in * error_in - baseline_in * baseline_in, 0.0));
}

/* Every channel's values in one array, a row of samples each, from touchdown on. */
static size_t take_series(const struct measured *measured, struct fit_series series[MR_TRANSDUCERS],
                          double *values)
{
    size_t count = 0, first = 0;
    while (first < measured->samples && measured_time_s(measured, first) < 0.0)
        first++;
    for (unsigned c = 0; c < MR_TRANSDUCERS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_DISPLACEMENT || !channel->raw ||
            !isfinite(channel->baseline) || first >= measured->samples)
            continue;
        double *row = values + count * measured->samples;
        for (size_t i = first; i < measured->samples; i++)
            row[i - first] = measured_value(channel, i);
        /* A message from CAN is one mean for all blocks it fills. */
        double noise_in = channel->noise * sqrt((double)channel->stride);
        double baseline_in = noise_in / sqrt(fmax((double)channel->rest, 1.0));
        series[count++] = (struct fit_series){
            .number = channel->config.number,
            .station_ft = (double)channel->config.station_ft,
            .t0_s = measured_time_s(measured, first),
            .dt_s = measured_time_s(measured, 1) - measured_time_s(measured, 0),
            .value_in = row,
            .count = measured->samples - first,
            .noise_in = noise_in,
            .baseline_in = baseline_in,
            .gain = gain_error(measured, channel, baseline_in),
        };
    }
    return count;
}

/* A survey that the landing did not begin with. */
static bool surveyed_anew(const struct fit_landing *landing, const struct fit_surveyed *after)
{
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(after->sum_in[s]) && !(fabs(after->sum_in[s] - landing->survey_in[s]) < 1e-9))
            return true;
    }
    return false;
}

static bool follows(struct store *store, const struct store_landing *landing, int64_t before)
{
    struct store_landing previous;
    struct error ignored = {0};
    return store_landing_get(store, before, &previous, &ignored) == MR_OK &&
           landing->board_landing == previous.board_landing + 1 &&
           strcmp(landing->board_uid, previous.board_uid) == 0;
}

/* The next landing's own survey counts only when no landing is missing in between. */
static enum mr_status load_after(struct store *store, const struct store_landing *now,
                                 struct fit_landing *landing, struct error *error)
{
    struct store_landing *rows;
    struct fit_surveyed after;
    size_t count;
    int64_t next = STORE_NONE;
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        landing->after_in[s] = (double)NAN;
    if (store_landings(store, &rows, &count, error) != MR_OK)
        return error->status;
    for (size_t i = 0; i < count && next == STORE_NONE; i++)
        next = rows[i].id > now->id && follows(store, &rows[i], now->id) ? rows[i].id : STORE_NONE;
    free(rows);
    if (fit_surveyed(store, now->id, true, next, &after, error) != MR_OK)
        return error->status;
    if (surveyed_anew(landing, &after))
        memcpy(landing->after_in, after.sum_in, sizeof landing->after_in);
    landing->after_error_in = after.error_in;
    return MR_OK;
}

static enum mr_status set_landing(struct store *store, const struct measured *measured,
                                  const char *scene_path, const struct fit_landings *list,
                                  struct fit_landing *landing, struct error *error)
{
    struct fit_surveyed before;
    const struct mr_gates_summary *summary = &measured->summary;
    landing->run = measured->landing.id;
    if (fit_surveyed(store, landing->run, false, landing->run, &before, error) != MR_OK)
        return error->status;
    memcpy(landing->survey_in, before.sum_in, sizeof landing->survey_in);
    landing->survey_error_in = before.error_in;
    landing->gages = before.gages;
    landing->later = measured->landing.board_landing > 1;
    struct zones_closure survey = {.surveyed = (unsigned)before.segments};
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        survey.slack_in[s] = (float)before.sum_in[s];
    if (load_after(store, &measured->landing, landing, error) != MR_OK ||
        sim_scene_load(&landing->scene, scene_path, error) != MR_OK)
        return error->status;
    enum mr_status status = compare_scene(measured, &survey, &landing->scene, error);
    if (status == MR_OK && landing->scene.model != SIM_CHAIN)
        status = error_set(error, MR_USAGE,
                           "not a chain: %s is of model %s; give a scene of model chain",
                           scene_path, sim_model_name(landing->scene.model));
    if (status != MR_OK) {
        sim_scene_free(&landing->scene);
        return status;
    }
    for (size_t i = 0; i < landing->scene.path_count; i++)
        landing->scene.path[i].force_lb *= COMPARE_STRIPS; /* the whole aircraft's */
    double way_ft = summary->stop_station_ft.value - measured->landing.touchdown_ft;
    /* v0^2/2 is shared out over the way */
    landing->thrust_error = way_ft > 0.0 ? summary->stop_station_ft.error / way_ft : 0.0;
    landing->follows = list->count > 0 &&
                       follows(store, &measured->landing, list->landing[list->count - 1].run);
    return MR_OK;
}

enum mr_status fit_campaign_add(struct store *store, int64_t run, const char *scene_path,
                                struct fit_landings *list, struct error *error)
{
    struct measured measured;
    struct fit_landing landing = {0};
    struct fit_series series[MR_TRANSDUCERS];
    char torn[MEASURED_TORN_TEXT];
    enum mr_status status = measured_load(store, run, &measured, error);
    measured_torn_text(&measured, torn);
    if (status == MR_OK && torn[0])
        status = error_set(error, MR_USAGE, "RUN %lld is %s; leave that landing out",
                           (long long)run, torn);
    if (status == MR_OK)
        status = set_landing(store, &measured, scene_path, list, &landing, error);
    if (status == MR_OK) {
        double *values = xcalloc(measured.samples * MR_TRANSDUCERS + 1, sizeof *values);
        size_t count = take_series(&measured, series, values);
        status = fit_landings_add(list, &landing, series, count, error);
        free(values);
        if (status != MR_OK)
            sim_scene_free(&landing.scene);
    }
    measured_free(&measured);
    return status;
}

size_t fit_campaign_set_gap(struct fit_landings *list)
{
    double sum_in = 0.0;
    size_t surveyed = 0;
    for (size_t s = 0; s < MR_SEGMENTS && list->count > 0; s++) {
        if (isnan(list->landing[0].survey_in[s]))
            continue;
        sum_in += list->landing[0].survey_in[s];
        surveyed++;
    }
    if (surveyed > 0 && sum_in > 0.0) {
        list->parameter[FIT_GAP].value = sum_in / (double)(surveyed * MR_MATS_PER_SEGMENT);
        list->parameter[FIT_GAP].spread = SURVEY_SPREAD;
    }
    return surveyed;
}
