#include "tests/fit/runway.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "tests/fit/cheap.h"

#define JOINTS_MAX              421
#define WHOLE_MATS              420 /* that the plan of landings is for */
#define LENGTH_FT               (2.0 / 7.0)
#define SLACK_FT                0.0025
#define MOST_GAP_IN             0.036
#define SURVEY_READING_ERROR_IN 0.005
#define SURVEY_SPREAD           0.03
#define NOISE_IN                0.003
#define BASELINE_IN             0.0002
#define GAIN                    0.0065
#define THRUST_ERROR            0.005
#define AIRCRAFT_LB             1300.0
#define GRAVITY_FT_S2           32.174
#define TOUCHDOWN_FT            3.0
#define DWELL_S                 0.3
#define SAMPLE_S                0.002
#define PATH_ROWS               122
#define HEAVY_SHAPE             2.0

const char *const runway_names[RUNWAY_KINDS] = {"model", "heavy", "half", "patchy", "braking"};

/* Speed and way to the stop: from light to hard braking. */
static const struct {
    double slow_ft_s, fast_ft_s, short_ft, long_ft;
} plan[RUNWAY_LANDINGS] = {{27.0, 30.0, 86.0, 100.0}, {35.0, 39.0, 62.0, 78.0}};

struct truth {
    enum runway_kind kind;
    struct cheap_random random;
    double value[FIT_KEYS];
    int mats;
    double gap_ft[JOINTS_MAX], grit_lb[JOINTS_MAX];
    double factor; /* of all sums, by the gauge */
    bool turned;   /* half: the dirt lies before the middle */
};

static double between(struct cheap_random *random, double low, double high)
{
    return low + (high - low) * cheap_uniform(random);
}

static void set_priors(struct fit_parameter parameter[FIT_KEYS])
{
    parameter[FIT_GAP] = (struct fit_parameter){true, 0.018, SURVEY_SPREAD};
    parameter[FIT_GRIT] = (struct fit_parameter){true, 10.0, 0.4};
    parameter[FIT_FRICTION] = (struct fit_parameter){true, 0.5, 0.1};
    parameter[FIT_THRUST_SHARE] = (struct fit_parameter){true, 1.0 / 12.0, 0.1};
    parameter[FIT_STIFFNESS] = (struct fit_parameter){false, 2.9e5, 0.0};
}

static double draw_grit_lb(struct truth *truth, int joint)
{
    double mean_lb = truth->value[FIT_GRIT];
    bool before = 2 * joint < truth->mats;
    switch (truth->kind) {
    case RUNWAY_HEAVY: /* mean of Lomax: scale / (shape - 1) */
        return mean_lb * (HEAVY_SHAPE - 1.0) *
               (pow(cheap_uniform(&truth->random), -1.0 / HEAVY_SHAPE) - 1.0);
    case RUNWAY_HALF:
        return (before == truth->turned ? 3.0 : 1.0) * mean_lb * cheap_uniform(&truth->random);
    default: return 2.0 * mean_lb * cheap_uniform(&truth->random);
    }
}

static void draw_joints(struct truth *truth)
{
    int left = 0;
    double wide = cheap_uniform(&truth->random) < 0.5 ? 0.4 : 1.6;
    for (int j = 0; j <= truth->mats; j++, left--) {
        if (left == 0) {
            left = 12 + (int)(29.0 * cheap_uniform(&truth->random));
            wide = 2.0 - wide;
        }
        double factor = truth->kind == RUNWAY_PATCHY ? wide : 1.0;
        double gap_in = factor * MOST_GAP_IN * cheap_uniform(&truth->random);
        truth->gap_ft[j] = fmin(gap_in / 12.0, SLACK_FT);
        truth->grit_lb[j] = draw_grit_lb(truth, j);
    }
}

static void read_survey(struct truth *truth, double sum_in[MR_SEGMENTS])
{
    for (size_t s = 0; s < (size_t)truth->mats / MR_MATS_PER_SEGMENT; s++) {
        double sum = 0.0;
        for (size_t j = 0; j < MR_MATS_PER_SEGMENT; j++)
            sum += 12.0 * fmax(truth->gap_ft[MR_MATS_PER_SEGMENT * s + j], 0.0);
        sum_in[s] = sum / truth->factor + SURVEY_READING_ERROR_IN * cheap_normal(&truth->random);
    }
}

