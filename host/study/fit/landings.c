#include "host/study/fit/landings.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/measured_load.h"
#include "host/analyse/zones.h"
#include "host/base/xmalloc.h"
#include "host/compare/landing.h"
#include "host/survey/survey.h"
#include "host/sim/elements/wheel.h"
#include "host/sim/scene/scene.h"

/* ---- chains in parallel ---- */

#define SETTLING_S  1e-3
#define STEP_MARGIN 0.98 /* step / longest stable step; below 1 for single precision */

bool parallel_is_supported(const struct sim_scene *scene)
{
    bool plain = scene->model == SIM_MODEL_CHAIN && scene->thrust == SIM_THRUST_JUMP &&
                 scene->slack_ft > 0.0 && scene->left_end == SIM_END_FIXED &&
                 scene->right_end == SIM_END_FIXED && scene->cl_lb_s_ft > 0.0 &&
                 (scene->friction_law == SIM_FRICTION_STICK ||
                  scene->friction_law == SIM_FRICTION_SIGN) &&
                 scene->friction_normal == SIM_NORMAL_WEIGHT && !mods_are_present(scene) &&
                 !sim_scene_is_varied(scene);
    for (int i = 0; i < SIM_ELEMENTS_MAX; i++)
        plain = plain && !(scene->element_values[i] > 0.0);
    return plain && !(scene->wheel_load_lb > 0.0) && !(fabs(scene->v0_ft_s) > 0.0) &&
           scene->path_count > 1 && !(scene->path[0].t_s < 0.0) && scene->ground_ft.count == 0 &&
           isinf(scene->force_stop_s) && scene->mats >= 2 && scene->mats <= (int)MR_CHAIN_MATS &&
           isfinite(sim_scene_end_s(scene));
}

/* Number of sample rows, one every dt_s from 0 on. */
static size_t parallel_sample_count(const struct sim_scene *scene, double dt_s)
{
    return (size_t)(sim_scene_end_s(scene) / dt_s + 1e-9) + 1;
}

struct simulation {
    const struct sim_scene *scene;
    struct parallel_lane *lanes;
    struct chains *chains;
    struct sim_wheel wheel;
    double step_s;
    unsigned steps; /* steps between two calls of chains_end_block */
    unsigned station_mat[MR_CHAIN_MATS];
    size_t station_count;
};

static struct mr_chain_params chain_params(const struct sim_scene *scene,
                                           const struct parallel_lane *lane)
{
    return (struct mr_chain_params){
        .mats = (uint16_t)scene->mats,
        .mat_length_ft = (float)scene->length_ft,
        .mass_slug = (float)(scene->weight_lb / scene->g_ft_s2),
        .friction_lb = (float)(lane->friction * scene->weight_lb),
        .kl_lb_ft = (float)lane->kl_lb_ft,
        .cl_lb_s_ft = (float)scene->cl_lb_s_ft,
        .slack_ft = (float)scene->slack_ft,
    };
}

static bool start_chains(struct simulation *p)
{
    size_t joints = (size_t)p->scene->mats + 1;
    struct mr_chain_params params[CHAINS_LANES];
    const float *gap[CHAINS_LANES], *grit[CHAINS_LANES];
    enum mr_status status;
    double limit_s = (double)INFINITY;
    float *values = xcalloc(2 * CHAINS_LANES * joints, sizeof *values);
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        float *gap_ft = values + 2 * k * joints, *grit_lb = gap_ft + joints;
        params[k] = chain_params(p->scene, &p->lanes[k]);
        limit_s = fmin(limit_s, (double)mr_chain_step_limit_s(&params[k]));
        for (size_t j = 0; j < joints; j++) {
            gap_ft[j] = (float)p->lanes[k].gap_ft[j];
            grit_lb[j] = (float)p->lanes[k].grit_lb[j];
        }
        gap[k] = gap_ft;
        grit[k] = grit_lb;
    }
    p->steps = (unsigned)ceil(SETTLING_S / (STEP_MARGIN * (double)MR_CHAIN_STEP_MARGIN * limit_s));
    p->step_s = SETTLING_S / p->steps;
    for (unsigned k = 0; k < CHAINS_LANES; k++)
        params[k].step_s = (float)p->step_s;
    p->chains = isfinite(limit_s) ? chains_make(params, gap, grit, &status) : NULL;
    free(values);
    return p->chains != NULL;
}

/* Returns the mean thrust in a step, and sets *mat to the mat that carries most of it. */
static double step_thrust_lb(struct simulation *p, double from_s, unsigned *mat)
{
    struct sim_touch touch[SIM_WHEEL_TOUCHES_MAX];
    int count = sim_wheel_compute_action(&p->wheel, from_s, from_s + p->step_s, touch);
    double sum = 0.0, most = -1.0;
    *mat = 1;
    for (int i = 0; i < count; i++) {
        sum += touch[i].thrust_lb;
        if (touch[i].load_share > most) {
            most = touch[i].load_share;
            *mat = (unsigned)touch[i].mat;
        }
    }
    return sum;
}

static void record_sample(const struct simulation *p, size_t row)
{
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        for (size_t s = 0; s < p->station_count; s++)
            p->lanes[k].sample_u_ft[row * p->station_count + s] =
                (double)chains_displacement_ft(p->chains, k, p->station_mat[s]);
    }
}

static unsigned advance_chains(struct simulation *p, size_t samples, unsigned each)
{
    unsigned away = 0, mat[CHAINS_LANES];
    float thrust_lb[CHAINS_LANES];
    bool over = false;
    record_sample(p, 0);
    for (size_t row = 1; row < samples; row++) {
        for (unsigned n = 0; n < each && !over; n++) {
            size_t block = (row - 1) * each + n;
            for (unsigned i = 0; i < p->steps; i++) {
                double t_s = SETTLING_S * (double)block + p->step_s * i, lb;
                lb = step_thrust_lb(p, t_s, &mat[0]);
                for (unsigned k = 0; k < CHAINS_LANES; k++) {
                    mat[k] = mat[0];
                    thrust_lb[k] = (float)(lb * p->lanes[k].thrust_factor);
                }
                chains_step(p->chains, mat, thrust_lb);
            }
            away |= chains_end_block(p->chains);
            over = sim_wheel_is_past_path(&p->wheel, SETTLING_S * (double)(block + 1)) &&
                   chains_active_mats(p->chains) == 0; /* all mats are at rest */
        }
        record_sample(p, row);
    }
    return away;
}

