#include "host/analyse/measured_load.h"
#include "host/compare/landing.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/wire.h"
#include "host/base/progress.h"
#include "host/base/xmalloc.h"
#include "host/landing_series/ensemble.h"
#include "host/link/link.h"
#include "host/store/store_journal.h"

#define IN_PER_FT                  12.0
/* half the interval over which the deceleration is averaged */
#define DECELERATION_HALF_WIDTH_S  0.005
#define SIMULATED_AFTER_STOP_MIN_S 0.5
/* upper limit for the duration of a path; no landing takes that long */
#define PATH_MAX_S                 3600.0

static double compute_deceleration(const struct measured_landing *measured, double t_s,
                                   double stop_s)
{
    double from_s = fmax(0.0, t_s - DECELERATION_HALF_WIDTH_S);
    double to_s = fmin(stop_s, t_s + DECELERATION_HALF_WIDTH_S);
    double error_ft_s;
    double from_ft_s = measured_speed_ft_s(measured, from_s, &error_ft_s);
    /* the speed at the stop is 0 by definition */
    double to_ft_s = to_s < stop_s ? measured_speed_ft_s(measured, to_s, &error_ft_s) : 0.0;
    return fmax(0.0, (from_ft_s - to_ft_s) / (to_s - from_s));
}

static enum mr_status set_path(const struct measured_landing *measured, struct sim_scene *scene,
                               struct error *error)
{
    double stop_s = measured->summary.stop_t_s.value;
    double last_s = stop_s - 0.001; /* the thrust ends at most 1 ms before the stop */
    if (!(last_s > 0.0 && last_s < PATH_MAX_S))
        return error_set(error, MR_TOO_FEW,
                         "impossible stop %g s after touchdown: RUN %lld; check the switches",
                         stop_s, (long long)measured->landing.id);
    size_t steps = (size_t)ceil(last_s / COMPARE_PATH_STEP_S);
    struct sim_path_row *rows = xcalloc(steps + 2, sizeof *rows);
    for (size_t i = 0; i <= steps; i++) {
        double t_s = i < steps ? (double)i * COMPARE_PATH_STEP_S : last_s;
        double thrust_lb = COMPARE_AIRCRAFT_LB / COMPARE_RIG_STRIPS *
                           compute_deceleration(measured, t_s, stop_s) / scene->g_ft_s2;
        rows[i] = (struct sim_path_row){t_s, measured_station_ft(measured, t_s), thrust_lb};
    }
    rows[steps + 1] = (struct sim_path_row){stop_s, measured->summary.stop_station_ft.value, 0.0};
    sim_scene_set_path(scene, rows, steps + 2);
    free(rows);
    return MR_OK;
}

/* Sets each joint of a surveyed segment to an equal share of the segment's slack. Other joints keep
 * the scene's gap. */
static void set_gaps(const struct zones_slack *survey, struct sim_scene *scene)
{
    size_t count = (size_t)scene->mats + 1;
    double *gap_ft = xcalloc(count, sizeof *gap_ft);
    for (size_t j = 0; j < count; j++) {
        double station_ft = (double)j * scene->length_ft;
        /* A joint belongs to the segment in or at the start of which it is. Adding half a mat
         * avoids rounding errors. */
        size_t segment =
            (size_t)((station_ft + 0.5 * scene->length_ft) / (double)MR_SEGMENT_LENGTH_FT);
        gap_ft[j] = sim_scene_joint_value(&scene->gap0_ft, (int)j + 1);
        if (segment < MR_SEGMENTS && !isnan(survey->slack_in[segment]))
            gap_ft[j] = (double)survey->slack_in[segment] / MR_MATS_PER_SEGMENT / IN_PER_FT;
    }
    sim_scene_set_list(&scene->gap0_ft, gap_ft, count);
    free(gap_ft);
}

