/* The chain against closed forms. Units ft, lb, s. */

#include "tests/host/sim_case.h"
#include "tests/host/model_mat.h"

#define run_at(scene, step_s) run(scene, (struct sim_options){.dt_s = (step_s)})

/* N mats of 160 lb, 2 ft, free, no friction, no damper, the aircraft standing on mat 1 without
 * thrust. */
static struct sim_scene plain(int mats)
{
    struct sim_scene scene;
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.mats = mats;
    scene.left_end = scene.right_end = SIM_END_FREE;
    scene.cl_lb_s_ft = 0.0;
    scene.force_lb = scene.vac_ft_s = scene.v0_ft_s = 0.0;
    scene.friction_law = SIM_FRICTION_NONE;
    return scene;
}

TEST(below_its_friction_a_mat_stays)
{
    struct sim_scene scene = plain(3);
    scene.friction_law = SIM_FRICTION_STICK;
    scene.kl_lb_ft = 1e3;
    scene.force_lb = 80.0; /* exactly f W */
    scene.t_end_s = 0.5;
    struct sim_result result = run_at(&scene, 0.0);
    for (int n = 1; n <= 3; n++)
        assert_true(result.u_ft[n] == 0.0);
    assert_true(result.speed_end_ft_s == 0.0 && result.events == 0);
    sim_result_free(&result);

    scene.force_lb = 80.0001;
    result = run_at(&scene, 0.0);
    assert_true(result.u_ft[1] > 0.0 && result.u_ft[2] == 0.0);
    sim_result_free(&result);

    scene.force_lb = 100.0; /* 20 lb too much, but 50 lb on the wheel hold it */
    scene.wheel_load_lb = 50.0;
    result = run_at(&scene, 0.0);
    assert_true(result.u_ft[1] == 0.0);
    sim_result_free(&result);
}

/* A push F - f W that begins at once is answered by twice that, shared by what joints hold the mat.
 * 4.7 steps a swing: without the parabola up to 8.5 % is missed. */
TEST(the_largest_force_is_found_within_a_step)
{
    for (int phase = 0; phase < 24; phase++) {
        for (int ends = 0; ends < 2; ends++) {
            struct sim_scene scene = plain(1);
            double swing_s = 2.0 * acos(-1.0) / sqrt((ends + 1) * 3000.0 * G / 160.0);
            const struct sim_path_row path[] = {{(0.3 + phase / 24.0) * swing_s / 4.7, 1.0, 1080.0},
                                                {1.0, 1.0, 1080.0}};
            scene.friction_law = SIM_FRICTION_STICK;
            scene.kl_lb_ft = 3000.0;
            scene.left_end = SIM_END_FIXED;
            scene.right_end = ends ? SIM_END_FIXED : SIM_END_FREE;
            scene.t_end_s = 1.2 * swing_s;
            sim_scene_set_path(&scene, path, 2);
            struct sim_result result = run(&scene, (struct sim_options){.dt_s = swing_s / 4.7,
                                                                        .solver = "staggered",
                                                                        .is_single_pass = true});
            near(result.max_tension_lb[1], 2000.0 / (ends + 1), 0.05 * 2000.0 / (ends + 1));
            sim_result_free(&result);
        }
    }
}

