#include "host/sim/solvers/landing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"
#include "host/sim/solvers/pass.h"
#include "host/sim/solvers/planar_engine.h"
#include "host/sim/elements/law.h"

#define FIRST_STEP_SHARE        0.25  /* first step / stability limit, if no step is given */
#define CROSSED_MAT_SHARE_MAX   0.25  /* part of a mat that the aircraft may cross in one step */
#define SHORTEST_TIME_SHARE_MAX 0.125 /* step / shortest time that a step must resolve */
/* Largest product of step and fastest rate. The scheme is stable up to 2 for an undamped
 * oscillation and up to less with damping. */
#define STABILITY_LIMIT         1.8
#define MIN_STEPS               1000.0
#define MAX_STEPS               1e8
#define MAX_STEP_REDUCTIONS     4
/* Error estimate / difference of two marches (a march is a run with one step size,
 * planar_engine.h). The scheme is of order 1, so the error of the finer march is about as large as
 * the difference. */
#define ERROR_FACTOR            2.0
/* Ratio of the steps of two marches. With the ratio 2, every second short step would end together
 * with a long one, and both marches would sample these switches at the same moment. */
#define STEP_RATIO              1.9
/* Step of a fourth march divided by the finest step. It is between the steps of the marches
 * `coarse` and `rough`. */
#define FOURTH_STEP_RATIO       2.6
/* step of the additional march for a sensitive result / finest step */
#define SENSITIVE_STEP_RATIO    1.37
/* A result is sensitive if its error estimate exceeds this fraction of the largest movement or
 * lift. */
#define SENSITIVE_ERROR_MIN     1e-3
/* Factor on the error estimate of a sensitive result. It was 1.5 until the scene of random seed
 * 930973 exceeded its estimate. */
#define SENSITIVE_ERROR_FACTOR  2.0

/* Smallest error estimate, as a fraction of the largest movement or lift, because all marches miss
 * a contact shorter than their steps. Introduced after such a contact in scene 219 of random seed
 * 940556. */
#define ERROR_SHARE_MIN 1e-4

static void free_march(struct march *march)
{
    sim_record_free(&march->record);
    free(march->mods);
    *march = (struct march){0};
}

/* Clears a march whose arrays were moved to another march. */
static void clear_moved_march(struct march *march)
{
    march->record = (struct sim_record){0};
    march->mods = NULL;
}

static void start_march(struct planar_engine *l, struct march *march,
                        const struct sim_options *options, uint64_t steps,
                        struct sim_result *result)
{
    *march = (struct march){.step_count = steps,
                            .h_s = sim_scene_end_s(l->scene) / (double)steps,
                            .pass_number = ++result->pass_count};
    sim_record_make(&march->record, l->scene, options);
    planar_engine_run(l, march, options);
    result->evaluations += march->completed_step_count;
}

static double *copy_array(const double *from, size_t count)
{
    double *copy = xcalloc(count + 1, sizeof *copy);
    memcpy(copy + 1, from, count * sizeof *copy);
    return copy;
}

