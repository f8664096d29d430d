#include "host/sim/scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
static void mods_defaults(struct sim_mods *mods);

void sim_scene_defaults(struct sim_scene *scene)
{
    *scene = (struct sim_scene){
        .mats = 53,
        .length_ft = 2.0,
        .weight_lb = 160.0,
        .g_ft_s2 = 32.174,
        .inertia_slug_ft2 = 2.0,
        .kv_lb_ft = 1e7,
        .cv_lb_s_ft = 2e4,
        .kl_lb_ft = 8e6,
        .cl_lb_s_ft = 50.0,
        .kt_lb_ft_rad = 1e5,
        .ct_lb_ft_s_rad = 1.0,
        .tad_deg = 10.0,
        .left = SIM_FREE,
        .right = SIM_FIXED,
        .force_lb = 12000.0,
        .vac_ft_s = 90.0,
        .force_stop_s = (double)INFINITY,
        .friction = 0.5,
        .veps_ft_s = 1e-3,
        .shear_lb = 120.0,
        .bump_first = 5,
        .v0_ft_s = 2.0,
        .mats_crossed = 3.0,
        .t_dwell_s = -1.0,
        .gear = {.damping = 0.5, .unloading = 1.0, .axle_law = 1.0},
    };
    mods_defaults(&scene->mods);
}

void sim_scene_free(struct sim_scene *scene)
{
    free(scene->bump_ft.values);
    free(scene->t_out_s.values);
    free(scene->u_mats.values);
    free(scene->gap0_ft.values);
    free(scene->grit_lb.values);
    free(scene->ground_ft.values);
    free(scene->gear.lines_ft.values);
    free(scene->gear.axles.values);
    free(scene->path);
    mods_free_lists(&scene->mods);
    sim_scene_defaults(scene);
}

static void copy_array(void *to, const void *from, size_t count, size_t size)
{
    void **array = to, *copy = NULL;
    if (count > 0) {
        copy = xcalloc(count, size);
        memcpy(copy, from, count * size);
    }
    free(*array);
    *array = copy;
}

void sim_scene_set_list(struct sim_list *list, const double *values, size_t count)
{
    copy_array(&list->values, values, count, sizeof *values);
    list->count = count;
}

void sim_scene_set_path(struct sim_scene *scene, const struct sim_path_row *rows, size_t count)
{
    copy_array(&scene->path, rows, count, sizeof *rows);
    scene->path_count = count;
}

double sim_scene_joint(const struct sim_list *list, int joint)
{
    if (list->count == 0)
        return 0.0;
    return list->values[list->count == 1 ? 0 : (size_t)(joint - 1)];
}

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

/* Defaults with a source: the model's bands of 5.1.2.1 (3/8 x 0.020 in, steel), the wheel's static
 * deflection of 2.6 (0.050 in over a mat of 24/7 in), cleats of 5.5 (3/4 in), AM2's thickness
 * (1.5 in). */
static void mods_defaults(struct sim_mods *mods)
{
    *mods = (struct sim_mods){
        .cleat_travel_ft = (double)INFINITY,
        .cleat_depth_ft = 0.75 / 12.0,
        .stiff_free = 1,
        .stiff_lines = 1,
        .stiff_first = 1,
        .stiff_grip_lb = (double)INFINITY,
        .stiff_yield_lb_ft = (double)INFINITY,
        .tear_lb = (double)INFINITY,
        .unhinge_deg = (double)INFINITY,
        .unhinge_lap_ft = 1.5 / 12.0,
    };
    for (int g = 0; g < SIM_BAND_GROUPS; g++)
        mods->band[g] = (struct sim_bands){
            .area_ft2 = 0.375 * 0.020 / 144.0,
            .e_lb_ft2 = 29e6 * 144.0,
            .every = 20,
            .k_lb_ft = (double)INFINITY,
            .grip_lb = (double)INFINITY,
            .pull_lb = (double)INFINITY,
            .wear_ft = (double)INFINITY,
            .tilt_rad = 0.050 / (24.0 / 7.0),
            .alpha_f = 6.5e-6,
        };
}

void mods_lists(struct sim_mods *m, struct sim_list *lists[MODS_LISTS])
{
    size_t count = 0;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        lists[count++] = &m->band[g].t0_lb;
        lists[count++] = &m->band[g].slipped_ft;
        lists[count++] = &m->band[g].pulled;
    }
    lists[count++] = &m->cleat_left;
    lists[count++] = &m->stiff_gap0_ft;
    lists[count++] = &m->torn;
}

void mods_free_lists(struct sim_mods *mods)
{
    struct sim_list *lists[MODS_LISTS];
    mods_lists(mods, lists);
    for (size_t i = 0; i < MODS_LISTS; i++) {
        free(lists[i]->values);
        *lists[i] = (struct sim_list){0};
    }
}

bool mods_any(const struct sim_scene *scene)
{
    const struct sim_mods *m = &scene->mods;
    return m->band[0].count > 0.0 || m->band[1].count > 0.0 || m->cleat_every > 0 ||
           m->stiff_span > 1 || m->lay_deg > 0.0 || m->tear_lb < HUGE_VAL || m->torn.count > 0 ||
           m->unhinge_deg < HUGE_VAL;
}

int mods_connections(const struct sim_scene *scene, int group)
{
    const struct sim_bands *b = &scene->mods.band[group];
    int first = mods_connection_mat(scene, group, 0);
    int last = b->last > 0 && b->last < scene->mats ? b->last : scene->mats;
    return b->count > 0.0 && first <= last ? (last - first) / b->every + 1 : 0;
}

int mods_connection_mat(const struct sim_scene *scene, int group, int i)
{
    const struct sim_bands *b = &scene->mods.band[group];
    return (b->first > 0 ? b->first : b->every) + i * b->every;
}

int mods_cleats(const struct sim_scene *scene)
{
    const struct sim_mods *m = &scene->mods;
    int first = m->cleat_first > 0 ? m->cleat_first : m->cleat_every;
    return m->cleat_every > 0 && first <= scene->mats ? (scene->mats - first) / m->cleat_every + 1
                                                      : 0;
}

int mods_cleat_mat(const struct sim_scene *scene, int i)
{
    const struct sim_mods *m = &scene->mods;
    return (m->cleat_first > 0 ? m->cleat_first : m->cleat_every) + i * m->cleat_every;
}
