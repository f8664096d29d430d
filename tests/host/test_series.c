/* Campaigns: uneven ground, the path of a landing, what carries over, and that neither threads nor
 * what is left out change an answer. */
#include "tests/cmocka_all.h"

#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/statistics.h"
#include "host/landing_series/ensemble.h"
#include "host/sim/sim.h"
#include "tests/scoreboard/facts.h"

#define RIG                                                                                      \
    "\"N\":%d,\"L\":0.2857142857142857,\"W\":0.466,\"I\":1.19e-4,\"KV\":1.3e4,\"CV\":60,\"KT\":" \
    "41.6,\"CT\":1.57e-4,"                                                                       \
    "\"TAD_deg\":7,\"profile\":\"full\",\"KL\":2.9e5,\"CL\":5,\"slack\":0.0025,\"left\":"        \
    "\"fixed\",\"right\":\"fixed\","                                                             \
    "\"f\":0.5,\"friction\":\"stick\",\"v0\":0,\"thrust\":\"jump\""

static struct error error;
static struct facts facts;

static const char *file_of(const char *text)
{
    static char path[64];
    snprintf(path, sizeof path, "build/test-campaign-%d.json", (int)getpid());
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
    return path;
}

static struct landing_series load(int mats, const char *rest)
{
    char text[2000];
    struct landing_series series;
    int scene = snprintf(text, sizeof text, "{\"scene\":{" RIG "},", mats);
    snprintf(text + scene, sizeof text - (size_t)scene, "%s}", rest);
    error = (struct error){0};
    const char *path = file_of(text);
    enum mr_status status = series_load(&series, path, &error);
    remove(path);
    if (status != MR_OK)
        fail_msg("%s", error.text);
    return series;
}

/* Largest rise of nine mats pressed together by a slowly growing thrust, when their middle joint
 * lies on a high spot. */
static double rise_in(double spot_ft, double thrust_lb)
{
    struct sim_scene scene;
    struct sim_result result;
    double ground[10] = {0.0}, closed = 0.0;
    const struct sim_path_row rows[] = {
        {0.0, 0.1, 0.0}, {0.5, 0.1, thrust_lb}, {0.55, 0.1, thrust_lb}};
    const struct sim_options options = {.is_single_pass = true};
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CONSISTENT;
    scene.mats = 9;
    scene.length_ft = 2.0 / 7.0;
    scene.weight_lb = 0.466;
    scene.inertia_slug_ft2 = 1.19e-4;
    scene.kv_lb_ft = 1.3e4;
    scene.cv_lb_s_ft = 60.0;
    scene.kt_lb_ft_rad = 0.0;
    scene.ct_lb_ft_s_rad = 0.0;
    scene.kl_lb_ft = 2.9e6;
    scene.cl_lb_s_ft = 20.0;
    scene.profile = SIM_PROFILE_FULL;
    scene.friction_law = SIM_FRICTION_NONE;
    scene.v0_ft_s = 0.0;
    ground[5] = spot_ft;
    error = (struct error){0};
    sim_scene_set_list(&scene.gap0_ft, &closed, 1);
    sim_scene_set_list(&scene.ground_ft, ground, 10);
    sim_scene_set_path(&scene, rows, 3);
    /* one that rises ends by folding */
    if (sim_run(&scene, &options, &result, &error) != MR_OK && !result.max_rise_ft)
        fail_msg("%s", error.text);
    double rise = result.max_rise_ft[6] * 12.0;
    sim_result_free(&result);
    sim_scene_free(&scene);
    return rise;
}

/* Two mats that lean against each other at height h under a compression P are lifted when 2 P h/L
 * exceeds a mat's weight: statics of the joint between them. */
TEST(test_a_vee_rises_above_its_static_load)
{
    for (double spot_in = 0.02; spot_in < 0.1; spot_in *= 2.0) {
        double critical_lb = 0.466 * (2.0 / 7.0) / (2.0 * spot_in / 12.0);
        assert_true(rise_in(spot_in / 12.0, 0.93 * critical_lb) < 0.002);
        assert_true(rise_in(spot_in / 12.0, 1.07 * critical_lb) > 0.5);
    }
    /* a hollow holds down */
    assert_true(rise_in(-0.05 / 12.0, 60.0) < 0.1 * rise_in(0.05 / 12.0, 60.0));
}

/* A landing of constant braking: the onset's smooth step loses what a delay of half of it would. */
TEST(test_the_path_is_uniform_braking)
{
    struct landing_series series = load(420,
                                        "\"landings\":[{\"deceleration_ft_s2\":4.6,\"times\":2},"
                                        "{\"speed_ft_s\":30,\"profile\":[[3,5],[53,5.001]]},"
                                        "{\"touchdown_ft\":2,\"speed_ft_s\":4,\"tow_lb\":26}]");
    struct draw_path path = {0};
    assert_int_equal(draw_landing_path(&series, &series.landings[0], 1, 0, &path, &error), MR_OK);
    assert_near(path.stop_ft, 3.0 + 28.0 * 0.025 + 28.0 * 28.0 / 9.2, 0.02);
    assert_near(path.rows[100].force_lb, 1300.0 / 12.0 * 4.6 / 32.174, 1e-9);
    assert_near(path.rows[path.count - 1].t_s, 0.025 + 28.0 / 4.6, 2e-3);
    assert_true(path.rows[path.count - 1].force_lb == 0.0);
    assert_int_equal(draw_landing_path(&series, &series.landings[2], 1, 2, &path, &error), MR_OK);
    assert_near(path.stop_ft, 3.0 + 30.0 * 0.025 + 30.0 * 30.0 / 10.0, 0.05);
    assert_int_equal(draw_landing_path(&series, &series.landings[3], 1, 3, &path, &error), MR_OK);
    assert_near(path.stop_ft, 120.0, 0.01); /* towed at 4 ft/s: 29.5 s to the end */
    assert_near(path.rows[path.count - 1].t_s, 29.5, 2e-3);
    assert_near(path.rows[1000].x_ft, 2.0 + 4.0 * path.rows[1000].t_s, 1e-9);
    assert_near(path.rows[1000].force_lb, 26.0, 1e-12);
    draw_path_free(&path);
    series_free(&series);
}

