/* The fit: against closed forms where there are any, against finite differences of ensemble means,
 * on cheap landings with known parameters, and on cases confounded on purpose. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_journal.h"
#include "host/study/fit/landings.h"
#include "tests/fit/cheap.h"
#include "tests/fit/runway.h"
#include "tests/host/scratch.h"

static void near_to(double got, double wanted, double tolerance, const char *what)
{
    if (!(fabs(got - wanted) <= tolerance))
        fail_msg("%s: %.6g, expected %.6g within %.2g", what, got, wanted, tolerance);
}

/* ---- linear, Gaussian: s = A z + noise of known covariance, by its Cholesky factor ---- */

#define LINEAR_STATISTICS 4
struct linear {
    double slope[LINEAR_STATISTICS][2];
    double noise[LINEAR_STATISTICS][LINEAR_STATISTICS]; /* lower */
    double curve;                                       /* times z0^2, on every statistic */
};

static void simulate_linear(const void *context, size_t count, const double *z,
                            const uint64_t *draw, double *statistic, bool *good)
{
    const struct linear *linear = context;
    for (size_t n = 0; n < count; n++, z += 2, statistic += LINEAR_STATISTICS) {
        struct cheap_random random = {draw[n]};
        double e[LINEAR_STATISTICS];
        for (int i = 0; i < LINEAR_STATISTICS; i++)
            e[i] = cheap_normal(&random);
        for (int i = 0; i < LINEAR_STATISTICS; i++) {
            statistic[i] = linear->slope[i][0] * z[0] + linear->slope[i][1] * z[1] +
                           linear->curve * z[0] * z[0];
            for (int k = 0; k <= i; k++)
                statistic[i] += linear->noise[i][k] * e[k];
        }
        good[n] = true;
    }
}

static const struct linear plain = {
    .slope = {{1.0, 0.5}, {0.3, 2.0}, {-0.7, 0.4}, {0.0, 1.0}},
    .noise = {{0.5}, {0.2, 0.8}, {-0.1, 0.3, 0.6}, {0.4, 0.1, -0.2, 0.9}},
};

static void fit_linear(const struct linear *linear, const double *measured, size_t draws,
                       unsigned threads, struct fit_result *answer)
{
    struct fit_model model = {2, LINEAR_STATISTICS, simulate_linear, linear};
    struct fit_options options = {.draw_count = draws, .thread_count = threads, .seed = 5};
    struct error error = {0};
    fit_run(&model, measured, &options, answer, &error);
    assert_no_error(&error);
}

/* A' S^-1 A and A' S^-1 s of `plain`, by forward substitution through the noise's factor. */
static void closed_form(const struct linear *linear, const double *measured,
                        double information[2][2], double side[2])
{
    double white[LINEAR_STATISTICS][3];
    for (int i = 0; i < LINEAR_STATISTICS; i++) {
        for (int c = 0; c < 3; c++) {
            double rest = c < 2 ? linear->slope[i][c] : measured[i];
            for (int k = 0; k < i; k++)
                rest -= linear->noise[i][k] * white[k][c];
            white[i][c] = rest / linear->noise[i][i];
        }
    }
    for (int a = 0; a < 2; a++) {
        side[a] = 0.0;
        for (int i = 0; i < LINEAR_STATISTICS; i++)
            side[a] += white[i][a] * white[i][2];
        for (int b = 0; b < 2; b++) {
            information[a][b] = 0.0;
            for (int i = 0; i < LINEAR_STATISTICS; i++)
                information[a][b] += white[i][a] * white[i][b];
        }
    }
}