static void fill_result(struct planar_engine *l, struct march *fine, const struct march *coarse,
                        struct sim_result *result)
{
    result->dt_s = fine->h_s;
    result->checked_dt_s = coarse->h_s;
    result->pass_ms = fine->ms;
    result->steps = fine->completed_step_count;
    result->other_steps = result->evaluations - fine->completed_step_count;
    result->events = fine->events;
    result->integrated_mats_max = fine->active_mats_max;
    result->integrated_mats_mean = fine->active_mat_time_s /
                                   ((double)fine->completed_step_count * fine->h_s);
    result->crest_deg = fine->crest_deg;
    result->crest_joint = fine->crest_joint;
    result->sag_deg = fine->sag_deg;
    result->sag_joint = fine->sag_joint;
    result->wave_encounter_count = fine->wave_encounter_count;
    result->first_crest_node = fine->first_crest_node;
    result->first_crest_wheel_mat = fine->first_crest_wheel_mat;
    memcpy(result->wave_encounter_nodes, fine->wave_encounter_nodes,
           sizeof result->wave_encounter_nodes);
    size_t joints = (size_t)l->model.mats + 1;
    result->max_compression_lb = copy_array(l->max_compression_lb, joints);
    result->max_tension_lb = copy_array(l->max_tension_lb, joints);
    result->max_rise_ft = copy_array(l->max_rise_ft, joints);
    if (fine->mods && coarse->mods)
        fine->mods->band_error_lb = ERROR_FACTOR * mods_difference_lb(fine->mods, coarse->mods);
    result->mods = fine->mods;
    fine->mods = NULL;
    pass_fill_outputs(&l->model, l->z, &fine->record, fine->max_lift_ft, fine->speed_end_ft_s,
                      result);
}

/* Difference of two marches. */
static struct pass_difference march_difference(const struct march *a, const struct march *b)
{
    return (struct pass_difference){sim_record_difference(&a->record, &b->record),
                                    fmax(sim_record_lift_difference(&a->record, &b->record),
                                         fabs(a->max_lift_ft - b->max_lift_ft))};
}

/* True if two complete marches agree. */
static bool marches_agree(const struct planar_engine *l, const struct march *coarse,
                          const struct march *fine)
{
    struct pass_difference apart = march_difference(coarse, fine);
    double threshold = pass_bow_threshold_ft(l->scene),
           lift = fmin(coarse->max_lift_ft, fine->max_lift_ft);
    return apart.u.u_ft <= PASS_DISAGREEMENT_MAX * sim_record_peak(&fine->record).u_ft +
                               1e-9 * l->model.length_ft &&
           apart.lift_ft <= PASS_DISAGREEMENT_MAX * fmax(lift, threshold) &&
           (coarse->max_lift_ft > threshold) == (fine->max_lift_ft > threshold);
}

static bool is_march_complete(const struct march *march)
{
    return march->completed_step_count > 0 && march->status == SIM_OK;
}

static void widen_error(struct sim_result *result, struct pass_difference apart)
{
    result->error_u_ft = fmax(result->error_u_ft, apart.u.u_ft);
    result->error_lift_ft = fmax(result->error_lift_ft, apart.lift_ft);
}

/* Computes the error estimate. Each step size samples the switches at other times, so two marches
 * can agree by chance. If the previous march agrees with both, its difference is included too. */
static void set_march_error(const struct planar_engine *l, const struct march *rough,
                            const struct march *coarse, const struct march *fine,
                            struct pass_difference apart, struct sim_result *result)
{
    result->error_u_ft = ERROR_FACTOR * apart.u.u_ft;
    /* The landing of a node is found up to one step late; all marches have this error in common. */
    result->error_lift_ft = fmax(ERROR_FACTOR * apart.lift_ft, fine->h_s * fine->impact_ft_s);
    if (!is_march_complete(rough))
        return;
    struct pass_difference before = march_difference(rough, coarse);
    if (marches_agree(l, rough, coarse))
        widen_error(result, before);
}

/* Runs one more march on a copy of `l`, because the state in `l` belongs to the result. */
static void run_extra_march(struct planar_engine *l, struct march *march,
                            const struct sim_options *options, uint64_t steps,
                            struct sim_result *result)
{
    double *kept = xmalloc(l->stored_value_count * sizeof *kept);
    memcpy(kept, l->z, l->stored_value_count * sizeof *kept);
    start_march(l, march, options, steps, result);
    memcpy(l->z, kept, l->stored_value_count * sizeof *kept);
    free(kept);
}

/* Increases the estimate to the largest difference of any two marches that agree. Three marches
 * agree by chance in one of a hundred cases, so this function runs a fourth march with a step
 * between theirs. */
