/* Joints that come apart: in tension, turned downwards, and the ends that pass over each other.
 * Expected values are closed forms of one or two mats. Units ft, lb, s. */
#include "host/sim/elements/parting.h"
#include "tests/host/mods_case.h"

#define TEAR    100.0
#define SPEED   2.0
#define KL      1e4
#define HIGH_FT 0.9
#define RATE    20.0                /* of two mats about a hinge, 1/s */
#define START   (10.0 * PI / 180.0) /* each mat's angle */

/* Two free mats of 1 slug without friction; no bands. */
static struct sim_scene two_mats(enum sim_model model)
{
    struct sim_scene scene = apart(2);
    const double none = 0.0;
    scene.model = model;
    scene.mods.band[0].count = 0.0;
    scene.kl_lb_ft = KL;
    scene.cl_lb_s_ft = 0.0;
    scene.slack_ft = 0.0;
    scene.kv_lb_ft = 1e4;
    scene.cv_lb_s_ft = 50.0;
    scene.inertia_slug_ft2 = 0.1;
    scene.ct_lb_ft_s_rad = 0.0;
    scene.wheel_load_lb = 0.0;
    scene.t_end_s = 0.02;
    sim_scene_set_list(&scene.gap0_ft, &none, 1);
    return scene;
}

static struct sim_result run_fixed(struct sim_scene *scene, double dt_s, double end_s)
{
    scene->t_end_s = end_s;
    return run(scene, (struct sim_options){.solver = "staggered", .dt_s = dt_s, .single = true});
}

/* Mat 2 leaves mat 1 at SPEED: T = KL v/w sin wt, w^2 = 2 KL/m, until it is TEAR; from then on each
 * goes its way, and what the joint's spring held is lost. */
static void torn_movement(double t_s, double *u1_ft, double *u2_ft)
{
    double w = sqrt(2.0 * KL), torn_s = asin(TEAR * w / (KL * SPEED)) / w;
    double middle_ft = 0.5 * SPEED * t_s, half_ft = 0.5 * SPEED / w * sin(w * torn_s) +
                                                    0.5 * SPEED * cos(w * torn_s) * (t_s - torn_s);
    *u1_ft = middle_ft - half_ft;
    *u2_ft = middle_ft + half_ft;
}

TEST(a_joint_tears_at_its_force_and_time)
{
    static const enum sim_model models[] = {SIM_CHAIN, SIM_CONSISTENT};
    double u1, u2, chain_u2 = 0.0;
    for (int i = 0; i < 2; i++) {
        struct sim_scene scene = two_mats(models[i]);
        scene.v0_ft_s = SPEED;
        scene.v0_mat = 2;
        scene.mods.tear_lb = TEAR;
        scene.mods.unhinge_deg = 30.0;
        for (double dt_s = 2e-5; dt_s > 0.9e-5; dt_s *= 0.5) {
            struct sim_result a = run_fixed(&scene, dt_s, 0.02), b = run_fixed(&scene, dt_s, 0.03);
            torn_movement(0.02, &u1, &u2);
            /* it is seen to be torn up to a step late: TEAR dt/m of speed */
            near(a.u_ft[1], u1, 2.0 * TEAR * dt_s * 0.02);
            near(a.u_ft[2], u2, 2.0 * TEAR * dt_s * 0.02);
            assert_true(a.mods->torn[2] == 1.0 && a.mods->unhinged_s[2] == 0.0);
            /* the chain notes its forces now and then */
            assert_true(a.pull_lb[2] < TEAR + KL * SPEED * 2.0 * dt_s);
            assert_true(i == 0 || a.pull_lb[2] > TEAR);
            double v1 = (b.u_ft[1] - a.u_ft[1]) / 0.01, v2 = (b.u_ft[2] - a.u_ft[2]) / 0.01;
            double energy = 0.5 * (v1 * v1 + v2 * v2);
            near(energy, 0.5 * SPEED * SPEED - 0.5 * TEAR * TEAR / KL, 4.0 * TEAR * dt_s * SPEED);
            if (i == 0)
                chain_u2 = a.u_ft[2];
            else if (dt_s < 1.5e-5) /* nothing heaves */
                near(a.u_ft[2], chain_u2, 1e-9);
            sim_result_free(&a);
            sim_result_free(&b);
        }
        sim_scene_free(&scene);
    }
}

