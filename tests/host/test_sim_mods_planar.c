/* Modifications of the runway in the planar landing: waves that bands and stiffeners hold down,
 * cleats that come out. Units ft, lb, s. */
#include "host/sim/elements/element.h"
#include "tests/host/mods_case.h"

static struct sim_scene planar_runway(void)
{
    struct sim_scene scene = runway();
    scene.model = SIM_MODEL_CONSISTENT;
    scene.inertia_slug_ft2 = 1.19e-4;
    scene.kv_lb_ft = 1.3e4;
    scene.cv_lb_s_ft = 60.0;
    scene.kt_lb_ft_rad = 41.6;
    scene.ct_lb_ft_s_rad = 1.6e-4;
    scene.tad_deg = 7.0;
    return scene;
}

/* Flat mats do not heave: the planar landing is the chain's, with all that is added. */
TEST(a_flat_landing_is_the_chains)
{
    struct sim_scene flat = planar_runway(), chain = runway();
    add_all(&flat);
    add_all(&chain);
    struct sim_result a = run(&flat, (struct sim_options){.dt_s = 2e-5});
    struct sim_result b = run(&chain, (struct sim_options){.dt_s = 2e-5});
    assert_true(a.max_lift_ft == 0.0 && b.peak_u_ft > 0.002);
    for (int n = 1; n <= 120; n++)
        near(a.u_ft[n], b.u_ft[n], 2.0 * (a.error_u_ft + b.error_u_ft));
    for (size_t i = 0; i < a.mods->segment_count; i++)
        near(a.mods->band_lb[i], b.mods->band_lb[i],
             2.0 * (a.mods->band_error_lb + b.mods->band_error_lb) + 0.1);
    for (size_t i = 0; i < a.mods->cleat_count; i++)
        near(a.mods->cleat_remaining_share[i], b.mods->cleat_remaining_share[i], 0.02);
    sim_result_free(&a);
    sim_result_free(&b);
    sim_scene_free(&flat);
    sim_scene_free(&chain);
}

/* Forces of a band over a vee of height h at node 5 (from 0) between rivets in the middles of mats
 * 3 and 9: 2 T h/L where it follows the mats; T h (1/a + 1/b) where it is free from rivet to rivet,
 * and the rivets are pulled up by as much. */
TEST(a_taut_band_holds_a_vee_down)
{
    const double t0 = 50.0, h = 0.1;
    struct sim_scene scene = apart(12);
    struct mods *mods;
    double z[50] = {0}, down[14], moment[14];
    scene.mods.band[0].count = 2.0;
    rivet(&scene, 6, 3, 9);
    tension(&scene, &t0, 1);
    z[2 * 5] = -h;
    struct mods_heaving_part heave = {.z = z,
                                      .mats = 12,
                                      .length_ft = 1.0,
                                      .first = 0,
                                      .last = 11,
                                      .down_lb = down,
                                      .moment_lb_ft = moment};
    mods = mods_make(&scene);
    mods_compute_vertical_forces(mods, &heave);
    for (int j = 0; j <= 12; j++)
        near(down[j], j == 5 ? 2.0 * 2.0 * t0 * h : 0.0, 1e-12);
    mods_free(mods);
    scene.mods.band[0].acts_on = SIM_BAND_OVER_RIVETS;
    mods = mods_make(&scene);
    z[2 * 6] = -0.02; /* below the line from the crest to the rivet */
    mods_compute_vertical_forces(mods, &heave);
    double sum = 0.0, about = 0.0, left = 2.0 * t0 * h / 2.5, right = 2.0 * t0 * h / 3.5;
    for (int j = 0; j <= 12; j++) {
        sum += down[j];
        about += down[j] * j;
        double expected = j == 5           ? left + right
                        : j == 2 || j == 3 ? -0.5 * left
                        : j == 8 || j == 9 ? -0.5 * right
                                           : 0.0;
        near(down[j], expected, 1e-12);
    }
    near(sum, 0.0, 1e-12);
    near(about, 0.0, 1e-12);
    mods_free(mods);
    sim_scene_free(&scene);
}