/* Two landings by hand: the second begins with the gaps that the first has left. */
TEST(test_gaps_carry_over)
{
    struct landing_series series = load(
        120,
        "\"engine\":{\"use\":\"chain\"},\"stations_ft\":[1,10,20,30],\"runway\":{\"gap_in\":0.02,"
        "\"closing_lb\":2},\"landings\":[{\"speed_ft_s\":15,\"deceleration_ft_s2\":5,\"times\":2}"
        "]");
    struct series_run run;
    struct draw_path path = {0};
    double gap[121], closing = 2.0;
    series_simulate(&series, 1, &run);
    assert_int_equal(run.error.status, MR_OK);
    assert_int_equal(run.simulated_landing_count, 2);
    assert_int_equal(draw_landing_path(&series, &series.landings[0], 1, 0, &path, &error), MR_OK);
    for (int j = 0; j <= 120; j++)
        gap[j] = 0.02 / 12.0;
    for (int landing = 0; landing < 2; landing++) {
        struct sim_scene scene = series.landings[0].scene;
        const struct sim_options options = {.is_single_pass = true};
        struct sim_result result;
        scene.model = SIM_MODEL_CHAIN;
        scene.t_dwell_s = 0.3;
        sim_scene_set_list(&scene.gap0_ft, gap, 121);
        sim_scene_set_list(&scene.grit_lb, &closing, 1);
        sim_scene_set_path(&scene, path.rows, path.count);
        assert_int_equal(sim_run(&scene, &options, &result, &error), MR_OK);
        for (int s = 0; s < 4; s++)
            assert_near(run.outcomes[landing].movement_in[s],
                        12.0 * result.u_ft[(int)(series.stations_ft[s] / scene.length_ft) + 1],
                        1e-9);
        assert_true(landing > 0 || run.outcomes[landing].peak_movement_in > 0.05);
        for (int j = 0; j <= 120; j++)
            gap[j] += (j < 120 ? result.u_ft[j + 1] : 0.0) - (j > 0 ? result.u_ft[j] : 0.0);
        sim_result_free(&result);
        free(scene.gap0_ft.values);
        free(scene.grit_lb.values);
        free(scene.path);
    }
    /* it does matter */
    assert_true(run.outcomes[1].movement_in[1] < 0.9 * run.outcomes[0].movement_in[1]);
    draw_path_free(&path);
    series_run_free(&run);
    series_free(&series);
}

static void play_all(struct landing_series *series, unsigned jobs, struct series_run *runs)
{
    error = (struct error){0};
    series_simulate_all(series, jobs, NULL, NULL, runs);
    for (size_t i = 0; i < series->seed_count; i++) {
        if (runs[i].error.status != MR_OK)
            fail_msg("%s", runs[i].error.text);
    }
}

/* To the last bit before a wave. */
static void compare(const struct landing_series *series, struct series_run *a, struct series_run *b)
{
    for (size_t i = 0; i < series->seed_count; i++) {
        assert_int_equal(a[i].buckled_landing, b[i].buckled_landing);
        for (size_t k = 0; k < a[i].simulated_landing_count && a[i].outcomes[k].wave_count == 0;
             k++) {
            if (a[i].buckled_landing == (int)k + 1 || b[i].outcomes[k].wave_count > 0)
                break;
            assert_memory_equal(a[i].outcomes[k].movement_in, b[i].outcomes[k].movement_in,
                                series->station_count * sizeof(double));
        }
    }
}

TEST(test_neither_jobs_nor_skipping_change_an_answer)
{
    struct landing_series series =
        load(140, "\"seeds\":[5,7],\"landings\":[{\"speed_ft_s\":14,\"deceleration_ft_s2\":4.3},"
                  "{\"speed_ft_s\":24,\"deceleration_ft_s2\":[7.3,8]}]");
    struct series_run one[3], three[3], whole[3];
    size_t skipped = 0, buckled = 0;
    play_all(&series, 1, one);
    play_all(&series, 3, three);
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(one[i].seed, 5 + i);
        assert_int_equal(one[i].buckled_landing, three[i].buckled_landing);
        assert_memory_equal(one[i].outcomes, three[i].outcomes, 2 * sizeof *one[i].outcomes);
        skipped += !one[i].outcomes[0].has_planar_run;
        buckled += one[i].buckled_landing > 0;
    }
    series.planar_min_lift_share = -1.0;
    play_all(&series, 2, whole);
    compare(&series, one, whole);
    for (size_t i = 0; i < 3; i++) {
        if (!one[i].outcomes[0].has_planar_run)
            assert_true(whole[i].outcomes[0].has_planar_run &&
                        whole[i].outcomes[0].wave_rise_in < 0.001);
        series_run_free(&one[i]);
        series_run_free(&three[i]);
        series_run_free(&whole[i]);
    }
    assert_true(skipped > 0 && buckled > 0);
    series_free(&series);
}

