/* Properties of the planar engine's nodes, joints and mats along the runway. */
#include <math.h>

#include "host/sim/solvers/planar_engine.h"

static void lay_tilt(struct planar_engine *l)
{
    struct model *m = &l->model;
    const double *ground = l->scene->ground_ft.values;
    for (int n = 0; n < m->mats; n++) {
        l->tilt_ft[n] = ground ? ground[n] - ground[n + 1] : 0.0;
        /* nodes on soft soil settle deeper */
        l->rest_tilt_ft[n] = l->tilt_ft[n] + l->rest_ft[n + 1] - l->rest_ft[n];
        double s = l->rest_tilt_ft[n] / m->length_ft;
        l->rest_cos[n] = sqrt(1.0 - s * s);
    }
    for (int n = 0; n < m->mats; n++)
        m->tilt_most_ft = fmax(m->tilt_most_ft, fabs(l->rest_tilt_ft[n]));
    if (m->tilt_most_ft > 0.0) {
        m->tilt_ft = l->tilt_ft;
        m->rest_tilt_ft = l->rest_tilt_ft;
    }
}

/* Properties of each node, joint and mat; lists of the scene, or the same value everywhere. */
static void lay_along(struct planar_engine *l)
{
    struct model *m = &l->model;
    const struct sim_scene *s = l->scene;
    for (int j = 0; j <= m->mats; j++) {
        l->kv_lb_ft[j] = sim_scene_along(s, SIM_ALONG_KV, m->kv, j + 1);
        l->cv_lb_s_ft[j] = sim_scene_along(s, SIM_ALONG_CV, m->cv, j + 1);
        l->kl_lb_ft[j] = sim_scene_along(s, SIM_ALONG_KL, m->kl, j + 1);
        l->kt_lb_ft_rad[j] = sim_scene_along(s, SIM_ALONG_KT, m->kt, j + 1);
        l->rest_ft[j] = sim_scene_settled_ft(s, j + 1);
    }
    for (int n = 0; n < m->mats; n++) {
        double weight_lb = sim_scene_weight_lb(s, n + 1);
        l->mass_slug[n] = weight_lb / s->g_ft_s2;
        l->mass_ratio[n] = l->mass_slug[n] / m->mass_slug;
        l->limit_lb[n] = s->friction * weight_lb;
    }
    m->kv_at = l->kv_lb_ft;
    m->cv_at = l->cv_lb_s_ft;
    m->kt_at = l->kt_lb_ft_rad;
    m->mass_ratio = l->mass_ratio;
}

void engine_lay_ground(struct planar_engine *l)
{
    lay_along(l);
    lay_tilt(l);
}