TEST(one_that_is_not_pulled_so_far_holds)
{
    struct sim_scene scene = two_mats(SIM_CONSISTENT);
    scene.v0_ft_s = SPEED;
    scene.v0_mat = 2;
    scene.mods.tear_lb = SPEED * sqrt(KL / 2.0) * 1.001;
    scene.mods.unhinge_deg = 30.0;
    struct sim_result a = run_fixed(&scene, 1e-5, 0.1);
    assert_true(a.mods->torn[2] == 0.0);
    near(a.u_ft[1] + a.u_ft[2], SPEED * 0.1, 1e-9);
    near(a.u_ft[2] - a.u_ft[1], SPEED / sqrt(2.0 * KL) * sin(sqrt(2.0 * KL) * 0.1), 1e-4);
    sim_result_free(&a);
    sim_scene_free(&scene);
}

static void lift(struct sim_scene *scene, double middle_ft)
{
    double ends_ft = HIGH_FT - fmax(0.0, middle_ft);
    const double heights[] = {ends_ft, ends_ft + middle_ft, ends_ft};
    scene->bump_first = 1;
    sim_scene_set_list(&scene->bump_ft, heights, 3);
}

/* Two mats in free fall, turned upwards by 2 x 10 degrees. About their middles I q'' = -2 KT q
 * until they are in line; then nothing turns them, and they come to 30 degrees downwards. */
static struct sim_scene turning(double rate, double unhinge_deg)
{
    struct sim_scene scene = two_mats(SIM_CONSISTENT);
    scene.tad_deg = 0.0;
    scene.kt_lb_ft_rad = 0.5 * rate * rate * scene.inertia_slug_ft2;
    scene.mods.unhinge_deg = unhinge_deg;
    lift(&scene, sin(START));
    return scene;
}

static double unhinged_s(double dt_s, double unhinge_deg)
{
    struct sim_scene scene = turning(RATE, unhinge_deg);
    struct sim_result a = run_fixed(&scene, dt_s, 0.2);
    double at_s = a.mods->unhinged_s[2];
    assert_true((a.mods->torn[2] != 0.0) == (at_s > 0.0));
    sim_result_free(&a);
    sim_scene_free(&scene);
    return at_s;
}

TEST(a_joint_turned_downwards_parts)
{
    double expected_s = 0.5 * PI / RATE + 15.0 * PI / 180.0 / (RATE * START);
    double whole = unhinged_s(2e-5, 30.0) - expected_s, half = unhinged_s(1e-5, 30.0) - expected_s;
    near(whole, 0.0, 4e-5); /* two steps */
    near(half, 0.0, 2e-5);
    assert_true(unhinged_s(2e-5, 60.0) == 0.0); /* not there yet */
}

/* Ten times as fast they stand upright (85 degrees) before they have fallen far: then they lie on
 * the ground, where they stay. Joined they would end the run. */
TEST(a_mat_that_stands_upright_is_pushed_over)
{
    const double upright_s = (0.5 * PI + 85.0 / 10.0) / (10.0 * RATE), stations[] = {0.0, 1.0};
    struct sim_scene scene = turning(10.0 * RATE, 30.0);
    struct sim_options options = {.solver = "staggered",
                                  .dt_s = 1e-5,
                                  .single = true,
                                  .sample_dt_s = 1e-3,
                                  .station_ft = stations,
                                  .station_count = 2};
    scene.t_end_s = 0.06;
    struct sim_result a = run(&scene, options);
    double rest_ft = 0.5 * scene.weight_lb / scene.kv_lb_ft;
    for (size_t k = 0; k < a.sample_count; k++) {
        double t_s = 1e-3 * (double)k;
        if (t_s > upright_s + 1e-4)
            near(a.sample_y_ft[2 * k], -rest_ft, 1e-6);
        else if (t_s < upright_s - 1e-4)
            assert_true(a.sample_y_ft[2 * k] > 0.5);
    }
    assert_true(a.status == SIM_OK && a.sample_count > 55);
    sim_result_free(&a);
    sim_scene_free(&scene);
}