TEST(linear_is_the_closed_form)
{
    const double measured[LINEAR_STATISTICS] = {0.9, -0.4, 0.2, -0.8};
    double f[2][2], side[2];
    struct fit_result answer;
    closed_form(&plain, measured, f, side);
    double a = f[0][0] + 1.0, b = f[0][1], d = f[1][1] + 1.0, det = a * d - b * b;
    fit_linear(&plain, measured, 4000, 0, &answer);
    near_to(answer.z[0], (d * side[0] - b * side[1]) / det, 0.04, "estimate 1");
    near_to(answer.z[1], (a * side[1] - b * side[0]) / det, 0.04, "estimate 2");
    near_to(answer.information[0][0], f[0][0], 0.07 * f[0][0], "information 1");
    near_to(answer.information[1][1], f[1][1], 0.07 * f[1][1], "information 2");
    /* An estimate by data and priors that are both drawn anew about the truth has the covariance (F
     * + 1)^-1. */
    near_to(answer.covariance[0][0], d / det, 0.08 * d / det, "variance 1");
    near_to(answer.covariance[1][1], a / det, 0.08 * a / det, "variance 2");
    near_to(answer.covariance[0][1], -b / det, 0.08 * sqrt(a * d) / det, "covariance");
    near_to(answer.high[0] - answer.z[0], 1.96 * sqrt(answer.covariance[0][0]), 0.002,
            "half an interval");
    near_to(answer.z[0] - answer.low[0], 1.96 * sqrt(answer.covariance[0][0]), 0.002,
            "the other half");
    near_to(answer.bias[0], 0.0, 0.08, "bias");
    fit_free(&answer);
}

TEST(threads_change_nothing)
{
    const double measured[LINEAR_STATISTICS] = {0.9, -0.4, 0.2, -0.8};
    struct fit_result one, three;
    fit_linear(&plain, measured, 100, 1, &one);
    fit_linear(&plain, measured, 100, 3, &three);
    assert_memory_equal(one.z, three.z, sizeof one.z);
    assert_memory_equal(one.low, three.low, sizeof one.low);
    assert_memory_equal(one.residual, three.residual, LINEAR_STATISTICS * sizeof *one.residual);
    fit_free(&one);
    fit_free(&three);
}

/* ---- derivatives ---- */

TEST(slopes_are_those_of_the_misfit)
{
    struct linear curved = plain;
    struct fit_model model = {2, LINEAR_STATISTICS, simulate_linear, &curved};
    struct fit_options options = {.draw_count = 200, .thread_count = 1, .seed = 3};
    struct ensemble_region place = {
        .parameter_count = 2, .middle = {0.2, -0.1}, .spread = {{0.8}, {0.3, 0.6}}};
    struct ensemble ensemble;
    struct surface surface;
    struct solve solve;
    struct error error = {0};
    /* inside, and where the surface goes on straight */
    const double at[][2] = {{0.3, -0.7}, {2.9, 0.1}, {-3.0, 3.5}};
    curved.curve = 0.4;
    for (int i = 2; i < LINEAR_STATISTICS; i++) /* scores here are the first two statistics */
        curved.slope[i][0] = curved.slope[i][1] = 0.0;
    assert_int_equal(ensemble_simulate(&model, &place, &options, 0, &ensemble, &error), MR_OK);
    gsl_matrix *weight = gsl_matrix_calloc(LINEAR_STATISTICS, 2);
    gsl_matrix_set(weight, 0, 0, 1.0);
    gsl_matrix_set(weight, 1, 1, 1.0);
    struct ensemble scores;
    surface_combine(&ensemble, weight, &scores);
    assert_int_equal(surface_make(&scores, &surface, &error), MR_OK);
    assert_true(solve_begin(&solve, &surface, &place));
    solve.score[0] = 1.0;
    for (size_t n = 0; n < sizeof at / sizeof at[0]; n++) {
        double residual[4], slope[8], up[4], down[4], unused[8];
        solve_residual(&solve, at[n], residual, slope);
        for (int i = 0; i < 2; i++) {
            double high[2] = {at[n][0], at[n][1]}, low[2] = {at[n][0], at[n][1]};
            high[i] += 1e-5;
            low[i] -= 1e-5;
            solve_residual(&solve, high, up, unused);
            solve_residual(&solve, low, down, unused);
            for (int r = 0; r < 4; r++)
                near_to(slope[2 * r + i], (up[r] - down[r]) / 2e-5,
                        1e-5 * (1.0 + fabs(slope[2 * r + i])), "derivative");
        }
    }
    gsl_matrix_free(weight);
    surface_free(&surface);
    ensemble_free(&scores);
    ensemble_free(&ensemble);
}

