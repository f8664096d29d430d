/* Runs a scene, and makes an answer from the result. */
#ifndef MATRIG_HOST_SIM_SIM_H
#define MATRIG_HOST_SIM_SIM_H

#include "host/base/answer.h"
#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* True for a solver that matrig-study has and this program does not: cvode, because matrig is not
 * linked with SUNDIALS. */
bool sim_solver_is_missing(const char *solver);

/* Runs a scene. MR_OK: the result is SIM_OK. MR_NUMERICS: the run was refused for numerical
 * reasons, failed, or was interrupted; the result has the details, and `error` names mat and time.
 * An interrupted result has the values computed so far: the outputs and samples up to t_s of the
 * pass that was interrupted, without an error estimate. MR_USAGE: the model, the solver or an
 * option is not available. MR_MALFORMED: the scene is invalid. The result is written in every case,
 * and the caller frees it. Scene and options are not changed. */
enum mr_status sim_run(const struct sim_scene *scene, const struct sim_options *options,
                       struct sim_result *result, struct error *error);

/* A function for sim_options.may_continue that reports progress to a struct progress
 * (host/base/progress.h). It never stops the run. */
bool sim_report_progress(void *progress, int pass_from_1, double part);

/* Number of mats that a scene selects for output (u_mats; all by default), and the number of the
 * i-th of these mats. */
size_t sim_output_mat_count(const struct sim_scene *scene);
int sim_output_mat(const struct sim_scene *scene, size_t i);

/* Makes an answer from a result with any status; the caller frees it. In the JSON, lengths are in
 * ft, times in s and forces in lb, even with `si`. */
struct answer *sim_to_answer(const struct sim_scene *scene, const struct sim_result *result,
                             bool si);

#endif
