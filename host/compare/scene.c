#include "host/compare/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

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
    struct sim_path_row *rows = calloc(steps + 2, sizeof *rows);
    if (!rows)
        return error_set(error, MR_FULL, "no memory: path of RUN %lld; close other programs",
                         (long long)measured->landing.id);
    for (size_t i = 0; i <= steps; i++) {
        double t_s = i < steps ? (double)i * COMPARE_PATH_STEP_S : last_s;
        double thrust_lb = COMPARE_AIRCRAFT_LB / COMPARE_STRIPS *
                           deceleration_at(measured, t_s, stop_s) / scene->g_ft_s2;
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
        return error_set(error, MR_FULL, "no memory: gaps of %zu joints; close other programs",
                         count);
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
    enum mr_status status = sim_scene_set_list(&scene->gap0_ft, gap_ft, count, error);
    free(gap_ft);
    return status;
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
    enum mr_status status = set_path(measured, scene, error);
    return status == MR_OK ? set_gaps(survey, scene, error) : status;
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
