/* The ground under the gear as a row of the table: its key, and its place in the engines. What it
 * does is gear.h's. */
#include "host/sim/elements/element.h"

static double nothing(double k, struct element_mat mat)
{
    (void)k;
    (void)mat;
    return 0.0;
}

static double none(double k)
{
    (void)k;
    return 0.0;
}

static void describe(double k, struct sim_result *result)
{
    sim_result_note(result, "gear on elastic ground: %g lb/ft under a mat with one axle", k);
}

extern const struct element element_gear_ground;
const struct element element_gear_ground = {
    .key = {.name = "gear_k_lb_ft",
            .kind = SIM_KEY_REAL,
            .offset = ELEMENT_FIELD(gear_ground),
            .high = SIM_LARGEST,
            .unit = "lb/ft",
            .meaning = "elastic ground along the runway under a mat that carries one axle; 0: the "
                       "gear has one axle and slides by Coulomb's law",
            .lay = -1},
    .force_lb = nothing,
    .slope_lb_s_ft = nothing,
    .steepest_lb_s_ft = none,
    .push_at_rest_lb = none,
    .describe = describe,
    .remembers = true,
};
