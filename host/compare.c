#include "host/compare.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define IN_PER_FT 12.0
#define SLOPE_S 0.005 /* half the span over which deceleration is taken from speed */
#define DWELL_LEAST_S 0.5

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

static enum mr_status set_path(const struct measured *measured, struct sim_scene *scene, struct error *error)
{
    double stop_s = measured->summary.stop_t_s.value;
    double last_s = stop_s - 0.001; /* the thrust ends with the motion, within a millisecond */
    size_t steps = (size_t)ceil(last_s / COMPARE_PATH_STEP_S);
    struct sim_path_row *rows = calloc(steps + 2, sizeof *rows);
    if (!rows)
        return error_set(error, MR_FULL, "no memory: path of RUN %lld; close other programs",
                         (long long)measured->landing.id);
    for (size_t i = 0; i <= steps; i++) {
        double t_s = i < steps ? (double)i * COMPARE_PATH_STEP_S : last_s;
        double thrust_lb =
            COMPARE_AIRCRAFT_LB / COMPARE_STRIPS * deceleration_at(measured, t_s, stop_s) / scene->g_ft_s2;
        rows[i] = (struct sim_path_row){t_s, measured_station_ft(measured, t_s), thrust_lb};
    }
    rows[steps + 1] = (struct sim_path_row){stop_s, measured->summary.stop_station_ft.value, 0.0};
    enum mr_status status = sim_scene_set_path(scene, rows, steps + 2, error);
    free(rows);
    return status;
}

/* Each joint of a surveyed segment gets its share of the slack; the others keep the scene's. */
static enum mr_status set_gaps(const struct zones_closure *survey, struct sim_scene *scene,
                               struct error *error)
{
    size_t count = (size_t)scene->mats + 1;
    double *gap_ft = calloc(count, sizeof *gap_ft);
    if (!gap_ft)
        return error_set(error, MR_FULL, "no memory: gaps of %zu joints; close other programs", count);
    for (size_t j = 0; j < count; j++) {
        double station_ft = (double)j * scene->length_ft;
        /* A joint belongs to the segment it lies in or begins; half a mat keeps rounding out of it. */
        size_t segment = (size_t)((station_ft + 0.5 * scene->length_ft) / (double)MR_SEGMENT_LENGTH_FT);
        gap_ft[j] = sim_scene_joint(&scene->gap0_ft, (int)j + 1);
        if (segment < MR_SEGMENTS && !isnan(survey->slack_in[segment]))
            gap_ft[j] = (double)survey->slack_in[segment] / MR_MATS_PER_SEGMENT / IN_PER_FT;
    }
    enum mr_status status = sim_scene_set_list(&scene->gap0_ft, gap_ft, count, error);
    free(gap_ft);
    return status;
}

enum mr_status compare_scene(const struct measured *measured, const struct zones_closure *survey,
                             struct sim_scene *scene, struct error *error)
{
    if (measured->fit_status == MR_TRUNCATED)
        return error_set(error, MR_TRUNCATED,
                         "the record ends while the gear moves: RUN %lld; compare a landing that was logged to its end",
                         (long long)measured->landing.id);
    if (measured->fit_status != MR_OK)
        return error_set(error, MR_TOO_FEW,
                         "the motion of the gear is not known (%s): RUN %lld; a comparison needs at least 3 "
                         "switches and a stop",
                         mr_status_text(measured->fit_status), (long long)measured->landing.id);
    double end_s = measured_time_s(measured, measured->samples - 1);
    snprintf(scene->name, sizeof scene->name, "RUN %lld", (long long)measured->landing.id);
    scene->t_end_s = 0.0;
    scene->t_dwell_s = fmax(DWELL_LEAST_S, end_s - measured->summary.stop_t_s.value);
    enum mr_status status = set_path(measured, scene, error);
    return status == MR_OK ? set_gaps(survey, scene, error) : status;
}

/* Simulated movement of column `s` at a time, inches; linear between samples. */
static double simulated_in(const struct sim_result *result, size_t s, double t_s)
{
    double k = t_s / result->sample_dt_s;
    size_t row = (size_t)k;
    if (row + 1 >= result->sample_count)
        return IN_PER_FT * result->sample_u_ft[(result->sample_count - 1) * result->station_count + s];
    double from = result->sample_u_ft[row * result->station_count + s];
    double to = result->sample_u_ft[(row + 1) * result->station_count + s];
    return IN_PER_FT * (from + (k - (double)row) * (to - from));
}

