/* The fit on 420 mats whose truth is not its own model: series of tests/score/truth.h, host/sim's
 * chain in double precision with resistances of four shapes, braking that changes and ripples, or
 * with that a gear that has its weight, on elastic ground. How often the 95 % intervals hold, and
 * how often the model is called impossible.
 *
 *   others FOLDER [FIRST [CASES]]
 *
 * Series from FIRST on (2001), CASES of each kind (20). Fitted is the first landing of a series,
 * with a survey before and after it and eight transducers; the joints' stiffness is known. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/statistics.h"
#include "host/study/fit/landings.h"
#include "tests/fit/cheap.h"
#include "tests/score/truth.h"

#define DRAWS           64u
#define LANDINGS        1u
#define FIRST_STATION   3 /* at 40 ft */
#define NOISE_IN        0.003
#define SURVEY_ERROR_IN 0.005
#define AIRCRAFT_LB     1300.0
#define GRAVITY_FT_S2   32.174
#define LOOK_S          (1e-3 * SCORE_LOOK_MS)
#define ROW_S           (1e-3 * SCORE_ROW_MS)
#define DWELL_S         0.3
#define KINDS           2

static const char *const names[KINDS] = {"chain", "elastic"};
static const enum score_kind kinds[KINDS] = {SCORE_CHAIN, SCORE_ELASTIC};

static const struct fit_parameter priors[FIT_KEYS] = {[FIT_GAP] = {true, 0.018, 0.03},
                                                      [FIT_GRIT] = {true, 10.0, 0.5},
                                                      [FIT_FRICTION] = {true, 0.5, 0.1},
                                                      [FIT_SHARE] = {true, 1.0 / 12.0, 0.15},
                                                      [FIT_STIFFNESS] = {false, 2.9e5, 0.3}};

/* The gear's way at each look, and the force that its deceleration there says. */
static void set_path(struct sim_scene *scene, const struct score_landing *truth)
{
    static struct sim_path_row row[SCORE_LOOKS_MAX + 2];
    size_t count = 0;
    for (uint32_t k = 0; k < truth->looks; k++) {
        size_t before = k > 0 ? k - 1 : 0, after = k + 1 < truth->looks ? k + 1 : k;
        double brake =
            ((double)truth->speed_at_ft_s[before] - (double)truth->speed_at_ft_s[after]) /
            (LOOK_S * (double)(after - before > 0 ? after - before : 1));
        bool down = LOOK_S * k >= truth->touchdown_s;
        row[count++] = (struct sim_path_row){LOOK_S * k, (double)truth->wheel_ft[k],
                                             down ? AIRCRAFT_LB * fmax(brake, 0.0) / GRAVITY_FT_S2
                                                  : 0.0};
    }
    double force_lb = row[count - 1].force_lb;
    if (truth->stop_s > row[count - 1].t_s + 1e-6)
        row[count++] = (struct sim_path_row){truth->stop_s, truth->stop_ft, force_lb};
    row[count] = row[count - 1];
    row[count].t_s += 0.001;
    row[count++].force_lb = 0.0;
    sim_scene_set_path(scene, row, count);
}

static void read_survey(const float *gap_in, double sum_in[MR_SEGMENTS],
                        struct cheap_random *random)
{
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        sum_in[s] = SURVEY_ERROR_IN * cheap_normal(random);
        for (size_t j = 0; j < MR_MATS_PER_SEGMENT; j++)
            sum_in[s] += fmax((double)gap_in[MR_MATS_PER_SEGMENT * s + j], 0.0);
    }
}

static bool add_landing(const struct score_truth *truth, uint32_t number, uint32_t of,
                        struct fit_landings *list, struct cheap_random *random, struct error *error)
{
    const struct score_landing *its = &truth->landing[number];
    struct fit_landing landing = {.run = (int64_t)number + 1,
                                  .thrust_error = 0.005,
                                  .follows = number > 0,
                                  .survey_error_in = SURVEY_ERROR_IN,
                                  .after_error_in = SURVEY_ERROR_IN};
    struct fit_series series[MR_TRANSDUCERS];
    double *value_in = calloc((size_t)its->rows * MR_TRANSDUCERS + 1, sizeof *value_in);
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        landing.survey_in[s] = landing.after_in[s] = (double)NAN;
    sim_scene_defaults(&landing.scene);
    landing.scene.model = SIM_CHAIN;
    landing.scene.mats = SCORE_MATS;
    landing.scene.length_ft = SCORE_MAT_FT;
    landing.scene.weight_lb = 0.466;
    landing.scene.cl_lb_s_ft = 5.0;
    landing.scene.slack_ft = 0.0025;
    landing.scene.left = landing.scene.right = SIM_FIXED;
    landing.scene.v0_ft_s = 0.0;
    landing.scene.t_dwell_s = DWELL_S;
    if (number == 0)
        read_survey(its->gap_in, landing.survey_in, random);
    if (number + 1 == of) {
        float left_in[SCORE_JOINTS];
        for (int j = 0; j < SCORE_JOINTS; j++)
            left_in[j] = 1e-5f * (float)its->gap_hmil[its->looks - 1][j];
        read_survey(number + 1 < truth->series.landings ? truth->landing[number + 1].gap_in
                                                        : left_in,
                    landing.after_in, random);
    }
    for (size_t c = 0; c < MR_TRANSDUCERS && value_in; c++) {
        for (uint32_t k = 0; k < its->rows; k++)
            value_in[c * its->rows + k] = (double)its->u_in[k][FIRST_STATION + c] +
                                          NOISE_IN * cheap_normal(random);
        series[c] = (struct fit_series){.station_ft = 10.0 * (double)(FIRST_STATION + 1 + c),
                                        .dt_s = ROW_S,
                                        .value_in = value_in + c * its->rows,
                                        .count = its->rows,
                                        .noise_in = NOISE_IN};
    }
    bool good = value_in != NULL;
    set_path(&landing.scene, its);
    if (good && number == 0) {
        double sum_in = 0.0;
        fit_landings_begin(list, &landing.scene);
        memcpy(list->parameter, priors, sizeof priors);
        for (size_t s = 0; s < MR_SEGMENTS; s++)
            sum_in += landing.survey_in[s];
        list->parameter[FIT_GAP].value = sum_in / SCORE_MATS;
        list->parameter[FIT_FRICTION].value = truth->series.told_friction;
        list->parameter[FIT_STIFFNESS].value = truth->series.kl_lb_ft;
    }
    good = good && fit_landings_add(list, &landing, series, MR_TRANSDUCERS, error) == MR_OK;
    if (!good)
        sim_scene_free(&landing.scene);
    free(value_in);
    return good;
}