static void widen_error_by_fourth_march(struct planar_engine *l, const struct sim_options *options,
                                        const struct march *rough, const struct march *coarse,
                                        const struct march *fine, struct sim_result *result)
{
    struct march between = {0};
    uint64_t steps = (uint64_t)ceil((double)fine->step_count / FOURTH_STEP_RATIO);
    if (sim_scene_end_s(l->scene) / (double)steps > result->dt_limit_s)
        return;
    run_extra_march(l, &between, options, steps, result);
    if (is_march_complete(&between)) {
        const struct march *const others[] = {fine, coarse, rough};
        for (int i = 0; i < 3; i++) {
            struct pass_difference apart = {0};
            if (is_march_complete(others[i]))
                apart = march_difference(&between, others[i]);
            if (is_march_complete(others[i]) && marches_agree(l, &between, others[i]))
                widen_error(result, apart);
        }
        if (is_march_complete(rough)) {
            if (marches_agree(l, rough, fine))
                widen_error(result, march_difference(rough, fine));
        }
    }
    free_march(&between);
}

/* If the result is sensitive, increases its error estimate by one more march with another step. A
 * result is sensitive if its estimate is not small compared with the movement, because then it
 * depends on the switches. */
static void widen_error_if_sensitive(struct planar_engine *l, const struct sim_options *options,
                                     const struct march *fine, struct sim_result *result)
{
    struct march beside = {0};
    if (result->error_u_ft <= SENSITIVE_ERROR_MIN * sim_record_peak(&fine->record).u_ft &&
        result->error_lift_ft <= SENSITIVE_ERROR_MIN * fine->max_lift_ft)
        return;
    uint64_t steps = (uint64_t)ceil((double)fine->step_count / SENSITIVE_STEP_RATIO);
    run_extra_march(l, &beside, options, steps, result);
    if (is_march_complete(&beside)) {
        struct pass_difference apart = march_difference(&beside, fine);
        result->error_u_ft = SENSITIVE_ERROR_FACTOR *
                             fmax(result->error_u_ft, ERROR_FACTOR * apart.u.u_ft);
        result->error_lift_ft = SENSITIVE_ERROR_FACTOR *
                                fmax(result->error_lift_ft, ERROR_FACTOR * apart.lift_ft);
    }
    free_march(&beside);
}

/* Sets the divergence of the result from the marches so far. Called if no shorter step leads to
 * agreement. */
static void set_march_divergence(const struct planar_engine *l, const struct march *rough,
                                 const struct march *coarse, const struct march *fine,
                                 struct sim_result *result)
{
    const struct march *others[] = {coarse, rough};
    double threshold = pass_bow_threshold_ft(l->scene);
    double most_u_ft = PASS_DISAGREEMENT_MAX * sim_record_peak(&fine->record).u_ft,
           most_lift_ft = PASS_DISAGREEMENT_MAX * fmax(fine->max_lift_ft, threshold);
    result->diverging_run_count = 1;
    result->diverging_wave_count = fine->max_lift_ft > threshold;
    for (int i = 0; i < 2; i++) {
        if (!is_march_complete(others[i]))
            continue;
        struct pass_difference apart = march_difference(fine, others[i]);
        pass_find_divergence(result, &fine->record, &others[i]->record, most_u_ft, most_lift_ft);
        result->error_u_ft = fmax(result->error_u_ft, ERROR_FACTOR * apart.u.u_ft);
        result->error_lift_ft = fmax(result->error_lift_ft, ERROR_FACTOR * apart.lift_ft);
        result->diverging_run_count++;
        result->diverging_wave_count += others[i]->max_lift_ft > threshold;
    }
}

static uint64_t coarser_step_count(uint64_t steps)
{
    return (uint64_t)ceil((double)steps / STEP_RATIO);
}

/* Runs a march with a step and one with a longer step, then shorter ones until two agree. `rough`:
 * the march with the next longer step; empty: none. */
