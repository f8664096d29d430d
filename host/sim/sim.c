#include "host/sim/sim.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/base/cli.h"
#include "host/base/progress.h"
#include "host/sim/elements/mods.h"
#include "host/sim/solvers/chain.h"
#include "host/sim/solvers/planar.h"

bool sim_solver_is_missing(const char *solver)
{
    return strcmp(solver, "cvode") == 0 && !planar_has_solver(solver);
}

static enum mr_status check_options(const struct sim_scene *scene,
                                    const struct sim_options *options, struct error *error)
{
    double runway_ft = scene->mats * scene->length_ft,
           run_s = sim_scene_end_s(scene) - sim_scene_start_s(scene);
    bool chain = scene->model == SIM_MODEL_CHAIN;
    if (chain && options->solver && strcmp(options->solver, "staggered") != 0 &&
        strcmp(options->solver, "event") != 0 && strcmp(options->solver, "auto") != 0)
        return error_set(error, MR_USAGE,
                         "solver not available: %s for model chain; give event or staggered, or "
                         "leave --solver out",
                         options->solver);
    if (!chain && options->solver && !planar_has_solver(options->solver))
        return error_set(error, MR_USAGE,
                         "solver not available: %s for model %s; give auto, event, implicit, "
                         "cvode, rk4, rkgs, hamming or moreau",
                         options->solver, sim_model_name(scene->model));
    if (!(options->dt_s >= 0.0 && options->dt_s <= 1e6))
        return error_set(error, MR_USAGE, "step out of range: dt %g s; give 0 to 1e+06 s",
                         options->dt_s);
    if (!(options->time_limit_s >= 0.0))
        return error_set(error, MR_USAGE,
                         "computing limit out of range: %g s; give 0 (no limit) or more",
                         options->time_limit_s);
    if (options->rtol != 0.0 && !(options->rtol >= 1e-13 && options->rtol <= (chain ? 1.0 : 0.01)))
        return error_set(error, MR_USAGE, "tolerance out of range: rtol %g; give %s", options->rtol,
                         chain ? "1e-13 to 1" : "1e-13 to 0.01");
    if (!(options->sample_dt_s >= 0.0) ||
        (options->sample_dt_s > 0.0 && run_s / options->sample_dt_s > 1e7))
        return error_set(error, MR_USAGE,
                         "sampling interval out of range: %g s; give at most 1e7 samples",
                         options->sample_dt_s);
    for (size_t i = 0; i < options->station_count; i++) {
        if (!(options->station_ft[i] >= 0.0 && options->station_ft[i] <= runway_ft * (1.0 + 1e-9)))
            return error_set(error, MR_USAGE,
                             "no such station: %g ft; give at most %g ft, the length of the runway",
                             options->station_ft[i], runway_ft);
    }
    return MR_OK;
}

/* Writes the reason why a run failed, with mat and time, and what to do. */
static void format_reason(const struct sim_result *result, const struct sim_scene *scene, char *why,
                          size_t size)
{
    bool given = result->solver &&
                 (strcmp(result->solver, "staggered") == 0 || strcmp(result->solver, "rk4") == 0);
    bool underflow = result->status == SIM_STEP_UNDERFLOW;
    if (result->status == SIM_FOLDED)
        snprintf(why, size,
                 "the mat turned beyond 85 degrees; reduce the thrust, or give a smaller tend");
    else if (!given && underflow && scene->friction_law == SIM_FRICTION_SIGN &&
             scene->friction > 0.0)
        snprintf(why, size,
                 "the friction law sign chatters around rest; give friction stick, the exact form "
                 "of this law");
    else if (!given && underflow)
        snprintf(why, size,
                 "solver %s makes no progress; give another solver, a looser rtol or an earlier "
                 "tend",
                 result->solver);
    else if (!given)
        snprintf(why, size,
                 "solver %s gives different results at two tolerances; give a smaller rtol or "
                 "another solver",
                 result->solver);
    else if (underflow)
        snprintf(why, size,
                 "the runs still differ with a step of %g s; give --solver event, a larger rtol or "
                 "a smaller tend",
                 result->dt_s);
    else if (result->dt_s > result->dt_limit_s)
        snprintf(why, size,
                 "the step of %g s is beyond the stability limit of %g s; give a smaller dt",
                 result->dt_s, result->dt_limit_s);
    else
        snprintf(why, size, "the step of %g s fails its check; give a smaller dt, or rtol",
                 result->dt_s);
}

