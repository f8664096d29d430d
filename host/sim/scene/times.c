/* Times of a scene: when a run begins and ends, and its times counted from there. */
#include <math.h>
#include <stdlib.h>

#include "host/sim/scene/scene.h"

/* When the aircraft is at rest for good, or beyond the last mat. */
static double aircraft_gone_s(const struct sim_scene *scene)
{
    double runway_ft = scene->mats * scene->length_ft;
    if (scene->path_count == 0)
        return scene->vac_ft_s > 0.0 ? fmax(0.0, runway_ft - scene->s0_ft) / scene->vac_ft_s
                                     : HUGE_VAL;
    const struct sim_path_row *path = scene->path;
    size_t last = scene->path_count - 1;
    for (size_t i = 1; i <= last; i++) {
        if (path[i].x_ft >= runway_ft && path[i - 1].x_ft < runway_ft)
            return path[i - 1].t_s + (path[i].t_s - path[i - 1].t_s) *
                                         (runway_ft - path[i - 1].x_ft) /
                                         (path[i].x_ft - path[i - 1].x_ft);
    }
    while (last > 0 && path[last - 1].x_ft == path[last].x_ft)
        last--;
    return path[last].t_s;
}

double sim_scene_end_s(const struct sim_scene *scene)
{
    if (scene->t_end_s > 0.0)
        return scene->t_end_s;
    if (scene->t_dwell_s >= 0.0)
        return aircraft_gone_s(scene) + scene->t_dwell_s;
    if (scene->path_count > 0)
        return scene->path[scene->path_count - 1].t_s;
    return scene->vac_ft_s > 0.0 ? scene->mats_crossed * scene->length_ft / scene->vac_ft_s
                                 : HUGE_VAL;
}

/* Nothing moves before the aircraft comes. */
static bool rests(const struct sim_scene *scene)
{
    bool still = scene->v0_ft_s == 0.0 && scene->q1_lb == 0.0 && scene->ground_ft.count == 0 &&
                 !mods_any(scene);
    for (size_t i = 0; i < scene->bump_ft.count; i++)
        still = still && scene->bump_ft.values[i] == 0.0;
    for (size_t i = 0; i < scene->gap0_ft.count; i++)
        still = still && scene->gap0_ft.values[i] >= 0.0 &&
                scene->gap0_ft.values[i] <= scene->slack_ft;
    return still;
}

double sim_scene_start_s(const struct sim_scene *scene)
{
    double first_s = scene->path_count > 0 ? scene->path[0].t_s : 0.0;
    bool skips = first_s > SIM_CLOCK_S || rests(scene);
    return skips && sim_scene_end_s(scene) > first_s ? first_s : 0.0;
}

/* A large time has lost the end of the decimal number that was meant (1700000000.1 is 1.2e-7 off):
 * what is left of the difference is rounded to the last decimal place that such a time can have. */
static double since_s(double t_s, double start_s)
{
    double later_s = fmax(t_s, start_s),
           per_s = pow(10.0, -ceil(log10(nextafter(later_s, HUGE_VAL) - later_s)));
    return isfinite(t_s) ? round((t_s - start_s) * per_s) / per_s : t_s;
}

void sim_scene_from_start(struct sim_scene *counted, const struct sim_scene *scene)
{
    double start_s = sim_scene_start_s(scene);
    *counted = *scene;
    if (start_s == 0.0)
        return;
    counted->path = NULL;
    counted->t_out_s.values = NULL;
    sim_scene_set_path(counted, scene->path, scene->path_count);
    sim_scene_set_list(&counted->t_out_s, scene->t_out_s.values, scene->t_out_s.count);
    for (size_t i = 0; i < counted->path_count; i++)
        counted->path[i].t_s = since_s(counted->path[i].t_s, start_s);
    for (size_t i = 0; i < counted->t_out_s.count; i++)
        counted->t_out_s.values[i] = fmax(0.0, since_s(counted->t_out_s.values[i], start_s));
    counted->force_stop_s = since_s(scene->force_stop_s, start_s);
    if (scene->t_end_s > 0.0)
        counted->t_end_s = since_s(scene->t_end_s, start_s);
}

void sim_scene_from_start_free(struct sim_scene *counted, const struct sim_scene *scene)
{
    if (counted->path != scene->path) {
        free(counted->path);
        free(counted->t_out_s.values);
    }
}
