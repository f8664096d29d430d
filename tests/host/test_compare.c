/* The scene made of a run: path, thrust and gaps against the closed form; alignment, zones, limits;
 * the comparison's figures; ensembles. */
#include <unistd.h>

#include "common/wire.h"
#include "host/analyse/outcome.h"
#include "host/analyse/measured_load.h"
#include "host/compare/limits.h"
#include "host/compare/landing.h"
#include "host/compare/show.h"
#include "host/store/store_journal.h"
#include "tests/host/session.h"

static const struct stream_truth brisk = {.v0_ft_s = 35.0, .a_ft_s2 = 8.0, .peak_in = 0.8};

static void load_one(struct session *s, struct measured_landing *m, struct zones_slack *survey)
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

TEST(path_and_thrust)
{
    struct session s;
    struct measured_landing m;
    struct zones_slack survey;
    struct sim_scene scene;
    load_one(&s, &m, &survey);
    runway(&scene);
    assert_int_equal(compare_prepare_scene(&m, &survey, &scene, &s.error), MR_OK);
    assert_true(scene.path_count > 200);
    assert_near(scene.path[0].t_s, 0.0, 0.0);
    assert_near(scene.path[0].x_ft, 3.0, 0.001);
    const struct sim_path_row *last = &scene.path[scene.path_count - 1];
    assert_near(last->t_s, 4.375, 0.002);
    assert_near(last->x_ft, 79.5625, 0.005);
    assert_near(last->force_lb, 0.0, 0.0);
    /* (1300 lb / 12) (8 / 32.174) = 26.937 lb, all the way; up to the first switch beyond touchdown
     * (0.13 s) less sharply: this brake comes at once, and the fit allows it a delay */
    for (size_t i = 0; i + 1 < scene.path_count; i++) {
        double t = scene.path[i].t_s;
        assert_near(scene.path[i].x_ft, 3.0 + 35.0 * t - 4.0 * t * t, 0.005);
        assert_near(scene.path[i].force_lb, 26.937, t < 0.14 ? 7.0 : 0.8);
    }
    sim_scene_free(&scene);
    measured_free(&m);
    session_end(&s);
}

TEST(gaps_from_the_survey)
{
    struct session s;
    struct measured_landing m;
    struct zones_slack survey;
    struct sim_scene scene;
    load_one(&s, &m, &survey);
    runway(&scene);
    survey.slack_in[7] = 0.36f;  /* joints 71 to 80: 0.036 in each */
    survey.slack_in[8] = MR_NAN; /* joints 81 to 90: the scene's own 0.0015 ft */
    assert_int_equal(compare_prepare_scene(&m, &survey, &scene, &s.error), MR_OK);
    assert_int_equal(scene.gap0_ft.count, 421);
    assert_near(sim_scene_joint_value(&scene.gap0_ft, 70), 0.02 / 12.0, 1e-9);
    assert_near(sim_scene_joint_value(&scene.gap0_ft, 71), 0.036 / 12.0, 1e-9);
    assert_near(sim_scene_joint_value(&scene.gap0_ft, 80), 0.036 / 12.0, 1e-9);
    assert_near(sim_scene_joint_value(&scene.gap0_ft, 81), 0.0015, 1e-12);
    assert_near(sim_scene_joint_value(&scene.gap0_ft, 90), 0.0015, 1e-12);
    assert_near(sim_scene_joint_value(&scene.gap0_ft, 91), 0.02 / 12.0, 1e-9);
    assert_near(sim_scene_joint_value(&scene.gap0_ft, 421), 0.0015, 1e-12);
    sim_scene_free(&scene);
    measured_free(&m);
    session_end(&s);
}