enum mr_status compare_prepare_scene(const struct measured_landing *measured,
                                     const struct zones_slack *survey, struct sim_scene *scene,
                                     struct error *error)
{
    if (measured->fit_status == MR_TRUNCATED) {
        char reason[MEASURED_REASON_SIZE];
        measured_format_unknown_stop(measured, reason);
        return error_set(
            error, MR_TRUNCATED,
            "%s: RUN %lld; complete the landing from the black box, or compare a different landing",
            reason, (long long)measured->landing.id);
    }
    if (measured->fit_status != MR_OK)
        return error_set(error, MR_TOO_FEW,
                         "the motion of the gear is unknown (%s): RUN %lld; compare a landing with "
                         "at least 3 switches and a stop",
                         mr_status_text(measured->fit_status), (long long)measured->landing.id);
    double end_s = measured_time_s(measured, measured->samples - 1);
    snprintf(scene->name, sizeof scene->name, "RUN %lld", (long long)measured->landing.id);
    scene->t_end_s = 0.0;
    scene->t_dwell_s = fmax(SIMULATED_AFTER_STOP_MIN_S, end_s - measured->summary.stop_t_s.value);
    set_gaps(survey, scene);
    return set_path(measured, scene, error);
}

/* Checks that the scene has the mats and the runway of the rig. Otherwise MR_USAGE, with the
 * command that converts the scene. */
static enum mr_status check_scale(const struct sim_scene *scene, const char *where,
                                  struct error *error)
{
    const double rig_ft = MR_SEGMENTS * (double)MR_SEGMENT_LENGTH_FT;
    double runway_ft = scene->mats * scene->length_ft;
    if (fabs(scene->length_ft - (double)MR_MAT_LENGTH_FT) < 1e-3 * scene->length_ft &&
        fabs(runway_ft - rig_ft) < 1e-3 * runway_ft)
        return MR_OK;
    return error_set(
        error, MR_USAGE,
        "different scale: %s has %d mats of %.4g ft (runway %.4g ft), but the rig has %.0f mats of "
        "%.4g ft (runway %.4g ft); convert a prototype file with matrig scale FILE --to model",
        where, scene->mats, scene->length_ft, runway_ft, rig_ft / (double)MR_MAT_LENGTH_FT,
        (double)MR_MAT_LENGTH_FT, rig_ft);
}

/* number of gage points except the one at the fixed edge */
#define FREE_GAGE_POINTS (SURVEY_POINTS - 1u)

/* Returns true if the file is a study file, which has landings. For invalid JSON the scene loader
 * reports the error. */
static bool is_study_file(const char *path)
{
    json_error_t ignored;
    json_t *root = json_load_file(path, 0, &ignored);
    bool landings = json_object_get(root, "landings") != NULL;
    json_decref(root);
    return landings;
}

enum mr_status compare_model_load(struct compare_model *model, const char *path, size_t seeds,
                                  struct error *error)
{
    const char *slash = strrchr(path, '/');
    memset(model, 0, sizeof *model);
    snprintf(model->name, sizeof model->name, "%s", slash ? slash + 1 : path);
    model->seed_count = 1;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        model->previous_survey_in[s] = MR_NAN;
    const struct sim_scene *scene = &model->scene;
    if (is_study_file(path)) {
        if (series_load(&model->series, path, error) != MR_OK)
            return error->status;
        model->is_ensemble = true;
        model->seed_count = seeds ? seeds : model->series.seed_count;
        scene = &model->series.landings[0].scene;
    } else if (seeds > 1) {
        return error_set(error, MR_USAGE,
                         "no ensemble: %s is a scene with one runway; --seeds needs a study file",
                         path);
    } else if (sim_scene_load(&model->scene, path, error) != MR_OK) {
        return error->status;
    }
    if (check_scale(scene, path, error) != MR_OK)
        compare_model_free(model);
    else
        model->joint_count = (size_t)scene->mats + 1;
    return error->status;
}

void compare_model_free(struct compare_model *model)
{
    if (model->is_ensemble)
        series_free(&model->series);
    else
        sim_scene_free(&model->scene);
    free(model->gap_ft);
    *model = (struct compare_model){.is_ensemble = false};
}

/* Draws gaps and resistances of each runway, with the same random numbers as
 * host/landing_series/ensemble.c. */
