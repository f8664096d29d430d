/* Scenes that the tests of the runway's modifications share, and how they run them. Units ft, lb,
 * s. The caller frees what it gets. */
#ifndef MATRIG_TESTS_HOST_MODS_CASE_H
#define MATRIG_TESTS_HOST_MODS_CASE_H

#include "host/sim/elements/mods.h"
#include "tests/host/model_mat.h"
#include "tests/host/sim_case.h"

#define PI 3.14159265358979323846

/* N free mats far apart (joints never meet), 32.174 lb each: mass 1 slug; bands of A E = 1000
 * lb. */
static inline struct sim_scene apart(int mats)
{
    struct sim_scene scene;
    const double gap = 5.0;
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.mats = mats;
    scene.length_ft = 1.0;
    scene.weight_lb = G;
    scene.left_end = scene.right_end = SIM_END_FREE;
    scene.kl_lb_ft = 1e3;
    scene.slack_ft = 10.0;
    scene.force_lb = scene.vac_ft_s = scene.v0_ft_s = 0.0;
    scene.friction_law = SIM_FRICTION_NONE;
    scene.mods.band[0].count = 1.0;
    scene.mods.band[0].area_ft2 = 1.0;
    scene.mods.band[0].e_lb_ft2 = 1000.0;
    sim_scene_set_list(&scene.gap0_ft, &gap, 1);
    return scene;
}

static inline void rivet(struct sim_scene *scene, int every, int first, int last)
{
    scene->mods.band[0].spacing = every;
    scene->mods.band[0].first_mat = first;
    scene->mods.band[0].last_mat = last;
}

static inline void tension(struct sim_scene *scene, const double *values, size_t count)
{
    sim_scene_set_list(&scene->mods.band[0].initial_tension_lb, values, count);
}

static inline struct sim_scene runway(void)
{
    struct sim_scene scene;
    const struct sim_path_row rows[] = {
        {0, 2, 0}, {0.05, 3.4, 25}, {0.5, 13.5, 25}, {0.8, 17.5, 25}, {0.8, 17.5, 0}};
    double gaps[121], grits[121];
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.mats = 120;
    model_mat_chain(&scene);
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.v0_ft_s = 0.0;
    scene.t_dwell_s = 0.3;
    for (int j = 0; j <= 120; j++) {
        double x = 0.6180339887498949 * j + 0.31 * j * j / 97.0;
        gaps[j] = 0.0025 * (x - floor(x));
        grits[j] = 20.0 * (gaps[120 - j > 0 && j > 60 ? 120 - j : j] / 0.0025);
    }
    sim_scene_set_list(&scene.gap0_ft, gaps, 121);
    sim_scene_set_list(&scene.grit_lb, grits, 121);
    sim_scene_set_path(&scene, rows, 5);
    return scene;
}

static inline void add_all(struct sim_scene *scene)
{
    const double t0 = 60.0;
    scene->mods.band[0].count = 0.5;
    scene->mods.band[0].spacing = 10;
    scene->mods.band[0].k_lb_ft = 2000.0;
    scene->mods.band[0].grip_lb = 25.0;
    tension(scene, &t0, 1);
    scene->mods.band[1] = (struct sim_bands){.count = 0.25,
                                             .area_ft2 = scene->mods.band[0].area_ft2,
                                             .e_lb_ft2 = scene->mods.band[0].e_lb_ft2,
                                             .spacing = 15,
                                             .k_lb_ft = 1000.0,
                                             .grip_lb = 25.0,
                                             .rivet_pull_lb = (double)INFINITY,
                                             .hole_wear_ft = (double)INFINITY};
    sim_scene_set_list(&scene->mods.band[1].initial_tension_lb, &t0, 1);
    scene->mods.cleat_every = 7;
    scene->mods.cleat_hold_lb = 2.0;
    scene->mods.cleat_travel_ft = 0.02;
    scene->mods.stiffener_span_mats = 6;
    scene->mods.stiffener_k_lb_ft = 2e4;
    scene->mods.stiffener_grip_lb = 8.0;
    scene->mods.tear_lb = 60.0;
}

#endif
