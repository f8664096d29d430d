/* Waves and growth against closed forms: how fast a push runs along the joints, and how fast a
 * zigzag under compression rises. */

#include "tests/host/sim_case.h"

/* A step of force on the first mat of a chain of masses and springs: the speed behind the front is
 * F/sqrt(KL m), and at the front (n = c t / L) a third of it, as the Airy integral has it. */
TEST(a_push_runs_at_L_sqrt_KL_over_m)
{
    const double dt_s = 2e-5, length = 2.0, station[] = {100.0, 300.0};
    const char *const solvers[] = {"event", "implicit", "cvode"};
    for (int variant = 0; variant < 6; variant++) {
        struct sim_scene scene;
        double arrival_s[2] = {0.0, 0.0};
        sim_scene_defaults(&scene);
        scene.model = variant % 2 ? SIM_CONSISTENT : SIM_REPORT;
        scene.mats = 250;
        scene.v0_ft_s = 0.0;
        scene.cl_lb_s_ft = 0.0;
        scene.friction = 0.0;
        scene.vac_ft_s = 1e-3; /* the push stays on mat 1 */
        scene.t_end_s = 0.16;
        struct sim_options options = {.solver = solvers[variant / 2],
                                      .sample_dt_s = dt_s,
                                      .station_ft = station,
                                      .station_count = 2,
                                      .rtol = 1e-6};
        struct sim_result result = run(&scene, options);
        double mass = 160.0 / 32.174, behind = 12000.0 / sqrt(8e6 * mass),
               c_ft_s = length * sqrt(8e6 / mass);
        for (int s = 0; s < 2; s++) {
            for (size_t k = 1; k + 1 < result.sample_count && arrival_s[s] == 0.0; k++) {
                double v = (result.sample_u_ft[(k + 1) * 2 + (size_t)s] -
                            result.sample_u_ft[(k - 1) * 2 + (size_t)s]) /
                           (2.0 * dt_s);
                if (v > behind / 3.0)
                    arrival_s[s] = (double)k * dt_s;
            }
            assert_true(arrival_s[s] > 0.0);
        }
        assert_true(fabs((station[1] - station[0]) / (arrival_s[1] - arrival_s[0]) / c_ft_s - 1.0) <
                    0.01);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* Four mats well above the ground, without weight, in the shape of the chain's own third mode
 * (heights as the cosine of 3 pi/4 per node), under 12,000 lb from joints that start pressed: the
 * shape keeps and grows as cosh r t. */
TEST(a_small_zigzag_grows_at_its_rate)
{
    const char *const solvers[] = {"event", "implicit", "cvode"};
    const double rate_s[2] = {109.5, 91.7}; /* report model, consistent model */
    for (int variant = 0; variant < 6; variant++) {
        struct sim_scene scene;
        double heights[5];
        int model = variant % 2;
        for (int j = 0; j < 5; j++)
            heights[j] = 0.1 + 1e-4 * cos(0.75 * 3.14159265358979 * j);
        sim_scene_defaults(&scene);
        scene.model = model ? SIM_CONSISTENT : SIM_REPORT;
        scene.mats = 4;
        scene.g_ft_s2 = 32.174e-6; /* the mass stays, the weight goes */
        scene.weight_lb = 160e-6;
        scene.friction = 0.0;
        scene.force_lb = 0.0;
        scene.v0_ft_s = 0.0;
        scene.left = SIM_FIXED;
        scene.lift_shear = SIM_NO_SHEAR;
        scene.bump_first = 1;
        scene.t_end_s = 0.02;
        double pressed_ft = -12000.0 / 8e6;
        sim_scene_set_list(&scene.bump_ft, heights, 5);
        sim_scene_set_list(&scene.gap0_ft, &pressed_ft, 1);
        struct sim_result result = run(&scene,
                                       (struct sim_options){.solver = solvers[variant / 2]});
        /* of the highest node; the report model's nodes are a sum */
        double grown = (result.max_lift_ft - 0.1) / 1e-4;
        /* q1, the middle of mat 1, stays: node 1 rises by half of the first mat's slope */
        if (!model)
            grown =
                (result.outputs[0].lift_ft - 0.1 - 0.5e-4 * (1.0 + cos(0.75 * 3.14159265358979))) /
                (0.5e-4 * (1.0 - cos(0.75 * 3.14159265358979)));
        double rate = acosh(grown) / 0.02;
        assert_true(fabs(rate / rate_s[model] - 1.0) < 0.01);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}