static void run_march_pairs(struct planar_engine *l, const struct sim_options *options,
                            uint64_t steps, struct march *rough, struct sim_result *result)
{
    struct march coarse = {0}, fine = {0};
    struct pass_difference apart = {0};
    start_march(l, &coarse, options, coarser_step_count(steps), result);
    for (int shortened = 0;; shortened++) {
        if (coarse.status == SIM_INTERRUPTED) {
            sim_result_set_status(result, coarse.status, coarse.mat, coarse.t_s);
            fine = coarse;
            clear_moved_march(&coarse);
            break;
        }
        start_march(l, &fine, options, steps, result);
        if (fine.status == SIM_INTERRUPTED) {
            sim_result_set_status(result, fine.status, fine.mat, fine.t_s);
            break;
        }
        const struct march *failed = fine.status != SIM_OK   ? &fine
                                   : coarse.status != SIM_OK ? &coarse
                                                             : NULL;
        if (fine.status != SIM_OK && fine.status == coarse.status) {
            sim_result_set_status(result, fine.status, fine.mat, fine.t_s);
            break;
        }
        apart = failed ? apart : march_difference(&coarse, &fine);
        if (!failed && marches_agree(l, &coarse, &fine)) {
            set_march_error(l, rough, &coarse, &fine, apart, result);
            widen_error_by_fourth_march(l, options, rough, &coarse, &fine, result);
            widen_error_if_sensitive(l, options, &fine, result);
            result->error_u_ft = fmax(result->error_u_ft,
                                      ERROR_SHARE_MIN * sim_record_peak(&fine.record).u_ft);
            result->error_lift_ft = fmax(result->error_lift_ft, ERROR_SHARE_MIN * fine.max_lift_ft);
            break;
        }
        if (options->dt_s > 0.0 || shortened == MAX_STEP_REDUCTIONS ||
            STEP_RATIO * (double)steps > MAX_STEPS) {
            if (failed)
                sim_result_set_status(result, failed->status, failed->mat, failed->t_s);
            else if (options->dt_s > 0.0)
                sim_result_set_status(result, SIM_UNSTABLE, apart.u.mat, apart.u.t_s);
            else
                set_march_divergence(l, rough, &coarse, &fine, result);
            break;
        }
        free_march(rough);
        *rough = coarse;
        coarse = fine;
        steps = (uint64_t)ceil(STEP_RATIO * (double)steps);
        clear_moved_march(&fine);
    }
    fill_result(l, &fine, &coarse, result);
    free_march(&coarse);
    free_march(&fine);
}

/* Runs marches with the given step and with two longer ones. The longest step is used only if it is
 * stable. */
static void run_given_step(struct planar_engine *l, const struct sim_options *options,
                           uint64_t steps, struct sim_result *result)
{
    struct march rough = {0};
    uint64_t fewest = coarser_step_count(coarser_step_count(steps));
    bool stable = sim_scene_end_s(l->scene) / (double)fewest <= result->dt_limit_s;
    if (stable)
        start_march(l, &rough, options, fewest, result);
    if (rough.status == SIM_INTERRUPTED) {
        sim_result_set_status(result, rough.status, rough.mat, rough.t_s);
        fill_result(l, &rough, &rough, result);
    } else {
        run_march_pairs(l, options, steps, &rough, result);
    }
    free_march(&rough);
}

