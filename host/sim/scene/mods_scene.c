#include "host/sim/scene/mods_scene.h"

#include <math.h>
#include <stdlib.h>

/* Defaults with a source: the model's bands of 5.1.2.1 (3/8 x 0.020 in, steel), the wheel's static
 * deflection of 2.6 (0.050 in over a mat of 24/7 in), cleats of 5.5 (3/4 in), AM2's thickness
 * (1.5 in). */
void mods_defaults(struct sim_mods *mods)
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

enum mr_status mods_check(const struct sim_scene *scene, const char *where, struct error *error)
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