/* Simulates all lanes. `sample_dt_s`: whole milliseconds. False: invalid parameter. */
static bool parallel_run(const struct sim_scene *scene, const double *station_ft, size_t stations,
                         double sample_dt_s, struct parallel_lane lane[CHAINS_LANES])
{
    struct simulation p = {.scene = scene, .lanes = lane, .station_count = stations};
    if (stations > MR_CHAIN_MATS || !start_chains(&p))
        return false;
    sim_wheel_start(&p.wheel, scene);
    for (size_t s = 0; s < stations; s++) {
        int mat = (int)floor(station_ft[s] / scene->length_ft + 1e-9) + 1;
        p.station_mat[s] = (unsigned)(mat > scene->mats ? scene->mats : mat);
    }
    unsigned away = advance_chains(&p, parallel_sample_count(scene, sample_dt_s),
                                   (unsigned)(sample_dt_s / SETTLING_S + 0.5));
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        lane[k].is_valid = !(away >> k & 1u);
        for (int j = 0; j <= scene->mats; j++)
            lane[k].gap_ft[j] = fmax((double)chains_opening_ft(p.chains, k, (unsigned)j + 1u), 0.0);
    }
    chains_free(p.chains);
    return true;
}

/* ---- simulation ---- */

#define IN_PER_FT       12.0
#define SAMPLE_DT_S     0.002
#define GAP_BISECTIONS  40
#define PAIRS_PER_JOINT 6 /* number of draws; the start values then have an influence of 0.5 % */

/* Upper limit m of the gaps, given their mean. Gaps are uniform from 0 to 2 m, limited to the slack
 * s; if 2 m > s, their mean is s - s^2/(4 m). INFINITY: all joints are open by their slack. */
static double gap_half_range_ft(double mean_ft, double slack_ft)
{
    if (!(slack_ft > 0.0) || mean_ft <= 0.5 * slack_ft)
        return mean_ft;
    return mean_ft < slack_ft ? slack_ft * slack_ft / (4.0 * (slack_ft - mean_ft))
                              : (double)INFINITY;
}

static double draw_gap_ft(gsl_rng *random, double half_ft, double slack_ft)
{
    double gap_ft = isinf(half_ft) ? slack_ft : 2.0 * half_ft * gsl_rng_uniform(random);
    return slack_ft > 0.0 ? fmin(gap_ft, slack_ft) : gap_ft;
}

/* Scales gaps to a given sum. Each is limited to the slack, so the factor is found by bisection. If
 * all gaps are closed, or if the sum exceeds the total slack, all gaps become equal. */
static void scale_gaps(double *gap_ft, size_t count, double sum_ft, double slack_ft)
{
    double most_ft = slack_ft > 0.0 ? slack_ft : (double)INFINITY, low = 0.0, high = 1.0, sum = 0.0;
    sum_ft = fmax(sum_ft, 0.0);
    for (size_t i = 0; i < count; i++)
        sum += fmax(gap_ft[i], 0.0);
    if (!(sum > 0.0) || sum_ft >= most_ft * (double)count) {
        for (size_t i = 0; i < count; i++)
            gap_ft[i] = fmin(sum_ft / (double)count, most_ft);
        return;
    }
    for (int n = 0; n < GAP_BISECTIONS; n++, high *= 2.0) {
        double reached = 0.0;
        for (size_t i = 0; i < count; i++)
            reached += fmin(high * fmax(gap_ft[i], 0.0), most_ft);
        if (reached >= sum_ft)
            break;
    }
    for (int n = 0; n < GAP_BISECTIONS; n++) {
        double middle = 0.5 * (low + high), reached = 0.0;
        for (size_t i = 0; i < count; i++)
            reached += fmin(middle * fmax(gap_ft[i], 0.0), most_ft);
        *(reached < sum_ft ? &low : &high) = middle;
    }
    for (size_t i = 0; i < count; i++)
        gap_ft[i] = fmin(high * fmax(gap_ft[i], 0.0), most_ft);
}

/* Draws two gaps again, with the same sum. Each is uniform from 0 to `most_ft`, limited to the
 * slack. Either both are below the slack, with all possible values equally likely, or one joint is
 * hooked. The weight of a hooked gap is 1 - slack/most, that of other values 1/most. */
static void draw_pair(gsl_rng *random, double *one, double *other, double most_ft, double slack_ft)
{
    double limit = slack_ft > 0.0 ? fmin(most_ft, slack_ft) : most_ft, sum = *one + *other;
    double low = fmax(0.0, sum - limit), high = fmin(sum, limit);
    if (!(high > low))
        return; /* both joints are hooked or both closed, so there is nothing to draw */
    double hooked = limit < most_ft && sum >= limit ? 2.0 * (most_ft - limit) : 0.0;
    double pick = gsl_rng_uniform(random) * (high - low + hooked);
    *one = pick < high - low ? low + pick : pick < high - low + 0.5 * hooked ? limit : sum - limit;
    *other = sum - *one;
}

/* Draws the gaps of a segment, which are uniform, with a given sum, by a Gibbs sampler over pairs.
 * If the sum is too large for `mean_ft`, as it may be after a landing has pushed other mats
 * together, the upper limit of the gaps is twice the mean of this segment. */
