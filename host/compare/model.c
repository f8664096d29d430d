#include "host/compare/model.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/wire.h"
#include "host/base/xmalloc.h"
#include "host/landing_series/play.h"
#include "host/base/progress.h"

#define IN_PER_FT     12.0
#define SLOPE_S       0.005 /* half the span over which deceleration is taken from speed */
#define DWELL_LEAST_S 0.5
#define PATH_MOST_S   3600.0 /* no landing is longer */

static double deceleration_at(const struct measured *measured, double t_s, double stop_s)
{
    double from_s = fmax(0.0, t_s - SLOPE_S);
    double to_s = fmin(stop_s, t_s + SLOPE_S);
    double error_ft_s;
    double from_ft_s = measured_speed_ft_s(measured, from_s, &error_ft_s);
    /* At the stop the speed is 0 from both sides. */
    double to_ft_s = to_s < stop_s ? measured_speed_ft_s(measured, to_s, &error_ft_s) : 0.0;
    return fmax(0.0, (from_ft_s - to_ft_s) / (to_s - from_s));
}

static enum mr_status set_path(const struct measured *measured, struct sim_scene *scene,
                               struct error *error)
{
    double stop_s = measured->summary.stop_t_s.value;
    double last_s = stop_s - 0.001; /* the thrust ends with the motion, within a millisecond */
    if (!(last_s > 0.0 && last_s < PATH_MOST_S))
        return error_set(error, MR_TOO_FEW,
                         "stops %g s after touchdown: RUN %lld; check its switches", stop_s,
                         (long long)measured->landing.id);
    size_t steps = (size_t)ceil(last_s / COMPARE_PATH_STEP_S);
    struct sim_path_row *rows = xcalloc(steps + 2, sizeof *rows);
    for (size_t i = 0; i <= steps; i++) {
        double t_s = i < steps ? (double)i * COMPARE_PATH_STEP_S : last_s;
        double thrust_lb = COMPARE_AIRCRAFT_LB / COMPARE_STRIPS *
                           deceleration_at(measured, t_s, stop_s) / scene->g_ft_s2;
        rows[i] = (struct sim_path_row){t_s, measured_station_ft(measured, t_s), thrust_lb};
    }
    rows[steps + 1] = (struct sim_path_row){stop_s, measured->summary.stop_station_ft.value, 0.0};
    sim_scene_set_path(scene, rows, steps + 2);
    free(rows);
    return MR_OK;
}

/* Each joint of a surveyed segment gets its share of the slack; the others keep the scene's. */
static void set_gaps(const struct zones_closure *survey, struct sim_scene *scene)
{
    size_t count = (size_t)scene->mats + 1;
    double *gap_ft = xcalloc(count, sizeof *gap_ft);
    for (size_t j = 0; j < count; j++) {
        double station_ft = (double)j * scene->length_ft;
        /* A joint belongs to the segment it lies in or begins; half a mat keeps rounding out of
         * it. */
        size_t segment =
            (size_t)((station_ft + 0.5 * scene->length_ft) / (double)MR_SEGMENT_LENGTH_FT);
        gap_ft[j] = sim_scene_joint(&scene->gap0_ft, (int)j + 1);
        if (segment < MR_SEGMENTS && !isnan(survey->slack_in[segment]))
            gap_ft[j] = (double)survey->slack_in[segment] / MR_MATS_PER_SEGMENT / IN_PER_FT;
    }
    sim_scene_set_list(&scene->gap0_ft, gap_ft, count);
    free(gap_ft);
}

enum mr_status compare_scene(const struct measured *measured, const struct zones_closure *survey,
                             struct sim_scene *scene, struct error *error)
{
    if (measured->fit_status == MR_TRUNCATED) {
        char reason[MEASURED_REASON];
        measured_no_stop_text(measured, reason);
        return error_set(error, MR_TRUNCATED,
                         "%s: RUN %lld; complete it from the black box, or compare another landing",
                         reason, (long long)measured->landing.id);
    }
    if (measured->fit_status != MR_OK)
        return error_set(
            error, MR_TOO_FEW,
            "the motion of the gear is not known (%s): RUN %lld; a comparison needs at least 3 "
            "switches and a stop",
            mr_status_text(measured->fit_status), (long long)measured->landing.id);
    double end_s = measured_time_s(measured, measured->samples - 1);
    snprintf(scene->name, sizeof scene->name, "RUN %lld", (long long)measured->landing.id);
    scene->t_end_s = 0.0;
    scene->t_dwell_s = fmax(DWELL_LEAST_S, end_s - measured->summary.stop_t_s.value);
    set_gaps(survey, scene);
    return set_path(measured, scene, error);
}

