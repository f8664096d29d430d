#ifndef MATRIG_TESTS_HOST_BEADS_H
#define MATRIG_TESTS_HOST_BEADS_H

#include "host/sim/sim.h"

/* Seven hard, light mats between fixed ends that hit each other across their play without friction:
 * beads. One hit that comes a little later turns all that follow. */
static inline struct sim_scene beads(void)
{
    struct sim_scene scene;
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mats = 7;
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.thrust = SIM_THRUST_LINEAR;
    scene.weight_lb = 0.541296;
    scene.inertia_slug_ft2 = 108.333;
    scene.kv_lb_ft = 258222.0;
    scene.cv_lb_s_ft = 86.7103;
    scene.kl_lb_ft = 4.26391e8;
    scene.cl_lb_s_ft = 0.555537;
    scene.slack_ft = 0.005;
    scene.friction_law = SIM_FRICTION_NONE;
    scene.force_lb = 40.5972;
    scene.start_ft = 2.0;
    scene.v0_ft_s = 2.0;
    scene.t_end_s = 0.005;
    return scene;
}

#endif
