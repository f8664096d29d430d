/* Viscous damping by the ground, such as wet clay or a bituminous layer under the mats. The force
 * is -c v on each mat that the ground carries (element_mat.is_grounded). The coefficient c does not
 * depend on whether one end of the mat or both are on the ground. */
#include "host/sim/elements/element.h"

static double force_lb(double c, struct element_mat mat)
{
    return mat.is_grounded ? -c * mat.v_ft_s : 0.0;
}

static double slope_lb_s_ft(double c, struct element_mat mat)
{
    return mat.is_grounded ? -c : 0.0;
}

static double max_slope_lb_s_ft(double c)
{
    return c;
}

static double max_force_at_rest_lb(double c)
{
    (void)c;
    return 0.0;
}

static void describe(double c, struct sim_result *result)
{
    sim_result_add_note(result, "ground damping: %g lb s/ft on each mat that rests on the ground",
                        c);
}

extern const struct element element_ground_damping;
const struct element element_ground_damping = {
    .key = {.name = "ground_damping",
            .kind = SIM_KEY_REAL,
            .offset = ELEMENT_FIELD(ground_damping),
            .max = SIM_VALUE_MAX,
            .unit = "lb s/ft",
            .meaning = "viscous damping, along the runway, of each mat that rests on the ground"},
    .force_lb = force_lb,
    .slope_lb_s_ft = slope_lb_s_ft,
    .max_slope_lb_s_ft = max_slope_lb_s_ft,
    .max_force_at_rest_lb = max_force_at_rest_lb,
    .describe = describe,
};