/* At the runway's end, on its way there at SPEED: standing it takes less room than lying. Lying it
 * stays where it was pushed over, and passes nothing on to the end. */
TEST(one_that_is_pushed_over_at_the_end_presses_nothing)
{
    const double gaps[] = {0.0, 0.0, 0.05};
    struct sim_scene scene = turning(10.0 * RATE, 30.0);
    scene.profile = SIM_FULL;
    scene.right = SIM_FIXED;
    scene.slack_ft = 10.0;
    scene.v0_ft_s = SPEED;
    scene.v0_mat = 2;
    sim_scene_set_list(&scene.gap0_ft, gaps, 3);
    struct sim_result a = run_fixed(&scene, 1e-5, 0.06);
    assert_true(a.push_lb[3] == 0.0);
    near(a.u_ft[2], SPEED * (0.5 * PI + 85.0 / 10.0) / (10.0 * RATE), 2.0 * SPEED * 1e-5);
    sim_result_free(&a);
    sim_scene_free(&scene);
}

/* The runway's end tears as a joint does, and what it felt is told up to then. */
TEST(a_torn_end_feels_no_more)
{
    const double dt_s = 1e-5;
    struct sim_scene scene = two_mats(SIM_CONSISTENT);
    scene.left = SIM_FIXED;
    scene.v0_ft_s = SPEED;
    scene.v0_mat = 1;
    scene.mods.tear_lb = 0.4 * TEAR;
    scene.mods.unhinge_deg = 30.0;
    struct sim_result a = run_fixed(&scene, dt_s, 0.1);
    assert_true(a.mods->torn[1] == 1.0);
    assert_true(a.pull_lb[1] > 0.4 * TEAR && a.pull_lb[1] < 0.4 * TEAR + 2.0 * KL * SPEED * dt_s);
    sim_result_free(&a);
    sim_scene_free(&scene);
}

/* Sixty mats on ground that is not level, and between the ends 0.068 ft too long: two stand as a
 * vee. Each mat turns about its foot until P lift = W L/2. */
static struct sim_scene standing(double unhinge_deg)
{
    struct sim_scene scene = apart(60);
    const double bump = 0.255;
    double gaps[61] = {0}, ground[61] = {0};
    gaps[29] = gaps[31] = -0.017;
    gaps[30] = -0.034;
    ground[5] = 1e-5;
    scene.model = SIM_CONSISTENT;
    scene.mods.band[0].count = 0.0;
    scene.profile = SIM_FULL;
    scene.left = scene.right = SIM_FIXED;
    scene.friction_law = SIM_STICK;
    scene.friction = 0.5;
    scene.kl_lb_ft = 10.0 * KL;
    scene.cl_lb_s_ft = 50.0;
    scene.kv_lb_ft = 1e4;
    scene.cv_lb_s_ft = 100.0;
    scene.inertia_slug_ft2 = 1.0 / 12.0;
    scene.tad_deg = 80.0;
    scene.mods.unhinge_deg = unhinge_deg;
    scene.bump_first = 31;
    sim_scene_set_list(&scene.bump_ft, &bump, 1);
    sim_scene_set_list(&scene.gap0_ft, gaps, 61);
    sim_scene_set_list(&scene.ground_ft, ground, 61);
    return scene;
}

TEST(a_wave_that_stands_stays_as_short_as_it_is)
{
    static const double unhinge_deg[] = {(double)INFINITY, 80.0};
    for (int i = 0; i < 2; i++) {
        struct sim_scene scene = standing(unhinge_deg[i]);
        struct sim_options options = {.solver = "staggered", .dt_s = 1e-4, .single = true};
        scene.t_end_s = 6.0;
        struct sim_result a = run(&scene, options);
        options.no_prune = true;
        struct sim_result all = run(&scene, options);
        double lift_ft = a.outputs[a.output_count - 1].lift_ft;
        assert_true(lift_ft > 0.2);
        near(a.push_lb[30], 0.5 * G / lift_ft, 5.0); /* it swings before it stands */
        for (int n = 1; n <= 60; n++)
            near(a.u_ft[n], all.u_ft[n], 1e-6);
        assert_true(a.mats_mean < 59.0);
        sim_result_free(&a);
        sim_result_free(&all);
        sim_scene_free(&scene);
    }
}