/* The gear's way and the whole aircraft's force as they are told. */
static void set_path(struct sim_scene *scene, double speed_ft_s, double stopping_distance_ft)
{
    struct sim_path_row row[PATH_ROWS];
    double brake = speed_ft_s * speed_ft_s / (2.0 * stopping_distance_ft),
           stop_s = speed_ft_s / brake;
    for (int i = 0; i < PATH_ROWS - 1; i++) {
        double t_s = stop_s * i / (PATH_ROWS - 2);
        row[i] = (struct sim_path_row){t_s,
                                       TOUCHDOWN_FT + speed_ft_s * t_s - 0.5 * brake * t_s * t_s,
                                       AIRCRAFT_LB * brake / GRAVITY_FT_S2};
    }
    row[PATH_ROWS - 1] = (struct sim_path_row){stop_s + 0.001, row[PATH_ROWS - 2].x_ft, 0.0};
    sim_scene_set_path(scene, row, PATH_ROWS);
}

static void set_scene(struct sim_scene *scene, struct truth *truth, size_t number)
{
    double speed_ft_s = between(&truth->random, plan[number].slow_ft_s, plan[number].fast_ft_s),
           stopping_distance_ft = between(&truth->random, plan[number].short_ft,
                                          plan[number].long_ft);
    double scale = (double)truth->mats / WHOLE_MATS; /* of lengths; decelerations stay */
    size_t joints = (size_t)truth->mats + 1;
    sim_scene_set_defaults(scene);
    scene->model = SIM_MODEL_CHAIN;
    scene->mats = truth->mats;
    scene->length_ft = LENGTH_FT;
    scene->weight_lb = 0.466;
    scene->kl_lb_ft = truth->value[FIT_STIFFNESS];
    scene->cl_lb_s_ft = 5.0;
    scene->slack_ft = SLACK_FT;
    scene->left_end = scene->right_end = SIM_END_FIXED;
    scene->friction = truth->value[FIT_FRICTION];
    scene->v0_ft_s = 0.0;
    scene->t_dwell_s = DWELL_S;
    set_path(scene, speed_ft_s * sqrt(scale), stopping_distance_ft * scale);
    sim_scene_set_list(&scene->gap0_ft, truth->gap_ft, joints);
    sim_scene_set_list(&scene->grit_lb, truth->grit_lb, joints);
}

/* The force that there is, for the force that is told. */
static double thrust_factor(const struct truth *truth, const struct sim_scene *scene, size_t row)
{
    double half_s = 0.5 * scene->path[scene->path_count - 1].t_s;
    if (truth->kind != RUNWAY_BRAKING)
        return truth->value[FIT_THRUST_SHARE];
    return truth->value[FIT_THRUST_SHARE] * (scene->path[row].t_s < half_s ? 2.0 / 3.0 : 4.0 / 3.0);
}

/* What the transducers show; the runway is left as the landing leaves it. */
static bool land(struct truth *truth, struct sim_scene *scene,
                 const double station_ft[MR_TRANSDUCERS], double **value_in, size_t *samples,
                 struct error *error)
{
    struct sim_options options = {.sample_dt_s = SAMPLE_S,
                                  .station_ft = station_ft,
                                  .station_count = MR_TRANSDUCERS,
                                  .is_single_pass = true};
    struct sim_result result;
    double told_lb[PATH_ROWS];
    double error_of = 1.0 + THRUST_ERROR * cheap_normal(&truth->random);
    for (size_t i = 0; i < scene->path_count; i++) {
        told_lb[i] = scene->path[i].force_lb;
        scene->path[i].force_lb *= thrust_factor(truth, scene, i) * error_of;
    }
    bool good = sim_run(scene, &options, &result, error) == MR_OK;
    for (size_t i = 0; i < scene->path_count; i++)
        scene->path[i].force_lb = told_lb[i];
    *samples = good ? result.sample_count : 0;
    *value_in = calloc(MR_TRANSDUCERS * (*samples + 1), sizeof **value_in);
    for (size_t c = 0; c < MR_TRANSDUCERS && *value_in; c++) {
        double gain = 1.0 + GAIN * cheap_normal(&truth->random),
               zero_in = BASELINE_IN * cheap_normal(&truth->random);
        for (size_t k = 0; k < *samples; k++)
            (*value_in)[c * *samples + k] = 12.0 * gain *
                                                result.sample_u_ft[k * MR_TRANSDUCERS + c] +
                                            zero_in + NOISE_IN * cheap_normal(&truth->random);
    }
    for (int j = 0; good && j <= truth->mats; j++)
        truth->gap_ft[j] = fmax(result.gap_ft[j + 1], 0.0);
    sim_result_free(&result);
    return good && *value_in;
}