static void draw_gaps_with_sum(gsl_rng *random, double *gap_ft, size_t count, double mean_ft,
                               double slack_ft)
{
    double sum_ft = 0.0;
    for (size_t i = 0; i < count; i++)
        sum_ft += gap_ft[i];
    double most_ft = 2.0 * gap_half_range_ft(fmax(mean_ft, sum_ft / (double)count), slack_ft);
    if (isinf(most_ft))
        return; /* all joints are hooked */
    for (size_t n = 0; n < PAIRS_PER_JOINT * count && count > 1; n++) {
        size_t i = gsl_rng_uniform_int(random, count), k = gsl_rng_uniform_int(random, count - 1);
        draw_pair(random, &gap_ft[i], &gap_ft[k < i ? k : k + 1], most_ft, slack_ft);
    }
}

/* Returns the number of joints inside a segment or at its start; *first is the first of them. */
static size_t find_segment_joints(const struct sim_scene *scene, size_t segment, size_t *first)
{
    double from = (double)segment * (double)MR_SEGMENT_LENGTH_FT / scene->length_ft - 0.5;
    double to = (double)(segment + 1) * (double)MR_SEGMENT_LENGTH_FT / scene->length_ft - 0.5;
    size_t begin = (size_t)fmax(ceil(from - 1e-9), 0.0), end = (size_t)fmax(ceil(to - 1e-9), 0.0),
           joints = (size_t)scene->mats + 1;
    *first = begin < joints ? begin : joints;
    return (end < joints ? end : joints) - *first;
}

static double segment_sum_in(const struct sim_scene *scene, size_t segment, const double *gap_ft)
{
    size_t first, count = find_segment_joints(scene, segment, &first);
    double sum_in = 0.0;
    while (count-- > 0)
        sum_in += IN_PER_FT * fmax(gap_ft[first++], 0.0);
    return sum_in;
}

/* Inputs of one simulated data set. */
struct inputs {
    const struct fit_landings *list;
    gsl_rng *random;
    double value[FIT_KEYS];
    double *gap_ft, *grit_lb; /* values of joints 0 to `mats` */
    struct sim_path_row *path;
    bool is_valid;
};

/* Factor between true and surveyed sums: the same in all surveys (one gauge); 1 without one. */
static double survey_scale_factor(const struct inputs *inputs)
{
    const struct fit_landings *list = inputs->list;
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(list->landing[0].survey_in[s]))
            return inputs->value[FIT_GAP] / list->parameter[FIT_GAP].value;
    }
    return 1.0;
}

static double survey_error_in(double own_in, const struct fit_landings *list)
{
    return own_in > 0.0 ? own_in : list->survey_error_in;
}

static void draw_gaps(const struct inputs *inputs, const struct fit_landing *landing)
{
    const struct sim_scene *scene = &landing->scene;
    double half_ft = gap_half_range_ft(inputs->value[FIT_GAP] / IN_PER_FT, scene->slack_ft);
    double gauge = survey_scale_factor(inputs);
    double error_in = survey_error_in(landing->before_error_in, inputs->list);
    for (int j = 0; j <= scene->mats && !landing->is_consecutive; j++)
        inputs->gap_ft[j] = draw_gap_ft(inputs->random, half_ft, scene->slack_ft);
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        size_t first, count = find_segment_joints(scene, s, &first);
        if (isnan(landing->survey_in[s]) || count == 0)
            continue;
        double sum_in = gauge * landing->survey_in[s] +
                        gsl_ran_gaussian_ziggurat(inputs->random, error_in);
        scale_gaps(inputs->gap_ft + first, count, sum_in / IN_PER_FT, scene->slack_ft);
        if (!landing->is_consecutive)
            draw_gaps_with_sum(inputs->random, inputs->gap_ft + first, count,
                               inputs->value[FIT_GAP] / IN_PER_FT, scene->slack_ft);
    }
}

/* Draws gaps with the mean of the survey, and the surveyed sums (NaN: not surveyed). */
static void draw_survey(const struct fit_landings *list, const struct fit_landing *landing,
                        gsl_rng *random, double sum_in[MR_SEGMENTS])
{
    const struct sim_scene *scene = &landing->scene;
    double half_ft = gap_half_range_ft(list->parameter[FIT_GAP].value / IN_PER_FT, scene->slack_ft);
    double error_in = survey_error_in(landing->before_error_in, list);
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        size_t first, count = find_segment_joints(scene, s, &first);
        sum_in[s] = gsl_ran_gaussian_ziggurat(random, error_in);
        for (size_t j = 0; j < count; j++)
            sum_in[s] += IN_PER_FT * draw_gap_ft(random, half_ft, scene->slack_ft);
        if (isnan(landing->survey_in[s]))
            sum_in[s] = (double)NAN;
    }
}

#define ASINH_SCALE_IN 0.05 /* the constant u0 in the statistic u0 asinh(u/u0) */

/* Statistic of a displacement u: u0 asinh(u/u0). */
static double asinh_in(double u_in)
{
    return ASINH_SCALE_IN * asinh(u_in / ASINH_SCALE_IN);
}

struct outcome {
    double *sample_u_ft; /* `samples` rows, SAMPLE_DT_S apart, one value per channel */
    size_t samples;
    const double *gap_ft; /* gaps of joints 0 to `mats` at the end */
};

