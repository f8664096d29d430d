#include "tests/fit/cheap.h"

#include <math.h>
#include <string.h>

#include "common/splitmix.h"

#define MATS                    30
#define LENGTH_FT               (2.0 / 7.0)
#define WEIGHT_LB               0.466
#define SLACK_FT                0.0025
#define AIRCRAFT_LB             520.0
#define GRAVITY_FT_S2           32.174
#define SPEED_FT_S              8.0
#define BRAKE_FT_S2             10.0
#define TOUCHDOWN_FT            1.5
#define DWELL_S                 0.25
#define SAMPLE_S                0.002
#define TRANSDUCERS             4
#define PATH_ROWS               42
#define SAMPLES                 700
#define SURVEY_READING_ERROR_IN 0.005

double cheap_uniform(struct cheap_random *random)
{
    return ((double)(mr_splitmix64(&random->state) >> 11) + 0.5) * 0x1p-53;
}

double cheap_normal(struct cheap_random *random) /* Box and Muller */
{
    double radius = sqrt(-2.0 * log(cheap_uniform(random)));
    return radius * cos(6.283185307179586 * cheap_uniform(random));
}

void cheap_priors(struct fit_parameter parameter[FIT_KEYS])
{
    parameter[FIT_GAP] = (struct fit_parameter){true, 0.010, 0.35};
    parameter[FIT_GRIT] = (struct fit_parameter){true, 6.0, 0.4};
    parameter[FIT_FRICTION] = (struct fit_parameter){true, 0.5, 0.3};
    parameter[FIT_THRUST_SHARE] = (struct fit_parameter){true, 1.0 / 12.0, 0.15};
    parameter[FIT_STIFFNESS] = (struct fit_parameter){true, 4e3, 0.4};
}

/* Distance and force of the whole aircraft over time; the force ends with the motion. */
static void set_path(struct sim_scene *scene)
{
    struct sim_path_row row[PATH_ROWS];
    double stop_s = SPEED_FT_S / BRAKE_FT_S2;
    for (int i = 0; i < PATH_ROWS - 1; i++) {
        double t_s = stop_s * i / (PATH_ROWS - 2);
        row[i] = (struct sim_path_row){
            t_s, TOUCHDOWN_FT + SPEED_FT_S * t_s - 0.5 * BRAKE_FT_S2 * t_s * t_s,
            AIRCRAFT_LB * BRAKE_FT_S2 / GRAVITY_FT_S2};
    }
    row[PATH_ROWS - 1] = (struct sim_path_row){stop_s + 0.001, row[PATH_ROWS - 2].x_ft, 0.0};
    sim_scene_set_path(scene, row, PATH_ROWS);
}

static void set_scene(struct sim_scene *scene, const double value[FIT_KEYS], double *gap_ft,
                      double *grit_lb, struct cheap_random *random)
{
    sim_scene_set_defaults(scene);
    scene->model = SIM_MODEL_CHAIN;
    scene->mats = MATS;
    scene->length_ft = LENGTH_FT;
    scene->weight_lb = WEIGHT_LB;
    scene->kl_lb_ft = value[FIT_STIFFNESS];
    scene->cl_lb_s_ft = 5.0;
    scene->slack_ft = SLACK_FT;
    scene->left_end = scene->right_end = SIM_END_FIXED;
    scene->friction = value[FIT_FRICTION];
    scene->v0_ft_s = 0.0;
    scene->t_dwell_s = DWELL_S;
    /* Uniform, but none beyond the slack s: up to 2 h leaves a mean of s - s^2/(4 h) where 2 h > s,
     * and that mean is the parameter. */
    double mean_ft = value[FIT_GAP] / 12.0;
    double half_ft = mean_ft > 0.5 * SLACK_FT
                       ? SLACK_FT * SLACK_FT / 4.0 / fmax(SLACK_FT - mean_ft, 1e-6)
                       : mean_ft;
    for (int j = 0; j <= MATS; j++) {
        gap_ft[j] = fmin(2.0 * half_ft * cheap_uniform(random), SLACK_FT);
        grit_lb[j] = 2.0 * value[FIT_GRIT] * cheap_uniform(random);
    }
    set_path(scene);
    sim_scene_set_list(&scene->gap0_ft, gap_ft, MATS + 1);
    sim_scene_set_list(&scene->grit_lb, grit_lb, MATS + 1);
}