/* Stiffeners over all joints that turn freely otherwise are joints without free rotation: the same
 * run. */
TEST(stiffeners_are_stiff_joints)
{
    double heights[121] = {0};
    for (int i = 0; i < 2; i++) {
        struct sim_scene a = planar_runway(), b = planar_runway();
        struct sim_scene *both[2] = {&a, &b};
        for (int k = 0; k < 2; k++) {
            for (int j = 20; j < 60; j++)
                heights[j] = 0.003 * (j % 3);
            both[k]->bump_first = 1;
            both[k]->profile = SIM_PROFILE_FULL;
            both[k]->ct_lb_ft_s_rad = 0.0;
            sim_scene_set_list(&both[k]->bump_ft, heights, 121);
        }
        a.kt_lb_ft_rad = 20.0;
        a.tad_deg = 0.0;
        b.kt_lb_ft_rad = 0.0;
        b.mods.stiffener_span_mats = 120;
        b.mods.stiffener_first_mat = 1;
        b.mods.stiffener_line_count = 1;
        b.mods.stiffener_kt_lb_ft_rad = 20.0;
        b.mods.stiffener_yield_lb_ft = i ? 1e-3 : HUGE_VAL;
        struct sim_result ra = run(&a, (struct sim_options){.dt_s = 2e-5});
        struct sim_result rb = run(&b, (struct sim_options){.dt_s = 2e-5});
        assert_true(ra.max_lift_ft > 0.0);
        double apart_ft = 0.0;
        for (int n = 1; n <= 120; n++)
            apart_ft = fmax(apart_ft, fabs(ra.u_ft[n] - rb.u_ft[n]));
        if (i == 0) {
            near(ra.max_lift_ft, rb.max_lift_ft, 1e-9);
            near(apart_ft, 0.0, 1e-7);
        } else
            assert_true(apart_ft > 1e-7); /* they have bent */
        sim_result_free(&ra);
        sim_result_free(&rb);
        sim_scene_free(&a);
        sim_scene_free(&b);
    }
}

/* Half out of the ground a cleat holds a quarter, and half of it bends when the wheel comes. */
TEST(a_raised_cleat_holds_less)
{
    struct sim_scene scene = apart(4);
    struct mods *mods;
    scene.mods.band[0].count = 0.0;
    scene.mods.cleat_every = 2;
    scene.mods.cleat_hold_lb = 8.0;
    scene.mods.cleat_depth_ft = 0.06;
    mods = mods_make(&scene);
    near(mods_raised_cleat_hold_lb(mods, 2, 0.001, 0.001), 8.0, 1e-12); /* pressed into the soil */
    near(mods_raised_cleat_hold_lb(mods, 2, -0.02, -0.04), 2.0, 1e-12);
    near(mods_raised_cleat_hold_lb(mods, 2, -1.0, 0.0), 0.0, 1e-12); /* 1/2 ft up: altogether out */
    near(mods_raised_cleat_hold_lb(mods, 3, 0.0, 0.0), 0.0, 1e-12);
    mods_reset(mods);
    near(mods_raised_cleat_hold_lb(mods, 4, -0.03, -0.03), 2.0, 1e-12);
    const struct sim_touch wheel = {4, 1.0, 1.0};
    mods_bend_raised_cleats(mods, &wheel, 1);
    near(mods_cleat_hold_lb(mods, 4), 4.0, 1e-12);
    mods_bend_raised_cleats(mods, &wheel, 1); /* it has not risen again */
    near(mods_cleat_hold_lb(mods, 4), 4.0, 1e-12);
    near(mods_cleat_hold_lb(mods, 2), 8.0, 1e-12);
    mods_free(mods);
    sim_scene_free(&scene);
}

