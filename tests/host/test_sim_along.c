/* Values that differ along the runway, ends with a spring or a weight, and restraints (anchors,
 * tie-downs, absorbers): closed forms, an independent integration, and scenes without them. Units
 * ft, lb, s. */
#include "host/sim/solvers/planar_engine.h"
#include "tests/host/mods_case.h"

static struct sim_scene text_scene(const char *text)
{
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    if (sim_scene_parse(&scene, "text", text, strlen(text), &error) != MR_OK)
        fail_msg("%s", error.text);
    return scene;
}

static void refused(const char *text, const char *part)
{
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    assert_int_equal(sim_scene_parse(&scene, "text", text, strlen(text), &error), MR_MALFORMED);
    if (!strstr(error.text, part))
        fail_msg("\"%s\" is not in: %s", part, error.text);
}

TEST(values_are_lists_or_ranges)
{
    struct sim_scene s = text_scene("{\"KV\": [1e4, [2, 3, 5e3], [3, 3, \"1 lb/ft\"]], \"N\": 4, "
                                    "\"W\": [1, 2, 3, 4], \"gap0\": [0.5, [5, 5, 0.1]], "
                                    "\"v0\": [0, [2, 2, -1]]}");
    const double kv[] = {1e4, 5e3, 1, 1e4, 1e4}, gap[] = {0.5, 0.5, 0.5, 0.5, 0.1};
    for (int j = 1; j <= 5; j++) {
        near(sim_scene_local_value(&s, SIM_VARIED_KV, s.kv_lb_ft, j), kv[j - 1], 0.0);
        near(sim_scene_joint_value(&s.gap0_ft, j), gap[j - 1], 0.0);
        near(sim_scene_local_value(&s, SIM_VARIED_KT, 7.0, j), 7.0, 0.0); /* no list */
    }
    near(s.kv_lb_ft, 1e4, 0.0);
    near(sim_scene_weight_lb(&s, 4), 4.0, 0.0);
    near(sim_scene_local_value(&s, SIM_VARIED_V0, 0.0, 2), -1.0, 0.0);
    near(sim_scene_step_limiting_value(&s, SIM_VARIED_W, 0.0), 1.0, 0.0);
    near(sim_scene_step_limiting_value(&s, SIM_VARIED_KV, 0.0), 1e4, 0.0);
    /* node 2 carries half of mats 1 and 2 on two springs of 5,000 lb/ft, node 5 half of mat 4 */
    near(sim_scene_settlement_ft(&s, 2), 1.5 / 1e4, 1e-18);
    near(sim_scene_settlement_ft(&s, 5), 2.0 / 1e4, 1e-18);
    sim_scene_free(&s);
    refused("{\"N\": 4, \"KV\": [1e4, [2, 6, 5e3]]}", "KV[1]");
    refused("{\"N\": 4, \"KV\": [1e4, [3, 2, 5e3]]}", "from 1 to 5");
    refused("{\"N\": 4, \"W\": [1, [1, 5, 2]]}", "from 1 to 4");
    refused("{\"N\": 4, \"W\": [1, 2, 3]}", "4, one per mat (N)");
    refused("{\"N\": 4, \"KL\": [1, 2, 3, 4]}", "5, one per joint (N + 1)");
    refused("{\"N\": 4, \"W\": [1, 2, 3, 0]}", "W[3] is 0");
    refused("{\"N\": 4, \"W\": [1, [1, 2, \"x\"]]}", "W[1]");
    refused("{\"N\": 4, \"anchor_every\": 2}", "no stiffness");
    refused("{\"N\": 4, \"anchor_every\": 2, \"anchor_K\": 1, \"anchor_zero\": [1, 2, 3]}",
            "one per restraint");
}

/* Solvers that choose their steps refuse such a scene, and say so. */
TEST(other_solvers_refuse)
{
    struct sim_scene s =
        text_scene("{\"model\": \"report\", \"N\": 4, \"KV\": [1e7, [2, 2, 1e6]]}");
    struct sim_result result;
    assert_int_equal(attempt(&s, NULL, 0.0, 0.0, &result), MR_USAGE);
    assert_non_null(strstr(error.text, "a list of KV"));
    sim_result_free(&result);
    s.model = SIM_MODEL_CONSISTENT;
    assert_int_equal(attempt(&s, "event", 0.0, 0.0, &result), MR_USAGE);
    assert_non_null(strstr(error.text, "staggered"));
    sim_result_free(&result);
    sim_scene_free(&s);
}