static void draw_runways(struct compare_model *model)
{
    size_t all = model->seed_count * model->joint_count;
    model->gap_ft = xcalloc(2 * all, sizeof *model->gap_ft);
    model->closing_lb = model->gap_ft + all;
    for (size_t seed = 0; seed < model->seed_count; seed++) {
        const struct landing_series *c = &model->series;
        double *gap_ft = model->gap_ft + seed * model->joint_count,
               *closing_lb = model->closing_lb + seed * model->joint_count;
        struct draw_generator gaps = draw_generator_init(c->first_seed + seed, DRAW_GAPS),
                              closing = draw_generator_init(c->first_seed + seed, DRAW_CLOSING);
        for (size_t j = 0; j < model->joint_count; j++) {
            gap_ft[j] = model->is_ensemble
                          ? fmin(draw_from_range(&gaps, c->gap_in) / IN_PER_FT,
                                 c->landings[0].scene.slack_ft)
                          : sim_scene_joint_value(&model->scene.gap0_ft, (int)j + 1);
            closing_lb[j] = model->is_ensemble
                              ? draw_from_range(&closing, c->closing_lb)
                              : sim_scene_joint_value(&model->scene.grit_lb, (int)j + 1);
        }
    }
}

/* Changes openings to a given sum, as far as possible. For a smaller sum, scales the openings; for
 * a larger sum, scales the differences between `most_ft` and the openings. */
static void scale_gaps_to_sum(double *gap_ft, size_t count, double sum_ft, double most_ft)
{
    double now_ft = 0.0, room_ft = 0.0;
    for (size_t j = 0; j < count; j++) {
        gap_ft[j] = fmin(fmax(gap_ft[j], 0.0), most_ft);
        now_ft += gap_ft[j];
        room_ft += most_ft - gap_ft[j];
    }
    double less = now_ft > 0.0 ? fmin(sum_ft / now_ft, 1.0) : 1.0;
    double more = room_ft > 0.0 ? fmin(fmax(sum_ft - now_ft, 0.0) / room_ft, 1.0) : 0.0;
    for (size_t j = 0; j < count; j++)
        gap_ft[j] = sum_ft < now_ft ? gap_ft[j] * less : gap_ft[j] + more * (most_ft - gap_ft[j]);
}

static bool is_new_survey(const struct compare_model *model, const struct zones_slack *survey)
{
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(survey->slack_in[s]) &&
            !(fabsf(survey->slack_in[s] - model->previous_survey_in[s]) < 1e-6f))
            return true;
    }
    return false;
}

static void apply_survey(struct compare_model *model, const struct zones_slack *survey)
{
    if (!is_new_survey(model, survey))
        return;
    for (size_t seed = 0; seed < model->seed_count; seed++) {
        for (size_t s = 0; s < MR_SEGMENTS; s++) {
            double *gap_ft = model->gap_ft + seed * model->joint_count + s * MR_MATS_PER_SEGMENT;
            double sum_ft = (double)survey->slack_in[s] / IN_PER_FT;
            if (isnan(sum_ft))
                continue;
            if (model->is_ensemble)
                scale_gaps_to_sum(gap_ft, MR_MATS_PER_SEGMENT, sum_ft,
                                  model->series.landings[0].scene.slack_ft);
            for (size_t j = 0; j < MR_MATS_PER_SEGMENT && !model->is_ensemble; j++)
                gap_ft[j] = sum_ft / MR_MATS_PER_SEGMENT;
        }
    }
    memcpy(model->previous_survey_in, survey->slack_in, sizeof model->previous_survey_in);
}

/* Makes the scene that all seeds of the landing share. The scene owns path, gaps and
 * resistances. */