TEST(test_spreads)
{
    double values[] = {5, 1, 4, 2, 3}, one = 7.0;
    struct series_spread s = series_compute_spread(values, 5);
    assert_near(s.median, 3.0, 0.0);
    assert_near(s.low, 1.2, 1e-12);
    assert_near(s.high, 4.8, 1e-12);
    assert_near(series_compute_spread(&one, 1).high, 7.0, 0.0);
    assert_true(isnan(series_compute_spread(&one, 0).median));
}

/* By hand: six runways, of which two were played twice, -3 and 4 lb apart: root mean square 3.5355
 * lb, 4.3027/1.96 for 2 degrees of freedom, spread 3.7417 lb; mean of the pairs 0.5 lb,
 * of 0.37 of the step. */
TEST(test_errors_of_peaks)
{
    struct landing_series series = load(60,
                                        "\"seeds\":6,\"landings\":[{\"deceleration_ft_s2\":4}]");
    struct series_outcome outcomes[6] = {{0}}, other[6] = {{0}};
    struct series_run runs[6];
    struct series_summary summary;
    const double again_lb[6] = {0.0, 15.0, 0.0, 0.0, 14.0, 0.0};
    for (int i = 0; i < 6; i++) {
        outcomes[i].compression_lb = 10.0 + 2.0 * i;
        other[i].compression_lb = again_lb[i];
        runs[i] = (struct series_run){
            .simulated_landing_count = 1, .outcomes = &outcomes[i], .check_outcomes = &other[i]};
        runs[i].check_landing_count = again_lb[i] > 0.0;
    }
    series_compute_errors(&series, runs);
    for (int i = 0; i < 6; i++)
        assert_near(outcomes[i].compression_error_lb, 9.44871, 1e-3);
    series_summarise(&summary, &series, runs);
    assert_near(summary.landing[0].compression_lb.mean, 15.0, 1e-12);
    assert_near(summary.landing[0].compression_lb.run_error, 9.44871, 1e-3);
    assert_near(summary.landing[0].compression_lb.mean_error, 4.08730, 1e-3);
    series_summary_free(&summary);
    /* the other engine's runways, the pair of 3 lb among them, are no pairs, but borrow: a pair of
     * 4 lb at a mean of 16 lb is a quarter of it */
    outcomes[1].is_planar = outcomes[2].is_planar = true;
    series_compute_errors(&series, runs);
    assert_near(outcomes[1].compression_error_lb, 21.765, 1e-2);
    assert_near(outcomes[4].compression_error_lb, 28.009, 1e-2);
    runs[4].check_landing_count = 0;
    series_compute_errors(&series, runs);
    assert_true(isnan(outcomes[1].compression_error_lb) && isnan(outcomes[4].compression_error_lb));
    series_free(&series);
}

/* Beyond its error by the finest steps: at most one in twenty twice, none four times. */
TEST(test_peaks_are_as_wrong_as_they_say)
{
    struct landing_series series =
        load(100, "\"seeds\":30,\"engine\":{\"use\":\"chain\"},\"landings\":[{\"speed_ft_s\":16,"
                  "\"deceleration_ft_s2\":4,\"times\":3}]");
    struct series_run stated[30], fine[30];
    int twice = 0, all = 0;
    play_all(&series, 2, stated);
    series.chain_dt_s = 1e-5;
    play_all(&series, 2, fine);
    for (int i = 0; i < 30; i++) {
        assert_int_equal(stated[i].check_landing_count, i % 6 == 5 ? 3 : 0);
        for (int k = 0; k < 3; k++, all += 2) {
            const struct series_outcome *a = &stated[i].outcomes[k], *b = &fine[i].outcomes[k];
            double push = fabs(a->compression_lb - b->compression_lb) / a->compression_error_lb,
                   pull = fabs(a->tension_lb - b->tension_lb) / a->tension_error_lb;
            assert_true(push < 4.0 && pull < 4.0);
            assert_true(a->compression_error_lb < 0.5 * a->compression_lb);
            twice += (push > 2.0) + (pull > 2.0);
        }
    }
    assert_true(20 * twice <= all);
    for (int i = 0; i < 30; i++) {
        series_run_free(&stated[i]);
        series_run_free(&fine[i]);
    }
    series_free(&series);
}

/* A band is put on before landing 2 and off before landing 3; what is not touched stays. */
TEST(test_modifications_are_laid_over_the_scene)
{
    struct landing_series series = load(
        60,
        "\"landings\":[{\"deceleration_ft_s2\":4},{\"deceleration_ft_s2\":4,\"times\":2,"
        "\"apply\":{\"f\":0.85,\"TAD_deg\":1}},{\"deceleration_ft_s2\":4,\"apply\":{\"f\":0.5}}]");
    assert_int_equal(series.landing_count, 4);
    const double f[] = {0.5, 0.85, 0.85, 0.5}, tad[] = {7, 1, 1, 1};
    const bool modified[] = {false, true, false, true};
    for (int i = 0; i < 4; i++) {
        assert_near(series.landings[i].scene.friction, f[i], 0.0);
        assert_near(series.landings[i].scene.tad_deg, tad[i], 0.0);
        assert_int_equal(series.landings[i].is_modified, modified[i]);
    }
    series_free(&series);
}