/* The chain sticks and closes, so one landing has no derivative; the mean over many draws has. The
 * surface's slope, from 400 draws spread about, against central differences of means over 400 draws
 * at either end. */
TEST(surface_slopes_are_those_of_means)
{
    enum { DRAWS = 400, STATISTICS = 64 };
    const double truth[FIT_KEYS] = {0.0};
    struct fit_landings list;
    struct ensemble ensemble;
    struct surface surface;
    struct error error = {0};
    struct fit_options options = {.draw_count = DRAWS, .seed = 9};
    struct ensemble_region place = {.parameter_count = FIT_KEYS};
    double middle[FIT_KEYS] = {0.0}, expected[STATISTICS], slope[STATISTICS * FIT_KEYS],
           one[STATISTICS];
    const double step = 0.6;
    assert_true(cheap_landing(truth, 4, false, &list, &error));
    struct fit_model model = fit_landings_model(&list);
    assert_true(list.statistics <= STATISTICS && list.statistics > 8);
    for (int i = 0; i < FIT_KEYS; i++)
        place.spread[i][i] = step;
    assert_int_equal(ensemble_simulate(&model, &place, &options, 0, &ensemble, &error), MR_OK);
    assert_int_equal(surface_make(&ensemble, &surface, &error), MR_OK);
    surface_evaluate(&surface, middle, expected, slope);
    /* gaps, share: the rest goes the same way */
    for (int i = 0; i < FIT_KEYS; i += FIT_THRUST_SHARE) {
        double sum[2][STATISTICS] = {{0.0}}, square[2][STATISTICS] = {{0.0}}, squares = 0.0;
        for (uint64_t n = 0; n < 2 * DRAWS; n++) {
            double z[FIT_KEYS] = {0.0};
            uint64_t draw = 1000000 + n;
            bool good;
            z[i] = n % 2 ? step : -step;
            model.simulate(model.context, 1, z, &draw, one, &good);
            assert_true(good);
            for (size_t s = 0; s < list.statistics; s++) {
                sum[n % 2][s] += one[s];
                square[n % 2][s] += one[s] * one[s];
            }
        }
        for (size_t s = 0; s < list.statistics; s++) {
            double variance = 0.0;
            for (int side = 0; side < 2; side++)
                variance += (square[side][s] / DRAWS - pow(sum[side][s] / DRAWS, 2.0)) / DRAWS;
            /* In w, whose unit is the step, both are the same difference; the surface's own error
             * is that of one side. */
            double difference = 0.5 * (sum[1][s] - sum[0][s]) / DRAWS -
                                slope[s * FIT_KEYS + (size_t)i];
            double error_of =
                sqrt(0.25 * variance + gsl_matrix_get(surface.covariance, s, s) / DRAWS);
            squares += pow(difference / error_of, 2.0);
            assert_true(fabs(difference) < 5.0 * error_of);
        }
        /* they are correlated: of order 1 */
        assert_true(squares / (double)list.statistics < 4.0);
    }
    surface_free(&surface);
    ensemble_free(&ensemble);
    fit_landings_free(&list);
}

/* ---- confounded ---- */

TEST(sum_alone_cannot_be_told_apart)
{
    struct linear sum = plain;
    const double measured[LINEAR_STATISTICS] = {0.5, 1.0, -0.5, 0.2};
    struct fit_result answer;
    for (int i = 0; i < LINEAR_STATISTICS; i++)
        sum.slope[i][1] = sum.slope[i][0] = 1.0 + i;
    fit_linear(&sum, measured, 300, 0, &answer);
    near_to(answer.covariance[0][1] / sqrt(answer.covariance[0][0] * answer.covariance[1][1]), -1.0,
            0.1, "correlation");
    fit_free(&answer);
}