/* Of cohesion alone it holds as deep as it is. Pressed back from half its depth it turns by 60
 * degrees at its root, of which 30 spring back: cos 30 degrees of its depth. Of a tenth, 26
 * degrees, nothing stays. */
TEST(a_cleat_that_is_pressed_back_turns_at_its_root)
{
    static const double powers[] = {1.0, 2.0}, halves_lb[] = {4.0, 2.0},
                        springing_lb[] = {6.92820323027551, 6.0};
    const struct sim_touch wheel = {2, 1.0, 1.0};
    for (int i = 0; i < 2; i++) {
        struct sim_scene scene = apart(4);
        struct mods *mods;
        scene.mods.band[0].count = 0.0;
        scene.mods.cleat_every = 2;
        scene.mods.cleat_hold_lb = 8.0;
        scene.mods.cleat_depth_ft = 0.06;
        scene.mods.cleat_exponent = powers[i];
        mods = mods_make(&scene);
        near(mods_raised_cleat_hold_lb(mods, 2, -0.03, -0.03), halves_lb[i], 1e-12);
        mods_bend_raised_cleats(mods, &wheel, 1);
        near(mods_cleat_hold_lb(mods, 2), halves_lb[i], 1e-12);
        scene.mods.cleat_spring_deg = 30.0;
        mods_reset(mods);
        mods_raised_cleat_hold_lb(mods, 2, -0.03, -0.03);
        mods_bend_raised_cleats(mods, &wheel, 1);
        near(mods_cleat_hold_lb(mods, 2), springing_lb[i], 1e-12);
        mods_reset(mods);
        mods_raised_cleat_hold_lb(mods, 2, -0.006, -0.006);
        mods_bend_raised_cleats(mods, &wheel, 1);
        near(mods_cleat_hold_lb(mods, 2), 8.0, 1e-12);
        mods_free(mods);
        sim_scene_free(&scene);
    }
}

/* Mats 5 to 11 are one rigid block; an axle stands on its first joint, a quarter of its load on
 * node 4, half on node 5, a quarter on node 6. The mats beside it add half a weight at its ends. It
 * sinks by y0 - i s at its nodes i = 0..7, on springs of 2 KV that do not pull: nodes 0 to 2 bear,
 * so that with F and M all forces and their moment about node 0 over L
 *     3 y0 - 3 s = F/(2 KV)    3 y0 - 5 s = M/(2 KV)
 * and the far end is 7 s - y0 high. */
TEST(a_wheel_tips_a_stiffened_block)
{
    const double length_ft = 2.0 / 7.0, weight_lb = 0.466, load_lb = 108.3, kv = 1.3e4;
    const double lines_ft = 0.0, stations[] = {4.0 * length_ft, 11.0 * length_ft};
    struct sim_scene scene = apart(16);
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mods.band[0].count = 0.0;
    scene.length_ft = length_ft;
    scene.weight_lb = weight_lb;
    scene.inertia_slug_ft2 = 1.19e-4;
    scene.kv_lb_ft = kv;
    scene.cv_lb_s_ft = 60.0;
    scene.kt_lb_ft_rad = 41.6;
    scene.ct_lb_ft_s_rad = 0.0;
    scene.tad_deg = 7.0;
    scene.start_ft = 4.0 * length_ft;
    scene.wheel_load_lb = load_lb;
    scene.element_values[ELEMENT_gear_ground] = 7000.0;
    scene.gear.axle_length_ft = length_ft;
    sim_scene_set_list(&scene.gear.line_setbacks_ft, &lines_ft, 1);
    scene.mods.stiffener_span_mats = 7;
    scene.mods.stiffener_free_joints = 50;
    scene.mods.stiffener_first_mat = 5;
    scene.mods.stiffener_kt_lb_ft_rad = 1e5;
    scene.t_end_s = 0.5;
    struct sim_result a = run(&scene, (struct sim_options){.solver = "staggered",
                                                           .dt_s = 1e-5,
                                                           .is_single_pass = true,
                                                           .sample_dt_s = 0.25,
                                                           .station_ft = stations,
                                                           .station_count = 2});
    double f = (0.75 * load_lb + 8.0 * weight_lb) / (2.0 * kv);
    double m = (0.25 * load_lb + 28.0 * weight_lb) / (2.0 * kv);
    double s = 0.5 * (f - m), y0 = f / 3.0 + s;
    assert_true(y0 - 2.0 * s > 0.0 && y0 - 3.0 * s < 0.0);
    assert_true(a.sample_count >= 3);
    near(a.sample_y_ft[2 * 2 + 1], 7.0 * s - y0, 0.03 * (7.0 * s - y0)); /* 0.049 in */
    near(a.sample_y_ft[2 * 2], -y0, 0.03 * y0);
    sim_result_free(&a);
    scene.mods.stiffener_kt_lb_ft_rad = 0.0; /* hinges: nothing rises */
    a = run(&scene,
            (struct sim_options){.solver = "staggered", .dt_s = 1e-5, .is_single_pass = true});
    assert_true(a.max_lift_ft == 0.0);
    sim_result_free(&a);
    sim_scene_free(&scene);
}