/* Turned by 35 degrees they part at once. The wheel stands on mat 1 alone: that falls with
 * g (1 + P/W), mat 2 with g. Then each lies on the ground by itself, a foot beside a foot. */
TEST(ends_that_are_apart_fall_by_themselves)
{
    const double stations[] = {0.0, 1.0};
    struct sim_scene scene = two_mats(SIM_CONSISTENT);
    scene.s0_ft = 0.5;
    scene.wheel_load_lb = 0.5 * scene.weight_lb;
    scene.mods.unhinge_deg = 30.0;
    scene.t_end_s = 0.1;
    lift(&scene, -0.3);
    struct sim_result a = run(&scene, (struct sim_options){.solver = "staggered",
                                                           .dt_s = 2e-5,
                                                           .single = true,
                                                           .sample_dt_s = 0.05,
                                                           .station_ft = stations,
                                                           .station_count = 2});
    for (size_t k = 0; k < a.sample_count && k < 3; k++) {
        double rest_ft = 0.5 * scene.weight_lb / scene.kv_lb_ft; /* settled */
        double t_s = 0.05 * (double)k, fall_ft = 0.5 * G * t_s * t_s;
        near(a.sample_y_ft[2 * k], HIGH_FT - rest_ft - 1.5 * fall_ft, 1e-3);
        near(a.sample_y_ft[2 * k + 1], HIGH_FT - 0.3 - rest_ft - fall_ft, 1e-3);
    }
    assert_true(a.sample_count >= 3 && a.mods->torn[2] == 1.0);
    sim_result_free(&a);
    sim_scene_free(&scene);
}

TEST(ends_that_are_not_level_pass_over_each_other)
{
    struct sim_scene scene = two_mats(SIM_CONSISTENT);
    struct parting *p;
    scene.mods.unhinge_deg = 30.0;
    scene.mods.unhinge_lap_ft = 0.02;
    p = parting_make(&scene);
    parting_part(p, 1, 0.0, 0.0);
    assert_true(parting_abuts(p, 1, -0.01, -0.019));
    assert_true(parting_abuts(p, 1, 0.01, -0.5)); /* open */
    assert_true(!parting_abuts(p, 1, -0.01, -0.021));
    assert_true(!parting_abuts(p, 1, -0.01, 0.0)); /* on top of it */
    assert_true(parting_abuts(p, 1, 0.001, 0.0));  /* drawn off */
    assert_true(parting_abuts(p, 1, -0.001, 0.0));
    parting_free(p);
    scene.mods.unhinge_deg = HUGE_VAL;
    p = parting_make(&scene);
    assert_null(p);
    sim_scene_free(&scene);
}

/* On flat ground nothing turns: what may part does as what cannot, and as the chain. */
TEST(a_flat_landing_is_as_without)
{
    struct sim_scene scene = runway();
    scene.mods.tear_lb = 20.0;
    struct sim_result chain = run(&scene, (struct sim_options){.dt_s = 2e-5, .single = true});
    scene.model = SIM_CONSISTENT;
    scene.inertia_slug_ft2 = 1.19e-4;
    scene.kv_lb_ft = 1.3e4;
    scene.cv_lb_s_ft = 60.0;
    scene.kt_lb_ft_rad = 41.6;
    scene.ct_lb_ft_s_rad = 1.6e-4;
    scene.tad_deg = 7.0;
    struct sim_result plain = run(&scene, (struct sim_options){.dt_s = 2e-5, .single = true});
    scene.mods.unhinge_deg = 30.0;
    struct sim_result parts = run(&scene, (struct sim_options){.dt_s = 2e-5, .single = true});
    int torn = 0;
    for (int n = 1; n <= 120; n++) {
        assert_true(plain.u_ft[n] == parts.u_ft[n]);
        near(chain.u_ft[n], parts.u_ft[n], 1e-9);
        torn += parts.mods->torn[n] != 0.0;
    }
    assert_true(torn > 0);
    sim_result_free(&chain);
    sim_result_free(&plain);
    sim_result_free(&parts);
    sim_scene_free(&scene);
}
