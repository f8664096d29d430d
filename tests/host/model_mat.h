/* The mat of the 1973 model, 1/7 of the size, as tests lay it. */
#ifndef MATRIG_TESTS_HOST_MODEL_MAT_H
#define MATRIG_TESTS_HOST_MODEL_MAT_H

#include <math.h>

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

/* Numbers between 0 and 1 that look random. */
static inline double uneven(int i)
{
    double x = 0.6180339887498949 * i + 0.31 * i * i / 97.0;
    return x - floor(x);
}

/* 80 mats of the model runway with uneven gaps and grit; the aircraft brakes across them and is
 * pulled off. */
static inline struct sim_scene short_runway(enum sim_model model)
{
    struct sim_scene scene;
    double gaps[81], grits[81];
    const struct sim_path_row rows[] = {
        {0, 1, 0}, {0.05, 2.4, 13.5}, {0.4, 10.5, 25}, {0.6, 12.5, 25}, {0.6, 12.5, 0}};
    sim_scene_set_defaults(&scene);
    scene.model = model;
    scene.mats = 80;
    model_mat_planar(&scene);
    scene.left_end = SIM_END_FIXED;
    scene.v0_ft_s = 0.0;
    scene.t_dwell_s = 0.2;
    for (int j = 0; j <= 80; j++) {
        gaps[j] = 0.0025 * uneven(j);
        grits[j] = 20.0 * uneven(j + 500);
    }
    sim_scene_set_list(&scene.gap0_ft, gaps, 81);
    sim_scene_set_list(&scene.grit_lb, grits, 81);
    sim_scene_set_path(&scene, rows, 5);
    return scene;
}

#endif