static void format_failure(const struct sim_result *result, const struct sim_scene *scene,
                           const struct deadline *deadline, struct error *error)
{
    const char *name = sim_scene_name(scene);
    char why[160];
    int nine = sim_time_digits(result->start_s, 9), six = sim_time_digits(result->start_s, 6);
    if (result->status == SIM_INTERRUPTED && deadline->is_exceeded) {
        error_set(
            error, MR_NUMERICS,
            "interrupted: %s: the run stopped at %.*g of %.*g s, by the computing limit of %g s; "
            "the result ends at that time; give a longer limit, an earlier tend or a looser rtol",
            name, nine, result->t_s, nine, result->t_end_s, deadline->caller_options->time_limit_s);
    } else if (result->status == SIM_INTERRUPTED) {
        error_set(
            error, MR_NUMERICS,
            "interrupted: %s: the run stopped at %.*g of %.*g s; the result ends at that time",
            name, nine, result->t_s, nine, result->t_end_s);
    } else if (result->status == SIM_UNPREDICTABLE) {
        error_set(error, MR_NUMERICS,
                  "unpredictable: %s: beyond %.*g s, first at mat %d, %d runs that should agree "
                  "diverge by up to %.2g ft of movement and %.2g ft of lift; give a smaller tend, "
                  "because a finer step does not help",
                  name, six, result->t_s, result->mat, result->diverging_run_count,
                  result->error_u_ft, result->error_lift_ft);
    } else {
        format_reason(result, scene, why, sizeof why);
        error_set(error, MR_NUMERICS, "%s: %s: mat %d at %.*g s: %s",
                  sim_status_name(result->status), name, result->mat, nine, result->t_s, why);
    }
}

/* Converts the times of a result, which the engines count from the start of the run, to times in
 * the scene. */
static void convert_to_scene_times(struct sim_result *result)
{
    result->t_s += result->start_s;
    result->t_end_s += result->start_s;
    for (size_t k = 0; k < result->output_count; k++)
        result->outputs[k].t_s += result->start_s;
}

/* Sets status and error of a finished run. If the run was stopped while it was being checked, the
 * result has no error estimate. */
static enum mr_status finish_result(struct sim_result *result, const struct sim_scene *scene,
                                    const struct deadline *deadline, struct error *error)
{
    if (error->status != MR_OK)
        return error->status;
    if (deadline->is_exceeded && result->status == SIM_OK)
        sim_result_set_status(result, SIM_INTERRUPTED, 1, result->t_end_s);
    if (result->status != SIM_OK)
        format_failure(result, scene, deadline, error);
    return error->status;
}

enum mr_status sim_run(const struct sim_scene *scene, const struct sim_options *options,
                       struct sim_result *result, struct error *error)
{
    const char *where = sim_scene_name(scene);
    struct deadline deadline;
    *result = (struct sim_result){0};
    deadline_begin(&deadline, options, options->time_limit_s);
    if (sim_scene_check(scene, where, error) != MR_OK ||
        check_options(scene, options, error) != MR_OK)
        return error->status;
    if (scene->model == SIM_MODEL_CHAIN && scene->friction_law != SIM_FRICTION_NONE &&
        scene->friction_normal == SIM_NORMAL_SOIL)
        return error_set(error, MR_USAGE,
                         "friction_normal is soil, but model chain has no soil: %s; set "
                         "friction_normal to weight",
                         where);
    struct sim_scene shifted;
    sim_scene_shift_times(&shifted, scene);
    result->start_s = sim_scene_start_s(scene);
    if (scene->model == SIM_MODEL_CHAIN)
        chain_run(&shifted, &deadline.options, result, error);
    else
        planar_run(&shifted, &deadline.options, result, error);
    sim_scene_shift_times_free(&shifted, scene);
    convert_to_scene_times(result);
    return finish_result(result, scene, &deadline, error);
}

