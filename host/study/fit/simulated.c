/* What is simulated of landings: joints and errors drawn, the chain run, statistics read. */
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/study/fit/beside.h"
#include "host/study/fit/landings.h"

#define IN_PER_FT       12.0
#define SAMPLE_S        0.002
#define HALVINGS        40
#define PAIRS_PER_JOINT 6 /* leaves half a percent of where it began */

/* Half of what gaps are uniform up to, for a mean of those that none beyond the slack leaves: s -
 * s^2/(4 m) with 2 m > s. All hooked: INFINITY. */
static double half_range_ft(double mean_ft, double slack_ft)
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

/* Scales gaps, none beyond the slack, to a sum: the factor by bisection. All closed, or wanted
 * wider than the slack: evenly. */
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
    for (int n = 0; n < HALVINGS; n++, high *= 2.0) {
        double reached = 0.0;
        for (size_t i = 0; i < count; i++)
            reached += fmin(high * fmax(gap_ft[i], 0.0), most_ft);
        if (reached >= sum_ft)
            break;
    }
    for (int n = 0; n < HALVINGS; n++) {
        double middle = 0.5 * (low + high), reached = 0.0;
        for (size_t i = 0; i < count; i++)
            reached += fmin(middle * fmax(gap_ft[i], 0.0), most_ft);
        *(reached < sum_ft ? &low : &high) = middle;
    }
    for (size_t i = 0; i < count; i++)
        gap_ft[i] = fmin(high * fmax(gap_ft[i], 0.0), most_ft);
}

/* Two gaps, uniform over 0 to `most` but none beyond the slack, drawn again with the sum they have:
 * both below the slack (evenly over what the sum allows), or one hooked at it (of weight 1 -
 * slack/most, against 1/most for each of the others). */
static void draw_pair(gsl_rng *random, double *one, double *other, double most_ft, double slack_ft)
{
    double limit = slack_ft > 0.0 ? fmin(most_ft, slack_ft) : most_ft, sum = *one + *other;
    double low = fmax(0.0, sum - limit), high = fmin(sum, limit);
    if (!(high > low))
        return; /* both hooked, or both closed */
    /* both times most^2 */
    double hooked = limit < most_ft && sum >= limit ? 2.0 * (most_ft - limit) : 0.0;
    double pick = gsl_rng_uniform(random) * (high - low + hooked);
    *one = pick < high - low ? low + pick : pick < high - low + 0.5 * hooked ? limit : sum - limit;
    *other = sum - *one;
}

/* Gibbs' sampler over pairs: gaps of a segment that are uniform, given their sum. Where the sum is
 * more than the mean leaves for it, up to twice the segment's own mean: the rest of the runway may
 * have been pushed together. */
static void draw_given_sum(gsl_rng *random, double *gap_ft, size_t count, double mean_ft,
                           double slack_ft)
{
    double sum_ft = 0.0;
    for (size_t i = 0; i < count; i++)
        sum_ft += gap_ft[i];
    double most_ft = 2.0 * half_range_ft(fmax(mean_ft, sum_ft / (double)count), slack_ft);
    if (isinf(most_ft))
        return; /* all hooked */
    for (size_t n = 0; n < PAIRS_PER_JOINT * count && count > 1; n++) {
        size_t i = gsl_rng_uniform_int(random, count), k = gsl_rng_uniform_int(random, count - 1);
        draw_pair(random, &gap_ft[i], &gap_ft[k < i ? k : k + 1], most_ft, slack_ft);
    }
}

/* Joint j, from 0, lies in the segment it begins or lies in (as in host/compare/). */
static size_t segment_joints(const struct sim_scene *scene, size_t segment, size_t *first)
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
    size_t first, count = segment_joints(scene, segment, &first);
    double sum_in = 0.0;
    for (size_t j = 0; j < count; j++)
        sum_in += IN_PER_FT * fmax(gap_ft[first + j], 0.0);
    return sum_in;
}

/* What one data set is simulated with. */
struct drawing {
    const struct fit_landings *list;
    gsl_rng *random;
    double value[FIT_KEYS];
    double *gap_ft, *grit_lb; /* joints 0 .. mats */
    struct sim_path_row *path;
    bool good;
};

/* What sums are, of what a survey reads: one gauge reads all. Without a survey the gap is no such
 * factor. */
