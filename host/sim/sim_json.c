#include "host/sim/sim_json.h"

#include <stdio.h>

#include "host/base/cli.h"
#include "host/sim/mods_show.h"

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
        json_array_append_new(outputs, json_pack("{s:o,s:o,s:o,s:i}", "t_s", cli_json_number(output->t_s, 12),
                                                 "u_ft", u, "lift_ft", cli_json_number(output->lift_ft, 12),
                                                 "lift_node", output->lift_node));
    }
    return outputs;
}

static json_t *active_json(const struct sim_result *result)
{
    json_t *left_out = json_array();
    json_t *notes = json_array();
    for (size_t i = 0; result->left_out[i]; i++)
        json_array_append_new(left_out, json_string(result->left_out[i]));
    for (size_t i = 0; result->notes[i][0]; i++)
        json_array_append_new(notes, json_string(result->notes[i]));
    return json_pack("{s:i,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "mats_max", result->mats_max, "mats_mean",
                     cli_json_number(result->mats_mean, 6), "dt_s", cli_json_number(result->dt_s, 9),
                     "dt_limit_s", cli_json_number(result->dt_limit_s, 9), "checked_dt_s",
                     cli_json_number(result->checked_dt_s, 9), "pass_ms", cli_json_number(result->pass_ms, 6),
                     "left_out", left_out, "notes", notes);
}

/* Null for a failed run that has none. */
static json_t *estimate_json(const struct sim_result *result, double error)
{
    return result->status == SIM_OK || (result->status != SIM_INTERRUPTED && error > 0.0) ? cli_json_number(error, 6) : json_null();
}

json_t *sim_result_json(const struct sim_scene *scene, const struct sim_result *result)
{
    json_t *object =
        json_pack("{s:s,s:s,s:s,s:s}", "scene", scene->name, "model", sim_model_name(scene->model), "solver",
                  result->solver, "status", sim_status_name(result->status));
    if (result->status != SIM_OK) {
        json_object_set_new(object, "mat", json_integer(result->mat));
        json_object_set_new(object, "t_s", cli_json_number(result->t_s, 12));
    }
    json_object_set_new(object, "t_end_s", cli_json_number(result->t_end_s, 12));
    json_object_set_new(object, "run_ms", cli_json_number(result->run_ms, 6));
    json_object_set_new(object, "rhs", json_integer((json_int_t)result->rhs));
    json_object_set_new(object, "steps", json_integer((json_int_t)result->steps));
    json_object_set_new(object, "rejected", json_integer((json_int_t)result->rejected));
    json_object_set_new(object, "events", json_integer((json_int_t)result->events));
    json_object_set_new(object, "error_estimate",
                        json_pack("{s:o,s:o}", "u_ft", estimate_json(result, result->error_u_ft), "lift_ft",
                                  estimate_json(result, result->error_lift_ft)));
    /* A run that failed has no verdict; one that was interrupted can only say that there is a wave already. */
    bool seen = result->status == SIM_OK || result->status == SIM_INTERRUPTED;
    bool verdict = result->status == SIM_OK || (seen && result->bow_wave);
    json_object_set_new(object, "max_lift_ft", seen ? cli_json_number(result->max_lift_ft, 12) : json_null());
    json_object_set_new(object, "bow_wave", verdict ? json_boolean(result->bow_wave) : json_null());
    if (result->mods)
        json_object_set_new(object, "mods", sim_mods_json(scene, result->mods));
    json_object_set_new(object, "outputs", outputs_json(scene, result));
    json_object_set_new(object, "active", active_json(result));
    return object;
}
