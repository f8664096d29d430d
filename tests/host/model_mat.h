/* The mat of the 1973 model, 1/7 of the size, as tests lay it. */
#ifndef MATRIG_TESTS_HOST_MODEL_MAT_H
#define MATRIG_TESTS_HOST_MODEL_MAT_H

#include "host/sim/sim.h"

/* As a chain: along the runway alone. */
static inline void model_mat_chain(struct sim_scene *scene)
{
    scene->length_ft = 2.0 / 7.0;
    scene->weight_lb = 0.466;
    scene->kl_lb_ft = 2.9e5;
    scene->cl_lb_s_ft = 5.0;
    scene->slack_ft = 0.0025;
}

static inline void model_mat_planar(struct sim_scene *scene)
{
    model_mat_chain(scene);
    scene->inertia_slug_ft2 = 1.19e-4;
    scene->kv_lb_ft = 1.3e4;
    scene->cv_lb_s_ft = 60.0;
    scene->kt_lb_ft_rad = 41.6;
    scene->ct_lb_ft_s_rad = 1.6e-4;
    scene->tad_deg = 7.0;
}

#endif