static double gauge_of(const struct drawing *drawing)
{
    const struct fit_landings *list = drawing->list;
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(list->landing[0].survey_in[s]))
            return drawing->value[FIT_GAP] / list->parameter[FIT_GAP].value;
    }
    return 1.0;
}

static void draw_gaps(const struct drawing *drawing, const struct fit_landing *landing)
{
    const struct sim_scene *scene = &landing->scene;
    double half_ft = half_range_ft(drawing->value[FIT_GAP] / IN_PER_FT, scene->slack_ft);
    double gauge = gauge_of(drawing);
    double error_in = landing->survey_error_in > 0.0 ? landing->survey_error_in
                                                     : drawing->list->survey_error_in;
    for (int j = 0; j <= scene->mats && !landing->follows; j++)
        drawing->gap_ft[j] = draw_gap_ft(drawing->random, half_ft, scene->slack_ft);
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        size_t first, count = segment_joints(scene, s, &first);
        if (isnan(landing->survey_in[s]) || count == 0)
            continue;
        double sum_in = gauge * landing->survey_in[s] +
                        gsl_ran_gaussian_ziggurat(drawing->random, error_in);
        scale_gaps(drawing->gap_ft + first, count, sum_in / IN_PER_FT, scene->slack_ft);
        if (!landing->follows)
            draw_given_sum(drawing->random, drawing->gap_ft + first, count,
                           drawing->value[FIT_GAP] / IN_PER_FT, scene->slack_ft);
    }
}

void fit_landings_lay(const struct fit_landings *list, const struct fit_landing *landing,
                      gsl_rng *random, double sum_in[MR_SEGMENTS])
{
    const struct sim_scene *scene = &landing->scene;
    double half_ft = half_range_ft(list->parameter[FIT_GAP].value / IN_PER_FT, scene->slack_ft);
    double error_in = landing->survey_error_in > 0.0 ? landing->survey_error_in
                                                     : list->survey_error_in;
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        size_t first, count = segment_joints(scene, s, &first);
        sum_in[s] = gsl_ran_gaussian_ziggurat(random, error_in);
        for (size_t j = 0; j < count; j++)
            sum_in[s] += IN_PER_FT * draw_gap_ft(random, half_ft, scene->slack_ft);
        if (isnan(landing->survey_in[s]))
            sum_in[s] = (double)NAN;
    }
}

/* What one data set's landing came to. */
struct outcome {
    double *sample_u_ft; /* samples rows of the landing's channels, SAMPLE_S apart */
    size_t samples;
    const double *gap_ft; /* joints 0 .. mats, at the end */
};

static void read_statistics(const struct drawing *drawing, const struct fit_landing *landing,
                            const struct outcome *outcome, double *statistic)
{
    double gain[MR_TRANSDUCERS], baseline_in[MR_TRANSDUCERS];
    for (size_t c = 0; c < landing->channels; c++) {
        gain[c] = 1.0 + gsl_ran_gaussian_ziggurat(drawing->random, landing->channel[c].gain);
        baseline_in[c] = gsl_ran_gaussian_ziggurat(drawing->random,
                                                   landing->channel[c].baseline_in);
    }
    double after_error_in = landing->after_error_in > 0.0 ? landing->after_error_in
                                                          : drawing->list->survey_error_in;
    double gauge = gauge_of(drawing);
    for (size_t w = 0; w < landing->windows; w++) {
        const struct fit_window *window = &landing->window[w];
        if (window->channel == SIZE_MAX) {
            statistic[w] = segment_sum_in(&landing->scene, window->segment, outcome->gap_ft) /
                               gauge +
                           gsl_ran_gaussian_ziggurat(drawing->random, after_error_in);
            continue;
        }
        size_t c = window->channel, from = (size_t)ceil(window->from_s / SAMPLE_S),
               to = (size_t)ceil(window->to_s / SAMPLE_S);
        to = to > outcome->samples ? outcome->samples : to <= from ? from + 1 : to;
        double sum_in = 0.0;
        for (size_t k = from; k < to; k++)
            sum_in += IN_PER_FT * outcome->sample_u_ft[k * landing->channels + c];
        double noise_in = gsl_ran_gaussian_ziggurat(drawing->random, landing->channel[c].noise_in /
                                                                         sqrt(window->samples));
        statistic[w] = fit_bent(gain[c] * sum_in / (double)(to - from) + baseline_in[c] + noise_in);
    }
}

