#include "host/sim/sim_answer.h"

#include <math.h>
#include <stdio.h>

#include "host/base/cli.h"
#include "host/sim/mods_answer.h"

#define ROWS_MAX 12 /* of all mats, for people */

size_t sim_shown_count(const struct sim_scene *scene)
{
    return scene->u_mats.count > 0 ? scene->u_mats.count : (size_t)scene->mats;
}

int sim_shown_mat(const struct sim_scene *scene, size_t i)
{
    return scene->u_mats.count > 0 ? (int)scene->u_mats.values[i] : (int)i + 1;
}

static json_t *outputs_json(const struct sim_scene *scene, const struct sim_result *result)
{
    json_t *outputs = json_array();
    for (size_t k = 0; k < result->output_count; k++) {
        const struct sim_output *output = &result->outputs[k];
        json_t *u = json_object();
        for (size_t i = 0; i < sim_shown_count(scene); i++) {
            char key[16];
            int mat = sim_shown_mat(scene, i);
            snprintf(key, sizeof key, "%d", mat);
            json_object_set_new(u, key, cli_json_number(output->u_ft[mat], 12));
        }
        json_array_append_new(outputs, json_pack("{s:o,s:o,s:o,s:i}", "t_s",
                                                 cli_json_number(output->t_s, 12), "u_ft", u,
                                                 "lift_ft", cli_json_number(output->lift_ft, 12),
                                                 "lift_node", output->lift_node));
    }
    return outputs;
}

/* People see every so many of a long runway's mats. */
static void add_outputs(struct answer *answer, const struct sim_scene *scene,
                        const struct sim_result *result)
{
    int every = scene->u_mats.count == 0 ? (scene->mats + ROWS_MAX - 1) / ROWS_MAX : 1;
    answer_json_value(answer, "outputs", outputs_json(scene, result));
    for (size_t k = 0; k < result->output_count; k++) {
        char label[40];
        snprintf(label, sizeof label, "movement at %g s", result->outputs[k].t_s);
        answer_table(answer, NULL, label);
        for (size_t i = 0; i < sim_shown_count(scene); i++) {
            int mat = sim_shown_mat(scene, i);
            if (every > 1 && (mat - 1) % every != 0)
                continue;
            answer_row(answer);
            answer_count(answer, NULL, "mat", mat);
            answer_value(answer, NULL, "station", UNIT_STATION, (mat - 1) * scene->length_ft, 2);
            answer_value(answer, NULL, "movement", UNIT_MOVEMENT, result->outputs[k].u_ft[mat], 6);
        }
        answer_close(answer);
    }
}

/* NaN, null: a failed run that has none. */
static double estimate(const struct sim_result *result, double error)
{
    return result->status == SIM_OK || result->status == SIM_UNPREDICTABLE ||
                   (result->status != SIM_INTERRUPTED && error > 0.0)
             ? error
             : (double)NAN;
}

/* A run that failed has no verdict; one that was interrupted can only say that there is a wave
 * already. */
static void add_extremes(struct answer *answer, const struct sim_scene *scene,
                         const struct sim_result *result)
{
    bool interrupted = result->status == SIM_INTERRUPTED,
         unsure = result->status == SIM_UNPREDICTABLE,
         seen = result->status == SIM_OK || interrupted || unsure;
    bool lifts = scene->model != SIM_CHAIN;
    answer_value(answer, NULL, "largest movement", UNIT_MOVEMENT, result->peak_u_ft, 4);
    answer_remark(answer, ", of mat %d", result->peak_mat);
    answer_value(answer, "max_lift", lifts ? "largest lift" : NULL, UNIT_MOVEMENT,
                 seen ? result->max_lift_ft : (double)NAN, 4)
        ->digits = 12;
    bool alike = unsure &&
                 (result->spread_waves == 0 || result->spread_waves == result->spread_runs);
    if (result->status == SIM_OK || alike || (interrupted && result->bow_wave))
        answer_flag(answer, "bow_wave", lifts ? "bow wave" : NULL, result->bow_wave);
    else
        answer_none(answer, "bow_wave", lifts ? "bow wave" : NULL,
                    unsure ? "in some of the runs" : "none yet");
    if (unsure) {
        answer_count(answer, "spread_runs", "runs", result->spread_runs);
        answer_count(answer, "spread_waves", lifts ? "of them with a bow wave" : NULL,
                     result->spread_waves);
    }
    answer_open(answer, "error_estimate", interrupted ? NULL : "");
    answer_value(answer, "u", "error of movement", UNIT_MOVEMENT,
                 estimate(result, result->error_u_ft), -2);
    answer_remark(answer, ", estimated against steps of %.4g s", result->checked_dt_s);
    answer_value(answer, "lift", lifts ? "error of lift" : NULL, UNIT_MOVEMENT,
                 estimate(result, result->error_lift_ft), -2);
    answer_close(answer);
    if (result->speed_end_ft_s > 0.0)
        answer_value(answer, NULL, "moving at the end", UNIT_SPEED, result->speed_end_ft_s, -3)
            ->end = " at most";
}