/* Two mats of 1 and 3 slug between a joint of 8 lb/ft and the ends' 1 lb/ft and 5 lb/ft: modes of
 * [9 -8; -8 13] u = w^2 diag(1, 3) u, from the first mat's speed. */
static double two_masses_ft(double t_s, int mat)
{
    const double a = 9.0, b = -8.0, d = 13.0, m2 = 3.0;
    double u = 0.0, half = 0.5 * (a + d / m2), root = sqrt(half * half - (a * d - b * b) / m2);
    for (double sign = -1.0; sign < 2.0; sign += 2.0) {
        double w2 = half + sign * root, ratio = (w2 - a) / b; /* of u2 to u1 */
        double share = 1.0 / (1.0 + m2 * ratio * ratio);      /* of the speed, by orthogonality */
        u += share * sin(sqrt(w2) * t_s) / sqrt(w2) * (mat == 1 ? 1.0 : ratio);
    }
    return u;
}

TEST(two_unequal_mats_have_their_modes)
{
    struct sim_scene s = text_scene(
        "{\"model\": \"chain\", \"N\": 2, \"L\": 1, \"g\": 1, \"W\": [1, 3], \"KL\": [1, 8, 5], "
        "\"CL\": 0, \"left\": \"fixed\", \"right\": \"fixed\", \"F\": 0, \"Vac\": 0, \"v0\": [1, "
        "0], "
        "\"friction\": \"none\", \"I\": 0.08, \"KV\": 1e3, \"CV\": 0, \"tend\": 3}");
    const double at_s[] = {0.5, 1.0, 2.0, 3.0};
    sim_scene_set_list(&s.t_out_s, at_s, 4);
    for (int model = SIM_MODEL_CONSISTENT; model <= SIM_MODEL_CHAIN; model++) {
        s.model = (enum sim_model)model;
        struct sim_result result = run(&s, (struct sim_options){.solver = "staggered"});
        for (int k = 0; k < 4; k++) {
            for (int mat = 1; mat <= 2; mat++)
                near(result.outputs[k].u_ft[mat], two_masses_ft(at_s[k], mat),
                     fmin(result.error_u_ft, 1e-3));
        }
        sim_result_free(&result);
    }
    sim_scene_free(&s);
}

/* The planar engine's state after t_end_s in steps of 2e-5 s: heights at z[2 j], rates behind. */
static void march(const struct sim_scene *scene, double z[], size_t count)
{
    struct planar_engine l = {0};
    const struct sim_options options = {.integrates_all_mats = true};
    struct march march = {.step_count = (uint64_t)(scene->t_end_s / 2e-5 + 0.5)};
    march.h_s = scene->t_end_s / (double)march.step_count;
    memset(&error, 0, sizeof error);
    assert_int_equal(planar_engine_make(&l, scene, NULL, &error), MR_OK);
    sim_record_make(&march.record, scene, &options);
    planar_engine_run(&l, &march, &options);
    memcpy(z, l.z, count * sizeof *z);
    sim_record_free(&march.record);
    free(march.mods);
    planar_engine_free(&l);
}