bool sim_report_progress(void *progress, int pass, double part)
{
    progress_set(progress, "run %d is at %.0f %%", pass, 100.0 * part);
    return true;
}

/* ---- the answer of `matrig sim` ---- */

#define JSON_DIGITS 9

static json_t *numbers_to_json(const double *values, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, cli_json_number(values[i], JSON_DIGITS));
    return list;
}

static json_t *flagged_numbers_to_json(const double *flags, const double *names, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++) {
        if (flags[i] != 0.0)
            json_array_append_new(list, json_integer(names ? (json_int_t)names[i] : (json_int_t)i));
    }
    return list;
}

/* Adds one group of bands to the answer. Its values begin at `segment` and `connection` in the
 * arrays. */
static void add_band_group(struct answer *answer, int group, const struct mods_state *s,
                           size_t segment, size_t connection, size_t count)
{
    const struct {
        const char *name;
        json_t *list;
    } lists[] = {
        {"T0", numbers_to_json(s->band_lb + segment, count + 1)},
        {"least_lb", numbers_to_json(s->band_min_lb + segment, count + 1)},
        {"most_lb", numbers_to_json(s->band_max_lb + segment, count + 1)},
        {"mats", numbers_to_json(s->band_mat + connection, count)},
        {"load_lb", numbers_to_json(s->band_load_lb + connection, count)},
        {"slipped", numbers_to_json(s->band_slip_ft + connection, count)},
        {"pulled",
         flagged_numbers_to_json(s->band_pulled_out + connection, s->band_mat + connection, count)},
    };
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++) {
        char name[24];
        snprintf(name, sizeof name, "%s_%s", group == 0 ? "band" : "band2", lists[i].name);
        answer_add_json(answer, name, lists[i].list);
    }
}

static size_t find_extreme(const double *values, size_t count, double sign)
{
    size_t at = 0;
    for (size_t i = 1; i < count; i++)
        at = sign * values[i] > sign * values[at] ? i : at;
    return at;
}

static void add_bands(struct answer *answer, const struct mods_state *s)
{
    size_t least = find_extreme(s->band_min_lb, s->segment_count, -1.0),
           most = find_extreme(s->band_max_lb, s->segment_count, 1.0);
    size_t load = find_extreme(s->band_load_lb, s->connection_count, 1.0),
           slip = find_extreme(s->band_slip_ft, s->connection_count, 1.0);
    size_t slack = 0, out = 0;
    for (size_t i = 0; i < s->segment_count; i++)
        slack += s->band_min_lb[i] < 0.0;
    for (size_t i = 0; i < s->connection_count; i++)
        out += s->band_pulled_out[i] != 0.0;
    answer_add_value(answer, NULL, "least tension", UNIT_TENSION, fmax(0.0, s->band_min_lb[least]),
                     -4);
    answer_append_remark(answer, ", in segment %zu of %zu; %zu segments became slack", least + 1,
                         s->segment_count, slack);
    answer_add_value(answer, NULL, "largest tension", UNIT_TENSION, s->band_max_lb[most], -4);
    answer_append_remark(answer, ", in segment %zu", most + 1);
    answer_add_value(answer, "band_error", "error of tension", UNIT_TENSION, s->band_error_lb, -2)
        ->digits = JSON_DIGITS;
    answer_add_value(answer, NULL, "largest load", UNIT_TENSION, s->band_load_lb[load], -4);
    answer_append_remark(answer, ", at the connection at mat %.0f", s->band_mat[load]);
    answer_add_value(answer, NULL, "largest slip", UNIT_MOVEMENT, s->band_slip_ft[slip], -4);
    answer_append_remark(answer,
                         ", at the connection at mat %.0f; %zu of %zu connections pulled out",
                         s->band_mat[slip], out, s->connection_count);
}