/* On even ground no compression raises a joint; a wheel with weight on mats that are tied does. */
TEST(test_tied_mats_under_weight_are_asked_for)
{
    static const struct {
        const char *ground, *modification;
        bool asked;
    } cases[] = {{"elastic", "\"stiff_span\":7,\"stiff_KT\":84", true},
                 {"elastic", "\"stiff_span\":7,\"stiff_K\":1e6", false},
                 {"elastic", "\"f\":0.85", false},
                 {"weightless", "\"stiff_span\":7,\"stiff_KT\":84", false}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        char rest[600];
        struct series_run run;
        snprintf(rest, sizeof rest,
                 "\"ground\":\"%s\",\"elastic\":{\"wheel_load\":108.3,\"gear_k_lb_ft\":7000},"
                 "\"runway\":{\"irregularity_in\":0},\"landings\":[{\"speed_ft_s\":6,"
                 "\"deceleration_ft_s2\":4,\"apply\":{%s}}]",
                 cases[i].ground, cases[i].modification);
        struct landing_series series = load(60, rest);
        series_simulate(&series, 1, &run);
        assert_int_equal(run.error.status, MR_OK);
        assert_int_equal(run.outcomes[0].has_planar_run, cases[i].asked);
        series_run_free(&run);
        series_free(&series);
    }
}

TEST(test_files_that_are_refused)
{
    static const struct {
        const char *text, *says;
    } cases[] = {
        {"{\"scene\":{\"N\":9},\"landings\":[]}", "landings"},
        {"{\"scene\":{\"N\":9}}", "landings"},
        {"{\"landings\":[{\"deceleration_ft_s2\":4}]}", "scene"},
        {"{\"scene\":{\"N\":9,\"path\":[]},\"landings\":[{\"deceleration_ft_s2\":4}]}",
         "scene.path"},
        {"{\"scene\":{\"N\":9,\"nonsense\":1},\"landings\":[{\"deceleration_ft_s2\":4}]}",
         "nonsense"},
        {"{\"scene\":{\"N\":9},\"landings\":[{\"deceleration_ft_s2\":-4}]}",
         "landings.0..deceleration_ft_s2"},
        {"{\"scene\":{\"N\":9},\"landings\":[{\"deceleration_ft_s2\":[5,4]}]}",
         "landings.0..deceleration_ft_s2"},
        {"{\"scene\":{\"N\":9},\"landings\":[{}]}", "profile"},
        {"{\"scene\":{\"N\":9,\"L\":2},\"landings\":[{\"deceleration_ft_s2\":4,\"touchdown_ft\":[4,"
         "18]}]}",
         "landings.0..touchdown_ft.18 ft"},
        {"{\"scene\":{\"N\":1,\"L\":2},\"landings\":[{\"deceleration_ft_s2\":4}]}",
         "landings.0..touchdown_ft.2 ft"},
        {"{\"scene\":{\"N\":9},\"landings\":[{\"deceleration_ft_s2\":4},{\"deceleration_ft_s2\":4,"
         "\"apply\":{\"N\":10}}]}",
         "runways differ"},
        {"{\"scene\":{\"N\":9},\"landings\":[{\"deceleration_ft_s2\":4,\"apply\":[\"bands\"]}]}",
         "apply"},
        {"{\"scene\":{\"N\":9},\"runway\":{\"gap_in\":[1,0]},\"landings\":[{\"deceleration_ft_s2\":"
         "4}]}",
         "runway.gap_in"},
        {"{\"scene\":{\"N\":9},\"seeds\":0,\"landings\":[{\"deceleration_ft_s2\":4}]}", "seeds"},
        {"{\"scene\":{\"N\":9},\"landing\":[]}", "unknown key"},
        {"{\"scene\":{\"N\":9},\"press_flat\":1,\"landings\":[{\"deceleration_ft_s2\":4}]}",
         "press_flat; give true or false"},
        {"{\"scene\":{\"N\":9},\"landings\":[{\"deceleration_ft_s2\":4,\"times\":500}]}", "times"},
        {"{\"scene\":{\"N\":9},", "line 1"},
        {"[]", "object"},
    };
    struct landing_series series;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        error = (struct error){0};
        const char *path = file_of(cases[i].text);
        assert_int_not_equal(series_load(&series, path, &error), MR_OK);
        remove(path);
        char *dots = strdup(cases[i].says), *found = error.text;
        assert_non_null(dots);
        for (char *part = strtok(dots, "."); part && found; part = strtok(NULL, "."))
            found = strstr(found, part);
        if (!found)
            fail_msg("case %zu: \"%s\" does not say %s", i, error.text, cases[i].says);
        free(dots);
    }
    error = (struct error){0};
    assert_int_equal(series_load(&series, "build/no-such-campaign.json", &error), MR_IO);
}

/* The report's rig: the first landing moves the mats by 1/4 to 1/2 in and reaches 12 to 16 ft
 * ahead. */
TEST(test_the_standard_series_moves_as_observed)
{
    struct landing_series series;
    struct series_run run;
    error = (struct error){0};
    assert_int_equal(series_load(&series, "host/landing_series/series/standard.json", &error),
                     MR_OK);
    series.engine = SERIES_ENGINE_CHAIN;
    series_simulate(&series, 1, &run);
    assert_int_equal(run.simulated_landing_count, 5);
    for (int i = 0; i < 4; i++)
        assert_true(run.outcomes[i].peak_movement_in > 0.25 &&
                    run.outcomes[i].peak_movement_in < 0.6 &&
                    run.outcomes[i].moved_length_beyond_stop_ft > 9.0 &&
                    run.outcomes[i].moved_length_beyond_stop_ft < 18.0);
    assert_true(run.outcomes[4].zone_mats > 50);
    series_run_free(&run);
    series_free(&series);
}