/* With I = m L^2/4 each node is half of the mat of 1 slug on its own spring and damper. */
TEST(each_node_has_its_soil)
{
    struct sim_scene s = text_scene(
        "{\"model\": \"consistent\", \"N\": 1, \"L\": 2, \"g\": 10, \"W\": 10, \"I\": 1, "
        "\"KV\": [300, 1200], \"CV\": [3, 0], \"right\": \"free\", \"F\": 0, \"Vac\": 0, "
        "\"v0\": 0, \"friction\": \"none\", \"bump_first\": 1, \"tend\": 0.3}");
    const double bump[] = {0.001, 0.001};
    double z[3];
    march(&s, z, 3); /* settled: it stays */
    near(z[0], 5.0 / 300.0, 1e-12);
    near(z[2], 5.0 / 1200.0, 1e-12);
    sim_scene_set_list(&s.bump_ft, bump, 2);
    for (int k = 1; k <= 6; k++) {
        double t = 0.05 * k, w = sqrt(600.0 - 9.0);
        s.t_end_s = t;
        march(&s, z, 3);
        near(z[0], 5.0 / 300.0 - 1e-3 * exp(-3.0 * t) * (cos(w * t) + 3.0 / w * sin(w * t)), 2e-6);
        near(z[2], 5.0 / 1200.0 - 1e-3 * cos(sqrt(2400.0) * t), 2e-6);
    }
    /* the same soil everywhere by a list gives the run of the number */
    struct sim_scene one = text_scene("{\"model\": \"consistent\", \"N\": 12, \"mats_crossed\": 2, "
                                      "\"bump\": [0.01, 0.02, 0.01]}"),
                     list = text_scene("{\"model\": \"consistent\", \"N\": 12, "
                                       "\"mats_crossed\": 2, \"bump\": [0.01, 0.02, 0.01], "
                                       "\"KV\": [1e7, [1, 13, 1e7]], \"CV\": [2e4, [1, 2, 2e4]], "
                                       "\"KL\": [8e6, [1, 2, 8e6]], \"KT\": [1e5, [1, 2, 1e5]], "
                                       "\"W\": [160, [1, 2, 160]]}");
    struct sim_result a = run(&one, (struct sim_options){.solver = "staggered", .dt_s = 1e-5}),
                      b = run(&list, (struct sim_options){.solver = "staggered", .dt_s = 1e-5});
    near(a.max_lift_ft, b.max_lift_ft, 1e-9);
    assert_true(a.max_lift_ft > 0.02);
    for (int n = 1; n <= 12; n++)
        near(a.u_ft[n], b.u_ft[n], 1e-9);
    sim_result_free(&a);
    sim_result_free(&b);
    sim_scene_free(&one);
    sim_scene_free(&list);
    sim_scene_free(&s);
}

/* A weight of 60 lb on an end mat of 40 lb, pushed by 100 lb: (100 - f 100)/(100/g). */
TEST(a_weight_on_an_end_slides)
{
    struct sim_scene s = text_scene(
        "{\"N\": 1, \"W\": 40, \"left\": \"weight\", \"left_weight\": 60, \"right\": \"free\", "
        "\"f\": 0.4, \"F\": 100, \"Vac\": 0, \"s0\": 1, \"v0\": 0, \"tend\": 0.2}");
    for (int model = SIM_MODEL_CONSISTENT; model <= SIM_MODEL_CHAIN; model++) {
        s.model = (enum sim_model)model;
        s.force_lb = 100.0;
        struct sim_result result = run(&s, (struct sim_options){.solver = "staggered"});
        double u = 0.5 * 0.6 * G * 0.2 * 0.2;
        near(result.u_ft[1], u, fmax(result.error_u_ft, 1e-4 * u));
        sim_result_free(&result);
        s.force_lb = 39.9; /* held by 40 lb, of which 24 are the weight's */
        result = run(&s, (struct sim_options){.solver = "staggered"});
        near(result.u_ft[1], 0.0, 0.0);
        sim_result_free(&result);
    }
    sim_scene_free(&s);
}

TEST(an_end_springs)
{
    for (int right = 0; right < 2; right++) {
        struct sim_scene s = apart(1);
        s.mods.band[0].count = 0.0;
        *(right ? &s.right_end : &s.left_end) = SIM_END_SPRING;
        s.end_k_lb_ft[right] = 400.0;
        s.gap0_ft.count = 0;
        s.v0_ft_s = 1.0;
        s.t_end_s = 0.7;
        for (int model = SIM_MODEL_CONSISTENT; model <= SIM_MODEL_CHAIN; model++) {
            s.model = (enum sim_model)model;
            struct sim_result result =
                run(&s, (struct sim_options){.solver = "staggered", .dt_s = 2e-5});
            near(result.u_ft[1], sin(20.0 * 0.7) / 20.0, fmax(result.error_u_ft, 1e-6));
            sim_result_free(&result);
        }
        sim_scene_free(&s);
    }
}