TEST(what_changes_nothing_keeps_its_prior)
{
    struct linear one = plain;
    const double measured[LINEAR_STATISTICS] = {0.5, 1.0, -0.5, 0.2};
    struct fit_result answer;
    for (int i = 0; i < LINEAR_STATISTICS; i++)
        one.slope[i][1] = 0.0;
    fit_linear(&one, measured, 300, 0, &answer);
    near_to(answer.covariance[1][1], 1.0, 0.2, "what is left of the prior");
    fit_free(&answer);
}

static void fit_cheap(const double truth[FIT_KEYS], uint64_t seed, unsigned of, double widen,
                      struct fit_landings *list, struct fit_result *answer)
{
    struct error error = {0};
    struct fit_options options = {.draw_count = 200, .seed = 11};
    assert_true(cheap_landing(truth, seed, false, list, &error));
    for (int k = 0; k < FIT_KEYS; k++) {
        list->parameter[k].is_fitted = of >> k & 1u;
        list->parameter[k].spread *= widen;
    }
    struct fit_model model = fit_landings_model(list);
    fit_run(&model, list->measured, &options, answer, &error);
    assert_no_error(&error);
}

/* ---- known parameters found again ---- */

TEST(known_parameters_are_found)
{
    static const double truth[3][FIT_KEYS] = {
        {0.0}, {0.5, -0.8, 1.0, 0.3, -0.5}, {-0.6, 0.7, -1.2, -0.4, 0.8}};
    for (uint64_t n = 0; n < 3; n++) {
        struct fit_landings list;
        struct fit_result answer;
        fit_cheap(truth[n], 31 + n, 31, 1.0, &list, &answer);
        for (int k = 0; k < FIT_KEYS; k++) {
            double error_z = sqrt(answer.covariance[k][k]);
            near_to(answer.z[k], truth[n][k], 2.6 * error_z, fit_parameter_names[k].key);
            assert_true(error_z < 1.25);
        }
        /* most of what is known of these two comes from the landing */
        assert_true(answer.covariance[FIT_FRICTION][FIT_FRICTION] < 0.8 * 0.8);
        assert_true(answer.covariance[FIT_STIFFNESS][FIT_STIFFNESS] < 0.8 * 0.8);
        fit_free(&answer);
        fit_landings_free(&list);
    }
}

/* ---- statistics ---- */

/* A transducer that moves an inch a second: a window's mean is its middle's time. The wheel runs at
 * 10 ft/s from 0 and stops at 4 s; the transducer stands at 30 ft. */
TEST(windows_follow_the_wheel)
{
    enum { COUNT = 5000 };
    static const double middle_s[] = {1.8, 2.4, 2.7, 2.9, 3.2, 4.4};
    static const char *const names[] = {"16 to 8 ft ahead", "8 to 4 ft ahead",  "4 to 2 ft ahead",
                                        "2 to 0 ft ahead",  "0 to 4 ft behind", "end"};
    struct sim_path_row path[] = {{0.0, 0.0, 1.0}, {4.0, 40.0, 1.0}};
    struct fit_landings list;
    struct fit_landing landing = {.run = 7};
    struct error error = {0};
    double *value = calloc(COUNT, sizeof *value);
    struct fit_series series = {30.0, 0.0, 0.001, value, COUNT, 0.0, 0.0, 0.0};
    assert_non_null(value);
    for (int i = 0; i < COUNT; i++)
        value[i] = 0.001 * i;
    sim_scene_set_defaults(&landing.scene);
    landing.scene.t_dwell_s = 0.5;
    sim_scene_set_path(&landing.scene, path, 2);
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        landing.survey_in[s] = landing.survey_after_in[s] = (double)NAN;
    fit_landings_begin(&list, &landing.scene);
    for (int i = 2200; i < 2500; i++) /* three quarters of 8 to 4 ft ahead */
        value[i] = (double)NAN;
    value[2700] = (double)NAN;
    assert_int_equal(fit_landings_add(&list, &landing, &series, 1, &error), MR_OK);
    assert_int_equal(list.statistics, 5); /* of the six, the one with too few left out */
    for (size_t s = 0, w = 0; w < 6; w++) {
        if (w == 1)
            continue;
        near_to(0.05 * sinh(list.measured[s] / 0.05), middle_s[w], 0.002, names[w]);
        s++;
    }
    fit_landings_free(&list);
    free(value);
}