static enum mr_status make_scene(const struct compare_model *model, size_t index,
                                 const struct measured_landing *measured, struct sim_scene *scene,
                                 struct error *error)
{
    const struct landing_series *c = &model->series;
    struct zones_slack none;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        none.slack_in[s] = MR_NAN;
    none.surveyed_segment_count = 0;
    if (model->is_ensemble && index >= c->landing_count)
        return error_set(error, MR_USAGE,
                         "%s describes only %zu landings, but the landing to compare is number %zu "
                         "of its series; add this landing to the file, or give --series NAME",
                         model->name, c->landing_count, index + 1);
    *scene = model->is_ensemble ? c->landings[index].scene : model->scene;
    scene->gap0_ft = scene->grit_lb = scene->ground_ft = (struct sim_list){0};
    scene->path = NULL;
    scene->path_count = 0;
    if (model->is_ensemble)
        scene->model = SIM_MODEL_CHAIN;
    enum mr_status status = compare_prepare_scene(measured, &none, scene, error);
    double share = c->weight_lb / c->axles * COMPARE_RIG_STRIPS / COMPARE_AIRCRAFT_LB;
    for (size_t i = 0; model->is_ensemble && i < scene->path_count; i++)
        scene->path[i].force_lb *= share;
    return status;
}

static void allocate_rows(struct compare_simulated *s, const struct sim_result *result)
{
    if (s->mean_movement_in)
        return;
    s->row_count = result->sample_count;
    s->dt_s = result->sample_dt_s;
    s->segment_row_count =
        (size_t)floor((double)(s->row_count - 1) * s->dt_s / COMPARE_SEGMENT_STEP_S) + 1;
    s->mean_movement_in = xcalloc(2 * s->row_count * s->station_count, sizeof *s->mean_movement_in);
    s->remaining_in = xcalloc(s->segment_row_count * MR_SEGMENTS, sizeof *s->remaining_in);
    s->movement_spread_in = s->mean_movement_in + s->row_count * s->station_count;
}

/* Adds a value to the mean and to the sum of squared deviations (Welford 1962). */
static void add_to_mean(double *mean, double *squares, double value, size_t count)
{
    double step = value - *mean;
    *mean += step / (double)count;
    *squares += step * (value - *mean);
}

/* Returns the movement of gage point p (1..42), which is on mat 10 p. The columns of the gage
 * points follow those of the stations. */
static double get_point_movement_in(const struct sim_result *result, size_t row, size_t stations,
                                    size_t p)
{
    return p == 0 ? 0.0
                  : IN_PER_FT * result->sample_u_ft[row * result->station_count + stations + p - 1];
}

static void add_seed_result(struct compare_simulated *s, const struct sim_result *result,
                            const double *gap_ft, size_t count)
{
    size_t rows = s->row_count < result->sample_count ? s->row_count : result->sample_count;
    for (size_t row = 0; row < rows; row++) {
        for (size_t k = 0; k < s->station_count; k++)
            add_to_mean(&s->mean_movement_in[row * s->station_count + k],
                        &s->movement_spread_in[row * s->station_count + k],
                        IN_PER_FT * result->sample_u_ft[row * result->station_count + k], count);
    }
    for (size_t i = 0; i < s->segment_row_count; i++) {
        size_t row = (size_t)lround((double)i * COMPARE_SEGMENT_STEP_S / s->dt_s);
        for (size_t segment = 0; segment < MR_SEGMENTS && row < rows; segment++) {
            double left_in = get_point_movement_in(result, row, s->station_count, segment + 1) -
                             get_point_movement_in(result, row, s->station_count, segment);
            for (size_t j = 0; j < MR_MATS_PER_SEGMENT; j++)
                left_in += IN_PER_FT * gap_ft[segment * MR_MATS_PER_SEGMENT + j];
            float *mean = &s->remaining_in[i * MR_SEGMENTS + segment];
            *mean += ((float)left_in - *mean) / (float)count;
        }
    }
}

/* Converts sums of squared deviations to standard deviations. */
static void convert_squares_to_deviations(double *squares, size_t count, size_t seeds)
{
    for (size_t i = 0; i < count; i++)
        squares[i] = seeds > 1 ? sqrt(squares[i] / (double)(seeds - 1)) : 0.0;
}