static void set_truth(const struct score_series *series, const struct fit_landings *list,
                      double z[FIT_KEYS])
{
    const double value[FIT_KEYS] = {[FIT_GAP] = list->parameter[FIT_GAP].value,
                                    [FIT_GRIT] = series->grit_mean_lb,
                                    [FIT_FRICTION] = series->friction,
                                    [FIT_SHARE] = series->thrust_share / 12.0,
                                    [FIT_STIFFNESS] = series->kl_lb_ft};
    for (int k = 0; k < FIT_STIFFNESS; k++)
        z[k] = log(value[k] / list->parameter[k].value) / list->parameter[k].spread;
}

struct tally {
    unsigned cases, cannot, held[FIT_KEYS], trusted, trusted_held, other, other_held;
};

static bool play(const char *folder, enum score_kind kind, uint32_t number, struct tally *tally)
{
    static struct score_truth truth;
    struct fit_landings list = {0};
    struct fit_answer answer = {0};
    struct error error = {0};
    struct cheap_random random = {0x07e50000u + number};
    double z[FIT_KEYS];
    if (!score_truth_get(&truth, number, kind, folder))
        return false;
    uint32_t of = truth.series.landings < LANDINGS ? truth.series.landings : LANDINGS;
    bool good = of > 0;
    for (uint32_t n = 0; n < of && good; n++)
        good = add_landing(&truth, n, of, &list, &random, &error);
    struct fit_model model = fit_landings_model(&list);
    struct fit_options options = {.draws = DRAWS, .seed = number};
    good = good && fit_run(&model, list.measured, &options, &answer, &error) == MR_OK;
    if (good) {
        struct misfit misfit = misfit_check(&list, &answer, number);
        set_truth(&truth.series, &list, z);
        tally->cases++;
        tally->cannot += misfit.cannot;
        for (int k = 0; k < FIT_STIFFNESS; k++) {
            bool held = answer.low[k] <= z[k] && z[k] <= answer.high[k];
            tally->held[k] += held;
            *(misfit.cannot ? &tally->other : &tally->trusted) += 1;
            *(misfit.cannot ? &tally->other_held : &tally->trusted_held) += held;
        }
        if (getenv("MISFITS_ROWS"))
            printf("%u: %d %.2f, shape %u, %u landings\n", number, misfit.cannot, misfit.share,
                   truth.series.grit_shape, of);
    } else {
        fprintf(stderr, "others: series %u: %s\n", number, error.text);
    }
    fit_free(&answer);
    fit_landings_free(&list);
    return good;
}

static double percent(unsigned part, unsigned of)
{
    return of > 0 ? 100.0 * part / of : (double)NAN;
}

int main(int argc, char **argv)
{
    uint32_t first = argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 10) : 2001,
             cases = argc > 3 ? (uint32_t)strtoul(argv[3], NULL, 10) : 20;
    if (argc < 2) {
        fprintf(stderr, "others FOLDER [FIRST [CASES]]\n");
        return 2;
    }
    static struct tally tally[KINDS];
    for (uint32_t n = 0; n < cases; n++) {
        for (int k = 0; k < KINDS; k++)
            play(argv[1], kinds[k], first + n, &tally[k]);
    }
    printf("420 mats, other truths, series from %u: cases, called impossible (95 %%), intervals "
           "hold of gap grit f share, %%, of all where trusted and where not\n",
           first);
    for (int k = 0; k < KINDS; k++) {
        struct wilson wilson = wilson_of(tally[k].cannot, tally[k].cases);
        printf("%-8s %3u %3u (%.0f to %.0f %%) ", names[k], tally[k].cases, tally[k].cannot,
               100.0 * wilson.low, 100.0 * wilson.high);
        for (int i = 0; i < FIT_STIFFNESS; i++)
            printf(" %3.0f", percent(tally[k].held[i], tally[k].cases));
        printf("   %.0f of %u, %.0f of %u\n", percent(tally[k].trusted_held, tally[k].trusted),
               tally[k].trusted, percent(tally[k].other_held, tally[k].other), tally[k].other);
    }
    return 0;
}