static bool add_landing(struct truth *truth, size_t number, bool last, bool surveyed,
                        struct fit_landings *list, struct error *error)
{
    double station_ft[MR_TRANSDUCERS], *value_in = NULL;
    struct fit_series series[MR_TRANSDUCERS];
    struct fit_landing landing = {.run = (int64_t)number + 1,
                                  .thrust_error = THRUST_ERROR,
                                  .is_consecutive = number > 0,
                                  .before_error_in = SURVEY_READING_ERROR_IN,
                                  .after_error_in = SURVEY_READING_ERROR_IN};
    size_t samples = 0;
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        landing.survey_in[s] = landing.survey_after_in[s] = (double)NAN;
    if (surveyed && number == 0)
        read_survey(truth, landing.survey_in);
    for (size_t c = 0; c < MR_TRANSDUCERS; c++)
        station_ft[c] = (110.0 - 10.0 * (double)(MR_TRANSDUCERS - 1 - c)) * truth->mats /
                        (double)WHOLE_MATS;
    set_scene(&landing.scene, truth, number);
    bool good = land(truth, &landing.scene, station_ft, &value_in, &samples, error);
    if (good && surveyed && last)
        read_survey(truth, landing.survey_after_in);
    for (size_t c = 0; c < MR_TRANSDUCERS && good; c++)
        series[c] = (struct fit_series){.station_ft = station_ft[c],
                                        .dt_s = SAMPLE_S,
                                        .value_in = value_in + c * samples,
                                        .count = samples,
                                        .noise_in = NOISE_IN,
                                        .baseline_error_in = BASELINE_IN,
                                        .gain_error = GAIN};
    if (good && number == 0) {
        struct fit_parameter prior[FIT_KEYS];
        set_priors(prior);
        fit_landings_begin(list, &landing.scene);
        memcpy(list->parameter, prior, sizeof prior);
        double sum_in = 0.0;
        for (size_t s = 0; s < MR_SEGMENTS && surveyed; s++)
            sum_in += isnan(landing.survey_in[s]) ? 0.0 : landing.survey_in[s];
        if (surveyed)
            list->parameter[FIT_GAP].value = sum_in / truth->mats;
    }
    good = good && fit_landings_add(list, &landing, series, MR_TRANSDUCERS, error) == MR_OK;
    if (!good)
        sim_scene_free(&landing.scene);
    free(value_in);
    return good;
}

bool runway_campaign(const struct runway_wanted *wanted, uint64_t seed, double z[FIT_KEYS],
                     struct fit_landings *list, struct error *error)
{
    struct truth truth = {
        .kind = wanted->kind,
        .random = {seed * 0x2545F4914F6CDD1Du + 0x420u + ((uint64_t)wanted->kind << 48)}};
    struct fit_parameter prior[FIT_KEYS];
    size_t landings = wanted->landings ? wanted->landings : RUNWAY_LANDINGS;
    truth.mats = wanted->mats ? wanted->mats : RUNWAY_MATS;
    *list = (struct fit_landings){0};
    set_priors(prior);
    for (int k = 0; k < FIT_KEYS; k++) {
        z[k] = cheap_normal(&truth.random);
        truth.value[k] = prior[k].value * exp(prior[k].spread * z[k]);
    }
    truth.factor = exp(SURVEY_SPREAD * z[FIT_GAP]);
    truth.turned = cheap_uniform(&truth.random) < 0.5;
    draw_joints(&truth);
    for (size_t n = 0; n < landings && n < RUNWAY_LANDINGS; n++) {
        if (!add_landing(&truth, n, n + 1 == landings, wanted->surveyed, list, error))
            return false;
    }
    return true;
}
