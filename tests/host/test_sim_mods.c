/* Modifications of the runway against closed forms and an independent integration: the chain, and
 * what is refused. Units ft, lb, s. */
#include "tests/host/mods_case.h"

/* C.6 and C.7: one riveted mat in a band between two springs, pushed slowly. */
TEST(a_slow_push_splits_as_appendix_c_says)
{
    const double springs[] = {20.0, 100.0, 1e9}, pushed = 30.0, t0 = 80.0;
    const int at[] = {3, 5, 9};
    for (int i = 0; i < 9; i++) {
        double k = springs[i / 3], l = 10.0, ae = 1000.0;
        int mat = at[i % 3];
        struct sim_scene scene = apart(10);
        const struct sim_path_row rows[] = {
            {0, mat - 0.5, 0}, {20, mat - 0.5, pushed}, {24, mat - 0.5, pushed}};
        scene.friction_law = SIM_FRICTION_STICK;
        scene.friction = 0.01 / G; /* 0.01 lb: what may be missing */
        rivet(&scene, 10, mat, mat);
        tension(&scene, &t0, 1);
        scene.mods.band[0].k_lb_ft = k;
        sim_scene_set_path(&scene, rows, 3);
        struct sim_result result = run(&scene, (struct sim_options){0});
        double a = (mat - 0.5) / l, s = k * l / ae;
        near(result.mods->band_lb[1] - t0, -pushed * (a * s + 1) / (s + 2), 0.15);
        near(result.mods->band_lb[0] - t0, pushed * ((1 - a) * s + 1) / (s + 2), 0.15);
        near(result.mods->band_load_lb[0], pushed, 0.5); /* it swings a little */
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* Between rigid anchors, 5 ft either side: 400 lb/ft together. Two bands double it; v0 gives the
 * amplitude. */
TEST(a_mat_swings_between_anchors)
{
    for (int bands = 1; bands <= 2; bands++) {
        const double t0 = 500.0;
        struct sim_scene scene = apart(10);
        rivet(&scene, 10, 5, 5);
        tension(&scene, &t0, 1);
        scene.mods.band[0].count = bands;
        scene.v0_ft_s = 1.0;
        scene.v0_mat = 5;
        double k = 1000.0 / 4.5 + 1000.0 / 5.5, rate = sqrt(bands * k);
        scene.t_end_s = 0.5 * PI / rate; /* a quarter of a period: at its furthest */
        struct sim_result result = run(&scene, (struct sim_options){.dt_s = 1e-5});
        near(result.u_ft[5], 1.0 / rate, 1e-7);
        near(result.mods->band_min_lb[1], t0 - 1000.0 / 5.5 / rate, 1e-3);
        near(result.mods->band_max_lb[0], t0 + 1000.0 / 4.5 / rate, 1e-3);
        assert_true(result.speed_end_ft_s < 1e-3);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* T0 20 lb: ahead of the mat the band is slack after 0.1 ft; what is left brakes it alone. Energy:
 * 1/2 v^2. */
TEST(a_slack_band_does_not_push)
{
    const double t0 = 20.0;
    struct sim_scene scene = apart(11);
    rivet(&scene, 11, 6, 6); /* 5.5 ft on either side */
    tension(&scene, &t0, 1);
    scene.v0_ft_s = 6.0;
    scene.v0_mat = 6;
    /* force 2 k x to slack, then T0 + k x = k (slack + x) */
    double k = 1000.0 / 5.5, slack = t0 / k;
    /* k x^2/2 + k slack x - k slack^2/2 = 18 */
    double furthest = -slack + sqrt(2.0 * slack * slack + 36.0 / k);
    scene.t_end_s = 0.5;
    scene.mods.band[0].k_lb_ft = (double)INFINITY;
    struct sim_result result = run(&scene, (struct sim_options){.dt_s = 1e-5});
    near(result.mods->band_max_lb[0], t0 + k * furthest, 1e-3);
    /* negative: how much it hangs loose */
    near(result.mods->band_min_lb[1], t0 - k * furthest, 1e-3);
    assert_true(result.mods->band_min_lb[1] < 0.0);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Once the band slides, the mat feels its grip and no more; the band is then out by what slid. */
TEST(a_connection_holds_its_grip)
{
    const double t0 = 200.0;
    struct sim_scene scene = apart(11);
    const struct sim_path_row rows[] = {{0, 5.5, 50.0}, {0.2, 5.5, 50.0}};
    rivet(&scene, 11, 6, 6);
    tension(&scene, &t0, 1);
    scene.mods.band[0].grip_lb = 10.0;
    sim_scene_set_path(&scene, rows, 2);
    struct sim_result result = run(&scene, (struct sim_options){.dt_s = 1e-5});
    double k = 1000.0 / 5.5, rate = sqrt(2.0 * k);
    /* elastic until 2 k u = 10, then constant 40 lb on 1 slug */
    double u1 = 10.0 / (2.0 * k), c = 1.0 - u1 * 2.0 * k / 50.0, t1 = acos(c) / rate,
           v1 = 50.0 / (2.0 * k) * rate * sin(acos(c));
    double left = 0.2 - t1, u = u1 + v1 * left + 20.0 * left * left;
    near(result.u_ft[6], u, 1e-4);
    near(result.mods->band_slip_ft[0], u - u1, 1e-4);
    near(result.mods->band_load_lb[0], 10.0, 1e-9);
    near(result.mods->band_lb[0] - result.mods->band_lb[1], 10.0, 1e-6);
    /* both halves as stiff */
    near(result.mods->band_lb[0] + result.mods->band_lb[1], 2.0 * t0, 1e-6);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Warmer bands: T0 - A E alpha dT between rigid anchors whatever the rivets; with springs the whole
 * gives way. */
TEST(heat_slackens)
{
    const double t0 = 80.0;
    struct sim_scene scene = apart(10);
    scene.friction_law = SIM_FRICTION_STICK;
    scene.friction = 10.0;
    scene.t_end_s = 0.1;
    rivet(&scene, 3, 2, 0);
    tension(&scene, &t0, 1);
    scene.mods.band[0].thermal_expansion_per_degf = 1e-3;
    scene.mods.band[0].temperature_rise_degf = 20.0;
    struct sim_result result = run(&scene, (struct sim_options){0});
    assert_int_equal(result.mods->segment_count, 4);
    for (int i = 0; i < 4; i++)
        near(result.mods->band_lb[i], 80.0 - 20.0, 1e-9);
    sim_result_free(&result);

    rivet(&scene, 10, 5, 5);
    scene.mods.band[0].k_lb_ft = 50.0; /* 4.5 and 5.5 ft, 20 ft of give each */
    result = run(&scene, (struct sim_options){0});
    near(result.mods->band_lb[0], 80.0 - 1e-3 * 20.0 * 4.5 / (4.5 / 1000 + 1 / 50.0), 1e-9);
    near(result.mods->band_lb[1], 80.0 - 1e-3 * 20.0 * 5.5 / (5.5 / 1000 + 1 / 50.0), 1e-9);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Without its rivets a mat lets the band run through: one tension, that of the stretch of both
 * parts together. */
TEST(pulled_rivets_let_the_band_run)
{
    const double t0[] = {100.0, 10.0, 40.0}, mat = 3.0;
    struct sim_scene scene = apart(10);
    scene.friction_law = SIM_FRICTION_STICK;
    scene.friction = 10.0;
    scene.t_end_s = 0.1;
    rivet(&scene, 5, 3, 8);
    tension(&scene, t0, 3);
    sim_scene_set_list(&scene.mods.band[0].pulled, &mat, 1);
    struct sim_result result = run(&scene, (struct sim_options){0});
    double both = (100.0 * 2.5 + 10.0 * 5.0) / 7.5;
    near(result.mods->band_lb[0], both, 1e-9);
    near(result.mods->band_lb[1], both, 1e-9);
    near(result.mods->band_lb[2], 40.0, 1e-9);
    assert_true(result.mods->band_pulled_out[0] == 1.0 && result.mods->band_pulled_out[1] == 0.0);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* The wheel tilts a mat whose bands pull 100 + 100 lb: 2 lb across at 0.01 rad. Rivets of 1.9 lb
 * leave, of 2.1 stay, and of 2.1 with half of it worn off leave too. */
TEST(the_wheel_pulls_rivets_out)
{
    const double t0 = 100.0, slipped = 0.5;
    struct sim_scene scene = apart(10);
    scene.friction_law = SIM_FRICTION_STICK;
    scene.friction = 10.0;
    scene.vac_ft_s = 50.0;
    scene.t_end_s = 0.13;
    rivet(&scene, 5, 3, 8);
    tension(&scene, &t0, 1);
    scene.mods.band[0].mat_tilt_rad = 0.01;
    for (int i = 0; i < 3; i++) {
        scene.mods.band[0].rivet_pull_lb = i == 0 ? 1.9 : 2.1;
        scene.mods.band[0].hole_wear_ft = 1.0;
        if (i == 2)
            sim_scene_set_list(&scene.mods.band[0].slipped_ft, &slipped, 1);
        struct sim_result result = run(&scene, (struct sim_options){0});
        /* mat 3 is passed at 0.04 to 0.06 s */
        assert_true(result.mods->band_pulled_out[0] == (i == 1 ? 0.0 : 1.0));
        assert_true(result.mods->band_pulled_out[1] == 0.0); /* mat 8 would be at 0.14 */
        sim_result_free(&result);
    }
    sim_scene_free(&scene);
}

/* A riveted mat far away moves through its band, not through the mats between. */
TEST(leaving_mats_out_changes_nothing)
{
    for (int all = 0; all < 2; all++) {
        struct sim_scene scene = runway();
        const double uneven[] = {10, 90, 60, 60, 60, 60, 60, 60, 60, 60, 60, 20, 60};
        add_all(&scene);
        if (!all) {
            scene.mods.cleat_every = scene.mods.stiffener_span_mats = 0;
            scene.mods.tear_lb = HUGE_VAL;
            tension(&scene, uneven, 13); /* pulls mats at both ends at once */
        }
        struct sim_result pruned = run(&scene, (struct sim_options){.dt_s = 5e-5});
        struct sim_result whole =
            run(&scene, (struct sim_options){.dt_s = 5e-5, .integrates_all_mats = true});
        assert_true(pruned.integrated_mats_mean < 0.95 * whole.integrated_mats_mean);
        assert_true(whole.peak_u_ft > 0.002);
        for (int n = 1; n <= 120; n++)
            assert_true(pruned.u_ft[n] == whole.u_ft[n]);
        for (size_t i = 0; i < pruned.mods->segment_count; i++)
            assert_true(pruned.mods->band_lb[i] == whole.mods->band_lb[i]);
        sim_result_free(&pruned);
        sim_result_free(&whole);
        sim_scene_free(&scene);
    }
}

/* What a landing left is the next one's start: without an aircraft nothing moves, and the state is
 * what it was. */
TEST(state_carries_over)
{
    struct sim_scene scene = runway();
    const struct sim_path_row none[] = {{0, 2, 0}, {0.3, 2, 0}};
    add_all(&scene);
    struct sim_result first = run(&scene, (struct sim_options){0});
    assert_true(first.mods->cleat_remaining_share[2] < 1.0 && first.mods->band_slip_ft[1] > 0.0);
    sim_scene_set_list(&scene.gap0_ft, first.gap_ft + 1, 121);
    mods_carry_over(&scene, &first);
    sim_scene_set_path(&scene, none, 2);
    struct sim_result second = run(&scene, (struct sim_options){0});
    assert_true(second.peak_u_ft < 0.02 * first.peak_u_ft);
    double changed_lb = 0.0;
    for (size_t i = 0; i < first.mods->segment_count; i++) {
        changed_lb = fmax(changed_lb, fabs(first.mods->band_lb[i] - 60.0));
        /* what grit held is dropped: G/KL in 76,000 lb/ft */
        near(second.mods->band_lb[i], first.mods->band_lb[i], 5.0);
    }
    assert_true(changed_lb > 15.0);
    for (size_t c = 0; c < first.mods->connection_count; c++)
        near(second.mods->band_slip_ft[c], first.mods->band_slip_ft[c], 1e-3 * first.peak_u_ft);
    for (size_t c = 0; c < first.mods->cleat_count; c++)
        near(second.mods->cleat_remaining_share[c], first.mods->cleat_remaining_share[c], 0.01);
    sim_result_free(&first);
    sim_result_free(&second);
    sim_scene_free(&scene);
}

/* --- a second implementation --- */

#define MATS 6
static double pull_of(double k, double stretch)
{
    return stretch > 0.0 ? k * stretch : 0.0;
}

/* Six mats, rivets in 2 and 5, joints with slack, friction, a band that slides: velocity Verlet
 * with forces from the definitions, the band's place under each rivet found by bisection. */
static void march(double h, double end, double thrust, double grip, double u[MATS + 2], double t[3])
{
    double v[MATS + 2] = {0}, place[2] = {0}, f[MATS + 2], mass = 2.0 / G, friction = 1.0, kl = 1e4,
                    cl = 5.0, slack = 0.01;
    const double length[3] = {1.5, 3.0, 1.5}, t0 = 20.0, ea = 3000.0, bands = 0.5;
    const int mat[2] = {2, 5};
    memset(u, 0, (MATS + 2) * sizeof *u);
    for (int i = 0; i * h < end; i++) {
        for (int sweep = 0; sweep < 60; sweep++) {
            /* place[c]: how far the band lies ahead of its mat */
            bool slid = false;
            for (int c = 0; c < 2; c++) {
                double y[4] = {0.0, u[2] + place[0], u[5] + place[1], 0.0};
                double before = pull_of(ea / length[c], t0 * length[c] / ea + y[c + 1] - y[c]);
                double after = pull_of(ea / length[c + 1],
                                       t0 * length[c + 1] / ea + y[c + 2] - y[c + 1]);
                if (fabs(after - before) <= grip * (1.0 + 1e-9))
                    continue;
                slid = true;
                double low = place[c] - 0.1, high = place[c] + 0.1, kept = place[c];
                for (int b = 0; b < 60; b++) {
                    double x[4] = {0.0, u[2] + place[0], u[5] + place[1], 0.0},
                           middle = 0.5 * (low + high);
                    x[c + 1] = u[mat[c]] + middle;
                    double left = pull_of(ea / length[c], t0 * length[c] / ea + x[c + 1] - x[c]);
                    double right = pull_of(ea / length[c + 1],
                                           t0 * length[c + 1] / ea + x[c + 2] - x[c + 1]);
                    double limit = middle > kept ? right - left - grip : right - left + grip;
                    if (limit > 0.0) /* pulled on forwards by more than it holds */
                        low = middle;
                    else
                        high = middle;
                }
                place[c] = 0.5 * (low + high);
            }
            if (!slid)
                break;
        }
        double x[4] = {0.0, u[2] + place[0], u[5] + place[1], 0.0};
        for (int s = 0; s < 3; s++)
            t[s] = pull_of(ea / length[s], t0 * length[s] / ea + x[s + 1] - x[s]);
        for (int n = 1; n <= MATS; n++)
            f[n] = n == 3 ? thrust * fmin(1.0, i * h / 0.02) : 0.0;
        for (int j = 2; j <= MATS; j++) {
            double g = 0.004 + u[j] - u[j - 1], d = v[j] - v[j - 1], force = 0.0;
            if (g < 0.0)
                force = kl * g + cl * d;
            else if (g > slack)
                force = kl * (g - slack) + cl * d;
            f[j] -= force;
            f[j - 1] += force;
        }
        for (int c = 0; c < 2; c++)
            f[mat[c]] += bands * (t[c + 1] - t[c]);
        for (int n = 1; n <= MATS; n++) {
            double sign = v[n] != 0.0 ? (v[n] > 0.0 ? 1.0 : -1.0) : f[n] > 0.0 ? 1.0 : -1.0;
            if (v[n] == 0.0 && fabs(f[n]) <= friction)
                continue;
            double after = v[n] + (f[n] - sign * friction) / mass * h;
            v[n] = after * sign < 0.0 ? 0.0 : after;
            u[n] += v[n] * h;
        }
    }
}

TEST(a_second_implementation_agrees)
{
    for (int i = 0; i < 3; i++) {
        const double t0 = 20.0, gap = 0.004, thrusts[] = {12.0, 12.0, 25.0},
                     grips[] = {HUGE_VAL, 8.0, 15.0};
        const struct sim_path_row rows[] = {
            {0, 2.5, 0}, {0.02, 2.5, thrusts[i]}, {0.1, 2.5, thrusts[i]}};
        struct sim_scene scene = apart(MATS);
        double u[MATS + 2], t[3];
        scene.weight_lb = 2.0;
        scene.friction_law = SIM_FRICTION_STICK;
        scene.friction = 0.5;
        scene.kl_lb_ft = 1e4;
        scene.cl_lb_s_ft = 5.0;
        scene.slack_ft = 0.01;
        scene.mods.band[0].count = 0.5;
        scene.mods.band[0].e_lb_ft2 = 3000.0;
        scene.mods.band[0].grip_lb = grips[i];
        rivet(&scene, 3, 2, 5);
        tension(&scene, &t0, 1);
        sim_scene_set_list(&scene.gap0_ft, &gap, 1);
        sim_scene_set_path(&scene, rows, 3);
        struct sim_result result = run(&scene, (struct sim_options){.dt_s = 2e-6});
        march(5e-6, 0.1, thrusts[i], grips[i], u, t);
        assert_true(result.peak_u_ft > 0.005);
        for (int n = 1; n <= MATS; n++)
            near(result.u_ft[n], u[n], 0.01 * result.peak_u_ft);
        for (int s = 0; s < 3; s++)
            near(fmax(0.0, result.mods->band_lb[s]), t[s], 0.3);
        assert_true((result.mods->band_slip_ft[0] > 0.0) == (i > 0));
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

/* --- cleats, stiffeners, diagonal joints, tears --- */

/* A cleated mat stands up to f W + hold, and a fresh hold falls by e over its travel: a push of
 * constant F does the work F x = f W x + hold l (1 - exp(-x/l)) + 1/2 m v^2. */
TEST(a_cleat_wears_as_it_moves)
{
    struct sim_scene scene = apart(3);
    const struct sim_path_row rows[] = {{0, 1.5, 20.0}, {0.4, 1.5, 20.0}};
    scene.mods.band[0].count = 0.0;
    scene.friction_law = SIM_FRICTION_STICK;
    scene.friction = 5.0 / G;
    scene.mods.cleat_every = 2;
    scene.mods.cleat_hold_lb = 15.0001;
    scene.mods.cleat_travel_ft = 0.1;
    sim_scene_set_path(&scene, rows, 2);
    struct sim_result result = run(&scene, (struct sim_options){0});
    assert_true(result.u_ft[2] == 0.0 && result.mods->cleat_remaining_share[0] == 1.0);
    sim_result_free(&result);
    scene.mods.cleat_hold_lb = 10.0;
    result = run(&scene, (struct sim_options){.dt_s = 1e-5});
    double x = result.u_ft[2];
    near(result.mods->cleat_remaining_share[0], exp(-x / 0.1), 1e-4);
    near(0.5 * result.speed_end_ft_s * result.speed_end_ft_s,
         15.0 * x - 10.0 * 0.1 * (1 - exp(-x / 0.1)), 1e-3);
    assert_true(x > 0.2);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Mats 1 to 3 tied, 4 free: pushed at 1, the three swing as two springs between three masses, the
 * fourth stays. */
TEST(a_stiffener_ties_mats)
{
    struct sim_scene scene = apart(4);
    scene.mods.band[0].count = 0.0;
    scene.mods.stiffener_span_mats = 3;
    scene.mods.stiffener_k_lb_ft = 100.0;
    scene.v0_mat = 1;
    scene.v0_ft_s = 1.0;
    scene.t_end_s = 0.2;
    struct sim_result result = run(&scene, (struct sim_options){.dt_s = 1e-5});
    /* modes of three masses: (1,1,1)/3 drifts, (1,0,-1)/2 at sqrt k, (1,-2,1)/6 at sqrt 3k */
    double t = 0.2, a = sqrt(100.0), b = sqrt(300.0);
    near(result.u_ft[1], t / 3 + sin(a * t) / (2 * a) + sin(b * t) / (6 * b), 1e-6);
    near(result.u_ft[2], t / 3 - 2 * sin(b * t) / (6 * b), 1e-6);
    near(result.u_ft[3], t / 3 - sin(a * t) / (2 * a) + sin(b * t) / (6 * b), 1e-6);
    assert_true(result.u_ft[4] == 0.0);
    sim_result_free(&result);
    scene.mods.stiffener_free_joints = 2; /* joints 4 and 5 are free: mats 1 to 3, 5 to 7 */
    scene.mats = 9;
    scene.v0_mat = 6;
    result = run(&scene, (struct sim_options){.dt_s = 1e-5});
    assert_true(result.u_ft[4] == 0.0 && result.u_ft[5] > 0.01 && result.u_ft[7] > 0.01 &&
                result.u_ft[8] == 0.0);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Joints at 45 degrees that slide at S: along the runway S sin 45; two mats of 1 slug share speed
 * when it stops. */
TEST(joints_at_45_degrees_slide)
{
    struct sim_scene scene = apart(2);
    scene.mods.band[0].count = 0.0;
    scene.kl_lb_ft = 1e6; /* the joint's own give is small */
    scene.mods.lay_deg = 45.0;
    scene.mods.lay_slide_lb = 10.0;
    scene.v0_mat = 1;
    scene.v0_ft_s = 4.0;
    scene.t_end_s = 0.2;
    struct sim_result result = run(&scene, (struct sim_options){.dt_s = 1e-5});
    /* the one is slowed, the other pulled along: relative 4 - 2 s t */
    double s = 10.0 * sqrt(0.5), t = 0.2;
    near(result.u_ft[1], 4.0 * t - 0.5 * s * t * t, 1e-4);
    near(result.u_ft[2], 0.5 * s * t * t, 1e-4);
    sim_result_free(&result);
    scene.t_end_s = 1.0; /* together after 4/(2 s) = 0.283 s, at 2 ft/s */
    result = run(&scene, (struct sim_options){.dt_s = 1e-5});
    near(result.u_ft[1] - result.u_ft[2], 16.0 / (4.0 * s), 1e-3);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Two mats pulled apart: the joint hooks at its slack and tears when the pull passes its strength;
 * then nothing holds. */
TEST(a_joint_tears)
{
    for (int i = 0; i < 2; i++) {
        struct sim_scene scene = apart(2);
        scene.mods.band[0].count = 0.0;
        scene.slack_ft = 5.05;
        scene.v0_mat = 2;
        scene.v0_ft_s = 2.0;
        scene.cl_lb_s_ft = 0.0;
        scene.t_end_s = 0.5;
        /* 1e3 lb/ft stops a relative speed of 2 ft/s of half a slug with 2 sqrt(1e3/2) = 44.7 lb;
         * torn at half of that, cos 30 of the speed is left */
        double strength = 2.0 * sqrt(500.0), left = 2.0 * cos(PI / 6);
        scene.mods.tear_lb = i ? 1.01 * strength : 0.5 * strength;
        struct sim_result result = run(&scene, (struct sim_options){.dt_s = 1e-5});
        assert_true(result.mods->torn[2] == (i ? 0.0 : 1.0));
        if (i) /* all of the speed goes to the other, after half a period pi sqrt(m/2k) */
            near(result.u_ft[2], 0.05 + 1.0 * PI * sqrt(0.5e-3), 2e-3);
        else {
            double apart_ft = 0.05 + 0.5 * strength / 1e3 +
                              left * (0.5 - 0.025 - PI / 6 / sqrt(2e3));
            near(result.u_ft[1], 0.5 * (1.0 - apart_ft), 1e-3);
            near(result.u_ft[2], 0.5 * (1.0 + apart_ft), 1e-3);
        }
        mods_carry_over(&scene, &result);
        assert_int_equal(scene.mods.torn.count, i ? 0 : 1);
        if (!i) {
            assert_true(scene.mods.torn.values[0] == 2.0);
            struct sim_result again = run(&scene, (struct sim_options){.dt_s = 1e-5});
            near(again.u_ft[2], 1.0, 1e-9); /* torn from the start: away with it */
            sim_result_free(&again);
        }
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

static void refused(const struct sim_scene *scene, const char *why)
{
    struct sim_result result;
    memset(&error, 0, sizeof error);
    assert_true(sim_run(scene, &(struct sim_options){0}, &result, &error) != MR_OK);
    if (!strstr(error.text, why))
        fail_msg("'%s' does not say '%s'", error.text, why);
    sim_result_free(&result);
}

TEST(what_makes_no_sense_is_refused)
{
    const double two[] = {1, 2}, nine = 9;
    struct sim_scene scene = runway();
    scene.mods.band[0].count = 1.0;
    scene.mods.band[0].first_mat = 121;
    refused(&scene, "bands without rivets");
    scene.mods.band[0].first_mat = 10;
    tension(&scene, two, 2);
    refused(&scene, "band_T0 has 2 values; give one number or 7");
    tension(&scene, two, 1);
    sim_scene_set_list(&scene.mods.band[0].pulled, &nine, 1);
    refused(&scene, "not a riveted mat");
    sim_scene_set_list(&scene.mods.band[0].pulled, &nine, 0);
    scene.mods.stiffener_span_mats = 6;
    scene.mods.lay_deg = 45.0;
    refused(&scene, "stiffeners on a diagonal pattern");
    scene.mods.stiffener_span_mats = 0;
    scene.mods.lay_deg = 85.0;
    refused(&scene, "lay_deg is 85");
    scene.mods.lay_deg = 0.0;
    sim_scene_set_list(&scene.mods.torn, (const double[]){122}, 1);
    refused(&scene, "122");
    sim_scene_set_list(&scene.mods.torn, NULL, 0);
    scene.mods.band[0].count = 1.0;
    scene.model = SIM_MODEL_REPORT;
    sim_scene_set_list(&scene.grit_lb, NULL, 0);
    refused(&scene, "cleats and others) in model report; leave the feature out");
    sim_scene_free(&scene);
}

/* --- two groups of bands on one strip --- */

/* Ten free mats far apart (joints never meet) of 1 slug, without friction; a band of A E = 1000 lb
 * riveted to mat 5, at 500 lb. */
static struct sim_scene one_group(void)
{
    struct sim_scene scene = apart(10);
    const double t0 = 500.0;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        scene.mods.band[g].count = g == 0 ? 1.0 : 0.0;
        scene.mods.band[g].area_ft2 = 1.0;
        scene.mods.band[g].e_lb_ft2 = 1000.0;
        scene.mods.band[g].spacing = 10;
        scene.mods.band[g].first_mat = scene.mods.band[g].last_mat = 5;
        sim_scene_set_list(&scene.mods.band[g].initial_tension_lb, &t0, 1);
    }
    return scene;
}

/* Two of the first group and three of the second, twice as stiff and at another tension, swing mat
 * 5 together: 2 k + 3 (2 k) = 8 k. At a quarter of the period each has changed by its own stiffness
 * times the same amplitude. */
TEST(both_hold_the_same_mat)
{
    struct sim_scene scene = one_group();
    const double other_t0 = 900.0, left = 1000.0 / 4.5, right = 1000.0 / 5.5;
    scene.mods.band[0].count = 2.0;
    scene.mods.band[1].count = 3.0;
    scene.mods.band[1].e_lb_ft2 = 2000.0;
    sim_scene_set_list(&scene.mods.band[1].initial_tension_lb, &other_t0, 1);
    scene.v0_ft_s = 1.0;
    scene.v0_mat = 5;
    double rate = sqrt(8.0 * (left + right));
    scene.t_end_s = 0.5 * PI / rate;
    struct sim_result result = run(&scene, (struct sim_options){.dt_s = 1e-5});
    assert_int_equal(result.mods->segment_count, 4);
    assert_int_equal(result.mods->connection_count, 2);
    near(result.u_ft[5], 1.0 / rate, 1e-7);
    near(result.mods->band_lb[0], 500.0 + left / rate, 1e-3);
    near(result.mods->band_lb[1], 500.0 - right / rate, 1e-3);
    near(result.mods->band_lb[2], 900.0 + 2.0 * left / rate, 1e-3);
    near(result.mods->band_lb[3], 900.0 - 2.0 * right / rate, 1e-3);
    near(result.mods->band_load_lb[1], 2.0 * result.mods->band_load_lb[0], 1e-3);
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Riveted to other mats, each swings its own: the second mat 3, between 2.5 and 7.5 ft, with half
 * the first's stiffness. */
TEST(each_holds_its_own_mat)
{
    struct sim_scene scene = one_group();
    const double k = 1000.0 / 4.5 + 1000.0 / 5.5, other = 500.0 / 2.5 + 500.0 / 7.5;
    scene.mods.band[1].count = 1.0;
    scene.mods.band[1].first_mat = scene.mods.band[1].last_mat = 3;
    scene.mods.band[1].e_lb_ft2 = 500.0;
    scene.v0_ft_s = 1.0;
    for (int mat = 3; mat <= 5; mat += 2) {
        double rate = sqrt(mat == 3 ? other : k);
        scene.v0_mat = mat;
        scene.t_end_s = 0.5 * PI / rate;
        struct sim_result result = run(&scene, (struct sim_options){.dt_s = 1e-5});
        near(result.u_ft[mat], 1.0 / rate, 1e-7);
        near(result.u_ft[8 - mat], 0.0, 1e-15); /* the other one stays */
        near(result.mods->band_mat[0], 5.0, 0.0);
        near(result.mods->band_mat[1], 3.0, 0.0);
        sim_result_free(&result);
    }
    sim_scene_free(&scene);
}

/* The first 0.6 s of a landing in the planar model, the mats on uneven ground: bands in two groups
 * are those bands in one. */
static struct sim_scene landing(void)
{
    struct sim_scene scene;
    error = (struct error){0};
    if (sim_scene_load(&scene, "host/scenes/model_runway_planar.json", &error) != MR_OK)
        fail_msg("%s", error.text);
    scene.t_end_s = 0.6;
    scene.t_dwell_s = -1.0;
    return scene;
}

TEST(halves_are_the_whole)
{
    for (int over = 0; over < 2; over++) {
        struct sim_scene scene = landing();
        const double t0 = 100.0;
        struct sim_result result[2];
        for (int g = 0; g < 2; g++) {
            scene.mods.band[g].spacing = 10;
            scene.mods.band[g].k_lb_ft = 2000.0;
            scene.mods.band[g].grip_lb = 60.0;
            scene.mods.band[g].acts_on = over ? SIM_BAND_OVER_RIVETS : SIM_BAND_OVER_JOINTS;
            sim_scene_set_list(&scene.mods.band[g].initial_tension_lb, &t0, 1);
        }
        for (int i = 0; i < 2; i++) {
            /* a power of two: halving rounds nothing */
            scene.mods.band[0].count = i == 0 ? 0.5 : 0.25;
            scene.mods.band[1].count = i == 0 ? 0.0 : 0.25;
            result[i] = run(&scene, (struct sim_options){.is_single_pass = true, .dt_s = 5e-5});
        }
        size_t segments = result[0].mods->segment_count;
        double apart = 0.0;
        for (int n = 1; n <= scene.mats; n++)
            apart = fmax(apart, fabs(result[0].u_ft[n] - result[1].u_ft[n]));
        assert_true(result[0].peak_u_ft > 0.002);
        near(apart, 0.0, 1e-6 * result[0].peak_u_ft);
        for (size_t i = 0; i < segments; i++) {
            near(result[1].mods->band_lb[i], result[0].mods->band_lb[i], 1e-3);
            near(result[1].mods->band_lb[segments + i], result[0].mods->band_lb[i], 1e-3);
        }
        sim_result_free(&result[0]);
        sim_result_free(&result[1]);
        sim_scene_free(&scene);
    }
}

/* The second group's keys begin with band2_, and errors name them. */
TEST(keys)
{
    static const struct {
        const char *scene, *says;
    } wrong[] = {
        {"{\"model\":\"chain\",\"N\":30,\"bands2\":1,\"band2_first\":31}", "band2_first"},
        {"{\"model\":\"chain\",\"N\":30,\"bands2\":1,\"band2_every\":10,\"band2_T0\":[1,2]}",
         "band2_T0 has 2 values; give one number or 4"},
        {"{\"model\":\"chain\",\"N\":30,\"bands2\":1,\"band2_every\":10,\"band2_pulled\":[5]}",
         "band2_pulled[0] is 5"},
        {"{\"model\":\"chain\",\"N\":30,\"bands3\":1}", "bands3"},
    };
    static const char right[] = "{\"model\":\"chain\",\"N\":30,\"bands\":2,\"band_T0\":125,"
                                "\"bands2\":1,\"band2_every\":15,\"band2_T0\":60}";
    struct sim_scene scene;
    error = (struct error){0};
    assert_int_equal(sim_scene_parse(&scene, "x", right, strlen(right), &error), MR_OK);
    assert_int_equal(mods_connection_count(&scene, 0), 1);
    assert_int_equal(mods_connection_count(&scene, 1), 2);
    near(scene.mods.band[1].initial_tension_lb.values[0], 60.0, 0.0);
    sim_scene_free(&scene);
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        error = (struct error){0};
        assert_int_equal(
            sim_scene_parse(&scene, "x", wrong[i].scene, strlen(wrong[i].scene), &error),
            MR_MALFORMED);
        if (!strstr(error.text, wrong[i].says))
            fail_msg("'%s' does not say '%s'", error.text, wrong[i].says);
    }
}