static void add_active(struct answer *answer, const struct sim_result *result)
{
    answer_open(answer, "active", "integrated");
    answer_value(answer, "mats_mean", "mats on average", UNIT_NUMBER, result->mats_mean, 1);
    answer_count(answer, "mats_max", "mats at most", result->mats_max);
    answer_value(answer, "dt", "longest step", UNIT_TIME, result->dt_s, -4)->digits = 9;
    answer_value(answer, "dt_limit", "explicit limit", UNIT_TIME, result->dt_limit_s, -4)->digits =
        9;
    answer_value(answer, "checked_dt", NULL, UNIT_TIME, result->checked_dt_s, -4)->digits = 9;
    answer_value(answer, "pass_ms", "this pass took", UNIT_NUMBER, result->pass_ms, 1)->end = " ms";
    answer_list(answer, "left_out", "left out");
    for (size_t i = 0; result->left_out[i]; i++)
        answer_sentence(answer, NULL, "%s", result->left_out[i]);
    answer_close(answer);
    answer_list(answer, "notes", "notes");
    for (size_t i = 0; result->notes[i][0]; i++)
        answer_sentence(answer, NULL, "%s", result->notes[i]);
    answer_close(answer);
    answer_close(answer);
}

struct answer *sim_answer(const struct sim_scene *scene, const struct sim_result *result, bool si)
{
    struct answer *answer = answer_new(si);
    answer_as_given(answer);
    answer_words(answer, "scene", "scene", "%s", scene->name);
    answer_words(answer, "model", "model", "%s", sim_model_name(scene->model));
    answer_words(answer, "solver", "solver", "%s", result->solver);
    answer_words(answer, "status", "status", "%s", sim_status_name(result->status));
    if (result->status == SIM_INTERRUPTED)
        answer_remark(answer, " at %.6g s: what follows is unchecked and goes that far only",
                      result->t_s);
    if (result->status == SIM_UNPREDICTABLE)
        answer_remark(answer,
                      " beyond %.6g s: from then on the errors are the spread of runs that "
                      "should be alike",
                      result->t_s);
    if (result->status != SIM_OK) {
        answer_count(answer, "mat", NULL, result->mat);
        answer_value(answer, "t", NULL, UNIT_TIME, result->t_s, -6)->digits = 12;
    }
    answer_count(answer, NULL, "mats", result->mats);
    answer_value(answer, "t_end", "end", UNIT_TIME, result->t_end_s, -6)->digits = 12;
    answer_value(answer, "run_ms", "computed in", UNIT_NUMBER, result->run_ms, 1)->end = " ms";
    answer_count(answer, "rhs", NULL, (int64_t)result->rhs);
    answer_count(answer, "steps", "steps", (int64_t)result->steps);
    answer_count(answer, "rejected", NULL, (int64_t)result->rejected);
    answer_count(answer, "events", NULL, (int64_t)result->events);
    add_extremes(answer, scene, result);
    mods_answer(answer, scene, result->mods);
    add_outputs(answer, scene, result);
    add_active(answer, result);
    return answer;
}
