#include "host/sim/scene/scene.h"
#include "host/base/xmalloc.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/scene/scene_keys.h"

static void mods_defaults(struct sim_mods *mods);

static enum mr_status mods_check(const struct sim_scene *scene, const char *where,
                                 struct error *error);

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

static enum mr_status check_length(const struct sim_list *list, int wanted, const char *key,
                                   const char *part, const char *where, struct error *error)
{
    if (list->count <= 1 || list->count == (size_t)wanted)
        return MR_OK;
    return error_set(
        error, MR_MALFORMED,
        "list of the wrong length: %s: %s has %zu values; give one number or %d, one per %s", where,
        key, list->count, wanted, part);
}

static enum mr_status check_bands(const struct sim_scene *scene, int group, const char *where,
                                  struct error *error)
{
    static const char *const t0_names[] = {"band_T0", "band2_T0"}, *const slip_names[] = {
                                                                       "band_slipped",
                                                                       "band2_slipped"};
    static const char *const prefixes[] = {"band", "band2"};
    const struct sim_bands *b = &scene->mods.band[group];
    int connections = mods_connections(scene, group), first = mods_connection_mat(scene, group, 0);
    if (!(b->count > 0.0))
        return MR_OK;
    if (connections == 0)
        return error_set(error, MR_MALFORMED,
                         "bands riveted nowhere: %s: the first riveted mat is %d of %d (%s_first, "
                         "%s_every); give a "
                         "smaller one",
                         where, first, scene->mats, prefixes[group], prefixes[group]);
    if (check_length(&b->t0_lb, connections + 1, t0_names[group], "segment (riveted mats + 1)",
                     where, error) != MR_OK ||
        check_length(&b->slipped_ft, connections, slip_names[group], "riveted mat", where, error) !=
            MR_OK)
        return error->status;
    for (size_t i = 0; i < b->pulled.count; i++) {
        double at = (b->pulled.values[i] - first) / b->every;
        if (!(at >= 0.0 && at < connections && at == floor(at)))
            return error_set(error, MR_MALFORMED,
                             "not a riveted mat: %s: %s_pulled[%zu] is %g; rivets are in every "
                             "%dth mat from %d on",
                             where, prefixes[group], i, b->pulled.values[i], b->every, first);
    }
    return MR_OK;
}

static enum mr_status mods_check(const struct sim_scene *scene, const char *where,
                                 struct error *error)
{
    const struct sim_mods *m = &scene->mods;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        if (check_bands(scene, g, where, error) != MR_OK)
            return error->status;
    }
    if (m->cleat_every > 0 && check_length(&m->cleat_left, mods_cleats(scene), "cleat_left",
                                           "cleated mat", where, error) != MR_OK)
        return error->status;
    if (m->stiff_span > 1 && m->lay_deg > 0.0)
        return error_set(
            error, MR_MALFORMED,
            "stiffeners on a diagonal pattern: %s: stiff_span and lay_deg; give one of them",
            where);
    if (m->lay_deg > 0.0 && !(scene->slack_ft > 0.0) && m->lay_slide_lb == 0.0 && m->lay_mu == 0.0)
        return error_set(
            error, MR_MALFORMED,
            "nothing to slide: %s: lay_deg without lay_slide, lay_mu or slack; give one of them",
            where);
    for (size_t i = 0; i < m->torn.count; i++) {
        if (m->torn.values[i] > scene->mats + 1 || m->torn.values[i] != floor(m->torn.values[i]))
            return error_set(error, MR_MALFORMED,
                             "no such joint: %s: torn[%zu] is %g; there are %d", where, i,
                             m->torn.values[i], scene->mats + 1);
    }
    return MR_OK;
}