enum mr_status compare_scale(const struct sim_scene *scene, const char *where, struct error *error)
{
    const double rig_ft = MR_SEGMENTS * (double)MR_SEGMENT_LENGTH_FT;
    double runway_ft = scene->mats * scene->length_ft;
    if (fabs(scene->length_ft - (double)MR_MAT_LENGTH_FT) < 1e-3 * scene->length_ft &&
        fabs(runway_ft - rig_ft) < 1e-3 * runway_ft)
        return MR_OK;
    return error_set(error, MR_USAGE,
                     "another scale: %s has %d mats of %.4g ft, a runway of %.4g ft; the rig has "
                     "%.0f of %.4g ft, %.4g ft; "
                     "matrig scale FILE --to model makes one from the prototype's",
                     where, scene->mats, scene->length_ft, runway_ft,
                     rig_ft / (double)MR_MAT_LENGTH_FT, (double)MR_MAT_LENGTH_FT, rig_ft);
}

#define IN_PER_FT 12.0
#define POINTS    (SURVEY_POINTS - 1u) /* gage points downfield of the edge, which does not move */

/* A campaign has landings. MR_OK also where it is no JSON: the scene's reader says what is wrong
 * with it. */
static bool is_campaign(const char *path)
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
    model->seeds = 1;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        model->survey_in[s] = MR_NAN;
    const struct sim_scene *scene = &model->scene;
    if (is_campaign(path)) {
        if (series_load(&model->series, path, error) != MR_OK)
            return error->status;
        model->ensemble = true;
        model->seeds = seeds ? seeds : model->series.seeds;
        scene = &model->series.landings[0].scene;
    } else if (seeds > 1) {
        return error_set(error, MR_USAGE,
                         "no ensemble: %s is a scene, one runway; give a study file for --seeds",
                         path);
    } else if (sim_scene_load(&model->scene, path, error) != MR_OK) {
        return error->status;
    }
    if (compare_scale(scene, path, error) != MR_OK)
        compare_model_free(model);
    else
        model->joints = (size_t)scene->mats + 1;
    return error->status;
}

void compare_model_free(struct compare_model *model)
{
    if (model->ensemble)
        series_free(&model->series);
    else
        sim_scene_free(&model->scene);
    free(model->gap_ft);
    *model = (struct compare_model){.ensemble = false};
}

/* Openings and resistances as the runways were laid: the same draws as the series'
 * (host/landing_series/play.c). */
static void lay(struct compare_model *model)
{
    size_t all = model->seeds * model->joints;
    model->gap_ft = xcalloc(2 * all, sizeof *model->gap_ft);
    model->closing_lb = model->gap_ft + all;
    for (size_t seed = 0; seed < model->seeds; seed++) {
        const struct landing_series *c = &model->series;
        double *gap_ft = model->gap_ft + seed * model->joints,
               *closing_lb = model->closing_lb + seed * model->joints;
        struct draw gaps = draw_from(c->first_seed + seed, DRAW_GAPS),
                    closing = draw_from(c->first_seed + seed, DRAW_CLOSING);
        for (size_t j = 0; j < model->joints; j++) {
            gap_ft[j] = model->ensemble ? fmin(draw_between(&gaps, c->gap_in) / IN_PER_FT,
                                               c->landings[0].scene.slack_ft)
                                        : sim_scene_joint(&model->scene.gap0_ft, (int)j + 1);
            closing_lb[j] = model->ensemble ? draw_between(&closing, c->closing_lb)
                                            : sim_scene_joint(&model->scene.grit_lb, (int)j + 1);
        }
    }
}

/* Brings openings to a sum, as far as it goes: less by scaling them, more by scaling what is left
 * to the most that a joint can be open. */
static void scale_to(double *gap_ft, size_t count, double sum_ft, double most_ft)
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

static bool surveyed_anew(const struct compare_model *model, const struct zones_closure *survey)
{
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(survey->slack_in[s]) &&
            !(fabsf(survey->slack_in[s] - model->survey_in[s]) < 1e-6f))
            return true;
    }
    return false;
}

static void take_survey(struct compare_model *model, const struct zones_closure *survey)
{
    if (!surveyed_anew(model, survey))
        return;
    for (size_t seed = 0; seed < model->seeds; seed++) {
        for (size_t s = 0; s < MR_SEGMENTS; s++) {
            double *gap_ft = model->gap_ft + seed * model->joints + s * MR_MATS_PER_SEGMENT;
            double sum_ft = (double)survey->slack_in[s] / IN_PER_FT;
            if (isnan(sum_ft))
                continue;
            if (model->ensemble)
                scale_to(gap_ft, MR_MATS_PER_SEGMENT, sum_ft,
                         model->series.landings[0].scene.slack_ft);
            for (size_t j = 0; j < MR_MATS_PER_SEGMENT && !model->ensemble; j++)
                gap_ft[j] = sum_ft / MR_MATS_PER_SEGMENT;
        }
    }
    memcpy(model->survey_in, survey->slack_in, sizeof model->survey_in);
}

