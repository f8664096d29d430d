/* Whole landings with the consistent model: against the chain where nothing heaves, against the
 * solver that locates every switch where it does, and against itself with nothing left out. */

#include "host/sim/elements/element.h"
#include "tests/host/sim_case.h"
#include "tests/host/model_mat.h"

/* Flat mats without a wheel load do not heave: the planar landing is the chain's. */
TEST(a_flat_landing_is_the_chains)
{
    for (int variant = 0; variant < 3; variant++) {
        const double none = 0.0;
        struct sim_scene flat = short_runway(SIM_MODEL_CONSISTENT),
                         chain = short_runway(SIM_MODEL_CHAIN);
        struct sim_scene *both[2] = {&flat, &chain};
        for (int i = 0; i < 2; i++) {
            if (variant == 1)
                both[i]->profile = SIM_PROFILE_FULL;
            if (variant == 2)
                sim_scene_set_list(&both[i]->grit_lb, &none, 1);
        }
        struct sim_result a = run(&flat, (struct sim_options){.dt_s = 4e-5});
        struct sim_result b = run(&chain, (struct sim_options){.dt_s = 2e-5});
        assert_string_equal(a.solver, "staggered");
        assert_true(b.peak_u_ft > 0.005);
        assert_true(a.max_lift_ft == 0.0);
        /* same scheme, twice the step: apart by less than the two estimates together */
        for (int n = 1; n <= 80; n++)
            assert_true(fabs(a.u_ft[n] - b.u_ft[n]) < 2.0 * (a.error_u_ft + b.error_u_ft));
        sim_result_free(&a);
        sim_result_free(&b);
        sim_scene_free(&flat);
        sim_scene_free(&chain);
    }
}

TEST(leaving_mats_out_changes_nothing)
{
    for (int variant = 0; variant < 5; variant++) {
        struct sim_scene scene = short_runway(SIM_MODEL_CONSISTENT);
        double heights[81];
        for (int j = 0; j <= 80; j++)
            heights[j] = 0.0036 * uneven(j + 33);
        if (variant > 0)
            sim_scene_set_list(&scene.bump_ft, heights, variant == 3 ? 20 : 81);
        scene.bump_first = 1;
        if (variant == 2) {
            scene.wheel_load_lb = 3.0;
            scene.friction_normal = SIM_NORMAL_SOIL;
            scene.profile = SIM_PROFILE_FULL;
        }
        if (variant == 4)
            scene.element_values[ELEMENT_ground_damping] = 0.3;
        struct sim_result pruned = run(&scene, (struct sim_options){.dt_s = 4e-5});
        struct sim_result whole =
            run(&scene, (struct sim_options){.dt_s = 4e-5, .integrates_all_mats = true});
        assert_true(whole.integrated_mats_mean > 79.99 && pruned.integrated_mats_mean < 60.0);
        assert_true(pruned.peak_u_ft > 0.005);
        /* exact, but for a heaving part that is held back at its ends: switches of a fixed step
         * amplify that */
        double apart_ft = variant == 2 ? 0.05 * whole.error_u_ft : 0.0;
        for (int n = 1; n <= 80; n++)
            assert_true(fabs(pruned.u_ft[n] - whole.u_ft[n]) <= apart_ft);
        assert_true(fabs(pruned.max_lift_ft - whole.max_lift_ft) <= apart_ft);
        sim_result_free(&pruned);
        sim_result_free(&whole);
        sim_scene_free(&scene);
    }
}

/* Numbers 0 to 1 that look scattered: fixed from seed to seed. */
static double draw(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) / 9007199254740992.0;
}

static int pick(uint64_t *seed, int count)
{
    return (int)(draw(seed) * count);
}

/* A landing that starts before, on or beyond the runway and rolls either way over bumps, pressed
 * joints and slack. */