static void set_statistics(const struct inputs *inputs, const struct fit_landing *landing,
                           const struct outcome *outcome, double *statistic)
{
    double gain[MR_TRANSDUCERS], baseline_in[MR_TRANSDUCERS];
    for (size_t c = 0; c < landing->channels; c++) {
        gain[c] = 1.0 + gsl_ran_gaussian_ziggurat(inputs->random, landing->channel[c].gain_error);
        baseline_in[c] = gsl_ran_gaussian_ziggurat(inputs->random,
                                                   landing->channel[c].baseline_error_in);
    }
    double after_error_in = survey_error_in(landing->after_error_in, inputs->list);
    double gauge = survey_scale_factor(inputs);
    for (size_t w = 0; w < landing->window_count; w++) {
        const struct fit_window *window = &landing->window[w];
        if (window->channel == SIZE_MAX) {
            statistic[w] = segment_sum_in(&landing->scene, window->segment, outcome->gap_ft) /
                               gauge +
                           gsl_ran_gaussian_ziggurat(inputs->random, after_error_in);
            continue;
        }
        size_t c = window->channel, from = (size_t)ceil(window->from_s / SAMPLE_DT_S),
               to = (size_t)ceil(window->to_s / SAMPLE_DT_S);
        to = to > outcome->samples ? outcome->samples : to <= from ? from + 1 : to;
        double sum_in = 0.0;
        for (size_t k = from; k < to; k++)
            sum_in += IN_PER_FT * outcome->sample_u_ft[k * landing->channels + c];
        double noise_in = gsl_ran_gaussian_ziggurat(
            inputs->random, landing->channel[c].noise_in / sqrt(window->valid_samples));
        statistic[w] = asinh_in(gain[c] * sum_in / (double)(to - from) + baseline_in[c] + noise_in);
    }
}

/* Draws the ratio of the thrust on the mat strip to the thrust of the landing's path. */
static double draw_thrust(const struct inputs *inputs, const struct fit_landing *landing)
{
    return inputs->value[FIT_THRUST_SHARE] *
           (1.0 + gsl_ran_gaussian_ziggurat(inputs->random, landing->thrust_error));
}

/* Simulates one data set with host/sim, for scenes that parallel_is_supported refuses. */
static bool simulate_one(const struct inputs *inputs, const struct fit_landing *landing,
                         const double *station_ft, double thrust, struct outcome *outcome)
{
    struct sim_scene scene = landing->scene;
    struct sim_result result;
    struct error error = {0};
    memcpy(inputs->path, scene.path, scene.path_count * sizeof *inputs->path);
    for (size_t i = 0; i < scene.path_count; i++)
        inputs->path[i].force_lb *= thrust;
    scene.path = inputs->path;
    scene.gap0_ft = (struct sim_list){inputs->gap_ft, (size_t)scene.mats + 1};
    scene.grit_lb = (struct sim_list){inputs->grit_lb, (size_t)scene.mats + 1};
    scene.friction = inputs->value[FIT_FRICTION];
    scene.kl_lb_ft = inputs->value[FIT_STIFFNESS];
    struct sim_options options = {.solver = scene.model == SIM_MODEL_CHAIN ? "staggered" : NULL,
                                  .sample_dt_s = SAMPLE_DT_S,
                                  .station_ft = station_ft,
                                  .station_count = landing->channels};
    bool good = sim_run(&scene, &options, &result, &error) == MR_OK;
    outcome->samples = good && result.sample_count < outcome->samples ? result.sample_count
                                                                      : outcome->samples;
    if (good)
        memcpy(outcome->sample_u_ft, result.sample_u_ft,
               outcome->samples * landing->channels * sizeof(double));
    for (int j = 0; good && j <= scene.mats; j++)
        inputs->gap_ft[j] = fmax(result.gap_ft[j + 1], 0.0);
    sim_result_free(&result);
    return good;
}

/* Simulates `count` data sets in parallel. Unused lanes repeat the first data set. */
static bool simulate_parallel(struct inputs *inputs, size_t count,
                              const struct fit_landing *landing, const double *station_ft,
                              const double *thrust, double *spare_gap_ft, struct outcome *outcome)
{
    struct parallel_lane lane[CHAINS_LANES];
    size_t joints = (size_t)landing->scene.mats + 1;
    for (size_t k = 0; k < CHAINS_LANES; k++) {
        size_t of = k < count ? k : 0;
        lane[k] = (struct parallel_lane){.gap_ft = inputs[of].gap_ft,
                                         .grit_lb = inputs[of].grit_lb,
                                         .friction = inputs[of].value[FIT_FRICTION],
                                         .kl_lb_ft = inputs[of].value[FIT_STIFFNESS],
                                         .thrust_factor = thrust[of],
                                         .sample_u_ft = outcome[k].sample_u_ft};
        if (k >= count) {
            memcpy(spare_gap_ft + k * joints, inputs[0].gap_ft, joints * sizeof(double));
            lane[k].gap_ft = spare_gap_ft + k * joints;
        }
    }
    bool good = parallel_run(&landing->scene, station_ft, landing->channels, SAMPLE_DT_S, lane);
    for (size_t k = 0; k < count; k++)
        inputs[k].is_valid = inputs[k].is_valid && good && lane[k].is_valid;
    return good;
}

static void simulate_landing(struct inputs *inputs, size_t count, const struct fit_landing *landing,
                             double *statistic)
{
    struct outcome outcome[CHAINS_LANES];
    double station_ft[MR_TRANSDUCERS], thrust[CHAINS_LANES];
    size_t samples = parallel_sample_count(&landing->scene, SAMPLE_DT_S),
           joints = (size_t)landing->scene.mats + 1, each = samples * landing->channels;
    double *room = xcalloc(CHAINS_LANES * (each + joints), sizeof *room);
    for (size_t c = 0; c < landing->channels; c++)
        station_ft[c] = landing->channel[c].station_ft;
    for (size_t k = 0; k < CHAINS_LANES; k++)
        outcome[k] = (struct outcome){.sample_u_ft = room + k * each, .samples = samples};
    for (size_t k = 0; k < count; k++) {
        thrust[k] = draw_thrust(&inputs[k], landing);
        draw_gaps(&inputs[k], landing);
        outcome[k].gap_ft = inputs[k].gap_ft;
    }
    if (parallel_is_supported(&landing->scene)) {
        simulate_parallel(inputs, count, landing, station_ft, thrust, room + CHAINS_LANES * each,
                          outcome);
    } else {
        for (size_t k = 0; k < count; k++)
            inputs[k].is_valid = inputs[k].is_valid && simulate_one(&inputs[k], landing, station_ft,
                                                                    thrust[k], &outcome[k]);
    }
    for (size_t k = 0; k < count; k++) {
        if (inputs[k].is_valid)
            set_statistics(&inputs[k], landing, &outcome[k],
                           statistic + k * inputs->list->statistics + landing->first_statistic);
    }
    free(room);
}