/* Share of the thrust that a landing's path puts on the strip. */
static double draw_thrust(const struct drawing *drawing, const struct fit_landing *landing)
{
    return drawing->value[FIT_SHARE] *
           (1.0 + gsl_ran_gaussian_ziggurat(drawing->random, landing->thrust_error));
}

/* By host/sim: what the chains side by side do not have. */
static bool run_alone(const struct drawing *drawing, const struct fit_landing *landing,
                      const double *station_ft, double thrust, struct outcome *outcome)
{
    struct sim_scene scene = landing->scene;
    struct sim_result result;
    struct error error = {0};
    memcpy(drawing->path, scene.path, scene.path_count * sizeof *drawing->path);
    for (size_t i = 0; i < scene.path_count; i++)
        drawing->path[i].force_lb *= thrust;
    scene.path = drawing->path;
    scene.gap0_ft = (struct sim_list){drawing->gap_ft, (size_t)scene.mats + 1};
    scene.grit_lb = (struct sim_list){drawing->grit_lb, (size_t)scene.mats + 1};
    scene.friction = drawing->value[FIT_FRICTION];
    scene.kl_lb_ft = drawing->value[FIT_STIFFNESS];
    struct sim_options options = {
        .sample_dt_s = SAMPLE_S, .station_ft = station_ft, .station_count = landing->channels};
    bool good = sim_run(&scene, &options, &result, &error) == MR_OK;
    outcome->samples = good && result.sample_count < outcome->samples ? result.sample_count
                                                                      : outcome->samples;
    if (good)
        memcpy(outcome->sample_u_ft, result.sample_u_ft,
               outcome->samples * landing->channels * sizeof(double));
    for (int j = 0; good && j <= scene.mats; j++)
        drawing->gap_ft[j] = fmax(result.gap_ft[j + 1], 0.0);
    sim_result_free(&result);
    return good;
}

/* Side by side; lanes that are left over repeat the first drawing. */
static bool run_beside(struct drawing *drawing, size_t count, const struct fit_landing *landing,
                       const double *station_ft, const double *thrust, double *spare_gap_ft,
                       struct outcome *outcome)
{
    struct beside_lane lane[CHAINS_LANES];
    size_t joints = (size_t)landing->scene.mats + 1;
    for (size_t k = 0; k < CHAINS_LANES; k++) {
        size_t of = k < count ? k : 0;
        lane[k] = (struct beside_lane){.gap_ft = drawing[of].gap_ft,
                                       .grit_lb = drawing[of].grit_lb,
                                       .friction = drawing[of].value[FIT_FRICTION],
                                       .kl_lb_ft = drawing[of].value[FIT_STIFFNESS],
                                       .thrust = thrust[of],
                                       .sample_u_ft = outcome[k].sample_u_ft};
        if (k >= count) {
            memcpy(spare_gap_ft + k * joints, drawing[0].gap_ft, joints * sizeof(double));
            lane[k].gap_ft = spare_gap_ft + k * joints;
        }
    }
    bool good = beside_run(&landing->scene, station_ft, landing->channels, SAMPLE_S, lane);
    for (size_t k = 0; k < count; k++)
        drawing[k].good = drawing[k].good && good && lane[k].good;
    return good;
}

static bool simulate_landing(struct drawing *drawing, size_t count,
                             const struct fit_landing *landing, double *statistic)
{
    struct outcome outcome[CHAINS_LANES];
    double station_ft[MR_TRANSDUCERS], thrust[CHAINS_LANES];
    size_t samples = beside_samples(&landing->scene, SAMPLE_S),
           joints = (size_t)landing->scene.mats + 1, each = samples * landing->channels;
    double *room = calloc(CHAINS_LANES * (each + joints), sizeof *room);
    if (!room)
        return false;
    for (size_t c = 0; c < landing->channels; c++)
        station_ft[c] = landing->channel[c].station_ft;
    for (size_t k = 0; k < CHAINS_LANES; k++)
        outcome[k] = (struct outcome){.sample_u_ft = room + k * each, .samples = samples};
    for (size_t k = 0; k < count; k++) {
        thrust[k] = draw_thrust(&drawing[k], landing);
        draw_gaps(&drawing[k], landing);
        outcome[k].gap_ft = drawing[k].gap_ft;
    }
    if (beside_can(&landing->scene)) {
        run_beside(drawing, count, landing, station_ft, thrust, room + CHAINS_LANES * each,
                   outcome);
    } else {
        for (size_t k = 0; k < count; k++)
            drawing[k].good = drawing[k].good &&
                              run_alone(&drawing[k], landing, station_ft, thrust[k], &outcome[k]);
    }
    for (size_t k = 0; k < count; k++) {
        if (drawing[k].good)
            read_statistics(&drawing[k], landing, &outcome[k],
                            statistic + k * drawing->list->statistics + landing->first);
    }
    free(room);
    return true;
}