static void add_cleats(struct answer *answer, const struct mods_state *s)
{
    size_t worst = find_extreme(s->cleat_remaining_share, s->cleat_count, -1.0);
    double sum = 0.0;
    for (size_t i = 0; i < s->cleat_count; i++)
        sum += s->cleat_remaining_share[i];
    answer_add_json(answer, "cleat_left",
                    numbers_to_json(s->cleat_remaining_share, s->cleat_count));
    answer_add_value(answer, NULL, "holding force of cleats", UNIT_NUMBER,
                     sum / (double)s->cleat_count, -3);
    answer_append_remark(answer, " of the initial force remains on average, %.3g on mat %.0f",
                         s->cleat_remaining_share[worst], s->cleat_mat[worst]);
}

static void add_restraints(struct answer *answer, const struct mods_state *s)
{
    size_t first = 0;
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; first += s->restraint_counts[k++]) {
        const char *kind = mods_restraint_name(k);
        const double *load_lb = s->restraint_load_lb + first, *at = s->restraint_places + first;
        size_t count = s->restraint_counts[k], most = find_extreme(load_lb, count, 1.0);
        char name[24];
        if (count == 0)
            continue;
        snprintf(name, sizeof name, "%s_zero", kind);
        answer_add_json(answer, name, numbers_to_json(s->restraint_zero_ft + first, count));
        snprintf(name, sizeof name, "%s_load_lb", kind);
        answer_add_json(answer, name, numbers_to_json(load_lb, count));
        snprintf(name, sizeof name, "largest %s load", kind);
        answer_add_value(answer, NULL, name, UNIT_TENSION, load_lb[most], -4);
        answer_append_remark(answer, ", at %s %.0f", k == SIM_ABSORBERS ? "joint" : "mat",
                             at[most]);
    }
}

/* Adds the modifications to the answer, under the name "mods". The JSON has the state as scene keys
 * (band_T0, band_slipped, band_pulled, cleat_left, torn) and the extremes of each part. Text has
 * the extremes over all parts. `state` NULL: there are no modifications, and nothing is added. */
static void add_mods(struct answer *answer, const struct sim_scene *scene,
                     const struct mods_state *s)
{
    size_t segment = 0, connection = 0, torn = 0;
    if (!s)
        return;
    answer_open_group(answer, "mods", "");
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        size_t count = (size_t)mods_connection_count(scene, g);
        if (count == 0)
            continue;
        add_band_group(answer, g, s, segment, connection, count);
        segment += count + 1;
        connection += count;
    }
    if (s->segment_count > 0)
        add_bands(answer, s);
    if (s->cleat_count > 0)
        add_cleats(answer, s);
    add_restraints(answer, s);
    for (size_t j = 1; j <= s->joint_count; j++)
        torn += s->torn[j] != 0.0;
    bool may_tear = scene->mods.tear_lb < HUGE_VAL;
    if (may_tear || scene->mods.torn.count > 0)
        answer_add_json(answer, "torn", flagged_numbers_to_json(s->torn, NULL, s->joint_count + 1));
    if (may_tear || torn > 0)
        answer_add_count(answer, NULL, "joints torn", (int64_t)torn);
    answer_close_group(answer);
}

#define PRINTED_MATS_MAX 12 /* largest number of mats that are printed */

size_t sim_output_mat_count(const struct sim_scene *scene)
{
    return scene->output_mats.count > 0 ? scene->output_mats.count : (size_t)scene->mats;
}

int sim_output_mat(const struct sim_scene *scene, size_t i)
{
    return scene->output_mats.count > 0 ? (int)scene->output_mats.values[i] : (int)i + 1;
}