/* Draws the closing resistances and allocates the arrays. Call free_inputs in every case. */
static void init_inputs(struct inputs *inputs, const struct fit_landings *list, const double *z,
                        uint64_t draw)
{
    size_t joints = 0, rows = 0;
    *inputs =
        (struct inputs){.list = list, .is_valid = true, .random = gsl_rng_alloc(gsl_rng_taus2)};
    for (size_t l = 0; l < list->count; l++) {
        const struct sim_scene *scene = &list->landing[l].scene;
        joints = joints > (size_t)scene->mats + 1 ? joints : (size_t)scene->mats + 1;
        rows = rows > scene->path_count ? rows : scene->path_count;
    }
    inputs->gap_ft = xcalloc(joints, sizeof(double));
    inputs->grit_lb = xcalloc(joints, sizeof(double));
    inputs->path = xcalloc(rows, sizeof *inputs->path);
    gsl_rng_set(inputs->random, (unsigned long)(draw ^ draw >> 32) & 0xffffffffu);
    fit_landings_values(list, z, inputs->value);
    for (size_t j = 0; j < joints; j++)
        inputs->grit_lb[j] = 2.0 * inputs->value[FIT_GRIT] * gsl_rng_uniform(inputs->random);
}

static void free_inputs(struct inputs *inputs)
{
    free(inputs->gap_ft);
    free(inputs->grit_lb);
    free(inputs->path);
    gsl_rng_free(inputs->random);
}

static void simulate(const void *context, size_t count, const double *z, const uint64_t *draw,
                     double *statistic, bool *good)
{
    const struct fit_landings *list = context;
    struct inputs inputs[FIT_BATCH_MAX];
    enum fit_key key[FIT_KEYS];
    size_t fitted = fit_landings_list_keys(list, key);
    for (size_t k = 0; k < count; k++)
        init_inputs(&inputs[k], list, z + k * fitted, draw[k]);
    for (size_t l = 0; l < list->count; l++)
        simulate_landing(inputs, count, &list->landing[l], statistic);
    for (size_t k = 0; k < count; k++) {
        good[k] = inputs[k].is_valid;
        free_inputs(&inputs[k]);
    }
}

void fit_landings_sample_joints(const struct fit_landings *list, const double *z, uint64_t draw,
                                struct sim_scene *scene, double *share)
{
    struct inputs inputs;
    size_t joints = (size_t)scene->mats + 1;
    init_inputs(&inputs, list, z, draw);
    *share = draw_thrust(&inputs, &list->landing[0]);
    draw_gaps(&inputs, &list->landing[0]);
    sim_scene_set_list(&scene->gap0_ft, inputs.gap_ft, joints);
    sim_scene_set_list(&scene->grit_lb, inputs.grit_lb, joints);
    free_inputs(&inputs);
}

struct fit_model fit_landings_model(const struct fit_landings *list)
{
    enum fit_key key[FIT_KEYS];
    return (struct fit_model){fit_landings_list_keys(list, key), list->statistics, simulate, list};
}

/* ---- landings ---- */

#define END_WINDOW_S    0.2
#define MIN_WINDOW_S    0.01
#define MIN_VALID_SHARE 0.5

const struct fit_parameter_name fit_parameter_names[FIT_KEYS] = {
    [FIT_GAP] = {"gap", "mean gap of the joints", UNIT_DISPLACEMENT},
    [FIT_GRIT] = {"grit", "mean closing resistance", UNIT_TENSION},
    [FIT_FRICTION] = {"f", "friction", UNIT_NUMBER},
    [FIT_THRUST_SHARE] = {"share", "share of the thrust", UNIT_NUMBER},
    [FIT_STIFFNESS] = {"KL", "stiffness of a joint", UNIT_STIFFNESS},
};

/* Distances of the wheel behind a transducer, ft, that limit the windows. */
static const double edges_ft[] = {16.0, 8.0, 4.0, 2.0, 0.0, -4.0};
#define WINDOW_EDGES (sizeof edges_ft / sizeof edges_ft[0])

void fit_landings_begin(struct fit_landings *list, const struct sim_scene *scene)
{
    *list = (struct fit_landings){.survey_error_in = 0.005};
    list->parameter[FIT_GAP] =
        (struct fit_parameter){true, IN_PER_FT * sim_scene_joint_value(&scene->gap0_ft, 1), 0.5};
    list->parameter[FIT_GRIT] =
        (struct fit_parameter){true, sim_scene_joint_value(&scene->grit_lb, 1), 0.5};
    list->parameter[FIT_FRICTION] = (struct fit_parameter){true, scene->friction, 0.2};
    list->parameter[FIT_THRUST_SHARE] = (struct fit_parameter){true, 1.0 / 12.0, 0.15};
    list->parameter[FIT_STIFFNESS] = (struct fit_parameter){true, scene->kl_lb_ft, 0.5};
}

void fit_landings_free(struct fit_landings *list)
{
    for (size_t l = 0; l < list->count; l++)
        sim_scene_free(&list->landing[l].scene);
    free(list->landing);
    free(list->measured);
    *list = (struct fit_landings){0};
}

/* ---- measurements ---- */

/* Time at which the wheel reaches a station; INFINITY: never; 0: the path begins beyond it. */
static double arrival_s(const struct sim_scene *scene, double x_ft)
{
    const struct sim_path_row *row = scene->path;
    if (row[0].x_ft >= x_ft)
        return 0.0;
    for (size_t i = 1; i < scene->path_count; i++) {
        if (row[i].x_ft >= x_ft)
            return row[i - 1].t_s + (row[i].t_s - row[i - 1].t_s) * (x_ft - row[i - 1].x_ft) /
                                        (row[i].x_ft - row[i - 1].x_ft);
    }
    return (double)INFINITY;
}