static void load_model(struct compare_model *model, const char *text)
{
    char path[200];
    struct error error = {0};
    FILE *file = fopen(scratch_path(path, sizeof path, "model.json"), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    compare_model_load(model, path, 0, &error);
    assert_no_error(&error);
}

/* Replace what was measured of a transducer by the simulated movement, stretched, moved up, and
 * later. */
static void measure(struct measured_landing *m, size_t channel, const struct store_simulation *row,
                    double scale, double up_in, double late_s)
{
    struct measured_channel *c = &m->channel[channel];
    for (size_t i = 0; i < m->samples; i++) {
        double k = (measured_time_s(m, i) - late_s) / row->dt_s;
        size_t at = k < 0.0 ? 0 : (size_t)k;
        double value = (double)row->series_in[row->length - 1];
        if (at + 1 < row->length)
            value = (double)row->series_in[at] +
                    (k - (double)at) * (double)(row->series_in[at + 1] - row->series_in[at]);
        c->raw[i] = (float)(c->baseline + (k < 0.0 ? 0.0 : scale * value) + up_in);
    }
}

/* What was measured is made of what was simulated: the figures are those of the copy. */
TEST(differences_of_a_known_series)
{
    struct session s;
    struct measured_landing m;
    struct zones_slack survey;
    struct compare_model model;
    struct compare_landing landing;
    struct compare_figures f;
    const struct compare_board_reports nothing = {0};
    load_one(&s, &m, &survey);
    assert_int_equal(compare_model_load(&model, "host/scenes/model_runway.json", 0, &s.error),
                     MR_OK);
    compare_run_landing(s.store, 1, &model, 0, &landing, &s.error);
    assert_no_error(&s.error);
    assert_int_equal(landing.row_count, 8);
    measure(&m, 2, &landing.row[2], 1.0, 0.0, 0.0);
    measure(&m, 3, &landing.row[3], 1.0, 0.1, 0.0);
    measure(&m, 4, &landing.row[4], 1.0, 0.0, 0.04);
    for (size_t i = 0; i < m.samples; i++) {
        m.channel[5].raw[i] = NAN;
        m.channel[5].validity[i] = MR_INVALID_OPEN;
    }
    compare_compute_figures(&m, &survey, &nothing, &landing.head, landing.row, landing.row_count,
                            &f);
    assert_int_equal(f.channel_count, 8);
    assert_near(f.channel[2].figures.rms, 0.0, 1e-5);
    assert_near(f.channel[2].figures.bias, 0.0, 1e-5);
    assert_near(f.channel[2].end_en_score, 0.0, 1e-3);
    assert_near(f.channel[3].figures.rms, 0.1, 1e-5);
    assert_near(f.channel[3].figures.bias, 0.1, 1e-5);
    assert_near(f.channel[3].end_measured.value - f.channel[3].end_simulated.value, 0.1, 1e-5);
    /* En is the difference over twice the error of both */
    double u = hypot(f.channel[3].end_measured.error, f.channel[3].end_simulated.error);
    assert_near(f.channel[3].end_en_score, 0.1 / (2.0 * u), 0.01);
    assert_near(f.channel[4].figures.arrival_measured.t_s -
                    f.channel[4].figures.arrival_simulated.t_s,
                0.04, 2e-3);
    assert_false(f.channel[5].is_compared);
    assert_non_null(strstr(f.channel[5].reason_or_remark, "0 % of the readings are valid"));
    /* untouched: as the landing had it */
    assert_true(f.channel[1].figures.rms == landing.figures.channel[1].figures.rms &&
                f.channel[1].figures.rms > 0.01);
    struct answer *answer = answer_new(false);
    compare_to_answer(&f, &(struct compare_verdict){0}, answer);
    json_t *json = answer_make_json(answer);
    char *text = json_dumps(json, 0);
    assert_non_null(text);
    assert_null(strstr(text, "nan"));
    free(text);
    json_decref(json);
    size_t length;
    FILE *out = open_memstream(&text, &length);
    assert_true(answer_print_text(answer, out));
    fclose(out);
    assert_non_null(strstr(text, "transducer 6: not compared: only 0 % of the readings are valid"));
    free(text);
    answer_free(answer);
    compare_landing_free(&landing);
    compare_model_free(&model);
    measured_free(&m);
    session_end(&s);
}

/* The report's table is the same from what the campaign keeps. */
TEST(kept_and_made_again)
{
    struct session s;
    struct measured_landing m;
    struct zones_slack survey;
    struct compare_model model;
    struct compare_landing landing;
    struct compare_figures again;
    struct store_simulation *rows;
    struct store_simulation_summary head;
    const struct compare_board_reports nothing = {0};
    size_t count;
    load_one(&s, &m, &survey);
    compare_model_load(&model, "host/scenes/model_runway.json", 0, &s.error);
    compare_run_landing(s.store, 1, &model, 0, &landing, &s.error);
    store_simulations_get(s.store, 1, &rows, &count, &s.error);
    store_simulation_summary_get(s.store, 1, &head, &s.error);
    compare_compute_figures(&m, &survey, &nothing, &head, rows, count, &again);
    assert_no_error(&s.error);
    assert_string_equal(again.model_file, "model_runway.json");
    assert_int_equal(again.seed_count, 1);
    for (size_t c = 0; c < 8; c++) {
        assert_true(again.channel[c].figures.rms == landing.figures.channel[c].figures.rms);
        assert_true(again.channel[c].peak_en_score == landing.figures.channel[c].peak_en_score);
        assert_true(again.channel[c].figures.bias_error ==
                    landing.figures.channel[c].figures.bias_error);
    }
    assert_int_equal(again.zones.count, landing.figures.zones.count);
    assert_true(again.zones.moment[0].zone[COMPARE_SIMULATED].mats ==
                landing.figures.zones.moment[0].zone[COMPARE_SIMULATED].mats);
    free(head.segments_in);
    store_simulations_free(rows, count);
    compare_landing_free(&landing);
    compare_model_free(&model);
    measured_free(&m);
    session_end(&s);
}

/* A sample's error: what the reading has, and how far the simulated movement changes while the
 * wheel's time is uncertain. */
TEST(errors_of_a_sample)
{
    struct session s;
    struct measured_landing m;
    struct zones_slack survey;
    struct compare_timing clock;
    struct compare_curves series;
    load_one(&s, &m, &survey);
    float slope[1001], spread[1001];
    for (size_t i = 0; i <= 1000; i++) {
        slope[i] = 0.001f * (float)i; /* 0.25 in/s */
        spread[i] = 0.04f;
    }
    const struct store_simulation row = {
        .number = 3, .dt_s = 0.004, .series_in = slope, .spread_in = spread, .length = 1001};
    compare_timing_init(&m, &clock);
    /* before the stop at 4.375 s the wheel's time is known to a fraction of a millisecond, at rest
     * to no more than the stop's */
    assert_true(compare_compute_time_error_s(&clock, 1.0) > 1e-6 &&
                compare_compute_time_error_s(&clock, 1.0) < 2e-3);
    assert_near(compare_compute_time_error_s(&clock, 100.0), clock.stop_error_s, 0.0);
    assert_near(compare_compute_time_error_s(&clock, -1.0), clock.error_s[0], 0.0);
    for (size_t i = 0; i <= COMPARE_TIMING_POINTS; i++)
        clock.error_s[i] = 0.02;
    compare_fill_curves(&m, &clock, &m.channel[2], &row, 0.03, &series);
    size_t compared = 0;
    for (size_t i = 0; i < m.samples; i++) {
        if (series.t_s[i] < 0.1 || series.t_s[i] > 3.8)
            continue;
        double reading_in = measured_standard_error(&m, &m.channel[2],
                                                    measured_value(&m.channel[2], i), 1.0);
        assert_near(series.simulated_in[i], 0.25 * series.t_s[i], 1e-6);
        assert_near(series.alignment_error_in[i], 0.25 * 0.02, 1e-6);
        assert_near(series.measured_error_in[i], hypot(reading_in, 0.005), 1e-6);
        assert_near(series.simulated_error_in[i], 0.05, 1e-8); /* 3, 4, 5 */
        assert_true(reading_in > 1e-4);
        compared++;
    }
    assert_true(compared > 3000);
    free(series.storage);
    measured_free(&m);
    session_end(&s);
}

TEST(zones_by_segments)
{
    const double segment_ft = 20.0 / 7.0;
    float slack_in[MR_SEGMENTS], left_in[MR_SEGMENTS];
    for (unsigned k = 0; k < MR_SEGMENTS; k++)
        slack_in[k] = left_in[k] = 0.2f;
    struct compare_zone none = compare_find_closed_zone(slack_in, left_in, 50.0);
    assert_true(none.is_known && none.mats == 0.0);
    for (unsigned k = 20; k < 25; k++)
        left_in[k] = 0.009f;
    left_in[30] = 0.009f;
    struct compare_zone ahead = compare_find_closed_zone(slack_in, left_in, 50.0);
    assert_near(ahead.mats, 50.0, 1e-3);
    assert_near(ahead.start_ft, 20.0 * segment_ft, 1e-4);
    assert_near(ahead.end_ft, 25.0 * segment_ft, 1e-4);
    struct compare_zone in = compare_find_closed_zone(slack_in, left_in,
                                                      60.0); /* the wheel is in it */
    assert_near(in.start_ft, 60.0, 1e-9);
    assert_near(in.mats, 40.0, 1e-9); /* 40.0 mats */
    assert_near(in.start_error_ft, 0.0, 1e-9);
    assert_near(in.end_error_ft, segment_ft, 1e-6);
    struct compare_zone beyond = compare_find_closed_zone(slack_in, left_in, 75.0);
    assert_near(beyond.start_ft, 30.0 * segment_ft, 1e-4);
    left_in[25] = 0.04f; /* four fifths are closed */
    struct compare_zone partly = compare_find_closed_zone(slack_in, left_in, 50.0);
    assert_near(partly.end_ft, 25.8 * segment_ft, 1e-4);
    assert_near(partly.mats, 58.0, 1e-9);
    left_in[24] = 0.02f; /* a tenth is open: nothing beyond it counts */
    partly = compare_find_closed_zone(slack_in, left_in, 50.0);
    assert_near(partly.end_ft, 24.9 * segment_ft, 1e-4);
    /* 57.14 to 71.43 against 60 to 80: 11.43 ft of 22.86 */
    struct compare_overlap o =
        compare_compute_overlap(&ahead, &(struct compare_zone){true, 70.0, 60.0, 80.0, 0.0, 0.0});
    assert_near(o.common_mats, (25.0 * segment_ft - 60.0) * 3.5, 1e-3);
    assert_near(o.all_mats, (80.0 - 20.0 * segment_ft) * 3.5, 1e-3);
    assert_near(o.share, o.common_mats / o.all_mats, 1e-9);
    assert_near(o.start_difference_ft, 20.0 * segment_ft - 60.0, 1e-3);
    assert_near(o.end_difference_ft, 25.0 * segment_ft - 80.0, 1e-3);
    o = compare_compute_overlap(&none, &none);
    assert_true(o.is_known && o.share == 1.0 && isnan(o.start_difference_ft));
    o = compare_compute_overlap(&ahead, &none);
    assert_true(o.share == 0.0 && isnan(o.end_difference_ft));
    assert_false(
        compare_compute_overlap(&ahead, &(struct compare_zone){.is_known = false}).is_known);
}

/* A longer zone farther ahead does not hide the one at the wheel. */
TEST(the_zone_near_the_wheel)
{
    const double segment_ft = 20.0 / 7.0;
    float slack_in[MR_SEGMENTS], left_in[MR_SEGMENTS];
    struct mr_closure_zone zone;
    struct reached_zone reach;
    for (unsigned k = 0; k < MR_SEGMENTS; k++) {
        slack_in[k] = 0.3f;
        left_in[k] = (k >= 10 && k <= 15) || (k >= 25 && k <= 34) ? 0.0f : 0.3f;
    }
    zones_find_longest_zone(slack_in, left_in, 10.0 * segment_ft, (double)INFINITY, &zone);
    assert_int_equal(zone.mats, 100);
    reached_zone_init(&reach);
    for (unsigned k = 0; k < 10; k++) {
        zones_find_longest_zone(slack_in, left_in, 10.0 * segment_ft, REACHED_ZONE_DISTANCE_MAX_FT,
                                &zone);
        assert_int_equal(zone.mats, 60);
        reached_zone_update(&reach, 0.02 * k, 10.0 * segment_ft, &zone);
    }
    assert_int_equal(reach.longest_mats, 60);
    assert_near(reach.reached_t_s[REACHED_ZONE_BEST], 0.0, 0.0);
}

static const char campaign_text[] =
    "{\"name\": \"two\", \"scene\": {\"N\": 420, \"L\": 0.2857142857142857, \"W\": 0.466, \"KL\": "
    "2.9e5, \"CL\": 5, \"slack\": 0.0025,"
    " \"f\": 0.5, \"friction\": \"stick\", \"left\": \"fixed\", \"right\": \"fixed\"}, "
    "\"landings\": [{\"times\": 2, \"deceleration_ft_s2\": 8}], \"seeds\": %s,"
    " \"runway\": {\"gap_in\": [0, 0.03], \"closing_lb\": [0, 20]}}";

/* Mean and spread of two runways are those of each of them alone. */
TEST(an_ensemble_of_two)
{
    static const char *const seeds[] = {"[1, 1]", "[2, 2]", "[1, 2]"};
    struct session s;
    struct measured_landing m;
    struct zones_slack survey;
    struct compare_model model;
    struct compare_simulated sim[3];
    const double station_ft[2] = {50.0, 70.0};
    char text[900];
    load_one(&s, &m, &survey);
    for (unsigned k = 0; k < MR_SEGMENTS; k++)
        survey.slack_in[k] = k == 20 ? 0.27f : MR_NAN; /* one segment is surveyed */
    for (int i = 0; i < 3; i++) {
        snprintf(text, sizeof text, campaign_text, seeds[i]);
        load_model(&model, text);
        compare_simulate(&model, 0, &m, &survey, station_ft, 2, &sim[i], &s.error);
        assert_no_error(&s.error);
        /* its openings add up to the survey's, in every runway; the others are as drawn */
        assert_near((double)sim[i].remaining_in[20], 0.27, 1e-5);
        assert_true(sim[i].remaining_in[21] > 0.05f && sim[i].remaining_in[21] < 0.3f);
        /* and are what they were when the next landing begins */
        float end_in = sim[i].remaining_in[(sim[i].segment_row_count - 1) * MR_SEGMENTS + 20];
        struct compare_simulated next;
        compare_simulate(&model, 1, &m, &survey, station_ft, 2, &next, &s.error);
        assert_no_error(&s.error);
        assert_near((double)next.remaining_in[20], (double)end_in, 1e-4);
        compare_simulated_free(&next);
        compare_model_free(&model);
    }
    bool differ = false;
    for (size_t k = 0; k < 2 * sim[2].row_count; k += 37) {
        double a = sim[0].mean_movement_in[k], b = sim[1].mean_movement_in[k];
        /* single passes beyond the first have another step */
        assert_near(sim[2].mean_movement_in[k], 0.5 * (a + b), 1e-2);
        assert_near(sim[2].movement_spread_in[k], fabs(a - b) / sqrt(2.0), 1.5e-2);
        differ = differ || fabs(a - b) > 0.05;
    }
    assert_true(differ && sim[0].movement_spread_in[100] == 0.0 && sim[2].seed_count == 2);
    for (int i = 0; i < 3; i++)
        compare_simulated_free(&sim[i]);
    measured_free(&m);
    session_end(&s);
}

/* Pooled over eight transducers by samples. */
TEST(a_series_of_one)
{
    struct session s;
    struct measured_landing m;
    struct zones_slack zones;
    struct compare_model model;
    struct compare_series set;
    double n = 0.0, rms = 0.0;
    load_one(&s, &m, &zones);
    compare_model_load(&model, "host/scenes/model_runway.json", 0, &s.error);
    compare_series_run(s.store, NULL, &model, NULL, NULL, &set, &s.error);
    assert_no_error(&s.error);
    assert_int_equal(set.compared_count, 1);
    for (size_t c = 0; c < 8; c++) {
        const struct signal_figures *f = &set.landing[0].figures.channel[c].figures;
        n += (double)f->compared_sample_count;
        rms += (double)f->compared_sample_count * f->rms * f->rms;
    }
    assert_near(set.pooled.rms_in, sqrt(rms / n), 1e-9);
    compare_series_free(&set);
    compare_model_free(&model);
    measured_free(&m);
    session_end(&s);
}

static struct compare_limits limits_of(const char *text, struct error *error)
{
    struct compare_limits limits = {NULL};
    char path[200];
    FILE *file = fopen(scratch_path(path, sizeof path, "limits.json"), "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    compare_limits_load(&limits, path, error);
    return limits;
}

static struct compare_figures two_channels(void)
{
    struct compare_figures f = {.run = 7, .channel_count = 2};
    for (int c = 0; c < 2; c++)
        f.channel[c] = (struct compare_channel){
            .number = c + 1,
            .is_compared = true,
            .figures = {.rms = 0.02 * (c + 1), .bias = -0.03, .rms_per_error = (double)NAN}};
    f.zones.count = 1;
    f.zones.moment[0] = (struct compare_zone_moment){
        .description = "at rest",
        .simulated_overlap = {true, 20.0, 50.0, 0.4, (double)NAN, (double)NAN},
        .board_overlap = {.is_known = false}};
    return f;
}

static struct compare_verdict verdict_of(const char *text, const struct compare_figures *figures)
{
    struct error error = {0};
    struct compare_verdict verdict = {0};
    struct compare_limits limits = limits_of(text, &error);
    assert_no_error(&error);
    compare_check(figures, &limits, &verdict);
    compare_limits_free(&limits);
    return verdict;
}

TEST(limits_decide)
{
    struct compare_figures f = two_channels();
    struct compare_verdict v;
    v = verdict_of("{\"channels.*.rms_in\": 0.05, \"channels.*.bias_in\": 0.04}", &f);
    assert_true(v.failed_limit_count == 0 &&
                v.checked_limit_count == 5); /* two of each, and that none is missing */
    v = verdict_of("{\"channels.*.rms_in\": 0.03}", &f);
    assert_true(v.failed_limit_count == 1);
    assert_string_equal(
        v.worst_failure,
        "channels.2.rms_in of RUN 7 is 0.0400; the limit 0.0300 is exceeded by 0.0100");
    /* 0.05 in */
    v = verdict_of("{\"channels.*.rms_in\": 0.03, \"channels.2.rms_in\": \"1.27 mm\"}", &f);
    assert_true(v.failed_limit_count == 0 && v.checked_limit_count == 3);
    v = verdict_of("{\"channels.*.rms_mm\": 1}", &f);
    assert_true(v.failed_limit_count == 1 && v.checked_limit_count == 3);
    v = verdict_of("{\"channels.*.bias_in\": 0.02}", &f); /* its size counts */
    assert_true(v.failed_limit_count == 2);
    /* what is not known does not pass */
    v = verdict_of("{\"channels.*.chi\": 0.1}", &f);
    assert_true(v.failed_limit_count == 2 && strstr(v.worst_failure, "chi of RUN 7 is not known"));
    v = verdict_of("{\"channels.5.rms_in\": 1}", &f);
    assert_true(v.failed_limit_count == 1 &&
                strstr(v.worst_failure, "the result has no value channels.5.rms_in: RUN 7"));
    v = verdict_of("{\"channels.*.rsm_in\": 1}", &f);
    assert_true(v.failed_limit_count == 1 &&
                strstr(v.worst_failure, "the result has no value channels.*.rsm_in"));
    /* ends that are not there are the overlap's */
    v = verdict_of("{\"zones.*.overlap_simulated.share\": 0.5, "
                   "\"zones.*.overlap_simulated.start_difference_ft\": 3}",
                   &f);
    assert_true(v.failed_limit_count == 1 && v.checked_limit_count == 1);
    assert_string_equal(v.worst_failure,
                        "zones.1.overlap_simulated.share of RUN 7 is 0.4000; the limit "
                        "0.5000 is missed by 0.1000");
    v = verdict_of("{\"zones.*.overlap_board.share\": 0.5}", &f);
    assert_true(v.failed_limit_count == 1 && strstr(v.worst_failure, "not known"));
    f.channel[0].is_compared = false;
    snprintf(f.channel[0].reason_or_remark, sizeof f.channel[0].reason_or_remark, "open");
    v = verdict_of("{\"channels.*.rms_in\": 1}", &f);
    assert_true(v.failed_limit_count == 1);
    assert_string_equal(
        v.worst_failure,
        "missing_channels of RUN 7 is 1.0000; the limit 0.0000 is exceeded by 1.0000");
    v = verdict_of("{\"channels.*.rms_in\": 1, \"missing_channels\": 1}", &f);
    assert_true(v.failed_limit_count == 0);
}

TEST(limits_that_are_wrong)
{
    static const struct {
        const char *text, *says;
    } wrong[] = {
        {"{\"channels.*.rms_in\": \"x\"}", "not a number: "},
        {"{\"channels.*.rms_in\": \"3 lb\"}", "a force instead of a length: "},
        {"{\"channels.*.rms_in\": -1}", "not a limit: "},
        {"{\"channels\": {\"all\": {\"rms_in\": 1}}}", "not a limit: "}, /* as it was once */
        {"{\"_\": 1}", "give at least one"},
        {"{\n \"missing_channels\": 1,}", "not valid JSON: "},
        {"{\"missing_channels\": 1, \"missing_channels\": 2}", "not valid JSON: "},
    };
    for (size_t i = 0; i < COUNT_OF(wrong); i++) {
        struct error error = {0};
        struct compare_limits limits = limits_of(wrong[i].text, &error);
        compare_limits_free(&limits);
        assert_error(&error, MR_MALFORMED, wrong[i].says);
    }
}

/* Two transducers that agree in all six values. */
static struct compare_figures agreeing(void)
{
    struct compare_figures figures = {.run = 7, .model_file = "x.json", .channel_count = 2};
    for (size_t i = 0; i < 2; i++) {
        struct compare_channel *c = &figures.channel[i];
        c->number = (int64_t)(3 + i);
        c->station_ft = 60.0 + 10.0 * (double)i;
        c->is_compared = true;
        c->figures.peak_measured.value = 0.8;
        c->figures.peak_simulated.value = 0.804;
        c->figures.arrival_measured.t_s = 1.5;
        c->figures.arrival_simulated.t_s = 1.509;
        c->peak_en_score = 0.4;
        c->arrival_en_score = 0.9;
    }
    return figures;
}

static void assert_sentence(const struct compare_figures *figures, bool si, const char *expected)
{
    struct compare_agreement agreement;
    char sentence[COMPARE_AGREEMENT_SIZE];
    compare_compute_agreement(figures, &agreement);
    compare_write_agreement(&agreement, si, sentence);
    assert_string_equal(sentence, expected);
}

TEST(a_sentence_has_the_largest_difference)
{
    struct compare_figures figures = agreeing();
    assert_sentence(&figures, false,
                    "RUN 7 agrees with x.json: 0 of 6 peaks, ends and arrivals differ by more "
                    "than twice their errors; largest: the arrival at transducer 3, 60.0 ft, "
                    "measured 1.5000 s, simulated 1.5090 s, En 0.9");
    figures.channel[1].figures.peak_simulated.value = 0.85;
    figures.channel[1].peak_en_score = 5.0;
    figures.channel[0].end_en_score = 1.01;
    figures.channel[0].arrival_en_score = (double)NAN;
    assert_sentence(&figures, true,
                    "RUN 7 differs from x.json: 2 of 5 peaks, ends and arrivals differ by more "
                    "than twice their errors; largest: the peak at transducer 4, 21.3 m, measured "
                    "20.320 mm, simulated 21.590 mm, En 5");
    figures.channel[0].is_compared = figures.channel[1].is_compared = false;
    assert_sentence(&figures, false,
                    "RUN 7 has no peak, end or arrival that can be compared with x.json");
}