static double stable_step_limit_s(struct planar_engine *l, double crossing_s)
{
    struct model *m = &l->model;
    model_start(m, l->z);
    /* an upper bound on the rate: the largest stiffness for every joint and the smallest mass for
     * every mat */
    struct model fastest = *m;
    double lightest = sim_scene_step_limiting_value(l->scene, SIM_VARIED_W, m->weight_lb) /
                      m->weight_lb;
    fastest.kv_lb_ft = sim_scene_step_limiting_value(l->scene, SIM_VARIED_KV, m->kv_lb_ft);
    fastest.kl_lb_ft = sim_scene_step_limiting_value(l->scene, SIM_VARIED_KL, m->kl_lb_ft);
    fastest.kt_lb_ft_rad = sim_scene_step_limiting_value(l->scene, SIM_VARIED_KT, m->kt_lb_ft_rad);
    fastest.mass_slug *= lightest;
    fastest.inertia_slug_ft2 *= lightest;
    double rate = model_fastest_rate(&fastest, l->z, MODEL_RATE_STAGGERED);
    if (l->mods)
        rate = sqrt(rate * rate +
                    mods_rate_squared(l->mods, fastest.mass_slug, fastest.inertia_slug_ft2));
    return fmin(rate > 0.0 ? STABILITY_LIMIT / rate : HUGE_VAL, crossing_s);
}

static enum mr_status run_engine(struct planar_engine *l, const struct sim_options *options,
                                 struct sim_result *result, struct error *error)
{
    struct sim_wheel wheel;
    double end_s = sim_scene_end_s(l->scene);
    sim_wheel_start(&wheel, l->scene);
    /* INFINITY if the aircraft is at rest */
    double crossing_s = l->scene->length_ft / sim_wheel_max_speed_ft_s(&wheel);
    result->dt_limit_s = stable_step_limit_s(l, crossing_s);
    double h =
        options->dt_s > 0.0
            ? options->dt_s
            : fmin((options->is_single_pass ? 2.0 : 1.0) * FIRST_STEP_SHARE * result->dt_limit_s,
                   fmin(fmin(CROSSED_MAT_SHARE_MAX * crossing_s, end_s / MIN_STEPS),
                        SHORTEST_TIME_SHARE_MAX * sim_scene_shortest_time_s(l->scene)));
    double steps = ceil(end_s / h * (1.0 - 1e-12));
    if (h > result->dt_limit_s) {
        result->dt_s = h;
        sim_result_set_status(result, SIM_UNSTABLE, sim_wheel_first_mat(&wheel), 0.0);
        return MR_OK;
    }
    if (!(steps <= MAX_STEPS))
        return error_set(error, MR_USAGE,
                         "too many steps: %s: tend is %g s and the step is %g s; give a smaller "
                         "tend, a larger dt or --solver implicit",
                         sim_scene_name(l->scene), end_s, h);
    if (options->is_single_pass) {
        struct march only = {0};
        start_march(l, &only, options, (uint64_t)steps, result);
        result->first_crest_node = only.first_crest_node;
        result->first_crest_wheel_mat = only.first_crest_wheel_mat;
        if (only.status != SIM_OK)
            sim_result_set_status(result, only.status, only.mat, only.t_s);
        result->t_end_s = fmin(result->t_end_s, (double)only.completed_step_count * only.h_s);
        fill_result(l, &only, &only, result);
        free_march(&only);
        return error->status;
    }
    /* true if the march with double the step, used as check, is stable too */
    bool room = 2.0 * h <= result->dt_limit_s;
    run_given_step(l, options, 2 * (uint64_t)ceil(room ? steps / 2.0 : steps), result);
    return MR_OK;
}

enum mr_status landing_run(const struct sim_scene *scene, const struct sim_options *options,
                           struct sim_result *result, struct error *error)
{
    struct planar_engine l = {0};
    double begin_s = monotonic_s();
    if (planar_engine_make(&l, scene, result, error) == MR_OK) {
        result->solver = "staggered";
        result->mats = scene->mats;
        result->t_end_s = sim_scene_end_s(scene);
        sim_result_add_note(result,
                            "error estimate: largest difference between runs at 1, 1.9, 2.6 and "
                            "3.6 times the step, with a weight of 2 for the first two");
        if (l.mods)
            mods_describe(l.mods, result);
        run_engine(&l, options, result, error);
        result->run_ms = 1e3 * (monotonic_s() - begin_s);
    }
    planar_engine_free(&l);
    return error->status;
}
