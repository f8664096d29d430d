/* Running a scene, and what is answered of its result. */
#ifndef MATRIG_HOST_SIM_SIM_H
#define MATRIG_HOST_SIM_SIM_H

#include "host/base/answer.h"
#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* Whether this program lacks a solver that matrig-study has: true for cvode in
 * matrig, which is not linked with SUNDIALS. */
bool sim_solver_elsewhere(const char *solver);

/* Run a scene. MR_OK: the result is SIM_OK. MR_NUMERICS: the numerics were refused or failed, or
 * the run was interrupted; the result says how and the error names mat and time. An interrupted
 * result holds what was computed: outputs and samples up to t_s, from the pass under way, without
 * an error estimate. MR_USAGE: the model, the solver or an option is not available. MR_MALFORMED:
 * the scene is wrong. The result is written in every case; the caller frees it. Scene and options
 * are only read. */
enum mr_status sim_run(const struct sim_scene *scene, const struct sim_options *options,
                       struct sim_result *result, struct error *error);

/* sim_options.go_on for a struct progress (host/base/progress.h): always goes on. */
bool sim_progress(void *progress, int pass_from_1, double part);

/* The mats that a scene asks for (u_mats, else all): how many, and the i-th of them, from 1. */
size_t sim_shown_count(const struct sim_scene *scene);
int sim_shown_mat(const struct sim_scene *scene, size_t i);

/* A new answer of a result, whatever its status; the caller frees. For programs lengths in ft,
 * times in s, forces in lb, also with `si`. */
struct answer *sim_answer(const struct sim_scene *scene, const struct sim_result *result, bool si);

#endif
