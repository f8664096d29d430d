/* What tests of host/sim share: how they run a scene, and how near is near. Units ft, lb, s. The
 * caller frees what it gets. */
#ifndef MATRIG_TESTS_HOST_SIM_CASE_H
#define MATRIG_TESTS_HOST_SIM_CASE_H

#include <math.h>
#include <string.h>

#include "host/sim/sim.h"
#include "tests/cmocka_all.h"

#define G 32.174

static struct error error; /* of the last run */

static inline void near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.15g is not %.15g to %g", value, expected, tolerance);
}

static inline struct sim_scene load(const char *path)
{
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    if (sim_scene_load(&scene, path, &error) != MR_OK)
        fail_msg("%s", error.text);
    return scene;
}

/* With a solver (NULL: auto), a tolerance, a step (0: chosen). */
static inline enum mr_status attempt(const struct sim_scene *scene, const char *solver, double rtol,
                                     double dt_s, struct sim_result *result)
{
    struct sim_options options = {.solver = solver, .rtol = rtol, .dt_s = dt_s};
    memset(&error, 0, sizeof error);
    return sim_run(scene, &options, result, &error);
}

static inline struct sim_result run(const struct sim_scene *scene, struct sim_options options)
{
    struct sim_result result;
    memset(&error, 0, sizeof error);
    if (sim_run(scene, &options, &result, &error) != MR_OK)
        fail_msg("%s: %s", options.solver ? options.solver : "auto", error.text);
    return result;
}

#endif
