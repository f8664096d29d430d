#include "host/sim/scene/scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/scene/mods_scene.h"
#include "host/sim/scene/scene_keys.h"

const char *sim_model_name(enum sim_model model)
{
    return sim_models[model];
}

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

static enum mr_status copy_array(void **to, const void *from, size_t count, size_t size,
                                 struct error *error)
{
    void *copy = NULL;
    if (count > 0) {
        copy = calloc(count, size);
        if (!copy)
            return error_set(error, MR_FULL,
                             "out of memory: a list of %zu values; use a smaller scene", count);
        memcpy(copy, from, count * size);
    }
    free(*to);
    *to = copy;
    return MR_OK;
}

enum mr_status sim_scene_set_list(struct sim_list *list, const double *values, size_t count,
                                  struct error *error)
{
    void *array = list->values;
    enum mr_status status = copy_array(&array, values, count, sizeof *values, error);
    if (status == MR_OK)
        *list = (struct sim_list){array, count};
    return status;
}

enum mr_status sim_scene_set_path(struct sim_scene *scene, const struct sim_path_row *rows,
                                  size_t count, struct error *error)
{
    void *array = scene->path;
    enum mr_status status = copy_array(&array, rows, count, sizeof *rows, error);
    if (status == MR_OK) {
        scene->path = array;
        scene->path_count = count;
    }
    return status;
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

static enum mr_status out_of_range(const struct sim_key *key, const char *where, double value,
                                   size_t index, bool listed, struct error *error)
{
    char entry[32] = "";
    if (listed)
        snprintf(entry, sizeof entry, "[%zu]", index);
    if (key->high >= SIM_LARGEST)
        return error_set(error, MR_MALFORMED, "value out of range: %s: %s%s is %g; give %s %g",
                         where, key->name, entry, value,
                         key->above ? "a number above" : "a finite number from", key->low);
    return error_set(error, MR_MALFORMED, "value out of range: %s: %s%s is %g; give %g to %g",
                     where, key->name, entry, value, key->low, key->high);
}

static bool allowed(const struct sim_key *key, double value)
{
    return value >= key->low && value <= key->high && !(key->above && value == key->low);
}

static enum mr_status check_key(const struct sim_scene *scene, const struct sim_key *key,
                                const char *where, struct error *error)
{
    const void *field = (const char *)scene + key->offset;
    double value;
    switch (key->kind) {
    case SIM_KEY_TEXT:
    case SIM_KEY_PATH: return MR_OK;
    case SIM_KEY_CHOICE: {
        unsigned choice;
        size_t count = 0;
        memcpy(&choice, field, sizeof choice);
        while (key->choices[count])
            count++;
        if (choice >= count)
            return error_set(error, MR_MALFORMED,
                             "value out of range: %s: %s is choice %u; there are %zu", where,
                             key->name, choice, count);
        return MR_OK;
    }
    case SIM_KEY_REAL:
        value = *(const double *)field;
        return allowed(key, value) ? MR_OK : out_of_range(key, where, value, 0, false, error);
    case SIM_KEY_INTEGER:
        value = *(const int *)field;
        return allowed(key, value) ? MR_OK : out_of_range(key, where, value, 0, false, error);
    case SIM_KEY_LIST:
    case SIM_KEY_MATS:
    case SIM_KEY_JOINTS:
    case SIM_KEY_PARTS: break;
    }
    const struct sim_list *list = field;
    for (size_t i = 0; i < list->count; i++) {
        if (!allowed(key, list->values[i]))
            return out_of_range(key, where, list->values[i], i, true, error);
    }
    size_t joints = (size_t)scene->mats + 1;
    if (key->kind == SIM_KEY_JOINTS && list->count > 1 && list->count != joints)
        return error_set(error, MR_MALFORMED,
                         "list of the wrong length: %s: %s has %zu values; give one number or %zu, "
                         "one per joint (N + 1)",
                         where, key->name, list->count, joints);
    return MR_OK;
}

/* The stiffness is an element's key, so its place is known by name alone here. */
static bool stands_on_ground(const struct sim_scene *scene)
{
    const struct sim_key *key = sim_key_find("gear_k_lb_ft");
    return key && *(const double *)((const char *)scene + key->offset) > 0.0;
}

static enum mr_status check_gear(const struct sim_scene *scene, const char *where,
                                 struct error *error)
{
    const struct sim_list *lines = &scene->gear.lines_ft, *axles = &scene->gear.axles;
    size_t count = lines->count > 0 ? lines->count : 1;
    if (count > SIM_GEAR_LINES_MAX)
        return error_set(error, MR_MALFORMED,
                         "list too long: %s: gear_lines_ft has %zu axle lines; give at most %d",
                         where, count, SIM_GEAR_LINES_MAX);
    if (axles->count > 0 && axles->count != count)
        return error_set(error, MR_MALFORMED,
                         "list of the wrong length: %s: gear_axles has %zu values; give %zu, one "
                         "per axle line",
                         where, axles->count, count);
    if (scene->gear.foot_ft > 4.0 * scene->length_ft)
        return error_set(error, MR_MALFORMED,
                         "value out of range: %s: gear_foot_ft is %g; give at most 4 mats, %g ft",
                         where, scene->gear.foot_ft, 4.0 * scene->length_ft);
    if ((lines->count > 0 || axles->count > 0) && !stands_on_ground(scene))
        return error_set(error, MR_MALFORMED,
                         "axle lines without ground: %s: gear_lines_ft or gear_axles without "
                         "gear_k_lb_ft; give the stiffness of the ground, or leave them out",
                         where);
    return MR_OK;
}

static enum mr_status check_path(const struct sim_scene *scene, const char *where,
                                 struct error *error)
{
    for (size_t i = 0; i < scene->path_count; i++) {
        const struct sim_path_row *row = &scene->path[i];
        if (!(fabs(row->t_s) <= SIM_LARGEST && fabs(row->x_ft) <= SIM_LARGEST &&
              fabs(row->force_lb) <= SIM_LARGEST))
            return error_set(error, MR_MALFORMED,
                             "value out of range: %s: path row %zu; give finite t_s, x_ft, F_lb",
                             where, i);
        if (row->t_s < 0.0 || (i > 0 && row->t_s < row[-1].t_s))
            return error_set(error, MR_MALFORMED,
                             "times out of order: %s: path row %zu is at %g s; give rows in order "
                             "of time from 0 s on (equal times: a jump of F)",
                             where, i, row->t_s);
        if (i > 0 && row->t_s == row[-1].t_s && row->x_ft != row[-1].x_ft)
            return error_set(error, MR_MALFORMED,
                             "aircraft jumps: %s: path row %zu has the time of the row before and "
                             "another x; give it a later time",
                             where, i);
    }
    if (scene->path_count == 1)
        return error_set(error, MR_MALFORMED,
                         "list too short: %s: path has one row; give at least two", where);
    return MR_OK;
}

enum mr_status sim_scene_check(const struct sim_scene *scene, const char *where,
                               struct error *error)
{
    const struct sim_key *key;
    for (size_t i = 0; (key = sim_key_at(i)); i++) {
        if (check_key(scene, key, where, error) != MR_OK)
            return error->status;
    }
    if (check_path(scene, where, error) != MR_OK)
        return error->status;
    for (size_t i = 0; i < scene->u_mats.count; i++) {
        double mat = scene->u_mats.values[i];
        if (mat > scene->mats || mat != floor(mat))
            return error_set(error, MR_MALFORMED, "no such mat: %s: u_mats[%zu] is %g; N is %d",
                             where, i, mat, scene->mats);
    }
    if (scene->v0_mat > scene->mats)
        return error_set(error, MR_MALFORMED, "no such mat: %s: v0_mat is %d; N is %d", where,
                         scene->v0_mat, scene->mats);
    if (scene->bump_ft.count > 0 &&
        (size_t)scene->bump_first + scene->bump_ft.count > (size_t)scene->mats + 2)
        return error_set(error, MR_MALFORMED,
                         "no such node: %s: bump ends at node %zu; N + 1 is %d", where,
                         (size_t)scene->bump_first + scene->bump_ft.count - 1, scene->mats + 1);
    if (scene->ground_ft.count > 0 && scene->ground_ft.count != (size_t)scene->mats + 1)
        return error_set(
            error, MR_MALFORMED,
            "list of the wrong length: %s: ground has %zu values; give %d, one per node (N + 1)",
            where, scene->ground_ft.count, scene->mats + 1);
    if (mods_check(scene, where, error) != MR_OK || check_gear(scene, where, error) != MR_OK)
        return error->status;
    double end_s = sim_scene_end_s(scene);
    if (!(end_s > 0.0 && end_s <= SIM_LARGEST))
        return error_set(error, MR_MALFORMED,
                         "no end: %s: nothing says when the run ends; give tend", where);
    for (size_t i = 0; i < scene->t_out_s.count; i++) {
        if (scene->t_out_s.values[i] > end_s)
            return error_set(
                error, MR_MALFORMED,
                "output after the end: %s: t_out[%zu] is %g s and the run ends at %g s; "
                "give a later tend",
                where, i, scene->t_out_s.values[i], end_s);
    }
    return MR_OK;
}