/* A mat of 1 slug with 2 ft/s: elastic up to the grip of 10 lb, then braked by it until it stops;
 * 0.1 ft short of where it is, the anchor exerts nothing. */
TEST(an_anchor_holds_its_grip)
{
    struct sim_scene s = apart(5);
    s.mods.band[0].count = 0.0;
    s.mods.restraint[SIM_ANCHORS] =
        (struct sim_restraint){.spacing = 3, .k_lb_ft = 100.0, .grip_lb = 10.0};
    s.v0_mat = 3;
    s.v0_ft_s = 2.0;
    double u1 = 0.1, v1 = sqrt(4.0 - 100.0 * u1 * u1), t1 = asin(100.0 * u1 / 20.0) / 10.0,
           t2 = 0.1;
    s.t_end_s = t1 + t2;
    struct sim_result result = run(&s, (struct sim_options){.dt_s = 1e-5});
    double u = u1 + v1 * t2 - 5.0 * t2 * t2;
    near(result.u_ft[3], u, 2e-5);
    near(result.mods->restraint_zero_ft[0], u - 0.1, 2e-5);
    near(result.mods->restraint_load_lb[0], 10.0, 1e-12);
    assert_int_equal(result.mods->restraint_counts[SIM_ANCHORS], 1);
    mods_carry_over(&s, &result); /* the next landing begins with the load that is left */
    near(s.mods.restraint[SIM_ANCHORS].zero_ft.values[0], -0.1, 1e-9);
    sim_result_free(&result);
    s.v0_ft_s = 0.0;
    s.t_end_s = 0.25 * PI / 10.0;
    result = run(&s, (struct sim_options){.dt_s = 1e-5});
    near(result.u_ft[3], -0.1 + 0.1 * cos(10.0 * s.t_end_s), 2e-5);
    sim_result_free(&result);
    sim_scene_free(&s);
}

/* Two mats of 1 slug, one thrown at the other with 1 ft/s: the opening x of their joint follows
 * x'' = -2 (k x + c x'), the two together move at 1/2 ft/s; capped, x'' = 2 grip. */
TEST(an_absorber_keeps_the_opening)
{
    const double k = 50.0, c = 2.0, w = sqrt(2.0 * k - c * c), t = 0.4;
    struct sim_scene s = apart(2);
    s.mods.band[0].count = 0.0;
    s.mods.restraint[SIM_ABSORBERS] = (struct sim_restraint){
        .spacing = 1, .first_place = 2, .k_lb_ft = k, .c_lb_s_ft = c, .grip_lb = (double)INFINITY};
    s.v0_mat = 1;
    s.v0_ft_s = 1.0;
    s.t_end_s = t;
    for (int model = SIM_MODEL_CONSISTENT; model <= SIM_MODEL_CHAIN; model++) {
        s.model = (enum sim_model)model;
        struct sim_result result = run(&s,
                                       (struct sim_options){.solver = "staggered", .dt_s = 1e-5});
        double x = -exp(-c * t) * sin(w * t) / w;
        near(result.u_ft[2] - result.u_ft[1], x, 2e-5);
        near(result.u_ft[2] + result.u_ft[1], t, 1e-5);
        sim_result_free(&result);
    }
    s.mods.restraint[SIM_ABSORBERS].k_lb_ft = 1e4;
    s.mods.restraint[SIM_ABSORBERS].c_lb_s_ft = 0.0;
    s.mods.restraint[SIM_ABSORBERS].grip_lb = 1.0;
    struct sim_result result = run(&s, (struct sim_options){.dt_s = 1e-5}); /* chain */
    near(result.u_ft[2] - result.u_ft[1], -t + t * t, 1e-3);
    near(result.mods->restraint_load_lb[0], 1.0, 1e-12);
    /* the next landing begins with the absorber pressed: it pushes the mats apart */
    const double gaps[] = {5.0, 5.0 + result.u_ft[2] - result.u_ft[1], 5.0};
    mods_carry_over(&s, &result);
    sim_scene_set_list(&s.gap0_ft, gaps, 3);
    sim_result_free(&result);
    s.v0_ft_s = 0.0;
    s.t_end_s = 0.3;
    result = run(&s, (struct sim_options){.dt_s = 1e-5});
    near(result.u_ft[2] - result.u_ft[1], 0.09, 1e-4);
    sim_result_free(&result);
    sim_scene_free(&s);
}