static struct sim_scene scattered(uint64_t seed)
{
    struct sim_scene scene;
    double gaps[201] = {0}, bump[5];
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mats = pick(&seed, 6) == 0 ? 1 + pick(&seed, 4) : 5 + pick(&seed, 195);
    scene.profile = pick(&seed, 3) == 0 ? SIM_PROFILE_FULL : SIM_PROFILE_LOW;
    scene.friction_normal = pick(&seed, 3) == 0 ? SIM_NORMAL_SOIL : SIM_NORMAL_WEIGHT;
    scene.friction_law = pick(&seed, 8) == 0 ? SIM_FRICTION_NONE : SIM_FRICTION_STICK;
    scene.wheel_load_lb = pick(&seed, 3) == 0 ? 2000.0 * draw(&seed) : 0.0;
    scene.thrust = pick(&seed, 2) == 0 ? SIM_THRUST_LINEAR : SIM_THRUST_JUMP;
    scene.slack_ft = pick(&seed, 3) == 0 ? 0.01 * draw(&seed) : 0.0;
    scene.tad_deg = pick(&seed, 3) == 0 ? draw(&seed) : 10.0;
    scene.left_end = pick(&seed, 2) == 0 ? SIM_END_FIXED : SIM_END_FREE;
    scene.v0_ft_s = 4.0 * draw(&seed) - 2.0;
    scene.v0_mat = 1 + pick(&seed, scene.mats);
    if (scene.slack_ft > 0.0 && pick(&seed, 2) == 0) {
        const double grit = 1000.0 * draw(&seed);
        sim_scene_set_list(&scene.grit_lb, &grit, 1);
    }
    for (int i = 0; i < 2; i++)
        gaps[pick(&seed, scene.mats + 1)] = -2e-4 * draw(&seed);
    sim_scene_set_list(&scene.gap0_ft, gaps, (size_t)scene.mats + 1);
    scene.bump_first = 1 + pick(&seed, scene.mats);
    for (int i = 0; i < 5; i++)
        bump[i] = 0.02 + 0.03 * draw(&seed);
    int bumps = scene.mats + 2 - scene.bump_first;
    sim_scene_set_list(&scene.bump_ft, bump, (size_t)(bumps < 5 ? bumps : 5));
    double x_ft = (1.2 * draw(&seed) - 0.1) * scene.mats * 2.0, end_s = 0.03 + 0.07 * draw(&seed);
    double speed = (draw(&seed) < 0.8 ? 1.0 : -1.0) * (20.0 + 100.0 * draw(&seed)),
           f = 500.0 + 15000.0 * draw(&seed);
    const struct sim_path_row rows[] = {{0.1 * end_s, x_ft, 0.0},
                                        {0.3 * end_s, x_ft + 0.2 * speed * end_s, f},
                                        {0.7 * end_s, x_ft + 0.5 * speed * end_s, 0.8 * f},
                                        {end_s, x_ft + 0.6 * speed * end_s, 0.0}};
    sim_scene_set_path(&scene, rows, 4);
    scene.t_end_s = end_s * (0.8 + 0.5 * draw(&seed));
    return scene;
}

TEST(leaving_mats_out_of_scattered_landings_changes_nothing)
{
    int compared = 0, lighter = 0;
    for (uint64_t seed = 1; seed <= 103; seed++) {
        /* and: soil friction lets go of a mat that nobody pushes; the wheel comes on far from what
         * moves */
        struct sim_scene scene = scattered(seed == 101   ? 674
                                           : seed == 102 ? 727
                                           : seed == 103 ? 158
                                                         : seed);
        struct sim_result results[2];
        double stations[200];
        for (int n = 0; n < scene.mats; n++)
            stations[n] = n * scene.length_ft;
        for (int whole = 0; whole < 2; whole++) {
            struct sim_options options = {.integrates_all_mats = whole,
                                          .sample_dt_s = scene.t_end_s / 20.0,
                                          .station_ft = stations,
                                          .station_count = (size_t)scene.mats};
            memset(&error, 0, sizeof error);
            sim_run(&scene, &options, &results[whole], &error);
        }
        assert_int_equal(results[0].status, results[1].status);
        if (results[0].status == SIM_OK) {
            const struct sim_result *a = &results[0], *b = &results[1];
            /* what the ends of the heaving part hold back, amplified by switches of a fixed step */
            double apart_ft = fmax(1e-9, 0.05 * fmax(b->error_u_ft, b->error_lift_ft));
            for (size_t k = 0; k < a->sample_count * a->station_count; k++) {
                if (!(fabs(a->sample_u_ft[k] - b->sample_u_ft[k]) <= apart_ft &&
                      fabs(a->sample_y_ft[k] - b->sample_y_ft[k]) <= apart_ft))
                    fail_msg("landing %d: u %g and %g, height %g and %g", (int)seed,
                             a->sample_u_ft[k], b->sample_u_ft[k], a->sample_y_ft[k],
                             b->sample_y_ft[k]);
            }
            compared++;
            lighter += a->integrated_mats_mean < 0.9 * b->integrated_mats_mean;
        }
        sim_result_free(&results[0]);
        sim_result_free(&results[1]);
        sim_scene_free(&scene);
    }
    assert_true(compared >= 95 && lighter >= 25);
}