static enum mr_status simulate_seed(struct compare_model *model, size_t seed,
                                    const double *station_ft, size_t columns,
                                    struct compare_simulated *s, struct error *error)
{
    double *gap_ft = model->gap_ft + seed * model->joint_count;
    /* For the first seed, simulate again with another step to find the numerical error. All seeds
     * use the same solver, so this error applies to all; it is far below the differences between
     * seeds. */
    bool chain = s->scene.model == SIM_MODEL_CHAIN;
    struct sim_options options = {.solver = chain ? "staggered" : NULL,
                                  .sample_dt_s = COMPARE_SAMPLE_STEP_S,
                                  .station_ft = station_ft,
                                  .station_count = columns,
                                  .is_single_pass = seed > 0};
    struct progress progress;
    struct sim_result result = {0};
    options.may_continue = sim_report_progress;
    options.may_continue_ctx = &progress;
    progress_begin(&progress, "compare", "a smaller tend or fewer mats", false);
    sim_scene_set_list(&s->scene.gap0_ft, gap_ft, model->joint_count);
    sim_scene_set_list(&s->scene.grit_lb, model->closing_lb + seed * model->joint_count,
                       model->joint_count);
    enum mr_status status = sim_run(&s->scene, &options, &result, error);
    progress_end(&progress);
    if (status == MR_OK) {
        allocate_rows(s, &result);
        if (seed == 0) {
            s->solver = result.solver;
            s->solver_dt_s = result.dt_s;
            s->solver_error_in = IN_PER_FT * result.error_u_ft;
        }
        s->simulation_ms += result.run_ms;
        s->seed_count = seed + 1;
        add_seed_result(s, &result, gap_ft, seed + 1);
        for (size_t j = 0; j < model->joint_count; j++)
            gap_ft[j] += (j + 1 < model->joint_count ? result.u_ft[j + 1] : 0.0) -
                         (j > 0 ? result.u_ft[j] : 0.0);
    }
    sim_result_free(&result);
    return error->status;
}

enum mr_status compare_simulate(struct compare_model *model, size_t index,
                                const struct measured_landing *measured,
                                const struct zones_slack *survey, const double *station_ft,
                                size_t stations, struct compare_simulated *s, struct error *error)
{
    memset(s, 0, sizeof *s);
    s->station_count = stations;
    if (make_scene(model, index, measured, &s->scene, error) != MR_OK)
        return error->status;
    if (!model->gap_ft)
        draw_runways(model);
    apply_survey(model, survey);
    double *columns = xcalloc(stations + FREE_GAGE_POINTS, sizeof *columns);
    memcpy(columns, station_ft, stations * sizeof *columns);
    for (size_t p = 1; p <= FREE_GAGE_POINTS; p++)
        columns[stations + p - 1] = ((double)(p * MR_MATS_PER_SEGMENT) - 1.0) * s->scene.length_ft;
    for (size_t seed = 0; seed < model->seed_count && error->status == MR_OK; seed++)
        simulate_seed(model, seed, columns, stations + FREE_GAGE_POINTS, s, error);
    free(columns);
    if (error->status == MR_OK)
        convert_squares_to_deviations(s->movement_spread_in, s->row_count * s->station_count,
                                      s->seed_count);
    return error->status;
}

void compare_simulated_free(struct compare_simulated *s)
{
    free(s->scene.gap0_ft.values);
    free(s->scene.grit_lb.values);
    free(s->scene.path); /* the model owns the other parts of the scene */
    free(s->mean_movement_in);
    free(s->remaining_in);
    memset(s, 0, sizeof *s);
}

/* Describes the simulation, so that it can be repeated. The caller frees the text. */
static char *make_scene_json(const struct compare_model *model, const struct compare_simulated *s)
{
    const struct sim_scene *scene = &s->scene;
    json_t *path = json_array(), *gaps = json_array();
    for (size_t i = 0; i < scene->path_count; i++)
        json_array_append_new(path, json_pack("[fff]", scene->path[i].t_s, scene->path[i].x_ft,
                                              scene->path[i].force_lb));
    for (size_t i = 0; i < scene->gap0_ft.count; i++)
        json_array_append_new(gaps, json_real(scene->gap0_ft.values[i]));
    json_t *root = json_pack("{sssssIsisfsfsfsfsfsfsososssfsf}", "file", model->name, "model",
                             sim_model_name(scene->model), "seeds", (json_int_t)s->seed_count, "N",
                             scene->mats, "L", scene->length_ft, "W", scene->weight_lb, "KL",
                             scene->kl_lb_ft, "CL", scene->cl_lb_s_ft, "f", scene->friction,
                             "slack", scene->slack_ft, "path", path, "gap0", gaps, "solver",
                             s->solver, "dt_s", s->solver_dt_s, "t_dwell", scene->t_dwell_s);
    char *text = json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(9));
    json_decref(root);
    return text;
}