static enum mr_status compare_channel(const struct measured *measured, const struct measured_channel *channel,
                                      const struct sim_result *result, size_t s, struct store_simulation *row,
                                      struct error *error)
{
    double end_s = (double)(result->sample_count - 1) * result->sample_dt_s;
    double squares = 0.0;
    size_t compared = 0;
    *row = (struct store_simulation){
        .number = channel->config.number,
        .station_ft = (double)channel->config.station_ft,
        .peak_measured_in = channel->peak,
        .peak_measured_error_in = channel->error,
        .peak_simulated_error_in = IN_PER_FT * result->error_u_ft,
        .end_measured_in = channel->end,
        .end_simulated_in = simulated_in(result, s, end_s),
        .rms_in = (double)NAN,
        .dt_s = result->sample_dt_s,
        .length = result->sample_count,
    };
    row->series_in = malloc(result->sample_count * sizeof *row->series_in);
    if (!row->series_in)
        return error_set(error, MR_FULL, "no memory: series of transducer %u; close other programs",
                         channel->config.number);
    for (size_t k = 0; k < result->sample_count; k++) {
        double u_in = IN_PER_FT * result->sample_u_ft[k * result->station_count + s];
        row->series_in[k] = (float)u_in;
        if (fabs(u_in) > fabs(row->peak_simulated_in))
            row->peak_simulated_in = u_in;
    }
    for (size_t i = 0; i < measured->samples; i++) {
        double t_s = measured_time_s(measured, i);
        double value_in = measured_value(channel, i);
        if (t_s < 0.0 || t_s > end_s || isnan(value_in))
            continue;
        double difference_in = value_in - simulated_in(result, s, t_s);
        squares += difference_in * difference_in;
        compared++;
    }
    if (compared)
        row->rms_in = sqrt(squares / (double)compared);
    return MR_OK;
}

/* What was simulated, so that a report can be checked later: parameters that matter, path and gaps as used.
 */
static char *describe(const struct sim_scene *scene, const struct sim_result *result)
{
    json_t *path = json_array();
    for (size_t i = 0; i < scene->path_count; i++)
        json_array_append_new(
            path, json_pack("[fff]", scene->path[i].t_s, scene->path[i].x_ft, scene->path[i].force_lb));
    json_t *gaps = json_array();
    for (size_t i = 0; i < scene->gap0_ft.count; i++)
        json_array_append_new(gaps, json_real(scene->gap0_ft.values[i]));
    json_t *root =
        json_pack("{sssisfsfsfsfsfsfsososssfsf}", "model", sim_model_name(scene->model), "N", scene->mats,
                  "L", scene->length_ft, "W", scene->weight_lb, "KL", scene->kl_lb_ft, "CL",
                  scene->cl_lb_s_ft, "f", scene->friction, "slack", scene->slack_ft, "path", path, "gap0",
                  gaps, "solver", result->solver, "dt_s", result->dt_s, "t_dwell", scene->t_dwell_s);
    char *text = root ? json_dumps(root, JSON_COMPACT | JSON_REAL_PRECISION(9)) : NULL;
    json_decref(root);
    return text;
}

enum mr_status compare_run(const struct measured *measured, const struct sim_scene *scene,
                           struct comparison *comparison, struct error *error)
{
    const struct measured_channel *channels[MR_TRANSDUCERS];
    double station_ft[MR_TRANSDUCERS];
    size_t count = 0;
    memset(comparison, 0, sizeof *comparison);
    for (unsigned c = 0; c < MR_TRANSDUCERS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_DISPLACEMENT || !channel->raw)
            continue;
        channels[count] = channel;
        station_ft[count++] = (double)channel->config.station_ft;
    }
    if (count == 0)
        return error_set(error, MR_TOO_FEW, "no displacements: RUN %lld; nothing to compare with",
                         (long long)measured->landing.id);

    struct sim_options options = {
        .sample_dt_s = COMPARE_SAMPLE_S, .station_ft = station_ft, .station_count = count};
    struct sim_result result;
    enum mr_status status = sim_run(scene, &options, &result, error);
    for (size_t s = 0; s < count && status == MR_OK; s++) {
        status = compare_channel(measured, channels[s], &result, s, &comparison->row[s], error);
        comparison->count = s + 1;
    }
    if (status == MR_OK) {
        comparison->run_ms = result.run_ms;
        comparison->error_in = IN_PER_FT * result.error_u_ft;
        comparison->scene_json = describe(scene, &result);
        if (!comparison->scene_json)
            status = error_set(error, MR_FULL, "no memory: scene of RUN %lld; close other programs",
                               (long long)measured->landing.id);
    }
    sim_result_free(&result);
    return status;
}

void compare_free(struct comparison *comparison)
{
    for (size_t i = 0; i < comparison->count; i++)
        free(comparison->row[i].series_in);
    free(comparison->scene_json);
}