/* A mat at rest feels its neighbour's damper let go one step after that neighbour has stopped. */
TEST(a_mat_at_rest_is_left_after_its_neighbour)
{
    struct sim_scene scene;
    struct sim_result results[2];
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mats = 190;
    scene.right_end = SIM_END_FREE;
    scene.force_lb = 206.442;
    scene.vac_ft_s = 136.575;
    scene.v0_ft_s = 2.88867;
    scene.wheel_load_lb = 1179.51;
    scene.t_end_s = 0.0152981;
    for (int whole = 0; whole < 2; whole++)
        results[whole] =
            run(&scene, (struct sim_options){.solver = "staggered", .integrates_all_mats = whole});
    assert_true(results[0].integrated_mats_mean < 50.0 && results[0].peak_u_ft > 1e-3);
    for (int n = 1; n <= 190; n++)
        assert_true(fabs(results[0].u_ft[n] - results[1].u_ft[n]) <= 1e-12);
    sim_result_free(&results[0]);
    sim_result_free(&results[1]);
    sim_scene_free(&scene);
}

/* A bow wave on ten mats: the fixed step converges to what the solver finds that locates every
 * switch. */
TEST(it_converges_to_located_switches)
{
    const double bump[] = {0.0099, 0.02, 0.0099};
    for (int variant = 0; variant < 3; variant++) {
        struct sim_scene scene;
        sim_scene_set_defaults(&scene);
        scene.model = SIM_MODEL_CONSISTENT;
        scene.mats = 30;
        scene.slack_ft = variant == 1 ? 0.02 : 0.0;
        scene.profile = variant == 2 ? SIM_PROFILE_FULL : SIM_PROFILE_LOW;
        sim_scene_set_list(&scene.bump_ft, bump, 3);
        struct sim_result truth = run(&scene, (struct sim_options){.solver = "event"});
        double before_u = 0.0, before_lift = 0.0;
        for (int halving = 0; halving < 3; halving++) {
            struct sim_options options = {.solver = "staggered", .dt_s = ldexp(2e-5, -2 * halving)};
            struct sim_result fixed = run(&scene, options);
            double off_u = 0.0, off_lift = fabs(fixed.max_lift_ft - truth.max_lift_ft);
            for (int n = 1; n <= 30; n++)
                off_u = fmax(off_u, fabs(fixed.u_ft[n] - truth.u_ft[n]));
            assert_true(off_u < 3.0 * fixed.error_u_ft + 1e-7);
            assert_true(off_lift < 3.0 * fixed.error_lift_ft + 1e-6);
            if (halving > 0)
                assert_true(off_u < 0.5 * before_u && off_lift < 0.5 * before_lift);
            before_u = off_u;
            before_lift = off_lift;
            sim_result_free(&fixed);
        }
        assert_true(truth.peak_u_ft > 0.01 && before_u < 0.01 * truth.peak_u_ft);
        sim_result_free(&truth);
        sim_scene_free(&scene);
    }
}

