#include <math.h>
#include <stdlib.h>

#include "host/sim/solvers/landing_engine.h"

static void lay_ground(struct landing *l)
{
    struct model *m = &l->model;
    const double *ground = l->scene->ground_ft.values;
    for (int n = 0; n < m->mats; n++) {
        l->tilt_ft[n] = ground ? ground[n] - ground[n + 1] : 0.0;
        double s = l->tilt_ft[n] / m->length_ft;
        l->rest_cos[n] = sqrt(1.0 - s * s);
    }
    model_lay(m, l->tilt_ft);
}

/* Arrays of a landing; the model is made. */
static enum mr_status lay_out(struct landing *l, struct error *error)
{
    struct model *m = &l->model;
    size_t length = 2 * (size_t)m->size, joints = (size_t)m->mats + 2;
    l->stored = 2 * length + 17 * joints;
    double *storage = calloc(l->stored, sizeof *storage);
    if (!storage)
        return error_set(error, MR_FULL, "out of memory: %d mats; use a smaller N", m->mats);
    l->z = storage;
    l->accel = storage + length;
    l->u = storage + 2 * length;
    l->v = l->u + joints;
    l->gap0_ft = l->v + joints;
    l->hold_lb = l->gap0_ft + joints;
    l->give_ft = l->hold_lb + joints;
    l->reach_ft = l->give_ft + joints;
    l->tension_lb = l->reach_ft + joints;
    l->height = l->tension_lb + joints;
    l->push_lb = l->height + joints;
    l->pull_lb = l->push_lb + joints;
    l->rise_ft = l->pull_lb + joints;
    l->tilt_ft = l->rise_ft + joints;
    l->rest_cos = l->tilt_ft + joints;
    l->rub_lb = l->rest_cos + joints;
    l->rub_next_lb = l->rub_lb + joints;
    lay_ground(l);
    bool braced = l->mods && (l->mods->banded || l->mods->stiffened);
    m->parting = l->parting;
    if (braced || l->gear || l->parting) {
        l->brace_heaves = l->gear ? landing_load_heaves : braced ? landing_brace_heaves : NULL;
        l->brace_lb = l->rub_next_lb + joints;
        l->brace_lb_ft = l->brace_lb + joints;
        model_brace(m, l->brace_lb, l->brace_lb_ft);
    }
    l->slack_ft = m->slack_ft;
    model_lend(m, l->tension_lb);
    bool gritty = false;
    for (int j = 0; j <= m->mats; j++) {
        l->gap0_ft[j] = sim_scene_joint(&l->scene->gap0_ft, j + 1);
        l->hold_lb[j] = -sim_scene_joint(&l->scene->grit_lb, j + 1);
        l->give_ft[j] = -l->hold_lb[j] / m->kl;
        gritty = gritty || l->hold_lb[j] < 0.0;
    }
    l->joints = joint_law(l->slack_ft, gritty);
    return MR_OK;
}

enum mr_status landing_make(struct landing *l, const struct sim_scene *scene,
                            struct sim_result *result, struct error *error)
{
    l->scene = scene;
    if (scene->friction > 0.0 &&
        (scene->friction_law == SIM_TANH || scene->friction_law == SIM_SIGN))
        return error_set(
            error, MR_USAGE,
            "not available: %s: friction tanh or sign with solver fixed; give stick, or "
            "solver event",
            scene->name[0] ? scene->name : "scene");
    if (model_make(&l->model, scene, true, error) != MR_OK)
        return error->status;
    if (result) /* before the landing takes over what it has of its own */
        model_describe(&l->model, result);
    if (mods_make(&l->mods, scene, error) == MR_OK && gear_make(&l->gear, scene, error) == MR_OK &&
        parting_make(&l->parting, scene, error) == MR_OK)
        lay_out(l, error);
    return error->status;
}

void landing_free(struct landing *l)
{
    mods_free(l->mods);
    gear_free(l->gear);
    parting_free(l->parting);
    model_free(&l->model);
    free(l->z);
}