/* Ten gaps that are uniform over 0 to 0.036 in and sum up to 0.03 in lie evenly on a simplex: no
 * cap binds, so E[g^2] = 2 S^2/(n (n + 1)) (Dirichlet's distribution). Uniform ones scaled to that
 * sum would have 0.0129 instead of 0.0182. */
TEST(gaps_given_their_sum)
{
    enum { DRAWS = 3000 };
    const double z[FIT_KEYS] = {0.0};
    struct fit_landings list;
    struct sim_scene scene;
    struct error error = {0};
    double squares = 0.0, hooked = 0.0, mean_in = 0.0, share;
    assert_true(cheap_landing(z, 4, false, &list, &error));
    sim_scene_set_defaults(&scene);
    scene.mats = list.landing[0].scene.mats;
    list.survey_error_in = 0.0;
    list.parameter[FIT_GAP].value = 0.018;
    list.landing[0].survey_in[0] = 0.03;
    for (uint64_t n = 0; n < DRAWS; n++) {
        double sum_in = 0.0;
        fit_landings_sample_joints(&list, z, 500 + n, &scene, &share);
        for (int j = 1; j <= 10; j++) {
            double gap_in = 12.0 * sim_scene_joint_value(&scene.gap0_ft, j);
            sum_in += gap_in;
            squares += gap_in * gap_in / (0.03 * 0.03) / (10.0 * DRAWS);
        }
        near_to(sum_in, 0.03, 1e-9, "sum");
    }
    near_to(squares, 2.0 / 110.0, 0.0004, "mean square");
    /* Not surveyed, mean 0.024 in, slack 0.03 in: uniform up to 0.075 in, so that three of five lie
     * hooked. */
    list.parameter[FIT_GAP].value = 0.024;
    list.landing[0].survey_in[0] = (double)NAN;
    for (uint64_t n = 0; n < DRAWS; n++) {
        fit_landings_sample_joints(&list, z, 500 + n, &scene, &share);
        double gap_in = 12.0 * sim_scene_joint_value(&scene.gap0_ft, 5);
        hooked += (gap_in > 0.03 - 1e-12) / (double)DRAWS;
        mean_in += gap_in / DRAWS;
    }
    near_to(hooked, 0.6, 0.03, "hooked");
    near_to(mean_in, 0.024, 0.0006, "mean gap");
    sim_scene_free(&scene);
    fit_landings_free(&list);
}

/* ---- refusals ---- */

static void fail_always(const void *context, size_t count, const double *z, const uint64_t *draw,
                        double *statistic, bool *good)
{
    (void)context, (void)z, (void)draw, (void)statistic;
    memset(good, 0, count * sizeof *good);
}

TEST(bad_input_is_refused)
{
    const double measured[LINEAR_STATISTICS] = {0.0};
    struct fit_model model = {2, 1, simulate_linear, &plain};
    struct fit_options options = {.draw_count = 100, .thread_count = 1};
    struct fit_result answer;
    struct error few = {0}, draws = {0}, failed = {0};
    fit_run(&model, measured, &options, &answer, &few);
    assert_error(&few, MR_TOO_FEW, "the landings give 1 statistics for 2 parameters");
    fit_free(&answer);
    model.statistic_count = LINEAR_STATISTICS;
    options.draw_count = 20;
    fit_run(&model, measured, &options, &answer, &draws);
    assert_error(&draws, MR_USAGE, "too few draws");
    fit_free(&answer);
    options.draw_count = 100;
    model.simulate = fail_always;
    fit_run(&model, measured, &options, &answer, &failed);
    assert_error(&failed, MR_NUMERICS, "100 of 100 simulations failed");
    fit_free(&answer);
}

/* ---- fit surveyed ---- */

static struct error failure;

static struct store *fresh(const char *name)
{
    char path[200];
    struct store *store = NULL;
    failure = (struct error){0};
    store_open(scratch_path(path, sizeof path, name), STORE_CREATE, &store, &failure);
    assert_no_error(&failure);
    return store;
}