/* ---- a landing ---- */

static size_t list_stations(const struct measured_landing *measured,
                            const struct measured_channel **channels, double *station_ft)
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

/* Copies mean and spread of a station, sample by sample. */
static void set_simulation_row(const struct compare_simulated *s, size_t column,
                               const struct measured_channel *channel, size_t length,
                               struct store_simulation *row)
{
    *row = (struct store_simulation){.number = channel->config.number,
                                     .station_ft = (double)channel->config.station_ft,
                                     .rms_in = (double)NAN,
                                     .dt_s = s->dt_s};
    row->series_in = xmalloc(length * sizeof *row->series_in);
    row->spread_in = s->seed_count > 1 ? xmalloc(length * sizeof *row->spread_in) : NULL;
    row->length = length;
    for (size_t k = 0; k < length; k++) {
        row->series_in[k] = (float)s->mean_movement_in[k * s->station_count + column];
        if (row->spread_in)
            row->spread_in[k] = (float)s->movement_spread_in[k * s->station_count + column];
    }
}

static void set_simulation_head(const struct compare_model *model,
                                const struct compare_simulated *s, double end_s,
                                struct store_simulation_summary *head)
{
    *head = (struct store_simulation_summary){
        .run_ms = s->simulation_ms,
        .error_in = s->solver_error_in,
        .seeds = (int64_t)s->seed_count,
        .segments_dt_s = COMPARE_SEGMENT_STEP_S,
        .segment_rows = (size_t)floor(end_s / COMPARE_SEGMENT_STEP_S) + 1,
    };
    snprintf(head->file, sizeof head->file, "%s", model->name);
    head->segment_rows = head->segment_rows < s->segment_row_count ? head->segment_rows
                                                                   : s->segment_row_count;
    const size_t bytes = head->segment_rows * MR_SEGMENTS * sizeof *head->segments_in;
    head->segments_in = xmalloc(bytes);
    memcpy(head->segments_in, s->remaining_in, bytes);
}

static enum mr_status simulate_landing(struct compare_model *model, size_t index,
                                       const struct zones_slack *survey,
                                       struct compare_landing *landing, char **scene_json,
                                       struct error *error)
{
    const struct measured_landing *measured = &landing->measured;
    const struct measured_channel *channels[MR_TRANSDUCERS];
    double station_ft[MR_TRANSDUCERS];
    struct compare_simulated simulated;
    size_t count = list_stations(measured, channels, station_ft);
    if (count == 0)
        return error_set(error, MR_TOO_FEW,
                         "RUN %lld has no displacement readings; choose a landing that has them",
                         (long long)measured->landing.id);
    compare_simulate(model, index, measured, survey, station_ft, count, &simulated, error);
    /* end of the time that measurement and simulation have in common */
    double end_s = measured_time_s(measured, measured->samples - 1);
    if (error->status == MR_OK)
        end_s = fmin(end_s, (double)(simulated.row_count - 1) * simulated.dt_s);
    if (error->status == MR_OK && !(end_s > 0.0))
        error_set(error, MR_TOO_FEW,
                  "the landing and the simulation do not overlap in time: RUN %lld; choose a "
                  "different landing or scene",
                  (long long)measured->landing.id);
    size_t length = error->status == MR_OK ? (size_t)floor(end_s / simulated.dt_s) + 1 : 0;
    for (size_t k = 0; k < count && error->status == MR_OK; k++)
        set_simulation_row(&simulated, k, channels[k], length, &landing->row[landing->row_count++]);
    if (error->status == MR_OK) {
        set_simulation_head(model, &simulated, end_s, &landing->head);
        *scene_json = make_scene_json(model, &simulated);
    }
    compare_simulated_free(&simulated);
    return error->status;
}