/* --- absence and errors --- */

TEST(what_is_absent_changes_nothing)
{
    struct sim_scene scene = runway();
    struct sim_result plain = run(&scene, (struct sim_options){.dt_s = 5e-5});
    assert_null(plain.mods);
    scene.mods.band[0].grip_lb = 3.0; /* of no bands */
    scene.mods.cleat_hold_lb = 3.0;
    scene.mods.stiffener_k_lb_ft = 3.0;
    struct sim_result still = run(&scene, (struct sim_options){.dt_s = 5e-5});
    assert_null(still.mods);
    add_all(&scene); /* present but of no strength */
    const double zero = 0.0;
    tension(&scene, &zero, 1);
    scene.mods.band[0].count = scene.mods.band[1].count = 1e-300;
    scene.mods.cleat_hold_lb = 0.0;
    scene.mods.stiffener_k_lb_ft = 0.0;
    scene.mods.tear_lb = 1e9;
    struct sim_result weak = run(&scene, (struct sim_options){.dt_s = 5e-5});
    for (int n = 1; n <= 120; n++)
        assert_true(plain.u_ft[n] == still.u_ft[n] && plain.u_ft[n] == weak.u_ft[n]);
    sim_result_free(&plain);
    sim_result_free(&still);
    sim_result_free(&weak);
    sim_scene_free(&scene);
}

/* --- joints that tear, and a wave that stands --- */