/* Raised by 0.05 ft a tied mat falls with its weight and the tie's pull: elastic, or pulled out. */
TEST(a_tie_pulls_a_mat_down)
{
    struct sim_scene s = text_scene(
        "{\"model\": \"consistent\", \"N\": 1, \"L\": 2, \"g\": 10, \"W\": 10, \"I\": 1, "
        "\"KV\": 1e7, \"CV\": 0, \"right\": \"free\", \"F\": 0, \"Vac\": 0, \"v0\": 0, "
        "\"friction\": \"none\", \"bump_first\": 1, \"bump\": [0.05, 0.05], \"tend\": 0.05, "
        "\"tie_every\": 1, \"tie_K\": 400}");
    double z[3], t = 0.05;
    march(&s, z, 3);
    near(-z[0], -0.025 + 0.075 * cos(20.0 * t), 1e-5);
    near(z[0], z[2], 1e-12);
    s.mods.restraint[SIM_TIE_DOWNS].grip_lb = 5.0;
    march(&s, z, 3);
    /* pulled out to 0.0375 ft at once, elastic down to there, then free */
    double t1 = acos(2.0 / 3.0) / 20.0, v1 = -20.0 * 0.0375 * sin(20.0 * t1), t2 = t - t1;
    near(-z[0], 0.0375 + v1 * t2 - 5.0 * t2 * t2, 1e-5);
    s.mods.restraint[SIM_TIE_DOWNS].k_lb_ft = 0.0;
    s.mods.restraint[SIM_TIE_DOWNS].spacing = 0;
    march(&s, z, 3);
    near(-z[0], 0.05 - 0.5 * 10.0 * t * t, 1e-5);
    sim_scene_free(&s);
}

/* Mats left out by the window change nothing, bit for bit. */
TEST(the_window_changes_nothing)
{
    double weights[120], kl[121];
    for (int model = SIM_MODEL_CONSISTENT; model <= SIM_MODEL_CHAIN; model++) {
        struct sim_scene s = runway();
        s.model = (enum sim_model)model;
        for (int n = 0; n < 120; n++)
            weights[n] = s.weight_lb * (1.0 + 0.3 * (n % 3));
        for (int j = 0; j <= 120; j++)
            kl[j] = s.kl_lb_ft * (1.0 - 0.2 * (j % 4));
        sim_scene_set_list(&s.varied[SIM_VARIED_W], weights, 120);
        sim_scene_set_list(&s.varied[SIM_VARIED_KL], kl, 121);
        s.left_end = SIM_END_SPRING;
        s.end_k_lb_ft[0] = 1e3;
        s.right_end = SIM_END_LOADED;
        s.end_load_lb[1] = 20.0;
        s.mods.restraint[SIM_ANCHORS] = (struct sim_restraint){
            .spacing = 9, .k_lb_ft = 500.0, .c_lb_s_ft = 0.5, .grip_lb = 4.0};
        s.mods.restraint[SIM_ABSORBERS] =
            (struct sim_restraint){.spacing = 4, .k_lb_ft = 2e3, .c_lb_s_ft = 0.3, .grip_lb = 9.0};
        struct sim_result part = run(&s, (struct sim_options){.dt_s = 2e-5}),
                          whole = run(
                              &s, (struct sim_options){.dt_s = 2e-5, .integrates_all_mats = true});
        assert_true(part.integrated_mats_mean < 0.95 * whole.integrated_mats_mean &&
                    whole.peak_u_ft > 0.002);
        for (int n = 1; n <= 120 && model == SIM_MODEL_CHAIN; n++)
            assert_true(part.u_ft[n] == whole.u_ft[n]);
        for (int n = 1; n <= 120; n++)
            near(part.u_ft[n], whole.u_ft[n], 1e-9 + part.error_u_ft);
        sim_result_free(&part);
        sim_result_free(&whole);
        sim_scene_free(&s);
    }
}
