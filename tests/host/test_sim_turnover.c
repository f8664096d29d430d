/* Where friction tanh turns over: the steps of solver event are cut so that none goes over it from
 * far on one side to far on the other. Units ft, lb, s.
 *
 * Expected steps: by hand, from a speed and a rate. Expected answers: solver implicit, another
 * method, which is not cut, at 1e-11. */

#include "host/sim/solvers/stepper.h"
#include "tests/host/sim_case.h"

#define MATS 2
#define SIZE (2 * MATS + 1)

/* Two mats of which the second moves at v with rate a; veps 0.01, edge at 4 veps, a step of 1 ms.
 * Returns how long the step may be. */
static double step_s(enum sim_friction law, double turn_veps, double v_ft_s, double a_ft_s2)
{
    const struct stepper_kind kind = {.turn_veps = turn_veps};
    struct model model = {.law = law, .veps_ft_s = 0.01, .mats = MATS, .size = SIZE, .last = 1};
    double z[2 * SIZE] = {0.0}, rate[2 * SIZE] = {0.0};
    z[SIZE + 3] = v_ft_s;
    rate[SIZE + 3] = a_ft_s2;
    struct stepper stepper = {.kind = &kind, .model = &model, .least_s = 1e-14, .z = z};
    double h_s = 1e-3, before_s = h_s;
    bool cut = stepper_turns(&stepper, rate, &h_s);
    assert_int_equal(cut, h_s < before_s);
    return h_s;
}

TEST(a_step_ends_before_and_within)
{
    for (double way = -1.0; way <= 1.0; way += 2.0) {
        /* at 0.1 ft/s, slowed by 400 ft/s^2: 0.04 ft/s is reached after 0.15 ms */
        near(step_s(SIM_TANH, 4.0, way * 0.1, way * -400.0), 1.5e-4, 1e-15);
        /* from there to rest, and from rest to the other edge: 0.1 ms each */
        near(step_s(SIM_TANH, 4.0, way * 0.04, way * -400.0), 1e-4, 1e-15);
        near(step_s(SIM_TANH, 4.0, 0.0, way * -400.0), 1e-4, 1e-15);
        /* twice as narrow: 0.02 ft/s after 0.2 ms */
        near(step_s(SIM_TANH, 2.0, way * 0.1, way * -400.0), 2e-4, 1e-15);
    }
}

TEST(other_steps_are_left_alone)
{
    assert_true(step_s(SIM_TANH, 4.0, 0.1, 400.0) == 1e-3);    /* it goes faster */
    assert_true(step_s(SIM_TANH, 4.0, 0.5, -400.0) == 1e-3);   /* it slows down to 0.1 ft/s */
    assert_true(step_s(SIM_TANH, 4.0, -0.05, -400.0) == 1e-3); /* it has turned */
    assert_true(step_s(SIM_TANH, 4.0, 0.005, -9.0) == 1e-3);   /* less than veps: it is smooth */
    assert_true(step_s(SIM_TANH, 4.0, 0.1, -(double)INFINITY) == 1e-3); /* the step will fail */
    assert_true(step_s(SIM_STICK, 4.0, 0.1, -400.0) == 1e-3); /* it stops there, located */
    assert_true(step_s(SIM_TANH, 4.0, 0.0, 0.0) == 1e-3);
}

/* Not cut, tolerances from 1e-3 to 1e-5 end 9e-6 to 6e-5 ft from the truth: the jump is within the
 * tolerance of each step, and finer steps meet it by chance. */
TEST(loose_tolerances_do_not_lie)
{
    const double bump[] = {0.0099, 0.02, 0.0099};
    struct sim_scene scene;
    sim_scene_defaults(&scene);
    sim_scene_set_list(&scene.bump_ft, bump, 3);
    scene.mats = 30;
    scene.mats_crossed = 3.0;
    scene.friction_law = SIM_TANH;
    scene.veps_ft_s = 1e-2;
    struct sim_result truth, result;
    struct sim_options fine = {.solver = "implicit", .rtol = 1e-11};
    if (sim_run(&scene, &fine, &truth, &error) != MR_OK)
        fail_msg("%s", error.text);
    for (double rtol = 1e-3; rtol > 5e-6; rtol *= sqrt(0.1)) {
        struct sim_options options = {.solver = "event", .rtol = rtol};
        if (sim_run(&scene, &options, &result, &error) != MR_OK)
            fail_msg("%s", error.text);
        near(result.max_lift_ft, truth.max_lift_ft, 3e-6);
        for (int n = 1; n <= scene.mats; n++)
            near(result.u_ft[n], truth.u_ft[n], 3e-6);
        sim_result_free(&result);
    }
    sim_result_free(&truth);
    sim_scene_free(&scene);
}