TEST(what_it_cannot_do_is_refused)
{
    struct sim_scene scene = short_runway(SIM_MODEL_CONSISTENT);
    struct sim_result result;
    memset(&error, 0, sizeof error);
    assert_int_equal(sim_run(&scene, &(struct sim_options){.dt_s = 1e-3}, &result, &error),
                     MR_NUMERICS);
    assert_int_equal(result.status, SIM_UNSTABLE);
    assert_non_null(strstr(error.text, "stability limit"));
    sim_result_free(&result);
    memset(&error, 0, sizeof error);
    assert_int_equal(sim_run(&scene, &(struct sim_options){.solver = "event"}, &result, &error),
                     MR_USAGE);
    assert_non_null(strstr(error.text, "grit"));
    sim_result_free(&result);
    memset(&error, 0, sizeof error);
    scene.friction_law = SIM_FRICTION_TANH;
    assert_int_equal(sim_run(&scene, &(struct sim_options){0}, &result, &error), MR_USAGE);
    assert_non_null(strstr(error.text, "tanh"));
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* --- stated errors hold the true ones: every pair of ends, profile and law, then what stiff
 * soil does to friction and to neighbours. Truth is `event`, which locates every switch and
 * integrates by another method --- */

#define END_MATS    8
#define END_OUTPUTS 16

static struct sim_scene small_scene(int bump_first, size_t bumps, double end_s)
{
    static const double bump_ft[] = {0.0099, 0.02, 0.0099};
    struct sim_scene scene;
    double times_s[END_OUTPUTS];
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mats = END_MATS;
    scene.bump_first = bump_first;
    scene.t_end_s = end_s;
    for (int i = 0; i < END_OUTPUTS; i++)
        times_s[i] = scene.t_end_s * (i + 1) / END_OUTPUTS;
    sim_scene_set_list(&scene.bump_ft, bump_ft, bumps);
    sim_scene_set_list(&scene.t_out_s, times_s, END_OUTPUTS);
    return scene;
}

/* Runs a scene with both and frees it. */
static bool held_against(const char *located, struct sim_scene *scene, const char *what)
{
    struct sim_result fixed = run(scene, (struct sim_options){.solver = "staggered"}),
                      truth = run(scene, (struct sim_options){.solver = located, .rtol = 1e-11});
    double off_u_ft = 0.0, off_lift_ft = fabs(fixed.max_lift_ft - truth.max_lift_ft);
    for (size_t i = 0; i < END_OUTPUTS; i++) {
        off_lift_ft = fmax(off_lift_ft, fabs(fixed.outputs[i].lift_ft - truth.outputs[i].lift_ft));
        for (int n = 1; n <= scene->mats; n++)
            off_u_ft = fmax(off_u_ft, fabs(fixed.outputs[i].u_ft[n] - truth.outputs[i].u_ft[n]));
    }
    bool holds = off_u_ft <= fixed.error_u_ft + truth.error_u_ft + 1e-9 &&
                 off_lift_ft <= fixed.error_lift_ft + truth.error_lift_ft + 1e-9;
    if (!holds)
        print_error("%s: u is off by %g ft (stated %g), lift by %g ft (stated %g)\n", what,
                    off_u_ft, fixed.error_u_ft, off_lift_ft, fixed.error_lift_ft);
    assert_true(truth.peak_u_ft > 1e-6 && truth.max_lift_ft > 1e-3);
    assert_true(fixed.error_u_ft < 0.1 * truth.peak_u_ft);
    sim_result_free(&fixed);
    sim_result_free(&truth);
    sim_scene_free(scene);
    return holds;
}

TEST(every_end_profile_and_law)
{
    static const struct {
        const char *name;
        enum sim_friction law;
        enum sim_normal normal;
    } laws[] = {{"stick", SIM_FRICTION_STICK, SIM_NORMAL_WEIGHT},
                {"stick on soil", SIM_FRICTION_STICK, SIM_NORMAL_SOIL},
                {"none", SIM_FRICTION_NONE, SIM_NORMAL_WEIGHT}};
    int wrong = 0;
    for (int i = 0; i < 4 * 2 * 3; i++) {
        char what[80];
        struct sim_scene scene = small_scene(1, 3, 0.01); /* mat 1 is tilted */
        scene.left_end = i & 1 ? SIM_END_FIXED : SIM_END_FREE;
        scene.right_end = i & 2 ? SIM_END_FIXED : SIM_END_FREE;
        scene.profile = i & 4 ? SIM_PROFILE_FULL : SIM_PROFILE_LOW;
        scene.friction_law = laws[i / 8].law;
        scene.friction_normal = laws[i / 8].normal;
        scene.wheel_load_lb = i % 3 == 0 ? 500.0 : 0.0;
        snprintf(what, sizeof what, "left %s, right %s, profile %s, friction %s",
                 i & 1 ? "fixed" : "free", i & 2 ? "fixed" : "free", i & 4 ? "full" : "low",
                 laws[i / 8].name);
        wrong += !held_against("event", &scene, what);
    }
    assert_int_equal(wrong, 0);
}

/* Soil that stops a foot within a small part of a step: friction takes the impulse of that landing,
 * not more. */
TEST(friction_of_a_foot_that_lands_hard)
{
    struct sim_scene scene = small_scene(1, 1, 0.02);
    scene.left_end = scene.right_end = SIM_END_FREE;
    scene.left_torsion = SIM_END_FIXED;
    scene.friction_normal = SIM_NORMAL_SOIL;
    scene.friction = 0.2;
    scene.weight_lb = scene.wheel_load_lb = 1480.0;
    scene.inertia_slug_ft2 = 18.5;
    scene.kv_lb_ft = 1.15e7;
    scene.cv_lb_s_ft = 1.44e7;
    scene.kl_lb_ft = 3.02e5;
    scene.cl_lb_s_ft = 489.0;
    scene.kt_lb_ft_rad = 1e6;
    scene.slack_ft = 0.005;
    scene.tad_deg = 0.0;
    scene.force_lb = 11100.0;
    scene.vac_ft_s = 60.0;
    scene.thrust = SIM_THRUST_LINEAR;
    scene.v0_ft_s = 0.0;
    assert_true(held_against("event", &scene, "soil friction"));
}

/* A foot that lands lifts its neighbour off at once: the soil does not hold it down for that
 * step. */
TEST(soil_does_not_hold_a_neighbour_down)
{
    struct sim_scene scene = small_scene(3, 1, 0.02);
    scene.left_end = scene.right_end = SIM_END_FREE;
    scene.left_torsion = SIM_END_FIXED;
    scene.friction_normal = SIM_NORMAL_SOIL;
    scene.friction = 0.2;
    scene.weight_lb = scene.wheel_load_lb = 14600.0;
    scene.inertia_slug_ft2 = 3.52;
    scene.kv_lb_ft = 1.87e8;
    scene.cv_lb_s_ft = 7.57e6;
    scene.kl_lb_ft = 3.6e6;
    scene.cl_lb_s_ft = 9230.0;
    scene.kt_lb_ft_rad = 7.49e6;
    scene.tad_deg = 0.0;
    scene.force_lb = 1200.0;
    scene.vac_ft_s = 60.0;
    scene.start_ft = 5.0;
    scene.v0_ft_s = 0.0;
    assert_true(held_against("event", &scene, "one-sided soil"));
}

/* Two feet of light mats on stiff soil land 13 us after each other, within one step of 20 us. The
 * second one lands on a node that the first has lifted, and mat 1 hops by 0.46e-3 ft; together they
 * lift nobody, and runs at 1, 1.9 and 3.6 times the step said that, to 3e-5 ft. */
TEST(feet_that_land_within_one_step)
{
    static const double bump_ft[] = {0.002475, 0.005, 0.002475};
    static const struct sim_path_row rows[] = {{0.0, 0.0539771, 0.0},
                                               {0.00961035, -0.522644, 72518.4},
                                               {0.00961035, -0.522644, 72518.4},
                                               {0.02, -0.834333, 36259.2}};
    struct sim_scene scene = small_scene(3, 3, 0.02);
    sim_scene_set_list(&scene.bump_ft, bump_ft, 3);
    sim_scene_set_path(&scene, rows, 4);
    scene.mats = 7;
    scene.profile = SIM_PROFILE_FULL;
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.thrust = SIM_THRUST_JUMP;
    scene.weight_lb = 483.456;
    scene.inertia_slug_ft2 = 0.097998;
    scene.kv_lb_ft = 1.07855e6;
    scene.cv_lb_s_ft = 1.8331e7;
    scene.kl_lb_ft = 1.01181e6;
    scene.cl_lb_s_ft = 16.8097;
    scene.kt_lb_ft_rad = 8.50158e7;
    scene.ct_lb_ft_s_rad = 0.508058;
    scene.tad_deg = 1.0;
    scene.slack_ft = 0.25 / 12.0;
    scene.friction = 0.9;
    scene.v0_ft_s = 2.0;
    assert_true(held_against("implicit", &scene, "two feet within a step"));
}

/* A damped joint that closes within a step brakes from there on, not what lay open before: 0.4e-6
 * ft of u, alike at every step that is longer than that. */
TEST(a_damper_does_not_brake_the_slack)
{
    static const double bump_ft[] = {0.002475};
    static const struct sim_path_row rows[] = {{0.002, 5.05659, 0.0},
                                               {0.00716132, 5.77917, 37.2939},
                                               {0.00716132, 5.77917, 18.647},
                                               {0.02, 6.67788, 9.32348}};
    struct sim_scene scene = small_scene(3, 1, 0.02);
    sim_scene_set_list(&scene.bump_ft, bump_ft, 1);
    sim_scene_set_path(&scene, rows, 4);
    scene.mats = 13;
    scene.profile = SIM_PROFILE_FULL;
    scene.left_end = scene.right_end = scene.right_torsion = SIM_END_FIXED;
    scene.thrust = SIM_THRUST_LINEAR;
    scene.weight_lb = 4.97252;
    scene.inertia_slug_ft2 = 0.0621566;
    scene.kv_lb_ft = 12939.9;
    scene.cv_lb_s_ft = 8.20025e6;
    scene.kl_lb_ft = 2.1068e7;
    scene.cl_lb_s_ft = 35774.6;
    scene.kt_lb_ft_rad = 3.25206e7;
    scene.ct_lb_ft_s_rad = 159.84;
    scene.slack_ft = 0.25 / 12.0;
    scene.wheel_load_lb = 0.497252;
    scene.friction = 0.2;
    scene.v0_ft_s = 2.0;
    assert_true(held_against("implicit", &scene, "a joint that closes"));
}

/* A damped joint that opens within a step has pulled over its whole compression, an impulse of CL
 * times 2e-8 ft: 2e-6 ft of u, alike at every longer step. */
TEST(a_damper_pulls_until_its_joint_opens)
{
    static const double bump_ft[] = {0.0495, 0.1, 0.0495};
    static const struct sim_path_row rows[] = {{0.001, 17.8128689, 46.0295219},
                                               {0.00356101852, 18.0433606, 46.0295219},
                                               {0.01, 18.3331148, 23.0147609}};
    struct sim_scene scene = small_scene(3, 3, 0.01);
    sim_scene_set_list(&scene.bump_ft, bump_ft, 3);
    sim_scene_set_path(&scene, rows, 3);
    scene.mats = 11;
    scene.profile = SIM_PROFILE_FULL;
    scene.left_end = scene.right_end = scene.left_torsion = SIM_END_FREE;
    scene.right_torsion = SIM_END_FIXED;
    scene.thrust = SIM_THRUST_LINEAR;
    scene.weight_lb = 6.13727;
    scene.inertia_slug_ft2 = 0.0767159;
    scene.kv_lb_ft = 136910.0;
    scene.cv_lb_s_ft = 434.149;
    scene.kl_lb_ft = 2.9325e8;
    scene.cl_lb_s_ft = 17569.6;
    scene.kt_lb_ft_rad = 41579.4;
    scene.ct_lb_ft_s_rad = 47.1782;
    scene.slack_ft = 0.005;
    scene.wheel_load_lb = 0.0;
    scene.friction = 0.5;
    scene.v0_ft_s = 2.0;
    assert_true(held_against("event", &scene, "a joint that opens"));
}