/* Copies the results to the fields that queries of a campaign can read without the samples. */
static void copy_figures_to_rows(struct compare_landing *landing)
{
    for (size_t i = 0; i < landing->row_count; i++) {
        struct store_simulation *row = &landing->row[i];
        for (size_t c = 0; c < landing->figures.channel_count; c++) {
            const struct compare_channel *channel = &landing->figures.channel[c];
            if (channel->number != row->number)
                continue;
            row->peak_measured_in = channel->figures.peak_measured.value;
            row->peak_measured_error_in = channel->figures.peak_measured.error;
            row->peak_simulated_in = channel->figures.peak_simulated.value;
            row->peak_simulated_error_in = channel->figures.peak_simulated.error;
            row->rms_in = channel->figures.rms;
            row->end_measured_in = channel->end_measured.value;
            row->end_simulated_in = channel->end_simulated.value;
        }
    }
}

static enum mr_status compute_figures(struct store *store, struct compare_landing *landing,
                                      const struct zones_slack *survey, struct error *error)
{
    struct store_zone *zones = NULL;
    struct store_prediction *predictions = NULL;
    struct compare_board_reports reports = {0};
    int64_t run = landing->measured.landing.id;
    if (store_zones_get(store, run, &zones, &reports.zone_count, error) == MR_OK &&
        store_predictions_get(store, run, &predictions, &reports.prediction_count, error) ==
            MR_OK) {
        reports.zone = zones;
        reports.prediction = predictions;
        compare_compute_figures(&landing->measured, survey, &reports, &landing->head, landing->row,
                                landing->row_count, &landing->figures);
    }
    free(zones);
    free(predictions);
    return error->status;
}

static enum mr_status store_comparison(struct store *store, const struct compare_landing *landing,
                                       const char *scene_json, struct error *error)
{
    const int64_t run = landing->measured.landing.id;
    return store_begin(store, error) ?:
           store_simulation_put(store, run, scene_json, (int64_t)link_now_us(), &landing->head,
                                landing->row, landing->row_count, error) ?:
           store_commit(store, error);
}

enum mr_status compare_run_landing(struct store *store, int64_t run, struct compare_model *model,
                                   size_t index, struct compare_landing *landing,
                                   struct error *error)
{
    struct zones_slack survey;
    char *scene_json = NULL;
    memset(landing, 0, sizeof *landing);
    if (measured_load(store, run, &landing->measured, error) == MR_OK &&
        zones_load_survey(store, run, &survey, error) == MR_OK &&
        simulate_landing(model, index, &survey, landing, &scene_json, error) == MR_OK &&
        compute_figures(store, landing, &survey, error) == MR_OK) {
        copy_figures_to_rows(landing);
        if (!model->is_storing_disabled)
            store_comparison(store, landing, scene_json, error);
    }
    free(scene_json);
    return error->status;
}

void compare_landing_free(struct compare_landing *landing)
{
    for (size_t i = 0; i < landing->row_count; i++) {
        free(landing->row[i].series_in);
        free(landing->row[i].spread_in);
    }
    free(landing->head.segments_in);
    measured_free(&landing->measured);
    memset(landing, 0, sizeof *landing);
}

/* Lists the RUNs of the series. The caller frees the list. */
static enum mr_status select_runs(struct store *store, const char *name, int64_t **runs,
                                  size_t *count, struct error *error)
{
    struct store_landing *rows = NULL;
    size_t all = 0;
    *count = 0;
    *runs = NULL;
    if (store_landings_get(store, &rows, &all, error) != MR_OK)
        return error->status;
    *runs = xcalloc(all + 1, sizeof **runs);
    for (size_t i = 0; i < all && error->status == MR_OK; i++) {
        struct store_series series = {0};
        bool is_void = false;
        if (store_is_void(store, rows[i].id, &is_void, NULL, error) == MR_OK && name)
            store_landing_series_get(store, &rows[i], &series, error);
        if (!is_void && (!name || strcmp(series.name, name) == 0))
            (*runs)[(*count)++] = rows[i].id;
    }
    free(rows);
    if (error->status == MR_OK && *count == 0 && name)
        error_set(error, MR_UNKNOWN,
                  "no landings in series '%s': %s; leave --series out for all landings, or begin a "
                  "series with matrig landing %s --series NAME",
                  name, store_path(store), store_path(store));
    else if (error->status == MR_OK && *count == 0)
        error_set(error, MR_TOO_FEW, "no landings to compare: %s; log a landing first",
                  store_path(store));
    return error->status;
}