static double mean_in_window(const struct fit_series *series, double from_s, double to_s,
                             double *samples)
{
    double sum = 0.0, wanted = (to_s - from_s) / series->dt_s;
    *samples = 0.0;
    for (size_t i = 0; i < series->count; i++) {
        double t_s = series->t0_s + (double)i * series->dt_s;
        if (t_s < from_s || t_s >= to_s || isnan(series->value_in[i]))
            continue;
        sum += series->value_in[i];
        *samples += 1.0;
    }
    return *samples > 0.0 && *samples >= MIN_VALID_SHARE * wanted ? sum / *samples : (double)NAN;
}

static void add_window(struct fit_landing *landing, const struct fit_series *series, size_t channel,
                       double from_s, double to_s, double *measured)
{
    struct fit_window window = {.channel = channel, .from_s = from_s, .to_s = to_s};
    double mean_in = to_s - from_s >= MIN_WINDOW_S
                       ? mean_in_window(series, from_s, to_s, &window.valid_samples)
                       : (double)NAN;
    if (isnan(mean_in) || landing->window_count == FIT_WINDOWS_MAX)
        return;
    measured[landing->window_count] = asinh_in(mean_in);
    landing->window[landing->window_count++] = window;
}

static void add_channel(struct fit_landing *landing, const struct fit_series *series,
                        double *measured)
{
    size_t channel = landing->channels++;
    double end_s = sim_scene_end_s(&landing->scene),
           stop_s = landing->scene.path[landing->scene.path_count - 1].t_s;
    landing->channel[channel].station_ft = series->station_ft;
    landing->channel[channel].noise_in = series->noise_in;
    landing->channel[channel].baseline_error_in = series->baseline_error_in;
    landing->channel[channel].gain_error = series->gain_error;
    for (size_t e = 0; e + 1 < WINDOW_EDGES; e++) {
        double from_s = arrival_s(&landing->scene, series->station_ft - edges_ft[e]);
        double to_s = fmin(arrival_s(&landing->scene, series->station_ft - edges_ft[e + 1]),
                           stop_s);
        add_window(landing, series, channel, from_s, to_s, measured);
    }
    add_window(landing, series, channel, end_s - END_WINDOW_S, end_s, measured);
}

static void add_segment_statistics(struct fit_landing *landing, double *measured)
{
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        if ((isnan(landing->survey_in[s]) && !landing->is_consecutive) ||
            isnan(landing->survey_after_in[s]) || landing->window_count == FIT_WINDOWS_MAX)
            continue;
        struct fit_window window = {.channel = SIZE_MAX, .segment = s, .valid_samples = 1.0};
        measured[landing->window_count] = landing->survey_after_in[s];
        landing->window[landing->window_count++] = window;
    }
}

enum mr_status fit_landings_add(struct fit_landings *list, struct fit_landing *landing,
                                const struct fit_series *series, size_t count, struct error *error)
{
    double measured[FIT_WINDOWS_MAX];
    landing->channels = landing->window_count = 0;
    for (size_t c = 0; c < count && c < MR_TRANSDUCERS; c++)
        add_channel(landing, &series[c], measured);
    if (landing->window_count == 0)
        return error_set(error, MR_TOO_FEW,
                         "no transducer has enough valid samples: RUN %lld; fit different landings",
                         (long long)landing->run);
    add_segment_statistics(landing, measured);
    list->measured = xrealloc(list->measured,
                              (list->statistics + landing->window_count) * sizeof *list->measured);
    xlist_grow(&list->landing, list->count, sizeof *list->landing);
    landing->first_statistic = list->statistics;
    memcpy(list->measured + list->statistics, measured, landing->window_count * sizeof *measured);
    list->statistics += landing->window_count;
    list->landing[list->count++] = *landing;
    return MR_OK;
}

/* ---- parameters ---- */

size_t fit_landings_list_keys(const struct fit_landings *list, enum fit_key key[FIT_KEYS])
{
    size_t count = 0;
    for (enum fit_key k = 0; k < FIT_KEYS; k++) {
        if (list->parameter[k].is_fitted)
            key[count++] = k;
    }
    return count;
}

void fit_landings_values(const struct fit_landings *list, const double *z, double value[FIT_KEYS])
{
    for (enum fit_key k = 0; k < FIT_KEYS; k++) {
        const struct fit_parameter *parameter = &list->parameter[k];
        value[k] = parameter->value * (parameter->is_fitted ? exp(parameter->spread * *z++) : 1.0);
    }
}

/* ---- misfit ---- */

/* Squared Mahalanobis distance of each row of residuals. */
static void set_squared_distances(const struct fit_result *answer, size_t rows, double *square)
{
    size_t p = answer->statistic_count;
    gsl_matrix *z = gsl_matrix_alloc(rows, p), *covariance = gsl_matrix_alloc(p, p);
    for (size_t s = 0; s < p; s++) {
        const double *column = answer->residual + s;
        double mean = gsl_stats_mean(column, p, rows), sd = gsl_stats_sd(column, p, rows);
        for (size_t i = 0; i < rows; i++)
            gsl_matrix_set(z, i, s, sd > 0.0 ? (column[i * p] - mean) / sd : 0.0);
    }
    gsl_blas_dgemm(CblasTrans, CblasNoTrans, 1.0 / (double)(rows - 1), z, z, 0.0, covariance);
    surface_shrink(z, covariance);
    for (size_t s = 0; s < p; s++) /* keeps the matrix regular even if a statistic never varies */
        *gsl_matrix_ptr(covariance, s, s) += 1e-6;
    gsl_linalg_cholesky_decomp1(covariance);
    for (size_t i = 0; i < rows; i++) {
        gsl_vector_view row = gsl_matrix_row(z, i);
        gsl_blas_dtrsv(CblasLower, CblasNoTrans, CblasNonUnit, covariance, &row.vector);
        gsl_blas_ddot(&row.vector, &row.vector, &square[i]);
    }
    gsl_matrix_free(z);
    gsl_matrix_free(covariance);
}