/* What the transducers show, with noise. */
static bool run_scene(struct sim_scene *scene, double share, const double station_ft[TRANSDUCERS],
                      double value_in[TRANSDUCERS][SAMPLES], size_t *samples,
                      struct cheap_random *random, struct error *error)
{
    struct sim_options options = {
        .sample_dt_s = SAMPLE_S, .station_ft = station_ft, .station_count = TRANSDUCERS};
    struct sim_result result;
    for (size_t i = 0; i < scene->path_count; i++)
        scene->path[i].force_lb *= share;
    bool good = sim_run(scene, &options, &result, error) == MR_OK;
    for (size_t i = 0; i < scene->path_count; i++)
        scene->path[i].force_lb /= share;
    *samples = good ? result.sample_count < SAMPLES ? result.sample_count : SAMPLES : 0;
    for (size_t k = 0; k < *samples; k++) {
        for (size_t c = 0; c < TRANSDUCERS; c++)
            value_in[c][k] = 12.0 * result.sample_u_ft[k * TRANSDUCERS + c] +
                             CHEAP_NOISE_IN * cheap_normal(random);
    }
    sim_result_free(&result);
    return good;
}

/* Reads the sums; true sums are `factor` times what an exact reading says. Gives the mean reading
 * of a joint. */
static double survey(const double *gap_ft, double factor, double slack_in[MR_SEGMENTS],
                     struct cheap_random *random)
{
    double all_in = 0.0;
    for (size_t s = 0; s < MATS / 10; s++) {
        double sum_in = 0.0;
        for (size_t j = 0; j < 10; j++)
            sum_in += 12.0 * gap_ft[10 * s + j];
        slack_in[s] = sum_in / factor + SURVEY_READING_ERROR_IN * cheap_normal(random);
        all_in += slack_in[s];
    }
    return all_in / MATS;
}

bool cheap_landing(const double z[FIT_KEYS], uint64_t seed, bool surveyed,
                   struct fit_landings *list, struct error *error)
{
    static const double station_ft[TRANSDUCERS] = {3.0, 4.2, 5.4, 6.6};
    double value_in[TRANSDUCERS][SAMPLES], gap_ft[MATS + 1], grit_lb[MATS + 1], value[FIT_KEYS];
    struct cheap_random random = {seed * 0x2545F4914F6CDD1Du + 77};
    struct fit_series series[TRANSDUCERS];
    struct fit_landing landing = {.run = 1};
    struct fit_parameter prior[FIT_KEYS];
    size_t samples = 0;
    cheap_priors(prior);
    for (int k = 0; k < FIT_KEYS; k++)
        value[k] = prior[k].value *
                   exp(prior[k].spread * (surveyed && k == FIT_GAP ? cheap_normal(&random) : z[k]));
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        landing.survey_in[s] = landing.survey_after_in[s] = (double)NAN;
    set_scene(&landing.scene, value, gap_ft, grit_lb, &random);
    bool good = run_scene(&landing.scene, value[FIT_THRUST_SHARE], station_ft, value_in, &samples,
                          &random, error);
    if (good && surveyed)
        prior[FIT_GAP] = (struct fit_parameter){
            true, survey(gap_ft, exp(CHEAP_SURVEY_SPREAD * z[FIT_GAP]), landing.survey_in, &random),
            CHEAP_SURVEY_SPREAD};
    for (size_t c = 0; c < TRANSDUCERS && good; c++)
        series[c] = (struct fit_series){station_ft[c],  0.0, SAMPLE_S, value_in[c], samples,
                                        CHEAP_NOISE_IN, 0.0, 0.0};
    fit_landings_begin(list, &landing.scene);
    memcpy(list->parameter, prior, sizeof prior);
    if (good)
        good = fit_landings_add(list, &landing, series, TRANSDUCERS, error) == MR_OK;
    if (!good)
        sim_scene_free(&landing.scene);
    return good;
}