static void pool_figures(struct compare_series *set, const struct compare_figures *figures)
{
    set->simulation_ms += figures->simulation_ms;
    set->worst_solver_error_in = fmax(set->worst_solver_error_in, figures->solver_error_in);
    for (size_t c = 0; c < figures->channel_count; c++) {
        const struct compare_channel *channel = &figures->channel[c];
        double n = (double)channel->figures.compared_sample_count;
        if (!channel->is_compared || channel->figures.compared_sample_count == 0)
            continue;
        set->channel_means[channel->number - 1].number = channel->number;
        set->channel_means[channel->number - 1].station_ft = channel->station_ft;
        set->channel_means[channel->number - 1].compared_landings++;
        set->channel_means[channel->number - 1].sample_count += n;
        set->channel_means[channel->number - 1].bias_in += n * channel->figures.bias;
        set->channel_means[channel->number - 1].rms_in += n * channel->figures.rms *
                                                          channel->figures.rms;
    }
}

/* Divides the sums over the series by the numbers of samples. */
static void compute_series_means(struct compare_series *set)
{
    double samples = 0.0, sum = 0.0, squares = 0.0;
    for (size_t c = 0; c < MR_TRANSDUCERS; c++) {
        double n = set->channel_means[c].sample_count;
        samples += n;
        sum += set->channel_means[c].bias_in;
        squares += set->channel_means[c].rms_in;
        set->channel_means[c].bias_in /= n;
        set->channel_means[c].rms_in = sqrt(set->channel_means[c].rms_in / n);
    }
    set->pooled.bias_in = sum / samples;
    set->pooled.rms_in = sqrt(squares / samples);
    set->pooled.within_limits_share = (double)NAN;
}

/* ---- the series ---- */

static enum mr_status compare_series_landing_run(struct store *store, struct compare_model *model,
                                                 struct compare_series *set, size_t index,
                                                 struct error *error)
{
    struct compare_landing landing;
    struct compare_series_landing *out = &set->landing[index];
    struct error why = {0};
    enum mr_status status = compare_run_landing(store, out->run, model, index, &landing, &why);
    if (status == MR_OK) {
        out->is_compared = true;
        set->compared_count++;
        out->figures = landing.figures;
        pool_figures(set, &out->figures);
    } else if (status == MR_TOO_FEW || status == MR_TRUNCATED || status == MR_NUMERICS) {
        snprintf(out->reason, sizeof out->reason, "%s", why.text);
    } else {
        error_set(error, status, "%s", why.text);
    }
    compare_landing_free(&landing);
    return error->status;
}

enum mr_status compare_series_run(struct store *store, const char *name,
                                  struct compare_model *model,
                                  void (*progress)(void *ctx, size_t done, size_t total), void *ctx,
                                  struct compare_series *set, struct error *error)
{
    int64_t *runs = NULL;
    memset(set, 0, sizeof *set);
    snprintf(set->model_file, sizeof set->model_file, "%s", model->name);
    snprintf(set->name, sizeof set->name, "%s", name ? name : "");
    if (select_runs(store, name, &runs, &set->landing_count, error) == MR_OK)
        set->landing = xcalloc(set->landing_count, sizeof *set->landing);
    for (size_t i = 0; i < set->landing_count && error->status == MR_OK; i++) {
        set->landing[i].run = runs[i];
        compare_series_landing_run(store, model, set, i, error);
        if (progress)
            progress(ctx, i + 1, set->landing_count);
    }
    if (error->status == MR_OK && set->compared_count == 0)
        error_set(error, MR_TOO_FEW, "no landing could be compared: %s: %s", store_path(store),
                  set->landing[0].reason);
    if (error->status == MR_OK)
        compute_series_means(set);
    free(runs);
    return error->status;
}

void compare_series_free(struct compare_series *set)
{
    free(set->landing);
    memset(set, 0, sizeof *set);
}