/* Computes the logarithm of the spread of the sums. False: too few surveyed. */
static bool compute_log_spread(const double *sum_in, double *spread)
{
    double read[MR_SEGMENTS];
    size_t count = 0;
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(sum_in[s]))
            read[count++] = sum_in[s];
    }
    *spread = count > 4 ? log(fmax(gsl_stats_sd(read, 1, count), 1e-9)) : 0.0;
    return count > 4;
}

/* Compares the spread of the surveyed sums with the spread of sums drawn as in the fit. Needs a
 * survey before the runway's first landing: only such a survey shows how the gaps were laid. */
static void add_survey(const struct fit_landings *list, uint64_t seed, size_t rows, double *square)
{
    const struct fit_landing *first = &list->landing[0];
    double sum_in[MR_SEGMENTS], *spread = xcalloc(2 * rows, sizeof *spread),
                                *sorted = spread + rows;
    if (!first->has_earlier_landings && compute_log_spread(first->survey_in, &spread[0])) {
        gsl_rng *random = gsl_rng_alloc(gsl_rng_taus2);
        gsl_rng_set(random, (unsigned long)(seed * 2654435761u + 17u) & 0xffffffffu);
        for (size_t i = 1; i < rows; i++) {
            draw_survey(list, first, random, sum_in);
            compute_log_spread(sum_in, &spread[i]);
        }
        gsl_rng_free(random);
        for (size_t i = 0; i < rows; i++)
            sorted[i] = spread[i];
        gsl_sort(sorted, 1, rows);
        double middle = gsl_stats_median_from_sorted_data(sorted, 1, rows),
               unit = gsl_stats_quantile_from_sorted_data(sorted, 1, rows, 0.8413) - middle;
        for (size_t i = 0; i < rows && unit > 0.0; i++)
            square[i] += pow(fmax(spread[i] - middle, 0.0) / unit, 2.0);
    }
    free(spread);
}

struct misfit misfit_check(const struct fit_landings *list, const struct fit_result *answer,
                           uint64_t seed)
{
    size_t rows = 1 + answer->replica_count, out = 0;
    struct misfit misfit = {.replica_count = answer->replica_count};
    if (answer->replica_count < MISFIT_REPLICAS_MIN)
        return misfit;
    double *square = xcalloc(rows, sizeof *square);
    set_squared_distances(answer, rows, square);
    add_survey(list, seed, rows, square);
    for (size_t i = 0; i < rows; i++)
        out += square[i] >= square[0];
    free(square);
    misfit.is_checked = true;
    misfit.p_value = (double)out / (double)rows;
    misfit.is_rejected = misfit.p_value <= MISFIT_LEVEL;
    return misfit;
}

/* ---- landings of a campaign ---- */

enum mr_status fit_load_survey(struct store *store, int64_t run, bool after, int64_t board,
                               struct fit_survey *surveyed, struct error *error)
{
    static struct survey_results found;
    struct zones_slack told = {.surveyed_segment_count = 0};
    struct store_landing *rows = NULL;
    size_t count = 0;
    bool there = false;
    double squares = 0.0;
    int64_t from_us = INT64_MIN, to_us = INT64_MAX;
    *surveyed = (struct fit_survey){0};
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        told.slack_in[s] = NAN;
    if (store_landings_get(store, &rows, &count, error) != MR_OK)
        return error->status;
    for (size_t i = 0; i < count; i++) {
        if (rows[i].id < run + after)
            from_us = rows[i].armed_us > from_us ? rows[i].armed_us : from_us;
        else
            to_us = rows[i].armed_us < to_us ? rows[i].armed_us : to_us;
    }
    free(rows);
    if ((board != STORE_NONE && zones_load_survey(store, board, &told, error) != MR_OK) ||
        survey_evaluate_between(store, from_us, to_us, &found, &there, error) != MR_OK)
        return error->status;
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        const struct survey_estimate *read = &found.slack.segment[s];
        bool gage = there && !isnan(read->value_in);
        surveyed->sum_in[s] = gage ? read->value_in : (double)told.slack_in[s];
        surveyed->segment_count += isnan(surveyed->sum_in[s]) ? 0 : 1;
        surveyed->gage_segment_count += gage;
        squares += gage ? read->error_in * read->error_in : 0.0;
    }
    if (surveyed->gage_segment_count > 0)
        surveyed->error_in = sqrt(squares / (double)surveyed->gage_segment_count);
    return MR_OK;
}

#define SURVEY_RELATIVE_ERROR 0.03 /* same for all sums: gauge, length of closed joints */
#define UNLIMITED_SAMPLES     1e9

/* Returns the relative error of a movement that averaging over samples does not reduce. */
static double gain_error(const struct measured_landing *measured,
                         const struct measured_channel *channel, double baseline_in)
{
    double error_in = measured_standard_error(measured, channel, 1.0, UNLIMITED_SAMPLES);
    return isnan(error_in) ? 0.0 : sqrt(fmax(error_in * error_in - baseline_in * baseline_in, 0.0));
}

/* Copies the values of each channel after touchdown to `series`. Returns their number. */
static size_t collect_series(const struct measured_landing *measured,
                             struct fit_series series[MR_TRANSDUCERS], double *values)
{
    size_t count = 0, first = 0;
    while (first < measured->samples && measured_time_s(measured, first) < 0.0)
        first++;
    for (unsigned c = 0; c < MR_TRANSDUCERS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        if (channel->config.kind != MR_KIND_DISPLACEMENT || !channel->raw ||
            !isfinite(channel->baseline) || first >= measured->samples)
            continue;
        double *row = values + count * measured->samples;
        for (size_t i = first; i < measured->samples; i++)
            row[i - first] = measured_value(channel, i);
        /* blocks of one CAN message have the same mean, so their noise is not independent */
        double noise_in = channel->noise * sqrt((double)channel->stride);
        double baseline_in = noise_in / sqrt(fmax((double)channel->rest_samples, 1.0));
        series[count++] = (struct fit_series){
            .station_ft = (double)channel->config.station_ft,
            .t0_s = measured_time_s(measured, first),
            .dt_s = measured_time_s(measured, 1) - measured_time_s(measured, 0),
            .value_in = row,
            .count = measured->samples - first,
            .noise_in = noise_in,
            .baseline_error_in = baseline_in,
            .gain_error = gain_error(measured, channel, baseline_in),
        };
    }
    return count;
}

