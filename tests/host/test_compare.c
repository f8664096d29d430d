/* The scene made of a run: path, thrust and gaps against the closed form; and the comparison's figures. */
#include "common/wire.h"
#include "host/compare.h"
#include "tests/host/session.h"

static const struct stream_truth brisk = {.v0_ft_s = 35.0, .a_ft_s2 = 8.0, .peak_in = 0.8};

static void load_one(struct session *s, struct measured *m, struct zones_closure *survey)
{
    struct stream_truth truth = brisk;
    session_begin(s, false, true);
    stream_hello(&s->stream, MR_LAYOUT);
    stream_configuration(&s->stream);
    stream_idle(&s->stream, 300);
    stream_landing(&s->stream, &truth, 5);
    session_log(s, "compare.db");
    assert_int_equal(measured_load(s->store, 1, m, &s->error), MR_OK);
    assert_int_equal(zones_load_survey(s->store, 1, survey, &s->error), MR_OK);
}

static void runway(struct sim_scene *scene)
{
    struct error error = {0};
    assert_int_equal(sim_scene_load(scene, "host/scenes/model_runway.json", &error), MR_OK);
}

static void path_and_thrust(void **state)
{
    struct session s;
    struct measured m;
    struct zones_closure survey;
    struct sim_scene scene;
    (void)state;
    load_one(&s, &m, &survey);
    runway(&scene);
    assert_int_equal(compare_scene(&m, &survey, &scene, &s.error), MR_OK);
    assert_true(scene.path_count > 200);
    assert_near(scene.path[0].t_s, 0.0, 0.0);
    assert_near(scene.path[0].x_ft, 3.0, 0.001);
    const struct sim_path_row *last = &scene.path[scene.path_count - 1];
    assert_near(last->t_s, 4.375, 0.002);
    assert_near(last->x_ft, 79.5625, 0.005);
    assert_near(last->force_lb, 0.0, 0.0);
    /* (1300 lb / 12) (8 / 32.174) = 26.937 lb, all the way; up to the first switch beyond touchdown (0.13 s) less sharply: this
     * brake comes at once, and the fit allows it a delay */
    for (size_t i = 0; i + 1 < scene.path_count; i++) {
        double t = scene.path[i].t_s;
        assert_near(scene.path[i].x_ft, 3.0 + 35.0 * t - 4.0 * t * t, 0.005);
        assert_near(scene.path[i].force_lb, 26.937, t < 0.14 ? 7.0 : 0.8);
    }
    sim_scene_free(&scene);
    measured_free(&m);
    session_end(&s);
}

static void gaps_from_the_survey(void **state)
{
    struct session s;
    struct measured m;
    struct zones_closure survey;
    struct sim_scene scene;
    (void)state;
    load_one(&s, &m, &survey);
    runway(&scene);
    survey.slack_in[7] = 0.36f;  /* joints 71 to 80: 0.036 in each */
    survey.slack_in[8] = MR_NAN; /* joints 81 to 90: the scene's own 0.0015 ft */
    assert_int_equal(compare_scene(&m, &survey, &scene, &s.error), MR_OK);
    assert_int_equal(scene.gap0_ft.count, 421);
    assert_near(sim_scene_joint(&scene.gap0_ft, 70), 0.02 / 12.0, 1e-9);
    assert_near(sim_scene_joint(&scene.gap0_ft, 71), 0.036 / 12.0, 1e-9);
    assert_near(sim_scene_joint(&scene.gap0_ft, 80), 0.036 / 12.0, 1e-9);
    assert_near(sim_scene_joint(&scene.gap0_ft, 81), 0.0015, 1e-12);
    assert_near(sim_scene_joint(&scene.gap0_ft, 90), 0.0015, 1e-12);
    assert_near(sim_scene_joint(&scene.gap0_ft, 91), 0.02 / 12.0, 1e-9);
    assert_near(sim_scene_joint(&scene.gap0_ft, 421), 0.0015, 1e-12);
    sim_scene_free(&scene);
    measured_free(&m);
    session_end(&s);
}

static void motion_not_known_is_refused(void **state)
{
    struct session s;
    struct measured m;
    struct zones_closure survey;
    struct sim_scene scene;
    (void)state;
    load_one(&s, &m, &survey);
    runway(&scene);
    m.fit_status = MR_TOO_FEW;
    assert_int_equal(compare_scene(&m, &survey, &scene, &s.error), MR_TOO_FEW);
    assert_error(&s.error, MR_TOO_FEW, "RUN 1");
    sim_scene_free(&scene);
    measured_free(&m);
    session_end(&s);
}

/* Put the simulated movement into the measured series: all differences vanish; add 0.1 in: the rms is 0.1. */
static void differences_of_a_known_series(void **state)
{
    struct session s;
    struct measured m;
    struct zones_closure survey;
    struct sim_scene scene;
    struct comparison first, same, off;
    (void)state;
    load_one(&s, &m, &survey);
    runway(&scene);
    assert_int_equal(compare_scene(&m, &survey, &scene, &s.error), MR_OK);
    assert_int_equal(compare_run(&m, &scene, &first, &s.error), MR_OK);
    assert_int_equal(first.count, 8);
    struct measured_channel *c = &m.channel[2];
    const struct store_simulation *row = &first.row[2];
    double largest = 0.0;
    for (size_t i = 0; i < m.samples; i++) {
        double k = measured_time_s(&m, i) / row->dt_s;
        size_t at = k < 0.0 ? 0 : (size_t)k;
        float value =
            at + 1 < row->length
                ? row->series_in[at] + (float)(k - (double)at) * (row->series_in[at + 1] - row->series_in[at])
                : row->series_in[row->length - 1];
        c->raw[i] = k < 0.0 ? (float)c->baseline : value + (float)c->baseline;
    }
    for (size_t k = 0; k < row->length; k++)
        largest = fmax(largest, fabs((double)row->series_in[k]));
    assert_true(largest > 0.05);
    assert_near(row->peak_simulated_in, largest, 1e-6);
    assert_int_equal(compare_run(&m, &scene, &same, &s.error), MR_OK);
    assert_near(same.row[2].rms_in, 0.0, 1e-5);
    for (size_t i = 0; i < m.samples; i++)
        c->raw[i] += 0.1f;
    assert_int_equal(compare_run(&m, &scene, &off, &s.error), MR_OK);
    assert_near(off.row[2].rms_in, 0.1, 1e-5);
    assert_true(off.row[1].rms_in == first.row[1].rms_in);
    compare_free(&first);
    compare_free(&same);
    compare_free(&off);
    sim_scene_free(&scene);
    measured_free(&m);
    session_end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(path_and_thrust),
        cmocka_unit_test(gaps_from_the_survey),
        cmocka_unit_test(motion_not_known_is_refused),
        cmocka_unit_test(differences_of_a_known_series),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