/* Closing resistances and room for the rest; end_drawing in any case. */
static bool begin_drawing(struct drawing *drawing, const struct fit_landings *list, const double *z,
                          uint64_t draw)
{
    size_t joints = 0, rows = 0;
    *drawing = (struct drawing){.list = list, .good = true, .random = gsl_rng_alloc(gsl_rng_taus2)};
    for (size_t l = 0; l < list->count; l++) {
        joints = joints > (size_t)list->landing[l].scene.mats + 1
                   ? joints
                   : (size_t)list->landing[l].scene.mats + 1;
        rows = rows > list->landing[l].scene.path_count ? rows : list->landing[l].scene.path_count;
    }
    drawing->gap_ft = calloc(joints, sizeof(double));
    drawing->grit_lb = calloc(joints, sizeof(double));
    drawing->path = calloc(rows, sizeof *drawing->path);
    if (!drawing->random || !drawing->gap_ft || !drawing->grit_lb || !drawing->path)
        return false;
    gsl_rng_set(drawing->random, (unsigned long)(draw ^ draw >> 32) & 0xffffffffu);
    fit_landings_values(list, z, drawing->value);
    for (size_t j = 0; j < joints; j++)
        drawing->grit_lb[j] = 2.0 * drawing->value[FIT_GRIT] * gsl_rng_uniform(drawing->random);
    return true;
}

static void end_drawing(struct drawing *drawing)
{
    free(drawing->gap_ft);
    free(drawing->grit_lb);
    free(drawing->path);
    if (drawing->random)
        gsl_rng_free(drawing->random);
}

static void simulate_some(const void *context, size_t count, const double *z, const uint64_t *draw,
                          double *statistic, bool *good)
{
    const struct fit_landings *list = context;
    struct drawing drawing[FIT_SOME];
    enum fit_key key[FIT_KEYS];
    size_t fitted = fit_landings_fitted(list, key);
    bool ready = true;
    for (size_t k = 0; k < count; k++)
        ready = begin_drawing(&drawing[k], list, z + k * fitted, draw[k]) && ready;
    for (size_t l = 0; l < list->count && ready; l++)
        ready = simulate_landing(drawing, count, &list->landing[l], statistic);
    for (size_t k = 0; k < count; k++) {
        good[k] = ready && drawing[k].good;
        end_drawing(&drawing[k]);
    }
}

static bool simulate(const void *context, const double *z, uint64_t draw, double *statistic)
{
    bool good;
    simulate_some(context, 1, z, &draw, statistic, &good);
    return good;
}

bool fit_landings_joints(const struct fit_landings *list, const double *z, uint64_t draw,
                         struct sim_scene *scene, double *share, struct error *error)
{
    struct drawing drawing;
    size_t joints = (size_t)scene->mats + 1;
    bool good = begin_drawing(&drawing, list, z, draw);
    if (good) {
        *share = draw_thrust(&drawing, &list->landing[0]);
        draw_gaps(&drawing, &list->landing[0]);
        good = sim_scene_set_list(&scene->gap0_ft, drawing.gap_ft, joints, error) == MR_OK &&
               sim_scene_set_list(&scene->grit_lb, drawing.grit_lb, joints, error) == MR_OK;
    } else {
        error_set(error, MR_FULL, "no memory: joints of %zu mats; fit fewer landings", joints);
    }
    end_drawing(&drawing);
    return good;
}

struct fit_model fit_landings_model(const struct fit_landings *list)
{
    enum fit_key key[FIT_KEYS];
    return (struct fit_model){fit_landings_fitted(list, key), list->statistics, simulate, list,
                              simulate_some};
}