/* Everything of the landing that all seeds have in common. The scene owns its path, gaps and
 * resistances. */
static enum mr_status make_scene(const struct compare_model *model, size_t index,
                                 const struct measured *measured, struct sim_scene *scene,
                                 struct error *error)
{
    const struct landing_series *c = &model->series;
    struct zones_closure none;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        none.slack_in[s] = MR_NAN;
    none.surveyed = 0;
    if (model->ensemble && index >= c->landing_count)
        return error_set(error, MR_USAGE,
                         "no such landing: %s has %zu, this is the %zu. of the series; add it "
                         "there, or name the series",
                         model->name, c->landing_count, index + 1);
    *scene = model->ensemble ? c->landings[index].scene : model->scene;
    scene->gap0_ft = scene->grit_lb = scene->ground_ft = (struct sim_list){0};
    struct sim_path_row *path = scene->path;
    size_t rows = scene->path_count;
    scene->path = NULL;
    scene->path_count = 0;
    if (model->as_is && !path)
        return error_set(error, MR_USAGE,
                         "no motion: %s has no path; give it one, or leave --as-is out",
                         model->name);
    if (model->as_is) {
        sim_scene_set_path(scene, path, rows);
        return MR_OK;
    }
    if (model->ensemble)
        scene->model = SIM_CHAIN;
    enum mr_status status = compare_scene(measured, &none, scene, error);
    double share = c->weight_lb / c->axles * COMPARE_STRIPS / COMPARE_AIRCRAFT_LB;
    for (size_t i = 0; model->ensemble && i < scene->path_count; i++)
        scene->path[i].force_lb *= share;
    return status;
}

static void make_room(struct compare_simulated *s, const struct sim_result *result)
{
    if (s->mean_in)
        return;
    s->rows = result->sample_count;
    s->dt_s = result->sample_dt_s;
    s->segment_rows = (size_t)floor((double)(s->rows - 1) * s->dt_s / COMPARE_SEGMENTS_S) + 1;
    s->mean_in = xcalloc(2 * s->rows * s->stations, sizeof *s->mean_in);
    s->remaining_in = xcalloc(s->segment_rows * MR_SEGMENTS, sizeof *s->remaining_in);
    s->spread_in = s->mean_in + s->rows * s->stations;
}

/* Mean and sum of squared deviations of one value more (Welford 1962). */
static void accumulate(double *mean, double *squares, double value, size_t count)
{
    double step = value - *mean;
    *mean += step / (double)count;
    *squares += step * (value - *mean);
}

/* Gage point p (1..42) is on mat 10 p, whose column follows the stations'. */
static double point_in(const struct sim_result *result, size_t row, size_t stations, size_t p)
{
    return p == 0 ? 0.0
                  : IN_PER_FT * result->sample_u_ft[row * result->station_count + stations + p - 1];
}

static void add_seed(struct compare_simulated *s, const struct sim_result *result,
                     const double *gap_ft, size_t count)
{
    size_t rows = s->rows < result->sample_count ? s->rows : result->sample_count;
    for (size_t row = 0; row < rows; row++) {
        for (size_t k = 0; k < s->stations; k++)
            accumulate(&s->mean_in[row * s->stations + k], &s->spread_in[row * s->stations + k],
                       IN_PER_FT * result->sample_u_ft[row * result->station_count + k], count);
    }
    for (size_t i = 0; i < s->segment_rows; i++) {
        size_t row = (size_t)lround((double)i * COMPARE_SEGMENTS_S / s->dt_s);
        for (size_t segment = 0; segment < MR_SEGMENTS && row < rows; segment++) {
            double left_in = point_in(result, row, s->stations, segment + 1) -
                             point_in(result, row, s->stations, segment);
            for (size_t j = 0; j < MR_MATS_PER_SEGMENT; j++)
                left_in += IN_PER_FT * gap_ft[segment * MR_MATS_PER_SEGMENT + j];
            float *mean = &s->remaining_in[i * MR_SEGMENTS + segment];
            *mean += ((float)left_in - *mean) / (float)count;
        }
    }
    for (size_t p = 0; p < SURVEY_POINTS; p++)
        accumulate(&s->moved_in[p], &s->moved_spread_in[p],
                   point_in(result, rows - 1, s->stations, p), count);
}