static int64_t land(struct store *store, int64_t number)
{
    struct store_session session = {.started_us = 1000 * number, .can_link = "file:a"};
    assert_int_equal(store_session_add(store, &session, &failure), MR_OK);
    struct store_landing landing = {.session = session.id,
                                    .board_landing = number,
                                    .armed_block = 800,
                                    .armed_us = 1000 * number,
                                    .state = 4,
                                    .board_uid = "AB",
                                    .image_crc = STORE_NONE,
                                    .switch_error_ft = (double)NAN};
    assert_int_equal(store_landing_add(store, &landing, &failure), MR_OK);
    return landing.id;
}

/* Lines 1 and 2 of `count` spans from 0 on, `add` and 0.02 in beyond closed: their mean is add +
 * 0.01. */
static void survey(struct store *store, int64_t made_us, int64_t count, double add, double error_in)
{
    struct store_gage_survey row = {.made_us = made_us,
                                    .ended_us = STORE_NONE,
                                    .edges = "none",
                                    .error_in = error_in,
                                    .closed_in = 33.5};
    assert_int_equal(store_gage_survey_add(store, &row, &failure), MR_OK);
    for (int64_t place = 0; place < count; place++) {
        for (int64_t line = 1; line <= 2; line++) {
            struct store_gage_reading reading = {.kind = "gap",
                                                 .line = line,
                                                 .place = place,
                                                 .taken_us = made_us,
                                                 .source = "typed",
                                                 .value_in = 33.5 + add + (line == 2 ? 0.02 : 0.0)};
            assert_int_equal(store_gage_reading_add(store, row.id, &reading, &failure), MR_OK);
        }
    }
}

static void board(struct store *store, int64_t run, double slack_in)
{
    for (int64_t s = 0; s < (int64_t)MR_SEGMENTS; s++) {
        struct store_segment segment = {.segment = s, .slack_in = slack_in, .joints = 10};
        assert_int_equal(store_segment_put(store, run, &segment, &failure), MR_OK);
    }
}

TEST(nothing_is_known)
{
    struct store *store = fresh("surveyed0.db");
    struct fit_survey found;
    int64_t run = land(store, 1);
    assert_int_equal(fit_load_survey(store, run, false, run, &found, &failure), MR_OK);
    assert_int_equal(found.segment_count, 0);
    assert_true(isnan(found.sum_in[0]) && found.error_in == 0.0);
    assert_int_equal(fit_load_survey(store, run, true, STORE_NONE, &found, &failure), MR_OK);
    assert_int_equal(found.segment_count, 0);
    store_close(store);
}

/* Survey, landing 1, an old and a new survey of ten segments, landing 2, a survey of all. The board
 * knew 0.20 in, then 0.18. */
TEST(the_newest_between_two_landings)
{
    struct store *store = fresh("surveyed1.db");
    struct fit_survey found;
    survey(store, 500, 42, 0.25, 0.004);
    int64_t first = land(store, 1);
    board(store, first, 0.20);
    survey(store, 1500, 10, 0.40, 0.004);
    survey(store, 1600, 10, 0.15, 0.1);
    int64_t second = land(store, 2);
    board(store, second, 0.18);
    survey(store, 2500, 42, 0.05, 0.004);

    assert_int_equal(fit_load_survey(store, first, false, first, &found, &failure), MR_OK);
    assert_int_equal(found.gage_segment_count, 42);
    assert_near(found.sum_in[0], 0.26, 1e-9);
    assert_near(found.sum_in[41], 0.26, 1e-9);
    /* two lines 0.02 in apart say more than 0.004/sqrt 2 */
    assert_near(found.error_in, 0.01, 1e-9);

    assert_int_equal(fit_load_survey(store, first, true, second, &found, &failure), MR_OK);
    assert_int_equal(found.gage_segment_count, 10);
    assert_int_equal(found.segment_count, 42);
    assert_near(found.sum_in[9], 0.16, 1e-9);
    assert_near(found.sum_in[10], 0.18, 1e-6); /* not read: the board's */
    assert_near(found.error_in, 0.1 / sqrt(2.0), 1e-9);

    struct fit_survey before;
    assert_int_equal(fit_load_survey(store, second, false, second, &before, &failure), MR_OK);
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        assert_near(before.sum_in[s], found.sum_in[s], 0.0);

    assert_int_equal(fit_load_survey(store, second, true, STORE_NONE, &found, &failure), MR_OK);
    assert_int_equal(found.gage_segment_count, 42);
    assert_near(found.sum_in[20], 0.06, 1e-9);
    store_close(store);
}