static json_t *outputs_to_json(const struct sim_scene *scene, const struct sim_result *result)
{
    json_t *outputs = json_array();
    int twelve = sim_time_digits(result->start_s, 12);
    for (size_t k = 0; k < result->output_count; k++) {
        const struct sim_output *output = &result->outputs[k];
        json_t *u = json_object();
        for (size_t i = 0; i < sim_output_mat_count(scene); i++) {
            char key[16];
            int mat = sim_output_mat(scene, i);
            snprintf(key, sizeof key, "%d", mat);
            json_object_set_new(u, key, cli_json_number(output->u_ft[mat], 12));
        }
        json_array_append_new(outputs, json_pack("{s:o,s:o,s:o,s:i}", "t_s",
                                                 cli_json_number(output->t_s, twelve), "u_ft", u,
                                                 "lift_ft", cli_json_number(output->lift_ft, 12),
                                                 "lift_node", output->highest_node));
    }
    return outputs;
}

/* Adds the displacements at the output times. If the runway is long, text shows only every n-th
 * mat. */
static void add_outputs(struct answer *answer, const struct sim_scene *scene,
                        const struct sim_result *result)
{
    int every = scene->output_mats.count == 0
                  ? (scene->mats + PRINTED_MATS_MAX - 1) / PRINTED_MATS_MAX
                  : 1;
    answer_add_json(answer, "outputs", outputs_to_json(scene, result));
    for (size_t k = 0; k < result->output_count; k++) {
        char label[40];
        snprintf(label, sizeof label, "movement at %.*g s", sim_time_digits(result->start_s, 6),
                 result->outputs[k].t_s);
        answer_open_table(answer, NULL, label);
        for (size_t i = 0; i < sim_output_mat_count(scene); i++) {
            int mat = sim_output_mat(scene, i);
            if (every > 1 && (mat - 1) % every != 0)
                continue;
            answer_open_row(answer);
            answer_add_count(answer, NULL, "mat", mat);
            answer_add_value(answer, NULL, "station", UNIT_STATION, (mat - 1) * scene->length_ft,
                             2);
            answer_add_value(answer, NULL, "movement", UNIT_MOVEMENT, result->outputs[k].u_ft[mat],
                             6);
        }
        answer_close_group(answer);
    }
}

/* Returns the error estimate, or NaN (null in JSON) for a failed run. */
static double error_or_nan(const struct sim_result *result, double error)
{
    return result->status == SIM_OK || result->status == SIM_UNPREDICTABLE ||
                   (result->status != SIM_INTERRUPTED && error > 0.0)
             ? error
             : (double)NAN;
}

/* Adds the extremes to the answer. A failed run has none. For an interrupted run, only a wave that
 * has already occurred is reported. */
static void add_extremes(struct answer *answer, const struct sim_scene *scene,
                         const struct sim_result *result)
{
    bool interrupted = result->status == SIM_INTERRUPTED,
         unsure = result->status == SIM_UNPREDICTABLE,
         seen = result->status == SIM_OK || interrupted || unsure;
    bool lifts = scene->model != SIM_MODEL_CHAIN;
    answer_add_value(answer, NULL, "largest movement", UNIT_MOVEMENT, result->peak_u_ft, 4);
    answer_append_remark(answer, ", of mat %d", result->peak_mat);
    answer_add_value(answer, "max_lift", lifts ? "largest lift" : NULL, UNIT_MOVEMENT,
                     seen ? result->max_lift_ft : (double)NAN, 4)
        ->digits = 12;
    bool alike = unsure && (result->diverging_wave_count == 0 ||
                            result->diverging_wave_count == result->diverging_run_count);
    if (result->status == SIM_OK || alike || (interrupted && result->bow_wave))
        answer_add_flag(answer, "bow_wave", lifts ? "bow wave" : NULL, result->bow_wave);
    else
        answer_add_missing_value(answer, "bow_wave", lifts ? "bow wave" : NULL,
                                 unsure ? "in some runs" : "none yet");
    if (unsure) {
        answer_add_count(answer, "spread_runs", "runs", result->diverging_run_count);
        answer_add_count(answer, "spread_waves", lifts ? "runs with a bow wave" : NULL,
                         result->diverging_wave_count);
    }
    answer_open_group(answer, "error_estimate", interrupted ? NULL : "");
    answer_add_value(answer, "u", "error of movement", UNIT_MOVEMENT,
                     error_or_nan(result, result->error_u_ft), -2);
    answer_append_remark(answer, ", estimated by comparison with steps of %.4g s",
                         result->checked_dt_s);
    answer_add_value(answer, "lift", lifts ? "error of lift" : NULL, UNIT_MOVEMENT,
                     error_or_nan(result, result->error_lift_ft), -2);
    answer_close_group(answer);
    if (result->speed_end_ft_s > 0.0)
        answer_add_value(answer, NULL, "moving at the end", UNIT_SPEED, result->speed_end_ft_s, -3)
            ->suffix = " at most";
}