/* A wheel that rides a wave until it stops has met one wave, however far it is carried. */
TEST(test_a_wave_that_is_ridden_is_met_once)
{
    struct landing_series series;
    struct series_run run;
    error = (struct error){0};
    assert_int_equal(series_load(&series, "host/landing_series/series/standard.json", &error),
                     MR_OK);
    series_simulate(&series, 2, &run);
    assert_int_equal(run.buckled_landing, 5);
    const struct series_outcome *o = &run.outcomes[4];
    assert_int_equal(o->wave_encounter_count, 1);
    assert_int_equal(o->failure_count, 1);
    assert_true(o->failure_station_ft[0] == o->wave_encounter_station_ft[0] &&
                run.buckle_station_ft == o->wave_encounter_station_ft[0]);
    assert_true(o->stop_ft - o->wave_encounter_station_ft[0] > 5.0); /* that it is carried for */
    series_run_free(&run);
    series_free(&series);
}

/* "(4.2" or ", 4.2)": sections IV to VI of the report. */
static void quotes_its_section(const struct landing_series *series, const char *says)
{
    const char *section = strpbrk(says, "(");
    while (section && !(section[1] >= '4' && section[1] <= '6' && section[2] == '.'))
        section = strpbrk(section + 1, "(");
    if (!section)
        fail_msg("%s: no section: %s", series->name, says);
}