TEST(a_wave_runs_at_its_speed)
{
    struct sim_scene scene = plain(100);
    const double times[] = {0.05, 0.07};
    const double speed = 2.0 * sqrt(8e6 * G / 160.0);    /* L sqrt(KL/m), 2536.6 ft/s */
    const double jump = 12000.0 / sqrt(8e6 * 160.0 / G); /* F/sqrt(KL m), 1.9026 ft/s */
    scene.force_lb = 12000.0;
    scene.t_end_s = 0.07;
    sim_scene_set_list(&scene.t_out_s, times, 2);
    struct sim_result result = run_at(&scene, 0.0);
    const double *u = result.outputs[0].u_ft;
    double velocity = (result.outputs[1].u_ft[10] - u[10]) / 0.02;
    near(velocity, jump, 0.01 * jump);
    /* behind the front u = jump (t - x/speed): the slope along the runway gives the speed */
    double slope = (u[5] - u[45]) / (40.0 * 2.0);
    near(jump / slope, speed, 0.01 * speed);
    /* the front: 0.05 s at 2536.6 ft/s is mat 64 */
    assert_true(u[60] > 1e-3 && u[70] < 1e-3 * u[1]);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

TEST(an_impulse_is_all_there)
{
    /* F rises to 500 lb and falls while the aircraft crosses several mats: impulse 500 * 0.05 lb
     * s */
    const struct sim_path_row rows[] = {
        {0, 0.3, 0}, {0.03, 4.1, 500}, {0.1, 11.3, 0}, {0.2, 12, 0}};
    const double times[] = {0.11, 0.19};
    for (int law = SIM_THRUST_JUMP; law <= SIM_THRUST_LINEAR; law++) {
        struct sim_scene scene = plain(30);
        double sum = 0.0;
        scene.thrust = (enum sim_thrust)law;
        sim_scene_set_path(&scene, rows, 4);
        sim_scene_set_list(&scene.t_out_s, times, 2);
        struct sim_result result = run_at(&scene, 0.0);
        for (int n = 1; n <= 30; n++)
            sum += result.outputs[1].u_ft[n] - result.outputs[0].u_ft[n];
        near(sum * (160.0 / G) / 0.08, 25.0, 1e-8);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* A mat crosses its gap, hits, stops; the other goes on, comes to the end of the slack, stops and
 * pulls the first along. */
TEST(slack_is_free_travel)
{
    struct sim_scene scene = plain(2);
    const double m = 160.0 / G, k = 8e6, v = 2.0, gap = 0.01, slack = 0.03;
    const double contact = 3.14159265358979 *
                           sqrt(0.5 * m / k); /* half a period, in which they exchange speeds */
    const double hit = gap / v, parted = hit + contact, hooked = parted + slack / v,
                 towed = hooked + contact;
    const double times[] = {0.9 * hit, 0.5 * (parted + hooked), towed + 0.004};
    scene.kl_lb_ft = k;
    scene.slack_ft = slack;
    scene.v0_ft_s = v;
    scene.t_end_s = towed + 0.005;
    sim_scene_set_list(&scene.gap0_ft, &gap, 1);
    sim_scene_set_list(&scene.t_out_s, times, 3);
    struct sim_result result = run_at(&scene, 1e-6);
    const double moved = gap + 0.5 * v * contact; /* of mat 1 when they part */
    assert_true(result.outputs[0].u_ft[2] == 0.0);
    near(result.outputs[0].u_ft[1], v * times[0], 1e-12);
    near(result.outputs[1].u_ft[1], moved, 1e-6);
    near(result.outputs[1].u_ft[2], 0.5 * v * contact + v * (times[1] - parted), 1e-6);
    near(result.outputs[2].u_ft[2], 0.5 * v * contact + slack + 0.5 * v * contact, 2e-6);
    near(result.outputs[2].u_ft[1], moved + 0.5 * v * contact + v * 0.004, 2e-6);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* One strip of the model runway, N mats, fixed downfield, pushed on mat 1 by a force that rises so
 * slowly that joints close one after the other: each closed joint adds a mat to push. */
static struct sim_scene ploughed(int mats, double gap, double grit, const struct sim_path_row *rows,
                                 size_t count)
{
    struct sim_scene scene = plain(mats);
    model_mat_chain(&scene);
    scene.friction_law = SIM_FRICTION_STICK;
    scene.right_end = SIM_END_FIXED;
    sim_scene_set_list(&scene.gap0_ft, &gap, 1);
    sim_scene_set_list(&scene.grit_lb, &grit, 1);
    sim_scene_set_path(&scene, rows, count);
    return scene;
}

static int closed_joints(const struct sim_result *result)
{
    int closed = 0;
    for (int j = 2; j <= result->mats + 1; j++) /* joint 1 is the free end */
        closed += result->gap_ft[j] < 1e-5;
    return closed;
}

TEST(a_slow_push_closes_joints_one_by_one)
{
    const double fw = 0.5 * 0.466, gap = 0.0015;
    const double grits[] = {0.0, 1.0};
    for (int i = 0; i < 2; i++) {
        /* grit too has to be overcome: n f w + grit < F */
        const double force = 10.5 * fw + grits[i];
        const struct sim_path_row rows[] = {{0, 0.1, grits[i]}, {3, 0.1, force}, {3.5, 0.1, force}};
        struct sim_scene scene = ploughed(40, gap, grits[i], rows, 3);
        struct sim_result result = run_at(&scene, 0.0);
        assert_int_equal(closed_joints(&result), 10);
        near(result.u_ft[1], 10.0 * gap, 0.5 * gap);
        assert_true(result.u_ft[10] > 0.9 * gap && result.u_ft[12] < 1e-4);
        assert_true(result.speed_end_ft_s == 0.0);
        assert_true(result.integrated_mats_max < 20); /* the rest of the runway sleeps */
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

TEST(grit_holds_an_open_joint)
{
    const double fw = 0.5 * 0.466, gap = 0.0015, grit = 10.0;
    /* just below and just above what joint 2 needs: F = f w + grit */
    for (int above = 0; above <= 1; above++) {
        const double force = fw + grit + (above ? 0.01 : -0.01);
        const struct sim_path_row rows[] = {{0, 0.1, 0}, {1, 0.1, force}, {1.5, 0.1, force}};
        struct sim_scene scene = ploughed(5, gap, grit, rows, 3);
        struct sim_result result = run_at(&scene, 0.0);
        if (above)
            assert_true(result.gap_ft[2] < 1e-4);
        else
            near(result.gap_ft[2], gap, 1.01 * grit / 2.9e5); /* gives way by grit/KL at most */
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* A joint that is run into: the damper alone would push with CL v = 5 lb and more, an open joint
 * never with more than grit. */
TEST(grit_is_all_an_open_joint_can_push)
{
    const double m = 0.466 / G, grit = 3.0, v = 1.0, a = (grit + 0.5 * 0.466) / m, t = 1e-3;
    const struct sim_path_row rows[] = {{0, 0.1, 0}, {0.002, 0.1, 0}};
    struct sim_scene scene = ploughed(1, 0.0015, grit, rows, 2);
    scene.v0_ft_s = v;
    sim_scene_set_list(&scene.t_out_s, &t, 1);
    struct sim_result result = run_at(&scene, 1e-6);
    /* it bears from the first step on */
    near(result.outputs[0].u_ft[1], v * t - 0.5 * a * t * t, 2e-7);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Closed by half, pulled open again without resistance, then pushed: it takes the whole grit
 * again. */
TEST(an_opened_joint_needs_its_grit_again)
{
    const double fw = 0.5 * 0.466, m = 0.466 / G, grit = 3.0, push = 5.0;
    const struct sim_path_row rows[] = {{0, 0.1, push},
                                        {0.0035, 0.1, push},
                                        /* closes part of the way */
                                        {0.0035, 0.1, 0},
                                        {0.1, 0.1, 0},
                                        {0.1, 0.1, -0.6},
                                        {0.102, 0.1, -0.6},
                                        {0.102, 0.1, 0},
                                        {0.2, 0.1, 0}, /* opens a part of that */
                                        {0.28, 0.1, 3.1},
                                        {0.3, 0.1, 3.1},
                                        /* not enough: f w + grit = 3.233 */
                                        {0.3, 0.1, 0},
                                        {0.4, 0.1, 0},
                                        {0.48, 0.1, 3.4},
                                        {0.5, 0.1, 3.4},
                                        {0.5, 0.1, 0},
                                        {0.6, 0.1, 0}}; /* enough */
    const double times[] = {0.1, 0.2, 0.3, 0.6};
    struct sim_scene scene = ploughed(1, 0.0015, grit, rows, 16);
    sim_scene_set_list(&scene.t_out_s, times, 4);
    struct sim_result result = run_at(&scene, 2e-5);
    const double closed = result.outputs[0].u_ft[1], opened = result.outputs[1].u_ft[1];
    assert_true(closed > 3e-4 && closed < 1.3e-3);
    /* pulled for 2 ms against friction alone, then slowing by f g */
    const double pull = (0.6 - fw) / m, v = pull * 0.002;
    near(closed - opened, 0.5 * v * 0.002 + v * v / (2.0 * 0.5 * G), 0.02 * (closed - opened));
    near(result.outputs[2].u_ft[1], opened, 1.1 * 3.1 / 2.9e5);
    assert_true(result.outputs[3].u_ft[1] > closed); /* beyond where it once was */
    sim_result_free(&result);
    sim_scene_free(&scene);
}

TEST(a_fixed_end_holds_and_a_loaded_joint_pushes)
{
    /* three joints, gap0 below 0 in joint 1 only, which is fixed: the mat swings about where joint
     * 1 and 2 balance */
    const double gaps[] = {-0.001, 0.0, 0.0}, t = 3.14159265358979 / sqrt(3.0 * 8e6 * G / 160.0);
    struct sim_scene scene = plain(1);
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.t_end_s = t; /* not yet half a period of sqrt(2 KL/m) */
    sim_scene_set_list(&scene.gap0_ft, gaps, 2);
    struct sim_result result = run_at(&scene, 1e-7);
    double w = sqrt(2.0 * 8e6 * G / 160.0);
    near(result.u_ft[1], 0.0005 * (1.0 - cos(w * t)), 1e-9);
    near(result.gap_ft[1], -0.001 + result.u_ft[1], 1e-15);
    near(result.gap_ft[2], -result.u_ft[1], 1e-15);
    assert_non_null(strstr(result.notes[0], "1 joints start under load"));
    sim_result_free(&result);
    sim_scene_free(&scene);
}