static void add_active_mats(struct answer *answer, const struct sim_result *result)
{
    answer_open_group(answer, "active", "integration");
    answer_add_value(answer, "mats_mean", "integrated mats, mean", UNIT_NUMBER,
                     result->integrated_mats_mean, 1);
    answer_add_count(answer, "mats_max", "integrated mats, max", result->integrated_mats_max);
    answer_add_value(answer, "dt", "longest step", UNIT_TIME, result->dt_s, -4)->digits = 9;
    answer_add_value(answer, "dt_limit", "stability limit", UNIT_TIME, result->dt_limit_s, -4)
        ->digits = 9;
    answer_add_value(answer, "checked_dt", NULL, UNIT_TIME, result->checked_dt_s, -4)->digits = 9;
    answer_add_value(answer, "pass_ms", "time of this run", UNIT_NUMBER, result->pass_ms, 1)
        ->suffix = " ms";
    answer_open_list(answer, "left_out", "left out");
    for (size_t i = 0; result->omitted_effects[i]; i++)
        answer_add_sentence(answer, NULL, "%s", result->omitted_effects[i]);
    answer_close_group(answer);
    answer_open_list(answer, "notes", "notes");
    for (size_t i = 0; result->notes[i][0]; i++)
        answer_add_sentence(answer, NULL, "%s", result->notes[i]);
    answer_close_group(answer);
    answer_close_group(answer);
}

struct answer *sim_to_answer(const struct sim_scene *scene, const struct sim_result *result,
                             bool si)
{
    struct answer *answer = answer_new(si);
    int twelve = sim_time_digits(result->start_s, 12), six = sim_time_digits(result->start_s, 6);
    answer_keep_units(answer);
    answer_add_text(answer, "scene", "scene", "%s", scene->name);
    answer_add_text(answer, "model", "model", "%s", sim_model_name(scene->model));
    answer_add_text(answer, "solver", "solver", "%s", result->solver);
    answer_add_text(answer, "status", "status", "%s", sim_status_name(result->status));
    if (result->status == SIM_INTERRUPTED)
        answer_append_remark(answer,
                             " at %.*g s; the results below are unchecked and end at this time",
                             six, result->t_s);
    if (result->status == SIM_UNPREDICTABLE)
        answer_append_remark(answer,
                             " beyond %.*g s, because runs with different steps disagree after "
                             "this time; the errors are the differences between these runs",
                             six, result->t_s);
    if (result->status != SIM_OK) {
        answer_add_count(answer, "mat", NULL, result->mat);
        answer_add_value(answer, "t", NULL, UNIT_TIME, result->t_s, -six)->digits = twelve;
    }
    answer_add_count(answer, NULL, "mats", result->mats);
    answer_add_value(answer, "t_end", "end", UNIT_TIME, result->t_end_s, -six)->digits = twelve;
    answer_add_value(answer, "run_ms", "computed in", UNIT_NUMBER, result->run_ms, 1)->suffix =
        " ms";
    answer_add_count(answer, "rhs", NULL, (int64_t)result->evaluations);
    answer_add_count(answer, "steps", "steps", (int64_t)result->steps);
    answer_add_count(answer, "rejected", NULL, (int64_t)result->other_steps);
    answer_add_count(answer, "events", NULL, (int64_t)result->events);
    add_extremes(answer, scene, result);
    add_mods(answer, scene, result->mods);
    add_outputs(answer, scene, result);
    add_active_mats(answer, result);
    return answer;
}
