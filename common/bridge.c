#include "common/bridge.h"

/* Pounds for an output of the whole excitation. */
static double lb_per_ratio(const struct mr_bridge *bridge)
{
    return 4.0 * bridge->modulus_psi * bridge->area_in2 / (bridge->gage_factor * bridge->arms);
}

double mr_bridge_lb_per_code(const struct mr_bridge *bridge)
{
    double ratio_per_code = MR_ADC_V / MR_ADC_CODES /
                            (bridge->excitation_v * bridge->amplifier_gain);
    return lb_per_ratio(bridge) * ratio_per_code;
}

double mr_bridge_shunt_lb(const struct mr_bridge *bridge)
{
    if (!(bridge->shunt_ohm > 0.0))
        return (double)__builtin_nanf("");
    return lb_per_ratio(bridge) * bridge->gage_ohm /
           (2.0 * (2.0 * bridge->shunt_ohm + bridge->gage_ohm));
}