/* What elastic ground adds comes from the series' own object or a file beside it. */
TEST(test_ground_is_chosen)
{
    static const char *const own =
        "{\"scene\":{\"N\":60,\"slack\":0.0025,\"W\":1},\"ground\":\"elastic\",%s"
        "\"landings\":[{\"deceleration_ft_s2\":5}]}";
    char text[500], ground[200];
    struct landing_series series;
    snprintf(text, sizeof text, own,
             "\"elastic\":{\"W\":2,\"wheel_load\":100,\"gear_k_lb_ft\":5000},");
    json_t *root = json_loads(text, 0, NULL);
    error = (struct error){0};
    assert_int_equal(series_from_json(&series, "test", root, &error), MR_OK);
    assert_true(series.landings[0].scene.weight_lb == 2.0);
    series_describe_ground(&series, ground, sizeof ground);
    assert_string_equal(ground,
                        "elastic ground under a gear with weight: 5000 lb/ft per mat and axle, "
                        "100 lb per axle, 1 axles in 1 line");
    series_free(&series);
    json_object_set_new(root, "ground", json_string("weightless"));
    assert_int_equal(series_from_json(&series, "test", root, &error), MR_OK);
    assert_true(series.landings[0].scene.weight_lb == 1.0);
    series_free(&series);
    json_decref(root);
    static const struct {
        const char *with, *says;
    } wrong[] = {{"", "elastic ground without a stiffness"},
                 {"\"elastic\":5,", "an object of scene keys"},
                 {"\"elastic\":{\"gear_k\":5},", "gear_k"},
                 {"\"elastic\":\"none.json\",", "none.json"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        snprintf(text, sizeof text, own, wrong[i].with);
        root = json_loads(text, 0, NULL);
        error = (struct error){0};
        assert_int_not_equal(series_from_json(&series, "test", root, &error), MR_OK);
        if (!strstr(error.text, wrong[i].says))
            fail_msg("%s: %s", wrong[i].with, error.text);
        json_decref(root);
    }
}

/* Newcombe, Statistics in Medicine 17 (1998) 857, table I, method 3. */
TEST(test_wilson)
{
    static const struct {
        size_t count, of;
        double low, high;
    } cases[] = {{81, 263, 0.2553, 0.3662},
                 {15, 148, 0.0624, 0.1605},
                 {0, 20, 0.0, 0.1611},
                 {1, 29, 0.0061, 0.1718}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct proportion_interval w = compute_proportion_interval(cases[i].count, cases[i].of);
        assert_true(fabs(w.low - cases[i].low) < 6e-5 && fabs(w.high - cases[i].high) < 6e-5);
    }
}

/* Of three runways two buckle in landing 2 and one never, of four landings: shares by hand. */
TEST(test_log_score)
{
    struct series_run runs[3] = {
        {.buckled_landing = 2}, {.buckled_landing = 2}, {.buckled_landing = 0}};
    struct landing_series series = {.seed_count = 3, .landing_count = 4};
    static const struct {
        int seen;
        double share;
    } cases[] = {{2, 2.2 / 4.0}, {1, 0.2 / 4.0}, {-1, 1.2 / 4.0}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        facts.observed_landing = cases[i].seen;
        double bits = series_log_score_bits(&series, &facts, runs);
        assert_true(fabs(pow(2.0, -bits) - cases[i].share) < 1e-12);
    }
    facts.observed_landing = 0;
    assert_true(isnan(series_log_score_bits(&series, &facts, runs)));
}

TEST(test_every_series_can_be_read)
{
    glob_t files;
    size_t count = 0;
    assert_int_equal(glob("host/landing_series/series/*.json", 0, NULL, &files), 0);
    for (size_t i = 0; i < files.gl_pathc; i++) {
        struct landing_series series;
        char ground[200];
        if (strstr(files.gl_pathv[i], "rig.json") || strstr(files.gl_pathv[i], "prototype.json") ||
            strstr(files.gl_pathv[i], "_ground.json"))
            continue;
        for (int elastic = 0; elastic < 2; elastic++) {
            error = (struct error){0};
            if (series_load_on_ground(&series, files.gl_pathv[i], elastic ? "elastic" : NULL,
                                      &error) != MR_OK)
                fail_msg("%s", error.text);
            series_describe_ground(&series, ground, sizeof ground);
            assert_non_null(
                strstr(ground, elastic ? "elastic ground under a gear" : "weightless gear"));
            assert_true(series.seed_count >= 16 && series.observed[0] != 0);
            assert_true(series.basis[0] != 0);
            json_t *root = json_load_file(files.gl_pathv[i], 0, NULL);
            assert_int_equal(facts_read(files.gl_pathv[i], root, &series, &facts, &error), MR_OK);
            json_decref(root);
            for (size_t k = 0; k < facts.count; k++)
                quotes_its_section(&series, facts.fact[k].says);
            series_free(&series);
        }
        count++;
    }
    assert_int_equal(count, 15);
    globfree(&files);
}

static struct landing_series series(const char *path)
{
    struct landing_series series;
    error = (struct error){0};
    if (series_load(&series, path, &error) != MR_OK)
        fail_msg("%s", error.text);
    return series;
}

/* Every key of `scene` is `from`'s times the factor beside it. */
static void is_scaled(const struct sim_scene *scene, const struct sim_scene *from,
                      const double *factors)
{
    const double now[] = {scene->length_ft,    scene->weight_lb,      scene->inertia_slug_ft2,
                          scene->kl_lb_ft,     scene->cl_lb_s_ft,     scene->slack_ft,
                          scene->kt_lb_ft_rad, scene->ct_lb_ft_s_rad, scene->tad_deg,
                          scene->kv_lb_ft,     scene->cv_lb_s_ft,     scene->friction};
    const double then[] = {from->length_ft,    from->weight_lb,      from->inertia_slug_ft2,
                           from->kl_lb_ft,     from->cl_lb_s_ft,     from->slack_ft,
                           from->kt_lb_ft_rad, from->ct_lb_ft_s_rad, from->tad_deg,
                           from->kv_lb_ft,     from->cv_lb_s_ft,     from->friction};
    for (size_t i = 0; i < sizeof now / sizeof now[0]; i++) {
        if (fabs(now[i] / (then[i] * factors[i]) - 1.0) > 1e-5)
            fail_msg("key %zu: %.9g, not %.9g", i, now[i], then[i] * factors[i]);
    }
}

/* Dyess is the rig by the report's table 2.2 with n = 7; the diagonal pattern
 * the rig with joints across at 45 degrees: lengths along the runway over cos
 * 45, and with them the weight and the soil under a mat; forces of a joint and
 * turns about it times cos 45. */
TEST(test_scenes_are_the_rig_scaled)
{
    struct landing_series rig = series("host/landing_series/series/standard.json"),
                          dyess = series("host/landing_series/series/dyess.json");
    struct landing_series diagonal = series("host/landing_series/series/diagonal.json");
    const double n = 7.0, c = sqrt(0.5);
    const double prototype[] = {n,         n * n * n,   pow(n, 5), n * n, pow(n, 2.5), n,
                                pow(n, 4), pow(n, 4.5), 1.0,       n * n, pow(n, 2.5), 1.0};
    const double across[] = {1 / c,      1 / c,      pow(c, -3), c,     c,     1 / c,
                             pow(c, -3), pow(c, -3), c,          1 / c, 1 / c, 1.0};
    is_scaled(&dyess.landings[0].scene, &rig.landings[0].scene, prototype);
    is_scaled(&diagonal.landings[0].scene, &rig.landings[0].scene, across);
    assert_true(fabs(dyess.gap_in.high - n * rig.gap_in.high) < 1e-9);
    assert_true(fabs(dyess.closing_lb.high - n * n * n * rig.closing_lb.high) < 1e-9);
    assert_true(fabs(diagonal.gap_in.high - rig.gap_in.high / c) < 1e-4);
    series_free(&rig);
    series_free(&dyess);
    series_free(&diagonal);
}

/* ---- series facts ---- */

#define LANDINGS "\"landings\":[{\"deceleration_ft_s2\":5,\"times\":4}],\"stations_ft\":[5,10],"
#define SCENE    "\"scene\":{\"N\":60,\"L\":0.2857142857142857,\"slack\":0.0025}"

static struct error error;

static enum mr_status read_facts(const char *list, struct landing_series *series)
{
    char text[1200];
    snprintf(text, sizeof text, "{" LANDINGS SCENE ",\"_facts\":[%s]}", list);
    json_t *root = json_loads(text, 0, NULL);
    assert_non_null(root);
    error = (struct error){0};
    if (series_from_json(series, "test", root, &error) != MR_OK)
        fail_msg("%s", error.text);
    enum mr_status status = facts_read("test", root, series, &facts, &error);
    json_decref(root);
    return status;
}

/* Two runways: one takes four landings; the other buckles in its third. */
struct case_ {
    struct series_outcome lasting[4], buckling[4];
    struct series_run runs[2];
};

static void write_down(struct case_ *c)
{
    static const double movement_in[4] = {0.25, -0.125, 0.5, 0.375};
    memset(c, 0, sizeof *c);
    for (int i = 0; i < 4; i++) {
        c->lasting[i].peak_movement_in = 1.0 + i;
        c->lasting[i].movement_in[0] = movement_in[i];
        c->lasting[i].movement_in[1] = -2.0 * movement_in[i];
        c->lasting[i].zone_mats = 10 * (i + 1);
        c->lasting[i].wave_count = i == 1 ? 3 : 0;
        c->lasting[i].slack_band_segment_count = i > 1;
        c->lasting[i].torn_joint_count = i == 3 ? 7 : 0;
        c->buckling[i] = c->lasting[i];
    }
    c->buckling[2].is_buckled = true;
    c->buckling[2].wave_count = 1;
    c->buckling[2].failure_count = 2;
    c->buckling[2].failure_station_ft[0] = 85.0;
    c->buckling[2].failure_station_ft[1] = 91.0;
    c->runs[0] =
        (struct series_run){.seed = 1, .simulated_landing_count = 4, .outcomes = c->lasting};
    c->runs[1] = (struct series_run){
        .seed = 2, .simulated_landing_count = 3, .buckled_landing = 3, .outcomes = c->buckling};
}

/* The value of a fact on both runways. */
static void values(const char *keys, double of[2])
{
    char fact[300];
    struct landing_series series;
    struct case_ c;
    write_down(&c);
    snprintf(fact, sizeof fact, "{\"says\":\"x\",\"at_least\":0,%s}", keys);
    if (read_facts(fact, &series) != MR_OK)
        fail_msg("%s", error.text);
    assert_int_equal(facts.count, 1);
    for (int i = 0; i < 2; i++)
        of[i] = facts_value(&series, &facts.fact[0], &c.runs[i]);
    series_free(&series);
}

TEST(test_quantities)
{
    static const struct {
        const char *keys;
        double lasting, buckling; /* worked by hand; NaN: none */
    } cases[] = {
        {"\"quantity\":\"moved_in\",\"landings\":[1,4],\"station_ft\":5", 1.0, (double)NAN},
        {"\"quantity\":\"moved_in\",\"landings\":[1,4]", 2.0, (double)NAN},
        {"\"quantity\":\"moved_in\",\"landings\":[1,2],\"station_ft\":6", 0.125, 0.125},
        {"\"quantity\":\"each_in\",\"landings\":[1,4],\"station_ft\":5", 0.3125, 0.1875},
        {"\"quantity\":\"each_in\",\"landings\":[2,3]", 2.5, 2.0},
        {"\"quantity\":\"each_in\",\"landings\":[3,4],\"against\":[1,2]", 3.5 / 1.5, (double)NAN},
        {"\"quantity\":\"most_in\",\"landings\":[1,3],\"station_ft\":9", 1.0, 0.5},
        {"\"quantity\":\"mean_in\",\"landings\":[1,4]", 0.46875, 0.28125},
        {"\"quantity\":\"zone_mats\",\"landings\":[1,4]", 40.0, 20.0},
        {"\"quantity\":\"zone_mats\",\"landings\":\"before buckling\"", (double)NAN, 20.0},
        {"\"quantity\":\"zone_mats\",\"landings\":\"at buckling\"", (double)NAN, 30.0},
        {"\"quantity\":\"waves\",\"landings\":[1,4]", 1.0, 1.0},
        {"\"quantity\":\"slack\",\"landings\":[1,4]", 2.0, 0.0},
        {"\"quantity\":\"torn\",\"landings\":[4,4]", 1.0, (double)NAN},
        {"\"quantity\":\"failures\",\"landings\":\"at buckling\"", (double)NAN, 2.0},
        {"\"quantity\":\"failures\",\"landings\":[1,4]", 0.0, 0.0},
        {"\"quantity\":\"apart_ft\",\"landings\":\"at buckling\"", (double)NAN, 6.0},
        {"\"quantity\":\"apart_ft\",\"landings\":[1,4]", (double)NAN, (double)NAN},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        double of[2], wanted[2] = {cases[i].lasting, cases[i].buckling};
        values(cases[i].keys, of);
        for (int k = 0; k < 2; k++) {
            if (isnan(wanted[k]) ? !isnan(of[k]) : fabs(of[k] - wanted[k]) > 1e-12)
                fail_msg("%s: runway %d has %g, should have %g", cases[i].keys, k + 1, of[k],
                         wanted[k]);
        }
    }
}

/* Nodes 0.5 ft apart; 3 in is a failure. Drawn: two waves and a low one; what the wheel met of
 * them. */
TEST(test_failures)
{
    /* by node, 1 to 12 */
    static const double rise_ft[] = {0, 9, 0.1, 0.25, 0.3, 0.26, 0.2, 0.24, 0.27, 0.4, 0.3, 0.1, 9};
    static const double met_ft[] = {4.5, 1.5}, low_ft[] = {2.5};
    double at_ft[SERIES_FAILURES_MAX];
    /* the ends are held */
    assert_int_equal(series_find_failures(rise_ft, 12, 0.5, 0.25, NULL, 0, at_ft), 2);
    assert_near(at_ft[0], 1.5, 1e-12); /* crests: nodes 4 and 9 */
    assert_near(at_ft[1], 4.0, 1e-12);
    assert_int_equal(series_find_failures(rise_ft, 12, 0.5, 0.25, met_ft, 2, at_ft), 2);
    assert_near(at_ft[0], 1.5, 1e-12);
    assert_near(at_ft[1], 4.5, 1e-12);
    /* met between them: neither's */
    assert_int_equal(series_find_failures(rise_ft, 12, 0.5, 0.25, low_ft, 1, at_ft), 2);
    assert_near(at_ft[1], 4.0, 1e-12);
    /* nothing lies between them */
    assert_int_equal(series_find_failures(rise_ft, 12, 0.5, 0.2, NULL, 0, at_ft), 1);
    assert_int_equal(series_find_failures(rise_ft, 12, 0.5, 0.5, NULL, 0, at_ft), 0);
}

TEST(test_agreement)
{
    static const char two[] =
        "{\"says\":\"a\",\"quantity\":\"zone_mats\",\"landings\":[1,4],\"at_least\":15,\"at_most\":"
        "25,\"needed\":0.5},"
        "{\"says\":\"b\",\"quantity\":\"torn\",\"landings\":[4,4],\"at_least\":1,\"needed\":1}";
    struct landing_series series;
    struct case_ c;
    write_down(&c);
    assert_int_equal(read_facts(two, &series), MR_OK);
    series.seed_count = 2;
    struct series_fact_summary fact = facts_summarise(&series, &facts.fact[0], c.runs);
    assert_int_equal(fact.agree, 1);
    assert_true(fact.enough);
    assert_int_equal(fact.value.count, 2);
    assert_near(fact.value.median, 30.0, 1e-12);
    /* the other never came to landing 4: it does not agree */
    fact = facts_summarise(&series, &facts.fact[1], c.runs);
    assert_int_equal(fact.agree, 1);
    assert_false(fact.enough);
    assert_int_equal(fact.value.count, 1);
    series_free(&series);
}

TEST(test_mistakes)
{
    static const struct {
        const char *fact, *says;
    } cases[] = {
        {"{\"says\":\"x\",\"landings\":[1,2],\"at_least\":1}", "quantity"},
        {"{\"says\":\"x\",\"quantity\":\"moved\",\"landings\":[1,2],\"at_least\":1}", "a quantity"},
        {"{\"says\":\"x\",\"quantity\":\"torn\",\"landings\":[1,5],\"at_least\":1}", "in order"},
        {"{\"says\":\"x\",\"quantity\":\"torn\",\"landings\":\"after\",\"at_least\":1}",
         "in order"},
        {"{\"says\":\"x\",\"quantity\":\"torn\",\"landings\":[1,2]}", "a range"},
        {"{\"says\":\"x\",\"quantity\":\"each_in\",\"landings\":[1,2],\"most\":90}", "most"},
    };
    struct landing_series series;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_int_equal(read_facts(cases[i].fact, &series), MR_MALFORMED);
        series_free(&series);
        if (!strstr(error.text, cases[i].says) || !strstr(error.text, "_facts[0]"))
            fail_msg("%s: '%s' does not name %s", cases[i].fact, error.text, cases[i].says);
    }
}