/* ---- fit misfit ---- */

enum { REPLICAS = 99, ROWS = REPLICAS + 1 };

struct rows {
    struct fit_landings list;
    struct fit_result answer;
};

/* A campaign's statistics with residuals that are normal, neighbours' correlated by a third. */
static void begin(struct rows *rows, uint64_t seed)
{
    const struct runway_wanted wanted = {.surveyed = true, .landings = 1, .mats = 100};
    static struct error error;
    double z[FIT_KEYS];
    struct cheap_random random = {seed};
    assert_true(runway_campaign(&wanted, seed, z, &rows->list, &error));
    size_t p = rows->list.statistics;
    rows->answer = (struct fit_result){.statistic_count = p, .replica_count = REPLICAS};
    rows->answer.residual = calloc(ROWS * p, sizeof(double));
    assert_non_null(rows->answer.residual);
    for (size_t i = 0; i < ROWS; i++) {
        for (size_t s = 0; s < p; s++) {
            double *at = &rows->answer.residual[i * p + s];
            *at = cheap_normal(&random) + (s > 0 ? 0.35 * at[-1] : 0.0);
        }
    }
}

static void end(struct rows *rows)
{
    fit_free(&rows->answer);
    fit_landings_free(&rows->list);
}

static struct misfit check(const struct rows *rows)
{
    return misfit_check(&rows->list, &rows->answer, 3);
}

/* The measured row is one of a hundred: five of them are said to be odd, whichever it is. */
TEST(one_among_equals)
{
    struct rows rows;
    unsigned cannot = 0;
    begin(&rows, 11);
    size_t p = rows.list.statistics;
    double *first = calloc(p, sizeof *first);
    assert_non_null(first);
    for (size_t s = 0; s < MR_SEGMENTS; s++) /* the survey stays the same: leave it out */
        rows.list.landing[0].survey_in[s] = (double)NAN;
    for (size_t i = 0; i < ROWS; i++) {
        struct misfit misfit = check(&rows);
        assert_true(misfit.is_checked);
        cannot += misfit.is_rejected;
        memcpy(first, rows.answer.residual, p * sizeof *first);
        for (size_t k = 0; k + 1 < ROWS; k++)
            memcpy(rows.answer.residual + k * p, rows.answer.residual + (k + 1) * p,
                   p * sizeof *first);
        memcpy(rows.answer.residual + (ROWS - 1) * p, first, p * sizeof *first);
    }
    assert_int_equal(cannot, 5);
    free(first);
    end(&rows);
}

static double station(const struct rows *rows, size_t s)
{
    const struct fit_landing *landing = &rows->list.landing[0];
    const struct fit_window *window = &landing->window[s];
    return window->channel == SIZE_MAX ? -1.0 : landing->channel[window->channel].station_ft;
}

/* Four standard deviations on the second half alone; one residual of 9. */
TEST(what_is_odd_is_found)
{
    struct rows rows;
    begin(&rows, 12);
    for (size_t s = 0; s < rows.list.statistics; s++)
        rows.answer.residual[s] += station(&rows, s) > 50.0 / 3.5 ? 4.0 : 0.0;
    assert_true(check(&rows).is_rejected);
    end(&rows);

    begin(&rows, 14);
    rows.answer.residual[7] = 9.0;
    assert_true(check(&rows).is_rejected);
    end(&rows);
}

TEST(too_few_are_not_checked)
{
    struct rows rows;
    begin(&rows, 15);
    rows.answer.replica_count = MISFIT_REPLICAS_MIN - 1;
    struct misfit misfit = check(&rows);
    assert_false(misfit.is_checked || misfit.is_rejected);
    end(&rows);
}