/* From sums of squared deviations to standard deviations. */
static void finish_spread(double *squares, size_t count, size_t seeds)
{
    for (size_t i = 0; i < count; i++)
        squares[i] = seeds > 1 ? sqrt(squares[i] / (double)(seeds - 1)) : 0.0;
}

static enum mr_status play_seed(struct compare_model *model, size_t seed, const double *station_ft,
                                size_t columns, struct compare_simulated *s, struct error *error)
{
    double *gap_ft = model->gap_ft + seed * model->joints;
    /* The first one is checked by a second pass, which gives the error; the spread of the others is
     * far larger than theirs. */
    struct sim_options options = {.sample_dt_s = COMPARE_SAMPLE_S,
                                  .station_ft = station_ft,
                                  .station_count = columns,
                                  .single = seed > 0};
    struct progress progress;
    struct sim_result result = {0};
    options.go_on = sim_progress;
    options.go_on_ctx = &progress;
    progress_begin(&progress, "compare", "an earlier tend or fewer mats", false);
    sim_scene_set_list(&s->scene.gap0_ft, gap_ft, model->joints);
    sim_scene_set_list(&s->scene.grit_lb, model->closing_lb + seed * model->joints, model->joints);
    enum mr_status status = sim_run(&s->scene, &options, &result, error);
    progress_end(&progress);
    if (status == MR_OK) {
        make_room(s, &result);
        if (seed == 0) {
            s->solver = result.solver;
            s->solver_dt_s = result.dt_s;
            s->error_in = IN_PER_FT * result.error_u_ft;
        }
        s->run_ms += result.run_ms;
        s->seeds = seed + 1;
        add_seed(s, &result, gap_ft, seed + 1);
        for (size_t j = 0; j < model->joints; j++)
            gap_ft[j] += (j + 1 < model->joints ? result.u_ft[j + 1] : 0.0) -
                         (j > 0 ? result.u_ft[j] : 0.0);
    }
    sim_result_free(&result);
    return error->status;
}

enum mr_status compare_simulate(struct compare_model *model, size_t index,
                                const struct measured *measured, const struct zones_closure *survey,
                                const double *station_ft, size_t stations,
                                struct compare_simulated *s, struct error *error)
{
    memset(s, 0, sizeof *s);
    s->stations = stations;
    if (make_scene(model, index, measured, &s->scene, error) != MR_OK)
        return error->status;
    if (!model->gap_ft)
        lay(model);
    if (!model->as_is)
        take_survey(model, survey);
    double *columns = xcalloc(stations + POINTS, sizeof *columns);
    memcpy(columns, station_ft, stations * sizeof *columns);
    for (size_t p = 1; p <= POINTS; p++)
        columns[stations + p - 1] = ((double)(p * MR_MATS_PER_SEGMENT) - 1.0) * s->scene.length_ft;
    for (size_t seed = 0; seed < model->seeds && error->status == MR_OK; seed++)
        play_seed(model, seed, columns, stations + POINTS, s, error);
    free(columns);
    if (error->status == MR_OK) {
        finish_spread(s->spread_in, s->rows * s->stations, s->seeds);
        finish_spread(s->moved_spread_in, SURVEY_POINTS, s->seeds);
    }
    return error->status;
}

void compare_simulated_free(struct compare_simulated *s)
{
    free(s->scene.gap0_ft.values);
    free(s->scene.grit_lb.values);
    free(s->scene.path); /* everything else is the model's */
    free(s->mean_in);
    free(s->remaining_in);
    memset(s, 0, sizeof *s);
}

char *compare_describe(const struct compare_model *model, const struct compare_simulated *s)
{
    const struct sim_scene *scene = &s->scene;
    json_t *path = json_array(), *gaps = json_array();
    for (size_t i = 0; i < scene->path_count; i++)
        json_array_append_new(path, json_pack("[fff]", scene->path[i].t_s, scene->path[i].x_ft,
                                              scene->path[i].force_lb));
    for (size_t i = 0; i < scene->gap0_ft.count; i++)
        json_array_append_new(gaps, json_real(scene->gap0_ft.values[i]));
    json_t *root = json_pack("{sssssIsisfsfsfsfsfsfsososssfsf}", "file", model->name, "model",
                             sim_model_name(scene->model), "seeds", (json_int_t)s->seeds, "N",
                             scene->mats, "L", scene->length_ft, "W", scene->weight_lb, "KL",
                             scene->kl_lb_ft, "CL", scene->cl_lb_s_ft, "f", scene->friction,
                             "slack", scene->slack_ft, "path", path, "gap0", gaps, "solver",
                             s->solver, "dt_s", s->solver_dt_s, "t_dwell", scene->t_dwell_s);
    char *text = json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(9));
    json_decref(root);
    return text;
}