/* ---- flatten ---- */

#define JOINTS 8 /* seven mats */
#define RUB    1.0
#define KL     1e6

static double gap_ft[JOINTS], u_ft[JOINTS], closing_lb[JOINTS];

static void press(const double *gaps)
{
    struct runway_flattening runway = {JOINTS, gap_ft, u_ft, closing_lb, RUB, KL};
    memcpy(gap_ft, gaps, sizeof gap_ft);
    memset(u_ft, 0, sizeof u_ft);
    flatten_waves(&runway);
}

static void near(double value, double expected)
{
    if (!(fabs(value - expected) <= 1e-11))
        fail_msg("%.12g is not %.12g", value, expected);
}

/* One mat on the right, two on the left, as a joint is closed there. Then two on either side, which
 * hold 2 lb: 2e-6 ft. Of equal sides the right one goes. */
TEST(it_goes_to_the_side_that_resists_less)
{
    const double gaps[JOINTS] = {0.1, 0.1, 0.01, 0, -0.0150, 0.01, 0.1, 0.1};
    press(gaps);
    near(gap_ft[5], 0.0);
    near(gap_ft[4], -2.0 * RUB / KL);
    near(gap_ft[6], 0.1 - (0.005 - 2e-6));
    near(u_ft[6], 0.005 - 2e-6);
    near(u_ft[5], 0.015 - 2e-6);
    near(u_ft[4], 0.0);
}

