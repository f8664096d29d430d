/* Scene files: what is read, what is refused, and how the refusal reads. */

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include <jansson.h>

#include "host/sim/scene/scene.h"
#include "tests/cmocka_all.h"

#define SCENE_FILE "build/test-tmp/test_sim_scene.json"

static enum mr_status load(const char *text, struct sim_scene *scene, struct error *error)
{
    mkdir("build", 0777);
    mkdir("build/test-tmp", 0777);
    FILE *file = fopen(SCENE_FILE, "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
    memset(error, 0, sizeof *error);
    return sim_scene_load(scene, SCENE_FILE, error);
}

static void refused(const char *text, enum mr_status status, const char *names)
{
    struct sim_scene scene;
    struct error error;
    assert_int_equal(load(text, &scene, &error), status);
    if (!strstr(error.text, names))
        fail_msg("'%s' does not name '%s'", error.text, names);
    assert_non_null(strstr(error.text, "test_sim_scene.json"));
}

TEST(defaults_are_those_of_the_model)
{
    struct sim_scene scene;
    struct error error;
    assert_int_equal(load("{}", &scene, &error), MR_OK);
    assert_int_equal(scene.model, SIM_MODEL_REPORT);
    assert_int_equal(scene.mats, 53);
    assert_true(scene.weight_lb == 160.0 && scene.kl_lb_ft == 8e6 && scene.g_ft_s2 == 32.174);
    assert_true(scene.left_end == SIM_END_FREE && scene.right_end == SIM_END_FIXED &&
                scene.v0_ft_s == 2.0);
    assert_true(fabs(sim_scene_end_s(&scene) - 3.0 * 2.0 / 90.0) < 1e-15);
    sim_scene_free(&scene);
}

TEST(every_key_is_read)
{
    struct sim_scene s;
    struct error error;
    enum mr_status status = load(
        "{\"_a comment\": [1],\"name\": \"all\",\"model\": \"chain\",\"N\": 3,\"L\": 1,\"W\": 2,"
        "\"g\": 30,\"I\": 4,\"KV\": 5,\"CV\": 6,\"KL\": 7,\"CL\": 8,\"KT\": 9,\"CT\": 10,"
        "\"TAD_deg\": 11,\"tad_mode\": \"switched\",\"profile\": \"full\",\"slack\": 0.5,"
        "\"left\": \"fixed\",\"right\": \"free\",\"left_torsion\": \"fixed\","
        "\"right_torsion\": \"fixed\",\"F\": 12,\"Vac\": 13,\"s0\": 0.14,\"F_tstop\": 15,"
        "\"thrust\": \"linear\",\"wheel_load\": 16,\"f\": 0.17,\"friction\": \"tanh\",\"veps\": "
        "0.18,"
        "\"friction_normal\": \"soil\",\"V\": 19,\"lift_shear\": \"both\",\"Q1\": "
        "20,\"bump_first\": 2,"
        "\"bump\": [0.1, 0.2, 0.3],\"v0\": 21,\"v0_mat\": 3,\"mats_crossed\": 2,\"tend\": 9,"
        "\"t_out\": [1, 9],\"u_mats\": [3, 1],\"path\": [[0, 0, 1], [8, 2, 3]],"
        "\"gap0\": [0.1, 0.2, 0.3, 0.4],\"grit\": 22,\"t_dwell\": 1}",
        &s, &error);
    if (status != MR_OK)
        fail_msg("%s", error.text);
    assert_string_equal(s.name, "all");
    assert_int_equal(s.model, SIM_MODEL_CHAIN);
    const double read[] = {
        s.mats,           s.length_ft,    s.weight_lb,     s.g_ft_s2,    s.inertia_slug_ft2,
        s.kv_lb_ft,       s.cv_lb_s_ft,   s.kl_lb_ft,      s.cl_lb_s_ft, s.kt_lb_ft_rad,
        s.ct_lb_ft_s_rad, s.tad_deg,      s.slack_ft,      s.force_lb,   s.vac_ft_s,
        s.start_ft,       s.force_stop_s, s.wheel_load_lb, s.friction,   s.veps_ft_s,
        s.lift_shear_lb,  s.q1_lb,        s.bump_first,    s.v0_ft_s,    s.v0_mat,
        s.mats_crossed,   s.t_end_s,      s.t_dwell_s};
    const double written[] = {3,  1,    2,  30, 4,    5,    6,  7,  8, 9,  10, 11, 0.5, 12,
                              13, 0.14, 15, 16, 0.17, 0.18, 19, 20, 2, 21, 3,  2,  9,   1};
    for (size_t i = 0; i < sizeof read / sizeof read[0]; i++)
        assert_true(read[i] == written[i]);
    assert_true(s.tad_mode == SIM_TAD_SWITCHED && s.profile == SIM_PROFILE_FULL &&
                s.left_end == SIM_END_FIXED && s.right_end == SIM_END_FREE);
    assert_true(s.left_torsion == SIM_END_FIXED && s.right_torsion == SIM_END_FIXED &&
                s.thrust == SIM_THRUST_LINEAR);
    assert_true(s.friction_law == SIM_FRICTION_TANH && s.friction_normal == SIM_NORMAL_SOIL &&
                s.lift_shear == SIM_SHEAR_BOTH);
    assert_true(s.bump_ft.count == 3 && s.bump_ft.values[2] == 0.3 && s.output_mats.count == 2 &&
                s.output_mats.values[0] == 3.0);
    assert_true(s.t_out_s.count == 2 && s.path_count == 2 && s.path[1].x_ft == 2.0 &&
                s.path[1].force_lb == 3.0);
    assert_true(sim_scene_joint_value(&s.gap0_ft, 4) == 0.4 &&
                sim_scene_joint_value(&s.grit_lb, 4) == 22.0);
    sim_scene_free(&s);
}

TEST(unknown_keys_are_named)
{
    refused("{\"frictoin\": \"stick\"}", MR_MALFORMED, "\"frictoin\"");
    refused("{\"n\": 3}", MR_MALFORMED, "\"n\"");
}

TEST(wrong_types_are_named)
{
    refused("{\"KL\": \"8e6\"}", MR_MALFORMED, "KL is \"8e6\"; write lb/ft, ");
    refused("{\"kl\": 8e6}", MR_MALFORMED, "write \"KL\"");
    refused("{\"N\": 3.5}", MR_MALFORMED,
            "N is a number with a point or exponent; give a whole number");
    refused("{\"N\": true}", MR_MALFORMED, "N is true or false; give a whole number");
    refused("{\"name\": 1}", MR_MALFORMED, "name is a number; give text");
    refused("{\"left\": 1}", MR_MALFORMED, "left; give one of free, fixed");
    refused("{\"left\": \"loose\"}", MR_MALFORMED, "left is \"loose\"; give one of free, fixed");
    refused("{\"bump\": 1}", MR_MALFORMED, "bump is a number; give a list");
    refused("{\"bump\": [1, null]}", MR_MALFORMED, "bump[1]");
    refused("{\"gap0\": \"x\"}", MR_MALFORMED, "gap0 is \"x\"; write digits such as 4, or 4 ft");
    refused("{\"path\": 5}", MR_MALFORMED, "path is a number; give a list of rows");
    refused("{\"path\": [[0, 1, 2], [1, 2]]}", MR_MALFORMED, "row 1 of path");
    refused("{\"path\": [[0, 1, 2], 7]}", MR_MALFORMED, "row 1 of path");
    refused("[1, 2]", MR_MALFORMED, "not a JSON object");
}

TEST(wrong_lengths_and_ranges_are_named)
{
    refused("{\"N\": 3, \"gap0\": [0.1, 0.2, 0.3]}", MR_MALFORMED,
            "gap0 has 3 values; give one number or 4");
    refused("{\"N\": 0}", MR_MALFORMED, "N is 0");
    refused("{\"N\": 99999999999}", MR_MALFORMED, "N is 99999999999");
    refused("{\"W\": 0}", MR_MALFORMED, "W is 0; give a number above 0");
    refused("{\"f\": -0.5}", MR_MALFORMED, "f is -0.5; give a finite number from 0");
    refused("{\"W\": 1e30}", MR_MALFORMED, "W is 1e+30; give at most 1e+15");
    refused("{\"tend\": 1e16}", MR_MALFORMED, "tend is 1e+16; give at most 1e+15");
    refused("{\"F\": -1e16}", MR_MALFORMED, "F is -1e+16; give a finite number from -1e+15");
    refused("{\"tend\": 1, \"t_out\": [1e16]}", MR_MALFORMED, "t_out[0] is 1e+16; give at most");
    refused("{\"TAD_deg\": 190}", MR_MALFORMED, "TAD_deg is 190; give 0 to 180");
    refused("{\"path\": [[0, 1, 2], [1, 1e16, 2]]}", MR_MALFORMED,
            "row 1 of path: x_ft is 1e+16; give -1e+15 to 1e+15");
    refused("{\"N\": 1, \"grit\": [1, -2]}", MR_MALFORMED, "grit[1] is -2");
    refused("{\"t_dwell\": -1}", MR_MALFORMED, "t_dwell");
    refused("{\"N\": 5, \"u_mats\": [6]}", MR_MALFORMED,
            "u_mats[0] is 6; give a whole number from 1 to 5 (N)");
    refused("{\"N\": 5, \"u_mats\": [1.5]}", MR_MALFORMED, "u_mats[0]");
    refused("{\"N\": 5, \"v0_mat\": 6}", MR_MALFORMED, "v0_mat");
    refused("{\"N\": 5, \"bump\": [1, 1, 1]}", MR_MALFORMED,
            "bump ends at node 7; give values up to node 6");
    refused("{\"tend\": 1, \"t_out\": [0.5, 1.5]}", MR_MALFORMED, "t_out[1]");
    refused("{\"Vac\": 0}", MR_MALFORMED, "tend");
    refused("{\"path\": []}", MR_MALFORMED, "path");
    refused("{\"path\": [[0, 1, 2]]}", MR_MALFORMED, "path");
    refused("{\"path\": [[1, 1, 2], [0.5, 2, 2]]}", MR_MALFORMED, "row 1 of path is at 0.5 s");
    refused("{\"path\": [[1, 1, 2], [1, 2, 2], [2, 2, 2]]}", MR_MALFORMED, "row 1 of path");
}

TEST(broken_json_has_line_and_column)
{
    refused("{\"N\": 3,\n \"L\": 1 \"W\": 2}", MR_MALFORMED, "line 2 column");
    refused("{\"N\": 3,\n \"L\": 1,\n", MR_TRUNCATED, "line ");
    refused("", MR_TRUNCATED, "line ");
    refused("{\"N\": 3, \"N\": 4}", MR_MALFORMED, "uplicate");
    refused("{\"L\": 1e999}", MR_MALFORMED, "line 1 column");
    refused("{\"L\": NaN}", MR_MALFORMED, "line 1 column");
}

TEST(unreadable_files_are_io)
{
    struct sim_scene scene;
    struct error error = {0};
    assert_int_equal(sim_scene_load(&scene, "build/test-tmp/no such scene.json", &error), MR_IO);
    assert_non_null(strstr(error.text, "no such scene.json"));
    memset(&error, 0, sizeof error);
    assert_int_equal(sim_scene_load(&scene, "tests", &error), MR_IO);
}

TEST(a_scene_made_in_memory_is_checked_too)
{
    struct sim_scene scene;
    struct error error = {0};
    double two[] = {1.0, 2.0};
    sim_scene_set_defaults(&scene);
    sim_scene_set_list(&scene.gap0_ft, two, 2);
    assert_int_equal(sim_scene_check(&scene, "made", &error), MR_MALFORMED);
    assert_non_null(strstr(error.text, "made: gap0 has 2 values; give one number or 54"));
    memset(&error, 0, sizeof error);
    sim_scene_set_list(&scene.gap0_ft, two, 1);
    assert_int_equal(sim_scene_check(&scene, "made", &error), MR_OK);
    scene.kl_lb_ft = (double)NAN;
    assert_int_equal(sim_scene_check(&scene, "made", &error), MR_MALFORMED);
    assert_non_null(strstr(error.text, "KL"));
    sim_scene_free(&scene);
}

TEST(the_end_follows_the_aircraft)
{
    struct sim_scene scene;
    const struct sim_path_row stops[] = {{0, 0, 5}, {2, 10, 5}, {3, 10, 0}, {9, 10, 0}};
    const struct sim_path_row leaves[] = {{0, 0, 5}, {1, 100, 5}, {2, 300, 5}};
    sim_scene_set_defaults(&scene);
    sim_scene_set_path(&scene, stops, 4);
    assert_true(sim_scene_end_s(&scene) == 9.0);
    scene.t_dwell_s = 0.5;
    assert_true(sim_scene_end_s(&scene) == 2.5);
    sim_scene_set_path(&scene, leaves, 3); /* 53 mats of 2 ft: left at 1.03 s */
    assert_true(fabs(sim_scene_end_s(&scene) - 1.53) < 1e-12);
    scene.t_end_s = 0.7;
    assert_true(sim_scene_end_s(&scene) == 0.7);
    sim_scene_free(&scene);
}

TEST(shipped_scenes_load)
{
    const char *const names[] = {"host/scenes/model_runway.json", "host/scenes/friction_block.json",
                                 "host/scenes/wave.json"};
    for (size_t i = 0; i < 3; i++) {
        struct sim_scene scene;
        struct error error = {0};
        if (sim_scene_load(&scene, names[i], &error) != MR_OK)
            fail_msg("%s", error.text);
        if (i == 0) {
            /* 28 ft/s at 4 ft/s2, and half of the 50 ms rise: stops after 7.025 s near 98 + 3 + 0.7
             * ft */
            const struct sim_path_row *stop = &scene.path[scene.path_count - 1];
            assert_true(fabs(stop->t_s - 7.025) < 1e-3 &&
                        fabs(stop->x_ft - (3.0 + 98.0 + 0.7)) < 0.01);
            assert_true(fabs(sim_scene_end_s(&scene) - stop->t_s - 1.0) < 1e-12);
            assert_true(fabs(scene.path[20].force_lb - 1300.0 / 12.0 * 4.0 / 32.174) < 1e-3);
        }
        sim_scene_free(&scene);
    }
}

/* 1 lb = 4.4482216152605 N and 1 ft = 0.3048 m (exact). */
TEST(numbers_are_read_with_their_unit)
{
    struct sim_scene s;
    struct error error;
    if (load("{\"L\": \"0.6096 m\", \"W\": \"444.82216152605 N\", \"KV\": \"14593.902937206364 "
             "N/m\", \"CV\": \"7 lb s/ft\","
             "\"I\": \"2.7116358966628 kg m2\", \"V\": \"-5lb\", \"g\": \"9.80665 m/s2\"}",
             &s, &error) != MR_OK)
        fail_msg("%s", error.text);
    const double read[] = {s.length_ft,        s.weight_lb,     s.kv_lb_ft, s.cv_lb_s_ft,
                           s.inertia_slug_ft2, s.lift_shear_lb, s.g_ft_s2};
    const double meant[] = {2, 100, 1000, 7, 2, -5, 9.80665 / 0.3048};
    for (size_t i = 0; i < sizeof read / sizeof read[0]; i++) {
        if (!(fabs(read[i] - meant[i]) <= 1e-12 * fabs(meant[i])))
            fail_msg("number %zu is %.17g, not %.17g", i, read[i], meant[i]);
    }
    sim_scene_free(&s);
    refused("{\"CV\": \"7 N\"}", MR_MALFORMED, "a force instead of a damping: ");
    refused("{\"CV\": \"N s/m\"}", MR_MALFORMED, "CV");
    refused("{\"CV\": \"7 N s/m2\"}", MR_MALFORMED, "N s/m");
    refused("{\"CV\": \"-7 N s/m\"}", MR_MALFORMED, "value out of range");
    refused("{\"CV\": \"nan N s/m\"}", MR_MALFORMED, "not a number: ");
    refused("{\"TAD_deg\": \"7 ft\"}", MR_MALFORMED, "a length instead of an angle: ");
    refused("{\"N\": \"7 ft\"}", MR_MALFORMED, "wrong type");
}

/* Every key is explained, and the defaults read as a scene are the scene of an empty file. */
TEST(the_keys_say_what_is_read)
{
    struct sim_scene plain, read;
    struct error error = {0};
    json_t *keys = sim_scene_keys_to_json(), *scene = json_object(), *one;
    const struct sim_key *key;
    const char *name;
    size_t count = 0, defaults = 0;
    for (; (key = sim_key_at(count)); count++)
        assert_true(key->meaning[0] != '\0');
    assert_int_equal(json_object_size(keys), count);
    json_object_foreach(keys, name, one)
    {
        assert_string_equal(json_string_value(json_object_get(one, "meaning")),
                            sim_key_find(name)->meaning);
        defaults += json_object_set(scene, name, json_object_get(one, "default")) == 0;
    }
    json_object_set_new(scene, "tend", json_real(0.5)); /* 0 means: from the others */
    assert_true(defaults > 60);
    if (sim_scene_from_json(&read, "keys", scene, &error) != MR_OK)
        fail_msg("%s", error.text);
    sim_scene_set_defaults(&plain);
    plain.t_end_s = 0.5;
    for (size_t i = 0; (key = sim_key_at(i)); i++) {
        size_t bytes = key->kind == SIM_KEY_REAL                                ? sizeof(double)
                     : key->kind <= SIM_KEY_CHOICE && key->kind != SIM_KEY_TEXT ? sizeof(int)
                                                                                : 0;
        assert_memory_equal((const char *)&read + key->offset, (const char *)&plain + key->offset,
                            bytes);
    }
    sim_scene_free(&read);
    json_decref(scene);
    json_decref(keys);
}