static bool is_survey_new(const struct fit_landing *landing, const struct fit_survey *after)
{
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(after->sum_in[s]) && !(fabs(after->sum_in[s] - landing->survey_in[s]) < 1e-9))
            return true;
    }
    return false;
}

static bool is_next(struct store *store, const struct store_landing *landing, int64_t before)
{
    struct store_landing previous;
    struct error ignored = {0};
    return store_landing_get(store, before, &previous, &ignored) == MR_OK &&
           landing->board_landing == previous.board_landing + 1 &&
           strcmp(landing->board_uid, previous.board_uid) == 0;
}

/* Loads the survey after a landing, which is the one before the next, if none is missing. */
static enum mr_status load_survey_after(struct store *store, const struct store_landing *now,
                                        struct fit_landing *landing, struct error *error)
{
    struct store_landing *rows;
    struct fit_survey after;
    size_t count;
    int64_t next = STORE_NONE;
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        landing->survey_after_in[s] = (double)NAN;
    if (store_landings_get(store, &rows, &count, error) != MR_OK)
        return error->status;
    for (size_t i = 0; i < count && next == STORE_NONE; i++)
        next = rows[i].id > now->id && is_next(store, &rows[i], now->id) ? rows[i].id : STORE_NONE;
    free(rows);
    if (fit_load_survey(store, now->id, true, next, &after, error) != MR_OK)
        return error->status;
    if (is_survey_new(landing, &after))
        memcpy(landing->survey_after_in, after.sum_in, sizeof landing->survey_after_in);
    landing->after_error_in = after.error_in;
    return MR_OK;
}

static enum mr_status load_landing(struct store *store, const struct measured_landing *measured,
                                   const char *scene_path, const struct fit_landings *list,
                                   struct fit_landing *landing, struct error *error)
{
    struct fit_survey before;
    const struct mr_gates_summary *summary = &measured->summary;
    landing->run = measured->landing.id;
    if (fit_load_survey(store, landing->run, false, landing->run, &before, error) != MR_OK)
        return error->status;
    memcpy(landing->survey_in, before.sum_in, sizeof landing->survey_in);
    landing->before_error_in = before.error_in;
    landing->gage_segment_count = before.gage_segment_count;
    landing->has_earlier_landings = measured->landing.board_landing > 1;
    struct zones_slack survey = {.surveyed_segment_count = (unsigned)before.segment_count};
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        survey.slack_in[s] = (float)before.sum_in[s];
    if (load_survey_after(store, &measured->landing, landing, error) != MR_OK ||
        sim_scene_load(&landing->scene, scene_path, error) != MR_OK)
        return error->status;
    enum mr_status status = compare_prepare_scene(measured, &survey, &landing->scene, error);
    if (status == MR_OK && landing->scene.model != SIM_MODEL_CHAIN)
        status = error_set(error, MR_USAGE,
                           "not of model chain: %s uses model %s; give a scene of model chain",
                           scene_path, sim_model_name(landing->scene.model));
    if (status != MR_OK) {
        sim_scene_free(&landing->scene);
        return status;
    }
    for (size_t i = 0; i < landing->scene.path_count; i++)
        landing->scene.path[i].force_lb *= COMPARE_RIG_STRIPS; /* from strip to aircraft */
    double roll_ft = summary->stop_station_ft.value - measured->landing.touchdown_ft;
    /* an error of the energy v0^2/2 is an error of the thrust over the stopping distance */
    landing->thrust_error = roll_ft > 0.0 ? summary->stop_station_ft.error / roll_ft : 0.0;
    landing->is_consecutive = list->count > 0 && is_next(store, &measured->landing,
                                                         list->landing[list->count - 1].run);
    return MR_OK;
}

enum mr_status fit_campaign_add(struct store *store, int64_t run, const char *scene_path,
                                struct fit_landings *list, struct error *error)
{
    struct measured_landing measured;
    struct fit_landing landing = {0};
    struct fit_series series[MR_TRANSDUCERS];
    char torn[MEASURED_MISSING_START_SIZE];
    enum mr_status status = measured_load(store, run, &measured, error);
    measured_format_missing_start(&measured, torn);
    if (status == MR_OK && torn[0])
        status = error_set(error, MR_USAGE, "RUN %lld is %s; leave that landing out",
                           (long long)run, torn);
    if (status == MR_OK)
        status = load_landing(store, &measured, scene_path, list, &landing, error);
    if (status == MR_OK) {
        double *values = xcalloc(measured.samples * MR_TRANSDUCERS + 1, sizeof *values);
        size_t count = collect_series(&measured, series, values);
        status = fit_landings_add(list, &landing, series, count, error);
        free(values);
        if (status != MR_OK)
            sim_scene_free(&landing.scene);
    }
    measured_free(&measured);
    return status;
}

size_t fit_campaign_set_gap(struct fit_landings *list)
{
    double sum_in = 0.0;
    size_t surveyed = 0;
    for (size_t s = 0; s < MR_SEGMENTS && list->count > 0; s++) {
        if (isnan(list->landing[0].survey_in[s]))
            continue;
        sum_in += list->landing[0].survey_in[s];
        surveyed++;
    }
    if (surveyed > 0 && sum_in > 0.0) {
        list->parameter[FIT_GAP].value = sum_in / (double)(surveyed * MR_MATS_PER_SEGMENT);
        list->parameter[FIT_GAP].spread = SURVEY_RELATIVE_ERROR;
    }
    return surveyed;
}