#define TEAR  100.0
#define SPEED 2.0
#define KL    1e4

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
    return run(scene,
               (struct sim_options){.solver = "staggered", .dt_s = dt_s, .is_single_pass = true});
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
    static const enum sim_model models[] = {SIM_MODEL_CHAIN, SIM_MODEL_CONSISTENT};
    double u1, u2, chain_u2 = 0.0;
    for (int i = 0; i < 2; i++) {
        struct sim_scene scene = two_mats(models[i]);
        scene.v0_ft_s = SPEED;
        scene.v0_mat = 2;
        scene.mods.tear_lb = TEAR;
        for (double dt_s = 2e-5; dt_s > 0.9e-5; dt_s *= 0.5) {
            struct sim_result a = run_fixed(&scene, dt_s, 0.02), b = run_fixed(&scene, dt_s, 0.03);
            torn_movement(0.02, &u1, &u2);
            /* it is seen to be torn up to a step late: TEAR dt/m of speed */
            near(a.u_ft[1], u1, 2.0 * TEAR * dt_s * 0.02);
            near(a.u_ft[2], u2, 2.0 * TEAR * dt_s * 0.02);
            assert_true(a.mods->torn[2] == 1.0);
            /* the chain notes its forces now and then */
            assert_true(a.max_tension_lb[2] < TEAR + KL * SPEED * 2.0 * dt_s);
            assert_true(i == 0 || a.max_tension_lb[2] > TEAR);
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
    struct sim_scene scene = two_mats(SIM_MODEL_CONSISTENT);
    scene.v0_ft_s = SPEED;
    scene.v0_mat = 2;
    scene.mods.tear_lb = SPEED * sqrt(KL / 2.0) * 1.001;
    struct sim_result a = run_fixed(&scene, 1e-5, 0.1);
    assert_true(a.mods->torn[2] == 0.0);
    near(a.u_ft[1] + a.u_ft[2], SPEED * 0.1, 1e-9);
    near(a.u_ft[2] - a.u_ft[1], SPEED / sqrt(2.0 * KL) * sin(sqrt(2.0 * KL) * 0.1), 1e-4);
    sim_result_free(&a);
    sim_scene_free(&scene);
}

TEST(a_torn_end_feels_no_more)
{
    const double dt_s = 1e-5;
    struct sim_scene scene = two_mats(SIM_MODEL_CONSISTENT);
    scene.left_end = SIM_END_FIXED;
    scene.v0_ft_s = SPEED;
    scene.v0_mat = 1;
    scene.mods.tear_lb = 0.4 * TEAR;
    struct sim_result a = run_fixed(&scene, dt_s, 0.1);
    assert_true(a.mods->torn[1] == 1.0);
    assert_true(a.max_tension_lb[1] > 0.4 * TEAR &&
                a.max_tension_lb[1] < 0.4 * TEAR + 2.0 * KL * SPEED * dt_s);
    sim_result_free(&a);
    sim_scene_free(&scene);
}

/* Sixty mats on ground that is not level, and between the ends 0.068 ft too long: two stand as a
 * vee. Each mat turns about its foot until P lift = W L/2. */
static struct sim_scene standing(void)
{
    struct sim_scene scene = apart(60);
    const double bump = 0.255;
    double gaps[61] = {0}, ground[61] = {0};
    gaps[29] = gaps[31] = -0.017;
    gaps[30] = -0.034;
    ground[5] = 1e-5;
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mods.band[0].count = 0.0;
    scene.profile = SIM_PROFILE_FULL;
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.friction_law = SIM_FRICTION_STICK;
    scene.friction = 0.5;
    scene.kl_lb_ft = 10.0 * KL;
    scene.cl_lb_s_ft = 50.0;
    scene.kv_lb_ft = 1e4;
    scene.cv_lb_s_ft = 100.0;
    scene.inertia_slug_ft2 = 1.0 / 12.0;
    scene.tad_deg = 80.0;
    scene.bump_first = 31;
    sim_scene_set_list(&scene.bump_ft, &bump, 1);
    sim_scene_set_list(&scene.gap0_ft, gaps, 61);
    sim_scene_set_list(&scene.ground_ft, ground, 61);
    return scene;
}

TEST(a_wave_that_stands_stays_as_short_as_it_is)
{
    struct sim_scene scene = standing();
    struct sim_options options = {.solver = "staggered", .dt_s = 1e-4, .is_single_pass = true};
    scene.t_end_s = 6.0;
    struct sim_result a = run(&scene, options);
    options.integrates_all_mats = true;
    struct sim_result all = run(&scene, options);
    double lift_ft = a.outputs[a.output_count - 1].lift_ft;
    assert_true(lift_ft > 0.2);
    near(a.max_compression_lb[30], 0.5 * G / lift_ft, 5.0); /* it swings before it stands */
    for (int n = 1; n <= 60; n++)
        near(a.u_ft[n], all.u_ft[n], 1e-6);
    assert_true(a.integrated_mats_mean < 59.0);
    sim_result_free(&a);
    sim_result_free(&all);
    sim_scene_free(&scene);
}