TEST(dirt_turns_it_round)
{
    const double gaps[JOINTS] = {0.1, 0.1, 0.01, 0, -0.0150, 0.01, 0.1, 0.1};
    closing_lb[5] = 20.0;
    press(gaps);
    closing_lb[5] = 0.0;
    near(gap_ft[5], 0.01);
    near(gap_ft[2], 0.0); /* mats 4 and 3 */
    near(gap_ft[1], 0.1 - (0.005 - 3e-6));
    near(u_ft[2], -(0.005 - 3e-6));
    near(u_ft[3], -(0.015 - 3e-6));
    near(u_ft[5], 0.0);
}

/* Against an end nothing moves, and all openings together stay what they are. */
TEST(ends_hold_and_the_sum_stays)
{
    const double gaps[JOINTS] = {-0.02, 0, -0.01, 0.003, -0.004, 0.02, 0.001, 0.03};
    double before = 0.0, after = 0.0;
    press(gaps);
    for (int j = 0; j < JOINTS; j++) {
        before += gaps[j];
        after += gap_ft[j];
        assert_true(gap_ft[j] > -8.0 * RUB / KL);
        double opened = (j < JOINTS - 1 ? u_ft[j + 1] : 0.0) - (j > 0 ? u_ft[j] : 0.0);
        near(gap_ft[j] - gaps[j], opened);
    }
    near(after, before);
}

/* What friction holds stays as it is, to the bit. */
TEST(a_pressed_runway_that_holds_stays)
{
    const double gaps[JOINTS] = {0.1, 0, -0.9e-6, -1.9e-6, -2.9e-6, -1.9e-6, -0.9e-6, 0.1};
    press(gaps);
    assert_memory_equal(gap_ft, gaps, sizeof gap_ft);
}
