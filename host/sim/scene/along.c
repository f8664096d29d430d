/* Values of a scene that vary along the runway, and positions of its modifications. */
#include <math.h>
#include <stdlib.h>

#include "host/sim/scene/scene.h"

double sim_scene_joint_value(const struct sim_list *list, int joint)
{
    if (list->count == 0)
        return 0.0;
    return list->values[list->count == 1 ? 0 : (size_t)(joint - 1)];
}

bool sim_scene_is_varied(const struct sim_scene *scene)
{
    bool varies = scene->left_end == SIM_END_LOADED || scene->right_end == SIM_END_LOADED;
    for (size_t i = 0; i < SIM_VARIED_COUNT; i++)
        varies = varies || scene->varied[i].count > 0;
    return varies;
}

double sim_scene_local_value(const struct sim_scene *scene, enum sim_varied which,
                             double everywhere, int at)
{
    const struct sim_list *list = &scene->varied[which];
    return list->count > 0 ? sim_scene_joint_value(list, at) : everywhere;
}

double sim_scene_weight_lb(const struct sim_scene *scene, int mat)
{
    double weight_lb = sim_scene_local_value(scene, SIM_VARIED_W, scene->weight_lb, mat);
    if (mat == 1 && scene->left_end == SIM_END_LOADED)
        weight_lb += scene->end_load_lb[0];
    if (mat == scene->mats && scene->right_end == SIM_END_LOADED)
        weight_lb += scene->end_load_lb[1];
    return weight_lb;
}

double sim_scene_step_limiting_value(const struct sim_scene *scene, enum sim_varied which,
                                     double everywhere)
{
    const struct sim_list *list = &scene->varied[which];
    double extreme = list->count > 0 ? list->values[0] : everywhere;
    for (size_t i = 1; i < list->count; i++)
        extreme = which == SIM_VARIED_W ? fmin(extreme, list->values[i])
                                        : fmax(extreme, list->values[i]);
    return extreme;
}

/* Each end of a mat carries half of the mat's weight. */
double sim_scene_settlement_ft(const struct sim_scene *scene, int node)
{
    double kv = sim_scene_local_value(scene, SIM_VARIED_KV, scene->kv_lb_ft, node), weight_lb = 0.0;
    int ends = 0;
    for (int mat = node - 1; mat <= node; mat++) {
        if (mat >= 1 && mat <= scene->mats) {
            weight_lb += sim_scene_weight_lb(scene, mat);
            ends++;
        }
    }
    return 0.5 * weight_lb / ends / kv;
}

void mods_collect_lists(struct sim_mods *m, struct sim_list *lists[MODS_LIST_COUNT])
{
    size_t count = 0;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        lists[count++] = &m->band[g].initial_tension_lb;
        lists[count++] = &m->band[g].slipped_ft;
        lists[count++] = &m->band[g].pulled;
    }
    lists[count++] = &m->cleat_remaining_share;
    lists[count++] = &m->stiffener_gap0_ft;
    lists[count++] = &m->torn;
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; k++)
        lists[count++] = &m->restraint[k].zero_ft;
}

void mods_free_lists(struct sim_mods *mods)
{
    struct sim_list *lists[MODS_LIST_COUNT];
    mods_collect_lists(mods, lists);
    for (size_t i = 0; i < MODS_LIST_COUNT; i++) {
        free(lists[i]->values);
        *lists[i] = (struct sim_list){0};
    }
}

bool mods_are_present(const struct sim_scene *scene)
{
    const struct sim_mods *m = &scene->mods;
    bool restrained = scene->left_end == SIM_END_SPRING || scene->right_end == SIM_END_SPRING;
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; k++)
        restrained = restrained || m->restraint[k].spacing > 0;
    return restrained || m->band[0].count > 0.0 || m->band[1].count > 0.0 || m->cleat_every > 0 ||
           m->stiffener_span_mats > 1 || m->lay_deg > 0.0 || m->tear_lb < HUGE_VAL ||
           m->torn.count > 0;
}

int mods_nth_place(int first, int every, int i)
{
    return (first > 0 ? first : every) + i * every;
}

/* Returns the number of places first, first + every, ... up to `last`. */
static int count_places(int first, int every, int last)
{
    int begin = mods_nth_place(first, every, 0);
    return every > 0 && begin <= last ? (last - begin) / every + 1 : 0;
}

int mods_connection_count(const struct sim_scene *scene, int group)
{
    const struct sim_bands *b = &scene->mods.band[group];
    int last = b->last_mat > 0 && b->last_mat < scene->mats ? b->last_mat : scene->mats;
    return b->count > 0.0 ? count_places(b->first_mat, b->spacing, last) : 0;
}

int mods_cleat_count(const struct sim_scene *scene)
{
    return count_places(scene->mods.cleat_first, scene->mods.cleat_every, scene->mats);
}

int mods_restraint_count(const struct sim_scene *scene, int kind)
{
    const struct sim_restraint *r = &scene->mods.restraint[kind];
    return count_places(r->first_place, r->spacing, scene->mats);
}

const char *mods_restraint_name(int kind)
{
    static const char *const names[] = {"anchor", "tie", "absorber"};
    return names[kind];
}