/* From the landing to the check: gaps laid in stretches, and gaps that were not. */
TEST(gaps_in_stretches)
{
    for (int patchy = 0; patchy < 2; patchy++) {
        const struct runway_wanted wanted = {.kind = patchy ? RUNWAY_PATCHY : RUNWAY_MODEL,
                                             .surveyed = true,
                                             .landings = 1,
                                             .mats = 100};
        struct fit_options options = {.draw_count = 60, .replica_count = 59, .seed = 3};
        struct rows rows = {0};
        struct error error = {0};
        double z[FIT_KEYS];
        assert_true(runway_campaign(&wanted, 21, z, &rows.list, &error));
        for (int k = 0; k < FIT_KEYS; k++)
            rows.list.parameter[k].is_fitted = k == FIT_GRIT;
        struct fit_model model = fit_landings_model(&rows.list);
        fit_run(&model, rows.list.measured, &options, &rows.answer, &error);
        assert_no_error(&error);
        struct misfit misfit = check(&rows);
        assert_true(misfit.is_checked);
        assert_int_equal(misfit.is_rejected, patchy);
        end(&rows);
    }
}

/* ---- fit beside ---- */

enum { DRAWS = 24 };

static double *simulated(struct fit_landings *list)
{
    struct fit_model model = fit_landings_model(list);
    double *statistic = calloc(DRAWS * list->statistics, sizeof *statistic);
    double z[DRAWS * FIT_KEYS];
    uint64_t draw[DRAWS];
    bool good[DRAWS];
    assert_non_null(statistic);
    for (unsigned n = 0; n < DRAWS; n++) {
        draw[n] = 4000 + n;
        for (int k = 0; k < FIT_KEYS; k++)
            z[n * FIT_KEYS + (unsigned)k] = 0.5 * sin(3.0 * n + 2.0 * k);
    }
    for (unsigned n = 0; n < DRAWS; n += FIT_BATCH_MAX)
        model.simulate(model.context, FIT_BATCH_MAX, z + n * FIT_KEYS, draw + n,
                       statistic + n * list->statistics, good + n);
    for (unsigned n = 0; n < DRAWS; n++)
        assert_true(good[n]);
    return statistic;
}

TEST(as_host_sim)
{
    const struct runway_wanted wanted = {.surveyed = true, .landings = 2};
    struct fit_landings list;
    struct error error = {0};
    double z[FIT_KEYS], squares = 0.0, offset = 0.0, worst = 0.0;
    assert_true(runway_campaign(&wanted, 7, z, &list, &error));
    assert_true(parallel_is_supported(&list.landing[0].scene));
    size_t p = list.statistics;
    double *beside = simulated(&list);
    for (size_t l = 0; l < list.count; l++)
        list.landing[l].scene.wheel_load_lb = 1e-9; /* the chains have none */
    assert_false(parallel_is_supported(&list.landing[0].scene));
    double *alone = simulated(&list);
    for (size_t s = 0; s < p; s++) {
        double mean = 0.0, spread = 0.0, difference = 0.0, square = 0.0;
        for (size_t n = 0; n < DRAWS; n++) {
            double d = beside[n * p + s] - alone[n * p + s];
            difference += d / DRAWS;
            square += d * d / DRAWS;
            mean += alone[n * p + s] / DRAWS;
        }
        for (size_t n = 0; n < DRAWS; n++)
            spread += pow(alone[n * p + s] - mean, 2.0) / (DRAWS - 1);
        squares += square / spread / (double)p;
        offset += difference / sqrt(spread) / (double)p;
        worst = fmax(worst, fabs(difference) / sqrt(spread));
    }
    print_message("rms %.3f, mean %+.4f, worst mean %.3f of what joints scatter\n", sqrt(squares),
                  offset, worst);
    assert_true(sqrt(squares) < 0.1);
    assert_true(fabs(offset) < 0.01);
    assert_true(worst < 0.1);
    free(beside);
    free(alone);
    fit_landings_free(&list);
}
