/* Times of a scene: start and end of a run, and times relative to its start. */
#include <math.h>
#include <stdlib.h>

#include "host/sim/scene/scene.h"

/* Returns the time from which the aircraft is at rest or beyond the last mat. */
static double aircraft_leave_time_s(const struct sim_scene *scene)
{
    double runway_ft = scene->mats * scene->length_ft;
    if (scene->path_count == 0)
        return scene->vac_ft_s > 0.0 ? fmax(0.0, runway_ft - scene->start_ft) / scene->vac_ft_s
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
        return aircraft_leave_time_s(scene) + scene->t_dwell_s;
    if (scene->path_count > 0)
        return scene->path[scene->path_count - 1].t_s;
    return scene->vac_ft_s > 0.0 ? scene->mats_crossed * scene->length_ft / scene->vac_ft_s
                                 : HUGE_VAL;
}

/* True if nothing moves before the aircraft arrives. */
static bool is_scene_at_rest(const struct sim_scene *scene)
{
    bool still = scene->v0_ft_s == 0.0 && scene->varied[SIM_VARIED_V0].count == 0 &&
                 scene->q1_lb == 0.0 && scene->ground_ft.count == 0 && !mods_are_present(scene);
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
    bool skips = first_s > SIM_CLOCK_S || is_scene_at_rest(scene);
    return skips && sim_scene_end_s(scene) > first_s ? first_s : 0.0;
}

/* Returns a time relative to the start, rounded to the last decimal place that the large time has:
 * a double does not represent a large decimal time exactly (1700000000.1 is off by 1.2e-7). */
static double time_from_start_s(double t_s, double start_s)
{
    double later_s = fmax(t_s, start_s),
           per_s = pow(10.0, -ceil(log10(nextafter(later_s, HUGE_VAL) - later_s)));
    return isfinite(t_s) ? round((t_s - start_s) * per_s) / per_s : t_s;
}

void sim_scene_shift_times(struct sim_scene *shifted, const struct sim_scene *scene)
{
    double start_s = sim_scene_start_s(scene);
    *shifted = *scene;
    if (start_s == 0.0)
        return;
    shifted->path = NULL;
    shifted->t_out_s.values = NULL;
    sim_scene_set_path(shifted, scene->path, scene->path_count);
    sim_scene_set_list(&shifted->t_out_s, scene->t_out_s.values, scene->t_out_s.count);
    for (size_t i = 0; i < shifted->path_count; i++)
        shifted->path[i].t_s = time_from_start_s(shifted->path[i].t_s, start_s);
    for (size_t i = 0; i < shifted->t_out_s.count; i++)
        shifted->t_out_s.values[i] = fmax(0.0,
                                          time_from_start_s(shifted->t_out_s.values[i], start_s));
    shifted->force_stop_s = time_from_start_s(scene->force_stop_s, start_s);
    if (scene->t_end_s > 0.0)
        shifted->t_end_s = time_from_start_s(scene->t_end_s, start_s);
}

void sim_scene_shift_times_free(struct sim_scene *shifted, const struct sim_scene *scene)
{
    if (shifted->path != scene->path) {
        free(shifted->path);
        free(shifted->t_out_s.values);
    }
}

/* A time interval in which the thrust exceeds the limit of friction. */
struct pulse {
    bool is_active;
    double from_s, impulse_lb_s;
};

#define PULSE_MOVEMENT_MIN 1e-7 /* smallest movement / mat length that counts */

static void finish_pulse(struct pulse *pulse, const struct sim_scene *scene, double at_s,
                         double *shortest_s)
{
    double length_s = fmin(at_s, scene->force_stop_s) - pulse->from_s,
           speed_ft_s = pulse->impulse_lb_s * scene->g_ft_s2 / scene->weight_lb,
           reach_ft = speed_ft_s *
                      (length_s + 0.5 * speed_ft_s / (scene->friction * scene->g_ft_s2));
    if (pulse->is_active && length_s > 0.0 && reach_ft > PULSE_MOVEMENT_MIN * scene->length_ft)
        *shortest_s = fmin(*shortest_s, length_s);
    *pulse = (struct pulse){0};
}

/* Extends the pulse by one row of the path, in which the thrust minus the limit changes from a_lb
 * to b_lb. */
static void update_pulse(struct pulse *pulse, const struct sim_scene *scene,
                         const struct sim_path_row *row, double a_lb, double b_lb,
                         double *shortest_s)
{
    double length_s = row[1].t_s - row[0].t_s,
           zero_s = row[0].t_s + (a_lb * b_lb < 0.0 ? length_s * a_lb / (a_lb - b_lb) : 0.0);
    if (!(length_s > 0.0))
        return;
    if (pulse->is_active && !(a_lb > 0.0))
        finish_pulse(pulse, scene, row[0].t_s, shortest_s);
    if (!pulse->is_active && (a_lb > 0.0 || b_lb > 0.0))
        *pulse = (struct pulse){.is_active = true, .from_s = a_lb > 0.0 ? row[0].t_s : zero_s};
    pulse->impulse_lb_s += 0.5 * length_s * (fmax(a_lb, 0.0) + fmax(b_lb, 0.0));
    if (pulse->is_active && !(b_lb > 0.0))
        finish_pulse(pulse, scene, a_lb * b_lb < 0.0 ? zero_s : row[1].t_s, shortest_s);
}

double sim_scene_shortest_time_s(const struct sim_scene *scene)
{
    double hold_lb = scene->friction * (scene->weight_lb + scene->wheel_load_lb),
           shortest_s = HUGE_VAL, end_s = sim_scene_end_s(scene);
    const struct sim_path_row steady[] = {{0.0, 0.0, scene->force_lb},
                                          {end_s, 0.0, scene->force_lb}};
    const struct sim_path_row *rows = scene->path_count > 0 ? scene->path : steady;
    size_t count = scene->path_count > 0 ? scene->path_count : 2;
    if (!(hold_lb > 0.0) || scene->friction_law == SIM_FRICTION_NONE)
        return HUGE_VAL;
    if (scene->v0_ft_s != 0.0)
        shortest_s = fabs(scene->v0_ft_s) / (scene->friction * scene->g_ft_s2);
    for (double way = -1.0; way < 2.0; way += 2.0) {
        struct pulse pulse = {0};
        for (size_t i = 0; i + 1 < count; i++)
            update_pulse(&pulse, scene, rows + i, way * rows[i].force_lb - hold_lb,
                         way * rows[i + 1].force_lb - hold_lb, &shortest_s);
        finish_pulse(&pulse, scene, rows[count - 1].t_s, &shortest_s);
    }
    return shortest_s;
}
